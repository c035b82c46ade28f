! SPDX-License-Identifier: GPL-3.0-or-later
!> Repeats the experiment for one load: it bends the wing by the true load and applies the instrument. It also differentiates the
!> result with respect to every unknown, to effects that are not unknowns, and to errors of the load.
!>
!> All derivatives are exact: one back-substitution each with the factorised tangent of the shape (and a second one with the tangent
!> of the unloaded wing, if its weight bends it).
module measurement_simulation
  use base_errors, only: require
  use base_kinds, only: rp
  use measurement_experiment, only: bends_rest, experiment_t
  use measurement_forces, only: add_weight, applied_t, apply_load, force_derivative, magnitude_derivative, &
                                position_derivative, stiffness_factor, stiffness_slopes
  use measurement_instrument, only: missing_for
  use measurement_instrument_causes, only: GRAVITY_X, GRAVITY_Z, NONLINEARITY, PISTON, TILT_X, TILT_Y
  use measurement_view, only: view_t
  use solid_bent_wing, only: bent_wing_t
  use solid_effects, only: any_curves_rest
  use solid_params, only: solid_params_t
  use solid_usual_causes, only: PARAM_YOUNG
  use solid_statics, only: static_options_t, static_report_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: bending_direction, damage_direction, hinge_direction
  implicit none
  private
  public :: simulation_t

  integer, parameter, public :: N_NUISANCES = 6 !< force, x and y of its site, tilt about x and y, piston

  !> Work space of simulations, one per process. It does not affect the next simulation. Derivatives are those of the last one.
  type :: simulation_t
    type(bent_wing_t) :: loaded                      !< the wing under the load
    type(view_t) :: view                             !< what the instrument shows
    type(bent_wing_t), private :: rest               !< the wing without a load, if its weight bends it or a tangent needs it
    logical, private :: has_rest = .false.           !< `find_rest` was called since the last `solve`
    type(applied_t), private :: applied
    type(solid_params_t), private :: params          !< without drying and creep
    type(stiffness_t), private :: direction
    real(rp), allocatable, dimension(:, :), private :: force, change, motion, rest_u
    real(rp), allocatable, private :: outcome(:)
  contains
    procedure :: init => simulation_init
    procedure :: free => simulation_free
    procedure :: solve => simulation_solve
    procedure :: residuals => simulation_residuals
    procedure :: derivative => simulation_derivative
    procedure :: hinge_tangent => simulation_hinge_tangent
    procedure :: damage_tangent => simulation_damage_tangent
    procedure :: force_tangent => simulation_force_tangent
    procedure :: parameter_tangent => simulation_parameter_tangent
    procedure :: instrument_tangent => simulation_instrument_tangent
    procedure :: nuisance_tangents => simulation_nuisance_tangents
  end type simulation_t

contains

  !> Makes room for this experiment.
  subroutine simulation_init(self, experiment)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer :: n
    call self%free()
    n = experiment%model%n_all
    call self%loaded%init(experiment%model)
    if (experiment%bends_rest) call self%rest%init(experiment%model)
    call self%view%init(experiment)
    allocate (self%force(3, n), self%change(3, n), self%motion(3, n), self%rest_u(3, n), &
              self%outcome(maxval(experiment%comparisons%n)), source=0.0_rp)
  end subroutine simulation_init

  !> Releases everything.
  subroutine simulation_free(self)
    class(simulation_t), intent(inout) :: self
    call self%loaded%free()
    call self%rest%free()
    self%has_rest = .false.
    call self%view%free()
    if (allocated(self%force)) deallocate (self%force, self%change, self%motion, self%rest_u, self%outcome)
  end subroutine simulation_free

  !> Finds the shape under load l at these coordinates. u(3, n_all) [m] is as in `bent_wing_t%solve`. If `load_offset` is given, the
  !> force acts at this distance [m] from its declared site. The report fails if drying leaves no stiffness, or if the force acts
  !> outside the wing.
  subroutine simulation_solve(self, experiment, coordinates, l, is_warm, u, report, load_offset)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    real(rp), intent(in) :: coordinates(:)
    integer, intent(in) :: l
    logical, intent(in) :: is_warm
    real(rp), intent(inout) :: u(:, :)
    type(static_report_t), intent(out) :: report
    real(rp), intent(in), optional :: load_offset(2)
    type(static_report_t) :: rest_report
    type(solid_params_t) :: params
    real(rp) :: factor(2), off(2)
    logical :: starts_curved
    off = 0
    if (present(load_offset)) off = load_offset
    params = experiment%params(coordinates)
    self%params = params
    self%has_rest = .false.
    call self%view%set(experiment%instrument_at(coordinates))
    associate (load => experiment%measurement%loads(l))
      call apply_load(self%view%instrument, load, experiment%sites(l), experiment%model, off, self%applied, self%force)
      factor = stiffness_factor(self%view%instrument, load)
    end associate
    if (.not. self%applied%is_valid) report%reason = 'the place of the force is outside the outline of the wing'
    if (.not. minval(factor) > 0) report%reason = 'drift or creep makes the stiffness zero or negative'
    if (allocated(report%reason)) return
    self%force = self%view%scale*self%force
    if (experiment%bends_rest) then
      call self%rest%model%set_params(params)
      self%change = 0
      call add_weight(self%view%instrument, experiment%masses, self%change)
      self%change = self%view%scale*self%change
      self%rest_u = 0
      call self%rest%solve(self%change, .true., options_for(experiment%options, self%force, self%change), self%rest_u, &
                           rest_report)
      self%force = self%force + self%change
    end if
    params%bending_factor = factor(1)
    params%young = params%young*factor(2)
    call self%loaded%model%set_params(params)
    starts_curved = .not. is_warm .and. any_curves_rest(params%effects)
    if (starts_curved) u = self%rest_u
    call self%loaded%solve(self%force, is_warm .or. starts_curved, experiment%options, u, report)
    if (.not. experiment%bends_rest) return
    report%factorisations = report%factorisations + rest_report%factorisations
    report%snaps = report%snaps + rest_report%snaps
    report%was_repeated = report%was_repeated .or. rest_report%was_repeated
    report%is_start = report%is_start .and. rest_report%is_start
    if (rest_report%converged) return
    report%converged = .false.
    report%reason = 'under its weight alone: '//rest_report%reason
  end subroutine simulation_solve

  !> Returns the tolerance for the wing under its weight. In newtons it is that of the load, because the weight is a small load, for
  !> which rounding is relatively larger.
  pure function options_for(options, load, weight) result(changed)
    type(static_options_t), intent(in) :: options
    real(rp), intent(in) :: load(:, :), weight(:, :)
    type(static_options_t) :: changed
    real(rp), parameter :: COARSEST = 1.0e-3_rp
    changed = options
    if (.not. norm2(weight) > 0 .or. .not. norm2(weight) < norm2(load)) return
    changed%tolerance = COARSEST
    if (norm2(weight)*COARSEST > options%tolerance*norm2(load)) &
      changed%tolerance = options%tolerance*norm2(load)/norm2(weight)
  end function options_for

  !> Returns residuals(n), the simulated values less the measured ones, after a converged `solve`.
  subroutine simulation_residuals(self, experiment, coordinates, l, residuals)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    real(rp), intent(in) :: coordinates(:)
    integer, intent(in) :: l
    real(rp), intent(out) :: residuals(:)
    if (experiment%bends_rest) then
      call self%view%observe_rest(experiment, l, self%rest%moved)
    else if (experiment%moves_rest) then
      call self%view%observe_rest(experiment, l)
    end if
    call self%view%residuals(experiment, l, self%loaded%moved, coordinates(experiment%count_parameters() + 1:), &
                             residuals)
    call keep_outcome(self, experiment, coordinates, l, residuals)
    call self%view%add_plane(experiment, l, residuals)
  end subroutine simulation_residuals

  !> Computes the simulated values alone, without the measured ones and without unknown offsets.
  subroutine keep_outcome(self, experiment, coordinates, l, residuals)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    real(rp), intent(in) :: coordinates(:), residuals(:)
    integer, intent(in) :: l
    integer :: k, zero
    associate (comparison => experiment%comparisons(l))
      self%outcome(:comparison%n) = residuals + comparison%measured
      do k = 1, size(comparison%gauges)
        zero = comparison%gauges(k)%zero
        if (zero > 0) self%outcome(comparison%n_heights + k) = self%outcome(comparison%n_heights + k) - &
                                                               coordinates(experiment%count_parameters() + zero)
      end do
    end associate
  end subroutine keep_outcome

  !> Returns column(n), the derivative of the residuals with respect to unknown i. Call this and the following procedures after
  !> `residuals`.
  subroutine simulation_derivative(self, experiment, l, i, column)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l, i
    real(rp), intent(out) :: column(:)
    integer :: k, zero
    zero = i - experiment%count_parameters()
    if (i <= size(experiment%numbers)) then
      call self%parameter_tangent(experiment, l, experiment%numbers(i), column)
    else if (zero <= 0) then
      call self%instrument_tangent(experiment, l, experiment%instrument_numbers(i - size(experiment%numbers)), column)
    else
      column = 0
      associate (comparison => experiment%comparisons(l))
        do k = 1, size(comparison%gauges)
          if (comparison%gauges(k)%zero == zero) column(comparison%n_heights + k) = 1
        end do
      end associate
    end if
  end subroutine simulation_derivative

  !> Returns the derivative with respect to parameter `number` of the wing, free or not, per log unit if it varies by factors.
  subroutine simulation_parameter_tangent(self, experiment, l, number, column)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l, number
    real(rp), intent(out) :: column(:)
    call self%loaded%parameter_motion(number, self%motion)
    call self%view%loaded_tangent(experiment, l, self%motion, column)
    if (.not. experiment%bends_rest .and. bends_rest(self%params, number)) then
      call find_rest(self, experiment)
      if (.not. experiment%moves_rest) call self%view%observe_rest(experiment, l)
    else if (.not. experiment%bends_rest) then
      return
    end if
    call self%rest%parameter_motion(number, self%motion)
    call self%view%rest_tangent(experiment, l, self%motion, column)
  end subroutine simulation_parameter_tangent

  !> Returns the derivative with respect to the logarithm of the stiffness of hinge h of the model.
  subroutine simulation_hinge_tangent(self, experiment, l, h, column)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l, h
    real(rp), intent(out) :: column(:)
    call hinge_direction(self%loaded%model, h, self%direction)
    call self%loaded%stiffness_motion(self%direction, self%motion)
    call self%view%loaded_tangent(experiment, l, self%motion, column)
    if (.not. experiment%bends_rest) return
    call hinge_direction(self%rest%model, h, self%direction)
    call self%rest%stiffness_motion(self%direction, self%motion)
    call self%view%rest_tangent(experiment, l, self%motion, column)
  end subroutine simulation_hinge_tangent

  !> Returns the derivative with respect to the logarithm of a damage in disc = (x, y, radius) [m] that the wing does not have.
  subroutine simulation_damage_tangent(self, experiment, l, disc, column)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(in) :: disc(3)
    real(rp), intent(out) :: column(:)
    call damage_direction(self%loaded%model, disc, self%direction)
    call self%loaded%stiffness_motion(self%direction, self%motion)
    call self%view%loaded_tangent(experiment, l, self%motion, column)
    if (.not. experiment%bends_rest) return
    call damage_direction(self%rest%model, disc, self%direction)
    call self%rest%stiffness_motion(self%direction, self%motion)
    call self%view%rest_tangent(experiment, l, self%motion, column)
  end subroutine simulation_damage_tangent

  !> Returns the derivative with respect to the size of a further dead load force(3, n_all) [N].
  subroutine simulation_force_tangent(self, experiment, l, force, column)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(in) :: force(:, :)
    real(rp), intent(out) :: column(:)
    call self%loaded%force_motion(force, self%motion)
    call self%view%loaded_tangent(experiment, l, self%motion, column)
  end subroutine simulation_force_tangent

  !> Returns the derivative with respect to the coordinate of parameter `number` of the instrument, free or not. The measurement
  !> must hold the data that the parameter needs (see `missing_for`), and the experiment the masses for its weight.
  subroutine simulation_instrument_tangent(self, experiment, l, number, column)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l, number
    real(rp), intent(out) :: column(:)
    real(rp) :: slope(2)
    logical :: is_weight
    is_weight = number >= GRAVITY_X .and. number <= GRAVITY_Z
    call require(missing_for(number, experiment%measurement) == '', 'measurement_simulation: data are missing')
    if (is_weight) call require(size(experiment%masses) > 0, 'measurement_simulation: weight needs masses')
    if (is_weight .and. .not. experiment%bends_rest) call find_rest(self, experiment)
    if (number == NONLINEARITY) then
      call find_nonlinearity(self, experiment, l, column)
      return
    end if
    column = 0
    associate (load => experiment%measurement%loads(l))
      slope = stiffness_slopes(self%view%instrument, load, number)
      call force_derivative(self%view%instrument, load, self%applied, experiment%masses, experiment%model%points, &
                            number, self%change)
      self%change = self%view%scale*self%change
      if (any(abs(self%change) > 0)) then
        call self%loaded%force_motion(self%change, self%motion)
        call self%view%loaded_tangent(experiment, l, self%motion, column)
        if (.not. is_weight) return
        if (.not. experiment%moves_rest) call self%view%observe_rest(experiment, l)
        call self%rest%force_motion(self%change, self%motion)
        call self%view%rest_tangent(experiment, l, self%motion, column)
      else if (abs(slope(1)) > 0) then
        call bending_direction(self%loaded%model, self%direction)
        call self%loaded%stiffness_motion(self%direction, self%motion)
        call self%view%loaded_tangent(experiment, l, self%motion, column)
        column = slope(1)*column
      else if (abs(slope(2)) > 0) then
        call self%loaded%parameter_motion(PARAM_YOUNG, self%motion)
        call self%view%loaded_tangent(experiment, l, self%motion, column)
        column = slope(2)*column
      else if (experiment%comparisons(l)%n_heights > 0) then
        call self%view%map_tangent(experiment, l, number, column)
        if (.not. any(abs(column) > 0)) call self%view%plane(experiment, l, number, column)
      end if
    end associate
  end subroutine simulation_instrument_tangent

  !> Computes d(Y/e)/dq: with e = sqrt q and the outcome Y(e)/e under the forces e F it is (dY/de/e - Y/e^2)/(2 e).
  subroutine find_nonlinearity(self, experiment, l, column)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(out) :: column(:)
    self%change = self%force/self%view%scale
    call self%loaded%force_motion(self%change, self%motion)
    call self%view%loaded_tangent(experiment, l, self%motion, column)
    if (experiment%bends_rest) then
      self%change = 0
      call add_weight(self%view%instrument, experiment%masses, self%change)
      call self%rest%force_motion(self%change, self%motion)
      call self%view%rest_tangent(experiment, l, self%motion, column)
    end if
    column = (column - self%outcome(:size(column))/self%view%scale)/(2*self%view%scale)
  end subroutine find_nonlinearity

  !> Returns columns(n, N_NUISANCES), the derivatives with respect to errors of this load alone: its force [N], x and y [m] of its
  !> site, tilt [rad] about x and about y, and piston [m] of its scan. Also returns their declared sd, 0 if none is declared.
  subroutine simulation_nuisance_tangents(self, experiment, l, columns, sd)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(out) :: columns(:, :), sd(N_NUISANCES)
    integer, parameter :: PLANE(3) = [TILT_X, TILT_Y, PISTON]
    integer :: i
    associate (accuracy => experiment%measurement%accuracy)
      sd = [accuracy%force, accuracy%position, accuracy%position, accuracy%tilt, accuracy%tilt, accuracy%piston]
      do i = 1, 3
        if (i == 1) then
          call magnitude_derivative(self%applied, self%change)
        else
          call position_derivative(self%applied, experiment%model%points, i - 1, self%change)
        end if
        self%change = self%view%scale*self%change
        call self%loaded%force_motion(self%change, self%motion)
        call self%view%loaded_tangent(experiment, l, self%motion, columns(:, i))
      end do
      do i = 1, 3
        call self%view%plane(experiment, l, PLANE(i), columns(:, 3 + i))
      end do
    end associate
  end subroutine simulation_nuisance_tangents

  !> Factorises the tangent of the wing without a load, if no weight bends it, once for all tangents after a `solve`.
  subroutine find_rest(self, experiment)
    class(simulation_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    type(static_report_t) :: report
    if (self%has_rest) return
    if (.not. allocated(self%rest%moved)) call self%rest%init(experiment%model)
    call self%rest%model%set_params(self%params)
    self%rest_u = 0
    call self%rest%solve(0*self%change, .false., experiment%options, self%rest_u, report)
    call require(report%converged, 'measurement_simulation: the unloaded wing is in equilibrium')
    self%has_rest = .true.
  end subroutine find_rest
end module measurement_simulation

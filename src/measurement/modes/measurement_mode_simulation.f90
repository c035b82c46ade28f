! SPDX-License-Identifier: GPL-3.0-or-later
!> Compares measured natural modes with computed modes: it forms pairs, and returns residuals and their exact derivatives.
!>
!> The wing vibrates about its flat unloaded shape or about its shape under the loads of a mode. In air, its membrane carries the
!> added mass of strip theory. Modes with the same medium and the same loads belong to one state of the wing. Each evaluation
!> follows the loading path from the unloaded shape, so that it does not depend on earlier evaluations. Pairs are formed as follows.
!> A measured mode with a number is paired with the computed mode of this number. The other pairs are taken in the order of their
!> score MAC exp(-(ln(f/f_m))^2/(2 SPREAD^2)), the largest score first. Any computed mode may stay without a partner, because
!> measurements miss modes.
module measurement_mode_simulation
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use measurement_data, only: measurement_t
  use measurement_mode_target, only: mode_target_t
  use measurement_material_point, only: find_material_point, material_point_t
  use measurement_modes, only: measured_mode_t, MEDIUM_AIR, MEDIUM_VACUUM
  use measurement_motion_simulation, only: motion_simulation_t
  use solid_damping_effects, only: damping_effects_t
  use solid_joint_forces, only: apply_joints
  use solid_mass_effects, only: mass_effects_t, mass_parts_t
  use solid_modal, only: modal_t, mode_slopes_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_statics, only: static_options_t
  use solid_stiffness, only: stiffness_t
  implicit none
  private
  public :: mode_simulation_t

  real(rp), parameter :: GAP = 0.01_rp   !< relative difference of frequencies within a cluster
  real(rp), parameter :: SPREAD = 0.5_rp !< standard deviation of ln(f/f_m) of a pair
  integer, parameter :: MISSED = 4       !< modes below the last measured one that a measurement may miss
  integer, parameter :: BESIDE = 3       !< further modes that are computed for the derivatives

  !> Describes a state of the wing: its medium and its loads.
  type :: state_t
    type(measured_mode_t) :: example              !< the first mode of this state
    real(rp) :: density = 0                       !< [kg/m^3] of the air
    integer :: n_modes = 0                        !< computed modes
    integer :: n_paired = 0                       !< computed modes that may be paired
    real(rp), allocatable :: force(:, :)          !< (3, n_all) [N]
  end type state_t

  !> The simulation, one per process. An evaluation does not depend on earlier evaluations.
  type, extends(motion_simulation_t) :: mode_simulation_t
    type(mode_target_t), allocatable :: targets(:)    !< (modes)
    integer, allocatable :: first(:)                  !< (modes) their first observation
    type(mass_parts_t) :: parts
    type(state_t), allocatable, private :: states(:)  !< unloaded states first
    class(modal_t), allocatable, private :: modal(:)  !< of each state; polymorphic, so that compilers copy it by a call
    type(static_options_t), private :: options
    logical, allocatable, private :: same(:, :)
    real(rp), allocatable, private :: rubbing(:, :)   !< change of K_joints between the modes of `same`
    logical, private :: rubs = .false.                !< joints have friction in the last evaluation
    type(mode_slopes_t), private :: slopes
    real(rp), allocatable, private :: mass(:, :)
    real(rp), allocatable, private :: bent(:, :, :, :) !< (3, n_all, modes, states) K_joints Phi; empty if no damping needs it
  contains
    procedure :: init => simulation_init
    procedure :: free => simulation_free
    procedure :: evaluate => simulation_evaluate
    procedure :: stiffness_tangent => simulation_stiffness_tangent
    procedure :: mass_tangent => simulation_mass_tangent
    procedure :: clamp_tangent => simulation_clamp_tangent
    procedure :: damping_tangent => simulation_damping_tangent
    procedure :: model => simulation_model
  end type mode_simulation_t

contains

  !> Takes the modes of a checked measurement, none or more, of the wing of `model` with these masses. `options` control the static
  !> solution that finds loaded shapes.
  subroutine simulation_init(self, measurement, model, parts, options)
    class(mode_simulation_t), intent(inout) :: self
    type(measurement_t), intent(in) :: measurement
    type(solid_model_t), intent(in) :: model
    type(mass_parts_t), intent(in) :: parts
    type(static_options_t), intent(in), optional :: options
    integer :: i, m, most
    call self%free()
    self%parts = parts
    if (present(options)) self%options = options
    allocate (self%targets(measurement%count_modes()), self%first(measurement%count_modes()), self%states(0))
    self%n = 0
    do i = 1, size(self%targets)
      call self%targets(i)%init(measurement%modes(i), model)
      self%first(i) = self%n + 1
      self%n = self%n + self%targets(i)%n
    end do
    call find_states(self, measurement, MEDIUM_VACUUM, .false.)
    call find_states(self, measurement, MEDIUM_AIR, .false.)
    call find_states(self, measurement, MEDIUM_VACUUM, .true.)
    call find_states(self, measurement, MEDIUM_AIR, .true.)
    allocate (modal_t :: self%modal(size(self%states)))
    do m = 1, size(self%states)
      associate (state => self%states(m), is_here => self%targets%state == m)
        most = max(count(is_here), maxval(self%targets%number, mask=is_here))
        state%n_modes = min(most + MISSED + BESIDE, 3*model%n_free)
        state%n_paired = min(most + MISSED, state%n_modes)
        state%force = force_of(state%example, model)
      end associate
      call self%modal(m)%init(model)
    end do
    allocate (self%mass(3, model%n_all))
    most = 0
    if (any(model%plans%joint > 0) .and. any(measurement%modes%damping >= 0)) most = maxval(self%states%n_modes)
    allocate (self%bent(3, model%n_all, most, size(self%states)), source=0.0_rp)
  end subroutine simulation_init

  !> Appends the states of the modes in this medium, either unloaded or loaded, and stores the numbers of the states in the targets.
  subroutine find_states(self, measurement, medium, is_loaded)
    class(mode_simulation_t), intent(inout) :: self
    type(measurement_t), intent(in) :: measurement
    integer, intent(in) :: medium
    logical, intent(in) :: is_loaded
    type(state_t) :: state
    integer :: i, m, found
    do i = 1, size(self%targets)
      associate (mode => measurement%modes(i))
        if (mode%medium /= medium .or. (mode%is_loaded() .neqv. is_loaded)) cycle
        found = 0
        do m = 1, size(self%states)
          if (self%states(m)%example%has_load_of(mode)) found = m
        end do
        if (found == 0) then
          state%example = mode
          state%density = merge(measurement%air_density, 0.0_rp, medium == MEDIUM_AIR)
          self%states = [self%states, state]
          found = size(self%states)
        end if
        self%targets(i)%state = found
      end associate
    end do
  end subroutine find_states

  !> Returns force(3, n_all) [N] of the point loads of a mode.
  function force_of(mode, model) result(force)
    type(measured_mode_t), intent(in) :: mode
    type(solid_model_t), intent(in) :: model
    real(rp), allocatable :: force(:, :)
    type(material_point_t) :: site
    integer :: i, c
    allocate (force(3, model%n_all), source=0.0_rp)
    if (.not. allocated(mode%load_size)) return
    do i = 1, size(mode%load_size)
      site = find_material_point(model%points(:, :model%n_points), model%triangles, model%size, mode%load_place(:, i))
      do c = 1, 3
        associate (p => site%corner(c))
          force(:, p) = force(:, p) + site%weight(c)*mode%load_size(i)*mode%load_direction(:, i)
        end associate
      end do
    end do
  end function force_of

  !> Releases everything.
  subroutine simulation_free(self)
    class(mode_simulation_t), intent(inout) :: self
    integer :: m
    if (allocated(self%modal)) then
      do m = 1, size(self%modal)
        call self%modal(m)%free()
      end do
      deallocate (self%modal, self%states)
    end if
    if (allocated(self%targets)) deallocate (self%targets, self%first, self%mass, self%bent)
    self%n = 0
  end subroutine simulation_free

  !> Finds the modes with these parameters, masses and damping, and residuals(n). `ok` is false if there are no residuals, because
  !> the unloaded wing is unstable or has no equilibrium under the loads of a mode.
  subroutine simulation_evaluate(self, params, effects, damping, residuals, ok)
    class(mode_simulation_t), intent(inout) :: self
    type(solid_params_t), intent(in) :: params
    type(mass_effects_t), intent(in) :: effects
    type(damping_effects_t), intent(in) :: damping
    real(rp), intent(out) :: residuals(:)
    logical, intent(out) :: ok
    type(failure_t) :: failure
    integer :: m, i
    residuals = 0
    ok = .true.
    self%rubs = abs(damping%joints) > 0 .and. size(self%bent) > 0
    do m = 1, size(self%states)
      call self%modal(m)%model%set_params(params)
      call self%parts%masses(effects, self%states(m)%density, self%mass)
      ok = minval(self%mass(:, self%modal(m)%model%movable)) > 0
      if (.not. ok) return
      associate (state => self%states(m), modal => self%modal(m))
        if (state%example%is_loaded()) call modal%bend(self%mass, state%force, state%example%gravity, self%options, failure)
        if (.not. failure%failed) call modal%solve(self%mass, state%n_modes, failure)
      end associate
      ok = .not. failure%failed
      if (ok) call make_pairs(self, m, ok)
      if (.not. ok) return
      if (size(self%bent) > 0) call apply_joints(self%modal(m), self%bent(:, :, :self%states(m)%n_modes, m))
    end do
    do i = 1, size(self%targets)
      associate (t => self%targets(i), modal => self%modal(self%targets(i)%state))
        associate (own => residuals(self%first(i):self%first(i) + t%n - 1), shapes => modal%shapes(:, :, t%lo:t%hi))
          call t%residuals(modal%lambda(t%lo:t%hi), shapes, own)
          call t%damp(damping, self%bent(:, :, t%lo:min(t%hi, size(self%bent, 3)), t%state), shapes, own)
        end associate
      end associate
    end do
  end subroutine simulation_evaluate

  !> Pairs all measured modes of state m with computed modes.
  subroutine make_pairs(self, m, ok)
    class(mode_simulation_t), intent(inout) :: self
    integer, intent(in) :: m
    logical, intent(out) :: ok
    real(rp), allocatable :: score(:, :), f(:)
    integer, allocatable :: lo(:), hi(:), room(:)
    integer :: i, c, best(2)
    f = self%modal(m)%frequencies()
    call find_clusters(f(:self%states(m)%n_paired), lo, hi)
    room = hi - lo + 1
    allocate (score(size(self%targets), size(lo)), source=-1.0_rp)
    do i = 1, size(self%targets)
      associate (t => self%targets(i))
        if (t%state /= m) cycle
        if (t%number > 0) then
          t%lo = t%number
          t%hi = t%number
          c = findloc(t%number >= lo .and. t%number <= hi, .true., 1)
          if (c > 0) room(c) = room(c) - 1
          cycle
        end if
        do c = 1, size(lo)
          score(i, c) = t%assurance(self%modal(m)%shapes(:, :, lo(c):hi(c)))* &
                        t%nearness(sqrt(f(lo(c))*f(hi(c))), SPREAD)
        end do
      end associate
    end do
    do while (any(score >= 0))
      best = maxloc(score)
      i = best(1)
      c = best(2)
      if (room(c) <= 0) then
        score(:, c) = -1
        cycle
      end if
      self%targets(i)%lo = lo(c)
      self%targets(i)%hi = hi(c)
      room(c) = room(c) - 1
      score(i, :) = -1
    end do
    ok = all(self%targets%lo > 0 .or. self%targets%state /= m)
  end subroutine make_pairs

  !> Modes lo(c) to hi(c) form cluster c: neighbouring frequencies differ by less than GAP.
  pure subroutine find_clusters(f, lo, hi)
    real(rp), intent(in) :: f(:)
    integer, allocatable, intent(out) :: lo(:), hi(:)
    integer :: i
    lo = [1]
    hi = [1]
    do i = 2, size(f)
      if (f(i) - f(i - 1) < GAP*f(i)) then
        hi(size(hi)) = i
      else
        lo = [lo, i]
        hi = [hi, i]
      end if
    end do
  end subroutine find_clusters

  !> Returns the change of the residuals by a change of stiffness; see motion_simulation_t.
  subroutine simulation_stiffness_tangent(self, direction, column)
    class(mode_simulation_t), intent(inout) :: self
    type(stiffness_t), intent(in) :: direction
    real(rp), intent(out) :: column(:)
    integer :: m
    do m = 1, size(self%states)
      call note_clusters(self, m)
      call self%modal(m)%slopes_of_stiffness(direction, self%same, self%slopes)
      if (self%rubs) call note_joints(self, m, direction)
      call project_change(self, m, .false., column)
    end do
  end subroutine simulation_stiffness_tangent

  !> Finds the change of the stiffness of joints between the modes of `same` when all stiffness changes along `direction`.
  subroutine note_joints(self, m, direction)
    class(mode_simulation_t), intent(inout) :: self
    integer, intent(in) :: m
    type(stiffness_t), intent(in) :: direction
    real(rp) :: changed(3, size(self%mass, 2), size(self%same, 1))
    integer :: i, j
    call apply_joints(self%modal(m), changed, direction)
    do j = 1, size(changed, 3)
      do i = 1, size(changed, 3)
        self%rubbing(i, j) = sum(self%modal(m)%shapes(:, :, i)*changed(:, :, j))
      end do
    end do
  end subroutine note_joints

  !> Returns the change of the residuals by a change of the masses; see motion_simulation_t.
  subroutine simulation_mass_tangent(self, number, effects, column)
    class(mode_simulation_t), intent(inout) :: self
    integer, intent(in) :: number
    type(mass_effects_t), intent(in) :: effects
    real(rp), intent(out) :: column(:)
    integer :: m
    do m = 1, size(self%states)
      call note_clusters(self, m)
      call self%parts%derivative(effects, self%states(m)%density, number, self%mass)
      call self%modal(m)%slopes_of_mass(self%mass, self%same, self%slopes)
      call project_change(self, m, .true., column)
    end do
  end subroutine simulation_mass_tangent

  !> Returns the change of the residuals by a compliant clamp; see motion_simulation_t.
  subroutine simulation_clamp_tangent(self, k, column)
    class(mode_simulation_t), intent(inout) :: self
    integer, intent(in) :: k
    real(rp), intent(out) :: column(:)
    integer :: m
    do m = 1, size(self%states)
      call note_clusters(self, m)
      call self%modal(m)%slopes_of_clamp(k, self%same, self%slopes)
      call project_change(self, m, .false., column)
    end do
  end subroutine simulation_clamp_tangent

  !> Returns the change of the residuals by damping effect `number`; see mode_target_t.
  subroutine simulation_damping_tangent(self, number, time, column)
    class(mode_simulation_t), intent(inout) :: self
    integer, intent(in) :: number
    real(rp), intent(in) :: time
    real(rp), intent(out) :: column(:)
    integer :: i
    do i = 1, size(self%targets)
      associate (t => self%targets(i), first => self%first(i))
        call t%damping_tangent(number, time, column(first:first + t%n - 1))
      end associate
    end do
  end subroutine simulation_damping_tangent

  !> Finds which of the modes up to the last paired one form a cluster.
  subroutine note_clusters(self, m)
    class(mode_simulation_t), intent(inout) :: self
    integer, intent(in) :: m
    integer :: i, n
    n = maxval(self%targets%hi, mask=self%targets%state == m)
    if (allocated(self%same)) deallocate (self%same, self%rubbing)
    if (allocated(self%slopes%shapes)) deallocate (self%slopes%shapes)
    allocate (self%same(n, n), source=.false.)
    allocate (self%rubbing(n, n), source=0.0_rp)
    do i = 1, size(self%targets)
      associate (t => self%targets(i))
        if (t%state == m .and. t%hi > t%lo) self%same(t%lo:t%hi, t%lo:t%hi) = .true.
      end associate
    end do
  end subroutine note_clusters

  !> Turns the change of the modes in medium `m` into a column of the Jacobian.
  subroutine project_change(self, m, is_mass, column)
    class(mode_simulation_t), intent(in) :: self
    integer, intent(in) :: m
    logical, intent(in) :: is_mass
    real(rp), intent(inout) :: column(:)
    integer :: i
    do i = 1, size(self%targets)
      associate (t => self%targets(i))
        if (t%state /= m) cycle
        call t%tangent(self%slopes%force(t%lo:t%hi, t%lo:t%hi), self%slopes%shapes(:, :, t%lo:t%hi), is_mass, &
                       self%rubbing(t%lo:t%hi, t%lo:t%hi), column(self%first(i):self%first(i) + t%n - 1))
      end associate
    end do
  end subroutine project_change

  !> Returns the model with the parameters of the last evaluation, from which directions of stiffness are made.
  function simulation_model(self) result(model)
    class(mode_simulation_t), intent(in), target :: self
    type(solid_model_t), pointer :: model
    model => self%modal(1)%model
  end function simulation_model
end module measurement_mode_simulation

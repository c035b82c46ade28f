! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimates the error that the mesh makes in a diagnosis. It fits the baseline on the wing of the file and on the same wing
!> with a mesh of half the size. The difference d between both fits is an error of about this size and of unknown sign. With its
!> directions in the covariance a diagnosis does not take numerical error for a cause. The error is (a + b_l) d in load l. a ~
!> N(0, 1) is common to all loads, as they have the same mesh, and b_l ~ N(0, LOADS_DIFFER^2) allows loads to converge at
!> different orders.
!>
!> Where the diagnosis itself is made on the finer mesh, the error of that mesh is needed. Richardson's estimate of it is
!> d/(2^p - 1), where p is the order of convergence. Two meshes do not determine p. Nets of springs converge slowly, and p = 1 is
!> assumed: the error is the whole d, which is too much where p is larger.
!>
!> The effect of the mesh depends on the wing. Where a cause is clear, the difference is computed again with this cause in both
!> models, with the strength that was found on the mesh of the diagnosis.
!>
!> Both fits are rough. Their errors lie along the unknowns of the baseline, which all later steps fit again.
module diagnosis_discretisation
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_lapack, only: orthogonalise
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_wing_bins, only: bins_t, make_bins
  use diagnosis_wing_catalogue, only: catalogue_t, make_catalogue
  use diagnosis_wing_parameters, only: is_hinge_of_piece, place_on_file, relate_to_file, wing_parameter_t, KIND_DAMAGE, &
                                       KIND_PARAMETER, KIND_POINT_MASS, KIND_RELAXATION, KIND_RELAXATION_TIME, KIND_SHAKE, &
                                       KIND_SOFT
  use diagnosis_wing_simulator, only: wing_simulator_t
  use diagnosis_wing_state, only: wing_state_t
  use inference_growing_fit, only: grow_fit
  use inference_refit, only: fit_nested, fit_loosely, nested_fit_t, loose_options
  use inference_whitener, only: whitener_t
  use io_journal, only: journal_t
  use least_squares_fit, only: fit_options_t
  use least_squares_state, only: solver_state_t
  use measurement_experiment, only: experiment_t
  use measurement_observed_wing, only: wing_patterns_t
  use parallel_world, only: world_t
  use solid_mass, only: lump_mass, mass_t
  use solid_mass_effects, only: mass_parts_t
  use solid_params, only: solid_params_t
  use solid_wing, only: wing_t
  use solid_wing_refine, only: equal_rotation, refine_params, refine_wing
  implicit none
  private
  public :: discretisation_error_t

  !> Signal-to-noise ratio of the error of a mesh from which it may decide between two causes: their log likelihoods then differ by
  !> 3, the least difference with which a set does not hold both (inference_decision), and snr^2/2 = 3.
  real(rp), parameter, public :: DECISIVE_SNR = sqrt(6.0_rp)

  !> Half of the difference between d/(2^p - 1) for p = 1 and for p = 2, in units of d.
  real(rp), parameter :: LOADS_DIFFER = 1.0_rp/3

  type :: discretisation_error_t
    logical :: is_found = .false.
    integer :: n_points = 0               !< of the finer mesh
    real(rp) :: rms = 0                   !< [m] of the difference that remains after both fits
    real(rp) :: snr = 0                   !< signal-to-noise ratio of the effect that the difference would imitate
    real(rp), allocatable :: start(:)     !< (parameters) the rough fit of the baseline on the mesh of the diagnosis
    type(wing_t), private :: wing
    type(experiment_t), private :: experiment
    type(catalogue_t), private :: catalogue
    type(wing_simulator_t), private :: simulator !< on the other mesh, which is not that of the diagnosis
    integer, allocatable, private :: parents(:, :)
    logical, private :: is_coarser = .false. !< the other mesh is the coarser one
    type(world_t), private :: world
    type(wing_simulator_t), pointer, private :: diagnosis_simulator => null() !< of the diagnosis
    type(fit_options_t), private :: options
  contains
    procedure :: init => discretisation_init
    procedure :: find => discretisation_find
    procedure :: use_journal => discretisation_use_journal
    procedure :: begin_renewal => discretisation_begin_renewal
    procedure :: renew => discretisation_renew
    procedure :: serve_first => discretisation_serve_first
    procedure :: serve => discretisation_serve
    procedure :: free => discretisation_free
  end type discretisation_error_t

contains

  !> Makes the wing of the other mesh on all ranks. `failure` says why there is none. Collective.
  subroutine discretisation_init(self, world, s, failure)
    class(discretisation_error_t), intent(inout), target :: self
    type(world_t), intent(in) :: world
    class(diagnosis_case_t), intent(in) :: s
    type(failure_t), intent(out) :: failure
    type(wing_patterns_t) :: patterns
    type(bins_t) :: bins
    type(solid_params_t) :: params
    type(wing_t) :: fine
    type(mass_parts_t) :: parts
    type(mass_t) :: mass
    type(message_list_t) :: messages
    real(rp), allocatable :: masses(:)
    self%world = world
    self%options = loose_options(s%options%fit)
    self%is_coarser = s%fits_finer
    if (self%is_coarser) then
      self%wing = s%file_wing
      params = s%file_requested
      call refine_wing(s%file_wing, fine, self%parents)
    else
      call refine_wing(s%wing_case%wing, self%wing, self%parents)
      params = refine_params(s%wing_case%requested)
    end if
    self%n_points = size(self%parents, 2)
    allocate (masses(0))
    if (s%measurement%moves()) then ! motion needs the mass of this mesh
      call lump_mass(self%wing, s%wing_case%material, mass, messages)
      masses = mass%nodal
      call parts%init(self%wing, mass)
    end if
    call self%experiment%init(s%measurement, self%wing, params, [integer ::], s%experiment%options, failure, &
                              s%instrument, masses=masses)
    if (failure%failed) return
    call make_bins(self%experiment, s%bins%size, bins)
    if (bins%n /= s%bins%n) then
      call failure%raise('the refined mesh maps to a different set of height samples; --refine=no counts no error of the mesh')
      return
    end if
    call make_catalogue(self%experiment, self%wing, s%free_parameters%numbers, s%prior_decades, self%catalogue, s%flights, &
                        s%membrane_sd)
    if (.not. self%is_coarser) then
      call relate_to_file(self%catalogue%parameters, self%experiment%model%params, s%experiment%model%params%joint)
      call place_on_file(self%catalogue%parameters, s%wing_case%wing)
    end if
    allocate (patterns%site(2, 0))
    call self%simulator%init(world, self%experiment, self%wing, self%catalogue, bins, patterns, parts, &
                             s%flights)
    self%simulator%noise = s%noise%model
    self%simulator%membrane_sd = s%membrane_sd
  end subroutine discretisation_init

  !> Makes the simulator of the other mesh keep its results in `journal`, too. On rank 0.
  subroutine discretisation_use_journal(self, journal)
    class(discretisation_error_t), intent(inout) :: self
    type(journal_t), pointer, intent(in) :: journal
    self%simulator%motion%journal => journal
  end subroutine discretisation_use_journal

  !> Fits the baseline on both meshes and gives the directions of the error to the simulator of the diagnosis. Rank 0 calls it;
  !> the others are in `serve`.
  subroutine discretisation_find(self, s, simulator)
    class(discretisation_error_t), intent(inout), target :: self
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(inout), target :: simulator
    type(whitener_t), target :: whitener
    real(rp), allocatable :: coarse(:), fine(:), jacobian(:, :), white(:, :)
    integer :: n
    self%diagnosis_simulator => simulator
    n = simulator%n_observations
    allocate (coarse(n), fine(n), jacobian(n, simulator%n_baseline), white(n, 1))
    if (self%is_coarser) then
      call fit_both_meshes(self, s, self%simulator, simulator, whitener, coarse, fine, jacobian)
    else
      call fit_both_meshes(self, s, simulator, self%simulator, whitener, coarse, fine, jacobian)
    end if
    if (.not. self%is_found) return
    n = simulator%bins%n ! heights and readings, but no modes
    self%rms = sqrt(sum((fine(:n) - coarse(:n))**2)/max(1, n))
    white(:, 1) = fine - coarse
    call whitener%apply(white)
    call whitener%apply(jacobian)
    self%snr = length_after_projection(white(:, 1), jacobian)
    call simulator%set_error_directions(error_directions(simulator, fine - coarse))
  end subroutine discretisation_find

  !> Returns the directions of the error for the difference(n) between both meshes.
  function error_directions(simulator, difference) result(directions)
    type(wing_simulator_t), intent(in) :: simulator
    real(rp), intent(in) :: difference(:)
    real(rp) :: directions(size(difference), 0:size(simulator%labels%fold))
    integer :: l
    directions(:, 0) = difference
    do l = 1, ubound(directions, 2)
      directions(:, l) = merge(LOADS_DIFFER, 0.0_rp, simulator%labels%surface == l)*difference
    end do
  end function error_directions

  !> Prepares `renew` at q, the fit of a cause, to which `state` belongs: computes the residuals `own` of the simulator of the
  !> diagnosis, and the point q_other of the other mesh that corresponds to q. `can_renew` is false if there is no such point or no
  !> result. On rank 0, while the others serve the simulator of the diagnosis.
  subroutine discretisation_begin_renewal(self, q, state, q_other, own, can_renew)
    class(discretisation_error_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: state
    real(rp), allocatable, intent(out) :: q_other(:)
    real(rp), intent(out) :: own(:)
    logical, intent(out) :: can_renew
    real(rp) :: nothing(size(own), 0)
    can_renew = .false.
    if (.not. self%is_found) return
    call map_to_other_mesh(self, q, q_other)
    if (.not. allocated(q_other)) return
    call self%diagnosis_simulator%evaluate(q, [integer ::], state, own, nothing, can_renew)
  end subroutine discretisation_begin_renewal

  !> Gives `state` the directions of the error from the difference between both meshes at this point. On rank 0, after
  !> `begin_renewal`; the others are in `serve`.
  subroutine discretisation_renew(self, whitener, q_other, own, state)
    class(discretisation_error_t), intent(inout) :: self
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: q_other(:), own(:)
    class(solver_state_t), intent(inout) :: state
    type(nested_fit_t) :: fitted
    class(solver_state_t), allocatable :: other_state
    integer :: i
    logical :: is_valid
    real(rp) :: other(whitener%n), nothing(whitener%n, 0)
    call self%simulator%state_from_mesh(state, self%parents, other_state)
    call fit_nested(self%simulator, whitener, [(i, i=1, self%diagnosis_simulator%n_baseline)], q_other, other_state, &
                    self%options, fitted)
    is_valid = fitted%is_found
    if (is_valid) call self%simulator%evaluate(fitted%q, [integer ::], fitted%state, other, nothing, is_valid)
    call self%simulator%shut_down()
    if (.not. is_valid) return
    select type (state)
    type is (wing_state_t)
      state%error_directions = error_directions(self%diagnosis_simulator, other - own)
    end select
  end subroutine discretisation_renew

  !> Returns the parameters of the other mesh that correspond to q of this mesh, or none if the other mesh lacks a parameter that
  !> differs from its null, or cannot have such a value. A soft place stands for a piece of vein as long as the adjacent edges, and
  !> so does a joint that bends as its vein. The additional rotation must be the same on both meshes, and a piece of half the length
  !> is twice as stiff.
  subroutine map_to_other_mesh(self, q, q_other)
    class(discretisation_error_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    real(rp), allocatable, intent(out) :: q_other(:)
    real(rp), allocatable :: values(:)
    real(rp) :: change, ratio, stiffness
    integer :: i, j, b
    b = self%diagnosis_simulator%n_baseline
    values = self%simulator%null_point()
    values(:b) = q(:b)
    associate (parameters => self%diagnosis_simulator%wing_parameters, others => self%simulator%wing_parameters)
      do i = b + 1, size(q)
        change = q(i) - self%diagnosis_simulator%parameters(i)%null
        if (.not. abs(change) > 0) cycle
        j = find_counterpart(parameters, i, others)
        if (j == 0) return
        ratio = 1 ! of the stiffness of the hinge there to that here, both at their null
        if (is_hinge_of_piece(parameters(i), self%experiment%model%params)) ratio = merge(0.5_rp, 2.0_rp, self%is_coarser)
        if (parameters(i)%kind == KIND_PARAMETER) then
          if (self%experiment%model%params%is_joint(parameters(i)%number)) ratio = exp(others(j)%null - parameters(i)%null)
        end if
        if (abs(ratio - 1) > 0) then
          stiffness = equal_rotation(exp(change), 1.0_rp, ratio)
          if (.not. stiffness > 0) return
          change = log(stiffness/ratio)
        end if
        values(j) = values(j) + change
      end do
    end associate
    if (all(abs(values) < huge(1.0_rp))) call move_alloc(values, q_other)
  end subroutine map_to_other_mesh

  !> Returns the number of parameter i among those of another mesh; 0 if it is not there.
  pure recursive integer function find_counterpart(parameters, i, others) result(j)
    type(wing_parameter_t), intent(in) :: parameters(:), others(:)
    integer, intent(in) :: i
    real(rp), parameter :: NEAR = 0.05_rp ! of a vein: largest distance of the corresponding hinge of the other mesh
    integer :: owner
    associate (one => parameters(i))
      owner = 0
      if (one%kind == KIND_RELAXATION_TIME) owner = find_counterpart(parameters, one%number, others)
      do j = 1, size(others)
        if (others(j)%kind /= one%kind) cycle
        select case (one%kind)
        case (KIND_SOFT)
          if (others(j)%vein == one%vein .and. abs(others(j)%fraction - one%fraction) < NEAR) exit
        case (KIND_DAMAGE, KIND_POINT_MASS)
          if (all(abs(others(j)%disc - one%disc) <= 1.0e-6_rp*one%disc(3))) exit
        case (KIND_RELAXATION)
          if (abs(others(j)%time - one%time) <= 1.0e-6_rp*one%time) exit
        case (KIND_SHAKE)
          if (others(j)%number == one%number .and. others(j)%record == one%record .and. &
              abs(others(j)%time - one%time) <= 1.0e-6_rp*one%time) exit
        case (KIND_RELAXATION_TIME)
          if (others(j)%number == owner) exit
        case default
          if (others(j)%number == one%number) exit
        end select
      end do
    end associate
    if (j > size(others)) j = 0
  end function find_counterpart

  !> Fits the wing on the coarser mesh and then, from there and with the same weights, that on the finer mesh. Returns the
  !> residuals(n) of both fits and the derivatives of the first. Sets self%start, where the diagnosis begins. Shuts down both
  !> simulators, the coarser one first.
  subroutine fit_both_meshes(self, s, coarse, fine, whitener, r_coarse, r_fine, jacobian)
    class(discretisation_error_t), intent(inout) :: self
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(inout), target :: coarse, fine
    type(whitener_t), intent(inout), target :: whitener
    real(rp), intent(out) :: r_coarse(:), r_fine(:), jacobian(:, :)
    type(nested_fit_t) :: one, two
    type(failure_t) :: failure
    class(solver_state_t), allocatable :: state
    integer :: i
    real(rp) :: nothing(size(r_fine), 0), q(size(fine%parameters)), begin(size(coarse%parameters))
    call coarse%initial_state(state)
    begin = coarse%null_point()
    call grow_fit(coarse, state, coarse%independent_fraction(), s%options%fit, begin)
    call whitener%init(coarse, [(i, i=1, coarse%n_observations)], coarse%independent_fraction(), failure)
    if (.not. failure%failed) call fit_loosely(coarse, begin, state, s%options%fit, whitener, one, failure)
    self%is_found = .not. failure%failed
    if (self%is_found) call coarse%evaluate(one%q, one%active, one%state, r_coarse, jacobian, self%is_found)
    call coarse%shut_down()
    if (self%is_found) then
      call fine%state_from_mesh(one%state, self%parents, state)
      q = fine%null_point()
      q(one%active) = one%q(one%active) ! further parameters are those of the catalogue, at their null
      call grow_fit(fine, state, fine%independent_fraction(), s%options%fit, q)
      call fit_nested(fine, whitener, one%active, q, state, loose_options(s%options%fit), two)
      self%is_found = two%is_found
    end if
    if (self%is_found) call fine%evaluate(two%q, [integer ::], two%state, r_fine, nothing, self%is_found)
    call fine%shut_down()
    if (.not. self%is_found) return
    if (self%is_coarser) self%start = two%q
    if (.not. self%is_coarser) self%start = one%q
  end subroutine fit_both_meshes

  !> Returns the length of the part of a that the columns of j cannot imitate.
  real(rp) function length_after_projection(a, j) result(length)
    real(rp), intent(in) :: a(:), j(:, :)
    real(rp), allocatable :: q(:, :), r(:, :)
    call orthogonalise(j, q, r)
    length = norm2(a - matmul(q, matmul(a, q)))
  end function length_after_projection

  !> Does on the other ranks what `find` asks for.
  subroutine discretisation_serve_first(self, simulator)
    class(discretisation_error_t), intent(inout) :: self
    type(wing_simulator_t), intent(inout) :: simulator
    if (self%is_coarser) then
      call self%simulator%serve()
      call simulator%serve()
    else
      call simulator%serve()
      call self%simulator%serve()
    end if
  end subroutine discretisation_serve_first

  !> Does on the other ranks what `renew` asks for.
  subroutine discretisation_serve(self)
    class(discretisation_error_t), intent(inout) :: self
    call self%simulator%serve()
  end subroutine discretisation_serve

  !> Releases everything.
  subroutine discretisation_free(self)
    class(discretisation_error_t), intent(inout) :: self
    call self%simulator%free()
  end subroutine discretisation_free
end module diagnosis_discretisation

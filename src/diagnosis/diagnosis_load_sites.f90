! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes how much a further load would tell about the unknowns of a diagnosis. For each site of a lattice over the wing, and
!> for a force up and a force down, it gives the whitened normal matrix of the tangents.
!>
!> At a distance r from the root the force is that of the nearest applied load, at r0, times r0/r: the wing has already carried
!> this moment at the root. The accuracy of the scan is that of the same load.
!>
!> The gain of the forces and D are common to all loads and known by their sd. They are columns after those of the baseline.
module diagnosis_load_sites
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_lapack, only: factorise, solve_lower
  use base_text, only: number_text
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_wing_bins, only: bin_covariance, bin_rows, bins_t, make_bins, noise_model_t
  use diagnosis_wing_lattice, only: lattice
  use diagnosis_wing_parameters, only: make_fit_case, wing_parameter_tangent, fit_case_coordinates, fit_case_t, wing_parameter_t, &
                                       KIND_INSTRUMENT, KIND_MEMBRANE, KIND_PARAMETER
  use diagnosis_wing_simulator, only: wing_simulator_t, N_COMMON_NUISANCES
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  use measurement_data, only: measured_load_t, measurement_t, observation_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use measurement_instrument_causes, only: FORCE_GAIN
  use measurement_simulation, only: N_NUISANCES
  use solid_usual_causes, only: PARAM_PLATE
  implicit none
  private
  public :: new_load_t, trial_t, common_columns, try_loads, normal_matrix, whitened_tangents

  real(rp), parameter :: SPACING = 0.15_rp, NEAR_ROOT = 0.2_rp !< of the wing's size

  type :: new_load_t
    integer :: number = 0                    !< of the trial
    real(rp) :: site(2) = 0                 !< [m]
    real(rp) :: force = 0                    !< [N]
    real(rp) :: direction(3) = 0
    real(rp), allocatable :: normal(:, :)    !< (columns, columns)
  end type new_load_t

  !> A wing to which new loads are applied.
  type :: trial_t
    integer :: n = 0 !< number of loads
    type(measurement_t), private :: m
    type(bins_t), private :: bins
    type(fit_case_t), private :: fit_case
    type(evaluation_work_t), private :: work
    type(wing_parameter_t), allocatable, private :: parameters(:)
    real(rp), allocatable, private :: q(:)
    real(rp), allocatable, private :: shapes(:, :, :) !< (3, n_all, n) [m] of loads that were applied
    logical, allocatable, private :: is_start(:)      !< (n) the next solution of this load may begin at its shape
  contains
    procedure :: begin => trial_begin
    procedure :: apply => trial_apply
    procedure :: end => trial_end
  end type trial_t

contains

  !> Finds the loads that the wing at q carries without a snap, with their normal matrices of the parameters `columns`. On rank 0
  !> alone.
  subroutine try_loads(s, noise, q, columns, loads)
    class(diagnosis_case_t), intent(in) :: s
    type(noise_model_t), intent(in) :: noise
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    type(new_load_t), allocatable, intent(out) :: loads(:)
    type(trial_t) :: trial
    type(new_load_t) :: one
    integer :: l
    logical :: ok
    allocate (loads(0))
    call trial%begin(s, q)
    do l = 1, trial%n
      call trial%apply(noise, l, columns, one, ok)
      if (ok) loads = [loads, one]
    end do
    call trial%end()
  end subroutine try_loads

  !> Makes the wing at q ready for the new loads, of which there are `n`, perhaps none. On rank 0 alone.
  subroutine trial_begin(self, s, q)
    class(trial_t), intent(inout) :: self
    class(diagnosis_case_t), intent(in) :: s
    real(rp), intent(in) :: q(:)
    type(experiment_t) :: experiment
    type(failure_t) :: failure
    self%n = 0
    call empty_measurement(s, self%m)
    if (size(self%m%loads) == 0) return
    call experiment%init(self%m, s%wing_case%wing, s%experiment%model%params, [integer ::], s%experiment%options, failure, &
                         s%instrument, masses=s%experiment%masses)
    if (failure%failed) return
    call make_bins(experiment, s%bins%size, self%bins)
    call make_fit_case(experiment, s%wing_case%wing, s%catalogue%parameters, q, self%fit_case)
    call self%work%init(self%fit_case%experiment)
    self%parameters = s%catalogue%parameters
    self%q = q
    self%n = size(self%m%loads)
    allocate (self%shapes(3, self%fit_case%experiment%model%n_all, self%n), source=0.0_rp)
    allocate (self%is_start(self%n), source=.false.)
  end subroutine trial_begin

  !> Applies load l, and computes in `one` its normal matrix of the parameters `columns`. `ok` is false if the wing does not carry
  !> the load. A load that is applied again takes less time.
  subroutine trial_apply(self, noise, l, columns, one, ok)
    class(trial_t), intent(inout) :: self
    type(noise_model_t), intent(in) :: noise
    integer, intent(in) :: l, columns(:)
    type(new_load_t), intent(out) :: one
    logical, intent(out) :: ok
    one%number = l
    one%site = self%m%loads(l)%point
    one%force = self%m%loads(l)%force
    one%direction = self%m%loads(l)%direction
    call find_normal(self, noise, columns, l, one%normal, ok)
  end subroutine trial_apply

  !> Releases what `begin` made.
  subroutine trial_end(self)
    class(trial_t), intent(inout) :: self
    if (self%n > 0) call self%work%free()
    if (allocated(self%shapes)) deallocate (self%shapes, self%is_start)
    self%n = 0
  end subroutine trial_end

  !> Makes a measurement with all new loads.
  subroutine empty_measurement(s, m)
    class(diagnosis_case_t), intent(in) :: s
    type(measurement_t), intent(out) :: m
    type(measured_load_t), allocatable :: loads(:)
    type(observation_t), allocatable :: observations(:)
    real(rp), allocatable :: sites(:, :)
    real(rp) :: radius
    integer :: i, k, sign_of_it, nearest, n, n_seen
    m = s%measurement
    call lattice(s%wing_case%wing, s%experiment%model%size, SPACING, sites)
    allocate (loads(2*size(sites, 2)), observations(2*size(sites, 2)*size(m%observations)))
    n = 0
    n_seen = 0
    do i = 1, size(sites, 2)
      radius = norm2(sites(:, i) - s%experiment%root(:2))
      nearest = nearest_load(m, sites(:, i))
      if (nearest == 0 .or. radius < NEAR_ROOT*s%experiment%model%size) cycle
      do sign_of_it = 1, -1, -2
        n = n + 1
        loads(n) = m%loads(nearest)
        loads(n)%name = 'new'//number_text(n)
        loads(n)%point = sites(:, i)
        loads(n)%direction = sign_of_it*m%loads(nearest)%direction
        loads(n)%force = m%loads(nearest)%force*norm2(m%loads(nearest)%point - s%experiment%root(:2))/radius
        if (loads(n)%order > 0) loads(n)%order = maxval(m%loads%order) + 1
        do k = 1, size(m%observations)
          if (m%observations(k)%load /= nearest) cycle
          n_seen = n_seen + 1
          observations(n_seen) = m%observations(k)
          observations(n_seen)%load = n
        end do
      end do
    end do
    m%loads = loads(:n)
    m%observations = observations(:n_seen)
  end subroutine empty_measurement

  !> Returns the strongest of the loads nearest to a site; 0 if no load has a force above 0.
  pure integer function nearest_load(m, site) result(nearest)
    type(measurement_t), intent(in) :: m
    real(rp), intent(in) :: site(2)
    real(rp) :: distance, least
    integer :: l
    nearest = 0
    least = huge(least)
    do l = 1, size(m%loads)
      if (.not. m%loads(l)%force > 0) cycle
      distance = norm2(m%loads(l)%point - site)
      if (nearest > 0) then
        if (distance > least .or. .not. (distance < least .or. m%loads(l)%force > m%loads(nearest)%force)) cycle
      end if
      nearest = l
      least = distance
    end do
  end function nearest_load

  !> Computes the normal matrix of load l. `ok` is false if the wing has no shape under the load, or only one after a snap.
  subroutine find_normal(self, noise, columns, l, normal, ok)
    class(trial_t), intent(inout) :: self
    type(noise_model_t), intent(in) :: noise
    integer, intent(in) :: columns(:), l
    real(rp), allocatable, intent(out) :: normal(:, :)
    logical, intent(out) :: ok
    type(evaluation_t) :: evaluation
    real(rp) :: sd(N_NUISANCES)
    real(rp) :: raw(self%fit_case%experiment%comparisons(l)%n), errors(size(raw), N_NUISANCES)
    real(rp) :: white(self%bins%count(l), size(columns)), seen(self%bins%count(l), 1), c(self%bins%count(l), self%bins%count(l))
    integer :: i
    call evaluation%init(self%fit_case%experiment, l, .false.)
    call evaluate(self%fit_case%experiment, self%work, fit_case_coordinates(self%fit_case, self%q), l, self%is_start(l), &
                  self%shapes(:, :, l), evaluation)
    self%is_start(l) = evaluation%is_start
    ok = evaluation%is_feasible() .and. evaluation%snaps == 0
    if (.not. ok) return
    call bin_covariance(self%bins, noise, [(i, i=self%bins%first(l), self%bins%first(l) + self%bins%count(l) - 1)], c)
    call self%work%nuisance_tangents(self%fit_case%experiment, l, errors, sd)
    do i = 1, N_NUISANCES
      call bin_rows(self%bins, l, sd(i)*errors(:, i), seen(:, 1))
      c = c + matmul(seen, transpose(seen))
    end do
    do i = 1, size(columns)
      call wing_parameter_tangent(self%work, self%fit_case, self%parameters, self%q, columns(i), l, raw)
      call bin_rows(self%bins, l, raw, white(:, i))
    end do
    call factorise(c, ok)
    if (.not. ok) return
    call solve_lower(c, white)
    normal = matmul(transpose(white), white)
  end subroutine find_normal

  !> Finds the quantities that are common to all loads and known by their sd.
  subroutine common_columns(s, columns, sd)
    class(diagnosis_case_t), intent(in) :: s
    integer, allocatable, intent(out) :: columns(:)
    real(rp), allocatable, intent(out) :: sd(:)
    logical :: fits_membrane
    integer :: i
    fits_membrane = any(s%catalogue%parameters%kind == KIND_MEMBRANE)
    allocate (columns(0), sd(0))
    do i = s%catalogue%n_baseline + 1, size(s%catalogue%parameters)
      associate (one => s%catalogue%parameters(i), gain_sd => s%measurement%accuracy%force_gain)
        if (one%kind == KIND_INSTRUMENT .and. one%number == FORCE_GAIN .and. gain_sd > 0) then
          columns = [columns, i]
          sd = [sd, gain_sd]
        else if (one%kind == KIND_PARAMETER .and. one%number == PARAM_PLATE .and. s%membrane_sd > 0 .and. .not. fits_membrane) then
          columns = [columns, i]
          sd = [sd, s%membrane_sd]
        end if
      end associate
    end do
  end subroutine common_columns

  !> Computes white(n_observations, columns), the whitened tangents of all loads of the measurement. For independent_fraction see
  !> `covariance` of simulator_t. Solutions begin at the shapes of `from`. Rank 0 calls it; the others serve.
  subroutine whitened_tangents(simulator, independent_fraction, q, from, columns, white, ok)
    type(wing_simulator_t), intent(inout) :: simulator
    real(rp), intent(in) :: independent_fraction, q(:)
    class(solver_state_t), intent(in) :: from
    integer, intent(in) :: columns(:)
    real(rp), allocatable, intent(out) :: white(:, :)
    logical, intent(out) :: ok
    type(whitener_t) :: whitener
    type(failure_t) :: failure
    real(rp) :: residuals(simulator%n_observations)
    real(rp), allocatable :: nuisances(:, :), patterns(:, :)
    integer :: i, n
    n = simulator%n_observations
    allocate (white(n, size(columns)), nuisances(n, simulator%n_nuisances), patterns(n, 0))
    call simulator%evaluate(q, columns, from, residuals, white, ok)
    if (ok) call simulator%directions(q, from, nuisances, patterns, ok)
    if (ok) call whitener%init(simulator, [(i, i=1, n)], independent_fraction, failure)
    if (failure%failed) ok = .false.
    if (.not. ok) return
    n = N_NUISANCES*size(simulator%experiment%loads)
    nuisances(:, n + 1:n + N_COMMON_NUISANCES) = 0 ! here these quantities are columns
    call whitener%add_directions(nuisances)
    call whitener%apply(white)
  end subroutine whitened_tangents

  !> Returns the normal matrix of the whitened tangents white(n_observations, columns). columns(:) are first the n_baseline
  !> parameters of the baseline, then the size(common_sd) quantities that are common to all loads, then others; the first two groups
  !> have priors.
  function normal_matrix(simulator, columns, common_sd, white) result(normal)
    type(wing_simulator_t), intent(in) :: simulator
    integer, intent(in) :: columns(:)
    real(rp), intent(in) :: common_sd(:), white(:, :)
    real(rp) :: normal(size(columns), size(columns))
    integer :: i, n
    normal = matmul(transpose(white), white)
    do i = 1, simulator%n_baseline
      associate (sd => simulator%parameters(columns(i))%prior_sd)
        if (sd > 0) normal(i, i) = normal(i, i) + 1/sd**2
      end associate
    end do
    do i = 1, size(common_sd)
      n = simulator%n_baseline + i
      normal(n, n) = normal(n, n) + 1/common_sd(i)**2
    end do
  end function normal_matrix
end module diagnosis_load_sites

! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures how well a model predicts data that were not used for its fit. Locations are left out one after another, each with all
!> its levels, signs and repeats, and predicted by the fit to the others.
!>
!> The score of a fold is its log predictive density, a normal density about the prediction. Its covariance contains noise,
!> nuisances and the uncertainty of the fitted parameters, in the linear approximation.
!>
!> The fit to the others is one Gauss-Newton step from the fit to all data, whose tangents are known. Only the loads that were
!> left out are then simulated. If the score differs by more than LINEAR from the one that the tangents predict, more steps are
!> made.
module inference_validation
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_lapack, only: orthogonalise, solve_lower
  use inference_refit, only: fit_nested, nested_fit_t, nested_unknowns
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  use least_squares_fit, only: fit_options_t
  use least_squares_problem, only: unknowns_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: validation_t, validate, compare_folds

  !> One row for every fold that could be predicted.
  type :: validation_t
    integer, allocatable :: fold(:)
    integer, allocatable :: n(:)           !< observations
    real(rp), allocatable :: density(:)    !< log predictive density, without the constant
    real(rp), allocatable :: chi2(:)       !< of the prediction over noise and nuisances alone
    real(rp), allocatable :: square(:)     !< sum of squared differences in the observations' units
    logical :: is_complete = .false.       !< all folds could be predicted
  end type validation_t

  !> Residuals, derivatives, errors and state at one point.
  type :: tangents_t
    real(rp) :: independent_fraction = 1
    logical :: is_valid = .false.
    real(rp), allocatable :: q(:), residuals(:), jacobian(:, :), nuisances(:, :)
    class(solver_state_t), allocatable :: state
  end type tangents_t

  real(rp), parameter :: LINEAR = 0.1_rp  !< see above
  integer, parameter :: MOST_STEPS = 6    !< of a fit without one location: a model that needs more is not a good one

contains

  !> Validates the model with the parameters `active` free. It starts from q, the fit to all data, which ended in the state `from`,
  !> and uses the nuisances(n, :) of this fit. For independent_fraction see `covariance` of simulator_t.
  subroutine validate(simulator, active, q, from, nuisances, independent_fraction, options, validation)
    class(simulator_t), intent(inout), target :: simulator
    integer, intent(in) :: active(:)
    real(rp), intent(in) :: q(:), nuisances(:, :), independent_fraction
    class(solver_state_t), intent(in) :: from
    type(fit_options_t), intent(in) :: options
    type(validation_t), intent(out) :: validation
    type(tangents_t) :: full
    real(rp) :: scores(3)
    integer, allocatable :: outside(:)
    integer :: f, i
    logical :: is_valid
    allocate (validation%fold(0), validation%n(0), validation%density(0), validation%chi2(0), validation%square(0))
    validation%is_complete = .true.
    call find_tangents(simulator, active, q, from, full, is_valid)
    full%nuisances = nuisances
    full%independent_fraction = independent_fraction
    do f = 1, maxval(simulator%labels%fold)
      outside = pack([(i, i=1, simulator%n_observations)], simulator%labels%fold(simulator%labels%surface) == f)
      if (size(outside) == 0) cycle
      scores = 0
      if (full%is_valid) call predict_fold(simulator, f, active, full, options, outside, scores, is_valid)
      validation%is_complete = validation%is_complete .and. is_valid
      if (.not. is_valid) cycle
      validation%fold = [validation%fold, f]
      validation%n = [validation%n, size(outside)]
      validation%density = [validation%density, scores(1)]
      validation%chi2 = [validation%chi2, scores(2)]
      validation%square = [validation%square, scores(3)]
    end do
  end subroutine validate

  !> Computes residuals, derivatives and state of all observations at q, starting from the state `from`.
  subroutine find_tangents(simulator, active, q, from, full, is_valid)
    class(simulator_t), intent(inout) :: simulator
    integer, intent(in) :: active(:)
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    type(tangents_t), intent(out) :: full
    logical, intent(out) :: is_valid
    integer :: n
    n = simulator%n_observations
    full%q = q
    allocate (full%residuals(n), full%jacobian(n, size(active)))
    call simulator%evaluate(q, active, from, full%residuals, full%jacobian, is_valid, full%state)
    full%is_valid = is_valid
  end subroutine find_tangents

  !> Returns the scores of fold f, whose observations are `outside`: log density, chi^2, sum of squares.
  subroutine predict_fold(simulator, f, active, full, options, outside, scores, is_valid)
    class(simulator_t), intent(inout), target :: simulator
    integer, intent(in) :: f, active(:), outside(:)
    type(tangents_t), intent(in) :: full
    type(fit_options_t), intent(in) :: options
    real(rp), intent(out) :: scores(3)
    logical, intent(out) :: is_valid
    type(whitener_t), target :: inner, outer, wide
    type(nested_fit_t) :: found
    type(fit_options_t) :: few
    type(failure_t) :: failure
    real(rp), allocatable :: spread(:, :), step(:), q(:), promised(:), seen(:)
    integer, allocatable :: inside(:)
    integer :: i
    logical :: is_linear
    scores = 0
    inside = pack([(i, i=1, simulator%n_observations)], simulator%labels%fold(simulator%labels%surface) /= f)
    is_valid = size(inside) > size(active)
    if (.not. is_valid) return
    call inner%init(simulator, inside, full%independent_fraction, failure)
    if (.not. failure%failed) call outer%init(simulator, outside, full%independent_fraction, failure)
    is_valid = .not. failure%failed
    if (.not. is_valid) return
    call inner%add_directions(full%nuisances(inside, :))
    call step_without(simulator, active, full, inner, step, spread)
    wide = outer
    call outer%add_directions(full%nuisances(outside, :))
    call wide%add_directions(reshape([full%nuisances(outside, :), matmul(full%jacobian(outside, :), spread)], &
                                     [size(outside), size(full%nuisances, 2) + size(active)]))
    q = full%q
    q(active) = q(active) + step
    promised = full%residuals(outside) + matmul(full%jacobian(outside, :), step)
    call predict(simulator, full%state, f, q, outside, seen, is_valid)
    is_linear = .false.
    if (is_valid) is_linear = abs(log_density(wide, seen) - log_density(wide, promised)) <= LINEAR
    if (.not. is_linear) then
      few = options
      few%reduction_tolerance = max(options%reduction_tolerance, LINEAR/max(1.0_rp, real(inner%n, rp)))
      few%most_rejections = 2
      few%most_iterations = min(options%most_iterations, MOST_STEPS)
      call fit_nested(simulator, inner, active, merge(q, full%q, is_valid), full%state, few, found, &
                      is_wanted=simulator%labels%fold /= f)
      is_valid = found%is_found
      if (is_valid) call predict(simulator, full%state, f, found%q, outside, seen, is_valid)
    end if
    if (.not. is_valid) return
    scores(3) = sum(seen**2)
    scores(1) = log_density(wide, seen)
    call outer%apply_one(seen)
    scores(2) = sum(seen**2)
  end subroutine predict_fold

  !> Computes residuals of the observations of fold f at q, starting from `state`.
  subroutine predict(simulator, state, f, q, outside, residuals, is_valid)
    class(simulator_t), intent(inout) :: simulator
    class(solver_state_t), intent(in) :: state
    integer, intent(in) :: f, outside(:)
    real(rp), intent(in) :: q(:)
    real(rp), allocatable, intent(out) :: residuals(:)
    logical, intent(out) :: is_valid
    real(rp) :: all(simulator%n_observations), jacobian(simulator%n_observations, 0)
    call simulator%evaluate(q, [integer ::], state, all, jacobian, is_valid, is_wanted=simulator%labels%fold == f)
    residuals = all(outside)
  end subroutine predict

  !> Returns the log density without its constant.
  real(rp) function log_density(whitener, residuals)
    type(whitener_t), intent(in) :: whitener
    real(rp), intent(in) :: residuals(:)
    real(rp) :: white(size(residuals))
    white = residuals
    call whitener%apply_one(white)
    log_density = -0.5_rp*(sum(white**2) + whitener%log_determinant)
  end function log_density

  !> Finds by how much the active parameters differ if only the observations of `inner` are fitted, in the linear approximation
  !> and within bounds, and spread(active, active) with spread spread^T their posterior covariance.
  subroutine step_without(simulator, active, full, inner, step, spread)
    class(simulator_t), intent(in) :: simulator
    integer, intent(in) :: active(:)
    type(tangents_t), intent(in) :: full
    type(whitener_t), intent(in) :: inner
    real(rp), allocatable, intent(out) :: step(:), spread(:, :)
    real(rp), parameter :: RIDGE = 1.0e-8_rp ! of the largest derivative, for what neither data nor prior determine
    type(unknowns_t) :: unknowns
    real(rp), allocatable :: rows(:, :), right(:), white(:, :), basis(:, :), r(:, :), lower(:, :), inverse(:, :)
    real(rp) :: largest
    integer :: i, n
    n = size(active)
    unknowns = nested_unknowns(simulator, active, full%q)
    white = reshape([full%jacobian(inner%rows, :), full%residuals(inner%rows)], [inner%n, n + 1])
    call inner%apply(white)
    allocate (rows(inner%n + n, n), right(inner%n + n), source=0.0_rp)
    rows(:inner%n, :) = white(:, :n)
    right(:inner%n) = white(:, n + 1)
    largest = maxval(norm2(white(:, :n), 1))
    if (.not. largest > 0) largest = 1 ! the data show none of them
    do i = 1, n
      rows(inner%n + i, i) = RIDGE*largest/unknowns%unit(i)
      if (.not. unknowns%prior_sd(i) > 0) cycle
      rows(inner%n + i, i) = 1/unknowns%prior_sd(i)
      right(inner%n + i) = (full%q(active(i)) - unknowns%prior(i))/unknowns%prior_sd(i)
    end do
    call orthogonalise(rows, basis, r)
    lower = transpose(r)
    allocate (inverse(n, n), source=0.0_rp)
    do i = 1, n
      inverse(i, i) = 1
    end do
    call solve_lower(lower, inverse)
    spread = transpose(inverse)
    step = -matmul(spread, matmul(right, basis))
    step = max(unknowns%lower - full%q(active), min(unknowns%upper - full%q(active), step))
  end subroutine step_without

  !> Returns the mean gain of log predictive density per fold of `other` over `one`, and the standard error of that mean over
  !> folds that both predict. `is_valid` is false if there are fewer than 2.
  subroutine compare_folds(one, other, gain, standard_error, is_valid)
    type(validation_t), intent(in) :: one, other
    real(rp), intent(out) :: gain, standard_error
    logical, intent(out) :: is_valid
    real(rp), allocatable :: gains(:)
    integer :: i, k
    allocate (gains(0))
    do i = 1, size(one%fold)
      do k = 1, size(other%fold)
        if (one%fold(i) == other%fold(k)) gains = [gains, other%density(k) - one%density(i)]
      end do
    end do
    gain = 0
    standard_error = huge(standard_error)
    is_valid = size(gains) >= 2
    if (.not. is_valid) return
    gain = sum(gains)/size(gains)
    standard_error = sqrt(sum((gains - gain)**2)/(size(gains) - 1)/size(gains))
  end subroutine compare_folds
end module inference_validation

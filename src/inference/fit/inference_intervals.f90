! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds 90 % intervals of the parameters of causes by profile likelihood, in units of the estimated noise, and tells whether
!> estimates and intervals are evidence for each cause.
module inference_intervals
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use inference_design, only: candidate_t
  use inference_refit, only: fit_nested, nested_fit_t, nested_problem_t, nested_unknowns
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  use least_squares_fit, only: fit_options_t
  use least_squares_profile, only: interval_t, linear_guess_t, profile_interval, THRESHOLD_90
  use least_squares_state, only: solver_point_t
  implicit none
  private
  public :: find_intervals, find_support, refit_from_better

contains

  !> Finds intervals of the parameters that `extended`, a fit over the observations of the whitener, has beside those of the
  !> baseline, in the order in which they are active. `scale` is the variance of the noise over that of the whitener. Each search
  !> begins in the state in which the fit has ended.
  subroutine find_intervals(simulator, whitener, scale, options, extended, intervals)
    class(simulator_t), intent(inout), target :: simulator
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: scale
    type(fit_options_t), intent(in) :: options
    type(nested_fit_t), intent(in) :: extended
    type(interval_t), allocatable, intent(out) :: intervals(:)
    real(rp), parameter :: RESOLUTION = 0.01_rp ! of the threshold, in sums of squares
    type(nested_problem_t) :: problem
    type(solver_point_t) :: optimum
    type(fit_options_t) :: fits
    integer :: i, n, first
    n = size(extended%active)
    first = simulator%n_baseline + 1
    allocate (intervals(n - first + 1))
    fits = options
    fits%most_rejections = 3
    ! The tolerance is a fraction of the sum of squares at the end of an interval: its minimum may be far below the threshold.
    fits%reduction_tolerance = max(fits%reduction_tolerance, RESOLUTION*THRESHOLD_90*scale/ &
                                   (extended%cost() + THRESHOLD_90*scale))
    optimum%p = extended%q(extended%active)
    allocate (optimum%state, source=extended%state)
    do i = first, n
      call problem%init(simulator, whitener, extended%active, extended%q)
      call profile_interval(problem, nested_unknowns(simulator, extended%active, extended%q), optimum, i, &
                            linear_guess_t(sqrt(extended%covariance(i, i)), extended%covariance(:, i)/extended%covariance(i, i)), &
                            THRESHOLD_90*scale, fits, intervals(i - first + 1))
    end do
  end subroutine find_intervals

  !> Tells whether an interval excludes the null.
  pure elemental logical function is_null_outside(interval, null) result(is_outside)
    type(interval_t), intent(in) :: interval
    real(rp), intent(in) :: null
    is_outside = (interval%has_lower .and. null < interval%lower) .or. (interval%has_upper .and. null > interval%upper)
  end function is_null_outside

  !> Tells whether every one of `causes`, which `extended` fits jointly, has a parameter whose interval excludes its null, and
  !> whether such a parameter lies at a bound of its box.
  pure subroutine find_support(parameters, causes, n_baseline, extended, intervals, is_null_excluded, is_at_bound)
    type(parameter_t), intent(in) :: parameters(:)
    type(candidate_t), intent(in) :: causes(:)
    integer, intent(in) :: n_baseline
    type(nested_fit_t), intent(in) :: extended
    type(interval_t), intent(in) :: intervals(:)
    logical, intent(out) :: is_null_excluded, is_at_bound
    logical :: is_decisive(size(intervals))
    integer :: i, c, columns(size(intervals))
    columns = extended%active(n_baseline + 1:)
    is_decisive = is_null_outside(intervals, parameters(columns)%null)
    is_null_excluded = .true.
    do c = 1, size(causes)
      is_null_excluded = is_null_excluded .and. &
                         any([(is_decisive(i) .and. any(causes(c)%columns == columns(i)), i=1, size(columns))])
    end do
    is_at_bound = any(is_decisive .and. extended%is_at_bound(n_baseline + 1:) .and. &
                      abs(extended%q(columns) - parameters(columns)%null) > 0)
  end subroutine find_support

  !> Fits the causes again from the point where a profile has found a smaller sum of squares than the fit. Otherwise the fitted
  !> value could lie outside its own interval.
  subroutine refit_from_better(simulator, whitener, options, intervals, extended, is_better)
    class(simulator_t), intent(inout), target :: simulator
    type(whitener_t), intent(in), target :: whitener
    type(fit_options_t), intent(in) :: options
    type(interval_t), intent(in) :: intervals(:)
    type(nested_fit_t), intent(inout) :: extended
    logical, intent(out) :: is_better
    type(nested_fit_t) :: other
    integer :: columns(size(intervals))
    real(rp) :: q(size(extended%q))
    columns = extended%active(simulator%n_baseline + 1:)
    q = extended%q
    is_better = any((intervals%has_lower .and. q(columns) < intervals%lower) .or. &
                    (intervals%has_upper .and. q(columns) > intervals%upper))
    if (.not. is_better) return
    q(columns) = intervals%best
    call fit_nested(simulator, whitener, extended%active, q, extended%state, options, other)
    is_better = other%is_found
    if (is_better) is_better = other%cost() < extended%cost()
    if (is_better) extended = other
  end subroutine refit_from_better
end module inference_intervals

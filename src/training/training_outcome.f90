! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the result of a training: the point, how it was reached, and what the data tell about every parameter.
module training_outcome
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  use least_squares_posterior, only: posterior_t
  use least_squares_profile, only: interval_t
  use measurement_evaluation, only: evaluation_t
  implicit none
  private
  public :: trained_t

  !> Holds the outcome of a training.
  type, extends(visited_t) :: trained_t
    real(rp), allocatable :: coordinates(:)  !< of the experiment
    real(rp), allocatable :: values(:)       !< of the unknowns, in their units
    integer, allocatable :: sides(:)         !< (unknowns) -1 or 1: the value is at the lower or upper bound of its box
    logical :: is_cold = .false.             !< all solutions of the polish began at the unloaded wing
    logical :: has_snapped = .false.         !< a fit on the way ended with a shape that the wing does not reach from rest
    logical :: is_polished = .false.         !< least squares were completed, and the following results are known
    character(:), allocatable :: reason      !< why least squares ended; not allocated if they were not asked for
    real(rp), allocatable :: path(:, :)      !< of all fits, one behind the other, see fit_by_continuation; some are without a load
    real(rp), allocatable :: local_minima(:, :)      !< (1 + unknowns, starts) chi^2 and coordinates where each start ended
    type(posterior_t) :: posterior
    real(rp), allocatable :: prior_sd(:)     !< prior sd of the coordinates of the posterior; 0: no prior
    logical :: has_intervals = .false.
    type(interval_t), allocatable :: intervals(:)
    logical, allocatable :: is_left_out(:, :) !< (loads, unknowns) the load does not count in the interval, because it jumps
    logical :: is_solved = .false.           !< all shapes were found from the unloaded wing, and lie in no excluded zone
    type(evaluation_t), allocatable :: evaluations(:) !< (loads) of the solution from the unloaded wing
    real(rp) :: h = 0                        !< [m] cost of the solution from the unloaded wing
    real(rp) :: chi2 = 0
    real(rp) :: prior_chi2 = 0               !< sum of squares of the priors
    logical :: fits = .false.                !< chi2 agrees with the declared errors: it is at most three sd too large
    real(rp) :: cold_difference = 0          !< [m] largest distance of a point between warm and cold solutions
    integer :: n_evaluations = 0             !< points at which all loads were solved
  contains
    procedure :: visit => trained_visit
    procedure :: cost => trained_cost
    procedure :: determines => trained_determines
    procedure :: has_failed_polish => trained_has_failed_polish
    procedure :: bound => trained_bound
  end type trained_t

contains

  !> Shows to the visitor what a polished minimum is. Its evaluations follow from the coordinates, and the rest is found afterwards.
  subroutine trained_visit(self, visitor)
    class(trained_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit_allocatable('coordinates', self%coordinates)
    call visitor%visit('is_cold', self%is_cold)
    call visitor%visit('has_snapped', self%has_snapped)
    call visitor%visit('is_polished', self%is_polished)
    call visitor%visit_allocatable('reason', self%reason)
    call visitor%visit_allocatable('path', self%path)
    associate (posterior => self%posterior)
      call visitor%visit_allocatable('posterior_covariance', posterior%covariance)
      call visitor%visit_allocatable('posterior_sd', posterior%sd)
      call visitor%visit_allocatable('posterior_singular_values', posterior%singular_values)
      call visitor%visit_allocatable('posterior_combinations', posterior%combinations)
    end associate
    call visitor%visit_allocatable('prior_sd', self%prior_sd)
    call visitor%visit('is_solved', self%is_solved)
    call visitor%visit('h', self%h)
    call visitor%visit('chi2', self%chi2)
    call visitor%visit('prior_chi2', self%prior_chi2)
    call visitor%visit('fits', self%fits)
    call visitor%visit('cold_difference', self%cold_difference)
    call visitor%visit('n_evaluations', self%n_evaluations)
    call visitor%leave_out('values sides local_minima posterior has_intervals intervals is_left_out evaluations')
  end subroutine trained_visit

  !> Returns the quantity that least squares minimise: chi^2 and the priors' sum of squares.
  pure real(rp) function trained_cost(self) result(cost)
    class(trained_t), intent(in) :: self
    cost = self%chi2 + self%prior_chi2
  end function trained_cost

  !> Tells whether the data determine unknown i: its interval has two ends or, if intervals were not asked for, the data halve its
  !> prior standard deviation and it is not at a bound of its box. A polish that failed determines nothing. If no polish was asked
  !> for, the result is true unless the unknown is at a bound.
  pure logical function trained_determines(self, i) result(is_determined)
    class(trained_t), intent(in) :: self
    integer, intent(in) :: i
    if (self%has_intervals) then
      is_determined = self%intervals(i)%has_lower .and. self%intervals(i)%has_upper
      return
    end if
    is_determined = self%bound(i) == 0 .and. .not. self%has_failed_polish()
    if (.not. self%is_polished) return
    if (self%prior_sd(i) > 0) is_determined = is_determined .and. self%posterior%sd(i) <= self%prior_sd(i)/2
  end function trained_determines

  !> Tells whether a polish was asked for but least squares accepted no step, so that only the point of the search is known.
  pure logical function trained_has_failed_polish(self) result(has_failed)
    class(trained_t), intent(in) :: self
    has_failed = allocated(self%reason) .and. .not. self%is_polished
  end function trained_has_failed_polish

  !> Returns -1, 0 or 1: unknown i is at the lower bound of its box, inside, at the upper one.
  pure integer function trained_bound(self, i) result(side)
    class(trained_t), intent(in) :: self
    integer, intent(in) :: i
    side = 0
    if (allocated(self%sides)) side = self%sides(i)
  end function trained_bound
end module training_outcome

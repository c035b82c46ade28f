! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the options of a fit and its result, and tells whether the fit leads to a known minimum.
module least_squares_report
  use base_kinds, only: rp
  use base_lapack, only: solve_least_squares
  use least_squares_problem, only: unknowns_t
  use least_squares_state, only: solver_point_t
  implicit none
  private
  public :: fit_options_t, fit_report_t, leads_to_known

  !> The choices of the algorithm.
  type :: fit_options_t
    real(rp) :: damping = 1.0e-3_rp       !< of the first step; 0: a full Gauss-Newton step
    real(rp) :: step_tolerance = 1.0e-9_rp      !< of an unknown, in its unit (1 where it is a logarithm)
    real(rp) :: reduction_tolerance = 1.0e-12_rp !< relative, of the sum of squares
    real(rp) :: largest_step = 2.0_rp           !< of an unknown, in its unit
    integer :: most_iterations = 100            !< steps tried
    !> Number of rejected steps in a row after which the sum of squares is taken to jump, as where a solution is about to move to
    !> another branch. The best point is then taken as the minimum.
    integer :: most_rejections = huge(1)
    logical :: is_smooth = .false. !< a point to which the residuals jump is not valid, see solver_state_t
    !> A known minimum, and the standard deviations there. The fit ends as soon as it leads to this minimum. Not allocated: no
    !> minimum is known.
    real(rp), allocatable :: known(:), known_sd(:)
  end type fit_options_t

  !> The result. Everything belongs to the point p and its state.
  type, extends(solver_point_t) :: fit_report_t
    logical :: is_converged = .false.
    logical :: leads_to_known = .false.         !< the fit has ended because it leads to the known minimum of the options
    logical :: has_jumped = .false.             !< it has ended because residuals jump: at the start, or at the end of every step
    logical, allocatable :: jumped(:)           !< (groups) those whose residuals jump, see solver_state_t
    character(:), allocatable :: reason         !< why the fit has ended
    real(rp), allocatable :: residuals(:), jacobian(:, :) !< of the problem, without priors
    real(rp) :: chi2 = 0                        !< sum of squares of the residuals
    real(rp) :: prior_chi2 = 0                  !< sum of squares of the priors
    logical, allocatable :: is_at_bound(:)
    integer :: n_accepted = 0, n_evaluations = 0
    real(rp) :: last_step = 0                   !< largest change of an unknown, in its unit, in the last step tried
    real(rp), allocatable :: path(:, :)         !< (3, 0:n_accepted) evaluations so far, chi2, prior_chi2
  contains
    procedure :: cost => report_cost
  end type fit_report_t

contains

  !> Returns the sum of squares with priors.
  pure real(rp) function report_cost(self) result(cost)
    class(fit_report_t), intent(in) :: self
    cost = self%chi2 + self%prior_chi2
  end function report_cost

  !> Tells whether the problem, linear about the point of the report, has its minimum at the known one: no unknown differs by more
  !> than its known_sd or a quarter of its prior's standard deviation, and the sum of squares of the linear problem at the known
  !> point lies at most 1 above its minimum. Enters this in the report, without convergence.
  logical function leads_to_known(known, known_sd, unknowns, report)
    real(rp), intent(in) :: known(:), known_sd(:)
    type(unknowns_t), intent(in) :: unknowns
    type(fit_report_t), intent(inout) :: report
    real(rp), parameter :: PART_OF_PRIOR = 0.25_rp, COST = 1
    real(rp), allocatable :: rows(:, :), right(:)
    real(rp) :: change(size(known)), near(size(known))
    integer :: i, m
    m = size(report%residuals)
    allocate (rows(m + size(known), size(known)), right(m + size(known)), source=0.0_rp)
    rows(:m, :) = report%jacobian
    right(:m) = -report%residuals
    near = known_sd
    do i = 1, size(known)
      if (.not. unknowns%prior_sd(i) > 0) cycle
      near(i) = min(near(i), PART_OF_PRIOR*unknowns%prior_sd(i))
      rows(m + i, i) = 1/unknowns%prior_sd(i)
      right(m + i) = -(report%p(i) - unknowns%prior(i))/unknowns%prior_sd(i)
    end do
    call solve_least_squares(rows, right, change, leads_to_known)
    if (.not. leads_to_known) return
    change = max(unknowns%lower, min(unknowns%upper, report%p + change)) - known
    leads_to_known = all(abs(change) <= near) .and. sum(matmul(rows, change)**2) <= COST
    if (.not. leads_to_known) return
    report%is_converged = .false.
    report%leads_to_known = .true.
    report%reason = 'the fit leads to the known minimum'
  end function leads_to_known
end module least_squares_report

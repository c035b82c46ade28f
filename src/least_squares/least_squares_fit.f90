! SPDX-License-Identifier: GPL-3.0-or-later
!> Minimises sums of squares by Levenberg's and Marquardt's method with bounds and priors.
!>
!> A step d minimises |r + J d|^2 + damping |D d|^2 over the unknowns that are not held at a bound, with D the
!> largest norms of the columns of J so far (More), within the bounds and a largest step. The damping follows the
!> ratio of actual and predicted reduction (Nielsen). Priors are residuals like others.
module least_squares_fit
  use base_errors, only: require
  use base_kinds, only: rp
  use base_lapack, only: solve_least_squares, triangle_of
  use least_squares_problem, only: least_squares_t, unknowns_t
  use least_squares_report, only: fit_options_t, fit_report_t, leads_to_known
  use least_squares_state, only: solver_point_t, solver_state_t
  implicit none
  private
  public :: fit, fit_options_t, fit_report_t

  !> The point that is tried, and the limits of steps.
  type, extends(solver_point_t) :: trial_t
    real(rp) :: damping = 0, growth = 2         !< damping of steps, and its factor when a step fails
    real(rp) :: radius = 0                      !< largest change of an unknown, in its unit
    real(rp), allocatable :: scale(:)           !< (unknowns) D
    integer :: rejections = 0, jumps = 0        !< number of them in a row
    real(rp), allocatable :: residuals(:), jacobian(:, :)
    logical :: is_valid = .false.               !< there are residuals
    real(rp) :: predicted = 0, actual = 0       !< reduction of the sum of squares
  contains
    procedure :: ratio => trial_ratio
  end type trial_t

contains

  !> Minimises the sum of squares. The start is moved into the box of the bounds and evaluated from the state `from`; every further
  !> point is evaluated from the state of the best point so far. If the start is not valid or the steps do not end, the report is
  !> not converged. p is the best point found, and the state is that of p, or `from` if the start is not valid.
  subroutine fit(problem, unknowns, start, from, options, report)
    class(least_squares_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    real(rp), intent(in) :: start(:)
    class(solver_state_t), intent(in) :: from !< must not be the state of `report`
    type(fit_options_t), intent(in) :: options
    type(fit_report_t), intent(out) :: report
    integer, parameter :: MOST_JUMPS = 6 ! in a row; the step is then 1/64 of the first step that met a jump
    type(trial_t) :: trial
    integer :: iteration
    logical :: is_end
    call begin(problem, unknowns, start, from, options, report)
    if (allocated(report%reason)) return
    trial = trial_t(damping=options%damping, radius=options%largest_step)
    allocate (trial%scale(size(start)), trial%residuals(size(report%residuals)), &
              trial%jacobian(size(report%residuals), size(start)), source=0.0_rp)
    report%reason = 'the largest number of steps was reached before the fit converged'
    do iteration = 1, options%most_iterations
      call propose_step(unknowns, report, trial)
      call check_next_step(options, trial, report, is_end)
      if (is_end) exit
      call try_point(problem, unknowns, options, report, trial)
      if (trial%jumps >= MOST_JUMPS) then
        report%reason = 'every further step, however short, jumps to another branch of solutions'
        exit
      end if
      if (trial%ratio(report%cost()) > 1.0e-4_rp) then
        call accept_step(unknowns, options, report, trial)
        if (allocated(options%known)) then
          if (leads_to_known(options%known, options%known_sd, unknowns, report)) exit
        end if
      else
        call reject_step(options, report, trial, is_end)
        if (is_end) exit
      end if
    end do
    report%has_jumped = trial%jumps > 0 .and. .not. report%is_converged
    if (report%has_jumped) report%jumped = trial%state%jumped
    report%is_at_bound = .not. unknowns%is_fixed .and. (report%p <= unknowns%lower .or. report%p >= unknowns%upper)
  end subroutine fit

  !> Evaluates at the start; gives a report with a reason if the start is not valid.
  subroutine begin(problem, unknowns, start, from, options, report)
    class(least_squares_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    real(rp), intent(in) :: start(:)
    class(solver_state_t), intent(in) :: from
    type(fit_options_t), intent(in) :: options
    type(fit_report_t), intent(inout) :: report
    class(solver_state_t), allocatable :: to
    logical :: is_valid
    integer :: n, m
    n = size(start)
    m = problem%n_residuals
    call require(size(unknowns%lower) == n .and. all(unknowns%lower <= unknowns%upper), &
                 'least_squares_fit: every unknown needs bounds, the lower one not above the upper one')
    allocate (report%residuals(m), report%jacobian(m, n), source=0.0_rp)
    allocate (report%is_at_bound(n), source=.false.)
    allocate (report%path(3, 0:-1))
    report%p = max(unknowns%lower, min(unknowns%upper, start))
    call problem%evaluate(report%p, from, report%residuals, report%jacobian, is_valid, to)
    report%n_evaluations = 1
    if (options%is_smooth) report%has_jumped = to%has_jumped()
    if (report%has_jumped) report%jumped = to%jumped
    if (.not. is_valid .or. report%has_jumped) then
      report%reason = 'the model cannot be computed at the starting values'
      allocate (report%state, source=from)
      return
    end if
    call move_alloc(to, report%state)
    call sum_squares(unknowns, report%p, report%residuals, report%chi2, report%prior_chi2)
    call remember(report)
  end subroutine begin

  !> Finds the next point to be tried, and the reduction that the linearised residuals promise there.
  subroutine propose_step(unknowns, report, trial)
    type(unknowns_t), intent(in) :: unknowns
    type(fit_report_t), intent(inout) :: report
    type(trial_t), intent(inout) :: trial
    real(rp), allocatable :: triangle(:, :)
    integer, allocatable :: free(:)
    real(rp) :: d(size(report%p))
    call select_free(unknowns, report, free, triangle)
    trial%scale(free) = max(trial%scale(free), column_norms(triangle))
    call find_step(triangle, free, trial%scale, max(unknowns%lower - report%p, -trial%radius*unknowns%unit), &
                   min(unknowns%upper - report%p, trial%radius*unknowns%unit), trial%damping, d)
    trial%p = max(unknowns%lower, min(unknowns%upper, report%p + d))
    d = trial%p - report%p
    trial%predicted = predicted_reduction(triangle, d(free))
    report%last_step = maxval(abs(d)/unknowns%unit)
  end subroutine propose_step

  !> Tells whether the fit ends before the point is tried, because the step or its promised reduction is small.
  pure subroutine check_next_step(options, trial, report, is_end)
    type(fit_options_t), intent(in) :: options
    type(trial_t), intent(in) :: trial
    type(fit_report_t), intent(inout) :: report
    logical, intent(out) :: is_end
    is_end = .true.
    if (report%last_step <= options%step_tolerance .and. trial%damping <= options%damping) then
      report%reason = 'the step is small'
      report%is_converged = .true.
    else if (.not. trial%predicted > options%reduction_tolerance*report%cost()) then
      ! A step that is small only because of the damping does not count.
      report%is_converged = trial%damping <= 1
      report%reason = 'no step reduces the sum of squares'
      if (.not. report%is_converged) report%reason = 'even the smallest steps fail'
    else
      is_end = .false.
    end if
  end subroutine check_next_step

  !> Evaluates at the point that is tried, from the state of the best one, and counts the jumps on the way to it.
  subroutine try_point(problem, unknowns, options, report, trial)
    class(least_squares_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    type(fit_options_t), intent(in) :: options
    type(fit_report_t), intent(inout) :: report
    type(trial_t), intent(inout) :: trial
    real(rp) :: chi2, prior_chi2
    call problem%evaluate(trial%p, report%state, trial%residuals, trial%jacobian, trial%is_valid, trial%state)
    report%n_evaluations = report%n_evaluations + 1
    trial%actual = 0
    if (trial%is_valid) then
      call sum_squares(unknowns, trial%p, trial%residuals, chi2, prior_chi2)
      trial%actual = report%chi2 + report%prior_chi2 - chi2 - prior_chi2
    end if
    if (options%is_smooth) then
      trial%jumps = merge(trial%jumps + 1, 0, trial%state%has_jumped())
      trial%is_valid = trial%is_valid .and. trial%jumps == 0
    end if
  end subroutine try_point

  !> Returns the ratio of the actual to the predicted reduction of the sum of squares `cost`, -1 without residuals. Reductions below
  !> the rounding of the sum count as achieved.
  pure real(rp) function trial_ratio(self, cost) result(ratio)
    class(trial_t), intent(in) :: self
    real(rp), intent(in) :: cost
    real(rp), parameter :: UNRESOLVED = 1.0e-13_rp ! of the sum of squares: its rounding
    ratio = -1
    if (.not. self%is_valid) return
    ratio = self%actual/self%predicted
    if (max(self%predicted, -self%actual) <= UNRESOLVED*cost) ratio = 1
  end function trial_ratio

  !> Accepts the tried point as that of the report, and lengthens the next step.
  subroutine accept_step(unknowns, options, report, trial)
    type(unknowns_t), intent(in) :: unknowns
    type(fit_options_t), intent(in) :: options
    type(fit_report_t), intent(inout) :: report
    type(trial_t), intent(inout) :: trial
    real(rp) :: ratio
    ratio = trial%ratio(report%cost())
    report%p = trial%p
    report%residuals = trial%residuals
    report%jacobian = trial%jacobian
    call move_alloc(trial%state, report%state)
    report%n_accepted = report%n_accepted + 1
    call sum_squares(unknowns, report%p, report%residuals, report%chi2, report%prior_chi2)
    call remember(report)
    trial%damping = trial%damping*max(1.0_rp/3, 1 - (2*ratio - 1)**3)
    trial%growth = 2
    trial%rejections = 0
    if (ratio > 0.25_rp) trial%radius = min(2*trial%radius, options%largest_step)
  end subroutine accept_step

  !> Shortens the next step, or ends the fit.
  pure subroutine reject_step(options, report, trial, is_end)
    type(fit_options_t), intent(in) :: options
    type(fit_report_t), intent(inout) :: report
    type(trial_t), intent(inout) :: trial
    logical, intent(out) :: is_end
    ! Relative error of the sum of squares, because residuals may come from internal iterations.
    real(rp), parameter :: NOISE = 1.0e-8_rp
    is_end = .true.
    if (trial%is_valid .and. max(trial%predicted, -trial%actual) <= NOISE*report%cost()) then
      report%reason = 'the sum of squares is reduced no further'
      report%is_converged = .true.
      return
    end if
    trial%rejections = trial%rejections + 1
    if (trial%rejections >= options%most_rejections) then
      report%reason = 'the sum of squares jumps'
      report%is_converged = .true.
      return
    end if
    trial%radius = max(0.5_rp*min(trial%radius, report%last_step), options%step_tolerance)
    trial%damping = max(trial%damping, 1.0e-8_rp)*trial%growth
    trial%growth = 2*trial%growth
    is_end = report%last_step <= options%step_tolerance
    if (is_end) report%reason = 'even the smallest steps fail'
  end subroutine reject_step

  !> Adds the present point to the path.
  pure subroutine remember(report)
    type(fit_report_t), intent(inout) :: report
    real(rp), allocatable :: longer(:, :)
    allocate (longer(3, 0:report%n_accepted))
    longer(:, :report%n_accepted - 1) = report%path
    longer(:, report%n_accepted) = [real(report%n_evaluations, rp), report%chi2, report%prior_chi2]
    call move_alloc(longer, report%path)
  end subroutine remember

  !> Sums the squares of the residuals and of the deviations from the prior, in sd.
  pure subroutine sum_squares(unknowns, p, residuals, chi2, prior_chi2)
    type(unknowns_t), intent(in) :: unknowns
    real(rp), intent(in) :: p(:), residuals(:)
    real(rp), intent(out) :: chi2, prior_chi2
    chi2 = sum(residuals**2)
    prior_chi2 = sum(((p - unknowns%prior)/merge(unknowns%prior_sd, 1.0_rp, unknowns%prior_sd > 0))**2, &
                     mask=unknowns%prior_sd > 0)
  end subroutine sum_squares

  !> Finds the unknowns that may move, neither fixed nor at a bound to which the descent would push them, and the triangle of the
  !> QR factorisation of their columns and the residuals (the last column), priors included.
  subroutine select_free(unknowns, report, free, triangle)
    type(unknowns_t), intent(in) :: unknowns
    type(fit_report_t), intent(in) :: report
    integer, allocatable, intent(out) :: free(:)
    real(rp), allocatable, intent(out) :: triangle(:, :)
    real(rp), allocatable :: rows(:, :)
    real(rp) :: slope(size(report%p)), offset(size(report%p)), weight(size(report%p))
    logical :: may_move(size(report%p))
    integer :: i, k, m
    m = size(report%residuals)
    weight = 0
    where (unknowns%prior_sd > 0) weight = 1/unknowns%prior_sd
    offset = (report%p - unknowns%prior)*weight
    slope = matmul(report%residuals, report%jacobian) + offset*weight
    may_move = .not. unknowns%is_fixed .and. .not. (report%p <= unknowns%lower .and. slope > 0) &
               .and. .not. (report%p >= unknowns%upper .and. slope < 0)
    free = pack([(i, i=1, size(report%p))], may_move)
    allocate (rows(m + size(free), size(free) + 1), source=0.0_rp)
    do k = 1, size(free)
      rows(:m, k) = report%jacobian(:, free(k))
      rows(m + k, k) = weight(free(k))
      rows(m + k, size(free) + 1) = offset(free(k))
    end do
    rows(:m, size(free) + 1) = report%residuals
    triangle = triangle_of(rows)
  end subroutine select_free

  !> Returns the norms of the columns of a matrix.
  pure function column_norms(triangle) result(norms)
    real(rp), intent(in) :: triangle(:, :)
    real(rp) :: norms(size(triangle, 2) - 1)
    integer :: k
    norms = [(norm2(triangle(:, k)), k=1, size(norms))]
  end function column_norms

  !> Finds d that minimises |R d + q|^2 + damping |scale d|^2 with [R q] the triangle, between `least` and `most`; 0 for unknowns
  !> that are not free. The unknown that would leave this box farthest is put on its side and the others are found again, until
  !> none leaves it: one badly determined unknown must not hold back the others.
  subroutine find_step(triangle, free, scale, least, most, damping, d)
    real(rp), intent(in) :: triangle(:, :), scale(:), least(:), most(:)
    integer, intent(in) :: free(:)
    real(rp), intent(inout) :: damping
    real(rp), intent(out) :: d(:)
    real(rp), parameter :: HUGE_EXCESS = 1.0e30_rp ! of a step at its bound, instead of an overflow
    real(rp) :: excess(size(free)), step(size(free)), room
    logical :: is_put(size(free))
    integer :: k, pass
    is_put = .false.
    step = 0
    do pass = 1, size(free) + 1
      call find_free_step(triangle, scale(free), is_put, damping, step)
      do k = 1, size(free)
        room = merge(most(free(k)), -least(free(k)), step(k) > 0)
        excess(k) = merge(0.0_rp, abs(step(k))/max(room, abs(step(k))/HUGE_EXCESS, tiny(room)), is_put(k))
      end do
      if (all(excess <= 1)) exit
      k = maxloc(excess, 1)
      is_put(k) = .true.
      step(k) = merge(most(free(k)), least(free(k)), step(k) > 0)
    end do
    if (.not. predicted_reduction(triangle, step) > 0) then
      is_put = .false.
      call find_free_step(triangle, scale(free), is_put, damping, step)
      do k = 1, size(free)
        room = merge(most(free(k)), -least(free(k)), step(k) > 0)
        excess(k) = abs(step(k))/max(room, abs(step(k))/HUGE_EXCESS, tiny(room))
      end do
      step = step/max(1.0_rp, maxval(excess))
    end if
    d = 0
    d(free) = step
  end subroutine find_step

  !> Solves for the unknowns that `step` does not prescribe. `damping` grows if the system is singular.
  subroutine find_free_step(triangle, scale, is_put, damping, step)
    real(rp), intent(in) :: triangle(:, :), scale(:)
    logical, intent(in) :: is_put(:)
    real(rp), intent(inout) :: damping, step(:)
    real(rp), parameter :: SMALLEST = 1.0e-15_rp ! damping that makes a singular system regular
    integer :: columns(count(.not. is_put))
    real(rp) :: rows(size(step) + size(columns), size(columns)), right(size(step) + size(columns)), found(size(columns))
    logical :: ok
    integer :: k, n
    n = size(step)
    columns = pack([(k, k=1, n)],.not. is_put)
    right = 0
    right(:n) = -triangle(:n, n + 1)
    do k = 1, n
      if (is_put(k)) right(:n) = right(:n) - triangle(:n, k)*step(k)
    end do
    do
      rows = 0
      rows(:n, :) = triangle(:n, columns)
      do k = 1, size(columns)
        rows(n + k, k) = sqrt(damping)*merge(scale(columns(k)), 1.0_rp, scale(columns(k)) > 0)
      end do
      call solve_least_squares(rows, right, found, ok)
      if (ok) exit
      damping = max(SMALLEST, 10*damping)
    end do
    step(columns) = found
  end subroutine find_free_step

  !> Returns the decrease of the linearised sum of squares by the step.
  pure real(rp) function predicted_reduction(triangle, step) result(reduction)
    real(rp), intent(in) :: triangle(:, :), step(:)
    real(rp) :: change(size(step))
    integer :: n
    n = size(step)
    change = matmul(triangle(:n, :n), step)
    reduction = -dot_product(change, change + 2*triangle(:n, n + 1))
  end function predicted_reduction
end module least_squares_fit

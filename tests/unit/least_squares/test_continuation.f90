! SPDX-License-Identifier: GPL-3.0-or-later
!> Continuation leads out of a wrong minimum, and ends where the declared problem does: on a problem with two minima,
!> p^2 = 1 with p = 0.8 thought before, which becomes convex when the data together weigh as much as the prior.
program test_continuation
  use base_kinds, only: rp
  use curve_problems, only: two_wells_t
  use least_squares_continuation, only: fit_by_continuation
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use least_squares_problem, only: unknowns_t
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: PRIOR = 0.8_rp, PRIOR_SD = 0.5_rp, ERROR = 1.0e-3_rp
  integer, parameter :: M = 4 !< readings
  real(rp), parameter :: ROUND_OFF = 1.0e-12_rp
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call leave_wrong_minimum()
  call keep_declared_problem()
  call leave_known_minimum()
  call keep_report_of_failure()
  call t%finish()

contains

  function some_unknowns() result(unknowns)
    type(unknowns_t) :: unknowns
    call unknowns%init(1)
    unknowns%prior = PRIOR
    unknowns%prior_sd = PRIOR_SD
  end function some_unknowns

  !> The first sum of squares is ((p^2 - 1)/(p0^2 - 1))^2 + ((p - 0.8)/sd)^2. Its second derivative, (12 p^2 - 4)/(p0^2 - 1)^2 +
  !> 2/sd^2, is positive everywhere if (p0^2 - 1)^2 > 2 sd^2 = 0.5: the starts have one minimum, and it lies at positive p.
  subroutine leave_wrong_minimum()
    real(rp), parameter :: STARTS(4) = [-3.0_rp, -2.0_rp, -1.4_rp, 2.5_rp]
    type(two_wells_t) :: problem
    type(fit_report_t) :: report, plain
    type(fit_options_t) :: options
    real(rp), allocatable :: path(:, :)
    integer :: i
    problem%n_residuals = M
    problem%error = ERROR
    call fit(problem, some_unknowns(), [STARTS(2)], solver_state_t(), options, plain)
    call t%check('least squares alone end in the minimum next to the start', &
                 plain%is_converged .and. plain%p(1) < -0.99_rp)
    do i = 1, size(STARTS)
      problem%n_evaluations = 0
      call fit_by_continuation(problem, some_unknowns(), [STARTS(i)], solver_state_t(), options, .true., report, path)
      ! The sum of squares, 0.16, is left to 1e-12 of it: p to 2e-10.
      call t%check_close('continuation ends where both data and prior say', report%p(1), best(), atol=1.0e-9_rp)
      call t%check('  and says so: '//report%reason, report%is_converged)
      call t%check('  all evaluations are counted', report%n_evaluations == problem%n_evaluations)
      call check_path(path, report, sqrt(real(M, rp))*abs(STARTS(i)**2 - 1)/ERROR)
    end do
  end subroutine leave_wrong_minimum

  !> Newton's method for the slope of M ((p^2 - 1)/e)^2 + ((p - prior)/sd)^2, from p = 1.
  pure real(rp) function best() result(p)
    integer :: i
    p = 1
    do i = 1, 20
      p = p - (4*M*p*(p**2 - 1)/ERROR**2 + 2*(p - PRIOR)/PRIOR_SD**2)/(M*(12*p**2 - 4)/ERROR**2 + 2/PRIOR_SD**2)
    end do
  end function best

  !> Stages begin with errors as large as the start's misfit, which fall at least tenfold to the declared ones; the sum of
  !> squares of every stage falls, and the end is that of the report.
  subroutine check_path(path, report, misfit)
    real(rp), intent(in) :: path(:, :), misfit
    type(fit_report_t), intent(in) :: report
    real(rp), allocatable :: squares(:)
    integer :: k, last
    logical :: goes_down, has_steps
    last = size(path, 2)
    call t%check_close('  errors begin at the misfit of the start', path(4, 1), misfit, rtol=ROUND_OFF)
    squares = path(2, :)/path(4, :)**2 + path(3, :)
    goes_down = .true.
    has_steps = .true.
    do k = 2, last
      if (path(4, k) < path(4, k - 1)) then
        has_steps = has_steps .and. path(4, k) <= max(1.0_rp, path(4, k - 1)*(0.1_rp + ROUND_OFF))
      else
        goes_down = goes_down .and. squares(k) <= squares(k - 1) .and. path(4, k) <= path(4, k - 1)
      end if
      has_steps = has_steps .and. path(1, k) > path(1, k - 1)
    end do
    call t%check('  sums of squares fall within every stage', goes_down)
    call t%check('  and errors tenfold from one to the next', has_steps)
    call t%check_close('  the last are the declared ones', path(4, last), 1.0_rp)
    call t%check_close('  the path ends with the data''s sum', path(2, last), report%chi2, rtol=ROUND_OFF)
    call t%check_close('  and with the priors''', path(3, last), ((report%p(1) - PRIOR)/PRIOR_SD)**2, rtol=ROUND_OFF)
  end subroutine check_path

  !> A start that fits within the declared errors has one stage, and that is least squares.
  subroutine keep_declared_problem()
    type(two_wells_t) :: problem
    type(fit_report_t) :: report, plain
    type(fit_options_t) :: options
    real(rp), allocatable :: path(:, :)
    problem%n_residuals = M
    problem%error = ERROR
    call fit(problem, some_unknowns(), [1.0_rp + 0.4_rp*ERROR], solver_state_t(), options, plain)
    call fit_by_continuation(problem, some_unknowns(), [1.0_rp + 0.4_rp*ERROR], solver_state_t(), options, .true., report, path)
    call t%check('a start that fits has one stage',.not. any(abs(path(4, :) - 1) > 0))
    call t%check('  which is least squares to the bit',.not. abs(report%p(1) - plain%p(1)) > 0)
    call fit(problem, some_unknowns(), [-2.0_rp], solver_state_t(), options, plain)
    call fit_by_continuation(problem, some_unknowns(), [-2.0_rp], solver_state_t(), options, .false., report, path)
    call t%check('so has any if stages are not wanted',.not. any(abs(path(4, :) - 1) > 0) .and. &
                 .not. abs(report%p(1) - plain%p(1)) > 0 .and. report%n_evaluations == plain%n_evaluations)
  end subroutine keep_declared_problem

  !> From a known minimum: a start in the other well ends there, where the priors alone would lead back; one in the same well says
  !> that it knows the minimum, after fewer evaluations.
  subroutine leave_known_minimum()
    type(two_wells_t) :: problem
    type(fit_report_t) :: known, report
    type(fit_options_t) :: options
    real(rp), allocatable :: path(:, :)
    problem%n_residuals = M
    problem%error = ERROR
    call fit_by_continuation(problem, some_unknowns(), [-2.0_rp], solver_state_t(), options, .true., known, path)
    call t%check('stages about the prior lead to its well', known%p(1) > 0)
    options%known = known%p
    options%known_sd = [ERROR]
    call fit_by_continuation(problem, some_unknowns(), [-2.0_rp], solver_state_t(), options, .true., report, path)
    call t%check('stages about a start in the other well stay there', report%p(1) < 0 .and. report%is_converged)
    call t%check_close('  and end in its minimum', report%p(1), -known%p(1), atol=ERROR)
    call fit_by_continuation(problem, some_unknowns(), [1.5_rp], solver_state_t(), options, .true., report, path)
    call t%check('a start in the same well meets the known minimum', report%leads_to_known)
    call t%check('  and is not converged',.not. report%is_converged)
  end subroutine leave_known_minimum

  subroutine keep_report_of_failure()
    type(two_wells_t) :: problem
    type(fit_report_t) :: report
    real(rp), allocatable :: path(:, :)
    problem%n_residuals = M
    call fit_by_continuation(problem, some_unknowns(), [11.0_rp], solver_state_t(), fit_options_t(), .true., report, path)
    call t%check('an invalid start is a failure: '//report%reason,.not. report%is_converged .and. size(path, 2) == 0 &
                 .and. report%n_accepted == 0 .and. report%n_evaluations == 1)
  end subroutine keep_report_of_failure
end program test_continuation

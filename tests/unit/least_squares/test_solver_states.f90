! SPDX-License-Identifier: GPL-3.0-or-later
!> Fits carry the state of a solver with the point to which it belongs, and intervals leave out data that jump.
program test_solver_states
  use base_kinds, only: rp
  use curve_problems, only: snapping_state_t, snapping_t
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use least_squares_problem, only: unknowns_t
  use least_squares_profile, only: interval_t, linear_guess_t, profile_interval, THRESHOLD_90
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(snapping_state_t) :: rest

  call t%start(parallel=.false.)
  allocate (rest%is_left_out(2), source=.false.)
  call follow_states()
  call leave_out_groups()
  call leave_out_jumps()
  call t%finish()

contains

  type(snapping_t) function some_problem() result(problem)
    problem%n_residuals = 2
    problem%error = [0.1_rp, 0.5_rp]
  end function some_problem

  function some_unknowns() result(unknowns)
    type(unknowns_t) :: unknowns
    call unknowns%init(1)
    unknowns%lower = -1000
    unknowns%upper = 1000
  end function some_unknowns

  !> Where the state was.
  real(rp) function place(state)
    class(solver_state_t), intent(in) :: state
    place = huge(place)
    select type (state)
    type is (snapping_state_t)
      place = state%p
    end select
  end function place

  !> Points, also those after a failed one, are evaluated from the best one so far; the state is that of the result.
  subroutine follow_states()
    type(snapping_t) :: problem
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    problem = some_problem()
    problem%snaps_at = 20
    options%largest_step = 200
    call fit(problem, some_unknowns(), [99.0_rp], rest, options, report)
    call t%check('a fit finds the minimum over a jump, and tries other steps', report%is_converged .and. &
                 report%n_evaluations > report%n_accepted + 1 .and. abs(report%p(1)) < 1.0e-3_rp)
    call t%check('every point is evaluated from the state of the best one', problem%n_wrong == 0)
    call t%check('the state is that of the result',.not. abs(place(report%state) - report%p(1)) > 0)
    rest%p = 7
    call fit(problem, some_unknowns(), [-101.0_rp], rest, options, report)
    call t%check('a start that is not valid leaves the state', report%n_accepted == 0 .and. .not. abs(place(report%state) - 7) > 0)
    rest%p = 0
  end subroutine follow_states

  subroutine leave_out_groups()
    type(snapping_state_t) :: state
    logical :: is_done
    state = rest
    call state%leave_out([.false., .false.], is_done)
    call t%check('nothing has jumped',.not. (is_done .or. any(state%is_left_out)))
    call state%leave_out([.false., .true.], is_done)
    call t%check('a group that has jumped is left out', is_done .and. all(state%is_left_out .eqv. [.false., .true.]))
    call state%leave_out([.true., .false.], is_done)
    call t%check('but not the last one',.not. (is_done .or. state%is_left_out(1)))
    call t%check('a state without groups has not jumped',.not. rest%has_jumped())
  end subroutine leave_out_groups

  !> The interval from both readings would reach beyond the jump of the first. It is that of the second alone.
  subroutine leave_out_jumps()
    type(snapping_t) :: problem
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    type(interval_t) :: interval
    problem = some_problem()
    problem%snaps_at = 0.05_rp
    call fit(problem, some_unknowns(), [0.01_rp], rest, options, report)
    call profile_interval(problem, some_unknowns(), report, 1, linear_guess_t(0.1_rp), THRESHOLD_90, options, interval)
    call t%check('the reading that jumps is left out', all(interval%is_left_out .eqv. [.true., .false.]))
    call t%check('the fit before it has left none',.not. any(report%state%is_left_out))
    call t%check('the interval has two ends, none of them a jump', interval%has_lower .and. interval%has_upper .and. &
                 .not. any(interval%is_jump))
    call t%check_close('they are those of the other reading', interval%upper - interval%lower, &
                       2*sqrt(THRESHOLD_90)*problem%error(2), rtol=0.02_rp)
  end subroutine leave_out_jumps
end program test_solver_states

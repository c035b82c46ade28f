! SPDX-License-Identifier: GPL-3.0-or-later
!> When FFTW's plans are measured: in long runs, and in runs that go on with measured plans.
program test_plans
  use base_kinds, only: rp
  use simulation_plans, only: choose_planner
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: SMALL = 32.0_rp**3, LARGE = 256.0_rp**3
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call expect('auto', 600.0_rp, SMALL, .false., .false., 'estimate', 'a short run on a small grid is estimated')
  call expect('auto', 10.0_rp, LARGE, .false., .true., 'estimate', 'a few steps on a large grid are estimated')
  call expect('auto', 4000.0_rp, LARGE, .false., .false., 'measure', 'a long run on a large grid is measured')
  call expect('auto', 1.0e9_rp, SMALL, .false., .false., 'measure', 'a very long run on a small grid is measured')
  call expect('auto', 4000.0_rp, LARGE, .true., .false., 'estimate', 'a run that goes on without wisdom is estimated')
  call expect('auto', 10.0_rp, SMALL, .true., .true., 'measure', 'a run that goes on with wisdom is measured')
  call expect('estimate', 1.0e9_rp, LARGE, .true., .true., 'estimate', 'who wants estimates gets them')
  call expect('measure', 1.0_rp, SMALL, .true., .false., 'measure', 'who wants measured plans gets them')
  call kit%finish()

contains

  subroutine expect(planner, steps, points, restarts, has_wisdom, want, sentence)
    character(*), intent(in) :: planner, want, sentence
    real(rp), intent(in) :: steps, points
    logical, intent(in) :: restarts, has_wisdom
    character(:), allocatable :: chosen, reason
    chosen = planner
    call choose_planner(chosen, steps, points, restarts, has_wisdom, reason)
    call kit%check(sentence, chosen == want)
    call kit%check(sentence//', and a reason is given', len(reason) > 0)
  end subroutine expect
end program test_plans

! SPDX-License-Identifier: GPL-3.0-or-later
!> When FFTW's plans are measured: in long runs, and in runs that go on with measured plans.
program test_plans
  use base_kinds, only: rp
  use simulation_plans, only: choose_planner
  use spectral_fftw, only: PLAN_AUTO, PLAN_ESTIMATE, PLAN_MEASURE
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: SMALL = 32.0_rp**3, LARGE = 256.0_rp**3
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call expect(PLAN_AUTO, 600.0_rp, SMALL, .false., .false., PLAN_ESTIMATE, 'a short run on a small grid is estimated')
  call expect(PLAN_AUTO, 10.0_rp, LARGE, .false., .true., PLAN_ESTIMATE, 'a few steps on a large grid are estimated')
  call expect(PLAN_AUTO, 4000.0_rp, LARGE, .false., .false., PLAN_MEASURE, 'a long run on a large grid is measured')
  call expect(PLAN_AUTO, 1.0e9_rp, SMALL, .false., .false., PLAN_MEASURE, 'a very long run on a small grid is measured')
  call expect(PLAN_AUTO, 4000.0_rp, LARGE, .true., .false., PLAN_ESTIMATE, 'a run that goes on without wisdom is estimated')
  call expect(PLAN_AUTO, 10.0_rp, SMALL, .true., .true., PLAN_MEASURE, 'a run that goes on with wisdom is measured')
  call expect(PLAN_ESTIMATE, 1.0e9_rp, LARGE, .true., .true., PLAN_ESTIMATE, 'who wants estimates gets them')
  call expect(PLAN_MEASURE, 1.0_rp, SMALL, .true., .false., PLAN_MEASURE, 'who wants measured plans gets them')
  call kit%finish()

contains

  subroutine expect(planner, steps, points, restarts, has_wisdom, want, sentence)
    integer, intent(in) :: planner, want
    character(*), intent(in) :: sentence
    real(rp), intent(in) :: steps, points
    logical, intent(in) :: restarts, has_wisdom
    integer :: chosen
    character(:), allocatable :: reason
    chosen = planner
    call choose_planner(chosen, steps, points, restarts, has_wisdom, reason)
    call kit%check(sentence, chosen == want)
    call kit%check(sentence//', and a reason is given', len(reason) > 0)
  end subroutine expect
end program test_plans

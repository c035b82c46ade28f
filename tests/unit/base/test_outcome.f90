! SPDX-License-Identifier: GPL-3.0-or-later
!> How a program ends: the first failure decides, an end without failure gives way to it, and each outcome has its exit code.
program test_outcome
  use base_outcome, only: exit_code_of, outcome_t, OUTCOME_COLLISION, OUTCOME_DIFFERENT, OUTCOME_DIVERGED, OUTCOME_DONE, &
                          OUTCOME_MISTAKE, OUTCOME_NO_MEMORY, OUTCOME_NOT_CONVERGED, OUTCOME_STOPPED, OUTCOME_UNWRITABLE, &
                          OUTCOME_VERDICT
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: KINDS(9) = [OUTCOME_DONE, OUTCOME_DIFFERENT, OUTCOME_MISTAKE, OUTCOME_DIVERGED, OUTCOME_COLLISION, &
                                    OUTCOME_NOT_CONVERGED, OUTCOME_STOPPED, OUTCOME_UNWRITABLE, OUTCOME_NO_MEMORY]
  type(testkit_t) :: t
  type(outcome_t) :: good, failed, stopped
  integer :: i
  call t%start(parallel=.false.)
  call t%check('each outcome has the exit code that the user knows', &
               all([(exit_code_of(KINDS(i)), i=1, 9)] == [0, 1, 2, 3, 3, 3, 4, 5, 6]))
  call t%check('a larger outcome has no smaller exit code', all(KINDS(2:) > KINDS(:8)))
  call t%check('a program is good until something happens', good%is_good() .and. good%exit_code() == 0)
  call good%classify(OUTCOME_DIVERGED)
  call t%check('without a failure there is nothing to classify', good%is_good())
  call failed%fail(OUTCOME_COLLISION, 'the first')
  call failed%fail(OUTCOME_UNWRITABLE, 'the second')
  call failed%end_as(OUTCOME_STOPPED)
  call t%check('the first failure decides', failed%kind == OUTCOME_COLLISION .and. failed%failure%reason == 'the first' .and. &
               failed%exit_code() == 3 .and. .not. failed%is_good())
  call stopped%end_as(OUTCOME_STOPPED)
  call t%check('an end without a failure', stopped%kind == OUTCOME_STOPPED .and. stopped%exit_code() == 4)
  call stopped%failure%raise('no backup')
  call t%check('a failure that has no kind yet is not good', stopped%kind == OUTCOME_STOPPED .and. .not. stopped%is_good())
  call stopped%classify(OUTCOME_UNWRITABLE)
  call t%check('a failure overrules an end without one', stopped%kind == OUTCOME_UNWRITABLE .and. stopped%exit_code() == 5)
  good%verdict = 11
  call t%check('a verdict has no say', good%exit_code() == 0)
  call good%end_as(OUTCOME_VERDICT)
  call t%check('unless it was asked for', good%exit_code() == 11)
  call t%finish()
end program test_outcome

! SPDX-License-Identifier: GPL-3.0-or-later
!> Says how a program ended, and maps this to its exit code. No other module decides exit codes.
!>
!> A program has one `outcome_t`. Failures (`failure_t`) say what went wrong; the outcome says what that means for the program.
!>
!> | outcome | exit code | meaning |
!> |---|---|---|
!> | DONE | 0 | the program reached its end |
!> | DIFFERENT | 1 | two files that were compared differ; a defect of the program has this code, too (`require`) |
!> | MISTAKE | 2 | the user made a mistake; nothing was written |
!> | DIVERGED | 3 | the flow has diverged: its velocity is not a number or too large |
!> | COLLISION | 3 | wings touch each other or leave the box |
!> | NOT_CONVERGED | 3 | an iteration found no solution |
!> | STOPPED | 4 | the program stopped early on request, with a checkpoint: submit again |
!> | UNWRITABLE | 5 | files cannot be written: the disk is full, or the folder is read-only or missing |
!> | NO_MEMORY | 6 | the machine has not enough memory |
!> | VERDICT | 10 to 20 | a diagnosis ended with this verdict, and --exit-code asked for it |
module base_outcome
  use base_errors, only: failure_t
  implicit none
  private
  public :: outcome_t, exit_code_of

  !> In the order of their exit codes, so that the largest of all ranks is the worst.
  integer, parameter, public :: OUTCOME_DONE = 0, OUTCOME_DIFFERENT = 1, OUTCOME_MISTAKE = 2, OUTCOME_DIVERGED = 3, &
                                OUTCOME_COLLISION = 4, OUTCOME_NOT_CONVERGED = 5, OUTCOME_STOPPED = 6, &
                                OUTCOME_UNWRITABLE = 7, OUTCOME_NO_MEMORY = 8, OUTCOME_VERDICT = 9
  integer, parameter :: CODES(OUTCOME_DONE:OUTCOME_NO_MEMORY) = [0, 1, 2, 3, 3, 3, 4, 5, 6]

  type :: outcome_t
    integer :: kind = OUTCOME_DONE
    type(failure_t) :: failure       !< why the program did not reach its end, if a failure is the reason
    integer :: verdict = 0           !< exit code of the verdict, for OUTCOME_VERDICT
    logical, private :: has_cause = .false. !< `failure` has decided the kind
  contains
    procedure :: is_good => outcome_is_good
    procedure :: end_as => outcome_end_as
    procedure :: fail => outcome_fail
    procedure :: classify => outcome_classify
    procedure :: exit_code => outcome_exit_code
  end type outcome_t

contains

  !> Tells whether the program has reached its end, or may continue.
  pure logical function outcome_is_good(self) result(is_good)
    class(outcome_t), intent(in) :: self
    is_good = self%kind == OUTCOME_DONE .and. .not. self%failure%failed
  end function outcome_is_good

  !> Makes the program end as `kind` says, unless a failure has decided how it ends.
  pure subroutine outcome_end_as(self, kind)
    class(outcome_t), intent(inout) :: self
    integer, intent(in) :: kind
    if (.not. self%has_cause) self%kind = kind
  end subroutine outcome_end_as

  !> Makes the program end by a failure of this kind. The first failure counts.
  subroutine outcome_fail(self, kind, reason)
    class(outcome_t), intent(inout) :: self
    integer, intent(in) :: kind
    character(*), intent(in) :: reason
    call self%failure%raise(reason)
    call self%classify(kind)
  end subroutine outcome_fail

  !> Sets the kind of a failure. If `failure` has been raised since the last call, it gets this kind and decides how the program
  !> ends. Without a failure nothing changes.
  pure subroutine outcome_classify(self, kind)
    class(outcome_t), intent(inout) :: self
    integer, intent(in) :: kind
    if (.not. self%failure%failed .or. self%has_cause) return
    self%kind = kind
    self%has_cause = .true.
  end subroutine outcome_classify

  !> Returns the exit code of the program.
  pure integer function outcome_exit_code(self) result(code)
    class(outcome_t), intent(in) :: self
    code = self%verdict
    if (self%kind /= OUTCOME_VERDICT) code = exit_code_of(self%kind)
  end function outcome_exit_code

  !> Returns the exit code of a program that ends as `kind` says, which is not OUTCOME_VERDICT.
  pure integer function exit_code_of(kind) result(code)
    integer, intent(in) :: kind
    code = CODES(kind)
  end function exit_code_of
end module base_outcome

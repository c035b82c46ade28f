! SPDX-License-Identifier: GPL-3.0-or-later
!> A wing file that a test makes, and what the reader must say about it.
module wing_case
  use base_errors, only: message_list_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use testkit, only: testkit_t
  use wing_writer, only: wing_writer_t
  implicit none
  private
  public :: wing_case_t

  character(*), parameter, public :: PATH = 'case.h5' !< of the file

  type, extends(wing_writer_t) :: wing_case_t
    type(testkit_t), pointer :: t => null()
  contains
    procedure :: check => case_check
    procedure :: accept => case_accept
    procedure :: refuse => case_refuse
    procedure :: refuse_any => case_refuse_any
    procedure :: refuse_open_any => case_refuse_open_any
  end type wing_case_t

contains

  !> Checks on rank 0 alone.
  subroutine case_check(self, sentence, holds)
    class(wing_case_t), intent(inout) :: self
    character(*), intent(in) :: sentence
    logical, intent(in) :: holds
    logical :: parallel
    parallel = self%t%parallel
    self%t%parallel = .false.
    call self%t%check(sentence, holds)
    self%t%parallel = parallel
  end subroutine case_check

  !> Closes the file that was made and expects it to be accepted.
  subroutine case_accept(self, what, wing)
    class(wing_case_t), intent(inout) :: self
    character(*), intent(in) :: what
    type(wing_t), intent(out) :: wing
    type(message_list_t) :: messages
    integer :: i
    call self%close()
    call read_wing(PATH, wing, messages)
    call self%check('accepted: '//what, messages%count() == 0)
    do i = 1, messages%count()
      write (*, '(a)') '      '//messages%text(i)
    end do
  end subroutine case_accept

  !> Closes the file that was made and expects exactly one message that begins with `fragment` behind the path.
  subroutine case_refuse(self, fragment)
    class(wing_case_t), intent(inout) :: self
    character(*), intent(in) :: fragment
    type(message_list_t) :: messages
    logical :: found
    call read_closed(self, messages)
    found = messages%count() == 1
    if (found) found = index(messages%text(1), PATH//': '//fragment) == 1
    call judge(self, fragment, found, messages)
  end subroutine case_refuse

  !> As `refuse`, but there may be other messages, and `fragment` may stand anywhere.
  subroutine case_refuse_any(self, fragment)
    class(wing_case_t), intent(inout) :: self
    character(*), intent(in) :: fragment
    type(message_list_t) :: messages
    integer :: i
    logical :: found
    call read_closed(self, messages)
    found = .false.
    do i = 1, messages%count()
      found = found .or. index(messages%text(i), fragment) > 0
    end do
    call judge(self, fragment, found, messages)
  end subroutine case_refuse_any

  subroutine read_closed(self, messages)
    class(wing_case_t), intent(inout) :: self
    type(message_list_t), intent(inout) :: messages
    type(wing_t) :: wing
    call self%close()
    call read_wing(PATH, wing, messages)
  end subroutine read_closed

  !> Tells what was said instead if it was not `found`.
  subroutine judge(self, fragment, found, messages)
    class(wing_case_t), intent(inout) :: self
    character(*), intent(in) :: fragment
    logical, intent(in) :: found
    type(message_list_t), intent(in) :: messages
    integer :: i
    call self%check('refused: '//fragment, found)
    if (found) return
    do i = 1, messages%count()
      write (*, '(a)') '      '//messages%text(i)
    end do
  end subroutine judge

  !> The same for the file of the last `refuse`.
  subroutine case_refuse_open_any(self, fragment)
    class(wing_case_t), intent(inout) :: self
    character(*), intent(in) :: fragment
    call self%open(PATH)
    call self%refuse_any(fragment)
  end subroutine case_refuse_open_any
end module wing_case

! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the three kinds of errors. The project reports errors in no other way.
!>
!> User mistakes are collected in a `message_list_t` and reported together. Numerical failures are
!> returned as a `failure_t`, which the caller handles. Programmer errors stop the program through
!> `require`.
module base_errors
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  private
  public :: message_list_t, failure_t, require

  type :: message_t
    character(:), allocatable :: text
  end type message_t

  !> A growing list of messages, in the order in which they were added.
  type :: message_list_t
    private
    type(message_t), allocatable :: items(:)
    integer :: n = 0
  contains
    procedure :: add => message_list_add
    procedure :: count => message_list_count
    procedure :: text => message_list_text
    procedure :: print => message_list_print
  end type message_list_t

  !> Outcome of a computation that may fail for numerical reasons.
  type :: failure_t
    logical :: failed = .false.
    character(:), allocatable :: reason !< what went wrong, set when `failed`
  contains
    procedure :: raise => failure_raise
  end type failure_t

contains

  !> Appends one message.
  subroutine message_list_add(self, text)
    class(message_list_t), intent(inout) :: self
    character(*), intent(in) :: text
    type(message_t), allocatable :: larger(:)
    integer :: i

    if (.not. allocated(self%items)) allocate (self%items(8))
    if (self%n == size(self%items)) then
      allocate (larger(2*self%n))
      do i = 1, self%n
        call move_alloc(self%items(i)%text, larger(i)%text)
      end do
      call move_alloc(larger, self%items)
    end if
    self%n = self%n + 1
    self%items(self%n)%text = text
  end subroutine message_list_add

  !> Returns the number of messages.
  pure integer function message_list_count(self) result(n)
    class(message_list_t), intent(in) :: self
    n = self%n
  end function message_list_count

  !> Returns the text of message `i`, 1 <= i <= count().
  function message_list_text(self, i) result(text)
    class(message_list_t), intent(in) :: self
    integer, intent(in) :: i
    character(:), allocatable :: text
    call require(i >= 1 .and. i <= self%n, 'message_list_t%text: index out of range')
    text = self%items(i)%text
  end function message_list_text

  !> Writes all messages to `unit`, one a line, each behind `prefix`.
  subroutine message_list_print(self, unit, prefix)
    class(message_list_t), intent(in) :: self
    integer, intent(in) :: unit
    character(*), intent(in) :: prefix
    integer :: i
    do i = 1, self%n
      write (unit, '(a,a)') prefix, self%items(i)%text
    end do
  end subroutine message_list_print

  !> Marks the failure. The first reason given is kept.
  subroutine failure_raise(self, reason)
    class(failure_t), intent(inout) :: self
    character(*), intent(in) :: reason
    if (self%failed) return
    self%failed = .true.
    self%reason = reason
  end subroutine failure_raise

  !> Stops the program with `message` unless `condition` holds. For programmer errors only; under
  !> MPI the launcher ends the other ranks when one exits with an error.
  subroutine require(condition, message)
    logical, intent(in) :: condition
    character(*), intent(in) :: message
    if (condition) return
    write (error_unit, '(a)') 'flusi-msm: internal error: '//message
    flush (error_unit)
    error stop 1
  end subroutine require
end module base_errors

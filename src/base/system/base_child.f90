! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs another program to its end.
module base_child
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
  implicit none
  private
  public :: run_child

  interface
    integer(c_int) function c_run_child(program, first, second) bind(C, name='flusi_run_child')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: program(*), first(*), second(*)
    end function c_run_child
  end interface

contains

  !> Runs the file `program` with two arguments, without a terminal, and waits. `code` is its exit code; `signal` is the
  !> number of the signal that ended it, or 0. `started` is false if there is no such program.
  subroutine run_child(program, first, second, started, code, signal)
    character(*), intent(in) :: program, first, second
    logical, intent(out) :: started
    integer, intent(out) :: code, signal
    integer, parameter :: SIGNALLED = 256
    integer :: outcome
    outcome = int(c_run_child(program//c_null_char, first//c_null_char, second//c_null_char))
    started = outcome >= 0
    signal = max(0, outcome - SIGNALLED)
    code = merge(outcome, 0, signal == 0)
  end subroutine run_child
end module base_child

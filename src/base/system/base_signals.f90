! SPDX-License-Identifier: GPL-3.0-or-later
!> Catches the signals that ask the program to stop: SIGTERM (end of a batch job), SIGUSR1 (its announcement), SIGINT (Ctrl-C) and
!> SIGHUP (the terminal is closed).
!>
!> The one module variable of the project: a signal handler takes no argument and can reach nothing
!> else. It is only ever set here and only read through `signal_caught`.
module base_signals
  use, intrinsic :: iso_c_binding, only: c_int, c_funptr, c_funloc, c_intptr_t
  implicit none
  private
  public :: catch_signals, signal_caught

  ! Linux numbers.
  integer(c_int), parameter :: SIGHUP = 1, SIGINT = 2, SIGUSR1 = 10, SIGTERM = 15
  integer(c_intptr_t), parameter :: SIG_DFL = 0, SIG_IGN = 1

  integer(c_int), volatile :: caught = 0 !< number of the last signal, 0 before any

  interface
    type(c_funptr) function c_signal(number, handler) bind(C, name='signal')
      import :: c_int, c_funptr
      integer(c_int), value :: number
      type(c_funptr), value :: handler
    end function c_signal
    integer(c_int) function was_ignored(number) bind(C, name='flusi_was_ignored')
      import :: c_int
      integer(c_int), value :: number
    end function was_ignored
  end interface

contains

  !> Makes the process remember these signals instead of ending. A second SIGINT ends it. SIGINT and SIGHUP remain ignored if they
  !> were ignored when the program began, as under nohup. Call it after MPI has started.
  subroutine catch_signals()
    integer(c_int), parameter :: NUMBERS(4) = [SIGTERM, SIGUSR1, SIGINT, SIGHUP]
    type(c_funptr) :: previous
    integer :: i
    do i = 1, size(NUMBERS)
      previous = c_signal(NUMBERS(i), c_funloc(handle))
      if (NUMBERS(i) /= SIGINT .and. NUMBERS(i) /= SIGHUP) cycle
      if (was_ignored(NUMBERS(i)) == 1) previous = c_signal(NUMBERS(i), transfer(SIG_IGN, previous))
    end do
  end subroutine catch_signals

  !> Returns the number of the last signal caught on this process, 0 if none came. Other ranks may know nothing of it: reduce it
  !> over the ranks before acting on it.
  integer function signal_caught()
    signal_caught = int(caught)
  end function signal_caught

  !> Records a signal. A second interrupt from the keyboard ends the program.
  subroutine handle(number) bind(C)
    integer(c_int), value :: number
    type(c_funptr) :: previous
    caught = number
    if (number == SIGINT) previous = c_signal(number, transfer(SIG_DFL, previous))
  end subroutine handle
end module base_signals

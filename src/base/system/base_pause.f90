! SPDX-License-Identifier: GPL-3.0-or-later
!> Lets a process wait without work for the processor.
module base_pause
  use, intrinsic :: iso_c_binding, only: c_int
  use base_kinds, only: rp
  implicit none
  private
  public :: pause_for

  interface
    function c_usleep(microseconds) result(error) bind(c, name='usleep')
      import :: c_int
      integer(c_int), value :: microseconds
      integer(c_int) :: error
    end function c_usleep
  end interface

contains

  !> Waits for so many seconds, at most one, or less if a signal arrives.
  subroutine pause_for(seconds)
    real(rp), intent(in) :: seconds
    real(rp), parameter :: MOST = 0.999_rp !< usleep takes less than a second
    integer(c_int) :: ignored
    ignored = c_usleep(nint(1.0e6_rp*max(0.0_rp, min(MOST, seconds)), c_int))
  end subroutine pause_for
end module base_pause

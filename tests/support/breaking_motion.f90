! SPDX-License-Identifier: GPL-3.0-or-later
!> A frame at rest whose acceleration overflows after a time, so that every later step fails.
module breaking_motion
  use base_kinds, only: rp
  use solid_motion, only: frame_t, motion_t
  implicit none
  private
  public :: breaking_motion_t

  type, extends(motion_t) :: breaking_motion_t
    real(rp) :: end = huge(1.0_rp) !< [s]
  contains
    procedure :: at => breaking_at
  end type breaking_motion_t

contains

  !> At rest until `end`.
  function breaking_at(self, time) result(frame)
    class(breaking_motion_t), intent(in) :: self
    real(rp), intent(in) :: time
    type(frame_t) :: frame
    if (time > self%end) frame%acceleration = huge(1.0_rp)
  end function breaking_at
end module breaking_motion

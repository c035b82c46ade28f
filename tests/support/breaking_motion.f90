! SPDX-License-Identifier: GPL-3.0-or-later
!> A frame at rest that is accelerated beyond all measure after a time, so that later steps fail.
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
    real(rp), parameter :: JERK(3) = [0.0_rp, 0.0_rp, 1.0e9_rp] ! [m/s^2]
    if (time > self%end) frame%acceleration = JERK
  end function breaking_at
end module breaking_motion

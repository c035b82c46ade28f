! SPDX-License-Identifier: GPL-3.0-or-later
!> A wing frame that turns faster and faster about z.
module turning_motion
  use base_kinds, only: rp
  use solid_motion, only: frame_t, motion_t
  implicit none
  private
  public :: turning_motion_t

  !> omega(t) = omega0 + alpha t about z.
  type, extends(motion_t) :: turning_motion_t
    real(rp) :: omega0 = 0, alpha = 0
  contains
    procedure :: at => turning_at
  end type turning_motion_t

contains

  !> The frame at `time`.
  function turning_at(self, time) result(frame)
    class(turning_motion_t), intent(in) :: self
    real(rp), intent(in) :: time
    type(frame_t) :: frame
    frame%omega(3) = self%omega0 + self%alpha*time
    frame%alpha(3) = self%alpha
  end function turning_at
end module turning_motion

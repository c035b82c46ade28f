! SPDX-License-Identifier: GPL-3.0-or-later
!> Converts the pose of a wing, in units L and T, into the moving frame in SI units that the mechanics of the wing uses.
!>
!> The frame's origin is the hinge and its axes are those of the wing frame; with pose matrix M,
!>
!>     velocity = M v_hinge L/T,  acceleration = M a_hinge L/T^2,  omega/T,  alpha/T^2,  gravity = M g.
!>
!> Velocities and accelerations are exact time derivatives of the pose, because the kinematics computes them with the pose
!> (fsi_rotation). A wing that is the mirror image of the one in its file is computed in the mirrored frame (fsi_wing_mirror).
module fsi_wing_frame
  use base_kinds, only: rp
  use fsi_body_motion, only: body_motion_t
  use fsi_kinematics, only: body_t, pose_wing, wing_mount_t, wing_pose_t
  use fsi_wing_mirror, only: mirror_frame
  use fsi_wing_motion, only: wing_motion_t
  use solid_motion, only: frame_t, motion_t
  implicit none
  private
  public :: flapping_motion_t, frame_of_pose

  !> The motion of a wing that flaps on a body. It is defined at any time; on a body in free flight only at the two recorded times.
  type, extends(motion_t) :: flapping_motion_t
    type(body_t) :: body                !< the body if it is tethered
    type(body_motion_t) :: carrier      !< motion of the body
    type(wing_mount_t) :: mount
    type(wing_motion_t) :: motion
    real(rp) :: length = 1     !< [m] one L
    real(rp) :: frequency = 1  !< [1/s] 1/T
    real(rp) :: gravity(3) = 0 !< [m/s^2] in space
    logical :: is_mirrored = .false. !< z of the wing file points to the other side than z of the wing frame
  contains
    procedure :: at => flapping_at
    procedure :: pose_at => flapping_pose_at
  end type flapping_motion_t

contains

  !> Returns the frame at `time` [s], along the axes of the wing file.
  function flapping_at(self, time) result(frame)
    class(flapping_motion_t), intent(in) :: self
    real(rp), intent(in) :: time
    type(frame_t) :: frame
    type(wing_pose_t) :: pose
    pose = self%pose_at(time)
    frame = frame_of_pose(pose, self%length, self%frequency, self%gravity)
    if (self%is_mirrored) frame = mirror_frame(frame)
  end function flapping_at

  !> Returns the pose of the wing at `time` [s].
  function flapping_pose_at(self, time) result(pose)
    class(flapping_motion_t), intent(in) :: self
    real(rp), intent(in) :: time
    type(wing_pose_t) :: pose
    call pose_wing(self%carrier%at(time*self%frequency, self%body), self%mount, self%motion, time*self%frequency, pose)
  end function flapping_pose_at

  !> Returns the frame of a pose, for units length [m] and 1/frequency [s], and the acceleration of gravity in space [m/s^2],
  !> along the axes of the wing frame. It holds for any motion of the body, as far as the pose contains it.
  pure type(frame_t) function frame_of_pose(pose, length, frequency, gravity) result(frame)
    type(wing_pose_t), intent(in) :: pose
    real(rp), intent(in) :: length, frequency, gravity(3)
    frame%velocity = (length*frequency)*pose%vector_to_wing(pose%hinge_velocity)
    frame%acceleration = (length*frequency**2)*pose%vector_to_wing(pose%hinge_acceleration)
    frame%omega = frequency*pose%omega
    frame%alpha = frequency**2*pose%omega_rate
    frame%gravity = pose%vector_to_wing(gravity)
  end function frame_of_pose
end module fsi_wing_frame

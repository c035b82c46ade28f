! SPDX-License-Identifier: GPL-3.0-or-later
!> Combines the motions of body, hinge and wing into the pose of each wing.
!>
!>     x_body = M_b (x - centre)          M_b = Rx(roll) Ry(pitch) Rz(yaw)
!>     x_FLUSI = M_w (x_body - hinge)     left:  M_w = Ry(alpha) Rz(theta) Rx(phi) Ry(eta)
!>                                        right: M_w = Ry(-alpha) Rz(theta) Rx(-phi) Rx(pi) Ry(eta)
!>     x_wing = (y, x, -z)_FLUSI          root to tip, to the leading edge, normal
!>
!> with FLUSI's matrices and its stroke-plane angle eta. Body axes: x forward, y left, z up. The wing frame
!> is right-handed on both sides; the right wing is the mirror image of the left one, so that +z points
!> ventrally on the left and dorsally on the right. docs/guide/kinematics.md has the drawing, fsi_wing_mirror the mechanics.
module fsi_kinematics
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  use fsi_rotation, only: angle_t, cross, rotation_t
  use fsi_wing_motion, only: wing_motion_t
  implicit none
  private
  public :: body_t, wing_mount_t, wing_pose_t
  public :: body_rotation, wing_rotation, pose_wing, swap_flusi_wing, mirror_wing

  !> The body as a moving frame.
  type, extends(visited_t) :: body_t
    real(rp) :: centre(3) = 0       !< L
    real(rp) :: velocity(3) = 0     !< L/T
    real(rp) :: acceleration(3) = 0 !< L/T^2
    real(rp) :: angles(3) = 0       !< roll, pitch, yaw, rad
    type(rotation_t) :: rotation    !< space to body
  contains
    procedure :: visit => body_visit
  end type body_t

  !> How a wing is attached to the body.
  type :: wing_mount_t
    logical :: is_right = .false.
    real(rp) :: hinge(3) = 0 !< in the body frame, L
    real(rp) :: eta = 0      !< stroke-plane angle, rad; -pi/2: the plane of the body axes x and y
  contains
    procedure :: dorsal_sign => mount_dorsal_sign
    procedure :: mirrors => mount_mirrors
  end type wing_mount_t

  !> A wing at one time. Vectors have components in the wing frame unless stated otherwise; angular velocity and acceleration are
  !> relative to space.
  type :: wing_pose_t
    type(angle_t) :: phi, alpha, theta
    real(rp) :: hinge(3) = 0                !< in space, L
    real(rp) :: hinge_velocity(3) = 0       !< in space, L/T
    real(rp) :: hinge_acceleration(3) = 0   !< in space, L/T^2
    real(rp) :: matrix(3, 3) = 0            !< takes components from space to the wing frame
    real(rp) :: omega(3) = 0                !< angular velocity, 1/T
    real(rp) :: omega_rate(3) = 0           !< angular acceleration, 1/T^2
    real(rp) :: omega_relative(3) = 0       !< angular velocity relative to the body, 1/T
    real(rp) :: omega_relative_rate(3) = 0  !< angular acceleration relative to the body, 1/T^2
  contains
    procedure :: vector_to_wing => pose_vector_to_wing
    procedure :: vector_to_space => pose_vector_to_space
    procedure :: point_to_space => pose_point_to_space
    procedure :: velocity_at => pose_velocity_at
    procedure :: acceleration_at => pose_acceleration_at
  end type wing_pose_t

contains

  !> Shows every component to the visitor.
  subroutine body_visit(self, visitor)
    class(body_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('centre', self%centre)
    call visitor%visit('velocity', self%velocity)
    call visitor%visit('acceleration', self%acceleration)
    call visitor%visit('angles', self%angles)
    call visitor%visit('rotation', self%rotation)
  end subroutine body_visit

  !> Returns the rotation from space to the body: yaw about z, then pitch about y, then roll about x. Positive pitch is nose down.
  pure type(rotation_t) function body_rotation(roll, pitch, yaw) result(rotation)
    type(angle_t), intent(in) :: roll, pitch, yaw
    call rotation%turn(3, yaw)
    call rotation%turn(2, pitch)
    call rotation%turn(1, roll)
  end function body_rotation

  !> Returns the rotation from the body to FLUSI's wing frame (x chordwise forward, y to the tip).
  pure type(rotation_t) function wing_rotation(is_right, eta, phi, alpha, theta) result(rotation)
    logical, intent(in) :: is_right
    real(rp), intent(in) :: eta !< rad
    type(angle_t), intent(in) :: phi, alpha, theta
    call rotation%turn(2, angle_t(value=eta))
    if (is_right) then
      call rotation%turn_half(1)
      call rotation%turn(1, -phi)
      call rotation%turn(3, theta)
      call rotation%turn(2, -alpha)
    else
      call rotation%turn(1, phi)
      call rotation%turn(3, theta)
      call rotation%turn(2, alpha)
    end if
  end function wing_rotation

  !> Converts components in FLUSI's wing frame to components in the wing frame of this program, and back: (y, x, -z).
  pure function swap_flusi_wing(v) result(swapped)
    real(rp), intent(in) :: v(3)
    real(rp) :: swapped(3)
    swapped = [v(2), v(1), -v(3)]
  end function swap_flusi_wing

  !> Converts a point of the left wing, in its wing frame, to its mirror image on the right wing, in the frame of the right wing,
  !> and back.
  pure function mirror_wing(x) result(mirrored)
    real(rp), intent(in) :: x(3)
    real(rp) :: mirrored(3)
    mirrored = [x(1), x(2), -x(3)]
  end function mirror_wing

  !> Returns +1 or -1, the direction of z of the wing frame that points to the upper (dorsal) side of the wing.
  pure real(rp) function mount_dorsal_sign(self) result(sign)
    class(wing_mount_t), intent(in) :: self
    sign = merge(1.0_rp, -1.0_rp, self%is_right)
  end function mount_dorsal_sign

  !> Tells whether z of the wing frame points to another side of the wing than the z of a wing file.
  pure logical function mount_mirrors(self, z_is_dorsal) result(mirrors)
    class(wing_mount_t), intent(in) :: self
    logical, intent(in) :: z_is_dorsal !< in the file
    mirrors = (self%dorsal_sign() > 0) .neqv. z_is_dorsal
  end function mount_mirrors

  !> Sets `pose` to the position, attitude and rates of the wing at time t [T].
  subroutine pose_wing(body, mount, motion, t, pose)
    type(body_t), intent(in) :: body
    type(wing_mount_t), intent(in) :: mount
    type(wing_motion_t), intent(in) :: motion
    real(rp), intent(in) :: t !< T
    type(wing_pose_t), intent(out) :: pose
    type(rotation_t) :: in_body, in_space
    real(rp) :: arm(3), turning(3)
    integer :: i
    call motion%evaluate(t, pose%phi, pose%alpha, pose%theta)
    in_body = wing_rotation(mount%is_right, mount%eta, pose%phi, pose%alpha, pose%theta)
    in_space = in_body%after(body%rotation)
    do i = 1, 3
      pose%matrix(:, i) = swap_flusi_wing(in_space%matrix(:, i))
    end do
    pose%omega = swap_flusi_wing(in_space%omega)
    pose%omega_rate = swap_flusi_wing(in_space%omega_rate)
    pose%omega_relative = swap_flusi_wing(in_body%omega)
    pose%omega_relative_rate = swap_flusi_wing(in_body%omega_rate)

    associate (b => body%rotation)
      turning = cross(b%omega, mount%hinge)
      arm = cross(b%omega_rate, mount%hinge) + cross(b%omega, turning)
      pose%hinge = body%centre + b%to_parent(mount%hinge)
      pose%hinge_velocity = body%velocity + b%to_parent(turning)
      pose%hinge_acceleration = body%acceleration + b%to_parent(arm)
    end associate
  end subroutine pose_wing

  !> Returns the components in the wing frame of a vector in space.
  pure function pose_vector_to_wing(self, v) result(w)
    class(wing_pose_t), intent(in) :: self
    real(rp), intent(in) :: v(3)
    real(rp) :: w(3)
    w = matmul(self%matrix, v)
  end function pose_vector_to_wing

  !> Returns the components in space of a vector in the wing frame.
  pure function pose_vector_to_space(self, w) result(v)
    class(wing_pose_t), intent(in) :: self
    real(rp), intent(in) :: w(3)
    real(rp) :: v(3)
    v = matmul(w, self%matrix)
  end function pose_vector_to_space

  !> Returns the position in space of a point in the wing frame [L].
  pure function pose_point_to_space(self, w) result(x)
    class(wing_pose_t), intent(in) :: self
    real(rp), intent(in) :: w(3)
    real(rp) :: x(3)
    x = self%hinge + matmul(w, self%matrix)
  end function pose_point_to_space

  !> Returns the velocity in space [L/T] of the point of the rigid wing that is at w [L] in the wing frame.
  pure function pose_velocity_at(self, w) result(v)
    class(wing_pose_t), intent(in) :: self
    real(rp), intent(in) :: w(3)
    real(rp) :: v(3)
    v = self%hinge_velocity + matmul(cross(self%omega, w), self%matrix)
  end function pose_velocity_at

  !> Returns the acceleration in space [L/T^2] of the point of the rigid wing that is at w [L] in the wing frame.
  pure function pose_acceleration_at(self, w) result(a)
    class(wing_pose_t), intent(in) :: self
    real(rp), intent(in) :: w(3)
    real(rp) :: a(3)
    a = self%hinge_acceleration + &
        matmul(cross(self%omega_rate, w) + cross(self%omega, cross(self%omega, w)), self%matrix)
  end function pose_acceleration_at
end module fsi_kinematics

! SPDX-License-Identifier: GPL-3.0-or-later
!> Prescribes the motion of the wing's frame, in which the root is at rest.
module solid_motion
  use base_kinds, only: rp
  use solid_vectors, only: cross
  implicit none
  private
  public :: frame_t, motion_t, steady_motion_t, rotating_motion_t, inertial_velocity

  !> The frame at one time. All components are along the axes of the frame itself, right-handed.
  type :: frame_t
    real(rp) :: velocity(3) = 0     !< [m/s] of the origin
    real(rp) :: acceleration(3) = 0 !< [m/s^2] of the origin
    real(rp) :: omega(3) = 0        !< [rad/s] angular velocity
    real(rp) :: alpha(3) = 0        !< [rad/s^2] angular acceleration
    real(rp) :: gravity(3) = 0      !< [m/s^2]
  end type frame_t

  !> A rule that gives the frame at any time.
  type, abstract :: motion_t
  contains
    procedure(frame_at), deferred :: at
  end type motion_t

  abstract interface
    !> Returns the frame at `time` [s].
    function frame_at(self, time) result(frame)
      import :: motion_t, frame_t, rp
      class(motion_t), intent(in) :: self
      real(rp), intent(in) :: time
      type(frame_t) :: frame
    end function frame_at
  end interface

  !> A frame that never changes: at rest, or spinning at constant speed about its own axis.
  type, extends(motion_t) :: steady_motion_t
    type(frame_t) :: frame
  contains
    procedure :: at => steady_at
  end type steady_motion_t

  !> A frame that turns about an axis fixed in space. At time 0 its axes are those of space. With a ramp
  !> tau > 0 it starts from rest, omega(t) = s(t/tau) rate axis with s(r) = r^3 (10 - 15 r + 6 r^2), and turns
  !> evenly from tau on.
  type, extends(motion_t) :: rotating_motion_t
    real(rp) :: axis(3) = [0.0_rp, 0.0_rp, 1.0_rp] !< unit vector; the same in space and in the frame
    real(rp) :: through(3) = 0 !< [m] a point of the axis, in the frame
    real(rp) :: rate = 0       !< [rad/s] angular speed
    real(rp) :: ramp = 0       !< [s] tau
    real(rp) :: gravity(3) = 0 !< [m/s^2] in space
  contains
    procedure :: at => rotating_at
  end type rotating_motion_t

contains

  !> Returns the frame, which is the same at all times.
  function steady_at(self, time) result(frame)
    class(steady_motion_t), intent(in) :: self
    real(rp), intent(in) :: time
    type(frame_t) :: frame
    frame = self%frame
    if (time < 0) return
  end function steady_at

  !> Returns the turning frame at `time` >= 0 [s].
  function rotating_at(self, time) result(frame)
    class(rotating_motion_t), intent(in) :: self
    real(rp), intent(in) :: time
    type(frame_t) :: frame
    real(rp) :: r, angle
    associate (e => self%axis, g => self%gravity)
      if (time < self%ramp) then
        r = time/self%ramp
        angle = self%rate*self%ramp*r**4*(2.5_rp - 3*r + r**2)
        frame%omega = (self%rate*r**3*(10 - 15*r + 6*r**2))*e
        frame%alpha = (self%rate/self%ramp*30*r**2*(1 - r)**2)*e
      else
        angle = self%rate*(time - 0.5_rp*self%ramp)
        frame%omega = self%rate*e
      end if
      frame%velocity = -cross(frame%omega, self%through)
      frame%acceleration = cross(frame%omega, frame%velocity) - cross(frame%alpha, self%through)
      ! Components along axes that have turned by `angle`.
      frame%gravity = dot_product(e, g)*e + cos(angle)*(g - dot_product(e, g)*e) - sin(angle)*cross(e, g)
    end associate
  end function rotating_at

  !> Returns the velocity [m/s] in an inertial frame, with components along the wing frame, of a point at x(3) [m] that moves with
  !> v(3) [m/s] in the wing frame.
  pure function inertial_velocity(frame, x, v) result(w)
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: x(3), v(3)
    real(rp) :: w(3)
    w = frame%velocity + cross(frame%omega, x) + v
  end function inertial_velocity
end module solid_motion

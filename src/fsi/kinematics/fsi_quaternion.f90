! SPDX-License-Identifier: GPL-3.0-or-later
!> Represents the attitude of a body as a unit quaternion q = (q0, q1, q2, q3), as FLUSI does.
!>
!>     q = q_z(yaw) q_y(pitch) q_x(roll),       dq/dt = q (0, omega)/2,
!>
!> omega along the axes of the body. A step by the rotation vector w, also along them, is q <- q exp(w/2): its length stays 1 up to
!> round-off, and each step normalises it, so that the length does not drift.
module fsi_quaternion
  use base_kinds, only: rp
  implicit none
  private
  public :: attitude_of, matrix_of, angles_of, turned, rate_of, spin_of

contains

  !> Returns the quaternion of these angles [rad].
  pure function attitude_of(roll, pitch, yaw) result(q)
    real(rp), intent(in) :: roll, pitch, yaw
    real(rp) :: q(0:3)
    q = product_of(product_of([cos(yaw/2), 0.0_rp, 0.0_rp, sin(yaw/2)], [cos(pitch/2), 0.0_rp, sin(pitch/2), 0.0_rp]), &
                   [cos(roll/2), sin(roll/2), 0.0_rp, 0.0_rp])
  end function attitude_of

  !> Returns the matrix that takes components from space to the body.
  pure function matrix_of(q) result(m)
    real(rp), intent(in) :: q(0:3)
    real(rp) :: m(3, 3)
    m(1, :) = [q(0)**2 + q(1)**2 - q(2)**2 - q(3)**2, 2*(q(1)*q(2) + q(0)*q(3)), 2*(q(1)*q(3) - q(0)*q(2))]
    m(2, :) = [2*(q(1)*q(2) - q(0)*q(3)), q(0)**2 - q(1)**2 + q(2)**2 - q(3)**2, 2*(q(2)*q(3) + q(0)*q(1))]
    m(3, :) = [2*(q(1)*q(3) + q(0)*q(2)), 2*(q(2)*q(3) - q(0)*q(1)), q(0)**2 - q(1)**2 - q(2)**2 + q(3)**2]
  end function matrix_of

  !> Returns roll, pitch and yaw [rad]; pitch lies between -pi/2 and pi/2.
  pure function angles_of(q) result(angles)
    real(rp), intent(in) :: q(0:3)
    real(rp) :: angles(3)
    real(rp) :: m(3, 3)
    m = matrix_of(q)
    angles = [atan2(m(2, 3), m(3, 3)), asin(max(-1.0_rp, min(1.0_rp, -m(1, 3)))), atan2(m(1, 2), m(1, 1))]
  end function angles_of

  !> Returns q after a turn by the rotation vector w [rad] along the axes of the body; the result has length 1.
  pure function turned(q, w) result(after)
    real(rp), intent(in) :: q(0:3), w(3)
    real(rp) :: after(0:3)
    real(rp), parameter :: SMALL = 1.0e-4_rp
    real(rp) :: angle, ratio
    angle = norm2(w)
    if (angle > SMALL) then
      ratio = sin(angle/2)/angle
    else
      ratio = 0.5_rp - angle**2/48 ! sin to round-off
    end if
    after = product_of(q, [cos(angle/2), ratio*w])
    after = after/norm2(after)
  end function turned

  !> Returns the quaternion product a b.
  pure function product_of(a, b) result(c)
    real(rp), intent(in) :: a(0:3), b(0:3)
    real(rp) :: c(0:3)
    c(0) = a(0)*b(0) - a(1)*b(1) - a(2)*b(2) - a(3)*b(3)
    c(1) = a(0)*b(1) + a(1)*b(0) + a(2)*b(3) - a(3)*b(2)
    c(2) = a(0)*b(2) + a(2)*b(0) + a(3)*b(1) - a(1)*b(3)
    c(3) = a(0)*b(3) + a(3)*b(0) + a(1)*b(2) - a(2)*b(1)
  end function product_of

  !> Returns dq/dt for the angular velocity omega along the axes of the body.
  pure function rate_of(q, omega) result(rate)
    real(rp), intent(in) :: q(0:3), omega(3)
    real(rp) :: rate(0:3)
    rate = product_of(q, [0.0_rp, omega])/2
  end function rate_of

  !> Returns the vector part of 2 conj(q) x along the axes of the body. If |q| = 1 at all times, that is the angular velocity for
  !> x = dq/dt, and the angular acceleration if x is the second derivative.
  pure function spin_of(q, x) result(omega)
    real(rp), intent(in) :: q(0:3), x(0:3)
    real(rp) :: omega(3)
    real(rp) :: whole(0:3)
    whole = 2*product_of([q(0), -q(1:3)], x)
    omega = whole(1:3)
  end function spin_of
end module fsi_quaternion

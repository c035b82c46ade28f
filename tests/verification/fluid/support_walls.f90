! SPDX-License-Identifier: GPL-3.0-or-later
!> Where the wall is that the flow outside of a penalized body sees.
module support_walls
  use base_kinds, only: rp
  use fluid_bodies, only: mask_profile
  implicit none
  private
  public :: wall_shift

contains

  !> Distance from the nominal surface (chi = 1/2) to the wall that the outer flow sees, for a mask whose step is
  !> 2 h wide: nu u'' = chi(y)/C_eta u with unit slope far outside, and the wall is where the outer line meets zero.
  !> Integrated outward from deep inside (fourth-order Runge-Kutta).
  real(rp) function wall_shift(nu, c_eta, h) result(shift)
    real(rp), intent(in) :: nu, c_eta, h
    integer, parameter :: STEPS = 4000
    real(rp) :: y, dy, u(2), k1(2), k2(2), k3(2), k4(2)
    integer :: i
    y = -2*h
    dy = 3*h/STEPS
    u = [1.0_rp, sqrt(1/(nu*c_eta))]
    do i = 1, STEPS
      k1 = slope(y, u)
      k2 = slope(y + dy/2, u + dy/2*k1)
      k3 = slope(y + dy/2, u + dy/2*k2)
      k4 = slope(y + dy, u + dy*k3)
      u = u + dy/6*(k1 + 2*k2 + 2*k3 + k4)
      u = u/maxval(abs(u)) ! the equation is linear
      y = y + dy
    end do
    shift = y - u(1)/u(2)

  contains

    pure function slope(y, u) result(du)
      real(rp), intent(in) :: y, u(2)
      real(rp) :: du(2)
      du = [u(2), mask_profile(y, h)/(nu*c_eta)*u(1)]
    end function slope
  end function wall_shift
end module support_walls

! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the rotation that a vector defines: about its direction, by its length [rad].
!>
!> R = 1 + a S + b S^2 with S = [v]x, a = sin t/t, b = (1 - cos t)/t^2, t = |v|; series near 0.
module solid_rotation
  use base_kinds, only: rp
  use solid_vectors, only: skew, IDENTITY
  implicit none
  private
  public :: rotation_matrix, rotation_derivative

  real(rp), parameter :: SMALL = 0.1_rp

contains

  !> Returns R(v), the rotation by |v| [rad] about v; the identity, exactly, for v = 0.
  pure function rotation_matrix(v) result(r)
    real(rp), intent(in) :: v(3)
    real(rp) :: r(3, 3), s(3, 3), c(4)
    c = coefficients(v)
    s = skew(v)
    r = IDENTITY + c(1)*s + c(2)*matmul(s, s)
  end function rotation_matrix

  !> Returns dR/dv(k).
  pure function rotation_derivative(v, k) result(d)
    real(rp), intent(in) :: v(3)
    integer, intent(in) :: k
    real(rp) :: d(3, 3), s(3, 3), e(3, 3), c(4)
    c = coefficients(v)
    s = skew(v)
    e = skew(IDENTITY(:, k))
    d = c(1)*e + c(2)*(matmul(e, s) + matmul(s, e)) + v(k)*(c(3)*s + c(4)*matmul(s, s))
  end function rotation_derivative

  !> Computes a, b, (da/dt)/t and (db/dt)/t.
  pure function coefficients(v) result(c)
    real(rp), intent(in) :: v(3)
    real(rp) :: c(4), t, q
    q = dot_product(v, v)
    t = sqrt(q)
    if (t < SMALL) then
      c(1) = 1 - q/6*(1 - q/20*(1 - q/42*(1 - q/72)))
      c(2) = 0.5_rp*(1 - q/12*(1 - q/30*(1 - q/56*(1 - q/90))))
      c(3) = -(1 - q/10*(1 - q/28*(1 - q/54)))/3
      c(4) = -(1 - q/15*(1 - q/37.333333333333336_rp*(1 - q/67.5_rp)))/12
    else
      c(1) = sin(t)/t
      c(2) = (1 - cos(t))/q
      c(3) = (t*cos(t) - sin(t))/(q*t)
      c(4) = (t*sin(t) - 2*(1 - cos(t)))/q**2
    end if
  end function coefficients
end module solid_rotation

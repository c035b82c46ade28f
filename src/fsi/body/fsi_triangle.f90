! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the closest point of a triangle: q = (1 - v - w) a + v b + w c with the smallest |p - q|.
!>
!> The barycentric coordinates v, w of the projection of p onto the plane are linear in p. If none of
!> 1 - v - w, v, w is negative, the projection is the closest point. Otherwise the closest point lies on an
!> edge whose coordinate is negative: p - q is in the normal cone of q, which at a corner is spanned by the
!> outward normals of both edges, and p is outside of at least one of them. Regions as in Ericson, Real-Time
!> Collision Detection (2005), section 5.1.5.
!>
!> A needle, whose height is below 1e-8 of its longest edge, has no reliable plane. It is treated as its three edges, with an
!> error smaller than its height. An edge without length is treated as its first point.
module fsi_triangle
  use base_kinds, only: rp
  use fsi_rotation, only: cross
  implicit none
  private
  public :: triangle_t, make_triangle

  real(rp), parameter :: NEEDLE = 1.0e-8_rp       !< height over length below which there is no plane
  real(rp), parameter :: NO_LENGTH = 1.0e-200_rp  !< squared length that cannot be inverted safely

  !> A triangle and quantities that depend on it alone. Lengths in code units.
  type :: triangle_t
    real(rp) :: a(3) = 0                  !< first corner
    real(rp) :: ab(3) = 0, ac(3) = 0      !< edges from it
    real(rp) :: bc(3) = 0
    real(rp) :: grad_v(3) = 0, grad_w(3) = 0 !< v = grad_v.(p - a), w = grad_w.(p - a)
    real(rp) :: normal(3) = 0             !< unit normal, counter-clockwise; 0 for a needle
    real(rp) :: outward(3, 3) = 0         !< unit normals of ab, ac, bc in the plane, (:, edge); 0 for a needle
    real(rp) :: height = 0                !< distance of a from the line bc
    real(rp) :: inv_ab = 0, inv_ac = 0, inv_bc = 0 !< 1/length^2, 0 for no length
    logical :: is_needle = .false.
  contains
    procedure :: closest => triangle_closest
  end type triangle_t

contains

  !> Returns the triangle with corners a, b, c; any three points will do.
  pure function make_triangle(a, b, c) result(triangle)
    real(rp), intent(in) :: a(3), b(3), c(3)
    type(triangle_t) :: triangle
    real(rp) :: n(3), n2, longest
    triangle%a = a
    triangle%ab = b - a
    triangle%ac = c - a
    triangle%bc = c - b
    triangle%inv_ab = inverse_square(triangle%ab)
    triangle%inv_ac = inverse_square(triangle%ac)
    triangle%inv_bc = inverse_square(triangle%bc)
    longest = max(dot_product(triangle%ab, triangle%ab), dot_product(triangle%ac, triangle%ac), &
                  dot_product(triangle%bc, triangle%bc))
    n = cross(triangle%ab, triangle%ac)
    n2 = dot_product(n, n)
    triangle%is_needle = n2 <= (NEEDLE*longest)**2
    if (triangle%is_needle) return
    triangle%normal = n/sqrt(n2)
    triangle%grad_v = cross(triangle%ac, n)/n2
    triangle%grad_w = cross(n, triangle%ab)/n2
    triangle%outward(:, 1) = -triangle%grad_w/norm2(triangle%grad_w)
    triangle%outward(:, 2) = -triangle%grad_v/norm2(triangle%grad_v)
    triangle%outward(:, 3) = triangle%grad_v + triangle%grad_w
    triangle%height = 1/norm2(triangle%outward(:, 3))
    triangle%outward(:, 3) = triangle%outward(:, 3)*triangle%height
  end function make_triangle

  !> Returns the squared distance of `p`, and the coordinates v, w >= 0, v + w <= 1 of the closest point.
  pure subroutine triangle_closest(self, p, distance2, v, w)
    class(triangle_t), intent(in) :: self
    real(rp), intent(in) :: p(3)
    real(rp), intent(out) :: distance2, v, w
    real(rp) :: ap(3), q(3), t, d2, v_plane, w_plane
    ap = p - self%a
    v_plane = dot_product(self%grad_v, ap)
    w_plane = dot_product(self%grad_w, ap)
    if (.not. self%is_needle .and. v_plane >= 0 .and. w_plane >= 0 .and. v_plane + w_plane <= 1) then
      v = v_plane
      w = w_plane
      q = ap - v*self%ab - w*self%ac
      distance2 = dot_product(q, q)
      return
    end if
    distance2 = huge(distance2)
    v = 0
    w = 0
    if (self%is_needle .or. w_plane < 0) then
      t = min(1.0_rp, max(0.0_rp, dot_product(ap, self%ab)*self%inv_ab))
      q = ap - t*self%ab
      distance2 = dot_product(q, q)
      v = t
    end if
    if (self%is_needle .or. v_plane < 0) then
      t = min(1.0_rp, max(0.0_rp, dot_product(ap, self%ac)*self%inv_ac))
      q = ap - t*self%ac
      d2 = dot_product(q, q)
      if (d2 < distance2) then
        distance2 = d2
        v = 0
        w = t
      end if
    end if
    if (self%is_needle .or. v_plane + w_plane > 1) then
      t = min(1.0_rp, max(0.0_rp, dot_product(ap - self%ab, self%bc)*self%inv_bc))
      q = ap - self%ab - t*self%bc
      d2 = dot_product(q, q)
      if (d2 < distance2) then
        distance2 = d2
        v = 1 - t
        w = t
      end if
    end if
  end subroutine triangle_closest

  !> Returns 1 over the square of an edge's length, 0 for an edge without length.
  pure real(rp) function inverse_square(edge) result(inverse)
    real(rp), intent(in) :: edge(3)
    inverse = dot_product(edge, edge)
    if (inverse > NO_LENGTH) then
      inverse = 1/inverse
    else
      inverse = 0
    end if
  end function inverse_square
end module fsi_triangle

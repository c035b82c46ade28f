! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds a point (x, y) on the unloaded wing: the triangle that contains it or, without triangles, the nearest point of the wing.
module measurement_material_point
  use base_kinds, only: rp
  implicit none
  private
  public :: material_point_t, find_material_point, weight_gradient

  real(rp), parameter, public :: NEAR = 0.01_rp !< in lengths of the wing: largest distance from a point of a structure of veins

  !> Describes a point that moves with the wing: the sum of share*(corner).
  type :: material_point_t
    logical :: is_found = .false.
    integer :: corner(3) = 1
    real(rp) :: weight(3) = 0
    logical :: is_in_triangle = .false.
  end type material_point_t

contains

  !> Finds the point (x, y) [m] on the wing of these points (3, n) [m] and triangles (3, m), whose length is `length` [m].
  pure function find_material_point(points, triangles, length, site) result(found)
    real(rp), intent(in) :: points(:, :), length, site(2)
    integer, intent(in) :: triangles(:, :)
    type(material_point_t) :: found
    real(rp), parameter :: TOLERANCE = 1.0e-9_rp ! the same as in solid_loads
    real(rp) :: w(3), distance, nearest
    integer :: t, i
    do t = 1, size(triangles, 2)
      associate (a => points(:2, triangles(1, t)), b => points(:2, triangles(2, t)), c => points(:2, triangles(3, t)))
        w = [twice_area(site, b, c), twice_area(a, site, c), twice_area(a, b, site)]/twice_area(a, b, c)
      end associate
      if (minval(w) < -TOLERANCE) cycle
      found%is_found = .true.
      found%is_in_triangle = .true.
      found%corner = triangles(:, t)
      found%weight = w
      return
    end do
    if (size(triangles) > 0) return
    nearest = huge(nearest)
    do i = 1, size(points, 2)
      distance = norm2(points(:2, i) - site)
      if (distance < nearest) found%corner = i
      nearest = min(nearest, distance)
    end do
    found%is_found = nearest <= NEAR*length
    found%weight = [1.0_rp, 0.0_rp, 0.0_rp]
  end function find_material_point

  !> Returns gradient(2, 3) [1/m], the change of the shares of a point in a triangle when it moves in x and y.
  pure function weight_gradient(points, site) result(gradient)
    real(rp), intent(in) :: points(:, :)
    type(material_point_t), intent(in) :: site
    real(rp) :: gradient(2, 3), area
    integer :: c
    area = twice_area(points(:2, site%corner(1)), points(:2, site%corner(2)), points(:2, site%corner(3)))
    do c = 1, 3
      associate (b => points(:2, site%corner(mod(c, 3) + 1)), d => points(:2, site%corner(mod(c + 1, 3) + 1)))
        gradient(:, c) = [b(2) - d(2), d(1) - b(1)]/area
      end associate
    end do
  end function weight_gradient

  !> Returns twice the area of a triangle in the plane, negative if its corners go clockwise.
  pure real(rp) function twice_area(a, b, c) result(area)
    real(rp), intent(in) :: a(2), b(2), c(2)
    area = (b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1))
  end function twice_area
end module measurement_material_point

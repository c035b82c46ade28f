! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures how close wings come to each other and to the periodic images of themselves and of each other.
!>
!> The distance is the smallest one between the points of one surface and the triangles of the other, in both directions. If two
!> edges cross, it is too large by less than half an edge; edges are about as short as the thickness of wings in the mask, or
!> shorter. Surfaces farther apart than the limit cost only a comparison of boxes.
module fsi_wing_gap
  use base_kinds, only: rp
  use fsi_surface, only: surface_t
  use fsi_triangle, only: make_triangle, triangle_t
  implicit none
  private
  public :: gap_t, smallest_gap

  type :: gap_t
    real(rp) :: distance = huge(1.0_rp)  !< L; huge: beyond the limit
    integer :: first = 0, second = 0     !< surfaces
    logical :: is_image = .false.        !< the second is a periodic image
  end type gap_t

contains

  !> Returns the smallest gap below `limit` [L] between different surfaces, their images in a box of size `length`, and each
  !> surface and its own images. Nothing is periodic in a direction of `length` 0.
  pure type(gap_t) function smallest_gap(surfaces, limit, length) result(gap)
    type(surface_t), intent(in) :: surfaces(:)
    real(rp), intent(in) :: limit
    real(rp), intent(in) :: length(3)
    real(rp) :: shift(3), distance
    integer :: i, j, x, y, z
    do i = 1, size(surfaces)
      do j = i, size(surfaces)
        do z = -1, 1
          do y = -1, 1
            do x = -1, 1
              if (i == j .and. all([x, y, z] == 0)) cycle
              if (any([x, y, z] /= 0 .and. length <= 0)) cycle
              shift = [x, y, z]*length
              distance = gap_between(surfaces(i), surfaces(j), shift, limit)
              if (distance >= min(limit, gap%distance)) cycle
              gap%distance = distance
              gap%first = i
              gap%second = j
              gap%is_image = any([x, y, z] /= 0)
            end do
          end do
        end do
      end do
    end do
  end function smallest_gap

  !> Returns the distance between `a` and `b` moved by `shift`, or anything not below `limit` if they are not as close.
  pure real(rp) function gap_between(a, b, shift, limit) result(distance)
    type(surface_t), intent(in) :: a, b
    real(rp), intent(in) :: shift(3), limit
    distance = limit
    if (any(minval(a%points, 2) > maxval(b%points, 2) + shift + limit)) return
    if (any(minval(b%points, 2) + shift > maxval(a%points, 2) + limit)) return
    distance = min(from_points(a, b, shift, limit), from_points(b, a, -shift, limit))
  end function gap_between

  !> Returns the distance of the points of `a` from the triangles of `b` moved by `shift`.
  pure real(rp) function from_points(a, b, shift, limit) result(distance)
    type(surface_t), intent(in) :: a, b
    real(rp), intent(in) :: shift(3), limit
    type(triangle_t) :: triangle
    real(rp) :: corners(3, 3), low(3), high(3), d2, v, w
    integer :: near(size(a%points, 2)) !< points of `a` in the box of `b`, the first n_near
    integer :: n_near, t, i, p
    distance = limit
    low = minval(b%points, 2) + shift - limit
    high = maxval(b%points, 2) + shift + limit
    n_near = 0
    do p = 1, size(a%points, 2)
      if (any(a%points(:, p) < low .or. a%points(:, p) > high)) cycle
      n_near = n_near + 1
      near(n_near) = p
    end do
    low = minval(a%points, 2)
    high = maxval(a%points, 2)
    do t = 1, size(b%triangles, 2)
      corners = b%points(:, b%triangles(:, t)) + spread(shift, 2, 3)
      associate (first => minval(corners, 2), last => maxval(corners, 2))
        if (any(first > high + distance) .or. any(last < low - distance)) cycle
        triangle = make_triangle(corners(:, 1), corners(:, 2), corners(:, 3))
        do i = 1, n_near
          p = near(i)
          if (a%points(1, p) > last(1) + distance .or. a%points(1, p) < first(1) - distance) cycle
          if (a%points(2, p) > last(2) + distance .or. a%points(2, p) < first(2) - distance) cycle
          if (a%points(3, p) > last(3) + distance .or. a%points(3, p) < first(3) - distance) cycle
          call triangle%closest(a%points(:, p), d2, v, w)
          distance = min(distance, sqrt(d2))
        end do
      end associate
    end do
  end function from_points
end module fsi_wing_gap

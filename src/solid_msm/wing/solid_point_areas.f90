! SPDX-License-Identifier: GPL-3.0-or-later
!> Shares the area of the membrane among the points of a wing.
module solid_point_areas
  use base_kinds, only: rp
  use solid_vectors, only: cross
  implicit none
  private
  public :: point_areas

contains

  !> Returns area(n), n = size(points, 2) [m^2], a third of the area of each of the triangles(3, :) that meet in a point of
  !> points(3, n) [m]; 0 without triangles.
  pure function point_areas(points, triangles) result(area)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: triangles(:, :)
    real(rp) :: area(size(points, 2))
    integer :: t
    area = 0
    do t = 1, size(triangles, 2)
      associate (c => triangles(:, t))
        area(c) = area(c) + norm2(cross(points(:, c(2)) - points(:, c(1)), points(:, c(3)) - points(:, c(1))))/6
      end associate
    end do
  end function point_areas
end module solid_point_areas

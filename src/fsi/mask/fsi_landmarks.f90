! SPDX-License-Identifier: GPL-3.0-or-later
!> Follows points of a wing: landmarks that a camera sees. A landmark moves with the triangle of the wing that contains it at rest,
!> in the projection (x, y) of the wing frame.
module fsi_landmarks
  use base_kinds, only: rp
  implicit none
  private
  public :: landmarks_t

  !> A point just outside of the triangles moves with the nearest one. Its shares of the corners are then negative, down to -BEYOND.
  real(rp), parameter :: BEYOND = 0.5_rp

  type :: landmarks_t
    integer, allocatable :: corner(:, :) !< (3, n) points of the wing
    real(rp), allocatable :: share(:, :) !< (3, n) of each corner in the place of the landmark; the sum is 1
  contains
    procedure :: find => landmarks_find
    procedure :: count => landmarks_count
    procedure :: places => landmarks_places
  end type landmarks_t

contains

  !> Finds the landmarks sites(2, n) on a wing of points(3, :) and triangles(3, :), all in the same unit of length. `lost` is the
  !> number of the first one that is not on the wing, or 0.
  pure subroutine landmarks_find(self, points, triangles, sites, lost)
    class(landmarks_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :), sites(:, :)
    integer, intent(in) :: triangles(:, :)
    integer, intent(out) :: lost
    real(rp) :: share(3), least, area
    integer :: i, t
    lost = 0
    if (allocated(self%corner)) deallocate (self%corner, self%share)
    allocate (self%corner(3, size(sites, 2)), source=1)
    allocate (self%share(3, size(sites, 2)), source=0.0_rp)
    do i = 1, size(sites, 2)
      least = -BEYOND
      do t = 1, size(triangles, 2)
        associate (a => points(:2, triangles(1, t)), b => points(:2, triangles(2, t)), c => points(:2, triangles(3, t)))
          area = twice_area(a, b, c)
          if (.not. abs(area) > 0) cycle
          share = [twice_area(sites(:, i), b, c), twice_area(a, sites(:, i), c), twice_area(a, b, sites(:, i))]/area
        end associate
        if (.not. minval(share) > least) cycle
        least = minval(share)
        self%corner(:, i) = triangles(:, t)
        self%share(:, i) = share
      end do
      if (lost == 0 .and. .not. any(abs(self%share(:, i)) > 0)) lost = i
    end do
  end subroutine landmarks_find

  !> Returns how many landmarks there are.
  pure integer function landmarks_count(self) result(n)
    class(landmarks_t), intent(in) :: self
    n = 0
    if (allocated(self%corner)) n = size(self%corner, 2)
  end function landmarks_count

  !> Returns the places x(3, n) of the landmarks on a wing whose points(3, :) are there.
  pure function landmarks_places(self, points) result(x)
    class(landmarks_t), intent(in) :: self
    real(rp), intent(in) :: points(:, :)
    real(rp) :: x(3, self%count())
    integer :: i
    do i = 1, self%count()
      x(:, i) = matmul(points(:, self%corner(:, i)), self%share(:, i))
    end do
  end function landmarks_places

  !> Returns twice the area of a triangle in the plane, negative if its corners go clockwise.
  pure real(rp) function twice_area(a, b, c) result(area)
    real(rp), intent(in) :: a(2), b(2), c(2)
    area = (b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1))
  end function twice_area
end module fsi_landmarks

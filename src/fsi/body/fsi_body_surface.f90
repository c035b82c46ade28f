! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the surface chi = 1/2 of a rigid body as triangles for viewers; their size is that of the smoothing of the mask. It cuts
!> each cube of the body's box into six tetrahedra, whose edges the surface crosses where chi is 1/2. Triangles do not share points.
module fsi_body_surface
  use base_kinds, only: rp
  use fsi_rigid_body, only: rigid_body_t
  implicit none
  private
  public :: body_surface

  !> Corners of the tetrahedra around the diagonal from corner 0 to 7 of a cube; bit k of a corner is its position along axis k.
  integer, parameter :: TETRAHEDRA(4, 6) = reshape([0, 1, 3, 7, 0, 3, 2, 7, 0, 2, 6, 7, 0, 6, 4, 7, 0, 4, 5, 7, 0, 5, 1, 7], &
                                                   [4, 6])

contains

  !> Returns the points (3, 3 m) [L] of the m triangles of the surface, in the frame of the body: triangle i has the points 3 i -
  !> 2, 3 i - 1, 3 i. Allocates.
  subroutine body_surface(body, points)
    type(rigid_body_t), intent(in) :: body
    real(rp), allocatable, intent(out) :: points(:, :)
    real(rp), allocatable :: larger(:, :)
    real(rp) :: corner(3, 0:7), chi(0:7), step
    integer :: first(3), last(3), i, j, k, c, n
    step = body%smoothing
    first = floor(body%low/step) - 1
    last = ceiling(body%high/step) + 1
    allocate (points(3, 3000))
    n = 0
    do k = first(3), last(3)
      do j = first(2), last(2)
        do i = first(1), last(1)
          do c = 0, 7
            corner(:, c) = ([i, j, k] + [iand(c, 1), iand(c/2, 1), c/4])*step
            chi(c) = body%mask_at(corner(:, c))
          end do
          if (all(chi >= 0.5_rp) .or. all(chi < 0.5_rp)) cycle
          if (n + 36 > size(points, 2)) then
            allocate (larger(3, 2*size(points, 2)))
            larger(:, :n) = points(:, :n)
            call move_alloc(larger, points)
          end if
          do c = 1, 6
            call cut(corner(:, TETRAHEDRA(:, c)), chi(TETRAHEDRA(:, c)), points, n)
          end do
        end do
      end do
    end do
    points = points(:, :n)
  end subroutine body_surface

  !> Adds one or two triangles where the surface crosses the tetrahedron.
  subroutine cut(corners, chi, points, n)
    real(rp), intent(in) :: corners(3, 4), chi(4)
    real(rp), intent(inout) :: points(:, :)
    integer, intent(inout) :: n
    integer :: inside(4), outside(4), i, a, b
    a = 0
    b = 0
    do i = 1, 4
      if (chi(i) >= 0.5_rp) then
        a = a + 1
        inside(a) = i
      else
        b = b + 1
        outside(b) = i
      end if
    end do
    if (a == 0 .or. b == 0) return
    if (a == 1) then
      call add(inside(1), outside(1), inside(1), outside(2), inside(1), outside(3))
    else if (b == 1) then
      call add(inside(1), outside(1), inside(2), outside(1), inside(3), outside(1))
    else
      call add(inside(1), outside(1), inside(1), outside(2), inside(2), outside(2))
      call add(inside(1), outside(1), inside(2), outside(2), inside(2), outside(1))
    end if

  contains

    subroutine add(a1, b1, a2, b2, a3, b3)
      integer, intent(in) :: a1, b1, a2, b2, a3, b3
      points(:, n + 1) = crossing(a1, b1)
      points(:, n + 2) = crossing(a2, b2)
      points(:, n + 3) = crossing(a3, b3)
      n = n + 3
    end subroutine add

    pure function crossing(p, q) result(x)
      integer, intent(in) :: p, q
      real(rp) :: x(3)
      x = corners(:, p) + (corners(:, q) - corners(:, p))*((chi(p) - 0.5_rp)/(chi(p) - chi(q)))
    end function crossing
  end subroutine cut
end module fsi_body_surface

! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a solid inside a closed surface of triangles. The level is the distance from the nearest triangle. Its sign follows
!> from the normal there; at edges and corners that is the sum of the normals weighted by angles (Baerentzen & Aanaes 2005, DOI
!> 10.1109/TVCG.2005.49).
!>
!> Each cell of edge a holds the triangles within 3 r of its middle, where r = sqrt(3)/2 a. If the surface is farther than r from
!> the middle, it does not cross the cell, which then lies on one side. Otherwise, for every point in the cell, the nearest triangle
!> is among those that the cell holds. A cell without triangles lies on the same side as its neighbour along x.
module fsi_closed_surface
  use base_kinds, only: rp
  use fsi_rotation, only: cross
  use fsi_solid_shape, only: level_shape_t
  use fsi_triangle, only: make_triangle, triangle_t
  implicit none
  private
  public :: closed_surface_t, make_closed_surface

  real(rp), parameter :: HALF_DIAGONAL = 0.8660254037844387_rp, TOUCHES = 1.0e-10_rp

  type, extends(level_shape_t) :: closed_surface_t
    type(triangle_t), allocatable :: triangles(:)
    real(rp), allocatable :: normals(:, :, :) !< (3, 7, m) of the face, of the edges ab, ac, bc, of the corners a, b, c
    real(rp) :: edge = 0, origin(3) = 0       !< of the cells
    integer :: n(3) = 0
    integer, allocatable :: first(:), list(:) !< triangles of cell c: list(first(c) : first(c + 1) - 1)
    integer, allocatable :: sides(:)          !< (cells) -1 inside, 1 outside, 0 the surface may cross it
  contains
    procedure :: level_at => surface_level
  end type closed_surface_t

contains

  !> Returns the solid inside of triangles(3, m), which face outward, between points(3, n) [L], with cells of edge `edge` [L]. The
  !> level is exact where it is smaller than `edge`. Allocates.
  function make_closed_surface(points, triangles, edge) result(shape)
    real(rp), intent(in) :: points(:, :), edge
    integer, intent(in) :: triangles(:, :)
    type(closed_surface_t) :: shape
    integer :: i
    shape%low = minval(points, 2)
    shape%high = maxval(points, 2)
    allocate (shape%triangles(size(triangles, 2)))
    do i = 1, size(triangles, 2)
      shape%triangles(i) = make_triangle(points(:, triangles(1, i)), points(:, triangles(2, i)), points(:, triangles(3, i)))
    end do
    call find_normals(shape, size(points, 2), triangles)
    shape%edge = edge
    shape%origin = shape%low - 2.5_rp*edge
    shape%n = ceiling((shape%high - shape%low)/edge) + 5
    call fill_cells(shape)
    call find_sides(shape)
  end function make_closed_surface

  !> Finds the normals of faces, edges and points; those of edges and points are means over the faces that meet there.
  subroutine find_normals(self, n_points, triangles)
    type(closed_surface_t), intent(inout) :: self
    integer, intent(in) :: n_points, triangles(:, :)
    integer, parameter :: FROM(3) = [1, 1, 2], UPTO(3) = [2, 3, 3]
    real(rp), allocatable :: at_points(:, :)
    integer, allocatable :: first(:), next(:), other(:), owner(:)
    integer :: i, k, e, n, low
    allocate (self%normals(3, 7, size(triangles, 2)), at_points(3, n_points), source=0.0_rp)
    allocate (first(n_points), next(3*size(triangles, 2)), other(3*size(triangles, 2)), owner(3*size(triangles, 2)))
    first = 0
    n = 0
    do i = 1, size(triangles, 2)
      associate (t => self%triangles(i), c => triangles(:, i))
        self%normals(:, 1, i) = t%normal
        at_points(:, c(1)) = at_points(:, c(1)) + angle(t%ab, t%ac)*t%normal
        at_points(:, c(2)) = at_points(:, c(2)) + angle(-t%ab, t%bc)*t%normal
        at_points(:, c(3)) = at_points(:, c(3)) + angle(t%ac, t%bc)*t%normal
        do k = 1, 3
          low = min(c(FROM(k)), c(UPTO(k)))
          e = first(low)
          do while (e > 0)
            if (other(e) == max(c(FROM(k)), c(UPTO(k)))) exit
            e = next(e)
          end do
          if (e == 0) then
            n = n + 1
            other(n) = max(c(FROM(k)), c(UPTO(k)))
            owner(n) = 8*i + k
            next(n) = first(low)
            first(low) = n
          else
            associate (neighbour => owner(e)/8, side => mod(owner(e), 8))
              self%normals(:, 1 + k, i) = t%normal + self%triangles(neighbour)%normal
              self%normals(:, 1 + side, neighbour) = self%normals(:, 1 + k, i)
            end associate
          end if
        end do
      end associate
    end do
    do i = 1, size(triangles, 2)
      self%normals(:, 5:7, i) = at_points(:, triangles(:, i))
    end do
  end subroutine find_normals

  !> Returns the angle between two vectors [rad].
  pure real(rp) function angle(a, b)
    real(rp), intent(in) :: a(3), b(3)
    angle = atan2(norm2(cross(a, b)), dot_product(a, b))
  end function angle

  !> Lists the triangles of each cell in two rounds over all triangles: the first counts, the second writes.
  subroutine fill_cells(self)
    type(closed_surface_t), intent(inout) :: self
    integer, allocatable :: filled(:)
    real(rp) :: reach, low(3), high(3), d2, v, w
    integer :: round, t, i, j, k, c, first(3), last(3)
    reach = 3*HALF_DIAGONAL*self%edge*(1 + TOUCHES)
    allocate (filled(product(self%n)), source=0)
    allocate (self%first(product(self%n) + 1), source=1)
    do round = 1, 2
      do t = 1, size(self%triangles)
        associate (shape => self%triangles(t))
          low = min(shape%a, shape%a + shape%ab, shape%a + shape%ac) - reach
          high = max(shape%a, shape%a + shape%ab, shape%a + shape%ac) + reach
          first = max(1, floor((low - self%origin)/self%edge) + 1)
          last = min(self%n, floor((high - self%origin)/self%edge) + 1)
          do k = first(3), last(3)
            do j = first(2), last(2)
              do i = first(1), last(1)
                call shape%closest(middle(self, i, j, k), d2, v, w)
                if (d2 > reach**2) cycle
                c = cell(self, i, j, k)
                if (round == 2) self%list(self%first(c) + filled(c)) = t
                filled(c) = filled(c) + 1
              end do
            end do
          end do
        end associate
      end do
      if (round == 2) exit
      do c = 1, size(filled)
        self%first(c + 1) = self%first(c) + filled(c)
      end do
      allocate (self%list(self%first(size(self%first)) - 1))
      filled = 0
    end do
  end subroutine fill_cells

  !> Finds which cells are wholly inside (-1) or outside (1); 0 where the surface may cross a cell.
  subroutine find_sides(self)
    type(closed_surface_t), intent(inout) :: self
    real(rp) :: d
    integer :: i, j, k, c, side
    allocate (self%sides(product(self%n)), source=0)
    do k = 1, self%n(3)
      do j = 1, self%n(2)
        side = 1
        do i = 1, self%n(1)
          c = cell(self, i, j, k)
          if (self%first(c + 1) > self%first(c)) then
            d = nearest_level(self, c, middle(self, i, j, k))
            side = merge(-1, 1, d < 0)
            if (abs(d) > HALF_DIAGONAL*self%edge) self%sides(c) = side
          else
            self%sides(c) = side
          end if
        end do
      end do
    end do
  end subroutine find_sides

  !> Returns the number of cell (i, j, k).
  pure integer function cell(self, i, j, k)
    type(closed_surface_t), intent(in) :: self
    integer, intent(in) :: i, j, k
    cell = i + self%n(1)*(j - 1 + self%n(2)*(k - 1))
  end function cell

  !> Returns the centre of cell (i, j, k).
  pure function middle(self, i, j, k) result(x)
    type(closed_surface_t), intent(in) :: self
    integer, intent(in) :: i, j, k
    real(rp) :: x(3)
    x = self%origin + ([i, j, k] - 0.5_rp)*self%edge
  end function middle

  !> Returns the signed distance from the nearest triangle of a cell that has some.
  pure real(rp) function nearest_level(self, c, x) result(level)
    type(closed_surface_t), intent(in) :: self
    integer, intent(in) :: c
    real(rp), intent(in) :: x(3)
    real(rp) :: best, d2, v, w, best_v, best_w, arm(3)
    integer :: i, t
    best = huge(best)
    t = self%list(self%first(c))
    best_v = 0
    best_w = 0
    do i = self%first(c), self%first(c + 1) - 1
      call self%triangles(self%list(i))%closest(x, d2, v, w)
      if (d2 >= best) cycle
      best = d2
      best_v = v
      best_w = w
      t = self%list(i)
    end do
    associate (shape => self%triangles(t))
      arm = x - shape%a - best_v*shape%ab - best_w*shape%ac
    end associate
    level = sign(sqrt(best), dot_product(arm, self%normals(:, feature(best_v, best_w), t)))
  end function nearest_level

  !> Returns which normal counts at the place (v, w) of a triangle.
  pure integer function feature(v, w)
    real(rp), intent(in) :: v, w
    logical :: on(3) ! ab, ac, bc
    on = [w <= TOUCHES, v <= TOUCHES, v + w >= 1 - TOUCHES]
    feature = 1
    if (on(1)) feature = 2
    if (on(2)) feature = 3
    if (on(3)) feature = 4
    if (on(1) .and. on(2)) feature = 5
    if (on(1) .and. on(3)) feature = 6
    if (on(2) .and. on(3)) feature = 7
  end function feature

  !> Returns the signed distance [L] of x from the surface, negative inside; far from it only the sign is right.
  pure real(rp) function surface_level(self, x) result(level)
    class(closed_surface_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    integer :: i(3), c
    i = floor((x - self%origin)/self%edge) + 1
    level = huge(level)
    if (any(i < 1 .or. i > self%n)) return
    c = cell(self, i(1), i(2), i(3))
    if (self%first(c + 1) == self%first(c)) then
      level = sign(huge(level), real(self%sides(c), rp))
    else
      level = nearest_level(self, c, x)
      if (self%sides(c) /= 0) level = sign(level, real(self%sides(c), rp))
    end if
  end function surface_level
end module fsi_closed_surface

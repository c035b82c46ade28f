! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists the edges of a triangulation, each once, with the triangles on both sides.
module solid_edges
  implicit none
  private
  public :: edges_t, make_edges

  !> Edges sorted by their lower, then by their higher point.
  type :: edges_t
    integer :: n = 0
    integer, allocatable :: nodes(:, :)     !< (2, n) lower and higher point
    integer, allocatable :: triangles(:, :) !< (2, n) neighbours; the second is 0 on the boundary
    integer, allocatable :: apexes(:, :)    !< (2, n) points of these triangles opposite the edge
    integer, allocatable :: start(:)        !< (n_points + 1) first edge of every lower point
  contains
    procedure :: find => edges_find
  end type edges_t

contains

  !> Finds the edges of triangles(3, m) on n_points points. At most two triangles may share an edge. (If there are more, two are
  !> kept; the reader of wing files refuses such meshes.)
  function make_edges(n_points, triangles) result(self)
    integer, intent(in) :: n_points, triangles(:, :)
    type(edges_t) :: self
    integer, allocatable :: sides(:, :), order(:), first(:), begin(:)
    integer :: t, c, s, i, lower, n_sides, place
    n_sides = 3*size(triangles, 2)
    allocate (sides(4, n_sides), order(n_sides), first(n_points + 2), source=0)
    do t = 1, size(triangles, 2)
      do c = 1, 3
        s = 3*t - 3 + c
        associate (a => triangles(mod(c, 3) + 1, t), b => triangles(mod(c + 1, 3) + 1, t))
          sides(:, s) = [min(a, b), max(a, b), t, triangles(c, t)]
        end associate
        first(sides(1, s) + 2) = first(sides(1, s) + 2) + 1
      end do
    end do
    first(1:2) = 1
    do i = 3, n_points + 2
      first(i) = first(i) + first(i - 1)
    end do
    begin = first
    do s = 1, n_sides ! into the bucket of the lower point, sorted by the higher one
      lower = sides(1, s)
      place = first(lower + 1)
      first(lower + 1) = place + 1
      do while (place > begin(lower + 1))
        if (sides(2, order(place - 1)) <= sides(2, s)) exit
        order(place) = order(place - 1)
        place = place - 1
      end do
      order(place) = s
    end do
    allocate (self%nodes(2, n_sides), self%triangles(2, n_sides), self%apexes(2, n_sides), source=0)
    allocate (self%start(n_points + 1), source=0)
    do i = 1, n_sides
      s = order(i)
      if (self%n > 0) then
        if (all(self%nodes(:, self%n) == sides(1:2, s))) then
          self%triangles(2, self%n) = sides(3, s)
          self%apexes(2, self%n) = sides(4, s)
          cycle
        end if
      end if
      self%n = self%n + 1
      self%nodes(:, self%n) = sides(1:2, s)
      self%triangles(1, self%n) = sides(3, s)
      self%apexes(1, self%n) = sides(4, s)
      self%start(sides(1, s) + 1) = self%start(sides(1, s) + 1) + 1
    end do
    self%start(1) = 1
    do i = 2, n_points + 1
      self%start(i) = self%start(i) + self%start(i - 1)
    end do
    self%nodes = self%nodes(:, :self%n)
    self%triangles = self%triangles(:, :self%n)
    self%apexes = self%apexes(:, :self%n)
  end function make_edges

  !> Returns the number of the edge between two points, 0 if there is none.
  pure integer function edges_find(self, a, b) result(edge)
    class(edges_t), intent(in) :: self
    integer, intent(in) :: a, b
    integer :: e
    edge = 0
    if (max(a, b) > size(self%start) - 1) return
    do e = self%start(min(a, b)), self%start(min(a, b) + 1) - 1
      if (self%nodes(2, e) == max(a, b)) edge = e
    end do
  end function edges_find
end module solid_edges

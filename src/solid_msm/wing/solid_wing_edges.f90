! SPDX-License-Identifier: GPL-3.0-or-later
!> Keeps pairs of points (edges of triangles, segments of veins) in sorted order, so that equal pairs are neighbours and a search
!> takes O(log n).
module solid_wing_edges
  use base_kinds, only: i8
  use base_sort, only: sorting_order
  implicit none
  private
  public :: edge_table_t, triangle_edges, vein_segments

  !> Directed pairs (from, to), sorted by from and then to; `owner` says whose pair it is.
  type :: edge_table_t
    integer, allocatable :: from(:), to(:), owner(:)
  contains
    procedure :: sort => table_sort
    procedure :: find => table_find
    procedure :: has_edge => table_has_edge
  end type edge_table_t

contains

  !> Returns the 3 m directed edges of triangles(3, m). The owner of an edge is its triangle.
  pure function triangle_edges(triangles) result(table)
    integer, intent(in) :: triangles(:, :)
    type(edge_table_t) :: table
    integer :: t, k, e
    e = 3*size(triangles, 2)
    allocate (table%from(e), table%to(e), table%owner(e))
    e = 0
    do t = 1, size(triangles, 2)
      do k = 1, 3
        e = e + 1
        table%from(e) = triangles(k, t)
        table%to(e) = triangles(mod(k, 3) + 1, t)
        table%owner(e) = t
      end do
    end do
    call table%sort()
  end function triangle_edges

  !> Returns the segments between neighbours in chains of points, the smaller point first. Chain c is
  !> nodes(first(c):first(c+1)-1), and the owner of a segment is its chain.
  pure function vein_segments(nodes, first) result(table)
    integer, intent(in) :: nodes(:), first(:)
    type(edge_table_t) :: table
    integer :: c, i, e
    e = 0
    do c = 1, size(first) - 1
      e = e + max(0, first(c + 1) - first(c) - 1)
    end do
    allocate (table%from(e), table%to(e), table%owner(e))
    e = 0
    do c = 1, size(first) - 1
      do i = first(c), first(c + 1) - 2
        e = e + 1
        table%from(e) = min(nodes(i), nodes(i + 1))
        table%to(e) = max(nodes(i), nodes(i + 1))
        table%owner(e) = c
      end do
    end do
    call table%sort()
  end function vein_segments

  !> Returns the index of the first pair (from, to), 0 if there is none.
  pure integer function table_find(self, from, to) result(found)
    class(edge_table_t), intent(in) :: self
    integer, intent(in) :: from, to
    integer :: low, high, middle
    low = 1
    high = size(self%from)
    do while (low <= high)
      middle = low + (high - low)/2
      if (key(self%from(middle), self%to(middle)) < key(from, to)) then
        low = middle + 1
      else
        high = middle - 1
      end if
    end do
    found = 0
    if (low > size(self%from)) return
    if (self%from(low) == from .and. self%to(low) == to) found = low
  end function table_find

  !> Tells whether the table has the pair in either direction.
  pure logical function table_has_edge(self, a, b) result(has)
    class(edge_table_t), intent(in) :: self
    integer, intent(in) :: a, b
    has = self%find(a, b) > 0
    if (.not. has) has = self%find(b, a) > 0
  end function table_has_edge

  !> Returns a number that is different for each pair of points.
  pure elemental integer(i8) function key(from, to)
    integer, intent(in) :: from, to
    key = int(from, i8)*2147483648_i8 + int(to, i8)
  end function key

  !> Sorts the pairs. Equal ones keep their order.
  pure subroutine table_sort(self)
    class(edge_table_t), intent(inout) :: self
    integer, allocatable :: order(:)
    order = sorting_order(key(self%from, self%to))
    self%from = self%from(order)
    self%to = self%to(order)
    self%owner = self%owner(order)
  end subroutine table_sort
end module solid_wing_edges

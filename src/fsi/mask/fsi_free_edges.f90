! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the free edge of a triangulated sheet.
module fsi_free_edges
  implicit none
  private
  public :: find_free_edges

contains

  !> Finds the edges (2, m) that belong to one triangle only, as pairs of points (from, to), in the orientation of their triangle: a
  !> sheet of counter-clockwise triangles lies on their left. They are in the order of the triangles. `owners` (m) are the numbers
  !> of these triangles.
  pure subroutine find_free_edges(n_points, triangles, edges, owners)
    integer, intent(in) :: n_points
    integer, intent(in) :: triangles(:, :) !< (3, :)
    integer, allocatable, intent(out) :: edges(:, :)
    integer, allocatable, intent(out), optional :: owners(:)
    integer, allocatable :: first(:), next(:), ends(:, :), of(:)
    logical, allocatable :: is_free(:)
    integer :: i, k, e, n, low, from, to
    ! The edges form a linked list at their lower point.
    allocate (first(n_points), source=0)
    allocate (next(3*size(triangles, 2)), ends(2, 3*size(triangles, 2)), is_free(3*size(triangles, 2)))
    allocate (of(3*size(triangles, 2)))
    n = 0
    do i = 1, size(triangles, 2)
      do k = 1, 3
        from = triangles(k, i)
        to = triangles(mod(k, 3) + 1, i)
        low = min(from, to)
        e = first(low)
        do while (e > 0)
          if (maxval(ends(:, e)) == max(from, to)) exit
          e = next(e)
        end do
        if (e > 0) then
          is_free(e) = .false.
        else
          n = n + 1
          ends(:, n) = [from, to]
          of(n) = i
          is_free(n) = .true.
          next(n) = first(low)
          first(low) = n
        end if
      end do
    end do
    allocate (edges(2, count(is_free(:n))))
    k = 0
    do e = 1, n
      if (.not. is_free(e)) cycle
      k = k + 1
      edges(:, k) = ends(:, e)
    end do
    if (present(owners)) owners = pack(of(:n), is_free(:n))
  end subroutine find_free_edges
end module fsi_free_edges

! SPDX-License-Identifier: GPL-3.0-or-later
!> Meshes a planform with triangles, structured in span and chord.
!>
!> Rows of points run along the chord. From row to row the longer one of leading and trailing edge advances by one edge length, so
!> that round tips are resolved. A row has as many intervals as its chord has edge lengths; a pointed end has one point.
!> Neighbouring rows are joined in the order of their points along the chord. The mesh meets the outline to second order in the edge
!> length.
module fsi_planform_mesh
  use base_errors, only: require
  use base_kinds, only: rp
  use fsi_planform, only: planform_t
  implicit none
  private
  public :: triangulate_planform, triangulate_star

  integer, parameter :: SAMPLES = 4000          !< places where the edges are looked up
  real(rp), parameter :: POINTED = 1.0e-2_rp    !< chord in edge lengths below which an end is a point

contains

  !> Returns points (3, n) with z = 0 and triangles (3, m), counter-clockwise seen from +z. Every x of the planform must have one
  !> chord. Lengths are in L.
  subroutine triangulate_planform(planform, edge, points, triangles)
    type(planform_t), intent(in) :: planform
    real(rp), intent(in) :: edge !< wanted length of the triangles' edges
    real(rp), allocatable, intent(out) :: points(:, :)
    integer, allocatable, intent(out) :: triangles(:, :)
    real(rp), allocatable :: x(:), trailing(:), leading(:)
    integer, allocatable :: intervals(:), first(:)
    integer :: i, j, n_rows, filled, crossings
    call require(edge > 0, 'triangulate_planform: the edge length must be positive')
    call place_rows(planform, edge, x)
    n_rows = size(x)
    allocate (trailing(n_rows), leading(n_rows), intervals(n_rows), first(n_rows + 1))
    first(1) = 1
    do i = 1, n_rows
      call planform%chord_at(x(i), trailing(i), leading(i), crossings)
      call require(crossings == 2, 'triangulate_planform: the outline has several chords at one x')
      intervals(i) = max(1, nint((leading(i) - trailing(i))/edge))
      if ((i == 1 .or. i == n_rows) .and. leading(i) - trailing(i) < POINTED*edge) intervals(i) = 0
      first(i + 1) = first(i) + intervals(i) + 1
    end do
    allocate (points(3, first(n_rows + 1) - 1))
    do i = 1, n_rows
      do j = 0, intervals(i)
        points(:, first(i) + j) = [x(i), trailing(i) + (leading(i) - trailing(i))*j/max(1, intervals(i)), 0.0_rp]
      end do
    end do
    allocate (triangles(3, sum(intervals(1:n_rows - 1) + intervals(2:n_rows))))
    filled = 0
    do i = 1, n_rows - 1
      call join_rows(first(i), intervals(i), first(i + 1), intervals(i + 1), triangles, filled)
    end do
  end subroutine triangulate_planform

  !> Finds the positions of the rows, at equal steps along the longer edge, both ends included.
  subroutine place_rows(planform, edge, x)
    type(planform_t), intent(in) :: planform
    real(rp), intent(in) :: edge
    real(rp), allocatable, intent(out) :: x(:)
    real(rp) :: span(2), trailing, leading, old(2), place, wanted, dx
    real(rp) :: advanced(0:SAMPLES)
    integer :: i, k, n, crossings
    span = planform%span()
    dx = (span(2) - span(1))/SAMPLES
    advanced(0) = 0
    call planform%chord_at(span(1), old(1), old(2), crossings)
    do i = 1, SAMPLES
      call planform%chord_at(span(1) + i*dx, trailing, leading, crossings)
      advanced(i) = advanced(i - 1) + max(hypot(dx, trailing - old(1)), hypot(dx, leading - old(2)))
      old = [trailing, leading]
    end do
    n = max(1, nint(advanced(SAMPLES)/edge))
    allocate (x(n + 1))
    x(1) = span(1)
    x(n + 1) = span(2)
    i = 1
    do k = 1, n - 1
      wanted = advanced(SAMPLES)*k/n
      do while (advanced(i) < wanted)
        i = i + 1
      end do
      place = (wanted - advanced(i - 1))/(advanced(i) - advanced(i - 1))
      x(k + 1) = span(1) + (i - 1 + place)*dx
    end do
  end subroutine place_rows

  !> Joins the row of n_a intervals from point a with the next one toward the tip, of n_b intervals from b.
  subroutine join_rows(a, n_a, b, n_b, triangles, filled)
    integer, intent(in) :: a, n_a, b, n_b
    integer, intent(inout) :: triangles(:, :), filled
    integer :: i, j
    logical :: on_a
    i = 0
    j = 0
    do while (i < n_a .or. j < n_b)
      on_a = j == n_b
      if (i < n_a .and. j < n_b) on_a = (i + 1)*n_b <= (j + 1)*n_a
      filled = filled + 1
      if (on_a) then
        triangles(:, filled) = [a + i, b + j, a + i + 1]
        i = i + 1
      else
        triangles(:, filled) = [a + i, b + j, b + j + 1]
        j = j + 1
      end if
    end do
  end subroutine join_rows

  !> Returns triangles of an outline that is visible from its Fourier centre everywhere, although some x crosses it more than
  !> twice: rings around this centre, counter-clockwise seen from +z. Allocates.
  subroutine triangulate_star(planform, edge, points, triangles)
    type(planform_t), intent(in) :: planform
    real(rp), intent(in) :: edge
    real(rp), allocatable, intent(out) :: points(:, :)
    integer, allocatable, intent(out) :: triangles(:, :)
    real(rp) :: centre(2), reach, turn
    integer :: n_rays, n_rings, n, ray, ring, next, k
    call require(allocated(planform%fourier%ai), 'triangulate_star: the outline has no centre')
    centre = planform%fourier%centre([2, 1])
    n = size(planform%outline, 2)
    reach = maxval(norm2(planform%outline - spread(centre, 2, n), 1))
    n_rings = max(2, ceiling(reach/edge))
    n_rays = min(n, max(24, ceiling(2*acos(-1.0_rp)*reach/edge)))
    allocate (points(3, 1 + n_rings*n_rays), triangles(3, n_rays*(2*n_rings - 1)))
    points(:, 1) = [centre, 0.0_rp]
    do ray = 1, n_rays
      k = 1 + (n*(ray - 1))/n_rays
      do ring = 1, n_rings
        points(:, place(ring, ray)) = [centre + (planform%outline(:, k) - centre)*(real(ring, rp)/n_rings), 0.0_rp]
      end do
    end do
    n = 0
    do ray = 1, n_rays
      next = mod(ray, n_rays) + 1
      n = n + 1
      triangles(:, n) = [1, place(1, ray), place(1, next)]
      do ring = 2, n_rings
        triangles(:, n + 1) = [place(ring - 1, ray), place(ring, ray), place(ring, next)]
        triangles(:, n + 2) = [place(ring - 1, ray), place(ring, next), place(ring - 1, next)]
        n = n + 2
      end do
    end do
    associate (a => points(:, 1), b => points(:, triangles(2, 1)), c => points(:, triangles(3, 1)))
      turn = (b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1))
    end associate
    if (turn < 0) triangles(2:3, :) = triangles([3, 2], :)

  contains

    pure integer function place(ring, ray)
      integer, intent(in) :: ring, ray
      place = 1 + ring + n_rings*(ray - 1)
    end function place
  end subroutine triangulate_star
end module fsi_planform_mesh

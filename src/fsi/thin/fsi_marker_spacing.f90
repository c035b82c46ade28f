! SPDX-License-Identifier: GPL-3.0-or-later
!> Places markers about a spacing h apart on a triangulated sheet, its free edges included.
!>
!> The aim is that no two markers are closer than LEAST h and that no point of the sheet is farther than LEAST h from one. If no
!> point can be added to a set without violating the first condition, the set satisfies the second (Eldar et al. 1997, DOI
!> 10.1109/83.623193), for any shape. All distances are measured in space, so that both sides of a slit count as one line. The edges
!> come first (fsi_marker_lines). The interior is filled from the edges like a growing crystal, each marker next to two others.
!> Lloyd's method then moves the inner markers to the centres of their Voronoi cells (Du, Faber & Gunzburger 1999, DOI
!> 10.1137/S0036144599352836). Finally markers that are too close are removed, and missing markers are added.
module fsi_marker_spacing
  use base_kinds, only: rp
  use fsi_free_edges, only: find_free_edges
  use fsi_marker_cloud, only: cloud_t, FREE_EDGE, FRONT, GAP, site_on_edge, site_t
  use fsi_marker_lines, only: line_site_t, place_on_lines
  implicit none
  private
  public :: place_sheet_markers

  real(rp), parameter :: LEAST = 0.75_rp         !< of h, least distance and largest gap
  real(rp), parameter :: SAME = 1.0e-9_rp        !< of h; smaller differences count as 0
  real(rp), parameter :: GROWTH = 0.95_rp        !< of h, distance of the growing front
  integer, parameter :: ROUNDS = 6, SWEEPS = 20  !< of Lloyd's method, at most, and in a round
  integer, parameter :: UNACCELERATED = 5                !< the last sweeps of a round are not accelerated
  real(rp), parameter :: SPEED = 1.7_rp

contains

  !> Places the markers of a sheet; the first `n_edge` lie on free edges. `left_out` counts corners and other sites of the outline
  !> that were left out because they are too close to others. `largest_gap`, in h, is the largest distance of sample points, 0.1 h
  !> apart, from a marker. Deterministic. Allocates.
  subroutine place_sheet_markers(points, triangles, spacing, sites, n_edge, left_out, largest_gap)
    real(rp), intent(in) :: points(:, :)   !< (3, n) L
    integer, intent(in) :: triangles(:, :) !< (3, m)
    real(rp), intent(in) :: spacing        !< h [L]
    type(site_t), allocatable, intent(out) :: sites(:)
    integer, intent(out) :: n_edge
    integer, intent(out) :: left_out(2)
    real(rp), intent(out) :: largest_gap
    type(cloud_t) :: cloud
    type(site_t), allocatable :: outline(:)
    integer, allocatable :: edges(:, :), owners(:)
    logical, allocatable :: is_corner(:), keep(:)
    integer :: round, n
    call find_free_edges(size(points, 2), triangles, edges, owners)
    call cloud%init(points, triangles, edges, owners, spacing)
    call place_outline(points, triangles, edges, owners, spacing, outline, is_corner)
    keep = are_clear(outline, LEAST*spacing)
    left_out = [count(is_corner .and. .not. keep), count(.not. (is_corner .or. keep))]
    sites = pack(outline, keep)
    call cloud%clear()
    do n = 1, size(sites)
      call cloud%add(sites(n)%x)
    end do
    call fill_gaps(cloud, FREE_EDGE, LEAST*spacing, sites)
    n_edge = size(sites)
    call fill_gaps(cloud, FRONT, GROWTH*spacing, sites)
    do round = 1, ROUNDS
      call relax(cloud, points, triangles, n_edge, sites)
      keep = are_clear(sites, LEAST*spacing)
      sites = pack(sites, keep)
      call cloud%clear()
      do n = 1, size(sites)
        call cloud%add(sites(n)%x)
      end do
      n = size(sites)
      call fill_gaps(cloud, GAP, LEAST*spacing, sites)
      if (all(keep) .and. size(sites) == n) exit
    end do
    largest_gap = maxval(cloud%distance)/spacing
  end subroutine place_sheet_markers

  !> Returns the requested sites on the free edges, corners first.
  subroutine place_outline(points, triangles, edges, owners, spacing, sites, is_corner)
    real(rp), intent(in) :: points(:, :), spacing
    integer, intent(in) :: triangles(:, :), edges(:, :), owners(:)
    type(site_t), allocatable, intent(out) :: sites(:)
    logical, allocatable, intent(out) :: is_corner(:)
    type(line_site_t), allocatable :: on_line(:)
    integer :: i
    call place_on_lines(points, edges, spacing, on_line)
    allocate (sites(size(on_line)))
    do i = 1, size(on_line)
      associate (e => on_line(i)%link)
        sites(i) = site_on_edge(points, triangles(:, owners(e)), edges(:, e), on_line(i)%fraction)
      end associate
    end do
    is_corner = on_line%is_corner
  end subroutine place_outline

  !> Tells which places are at least `limit` [L] from all earlier accepted ones.
  pure function are_clear(sites, limit)
    type(site_t), intent(in) :: sites(:)
    real(rp), intent(in) :: limit
    logical :: are_clear(size(sites))
    real(rp) :: x(3, size(sites))
    integer :: i, n
    n = 0
    do i = 1, size(sites)
      are_clear(i) = is_clear(sites(i)%x, x(:, :n), limit*(1 - SAME))
      if (.not. are_clear(i)) cycle
      n = n + 1
      x(:, n) = sites(i)%x
    end do
  end function are_clear

  !> Tells whether a place is at least `limit` from all others.
  pure logical function is_clear(x, others, limit)
    real(rp), intent(in) :: x(3), others(:, :), limit
    integer :: i
    is_clear = .false.
    do i = 1, size(others, 2)
      if ((others(1, i) - x(1))**2 + (others(2, i) - x(2))**2 + (others(3, i) - x(3))**2 < limit**2) return
    end do
    is_clear = .true.
  end function is_clear

  !> Adds the places that the cloud picks until it finds none.
  subroutine fill_gaps(cloud, mode, limit, sites)
    type(cloud_t), intent(inout) :: cloud
    integer, intent(in) :: mode
    real(rp), intent(in) :: limit
    type(site_t), allocatable, intent(inout) :: sites(:)
    type(site_t), allocatable :: larger(:)
    type(site_t) :: site
    logical :: found
    integer :: n
    n = size(sites)
    call cloud%search_for(mode, limit)
    do
      call cloud%pick(site, found)
      if (.not. found) exit
      if (n == size(sites)) then
        allocate (larger(2*n + 16))
        larger(:n) = sites
        call move_alloc(larger, sites)
      end if
      n = n + 1
      sites(n) = site
      call cloud%add(site%x)
    end do
    sites = sites(:n)
  end subroutine fill_gaps

  !> Does a round of Lloyd's method for all markers but the first `n_fixed`.
  subroutine relax(cloud, points, triangles, n_fixed, sites)
    type(cloud_t), intent(inout) :: cloud
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: triangles(:, :), n_fixed
    type(site_t), intent(inout) :: sites(:)
    real(rp) :: x(3, size(sites))
    integer :: i
    do i = 1, size(sites)
      x(:, i) = sites(i)%x
    end do
    do i = 1, SWEEPS
      call cloud%relax(x, n_fixed, merge(SPEED, 1.0_rp, i <= SWEEPS - UNACCELERATED))
    end do
    call cloud%project(points, triangles, x, n_fixed, sites)
  end subroutine relax
end module fsi_marker_spacing

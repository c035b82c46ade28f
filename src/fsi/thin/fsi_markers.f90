! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the markers of a wing without thickness: sites on its mid surface about a spacing h apart, free edges included. They are
!> interpolated from the points of their triangles.
!>
!> A marker moves with its triangle, x = sum_k weights(k) points(:, nodes(k)); in a plane flow it is a line across a strip
!> (fsi_marker_section). The response of the flow to forces at markers (fsi_marker_response) is well conditioned as long as no two
!> markers are much closer than two grid spacings. The flow passes between markers that are much farther apart. `least` and `gap`
!> measure how well the markers cover a wing.
module fsi_markers
  use base_kinds, only: rp
  use fsi_marker_cloud, only: site_t
  use fsi_marker_section, only: place_section_markers, station_t
  use fsi_marker_spacing, only: place_sheet_markers
  implicit none
  private
  public :: markers_t

  type :: markers_t
    integer :: n = 0
    integer, allocatable :: nodes(:, :)    !< (k, n) points of the wing; k = 3 but for strips
    real(rp), allocatable :: weights(:, :) !< (k, n) not negative, of sum 1
    logical, allocatable :: is_edge(:)     !< (n) on a free edge; of a strip: at an end
    integer :: left_out = 0 !< places of the outline without a marker, since others are too close
    real(rp) :: least = 0  !< distance of the closest two, over h
    real(rp) :: gap = 0    !< largest distance of any point of the wing from its nearest marker, over h
  contains
    procedure :: init => markers_init
    procedure :: positions => markers_positions
    procedure :: spread => markers_spread
  end type markers_t

contains

  !> Places markers about `spacing` [L] apart on the sheet of triangles(3, m) between points(3, np) [L]. With `is_2d` the
  !> sheet is a strip whose width lies along y, and a plane flow sees its section. Deterministic: the same on every rank.
  !> Allocates.
  subroutine markers_init(self, points, triangles, spacing, is_2d)
    class(markers_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :), spacing
    integer, intent(in) :: triangles(:, :)
    logical, intent(in) :: is_2d
    real(rp), allocatable :: x(:, :)
    integer :: i, j
    if (is_2d) then
      call place_stations(self, points, triangles, spacing)
    else
      call place_in_triangles(self, points, triangles, spacing)
    end if
    allocate (x(3, self%n))
    call self%positions(points, x)
    self%least = huge(1.0_rp)
    do i = 1, self%n
      do j = 1, i - 1
        self%least = min(self%least, norm2(x(:, i) - x(:, j))/spacing)
      end do
    end do
  end subroutine markers_init

  !> Places the markers of a wing that is a surface.
  subroutine place_in_triangles(self, points, triangles, spacing)
    type(markers_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :), spacing
    integer, intent(in) :: triangles(:, :)
    type(site_t), allocatable :: sites(:)
    integer :: i, left_out(2), n_edge
    call place_sheet_markers(points, triangles, spacing, sites, n_edge, left_out, self%gap)
    self%n = size(sites)
    self%left_out = sum(left_out)
    self%is_edge = [(i <= n_edge, i=1, self%n)]
    self%nodes = reshape([(sites(i)%nodes, i=1, self%n)], [3, self%n])
    self%weights = reshape([(sites(i)%weights, i=1, self%n)], [3, self%n])
  end subroutine place_in_triangles

  !> Places the markers of a wing that is a section, in two dimensions.
  subroutine place_stations(self, points, triangles, spacing)
    type(markers_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :), spacing
    integer, intent(in) :: triangles(:, :)
    type(station_t), allocatable :: stations(:)
    integer :: i, k, left_out(2)
    call place_section_markers(points, triangles, spacing, stations, left_out, self%gap)
    self%n = size(stations)
    self%left_out = sum(left_out)
    self%is_edge = stations%is_edge
    k = maxval([(size(stations(i)%nodes), i=1, self%n)])
    if (allocated(self%nodes)) deallocate (self%nodes, self%weights)
    allocate (self%nodes(k, self%n), self%weights(k, self%n))
    self%weights = 0
    do i = 1, self%n
      k = size(stations(i)%nodes)
      self%nodes(:, i) = stations(i)%nodes(1)
      self%nodes(:k, i) = stations(i)%nodes
      self%weights(:k, i) = stations(i)%weights
    end do
  end subroutine place_stations

  !> Interpolates `values` (3, np) at the points of the wing, positions or velocities, to the markers (3, n).
  pure subroutine markers_positions(self, values, at_markers)
    class(markers_t), intent(in) :: self
    real(rp), intent(in) :: values(:, :)
    real(rp), intent(inout) :: at_markers(:, :)
    integer :: m, k
    do m = 1, self%n
      at_markers(:, m) = self%weights(1, m)*values(:, self%nodes(1, m))
      do k = 2, size(self%nodes, 1)
        at_markers(:, m) = at_markers(:, m) + self%weights(k, m)*values(:, self%nodes(k, m))
      end do
    end do
  end subroutine markers_positions

  !> Adds to forces(3, np) on the points the forces that are equivalent to given forces (3, n) at the markers. This is the transpose
  !> of `positions`.
  pure subroutine markers_spread(self, at_markers, forces)
    class(markers_t), intent(in) :: self
    real(rp), intent(in) :: at_markers(:, :)
    real(rp), intent(inout) :: forces(:, :)
    integer :: m, k
    do m = 1, self%n
      do k = 1, size(self%nodes, 1)
        forces(:, self%nodes(k, m)) = forces(:, self%nodes(k, m)) + self%weights(k, m)*at_markers(:, m)
      end do
    end do
  end subroutine markers_spread
end module fsi_markers

! SPDX-License-Identifier: GPL-3.0-or-later
!> The markers of a wing without thickness: places on its mid surface about a spacing h apart, free edges included, tied
!> to the points of the triangles that hold them.
!>
!> A marker moves with its triangle, x = sum_k weights(k) points(:, nodes(k)). The response of the flow to forces at
!> markers (fsi_marker_response) is well conditioned as long as no two are much closer than two grid spacings, and the
!> flow passes between markers that are much farther apart: `least` and `gap` tell how well a wing is covered.
module fsi_markers
  use base_kinds, only: rp
  use fsi_marker_cloud, only: place_t
  use fsi_marker_spacing, only: space_markers
  implicit none
  private
  public :: markers_t

  type :: markers_t
    integer :: n = 0
    integer, allocatable :: nodes(:, :)    !< (3, n) points of the wing
    real(rp), allocatable :: weights(:, :) !< (3, n) not negative, of sum 1
    integer :: n_edge = 0  !< markers 1 .. n_edge lie on free edges
    integer :: left_out = 0 !< places of the outline without a marker, since others are too close
    real(rp) :: least = 0  !< distance of the closest two, over h
    real(rp) :: gap = 0    !< distance from the nearest marker of the point of the wing that is farthest from any, over h
  contains
    procedure :: init => markers_init
    procedure :: positions => markers_positions
    procedure :: spread => markers_spread
  end type markers_t

contains

  !> Places markers about `spacing` [L] apart on the sheet of triangles(3, m) between points(3, np) [L]. Deterministic:
  !> the same on every rank. Allocates.
  subroutine markers_init(self, points, triangles, spacing)
    class(markers_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :), spacing
    integer, intent(in) :: triangles(:, :)
    type(place_t), allocatable :: places(:)
    integer :: i, j, left_out(2)
    call space_markers(points, triangles, spacing, places, self%n_edge, left_out, self%gap)
    self%n = size(places)
    self%left_out = sum(left_out)
    self%nodes = reshape([(places(i)%nodes, i=1, self%n)], [3, self%n])
    self%weights = reshape([(places(i)%weights, i=1, self%n)], [3, self%n])
    self%least = huge(1.0_rp)
    do i = 1, self%n
      do j = 1, i - 1
        self%least = min(self%least, norm2(places(i)%x - places(j)%x)/spacing)
      end do
    end do
  end subroutine markers_init

  !> Values (3, n) at the markers of what has `values` (3, np) at the points of the wing: places or velocities.
  pure subroutine markers_positions(self, values, at_markers)
    class(markers_t), intent(in) :: self
    real(rp), intent(in) :: values(:, :)
    real(rp), intent(inout) :: at_markers(:, :)
    integer :: m
    do m = 1, self%n
      at_markers(:, m) = self%weights(1, m)*values(:, self%nodes(1, m)) + &
                         self%weights(2, m)*values(:, self%nodes(2, m)) + self%weights(3, m)*values(:, self%nodes(3, m))
    end do
  end subroutine markers_positions

  !> Adds to forces(3, np) on the points what those (3, n) at the markers are worth: the transpose of `positions`.
  pure subroutine markers_spread(self, at_markers, forces)
    class(markers_t), intent(in) :: self
    real(rp), intent(in) :: at_markers(:, :)
    real(rp), intent(inout) :: forces(:, :)
    integer :: m, k
    do m = 1, self%n
      do k = 1, 3
        forces(:, self%nodes(k, m)) = forces(:, self%nodes(k, m)) + self%weights(k, m)*at_markers(:, m)
      end do
    end do
  end subroutine markers_spread
end module fsi_markers

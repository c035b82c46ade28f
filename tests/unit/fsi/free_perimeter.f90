! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures the free edges of a triangulated wing.
module free_perimeter
  use base_kinds, only: rp
  use fsi_free_edges, only: find_free_edges
  use fsi_surface, only: surface_t
  implicit none
  private
  public :: perimeter_of

contains

  !> Returns the length [L] of all edges that belong to one triangle only.
  real(rp) function perimeter_of(surface) result(length)
    type(surface_t), intent(in) :: surface
    integer, allocatable :: edges(:, :)
    integer :: e
    call find_free_edges(size(surface%points, 2), surface%triangles, edges)
    length = 0
    do e = 1, size(edges, 2)
      length = length + norm2(surface%points(:, edges(2, e)) - surface%points(:, edges(1, e)))
    end do
  end function perimeter_of
end module free_perimeter

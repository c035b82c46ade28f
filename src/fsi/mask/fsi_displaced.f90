! SPDX-License-Identifier: GPL-3.0-or-later
!> Distributes the fluid that a sheet displaces to the points of its surface.
!>
!> u_s in the mask is the velocity of the closest point of the surface (fsi_mask), so that for any flat sheet int chi f(closest
!> point) dV = t int f dA + (pi t^2/8) int f ds + (t^3/12) sum theta f, with ds along the free edge and theta the turning angle of
!> the free edge at its corners; the smoothing changes it by O(h^2). With f linear on triangles this is sum v_i f_i. The v_i belong
!> to the undeformed sheet and are kept when it bends.
module fsi_displaced
  use base_constants, only: PI
  use base_errors, only: require
  use base_kinds, only: rp
  use fsi_free_edges, only: find_free_edges
  use fsi_rotation, only: cross
  implicit none
  private
  public :: displaced_volumes

contains

  !> Returns the volumes v (n) [L^3] of the points of a sheet of thickness t [L]. All triangles have one orientation, and every free
  !> edge belongs to one triangle. With `is_section` they are the volumes of a strip along y in a two-dimensional flow, which sees
  !> its section: they include t along the sheet and the round ends, but neither sides nor corners. Allocates.
  subroutine displaced_volumes(points, triangles, thickness, volumes, is_section)
    real(rp), intent(in) :: points(:, :)   !< (3, n) L
    integer, intent(in) :: triangles(:, :) !< (3, m)
    real(rp), intent(in) :: thickness
    real(rp), allocatable, intent(out) :: volumes(:)
    logical, intent(in), optional :: is_section
    real(rp), allocatable :: normals(:, :), in(:, :), out(:, :)
    real(rp) :: normal(3), edge(3)
    integer, allocatable :: free(:, :)
    logical :: is_strip
    integer :: i, k
    is_strip = .false.
    if (present(is_section)) is_strip = is_section
    allocate (volumes(size(points, 2)), source=0.0_rp)
    allocate (normals(3, size(points, 2)), in(3, size(points, 2)), out(3, size(points, 2)), source=0.0_rp)
    do i = 1, size(triangles, 2)
      associate (c => triangles(:, i))
        normal = cross(points(:, c(2)) - points(:, c(1)), points(:, c(3)) - points(:, c(1)))/2
        volumes(c) = volumes(c) + thickness*norm2(normal)/3
        do k = 1, 3
          normals(:, c(k)) = normals(:, c(k)) + normal
        end do
      end associate
    end do
    call find_free_edges(size(points, 2), triangles, free)
    do i = 1, size(free, 2)
      associate (a => free(1, i), b => free(2, i))
        edge = points(:, b) - points(:, a)
        if (is_strip) edge = [0.0_rp, edge(2), 0.0_rp]
        volumes(a) = volumes(a) + PI*thickness**2/16*norm2(edge)
        volumes(b) = volumes(b) + PI*thickness**2/16*norm2(edge)
        out(:, a) = edge
        in(:, b) = edge
      end associate
    end do
    do i = 1, merge(0, size(points, 2), is_strip)
      if (norm2(in(:, i)) <= 0 .or. norm2(out(:, i)) <= 0) cycle
      volumes(i) = volumes(i) + thickness**3/12*atan2(dot_product(cross(in(:, i), out(:, i)), normals(:, i))/ &
                                                      norm2(normals(:, i)), dot_product(in(:, i), out(:, i)))
    end do
    ! At a sharp inward corner of a thick sheet the share of a point may be negative; only the sum of the volumes matters.
    call require(sum(volumes) > 0, 'displaced_volumes: a sheet without volume')
  end subroutine displaced_volumes
end module fsi_displaced

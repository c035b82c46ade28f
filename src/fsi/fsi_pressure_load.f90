! SPDX-License-Identifier: GPL-3.0-or-later
!> The load of the flow on a thin deforming surface: the difference of the static pressure between its sides.
!>
!> Both sides of every triangle are looked at beyond the smoothing layer of the mask, at a distance from the
!> sheet's mid surface along the present normal. The force (p_below - p_above) A n of a triangle, with its
!> present area, is shared equally by its corners, which is consistent for a constant difference.
module fsi_pressure_load
  use base_errors, only: require
  use base_kinds, only: rp
  use fsi_rotation, only: cross
  use fsi_sampling, only: sampler_t
  use fsi_surface, only: surface_t
  implicit none
  private
  public :: pressure_load_t

  !> Work space of one surface. Code units with density 1.
  type :: pressure_load_t
    real(rp), allocatable :: jump(:)     !< (m) p_above - p_below of the triangles; above is where n points
    real(rp), allocatable :: force(:, :) !< (3, n) force on the points, in space
    real(rp), allocatable, private :: places(:, :), pressure(:)
  contains
    procedure :: init => load_init
    procedure :: look => load_look
  end type pressure_load_t

contains

  !> Room for the triangles of `surface`; no load yet.
  subroutine load_init(self, surface)
    class(pressure_load_t), intent(inout) :: self
    type(surface_t), intent(in) :: surface
    integer :: m
    m = size(surface%triangles, 2)
    if (allocated(self%jump)) deallocate (self%jump, self%force, self%places, self%pressure)
    allocate (self%jump(m), self%places(3, 2*m), self%pressure(2*m), source=0.0_rp)
    allocate (self%force(3, size(surface%points, 2)), source=0.0_rp)
  end subroutine load_init

  !> Sets `jump` and `force` for the surface where it is now. `distance` [L] is that of the places looked at
  !> from the surface. Collective.
  subroutine load_look(self, surface, sampler, pressure, distance)
    class(pressure_load_t), intent(inout) :: self
    type(surface_t), intent(in) :: surface
    type(sampler_t), intent(in) :: sampler
    real(rp), contiguous, intent(in) :: pressure(:, :, :) !< (nx, ny_local, nz_local)
    real(rp), intent(in) :: distance
    real(rp) :: centre(3), twice_area(3), share(3)
    integer :: i, k, m
    m = size(surface%triangles, 2)
    call require(size(self%jump) == m, 'pressure_load_t: the surface has other triangles')
    do i = 1, m
      call look_at(surface, i, centre, twice_area)
      twice_area = twice_area/norm2(twice_area)
      self%places(:, i) = centre + distance*twice_area
      self%places(:, m + i) = centre - distance*twice_area
    end do
    call sampler%sample(self%places, pressure, self%pressure)
    self%jump = self%pressure(:m) - self%pressure(m + 1:)
    self%force = 0
    do i = 1, m
      call look_at(surface, i, centre, twice_area)
      share = -self%jump(i)/6*twice_area
      do k = 1, 3
        associate (p => surface%triangles(k, i))
          self%force(:, p) = self%force(:, p) + share
        end associate
      end do
    end do
  end subroutine load_look

  !> Centre and twice the area vector of triangle i.
  pure subroutine look_at(surface, i, centre, twice_area)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: i
    real(rp), intent(out) :: centre(3), twice_area(3)
    associate (a => surface%points(:, surface%triangles(1, i)), b => surface%points(:, surface%triangles(2, i)), &
               c => surface%points(:, surface%triangles(3, i)))
      centre = (a + b + c)/3
      twice_area = cross(b - a, c - a)
    end associate
  end subroutine look_at
end module fsi_pressure_load

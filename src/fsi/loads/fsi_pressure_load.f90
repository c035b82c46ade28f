! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the load of the flow on a thin deforming surface: the difference of the static pressure between its sides and, on
!> request, the viscous traction on both.
!>
!> The flow is sampled on both sides of every triangle beyond the smoothing layer of the mask, at a distance d from the mid
!> surface of the sheet along the present normal n. The force (p_below - p_above) A n of a triangle, with its present area, is
!> shared equally by its corners, which is consistent for a constant difference. The difference decreases with the distance: for
!> an accelerated plate of chord c, by 2 d/c to first order (potential flow). On request the pressure is sampled at 2 d as well
!> and extrapolated linearly to the mid surface.
!>
!> The traction on a side is nu w_t/(d - t/2). Here t/2 is the half thickness, where the mask is 1/2, and w_t is the tangential
!> velocity at the sampled place relative to the wall, which is continued to this place as a rigid body. This is the one-sided
!> difference along a normal probe (Vanella & Balaras 2009, J. Comput. Phys. 228, 6617, DOI 10.1016/j.jcp.2009.06.003). It is
!> exact for a flow that is linear between wall and place, and gives the mean of the shear there otherwise. The vorticity at the
!> place would give the shear at its far end, and is the less smooth field next to a penalized wall.
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
    real(rp), allocatable :: jump(:)        !< (m) p_above - p_below of the triangles; above is where n points
    real(rp), allocatable :: force(:, :)    !< (3, n) force on the points, in space
    real(rp), allocatable :: friction(:, :) !< (3, n) the viscous part of it; 0 if it was not asked for
    real(rp), allocatable, private :: sample_points(:, :), values(:), velocity(:, :)
  contains
    procedure :: init => load_init
    procedure :: select_lines => load_select_lines
    procedure :: sample => load_sample
    procedure :: show => load_show
    procedure :: add_friction => load_add_friction
  end type pressure_load_t

contains

  !> Makes room for the triangles of `surface`. There is no load yet.
  subroutine load_init(self, surface)
    class(pressure_load_t), intent(inout) :: self
    type(surface_t), intent(in) :: surface
    integer :: m, n
    m = size(surface%triangles, 2)
    n = size(surface%points, 2)
    if (allocated(self%jump)) deallocate (self%jump, self%force, self%friction, self%sample_points, self%values, &
                                          self%velocity)
    allocate (self%jump(m), self%sample_points(3, 2*m), self%values(max(2*m, n)), self%velocity(3, 2*m), source=0.0_rp)
    allocate (self%force(3, n), self%friction(3, n), source=0.0_rp)
  end subroutine load_init

  !> Marks the `lines` of the grid (ny_local, nz_local) that `sample` will need for the surface at its present place, with the
  !> same arguments; leaves the others as they are.
  subroutine load_select_lines(self, surface, sampler, distance, extrapolates, lines)
    class(pressure_load_t), intent(inout) :: self
    type(surface_t), intent(in) :: surface
    type(sampler_t), intent(in) :: sampler
    real(rp), intent(in) :: distance
    logical, intent(in) :: extrapolates
    logical, intent(inout) :: lines(:, :)
    if (extrapolates) then
      call surface%points_beside(2*distance, self%sample_points)
      call sampler%select_lines(self%sample_points, lines)
    end if
    call surface%points_beside(distance, self%sample_points)
    call sampler%select_lines(self%sample_points, lines)
  end subroutine load_select_lines

  !> Sets `jump` and `force` for the surface at its present place; no friction. `distance` [L] is that of the sampled places from
  !> the surface. Collective.
  subroutine load_sample(self, surface, sampler, pressure, distance, extrapolates)
    class(pressure_load_t), intent(inout) :: self
    type(surface_t), intent(in) :: surface
    type(sampler_t), intent(in) :: sampler
    real(rp), contiguous, intent(in) :: pressure(:, :, :) !< (nx, ny_local, nz_local)
    real(rp), intent(in) :: distance
    logical, intent(in), optional :: extrapolates !< to the mid surface; not if not given
    real(rp) :: centre(3), twice_area(3)
    integer :: i, m
    logical :: samples_twice
    m = size(surface%triangles, 2)
    call require(size(self%jump) == m, 'pressure_load_t: the surface has other triangles')
    samples_twice = .false.
    if (present(extrapolates)) samples_twice = extrapolates
    if (samples_twice) then
      call surface%points_beside(2*distance, self%sample_points)
      call sampler%sample(self%sample_points, pressure, self%values)
      self%jump = self%values(:m) - self%values(m + 1:)
    end if
    call surface%points_beside(distance, self%sample_points)
    call sampler%sample(self%sample_points, pressure, self%values)
    if (samples_twice) then
      self%jump = 2*(self%values(:m) - self%values(m + 1:)) - self%jump
    else
      self%jump = self%values(:m) - self%values(m + 1:)
    end if
    self%force = 0
    self%friction = 0
    do i = 1, m
      call triangle_geometry(surface, i, centre, twice_area)
      call distribute(surface, i, -self%jump(i)/2*twice_area, self%force)
    end do
  end subroutine load_sample

  !> Sets `force` to given forces (3, n) on the points of the surface at its present place, and `jump` to the part of it that is
  !> normal to the triangles: each triangle has the mean of its corners' forces per area. No friction.
  subroutine load_show(self, surface, force)
    class(pressure_load_t), intent(inout) :: self
    type(surface_t), intent(in) :: surface
    real(rp), intent(in) :: force(:, :)
    real(rp) :: centre(3), twice_area(3)
    integer :: i, k
    self%force = force
    self%friction = 0
    self%values(:size(force, 2)) = 0
    do i = 1, size(self%jump)
      call triangle_geometry(surface, i, centre, twice_area)
      do k = 1, 3
        associate (area => self%values(surface%triangles(k, i)))
          area = area + norm2(twice_area)/6
        end associate
      end do
    end do
    do i = 1, size(self%jump)
      call triangle_geometry(surface, i, centre, twice_area)
      self%jump(i) = 0
      do k = 1, 3
        associate (p => surface%triangles(k, i))
          self%jump(i) = self%jump(i) - dot_product(force(:, p), twice_area)/(3*norm2(twice_area)*self%values(p))
        end associate
      end do
    end do
  end subroutine load_show

  !> Adds the viscous traction on both sides to `force`, at the places of the last `sample`, and stores it in `friction`.
  !> Collective.
  subroutine load_add_friction(self, surface, sampler, velocity, nu, distance, half_thickness)
    class(pressure_load_t), intent(inout) :: self
    type(surface_t), intent(in) :: surface
    type(sampler_t), intent(in) :: sampler
    real(rp), contiguous, intent(in) :: velocity(:, :, :, :) !< (nx, ny_local, nz_local, at least 3) L/T
    real(rp), intent(in) :: nu             !< L^2/T
    real(rp), intent(in) :: distance       !< of the last `sample`, L
    real(rp), intent(in) :: half_thickness !< of the sheet, L, less than `distance`
    real(rp) :: centre(3), twice_area(3), normal(3), wall(3), slip(3)
    integer :: i, c, m
    m = size(surface%triangles, 2)
    call require(distance > half_thickness, 'pressure_load_t: the places must be outside the sheet')
    do c = 1, 3
      call sampler%sample(self%sample_points, velocity(:, :, :, c), self%values)
      self%velocity(c, :) = self%values
    end do
    do i = 1, m
      call triangle_geometry(surface, i, centre, twice_area)
      normal = twice_area/norm2(twice_area)
      associate (corners => surface%triangles(:, i))
        wall = sum(surface%velocities(:, corners), 2)/3
      end associate
      ! The rotation of the wall cancels: the velocities that it adds on the two sides have opposite signs.
      slip = self%velocity(:, i) + self%velocity(:, m + i) - 2*wall
      slip = slip - normal*dot_product(normal, slip)
      call distribute(surface, i, nu/(distance - half_thickness)*norm2(twice_area)/2*slip, self%friction)
    end do
    self%force = self%force + self%friction
  end subroutine load_add_friction

  !> Adds a third of `force` to each corner of triangle i.
  pure subroutine distribute(surface, i, force, forces)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: i
    real(rp), intent(in) :: force(3)
    real(rp), intent(inout) :: forces(:, :)
    integer :: k
    do k = 1, 3
      associate (p => surface%triangles(k, i))
        forces(:, p) = forces(:, p) + force/3
      end associate
    end do
  end subroutine distribute

  !> Computes the centre and twice the area vector of triangle i.
  pure subroutine triangle_geometry(surface, i, centre, twice_area)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: i
    real(rp), intent(out) :: centre(3), twice_area(3)
    associate (a => surface%points(:, surface%triangles(1, i)), b => surface%points(:, surface%triangles(2, i)), &
               c => surface%points(:, surface%triangles(3, i)))
      centre = (a + b + c)/3
      twice_area = cross(b - a, c - a)
    end associate
  end subroutine triangle_geometry
end module fsi_pressure_load

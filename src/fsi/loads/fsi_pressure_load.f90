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
!> difference along a normal probe (Vanella & Balaras 2009, J. Comput. Phys. 228, 6617, DOI 10.1016/j.jcp.2009.06.003). It is exact
!> for a flow that is linear between wall and place, and gives the mean of the shear there otherwise. The vorticity at the place
!> would give the shear at its far end, and is less smooth next to a penalized wall.
module fsi_pressure_load
  use base_errors, only: require
  use base_kinds, only: rp
  use fluid_sampling, only: samples_t
  use fsi_rotation, only: cross
  use fsi_surface, only: surface_t
  implicit none
  private
  public :: pressure_load_t

  !> Work space of one surface. Code units with density 1.
  type :: pressure_load_t
    real(rp), allocatable :: jump(:)        !< (m) p_above - p_below of the triangles; above is where n points
    real(rp), allocatable :: force(:, :)    !< (3, n) force on the points, in space
    real(rp), allocatable :: friction(:, :) !< (3, n) the viscous part of it; 0 unless requested
    real(rp), allocatable, private :: area(:)        !< (n)
    real(rp), allocatable, private :: velocity(:, :) !< (3, 2 m)
  contains
    procedure :: init => load_init
    procedure :: take_pressure => load_take_pressure
    procedure :: take_velocity => load_take_velocity
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
    if (allocated(self%jump)) deallocate (self%jump, self%force, self%friction, self%area, self%velocity)
    allocate (self%jump(m), self%area(n), self%velocity(3, 2*m), source=0.0_rp)
    allocate (self%force(3, n), self%friction(3, n), source=0.0_rp)
  end subroutine load_init

  !> Sets `jump` and `force` for the surface at its present position, without friction. The samples are the pressure at the points
  !> `points_beside` of the surface: one set at the distance d or, to extrapolate to the mid surface, a second one at 2 d.
  subroutine load_take_pressure(self, surface, samples)
    class(pressure_load_t), intent(inout) :: self
    type(surface_t), intent(in) :: surface
    type(samples_t), intent(in) :: samples(:)
    real(rp) :: centre(3), twice_area(3)
    integer :: i, m
    m = size(surface%triangles, 2)
    call require(size(self%jump) == m, 'pressure_load_t: the surface has other triangles')
    self%jump = samples(1)%values(:m) - samples(1)%values(m + 1:)
    if (size(samples) == 2) self%jump = 2*self%jump - (samples(2)%values(:m) - samples(2)%values(m + 1:))
    self%force = 0
    self%friction = 0
    do i = 1, m
      call triangle_geometry(surface, i, centre, twice_area)
      call distribute(surface, i, -self%jump(i)/2*twice_area, self%force)
    end do
  end subroutine load_take_pressure

  !> Takes component `c` of the velocity of the flow at the points of the first set of samples, for `add_friction`.
  subroutine load_take_velocity(self, c, sample)
    class(pressure_load_t), intent(inout) :: self
    integer, intent(in) :: c
    type(samples_t), intent(in) :: sample
    self%velocity(c, :) = sample%values
  end subroutine load_take_velocity

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
    self%area = 0
    do i = 1, size(self%jump)
      call triangle_geometry(surface, i, centre, twice_area)
      do k = 1, 3
        associate (area => self%area(surface%triangles(k, i)))
          area = area + norm2(twice_area)/6
        end associate
      end do
    end do
    do i = 1, size(self%jump)
      call triangle_geometry(surface, i, centre, twice_area)
      self%jump(i) = 0
      do k = 1, 3
        associate (p => surface%triangles(k, i))
          self%jump(i) = self%jump(i) - dot_product(force(:, p), twice_area)/(3*norm2(twice_area)*self%area(p))
        end associate
      end do
    end do
  end subroutine load_show

  !> Adds the viscous traction on both sides to `force`, from the velocities that were taken; it is in `friction`, too.
  subroutine load_add_friction(self, surface, nu, distance, half_thickness)
    class(pressure_load_t), intent(inout) :: self
    type(surface_t), intent(in) :: surface
    real(rp), intent(in) :: nu             !< L^2/T
    real(rp), intent(in) :: distance       !< of the points from the surface, L
    real(rp), intent(in) :: half_thickness !< of the sheet, L, less than `distance`
    real(rp) :: centre(3), twice_area(3), normal(3), wall(3), slip(3)
    integer :: i, m
    m = size(surface%triangles, 2)
    call require(distance > half_thickness, 'pressure_load_t: the places must be outside the sheet')
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

! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes pressure and viscous traction of the flow on each side of every wing.
!>
!> The flow is sampled at the distance d from the centre of each triangle along its normal n, on both sides. The motion of the wall
!> is continued to these points as that of a rigid body, with the velocity v +- d dn/dt. With w the tangential velocity of the flow
!> relative to it, the traction is nu w/(d - t/2), where t/2 is the half thickness of a wing in the mask (the one-sided difference
!> of fsi_pressure_load). Both quantities are those of the flow at the distance d: the pressure decreases by about d/c, and the
!> traction is the mean shear of that layer. They show the distribution of the load. The total load in forces.t is more accurate.
module fsi_wing_sides
  use base_kinds, only: rp
  use fluid_sampling, only: samples_t
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_rotation, only: cross
  use fsi_surface, only: surface_t
  implicit none
  private
  public :: wing_sides_t

  !> Values of one wing. The last index is 1 on the side to which the normals point, +z of the wing frame, and 2 on the opposite
  !> side.
  type :: side_loads_t
    real(rp), allocatable :: pressure(:, :)    !< (m, 2) rho L^2/T^2
    real(rp), allocatable :: traction(:, :, :) !< (3, m, 2) in space, rho L^2/T^2
  end type side_loads_t

  !> Values of all wings. Nothing is allocated after `init`.
  type :: wing_sides_t
    type(side_loads_t), allocatable :: wings(:)
    real(rp) :: distance = 0 !< d, L
    real(rp), private :: half_thickness = 0
    type(samples_t), allocatable, private :: samples(:) !< of each wing
  contains
    procedure :: init => sides_init
    procedure :: sample => sides_sample
  end type wing_sides_t

contains

  !> Makes room for these wings, and in `fluid` for samples beside them. The flow is sampled one grid spacing outside the mask, or
  !> at two and a half spacings from wings without thickness, whose forces act on the flow smoothed over about two spacings.
  subroutine sides_init(self, fluid, wings)
    class(wing_sides_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(in) :: wings
    real(rp), parameter :: BESIDE_MASK = 1, BESIDE_MARKERS = 2.5_rp
    integer :: i, m
    call fluid%hold_samples()
    associate (p => wings%params)
      self%half_thickness = p%half_thickness
      self%distance = p%half_thickness + p%smoothing + &
                      merge(BESIDE_MARKERS, BESIDE_MASK, p%thin%is_thin)*fluid%transform%grid%max_spacing()
    end associate
    allocate (self%wings(size(wings%surfaces)), self%samples(size(wings%surfaces)))
    do i = 1, size(self%wings)
      m = size(wings%surfaces(i)%triangles, 2)
      associate (wing => self%wings(i))
        allocate (wing%pressure(m, 2), wing%traction(3, m, 2), source=0.0_rp)
      end associate
      call self%samples(i)%init(2*m)
    end do
  end subroutine sides_init

  !> Samples the flow of the last pass of `fluid`, which must have kept pressure and flow, beside `wings`, which must still be
  !> where they were in it. Costs the parts of four inverse transforms that reach the sampled places. Collective.
  subroutine sides_sample(self, fluid, wings)
    class(wing_sides_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(in) :: wings
    integer :: i, c, m
    do i = 1, size(self%wings)
      call wings%surfaces(i)%points_beside(self%distance, self%samples(i)%points)
    end do
    call fluid%sample_pressure(self%samples)
    do i = 1, size(self%wings)
      m = size(self%wings(i)%pressure, 1)
      self%wings(i)%pressure = reshape(self%samples(i)%values, [m, 2])
    end do
    do c = 1, 3
      call fluid%sample_flow(c, self%samples)
      do i = 1, size(self%wings)
        m = size(self%wings(i)%pressure, 1)
        self%wings(i)%traction(c, :, :) = reshape(self%samples(i)%values, [m, 2])
      end do
    end do
    do i = 1, size(self%wings)
      call shear(self, wings%surfaces(i), fluid%rhs%params%nu, self%wings(i)%traction)
    end do
  end subroutine sides_sample

  !> Computes tractions from the velocities next to the triangles.
  pure subroutine shear(self, surface, nu, traction)
    type(wing_sides_t), intent(in) :: self
    type(surface_t), intent(in) :: surface
    real(rp), intent(in) :: nu
    real(rp), intent(inout) :: traction(:, :, :)
    real(rp) :: normal(3), rate(3), wall(3), area
    integer :: i, side
    do i = 1, size(surface%triangles, 2)
      associate (x => surface%points, v => surface%velocities, a => surface%triangles(1, i), &
                 b => surface%triangles(2, i), c => surface%triangles(3, i))
        normal = cross(x(:, b) - x(:, a), x(:, c) - x(:, a))
        rate = cross(v(:, b) - v(:, a), x(:, c) - x(:, a)) + cross(x(:, b) - x(:, a), v(:, c) - v(:, a))
        wall = (v(:, a) + v(:, b) + v(:, c))/3
      end associate
      area = norm2(normal)
      normal = normal/area
      rate = (rate - normal*dot_product(normal, rate))/area
      do side = 1, 2
        associate (w => traction(:, i, side))
          w = w - wall - merge(1, -1, side == 1)*self%distance*rate
          w = (nu/(self%distance - self%half_thickness))*(w - normal*dot_product(normal, w))
        end associate
      end do
    end do
  end subroutine shear
end module fsi_wing_sides

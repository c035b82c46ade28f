! SPDX-License-Identifier: GPL-3.0-or-later
!> Wings without thickness in the flow: markers on their mid surface with forces that make the flow move as they do.
!>
!> The fluid makes its step without wings, u*. At the places X and with the velocities U of the markers at its end
!>
!>     dt M F = U - (I u*)(X),          u(n+1) = u* + dt P S F,
!>
!> where I looks at the flow, S is its adjoint, P the projection (fluid_point_forces) and M the response of the markers
!> (fsi_marker_response): forces as Lagrange multipliers (Taira & Colonius 2007, DOI 10.1016/j.jcp.2007.03.005). -F is
!> the load on the wing, and F.U the power that it gives to the flow. The forces of one wing do not take account of those
!> of another, and M leaves out the periodic images. The slip that this leaves is corrected in the next step.
module fsi_thin_wings
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_green, only: green_t
  use fsi_kinematics, only: pose_wing, wing_pose_t
  use fsi_marker_response, only: marker_response_t
  use fsi_markers, only: markers_t
  use fsi_surface_load, only: total_load
  use parallel_world, only: world_t
  implicit none
  private
  public :: thin_wings_t

  !> The markers of one wing are first .. last of all markers. Their response is known to the rank that owns the wing.
  type :: thin_wing_t
    type(markers_t) :: markers
    type(marker_response_t) :: response
    integer :: first = 1, last = 0, owner = 0
    real(rp), allocatable :: reference(:, :) !< (3, n) in the wing frame, unloaded, L
    real(rp), allocatable :: work(:, :)      !< (3, n)
  end type thin_wing_t

  !> How well the flow follows the wings after a step, L/T.
  type :: slip_t
    real(rp) :: before = 0 !< largest |U - I u*|, before the forces act
    real(rp) :: after = 0  !< largest |U - I u(n+1)|
    real(rp) :: speed = 0  !< largest |U|
  end type slip_t

  type :: thin_wings_t
    type(thin_wing_t), allocatable :: wings(:)
    real(rp), allocatable :: x(:, :), u(:, :)  !< (3, all markers) places [L] and velocities [L/T], in space
    real(rp), allocatable :: force(:, :)       !< (3, all markers) on the fluid, of the last step, rho L^4/T^2
    type(slip_t) :: slip
    type(world_t), private :: world
    type(green_t), private :: green
    real(rp), allocatable, private :: flow(:, :) !< (3, all markers) velocities of the flow there
  contains
    procedure :: init => thin_init
    procedure :: advance_rigid => thin_advance_rigid
    procedure :: memory_bytes => thin_memory_bytes
  end type thin_wings_t

contains

  !> Puts markers on the unloaded wings and prepares the fluid for them. Fails if markers are too close. Collective.
  subroutine thin_init(self, world, wings, fluid, failure)
    class(thin_wings_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(flapping_wings_t), intent(in) :: wings
    type(fluid_t), intent(inout) :: fluid
    type(failure_t), intent(inout) :: failure
    real(rp) :: extent
    integer :: i, n
    logical :: has_factor, all_have
    all_have = .true.
    self%world = world
    n = 0
    extent = 0
    allocate (self%wings(size(wings%params%wings)))
    do i = 1, size(self%wings)
      associate (wing => self%wings(i), given => wings%params%wings(i))
        call wing%markers%init(given%points, given%triangles, wings%params%thin%spacing)
        wing%first = n + 1
        n = n + wing%markers%n
        wing%last = n
        wing%owner = mod(i - 1, world%size)
        allocate (wing%reference(3, wing%markers%n), wing%work(3, wing%markers%n))
        call wing%markers%positions(given%points, wing%reference)
        extent = max(extent, norm2(maxval(wing%reference, 2) - minval(wing%reference, 2)))
      end associate
    end do
    allocate (self%x(3, n), self%u(3, n), self%force(3, n), self%flow(3, n), source=0.0_rp)
    call fluid%hold_points(n)
    call self%green%init(fluid%points%radius, extent, fluid%transform%grid%is_2d)
    do i = 1, size(self%wings)
      associate (wing => self%wings(i))
        if (wing%owner /= world%rank) cycle
        call wing%response%init(wing%markers%n)
        call wing%response%build(self%green, wing%reference, has_factor)
        all_have = all_have .and. has_factor
      end associate
    end do
    ! Only the owner of a wing knows whether its response has a factor; all ranks must stop together.
    if (world%max_integer(merge(0, 1, all_have)) > 0) &
      call failure%raise('the markers of a wing are too close to each other, so that the motion of the wing does not '// &
                         'determine their forces: set a larger [Insects] marker_spacing')
  end subroutine thin_init

  !> Lets rigid wings act on the step that `fluid` has just made: its end gets their forces; `slip` and the loads of the
  !> markers, which `wings` hold, are those of this step. `wings` stay where they are. Collective.
  subroutine thin_advance_rigid(self, fluid, wings)
    class(thin_wings_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(inout) :: wings
    type(wing_pose_t) :: poses(size(self%wings))
    integer :: i, m
    do i = 1, size(self%wings)
      associate (wing => self%wings(i), given => wings%params%wings(i), pose => poses(i))
        call pose_wing(wings%params%body, given%mount, given%motion, fluid%rhs%state%time, pose)
        do m = 1, wing%markers%n
          self%x(:, wing%first + m - 1) = pose%point_to_space(wing%reference(:, m))
          self%u(:, wing%first + m - 1) = pose%velocity_at(wing%reference(:, m))
        end do
      end associate
    end do
    call fluid%points%place(self%x)
    call fluid%velocities_at_points(self%flow)
    self%slip%before = largest(self%u - self%flow)
    self%slip%speed = largest(self%u)
    do i = 1, size(self%wings)
      call find_forces(self, self%wings(i), poses(i), fluid%dt)
    end do
    call fluid%push_at_points(self%force)
    call fluid%velocities_at_points(self%flow)
    self%slip%after = largest(self%u - self%flow)
    do i = 1, size(self%wings)
      associate (a => self%wings(i)%first, z => self%wings(i)%last)
        wings%marker_loads(i) = total_load(-self%force(:, a:z), self%x(:, a:z), self%u(:, a:z), poses(i)%hinge)
      end associate
    end do
  end subroutine thin_advance_rigid

  !> The forces of one wing that make the flow follow it, the same on all ranks.
  subroutine find_forces(self, wing, pose, dt)
    type(thin_wings_t), intent(inout) :: self
    type(thin_wing_t), intent(inout) :: wing
    type(wing_pose_t), intent(in) :: pose
    real(rp), intent(in) :: dt
    integer :: m, k
    associate (force => self%force(:, wing%first:wing%last))
      if (wing%owner == self%world%rank) then
        do m = 1, wing%markers%n
          k = wing%first + m - 1
          wing%work(:, m) = pose%vector_to_wing(self%u(:, k) - self%flow(:, k))/dt
        end do
        call wing%response%solve(wing%work, force)
        do m = 1, wing%markers%n
          force(:, m) = pose%vector_to_space(force(:, m))
        end do
      end if
      call broadcast(self%world, size(force), force, wing%owner)
    end associate
  end subroutine find_forces

  subroutine broadcast(world, n, values, from)
    type(world_t), intent(in) :: world
    integer, intent(in) :: n, from
    real(rp), intent(inout) :: values(n)
    call world%broadcast_reals(values, from)
  end subroutine broadcast

  !> Largest length of the vectors v(3, n).
  pure real(rp) function largest(v)
    real(rp), intent(in) :: v(:, :)
    integer :: i
    largest = 0
    do i = 1, size(v, 2)
      largest = max(largest, norm2(v(:, i)))
    end do
  end function largest

  !> Bytes of the responses that this rank owns.
  pure real(rp) function thin_memory_bytes(self) result(bytes)
    class(thin_wings_t), intent(in) :: self
    integer :: i
    bytes = 0
    do i = 1, size(self%wings)
      bytes = bytes + self%wings(i)%response%memory_bytes()
    end do
  end function thin_memory_bytes
end module fsi_thin_wings

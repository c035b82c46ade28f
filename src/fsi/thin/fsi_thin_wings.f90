! SPDX-License-Identifier: GPL-3.0-or-later
!> Puts wings without thickness into the flow: markers on their mid surface with forces that make the flow follow them.
!>
!> The fluid makes its step without wings, with the result u*. The markers have the positions X and the velocities U at the end of
!> the step. Then
!>
!>     dt M F = U - (I u*)(X),          u(n+1) = u* + dt P S F,
!>
!> where I interpolates the flow, S is its adjoint, P the projection (fluid_point_forces) and M the response of the markers
!> (fsi_marker_response). The forces are Lagrange multipliers (Taira & Colonius 2007, DOI 10.1016/j.jcp.2007.03.005). -F is the load
!> on the wing, and F.(U(n) + U(n+1))/2 the power that it gives to the flow. M omits the periodic images; the next step corrects
!> the remaining slip.
!> The forces of all rigid wings are computed in one system of equations (fsi_wing_pairs), those of flexible wings wing by wing.
!>
!> If a marker lies in a penalized body, near the hinge, the body determines the flow: with chi of the body at the marker, the
!> marker prescribes the velocity (1 - chi) U + chi U_body, and the share chi of its force acts on the body, not on the wing.
!>
!> Rigid wings are advanced here, flexible ones by fsi_thin_coupling in the same parts: `sample_flow`, find the forces,
!> `apply_forces`. M is computed in the frame of the wing, along the axes of the wing file. For a rigid wing this is done once. For
!> a flexible wing it is repeated when the wing has deformed, apart from a rotation (fsi_rigid_fit), by a fraction of the spacing of
!> its markers.
module fsi_thin_wings
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_green, only: green_t
  use fsi_kinematics, only: body_t, pose_wing, wing_pose_t
  use fsi_rotation, only: cross
  use fsi_surface_load, only: total_load
  use fsi_thin_slip, only: largest, slip_t
  use fsi_thin_wing, only: form_group, thin_wing_t
  use fsi_wing_pairs, only: wing_pairs_t
  use io_units, only: unit_scales_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: thin_wings_t

  !> Wall time of this rank so far.
  type :: thin_seconds_t
    real(rp) :: sampling = 0  !< interpolating the flow at the markers
    real(rp) :: responses = 0 !< computing responses
    real(rp) :: forces = 0    !< giving the forces to the flow, and preparing the measurement of the slip
  end type thin_seconds_t

  type :: thin_wings_t
    type(thin_wing_t), allocatable :: wings(:)
    real(rp), allocatable :: x(:, :), u(:, :)  !< (3, all markers) places [L] and velocities [L/T], in space
    real(rp), allocatable :: u_before(:, :)    !< (3, all markers) `u` of the step before; at rest before the first
    real(rp), allocatable :: force(:, :)       !< (3, all markers) on the fluid, mean of the last step, rho L^4/T^2
    real(rp), allocatable :: flow(:, :)        !< (3, all markers) velocities of the flow there, and `shift`, L/T
    real(rp), allocatable, private :: body_fraction(:) !< (all markers) chi of the body there
    real(rp), allocatable, private :: shift(:, :)     !< (3, all markers) chi (U - U_body), L/T
    real(rp), allocatable, private :: body_speed(:, :) !< (3, all markers) U_body, L/T
    real(rp), allocatable, private :: wanted(:, :)     !< (3, all markers) change of the flow, L/T^2
    type(slip_t) :: slip
    type(thin_seconds_t) :: seconds
    type(world_t) :: world
    type(green_t), private :: green
    type(wing_pairs_t), allocatable, private :: pairs !< of several rigid wings
    logical, private :: is_shared = .false.    !< groups of ranks share the responses
    type(world_t), private :: group            !< group of this rank in this case
    real(rp), private :: extent = 0            !< L largest distance of markers for which `green` holds
  contains
    procedure :: init => thin_init
    procedure :: init_flexible => thin_init_flexible
    procedure :: rebuild_responses => thin_rebuild_responses
    procedure :: free => thin_free
    procedure :: sample_flow => thin_sample_flow
    procedure :: apply_forces => thin_apply_forces
    procedure :: sample_slip => thin_sample_slip
    procedure :: read_slip => thin_read_slip
    procedure :: advance_rigid => thin_advance_rigid
    procedure :: broadcast => thin_broadcast
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
    real(rp), parameter :: LONGER = 1.2_rp ! deformation hardly lengthens a wing, but its outline need not be convex
    integer :: i, n
    logical :: has_factor(size(wings%params%wings)), is_2d
    self%world = world
    is_2d = fluid%transform%grid%is_2d
    n = 0
    allocate (self%wings(size(wings%params%wings)))
    do i = 1, size(self%wings)
      associate (wing => self%wings(i), given => wings%params%wings(i))
        call wing%init(given%points, given%triangles, wings%params%thin%spacing, is_2d, n)
        n = wing%last
        wing%is_mirrored = given%is_mirrored
        self%extent = max(self%extent, LONGER*norm2(maxval(given%points, 2) - minval(given%points, 2)))
      end associate
    end do
    allocate (self%body_fraction(n), self%shift(3, n), self%body_speed(3, n), self%wanted(3, n), source=0.0_rp)
    allocate (self%x(3, n), self%u(3, n), self%u_before(3, n), self%force(3, n), self%flow(3, n), source=0.0_rp)
    call fluid%hold_points(n)
    call init_responses(self, fluid)
    call form_group(world, self%wings%last - self%wings%first + 1, wings%params%thin%sharing, self%is_shared, self%group)
    do i = 1, size(self%wings)
      call self%wings(i)%hold_response(world, i, size(self%wings), is_2d, self%is_shared, self%group)
    end do
    call self%rebuild_responses([(.true., i=1, size(self%wings))], has_factor)
    if (.not. all(has_factor)) call failure%raise('the markers of a wing are too close to each other, and the motion of the '// &
                                                  'wing does not determine their forces: set a larger [Insects] marker_spacing')
  end subroutine thin_init

  !> Makes the table of the response, and room for the effect of rigid wings on each other.
  subroutine init_responses(self, fluid)
    type(thin_wings_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    real(rp) :: length(3)
    associate (grid => fluid%transform%grid)
      length = grid%length
      if (grid%is_2d) length(1) = 0
      if (size(self%wings) < 2) then
        call self%green%init(fluid%points%radius, self%extent, grid%is_2d)
      else
        call self%green%init(fluid%points%radius, max(self%extent, norm2(length)/2), grid%is_2d)
        allocate (self%pairs)
        call self%pairs%init(self%world, self%wings%first, self%wings%last, length)
      end if
    end associate
  end subroutine init_responses

  !> Prepares for flexible wings that are unloaded at points(3, n_all) [m] along the axes of the wing file.
  subroutine thin_init_flexible(self, points, units)
    class(thin_wings_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :)
    type(unit_scales_t), intent(in) :: units
    integer :: i
    if (allocated(self%pairs)) deallocate (self%pairs)
    do i = 1, size(self%wings)
      associate (wing => self%wings(i))
        if (wing%is_owner) call wing%reaction%init(wing%markers, points, units)
        call wing%update_reaction()
      end associate
    end do
  end subroutine thin_init_flexible

  !> Makes the responses of the wings that `are_changed` (wings) for markers at their `shape`, at the same time on the ranks that
  !> hold them. has_factor(wings) is false, on all ranks, if markers are too close to each other, or farther from each other than
  !> the table of the response reaches. Collective.
  subroutine thin_rebuild_responses(self, are_changed, has_factor)
    class(thin_wings_t), intent(inout) :: self
    logical, intent(in) :: are_changed(:)
    logical, intent(out) :: has_factor(:)
    real(rp) :: begun
    integer :: i
    begun = wall_seconds()
    has_factor = .true.
    do i = 1, size(self%wings)
      if (.not. are_changed(i)) cycle
      associate (wing => self%wings(i))
        has_factor(i) = norm2(maxval(wing%shape, 2) - minval(wing%shape, 2)) <= self%extent
        if (has_factor(i)) call wing%build_response(self%green, has_factor(i))
      end associate
    end do
    ! Only the owner of a wing knows whether its response has a factor; all ranks must stop together.
    do i = 1, size(self%wings)
      if (are_changed(i)) has_factor(i) = self%world%max_integer(merge(0, 1, has_factor(i))) == 0
    end do
    self%seconds%responses = self%seconds%responses + wall_seconds() - begun
  end subroutine thin_rebuild_responses

  !> Releases the group of ranks, if there is one. Collective over it.
  subroutine thin_free(self)
    class(thin_wings_t), intent(inout) :: self
    if (self%is_shared) call self%group%release()
    self%is_shared = .false.
  end subroutine thin_free

  !> Samples the flow, as it is without the wings, at the markers `x`: sets `flow`. The result is shifted such that a marker in the
  !> body, which moves with `u`, prescribes the motion of the body. Collective.
  subroutine thin_sample_flow(self, fluid, wings)
    class(thin_wings_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(in) :: wings
    real(rp) :: begun
    begun = wall_seconds()
    call fluid%points%place(self%x)
    call fluid%velocities_at_points(self%flow)
    if (wings%has_body()) then
      call find_body_fractions(self, fluid, wings)
      self%flow = self%flow + self%shift
    end if
    self%seconds%sampling = self%seconds%sampling + wall_seconds() - begun
  end subroutine thin_sample_flow

  !> Finds the chi and the velocity of the body at the markers at the end of the step.
  subroutine find_body_fractions(self, fluid, wings)
    type(thin_wings_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    type(flapping_wings_t), intent(in) :: wings
    type(body_t) :: body
    real(rp) :: arm(3)
    integer :: m
    body = wings%motion%at(fluid%rhs%state%time, wings%params%body)
    do m = 1, size(self%body_fraction)
      arm = self%x(:, m) - body%centre
      arm = body%rotation%to_frame(arm - fluid%transform%grid%length*anint(arm/fluid%transform%grid%length))
      self%body_fraction(m) = wings%params%solid%mask_at(arm)
      self%body_speed(:, m) = body%velocity + body%rotation%to_parent(cross(body%rotation%omega, arm))
      self%shift(:, m) = self%body_fraction(m)*(self%u(:, m) - self%body_speed(:, m))
    end do
  end subroutine find_body_fractions

  !> Applies `force` to the flow that was sampled at the markers, which move with `u`. Sets `slip`; if the slip after this step is
  !> due, the next pass of the fluid reads it, or the flow is sampled now if its grid does not permit that. Sets the loads of the
  !> markers, which `wings` hold; powers of wings are those of their mean velocities, that of the body of its velocity at the end of
  !> the step. `poses` are those of the wings at the end of the step. Collective.
  subroutine thin_apply_forces(self, fluid, wings, poses)
    class(thin_wings_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(inout) :: wings
    type(wing_pose_t), intent(in) :: poses(:)
    type(body_t) :: body
    real(rp) :: begun
    integer :: i
    begun = wall_seconds()
    self%slip%time = fluid%sums_time
    self%slip%before = largest(self%u - self%flow)
    self%slip%speed = largest(self%u)
    call fluid%push_at_points(self%force)
    do i = 1, size(self%wings)
      associate (a => self%wings(i)%first, z => self%wings(i)%last)
        wings%marker_loads(i) = total_load(-spread(1 - self%body_fraction(a:z), 1, 3)*self%force(:, a:z), self%x(:, a:z), &
                                           (self%u_before(:, a:z) + self%u(:, a:z))/2, poses(i)%hinge)
      end associate
    end do
    body = wings%motion%at(fluid%rhs%state%time, wings%params%body)
    if (wings%has_body()) wings%marker_loads(size(poses) + 1) = &
      total_load(-spread(self%body_fraction, 1, 3)*self%force, self%x, self%body_speed, body%centre)
    self%u_before = self%u
    self%slip%is_measured = .false.
    self%slip%is_due = mod(fluid%rhs%state%step, wings%params%thin%slip_interval) == 0
    if (self%slip%is_due) then
      self%slip%lost = sum(wings%marker_loads%power)
      if (fluid%rhs%reader%is_possible) then
        call fluid%rhs%reader%ask(self%x)
      else
        call self%sample_slip(fluid)
      end if
    end if
    self%seconds%forces = self%seconds%forces + wall_seconds() - begun
  end subroutine thin_apply_forces

  !> Measures the slip after the last step at once, to the error of the window, by three inverse transforms. Collective.
  subroutine thin_sample_slip(self, fluid)
    class(thin_wings_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    call fluid%velocities_at_points(self%flow)
    call self%slip%measure(self%u - (self%flow + self%shift), self%force)
  end subroutine thin_sample_slip

  !> Takes the slip after the last step from the pass that the fluid has just made, unless it is known. `is_new` tells that it was
  !> due and is known for the first time.
  subroutine thin_read_slip(self, fluid, is_new)
    class(thin_wings_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    logical, intent(out) :: is_new
    associate (slip => self%slip, reader => fluid%rhs%reader)
      is_new = slip%is_due .and. (slip%is_measured .or. reader%is_read)
      if (.not. is_new) return
      if (.not. slip%is_measured) call slip%measure(self%u - (reader%velocities + self%shift), self%force)
      slip%is_due = .false.
    end associate
  end subroutine thin_read_slip

  !> Lets rigid wings act on the step that `fluid` has just made: applies their forces to the flow at its end, and sets `slip` and
  !> the loads of the markers, which `wings` hold, for this step. `wings` stay where they are. Fails on all ranks if no forces are
  !> found; the flow is then unchanged. Collective.
  subroutine thin_advance_rigid(self, fluid, wings, failure)
    class(thin_wings_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(inout) :: wings
    type(failure_t), intent(inout) :: failure
    type(wing_pose_t) :: poses(size(self%wings))
    integer :: i, m
    do i = 1, size(self%wings)
      associate (wing => self%wings(i), given => wings%params%wings(i), pose => poses(i))
        call pose_wing(wings%motion%at(fluid%rhs%state%time, wings%params%body), given%mount, given%motion, &
                       fluid%rhs%state%time, pose)
        do m = 1, wing%markers%n
          self%x(:, wing%first + m - 1) = pose%point_to_space(wing%flat(:, m))
          self%u(:, wing%first + m - 1) = pose%velocity_at(wing%flat(:, m))
        end do
      end associate
    end do
    call self%sample_flow(fluid, wings)
    call find_forces(self, poses, fluid%dt, failure)
    if (.not. failure%failed) call self%apply_forces(fluid, wings, poses)
  end subroutine thin_advance_rigid

  !> Finds the forces that make the flow follow all rigid wings, the same on all ranks: sets `force`. For several wings it uses
  !> conjugate gradients, see fsi_wing_pairs. They fail if two wings coincide and part, or nearly do: see FAR_TOO_LARGE.
  subroutine find_forces(self, poses, dt, failure)
    type(thin_wings_t), intent(inout) :: self
    type(wing_pose_t), intent(in) :: poses(:)
    real(rp), intent(in) :: dt
    type(failure_t), intent(inout) :: failure
    integer, parameter :: MOST = 50
    real(rp), parameter :: ENOUGH = 1.0e-4_rp !< far less than the effect of periodic images
    real(rp), parameter :: TOO_MUCH = 1.0e-2_rp !< as much as the effect of these
    !> Of forces over those that each wing needs alone. Plates that part have 1.3 at a distance of 4 grid spacings, 3.8 at 2, 126 at
    !> 1, 870 at a half: a filtered flow cannot enter a gap of a grid spacing.
    real(rp), parameter :: FAR_TOO_LARGE = 100.0_rp
    real(rp) :: rz, pmp, step, ratio, begin, alone
    self%wanted = (self%u - self%flow)/dt
    if (.not. allocated(self%pairs)) then
      call solve_blocks(self, poses, self%wanted, self%force)
      return
    end if
    associate (r => self%pairs%r, z => self%pairs%z, p => self%pairs%p, mp => self%pairs%mp, dp => self%pairs%dp)
      call self%pairs%build(self%green, self%x)
      self%force = 0
      r = self%wanted
      begin = max(largest(r), tiny(begin)**0.25_rp) ! products of less would be 0
      ratio = 0
      rz = 1
      self%slip%iterations = 0
      alone = 0
      do while (self%slip%iterations < MOST)
        self%slip%left = largest(r)/begin
        if (self%slip%left <= ENOUGH) exit
        self%slip%iterations = self%slip%iterations + 1
        call solve_blocks(self, poses, r, z)
        if (self%slip%iterations == 1) alone = largest(z)
        if (self%slip%iterations > 1) ratio = sum(r*z)/rz
        rz = sum(r*z)
        p = z + ratio*p
        dp = r + ratio*dp
        mp = dp
        call self%pairs%add_product(p, mp)
        pmp = sum(p*mp)
        if (pmp <= 0) exit
        step = rz/pmp
        self%force = self%force + step*p
        r = r - step*mp
      end do
      self%slip%left = largest(r)/begin
      if (self%slip%left > TOO_MUCH .or. largest(self%force) > FAR_TOO_LARGE*alone) &
        call failure%raise('no forces make the flow follow all wings, because the wings are closer than a grid spacing, '// &
                           'touch or cross: set a larger distance between them ([Insects] x_pivot_l, x_pivot_r, or the '// &
                           'motion), a finer grid or a smaller [Time] CFL')
    end associate
  end subroutine find_forces

  !> Returns the forces f (3, all markers) in space that each wing alone needs for the velocities v, the same on all ranks.
  subroutine solve_blocks(self, poses, v, f)
    type(thin_wings_t), intent(inout) :: self
    type(wing_pose_t), intent(in) :: poses(:)
    real(rp), intent(in) :: v(:, :)
    real(rp), contiguous, intent(inout) :: f(:, :)
    integer :: i
    do i = 1, size(poses)
      associate (wing => self%wings(i), own => f(:, self%wings(i)%first:self%wings(i)%last))
        call wing%solve(poses(i), v(:, wing%first:wing%last), own)
      end associate
    end do
    do i = 1, size(poses)
      call self%broadcast(f(:, self%wings(i)%first:self%wings(i)%last), self%wings(i)%owner)
    end do
  end subroutine solve_blocks

  !> Gives values(3, n) of rank `from` to all. Collective.
  subroutine thin_broadcast(self, values, from)
    class(thin_wings_t), intent(in) :: self
    real(rp), contiguous, target, intent(inout) :: values(:, :)
    integer, intent(in) :: from
    real(rp), pointer :: flat(:)
    flat(1:size(values)) => values
    call self%world%broadcast_reals(flat, from)
  end subroutine thin_broadcast

  !> Returns the bytes of the responses that this rank owns.
  pure real(rp) function thin_memory_bytes(self) result(bytes)
    class(thin_wings_t), intent(in) :: self
    integer :: i
    bytes = 0
    do i = 1, size(self%wings)
      bytes = bytes + self%wings(i)%reaction%response%memory_bytes()
    end do
    if (allocated(self%pairs)) bytes = bytes + self%pairs%memory_bytes()
  end function thin_memory_bytes
end module fsi_thin_wings

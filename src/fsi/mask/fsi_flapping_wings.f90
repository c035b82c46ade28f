! SPDX-License-Identifier: GPL-3.0-or-later
!> Represents wings as moving solids in the fluid. Their frames follow the prescribed motion relative to the body, which is
!> tethered, moves as prescribed or flies freely (fsi_free_flight). In their frames wings are rigid, or have the deformation
!> that the coupling sets (fsi_coupler).
module fsi_flapping_wings
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use fluid_moving_solids, only: moving_solids_t
  use fluid_penalty, only: COLOR_BODY, N_COLORS, penalty_t
  use fluid_sums, only: sums_t
  use fsi_body_motion, only: body_motion_t
  use fsi_displaced, only: displaced_volumes
  use fsi_flight_params, only: flight_params_t
  use fsi_flyer, only: flyer_t
  use fsi_kinematics, only: body_t, pose_wing, wing_pose_t
  use fsi_mask, only: mask_t
  use fsi_moments, only: moments_of_points, moments_t, whole_t
  use fsi_rigid_mask, only: rigid_mask_t
  use fsi_rotation, only: cross
  use fsi_surface, only: surface_t
  use fsi_surface_load, only: surface_load_t
  use parallel_block, only: block_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: flapping_wings_t, deformation_t

  !> Volumes of the fluid that each point of a wing displaces, L^3.
  type :: displaced_t
    real(rp), allocatable :: volumes(:)
  end type displaced_t

  !> Motion of one wing in its frame, (3, n) each: displacement [L], its rate [L/T] and its acceleration [L/T^2].
  type :: deformation_t
    real(rp), allocatable :: u(:, :), v(:, :), a(:, :)
  end type deformation_t

  !> The wings at `time`, the same on all ranks. The time alone determines the state of rigid wings on a body that does not fly
  !> freely, so that a restart needs nothing else.
  type, extends(moving_solids_t) :: flapping_wings_t
    type(flight_params_t) :: params
    real(rp) :: time = 0                          !< of the last `place`, T
    type(body_motion_t) :: motion                 !< of the body
    type(body_t) :: body                          !< state of the body at the last `place`
    type(flyer_t), allocatable :: flyer           !< of a free flight
    type(wing_pose_t), allocatable :: poses(:)
    type(surface_t), allocatable :: surfaces(:)
    type(mask_t) :: mask
    type(rigid_mask_t) :: body_mask
    type(rigid_mask_t), allocatable :: wing_masks(:) !< of wings drawn up to their outline
    type(deformation_t), allocatable :: deformation(:) !< of the wings, not allocated if they are rigid
    real(rp), allocatable :: masses(:)            !< of the points of a wing that deforms, rho L^3
    type(surface_load_t), allocatable :: marker_loads(:) !< on wings without thickness (fsi_thin_wings), means of the last
    !< step with moments of its end; behind them that on the body, if there is one, about its centre
    real(rp) :: seconds = 0                       !< that `place` has taken on this rank so far
    real(rp) :: cells = 0                         !< band points of the mask it has drawn on this rank so far
    type(displaced_t), allocatable, private :: displaced(:)
  contains
    procedure :: init => wings_init
    procedure :: place => wings_place
    procedure :: momentum_rate => wings_momentum_rate
    procedure :: inertial_power_of_fluid => wings_inertial_power_of_fluid
    procedure :: inertial_power => wings_inertial_power
    procedure :: has_body => wings_has_body
    procedure, private :: draws_solids, draw_solids
    procedure :: max_speed => wings_max_speed
    procedure :: feel => wings_feel
    procedure :: refer => wings_refer
    procedure :: whole => wings_whole
    procedure :: own => wings_own
    procedure :: marker_total => wings_marker_total
  end type flapping_wings_t

contains

  !> Prepares the wings for drawing on this rank's `block` of `grid`.
  subroutine wings_init(self, params, grid, block)
    class(flapping_wings_t), intent(inout) :: self
    type(flight_params_t), intent(in) :: params
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    integer :: i
    self%params = params
    self%motion = params%motion
    self%body = params%motion%at(0.0_rp, params%body)
    if (params%thin%is_thin) then
      allocate (self%marker_loads(size(params%wings) + merge(1, 0, params%solid%exists())))
    else if (size(params%wings) > 0) then
      call self%mask%init(grid, block, params%half_thickness, min(params%smoothing, params%half_thickness))
    end if
    if (params%solid%exists()) call self%body_mask%init(grid, block)
    if (allocated(self%wing_masks)) deallocate (self%wing_masks)
    allocate (self%wing_masks(merge(size(params%wings), 0, self%draws_solids())))
    do i = 1, size(self%wing_masks)
      call self%wing_masks(i)%init(grid, block)
    end do
    if (allocated(self%poses)) deallocate (self%poses, self%surfaces, self%displaced)
    allocate (self%poses(size(params%wings)), self%surfaces(size(params%wings)), self%displaced(size(params%wings)))
    do i = 1, size(params%wings)
      associate (wing => params%wings(i))
        call self%surfaces(i)%init(wing%points, wing%triangles, wing%color)
        if (params%thin%is_thin) then
          allocate (self%displaced(i)%volumes(size(wing%points, 2)), source=0.0_rp)
        else
          call displaced_volumes(wing%points, wing%triangles, 2*params%half_thickness, self%displaced(i)%volumes, &
                                 grid%is_2d)
          associate (volumes => self%displaced(i)%volumes)
            if (wing%solid%exists()) volumes = volumes*(wing%solid%displaced%mass/sum(volumes))
          end associate
        end if
      end associate
    end do
  end subroutine wings_init

  !> Places the wings by the kinematics at `time` and draws them; see moving_solids_t.
  subroutine wings_place(self, time, penalty, failure)
    class(flapping_wings_t), intent(inout) :: self
    real(rp), intent(in) :: time
    type(penalty_t), intent(inout) :: penalty
    type(failure_t), intent(inout) :: failure
    real(rp) :: begun
    integer :: i
    begun = wall_seconds()
    self%time = time
    self%body = self%motion%at(time, self%params%body)
    do i = 1, size(self%surfaces)
      associate (wing => self%params%wings(i))
        call pose_wing(self%body, wing%mount, wing%motion, time, self%poses(i))
        if (allocated(self%deformation)) then
          associate (bent => self%deformation(i))
            call self%surfaces(i)%place_deformed(wing%points, bent%u, bent%v, self%poses(i))
          end associate
        else
          call self%surfaces(i)%place_at(wing%points, self%poses(i))
        end if
      end associate
    end do
    if (self%has_body()) then
      call penalty%erase_overlay()
      call self%body_mask%draw(self%params%solid, self%body, COLOR_BODY, penalty)
    end if
    if (self%draws_solids()) then
      call self%draw_solids(penalty)
    else if (.not. self%params%thin%is_thin .and. size(self%surfaces) > 0) then
      call self%mask%draw(self%surfaces, penalty, failure, self%has_body())
    end if
    self%seconds = self%seconds + wall_seconds() - begun
    self%cells = self%cells + self%mask%n_cells + self%body_mask%n_cells
  end subroutine wings_place

  !> Tells whether the wings are rigid solids that end at their outline.
  pure logical function draws_solids(self)
    class(flapping_wings_t), intent(in) :: self
    draws_solids = .false.
    if (size(self%params%wings) > 0) draws_solids = self%params%wings(1)%solid%exists()
  end function draws_solids

  !> Lays such wings over the mask, which holds the body at most.
  subroutine draw_solids(self, penalty)
    class(flapping_wings_t), intent(inout) :: self
    type(penalty_t), intent(inout) :: penalty
    integer :: i
    if (.not. self%has_body()) call penalty%erase_overlay()
    do i = size(self%wing_masks), 1, -1 ! as in FLUSI, which draws the right wing first
      call self%wing_masks(i)%draw(self%params%wings(i)%solid, frame_of(self%poses(i)), self%surfaces(i)%color, penalty)
      self%cells = self%cells + self%wing_masks(i)%n_cells
    end do
  end subroutine draw_solids

  !> Returns the wing as a moving frame.
  pure type(body_t) function frame_of(pose) result(frame)
    type(wing_pose_t), intent(in) :: pose
    frame%centre = pose%hinge
    frame%velocity = pose%hinge_velocity
    frame%acceleration = pose%hinge_acceleration
    frame%rotation%matrix = pose%matrix
    frame%rotation%omega = pose%omega
    frame%rotation%omega_rate = pose%omega_rate
  end function frame_of

  !> Returns the sums over the points of displaced volume times exact acceleration; see moving_solids_t.
  subroutine wings_momentum_rate(self, centre, force, moment)
    class(flapping_wings_t), intent(in) :: self
    real(rp), intent(in) :: centre(3)
    real(rp), intent(inout) :: force(3, 0:N_COLORS - 1)
    real(rp), intent(inout) :: moment(3, 0:N_COLORS - 1)
    real(rp) :: rate(3)
    integer :: i, p
    if (self%has_body()) call self%params%solid%momentum_rate(self%body, centre, force(:, COLOR_BODY), moment(:, COLOR_BODY))
    do i = 1, size(self%surfaces)
      associate (c => self%surfaces(i)%color)
        if (self%draws_solids()) then
          call self%params%wings(i)%solid%momentum_rate(frame_of(self%poses(i)), centre, force(:, c), moment(:, c))
          cycle
        end if
        do p = 1, size(self%surfaces(i)%points, 2)
          rate = self%displaced(i)%volumes(p)*acceleration(self, i, p)
          force(:, c) = force(:, c) + rate
          moment(:, c) = moment(:, c) + cross(self%surfaces(i)%points(:, p) - centre, rate)
        end do
      end associate
    end do
  end subroutine wings_momentum_rate

  !> Returns the acceleration in space of point p of wing i, L/T^2.
  pure function acceleration(self, i, p) result(a)
    type(flapping_wings_t), intent(in) :: self
    integer, intent(in) :: i, p
    real(rp) :: a(3)
    associate (pose => self%poses(i), x => self%params%wings(i)%points(:, p))
      if (allocated(self%deformation)) then
        associate (bent => self%deformation(i))
          a = pose%acceleration_at(x + bent%u(:, p)) + &
              pose%vector_to_space(2*cross(pose%omega, bent%v(:, p)) + bent%a(:, p))
        end associate
      else
        a = pose%acceleration_at(x)
      end if
    end associate
  end function acceleration

  !> Returns d/dt int chi u_s^2/2 dV of wing i [rho L^5/T^3], the power that accelerates the fluid inside the mask.
  real(rp) function wings_inertial_power_of_fluid(self, i) result(power)
    class(flapping_wings_t), intent(in) :: self
    integer, intent(in) :: i
    integer :: p
    power = 0
    if (self%draws_solids()) then
      power = self%params%wings(i)%solid%power_of_fluid(frame_of(self%poses(i)))
      return
    end if
    do p = 1, size(self%surfaces(i)%points, 2)
      power = power + self%displaced(i)%volumes(p)* &
              dot_product(self%surfaces(i)%velocities(:, p), acceleration(self, i, p))
    end do
  end function wings_inertial_power_of_fluid

  !> Returns d/dt of the kinetic energy of wing i itself [rho L^5/T^3]: of its masses if it deforms, else of its inertia tensor,
  !> and of its mass if the hinge moves.
  real(rp) function wings_inertial_power(self, i) result(power)
    class(flapping_wings_t), intent(in) :: self
    integer, intent(in) :: i
    integer :: p
    if (allocated(self%deformation)) then
      power = 0
      do p = 1, size(self%masses)
        power = power + self%masses(p)*dot_product(self%surfaces(i)%velocities(:, p), acceleration(self, i, p))
      end do
    else
      associate (pose => self%poses(i))
        power = dot_product(pose%omega, matmul(self%params%wings(i)%inertia, pose%omega_rate))
        if (self%motion%moves()) power = power + hinge_power(pose, self%params%wings(i)%moments)
      end associate
    end if
  end function wings_inertial_power

  !> Returns the contribution of the hinge's motion to d/dt of the kinetic energy of a rigid wing.
  pure real(rp) function hinge_power(pose, m) result(power)
    type(wing_pose_t), intent(in) :: pose
    type(moments_t), intent(in) :: m
    real(rp) :: v(3), a(3)
    v = pose%vector_to_wing(pose%hinge_velocity)
    a = pose%vector_to_wing(pose%hinge_acceleration)
    associate (w => pose%omega, s => m%first)
      power = m%mass*dot_product(v, a) + dot_product(a, cross(w, s)) + &
              dot_product(v, cross(pose%omega_rate, s) + cross(w, cross(w, s)))
    end associate
  end function hinge_power

  !> Sets the point about which moments are taken to the body's centre; see moving_solids_t.
  subroutine wings_refer(self, centre)
    class(flapping_wings_t), intent(in) :: self
    real(rp), intent(inout) :: centre(3)
    if (self%motion%moves()) centre = self%body%centre
  end subroutine wings_refer

  !> Gives a free body the forces of all of its parts, and finds its acceleration; see moving_solids_t.
  subroutine wings_feel(self, sums)
    class(flapping_wings_t), intent(inout) :: self
    type(sums_t), intent(in) :: sums
    integer :: i
    if (.not. allocated(self%flyer)) return
    call self%flyer%feel(self%time, sum(sums%force(:, COLOR_BODY:), 2), sum(sums%moment(:, COLOR_BODY:), 2), &
                         self%whole(self%time))
    self%body%acceleration = self%flyer%state%acceleration
    self%body%rotation%omega_rate = self%flyer%state%omega_rate
    do i = 1, size(self%poses)
      associate (wing => self%params%wings(i))
        call pose_wing(self%body, wing%mount, wing%motion, self%time, self%poses(i))
      end associate
    end do
  end subroutine wings_feel

  !> Returns the masses of a free flyer with their positions and motion relative to the body at `time` [T], without the fluid that
  !> they displace unless the flyer carries it. With `ahead` the masses of a deforming wing continue their motion for this time.
  function wings_whole(self, time, ahead) result(whole)
    class(flapping_wings_t), intent(in) :: self
    real(rp), intent(in) :: time
    real(rp), intent(in), optional :: ahead
    type(whole_t) :: whole
    type(wing_pose_t) :: pose
    real(rp) :: x(3), v(3), a(3), r(3), h, fraction
    integer :: i, p
    h = 0
    if (present(ahead)) h = ahead
    fraction = merge(0.0_rp, 1.0_rp, self%flyer%params%carries_fluid)
    call whole%add_part(self%flyer%body%minus(self%flyer%displaced))
    do i = 1, size(self%surfaces)
      associate (wing => self%params%wings(i), volumes => self%displaced(i)%volumes)
        call pose_wing(body_t(), wing%mount, wing%motion, time, pose)
        if (allocated(self%deformation)) then
          associate (bent => self%deformation(i), w => pose%omega)
            do p = 1, size(self%masses)
              x = wing%points(:, p) + bent%u(:, p) + h*(bent%v(:, p) + h/2*bent%a(:, p))
              v = bent%v(:, p) + h*bent%a(:, p)
              a = bent%a(:, p) + 2*cross(w, v) + cross(pose%omega_rate, x) + cross(w, cross(w, x))
              r = pose%point_to_space(x)
              call whole%add_point(self%masses(p) - fraction*volumes(p), r, pose%vector_to_space(v + cross(w, x)), &
                                   pose%vector_to_space(a))
              whole%heavy = whole%heavy + self%masses(p)*r
            end do
          end associate
        else
          associate (m => wing%moments)
            call whole%add_moving(m%minus(moments_of_points(fraction*volumes, wing%points)), pose%hinge, &
                                  transpose(pose%matrix), pose%omega, pose%omega_rate)
            whole%heavy = whole%heavy + m%mass*pose%hinge + pose%vector_to_space(m%first)
          end associate
        end if
      end associate
    end do
  end function wings_whole

  !> Returns the masses of the insect and of the fluid that it displaces, wings unbent, in the body's frame at `time` [T].
  function wings_own(self, time) result(own)
    class(flapping_wings_t), intent(in) :: self
    real(rp), intent(in) :: time
    type(whole_t) :: own
    type(wing_pose_t) :: pose
    type(moments_t) :: m
    integer :: i
    call own%add_part(self%flyer%body)
    do i = 1, size(self%surfaces)
      associate (wing => self%params%wings(i))
        call pose_wing(body_t(), wing%mount, wing%motion, time, pose)
        m = wing%moments
        if (allocated(self%deformation)) m = moments_of_points(self%masses, wing%points)
        call own%add_moving(m, pose%hinge, transpose(pose%matrix), pose%omega, pose%omega_rate)
      end associate
    end do
  end function wings_own

  !> Returns the force [rho L^4/T^2] and the moment about `centre` of the markers of wings without thickness, at the end of the last
  !> step, for which `poses` are the poses of the wings; 0 if no wing is without thickness.
  pure subroutine wings_marker_total(self, poses, centre, force, moment)
    class(flapping_wings_t), intent(in) :: self
    type(wing_pose_t), intent(in) :: poses(:)
    real(rp), intent(in) :: centre(3)
    real(rp), intent(out) :: force(3), moment(3)
    integer :: i
    force = 0
    moment = 0
    if (.not. allocated(self%marker_loads)) return
    do i = 1, size(self%marker_loads)
      associate (load => self%marker_loads(i))
        force = force + load%force
        moment = moment + load%moment ! of the body about its centre, which is `centre`
        if (i <= size(poses)) moment = moment + cross(poses(i)%hinge - centre, load%force)
      end associate
    end do
  end subroutine wings_marker_total

  !> Tells whether there is a body in the mask.
  pure logical function wings_has_body(self) result(has)
    class(flapping_wings_t), intent(in) :: self
    has = self%params%solid%exists()
  end function wings_has_body

  !> Returns a bound [L/T] of |u_s| on all wings and the body; see moving_solids_t.
  real(rp) function wings_max_speed(self) result(speed)
    class(flapping_wings_t), intent(in) :: self
    integer :: i, p
    speed = 0
    if (self%has_body()) speed = self%params%solid%max_speed(self%body)
    do i = 1, size(self%surfaces)
      do p = 1, size(self%surfaces(i)%velocities, 2)
        speed = max(speed, norm2(self%surfaces(i)%velocities(:, p)))
      end do
    end do
  end function wings_max_speed
end module fsi_flapping_wings

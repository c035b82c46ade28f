! SPDX-License-Identifier: GPL-3.0-or-later
!> Advances the fluid: it combines transforms, right-hand side and time step.
module fluid_solver
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use fluid_bodies, only: draw_bodies
  use fluid_inflow, only: inflow_t
  use fluid_flow_fields, only: flow_field
  use fluid_initial, only: is_uniform, set_mean
  use fluid_initial_keys, only: FLOW_MEAN
  use fluid_mean_flow, only: mean_response
  use fluid_moving_solids, only: moving_solids_t
  use fluid_params, only: fluid_params_t, SCHEME_AB2, SCHEME_EULER, SCHEME_RK2
  use fluid_point_forces, only: point_forces_t
  use fluid_requests, only: request_t, PASS_EVALUATE, PASS_AB2, PASS_RK_FIRST, PASS_RK_FOURTH, PASS_HEUN_FIRST, &
                            PASS_HEUN_SECOND, pass_begin
  use fluid_rhs, only: rhs_t
  use fluid_sponge, only: make_sponge
  use fluid_sums, only: sums_t
  use parallel_block, only: allocate_fields
  use parallel_world, only: world_t
  use spectral_backends, only: make_transform, transform_choices_t
  use spectral_transform, only: transform_t
  implicit none
  private
  public :: fluid_t

  type :: fluid_t
    class(transform_t), allocatable :: transform
    type(rhs_t) :: rhs
    type(inflow_t), private :: inflow       !< of the channel that has one
    real(rp) :: unsteady_force(3, 0:5) = 0  !< d/dt int chi u_s at the time of `sums`
    real(rp) :: unsteady_moment(3, 0:5) = 0
    type(sums_t) :: sums                    !< integrals of the last pass
    real(rp) :: sums_time = 0               !< time they belong to
    real(rp) :: dt = 0                      !< length of the step that began at that time
    type(point_forces_t), allocatable :: points !< points at which the flow is sampled and pushed, see `hold_points`
    logical, private :: has_pressure = .false. !< the last pass kept the pressure
    logical, private :: has_flow = .false.     !< the pass that `sums` are of kept the flow
    logical, private :: has_begun = .false.    !< the initial flow has served, but for `flow_field`
    logical, private :: accepted = .false.     !< the last pass is a trial with which the next step begins
  contains
    procedure :: init => fluid_init
    procedure :: start => fluid_start
    procedure :: step => fluid_step
    procedure :: evaluate => fluid_evaluate
    procedure :: try => fluid_try
    procedure :: accept => fluid_accept
    procedure :: pressure_field => fluid_pressure_field
    procedure :: flow_field => fluid_flow_field
    procedure :: hold_points => fluid_hold_points
    procedure :: velocities_at_points => fluid_velocities_at_points
    procedure :: push_at_points => fluid_push_at_points
    procedure :: free => fluid_free
    procedure :: memory_bytes => fluid_memory_bytes
  end type fluid_t

contains

  !> Builds transform, mask and sponge. Fails if there is no such transform or the mask has no sense. The process grid
  !> must exist (`process_grid`). Collective.
  subroutine fluid_init(self, world, params, keeps_fields, failure, keeps_pressure, keeps_rhs)
    class(fluid_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(fluid_params_t), intent(in) :: params
    logical, intent(in) :: keeps_fields !< whether fields will be asked for
    type(failure_t), intent(inout) :: failure
    logical, intent(in), optional :: keeps_pressure !< whether the pressure will; keeps_fields if not given
    logical, intent(in), optional :: keeps_rhs !< whether there will be trials; not if not given
    logical :: pressure, rhs
    rhs = .false.
    if (present(keeps_rhs)) rhs = keeps_rhs
    pressure = keeps_fields
    if (present(keeps_pressure)) pressure = keeps_pressure
    associate (r => params%resolution)
      call make_transform(self%transform, world, params%grid, transform_choices_t(r%transform, r%dealias, r%process_rows, &
                                                                                  r%planner), 7, &
                          merge(6, 3, params%sponge%is_on) + merge(1, 0, pressure), failure)
    end associate
    call self%rhs%init(world, params, self%transform%sticks, self%transform%block, keeps_fields, pressure, rhs)
    self%rhs%sponge = make_sponge(params, self%transform%block)
    call draw_bodies(world, params, self%transform%block, self%rhs%penalty, failure)
    if (params%walls%has_inflow) call self%inflow%init(self%rhs%penalty)
  end subroutine fluid_init

  !> Sets the initial condition. Until the first step the flow is the untruncated initial field, as in
  !> FLUSI; truncation starts with the first update. Collective.
  subroutine fluid_start(self, failure)
    class(fluid_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: field(:, :, :, :)
    integer :: c
    associate (rhs => self%rhs, block => self%transform%block)
      if (is_uniform(rhs%params)) then
        if (rhs%params%initial%flow == FLOW_MEAN) call set_mean(self%transform, rhs%params%mean%velocity, rhs%state%u)
        return
      end if
      allocate (rhs%initial)
      call rhs%initial%begin(self%transform, rhs%params, rhs%state%time, failure)
      if (failure%failed) return
      call allocate_fields(field, block, 1, 'a field of the initial condition')
      do c = 1, 3
        call rhs%initial%field(c, field)
        call self%transform%forward(field, rhs%state%u(:, :, c:c))
      end do
      call rhs%initial%rest()
      call truncate_all(rhs)
    end associate
  end subroutine fluid_start

  !> Advances the state by one step and leaves the integrals of its beginning in `sums`. On numerical
  !> failure `failure` tells why, time and step are not advanced, and the velocity is the one that failed:
  !> that of the state, or of a Runge-Kutta stage. `moving` are solids that move; they are placed at the time
  !> of every evaluation, and are left where they were at the time of `sums`. Collective.
  subroutine fluid_step(self, request, failure, moving)
    class(fluid_t), intent(inout) :: self
    type(request_t), intent(in) :: request
    type(failure_t), intent(inout) :: failure
    class(moving_solids_t), intent(inout), optional :: moving
    type(request_t) :: nothing
    integer :: pass, passes(2)
    if (any(self%rhs%params%time%scheme == [SCHEME_AB2, SCHEME_EULER])) then
      if (self%accepted .and. self%rhs%request%covers(request)) then
        call self%rhs%advance_kept()
      else
        call run_pass(self, PASS_AB2, request, moving)
      end if
      self%accepted = .false.
      if (.not. self%rhs%failure%failed) call keep_sums(self, moving)
    else
      passes = [PASS_RK_FIRST, PASS_RK_FOURTH]
      if (self%rhs%params%time%scheme == SCHEME_RK2) passes = [PASS_HEUN_FIRST, PASS_HEUN_SECOND]
      call run_pass(self, passes(1), request, moving)
      if (.not. self%rhs%failure%failed) call keep_sums(self, moving)
      do pass = passes(1) + 1, passes(2)
        if (self%rhs%failure%failed) exit
        call run_pass(self, pass, nothing, moving)
      end do
      ! What is written after the step belongs to its beginning.
      if (present(moving) .and. .not. self%rhs%failure%failed) call place_solids(self, moving, self%rhs%state%time)
    end if
    if (self%rhs%failure%failed) then
      call failure%raise(self%rhs%failure%reason)
      return
    end if
    associate (state => self%rhs%state)
      state%solid_momentum = self%sums%solid_momentum
      state%solid_moment = self%sums%solid_moment
      state%time = state%time + self%rhs%dt
      state%dt_old = self%rhs%dt
      state%step = state%step + 1
      ! Sums of dt must not leave the run an epsilon short of its end.
      if (abs(self%rhs%params%time%t_max - state%time) <= 1.0e-12_rp*self%rhs%params%time%t_max) &
        state%time = self%rhs%params%time%t_max
    end associate
  end subroutine fluid_step

  !> Computes integrals and fields of the present state without advancing it. Collective.
  subroutine fluid_evaluate(self, request, failure, moving)
    class(fluid_t), intent(inout) :: self
    type(request_t), intent(in) :: request
    type(failure_t), intent(inout) :: failure
    class(moving_solids_t), intent(inout), optional :: moving
    call run_pass(self, PASS_EVALUATE, request, moving)
    if (self%rhs%failure%failed) call failure%raise(self%rhs%failure%reason)
    call keep_sums(self, moving)
  end subroutine fluid_evaluate

  !> Evaluates the present state with solids that may turn out to be elsewhere: `sums` and what belongs to them
  !> stay those of the last step, only `pressure_field` and the fields, if requested, are of this trial. The fluid
  !> must have been built to keep right-hand sides. Costs what a step costs. Collective.
  subroutine fluid_try(self, request, failure, moving)
    class(fluid_t), intent(inout) :: self
    type(request_t), intent(in) :: request
    type(failure_t), intent(inout) :: failure
    class(moving_solids_t), intent(inout) :: moving
    type(request_t) :: complete
    call require(allocated(self%rhs%kept), 'fluid_t: a trial needs a fluid that keeps right-hand sides')
    complete = request
    complete%rhs = .true.
    call run_pass(self, PASS_EVALUATE, complete, moving)
    self%has_pressure = request%pressure
    if (self%rhs%failure%failed) call failure%raise(self%rhs%failure%reason)
  end subroutine fluid_try

  !> Says that the solids are where they were in the last trial, and will be there when the next step begins. An AB2 or Euler step
  !> then begins with that trial instead of repeating it, unless it must compute more. The result is the same to the last bit.
  subroutine fluid_accept(self)
    class(fluid_t), intent(inout) :: self
    call require(self%rhs%request%rhs, 'fluid_t: the last pass was no trial')
    self%accepted = .true.
  end subroutine fluid_accept

  !> Makes one pass of the scheme, which is a whole step of AB2 and Euler: places the solids, then computes the curl, multiplies,
  !> penalizes, projects and advances, as the kernels of `rhs_t` say.
  subroutine run_pass(self, pass, request, moving)
    class(fluid_t), intent(inout) :: self
    integer, intent(in) :: pass
    type(request_t), intent(in) :: request
    class(moving_solids_t), intent(inout), optional :: moving
    self%accepted = .false.
    if (self%has_begun .and. pass_begin(pass) <= 0) call drop_initial_flow(self)
    if (self%rhs%params%walls%has_inflow) &
      call self%inflow%set(self%rhs%params, self%rhs%time_of(pass), self%rhs%penalty)
    if (present(moving)) then
      call place_solids(self, moving, self%rhs%time_of(pass))
      if (self%rhs%failure%failed) return
    end if
    call self%rhs%prepare(pass, request)
    ! In this order: curl | product, penalize | (the step is chosen) | project, advance. A bar is a transform.
    call self%transform%pipeline(self%rhs)
    if (allocated(self%rhs%initial)) call self%rhs%initial%rest()
    self%has_begun = self%has_begun .or. pass /= PASS_EVALUATE
  end subroutine run_pass

  !> Places the solids at `time`, also in the mask, and takes moments about the point that moves with them.
  subroutine place_solids(self, moving, time)
    class(fluid_t), intent(inout) :: self
    class(moving_solids_t), intent(inout) :: moving
    real(rp), intent(in) :: time
    call moving%place(time, self%rhs%penalty, self%rhs%failure)
    if (self%rhs%failure%failed) return
    call moving%refer(self%rhs%params%solids%centre)
    self%rhs%solid_speed = moving%max_speed()
  end subroutine place_solids

  !> Releases the untruncated initial flow, if there is one.
  subroutine drop_initial_flow(self)
    class(fluid_t), intent(inout) :: self
    if (.not. allocated(self%rhs%initial)) return
    call self%rhs%initial%free()
    deallocate (self%rhs%initial)
  end subroutine drop_initial_flow

  !> Keeps the integrals of a pass and completes them by the rate of change of the solids' momentum: exact for
  !> solids whose motion is known, by a backward difference for others.
  subroutine keep_sums(self, moving)
    class(fluid_t), intent(inout) :: self
    class(moving_solids_t), intent(inout), optional :: moving
    self%sums = self%rhs%sums
    self%has_pressure = self%rhs%request%pressure
    self%has_flow = self%rhs%request%flow
    self%dt = self%rhs%dt
    associate (state => self%rhs%state)
      self%sums_time = state%time
      self%unsteady_force = 0
      self%unsteady_moment = 0
      if (present(moving)) then
        call moving%feel(self%sums)
        call moving%momentum_rate(self%rhs%params%solids%centre, self%unsteady_force, self%unsteady_moment)
        return
      end if
      if (.not. self%rhs%params%solids%unsteady_corrections .or. state%step == 0) return
      self%unsteady_force = (self%sums%solid_momentum - state%solid_momentum)/state%dt_old
      self%unsteady_moment = (self%sums%solid_moment - state%solid_moment)/state%dt_old
    end associate
  end subroutine keep_sums

  !> Computes the static pressure of the last pass, which must have kept it (fluid_pressure). On lines that are not wanted it is
  !> undefined. Costs one inverse transform, or parts of it if only some lines are wanted. Collective.
  subroutine fluid_pressure_field(self, p, lines)
    class(fluid_t), intent(inout) :: self
    real(rp), contiguous, target, intent(inout) :: p(:, :, :, :)     !< (nx, ny_local, nz_local, 1)
    logical, contiguous, target, optional, intent(in) :: lines(:, :) !< (ny_local, nz_local) those that are wanted, or all
    call require(self%has_pressure, 'fluid_t: the pressure was not requested')
    call self%rhs%pressure%field(self%transform, p(:, :, :, 1), lines)
  end subroutine fluid_pressure_field

  !> Computes a field of the flow at the beginning of the last pass, which must have kept it: 1 to 3 a component of the velocity,
  !> 4 to 6 one of the vorticity, or VORTICITY_MAGNITUDE of fluid_flow_fields. On lines that are not wanted it is undefined. Costs
  !> one inverse transform, or three for the magnitude. Collective.
  subroutine fluid_flow_field(self, which, field, lines)
    class(fluid_t), intent(inout) :: self
    integer, intent(in) :: which
    real(rp), contiguous, target, intent(inout) :: field(:, :, :, :)  !< (nx, ny_local, nz_local, 1)
    logical, contiguous, target, optional, intent(in) :: lines(:, :)  !< (ny_local, nz_local) those that are wanted, or all
    call require(self%has_flow, 'fluid_t: the flow was not requested')
    if (allocated(self%rhs%initial)) then
      call self%rhs%initial%field(which, field)
    else
      call flow_field(self%transform, self%rhs%past, which, 1, field, lines)
    end if
  end subroutine fluid_flow_field

  !> Makes room for up to `most` points at which other layers sample the flow and push it; `points%place` says where they are.
  subroutine fluid_hold_points(self, most)
    class(fluid_t), intent(inout) :: self
    integer, intent(in) :: most
    associate (t => self%transform)
      allocate (self%points)
      call self%points%init(self%rhs%world, t%grid, t%block, t%sticks, most)
    end associate
  end subroutine fluid_hold_points

  !> Returns the velocities (3, n) [L/T] of the present flow at the points, the same on all ranks. Collective.
  subroutine fluid_velocities_at_points(self, velocities)
    class(fluid_t), intent(inout) :: self
    real(rp), intent(inout) :: velocities(:, :)
    call self%points%sample(self%transform, self%rhs%state%u, velocities)
  end subroutine fluid_velocities_at_points

  !> Applies forces(3, n) [rho L^4/T^2] on the fluid at the points over the last step: the flow at its end changes by step times
  !> force. Collective.
  subroutine fluid_push_at_points(self, forces)
    class(fluid_t), intent(inout) :: self
    real(rp), intent(in) :: forces(:, :)
    associate (state => self%rhs%state)
      call self%points%apply(self%transform, forces, self%dt, mean_response(self%rhs%params, state%time), state%u)
    end associate
  end subroutine fluid_push_at_points

  !> Zeroes all modes outside the truncation.
  subroutine truncate_all(rhs)
    type(rhs_t), intent(inout) :: rhs
    integer :: s, c
    do c = 1, 3
      do s = 1, rhs%sticks%n
        call rhs%sticks%truncate(s, rhs%state%u(:, s, c))
      end do
    end do
  end subroutine truncate_all

  !> Releases plans and communicators. Collective.
  subroutine fluid_free(self)
    class(fluid_t), intent(inout) :: self
    if (allocated(self%rhs%initial)) call self%rhs%initial%free()
    call self%transform%free()
  end subroutine fluid_free

  !> Returns the bytes of this rank's large arrays.
  real(rp) function fluid_memory_bytes(self) result(bytes)
    class(fluid_t), intent(in) :: self
    bytes = self%transform%memory_bytes() + 16*real(size(self%rhs%state%u) + size(self%rhs%state%history), rp)
    if (allocated(self%rhs%fields)) bytes = bytes + 8*real(size(self%rhs%fields), rp)
    bytes = bytes + self%rhs%pressure%memory_bytes()
    if (allocated(self%rhs%past)) bytes = bytes + 16*real(size(self%rhs%past), rp)
    if (allocated(self%rhs%kept)) bytes = bytes + 16*real(size(self%rhs%kept), rp)
    bytes = bytes + self%rhs%stepper%memory_bytes()
    bytes = bytes + 48*real(self%rhs%penalty%n_points, rp)
    if (allocated(self%points)) bytes = bytes + self%points%memory_bytes()
  end function fluid_memory_bytes
end module fluid_solver

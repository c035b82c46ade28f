! SPDX-License-Identifier: GPL-3.0-or-later
!> Advances the fluid: it combines transforms, right-hand side and time step.
module fluid_solver
  use base_errors, only: failure_t, require
  use base_kinds, only: i8, rp
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
  use fluid_sampled_field, only: sampled_field_t
  use fluid_sampling, only: samples_t
  use fluid_sponge, only: make_sponge
  use fluid_sums, only: sums_t
  use parallel_block, only: allocate_fields
  use parallel_world, only: world_t
  use spectral_backends, only: make_transform, transform_choices_t
  use spectral_transform, only: transform_t
  implicit none
  private
  public :: fluid_t, trial_t

  !> A request for an evaluation with the solids at their positions at the beginning of the next step.
  type :: trial_t
    integer(i8), private :: pass = -1
  end type trial_t

  type :: fluid_t
    class(transform_t), allocatable :: transform
    type(rhs_t) :: rhs
    type(inflow_t), private :: inflow       !< of the channel that has one
    real(rp) :: unsteady_force(3, 0:5) = 0  !< d/dt int chi u_s at the time of `sums`
    real(rp) :: unsteady_moment(3, 0:5) = 0
    type(sums_t) :: sums                    !< integrals of the last pass
    real(rp) :: sums_time = 0               !< time of these integrals
    real(rp) :: dt = 0                      !< length of the step that began at that time
    type(point_forces_t), allocatable :: points !< points at which the flow is sampled and forces act on it, see `hold_points`
    type(sampled_field_t), private :: sampled  !< a field near the points where it is sampled, see `hold_samples`
    logical, private :: has_pressure = .false. !< the last pass kept the pressure
    logical, private :: has_flow = .false.     !< the pass that computed `sums` kept the flow
    logical, private :: has_begun = .false.    !< the initial flow is used by `flow_field` only
    integer(i8), private :: n_passes = 0       !< passes made; tells whether a trial is the last pass
  contains
    procedure :: init => fluid_init
    procedure :: start => fluid_start
    procedure :: step => fluid_step
    procedure :: evaluate => fluid_evaluate
    procedure :: try => fluid_try
    procedure :: pressure_field => fluid_pressure_field
    procedure :: flow_field => fluid_flow_field
    procedure :: hold_samples => fluid_hold_samples
    procedure :: sample_pressure => fluid_sample_pressure
    procedure :: sample_flow => fluid_sample_flow
    procedure :: sample_kept_field => fluid_sample_kept_field
    procedure :: hold_points => fluid_hold_points
    procedure :: velocities_at_points => fluid_velocities_at_points
    procedure :: push_at_points => fluid_push_at_points
    procedure :: free => fluid_free
    procedure :: memory_bytes => fluid_memory_bytes
  end type fluid_t

contains

  !> Builds transform, mask and sponge. Fails if the transform does not exist or the mask cannot be drawn. The process grid must
  !> exist (`process_grid`). Collective.
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
  !> of every evaluation, and are left where they were at the time of `sums`.
  !>
  !> An AB2 or Euler step begins with `trial` instead of repeating it, if this was the last pass and nothing more is requested;
  !> the result is the same to the bit. Collective.
  subroutine fluid_step(self, request, failure, moving, trial)
    class(fluid_t), intent(inout) :: self
    type(request_t), intent(in) :: request
    type(failure_t), intent(inout) :: failure
    class(moving_solids_t), intent(inout), optional :: moving
    type(trial_t), intent(in), optional :: trial
    type(request_t) :: nothing
    logical :: has_trial
    integer :: pass, passes(2)
    if (any(self%rhs%params%time%scheme == [SCHEME_AB2, SCHEME_EULER])) then
      has_trial = .false.
      if (present(trial)) has_trial = trial%pass == self%n_passes .and. self%rhs%request%covers(request)
      if (has_trial) then
        self%n_passes = self%n_passes + 1
        call self%rhs%advance_kept()
      else
        call run_pass(self, PASS_AB2, request, moving)
      end if
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
      ! Results that are written after the step belong to its beginning.
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
      ! Because of round-off the sum of dt may end just before t_max.
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

  !> Evaluates the present state with provisional positions of the solids. `sums` and the quantities that belong to them stay those
  !> of the last step; only `pressure_field` and the fields, if requested, belong to this trial. The fluid must have been built to
  !> keep right-hand sides. A step may begin with `trial` if the positions of the solids prove right. A trial costs as much as a
  !> step. Collective.
  subroutine fluid_try(self, request, failure, moving, trial)
    class(fluid_t), intent(inout) :: self
    type(request_t), intent(in) :: request
    type(failure_t), intent(inout) :: failure
    class(moving_solids_t), intent(inout) :: moving
    type(trial_t), intent(out) :: trial
    type(request_t) :: complete
    call require(allocated(self%rhs%kept), 'fluid_t: a trial needs a fluid that keeps right-hand sides')
    complete = request
    complete%rhs = .true.
    call run_pass(self, PASS_EVALUATE, complete, moving)
    self%has_pressure = request%pressure
    trial%pass = self%n_passes
    if (self%rhs%failure%failed) call failure%raise(self%rhs%failure%reason)
  end subroutine fluid_try

  !> Makes one pass of the scheme, which is a whole step of AB2 and Euler.
  subroutine run_pass(self, pass, request, moving)
    class(fluid_t), intent(inout) :: self
    integer, intent(in) :: pass
    type(request_t), intent(in) :: request
    class(moving_solids_t), intent(inout), optional :: moving
    self%n_passes = self%n_passes + 1
    if (self%has_begun .and. pass_begin(pass) <= 0) call drop_initial_flow(self)
    if (self%rhs%params%walls%has_inflow) &
      call self%inflow%set(self%rhs%params, self%rhs%time_of(pass), self%rhs%penalty)
    if (present(moving)) then
      call place_solids(self, moving, self%rhs%time_of(pass))
      if (self%rhs%failure%failed) return
    end if
    call self%rhs%prepare(pass, request)
    call self%rhs%take_curl_multiply_and_penalise(self%transform)
    call self%rhs%choose_step()
    if (.not. self%rhs%failure%failed) call self%rhs%project_and_advance(self%transform)
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

  !> Keeps the integrals of a pass and adds the rate of change of the momentum of the solids. It is exact for solids whose motion is
  !> known, and a backward difference for others.
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

  !> Computes the static pressure of the last pass, which must have kept it (fluid_pressure). Costs one inverse transform.
  !> Collective.
  subroutine fluid_pressure_field(self, p)
    class(fluid_t), intent(inout) :: self
    real(rp), contiguous, target, intent(inout) :: p(:, :, :, :) !< (nx, ny_local, nz_local, 1)
    call require(self%has_pressure, 'fluid_t: the pressure was not requested')
    call self%rhs%pressure%field(self%transform, p(:, :, :, 1))
  end subroutine fluid_pressure_field

  !> Computes a field of the flow at the beginning of the last pass, which must have kept it: 1 to 3 a component of the velocity,
  !> 4 to 6 one of the vorticity, or VORTICITY_MAGNITUDE of fluid_flow_fields. Costs one inverse transform, or three for the
  !> magnitude. Collective.
  subroutine fluid_flow_field(self, which, field)
    class(fluid_t), intent(inout) :: self
    integer, intent(in) :: which
    real(rp), contiguous, target, intent(inout) :: field(:, :, :, :) !< (nx, ny_local, nz_local, 1)
    call require(self%has_flow, 'fluid_t: the flow was not requested')
    if (allocated(self%rhs%initial)) then
      call self%rhs%initial%field(which, field)
    else
      call flow_field(self%transform, self%rhs%past, which, 1, field)
    end if
  end subroutine fluid_flow_field

  !> Allocates the memory for sampling fields at points, unless this was done before.
  subroutine fluid_hold_samples(self)
    class(fluid_t), intent(inout) :: self
    if (allocated(self%sampled%values)) return
    associate (t => self%transform)
      call self%sampled%init(self%rhs%world, t%grid, t%block)
    end associate
  end subroutine fluid_hold_samples

  !> Samples the field of `pressure_field` at the points of all `samples`. All samples together cost at most as much as
  !> `pressure_field`. Needs `hold_samples`. Collective.
  subroutine fluid_sample_pressure(self, samples)
    class(fluid_t), intent(inout) :: self
    type(samples_t), intent(inout) :: samples(:)
    call require(self%has_pressure, 'fluid_t: the pressure was not requested')
    call self%sampled%choose_lines(samples)
    call self%rhs%pressure%field(self%transform, self%sampled%values(:, :, :, 1), self%sampled%lines)
    call self%sampled%sample(samples)
  end subroutine fluid_sample_pressure

  !> Samples the field of `flow_field` in the same way. Collective.
  subroutine fluid_sample_flow(self, which, samples)
    class(fluid_t), intent(inout) :: self
    integer, intent(in) :: which
    type(samples_t), intent(inout) :: samples(:)
    call require(self%has_flow, 'fluid_t: the flow was not requested')
    call self%sampled%choose_lines(samples)
    if (allocated(self%rhs%initial)) then
      call self%rhs%initial%field(which, self%sampled%values)
    else
      call flow_field(self%transform, self%rhs%past, which, 1, self%sampled%values, self%sampled%lines)
    end if
    call self%sampled%sample(samples)
  end subroutine fluid_sample_flow

  !> Samples field `which`, 1 to 6, of the fields that the last pass kept on request. Costs no transform. Collective.
  subroutine fluid_sample_kept_field(self, which, samples)
    class(fluid_t), intent(in) :: self
    integer, intent(in) :: which
    type(samples_t), intent(inout) :: samples(:)
    call self%sampled%sample_other(self%rhs%fields(:, :, :, which), samples)
  end subroutine fluid_sample_kept_field

  !> Makes room for up to `most` points at which other layers sample the flow and apply forces; `points%place` sets their positions.
  !> `rhs%reader` reads the flow at as many points in a pass.
  subroutine fluid_hold_points(self, most)
    class(fluid_t), intent(inout) :: self
    integer, intent(in) :: most
    associate (t => self%transform)
      allocate (self%points)
      call self%points%init(self%rhs%world, t%grid, t%block, t%sticks, most)
      call self%rhs%reader%init(self%rhs%world, t%grid, t%block, self%points%radius, self%rhs%params%is_spherical, most)
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
    bytes = bytes + self%rhs%stepper%memory_bytes() + self%rhs%reader%memory_bytes()
    bytes = bytes + 48*real(self%rhs%penalty%n_points, rp)
    if (allocated(self%points)) bytes = bytes + self%points%memory_bytes()
    bytes = bytes + self%sampled%memory_bytes()
  end function fluid_memory_bytes
end module fluid_solver

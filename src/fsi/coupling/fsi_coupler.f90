! SPDX-License-Identifier: GPL-3.0-or-later
!> Couples flexible wings with the flow by a staggered scheme.
!>
!> At t(n) the deformed wings are drawn and the fluid makes its step to t(n+1). Then every wing makes its step, by BDF2 in its
!> frame at t(n+1), under a load f along its frame:
!>
!>     weak          f(n), as in Truong et al.: first order in the step
!>     extrapolated  f(n) + dt/dt_old (f(n) - f(n-1)): second order
!>     strong        f(n+1) of the flow at t(n+1) about the wing where f(n+1) takes it, by sub-iterations that begin
!>                   with the extrapolated load, f <- f + w (f(flow) - f), w by Aitken's rule over all wings (Kuettler
!>                   & Wall 2008, DOI 10.1007/s00466-008-0255-5): second order
!>
!> AB2 computes u(n+1) from the wings of t(n): a sub-iteration changes the pressure of t(n+1) only. The last one is also the pass
!> with which the next step begins. Wings without thickness and the forces of the flow on them are advanced together
!> (fsi_thin_coupling).
!>
!> The mechanics are in SI units along the axes of the wing file, the flow in L, T and rho, and output along the frame of each
!> wing (fsi_wing_mirror). This module converts masses, times, the motion of the hinge and the load of the pressure;
!> fsi_wing_deformation, fsi_thin_coupling and fsi_flow_reaction convert the rest, and fsi_restart turns what a checkpoint holds.
module fsi_coupler
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use base_text, only: number_text
  use fluid_requests, only: request_t
  use fluid_sampling, only: samples_t
  use fluid_solver, only: fluid_t, trial_t
  use fsi_coupler_params, only: coupler_params_t, COUPLING_STRONG, COUPLING_WEAK
  use fsi_coupling_history, only: coupling_history_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_pressure_load, only: pressure_load_t
  use fsi_surface_load, only: surface_load_t, total_load
  use fsi_thin_coupling, only: advance_thin_wings, thin_report_t
  use fsi_thin_wings, only: thin_wings_t
  use fsi_wing_deformation, only: check_deflections, rotate_forces_to_space, set_deformation
  use fsi_wing_energy, only: energy_meter_t, wing_energy_t
  use fsi_wing_mirror, only: mirror_momenta, mirror_vectors
  use fsi_wing_solver, only: wing_solver_t
  use parallel_world, only: world_t
  use solid_dynamics, only: dynamic_state_t
  use solid_inertia, only: measure_motion, momenta_t
  implicit none
  private
  public :: coupler_t

  !> Report on the sub-iterations of the strong coupling.
  type :: coupling_report_t
    integer :: iterations = 0       !< evaluations of the flow in the last step
    real(rp) :: residual = 0        !< of the load at its end, relative
    integer :: steps = 0, total = 0 !< steps with sub-iterations, and all their evaluations, in this run
  end type coupling_report_t

  type :: coupler_t
    type(coupler_params_t) :: params
    !> Data of the wings along the axes of the wing file. These and the following components are the same on all ranks.
    type(dynamic_state_t), allocatable :: states(:)
    type(wing_energy_t), allocatable :: energies(:)      !< at the end of the last step
    type(coupling_history_t) :: history
    type(surface_load_t), allocatable :: loads(:), friction(:) !< of the last sample, in space; its viscous part
    type(coupling_report_t) :: report
    type(trial_t) :: trial                               !< with which the next step of the fluid may begin
    type(pressure_load_t), allocatable :: surfaces(:)    !< of the last sample: pressure jumps, forces on the points
    type(wing_solver_t), allocatable :: wings(:)         !< for their reports
    type(energy_meter_t), allocatable, private :: meters(:)
    type(samples_t), allocatable, private :: samples(:)  !< pressure beside the wings, `n_sets` for each
    integer, private :: n_sets = 1                       !< distances at which the pressure is sampled
    type(world_t), private :: world
    real(rp) :: solver_seconds = 0                       !< wall time that solving wings has taken on this rank so far
    logical :: is_thin = .false.                         !< the wings have no thickness
    logical, private :: has_current_force = .false.               !< `force` is that of the time that the fluid has reached
    !> (3, n, wings) [N] along the axes of the wing file.
    real(rp), dimension(:, :, :), allocatable, private :: force, applied, residual, old_residual
  contains
    procedure :: init => coupler_init
    procedure :: sample_load => coupler_sample_load
    procedure :: advance => coupler_advance
    procedure :: add_request => coupler_add_request
    procedure :: rewind => coupler_rewind
    procedure :: measure => coupler_measure
    procedure :: deform => coupler_deform
    procedure :: surface_load => coupler_surface_load
    procedure :: free => coupler_free
    procedure, private :: sample, solve, subiterate
  end type coupler_t

contains

  !> Makes the wings, unloaded and at rest in their frames, at `time` [T]. `wings` becomes deformable, and `fluid` makes room for
  !> the samples of its pressure that their load needs. Collective.
  subroutine coupler_init(self, world, params, fluid, time, wings)
    class(coupler_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(coupler_params_t), intent(in) :: params
    type(fluid_t), intent(inout) :: fluid
    real(rp), intent(in) :: time
    type(flapping_wings_t), intent(inout) :: wings
    integer :: i, n
    self%world = world
    self%params = params
    n = size(wings%surfaces)
    self%is_thin = wings%params%thin%is_thin
    if (.not. self%is_thin) then
      call fluid%hold_samples()
      if (params%extrapolates) self%n_sets = 2
      allocate (self%samples(n*self%n_sets))
      do i = 1, size(self%samples)
        call self%samples(i)%init(2*size(wings%surfaces((i - 1)/self%n_sets + 1)%triangles, 2))
      end do
    end if
    allocate (self%force(3, params%model%n_all, n), self%applied(3, params%model%n_all, n), source=0.0_rp)
    if (params%coupling == COUPLING_STRONG .and. .not. self%is_thin) &
      allocate (self%residual(3, params%model%n_all, n), self%old_residual(3, params%model%n_all, n), source=0.0_rp)
    call self%history%init(params%model%n_all, n)
    allocate (self%wings(n), self%surfaces(n), self%meters(n), self%states(n), wings%deformation(n))
    allocate (self%energies(n), self%loads(n), self%friction(n))
    wings%masses = params%inertia%mass(:params%model%n_points)/params%units%mass
    do i = 1, n
      associate (motion => self%wings(i)%motion, given => wings%params%wings(i), bent => wings%deformation(i))
        motion%body = wings%params%body
        motion%carrier = wings%motion
        motion%mount = given%mount
        motion%motion = given%motion
        motion%length = params%units%length
        motion%frequency = 1/params%units%time
        motion%gravity = params%gravity
        motion%is_mirrored = given%is_mirrored
        call self%wings(i)%init(world, params%model, mod(i - 1, world%size))
        call self%surfaces(i)%init(wings%surfaces(i))
        call self%meters(i)%init(params%model, is_mean=self%is_thin)
        call self%states(i)%init(params%model, time*params%units%time)
        allocate (bent%u(3, params%model%n_points), source=0.0_rp)
        allocate (bent%v(3, params%model%n_points), source=0.0_rp)
        allocate (bent%a(3, params%model%n_points), source=0.0_rp)
      end associate
    end do
  end subroutine coupler_init

  !> Adds to `request` what the pass before `sample_load` must have kept.
  pure subroutine coupler_add_request(self, request)
    class(coupler_t), intent(in) :: self
    type(request_t), intent(inout) :: request
    if (self%is_thin) return
    request%pressure = .true.
    request%fields = request%fields .or. self%params%friction
  end subroutine coupler_add_request

  !> Samples the load of the fluid's last pass on the wings. The pass must have kept the fields of `add_request`, and the wings must
  !> not have moved since. The load of wings without thickness is the load of their last step. Collective.
  subroutine coupler_sample_load(self, fluid, wings)
    class(coupler_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(in) :: wings
    if (self%is_thin) then
      call set_loads_from_markers(self, wings)
    else if (.not. self%has_current_force) then
      call self%sample(fluid, wings)
    end if
    self%has_current_force = .false.
  end subroutine coupler_sample_load

  !> Sets `loads` and `surfaces` to the forces on the markers of wings without thickness in the last step.
  subroutine set_loads_from_markers(self, wings)
    class(coupler_t), intent(inout) :: self
    type(flapping_wings_t), intent(in) :: wings
    real(rp) :: on_points(3, self%params%model%n_points)
    integer :: i
    do i = 1, size(self%wings)
      self%loads(i) = wings%marker_loads(i)
      self%force(:, :, i) = self%history%applied(:, :, i)
      call rotate_forces_to_space(self%force(:, :, i), self%params%units, self%wings(i)%motion%is_mirrored, &
                                   wings%poses(i), on_points)
      call self%surfaces(i)%show(wings%surfaces(i), on_points)
    end do
  end subroutine set_loads_from_markers

  !> Sets `force`, `loads` and `friction`.
  subroutine sample(self, fluid, wings)
    class(coupler_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(in) :: wings
    real(rp) :: newton
    integer :: i, k, p, c, first
    associate (u => self%params%units)
      newton = u%mass*u%length/u%time**2
    end associate
    do i = 1, size(self%samples)
      k = mod(i - 1, self%n_sets) + 1
      call wings%surfaces((i - 1)/self%n_sets + 1)%points_beside(k*self%params%distance, self%samples(i)%points)
    end do
    call fluid%sample_pressure(self%samples)
    do i = 1, size(self%wings)
      first = (i - 1)*self%n_sets + 1
      associate (load => self%surfaces(i), surface => wings%surfaces(i), pose => wings%poses(i))
        call load%take_pressure(surface, self%samples(first:first + self%n_sets - 1))
        if (self%params%friction) then
          do c = 1, 3
            call fluid%sample_kept_field(c, self%samples(first:first))
            call load%take_velocity(c, self%samples(first))
          end do
          call load%add_friction(surface, fluid%rhs%params%nu, self%params%distance, wings%params%half_thickness)
        end if
        self%loads(i) = total_load(load%force, surface%points, surface%velocities, pose%hinge)
        self%friction(i) = total_load(load%friction, surface%points, surface%velocities, pose%hinge)
        do p = 1, size(load%force, 2)
          self%force(:, p, i) = newton*pose%vector_to_wing(load%force(:, p))
        end do
        if (self%wings(i)%motion%is_mirrored) call mirror_vectors(self%force(:, :, i))
      end associate
    end do
  end subroutine sample

  !> Advances the wings over a step dt [T] that `fluid` has just made, under the load that the coupling derives from the last
  !> sample. Gives their new deformation to `wings`, for their next placing. Fails if Newton's method or the sub-iterations do not
  !> converge, or if a wing bends beyond the limit; then the run cannot continue from this state.
  !>
  !> `fluid` is needed only by the strong coupling, which leaves the wings at the end of the step, and by wings without thickness,
  !> which change the flow. Wings without thickness also need `thin`. Collective.
  subroutine coupler_advance(self, dt, wings, failure, fluid, thin)
    class(coupler_t), intent(inout) :: self
    real(rp), intent(in) :: dt
    type(flapping_wings_t), intent(inout) :: wings
    type(failure_t), intent(inout) :: failure
    type(fluid_t), intent(inout), optional :: fluid
    type(thin_wings_t), intent(inout), optional :: thin
    integer :: i
    associate (p => self%params, seconds => self%params%units%time)
      call self%history%extrapolate(dt, self%force, self%applied)
      if (p%coupling == COUPLING_WEAK .or. self%is_thin) self%applied = self%force
      do i = 1, size(self%wings)
        associate (before => self%history%applied(:, :, i))
          if (self%history%old_dt <= 0) before = self%applied(:, :, i)
          call self%meters(i)%begin(p%model, p%inertia, self%wings(i)%motion, self%states(i), before, &
                                    self%history%old_dt <= 0, self%energies(i))
        end associate
        call self%wings(i)%begin(self%states(i))
      end do
      self%history%force = self%force
      if (self%is_thin) then
        call require(present(fluid) .and. present(thin), 'coupler_t: wings without thickness need markers and the fluid')
        call advance_thin(self, fluid, wings, thin, failure)
      else if (wings%time + dt <= p%release) then
        do i = 1, size(self%wings)
          self%states(i)%time = self%states(i)%time + dt*seconds
        end do
      else
        call self%solve(dt, wings, failure)
        if (p%coupling == COUPLING_STRONG) then
          call require(present(fluid), 'coupler_t: the strong coupling needs the fluid')
          call self%subiterate(dt, wings, fluid, failure)
        end if
      end if
      if (.not. self%is_thin) call check_deflections(wings, p%largest_deflection, failure)
      if (failure%failed) return
      call self%history%record_step(dt, self%applied)
      do i = 1, size(self%wings)
        call self%meters(i)%finish(p%model, p%inertia, self%wings(i)%motion, self%states(i), self%applied(:, :, i), &
                                   dt*seconds, self%energies(i))
      end do
    end associate
  end subroutine coupler_advance

  !> Gives the wings the shape and rates that they had before a failed `advance`, at `time` [T]. Collective.
  subroutine coupler_rewind(self, time, wings)
    class(coupler_t), intent(inout) :: self
    real(rp), intent(in) :: time
    type(flapping_wings_t), intent(inout) :: wings
    integer :: i
    do i = 1, size(self%wings)
      call self%wings(i)%rewind(self%world, self%states(i))
      self%states(i)%time = time*self%params%units%time
    end do
    call self%deform(wings)
  end subroutine coupler_rewind

  !> Makes the step of all wings without thickness, with the change of the flow by their forces; sets `applied`.
  subroutine advance_thin(self, fluid, wings, thin, failure)
    class(coupler_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(inout) :: wings
    type(thin_wings_t), intent(inout) :: thin
    type(failure_t), intent(inout) :: failure
    type(thin_report_t) :: step
    real(rp) :: begun
    begun = wall_seconds()
    call advance_thin_wings(thin, fluid, wings, self%params, self%wings, self%states, self%applied, step, failure)
    self%solver_seconds = self%solver_seconds + wall_seconds() - begun
    associate (report => self%report)
      report%iterations = step%passes
      report%residual = step%distance
      report%steps = report%steps + 1
      report%total = report%total + step%passes
    end associate
  end subroutine advance_thin

  !> Makes the step of all wings from its beginning under `applied`.
  subroutine solve(self, dt, wings, failure)
    class(coupler_t), intent(inout) :: self
    real(rp), intent(in) :: dt
    type(flapping_wings_t), intent(inout) :: wings
    type(failure_t), intent(inout) :: failure
    real(rp) :: begun
    integer :: i
    begun = wall_seconds()
    associate (p => self%params)
      do i = 1, size(self%wings)
        call self%wings(i)%solve(p%model, p%inertia, p%options, self%applied(:, :, i), dt*p%units%time, self%states(i))
      end do
    end associate
    self%solver_seconds = self%solver_seconds + wall_seconds() - begun
    do i = 1, size(self%wings)
      call self%wings(i)%broadcast(self%world, self%states(i), failure)
    end do
    if (.not. failure%failed) call self%deform(wings)
  end subroutine solve

  !> Repeats the step of the wings until the applied load equals the load at the end of the step.
  subroutine subiterate(self, dt, wings, fluid, failure)
    class(coupler_t), intent(inout) :: self
    real(rp), intent(in) :: dt
    type(flapping_wings_t), intent(inout) :: wings
    type(fluid_t), intent(inout) :: fluid
    type(failure_t), intent(inout) :: failure
    type(request_t) :: request
    type(trial_t) :: trial
    real(rp) :: scale, error
    integer :: k
    call self%add_request(request)
    error = 0
    scale = 0
    do k = 1, self%params%iterations
      if (failure%failed) return
      call fluid%try(request, failure, wings, trial)
      if (failure%failed) return
      call self%sample(fluid, wings)
      self%residual = self%force - self%applied
      error = norm2(self%residual)
      scale = norm2(self%force)
      if (error <= self%params%tolerance*scale) then
        self%trial = trial
        self%has_current_force = .true.
        exit
      end if
      call self%history%relax(k == 1, self%residual, self%old_residual, self%applied)
      if (k < self%params%iterations) call self%solve(dt, wings, failure)
    end do
    associate (report => self%report)
      report%iterations = min(k, self%params%iterations)
      report%residual = error/max(scale, tiny(scale))
      report%steps = report%steps + 1
      report%total = report%total + report%iterations
      if (.not. self%has_current_force .and. .not. failure%failed) &
        call failure%raise('the strong coupling has not converged: after '//number_text(real(report%iterations, rp))// &
                           ' sub-iterations the load still changes by the fraction '//number_text(report%residual)// &
                           ': set a smaller [Time] CFL or more [Flexible_wing] coupling_iterations')
    end associate
  end subroutine subiterate

  !> Gives the deformation that `states` hold to `wings`, for their next placing.
  subroutine coupler_deform(self, wings)
    class(coupler_t), intent(in) :: self
    type(flapping_wings_t), intent(inout) :: wings
    integer :: i
    do i = 1, size(self%states)
      call set_deformation(self%states(i), self%params%units, self%wings(i)%motion%is_mirrored, wings%deformation(i))
    end do
  end subroutine coupler_deform

  !> Returns energy and momentum of wing i at its present state, in SI units, along the axes of the wing frame; see solid_inertia.
  type(momenta_t) function coupler_measure(self, i) result(momenta)
    class(coupler_t), intent(in) :: self
    integer, intent(in) :: i
    associate (p => self%params, state => self%states(i))
      momenta = measure_motion(p%inertia, p%model, self%wings(i)%motion%at(state%time), state%u, state%v)
    end associate
    if (self%wings(i)%motion%is_mirrored) momenta = mirror_momenta(momenta)
  end function coupler_measure

  !> Returns the total force [rho L^4/T^2], in space, of the load sampled last on wing i.
  function coupler_surface_load(self, i) result(force)
    class(coupler_t), intent(in) :: self
    integer, intent(in) :: i
    real(rp) :: force(3)
    force = self%loads(i)%force
  end function coupler_surface_load

  !> Releases everything.
  subroutine coupler_free(self)
    class(coupler_t), intent(inout) :: self
    integer :: i
    if (.not. allocated(self%wings)) return
    do i = 1, size(self%wings)
      call self%wings(i)%free()
    end do
  end subroutine coupler_free
end module fsi_coupler

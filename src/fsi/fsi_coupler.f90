! SPDX-License-Identifier: GPL-3.0-or-later
!> The weak staggered coupling of flexible wings with the flow.
!>
!> At t(n) the deformed wings are drawn and the fluid goes from t(n) to t(n+1); then every wing does, by BDF2 in its
!> frame at t(n+1), under the pressure of t(n) on the surface of t(n), as in Truong et al. The mechanics works in SI
!> units, the flow in L, T and rho; all conversions are here.
module fsi_coupler
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_pressure_load, only: pressure_load_t
  use fsi_sampling, only: sampler_t
  use fsi_wing_frame, only: flapping_motion_t
  use io_units, only: unit_scales_t
  use parallel_block, only: block_t
  use parallel_world, only: world_t
  use solid_dynamics, only: dynamic_options_t, dynamic_state_t, dynamics_t, step_report_t
  use solid_inertia, only: inertia_t, measure_motion, momenta_t
  use solid_model, only: solid_model_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: coupler_t, coupler_params_t

  !> What the wings are made of; both have the same, as mirror images. SI units.
  type :: coupler_params_t
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(dynamic_options_t) :: options
    real(rp) :: membrane = 0            !< [kg/m^2] mean mass of the membrane, for information
    type(unit_scales_t) :: units        !< SI values of one L, T and M
    real(rp) :: gravity(3) = 0          !< [m/s^2] in space
    real(rp) :: distance = 0            !< of the places where the pressure is taken from the surface, L
    real(rp) :: release = 0             !< the wings are held rigid until then, T
    real(rp) :: largest_deflection = 1  !< of any point, over the wing length: beyond it the run stops
  end type coupler_params_t

  !> Of one wing.
  type :: flexible_wing_t
    type(flapping_motion_t) :: motion
    type(pressure_load_t) :: load
    type(dynamics_t) :: stepper
    real(rp), allocatable :: force(:, :)  !< (3, n_all) [N] in the wing frame
    integer :: owner = 0                  !< rank that solves it
    type(step_report_t) :: report         !< of the last step, on the owner
  end type flexible_wing_t

  type :: coupler_t
    type(coupler_params_t) :: params
    type(dynamic_state_t), allocatable :: states(:)      !< of the wings, the same on all ranks
    type(flexible_wing_t), allocatable, private :: wings(:)
    type(sampler_t), private :: sampler
    type(world_t), private :: world
    real(rp), allocatable, private :: pressure(:, :, :, :), packed(:)
  contains
    procedure :: init => coupler_init
    procedure :: look => coupler_look
    procedure :: advance => coupler_advance
    procedure :: measure => coupler_measure
    procedure :: deform => coupler_deform
    procedure :: surface_load => coupler_surface_load
    procedure :: point_loads => coupler_point_loads
    procedure :: newton_iterations => coupler_newton_iterations
    procedure :: free => coupler_free
  end type coupler_t

contains

  !> Wings at rest in their frames, unloaded, at time `time` [T]. `wings` becomes deformable. Collective.
  subroutine coupler_init(self, world, params, grid, block, time, wings)
    class(coupler_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(coupler_params_t), intent(in) :: params
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    real(rp), intent(in) :: time
    type(flapping_wings_t), intent(inout) :: wings
    integer :: i, n
    self%world = world
    self%params = params
    n = size(wings%surfaces)
    call self%sampler%init(world, grid, block)
    allocate (self%pressure(block%count(1), block%count(2), block%count(3), 1))
    allocate (self%packed(18*params%model%n_all + 2))
    allocate (self%wings(n), self%states(n), wings%deformation(n))
    wings%masses = params%inertia%mass(:params%model%n_points)/params%units%mass
    do i = 1, n
      associate (wing => self%wings(i), given => wings%params%wings(i), bent => wings%deformation(i))
        wing%motion%body = wings%params%body
        wing%motion%mount = given%mount
        wing%motion%motion = given%motion
        wing%motion%length = params%units%length
        wing%motion%frequency = 1/params%units%time
        wing%motion%gravity = params%gravity
        wing%owner = mod(i - 1, world%size)
        call wing%load%init(wings%surfaces(i))
        allocate (wing%force(3, params%model%n_all), source=0.0_rp)
        if (wing%owner == world%rank) call wing%stepper%init(params%model)
        call self%states(i)%init(params%model, time*params%units%time)
        allocate (bent%u(3, params%model%n_points), source=0.0_rp)
        allocate (bent%v(3, params%model%n_points), source=0.0_rp)
        allocate (bent%a(3, params%model%n_points), source=0.0_rp)
      end associate
    end do
  end subroutine coupler_init

  !> Takes the pressure of the fluid's last pass, which must have kept it, on the wings, which must still be where
  !> they were in that pass. Collective.
  subroutine coupler_look(self, fluid, wings)
    class(coupler_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(in) :: wings
    integer :: i
    call fluid%pressure_field(self%pressure)
    do i = 1, size(self%wings)
      call self%wings(i)%load%look(wings%surfaces(i), self%sampler, self%pressure(:, :, :, 1), self%params%distance)
      call to_wing(self, i, wings)
    end do
  end subroutine coupler_look

  !> Takes the wings over a step dt [T] under the load last looked at; gives their new deformation to `wings`, for
  !> their next placing. Fails if Newton's method does, and if a wing bends beyond the limit; then the run cannot go
  !> on from this state. Collective.
  subroutine coupler_advance(self, dt, wings, failure)
    class(coupler_t), intent(inout) :: self
    real(rp), intent(in) :: dt
    type(flapping_wings_t), intent(inout) :: wings
    type(failure_t), intent(inout) :: failure
    integer :: i
    if (wings%time + dt <= self%params%release) then
      do i = 1, size(self%wings)
        self%states(i)%time = self%states(i)%time + dt*self%params%units%time
      end do
      return
    end if
    do i = 1, size(self%wings)
      associate (wing => self%wings(i), p => self%params)
        if (wing%owner == self%world%rank) call wing%stepper%step(p%model, p%inertia, wing%motion, wing%force, &
                                                                dt*p%units%time, p%options, self%states(i), wing%report)
      end associate
    end do
    do i = 1, size(self%wings)
      call share(self, i, failure)
    end do
    if (.not. failure%failed) call self%deform(wings)
    if (failure%failed) return
    do i = 1, size(self%wings)
      if (sqrt(maxval(sum(wings%deformation(i)%u**2, 1))) > self%params%largest_deflection* &
          wings%params%wings(i)%length()) call failure%raise('the '//trim(wings%params%wings(i)%side)// &
                                                      ' wing bends beyond the limit [Flexible_wing] largest_deflection')
    end do
  end subroutine coupler_advance

  !> The load of wing i from space and code units to its frame and newtons.
  subroutine to_wing(self, i, wings)
    class(coupler_t), intent(inout) :: self
    integer, intent(in) :: i
    type(flapping_wings_t), intent(in) :: wings
    real(rp) :: newton
    integer :: p
    associate (u => self%params%units, wing => self%wings(i))
      newton = u%mass*u%length/u%time**2
      do p = 1, size(wing%load%force, 2)
        wing%force(:, p) = newton*wings%poses(i)%vector_to_wing(wing%load%force(:, p))
      end do
    end associate
  end subroutine to_wing

  !> Gives the new state of wing i to all ranks.
  subroutine share(self, i, failure)
    class(coupler_t), intent(inout) :: self
    integer, intent(in) :: i
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: reason
    logical :: is_packed
    integer :: n, verdict
    is_packed = .false.
    associate (state => self%states(i), wing => self%wings(i))
      verdict = 0
      if (wing%owner == self%world%rank) verdict = merge(0, 1, wing%report%converged)
      if (self%world%max_integer(verdict) > 0) then
        if (wing%owner == self%world%rank) reason = wing%report%reason
        call self%world%broadcast_text(reason, from=wing%owner)
        call failure%raise('a wing cannot be advanced: '//reason)
        return
      end if
      n = 0
      call move(state%u)
      call move(state%v)
      call move(state%g)
      call move(state%old_u)
      call move(state%old_v)
      call move(state%old_g)
      self%packed(n + 1:) = [state%time, state%old_step]
      call self%world%broadcast_reals(self%packed, from=wing%owner)
      is_packed = .true.
      n = 0
      call move(state%u)
      call move(state%v)
      call move(state%g)
      call move(state%old_u)
      call move(state%old_v)
      call move(state%old_g)
      state%time = self%packed(n + 1)
      state%old_step = self%packed(n + 2)
    end associate

  contains

    !> Puts an array behind what is packed, or takes it back from there.
    subroutine move(array)
      real(rp), intent(inout) :: array(:, :)
      integer :: k
      do k = 1, size(array, 2)
        if (is_packed) then
          array(:, k) = self%packed(n + 1:n + 3)
        else
          self%packed(n + 1:n + 3) = array(:, k)
        end if
        n = n + 3
      end do
    end subroutine move
  end subroutine share

  !> Gives the deformation that `states` hold to `wings`, for their next placing.
  subroutine coupler_deform(self, wings)
    class(coupler_t), intent(in) :: self
    type(flapping_wings_t), intent(inout) :: wings
    integer :: i, n
    n = self%params%model%n_points
    do i = 1, size(self%states)
      associate (state => self%states(i), bent => wings%deformation(i), u => self%params%units)
        bent%u = state%u(:, :n)/u%length
        bent%v = state%v(:, :n)*(u%time/u%length)
        bent%a = 0
        if (state%old_step > 0) bent%a = (state%v(:, :n) - state%old_v(:, :n))/state%old_step*(u%time**2/u%length)
      end associate
    end do
  end subroutine coupler_deform

  !> Energy and momentum of wing i at its present state, SI, components along the wing frame; see solid_inertia.
  type(momenta_t) function coupler_measure(self, i) result(momenta)
    class(coupler_t), intent(in) :: self
    integer, intent(in) :: i
    associate (p => self%params, state => self%states(i))
      momenta = measure_motion(p%inertia, p%model, self%wings(i)%motion%at(state%time), state%u, state%v)
    end associate
  end function coupler_measure

  !> Total force of the pressure on wing i in the last step, in space, rho L^4/T^2.
  function coupler_surface_load(self, i) result(force)
    class(coupler_t), intent(in) :: self
    integer, intent(in) :: i
    real(rp) :: force(3)
    force = sum(self%wings(i)%load%force, 2)
  end function coupler_surface_load

  !> The load of the last look on wing i in space: force (3, n) on its points, rho L^4/T^2, and p_above - p_below (m)
  !> of its triangles, rho L^2/T^2; above is where z of the wing frame points.
  subroutine coupler_point_loads(self, i, force, jump)
    class(coupler_t), intent(in) :: self
    integer, intent(in) :: i
    real(rp), intent(out) :: force(:, :), jump(:)
    force = self%wings(i)%load%force
    jump = self%wings(i)%load%jump
  end subroutine coupler_point_loads

  !> Newton iterations, and with them factorisations, of the last step of the wing that took most. Collective.
  integer function coupler_newton_iterations(self) result(n)
    class(coupler_t), intent(in) :: self
    integer :: i
    n = 0
    do i = 1, size(self%wings)
      if (self%wings(i)%owner == self%world%rank) n = max(n, self%wings(i)%report%iterations)
    end do
    n = self%world%max_integer(n)
  end function coupler_newton_iterations

  !> Releases everything.
  subroutine coupler_free(self)
    class(coupler_t), intent(inout) :: self
    integer :: i
    if (.not. allocated(self%wings)) return
    do i = 1, size(self%wings)
      call self%wings(i)%stepper%free()
    end do
  end subroutine coupler_free
end module fsi_coupler

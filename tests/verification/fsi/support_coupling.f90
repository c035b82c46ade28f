! SPDX-License-Identifier: GPL-3.0-or-later
!> One flapping flexible wing in air at rest, on a grid that is as coarse as the coupling allows: what is proven
!> with it holds on any grid.
module support_coupling
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fsi_coupler, only: coupler_t
  use fsi_coupler_params, only: coupler_params_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flight_params, only: flight_params_t
  use fsi_kinematics, only: body_rotation
  use fsi_rotation, only: angle_t
  use fsi_thin_wings, only: thin_wings_t
  use io_units, only: unit_scales_t
  use parallel_world, only: world_t
  use sample_wings, only: make_fly_wing
  use solid_params, only: default_params, solid_params_t
  use solid_wing, only: wing_t
  use support_fluid, only: box_3d, make_fluid, NL
  implicit none
  private
  public :: flight_t, PERIOD, BOX

  real(rp), parameter :: PERIOD = 1/158.0_rp !< [s] of the wing beat, one T
  real(rp), parameter :: METRE = 6.0e-3_rp   !< one L: the wing has the length 1.5
  real(rp), parameter :: BOX = 3.0_rp        !< L

  !> Choices, and the parts of a run. Set the choices, then `start`.
  type :: flight_t
    integer :: n = 24                        !< points in each direction
    real(rp) :: c_eta = 0.04_rp              !< T
    real(rp) :: dt = 0.01_rp                 !< T
    real(rp) :: density = 1.2_rp             !< [kg/m^3] of the air
    real(rp) :: mass = 250.0e-9_rp           !< [kg] of the wing
    real(rp) :: shift(3) = 0                 !< of everything, L
    real(rp) :: softness = 1                 !< of the wing
    real(rp) :: half_thickness = 0.2_rp      !< of the mask, L
    real(rp) :: smoothing = 0.125_rp         !< of the mask, L
    real(rp) :: distance = 0.45_rp           !< at which the flow is looked at, L
    logical :: is_thin = .false.             !< no thickness: markers in place of the mask
    real(rp) :: spacing = 2                  !< of the markers, in grid spacings
    type(coupler_params_t) :: params         !< coupling, tolerance, friction, damping
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(coupler_t) :: coupler
    type(thin_wings_t) :: thin
    type(failure_t) :: failure
  contains
    procedure :: start => flight_start
    procedure :: step => flight_step
    procedure :: sample => flight_sample
    procedure :: free => flight_free
  end type flight_t

contains

  !> Everything at time 0. Collective.
  subroutine flight_start(self, world)
    class(flight_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(wing_t) :: wing
    type(solid_params_t) :: stiffness
    type(flight_params_t) :: flight
    character(200) :: line
    real(rp) :: stiffness_damping, mass_damping
    integer :: i
    write (line, '(2(a,es24.16))') 'dt_fixed=', self%dt, NL//'[Penalization]'//NL//'eps=', self%c_eta
    call make_fluid(world, box_3d(self%n, BOX)//'[ReynoldsNumber]'//NL//'nu=0.05'//NL// &
                    '[Time]'//NL//'Tmax=1000'//NL//trim(line)//NL//'iPenalization=1'//NL//'iMask=empty'//NL// &
                    '[InitialCondition]'//NL//'inicond=quiescent'//NL, self%fluid, &
                    trials=self%params%needs_trials() .and. .not. self%is_thin)
    wing = make_fly_wing(24, 12)
    stiffness = default_params(wing)
    stiffness%young = stiffness%young/self%softness
    stiffness%plate = stiffness%plate/self%softness
    mass_damping = self%params%inertia%rayleigh_mass
    stiffness_damping = self%params%inertia%rayleigh_stiffness
    call self%params%model%init(wing, stiffness, self%failure)
    call self%params%inertia%init(self%params%model, &
                                  [(self%mass/size(wing%points, 2), i=1, size(wing%points, 2))])
    self%params%inertia%rayleigh_mass = mass_damping
    self%params%inertia%rayleigh_stiffness = stiffness_damping
    self%params%units = unit_scales_t(length=METRE, time=PERIOD, mass=self%density*METRE**3)
    self%params%distance = self%distance

    flight%thin%is_thin = self%is_thin
    flight%thin%spacing = self%spacing*BOX/self%n
    if (.not. self%is_thin) then
      flight%half_thickness = self%half_thickness
      flight%smoothing = self%smoothing
    end if
    flight%body%centre = BOX*[0.5_rp, 0.25_rp, 0.5_rp] + self%shift
    flight%body%rotation = body_rotation(roll=angle_t(value=0.3_rp), pitch=angle_t(value=-0.5_rp), &
                                         yaw=angle_t(value=0.2_rp))
    allocate (flight%wings(1))
    flight%wings(1)%points = wing%points/METRE
    flight%wings(1)%triangles = wing%triangles
    call flight%wings(1)%motion%phi%set_fourier(0.0_rp, [0.6_rp], [0.1_rp])
    call flight%wings(1)%motion%alpha%set_fourier(0.4_rp, [0.1_rp], [0.5_rp])
    call flight%wings(1)%motion%theta%set_constant(0.1_rp)
    flight%wings(1)%motion%ramp = 0.3_rp
    call self%wings%init(flight, self%fluid%rhs%params%grid, self%fluid%transform%block)
    call self%coupler%init(world, self%params, self%fluid, 0.0_rp, &
                           self%wings)
    if (.not. self%is_thin) return
    call self%thin%init(world, self%wings, self%fluid, self%failure)
    call self%thin%init_flexible(self%params%model%points, self%params%units)
  end subroutine flight_start

  !> Steps up to time `t_end` [T], or to the first failure. Collective.
  subroutine flight_step(self, t_end)
    class(flight_t), intent(inout) :: self
    real(rp), intent(in) :: t_end
    type(request_t) :: request
    call self%coupler%add_request(request)
    do while (self%fluid%rhs%state%time < t_end - 0.5_rp*self%dt)
      call self%fluid%step(request, self%failure, self%wings, self%coupler%trial)
      if (self%failure%failed) return
      call self%coupler%sample_load(self%fluid, self%wings)
      call self%coupler%advance(self%fluid%dt, self%wings, self%failure, self%fluid, self%thin)
      if (self%failure%failed) return
    end do
  end subroutine flight_step

  !> Evaluates the flow where it is, with the load of the wing. Collective.
  subroutine flight_sample(self)
    class(flight_t), intent(inout) :: self
    type(request_t) :: request
    call self%coupler%add_request(request)
    request%integrals = .true.
    call self%fluid%evaluate(request, self%failure, self%wings)
    call self%coupler%sample_load(self%fluid, self%wings)
  end subroutine flight_sample

  !> Releases everything.
  subroutine flight_free(self)
    class(flight_t), intent(inout) :: self
    call self%coupler%free()
    call self%fluid%free()
  end subroutine flight_free
end module support_coupling

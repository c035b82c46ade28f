! SPDX-License-Identifier: GPL-3.0-or-later
!> A beam under its own weight against rho g A L^4/(8 E I), and the energy balance of a damped, loaded beam in
!> a frame that turns.
program test_solid_weight
  use base_constants, only: PI, TWO_PI
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use sample_wings, only: make_beam
  use solid_balance, only: balance_t, work_t
  use solid_dynamics, only: dynamic_options_t, dynamic_state_t, dynamics_t, step_report_t
  use solid_equilibrium, only: equilibrium_t
  use solid_inertia, only: inertia_t, measure_motion, momenta_t
  use solid_loads, only: load_t
  use solid_mass, only: lump_mass, mass_params_t, mass_t
  use solid_model, only: solid_model_t
  use solid_motion, only: rotating_motion_t
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_weight()
  call test_balance()
  call t%finish()

contains

  !> A cuticle needle of 20 mm: the deflection of the tip under gravity, a thousandth of the length.
  subroutine test_weight()
    real(rp), parameter :: LENGTH = 0.02_rp, DIAMETER = 1.0e-4_rp, E = 12.58e9_rp, G = 9.81_rp
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(mass_params_t) :: material
    type(mass_t) :: mass
    type(load_t) :: load
    type(equilibrium_t) :: work
    type(static_options_t) :: options
    type(static_report_t) :: report
    type(message_list_t) :: messages
    type(failure_t) :: failure
    real(rp), allocatable :: u(:, :)
    real(rp) :: exact, errors(3), h(3)
    integer :: level, n
    exact = material%vein_density*G*(PI/4*DIAMETER**2)*LENGTH**4/(8*E*(PI/64*DIAMETER**4))
    do level = 1, 3
      n = 10*2**level
      wing = make_beam(n, LENGTH, DIAMETER, [1.0_rp, 0.0_rp, 0.0_rp])
      params = default_params(wing)
      params%young = E
      call model%init(wing, params, failure)
      call lump_mass(wing, material, mass, messages)
      call load%init(model)
      call load%add_gravity(mass%nodal, [0.0_rp, 0.0_rp, -G])
      if (allocated(u)) deallocate (u)
      allocate (u(3, model%n_all), source=0.0_rp)
      call work%init(model)
      call solve_static(work, model, load, .false., options, u, report)
      call work%free()
      call t%check('a beam under its weight has an equilibrium', report%converged)
      h(level) = 1.0_rp/n
      errors(level) = abs(u(3, n + 1) + exact)/exact
    end do
    call t%check_below('the beam sinks by a small part of its length', exact/LENGTH, 1.0e-2_rp)
    ! Large rotations change the tip by about (w/L)^2/2, 2e-5, which is small beside 1/n^2.
    call t%check_below('the tip sinks by rho g A L^4/(8 E I)', errors(3), 1.0_rp/80**2)
    call t%check_order('and the error is of second order', h, errors, 2.0_rp, 0.1_rp)
  end subroutine test_weight

  !> Largest imbalance up to time 1, relative to the largest work, with n steps.
  real(rp) function imbalance(n, all_terms) result(open)
    integer, intent(in) :: n
    logical, intent(out) :: all_terms
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(rotating_motion_t) :: motion
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(balance_t) :: balance
    type(work_t) :: work
    type(momenta_t) :: now
    type(failure_t) :: failure
    real(rp), allocatable :: force(:, :)
    real(rp) :: scale
    integer :: i
    wing = make_beam(5, 1.0_rp, 1.0_rp, [1.0_rp, 0.0_rp, 0.0_rp])
    params = default_params(wing)
    params%young = 64/PI
    params%k_vein = 200
    call model%init(wing, params, failure)
    call inertia%init(model, [0.2_rp, 0.2_rp, 0.2_rp, 0.2_rp, 0.2_rp, 0.1_rp])
    inertia%rayleigh_mass = 0.3_rp
    inertia%rayleigh_stiffness = 0.02_rp
    inertia%nodal(model%movable) = 0.1_rp
    motion%axis = [0.0_rp, 0.6_rp, 0.8_rp]
    motion%through = [0.1_rp, 0.2_rp, -0.1_rp]
    motion%rate = 2
    motion%ramp = 0.7_rp
    motion%gravity = [0.0_rp, 0.5_rp, -1.0_rp]
    options%tolerance = 1.0e-11_rp
    call stepper%init(model)
    call balance%init(model)
    call state%init(model, 0.0_rp)
    allocate (force(3, model%n_all), source=0.0_rp)
    now = measure_motion(inertia, model, motion%at(0.0_rp), state%u, state%v)
    work%start = now%relative_kinetic + now%elastic
    open = 0
    scale = 0
    do i = 1, n
      force(3, 6) = sin(TWO_PI*(i - 1)/n)
      call balance%record(model, inertia, motion%at(state%time), state, force)
      force(3, 6) = sin(TWO_PI*i/n)
      call stepper%step(model, inertia, motion, force, 1.0_rp/n, options, state, report)
      if (.not. report%converged) call t%check('the step converges', .false.)
      call balance%add_step(model, inertia, motion%at(state%time), state, force, 1.0_rp/n, work)
      now = measure_motion(inertia, model, motion%at(state%time), state%u, state%v)
      open = max(open, abs(work%imbalance(now%relative_kinetic + now%elastic)))
      scale = max(scale, abs(work%loads), abs(work%weight), abs(work%frame), abs(work%damped))
    end do
    call stepper%free()
    open = open/scale
    all_terms = minval(abs([work%loads, work%weight, work%frame, work%damped])) > 0.02_rp*scale
  end function imbalance

  subroutine test_balance()
    real(rp) :: errors(3), h(3)
    integer :: level
    logical :: all_terms
    do level = 1, 3
      h(level) = 1.0_rp/(200*2**level)
      errors(level) = imbalance(200*2**level, all_terms)
      call t%check('loads, weight, frame and damping all take part', all_terms)
    end do
    call t%check_below('work and energy balance', errors(3), 1.0e-4_rp)
    call t%check_order('and the balance closes with the square of the step', h, errors, 2.0_rp, 0.2_rp)
  end subroutine test_balance
end program test_solid_weight

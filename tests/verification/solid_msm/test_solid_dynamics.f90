! SPDX-License-Identifier: GPL-3.0-or-later
!> Motion of wings in time against closed forms, orders of convergence, conservation.
program test_solid_dynamics
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use cantilever, only: make_cantilever
  use sample_wings, only: make_beam
  use solid_dynamics, only: dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_inertia, only: inertia_t, momenta_t, measure_motion
  use solid_model, only: solid_model_t
  use solid_motion, only: frame_t, steady_motion_t
  use solid_params, only: solid_params_t, default_params
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use turning_motion, only: turning_motion_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_order()
  call test_damping()
  call test_pendulum()
  call test_spinning_rod()
  call test_free_rod()
  call t%finish()

contains

  !> A beam that swings widely from an initial velocity, with equal or unequal steps, up to time 1.
  subroutine swing(n_steps, uneven, u)
    integer, intent(in) :: n_steps
    real(rp), intent(in) :: uneven
    real(rp), allocatable, intent(out) :: u(:, :)
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: rest
    real(rp), allocatable :: v(:, :), force(:, :)
    real(rp) :: dt
    integer :: i
    logical :: fine
    call make_cantilever(5, 1.0_rp, 200.0_rp, model, inertia)
    call stepper%init(model)
    allocate (v(3, model%n_all), force(3, model%n_all), source=0.0_rp)
    v(2, :) = 2*model%points(1, :)**2
    v(3, :) = 1*model%points(1, :)**2
    call state%init(model, 0.0_rp, v=v)
    options%tolerance = 1.0e-11_rp
    fine = .true.
    do i = 1, n_steps
      dt = (1 + uneven*(2*mod(i, 2) - 1))/n_steps
      call stepper%step(model, inertia, rest, force, dt, options, state, report)
      fine = fine .and. report%converged .and. report%substeps == 1
    end do
    call t%check('all steps of the swing converge', fine)
    u = state%u
    call stepper%free()
  end subroutine swing

  subroutine test_order()
    real(rp), allocatable :: reference(:, :), u(:, :)
    real(rp) :: errors(3), h(3)
    integer :: i
    call swing(6400, 0.0_rp, reference)
    do i = 1, 3
      call swing(100*2**i, 0.0_rp, u)
      h(i) = 0.5_rp**i
      errors(i) = maxval(abs(u - reference))
    end do
    call t%check_order('BDF2 is of second order', h, errors, 2.0_rp, 0.15_rp)
    do i = 1, 3
      call swing(100*2**i, 0.3_rp, u)
      errors(i) = maxval(abs(u - reference))
    end do
    call t%check_order('also when short and long steps alternate', h, errors, 2.0_rp, 0.15_rp)
  end subroutine test_order

  !> A mass on an axial spring: every kind of damping gives its known decay.
  subroutine test_damping()
    real(rp), parameter :: K = 100, M = 0.5_rp, X0 = 1.0e-3_rp, DT = 2.0e-4_rp
    integer, parameter :: STEPS = 4000
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: rest
    real(rp), allocatable :: u(:, :), force(:, :)
    real(rp) :: omega, zeta, exact, damped
    integer :: kind, i
    call make_cantilever(1, 1.0_rp, K, model, inertia)
    call stepper%init(model)
    allocate (u(3, model%n_all), force(3, model%n_all), source=0.0_rp)
    u(1, 2) = X0
    omega = sqrt(K/M)
    zeta = 0.05_rp
    do kind = 1, 3
      inertia%nodal = 0
      inertia%rayleigh_mass = 0
      inertia%rayleigh_stiffness = 0
      if (kind == 1) inertia%nodal(2) = 2*zeta*omega*M
      if (kind == 2) inertia%rayleigh_mass = 2*zeta*omega
      if (kind == 3) inertia%rayleigh_stiffness = 2*zeta/omega
      call state%init(model, 0.0_rp, u=u)
      do i = 1, STEPS
        call stepper%step(model, inertia, rest, force, DT, options, state, report)
      end do
      damped = omega*sqrt(1 - zeta**2)
      exact = X0*exp(-zeta*omega*state%time)* &
              (cos(damped*state%time) + zeta*omega/damped*sin(damped*state%time))
      call t%check_close('a damped oscillator decays as it must', state%u(1, 2)/X0, exact/X0, atol=2.0e-4_rp)
    end do
    call stepper%free()
  end subroutine test_damping

  !> A bob on a rigid rod without hinge stiffness, released at 1 rad: T = 2 pi sqrt(L/g)/agm(1, cos 1/2).
  subroutine test_pendulum()
    real(rp), parameter :: ANGLE = 1, G = 9.81_rp
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: rest
    type(momenta_t) :: now
    real(rp), allocatable :: u(:, :), force(:, :)
    real(rp) :: period, a, b, c, last, dt, crossing, energy, drift
    integer :: i
    logical :: fine
    call make_cantilever(1, 0.0_rp, 1.0e6_rp, model, inertia)
    call stepper%init(model)
    a = 1
    b = cos(ANGLE/2)
    do i = 1, 8
      c = 0.5_rp*(a + b)
      b = sqrt(a*b)
      a = c
    end do
    period = TWO_PI*sqrt(1/G)/a
    rest%frame%gravity = [0.0_rp, -G, 0.0_rp] ! the rod starts along -y turned by ANGLE
    allocate (u(3, model%n_all), force(3, model%n_all), source=0.0_rp)
    u(:, 2) = [sin(ANGLE), -cos(ANGLE), 0.0_rp] - [1.0_rp, 0.0_rp, 0.0_rp]
    call state%init(model, 0.0_rp, u=u)
    dt = period/2000
    crossing = 0
    fine = .true.
    drift = 0
    energy = -inertia%mass(2)*G*cos(ANGLE)
    do i = 1, 1000
      last = 1 + state%u(1, 2)
      call stepper%step(model, inertia, rest, force, dt, options, state, report)
      fine = fine .and. report%converged
      if (last > 0 .and. 1 + state%u(1, 2) <= 0) crossing = state%time - dt*(1 + state%u(1, &
                                                                                         2))/(1 + state%u(1, 2) - last)
      now = measure_motion(inertia, model, rest%frame, state%u, state%v)
      drift = max(drift, abs(now%kinetic + now%elastic + inertia%mass(2)*G*state%u(2, 2) - energy))
    end do
    call t%check('all steps of the pendulum converge', fine)
    call t%check_close('a pendulum at 1 rad has its period', 4*crossing, period, rtol=1.0e-4_rp)
    call t%check_below('it keeps its energy', drift/abs(energy), 1.0e-3_rp)
    call stepper%free()
  end subroutine test_pendulum

  !> A rigid rod of length 1 hinged at distance e from the axis of a spinning frame flaps with
  !> Omega sqrt(1 + e) and lags with Omega sqrt(e).
  subroutine test_spinning_rod()
    real(rp), parameter :: OMEGA = 3, OFFSET = 0.25_rp, SMALL = 1.0e-4_rp
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(failure_t) :: failure
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(turning_motion_t) :: spin
    real(rp), allocatable :: u(:, :), force(:, :)
    real(rp) :: dt, t_end
    integer :: i, c
    wing = make_beam(1, 1.0_rp, 1.0_rp, [1.0_rp, 0.0_rp, 0.0_rp])
    wing%points(1, :) = wing%points(1, :) + OFFSET
    params = default_params(wing)
    params%young = 1
    params%root_factor = 0
    params%k_vein = 1.0e7_rp
    call model%init(wing, params, failure)
    call inertia%init(model, [0.0_rp, 1.0_rp])
    call stepper%init(model)
    spin%omega0 = OMEGA
    allocate (u(3, model%n_all), force(3, model%n_all))
    force = 0
    do c = 2, 3
      u = 0
      u(c, 2) = SMALL
      u(1, 2) = (1 + OFFSET)*OMEGA**2/params%k_vein
      call state%init(model, 0.0_rp, u=u)
      t_end = TWO_PI/(OMEGA*sqrt(OFFSET + (c - 2)))
      dt = t_end/4000
      do i = 1, 1000
        call stepper%step(model, inertia, spin, force, dt, options, state, report)
      end do
      call t%check_below(merge('a quarter period of lagging ', 'a quarter period of flapping', c == 2), &
                         abs(state%u(c, 2))/SMALL, 1.0e-3_rp)
      do i = 1, 1000
        call stepper%step(model, inertia, spin, force, dt, options, state, report)
      end do
      call t%check_close('and half a period', state%u(c, 2)/SMALL, -1.0_rp, rtol=1.0e-3_rp)
    end do
    call stepper%free()
  end subroutine test_spinning_rod

  !> A rod that nothing holds moves straight and turns evenly, seen from rest or from a frame that
  !> turns ever faster; its momentum is constant.
  subroutine test_free_rod()
    real(rp), parameter :: T_END = 0.5_rp
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(failure_t) :: failure
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(turning_motion_t) :: turning
    type(momenta_t) :: first, last
    real(rp), allocatable :: v(:, :), force(:, :)
    real(rp) :: errors(3), h(3), x(3), phi, masses(4), spin(3)
    integer :: i, n, refinement, c
    wing = make_beam(3, 3.0_rp, 1.0_rp, [1.0_rp, 0.0_rp, 0.0_rp]) ! 1-2 clamped, 3-4 free
    wing%veins = [wing%veins, wing%veins]
    wing%veins(1)%nodes = [1, 2]
    wing%veins(2)%nodes = [3, 4]
    wing%veins(1)%diameters = [1.0_rp, 1.0_rp]
    wing%veins(2)%diameters = [1.0_rp, 1.0_rp]
    wing%root = [1, 2]
    params = default_params(wing)
    params%k_vein = 2000
    call model%init(wing, params, failure)
    masses = [0.0_rp, 0.0_rp, 1.0_rp, 2.0_rp]
    call inertia%init(model, masses)
    call stepper%init(model)
    allocate (v(3, model%n_all), force(3, model%n_all))
    force = 0
    do c = 1, 2
      turning = turning_motion_t(omega0=0.0_rp, alpha=0.0_rp)
      if (c == 2) turning = turning_motion_t(omega0=2.0_rp, alpha=3.0_rp)
      do refinement = 1, 3
        n = 250*2**refinement
        v = 0
        v(:, 3) = [0.3_rp, 0.2_rp, -0.1_rp]
        v(:, 4) = v(:, 3)
        if (c == 1) v(2, 4) = v(2, 4) + 1.5_rp ! turns about its centre of mass
        if (c == 2) then ! the rod only moves on, seen from the frame
          v(1, 3:4) = v(1, 3:4) + turning%omega0*model%points(2, 3:4)
          v(2, 3:4) = v(2, 3:4) - turning%omega0*model%points(1, 3:4)
        end if
        call state%init(model, 0.0_rp, v=v)
        first = measure_motion(inertia, model, turning%at(0.0_rp), state%u, state%v)
        do i = 1, n
          call stepper%step(model, inertia, turning, force, T_END/n, options, state, report)
        end do
        last = measure_motion(inertia, model, turning%at(T_END), state%u, state%v)
        h(refinement) = 1.0_rp/n
        if (c == 1) then
          call t%check_below('linear momentum is conserved', maxval(abs(last%linear - first%linear)), &
                             1.0e-8_rp)
          spin = last%angular - first%angular
          errors(refinement) = norm2(spin)
        else
          phi = turning%omega0*T_END + 0.5_rp*turning%alpha*T_END**2
          x = model%points(:, 4) + [0.3_rp, 0.2_rp, -0.1_rp]*T_END
          x = [cos(phi)*x(1) + sin(phi)*x(2), cos(phi)*x(2) - sin(phi)*x(1), x(3)]
          errors(refinement) = norm2(model%points(:, 4) + state%u(:, 4) - x)
        end if
      end do
      if (c == 1) call t%check_below('angular momentum is conserved', errors(3), 1.0e-4_rp)
      if (c == 1) call t%check_order('and the better the shorter the steps', h, errors, 2.0_rp, 0.5_rp)
      if (c == 2) call t%check_order('a free rod moves straight through a turning frame', h, errors, 2.0_rp, &
                                     0.2_rp)
    end do
    call stepper%free()
  end subroutine test_free_rod
end program test_solid_dynamics

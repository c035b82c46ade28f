! SPDX-License-Identifier: GPL-3.0-or-later
!> A wing that rings: limits of a relaxing oscillator, the motion that the time integration of flusi finds, and derivatives with
!> respect to stiffness, masses and damping against differences. The argument names a wing file.
program test_series_simulation
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use loaded_wing, only: wing_of_argument
  use measurement_data, only: measurement_t
  use measurement_modes, only: MEDIUM_AIR, MEDIUM_VACUUM
  use measurement_series_projections, only: products
  use measurement_series_simulation, only: series_simulation_t
  use solid_damping_effects, only: damping_effects_t, DAMPING_DRAG, DAMPING_RELAXATION, DAMPING_TIME, N_DAMPING_EFFECTS
  use solid_dragged_flow, only: drag_t
  use solid_dynamics, only: dynamic_options_t, dynamic_state_t, dynamics_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_joint_forces, only: apply_joints
  use solid_mass, only: lump_mass, mass_params_t, mass_t
  use solid_mass_effects, only: mass_effects_t, mass_parts_t, MASS_POINT, N_MASS_EFFECTS
  use solid_modal, only: modal_t
  use solid_model, only: solid_model_t
  use solid_motion, only: steady_motion_t
  use solid_params, only: default_params, solid_params_t
  use solid_ringing, only: ringing_t, shake_t, EXCITED_BASE, EXCITED_RELEASE, EXCITED_TAP
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: parameter_direction
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: TIP(2) = [8.5e-3_rp, -0.8e-3_rp], MIDDLE(2) = [5.0e-3_rp, -0.5e-3_rp]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(solid_params_t) :: params
  type(mass_parts_t) :: parts
  type(mass_effects_t) :: effects
  type(damping_effects_t) :: damping
  type(series_simulation_t) :: simulation
  type(measurement_t) :: m

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  params = default_params(wing)
  params%joint = 1.0e-6_rp
  call prepare()
  call test_limits()
  call test_drag()
  call test_shake()
  call test_time_integration(2, 0.0_rp, 0.0_rp)
  call test_time_integration(16, 0.03_rp, 0.04_rp)
  call measure()
  call test_damping()
  call test_motion_of_base()
  call test_masses()
  call test_stiffness()
  call t%finish()

contains

  subroutine prepare()
    type(mass_t) :: mass
    type(mass_params_t) :: material
    type(message_list_t) :: messages
    type(failure_t) :: failure
    call lump_mass(wing, material, mass, messages)
    call parts%init(wing, mass)
    call model%init(wing, params, failure)
    call t%check('the wing is valid', messages%count() == 0 .and. .not. failure%failed)
  end subroutine prepare

  !> One mode of 1 rad/s that relaxes, released from 1. Slowly: it rings as if 1 + g times as stiff about the share g/(1 + g) of
  !> its release. Fast: as with damping of g tau in proportion to its stiffness; both errors are of first order in 1/tau and tau.
  subroutine test_limits()
    integer, parameter :: N = 60
    real(rp), parameter :: G = 0.3_rp, SLOW(2) = [2.0e4_rp, 1.0e4_rp], FAST(2) = [2.0e-4_rp, 1.0e-4_rp]
    type(damping_effects_t) :: relaxing
    type(ringing_t) :: ring
    real(rp) :: exact(N), times(N), error(2), v, d
    integer :: i, k
    ring%interval = 0.2_rp
    times = [(k*ring%interval, k=0, N - 1)]
    relaxing%relaxation = G
    do i = 1, 2
      relaxing%relaxation_time = SLOW(i)
      call ring_alone(ring, relaxing, N)
      exact = (G + cos(sqrt(1 + G)*times))/(1 + G)
      error(i) = maxval(abs(ring%seen(:, 1) - exact))
    end do
    call t%check_below('a wing that relaxes slowly is stiffer', error(1), 1.0e-3_rp)
    call t%check_close('up to an error of first order', error(2)/error(1), 2.0_rp, rtol=0.05_rp)
    do i = 1, 2
      relaxing%relaxation_time = FAST(i)
      call ring_alone(ring, relaxing, N)
      d = 0.5_rp*G*FAST(i)
      v = sqrt(1 - d**2)
      exact = exp(-d*times)*(cos(v*times) + d/v*sin(v*times))
      error(i) = maxval(abs(ring%seen(:, 1) - exact))
    end do
    call t%check_below('a wing that relaxes fast is damped in proportion to its stiffness', error(1), 1.0e-5_rp)
    call t%check_below('up to an error of higher order', error(2), 0.6_rp*error(1))
  end subroutine test_limits

  subroutine ring_alone(ring, how, n)
    type(ringing_t), intent(inout) :: ring
    type(damping_effects_t), intent(in) :: how
    integer, intent(in) :: n
    real(rp) :: one(1, 1), none(1, 1)
    one = 1
    none = 0
    call ring%run([1.0_rp], none, one, [1.0_rp], how, n, [real(rp) ::])
  end subroutine ring_alone

  !> One mode of 1 rad/s with drag, released from x = 1: x'' + x = -b |x'| x'. While it moves down from x = a, where it rests,
  !> v^2 = 1/(2 b^2) + x/b - (1/(2 b^2) + a/b) exp(2 b (x - a)); the next half turn is the mirror image from the other end.
  subroutine test_drag()
    integer, parameter :: N = 100
    real(rp), parameter :: B(2) = [0.1_rp, 0.5_rp]
    type(damping_effects_t) :: nothing
    type(ringing_t) :: ring
    real(rp) :: error, a, x, v, left
    integer :: i, k, side
    do i = 1, 2
      ring%interval = TWO_PI/30
      ring%drag = drag_t(B(i), [0.5_rp, 0.25_rp], reshape([1.0_rp, 2.0_rp**(1/3.0_rp)], [2, 1]))
      call ring_alone(ring, nothing, N)
      error = 0
      a = 1
      side = 1
      left = 0
      do k = 2, N
        x = side*ring%seen(k, 1)
        v = side*ring%rate(k, 1)
        if (v > 0) then ! the turn is complete
          a = other_end(a, B(i))
          side = -side
          x = -x
          v = -v
        end if
        left = 0.5_rp/B(i)**2 + x/B(i) - (0.5_rp/B(i)**2 + a/B(i))*exp(2*B(i)*(x - a))
        error = max(error, abs(v**2 - left))
      end do
      call t%check_below('the energy of a wing with drag falls as it must', error, 2.0e-6_rp)
      call t%check_below('after several turns', a, 0.7_rp)
    end do
  end subroutine test_drag

  !> The same mode without drag on a base that moves with a sin(w t) + b cos(w t): the sum of free and forced motion.
  subroutine test_shake()
    integer, parameter :: N = 60
    real(rp), parameter :: W = 1.7_rp, A = 0.4_rp, B = -0.3_rp
    type(damping_effects_t) :: nothing
    type(ringing_t) :: ring
    real(rp) :: exact(N), times(N)
    integer :: k
    ring%interval = 0.2_rp
    ring%start = 0.3_rp
    ring%shake = shake_t(1, W, [A, B])
    ring%shaken = [1.0_rp]
    times = [(ring%start + k*ring%interval, k=0, N - 1)]
    call ring_alone(ring, nothing, N)
    exact = cos(times) + (A*(sin(W*times) - W*sin(times)) + B*(cos(W*times) - cos(times)))/(1 - W**2)
    call t%check_below('a base that moves drives the wing', maxval(abs(ring%seen(:, 1) - exact)), 1.0e-12_rp)
  end subroutine test_shake

  !> How far a half turn from `a` goes: (1 - 2 b y) exp(2 b y) = (1 + 2 b a) exp(-2 b a), by bisection.
  pure real(rp) function other_end(a, b) result(y)
    real(rp), intent(in) :: a, b
    real(rp) :: low, high
    integer :: k
    low = 0
    high = min(a, 0.5_rp/b)
    do k = 1, 60
      y = 0.5_rp*(low + high)
      if ((1 - 2*b*y)*exp(2*b*y) > (1 + 2*b*a)*exp(-2*b*a)) then
        low = y
      else
        high = y
      end if
    end do
  end function other_end

  !> flusi's BDF2 of the whole nonlinear wing, viscoelastic with Rayleigh's damping, drag and friction of joints (of so many radians
  !> of the first mode), released a little from the shape of two modes: the difference at one tip to the motion in `r` modes falls
  !> with the square of the step. Friction of joints and drag move further modes too. `drag` is c times the displacement of the tip
  !> over the mass per area.
  subroutine test_time_integration(r, friction, drag)
    integer, intent(in) :: r
    real(rp), intent(in) :: friction, drag
    integer, parameter :: A_PERIOD(2) = [100, 200]
    type(modal_t) :: modal
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: rest
    type(failure_t) :: failure
    type(ringing_t) :: ring
    type(damping_effects_t) :: how
    real(rp), allocatable :: u(:, :), force(:, :), mass(:, :), stiff(:, :, :)
    real(rp) :: dt, look(1, r), push(r), joints(r, r), error(2)
    integer :: tip_point, n, i
    allocate (mass(3, model%n_all), force(3, model%n_all), source=0.0_rp)
    call parts%masses(mass_effects_t(), 0.0_rp, mass)
    call modal%init(model)
    call modal%solve(mass, r, failure)
    how%joints = friction/sqrt(modal%lambda(1))
    inertia%joint_friction = how%joints
    call inertia%init(model, mass(1, :model%n_points))
    how%mass = 0.1_rp*sqrt(modal%lambda(1))
    how%stiffness = 0.02_rp/sqrt(modal%lambda(1))
    inertia%rayleigh_mass = how%mass
    inertia%rayleigh_stiffness = how%stiffness
    how%relaxation = 0.3_rp
    how%relaxation_time = 1/sqrt(modal%lambda(1))
    inertia%relaxation = how%relaxation
    inertia%relaxation_time = how%relaxation_time
    if (drag > 0) then
      inertia%drag = drag*sum(inertia%mass)/sum(inertia%area)/(1.0e-5_rp*model%size)
      ring%drag%strength = inertia%drag
      ring%drag%area = inertia%area
      ring%drag%across = modal%shapes(3, :, :r) ! a constructor would take other numbers by an error of gfortran 12
    end if
    tip_point = maxloc(model%points(1, :model%n_points), 1)
    look(1, :) = modal%shapes(3, tip_point, :)
    push = 0
    push(:2) = 1.0e-5_rp*model%size/look(1, 1)*modal%lambda(:2)*[1.0_rp, 0.3_rp]
    allocate (stiff(3, model%n_all, r))
    call apply_joints(modal, stiff)
    joints = products(modal%shapes(:, :, :r), stiff)
    u = modal%shapes(:, :, 1)*push(1)/modal%lambda(1) + modal%shapes(:, :, 2)*push(2)/modal%lambda(2)
    do i = 1, 2
      dt = TWO_PI/sqrt(modal%lambda(1))/A_PERIOD(i)
      ring%interval = dt
      call ring%run(modal%lambda, joints, look, push, how, 3*A_PERIOD(i) + 1, [real(rp) ::])
      call stepper%init(model)
      call state%init(model, 0.0_rp, u=u)
      error(i) = 0
      do n = 1, 3*A_PERIOD(i)
        call stepper%step(model, inertia, rest, force, dt, options, state, report)
        error(i) = max(error(i), abs(state%u(3, tip_point) - ring%seen(n + 1, 1)))
      end do
      error(i) = error(i)/maxval(abs(ring%seen))
      call stepper%free()
    end do
    call t%check('there is friction in the joints', inertia%rubs() .eqv. friction > 0)
    call t%check_below('the motion is that of the time integration', error(2), 2.0e-2_rp)
    call t%check_close('whose error is of second order', error(1)/error(2), 4.0_rp, rtol=0.1_rp)
    call modal%free()
  end subroutine test_time_integration

  !> Three records: a release in air behind a filter, the velocity after a tap in a vacuum, a moving base. All values are 0.
  subroutine measure()
    integer, parameter :: N = 25, EXCITATIONS(3) = [EXCITED_RELEASE, EXCITED_TAP, EXCITED_BASE]
    real(rp), parameter :: SIZES(3) = [1.0e-5_rp, 1.0e-8_rp, 1.0_rp]
    integer :: i, k
    m = measurement_t()
    allocate (m%series(3))
    do i = 1, 3
      associate (s => m%series(i))
        s%name = 's'//achar(48 + i)
        s%excitation = EXCITATIONS(i)
        s%medium = merge(MEDIUM_AIR, MEDIUM_VACUUM, i == 1)
        s%is_velocity = i == 2
        s%point = TIP
        s%direction = [0.0_rp, 0.0_rp, 1.0_rp]
        s%size = SIZES(i)
        s%axis = [0.0_rp, 0.0_rp, 1.0_rp]
        s%rate = 2000.0_rp
        s%place = reshape([TIP, MIDDLE], [2, 2])
        allocate (s%values(N, 2), source=0.0_rp)
        allocate (s%is_known(N, 2), source=.true.)
        s%sigma = [1.0e-8_rp, 1.0e-8_rp]
        if (i == 2) s%sigma = 1.0e-5_rp
        allocate (s%base(0))
      end associate
    end do
    m%series(1)%lowpass = 1500
    m%series(1)%order = 2
    m%series(1)%start = 2.0e-4_rp
    m%series(3)%lowpass = 800
    m%series(3)%base = [(10*sin(0.9_rp*k**2), k=1, N)]
    effects = mass_effects_t()
    effects%corner = wing%triangles(:, size(wing%triangles, 2)/2)
    effects%weight = [0.5_rp, 0.3_rp, 0.2_rp]
    effects%veins = 1.2_rp
    effects%gradient = 0.3_rp
    effects%added = 0.8_rp
    effects%point = 2.0e-9_rp
    damping = damping_effects_t(mass=60.0_rp, stiffness=2.0e-5_rp, joints=1.0e-4_rp, relaxation=0.1_rp, relaxation_time=1.0e-3_rp, &
                                drag=20.0_rp)
    call simulation%init(m, model, parts)
    simulation%shake = shake_t(1, TWO_PI*400, [3.0_rp, -2.0_rp])
    call t%check('every number is an observation', simulation%n == 2*N*3)
  end subroutine measure

  !> Residuals, which are the motion in sd.
  function motion(p, e, d) result(r)
    type(solid_params_t), intent(in) :: p
    type(mass_effects_t), intent(in) :: e
    type(damping_effects_t), intent(in) :: d
    real(rp), allocatable :: r(:)
    logical :: ok
    allocate (r(simulation%n))
    call simulation%evaluate(p, e, d, r, ok)
    if (.not. ok) call t%check('there is a motion', .false.)
  end function motion

  !> The derivative column(:) against differences over `step` and half of it, plus(:, 2) less minus(:, 2). Central differences
  !> err with the square of the step, and with rounding: so do both, or both are small.
  subroutine judge(name, column, plus, minus, step)
    character(*), intent(in) :: name
    real(rp), intent(in) :: column(:), plus(:, :), minus(:, :), step
    real(rp) :: error(2)
    error(1) = norm2((plus(:, 1) - minus(:, 1))/(2*step) - column)/norm2(column)
    error(2) = norm2((plus(:, 2) - minus(:, 2))/step - column)/norm2(column)
    call t%check_below('derivative of the motion to '//name, error(2), 2.0e-3_rp)
    if (error(2) > 1.0e-7_rp) &
      call t%check_close('its differences err with the square of their step: '//name, error(1)/error(2), 4.0_rp, rtol=0.1_rp)
  end subroutine judge

  subroutine test_damping()
    character(18), parameter :: NAMES(N_DAMPING_EFFECTS) = [character(18) :: 'rayleigh_mass', 'rayleigh_stiffness', &
                                                            'joint_friction', 'relaxation', 'drag']
    real(rp), parameter :: STEPS(N_DAMPING_EFFECTS) = [4.0_rp, 1.0e-6_rp, 2.0e-5_rp, 0.01_rp, 0.5_rp]
    type(damping_effects_t) :: d
    real(rp), allocatable :: plus(:, :), minus(:, :), column(:), r(:)
    integer :: i, k
    allocate (plus(simulation%n, 2), minus(simulation%n, 2), column(simulation%n))
    do i = 1, N_DAMPING_EFFECTS
      do k = 1, 2
        d = shifted(i, STEPS(i)/k)
        plus(:, k) = motion(params, effects, d)
        d = shifted(i, -STEPS(i)/k)
        minus(:, k) = motion(params, effects, d)
      end do
      r = motion(params, effects, damping)
      call simulation%damping_tangent(i, damping%relaxation_time, column)
      call judge(trim(NAMES(i)), column, plus, minus, STEPS(i))
    end do
    do k = 1, 2
      d = damping
      d%relaxation_time = damping%relaxation_time*exp(0.02_rp/k)
      plus(:, k) = motion(params, effects, d)
      d%relaxation_time = damping%relaxation_time*exp(-0.02_rp/k)
      minus(:, k) = motion(params, effects, d)
    end do
    r = motion(params, effects, damping)
    call simulation%damping_tangent(DAMPING_TIME, 0.0_rp, column)
    call judge('relaxation_time', column, plus, minus, 0.02_rp)
    d = damping
    d%drag = 0
    r = motion(params, effects, d)
    call simulation%damping_tangent(DAMPING_DRAG, 0.0_rp, column)
    d%drag = 1.0e-4_rp
    plus(:, 2) = motion(params, effects, d)
    call t%check_below('drag that is not there has a derivative', norm2((plus(:, 2) - r)/d%drag - column)/norm2(column), 1.0e-4_rp)
    ! Of another relaxation time, where there is none: one-sided, as a share is not negative.
    d = damping
    d%relaxation = 0
    r = motion(params, effects, d)
    call simulation%damping_tangent(DAMPING_RELAXATION, 3.0e-4_rp, column)
    d%relaxation_time = 3.0e-4_rp
    d%relaxation = 1.0e-5_rp
    plus(:, 1) = motion(params, effects, d)
    call t%check_below('a relaxation that is not there can be scanned', norm2((plus(:, 1) - r)/1.0e-5_rp - column)/norm2(column), &
                       1.0e-3_rp)
  end subroutine test_damping

  !> Of the motion of the base in record 1, and of one in record 2 that is not there, whose effect is linear.
  subroutine test_motion_of_base()
    character(7), parameter :: NAMES(3) = [character(7) :: 'sine', 'cosine', 'rate']
    real(rp), parameter :: STEP = 0.02_rp, RATE = 3.0e3_rp
    type(shake_t) :: shake
    real(rp), allocatable :: plus(:, :), minus(:, :), column(:), r(:)
    integer :: part, k
    allocate (plus(simulation%n, 2), minus(simulation%n, 2), column(simulation%n))
    shake = simulation%shake
    do part = 1, 3
      do k = 1, 2
        simulation%shake = shaken_more(shake, part, STEP/k)
        plus(:, k) = motion(params, effects, damping)
        simulation%shake = shaken_more(shake, part, -STEP/k)
        minus(:, k) = motion(params, effects, damping)
      end do
      simulation%shake = shake
      r = motion(params, effects, damping)
      call simulation%shake_tangent(part, shake, column)
      call judge('the base''s '//trim(NAMES(part)), column, plus, minus, STEP)
    end do
    simulation%shake = shake_t()
    r = motion(params, effects, damping)
    do part = 1, 2
      call simulation%shake_tangent(part, shake_t(2, RATE, [0.0_rp, 0.0_rp]), column)
      plus(:, part) = column
    end do
    simulation%shake = shake_t(2, RATE, [1.0_rp, 2.0_rp])
    column = motion(params, effects, damping) - r
    call t%check_below('a motion of the base that is not there can be scanned', &
                       norm2(column - plus(:, 1) - 2*plus(:, 2))/norm2(column), 1.0e-10_rp)
    simulation%shake = shake
  end subroutine test_motion_of_base

  type(shake_t) function shaken_more(shake, part, step) result(other)
    type(shake_t), intent(in) :: shake
    integer, intent(in) :: part
    real(rp), intent(in) :: step
    other = shake
    if (part == 3) other%rate = shake%rate*exp(step)
    if (part < 3) other%amplitude(part) = shake%amplitude(part) + step
  end function shaken_more

  type(damping_effects_t) function shifted(i, step) result(d)
    integer, intent(in) :: i
    real(rp), intent(in) :: step
    d = damping
    select case (i)
    case (1)
      d%mass = d%mass + step
    case (2)
      d%stiffness = d%stiffness + step
    case (3)
      d%joints = d%joints + step
    case (DAMPING_DRAG)
      d%drag = d%drag + step
    case default
      d%relaxation = d%relaxation + step
    end select
  end function shifted

  subroutine test_masses()
    type(mass_effects_t) :: e
    real(rp), allocatable :: plus(:, :), minus(:, :), column(:), r(:)
    real(rp) :: step, value, sides(2)
    integer :: i, k, s
    logical :: is_log
    allocate (plus(simulation%n, 2), minus(simulation%n, 2), column(simulation%n))
    do i = 1, N_MASS_EFFECTS
      is_log = i /= 3 .and. i /= MASS_POINT
      step = merge(2.0e-10_rp, 0.01_rp, i == MASS_POINT)
      do k = 1, 2
        do s = 1, 2
          e = effects
          value = e%get(i)
          sides = [step, -step]/k
          call e%set(i, merge(value*exp(sides(s)), value + sides(s), is_log))
          if (s == 1) plus(:, k) = motion(params, e, damping)
          if (s == 2) minus(:, k) = motion(params, e, damping)
        end do
      end do
      r = motion(params, effects, damping)
      call simulation%mass_tangent(i, effects, column)
      call judge('mass effect '//achar(48 + i), column, plus, minus, step)
    end do
  end subroutine test_masses

  subroutine test_stiffness()
    character(12), parameter :: NAMES(7) = [character(12) :: 'E', 'D', 'root', 'joint:C_h', 'E_gradient', 'root_flap', 'root_twist']
    real(rp), parameter :: STEP = 0.01_rp
    type(solid_params_t) :: p
    type(stiffness_t) :: direction
    type(parameter_t) :: about
    real(rp), allocatable :: plus(:, :), minus(:, :), column(:), r(:)
    real(rp) :: value, scale
    integer :: i, k, s, number
    allocate (plus(simulation%n, 2), minus(simulation%n, 2), column(simulation%n))
    do i = 1, size(NAMES)
      number = params%find(trim(NAMES(i)))
      about = params%describe(number)
      scale = 1
      if (.not. about%is_log) scale = about%prior_sd
      do k = 1, 2
        do s = 1, 2
          p = base_params()
          value = p%get(number)
          call p%set(number, merge(value*exp(STEP*(3 - 2*s)/k), value + scale*STEP*(3 - 2*s)/k, about%is_log))
          if (s == 1) plus(:, k) = motion(p, effects, damping)
          if (s == 2) minus(:, k) = motion(p, effects, damping)
        end do
      end do
      r = motion(base_params(), effects, damping)
      if (NAMES(i) == 'root_flap' .or. NAMES(i) == 'root_twist') then
        call simulation%clamp_tangent(merge(2, 1, NAMES(i) == 'root_flap'), column)
      else
        call parameter_direction(simulation%model(), number, direction)
        call simulation%stiffness_tangent(direction, index(NAMES(i), 'joint:') == 1, column)
      end if
      call judge(trim(NAMES(i)), column, plus, minus, scale*STEP)
    end do
  end subroutine test_stiffness

  !> A clamp that gives way, so that its derivative is one on both sides.
  type(solid_params_t) function base_params() result(p)
    p = params
    call p%set_named('root_flap', 300.0_rp)
    call p%set_named('root_twist', 300.0_rp)
  end function base_params
end program test_series_simulation

! SPDX-License-Identifier: GPL-3.0-or-later
!> A wing that rings: derivatives of its records with respect to stiffness, masses, damping and a motion of the base against
!> differences. The argument names a wing file.
program test_series_simulation
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use loaded_wing, only: wing_of_argument
  use measurement_data, only: measurement_t
  use measurement_modes, only: MEDIUM_AIR, MEDIUM_VACUUM
  use measurement_series_simulation, only: series_simulation_t
  use solid_damping_effects, only: damping_effects_t, DAMPING_DRAG, DAMPING_RELAXATION, DAMPING_TIME, N_DAMPING_EFFECTS
  use solid_mass_effects, only: mass_effects_t, mass_parts_t, MASS_POINT, N_MASS_EFFECTS
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, solid_params_t
  use solid_ringing, only: shake_t, EXCITED_BASE, EXCITED_RELEASE, EXCITED_TAP
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: parameter_direction
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use weighed_model, only: make_weighed_model
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
  params%effects%disc = [4.5e-3_rp, -0.5e-3_rp, 1.2e-3_rp] ! with joints in it
  call prepare()
  call measure()
  call test_damping()
  call test_motion_of_base()
  call test_masses()
  call test_stiffness()
  call t%finish()

contains

  subroutine prepare()
    logical :: is_valid
    call make_weighed_model(wing, params, parts, model, is_valid)
    call t%check('the wing is valid', is_valid)
  end subroutine prepare

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
    real(rp), parameter :: STEPS(3) = [0.02_rp, 0.02_rp, 0.002_rp], RATE = 3.0e3_rp
    type(shake_t) :: shake
    real(rp), allocatable :: plus(:, :), minus(:, :), column(:), r(:)
    integer :: part, k
    allocate (plus(simulation%n, 2), minus(simulation%n, 2), column(simulation%n))
    shake = simulation%shake
    do part = 1, 3
      do k = 1, 2
        simulation%shake = shaken_more(shake, part, STEPS(part)/k)
        plus(:, k) = motion(params, effects, damping)
        simulation%shake = shaken_more(shake, part, -STEPS(part)/k)
        minus(:, k) = motion(params, effects, damping)
      end do
      simulation%shake = shake
      r = motion(params, effects, damping)
      call simulation%shake_tangent(part, shake, column)
      call judge('the base''s '//trim(NAMES(part)), column, plus, minus, STEPS(part))
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
    character(12), parameter :: NAMES(8) = [character(12) :: 'E', 'D', 'root', 'joint:C_h', 'E_gradient', 'damage', 'root_flap', &
                                             'root_twist']
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
        call simulation%stiffness_tangent(direction, column)
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

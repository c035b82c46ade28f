! SPDX-License-Identifier: GPL-3.0-or-later
!> Measured modes against computed ones: the pairs are right though a mode is missing, residuals of a wing's own modes are 0
!> whatever their size and sign, and derivatives equal differences, also where modes repeat and where a load bends the wing. The
!> argument names a wing file.
program test_mode_simulation
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use loaded_wing, only: wing_of_argument
  use measurement_data, only: measurement_t
  use measurement_mode_simulation, only: mode_simulation_t
  use measurement_modes, only: MEDIUM_AIR, MEDIUM_VACUUM
  use sample_wings, only: make_beam
  use solid_damping_effects, only: damping_effects_t, DAMPING_JOINTS, DAMPING_MASS, DAMPING_RELAXATION, DAMPING_STIFFNESS, &
                                   DAMPING_TIME
  use solid_decay, only: decay_t
  use solid_mass_effects, only: mass_effects_t, mass_parts_t, MASS_ADDED, MASS_GRADIENT, MASS_POINT, MASS_VEINS
  use solid_modal, only: modal_t
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: parameter_direction
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use weighed_model, only: make_weighed_model
  implicit none
  integer, parameter :: NUMBERS(4) = [1, 2, 4, 5] !< the third mode was not measured
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(solid_params_t) :: params
  type(mass_parts_t) :: parts
  type(mode_simulation_t) :: simulation
  type(measurement_t) :: m
  type(damping_effects_t) :: damping
  real(rp), allocatable :: r(:)

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  params = default_params(wing)
  params%joint = 1.0e-6_rp
  params%effects%disc = [4.5e-3_rp, -0.5e-3_rp, 1.2e-3_rp] ! with joints in it
  call prepare()
  call test_own_modes()
  call test_slopes('of a wing', 1.0e-7_rp)
  call test_decay()
  call test_strong_damping()
  call test_loaded()
  call test_repeated()
  call t%finish()

contains

  subroutine prepare()
    logical :: is_valid
    call make_weighed_model(wing, params, parts, model, is_valid)
    call t%check('the wing is valid', is_valid)
  end subroutine prepare

  !> A measurement of modes `numbers` of the wing in a vacuum or in air at all points that move in them, of any size and sign.
  subroutine measure(medium, numbers)
    integer, intent(in) :: medium, numbers(:)
    type(modal_t) :: modal
    type(failure_t) :: failure
    real(rp) :: mass(3, model%n_all)
    real(rp), allocatable :: f(:)
    integer, allocatable :: sites(:)
    integer :: i
    call parts%masses(mass_effects_t(), merge(1.2_rp, 0.0_rp, medium == MEDIUM_AIR), mass)
    call modal%init(model)
    call modal%solve(mass, maxval(numbers), failure)
    f = modal%frequencies()
    sites = [(i, i=1, model%n_points, max(1, model%n_points/13))]
    m = measurement_t()
    allocate (m%modes(size(numbers)))
    do i = 1, size(numbers)
      associate (mode => m%modes(size(numbers) + 1 - i)) ! not in the order of frequencies
        mode%name = 'm'//achar(48 + i)
        mode%medium = medium
        mode%frequency = f(numbers(i))
        mode%frequency_sigma = 0.01_rp*mode%frequency
        mode%place = model%points(:2, sites)
        mode%shape = (-0.3_rp)**i*modal%shapes(3, sites, numbers(i))
        mode%sigma = 0.02_rp*maxval(abs(mode%shape))*(1 + 0.5_rp*sin([(1.0_rp*i, i=1, size(sites))]))
      end associate
    end do
    call modal%free()
    call simulation%init(m, model, parts)
    if (allocated(r)) deallocate (r)
    allocate (r(simulation%n))
  end subroutine measure

  subroutine test_own_modes()
    logical :: ok
    integer :: i, n
    call measure(MEDIUM_AIR, NUMBERS)
    n = size(NUMBERS)
    call t%check('there is a number for each frequency and one less than places for each shape', &
                 simulation%n == n*size(m%modes(1)%shape))
    call simulation%evaluate(params, mass_effects_t(), damping, r, ok)
    call t%check('modes are computed', ok)
    call t%check('modes are paired, though one is missing', all([(simulation%targets(i)%lo, i=n, 1, -1)] == NUMBERS))
    call t%check_below('what is measured on the model itself leaves nothing', maxval(abs(r)), 1.0e-6_rp)
    call t%check_close('MAC is 1', minval(simulation%targets%mac), 1.0_rp, atol=1.0e-9_rp)
    m%modes(1)%shape(2) = m%modes(1)%shape(2) + m%modes(1)%sigma(2)
    call simulation%init(m, model, parts)
    call simulation%evaluate(params, mass_effects_t(), damping, r, ok)
    call t%check_below('an error of one sd is not more than one, to first order', norm2(r), 1.01_rp)
    call t%check_below('and most of it is seen', 1 - norm2(r), 0.2_rp)
    m%modes(1)%number = 3
    call simulation%init(m, model, parts)
    call simulation%evaluate(params, mass_effects_t(), damping, r, ok)
    call t%check('a number goes before the shape', simulation%targets(1)%lo == 3 .and. simulation%targets(1)%mac < 0.9_rp)
  end subroutine test_own_modes

  !> Derivatives at another wing than that of the measurement; differences of fourth order with h = 1e-3, as in test_solid_modal.
  subroutine test_slopes(what, limit)
    character(*), intent(in) :: what
    real(rp), intent(in) :: limit
    type(solid_params_t) :: other
    type(mass_effects_t) :: effects
    type(parameter_t) :: p
    type(stiffness_t) :: direction
    integer, parameter :: MASSES(4) = [MASS_VEINS, MASS_GRADIENT, MASS_ADDED, MASS_POINT]
    character(10), parameter :: NAMES(5) = [character(10) :: 'E', 'D', 'E_gradient', 'joint:C_h', 'damage']
    real(rp), allocatable :: column(:)
    real(rp) :: scale
    logical :: ok
    integer :: i
    if (what == 'of a wing') call measure(MEDIUM_AIR, NUMBERS)
    allocate (column(simulation%n))
    other = params
    other%plate = 1.3_rp*params%plate
    call other%set_named('E_gradient', 0.3_rp)
    effects%corner = [1, 1, model%n_points]
    effects%weight = [0.0_rp, 0.0_rp, 1.0_rp]
    effects%point = 1.0e-3_rp*(sum(parts%veins) + sum(parts%membrane))
    effects%gradient = -0.3_rp
    do i = 1, size(NAMES)
      if (other%find(trim(NAMES(i))) == 0) cycle ! a rod has no joints
      call simulation%evaluate(other, effects, damping, r, ok)
      p = other%describe(other%find(trim(NAMES(i))))
      call parameter_direction(simulation%model(), other%find(trim(NAMES(i))), direction)
      call simulation%stiffness_tangent(direction, column)
      call compare(other, effects, column, other%find(trim(NAMES(i))), 0, 1.0e-3_rp, p%is_log, what//' to '//trim(NAMES(i)), &
                   1.0_rp, limit)
    end do
    do i = 1, size(MASSES)
      call simulation%evaluate(other, effects, damping, r, ok)
      call simulation%mass_tangent(MASSES(i), effects, column)
      scale = merge(effects%point, 1.0_rp, MASSES(i) == MASS_POINT)
      call compare(other, effects, column, 0, MASSES(i), 1.0e-3_rp*scale, MASSES(i) == MASS_VEINS .or. MASSES(i) == MASS_ADDED, &
                   what//' to mass '//achar(48 + MASSES(i)), scale, limit)
    end do
  end subroutine test_slopes

  !> Differences with respect to parameter i of the wing or effect j of its masses.
  subroutine compare(other, effects, column, i, j, h, is_log, name, scale, limit)
    type(solid_params_t), intent(in) :: other
    type(mass_effects_t), intent(in) :: effects
    real(rp), intent(in) :: column(:), limit
    integer, intent(in) :: i, j
    real(rp), intent(in) :: h, scale
    logical, intent(in) :: is_log
    character(*), intent(in) :: name
    real(rp), parameter :: WEIGHTS(4) = [1.0_rp, -8.0_rp, 8.0_rp, -1.0_rp]/12, AT(4) = [-2, -1, 1, 2]
    type(solid_params_t) :: changed
    type(mass_effects_t) :: masses
    real(rp) :: difference(simulation%n), value
    logical :: ok
    integer :: n
    difference = 0
    do n = 1, 4
      changed = other
      masses = effects
      value = effects%get(max(1, j))
      if (i > 0) value = other%get(i)
      value = merge(value*exp(AT(n)*h), value + AT(n)*h, is_log)
      if (i > 0) call changed%set(i, value)
      if (j > 0) call masses%set(j, value)
      call simulation%evaluate(changed, masses, damping, r, ok)
      difference = difference + WEIGHTS(n)/h*r
    end do
    call t%check_below('derivative '//name, scale*maxval(abs(difference - column)), &
                       limit*max(1.0_rp, scale*maxval(abs(column))))
  end subroutine compare

  !> Damping ratios: of the mass and the stiffness as known, of joints by the change of lambda with their stiffness; a mode that
  !> relaxes moves as its equation says. Derivatives at another wing.
  subroutine test_decay()
    real(rp), parameter :: G = 0.2_rp, TAU = 4.0e-4_rp
    complex(rp) :: s
    real(rp) :: omega(size(NUMBERS)), rate(size(NUMBERS))
    logical :: ok
    integer :: i
    call measure(MEDIUM_AIR, NUMBERS)
    m%modes%damping = 0.03_rp
    m%modes%damping_sigma = 0.003_rp
    call simulation%init(m, model, parts)
    deallocate (r)
    allocate (r(simulation%n))
    damping = damping_effects_t(mass=50.0_rp, stiffness=1.0e-5_rp, joints=1.0e-4_rp)
    omega = TWO_PI*m%modes%frequency
    rate = damping%mass + omega**2*(damping%stiffness + damping%joints*[(change_by_joints(i), i=1, size(NUMBERS))])
    call simulation%evaluate(params, mass_effects_t(), damping, r, ok)
    call t%check('modes have damping ratios', ok .and. simulation%n == size(NUMBERS)*(size(m%modes(1)%shape) + 1))
    do i = 1, size(NUMBERS)
      call t%check_close('damping by mass, stiffness and joints', simulation%targets(i)%damping%decay%ratio, rate(i)/(2*omega(i)), &
                         rtol=1.0e-6_rp)
    end do
    damping%relaxation = G
    damping%relaxation_time = TAU
    call simulation%evaluate(params, mass_effects_t(), damping, r, ok)
    do i = 1, size(NUMBERS)
      associate (ratio => simulation%targets(i)%damping%decay%ratio)
        s = TWO_PI*simulation%targets(i)%frequency*cmplx(-ratio, sqrt(1 - ratio**2), rp)
      end associate
      call t%check_below('a mode with a relaxation', abs(s**2 + rate(i)*s + omega(i)**2*(1 + G*s/(s + 1/TAU)))/omega(i)**2, &
                         1.0e-6_rp)
    end do
    call test_slopes('of a damped wing', 1.0e-6_rp)
    call test_damping_slopes()
    damping = damping_effects_t()
  end subroutine test_decay

  !> Without a relaxation the ratio is d/(2 omega), also of a mode that does not swing, and where it ceases to. Slopes with a
  !> relaxation that begins are compared with differences on one side, which err with their step, some 20 G. Two roots of the cubic
  !> equation are those of the mode; their sum and product, which follow from the third root, give ratio and frequency.
  subroutine test_strong_damping()
    real(rp), parameter :: OMEGA = 3.0_rp, J = 2.0_rp, D(3) = OMEGA*[0.4_rp, 2.0_rp, 5.0_rp], G = 1.0e-7_rp, RATE = 1.7_rp
    type(damping_effects_t) :: how, relaxing
    type(decay_t) :: decay
    real(rp) :: slopes(2), r, f
    integer :: i, k
    do i = 1, size(D)
      how = damping_effects_t(mass=0.5_rp*D(i), stiffness=0.3_rp*D(i)/OMEGA**2, joints=0.2_rp*D(i)/J, relaxation_time=1/RATE)
      call decay%init(OMEGA**2, J, how)
      call t%check_close('a damped mode has its ratio', decay%ratio, D(i)/(2*OMEGA), rtol=1.0e-14_rp)
      call t%check_close('and the frequency without damping', exp(decay%log_rate), OMEGA, rtol=1.0e-14_rp)
      slopes = decay%slope_of_damping(DAMPING_MASS)
      call t%check_close('the ratio grows with damping', slopes(2), 0.5_rp/OMEGA, rtol=1.0e-14_rp)
      slopes = decay%slope_of_damping(DAMPING_JOINTS)
      call t%check_close('with the friction of joints', slopes(2), 0.5_rp*J/OMEGA, rtol=1.0e-14_rp)
      slopes = decay%slope_of_mode(1.0_rp, 0.0_rp)
      call t%check_close('with lambda, of the damping by stiffness', slopes(2), 0.5_rp*how%stiffness/OMEGA - &
                         decay%ratio/(2*OMEGA**2), atol=1.0e-14_rp)
      slopes = decay%slope_of_damping(DAMPING_RELAXATION)
      r = RATE ! s = -r is a root of s^2 + D s + omega^2 (1 + G s/(s + RATE))
      do k = 1, 10
        f = (r**2 - D(i)*r + OMEGA**2)*(RATE - r) - G*OMEGA**2*r
        r = r - f/((2*r - D(i))*(RATE - r) - (r**2 - D(i)*r + OMEGA**2) - G*OMEGA**2)
      end do
      f = OMEGA**2*RATE/r ! product of the other roots; their sum is r - RATE - D
      call t%check_close('a relaxation that begins raises the frequency', slopes(1), 0.5_rp*log(f/OMEGA**2)/G, rtol=1.0e-5_rp)
      call t%check_close('and changes the ratio', slopes(2), (0.5_rp*(RATE + D(i) - r)/sqrt(f) - decay%ratio)/G, rtol=1.0e-5_rp)
      relaxing = how
      relaxing%relaxation = G
      f = decay%ratio + G*slopes(2)
      call decay%init(OMEGA**2, J, relaxing)
      if (i == 1) call t%check_close('as the mode does', decay%ratio, f, rtol=1.0e-12_rp)
    end do
  end subroutine test_strong_damping

  !> Derivatives with respect to all damping, against differences of fourth order.
  subroutine test_damping_slopes()
    real(rp), parameter :: WEIGHTS(4) = [1.0_rp, -8.0_rp, 8.0_rp, -1.0_rp]/12, AT(4) = [-2, -1, 1, 2], &
                           STEPS(5) = [1.0_rp, 1.0e-7_rp, 1.0e-6_rp, 1.0e-3_rp, 1.0e-3_rp]
    integer, parameter :: WHICH(5) = [DAMPING_MASS, DAMPING_STIFFNESS, DAMPING_JOINTS, DAMPING_RELAXATION, DAMPING_TIME]
    type(damping_effects_t) :: base
    real(rp) :: column(simulation%n), difference(simulation%n), values(5)
    logical :: ok
    integer :: i, n
    base = damping
    values = [base%mass, base%stiffness, base%joints, base%relaxation, 0.0_rp]
    do i = 1, 5
      difference = 0
      do n = 1, 4
        damping = base
        if (WHICH(i) == DAMPING_TIME) then
          damping%relaxation_time = base%relaxation_time*exp(AT(n)*STEPS(i))
        else
          call damping%set(WHICH(i), values(i) + AT(n)*STEPS(i))
        end if
        call simulation%evaluate(params, mass_effects_t(), damping, r, ok)
        difference = difference + WEIGHTS(n)/STEPS(i)*r
      end do
      damping = base
      call simulation%evaluate(params, mass_effects_t(), damping, r, ok)
      call simulation%damping_tangent(WHICH(i), damping%relaxation_time, column)
      call t%check_below('derivative to damping '//achar(48 + i), norm2(difference - column), 1.0e-6_rp*norm2(column))
    end do
  end subroutine test_damping_slopes

  !> Returns d(ln lambda)/d(ln stiffness of all joints) of measured mode i, by central differences of a second simulation.
  real(rp) function change_by_joints(i)
    integer, intent(in) :: i
    real(rp), parameter :: H = 1.0e-3_rp
    type(mode_simulation_t) :: other
    type(solid_params_t) :: changed
    real(rp) :: values(simulation%n), lambda(2)
    logical :: ok
    integer :: k
    call other%init(m, model, parts)
    do k = 1, 2
      changed = params
      changed%joint = params%joint*exp((2*k - 3)*H)
      call other%evaluate(changed, mass_effects_t(), damping_effects_t(), values, ok)
      lambda(k) = other%targets(i)%frequency**2
    end do
    change_by_joints = log(lambda(2)/lambda(1))/(2*H)
    call other%free()
  end function change_by_joints

  !> Modes about rest and about the shape under a force and the weight, in one measurement. Its own wing leaves nothing of it; the
  !> load matters; a shape that is not found is no evaluation. Differences of fourth order; the limit is twice
  !> that of test_solid_loaded_modes.
  subroutine test_loaded()
    type(static_options_t) :: options
    type(solid_params_t) :: other
    type(stiffness_t) :: direction
    type(mass_effects_t) :: effects
    real(rp), parameter :: H = 5.0e-3_rp, LIMIT = 1.0e-6_rp
    real(rp), allocatable :: column(:)
    logical :: ok
    integer :: tip
    call measure(MEDIUM_VACUUM, [1, 2])
    m%modes = [m%modes, m%modes]
    tip = maxloc(model%points(1, :model%n_points), 1)
    m%modes(3:)%number = [2, 1]
    m%modes(3)%damping = 0.03_rp
    m%modes(3)%damping_sigma = 0.003_rp
    m%modes(3)%gravity = [0.0_rp, 0.0_rp, -50.0_rp]
    m%modes(3)%load_size = [1.0e-4_rp]
    m%modes(3)%load_place = model%points(:2, [tip])
    m%modes(3)%load_direction = reshape([0.6_rp, 0.0_rp, 0.8_rp], [3, 1])
    m%modes(4) = m%modes(3)
    m%modes(4)%number = 1
    deallocate (r)
    call simulation%init(m, model, parts)
    allocate (r(simulation%n), column(simulation%n))
    call simulation%evaluate(params, effects, damping, r, ok)
    call t%check('modes about rest and about a loaded shape are computed', ok)
    call t%check_below('modes about rest are as without the others', &
                       maxval(abs(r(:simulation%first(3) - 1))), 1.0e-6_rp)
    call t%check_below('those about a loaded shape are others', 10.0_rp, abs(r(simulation%first(4))))
    other = params
    call simulation%evaluate(other, effects, damping, r, ok)
    call parameter_direction(simulation%model(), other%find('E'), direction)
    call simulation%stiffness_tangent(direction, column)
    call compare(other, effects, column, other%find('E'), 0, H, .true., 'of a loaded wing to E', 1.0_rp, LIMIT)
    call simulation%evaluate(other, effects, damping, r, ok)
    call simulation%mass_tangent(MASS_VEINS, effects, column)
    call compare(other, effects, column, 0, MASS_VEINS, H, .true., 'of a loaded wing to its weight', 1.0_rp, LIMIT)
    damping%joints = 1.0e-4_rp
    call simulation%evaluate(other, effects, damping, r, ok)
    call parameter_direction(simulation%model(), other%find('joint:C_h'), direction)
    call simulation%stiffness_tangent(direction, column)
    call compare(other, effects, column, other%find('joint:C_h'), 0, H, .true., 'of a loaded wing to a joint with friction', &
                 1.0_rp, LIMIT)
    damping = damping_effects_t()
    options%factorisation_limit = 1
    call simulation%init(m, model, parts, options)
    call simulation%evaluate(params, effects, damping, r, ok)
    call t%check('a shape that is not found is no evaluation',.not. ok)
    deallocate (r)
  end subroutine test_loaded

  !> A rod of circular section vibrates at equal frequencies along y and z; the places see z alone, and a mode of the computed pair
  !> is any mix of both: the pair is taken as one.
  subroutine test_repeated()
    logical :: ok
    integer :: i
    wing = make_beam(24, 1.0_rp, 0.01_rp, [1.0_rp, 0.0_rp, 0.0_rp])
    params = default_params(wing)
    call prepare()
    call measure(MEDIUM_VACUUM, [1, 3])
    call simulation%evaluate(params, mass_effects_t(), damping, r, ok)
    call t%check('modes of a rod are computed', ok)
    call t%check('a measured mode is paired with both of equal frequency', &
                 all([(simulation%targets(i)%hi - simulation%targets(i)%lo, i=1, 2)] == 1))
    call t%check_below('the space of both holds the measured one', maxval(abs(r)), 1.0e-3_rp)
    call test_slopes('of a rod', 1.0e-6_rp)
  end subroutine test_repeated
end program test_mode_simulation

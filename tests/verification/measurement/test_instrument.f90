! SPDX-License-Identifier: GPL-3.0-or-later
!> What a measurement and a wing may do beyond the usual: derivatives of the residuals with respect to every parameter of
!> the instrument, to effects of the wing (a clamp that gives way among them), to effects that are only scanned and to
!> accidents of single loads equal differences of residuals, where all vanish and where they do not.
program test_instrument
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use loaded_wing, only: wing_of_argument
  use measurement_data, only: measurement_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use measurement_instrument, only: instrument_t
  use measurement_instrument_causes, only: CREEP, CREEP_TIME, DRIFT, DRIFT_RATE, DRIFT_VEINS, GRAVITY_X, GRAVITY_Z, HEIGHT_SCALE, &
                                           N_INSTRUMENT, TILT_X
  use measurement_simulation, only: N_NUISANCES
  use named_params, only: set_each, value_of
  use solid_mass, only: lump_mass, mass_params_t, mass_t
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t, MEMBRANE_UNIFORM
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N_LOADS = 2, NX = 45, NY = 24
  real(rp), parameter :: POINTS(2, N_LOADS) = reshape([7.21e-3_rp, -3.2e-4_rp, 4.96e-3_rp, -2.28e-3_rp], [2, N_LOADS])
  real(rp), parameter :: FORCES(N_LOADS) = [2.8e-4_rp, 1.4e-4_rp]
  !> Values away from null, in the order of the parameters.
real(rp), parameter :: VALUES(N_INSTRUMENT) = [1.07_rp, 1.5e-5_rp, 0.06_rp, -0.04_rp, 3.0e-5_rp, -2.1e-5_rp, -0.02_rp, &
                                                 1.0e-4_rp, 0.015_rp, 0.08_rp, 2.0_rp, 1.03_rp, 4.0e-3_rp, -3.0e-3_rp, &
                                                2.0e-5_rp, 4.0e-5_rp, -3.3e-5_rp, 0.011_rp, 1.004_rp, 3.0_rp, -2.0_rp, &
                                                 9.0_rp, 0.3_rp]
  !> Differences of the fourth order with steps of 1/500 of the usual size, from shapes to 1e-10 of the load. Residuals
  !> whose grid point passes from one triangle to the next within the steps, less than 1 um of 0.5 mm, have a kink there:
  !> up to 1 in 100 of them are left out.
  real(rp), parameter :: LIMIT = 1.0e-6_rp, STEP = 2.0e-3_rp, KINKS = 0.01_rp
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(measurement_t) :: m
  type(mass_t) :: mass
  type(static_options_t) :: options
  type(experiment_t) :: experiment
  type(evaluation_work_t) :: work

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  options%tolerance = 1.0e-10_rp
  call measure()
  call check_null()
  call check_derivatives('at null', is_null=.true.)
  call check_derivatives('away from null', is_null=.false.)
  call check_refusals()
  call t%finish()

contains

  !> Heights that are all 0 with everything that the instrument's parameters need, and the masses of the wing.
  subroutine measure()
    type(mass_params_t) :: material
    type(message_list_t) :: messages
    integer :: l, i, j
    material%membrane_law = MEMBRANE_UNIFORM
    call lump_mass(wing, material, mass, messages)
    call t%check('the wing has a mass', messages%count() == 0)
    allocate (m%x(NX), m%y(NY), m%unloaded(NX, NY), m%unloaded_sigma(NX, NY), m%has_unloaded(NX, NY), &
              m%loads(N_LOADS), m%observations(0), m%zeros(0))
    m%x = [(minval(wing%points(1, :)) + (i - 0.37_rp)*1.02_rp*extent(1)/NX, i=1, NX)]
    m%y = [(minval(wing%points(2, :)) + (j - 0.41_rp)*1.02_rp*extent(2)/NY, j=1, NY)]
    m%unloaded = 0
    m%unloaded_sigma = 1.0e-6_rp
    m%has_unloaded = .true.
    m%accuracy%height = 1.0e-6_rp
    m%accuracy%force = 1.0e-6_rp
    m%accuracy%position = 2.0e-5_rp
    m%accuracy%tilt = 1.0e-3_rp
    m%accuracy%piston = 5.0e-6_rp
    do l = 1, N_LOADS
      associate (load => m%loads(l))
        load%name = 'load_'//achar(iachar('0') + l)
        load%force = FORCES(l)
        load%direction = [0.0_rp, 0.0_rp, 1.0_rp]
        load%point = POINTS(:, l)
        load%order = 2 + 3*l
        load%time = 100.0_rp*l
        load%hold = 4.0_rp*l
        load%has_surface = .true.
        load%node = reshape([((i, j, i=1, NX), j=1, NY)], [2, NX*NY])
        allocate (load%height(NX*NY), source=0.0_rp)
        allocate (load%sigma(NX*NY), source=1.0e-6_rp)
      end associate
    end do
  end subroutine measure

  pure real(rp) function extent(direction)
    integer, intent(in) :: direction
    extent = maxval(wing%points(direction, :)) - minval(wing%points(direction, :))
  end function extent

  function wing_params(is_null) result(params)
    logical, intent(in) :: is_null
    type(solid_params_t) :: params
    params = default_params(wing)
    params%joint = 1.0e-6_rp
    params%effects%has_sided_veins = .true.
    params%effects%disc = [4.5e-3_rp, -0.5e-3_rp, 1.2e-3_rp]
    if (is_null) return
    call params%set_named('E_gradient', -0.7_rp)
    call params%set_named('damage', 0.4_rp)
    call params%set_named('joint_hardening', 8.0_rp)
    call params%set_named('root_flap', 3000.0_rp)
    call params%set_named('root_twist', 9000.0_rp)
    call set_each(params, 'camber_', [0.4_rp, 15.0_rp, -3.0_rp])
    call params%set_named('pretension', 0.03_rp)
  end function wing_params

  !> An instrument that is asked for, but does nothing, changes no bit.
  subroutine check_null()
    type(experiment_t) :: plain
    type(evaluation_work_t) :: other
    type(evaluation_t) :: a, b
    type(failure_t) :: failure
    type(solid_params_t) :: params
    real(rp), allocatable :: u(:, :), v(:, :)
    integer :: i, free_parameters(3)
    params = wing_params(.true.)
    free_parameters = [params%find('E'), params%find('joint_hardening'), params%find('root_flap')]
    call plain%init(m, wing, params, [params%find('E')], options, failure)
    call experiment%init(m, wing, params, free_parameters, options, failure, &
                         instrument_numbers=pack([(i, i=1, N_INSTRUMENT)], [(i < GRAVITY_X, i=1, N_INSTRUMENT)]))
    call t%check('the experiment is made',.not. failure%failed)
    call t%check('it has all unknowns', experiment%count() == 3 + 19 .and. plain%count() == 1)
    allocate (u(3, plain%model%n_all), v(3, plain%model%n_all), source=0.0_rp)
    call work%init(experiment)
    call other%init(plain)
    call a%init(experiment, 1, .true.)
    call b%init(plain, 1, .true.)
    call evaluate(experiment, work, experiment%start(), 1, .false., u, a)
    call evaluate(plain, other, plain%start(), 1, .false., v, b)
    call t%check('what vanishes changes no bit of residuals', a%is_solved .and. &
                 all(transfer(a%residuals, [1]) == transfer(b%residuals, [1])))
    call t%check('  nor of derivatives', all(transfer(a%jacobian(:, 1), [1]) == transfer(b%jacobian(:, 1), [1])))
    call other%free()
    call work%free()
  end subroutine check_null

  subroutine check_derivatives(where, is_null)
    character(*), intent(in) :: where
    logical, intent(in) :: is_null
    type(instrument_t) :: instrument
    type(solid_params_t) :: params
    type(failure_t) :: failure
    type(evaluation_t) :: at
    type(parameter_t) :: p
    real(rp), allocatable :: u(:, :), x(:), difference(:)
    integer :: l, i
    if (.not. is_null) instrument%values = VALUES
    params = wing_params(is_null)
    call experiment%init(m, wing, params, [params%find('E'), params%find('joint:'//trim(params%joint_names(1))), &
                                           params%find('E_gradient'), params%find('damage'), &
                                           params%find('joint_hardening'), params%find('root_flap'), &
                                           params%find('root_twist'), params%find('camber_chord'), &
                                           params%find('camber_twist'), params%find('pretension')], options, failure, &
                         instrument, &
                         [(i, i=1, N_INSTRUMENT)], mass%nodal)
    call t%check('the experiment is made '//where,.not. failure%failed)
    call work%init(experiment)
    x = experiment%start()
    do l = merge(1, 2, is_null), N_LOADS, 2
      u = spread([0.0_rp, 0.0_rp, 0.0_rp], 2, experiment%model%n_all)
      call at%init(experiment, l, .true.)
      call evaluate(experiment, work, x, l, .false., u, at)
      call t%check('the shape is found '//where, at%is_feasible() .and. at%snaps == 0)
      call check_accidents(where, l, x, u)
      call check_aside(where, l, x)
      do i = 1, experiment%count()
        p = experiment%describe(i)
        call differ(l, x, i, p, u, difference)
        call t%check('residuals depend on '//p%name//' '//where, maxval(abs(at%jacobian(:, i))) > 0 .or. &
                     (p%name == 'creep_time' .and. is_null))
        call compare('derivative to '//p%name//' '//where, difference, at%jacobian(:, i))
      end do
    end do
    call work%free()
  end subroutine check_derivatives

  subroutine compare(what, difference, derivative)
    character(*), intent(in) :: what
    real(rp), intent(in) :: difference(:), derivative(:)
    real(rp), allocatable :: errors(:)
    integer :: n
    errors = abs(difference - derivative)/max(maxval(abs(derivative)), tiny(1.0_rp))
    n = count(errors >= LIMIT)
    if (n <= KINKS*size(errors)) then
      call t%check_below(what, maxval(errors, mask=errors < LIMIT), LIMIT)
    else
      call t%check_below(what, maxval(errors), LIMIT)
    end if
  end subroutine compare

  subroutine differ(l, x, i, p, u, difference)
    integer, intent(in) :: l, i
    real(rp), intent(in) :: x(:), u(:, :)
    type(parameter_t), intent(in) :: p
    real(rp), allocatable, intent(out) :: difference(:)
    type(evaluation_t) :: ahead, behind
    real(rp) :: h, y(size(x)), v(3, size(u, 2))
    integer :: s
    h = STEP*merge(p%prior_sd, 0.1_rp, p%prior_sd > 0)
    if (index(p%name, 'map_') == 1) h = h/20 ! all points move, but no shape is computed anew
    call ahead%init(experiment, l, .false.)
    call behind%init(experiment, l, .false.)
    allocate (difference(experiment%count_residuals(l)), source=0.0_rp)
    do s = 1, 2
      y = x
      v = u
      y(i) = x(i) + s*h
      call evaluate(experiment, work, y, l, .true., v, ahead)
      y(i) = x(i) - s*h
      v = u
      call evaluate(experiment, work, y, l, .true., v, behind)
      if (.not. (ahead%is_solved .and. behind%is_solved)) call t%check('neighbours are found', .false.)
      difference = difference + merge(4, -1, s == 1)*(ahead%residuals - behind%residuals)/(6*s*h)
    end do
  end subroutine differ

  !> Right after an evaluation: derivatives to things that are not unknowns are those of the unknown of the same name,
  !> and accidents those of a measurement that states another force or place.
  subroutine check_accidents(where, l, x, u)
    character(*), intent(in) :: where
    integer, intent(in) :: l
    real(rp), intent(in) :: x(:), u(:, :)
    real(rp), allocatable :: columns(:, :), column(:), damage(:)
    real(rp) :: sd(N_NUISANCES)
    integer :: n, h, i
    n = experiment%count_residuals(l)
    allocate (columns(n, N_NUISANCES), column(n), damage(n))
    call work%nuisance_tangents(experiment, l, columns, sd)
    call t%check('declared sd '//where, all(abs(sd - [1.0e-6_rp, 2.0e-5_rp, 2.0e-5_rp, 1.0e-3_rp, 1.0e-3_rp, &
                                                      5.0e-6_rp]) < 1.0e-18_rp))
    call work%instrument_tangent(experiment, l, 2, column)
    call t%check_below('an accident of the force is an offset '//where, maxval(abs(columns(:, 1) - column)), &
                       1.0e-9_rp*maxval(abs(column)))
    do i = 1, 2
      call work%instrument_tangent(experiment, l, 4 + i, column)
      call t%check_below('  of the place a shift '//where, maxval(abs(columns(:, 1 + i) - column)), &
                         1.0e-9_rp*maxval(abs(column)))
    end do
    do i = 1, 3
      call work%instrument_tangent(experiment, l, TILT_X - 1 + i, column)
      call t%check_below('  of the scan a tilt '//where, maxval(abs(columns(:, 3 + i) - column)), &
                         1.0e-15_rp*maxval(abs(column)))
    end do
    ! The hinges of the first joint, whose stiffness is an unknown, and damage where the model has none.
    column = 0
    do h = 1, size(experiment%model%plans)
      if (experiment%model%plans(h)%joint /= 1) cycle
      call work%hinge_tangent(experiment, l, h, damage)
      column = column + damage
    end do
    call work%derivative(experiment, l, 2, damage)
    call t%check_below('a joint is the sum of its hinges '//where, maxval(abs(column - damage)), &
                       1.0e-9_rp*maxval(abs(damage)))
    call work%damage_tangent(experiment, l, experiment%model%params%effects%disc, damage)
    call work%derivative(experiment, l, 4, column)
    if (abs(value_of(experiment%model%params, 'damage') - 1) <= 0) &
      call t%check_below('damage anywhere '//where, maxval(abs(column - damage)), 1.0e-12_rp*maxval(abs(column)))
    call t%check('  depends on it', maxval(abs(damage)) > 0 .and. size(x) > 0 .and. size(u) > 0)
  end subroutine check_accidents

  !> A force aside of its place is one of an instrument whose forces all are: the same place, found twice.
  subroutine check_aside(where, l, x)
    character(*), intent(in) :: where
    integer, intent(in) :: l
    real(rp), intent(in) :: x(:)
    real(rp), parameter :: EARLIER_SUFFIX(2) = [2.5e-5_rp, -4.0e-5_rp]
    type(evaluation_t) :: at, moved, shifted
    real(rp), allocatable :: u(:, :)
    real(rp) :: y(size(x))
    integer :: i, k
    call at%init(experiment, l, .false.)
    call moved%init(experiment, l, .false.)
    call shifted%init(experiment, l, .false.)
    u = spread([0.0_rp, 0.0_rp, 0.0_rp], 2, experiment%model%n_all)
    call evaluate(experiment, work, x, l, .false., u, at)
    call evaluate(experiment, work, x, l, .false., u, moved, EARLIER_SUFFIX)
    y = x
    do i = 1, size(x)
      k = findloc(['load_shift_x', 'load_shift_y'], experiment_name(i), dim=1)
      if (k > 0) y(i) = y(i) + EARLIER_SUFFIX(k)
    end do
    call evaluate(experiment, work, y, l, .false., u, shifted)
    call t%check('all shapes beside are found '//where, moved%is_feasible() .and. shifted%is_feasible())
    call t%check_below('a force aside is a shifted one '//where, maxval(abs(moved%residuals - shifted%residuals)), &
                       1.0e-12_rp*maxval(abs(shifted%residuals)))
    call t%check('  and bends otherwise '//where, maxval(abs(moved%residuals - at%residuals)) > &
                 1.0e-3_rp*maxval(abs(at%residuals)))
  end subroutine check_aside

  character(12) function experiment_name(i) result(name)
    integer, intent(in) :: i
    type(parameter_t) :: p
    p = experiment%describe(i)
    name = p%name
  end function experiment_name

  !> Scans of instruments that are no unknowns give the same; what data lack is refused.
  subroutine check_refusals()
    type(experiment_t) :: other
    type(evaluation_work_t) :: plain_work, full_work
    type(evaluation_t) :: a, b
    type(solid_params_t) :: params
    type(failure_t) :: failure
    real(rp), allocatable :: u(:, :), column(:), expected(:)
    real(rp) :: worst
    integer :: i
    params = wing_params(.true.)
    call experiment%init(m, wing, params, [integer ::], options, failure, &
                         instrument_numbers=[(i, i=1, N_INSTRUMENT)], masses=mass%nodal)
    call other%init(m, wing, params, [params%find('E')], options, failure, masses=mass%nodal)
    call plain_work%init(other)
    call full_work%init(experiment)
    call a%init(experiment, 1, .true.)
    call b%init(other, 1, .true.)
    u = spread([0.0_rp, 0.0_rp, 0.0_rp], 2, other%model%n_all)
    call evaluate(experiment, full_work, experiment%start(), 1, .false., u, a)
    call evaluate(other, plain_work, other%start(), 1, .false., u, b)
    allocate (column(other%count_residuals(1)))
    worst = 0
    do i = 1, N_INSTRUMENT
      call plain_work%instrument_tangent(other, 1, i, column)
      expected = a%jacobian(:, i)
      worst = max(worst, maxval(abs(column - expected))/max(maxval(abs(expected)), tiny(worst)))
    end do
    ! The unloaded shape, 0, is found in two ways, which round differently; soft directions make more of it.
    call t%check_below('a scan of what is no unknown is the same', worst, 1.0e-7_rp)
    call full_work%free()
    call full_work%init(other)
    call evaluate(other, plain_work, other%start() + 0.3_rp, 1, .false., u, b)
    call plain_work%instrument_tangent(other, 1, GRAVITY_Z, column)
    call evaluate(other, full_work, other%start() + 0.3_rp, 1, .false., u, b)
    call full_work%instrument_tangent(other, 1, GRAVITY_Z, expected)
    call t%check('of another wing it does not depend on the wing before',.not. any(abs(column - expected) > 0))
    call plain_work%free()
    call full_work%free()
    call other%init(m, wing, params, [integer ::], options, failure, instrument_numbers=[GRAVITY_X])
    call t%check('weight needs masses', failure%failed)
    m%loads(1)%order = 0
    m%loads(2)%time = -1
    m%loads%hold = -1
    do i = 1, N_INSTRUMENT
      call other%init(m, wing, params, [integer ::], options, failure, instrument_numbers=[i], masses=mass%nodal)
      call t%check('what drift and creep need', failure%failed .eqv. any(i == [DRIFT, DRIFT_RATE, DRIFT_VEINS, CREEP, &
                                                                               CREEP_TIME]))
    end do
    m%loads%has_surface = .false.
    call other%init(m, wing, params, [integer ::], options, failure, instrument_numbers=[HEIGHT_SCALE])
    call t%check('a scale of heights needs heights', failure%failed)
  end subroutine check_refusals
end program test_instrument

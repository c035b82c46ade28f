! SPDX-License-Identifier: GPL-3.0-or-later
!> Natural modes about a loaded shape: a cantilever under axial loads against the exact frequencies, up to buckling; where
!> frequencies repeat; a bent wing against another solver, and its derivatives against differences; rest as the limit of no load.
!> The first argument names a wing file.
program test_solid_loaded_modes
  use base_constants, only: PI, TWO_PI
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_lapack, only: symmetric_eigen
  use base_parameter, only: parameter_t
  use loaded_wing, only: load_at, wing_of_argument, MODERATE_FORCES
  use cantilever, only: make_cantilever
  use solid_equilibrium, only: equilibrium_t
  use solid_inertia, only: inertia_t
  use solid_loads, only: load_t
  use solid_mass, only: lump_mass, mass_params_t, mass_t
  use solid_mass_effects, only: mass_effects_t, mass_parts_t, MASS_POINT, MASS_VEINS
  use solid_modal, only: modal_t, mode_slopes_t
  use solid_model, only: solid_model_t
  use solid_modes, only: natural_modes
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: parameter_direction
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: K = 4                !< modes that are compared
  real(rp), parameter :: AIR = 1.2_rp        !< [kg/m^3]
  real(rp), parameter :: NO_GRAVITY(3) = 0, GRAVITY(3) = [30.0_rp, 20.0_rp, -100.0_rp] !< [m/s^2]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(mass_parts_t) :: parts
  type(mass_effects_t) :: effects
  real(rp), allocatable :: force(:, :)

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  call test_column()
  call test_repeated()
  call prepare_wing()
  call test_rest()
  call test_other_solver()
  call test_slopes()
  call test_failures()
  call t%finish()

contains

  !> Length, mass and bending stiffness 1 with a dead force p along it at its tip: pull raises frequencies, push lowers them until
  !> the column buckles at p = -(pi/2)^2. Both planes vibrate alike. 60 segments are off by some h^2, 2.5e-3 of lambda in the second
  !> mode near buckling.
  subroutine test_column()
    real(rp), parameter :: BUCKLING = (PI/2)**2, LOADS(2) = BUCKLING*[-0.95_rp, 4.0_rp]
    type(modal_t) :: modal
    integer :: i, j
    do i = 1, size(LOADS)
      call solve_column(modal, LOADS(i), 1.0_rp)
      do j = 1, 4
        call t%check_close('a cantilever under an axial load has its exact frequency', modal%lambda(j), &
                           exact_lambda(LOADS(i), (j + 1)/2), rtol=3.0e-3_rp)
      end do
      call t%check('pull raises the lowest frequency, push lowers it', &
                   (modal%lambda(1) > exact_lambda(0.0_rp, 1)) .eqv. LOADS(i) > 0)
      call modal%free()
    end do
  end subroutine test_column

  !> Modes of the column under the axial force p with the factor `young` on its stiffness.
  subroutine solve_column(modal, p, young, extra)
    type(modal_t), intent(inout) :: modal
    real(rp), intent(in) :: p, young
    real(rp), intent(in), optional :: extra(:, :) !< (3, n_all) of mass
    integer, parameter :: N = 60
    type(solid_model_t) :: column
    type(inertia_t) :: inertia
    type(failure_t) :: failure
    real(rp), allocatable :: pull(:, :), mass(:, :)
    call make_cantilever(N, young, 1.0e7_rp, column, inertia)
    call modal%init(column)
    mass = spread(inertia%mass, 1, 3)
    if (present(extra)) mass = mass + extra
    pull = 0*mass
    pull(1, N + 1) = p
    call modal%bend(mass, pull, NO_GRAVITY, static_options_t(), failure)
    if (.not. failure%failed) call modal%solve(mass, 8, failure)
    call t%check('a cantilever under an axial load vibrates',.not. failure%failed)
  end subroutine solve_column

  !> Root number `mode` of the frequency equation of that cantilever, by bisection from below.
  real(rp) function exact_lambda(p, mode) result(lambda)
    real(rp), intent(in) :: p
    integer, intent(in) :: mode
    real(rp) :: a, b, step
    integer :: found, i
    step = 0.05_rp
    found = 0
    b = 1.0e-6_rp
    do while (found < mode)
      a = b
      b = b + step
      if (determinant(a, p)*determinant(b, p) <= 0) found = found + 1
    end do
    do i = 1, 60
      lambda = 0.5_rp*(a + b)
      if (determinant(a, p)*determinant(lambda, p) <= 0) then
        b = lambda
      else
        a = lambda
      end if
    end do
  end function exact_lambda

  !> W = A (cosh s1 x - cos s2 x) + B (sinh s1 x - s1/s2 sin s2 x), W'' = 0 and W''' = p W' at the tip.
  pure real(rp) function determinant(lambda, p)
    real(rp), intent(in) :: lambda, p
    real(rp) :: s1, s2
    s1 = sqrt(0.5_rp*(sqrt(p**2 + 4*lambda) + p))
    s2 = sqrt(0.5_rp*(sqrt(p**2 + 4*lambda) - p))
    determinant = (s1**2*cosh(s1) + s2**2*cos(s2))*(s2**2*cosh(s1) + s1**2*cos(s2)) - &
                  (s1**2*sinh(s1) + s1*s2*sin(s2))*(s2**2*sinh(s1) - s1*s2*sin(s2))
  end function determinant

  !> Frequencies that repeat, of a column under a pull. E changes both of a pair alike: with mass and length 1,
  !> lambda = E f(p/E), which differences of f give. A mass that acts along z alone splits the pair; the slopes of both parts are
  !> the eigenvalues of the pair's forces, and the plane y feels nothing.
  subroutine test_repeated()
    real(rp), parameter :: PULL = 3.0_rp, H = 1.0e-3_rp
    type(modal_t) :: modal, other
    type(stiffness_t) :: direction
    type(mode_slopes_t) :: slopes
    real(rp), allocatable :: extra(:, :)
    real(rp) :: split(4), pair(2, 2), values(2), want
    logical :: same(4, 4)
    integer :: i, other_one
    call solve_column(modal, PULL, 1.0_rp)
    same = reshape([.true., .true., .false., .false., .true., .true., .false., .false., &
                    .false., .false., .true., .true., .false., .false., .true., .true.], [4, 4])
    call parameter_direction(modal%model, 1, direction) ! log E
    call modal%slopes_of_stiffness(direction, same, slopes)
    do i = 1, 4
      other_one = merge(i + 1, i - 1, mod(i, 2) == 1)
      call t%check_below('frequencies of both planes repeat', abs(modal%lambda(i)/modal%lambda(other_one) - 1), 1.0e-8_rp)
      want = exact_lambda(PULL, (i + 1)/2) - PULL*(exact_lambda(PULL + H, (i + 1)/2) - exact_lambda(PULL - H, (i + 1)/2))/(2*H)
      call t%check_close('E stiffens a pulled column less than one at rest', slopes%force(i, i), want, rtol=3.0e-3_rp)
      call t%check_below('both planes at once', abs(slopes%force(other_one, i))/modal%lambda(i), 1.0e-7_rp)
    end do
    extra = 0*modal%shapes(:, :, 1)
    extra(3, :) = [(1.0e-2_rp*sin(2.0_rp*i), i=1, size(extra, 2))]
    call modal%slopes_of_mass(extra, same, slopes)
    split = 0
    do i = -1, 1, 2
      call solve_column(other, PULL, 1.0_rp, extra=i*H*extra)
      split = split + i*other%lambda(:4)/(2*H)
      call other%free()
    end do
    do i = 1, 3, 2
      pair = 0.5_rp*(slopes%force(i:i + 1, i:i + 1) + transpose(slopes%force(i:i + 1, i:i + 1)))
      call symmetric_eigen(pair, values)
      want = values(maxloc(abs(values), 1))
      ! The split part is above the other one on one side and below it on the other; their sum does not feel the order.
      call t%check_close('what splits a pair has the slope of one part', sum(split(i:i + 1)), want, rtol=1.0e-5_rp)
      call t%check_below('and the other part does not feel it', minval(abs(values)), 1.0e-6_rp*abs(want))
    end do
    call modal%free()
  end subroutine test_repeated

  subroutine prepare_wing()
    type(mass_params_t) :: material
    type(mass_t) :: mass
    type(message_list_t) :: messages
    type(failure_t) :: failure
    type(solid_params_t) :: params
    type(load_t) :: load
    integer :: i
    call lump_mass(wing, material, mass, messages)
    call parts%init(wing, mass)
    params = default_params(wing)
    params%joint = 1.0e-6_rp
    params%effects%has_sided_veins = .true.
    call params%set_named('E_gradient', -0.5_rp)
    call params%set_named('torsion', 0.5_rp)
    call params%set_named('joint_hardening', 2.0_rp)
    call model%init(wing, params, failure)
    call t%check('the wing is valid', messages%count() == 0 .and. .not. failure%failed)
    effects%corner = wing%triangles(:, size(wing%triangles, 2)/2)
    effects%weight = [0.5_rp, 0.3_rp, 0.2_rp]
    effects%point = 5.0e-9_rp
    allocate (force(3, model%n_all), source=0.0_rp)
    do i = 5, 8, 3
      call load_at(model, i, MODERATE_FORCES(i), load)
      force = force + load%force
    end do
    force(1, :) = 0.3_rp*force(3, :)
  end subroutine prepare_wing

  !> The wing with these parameters and masses, under the load or, times 0, at rest.
  subroutine solve(modal, params, mass_effects, times)
    type(modal_t), intent(inout) :: modal
    type(solid_params_t), intent(in) :: params
    type(mass_effects_t), intent(in) :: mass_effects
    real(rp), intent(in) :: times
    type(static_options_t) :: options
    type(failure_t) :: failure
    real(rp) :: mass(3, modal%model%n_all)
    options%tolerance = 1.0e-10_rp
    call modal%model%set_params(params)
    call parts%masses(mass_effects, AIR, mass)
    call modal%bend(mass, times*force, times*GRAVITY, options, failure)
    if (.not. failure%failed) call modal%solve(mass, K + 3, failure)
    if (failure%failed) call t%check('modes are found: '//failure%reason, .false.)
  end subroutine solve

  !> The change from shapes a to shapes b, whose signs are arbitrary.
  pure real(rp) function difference(a, b)
    real(rp), intent(in) :: a(:, :, :), b(:, :, :)
    integer :: m
    difference = 0
    do m = 1, size(a, 3)
      difference = max(difference, min(norm2(a(:, :, m) - b(:, :, m)), norm2(a(:, :, m) + b(:, :, m)))/norm2(a(:, :, m)))
    end do
  end function difference

  !> No load is rest, up to the rounding of the forces of hinges with a rest angle.
  subroutine test_rest()
    type(modal_t) :: modal, unloaded
    real(rp), parameter :: ROUNDING = 1.0e-10_rp ! residuals of 1e-12, over gaps of a tenth
    type(mode_slopes_t) :: slopes, slopes_at_rest
    type(stiffness_t) :: direction
    type(failure_t) :: failure
    real(rp) :: mass(3, model%n_all)
    logical :: same(K, K)
    same = .false.
    call modal%init(model)
    call unloaded%init(model)
    call solve(unloaded, model%params, effects, 0.0_rp)
    call parts%masses(effects, AIR, mass)
    call modal%solve(mass, K + 3, failure)
    call t%check_below('modes about a shape without load are those about rest', &
                       maxval(abs(modal%lambda/unloaded%lambda - 1)) + &
                       difference(modal%shapes, unloaded%shapes), ROUNDING)
    call parameter_direction(model, model%params%find('E'), direction)
    call modal%slopes_of_stiffness(direction, same, slopes_at_rest)
    call unloaded%slopes_of_stiffness(direction, same, slopes)
    call t%check_below('and so are their slopes', &
                       norm2(abs(slopes%force) - abs(slopes_at_rest%force))/norm2(slopes%force) + &
                       difference(slopes%shapes, slopes_at_rest%shapes), ROUNDING)
    call modal%free()
    call unloaded%free()
  end subroutine test_rest

  !> The same modes by subspace iteration about the shape of the statics, in a vacuum.
  subroutine test_other_solver()
    type(modal_t) :: modal
    type(equilibrium_t) :: work
    type(load_t) :: load
    type(static_report_t) :: report
    type(failure_t) :: failure
    real(rp) :: mass(3, model%n_all), u(3, model%n_all), f(K), shapes(3, model%n_all, K), rest(K)
    integer :: i
    call modal%init(model)
    call parts%masses(effects, 0.0_rp, mass)
    call modal%solve(mass, K + 3, failure)
    rest = modal%lambda(:K)
    call modal%bend(mass, force, GRAVITY, static_options_t(), failure)
    call modal%solve(mass, K + 3, failure)
    call t%check('the bent wing vibrates',.not. failure%failed)
    call load%init(model)
    load%force = force
    call load%add_gravity(mass(1, :model%n_points), GRAVITY)
    call work%init(model)
    call solve_static(work, model, load, .false., static_options_t(), u, report)
    call natural_modes(work, model, load, mass(1, :), u, f, shapes, failure)
    call t%check_below('the load bends the wing by a tenth of its length', 0.1_rp, maxval(norm2(u, 1))/model%size)
    do i = 1, K
      call t%check_close('modes about a bent shape are those of another solver', sqrt(modal%lambda(i))/TWO_PI, f(i), &
                         rtol=1.0e-8_rp)
    end do
    call t%check_below('the load changes frequencies', 0.05_rp, maxval(abs(modal%lambda(:K)/rest - 1)))
    call work%free()
    call modal%free()
  end subroutine test_other_solver

  subroutine test_slopes()
    character(18), parameter :: NAMES(3) = [character(18) :: 'E', 'k_membrane', 'joint_hardening']
    integer, parameter :: MASSES(1) = [MASS_VEINS]
    type(modal_t) :: modal, other
    type(mode_slopes_t) :: slopes
    type(stiffness_t) :: direction
    type(parameter_t) :: p
    real(rp) :: dm(3, model%n_all)
    logical :: same(K, K)
    integer :: i
    same = .false.
    call modal%init(model)
    call other%init(model)
    call solve(modal, model%params, effects, 1.0_rp)
    do i = 1, size(NAMES)
      p = model%params%describe(model%params%find(trim(NAMES(i))))
      call parameter_direction(modal%model, model%params%find(trim(NAMES(i))), direction)
      call modal%slopes_of_stiffness(direction, same, slopes)
      call compare(modal, other, slopes, p, model%params%find(trim(NAMES(i))), 0)
    end do
    do i = 1, size(MASSES)
      p%name = 'mass effect '//achar(48 + MASSES(i))
      p%is_log = MASSES(i) /= MASS_POINT
      p%prior_sd = merge(2.5e-8_rp, 1.0_rp, MASSES(i) == MASS_POINT)
      call parts%derivative(effects, AIR, MASSES(i), dm)
      call modal%slopes_of_mass(dm, same, slopes)
      call compare(modal, other, slopes, p, 0, MASSES(i))
    end do
    call modal%free()
    call other%free()
  end subroutine test_slopes

  !> Differences of fourth order with respect to parameter i of the wing, or effect j of its masses. In a bent wing modes stretch
  !> springs whose stiffness is 1e6 times that of the lowest mode, whose frequency therefore has a rounding error of 3e-10. Over h
  !> that is 1e-7; the error of the differences, (h/1)^4/30 of the fifth derivative, is smaller.
  subroutine compare(modal, other, slopes, p, i, j)
    type(modal_t), intent(in) :: modal
    type(modal_t), intent(inout) :: other
    type(mode_slopes_t), intent(in) :: slopes
    type(parameter_t), intent(in) :: p
    integer, intent(in) :: i, j
    real(rp), parameter :: WEIGHTS(4) = [1.0_rp, -8.0_rp, 8.0_rp, -1.0_rp]/12, AT(4) = [-2, -1, 1, 2], LIMIT = 5.0e-7_rp
    type(solid_params_t) :: changed
    type(mass_effects_t) :: masses
    real(rp) :: h, value, lambda(K), shapes(3, model%n_all, K), scale, error(2)
    integer :: n, m
    scale = 1
    if (.not. p%is_log .and. p%prior_sd > 0) scale = p%prior_sd ! per sd
    h = 5.0e-3_rp*scale
    lambda = 0
    shapes = 0
    do n = 1, 4
      changed = modal%model%params
      masses = effects
      if (i > 0) then
        value = changed%get(i)
        call changed%set(i, merge(value*exp(AT(n)*h), value + AT(n)*h, p%is_log))
      else
        value = effects%get(j)
        call masses%set(j, merge(value*exp(AT(n)*h), value + AT(n)*h, p%is_log))
      end if
      call solve(other, changed, masses, 1.0_rp)
      lambda = lambda + WEIGHTS(n)*other%lambda(:K)/h
      do m = 1, K
        shapes(:, :, m) = shapes(:, :, m) + WEIGHTS(n)/h*other%shapes(:, :, m)* &
                          sign(1.0_rp, sum(other%shapes(:, :, m)*modal%shapes(:, :, m)))
      end do
    end do
    error = 0
    do m = 1, K
      error(1) = max(error(1), scale*abs(lambda(m) - slopes%force(m, m))/modal%lambda(m))
      error(2) = max(error(2), scale*norm2(shapes(:, :, m) - slopes%shapes(:, :, m))/norm2(modal%shapes(:, :, m)))
    end do
    call t%check_below('derivative of frequencies to '//p%name//' in a bent wing', error(1), LIMIT)
    call t%check_below('derivative of shapes to '//p%name//' in a bent wing', error(2), LIMIT)
  end subroutine compare

  !> A shape that is not found, and a clamp that gives way, are failures.
  subroutine test_failures()
    type(modal_t) :: modal
    type(static_options_t) :: options
    type(failure_t) :: failure
    type(solid_params_t) :: params
    real(rp) :: mass(3, model%n_all)
    call modal%init(model)
    call parts%masses(effects, AIR, mass)
    options%factorisation_limit = 1
    call modal%bend(mass, force, GRAVITY, options, failure)
    call t%check('a shape that is not found is a failure', failure%failed)
    if (failure%failed) call t%check('with its reason', index(failure%reason, &
                                        'the loaded wing: no equilibrium is found with 1 factorisations') > 0)
    params = model%params
    call params%set_named('root_flap', 1.0e3_rp)
    call modal%model%set_params(params)
    call modal%bend(mass, force, GRAVITY, static_options_t(), failure)
    call t%check('so is a clamp that gives way', failure%failed)
    call modal%free()
  end subroutine test_failures
end program test_solid_loaded_modes

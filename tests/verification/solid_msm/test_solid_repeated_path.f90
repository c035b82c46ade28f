! SPDX-License-Identifier: GPL-3.0-or-later
!> Paths of the blowfly's wing, in the file that the first argument names, that lose their way: a second one with finer
!> settings finds the shape, which is then as good as any other.
program test_solid_repeated_path
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use cantilever, only: make_cantilever
  use loaded_wing, only: load_at, wing_of_argument
  use model_variation, only: set_parameter, shape_sensitivities
  use solid_equilibrium, only: equilibrium_t
  use solid_inertia, only: inertia_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: PLACE = 3
  real(rp), parameter :: FORCE = 5.12e-3_rp, JOINTS = 5 ! [N]; of the stiffness of the veins
  real(rp), parameter :: SAME = 1.0e-9_rp !< [m]; other shapes differ by micrometres
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_params_t) :: params
  type(solid_model_t) :: model
  type(equilibrium_t) :: work
  type(failure_t) :: failure
  type(load_t) :: load
  real(rp), allocatable :: u(:, :), before(:, :), after(:, :)

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  params = default_params(wing)
  params%young = 12.6e9_rp
  params%plate = 0.2e-6_rp
  call model%init(wing, params, failure)
  call t%check('the wing is valid',.not. failure%failed)
  params = model%params
  params%joint = JOINTS*params%joint
  call model%set_params(params)
  call work%init(model)
  allocate (u(3, model%n_all), before(3, model%n_all), after(3, model%n_all), source=0.0_rp)
  call solve_small_load(before)
  call load_at(model, PLACE, FORCE, load)
  call test_repeated()
  call test_sensitivities()
  call test_hopeless()
  call test_exhausted()
  call solve_small_load(after)
  call t%check('paths that lose their way leave nothing behind',.not. maxval(abs(after - before)) > 0)
  call work%free()
  call t%finish()

contains

  !> The second path ends in the shape to which stages of half the length lead.
  subroutine test_repeated()
    type(static_report_t) :: report
    type(static_options_t) :: options
    real(rp) :: by_short_stages(3, model%n_all)
    options%step_limit = options%step_limit/2
    call solve_static(work, model, load, .false., options, by_short_stages, report)
    call t%check('short stages find the shape', report%converged)
    options = static_options_t()
    call solve_static(work, model, load, .false., options, u, report)
    call t%check('a path that loses its way is repeated', report%was_repeated .and. .not. report%was_redone_cold)
    call t%check('and finds a stable equilibrium', report%converged .and. report%residual <= options%tolerance .and. &
                 .not. allocated(report%reason))
    call t%check('which is no start of warm solutions',.not. report%is_start)
    call t%check_below('and the same as by short stages', maxval(abs(by_short_stages - u)), SAME)
  end subroutine test_repeated

  !> The factorisation that the second path leaves gives the derivative to E: a central difference of shapes, warm from it.
  subroutine test_sensitivities()
    real(rp), parameter :: H = 2.5e-4_rp ! in ln E; an error of 3e-7, four times that at twice the step
    real(rp) :: d(3, model%n_all, 1), fd(3, model%n_all), other(3, model%n_all)
    type(static_report_t) :: report
    type(static_options_t) :: options
    integer :: p, side
    p = model%params%find('E')
    call shape_sensitivities(work, model, u, [p], d)
    fd = 0
    do side = -1, 1, 2
      call set_parameter(model, p, params%young*exp(side*H))
      other = u
      call solve_static(work, model, load, .true., options, other, report)
      call t%check('a warm start from the shape goes straight', report%converged .and. .not. report%was_redone_cold)
      fd = fd + side*other/(2*H)
    end do
    call set_parameter(model, p, params%young)
    call t%check_below('its derivative is the limit of differences', &
                       maxval(abs(fd - d(:, :, 1)))/maxval(abs(d)), 1.0e-6_rp)
  end subroutine test_sensitivities

  !> A straight column under four times Euler's load, which nothing pushes aside, stays straight: both paths end in this
  !> unstable equilibrium. So do those of a warm start, and only if it may be redone.
  subroutine test_hopeless()
    integer, parameter :: N = 8
    real(rp), parameter :: AXIS(3) = [1.0_rp, 0.0_rp, 0.0_rp], EULER = 0.25_rp*PI**2 ! [N] for L = 1 m, EI = 1 N m^2
    type(solid_model_t) :: column
    type(inertia_t) :: masses
    type(equilibrium_t) :: column_work
    type(load_t) :: axial_load
    type(static_report_t) :: cold, warm
    type(static_options_t) :: options
    real(rp), allocatable :: shape(:, :)
    call make_cantilever(N, 1.0_rp, 1.0e4_rp, column, masses)
    call axial_load%init(column)
    call axial_load%add_point(N + 1, -4*EULER*AXIS)
    call column_work%init(column)
    allocate (shape(3, column%n_all))
    call solve_static(column_work, column, axial_load, .false., options, shape, cold)
    call t%check('a path with an unstable end is repeated', cold%was_repeated .and. .not. cold%was_redone_cold)
    call t%check('in vain, which is told',.not. (cold%converged .or. cold%is_start) .and. &
                 index(cold%reason, 'is unstable (second try') > 0)
    shape = 0
    call solve_static(column_work, column, axial_load, .true., options, shape, warm)
    call t%check('a warm start is redone cold, and then repeated', warm%was_redone_cold .and. warm%was_repeated .and. &
                 warm%factorisations > cold%factorisations)
    options%redo_cold = .false.
    shape = 0
    call solve_static(column_work, column, axial_load, .true., options, shape, warm)
    call t%check('one that may not be redone is not repeated either',.not. warm%was_repeated)
    call column_work%free()
  end subroutine test_hopeless

  !> A path that needs too many factorisations would need more with finer settings.
  subroutine test_exhausted()
    type(static_report_t) :: report
    type(static_options_t) :: options
    real(rp) :: shape(3, model%n_all)
    options%factorisation_limit = 30
    call solve_static(work, model, load, .false., options, shape, report)
    call t%check('a path that needs too much work fails without repetition',.not. report%converged .and. &
                 .not. report%was_repeated .and. report%factorisations < 2*options%factorisation_limit)
  end subroutine test_exhausted

  !> A shape without difficulty, cold.
  subroutine solve_small_load(shape)
    real(rp), intent(out) :: shape(:, :)
    type(static_report_t) :: report
    call load_at(model, PLACE, 0.1_rp*FORCE, load)
    call solve_static(work, model, load, .false., static_options_t(), shape, report)
    call t%check('a path that keeps its way is not repeated', report%converged .and. .not. report%was_repeated)
  end subroutine solve_small_load
end program test_solid_repeated_path

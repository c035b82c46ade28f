! SPDX-License-Identifier: GPL-3.0-or-later
!> A path of the blowfly's wing, in the file that the first argument names, that snaps and whose last descent does not
!> converge: the one of the 160 of `bench/static` that has to be repeated.
program test_solid_repeated_path
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use bench_places, only: load_at, wing_of_argument
  use solid_equilibrium, only: equilibrium_t
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
  real(rp), allocatable :: u(:, :)

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
  allocate (u(3, model%n_all), source=0.0_rp)
  call load_at(model, PLACE, FORCE, load)
  call test_repeated()
  call test_exhausted()
  call work%free()
  call t%finish()

contains

  !> The shape at which the repeated path ends is the one to which the usual path comes with shorter stages.
  subroutine test_repeated()
    type(static_report_t) :: report
    type(static_options_t) :: options
    real(rp), allocatable :: by_short_stages(:, :)
    call solve_static(work, model, load, .false., options, u, report)
    call t%check('a path that does not come to its end is repeated', report%was_repeated)
    call t%check('and leads to a stable equilibrium', report%converged .and. report%residual <= options%tolerance .and. &
                 .not. allocated(report%reason))
    options%step_limit = 0.8_rp*options%step_limit
    allocate (by_short_stages(3, model%n_all), source=0.0_rp)
    call solve_static(work, model, load, .false., options, by_short_stages, report)
    call t%check('shorter stages need no repetition', report%converged .and. .not. report%was_repeated)
    call t%check_below('and lead to the same shape', maxval(abs(by_short_stages - u)), SAME)
  end subroutine test_repeated

  !> A path that needs too many factorisations would need more with finer settings.
  subroutine test_exhausted()
    type(static_report_t) :: report
    type(static_options_t) :: options
    options%factorisation_limit = 30
    call solve_static(work, model, load, .false., options, u, report)
    call t%check('a path that needs too much work fails without repetition',.not. report%converged .and. &
                 .not. report%was_repeated .and. report%factorisations < 2*options%factorisation_limit)
  end subroutine test_exhausted
end program test_solid_repeated_path

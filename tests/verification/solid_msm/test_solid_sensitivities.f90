! SPDX-License-Identifier: GPL-3.0-or-later
!> The derivatives of the shape of a blowfly's wing, in the file that the first argument names, to every
!> parameter equal central differences of equilibria under ten loads: under each load those to every other parameter, so
!> that every parameter meets five of the loads.
program test_solid_sensitivities
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use loaded_wing, only: N_LOADS, MODERATE_FORCES, load_at, wing_of_argument
  use model_variation, only: set_parameter, shape_sensitivities
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: H = 5.0e-4_rp !< half of a difference; H^2/6 is its error for an exponential
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_params_t) :: params
  type(solid_model_t) :: model
  type(equilibrium_t) :: work
  type(load_t) :: load
  type(failure_t) :: failure
  type(static_report_t) :: report
  type(static_options_t) :: options
  type(parameter_t) :: parameter
  real(rp), allocatable :: u(:, :), d(:, :, :)
  real(rp) :: scale, worst, error
  character(:), allocatable :: worst_name
  integer :: l, p, n_parameters

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  params = default_params(wing)
  params%cross_springs = .true.
  call model%init(wing, params, failure)
  call t%check('the wing is valid',.not. failure%failed)
  call t%check('it has the ten joints of the paper', size(wing%joints) == 10)
  n_parameters = model%params%count_basic() ! effects: test_effect_sensitivities
  call work%init(model)
  allocate (u(3, model%n_all), d(3, model%n_all, n_parameters), source=0.0_rp)
  do l = 1, N_LOADS
    call load_at(model, l, MODERATE_FORCES(l), load)
    call solve_static(work, model, load, .false., options, u, report)
    call t%check('the shape is found', report%converged)
    call shape_sensitivities(work, model, u, [(p, p=1, n_parameters)], d)
    scale = maxval(abs(d(:, :, model%params%find('E'))))
    worst = 0
    worst_name = ''
    do p = 1 + mod(l, 2), n_parameters, 2
      error = difference_error(p)
      parameter = model%params%describe(p)
      if (error > worst) worst_name = parameter%name
      worst = max(worst, error)
    end do
    call t%check_below('derivatives are the limits of differences; worst: '//worst_name, worst, 1.0e-6_rp)
  end do
  call work%free()
  call t%finish()

contains

  !> Error of the derivative to parameter p over its largest value, or over 1/1000 of the largest
  !> derivative to ln E if p matters less. Near a snap the third derivative is large; there a second
  !> difference with half the step makes the order four.
  real(rp) function difference_error(p) result(error)
    integer, intent(in) :: p
    real(rp), parameter :: GOOD = 1.0e-7_rp
    real(rp), dimension(3, model%n_all) :: wide, narrow
    real(rp) :: unit
    unit = max(maxval(abs(d(:, :, p))), 1.0e-3_rp*scale)
    call difference(p, H, wide)
    error = maxval(abs(wide - d(:, :, p)))/unit
    if (error < GOOD) return
    call difference(p, H/2, narrow)
    error = maxval(abs((4*narrow - wide)/3 - d(:, :, p)))/unit
  end function difference_error

  !> The central difference of the shape with respect to parameter p.
  subroutine difference(p, step, derivative)
    integer, intent(in) :: p
    real(rp), intent(in) :: step
    real(rp), intent(out) :: derivative(:, :)
    real(rp) :: behind(3, model%n_all), value
    value = model%params%get(p)
    parameter = model%params%describe(p)
    call solve_with(p, merge(value*exp(step), value + step, parameter%is_log), derivative)
    call solve_with(p, merge(value*exp(-step), value - step, parameter%is_log), behind)
    call set_parameter(model, p, value)
    derivative = (derivative - behind)/(2*step)
  end subroutine difference

  !> The shape, warm from u, with another value of parameter p.
  subroutine solve_with(p, value, shape)
    integer, intent(in) :: p
    real(rp), intent(in) :: value
    real(rp), intent(out) :: shape(:, :)
    call set_parameter(model, p, value)
    shape = u
    call solve_static(work, model, load, .true., options, shape, report)
    if (.not. report%converged .or. report%was_redone_cold) &
      call t%check('a neighbour is on the same path', .false.)
  end subroutine solve_with
end program test_solid_sensitivities

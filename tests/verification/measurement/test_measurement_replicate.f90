! SPDX-License-Identifier: GPL-3.0-or-later
!> A noise-free replicate: the shapes of the wing in the file that the first argument names under three loads are
!> measured on a grid; derivatives of the residuals equal differences, tasks do not depend on their history, and
!> a fit from wrong parameters finds the true ones.
program test_measurement_replicate
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use least_squares_posterior, only: find_posterior, posterior_t
  use least_squares_problem, only: unknowns_t
  use least_squares_profile, only: interval_t, linear_guess_t, profile_interval, profile_sentence, THRESHOLD_90
  use loaded_wing, only: wing_of_argument
  use measurement_data, only: measurement_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use measurement_file, only: read_measurement
  use measurement_problem, only: wing_point_t, wing_problem_t, wing_unknowns
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use whole_measurement, only: write_measurement
  implicit none
  integer, parameter :: N_LOADS = 3, NX = 60, NY = 30
  !> Where the wing is loaded, as fractions of its extent in x and y, and forces [N] that move it there by some 0.05 R.
  real(rp), parameter :: PLACES(2, N_LOADS) = reshape([0.6_rp, 0.8_rp, 0.8_rp, 0.6_rp, 0.35_rp, 0.5_rp], &
                                                      [2, N_LOADS]), &
                         FORCES(N_LOADS) = [6.0e-4_rp, 2.0e-4_rp, 8.0e-4_rp]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_params_t) :: params
  type(static_options_t) :: options
  type(measurement_t) :: m
  type(experiment_t), target :: experiment
  type(evaluation_work_t) :: work
  real(rp), allocatable :: truth(:), shapes(:, :, :)

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  params = default_params(wing)
  params%cross_springs = .true.
  options%tolerance = 1.0e-10_rp
  call measure()
  call check_derivatives()
  call check_tasks()
  call recover()
  call t%finish()

contains

  !> Flat measurements first, into which the computed shapes are then written; the file goes through the reader.
  subroutine measure()
    type(evaluation_t) :: evaluation
    type(failure_t) :: failure
    type(message_list_t) :: messages
    integer, allocatable :: numbers(:)
    integer :: l, i, j, k, nearest(1)
    allocate (m%x(NX), m%y(NY), m%unloaded(NX, NY), m%unloaded_sigma(NX, NY), m%has_unloaded(NX, NY), &
              m%loads(N_LOADS), m%observations(0), m%zeros(0))
    m%x = [(minval(wing%points(1, :)) + (i - 0.37_rp)*1.02_rp*span(1)/NX, i=1, NX)]
    m%y = [(minval(wing%points(2, :)) + (j - 0.41_rp)*1.02_rp*span(2)/NY, j=1, NY)]
    m%unloaded = 1.0e-4_rp
    m%unloaded_sigma = 1.0e-9_rp
    m%has_unloaded = .true.
    m%accuracy%height = 1.0e-9_rp
    do l = 1, N_LOADS
      associate (load => m%loads(l))
        load%name = 'load_'//achar(iachar('0') + l)
        load%force = FORCES(l)
        load%direction = [0.0_rp, 0.0_rp, 1.0_rp]
        nearest = minloc([(norm2(wing%points(:2, k) - [(minval(wing%points(i, :)) + PLACES(i, l)*span(i), i=1, 2)]), &
                           k=1, size(wing%points, 2))])
        load%point = wing%points(:2, nearest(1))
        load%node = reshape([((i, j, i=1, NX), j=1, NY)], [2, NX*NY])
        allocate (load%height(NX*NY), source=0.0_rp)
        allocate (load%sigma(NX*NY), source=1.0e-9_rp)
      end associate
    end do
    numbers = [params%find('E'), params%find('joint:'//trim(params%joint_names(1))), &
               params%find('joint:'//trim(params%joint_names(2)))]
    call experiment%init(m, wing, params, numbers, options, failure)
    call t%check('the experiment is made',.not. failure%failed)
    truth = experiment%start()
    call work%init(experiment)
    allocate (shapes(3, experiment%model%n_all, N_LOADS), source=0.0_rp)
    do l = 1, N_LOADS
      call evaluation%init(experiment, l, .false.)
      call evaluate(experiment, work, truth, l, .false., shapes(:, :, l), evaluation)
      call t%check('the shape is found', evaluation%is_feasible() .and. evaluation%snaps == 0)
      associate (comparison => experiment%comparisons(l), load => m%loads(l))
        do k = 1, comparison%n_heights
          i = comparison%node(1, k)
          j = comparison%node(2, k)
          load%height(i + NX*(j - 1)) = evaluation%residuals(k)
        end do
      end associate
    end do
    call write_measurement('replicate.h5', m, failure)
    call read_measurement('replicate.h5', wing, m, messages)
    call t%check('the measurement is valid', messages%count() == 0 .and. .not. failure%failed)
    call messages%print(6, '')
    call experiment%init(m, wing, params, numbers, options, failure)
    call work%init(experiment)
    do l = 1, N_LOADS
      call evaluation%init(experiment, l, .false.)
      call evaluate(experiment, work, truth, l, .true., shapes(:, :, l), evaluation)
      call t%check_below('the replicate shows what was measured', maxval(abs(evaluation%residuals)), 1.0e-12_rp)
    end do
  end subroutine measure

  pure real(rp) function span(direction)
    integer, intent(in) :: direction
    span = maxval(wing%points(direction, :)) - minval(wing%points(direction, :))
  end function span

  !> The error of a difference is H^2/6 of the third derivative, and the solver's over 2H. (Where a grid point
  !> changes its triangle between the two shapes the residual has a kink; they move sideways by less than 1e-9 m,
  !> and none does.)
  subroutine check_derivatives()
    real(rp), parameter :: H = 1.0e-4_rp
    type(evaluation_t) :: evaluation, ahead, behind
    real(rp), allocatable :: u(:, :), errors(:), at(:)
    real(rp) :: worst
    integer :: l, p
    allocate (at(size(truth)))
    worst = 0
    do l = 1, N_LOADS
      call evaluation%init(experiment, l, .true.)
      call ahead%init(experiment, l, .false.)
      call behind%init(experiment, l, .false.)
      u = shapes(:, :, l)
      call evaluate(experiment, work, truth, l, .true., u, evaluation)
      do p = 1, size(truth)
        at = truth
        at(p) = truth(p) + H
        u = shapes(:, :, l)
        call evaluate(experiment, work, at, l, .true., u, ahead)
        at(p) = truth(p) - H
        u = shapes(:, :, l)
        call evaluate(experiment, work, at, l, .true., u, behind)
        errors = abs((ahead%residuals - behind%residuals)/(2*H) - evaluation%jacobian(:, p))/ &
                 maxval(abs(evaluation%jacobian(:, p)))
        worst = max(worst, maxval(errors))
      end do
    end do
    call t%check_below('derivatives of residuals equal differences', worst, 1.0e-7_rp)
  end subroutine check_derivatives

  !> The same task gives the same bits whatever was done before, and by another process's work space.
  subroutine check_tasks()
    type(evaluation_t) :: first, second
    type(evaluation_work_t) :: other
    real(rp), allocatable :: u(:, :), v(:, :), at(:)
    at = truth + 0.1_rp
    call first%init(experiment, 2, .true.)
    call second%init(experiment, 2, .true.)
    u = shapes(:, :, 2)
    v = shapes(:, :, 2)
    call evaluate(experiment, work, at, 2, .true., u, first)
    call other%init(experiment)
    call evaluate(experiment, other, at, 2, .true., v, second)
    call other%free()
    call t%check('a task gives the same bits in another work space', all(transfer(u, [1]) == transfer(v, [1])) .and. &
                 all(transfer(first%jacobian, [1]) == transfer(second%jacobian, [1])))
  end subroutine check_tasks

  real(rp) function sum_terms(at, which) result(total)
    type(wing_point_t), intent(in) :: at
    integer, intent(in) :: which
    real(rp) :: terms(2)
    integer :: l
    total = 0
    do l = 1, N_LOADS
      terms = at%evaluations(l)%terms(experiment, l)
      total = total + terms(which)
    end do
  end function sum_terms

  !> From E three times too large and joints ten times too stiff and too soft, with priors of one decade about
  !> this start. They shift the optimum by (sd/decade)^2 ln 10, sd being that of an unknown at 1 nm noise.
  subroutine recover()
    type(wing_problem_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    type(posterior_t) :: posterior
    type(interval_t) :: interval
    type(parameter_t) :: parameter
    type(wing_point_t) :: cold
    real(rp), allocatable :: start(:)
    real(rp) :: difference
    integer :: i
    start = truth + log([3.0_rp, 10.0_rp, 0.1_rp])
    call problem%init(experiment)
    unknowns = wing_unknowns(experiment, start, 1.0_rp)
    call fit(problem, unknowns, start, problem%initial_state(), options, report)
    posterior = find_posterior(unknowns, report)
    call t%check('the fit converges: '//report%reason, report%is_converged)
    call t%check('in a few evaluations', report%n_evaluations <= 20)
    select type (at => report%state)
    type is (wing_point_t)
      call t%check_close('h and the sum of squares are sums over loads', sum_terms(at, 1), &
                         experiment%cost(report%residuals*sqrt(2.0_rp)*1.0e-9_rp)**2, rtol=1.0e-6_rp)
      call t%check_close('  the sum of squares', sum_terms(at, 2), report%chi2, rtol=1.0e-6_rp)
    class default
      call t%check('the state of a fit is a point of the wing', .false.)
    end select
    call t%check_below('h vanishes', experiment%cost(report%residuals*sqrt(2.0_rp)*1.0e-9_rp), 1.0e-12_rp)
    do i = 1, size(truth)
      parameter = experiment%describe(i)
      call t%check_below(parameter%name//' is found', abs(report%p(i) - truth(i)), 1.0e-6_rp)
    end do
    call problem%solve_cold(report%p, report%state, cold, difference)
    call t%check_below('cold shapes are the same', difference, 1.0e-9_rp)
    call profile_interval(problem, unknowns, report, 1, linear_guess_t(posterior%sd(1)), THRESHOLD_90, options, interval)
    call t%check('the interval of E has two ends', interval%has_lower .and. interval%has_upper .and. &
                 interval%is_complete)
    call t%check_close('  as wide as the covariance says', interval%upper - interval%lower, &
                       2*sqrt(THRESHOLD_90)*posterior%sd(1), rtol=0.02_rp)
    call t%check('  '//profile_sentence('E', 'Pa', .true., interval), interval%lower < truth(1) .and. &
                 interval%upper > truth(1))
    call problem%free()
  end subroutine recover
end program test_measurement_replicate

! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs one start of the paper's validation: a measurement without noise that the model made, E and ten joints unknown, the start
!> random in the whole box. Generations of CMA-ES find a point where least squares can begin; the least squares are those of
!> msm_train.
module bench_validation
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_kinds, only: i8, rp
  use base_parameter, only: parameter_t
  use bench_replicate, only: N_JOINTS, N_UNKNOWNS, replicate_t
  use cmaes_options, only: cmaes_options_t
  use cmaes_search, only: cmaes_search_t, start_region_t, RESTARTS_IPOP
  use cmaes_stop, only: RUNNING
  use least_squares_continuation, only: fit_by_continuation
  use least_squares_fit, only: fit_options_t, fit_report_t
  use least_squares_posterior, only: find_posterior, posterior_t
  use least_squares_problem, only: unknowns_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use measurement_problem, only: wing_problem_t, wing_unknowns
  implicit none
  private
  public :: validation_truth, validate, predict_sd

  real(rp), parameter, public :: NOISE = 1.0e-9_rp         !< [m] declared, and that of the prediction
  real(rp), parameter, public :: IDENTIFIABLE = 1.0e-3_rp  !< largest sd(ln k) at this noise
  real(rp), parameter, public :: BAR_YOUNG = 1.0e-6_rp, BAR_JOINT = 1.0e-3_rp, BAR_H = 1.0e-8_rp
  integer, parameter, public :: BAR_EVALUATIONS = 3000
  !> Stiffness of the replicate's joints over that of the vein without the joint.
  real(rp), parameter :: SOFTENED(N_JOINTS) = [0.5_rp, 0.2_rp, 0.8_rp, 0.3_rp, 0.6_rp, 0.1_rp, 0.4_rp, 0.7_rp, &
                                               0.25_rp, 0.9_rp]
  integer, parameter :: GENERATIONS = 1 !< of the search before each attempt to polish

contains

  !> Returns the coordinates of the true values.
  pure function validation_truth(replicate) result(truth)
    type(replicate_t), intent(in) :: replicate
    real(rp) :: truth(N_UNKNOWNS)
    truth = replicate%defaults() + [0.0_rp, log(SOFTENED)]
  end function validation_truth

  !> Returns the sd of every unknown at the truth in the linear approximation without priors.
  function predict_sd(experiment, truth) result(sd)
    type(experiment_t), intent(in), target :: experiment
    real(rp), intent(in) :: truth(N_UNKNOWNS)
    real(rp) :: sd(N_UNKNOWNS)
    type(wing_problem_t) :: problem
    type(fit_report_t) :: at
    type(posterior_t) :: posterior
    type(unknowns_t) :: unknowns
    logical :: is_valid
    call problem%init(experiment)
    at%p = truth
    allocate (at%residuals(problem%n_residuals), at%jacobian(problem%n_residuals, N_UNKNOWNS))
    call problem%evaluate(truth, problem%initial_state(), at%residuals, at%jacobian, is_valid, at%state)
    call unknowns%init(N_UNKNOWNS)
    posterior = find_posterior(unknowns, at)
    sd = posterior%sd
    call problem%free()
  end function predict_sd

  !> Searches from the random start that `seed` gives, runs the least squares, and prints the results of `report_joints`. `is_met`
  !> tells whether all requirements are met.
  subroutine validate(replicate, experiment, truth, sd, seed, is_met)
    type(replicate_t), intent(in) :: replicate
    type(experiment_t), intent(in), target :: experiment
    real(rp), intent(in) :: truth(N_UNKNOWNS), sd(N_UNKNOWNS)
    integer, intent(in) :: seed
    logical, intent(out) :: is_met
    type(cmaes_search_t) :: search
    type(wing_problem_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_report_t) :: report
    type(experiment_t) :: rough
    type(evaluation_work_t) :: work
    type(start_region_t) :: region
    type(cmaes_options_t) :: options
    real(rp), allocatable :: x(:, :)
    real(rp) :: best(N_UNKNOWNS), f, h, cpu, cpu_end, seconds(2)
    integer(i8) :: begun, ended, rate, ignored
    integer :: n_evaluations, attempt
    logical :: has_best

    call cpu_time(cpu)
    call system_clock(begun, rate)
    rough = experiment
    rough%options%tolerance = 1.0e-4_rp
    rough%options%factorisation_limit = 60
    call work%init(rough)
    call problem%init(experiment)
    unknowns = wing_unknowns(experiment, replicate%defaults(), 1.0_rp)
    unknowns%prior = (unknowns%lower + unknowns%upper)/2
    allocate (region%lower(N_UNKNOWNS), source=0.0_rp)
    allocate (region%upper(N_UNKNOWNS), source=1.0_rp)
    region%is_box = .true.
    options%seed = seed
    options%max_evaluations = BAR_EVALUATIONS
    call search%start(options, RESTARTS_IPOP, 9, region)
    n_evaluations = 0
    h = huge(h)
    report%p = unknowns%prior
    do attempt = 1, BAR_EVALUATIONS
      call search_on(search, rough, work, unknowns, x, n_evaluations)
      call search%best(has_best, f, best, ignored)
      if (has_best) then
        write (output_unit, '(a,i0,a,i0,a,es9.2,a)') 'seed ', seed, ': ', n_evaluations, &
          ' evaluations, search h ', f, ' m'
        flush (output_unit)
        best = unknowns%lower + best*(unknowns%upper - unknowns%lower)
        call polish(problem, unknowns, best, n_evaluations, report, h)
      end if
      if (h <= BAR_H .or. n_evaluations >= BAR_EVALUATIONS .or. search%state%stop_code /= RUNNING) exit
    end do
    call cpu_time(cpu_end)
    call system_clock(ended)
    seconds = [cpu_end - cpu, real(ended - begun, rp)/real(rate, rp)]
    call report_joints(experiment, report, truth, sd, n_evaluations, h, seconds, is_met)
    call work%free()
    call problem%free()
  end subroutine validate

  !> Prints the parameters and, as the last line, the JSON record. `is_met` tells whether all requirements are met.
  subroutine report_joints(experiment, report, truth, sd, n_evaluations, h, seconds, is_met)
    type(experiment_t), intent(in) :: experiment
    type(fit_report_t), intent(in) :: report
    real(rp), intent(in) :: truth(N_UNKNOWNS), sd(N_UNKNOWNS)
    integer, intent(in) :: n_evaluations
    real(rp), intent(in) :: h          !< [m] of the best fit
    real(rp), intent(in) :: seconds(2) !< of processors, and of a clock on the wall
    logical, intent(out) :: is_met
    type(parameter_t) :: parameter
    real(rp) :: errors(N_UNKNOWNS), worst
    integer :: i
    errors = abs(exp(report%p - truth) - 1)
    worst = maxval(errors(2:), mask=sd(2:) <= IDENTIFIABLE)
    write (output_unit, '(a)') '  parameter                      truth        found  rel. error  predicted sd'
    do i = 1, N_UNKNOWNS
      parameter = experiment%describe(i)
      write (output_unit, '(2x,a24,2es13.5,es12.2,es14.2,a)') parameter%name, exp(truth(i)), exp(report%p(i)), &
        errors(i), sd(i), trim(merge('  not identifiable', '                  ', sd(i) > IDENTIFIABLE))
    end do
    is_met = errors(1) <= BAR_YOUNG .and. worst <= BAR_JOINT .and. h <= BAR_H .and. &
             n_evaluations <= BAR_EVALUATIONS
    write (output_unit, '(a,i0,4(a,es10.3),a,f0.1,a)') '{"evaluations":', n_evaluations, ',"E_rel":', errors(1), &
      ',"joints_rel_max_identifiable":', worst, ',"h":', h, ',"cpu_s":', seconds(1), ',"wall_s":', &
      seconds(2), '}'
    flush (output_unit)
  end subroutine report_joints

  !> Runs some generations. Every candidate is counted, also those that are given up at their first unsolved load.
  subroutine search_on(search, experiment, work, unknowns, x, n_evaluations)
    type(cmaes_search_t), intent(inout) :: search
    type(experiment_t), intent(in) :: experiment
    type(evaluation_work_t), intent(inout) :: work
    type(unknowns_t), intent(in) :: unknowns
    real(rp), allocatable, intent(inout) :: x(:, :)
    integer, intent(inout) :: n_evaluations
    real(rp), allocatable :: f(:), violation(:)
    logical, allocatable :: has_failed(:)
    integer :: g, k, n
    do g = 1, GENERATIONS
      call search%ask(x)
      n = size(x, 2)
      allocate (f(n), violation(n), has_failed(n))
      do k = 1, n
        call judge(experiment, work, unknowns%lower + x(:, k)*(unknowns%upper - unknowns%lower), f(k), violation(k), &
                   has_failed(k))
      end do
      n_evaluations = n_evaluations + n
      call search%tell(f, violation, has_failed)
      deallocate (f, violation, has_failed)
      if (search%state%stop_code /= RUNNING) return
    end do
  end subroutine search_on

  !> Computes h [m] of a candidate; the shape of every load is computed from the unloaded wing.
  subroutine judge(experiment, work, coordinates, h, violation, has_failed)
    type(experiment_t), intent(in) :: experiment
    type(evaluation_work_t), intent(inout) :: work
    real(rp), intent(in) :: coordinates(:)
    real(rp), intent(out) :: h, violation
    logical, intent(out) :: has_failed
    type(evaluation_t) :: evaluation
    real(rp) :: u(3, experiment%model%n_all), terms(2)
    integer :: l
    h = 0
    violation = 0
    has_failed = .false.
    do l = 1, size(experiment%loads)
      call evaluation%init(experiment, l, .false.)
      u = 0
      call evaluate(experiment, work, coordinates, l, .false., u, evaluation)
      has_failed = .not. evaluation%is_solved
      if (has_failed) return
      violation = violation + sum(evaluation%violation)
      terms = evaluation%terms(experiment, l)
      h = h + terms(1)
    end do
    h = sqrt(h)
  end subroutine judge

  !> Runs the least squares of msm_train from `start`; returns h [m] of the point where it ends, or a huge number if the model
  !> cannot be computed at the start.
  subroutine polish(problem, unknowns, start, n_evaluations, report, h)
    type(wing_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    real(rp), intent(in) :: start(:)
    integer, intent(inout) :: n_evaluations
    type(fit_report_t), intent(out) :: report
    real(rp), intent(out) :: h
    real(rp), allocatable :: path(:, :)
    call fit_by_continuation(problem, unknowns, start, problem%initial_state(), fit_options_t(), .true., report, path)
    n_evaluations = n_evaluations + report%n_evaluations
    h = huge(h)
    if (size(path) == 0) return
    h = problem%experiment%cost(report%residuals*NOISE)
    write (output_unit, '(a,i0,a,es8.1,a,es9.2,a)') '  polish: ', report%n_evaluations, &
      ' evaluations, errors at first', path(4, 1), ' times as declared, h ', h, ' m; '//report%reason
    flush (output_unit)
  end subroutine polish
end module bench_validation

! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures the cost of the paper's full budget: a hundred generations of 64 candidates under ten loads, or the first ones of
!> them. The shapes of candidates are computed from those of the optimiser's mean, as in msm_train.
module bench_budget
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_kinds, only: i8, rp
  use base_parameter, only: parameter_t
  use bench_replicate, only: N_UNKNOWNS, replicate_t
  use bench_validation, only: NOISE, validation_truth
  use cmaes_options, only: cmaes_options_t, CONSTANTS_PAPER, CONSTANTS_TUTORIAL, WEIGHTS_ACTIVE, WEIGHTS_PAPER
  use cmaes_search, only: cmaes_search_t, start_region_t, RESTARTS_NONE
  use cmaes_stop, only: RUNNING
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  implicit none
  private
  public :: measure_budget

  integer, parameter :: POPULATION = 64, FULL = 100 !< candidates of a generation, generations of the paper
  real(rp), parameter :: PAPER_JOINT(2) = [1.0e-6_rp, 1.0e-2_rp] !< [N m/rad] bounds
  !> Redone are shapes that were computed from those of the mean and are then repeated from the wing at rest. Infeasible and
  !> unsolved candidates are counted nowhere else. The mean is no candidate.
  integer, parameter :: WARM = 1, REDONE = 2, COLD = 3, INFEASIBLE = 4, UNSOLVED = 5, MEAN = 6, N_KINDS = 6
  character(*), parameter :: KINDS(N_KINDS) = &
                             [character(10) :: 'warm', 'redone', 'cold', 'infeasible', 'unsolved', 'mean']

  !> The box of the search; its sides are those of the coordinates or of the values.
  type :: sides_t
    logical :: is_log = .true.
    real(rp) :: lower(N_UNKNOWNS) = 0, upper(N_UNKNOWNS) = 0 !< values
  contains
    procedure :: coordinates => sides_coordinates
  end type sides_t

contains

  !> Returns the coordinates (logarithms) of a point of [0, 1]^n.
  pure function sides_coordinates(self, x) result(coordinates)
    class(sides_t), intent(in) :: self
    real(rp), intent(in) :: x(:)
    real(rp) :: coordinates(size(x))
    if (self%is_log) then
      coordinates = log(self%lower) + x*log(self%upper/self%lower)
    else
      coordinates = log(self%lower + x*(self%upper - self%lower))
    end if
  end function sides_coordinates

  !> Runs the box `name`, log or linear; after every generation it prints a JSON record of what is done so far.
  subroutine measure_budget(replicate, n_generations, name)
    type(replicate_t), intent(in) :: replicate
    integer, intent(in) :: n_generations
    character(*), intent(in) :: name
    type(experiment_t) :: experiment
    type(parameter_t) :: parameter
    type(sides_t) :: sides
    logical :: is_done
    integer :: i
    call replicate%measure(validation_truth(replicate), NOISE, experiment, is_done)
    experiment%options%tolerance = 1.0e-8_rp
    experiment%options%factorisation_limit = 300
    parameter = experiment%describe(1)
    sides%lower = [parameter%lower, (PAPER_JOINT(1), i=2, N_UNKNOWNS)]
    sides%upper = [parameter%upper, (PAPER_JOINT(2), i=2, N_UNKNOWNS)]
    sides%is_log = name == 'log'
    call run_box(experiment, sides, name, n_generations)
  end subroutine measure_budget

  !> The weights include negative ones (active CMA-ES) in log space, and are those of the paper in its linear box.
  subroutine run_box(experiment, sides, name, n_generations)
    type(experiment_t), intent(in) :: experiment
    type(sides_t), intent(in) :: sides
    character(*), intent(in) :: name
    integer, intent(in) :: n_generations
    type(cmaes_search_t) :: search
    type(cmaes_options_t) :: options
    type(start_region_t) :: region
    type(evaluation_work_t) :: work
    real(rp), allocatable :: x(:, :), shapes(:, :, :)
    logical, allocatable :: is_start(:), has_failed(:)
    real(rp) :: f(POPULATION), violation(POPULATION), seconds(N_KINDS), costs(2)
    integer :: counts(N_KINDS), g, k, n_loads
    n_loads = size(experiment%loads)
    allocate (shapes(3, experiment%model%n_all, n_loads), source=0.0_rp)
    allocate (is_start(n_loads), source=.false.)
    allocate (has_failed(POPULATION), source=.false.)
    allocate (region%lower(N_UNKNOWNS), source=0.0_rp)
    allocate (region%upper(N_UNKNOWNS), source=1.0_rp)
    region%is_box = .true.
    options%lambda = POPULATION
    options%weights = merge(WEIGHTS_ACTIVE, WEIGHTS_PAPER, sides%is_log)
    options%constants = merge(CONSTANTS_TUTORIAL, CONSTANTS_PAPER, sides%is_log)
    options%max_evaluations = int(FULL, i8)*POPULATION
    call search%start(options, RESTARTS_NONE, 0, region)
    call work%init(experiment)
    counts = 0
    seconds = 0
    do g = 1, n_generations
      call search%ask(x)
      call solve(experiment, work, sides%coordinates(max(0.0_rp, min(1.0_rp, search%run%state%mean))), .true., shapes, &
                 is_start, costs, has_failed(1), counts, seconds)
      do k = 1, POPULATION
        call solve(experiment, work, sides%coordinates(x(:, k)), .false., shapes, is_start, costs, has_failed(k), &
                   counts, seconds)
        f(k) = sqrt(costs(1))
        violation(k) = costs(2)
      end do
      call search%tell(f, violation, has_failed)
      call report(name, g, n_loads, search%run%state%best%f, search%run%state%sigma, counts, seconds)
      if (search%state%stop_code /= RUNNING) exit
    end do
    call work%free()
  end subroutine run_box

  !> Computes all loads of one candidate, or of the mean, whose shapes become the starts. costs: h^2 [m^2] and the violation.
  subroutine solve(experiment, work, coordinates, is_mean, shapes, is_start, costs, has_failed, counts, seconds)
    type(experiment_t), intent(in) :: experiment
    type(evaluation_work_t), intent(inout) :: work
    real(rp), intent(in) :: coordinates(:)
    logical, intent(in) :: is_mean
    real(rp), intent(inout) :: shapes(:, :, :), seconds(:)
    logical, intent(inout) :: is_start(:)
    real(rp), intent(out) :: costs(2)
    logical, intent(out) :: has_failed
    integer, intent(inout) :: counts(:)
    type(evaluation_t) :: evaluation
    real(rp) :: u(size(shapes, 1), size(shapes, 2)), begun, ended, terms(2)
    integer :: l, kind_of
    costs = 0
    has_failed = .false.
    do l = 1, size(is_start)
      call evaluation%init(experiment, l, .false.)
      u = shapes(:, :, l)
      call cpu_time(begun)
      call evaluate(experiment, work, coordinates, l, is_start(l), u, evaluation)
      call cpu_time(ended)
      kind_of = COLD
      if (is_start(l)) kind_of = merge(REDONE, WARM, evaluation%was_redone_cold)
      if (.not. evaluation%is_feasible()) kind_of = INFEASIBLE
      if (.not. evaluation%is_solved) kind_of = UNSOLVED
      if (is_mean) kind_of = MEAN
      counts(kind_of) = counts(kind_of) + 1
      seconds(kind_of) = seconds(kind_of) + ended - begun
      has_failed = has_failed .or. .not. evaluation%is_solved
      terms = evaluation%terms(experiment, l)
      costs = costs + [terms(1), sum(evaluation%violation)]
      if (.not. is_mean) cycle
      is_start(l) = evaluation%is_start
      if (is_start(l)) shapes(:, :, l) = u
    end do
  end subroutine solve

  subroutine report(name, generation, n_loads, best, sigma, counts, seconds)
    character(*), intent(in) :: name
    integer, intent(in) :: generation, n_loads, counts(:)
    real(rp), intent(in) :: best, sigma, seconds(:)
    integer :: i
    write (output_unit, '(3a,i0,a,i0,2(a,es9.2))', advance='no') '{"box":"', name, '","generations":', generation, &
      ',"solves":', sum(counts(:UNSOLVED)), ',"best_h":', best, ',"sigma":', sigma
    do i = 1, N_KINDS
      write (output_unit, '(3a,i0,3a,f9.1)', advance='no') ',"', trim(KINDS(i)), '":', counts(i), &
        ',"', trim(KINDS(i)), '_ms":', 1000*seconds(i)/max(1, counts(i))
    end do
    write (output_unit, '(a,f9.1,3a,f9.3,a)') ',"cpu_s":', sum(seconds), ',"', &
      trim(merge('full_budget_cpu_h_extrapolated', 'full_budget_cpu_h             ', generation < FULL)), '":', &
      sum(seconds)/sum(counts(:UNSOLVED))*FULL*POPULATION*n_loads/3600, '}'
    flush (output_unit)
  end subroutine report
end module bench_budget

! SPDX-License-Identifier: GPL-3.0-or-later
!> What the paper's full budget costs: generations of 64 candidates under ten loads, of which the first ones
!> are done and the rest extrapolated. Candidates start warm from the solution of the optimiser's mean, as in msm_train.
module bench_budget
  use base_kinds, only: i8, rp
  use bench_twin, only: N_UNKNOWNS, twin_t
  use bench_validation, only: NOISE, validation_truth
  use cmaes_options, only: cmaes_options_t
  use cmaes_search, only: cmaes_search_t, start_region_t
  use cmaes_stop, only: RUNNING
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use solid_params, only: parameter_t
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  private
  public :: measure_budget

  integer, parameter :: POPULATION = 64, FULL = 100 !< candidates of a generation, generations of the paper
  real(rp), parameter :: PAPER_JOINT(2) = [1.0e-6_rp, 1.0e-2_rp] !< [N m/rad] bounds
  integer, parameter :: WARM = 1, COLD = 2, INFEASIBLE = 3, UNSOLVED = 4, MEAN = 5
  character(*), parameter :: KINDS(5) = [character(10) :: 'warm', 'cold', 'infeasible', 'unsolved', 'mean']

  !> The box, with sides of the coordinates or of the values.
  type :: sides_t
    logical :: is_log = .true.
    real(rp) :: lower(N_UNKNOWNS) = 0, upper(N_UNKNOWNS) = 0 !< values
  contains
    procedure :: coordinates => sides_coordinates
  end type sides_t

contains

  !> Coordinates (logarithms) of a point of [0, 1]^n.
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

  !> Both boxes; each ends with a JSON record.
  subroutine measure_budget(twin, n_generations)
    type(twin_t), intent(in) :: twin
    integer, intent(in) :: n_generations
    type(experiment_t) :: experiment
    type(parameter_t) :: parameter
    type(sides_t) :: sides
    logical :: is_done
    integer :: i
    call twin%measure(validation_truth(twin), NOISE, experiment, is_done)
    experiment%options%tolerance = 1.0e-8_rp
    experiment%options%factorisation_limit = 300
    parameter = experiment%describe(1)
    sides%lower = [parameter%lower, (PAPER_JOINT(1), i=2, N_UNKNOWNS)]
    sides%upper = [parameter%upper, (PAPER_JOINT(2), i=2, N_UNKNOWNS)]
    call run_box(experiment, sides, 'log', 'active', n_generations)
    sides%is_log = .false.
    call run_box(experiment, sides, 'linear', 'paper', n_generations)
  end subroutine measure_budget

  subroutine run_box(experiment, sides, name, weights, n_generations)
    type(experiment_t), intent(in) :: experiment
    type(sides_t), intent(in) :: sides
    character(*), intent(in) :: name, weights
    integer, intent(in) :: n_generations
    type(cmaes_search_t) :: search
    type(cmaes_options_t) :: options
    type(start_region_t) :: region
    type(evaluation_work_t) :: work
    real(rp), allocatable :: x(:, :), shapes(:, :, :)
    logical, allocatable :: is_start(:), has_failed(:)
    real(rp) :: f(POPULATION), violation(POPULATION), seconds(5), before(5), ignored(2)
    integer :: counts(5), g, k, n_loads
    n_loads = size(experiment%loads)
    allocate (shapes(3, experiment%model%n_all, n_loads), source=0.0_rp)
    allocate (is_start(n_loads), source=.false.)
    allocate (has_failed(POPULATION), source=.false.)
    allocate (region%lower(N_UNKNOWNS), source=0.0_rp)
    allocate (region%upper(N_UNKNOWNS), source=1.0_rp)
    region%is_box = .true.
    options%lambda = POPULATION
    options%weights = weights
    options%max_evaluations = int(FULL, i8)*POPULATION
    call search%start(options, 'none', 0, region)
    call work%init(experiment)
    counts = 0
    seconds = 0
    do g = 1, n_generations
      before = seconds
      call search%ask(x)
      call solve(experiment, work, sides%coordinates(max(0.0_rp, min(1.0_rp, search%run%state%mean))), .true., shapes, &
                 is_start, ignored, has_failed(1), counts, seconds)
      do k = 1, POPULATION
        call solve(experiment, work, sides%coordinates(x(:, k)), .false., shapes, is_start, ignored, has_failed(k), &
                   counts, seconds)
        f(k) = sqrt(ignored(1))
        violation(k) = ignored(2)
      end do
      call search%tell(f, violation, has_failed)
      write (output_unit, '(3a,i4,a,es9.2,a,f8.2,a)') name, ' box, generation ', '', g, ': best h ', &
        search%run%state%best_f, ' m, ', sum(seconds - before), ' CPU s'
      flush (output_unit)
      if (search%state%stop_code /= RUNNING) exit
    end do
    call work%free()
    call report(name, min(g, n_generations), n_loads, counts, seconds)
  end subroutine run_box

  !> All loads of one candidate, or of the mean, whose shapes become the starts. costs: h^2 [m^2] and the violation.
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
      if (is_start(l) .and. .not. evaluation%was_redone_cold) kind_of = WARM
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

  subroutine report(name, n_generations, n_loads, counts, seconds)
    character(*), intent(in) :: name
    integer, intent(in) :: n_generations, n_loads, counts(:)
    real(rp), intent(in) :: seconds(:)
    integer :: i
    write (output_unit, '(a)') '  kind         solves   CPU s   ms each'
    do i = 1, size(KINDS)
      write (output_unit, '(2x,a10,i9,f9.2,f9.2)') KINDS(i), counts(i), seconds(i), 1000*seconds(i)/max(1, counts(i))
    end do
    write (output_unit, '(3a,i0,a,i0,4(a,i0),a,f0.2,3a,f0.3,a)') '{"box":"', name, '","generations":', n_generations, &
      ',"solves":', sum(counts(:UNSOLVED)), ',"warm":', counts(WARM), ',"cold":', counts(COLD), ',"infeasible":', &
      counts(INFEASIBLE), ',"unsolved":', counts(UNSOLVED), ',"cpu_s":', sum(seconds), ',"', &
      trim(merge('full_budget_cpu_h_extrapolated', 'full_budget_cpu_h             ', n_generations < FULL)), '":', &
      sum(seconds)/sum(counts(:UNSOLVED))*FULL*POPULATION*n_loads/3600, '}'
    flush (output_unit)
  end subroutine report
end module bench_budget

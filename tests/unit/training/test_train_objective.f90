! SPDX-License-Identifier: GPL-3.0-or-later
!> Costs of candidates for a training of the wing in the file that the first argument names: the same to the bit on any
!> number of ranks, failed tasks are failed candidates, and a search in which every fifth candidate fails finds the truth, as do
!> least squares in which every fifth point fails. A batch ends when the time is over, and checkpoints know their readings.
program test_train_objective
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: i8, rp
  use base_random, only: random_uniforms
  use cmaes_options, only: cmaes_options_t
  use cmaes_search, only: cmaes_search_t, start_region_t, RESTARTS_NONE
  use cmaes_stop, only: RUNNING
  use failing_runner, only: counting_problem_t, failing_runner_t, is_to_fail
  use io_stop, only: job_limits_t
  use least_squares_continuation, only: fit_by_continuation
  use least_squares_fit, only: fit_options_t, fit_report_t
  use least_squares_problem, only: unknowns_t
  use measurement_bending_pool, only: bending_pool_t
  use measurement_bending_runner, only: bending_runner_t
  use measurement_bending_state, only: bending_state_t
  use measurement_bending_task, only: bending_task_t, task_input, TASK_COSTS
  use measurement_data, only: measurement_t, NOT_STATED, QUANTITY_DISPLACEMENT, QUANTITY_ROTATION
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use measurement_observed_wing, only: observed_wing_t
  use measurement_problem, only: wing_unknowns
  use parallel_world, only: world_t
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use testkit, only: testkit_t
  use training_case, only: training_case_t
  use training_fingerprint, only: fingerprint_of
  use training_history, only: train_history_t
  use training_objective, only: candidate_costs_t, train_objective_t
  implicit none
  integer, parameter :: N_LOADS = 2, NX = 24, NY = 12, LAMBDA = 9
  integer, parameter :: ONE_OF = 10 ! failing tasks: with two loads every fifth candidate
  integer, parameter :: SEARCHERS = 3 ! ranks that search; others would find the same
  real(rp), parameter :: PLACES(2, N_LOADS) = reshape([0.00721_rp, -0.00032_rp, 0.00496_rp, -0.00111_rp], [2, N_LOADS])
  real(rp), parameter :: FORCES(N_LOADS) = [2.0e-4_rp, 4.0e-4_rp]
  real(rp), parameter :: HALF(2) = log([2.5_rp, 2.5_rp]) ! of the box, E and the vein
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(experiment_t), target :: experiment
  type(bending_pool_t), target :: pool, alone
  type(world_t) :: world_alone
  type(job_limits_t) :: limits
  real(rp), allocatable :: truth(:)
  ! What rank 0 found while the others served.
  logical :: is_same = .true., is_right = .true., is_warm = .true., is_fifth = .true.
  real(rp) :: error = 0, polish_error = 0
  logical :: has_ended = .true., is_fifth_point = .true., ends_in_time = .false.

  call t%start(parallel=.true.)
  call test_starts()
  call make_experiment()
  call test_marks()
  limits%stop_seconds = 1.0e6_rp
  call make_pool(t%world, ONE_OF, limits, pool)
  if (t%world%is_root) then
    call world_alone%isolate()
    call make_pool(world_alone, ONE_OF, limits, alone)
    call test_costs()
    call test_clock()
    if (t%world%size == SEARCHERS) then
      call test_search()
      call test_polish()
    end if
    call pool%shut_down()
  else
    call pool%serve()
  end if
  call t%check('all ranks compute what one computes, to the bit', is_same)
  call t%check('candidates fail whose tasks fail', is_right)
  call t%check('solutions are warm, or cold where the mean failed', is_warm)
  call t%check('a batch begun in time ends when the time is over', ends_in_time .or. .not. t%world%is_root)
  if (t%world%size == SEARCHERS) then
    call t%check('in the search every fifth candidate failed', is_fifth)
    call t%check_below('it finds the truth all the same', error, 3.0e-2_rp)
    call t%check('in least squares every fifth point failed', is_fifth_point)
    call t%check('they end all the same', has_ended)
    ! Shapes are solved to 1e-10 of the load; the truth is the minimum of chi^2 and of the priors.
    call t%check_below('at the truth', polish_error, 1.0e-7_rp)
  end if
  call t%finish()

contains

  !> Ranks that fail one of so many tasks; 0: none.
  subroutine make_pool(world, one_of, limits, pool)
    type(world_t), intent(in) :: world
    integer, intent(in) :: one_of
    type(job_limits_t), intent(in) :: limits
    type(bending_pool_t), intent(inout) :: pool
    class(observed_wing_t), allocatable :: wing
    type(failing_runner_t), allocatable :: failing
    class(bending_runner_t), allocatable :: runner
    allocate (wing, failing)
    call wing%take_experiment(experiment)
    failing%one_of = one_of
    call failing%init(wing)
    call move_alloc(failing, runner)
    call pool%init(world, runner, limits)
  end subroutine make_pool

  !> Starts of polishes: feasible candidates by their cost, none beside a better one.
  subroutine test_starts()
    type(train_history_t) :: history
    type(candidate_costs_t) :: costs
    real(rp), allocatable :: starts(:, :)
    costs%f = [3.0_rp, 1.0_rp, 2.0_rp, 0.5_rp, 0.1_rp]
    costs%violation = [0.0_rp, 0.0_rp, 0.0_rp, 0.2_rp, 0.0_rp]
    costs%has_failed = [.false., .false., .false., .false., .true.]
    call history%init(1)
    call history%add_candidates([1_i8, 0_i8, 1_i8, 5_i8, 5_i8], costs, &
                                reshape([8.0_rp, 4.0_rp, 3.9_rp, 20.0_rp, 30.0_rp], [1, 5]))
    call history%best_candidates(3, 0.1_rp, starts)
    call t%check('starts are the best feasible candidates that differ', size(starts, 2) == 2)
    if (size(starts, 2) == 2) call t%check('the best is the first', all(abs(starts(1, :) - [4.0_rp, 8.0_rp]) <= 0))
  end subroutine test_starts

  !> A measurement of the model itself.
  subroutine make_experiment()
    type(measurement_t) :: m
    type(message_list_t) :: messages
    type(solid_params_t) :: params
    type(static_options_t) :: options
    type(evaluation_work_t) :: work
    type(evaluation_t) :: evaluation
    type(failure_t) :: failure
    real(rp), allocatable :: u(:, :)
    character(:), allocatable :: path
    integer, allocatable :: numbers(:)
    integer :: length, i, j, k, l
    call get_command_argument(1, length=length)
    allocate (character(length) :: path)
    call get_command_argument(1, path)
    call read_wing(path, wing, messages)
    params = default_params(wing)
    options%tolerance = 1.0e-10_rp
    allocate (m%x(NX), m%y(NY), m%unloaded(NX, NY), m%unloaded_sigma(NX, NY), m%has_unloaded(NX, NY), &
              m%loads(N_LOADS), m%observations(0), m%zeros(0))
    m%x = [(0.4e-3_rp*i, i=1, NX)]
    m%y = [(-3.0e-3_rp + 0.35e-3_rp*j, j=1, NY)]
    m%unloaded = 0
    m%unloaded_sigma = 1.0e-6_rp
    m%has_unloaded = .true.
    do l = 1, N_LOADS
      associate (load => m%loads(l))
        load%name = 'load_'//achar(iachar('0') + l)
        load%force = FORCES(l)
        load%direction = [0.0_rp, 0.0_rp, 1.0_rp]
        load%point = PLACES(:, l)
        load%node = reshape([((i, j, i=1, NX), j=1, NY)], [2, NX*NY])
        allocate (load%height(NX*NY), load%sigma(NX*NY))
        load%height = 0
        load%sigma = 1.0e-6_rp
      end associate
    end do
    numbers = [params%find('E'), params%find('E:R1')]
    call experiment%init(m, wing, params, numbers, options, failure)
    call t%check('the experiment is made',.not. failure%failed .and. messages%count() == 0)
    truth = experiment%start()
    call work%init(experiment)
    allocate (u(3, experiment%model%n_all))
    do l = 1, N_LOADS
      call evaluation%init(experiment, l, .false.)
      call evaluate(experiment, work, truth, l, .false., u, evaluation)
      call t%check('the truth is feasible', evaluation%is_feasible())
      do k = 1, experiment%comparisons(l)%n_heights
        associate (node => experiment%comparisons(l)%node(:, k))
          m%loads(l)%height(node(1) + NX*(node(2) - 1)) = evaluation%residuals(k)
        end associate
      end do
    end do
    call work%free()
    call experiment%init(m, wing, params, numbers, options, failure)
  end subroutine make_experiment

  !> u in [0, 1] is the box about the truth.
  pure function coordinates(u)
    real(rp), intent(in) :: u(:)
    real(rp) :: coordinates(size(u))
    coordinates = truth + HALF*(2*u - 1) + 0.2_rp ! the truth is not its middle
  end function coordinates

  !> Two generations, the second warm from another mean, by all ranks and by one.
  subroutine test_costs()
    type(train_objective_t) :: together, single
    type(bending_state_t) :: warm, warm_single, next, next_single
    type(candidate_costs_t) :: costs, costs_single
    real(rp) :: x(2, LAMBDA)
    integer :: k, l, pass
    logical :: has_failure
    call together%init(experiment, pool, .false.)
    call single%init(experiment, alone, .false.)
    warm = together%rest()
    warm_single = single%rest()
    do pass = 1, 2
      do k = 1, LAMBDA
        x(:, k) = coordinates(random_uniforms(5_i8, int(pass, i8), int(k, i8)))
      end do
      call together%solve_mean(coordinates([0.3_rp*pass, 0.5_rp]), warm, next)
      call together%evaluate(x, next, costs)
      call single%solve_mean(coordinates([0.3_rp*pass, 0.5_rp]), warm_single, next_single)
      call single%evaluate(x, next_single, costs_single)
      warm = next
      warm_single = next_single
      is_same = is_same .and. all(abs(costs%f - costs_single%f) <= 0) .and. &
                all(costs%has_failed .eqv. costs_single%has_failed) .and. &
                all(abs(costs%violation - costs_single%violation) <= 0)
      do k = 1, LAMBDA
        has_failure = .false.
        do l = 1, N_LOADS
          has_failure = has_failure .or. is_to_fail(task_input(bending_task_t(TASK_COSTS, l, next_single%is_start(l)), x(:, k), &
                                                              [integer ::]), ONE_OF)
        end do
        is_right = is_right .and. (has_failure .eqv. costs%has_failed(k))
      end do
    end do
    is_warm = together%counts%n_warm + together%counts%n_cold == 2*LAMBDA*N_LOADS .and. together%counts%n_warm > 0
  end subroutine test_costs

  !> Nobody looks between batches here; tasks take milliseconds, and the first one is over after the wall time.
  subroutine test_clock()
    type(train_objective_t) :: objective
    type(candidate_costs_t) :: costs
    type(bending_pool_t), target :: late
    type(job_limits_t) :: soon
    soon%stop_seconds = 1.0e-6_rp
    call make_pool(world_alone, 0, soon, late)
    call objective%init(experiment, late, .false.)
    call objective%evaluate(reshape([truth, truth], [2, 2]), objective%rest(), costs)
    ends_in_time = late%is_stopped .and. late%n_tasks < 2*N_LOADS
    call late%free()
  end subroutine test_clock

  !> A checkpoint belongs to one geometry of the scalar readings.
  subroutine test_marks()
    type(training_case_t) :: settings
    integer(i8) :: fingerprint
    settings%experiment = experiment
    settings%restarts = RESTARTS_NONE
    settings%free_parameters%numbers = [1]
    settings%free_parameters%lower = [1.0_rp]
    settings%free_parameters%upper = [2.0_rp]
    settings%free_parameters%is_log = [.true.]
    settings%free_parameters%instrument_numbers = [integer ::]
    deallocate (settings%experiment%measurement%observations)
    allocate (settings%experiment%measurement%observations(1))
    associate (one => settings%experiment%measurement%observations(1))
      one%load = 1
      one%point = [1.0e-3_rp, 2.0e-3_rp]
      one%axis = [0.0_rp, 0.0_rp, 1.0_rp]
      fingerprint = fingerprint_of(settings)
      call t%check('the mark is that of the input', fingerprint == fingerprint_of(settings))
      one%point(2) = 2.1e-3_rp
      call t%check('a reading at another point is another measurement', fingerprint /= fingerprint_of(settings))
      one%point(2) = 2.0e-3_rp
      one%axis = [0.0_rp, 1.0_rp, 0.0_rp]
      call t%check('as is one along another axis', fingerprint /= fingerprint_of(settings))
      one%axis = [0.0_rp, 0.0_rp, 1.0_rp]
      one%quantity = QUANTITY_ROTATION
      call t%check('of another quantity', fingerprint /= fingerprint_of(settings))
      one%quantity = QUANTITY_DISPLACEMENT
      one%load = 2
      call t%check('under another load', fingerprint /= fingerprint_of(settings))
      one%load = 1
      one%zero = 1
      call t%check('or with an offset', fingerprint /= fingerprint_of(settings))
      one%zero = 0
      call t%check('back at the first it is the same', fingerprint == fingerprint_of(settings))
    end associate
    call test_load_marks(settings)
  end subroutine test_marks

  !> Drift and creep depend on when a load acts, and for how long.
  subroutine test_load_marks(settings)
    type(training_case_t), intent(inout) :: settings
    integer(i8) :: fingerprint
    fingerprint = fingerprint_of(settings)
    associate (load => settings%experiment%measurement%loads(1))
      load%order = load%order + 1
      call t%check('a load in another order is another measurement', fingerprint /= fingerprint_of(settings))
      load%order = load%order - 1
      load%hold = 30
      call t%check('as is one that was held', fingerprint /= fingerprint_of(settings))
      load%hold = NOT_STATED
      load%time = 60
      call t%check('or one at another time', fingerprint /= fingerprint_of(settings))
      load%time = NOT_STATED
      call t%check('without these it is the same again', fingerprint == fingerprint_of(settings))
    end associate
  end subroutine test_load_marks

  !> The box is 0.92 wide to both sides; 30 generations make it 30 times smaller.
  subroutine test_search()
    type(train_objective_t) :: objective
    type(candidate_costs_t) :: costs
    type(bending_state_t) :: mean_state, next
    type(cmaes_search_t) :: search
    type(start_region_t) :: region
    type(cmaes_options_t) :: options
    real(rp), allocatable :: x(:, :), at(:, :)
    real(rp) :: best(2), f
    integer(i8) :: number
    integer :: k, n_failed
    logical :: has_best
    call objective%init(experiment, pool, .false.)
    mean_state = objective%rest()
    allocate (region%lower(2), region%upper(2))
    region%lower = 0
    region%upper = 1
    region%is_box = .true.
    options%max_iterations = 60
    options%seed = 3
    call search%start(options, RESTARTS_NONE, 0, region)
    n_failed = 0
    do while (search%state%stop_code == RUNNING)
      call search%ask(x)
      at = x
      do k = 1, size(x, 2)
        at(:, k) = coordinates(x(:, k))
      end do
      call objective%solve_mean(coordinates(search%run%state%mean), mean_state, next)
      mean_state = next
      call objective%evaluate(at, mean_state, costs)
      n_failed = n_failed + count(costs%has_failed)
      call search%tell(costs%f, costs%violation, costs%has_failed)
    end do
    call search%best(has_best, f, best, number)
    is_fifth = abs(real(n_failed, rp)/search%evaluations() - 0.19_rp) < 0.1_rp
    error = maxval(abs(coordinates(best) - truth))
  end subroutine test_search

  !> From points of the box, with stages; a point that fails has no second chance. The priors are about the truth.
  subroutine test_polish()
    integer, parameter :: N_STARTS = 6
    type(counting_problem_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    real(rp), allocatable :: path(:, :)
    real(rp) :: start(2)
    integer :: i, n_begun
    call problem%init(experiment)
    problem%pool => pool
    unknowns = wing_unknowns(experiment, truth, 1.0_rp)
    n_begun = 0
    do i = 1, N_STARTS
      start = coordinates(random_uniforms(6_i8, 1_i8, int(i, i8)))
      call fit_by_continuation(problem, unknowns, start, problem%initial_state(), options, .true., report, path)
      if (size(path, 2) == 0) cycle ! the start itself failed
      n_begun = n_begun + 1
      has_ended = has_ended .and. report%is_converged
      polish_error = max(polish_error, maxval(abs(report%p - truth)))
    end do
    has_ended = has_ended .and. n_begun >= N_STARTS/2
    is_fifth_point = abs(real(problem%n_failed, rp)/problem%n_points - 0.19_rp) < 0.1_rp
    call problem%free()
  end subroutine test_polish
end program test_train_objective

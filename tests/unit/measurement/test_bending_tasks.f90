! SPDX-License-Identifier: GPL-3.0-or-later
!> Tasks about the wing in the file that the first argument names, done by a pool of ranks, give what `evaluate` and the tangents of
!> a simulation give, to the bit, on any number of ranks. A pool stops between batches only with rules for it.
program test_bending_tasks
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use io_stop, only: job_limits_t
  use loaded_wing, only: wing_of_argument
  use measurement_bending_pool, only: bending_batch_t, bending_pool_t
  use measurement_bending_runner, only: bending_runner_t
  use measurement_bending_task, only: bending_task_t, take_columns, take_facts, task_input, COST_CHI2, COST_MEAN_SQUARE, &
                                      FACT_VIOLATION, N_FACTS, NOT_SOLVED, TASK_COSTS, TASK_DIRECTIONS, TASK_EVALUATE, &
                                      TASK_NUISANCES
  use measurement_data, only: measurement_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use measurement_observed_wing, only: observed_wing_t
  use measurement_simulation, only: N_NUISANCES
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: NX = 12, NY = 8, N_LOADS = 2, N = 2
  real(rp), parameter :: FORCES(N_LOADS) = [2.0e-4_rp, -1.5e-4_rp], OFFSET(2) = [2.0e-5_rp, 1.0e-5_rp]
  type(testkit_t) :: t
  type(wing_t), target :: wing
  type(experiment_t), target :: experiment
  type(bending_pool_t) :: pool
  type(evaluation_t) :: cold(N_LOADS), warm(N_LOADS), moved
  type(evaluation_work_t) :: work
  character(80) :: notes(20) = ''
  logical :: is_true(20) = .true.
  integer :: n_notes = 0, i
  real(rp), allocatable :: q(:), near(:), shapes(:, :, :), warm_shapes(:, :, :), u(:, :), directions(:, :)

  call t%start(parallel=.true.)
  wing = wing_of_argument()
  call make_experiment()
  call solve_alone()
  call make_pool()
  if (t%world%is_root) then
    call check_evaluations()
    call check_costs()
    call check_directions()
    call check_no_shape()
    call pool%poll()
    call note('without rules a pool does not stop',.not. pool%is_stopped)
    call note('tasks are counted', pool%n_tasks == 8)
    call pool%shut_down()
  else
    call pool%serve()
  end if
  call pool%free()
  call check_stop()
  call check_zone()
  call t%world%broadcast_integer(n_notes)
  do i = 1, n_notes ! all ranks check
    call t%check(trim(notes(i)), is_true(i))
  end do
  call t%finish()

contains

  !> Loads seen on a coarse grid; what the heights are does not matter.
  subroutine make_experiment()
    type(measurement_t) :: m
    type(solid_params_t) :: params
    type(static_options_t) :: options
    type(failure_t) :: failure
    real(rp) :: low(2), high(2)
    integer :: a, b, l
    low = minval(wing%points(:2, :), 2)
    high = maxval(wing%points(:2, :), 2)
    m%x = [(low(1) + (a - 0.5_rp)*(high(1) - low(1))/NX, a=1, NX)]
    m%y = [(low(2) + (b - 0.5_rp)*(high(2) - low(2))/NY, b=1, NY)]
    allocate (m%unloaded(NX, NY), source=0.0_rp)
    allocate (m%unloaded_sigma(NX, NY), source=1.0e-5_rp)
    allocate (m%has_unloaded(NX, NY), source=.true.)
    allocate (m%loads(N_LOADS), m%observations(0), m%zeros(0))
    m%accuracy%height = 1.0e-5_rp
    m%accuracy%tilt = 1.0e-3_rp
    do l = 1, N_LOADS
      associate (load => m%loads(l))
        load%name = 'load'
        load%has_surface = .true.
        load%force = FORCES(l)
        load%direction = [0.0_rp, 0.0_rp, 1.0_rp]
        load%point = sum(wing%points(:2, wing%triangles(:, size(wing%triangles, 2)/(1 + l))), 2)/3
        load%node = reshape([((a, b, a=1, NX), b=1, NY)], [2, NX*NY])
        allocate (load%height(NX*NY), source=0.0_rp)
        allocate (load%sigma(NX*NY), source=1.0e-5_rp)
      end associate
    end do
    params = default_params(wing)
    call experiment%init(m, wing, params, [params%find('E'), params%find('D')], options, failure)
    call t%check('the experiment is made',.not. failure%failed)
    q = experiment%start()
    near = q + [0.1_rp, -0.2_rp]
  end subroutine make_experiment

  !> What every rank finds by itself: cold, then warm at another point, and with a load beside its place.
  subroutine solve_alone()
    real(rp), allocatable :: columns(:, :)
    real(rp) :: sd(N_NUISANCES)
    integer :: l, i
    call work%init(experiment)
    allocate (shapes(3, experiment%model%n_all, N_LOADS), source=0.0_rp)
    do l = 1, N_LOADS
      call cold(l)%init(experiment, l, .true.)
      call warm(l)%init(experiment, l, .true.)
      call evaluate(experiment, work, q, l, .false., shapes(:, :, l), cold(l))
    end do
    warm_shapes = shapes
    do l = 1, N_LOADS
      call evaluate(experiment, work, near, l, .true., warm_shapes(:, :, l), warm(l))
    end do
    call t%check('the shapes are found', all(cold%is_solved .and. warm%is_solved .and. cold%is_start))
    call moved%init(experiment, 1, .true.)
    allocate (u(3, experiment%model%n_all), source=0.0_rp)
    call evaluate(experiment, work, q, 1, .false., u, moved, OFFSET)
    allocate (columns(size(moved%residuals), N_NUISANCES))
    call work%nuisance_tangents(experiment, 1, columns, sd)
    directions = reshape([((sd(i)*columns(l, i), l=1, size(columns, 1)), i=1, N_NUISANCES)], shape(columns))
    call work%free()
  end subroutine solve_alone

  subroutine make_pool(limits)
    type(job_limits_t), intent(in), optional :: limits
    class(observed_wing_t), allocatable :: observed
    class(bending_runner_t), allocatable :: runner
    allocate (observed, runner)
    call observed%take_experiment(experiment)
    call runner%init(observed)
    call pool%init(t%world, runner, limits)
  end subroutine make_pool

  !> Keeps what rank 0 has found until the others check, too.
  subroutine note(sentence, is_right)
    character(*), intent(in) :: sentence
    logical, intent(in) :: is_right
    n_notes = n_notes + 1
    notes(n_notes) = sentence
    is_true(n_notes) = is_right
  end subroutine note

  !> Whether two arrays have the same bits.
  pure logical function same(a, b)
    real(rp), intent(in) :: a(:), b(:)
    same = size(a) == size(b)
    if (same) same = .not. any(abs(a - b) > 0)
  end function same

  !> Both loads warm from the shapes that are shared, with all derivatives in another order; then one with an offset and one column.
  subroutine check_evaluations()
    type(bending_batch_t) :: batch
    type(evaluation_t) :: one
    logical :: is_right
    integer :: l, at
    call pool%make_batch(N_LOADS, TASK_EVALUATE, N, batch)
    do l = 1, N_LOADS
      batch%inputs(:, l) = task_input(bending_task_t(TASK_EVALUATE, l, .true.), near, [1, 2])
    end do
    batch%starts = reshape(shapes, [size(shapes)])
    batch%order = [2, 1]
    call pool%run(batch)
    is_right = all(batch%statuses == 0)
    do l = 1, N_LOADS
      call one%init(experiment, l, .true.)
      call take_facts(batch%outputs(:, l), one)
      is_right = is_right .and. one%is_solved .and. one%factorisations == warm(l)%factorisations .and. &
                 (one%is_start .eqv. warm(l)%is_start) .and. one%snaps == warm(l)%snaps .and. &
                 (one%was_redone_cold .eqv. warm(l)%was_redone_cold) .and. same(one%violation, warm(l)%violation)
      at = N_FACTS + size(one%residuals)
      is_right = is_right .and. same(batch%outputs(N_FACTS + 1:at, l), warm(l)%residuals)
      call take_columns([2, 1], N, batch%outputs(:, l), at, one%jacobian)
      is_right = is_right .and. same(one%jacobian(:, 1), warm(l)%jacobian(:, 2)) .and. &
                 same(one%jacobian(:, 2), warm(l)%jacobian(:, 1))
      is_right = is_right .and. same(batch%outputs(at + 1:at + size(u), l), reshape(warm_shapes(:, :, l), [size(u)]))
    end do
    call note('warm tasks give facts, residuals, derivatives and shapes', is_right)
    call pool%make_batch(1, TASK_EVALUATE, 1, batch)
    batch%inputs(:, 1) = task_input(bending_task_t(TASK_EVALUATE, 1, load_offset=OFFSET), q, [2])
    batch%starts = [real(rp) ::]
    call pool%run(batch)
    at = N_FACTS + size(moved%residuals)
    call note('a load beside its place is another one', same(batch%outputs(N_FACTS + 1:at, 1), moved%residuals) .and. &
                 .not. same(moved%residuals, cold(1)%residuals))
    call note('derivatives are those that are wanted', &
                 same(batch%outputs(at + 1:at + size(moved%residuals), 1), moved%jacobian(:, 2)))
  end subroutine check_evaluations

  subroutine check_costs()
    type(bending_batch_t) :: batch
    logical :: is_right
    integer :: l
    call pool%make_batch(N_LOADS, TASK_COSTS, 0, batch)
    do l = 1, N_LOADS
      batch%inputs(:, l) = task_input(bending_task_t(TASK_COSTS, l), q, [integer ::])
    end do
    batch%starts = [real(rp) ::]
    call pool%run(batch)
    is_right = all(batch%statuses == 0) .and. size(batch%outputs, 1) == COST_CHI2
    do l = 1, N_LOADS
      is_right = is_right .and. same(batch%outputs(COST_MEAN_SQUARE:COST_CHI2, l), cold(l)%terms(experiment, l))
    end do
    call note('costs are sums over the residuals', is_right)
  end subroutine check_costs

  !> Nuisances, and the derivative behind them, whether patterns are asked for, of which there are none, or not.
  subroutine check_directions()
    integer, parameter :: KINDS(2) = [TASK_DIRECTIONS, TASK_NUISANCES]
    type(bending_batch_t) :: batch
    integer :: k, b, last
    b = size(moved%residuals)
    last = N_FACTS + N_NUISANCES*b
    do k = 1, 2
      call pool%make_batch(1, KINDS(k), 1, batch)
      batch%inputs(:, 1) = task_input(bending_task_t(KINDS(k), 1, load_offset=OFFSET), q, [1])
      batch%starts = [real(rp) ::]
      call pool%run(batch)
      call note('directions of nuisances come first', same(batch%outputs(N_FACTS + 1:last, 1), &
                                                              reshape(directions, [size(directions)])))
      call note('  then derivatives', same(batch%outputs(last + 1:last + b, 1), moved%jacobian(:, 1)))
    end do
  end subroutine check_directions

  !> A force that is far beside the wing bends nothing.
  subroutine check_no_shape()
    type(bending_batch_t) :: batch
    call pool%make_batch(1, TASK_EVALUATE, N, batch)
    batch%inputs(:, 1) = task_input(bending_task_t(TASK_EVALUATE, 1, load_offset=[1.0_rp, 0.0_rp]), q, [1, 2])
    batch%starts = [real(rp) ::]
    call pool%run(batch)
    call note('without a shape there is a status, and nothing behind the facts', &
                 batch%statuses(1) == NOT_SOLVED .and. .not. any(abs(batch%outputs(N_FACTS + 1:, 1)) > 0))
  end subroutine check_no_shape

  !> Of a shape in an excluded zone there are facts, and no directions. The root is placed where load 1 moves the tip.
  subroutine check_zone()
    integer, parameter :: KINDS(2) = [TASK_DIRECTIONS, TASK_NUISANCES]
    type(bending_batch_t) :: batch
    integer :: k
    experiment%root(:2) = experiment%model%points(:2, experiment%tip) + shapes(:2, experiment%tip, 1)
    call make_pool()
    if (t%world%is_root) then
      do k = 1, 2
        call pool%make_batch(1, KINDS(k), 1, batch)
        batch%inputs(:, 1) = task_input(bending_task_t(KINDS(k), 1), q, [1])
        batch%starts = [real(rp) ::]
        call pool%run(batch)
        call note('the tip is at the root', batch%statuses(1) == 0 .and. &
                  any(batch%outputs(FACT_VIOLATION:FACT_VIOLATION + 1, 1) > 0.4_rp))
        call note('  and nothing is behind the facts',.not. any(abs(batch%outputs(N_FACTS + 1:, 1)) > 0))
      end do
      call pool%shut_down()
    else
      call pool%serve()
    end if
    call pool%free()
  end subroutine check_zone

  !> The time is over when ranks meet: they agree, and the next batch is not begun.
  subroutine check_stop()
    type(bending_batch_t) :: batch
    type(job_limits_t) :: soon
    soon%stop_seconds = 1.0e-6_rp
    call make_pool(soon)
    if (t%world%is_root) then
      call pool%poll()
      call pool%make_batch(1, TASK_COSTS, 0, batch)
      batch%inputs(:, 1) = task_input(bending_task_t(TASK_COSTS, 1), q, [integer ::])
      batch%starts = [real(rp) ::]
      call pool%run(batch)
      call note('a pool whose time is over begins no task', pool%is_stopped .and. all(batch%statuses < 0))
      call pool%shut_down()
    else
      call pool%serve()
    end if
    call t%check('all ranks know that they stop', pool%runner%stop_rules%must_stop)
    call pool%free()
  end subroutine check_stop
end program test_bending_tasks

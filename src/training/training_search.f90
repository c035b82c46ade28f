! SPDX-License-Identifier: GPL-3.0-or-later
!> Searches globally by CMA-ES, generation by generation, with a checkpoint and a row of the history for each; in two stages if
!> wanted, the second one with E fixed. Rank 0 searches while the other ranks serve the pool.
module training_search
  use base_errors, only: failure_t
  use base_files, only: folder_of, join_path, name_of
  use base_kinds, only: i8, rp
  use base_random, only: random_uniforms
  use base_text, only: number_text
  use cmaes_options, only: cmaes_options_t
  use cmaes_search, only: cmaes_search_t, start_region_t
  use cmaes_stop, only: RUNNING
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use io_checkpoint_slots, only: checkpoint_slots_t
  use io_checkpoint_values, only: load_part, save_part
  use io_identity, only: identity_t
  use measurement_bending_pool, only: bending_pool_t
  use measurement_bending_state, only: bending_state_t
  use measurement_evaluation, only: evaluation_t
  use parallel_world, only: world_t
  use solid_usual_causes, only: PARAM_YOUNG
  use training_budget, only: find_budget
  use training_case, only: training_case_t
  use training_fingerprint, only: fingerprint_of
  use training_history, only: train_history_t
  use training_listener, only: training_listener_t
  use training_moves_state, only: moves_state_t
  use training_objective, only: candidate_costs_t, full_results, train_objective_t
  use training_space, only: search_space_t
  implicit none
  private
  public :: train_search_t

  character(*), parameter :: SCHEMA = 'flusi-msm training'
  integer, parameter :: MOST_DRAWS = 20 !< of random starts
  integer(i8), parameter :: DRAWS = 2_i8**62 !< number of a stream of random numbers that the optimiser does not use
  character(*), parameter :: PREFIX = 'search_of_'  !< of what the optimiser stores
  character(*), parameter :: COUNTS = 'count_of_'   !< of numbers of solutions
  character(*), parameter :: MOVES = 'moves_'       !< of the state of the moves that follow

  type :: train_search_t
    type(search_space_t) :: space
    type(cmaes_search_t) :: search         !< of the present stage
    type(train_objective_t) :: objective
    type(bending_state_t) :: mean_state    !< the solutions of the last mean, from which the next ones begin
    type(train_history_t) :: history
    integer :: stage = 1
    integer(i8) :: spent = 0               !< evaluations of finished stages
    logical :: is_done = .false.
    type(moves_state_t) :: moves           !< that follow the search
    type(failure_t) :: failure             !< of files
    type(identity_t) :: identity           !< of the run, for checkpoints
    type(checkpoint_slots_t), private :: slots
    integer(i8), private :: fingerprint = 0       !< identifies the training to which a checkpoint must belong
    integer, private :: since_checkpoint = 0
  contains
    procedure :: init => search_init
    procedure :: has_backup => search_has_backup
    procedure :: restore => search_restore
    procedure :: choose_start => search_choose_start
    procedure :: run => search_run
    procedure :: back_up => search_back_up
    procedure :: best => search_best
    procedure :: starts => search_starts
    procedure :: evaluations => search_evaluations
  end type train_search_t

contains

  !> Makes the first generation of the first stage. Settings and pool must live as long as the search.
  subroutine search_init(self, settings, pool)
    class(train_search_t), intent(inout) :: self
    class(training_case_t), intent(inout), target :: settings
    type(bending_pool_t), intent(in), target :: pool
    type(world_t) :: alone
    call self%space%init(settings%experiment, settings%free_parameters)
    call self%objective%init(settings%experiment, pool, settings%use_chi2)
    call self%history%init(settings%experiment%count())
    call alone%isolate()
    call self%slots%scan(alone, folder_of(settings%name), name_of(settings%name)//'_backup')
    self%fingerprint = fingerprint_of(settings)
    call begin_stage(self, settings)
  end subroutine search_init

  !> Moves the start to a random point of the box where the wing has an equilibrium under all loads. Elsewhere every candidate may
  !> fail, at high cost. After MOST_DRAWS draws it accepts any point. It does not change a search that has begun or that begins at
  !> the values of [Wing].
  subroutine search_choose_start(self, settings, pool, log)
    class(train_search_t), intent(inout) :: self
    class(training_case_t), intent(in) :: settings
    type(bending_pool_t), intent(inout) :: pool
    class(training_listener_t), intent(inout) :: log
    type(evaluation_t), allocatable :: evaluations(:)
    real(rp), allocatable :: shapes(:, :, :)
    real(rp) :: u(size(self%space%free)), pair(2)
    logical :: is_feasible, is_start(size(settings%experiment%loads))
    integer :: draw, i, l
    if (settings%starts_at_wing .or. self%history%n_generations > 0 .or. self%stage > 1) return
    is_start = .false.
    do draw = 1, MOST_DRAWS
      do i = 1, size(u)
        pair = random_uniforms(settings%search%seed, DRAWS, int(draw, i8)*1000000_i8 + i)
        u(i) = pair(1)
      end do
      call full_results(settings%experiment, pool, self%space%coordinates(u), is_start, self%mean_state%shapes, &
                        evaluations, shapes)
      if (pool%is_stopped) return
      is_feasible = .true.
      do l = 1, size(evaluations)
        is_feasible = is_feasible .and. evaluations(l)%is_feasible()
      end do
      if (is_feasible) exit
    end do
    call log%say('start     random point '//number_text(min(draw, MOST_DRAWS))// &
                 trim(merge(', with equilibria under all loads ', ', no equilibrium under some loads ', &
                            is_feasible)))
    call begin_stage(self, settings, u)
  end subroutine search_choose_start

  !> Makes the first generation of the present stage; `first` is its start.
  subroutine begin_stage(self, settings, first)
    class(train_search_t), intent(inout) :: self
    class(training_case_t), intent(in) :: settings
    real(rp), intent(in), optional :: first(:)
    type(start_region_t) :: region
    type(cmaes_options_t) :: options
    integer :: n
    n = size(self%space%free)
    allocate (region%lower(n), source=0.0_rp)
    allocate (region%upper(n), source=1.0_rp)
    region%is_box = .true.
    if (settings%starts_at_wing .and. self%stage == 1) &
      region%first = self%space%point(settings%experiment%start())
    if (self%stage > 1) region%first = self%space%fixed(self%space%free)
    if (present(first)) region%first = first
    options = settings%search
    options%seed = options%seed + (self%stage - 1)
    call self%search%start(options, settings%restarts, settings%max_restarts, region)
    self%mean_state = self%objective%rest()
  end subroutine begin_stage

  !> Tells whether there is a checkpoint from which the search can continue.
  logical function search_has_backup(self) result(found)
    class(train_search_t), intent(in) :: self
    character(:), allocatable :: name
    call self%slots%newest_valid(name, found)
  end function search_has_backup

  !> Continues from the checkpoint `path`, or from the newest valid one if `path` is empty. `was` is the run that wrote it, if it
  !> could be read.
  subroutine search_restore(self, settings, path, log, was, failure)
    class(train_search_t), intent(inout) :: self
    class(training_case_t), intent(in) :: settings
    character(*), intent(in) :: path
    class(training_listener_t), intent(inout) :: log
    type(identity_t), intent(out) :: was
    type(failure_t), intent(inout) :: failure
    type(world_t) :: alone
    type(checkpoint_reader_t), target :: reader
    character(:), allocatable :: name, text
    integer(i8) :: number
    logical :: found
    name = path
    if (name == '') then
      call self%slots%newest_valid(name, found)
      if (.not. found) then
        call failure%raise('there is no valid backup to restart from: '//self%slots%reason(0)//'; '// &
                           self%slots%reason(1))
        return
      end if
      name = join_path(folder_of(settings%name), name)
    end if
    call alone%isolate()
    call reader%open(alone, name, failure)
    if (failure%failed) return
    text = ''
    if (reader%has('schema')) call reader%get_text('schema', text, failure)
    if (text /= SCHEMA) then
      call failure%raise(name//': is not a checkpoint of msm_train')
    else if (.not. reader%has(COUNTS//'warm') .or. (reader%has(MOVES//'is_begun') .and. .not. reader%has(MOVES//'n_without'))) then
      call failure%raise(name//': was written by an earlier version of msm_train: restart with that version, or start again '// &
                         'with --overwrite')
    end if
    call was%load(reader, failure)
    call reader%get_integer('mark', number, failure)
    if (.not. failure%failed .and. number /= self%fingerprint) &
      call failure%raise(name//': does not fit this input: the wing, measurement, bounds of parameters, seed or kind of '// &
                         'search differ; restore them, or start again with --overwrite')
    if (.not. failure%failed) call load_state(self, settings, reader, failure)
    call reader%close(failure)
    call self%slots%came_from(name)
    if (.not. failure%failed) call log%say('restart   after '//number_text(int(self%evaluations()))// &
                                           ' evaluations from '//name)
  end subroutine search_restore

  !> Reads the state of the search from a checkpoint.
  subroutine load_state(self, settings, reader, failure)
    class(train_search_t), intent(inout) :: self
    class(training_case_t), intent(in) :: settings
    type(checkpoint_reader_t), intent(inout), target :: reader
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: numbers(:)
    integer(i8) :: number
    call reader%get_integer('stage', number, failure)
    if (.not. failure%failed .and. number == 2) then
      call reader%get_reals('fixed', numbers, failure)
      if (.not. failure%failed) call fix_youngs_modulus(self, settings, numbers)
    end if
    call reader%get_integer('spent', self%spent, failure)
    if (failure%failed) return
    call load_part(reader, PREFIX, self%search, failure)
    call reader%get_reals('mean_shapes', numbers, failure)
    if (.not. failure%failed) self%mean_state%shapes = reshape(numbers, shape(self%mean_state%shapes))
    call reader%get_reals('mean_is_start', numbers, failure)
    if (.not. failure%failed) self%mean_state%is_start = numbers > 0.5_rp
    call load_part(reader, COUNTS, self%objective%counts, failure)
    call self%history%load(reader, failure)
    if (reader%has(MOVES//'is_begun')) call load_part(reader, MOVES, self%moves, failure)
    self%is_done = (self%search%state%stop_code /= RUNNING .or. has_enough(self, settings)) .and. self%stage == settings%n_stages
  end subroutine load_state

  !> Makes generations until the search ends or the pool is stopped. Then it writes a checkpoint.
  subroutine search_run(self, settings, pool, log)
    class(train_search_t), intent(inout) :: self
    class(training_case_t), intent(in) :: settings
    type(bending_pool_t), intent(inout) :: pool
    class(training_listener_t), intent(inout) :: log
    do while (.not. self%is_done)
      self%moves = moves_state_t()
      call pool%poll()
      if (.not. pool%is_stopped) call make_generation(self, settings%n_stages - self%stage, pool, log)
      if (pool%is_stopped) exit
      self%since_checkpoint = self%since_checkpoint + 1
      if (self%search%state%stop_code /= RUNNING .or. has_enough(self, settings)) call finish_stage(self, settings, log)
      if (self%since_checkpoint >= settings%checkpoint_every .or. self%is_done) call self%back_up()
      if (self%failure%failed) return
    end do
    if (self%since_checkpoint > 0 .or. self%history%n_generations == 0) call self%back_up()
  end subroutine search_run

  !> Makes one generation. If the pool is stopped during it, nothing changes.
  subroutine make_generation(self, n_coming, pool, log)
    class(train_search_t), intent(inout) :: self
    integer, intent(in) :: n_coming !< stages that follow this one
    type(bending_pool_t), intent(inout) :: pool
    class(training_listener_t), intent(inout) :: log
    type(train_objective_t) :: before
    type(bending_state_t) :: mean_state
    type(candidate_costs_t) :: costs
    real(rp), allocatable :: x(:, :), coordinates(:, :), values(:, :), mean(:), best_x(:)
    real(rp) :: sigma, condition, best
    integer(i8) :: counts(5), ignored
    integer :: k, run
    logical :: has_best
    before = self%objective
    call self%search%ask(x)
    allocate (coordinates(self%history%n_unknowns, size(x, 2)), best_x(size(x, 1)))
    allocate (values, source=coordinates)
    do k = 1, size(x, 2)
      coordinates(:, k) = self%space%coordinates(x(:, k))
      values(:, k) = self%space%values(x(:, k))
    end do
    associate (state => self%search%run%state)
      mean = self%space%values(state%mean)
      sigma = state%sigma
      condition = state%condition
      run = state%restart
      counts = [self%stage, run, state%generation + 1, size(x, 2), 0]
      call self%objective%solve_mean(self%space%coordinates(state%mean), self%mean_state, mean_state)
    end associate
    if (.not. pool%is_stopped) call self%objective%evaluate(coordinates, mean_state, costs)
    if (pool%is_stopped) then
      self%objective = before
      return
    end if
    self%mean_state = mean_state
    call self%search%tell(costs%f, costs%violation, costs%has_failed)
    call self%search%best(has_best, best, best_x, ignored)
    counts(5) = self%evaluations()
    call self%history%add_generation(counts, best, sigma, condition, costs, mean)
    call self%history%add_candidates(counts, costs, values)
    call log%progress(int(counts(3)), counts(5), find_budget(self%search, n_coming), best, sigma, condition)
    if (self%search%state%restart /= run) then
      call log%say('run '//number_text(run + 1)//' ended: '//self%search%stop_sentence())
      self%mean_state = self%objective%rest()
    end if
  end subroutine make_generation

  !> Tells whether a short search has found a point from which least squares can begin.
  logical function has_enough(self, settings)
    class(train_search_t), intent(in) :: self
    class(training_case_t), intent(in) :: settings
    real(rp), allocatable :: u(:)
    real(rp) :: best
    has_enough = .false.
    if (settings%search_is_short) call self%best(has_enough, best, u)
  end function has_enough

  !> Says why the stage ended, and begins the next one or ends the search.
  subroutine finish_stage(self, settings, log)
    class(train_search_t), intent(inout) :: self
    class(training_case_t), intent(in) :: settings
    class(training_listener_t), intent(inout) :: log
    real(rp), allocatable :: u(:)
    real(rp) :: best
    logical :: has_best
    call self%best(has_best, best, u)
    if (has_enough(self, settings)) then
      call log%say('search    ended after '//number_text(int(self%evaluations()))//' evaluations; a candidate has an '// &
                   'equilibrium under all loads, and least squares do the rest')
    else
      call log%say('search    ended after '//number_text(int(self%evaluations()))//' evaluations; '// &
                   self%search%stop_sentence())
    end if
    self%is_done = self%stage == settings%n_stages .or. .not. has_best
    if (self%is_done) return
    call log%say('stage 2   E is fixed, the other parameters are fitted again')
    call fix_youngs_modulus(self, settings, self%space%whole(u))
  end subroutine finish_stage

  !> Fixes E at its present value and begins the second stage.
  subroutine fix_youngs_modulus(self, settings, u)
    class(train_search_t), intent(inout) :: self
    class(training_case_t), intent(in) :: settings
    real(rp), intent(in) :: u(:)
    integer :: i
    do i = 1, size(settings%free_parameters%numbers)
      if (settings%free_parameters%numbers(i) == PARAM_YOUNG) call self%space%fix(i, u)
    end do
    self%stage = 2
    self%spent = self%search%evaluations()
    call begin_stage(self, settings)
  end subroutine fix_youngs_modulus

  !> Returns the number of candidates that all stages have evaluated.
  pure integer(i8) function search_evaluations(self) result(n)
    class(train_search_t), intent(in) :: self
    n = self%spent + self%search%evaluations()
  end function search_evaluations

  !> Returns the best feasible point of all stages, in the space of the present stage.
  subroutine search_best(self, has_best, cost, u)
    class(train_search_t), intent(in) :: self
    logical, intent(out) :: has_best
    real(rp), intent(out) :: cost
    real(rp), allocatable, intent(out) :: u(:)
    integer(i8) :: ignored
    allocate (u(size(self%space%free)))
    call self%search%best(has_best, cost, u, ignored)
    if (self%stage > 1) call self%history%improve(self%space, has_best, cost, u)
  end subroutine search_best

  !> Returns the points from which polishes may begin, as coordinates of the experiment. The point u comes first, then other good
  !> points.
  subroutine search_starts(self, settings, u, starts)
    class(train_search_t), intent(in) :: self
    class(training_case_t), intent(in) :: settings
    real(rp), intent(in) :: u(:)
    real(rp), allocatable, intent(out) :: starts(:, :)
    integer :: i
    call self%history%best_candidates(settings%polish_starts, 0.5_rp, starts)
    do i = 1, size(starts, 2)
      where (self%space%is_log) starts(:, i) = log(starts(:, i))
    end do
    if (self%stage > 1 .or. size(starts, 2) == 0) &
      starts = reshape(self%space%coordinates(u), [size(self%space%fixed), 1])
  end subroutine search_starts

  !> Writes the next of the two alternating checkpoints.
  subroutine search_back_up(self)
    class(train_search_t), intent(inout) :: self
    type(checkpoint_writer_t), target :: writer
    call self%slots%begin(writer, self%failure)
    call self%identity%save(writer)
    call writer%put_text('schema', SCHEMA)
    call writer%put_integer('mark', self%fingerprint)
    call writer%put_integer('stage', int(self%stage, i8))
    call writer%put_integer('spent', self%spent)
    call writer%put_reals('fixed', self%space%fixed)
    call save_part(writer, PREFIX, self%search)
    call writer%put_reals('mean_shapes', [self%mean_state%shapes])
    call writer%put_reals('mean_is_start', merge(1.0_rp, 0.0_rp, self%mean_state%is_start))
    call save_part(writer, COUNTS, self%objective%counts)
    call self%history%save(writer)
    if (self%moves%is_begun) call save_part(writer, MOVES, self%moves)
    call self%slots%commit(writer, self%failure)
    self%since_checkpoint = 0
  end subroutine search_back_up
end module training_search

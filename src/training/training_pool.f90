! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes all ranks work for rank 0. Batches of tasks for costs return few numbers, and batches with everything return long
!> results. All ranks take the same decision to stop.
!>
!>     if (world%is_root) then
!>       ... call pool%run_costs / run_full / poll as often as needed, then call pool%shut_down()
!>     else
!>       call pool%serve()
!>     end if
module training_pool
  use base_kinds, only: i8, rp
  use io_stop, only: job_limits_t, stop_rules_t
  use measurement_experiment, only: experiment_t
  use parallel_farm, only: farm_t
  use parallel_world, only: world_t
  use training_task, only: full_size, input_size, train_runner_t, COST_SIZE
  implicit none
  private
  public :: batch_t, worker_pool_t

  integer, parameter :: SHUT_DOWN = 0, COSTS = 1, FULL = 2, POLL = 3 ! commands to the other ranks

  !> Tasks and their results.
  type :: batch_t
    real(rp), allocatable :: starts(:)     !< what warm solutions start from, (3, n_all, loads) flat
    integer, allocatable :: order(:)       !< numbers of the tasks, the first to be begun first
    real(rp), allocatable :: inputs(:, :)  !< (numbers, tasks)
    real(rp), allocatable :: outputs(:, :) !< (numbers, tasks)
    integer, allocatable :: statuses(:)    !< (tasks) negative: not done
    real(rp), allocatable :: seconds(:)    !< (tasks) that they took
  contains
    procedure :: init => batch_init
  end type batch_t

  type :: worker_pool_t
    type(world_t) :: world
    class(train_runner_t), pointer :: runner => null()
    type(stop_rules_t) :: stop_rules
    logical :: is_stopped = .false.         !< no more tasks are begun, and results are missing
    integer(i8) :: n_tasks = 0
    real(rp) :: busy_seconds = 0            !< sum over tasks
    type(farm_t), private :: cost_farm, full_farm
  contains
    procedure :: init => pool_init
    procedure :: run_costs => pool_run_costs
    procedure :: run_full => pool_run_full
    procedure :: poll => pool_poll
    procedure :: serve => pool_serve
    procedure :: shut_down => pool_shut_down
  end type worker_pool_t

contains

  !> Makes room for n tasks, in the order of their numbers, with inputs and outputs of these sizes.
  subroutine batch_init(self, n, n_in, n_out)
    class(batch_t), intent(out) :: self
    integer, intent(in) :: n, n_in, n_out
    integer :: k
    self%order = [(k, k=1, n)]
    allocate (self%inputs(n_in, n), self%outputs(n_out, n), self%statuses(n), self%seconds(n))
  end subroutine batch_init

  !> Takes the runner, made for the experiment, which must live as long as the pool and gives it the time. Collective.
  subroutine pool_init(self, world, experiment, runner, limits)
    class(worker_pool_t), intent(inout), target :: self
    type(world_t), intent(in) :: world
    type(experiment_t), intent(in) :: experiment
    class(train_runner_t), intent(inout), target :: runner
    type(job_limits_t), intent(in) :: limits
    self%world = world
    self%runner => runner
    call self%cost_farm%start(world, input_size(experiment), COST_SIZE)
    call self%full_farm%start(world, input_size(experiment), full_size(experiment))
    call self%stop_rules%init(limits)
    runner%stop_rules => self%stop_rules
  end subroutine pool_init

  !> Does tasks for costs. If `is_stopped` is set afterwards, results are missing. On rank 0.
  subroutine pool_run_costs(self, batch)
    class(worker_pool_t), intent(inout) :: self
    type(batch_t), intent(inout) :: batch
    call run_batch(self, COSTS, self%cost_farm, batch)
  end subroutine pool_run_costs

  !> Does tasks with everything. If `is_stopped` is set afterwards, results are missing. On rank 0.
  subroutine pool_run_full(self, batch)
    class(worker_pool_t), intent(inout) :: self
    type(batch_t), intent(inout) :: batch
    call run_batch(self, FULL, self%full_farm, batch)
  end subroutine pool_run_full

  !> Runs the tasks of a batch on all ranks, and counts tasks and time.
  subroutine run_batch(self, command, farm, batch)
    class(worker_pool_t), intent(inout) :: self
    integer, intent(in) :: command
    type(farm_t), intent(inout) :: farm
    type(batch_t), intent(inout) :: batch
    call send(self, command)
    call farm%broadcast(self%runner, batch%starts)
    call farm%run(self%runner, batch%order, batch%inputs, batch%outputs, batch%statuses, batch%seconds)
    call farm%shut_down()
    self%n_tasks = self%n_tasks + count(batch%statuses >= 0)
    self%busy_seconds = self%busy_seconds + sum(batch%seconds)
    if (any(batch%statuses < 0)) self%is_stopped = .true.
  end subroutine run_batch

  !> Checks whether to stop: sets `is_stopped` and stop_rules%reason. On rank 0.
  subroutine pool_poll(self)
    class(worker_pool_t), intent(inout) :: self
    call send(self, POLL)
    call self%stop_rules%poll(self%world)
    if (.not. self%stop_rules%must_stop) return
    self%is_stopped = .true.
    self%runner%is_stopping = .true.
  end subroutine pool_poll

  !> Does what rank 0 asks for until it ends the service. On the other ranks.
  subroutine pool_serve(self)
    class(worker_pool_t), intent(inout) :: self
    integer :: command
    do
      command = SHUT_DOWN
      call self%world%broadcast_integer(command)
      select case (command)
      case (COSTS)
        call self%cost_farm%serve(self%runner)
      case (FULL)
        call self%full_farm%serve(self%runner)
      case (POLL)
        call self%stop_rules%poll(self%world)
      case default
        exit
      end select
    end do
  end subroutine pool_serve

  !> Ends `serve`. On rank 0.
  subroutine pool_shut_down(self)
    class(worker_pool_t), intent(inout) :: self
    call send(self, SHUT_DOWN)
  end subroutine pool_shut_down

  !> Tells all other ranks what to do next.
  subroutine send(self, command)
    class(worker_pool_t), intent(in) :: self
    integer, intent(in) :: command
    integer :: word
    word = command
    call self%world%broadcast_integer(word)
  end subroutine send
end module training_pool

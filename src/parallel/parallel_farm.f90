! SPDX-License-Identifier: GPL-3.0-or-later
!> Distributes tasks: rank 0 gives them one by one to free ranks.
!>
!> A task takes a few real numbers and returns a few real numbers and a status. It must depend on nothing but its input and the
!> shared context. Results are placed by task number, so that everything that rank 0 computes from them is the same to the last bit
!> for any number of ranks. While many tasks remain, every worker has one more task waiting. If there are few ranks, rank 0 works
!> too. It takes the last tasks of the order, which should be the shortest, so that it soon serves the others again. With one rank
!> everything is serial.
!>
!>     if (world%is_root) then
!>       call farm%broadcast(runner, context)            as often as needed
!>       call farm%run(runner, order, inputs, outputs, statuses, seconds)
!>       call farm%meet(runner)                        the same
!>       call farm%shut_down()                         once; ends `serve` of the others
!>     else
!>       call farm%serve(runner)
!>     end if
module parallel_farm
  use base_errors, only: require
  use base_kinds, only: rp
  use mpi_f08, only: MPI_Request, MPI_Status, MPI_Isend, MPI_Irecv, MPI_Recv, MPI_Iprobe, MPI_Wait, MPI_Wtime, &
                     MPI_ANY_SOURCE, MPI_DOUBLE_PRECISION, MPI_REQUEST_NULL, MPI_STATUS_IGNORE
  use parallel_world, only: world_t
  implicit none
  private
  public :: farm_t, task_runner_t, NOT_RUN

  integer, parameter :: NOT_RUN = -1 !< status of a task that was not begun because a stop was wanted
  integer, parameter :: FEW_RANKS = 8     ! up to this number rank 0 works: idle, it would waste over a tenth
  integer, parameter :: SHUT_DOWN = 0, BATCH = 1, BROADCAST = 2, MEETING = 3 ! commands to workers
  integer, parameter :: TASK_TAG = 71, RESULT_TAG = 72
  integer, parameter :: DEPTH = 2 ! tasks that a worker may hold

  !> Does tasks.
  type, abstract :: task_runner_t
    real(rp), allocatable :: context(:)    !< the array that rank 0 has shared last
    integer :: context_number = 0          !< number of arrays shared so far
    logical :: is_stopping = .false.       !< on rank 0: no more tasks are to be begun
  contains
    procedure(run_task), deferred :: run_task
    procedure(meet), deferred :: meet
    procedure :: wants_stop => runner_wants_stop
  end type task_runner_t

  abstract interface
    !> Computes the output of a task from its input and the context; `output` is 0 on entry. Status 0 is success; any positive
    !> number is a failure, which is only reported. Must not communicate.
    subroutine run_task(self, input, output, status)
      import :: task_runner_t, rp
      class(task_runner_t), intent(inout) :: self
      real(rp), intent(in) :: input(:)
      real(rp), intent(inout) :: output(:)
      integer, intent(out) :: status
    end subroutine run_task

    !> Does what all ranks have to do together between batches, for instance agree whether to stop. Collective.
    subroutine meet(self, world)
      import :: task_runner_t, world_t
      class(task_runner_t), intent(inout) :: self
      type(world_t), intent(in) :: world
    end subroutine meet
  end interface

  type :: buffer_t
    real(rp), allocatable :: numbers(:)
    type(MPI_Request) :: request
  end type buffer_t

  !> Sizes and messages. A task is (number, input), where number 0 ends a batch; a result is (number, status, seconds, output).
  type :: farm_t
    type(world_t) :: world
    integer :: n_input = 0, n_output = 0
    logical :: root_works = .true.
    type(buffer_t), allocatable, private :: tasks(:, :) !< DEPTH tasks for every other rank; rank 0 sends, others receive
    type(buffer_t), private :: results(DEPTH)           !< rank 0 receives with the first, others send
    integer, allocatable, private :: held(:), given(:)  !< tasks that a rank holds, and has been given
  contains
    procedure :: start => farm_start
    procedure :: broadcast => farm_broadcast
    procedure :: run => farm_run
    procedure :: meet => farm_meet
    procedure :: serve => farm_serve
    procedure :: shut_down => farm_shut_down
  end type farm_t

contains

  !> Tells, on rank 0, before tasks are distributed, whether to end the batch when the running tasks are done. May be overridden,
  !> for instance to check for signals.
  logical function runner_wants_stop(self) result(wants)
    class(task_runner_t), intent(inout) :: self
    wants = self%is_stopping
  end function runner_wants_stop

  !> Fixes the sizes of inputs and outputs; the same on all ranks. `root_works` replaces the rule that rank 0 works if there are at
  !> most eight ranks.
  subroutine farm_start(self, world, n_input, n_output, root_works)
    class(farm_t), intent(out) :: self
    type(world_t), intent(in) :: world
    integer, intent(in) :: n_input, n_output
    logical, intent(in), optional :: root_works
    integer :: rank, i
    self%world = world
    self%n_input = n_input
    self%n_output = n_output
    self%root_works = world%size <= FEW_RANKS
    if (present(root_works)) self%root_works = root_works .or. world%size == 1
    allocate (self%tasks(DEPTH, merge(world%size - 1, 1, world%is_root))) ! none on a single rank
    do rank = 1, size(self%tasks, 2)
      do i = 1, DEPTH
        allocate (self%tasks(i, rank)%numbers(1 + n_input), source=0.0_rp)
        self%tasks(i, rank)%request = MPI_REQUEST_NULL
      end do
    end do
    do i = 1, DEPTH
      allocate (self%results(i)%numbers(3 + n_output), source=0.0_rp)
      self%results(i)%request = MPI_REQUEST_NULL
    end do
    allocate (self%held(world%size - 1), self%given(world%size - 1))
  end subroutine farm_start

  !> Gives an array to the runners of all ranks. On rank 0, between batches; the others are in `serve`.
  subroutine farm_broadcast(self, runner, context)
    class(farm_t), intent(inout) :: self
    class(task_runner_t), intent(inout) :: runner
    real(rp), intent(in) :: context(:)
    call require(self%world%is_root, 'farm_broadcast: rank 0')
    call send_command(self, BROADCAST, size(context))
    call replace_context(self, runner, size(context), context)
  end subroutine farm_broadcast

  !> Broadcasts an array, as the sender and as a receiver.
  subroutine replace_context(self, runner, length, context)
    class(farm_t), intent(inout) :: self
    class(task_runner_t), intent(inout) :: runner
    integer, intent(in) :: length
    real(rp), intent(in), optional :: context(:)
    real(rp), allocatable :: copy(:)
    allocate (copy(length), source=0.0_rp)
    if (present(context)) copy = context
    call self%world%broadcast_reals(copy)
    call move_alloc(copy, runner%context)
    runner%context_number = runner%context_number + 1
  end subroutine replace_context

  !> Tells all other ranks what to do next. On rank 0.
  subroutine send_command(self, code, length)
    class(farm_t), intent(in) :: self
    integer, intent(in) :: code, length
    integer :: words(2)
    words = [code, length]
    call self%world%broadcast_integers(words)
  end subroutine send_command

  !> Makes all ranks do what they do together, see `task_runner_t`. On rank 0, between batches; the others are in `serve`.
  subroutine farm_meet(self, runner)
    class(farm_t), intent(in) :: self
    class(task_runner_t), intent(inout) :: runner
    call require(self%world%is_root, 'farm_meet: rank 0')
    call send_command(self, MEETING, 0)
    call runner%meet(self%world)
  end subroutine farm_meet

  !> Ends `serve` on the other ranks. On rank 0.
  subroutine farm_shut_down(self)
    class(farm_t), intent(inout) :: self
    call require(self%world%is_root, 'farm_shut_down: rank 0')
    call send_command(self, SHUT_DOWN, 0)
  end subroutine farm_shut_down

  !> Does the tasks 1 .. size(order), which begin in this order. The arrays are inputs(n_input, :) and outputs(n, :) with n up to
  !> n_output; only these n numbers are sent. The output of a task that was not run is 0, and its status NOT_RUN; a failed task
  !> leaves the output as the runner left it. `seconds` is the duration of each task. On rank 0; the others are in `serve`.
  subroutine farm_run(self, runner, order, inputs, outputs, statuses, seconds)
    class(farm_t), intent(inout) :: self
    class(task_runner_t), intent(inout) :: runner
    integer, intent(in) :: order(:)
    real(rp), intent(in) :: inputs(:, :)
    real(rp), intent(out) :: outputs(:, :)
    integer, intent(out) :: statuses(:)
    real(rp), intent(out) :: seconds(:)
    type(MPI_Status) :: envelope
    integer :: first, last, rank, number
    logical :: has_result
    call require(self%world%is_root, 'farm_run: rank 0')
    call require(size(inputs, 1) == self%n_input .and. size(outputs, 1) <= self%n_output .and. &
                 all([size(inputs, 2), size(outputs, 2), size(statuses), size(seconds)] == size(order)), &
                 'farm_run: arrays of the right sizes')
    call require(is_permutation(order), 'farm_run: an order of all tasks')
    statuses = NOT_RUN
    seconds = 0
    self%held = 0
    self%given = 0
    first = 1 ! the tasks order(first:last) are left
    last = size(order)
    call send_command(self, BATCH, size(outputs, 1))
    do
      if (first <= last) then
        if (runner%wants_stop()) last = first - 1
      end if
      do rank = 1, self%world%size - 1
        do while (first <= last .and. may_take(self, rank, last - first + 1))
          call hand_out(self, rank, order(first), inputs(:, order(first)))
          first = first + 1
        end do
      end do
      has_result = .false.
      if (first <= last .and. self%root_works) then
        number = order(last)
        if (self%world%size == 1) number = order(first)
        call time_task(runner, inputs(:, number), outputs(:, number), statuses(number), seconds(number))
        if (self%world%size == 1) then
          first = first + 1
        else
          last = last - 1
        end if
      else if (sum(self%held) > 0) then
        call take_result(self, outputs, statuses, seconds)
      else if (first > last) then
        exit
      end if
      do while (sum(self%held) > 0)
        call MPI_Iprobe(MPI_ANY_SOURCE, RESULT_TAG, self%world%comm, has_result, envelope)
        if (.not. has_result) exit
        call take_result(self, outputs, statuses, seconds)
      end do
    end do
    call end_batch(self)
    do number = 1, size(order)
      if (statuses(number) == NOT_RUN) outputs(:, number) = 0
    end do
  end subroutine farm_run

  !> Tells whether a worker may take one more task. It holds at most two, and near the end only one, so that no other is idle.
  pure logical function may_take(self, rank, n_left)
    class(farm_t), intent(in) :: self
    integer, intent(in) :: rank, n_left
    may_take = self%held(rank) == 0 .or. (self%held(rank) < DEPTH .and. n_left >= self%world%size)
  end function may_take

  !> Sends a task; the buffer is free, as the worker has returned what was sent from it before.
  subroutine hand_out(self, rank, number, input)
    class(farm_t), intent(inout) :: self
    integer, intent(in) :: rank, number
    real(rp), intent(in) :: input(:)
    integer :: slot
    slot = modulo(self%given(rank), DEPTH) + 1
    call MPI_Wait(self%tasks(slot, rank)%request, MPI_STATUS_IGNORE)
    self%tasks(slot, rank)%numbers(1) = number
    self%tasks(slot, rank)%numbers(2:) = input
    call MPI_Isend(self%tasks(slot, rank)%numbers, 1 + self%n_input, MPI_DOUBLE_PRECISION, rank, TASK_TAG, &
                   self%world%comm, self%tasks(slot, rank)%request)
    self%given(rank) = self%given(rank) + 1
    self%held(rank) = self%held(rank) + 1
  end subroutine hand_out

  !> Waits for a result and stores it under the number of its task.
  subroutine take_result(self, outputs, statuses, seconds)
    class(farm_t), intent(inout) :: self
    real(rp), intent(inout) :: outputs(:, :), seconds(:)
    integer, intent(inout) :: statuses(:)
    type(MPI_Status) :: envelope
    integer :: number
    call MPI_Recv(self%results(1)%numbers, 3 + size(outputs, 1), MPI_DOUBLE_PRECISION, MPI_ANY_SOURCE, RESULT_TAG, &
                  self%world%comm, envelope)
    number = nint(self%results(1)%numbers(1))
    statuses(number) = nint(self%results(1)%numbers(2))
    seconds(number) = self%results(1)%numbers(3)
    outputs(:, number) = self%results(1)%numbers(4:3 + size(outputs, 1))
    self%held(envelope%MPI_SOURCE) = self%held(envelope%MPI_SOURCE) - 1
  end subroutine take_result

  !> Sends the task number 0 to every worker, which then holds no task.
  subroutine end_batch(self)
    class(farm_t), intent(inout) :: self
    real(rp) :: nothing(self%n_input)
    integer :: rank, slot
    nothing = 0
    do rank = 1, self%world%size - 1
      call hand_out(self, rank, 0, nothing)
      do slot = 1, DEPTH
        call MPI_Wait(self%tasks(slot, rank)%request, MPI_STATUS_IGNORE)
      end do
    end do
  end subroutine end_batch

  !> Does the work that rank 0 requests until rank 0 ends the service. On the other ranks.
  subroutine farm_serve(self, runner)
    class(farm_t), intent(inout) :: self
    class(task_runner_t), intent(inout) :: runner
    integer :: words(2)
    call require(.not. self%world%is_root, 'farm_serve: another rank than 0')
    do
      words = 0
      call self%world%broadcast_integers(words)
      select case (words(1))
      case (BATCH)
        call serve_batch(self, runner, words(2))
      case (BROADCAST)
        call replace_context(self, runner, words(2))
      case (MEETING)
        call runner%meet(self%world)
      case default
        exit
      end select
    end do
  end subroutine farm_serve

  !> Does tasks, each with an output of this length, while the next one is being received.
  subroutine serve_batch(self, runner, length)
    class(farm_t), intent(inout) :: self
    class(task_runner_t), intent(inout) :: runner
    integer, intent(in) :: length
    integer :: slot, status
    slot = 1
    call expect_task(self, slot)
    do
      call MPI_Wait(self%tasks(slot, 1)%request, MPI_STATUS_IGNORE)
      if (nint(self%tasks(slot, 1)%numbers(1)) == 0) exit
      call expect_task(self, DEPTH + 1 - slot)
      call MPI_Wait(self%results(slot)%request, MPI_STATUS_IGNORE)
      associate (numbers => self%results(slot)%numbers)
        numbers(1) = self%tasks(slot, 1)%numbers(1)
        call time_task(runner, self%tasks(slot, 1)%numbers(2:), numbers(4:3 + length), status, numbers(3))
        numbers(2) = status
      end associate
      call MPI_Isend(self%results(slot)%numbers, 3 + length, MPI_DOUBLE_PRECISION, 0, RESULT_TAG, &
                     self%world%comm, self%results(slot)%request)
      slot = DEPTH + 1 - slot
    end do
    do slot = 1, DEPTH
      call MPI_Wait(self%results(slot)%request, MPI_STATUS_IGNORE)
    end do
  end subroutine serve_batch

  !> Prepares to receive a task into a slot.
  subroutine expect_task(self, slot)
    class(farm_t), intent(inout) :: self
    integer, intent(in) :: slot
    call MPI_Irecv(self%tasks(slot, 1)%numbers, 1 + self%n_input, MPI_DOUBLE_PRECISION, 0, TASK_TAG, self%world%comm, &
                   self%tasks(slot, 1)%request)
  end subroutine expect_task

  !> Runs one task and measures its time.
  subroutine time_task(runner, input, output, status, seconds)
    class(task_runner_t), intent(inout) :: runner
    real(rp), intent(in) :: input(:)
    real(rp), intent(out) :: output(:), seconds
    integer, intent(out) :: status
    seconds = MPI_Wtime()
    output = 0
    call runner%run_task(input, output, status)
    seconds = MPI_Wtime() - seconds
  end subroutine time_task

  !> Tells whether `order` holds each of the numbers 1 to n once.
  pure logical function is_permutation(order)
    integer, intent(in) :: order(:)
    logical :: seen(size(order))
    integer :: i
    seen = .false.
    do i = 1, size(order)
      if (order(i) >= 1 .and. order(i) <= size(order)) seen(order(i)) = .true.
    end do
    is_permutation = all(seen)
  end function is_permutation
end module parallel_farm

! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes all ranks work for rank 0 on bending tasks, in batches. If there are rules for stopping, all ranks take the same decision.
!>
!>     call pool%init(world, runner, limits)         collective
!>     if (world%is_root) then
!>       ... call pool%make_batch / run / poll as often as needed, then call pool%shut_down()
!>     else
!>       call pool%serve()
!>     end if
module measurement_bending_pool
  use base_kinds, only: i8, rp
  use io_stop, only: job_limits_t
  use measurement_bending_runner, only: bending_runner_t
  use parallel_farm, only: farm_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: bending_batch_t, bending_pool_t

  !> Holds tasks and their results, see measurement_bending_task.
  type :: bending_batch_t
    real(rp), allocatable :: starts(:)     !< shapes (3, n_all, loads) at which warm solutions begin, in one row
    integer, allocatable :: order(:)       !< numbers of the tasks in the order in which they begin
    real(rp), allocatable :: inputs(:, :)  !< (numbers, tasks)
    real(rp), allocatable :: outputs(:, :) !< (numbers, tasks)
    integer, allocatable :: statuses(:)    !< (tasks) negative: not done
    real(rp), allocatable :: seconds(:)    !< (tasks) duration of each
  end type bending_batch_t

  type :: bending_pool_t
    class(bending_runner_t), allocatable :: runner
    logical :: is_stopped = .false.         !< no more tasks are begun, and results are missing
    integer(i8) :: n_tasks = 0
    real(rp) :: busy_seconds = 0            !< sum over tasks
    type(farm_t), private :: farm
  contains
    procedure :: init => pool_init
    procedure :: free => pool_free
    procedure :: make_batch => pool_make_batch
    procedure :: run => pool_run
    procedure :: poll => pool_poll
    procedure :: serve => pool_serve
    procedure :: shut_down => pool_shut_down
  end type bending_pool_t

contains

  !> Takes over the runner, whose actual argument is not allocated afterwards. Without limits, every batch runs to its end.
  !> Collective.
  subroutine pool_init(self, world, runner, limits)
    class(bending_pool_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    class(bending_runner_t), allocatable, intent(inout) :: runner
    type(job_limits_t), intent(in), optional :: limits
    call move_alloc(runner, self%runner)
    call self%farm%start(world, self%runner%input_size(), self%runner%most_output())
    self%runner%has_stop_rules = present(limits)
    if (present(limits)) call self%runner%stop_rules%init(limits)
  end subroutine pool_init

  !> Releases everything.
  subroutine pool_free(self)
    class(bending_pool_t), intent(inout) :: self
    if (allocated(self%runner)) call self%runner%free()
  end subroutine pool_free

  !> Makes room for n tasks of one kind, in the order of their numbers, with derivatives with respect to n_columns coordinates.
  subroutine pool_make_batch(self, n, kind, n_columns, batch)
    class(bending_pool_t), intent(in) :: self
    integer, intent(in) :: n, kind, n_columns
    type(bending_batch_t), intent(out) :: batch
    integer :: k
    batch%order = [(k, k=1, n)]
    allocate (batch%inputs(self%runner%input_size(), n), batch%outputs(self%runner%output_size(kind, n_columns), n), &
              batch%statuses(n), batch%seconds(n))
  end subroutine pool_make_batch

  !> Does the tasks of a batch on all ranks. If `is_stopped` is set afterwards, results are missing. On rank 0.
  subroutine pool_run(self, batch)
    class(bending_pool_t), intent(inout) :: self
    type(bending_batch_t), intent(inout) :: batch
    call self%farm%broadcast(self%runner, batch%starts)
    call self%farm%run(self%runner, batch%order, batch%inputs, batch%outputs, batch%statuses, batch%seconds)
    self%n_tasks = self%n_tasks + count(batch%statuses >= 0)
    self%busy_seconds = self%busy_seconds + sum(batch%seconds)
    if (any(batch%statuses < 0)) self%is_stopped = .true.
  end subroutine pool_run

  !> Checks whether to stop: sets `is_stopped`; `runner%stop_rules` has the reason. On rank 0.
  subroutine pool_poll(self)
    class(bending_pool_t), intent(inout) :: self
    call self%farm%meet(self%runner)
    if (.not. self%runner%stop_rules%must_stop) return
    self%is_stopped = .true.
    self%runner%is_stopping = .true.
  end subroutine pool_poll

  !> Does the tasks of rank 0 until rank 0 ends the service. On the other ranks.
  subroutine pool_serve(self)
    class(bending_pool_t), intent(inout) :: self
    call self%farm%serve(self%runner)
  end subroutine pool_serve

  !> Ends `serve`. On rank 0.
  subroutine pool_shut_down(self)
    class(bending_pool_t), intent(inout) :: self
    call self%farm%shut_down()
  end subroutine pool_shut_down
end module measurement_bending_pool

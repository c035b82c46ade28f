! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs the tasks of a training: one load on one candidate (measurement_bending_task), for costs or with everything.
module training_task
  use base_kinds, only: rp
  use base_packing, only: count_packed, pack_value
  use base_signals, only: signal_caught
  use io_stop, only: stop_rules_t
  use measurement_bending_task, only: bending_task_t, bending_worker_t, task_head, task_of, NOT_SOLVED, N_HEAD, TASK_COSTS, &
                                      TASK_EVALUATE
  use measurement_evaluation, only: evaluation_t
  use measurement_experiment, only: experiment_t
  use parallel_farm, only: task_runner_t
  implicit none
  private
  public :: train_runner_t, COST_SIZE, task_input, full_size, input_size

  !> Numbers that a task for costs gives back.
  integer, parameter :: COST_SIZE = 7
  integer, parameter, public :: COST_MEAN_SQUARE = 1, COST_CHI2 = 2, COST_VIOLATION = 3, COST_FACTORISATIONS = 5, &
                                COST_SNAPS = 6, COST_REDONE = 7

  !> Does tasks. The context that rank 0 shares is empty or holds the starts of warm solutions, (3, n_all, loads).
  type, extends(task_runner_t) :: train_runner_t
    type(stop_rules_t), pointer :: stop_rules => null() !< whose clock rank 0 checks between tasks, if there are any
    type(experiment_t), pointer, private :: experiment => null()
    type(bending_worker_t), private :: worker
    type(evaluation_t), allocatable, private :: without_derivatives(:), with_derivatives(:) !< (loads) without and with derivatives
  contains
    procedure :: init => runner_init
    procedure :: free => runner_free
    procedure :: run_task => runner_run_task
    procedure :: wants_stop => runner_wants_stop
  end type train_runner_t

contains

  !> Takes the experiment, which must live as long as the runner.
  subroutine runner_init(self, experiment)
    class(train_runner_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: experiment
    integer :: l
    self%experiment => experiment
    call self%worker%work%init(experiment)
    call self%worker%init(experiment%model%n_all)
    allocate (self%without_derivatives(size(experiment%loads)), self%with_derivatives(size(experiment%loads)))
    do l = 1, size(experiment%loads)
      call self%without_derivatives(l)%init(experiment, l, .false.)
      call self%with_derivatives(l)%init(experiment, l, .true.)
    end do
    allocate (self%context(0))
  end subroutine runner_init

  !> Releases everything.
  subroutine runner_free(self)
    class(train_runner_t), intent(inout) :: self
    call self%worker%free()
  end subroutine runner_free

  !> Returns a task: load l at these coordinates, warm or cold, with everything (derivatives, shape) or costs alone.
  pure function task_input(coordinates, l, is_warm, is_full) result(input)
    real(rp), intent(in) :: coordinates(:)
    integer, intent(in) :: l
    logical, intent(in) :: is_warm, is_full
    real(rp) :: input(N_HEAD + size(coordinates))
    input(:N_HEAD) = task_head(merge(TASK_EVALUATE, TASK_COSTS, is_full), l, is_warm, [0.0_rp, 0.0_rp])
    input(N_HEAD + 1:) = coordinates
  end function task_input

  !> Returns how many numbers an input has.
  pure integer function input_size(experiment) result(n)
    type(experiment_t), intent(in) :: experiment
    n = N_HEAD + experiment%count()
  end function input_size

  !> Returns how many numbers a task with everything gives back at most: an evaluation and the shape after it.
  integer function full_size(experiment) result(n)
    type(experiment_t), intent(in) :: experiment
    type(evaluation_t) :: evaluation
    integer :: l, most
    most = 0
    do l = 1, size(experiment%loads)
      most = max(most, experiment%count_residuals(l))
    end do
    n = evaluation_overhead(evaluation) + most*(1 + experiment%count()) + 3*experiment%model%n_all
  end function full_size

  !> Returns how many numbers an evaluation has besides residuals and Jacobian.
  integer function evaluation_overhead(evaluation) result(n)
    type(evaluation_t), intent(in) :: evaluation
    type(evaluation_t) :: empty
    empty = evaluation
    allocate (empty%residuals(0), empty%jacobian(0, 0))
    n = count_packed(empty)
  end function evaluation_overhead

  !> See `task_input`. `output` is the packed evaluation followed by the shape (3, n_all) [m], or the
  !> COST_SIZE numbers. The status is NOT_SOLVED where no shape was found.
  subroutine runner_run_task(self, input, output, status)
    class(train_runner_t), intent(inout) :: self
    real(rp), intent(in) :: input(:)
    real(rp), intent(inout) :: output(:)
    integer, intent(out) :: status
    type(bending_task_t) :: task
    real(rp), allocatable :: words(:)
    task = task_of(input)
    associate (l => task%load, coordinates => input(N_HEAD + 1:))
      if (task%kind == TASK_EVALUATE) then
        call self%worker%solve(self%experiment, task, coordinates, self%context, self%with_derivatives(l))
        call pack_value(self%with_derivatives(l), words)
        associate (m => size(words), n => size(self%worker%u))
          output(:m) = words
          output(m + 1:m + n) = reshape(self%worker%u, [n])
        end associate
        status = merge(0, NOT_SOLVED, self%with_derivatives(l)%is_solved)
      else
        call self%worker%solve(self%experiment, task, coordinates, self%context, self%without_derivatives(l))
        call sum_up(self%experiment, l, self%without_derivatives(l), output)
        status = merge(0, NOT_SOLVED, self%without_derivatives(l)%is_solved)
      end if
    end associate
  end subroutine runner_run_task

  !> Computes the costs of one load.
  subroutine sum_up(experiment, l, evaluation, output)
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    type(evaluation_t), intent(in) :: evaluation
    real(rp), intent(inout) :: output(:)
    associate (comparison => experiment%comparisons(l), r => evaluation%residuals)
      if (comparison%n_heights > 0) &
        output(COST_MEAN_SQUARE) = sum(r(:comparison%n_heights)**2)/comparison%n_heights
      output(COST_CHI2) = sum((r/comparison%sigma)**2)
    end associate
    output(COST_VIOLATION:COST_VIOLATION + 1) = evaluation%violation
    output(COST_FACTORISATIONS) = evaluation%factorisations
    output(COST_SNAPS) = evaluation%snaps
    output(COST_REDONE) = merge(1, 0, evaluation%was_redone_cold)
  end subroutine sum_up

  !> Tells whether a signal has asked rank 0 to stop, or its time is over: a generation may last longer than a job has left.
  logical function runner_wants_stop(self) result(wants)
    class(train_runner_t), intent(inout) :: self
    if (signal_caught() > 0) self%is_stopping = .true.
    if (associated(self%stop_rules)) then
      if (self%stop_rules%is_time_over()) self%is_stopping = .true.
    end if
    wants = self%is_stopping
  end function runner_wants_stop
end module training_task

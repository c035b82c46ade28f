! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the tasks of trainings and diagnoses: one load on one wing, on any rank. A task and its output are arrays of numbers.
!>
!> The input is the head (kind, load, warm or cold, offset of the load), the coordinates q(n) of the wing, and for each of them 1 if
!> derivatives with respect to it are wanted, otherwise 0. The output begins with the N_FACTS facts about the solution. If a shape
!> was found, results follow that depend on the kind of the task. b is the number of observations of the load.
!>
!> | kind | results |
!> |---|---|
!> | TASK_EVALUATE | residuals(b), derivatives(b, wanted) in the order of the coordinates, the shape (3, n_all) [m] |
!> | TASK_DIRECTIONS | nuisances(b, N_NUISANCES) of one declared sd (see simulation_t), derivatives(b, wanted), patterns(b, :) |
!> | TASK_NUISANCES | the same without patterns |
!> | TASK_COSTS | (1) and (2) of `evaluation_t%terms` |
module measurement_bending_task
  use base_kinds, only: rp
  use measurement_evaluation, only: evaluation_t
  implicit none
  private
  public :: bending_task_t, input_size, put_facts, take_columns, take_facts, task_input, task_of

  integer, parameter, public :: TASK_EVALUATE = 1, TASK_DIRECTIONS = 2, TASK_NUISANCES = 3, TASK_COSTS = 4
  integer, parameter, public :: N_HEAD = 5     !< numbers at the beginning of an input that describe the task
  integer, parameter, public :: NOT_SOLVED = 1 !< status of a task whose shape was not found

  !> Indices of the numbers of an output: first facts, then costs.
  integer, parameter, public :: N_FACTS = 7
  integer, parameter, public :: FACT_SOLVED = 1, FACT_VIOLATION = 2, FACT_FACTORISATIONS = 4, FACT_SNAPS = 5, FACT_START = 6, &
                                FACT_REDONE = 7
  integer, parameter, public :: COST_MEAN_SQUARE = N_FACTS + 1, COST_CHI2 = N_FACTS + 2

  type :: bending_task_t
    integer :: kind = 0, load = 0
    logical :: is_warm = .false.    !< it begins at the shape that rank 0 has broadcast
    real(rp) :: load_offset(2) = 0  !< [m] distance of the load from its declared site
  end type bending_task_t

contains

  !> Returns the size of the input of a task with n coordinates.
  pure integer function input_size(n)
    integer, intent(in) :: n
    input_size = N_HEAD + 2*n
  end function input_size

  !> Returns the input of a task at q, with derivatives with respect to the coordinates `columns`.
  pure function task_input(task, q, columns) result(input)
    type(bending_task_t), intent(in) :: task
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    real(rp) :: input(N_HEAD + 2*size(q))
    input(:N_HEAD) = [real(task%kind, rp), real(task%load, rp), merge(1.0_rp, 0.0_rp, task%is_warm), task%load_offset]
    input(N_HEAD + 1:N_HEAD + size(q)) = q
    input(N_HEAD + size(q) + 1:) = 0
    input(N_HEAD + size(q) + columns) = 1
  end function task_input

  !> Returns the task that the first numbers of an input describe.
  pure type(bending_task_t) function task_of(input) result(task)
    real(rp), intent(in) :: input(:)
    task%kind = nint(input(1))
    task%load = nint(input(2))
    task%is_warm = input(3) > 0.5_rp
    task%load_offset = input(4:5)
  end function task_of

  !> Writes the facts about a solution to the beginning of an output.
  pure subroutine put_facts(evaluation, output)
    type(evaluation_t), intent(in) :: evaluation
    real(rp), intent(inout) :: output(:)
    output(FACT_SOLVED) = merge(1, 0, evaluation%is_solved)
    output(FACT_VIOLATION:FACT_VIOLATION + 1) = evaluation%violation
    output(FACT_FACTORISATIONS) = evaluation%factorisations
    output(FACT_SNAPS) = evaluation%snaps
    output(FACT_START) = merge(1, 0, evaluation%is_start)
    output(FACT_REDONE) = merge(1, 0, evaluation%was_redone_cold)
  end subroutine put_facts

  !> Reads the facts about a solution from an output; residuals and derivatives stay as they are.
  pure subroutine take_facts(output, evaluation)
    real(rp), intent(in) :: output(:)
    type(evaluation_t), intent(inout) :: evaluation
    evaluation%is_solved = output(FACT_SOLVED) > 0.5_rp
    evaluation%violation = output(FACT_VIOLATION:FACT_VIOLATION + 1)
    evaluation%factorisations = nint(output(FACT_FACTORISATIONS))
    evaluation%snaps = nint(output(FACT_SNAPS))
    evaluation%is_start = output(FACT_START) > 0.5_rp
    evaluation%was_redone_cold = output(FACT_REDONE) > 0.5_rp
  end subroutine take_facts

  !> Reads derivatives(rows, columns) of one load from an output, which has them behind index `at`, once for each of n coordinates
  !> and in their order. Raises `at` to the last index that was read.
  pure subroutine take_columns(columns, n, output, at, derivatives)
    integer, intent(in) :: columns(:), n
    real(rp), intent(in) :: output(:)
    integer, intent(inout) :: at
    real(rp), intent(inout) :: derivatives(:, :)
    integer :: i, k, b
    b = size(derivatives, 1)
    do i = 1, n
      if (.not. any(columns == i)) cycle
      do k = 1, size(columns)
        if (columns(k) == i) derivatives(:, k) = output(at + 1:at + b)
      end do
      at = at + b
    end do
  end subroutine take_columns
end module measurement_bending_task

! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs the tasks of trainings and diagnoses: one load on one wing, on any rank of a farm. The result depends on the task and on
!> what rank 0 has broadcast, never on earlier work of the rank.
!>
!> | kind | gives |
!> |---|---|
!> | TASK_EVALUATE | residuals, derivatives, the shape |
!> | TASK_DIRECTIONS | tangents with respect to nuisances, parameters and patterns |
!> | TASK_PIXELS | residuals of all pixels |
!> | TASK_NUISANCES | tangents without those of patterns |
!> | TASK_COSTS | sums of squares |
module measurement_bending_task
  use base_errors, only: require
  use base_kinds, only: rp
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  implicit none
  private
  public :: bending_task_t, bending_worker_t, task_head, task_of

  integer, parameter, public :: TASK_EVALUATE = 1, TASK_DIRECTIONS = 2, TASK_PIXELS = 3, TASK_NUISANCES = 4, TASK_COSTS = 5
  integer, parameter, public :: N_HEAD = 5     !< numbers of an input that tell the task
  integer, parameter, public :: NOT_SOLVED = 1 !< status of a task whose shape was not found

  type :: bending_task_t
    integer :: kind = 0, load = 0
    logical :: is_warm = .false.    !< it begins at the shape that rank 0 has broadcast
    real(rp) :: load_offset(2) = 0  !< [m] of the load from its place
  end type bending_task_t

  !> Solves tasks. Afterwards `work` gives derivatives, and u(3, n_all) [m] is the shape.
  type :: bending_worker_t
    type(evaluation_work_t) :: work
    real(rp), allocatable :: u(:, :)
  contains
    procedure :: init => worker_init
    procedure :: free => worker_free
    procedure :: solve => worker_solve
  end type bending_worker_t

contains

  !> Returns the first N_HEAD numbers of an input, which say what the task is.
  pure function task_head(kind, load, is_warm, load_offset) result(head)
    integer, intent(in) :: kind, load
    logical, intent(in) :: is_warm
    real(rp), intent(in) :: load_offset(2)
    real(rp) :: head(N_HEAD)
    head = [real(kind, rp), real(load, rp), merge(1.0_rp, 0.0_rp, is_warm), load_offset]
  end function task_head

  !> Returns the task that the first numbers of an input say.
  pure type(bending_task_t) function task_of(input) result(task)
    real(rp), intent(in) :: input(:)
    task%kind = nint(input(1))
    task%load = nint(input(2))
    task%is_warm = input(3) > 0.5_rp
    task%load_offset = input(4:5)
  end function task_of

  !> Makes room for wings of n_all points. `work` must be made for the experiment too.
  subroutine worker_init(self, n_all)
    class(bending_worker_t), intent(inout) :: self
    integer, intent(in) :: n_all
    allocate (self%u(3, n_all), source=0.0_rp)
  end subroutine worker_init

  !> Releases everything.
  subroutine worker_free(self)
    class(bending_worker_t), intent(inout) :: self
    call self%work%free()
    if (allocated(self%u)) deallocate (self%u)
  end subroutine worker_free

  !> Solves for the load of the task at these coordinates, from rest or from its shape among starts(3 n_all loads) [m], and
  !> compares: see `evaluate`.
  subroutine worker_solve(self, experiment, task, coordinates, starts, evaluation)
    class(bending_worker_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    type(bending_task_t), intent(in) :: task
    real(rp), intent(in) :: coordinates(:), starts(:)
    type(evaluation_t), intent(inout) :: evaluation
    integer :: n
    n = size(self%u)
    self%u = 0
    if (task%is_warm) then
      call require(size(starts) == n*size(experiment%loads), 'measurement_bending_task: starts of warm solutions')
      self%u = reshape(starts((task%load - 1)*n + 1:task%load*n), shape(self%u))
    end if
    call evaluate(experiment, self%work, coordinates, task%load, task%is_warm, self%u, evaluation, task%load_offset)
  end subroutine worker_solve
end module measurement_bending_task

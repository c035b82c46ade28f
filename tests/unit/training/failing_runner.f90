! SPDX-License-Identifier: GPL-3.0-or-later
!> Does the tasks of a training, but fails a share of them: those whose input says so; and counts in least squares how many
!> points that were.
module failing_runner
  use base_checksum, only: checksum_reals
  use base_kinds, only: i8, rp
  use measurement_bending_runner, only: bending_runner_t
  use measurement_bending_task, only: NOT_SOLVED
  use measurement_evaluation, only: evaluation_t
  use measurement_problem, only: wing_point_t
  use training_pool_problem, only: pool_problem_t
  implicit none
  private
  public :: counting_problem_t, failing_runner_t, is_to_fail

  type, extends(bending_runner_t) :: failing_runner_t
    integer :: one_of = 0 !< every so many-th task fails; 0: none
  contains
    procedure :: run_task => failing_run_task
  end type failing_runner_t

  !> Counts its points, and those where a load has no feasible shape.
  type, extends(pool_problem_t) :: counting_problem_t
    integer :: n_points = 0, n_failed = 0
  contains
    procedure :: run => counting_run
  end type counting_problem_t

contains

  !> Whether the task with this input fails: as good as random, and always the same.
  pure logical function is_to_fail(input, one_of)
    real(rp), intent(in) :: input(:)
    integer, intent(in) :: one_of
    is_to_fail = .false.
    if (one_of > 0) is_to_fail = modulo(checksum_reals(input, 0_i8), int(one_of, i8)) == 0
  end function is_to_fail

  !> As a solver that gives up: no numbers, only the status.
  subroutine failing_run_task(self, input, output, status)
    class(failing_runner_t), intent(inout) :: self
    real(rp), intent(in) :: input(:)
    real(rp), intent(inout) :: output(:)
    integer, intent(out) :: status
    status = NOT_SOLVED
    if (.not. is_to_fail(input, self%one_of)) call self%bending_runner_t%run_task(input, output, status)
  end subroutine failing_run_task

  !> See `wing_problem_t`.
  subroutine counting_run(self, p, from, evaluations, shapes)
    class(counting_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    type(wing_point_t), intent(in) :: from
    type(evaluation_t), allocatable, intent(out) :: evaluations(:)
    real(rp), allocatable, intent(out) :: shapes(:, :, :)
    logical :: is_feasible
    integer :: l
    call self%pool_problem_t%run(p, from, evaluations, shapes)
    is_feasible = .true.
    do l = 1, size(evaluations)
      is_feasible = is_feasible .and. evaluations(l)%is_feasible()
    end do
    self%n_points = self%n_points + 1
    if (.not. is_feasible) self%n_failed = self%n_failed + 1
  end subroutine counting_run
end module failing_runner

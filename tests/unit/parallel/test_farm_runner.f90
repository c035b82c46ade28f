! SPDX-License-Identifier: GPL-3.0-or-later
!> Tasks of different durations for the test of the farm.
module test_farm_runner
  use base_kinds, only: rp, i8
  use parallel_farm, only: task_runner_t
  use parallel_world, only: world_t
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  private
  public :: sleepy_t, expected, FAILING

  integer, parameter :: FAILING = 3 !< status of every fifth task

  type, extends(task_runner_t) :: sleepy_t
    integer :: questions_left = huge(1) !< after so many questions it wants to stop
    integer :: n_done = 0
    integer :: n_met = 0                !< ranks that met last
    integer :: done(1000) = 0           !< tasks done on this rank, in order
  contains
    procedure :: run_task => sleepy_run_task
    procedure :: wants_stop => sleepy_wants_stop
    procedure :: meet => sleepy_meet
  end type sleepy_t

  interface
    integer(c_int) function usleep(microseconds) bind(c)
      import :: c_int
      integer(c_int), value :: microseconds
    end function usleep
  end interface

contains

  !> Sleeps up to two milliseconds; input: number, two numbers in (0, 1).
  subroutine sleepy_run_task(self, input, output, status)
    class(sleepy_t), intent(inout) :: self
    real(rp), intent(in) :: input(:)
    real(rp), intent(inout) :: output(:)
    integer, intent(out) :: status
    integer(c_int) :: ignored
    ignored = usleep(int(2000*input(2), c_int))
    call expected(input, self%context, output)
    status = 0
    if (modulo(nint(input(1)), 5) == 0) status = FAILING
    self%n_done = self%n_done + 1
    if (self%n_done <= size(self%done)) self%done(self%n_done) = nint(input(1)) + ignored
  end subroutine sleepy_run_task

  !> True after some questions.
  logical function sleepy_wants_stop(self) result(wants)
    class(sleepy_t), intent(inout) :: self
    wants = self%questions_left <= 0
    self%questions_left = self%questions_left - 1
  end function sleepy_wants_stop

  !> Counts the ranks.
  subroutine sleepy_meet(self, world)
    class(sleepy_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    self%n_met = world%max_integer(world%rank + 1)
  end subroutine sleepy_meet

  !> What the output of a task should be: numbers that no other input or context gives.
  pure subroutine expected(input, context, output)
    real(rp), intent(in) :: input(:), context(:)
    real(rp), intent(out) :: output(:)
    integer :: k
    do k = 1, size(output)
      output(k) = sin(input(1)*k + input(2)) + exp(input(3))*sum(context)/size(context)
    end do
  end subroutine expected
end module test_farm_runner

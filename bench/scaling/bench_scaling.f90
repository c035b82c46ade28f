! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures the time of AB2 steps of a vortex ring and counts the bytes and messages that they send. Prints one JSON object on its
!> last line. It is called through bench/scaling/run.
!>
!> usage: bench_scaling NX NY NZ STEPS ROWS (0: as flusi chooses)
program bench_scaling
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use base_process, only: peak_memory, wall_seconds
  use bench_json, only: number
  use bench_ring, only: vortex_ring
  use fluid_params, only: fluid_params_t
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use parallel_world, only: world_t
  implicit none
  integer, parameter :: WARM_UP = 2
  type(world_t) :: world
  type(fluid_params_t) :: p
  type(fluid_t) :: fluid
  type(request_t) :: request
  type(failure_t) :: failure
  character(32) :: argument
  real(rp), allocatable :: walls(:)
  real(rp) :: sums(1), largest(2), cpu, now
  integer(i8) :: bytes, messages
  integer :: n(3), steps, i

  do i = 1, 3
    call get_command_argument(i, argument)
    read (argument, *) n(i)
  end do
  call get_command_argument(4, argument)
  read (argument, *) steps
  call get_command_argument(5, argument)
  read (argument, *) p%resolution%process_rows
  call world%start()
  p = vortex_ring(n)
  call fluid%init(world, p, .false., failure)
  call fluid%start(failure)
  do i = 1, WARM_UP
    call fluid%step(request, failure)
  end do
  fluid%transform%traffic%bytes = 0
  fluid%transform%traffic%messages = 0
  fluid%transform%traffic%seconds = 0
  allocate (walls(steps))
  call cpu_time(cpu)
  do i = 1, steps
    call world%barrier()
    walls(i) = wall_seconds()
    call fluid%step(request, failure)
    walls(i) = wall_seconds() - walls(i)
  end do
  call cpu_time(now)
  call world%max_reals(walls)
  if (failure%failed) error stop 'bench_scaling: the flow has failed'
  sums = (now - cpu)/steps
  call world%sum_reals(sums)
  largest = [fluid%transform%traffic%seconds/steps, real(peak_memory(), rp)]
  call world%max_reals(largest)
  bytes = world%sum_int8(fluid%transform%traffic%bytes)/steps
  messages = world%sum_int8(fluid%transform%traffic%messages)/steps
  if (world%is_root) write (output_unit, '(3(a,i0),3(a,i0),6a,2(a,i0),2a)') '{"grid":[', n(1), ',', n(2), ',', n(3), &
    '],"ranks":', world%size, ',"rows":', fluid%transform%rows, ',"steps":', steps, &
    ',"cpu_ms":', number(1e3_rp*sums(1)), ',"wall_ms":', number(1e3_rp*median(walls)), &
    ',"exchange_ms":', number(1e3_rp*largest(1)), ',"bytes":', bytes, ',"messages":', messages, &
    ',"peak_mb_per_rank":', number(largest(2)/1e6_rp)//'}'
  call fluid%free()
  call world%stop()

contains

  !> Returns the median; for an even number of values it is the lower one of the two in the middle.
  pure real(rp) function median(x) result(middle)
    real(rp), intent(in) :: x(:)
    integer :: i
    middle = x(1)
    do i = 1, size(x)
      if (count(x < x(i)) < (size(x) + 1)/2 .and. count(x <= x(i)) >= (size(x) + 1)/2) middle = x(i)
    end do
  end function median
end program bench_scaling

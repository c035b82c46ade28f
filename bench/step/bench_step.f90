! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures the time of AB2 steps of a vortex ring on N^3 points and compares it with the least possible time (bench_floor),
!> measured in the same minute. Prints one JSON object on its last line. It is called through bench/step/run.
program bench_step
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use bench_floor, only: floor_seconds
  use bench_json, only: number
  use bench_ring, only: vortex_ring
  use fluid_params, only: fluid_params_t
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fluid_sponge_keys, only: SPONGE_CAVITY
  use parallel_world, only: world_t
  implicit none
  type(world_t) :: world
  type(fluid_params_t) :: p
  type(fluid_t) :: fluid
  type(request_t) :: request
  type(failure_t) :: failure
  character(32) :: argument
  real(rp) :: times(4), begun_cpu, begun_wall, now, best_floor
  integer :: n, steps, i, n_out

  call get_command_argument(1, argument)
  read (argument, *) n
  call get_command_argument(2, argument)
  read (argument, *) steps
  call get_command_argument(4, argument)
  request%pressure = argument == 'pressure'
  call get_command_argument(3, argument)
  call world%start()
  p = vortex_ring([n, n, n])
  p%sponge%is_on = argument == 'sponge'
  p%sponge%kind = SPONGE_CAVITY
  p%sponge%damping_time = 0.05_rp
  p%sponge%thickness = max(2, n/16)
  n_out = merge(6, 3, p%sponge%is_on) + merge(1, 0, request%pressure)
  call fluid%init(world, p, .false., failure, keeps_pressure=request%pressure)
  call fluid%start(failure)
  do i = 1, 2
    call fluid%step(request, failure)
  end do
  best_floor = floor_seconds(fluid%transform, 6, n_out)
  call world%barrier()
  begun_wall = wall_seconds()
  call cpu_time(begun_cpu)
  do i = 1, steps
    call fluid%step(request, failure)
  end do
  call cpu_time(now)
  times(1) = (now - begun_cpu)/steps
  call world%barrier()
  times(2) = (wall_seconds() - begun_wall)/steps/world%size
  times(3) = (best_floor + floor_seconds(fluid%transform, 6, n_out))/2
  times(4) = fluid%memory_bytes()/8/real(n, rp)**3
  call world%sum_reals(times)
  if (world%is_root) then
    write (output_unit, '(a,i0,a,i0,a,f0.3,a)') 'vortex ring on ', n, '^3 points, ', world%size, ' ranks, ', &
      times(4), ' doubles per grid point'
    write (output_unit, '(a,i0,a,i0,8a)') '{"grid":', n, ',"ranks":', world%size, ',"cpu_ms_per_step":', &
      number(1e3_rp*times(1)), ',"wall_ms_per_step":', number(1e3_rp*times(2)), ',"floor_ms":', &
      number(1e3_rp*times(3)), ',"ratio_to_floor":', number(times(1)/times(3))//'}'
  end if
  call fluid%free()
  call world%stop()

contains
end program bench_step

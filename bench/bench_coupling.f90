! SPDX-License-Identifier: GPL-3.0-or-later
!> Times the parts of coupled steps of a run with flexible wings, after some steps that begin it; every other step is
!> one of the fluid alone, to compare with. Prints one JSON object on its last line. Called through bench/coupling.
!>
!> mask: placing and drawing the wings. load: what the pass takes longer if it keeps the pressure, its inverse
!> transform and the sampling. solid: all wings over the step. The rest of the step is the fluid. Every part is the
!> least over the steps of the CPU time of the slowest rank.
program bench_coupling
  use, intrinsic :: iso_fortran_env, only: output_unit
  use app_settings, only: load_settings, settings_t
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use bench_floor, only: floor_seconds
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use io_shared_text, only: read_shared_text
  use parallel_world, only: world_t
  implicit none
  integer, parameter :: PLAIN = 1, KEEPING = 2, MASK = 3, LOOK = 4, SOLID = 5, FACTORS = 6
  type(world_t) :: world
  type(settings_t) :: settings
  type(fluid_t) :: fluid
  type(flapping_wings_t) :: wings
  type(coupler_t) :: coupler
  type(message_list_t) :: errors, notices
  type(failure_t) :: failure
  character(:), allocatable :: text, problem
  character(256) :: argument
  real(rp), allocatable :: times(:, :)
  real(rp) :: least
  integer :: begin_with, steps, i

  call world%start()
  call get_command_argument(2, argument)
  read (argument, *) begin_with
  call get_command_argument(3, argument)
  read (argument, *) steps
  call get_command_argument(1, argument)
  call read_shared_text(trim(argument), text, problem, world)
  if (allocated(problem)) error stop 'bench_coupling: the input file cannot be read'
  call load_settings(text, trim(argument), .false., settings, errors, notices, world)
  if (errors%count() > 0 .or. .not. settings%flexible) error stop 'bench_coupling: flexible wings are expected'
  call fluid%init(world, settings%fluid, settings%coupler%needs_fields(), failure, .true., &
                  settings%coupler%needs_trials())
  call wings%init(settings%flight, settings%fluid%grid, fluid%transform%block)
  call coupler%init(world, settings%coupler, settings%fluid%grid, fluid%transform%block, 0.0_rp, wings)
  call fluid%start(failure)
  call wings%place(0.0_rp, fluid%rhs%penalty, failure)
  allocate (times(6, steps))
  do i = 1, begin_with
    call one_step(times(:, 1))
  end do
  do i = 1, steps
    call one_step(times(:, i))
  end do
  least = floor_seconds(fluid%transform, 6, merge(6, 3, settings%fluid%sponge))
  if (failure%failed) error stop 'bench_coupling: the flow has failed'
  call report()
  call coupler%free()
  call fluid%free()
  call world%stop()

contains

  !> Two steps of the fluid alone and two that keep the pressure, the last of which is coupled, in parts.
  subroutine one_step(t)
    real(rp), intent(out) :: t(:)
    type(request_t) :: nothing, pressure
    real(rp) :: pass
    integer :: w
    pressure%pressure = .true.
    t = 0
    t(PLAIN) = huge(1.0_rp)
    t(KEEPING) = huge(1.0_rp)
    do w = 1, 2
      call fluid_step(nothing, pass, t(MASK))
      t(PLAIN) = min(t(PLAIN), pass)
      call fluid_step(pressure, pass, t(MASK))
      t(KEEPING) = min(t(KEEPING), pass)
    end do
    call start_watch(t(LOOK))
    call coupler%look(fluid, wings)
    call stop_watch(t(LOOK))
    call start_watch(t(SOLID))
    call coupler%advance(fluid%dt, wings, failure)
    call stop_watch(t(SOLID))
    do w = 1, size(coupler%wings)
if (coupler%wings(w)%owner == world%rank) t(FACTORS) = max(t(FACTORS), real(coupler%wings(w)%report%factorisations, rp))
    end do
    call world%max_reals(t)
  end subroutine one_step

  !> A step of the fluid without the wings' placing and drawing, which are `mask`.
  subroutine fluid_step(request, pass, mask)
    type(request_t), intent(in) :: request
    real(rp), intent(out) :: pass, mask
    call start_watch(mask)
    call wings%place(fluid%rhs%state%time, fluid%rhs%penalty, failure)
    call stop_watch(mask)
    call start_watch(pass)
    call fluid%step(request, failure, wings) ! which draws them once more
    call stop_watch(pass)
    pass = pass - mask
  end subroutine fluid_step

  subroutine start_watch(begun)
    real(rp), intent(out) :: begun
    call world%barrier()
    call cpu_time(begun)
  end subroutine start_watch

  subroutine stop_watch(begun)
    real(rp), intent(inout) :: begun
    real(rp) :: now
    call cpu_time(now)
    begun = now - begun
  end subroutine stop_watch

  subroutine report()
    real(rp) :: mask_time, load_time, solid_time, step_time, floor_time(1)
    floor_time = least
    call world%max_reals(floor_time)
    if (.not. world%is_root) return
    mask_time = minval(times(MASK, :))
    load_time = minval(times(LOOK, :)) + max(0.0_rp, minval(times(KEEPING, :)) - minval(times(PLAIN, :)))
    solid_time = minval(times(SOLID, :))
    step_time = minval(times(KEEPING, :)) + mask_time + minval(times(LOOK, :)) + solid_time
  write (output_unit, '(a,3(i0,1x),a,i0,a,i0,a)') 'flexible wings on ', settings%fluid%grid%n, 'points, ', world%size, &
      ' ranks, ', steps, ' steps'
 write (output_unit, '(a,5(f0.1,a))') 'a step takes ', 1e3_rp*step_time, ' ms: mask ', 1e3_rp*mask_time, ' ms, load ', &
      1e3_rp*load_time, ' ms (', 1e3_rp*minval(times(LOOK, :)), ' after the pass), solid ', 1e3_rp*solid_time, ' ms'
    write (output_unit, '(a,i0,a)') 'at most ', nint(maxval(times(FACTORS, :))), ' factorisations per wing and step'
    write (output_unit, '(a,f0.2,a)') 'the fluid takes ', minval(times(PLAIN, :))/floor_time(1), ' times its floor'
    write (output_unit, '(20a)') '{"coupling_share":', number((mask_time + load_time + solid_time)/step_time), &
      ',"mask":', number(mask_time/step_time), ',"load":', number(load_time/step_time), ',"solid":', &
      number(solid_time/step_time), ',"factorisations":', number(maxval(times(FACTORS, :))), ',"fluid_to_floor":', &
      number(minval(times(PLAIN, :))/floor_time(1))//'}'
  end subroutine report

  !> A number as JSON wants it: with a digit before the point.
  function number(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    character(20) :: buffer
    write (buffer, '(f20.4)') x
    text = trim(adjustl(buffer))
  end function number
end program bench_coupling

! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures the time of the parts of the coupled steps of a run with flexible wings, after some initial steps from rest or from a
!> backup of flusi. Prints one JSON object on its last line. It is called through bench/coupling/run.
!>
!> Parts for wings in the mask. mask: placing and drawing the wings. load: keeping the pressure in the pass of the fluid, finding
!> the lines on which it is needed, the inverse transform and the sampling. solid: moving all wings over the step. checks:
!> measuring the gaps between the wings and their distance to the sides of the box. Parts for wings without thickness. meet:
!> reading the flow at the markers. solid: moving all wings over the step. renew: computing the responses of the markers. push:
!> adding their forces to the flow. read: reading the slip afterwards, in the next pass of the fluid. Each part of a step is the
!> wall time of the slowest rank, measured where the work is done; the time of the step is the sum of the parts and of the rest of
!> the fluid's pass. The work of keeping the pressure is spread over the whole pass: its time is the difference between passes that
!> do it and passes that do not, measured in turns. Every number is the median over the steps.
program bench_coupling
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use bench_floor, only: floor_seconds
  use bench_json, only: number
  use fluid_requests, only: request_t
  use fluid_restart, only: load_fluid
  use fluid_solver, only: fluid_t
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_restart, only: load_wings
  use fsi_thin_restart, only: load_thin_wings
  use fsi_thin_wings, only: thin_wings_t
  use io_broadcast_text, only: read_broadcast_text
  use io_checkpoint, only: checkpoint_reader_t
  use parallel_world, only: world_t
  use fsi_flight_faults, only: check_flight
  use simulation_settings, only: load_settings, settings_t
  implicit none
  integer, parameter :: FLOW = 1, MASK = 2, LOOK = 3, SOLID = 4, CHECKS = 5, WAIT = 6, SOLVE = 7, FACTORS = 8, &
                        MEET = 9, RENEW = 10, PUSH = 11, READ = 12
  type(world_t) :: world
  type(settings_t) :: settings
  type(fluid_t) :: fluid
  type(flapping_wings_t) :: wings
  type(coupler_t) :: coupler
  type(thin_wings_t) :: thin
  type(message_list_t) :: errors, notices
  type(failure_t) :: failure
  type(checkpoint_reader_t) :: backup
  character(:), allocatable :: text, problem
  character(256) :: argument
  real(rp), allocatable :: times(:, :)
  real(rp) :: least(1), keep
  real(rp) :: differences(3) = 0 !< of the flow at the markers; slip sampled and read; over the largest speed
  integer :: begin_with, steps, i

  call world%start()
  call get_command_argument(2, argument)
  read (argument, *) begin_with
  call get_command_argument(3, argument)
  read (argument, *) steps
  call get_command_argument(1, argument)
  call read_broadcast_text(trim(argument), text, problem, world)
  if (allocated(problem)) error stop 'bench_coupling: the input file cannot be read'
  call load_settings(text, trim(argument), .false., settings, errors, notices, world)
  if (errors%count() > 0 .or. .not. settings%flexible) error stop 'bench_coupling: flexible wings are expected'
  call fluid%init(world, settings%fluid, settings%needs_fields(), failure, settings%needs_pressure(), &
                  settings%needs_trials())
  call wings%init(settings%flight, settings%fluid%grid, fluid%transform%block)
  call coupler%init(world, settings%coupler, fluid, 0.0_rp, wings)
  if (coupler%is_thin) then
    call thin%init(world, wings, fluid, failure)
    call thin%init_flexible(settings%coupler%model%points, settings%coupler%units)
  end if
  if (command_argument_count() > 3) then
    call get_command_argument(4, argument)
    call backup%open(world, trim(argument), failure)
    call load_fluid(backup, settings%fluid, fluid%transform%sticks, fluid%rhs%state, failure)
    if (.not. failure%failed) call load_wings(backup, wings, coupler, failure)
    if (coupler%is_thin .and. .not. failure%failed) call load_thin_wings(backup, wings, thin, failure)
    call backup%close(failure)
    if (failure%failed) then
      if (world%is_root) write (output_unit, '(a)') 'bench_coupling: '//failure%reason
      error stop
    end if
  else
    call fluid%start(failure)
  end if
  allocate (times(12, steps))
  do i = 1, begin_with
    call one_step(times(:, 1))
  end do
  do i = 1, steps
    call one_step(times(:, i))
  end do
  if (coupler%is_thin) call compare_slips()
  keep = 0
  if (.not. coupler%is_thin) keep = keeping_seconds()
  least = floor_seconds(fluid%transform, 6, merge(6, 3, settings%fluid%sponge%is_on))
  call world%max_reals(least)
  if (failure%failed) error stop 'bench_coupling: the flow has failed'
  if (world%is_root .and. coupler%is_thin) call report_thin()
  if (world%is_root .and. .not. coupler%is_thin) call report()
  call coupler%free()
  call fluid%free()
  call world%stop()

contains

  !> Makes one coupled step as flusi does, and measures its parts.
  subroutine one_step(t)
    real(rp), intent(out) :: t(:)
    type(request_t) :: request
    real(rp) :: own(1)
    logical :: is_new
    integer :: w
    t = 0
    call coupler%add_request(request)
    t(MASK) = -wings%seconds
    t(READ) = -fluid%rhs%reader%seconds
    call start_watch(t(FLOW))
    call fluid%step(request, failure, wings, coupler%trial)
    if (coupler%is_thin) call thin%read_slip(fluid, is_new)
    call stop_watch(t(FLOW))
    t(MASK) = t(MASK) + wings%seconds
    t(READ) = t(READ) + fluid%rhs%reader%seconds
    call start_watch(t(LOOK))
    call coupler%sample_load(fluid, wings)
    call stop_watch(t(LOOK))
    call start_watch(t(CHECKS))
    call check_flight(wings, settings%fluid%grid, failure)
    call stop_watch(t(CHECKS))
    own = -coupler%solver_seconds
    t([MEET, RENEW, PUSH]) = -[thin%seconds%sampling, thin%seconds%responses, thin%seconds%forces]
    call start_watch(t(SOLID))
    call coupler%advance(fluid%dt, wings, failure, fluid, thin)
    call stop_watch(t(SOLID))
    own = own + coupler%solver_seconds
    t([MEET, RENEW, PUSH]) = t([MEET, RENEW, PUSH]) + [thin%seconds%sampling, thin%seconds%responses, thin%seconds%forces]
    t(WAIT) = -own(1)
    call world%max_reals(own)
    t(WAIT) = own(1) + t(WAIT)
    t(SOLVE) = own(1)
    do w = 1, size(coupler%wings)
      t(FACTORS) = max(t(FACTORS), real(coupler%wings(w)%factorisations, rp))
    end do
    call world%max_reals(t)
  end subroutine one_step

  !> Makes three more steps, and compares the flow at the markers that the next pass reads with the flow that is sampled there.
  subroutine compare_slips()
    real(rp) :: t(size(times, 1)), sampled(3, size(thin%x, 2))
    integer :: i
    logical :: is_new
    type(request_t) :: request
    if (.not. fluid%rhs%reader%is_possible) return
    do i = 1, 3
      call one_step(t)
      if (.not. thin%slip%is_due) cycle
      call fluid%velocities_at_points(sampled)
      call fluid%evaluate(request, failure, wings)
      call thin%read_slip(fluid, is_new)
      differences(1) = max(differences(1), sqrt(maxval(sum((fluid%rhs%reader%velocities - sampled)**2, 1)))/thin%slip%speed)
      differences(3) = thin%slip%after/thin%slip%speed
      call thin%sample_slip(fluid)
      differences(2) = thin%slip%after/thin%slip%speed
    end do
  end subroutine compare_slips

  !> Measures how much longer a pass takes that keeps the pressure; the flow does not change.
  real(rp) function keeping_seconds() result(seconds)
    type(request_t) :: request
    real(rp) :: passes(steps, 2)
    integer :: i, k
    do i = 1, steps
      do k = 1, 2
        request%pressure = k == 2
        call start_watch(passes(i, k))
        call fluid%evaluate(request, failure, wings)
        call stop_watch(passes(i, k))
        call world%max_reals(passes(i, k:k))
      end do
    end do
    seconds = median(passes(:, 2)) - median(passes(:, 1))
  end function keeping_seconds

  subroutine start_watch(begun)
    real(rp), intent(out) :: begun
    call world%barrier()
    begun = wall_seconds()
  end subroutine start_watch

  subroutine stop_watch(begun)
    real(rp), intent(inout) :: begun
    begun = wall_seconds() - begun
  end subroutine stop_watch

  subroutine report()
    real(rp), parameter :: MS = 1.0e3_rp
    real(rp), dimension(size(times, 2)) :: step, load, mask_time, fraction
    real(rp) :: ratio
    step = times(FLOW, :) + times(LOOK, :) + times(SOLID, :) + times(CHECKS, :)
    load = keep + times(LOOK, :)
    mask_time = times(MASK, :)
    fraction = (mask_time + load + times(SOLID, :) + times(CHECKS, :))/step
    ratio = median(times(FLOW, :) - mask_time - keep)/least(1)
    write (output_unit, '(a,3(i0,1x),a,i0,a,i0,a,f0.4)') 'flexible wings on ', settings%fluid%grid%n, 'points, ', &
      world%size, ' ranks, ', steps, ' steps until t = ', fluid%rhs%state%time
    write (output_unit, '(a,4(f0.1,a))') 'a step takes ', MS*median(step), ' ms: mask ', MS*median(mask_time), &
      ' ms, load ', MS*median(load), ' ms, solid ', MS*median(times(SOLID, :)), ' ms'
    write (output_unit, '(a,3(f0.2,a))') 'of the load, keeping the pressure takes ', MS*keep, &
      ' ms, finding the lines, transform and sampling ', MS*median(times(LOOK, :)), ' ms; checks take ', &
      MS*median(times(CHECKS, :)), ' ms'
    write (output_unit, '(2(a,f0.2),a)') 'solving a wing takes ', MS*median(times(SOLVE, :)), &
      ' ms of that; a rank waits at most ', MS*median(times(WAIT, :)), ' ms for the wing of another'
    write (output_unit, '(a,i0,a,f0.2)') 'at most ', nint(maxval(times(FACTORS, :))), &
      ' factorisations per wing and step, on average ', sum(times(FACTORS, :))/steps
    write (output_unit, '(a,f0.2,a)') 'the fluid takes ', ratio, ' times its floor'
    write (output_unit, '(a,2(f0.4,a))') 'the share of a step is between ', quantile(fraction, 0.1_rp), ' and ', &
      quantile(fraction, 0.9_rp), ' (first and last decile)'
    write (output_unit, '(20a)') '{"coupling_share":', number(median(fraction)), &
      ',"mask":', number(median(mask_time/step)), ',"load":', number(median(load/step)), &
      ',"solid":', number(median(times(SOLID, :)/step)), ',"checks":', number(median(times(CHECKS, :)/step)), &
      ',"keep":', number(median(keep/step)), ',"wait":', number(median(times(WAIT, :)/step)), &
      ',"factorisations":', number(maxval(times(FACTORS, :))), ',"fluid_to_floor":', number(ratio), '}'
  end subroutine report

  !> Measures a step with wings without thickness, its parts, and its ratio to a step of the fluid alone.
  subroutine report_thin()
    real(rp), parameter :: MS = 1.0e3_rp
    real(rp), dimension(size(times, 2)) :: step, bending
    real(rp) :: alone, points
    integer :: n
    step = times(FLOW, :) + times(LOOK, :) + times(SOLID, :) + times(CHECKS, :)
    bending = times(SOLID, :) - times(MEET, :) - times(RENEW, :) - times(PUSH, :)
    alone = median(times(FLOW, :) - times(MASK, :) - times(READ, :))
    n = size(thin%x, 2)
    points = product(real(settings%fluid%grid%n, rp))
    write (output_unit, '(a,3(i0,1x),3(a,i0),a,f0.4)') 'flexible wings without thickness on ', settings%fluid%grid%n, &
      'points, ', world%size, ' ranks, ', n, ' markers, ', steps, ' steps until t = ', fluid%rhs%state%time
    write (output_unit, '(a,7(f0.1,a))') 'a step takes ', MS*median(step), ' ms: fluid ', MS*alone, ' ms, meet ', &
      MS*median(times(MEET, :)), ' ms, solid ', MS*median(bending), ' ms, renew ', MS*sum(times(RENEW, :))/steps, &
      ' ms (mean), push ', MS*sum(times(PUSH, :))/steps, &
      ' ms (mean), read ', MS*sum(times(READ, :))/steps, ' ms (mean)'
    write (output_unit, '(3(a,es8.1))') 'the flow that a pass reads at the markers differs by at most', differences(1), &
      ' of the largest wing speed from the sampled one; slip after a step', differences(2), ', read', differences(3)
    write (output_unit, '(a,i0,a,f0.2)') 'at most ', nint(maxval(times(FACTORS, :))), &
      ' factorisations per wing and step, on average ', sum(times(FACTORS, :))/steps
    write (output_unit, '(a,f0.2,a,f0.2,a)') 'the fluid takes ', alone/least(1), ' times its floor; responses take ', &
      thin%memory_bytes()/8/points, ' doubles per point of the grid on rank 0'
    write (output_unit, '(22a)') '{"step_to_fluid":', number(sum(step)/steps/alone), ',"meet":', &
      number(median(times(MEET, :))/alone), ',"solid":', number(median(bending)/alone), ',"renew":', &
      number(sum(times(RENEW, :))/steps/alone), ',"push":', number(sum(times(PUSH, :))/steps/alone), ',"read":', &
      number(sum(times(READ, :))/steps/alone), ',"solid_ms":', number(MS*median(bending)), ',"markers":', &
      number(real(n, rp)), ',"fluid_to_floor":', number(alone/least(1)), '}'
  end subroutine report_thin

  pure real(rp) function median(x)
    real(rp), intent(in) :: x(:)
    median = quantile(x, 0.5_rp)
  end function median

  !> Returns the quantile of `x`: the value below which the given part of it lies.
  pure real(rp) function quantile(x, part)
    real(rp), intent(in) :: x(:), part
    integer :: i, rank
    rank = max(1, ceiling(part*size(x)))
    quantile = 0
    do i = 1, size(x)
      if (count(x < x(i)) < rank .and. count(x <= x(i)) >= rank) quantile = x(i)
    end do
  end function quantile
end program bench_coupling

! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures the transforms of P3DFFT and the builtin ones, in turns in one process: whole fields forward and backward, and AB2
!> steps of a vortex ring on N^3 points. The times are CPU times, summed over the ranks; medians of the turns are printed.
!>
!> usage: bench_transform N TURNS
program bench_transform
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_named_kinds, only: kind_of
  use bench_ring, only: vortex_ring
  use fluid_params, only: fluid_params_t
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use parallel_world, only: world_t
  use spectral_backends, only: HAS_P3DFFT, TRANSFORMS
  implicit none
  character(8), parameter :: NAMES(2) = ['builtin', 'p3dfft ']
  integer, parameter :: FIELDS = 3
  type(world_t) :: world
  type(fluid_t) :: fluids(2)
  real(rp), allocatable :: transform_times(:, :), steps(:, :)
  integer :: n, turns, turn, i, repeats

  call read_arguments()
  call world%start()
  if (.not. HAS_P3DFFT) then
    if (world%is_root) write (error_unit, '(a)') 'this program was built without P3DFFT (docs/theory/transforms.md)'
    call world%stop()
    stop 2
  end if
  do i = 1, 2
    call make_ring(trim(NAMES(i)), fluids(i))
  end do
  allocate (transform_times(2, turns), steps(2, turns))
  repeats = max(1, nint(2.0e7_rp/real(n, rp)**3))
  do turn = 1, turns
    do i = 1, 2
      transform_times(i, turn) = transform_seconds(fluids(i))
      steps(i, turn) = step_seconds(fluids(i))
    end do
  end do
  call report('one transform', transform_times)
  call report('one AB2 step', steps)
  do i = 1, 2
    call fluids(i)%free()
  end do
  call world%stop()

contains

  subroutine read_arguments()
    character(20) :: text
    call get_command_argument(1, text)
    read (text, *) n
    call get_command_argument(2, text)
    read (text, *) turns
  end subroutine read_arguments

  subroutine make_ring(name, fluid)
    character(*), intent(in) :: name
    type(fluid_t), intent(inout) :: fluid
    type(fluid_params_t) :: p
    type(failure_t) :: failure
    type(request_t) :: nothing
    integer :: step
    p = vortex_ring([n, n, n])
    p%resolution%transform = kind_of(TRANSFORMS, name)
    call fluid%init(world, p, .false., failure, keeps_pressure=.false.)
    if (.not. failure%failed) call fluid%start(failure)
    do step = 1, 2
      if (.not. failure%failed) call fluid%step(nothing, failure)
    end do
    if (failure%failed) then
      write (error_unit, '(a)') name//': '//failure%reason
      error stop
    end if
  end subroutine make_ring

  !> Returns the mean CPU seconds of a transform of one field, half of them forward, three fields at once, on all ranks together.
  real(rp) function transform_seconds(fluid) result(seconds)
    type(fluid_t), intent(inout) :: fluid
    real(rp), allocatable :: physical(:, :, :, :)
    complex(rp), allocatable :: spectral(:, :, :)
    integer :: k
    real(rp) :: begun
    associate (t => fluid%transform)
      allocate (physical(t%block%count(1), t%block%count(2), t%block%count(3), FIELDS))
      allocate (spectral(t%sticks%nkz, t%sticks%n, FIELDS))
      physical = 0.5_rp
      call t%forward(physical, spectral)
      begun = cpu()
      do k = 1, repeats
        call t%backward(spectral, physical)
        call t%forward(physical, spectral)
      end do
      seconds = (cpu() - begun)/(2*FIELDS*repeats)
    end associate
    seconds = summed(seconds)
  end function transform_seconds

  !> Returns the mean CPU seconds of a step, on all ranks together.
  real(rp) function step_seconds(fluid) result(seconds)
    type(fluid_t), intent(inout) :: fluid
    type(request_t) :: nothing
    type(failure_t) :: failure
    real(rp) :: begun
    integer :: k
    call fluid%step(nothing, failure)
    begun = cpu()
    do k = 1, repeats
      call fluid%step(nothing, failure)
    end do
    seconds = summed((cpu() - begun)/repeats)
  end function step_seconds

  real(rp) function summed(seconds)
    real(rp), intent(in) :: seconds
    real(rp) :: sums(1)
    sums = seconds
    call world%sum_reals(sums)
    summed = sums(1)
  end function summed

  real(rp) function cpu()
    call world%barrier()
    call cpu_time(cpu)
  end function cpu

  !> Prints the medians of both, and the median of their ratio in each turn.
  subroutine report(what, seconds)
    character(*), intent(in) :: what
    real(rp), intent(in) :: seconds(:, :)
    if (world%is_root) write (output_unit, '(a,i0,a,i0,2a,3(a,f0.2))') 'grid ', n, '^3, ranks ', world%size, ', ', what, &
      ' [ms]: builtin ', 1e3_rp*median(seconds(1, :)), ', p3dfft ', 1e3_rp*median(seconds(2, :)), ', ratio ', &
      median(seconds(2, :)/seconds(1, :))
  end subroutine report

  pure real(rp) function median(values)
    real(rp), intent(in) :: values(:)
    real(rp) :: sorted(size(values)), smallest
    integer :: k, at
    sorted = values
    do k = 1, size(values)
      at = k - 1 + minloc(sorted(k:), 1)
      smallest = sorted(at)
      sorted(at) = sorted(k)
      sorted(k) = smallest
    end do
    median = (sorted((size(values) + 1)/2) + sorted(size(values)/2 + 1))/2
  end function median
end program bench_transform

! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimates the least time that one AB2 step can cost on this machine now: the time of pruned one-dimensional FFTs and of
!> products at the rate they reach in the cache, plus the time of the memory traffic that cannot be avoided, at the rate of a
!> triad.
module bench_floor
  use, intrinsic :: iso_c_binding, only: c_ptr, c_size_t
  use base_kinds, only: rp
  use fluid_kernels, only: line_product
  use spectral_fftw, only: plan_t, plan_lines, plan_columns, plan_c2r, plan_r2c, execute_complex, execute_c2r, &
                           execute_r2c, free_plan, alloc_complex, alloc_real, free_buffer, effort_flag, PLAN_MEASURE
  use spectral_transform, only: transform_t
  implicit none
  private
  public :: floor_seconds

  real(rp), parameter :: PROBE_SECONDS = 0.15_rp !< a probe repeats for about this long

contains

  !> Returns the CPU seconds that one step needs for this rank's share, with n_in fields transformed backward and n_out forward.
  real(rp) function floor_seconds(transform, n_in, n_out) result(seconds)
    class(transform_t), intent(in) :: transform
    integer, intent(in) :: n_in, n_out
    integer, parameter :: BATCH = 8
    real(rp) :: lines, planes, sticks, points, modes, traffic, rate
    associate (n => transform%grid%n, s => transform%sticks, b => transform%block)
      lines = real(b%count(2), rp)*b%count(3)
      planes = b%count(3)
      sticks = s%n
      modes = sticks*s%nkz
      points = lines*n(1)
      seconds = lines*(n_in*line_time(n(1), .true.) + n_out*line_time(n(1), .false.)) + &
                planes*(n_in + n_out)*plane_time(s%n_row_kx, n(2)) + &
                sticks/BATCH*(n_in + n_out)*stick_time(n(3), BATCH) + points*product_time(n(1))
      ! State and history are read and written; every stick field between the passes is written (the
      ! line is fetched first) and read.
      traffic = 16*(modes*3*4 + sticks*n(3)*(n_in + n_out)*3)
      rate = triad_rate(int(max(1.0e6_rp, min(traffic/3/8, 4.0e7_rp))))
      seconds = seconds + traffic/rate
    end associate
  end function floor_seconds

  !> Measures the seconds of one x line, backward or forward, with a batch that stays in the L1 cache.
  real(rp) function line_time(n, backward) result(t)
    integer, intent(in) :: n
    logical, intent(in) :: backward
    integer :: batch, repeats
    type(plan_t) :: plan
    type(c_ptr) :: half_handle, line_handle
    complex(rp), pointer, contiguous :: half(:)
    real(rp), pointer, contiguous :: line(:), lines(:, :)
    real(rp) :: begun
    batch = max(1, 1500/n)
    call alloc_complex(int((n/2 + 1)*batch, c_size_t), half_handle, half)
    call alloc_real(int(n*batch, c_size_t), line_handle, line)
    lines(1:n, 1:batch) => line
    if (backward) then
      call plan_c2r(plan, n, batch, half, line, effort_flag(PLAN_MEASURE))
    else
      call plan_r2c(plan, n, batch, line, half, effort_flag(PLAN_MEASURE))
    end if
    half = 0
    line = 0
    repeats = 0
    begun = cpu()
    do while (cpu() - begun < PROBE_SECONDS)
      if (backward) then
        call execute_c2r(plan, half, lines)
      else
        call execute_r2c(plan, lines, half)
      end if
      repeats = repeats + 1
    end do
    t = (cpu() - begun)/repeats/batch
    call free_plan(plan)
    call free_buffer(half_handle)
    call free_buffer(line_handle)
  end function line_time

  !> Measures the seconds of the y transforms of one plane (n_kx, ny).
  real(rp) function plane_time(n_kx, ny) result(t)
    integer, intent(in) :: n_kx, ny
    type(plan_t) :: plan
    type(c_ptr) :: handle
    complex(rp), pointer, contiguous :: work(:)
    call alloc_complex(int(n_kx, c_size_t)*ny, handle, work)
    call plan_columns(plan, n_kx, ny, work, 1, effort_flag(PLAN_MEASURE))
    t = complex_time(plan, work)
    call free_plan(plan)
    call free_buffer(handle)
  end function plane_time

  !> Measures the seconds of the z transforms of a batch of sticks.
  real(rp) function stick_time(nz, batch) result(t)
    integer, intent(in) :: nz, batch
    type(plan_t) :: plan
    type(c_ptr) :: handle
    complex(rp), pointer, contiguous :: work(:)
    call alloc_complex(int(nz, c_size_t)*batch, handle, work)
    call plan_lines(plan, nz, batch, work, 1, effort_flag(PLAN_MEASURE))
    t = complex_time(plan, work)
    call free_plan(plan)
    call free_buffer(handle)
  end function stick_time

  real(rp) function complex_time(plan, work) result(t)
    type(plan_t), intent(in) :: plan
    complex(rp), contiguous, intent(inout) :: work(:)
    real(rp) :: begun
    integer :: repeats
    work = 0
    repeats = 0
    begun = cpu()
    do while (cpu() - begun < PROBE_SECONDS)
      call execute_complex(plan, work)
      repeats = repeats + 1
    end do
    t = (cpu() - begun)/repeats
  end function complex_time

  !> Measures the seconds per grid point of the product u x omega and its maximum, with data in the cache.
  real(rp) function product_time(n) result(t)
    integer, intent(in) :: n
    real(rp), allocatable :: f(:, :)
    real(rp) :: begun
    integer :: repeats
    allocate (f(n, 11))
    f = 0.5_rp
    repeats = 0
    begun = cpu()
    do while (cpu() - begun < PROBE_SECONDS)
      call line_product(n, f(:, 1), f(:, 2), f(:, 3), f(:, 4), f(:, 5), f(:, 6), f(:, 7), f(:, 8), f(:, 9), &
                        f(:, 10), f(:, 11))
      repeats = repeats + 1
    end do
    t = (cpu() - begun)/repeats/n
  end function product_time

  !> Measures the bytes per second of a(i) = b(i) + s c(i) on arrays of n reals; all three arrays are counted.
  real(rp) function triad_rate(n) result(rate)
    integer, intent(in) :: n
    real(rp), allocatable :: a(:), b(:), c(:)
    real(rp) :: begun
    integer :: repeats
    allocate (a(n), b(n), c(n))
    a = 1
    b = 2
    c = 3
    repeats = 0
    begun = cpu()
    do while (cpu() - begun < 2*PROBE_SECONDS .or. repeats < 2)
      a = b + (1 + 1.0e-9_rp*repeats)*c
      b(1) = a(n)
      repeats = repeats + 1
    end do
    rate = 24*real(n, rp)*repeats/(cpu() - begun)
  end function triad_rate

  real(rp) function cpu()
    call cpu_time(cpu)
  end function cpu
end module bench_floor

! SPDX-License-Identifier: GPL-3.0-or-later
!> Evaluations that CMA-ES needs beside those of a reference, and its own time per generation.
!>
!> usage: bench_optimiser REFERENCE.csv [SEEDS [LARGEST_N]]       defaults: 51 seeds, n up to 40
!>
!> Medians over seeds of the evaluations to f <= 1e-10, numbered in the order of asking: six functions at
!> the default lambda (n = 5, 10, 20, 40) and at n = 11, lambda = 64, with their ratios to the medians in
!> the reference (variant `active(default)` or `tutorial-active`); Rastrigin with IPOP; milliseconds of
!> ask and tell at n = 11, lambda = 64. The last line is a JSON object.
program bench_optimiser
  use base_kinds, only: rp, i8
  use bench_optimiser_runs, only: evaluations_to_target, ipop_evaluations, median_of, milliseconds_per_generation, &
                                  reference_median, NEVER
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  character(9), parameter :: NAMES(6) = [character(9) :: 'sphere', 'elli', 'rosen', 'cigar', 'discus', 'diffpow']
  integer, parameter :: SIZES(4) = [5, 10, 20, 40]
  integer, parameter :: BARS(6) = [6800, 10650, 16800, 0, 0, 0] ! of n = 11, lambda = 64; 0: none
  character(500) :: path, argument
  character(12) :: bar
  integer :: n_seeds, largest, i, j, lambda
  integer(i8), allocatable :: counts(:)
  real(rp) :: got, want, worst, at_64(6), success, ms

  call get_command_argument(1, path)
  n_seeds = 51
  largest = 40
  call get_command_argument(2, argument)
  if (len_trim(argument) > 0) read (argument, *) n_seeds
  call get_command_argument(3, argument)
  if (len_trim(argument) > 0) read (argument, *) largest
  allocate (counts(n_seeds))

  write (output_unit, '(a,i0,a)') '| function | n | lambda | median of ', n_seeds, &
    ' | quartiles | reached | reference | ratio | bar |'
  write (output_unit, '(a)') '|---|---|---|---|---|---|---|---|---|'
  worst = 0
  do i = 1, size(NAMES)
    do j = 1, size(SIZES)
      if (SIZES(j) > largest) cycle
      call evaluations_to_target(NAMES(i), SIZES(j), 0, counts, lambda)
      want = reference_median(path, 'active(default)', NAMES(i), SIZES(j), lambda)
      bar = ''
      call print_row(NAMES(i), SIZES(j))
      worst = max(worst, abs(got/want - 1))
    end do
  end do
  do i = 1, size(NAMES)
    call evaluations_to_target(NAMES(i), 11, 64, counts, lambda)
    want = reference_median(path, 'tutorial-active', NAMES(i), 11, lambda)
    bar = ''
    if (BARS(i) > 0) write (bar, '(i0)') BARS(i)
    call print_row(NAMES(i), 11)
    at_64(i) = got
  end do
  success = 1
  do j = 1, size(SIZES) - 1
    if (SIZES(j) > largest) cycle
    call ipop_evaluations(SIZES(j), counts, lambda)
    want = reference_median(path, 'IPOPx2 active', 'rastrigin', SIZES(j), lambda)
    write (bar, '(f4.2,a)') 1.5_rp, ' x'
    call print_row('rastrigin', SIZES(j))
    success = min(success, count(counts < NEVER)/real(n_seeds, rp))
  end do
  ms = milliseconds_per_generation(11, 64)
  write (output_unit, '(a,f7.4,a)') 'own time per generation, n = 11, lambda = 64: ', ms, ' ms'
  write (output_unit, '(a,i0,a,f6.3,3(a,f8.1),a,f5.3,a,f7.4,a)') '{"seeds": ', n_seeds, ', "worst_deviation": ', worst, &
    ', "sphere_64": ', at_64(1), ', "elli_64": ', at_64(2), ', "rosen_64": ', at_64(3), ', "rastrigin_success": ', &
    success, ', "ms_per_generation": ', ms, '}'

contains

  !> One line of the table, from counts, lambda, want and bar; `got` is the median of all runs.
  subroutine print_row(name, n)
    character(*), intent(in) :: name
    integer, intent(in) :: n
    got = median_of(counts, 0.5_rp)
    write (output_unit, '(3a,i0,a,i0,4(a,i0),2(a,i0),a,f5.3,3a)') '| ', trim(name), ' | ', n, ' | ', lambda, ' | ', &
      nint(got), ' | ', nint(median_of(counts, 0.25_rp)), ' to ', nint(median_of(counts, 0.75_rp)), ' | ', &
      count(counts < NEVER), '/', n_seeds, ' | ', nint(want), ' | ', got/want, ' | ', trim(bar), ' |'
    flush (output_unit)
  end subroutine print_row
end program bench_optimiser

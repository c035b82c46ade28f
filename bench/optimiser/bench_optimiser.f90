! SPDX-License-Identifier: GPL-3.0-or-later
!> Counts the evaluations that CMA-ES needs, compares them with those of a reference, and measures its own time per generation.
!>
!> usage: bench_optimiser REFERENCE.csv [SEEDS [LARGEST_N [PARTS]]]      defaults: 51 seeds, n up to 40, all parts
!>
!> Prints the medians over the seeds of the evaluations until f <= 1e-10, numbered in the order of asking, and their ratios to the
!> medians of the reference. The parts, separated by commas, are:
!>   active     six functions at the default lambda, n = 5, 10, 20, 40 (variant `active(default)`)
!>   positive   the same without negative weights, as far as the reference goes (`positive-only`)
!>   large      n = 11, lambda = 64 (`tutorial-active`)
!>   rastrigin  Rastrigin with IPOP
!>   time       milliseconds of ask and tell at n = 11, lambda = 64
!> The last line is a JSON object.
program bench_optimiser
  use base_kinds, only: rp, i8
  use bench_optimiser_runs, only: evaluations_to_target, ipop_evaluations, median_of, milliseconds_per_generation, &
                                  reference_median, NEVER, NO_REFERENCE
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  character(9), parameter :: NAMES(6) = [character(9) :: 'sphere', 'elli', 'rosen', 'cigar', 'discus', 'diffpow']
  integer, parameter :: SIZES(4) = [5, 10, 20, 40]
  integer, parameter :: BARS(6) = [6800, 10650, 16800, 0, 0, 0] ! of n = 11, lambda = 64; 0: none
  character(500) :: path, argument
  character(12) :: bar
  integer :: n_seeds, largest, i, j, lambda
  integer(i8), allocatable :: counts(:)
  real(rp) :: got, want, ms(2)
  character(:), allocatable :: parts, record

  call get_command_argument(1, path)
  n_seeds = 51
  largest = 40
  call get_command_argument(2, argument)
  if (len_trim(argument) > 0) read (argument, *) n_seeds
  call get_command_argument(3, argument)
  if (len_trim(argument) > 0) read (argument, *) largest
  call get_command_argument(4, argument)
  parts = ','//trim(argument)//','
  if (argument == '' .or. argument == 'all') parts = ',active,positive,large,rastrigin,time,'
  allocate (counts(n_seeds))

  write (output_unit, '(a,i0,a)') '| function | n | lambda | median of ', n_seeds, &
    ' | quartiles | reached | reference | ratio | bar |'
  write (output_unit, '(a)') '|---|---|---|---|---|---|---|---|---|'
  record = ''
  bar = ''
  if (index(parts, ',active,') > 0) call compare('active', 'active(default)')
  if (index(parts, ',positive,') > 0) call compare('positive', 'positive-only')
  if (index(parts, ',large,') > 0) call run_large()
  if (index(parts, ',rastrigin,') > 0) call run_rastrigin()
  if (index(parts, ',time,') > 0) then
    ms = milliseconds_per_generation(11, 64)
    write (output_unit, '(a,f7.4,a,f7.4,a)') 'own time per generation, n = 11, lambda = 64: median ', ms(1), &
      ' ms, fastest twentieth ', ms(2), ' ms'
    call add_to_record('ms_per_generation', ms(1), '(f7.4)')
    call add_to_record('ms_fastest_twentieth', ms(2), '(f7.4)')
  end if
  write (output_unit, '(a,i0,2a)') '{"seeds": ', n_seeds, record, '}'

contains

  !> Runs all functions at the default lambda.
  subroutine compare(weights, variant)
    character(*), intent(in) :: weights, variant
    real(rp) :: worst
    worst = 0
    do i = 1, size(NAMES)
      do j = 1, size(SIZES)
        if (SIZES(j) > largest) cycle
        ! Its default lambda is 4 + floor(3 ln n).
        want = reference_median(path, variant, NAMES(i), SIZES(j), 4 + floor(3*log(real(SIZES(j), rp))))
        if (want <= NO_REFERENCE) cycle
        call evaluations_to_target(NAMES(i), SIZES(j), 0, weights, counts, lambda)
        call print_row(trim(NAMES(i))//trim(merge(', positive', '          ', weights == 'positive')), SIZES(j))
        worst = max(worst, abs(got/want - 1))
      end do
    end do
    call add_to_record('worst_deviation_'//weights, worst, '(f6.3)')
  end subroutine compare

  subroutine run_large()
    do i = 1, size(NAMES)
      call evaluations_to_target(NAMES(i), 11, 64, 'active', counts, lambda)
      want = reference_median(path, 'tutorial-active', NAMES(i), 11, lambda)
      bar = ''
      if (BARS(i) > 0) write (bar, '(i0)') BARS(i)
      call print_row(trim(NAMES(i)), 11)
      if (BARS(i) > 0) call add_to_record(trim(NAMES(i))//'_64', got, '(f8.1)')
    end do
  end subroutine run_large

  subroutine run_rastrigin()
    real(rp) :: success
    success = 1
    do j = 1, size(SIZES)
      if (SIZES(j) > largest) cycle
      call ipop_evaluations(SIZES(j), counts, lambda)
      want = reference_median(path, 'IPOPx2 active', 'rastrigin', SIZES(j), lambda)
      write (bar, '(f4.2,a)') 1.5_rp, ' x'
      call print_row('rastrigin', SIZES(j))
      success = min(success, count(counts < NEVER)/real(n_seeds, rp))
    end do
    call add_to_record('rastrigin_success', success, '(f5.3)')
  end subroutine run_rastrigin

  subroutine add_to_record(key, value, form)
    character(*), intent(in) :: key, form
    real(rp), intent(in) :: value
    character(20) :: text
    write (text, form) value
    record = record//', "'//key//'": '//trim(adjustl(text))
  end subroutine add_to_record

  !> Prints one line of the table from counts, lambda, want and bar; `got` is the median of all runs.
  subroutine print_row(name, n)
    character(*), intent(in) :: name
    integer, intent(in) :: n
    got = median_of(counts, 0.5_rp)
    write (output_unit, '(3a,i0,a,i0,4(a,i0),2(a,i0),a,f5.3,3a)') '| ', name, ' | ', n, ' | ', lambda, ' | ', &
      nint(got), ' | ', nint(median_of(counts, 0.25_rp)), ' to ', nint(median_of(counts, 0.75_rp)), ' | ', &
      count(counts < NEVER), '/', n_seeds, ' | ', nint(want), ' | ', got/want, ' | ', trim(bar), ' |'
    flush (output_unit)
  end subroutine print_row
end program bench_optimiser

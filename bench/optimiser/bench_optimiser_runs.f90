! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the runs of bench_optimiser and reads the table that they are compared with.
module bench_optimiser_runs
  use base_errors, only: require
  use base_kinds, only: rp, i8
  use base_named_kinds, only: kind_of
  use cmaes_optimiser, only: cmaes_t
  use cmaes_options, only: cmaes_options_t, WEIGHTINGS
  use cmaes_params, only: derive_params
  use cmaes_ranking, only: sort_values
  use cmaes_search, only: cmaes_search_t, start_region_t, RESTARTS_IPOP
  use cmaes_stop, only: RUNNING
  use search_functions, only: value_of
  implicit none
  private
  public :: evaluations_to_target, ipop_evaluations, median_of, milliseconds_per_generation, reference_median, NEVER, NO_REFERENCE

  real(rp), parameter :: NO_REFERENCE = 0 !< stands for a value that the table does not have
  integer(i8), parameter :: NEVER = 1000000000_i8 !< stands for a target that was not reached
  real(rp), parameter :: target = 1.0e-10_rp

contains

  !> Counts the evaluations to the target: counts(s) belongs to seed 1000 + s. lambda 0 means the default, which is returned.
  !> Start and step are those of the reference; only numerical criteria stop a run.
  subroutine evaluations_to_target(name, n, population, weights, counts, lambda)
    character(*), intent(in) :: name, weights
    integer, intent(in) :: n, population
    integer(i8), intent(out) :: counts(:)
    integer, intent(out) :: lambda
    type(cmaes_options_t) :: options
    type(cmaes_t) :: run
    real(rp), allocatable :: x(:, :), f(:), mean(:)
    integer :: s, k
    options%lambda = population
    options%weights = kind_of(WEIGHTINGS, weights)
    options%sigma0 = merge(0.5_rp, 1.0_rp, name == 'rosen')
    options%f_target = target
    options%tolfun = 0
    options%tolfunhist = 0
    options%tolx = 0
    options%max_iterations = 100000
    options%tolstagnation = 2000
    allocate (mean(n))
    mean = merge(0.0_rp, 1.0_rp, name == 'rosen')
    do s = 1, size(counts)
      options%seed = 1000 + s
      call run%start(options, derive_params(options, n), mean, has_box=.false.)
      lambda = run%params%lambda
      if (.not. allocated(x)) allocate (x(n, lambda), f(lambda))
      do while (run%state%stop_code == RUNNING)
        call run%ask(x)
        do k = 1, lambda
          f(k) = value_of(name, x(:, k))
        end do
        call run%tell(f)
        if (any(f <= target)) exit
      end do
      counts(s) = NEVER
      if (any(f <= target)) counts(s) = run%state%counts%evaluations - lambda + findloc_first(f)
    end do
  end subroutine evaluations_to_target

  pure integer function findloc_first(f) result(k)
    real(rp), intent(in) :: f(:)
    do k = 1, size(f)
      if (f(k) <= target) return
    end do
  end function findloc_first

  !> Does the same for Rastrigin's function with IPOP: it starts in [-5, 5]^n with sigma0 = 2, has the reference's tolerances of
  !> f, and makes at most 3e6 evaluations.
  subroutine ipop_evaluations(n, counts, lambda)
    integer, intent(in) :: n
    integer(i8), intent(out) :: counts(:)
    integer, intent(out) :: lambda
    type(cmaes_options_t) :: options
    type(cmaes_search_t) :: search
    type(start_region_t) :: region
    real(rp), allocatable :: x(:, :), f(:)
    integer :: s, k
    options%sigma0 = 2
    options%f_target = target
    options%f_scale = 1
    options%tolfun = 1.0e-12_rp
    options%tolfunhist = 1.0e-12_rp
    options%max_evaluations = 3000000
    allocate (region%lower(n), region%upper(n))
    region%lower = -5
    region%upper = 5
    do s = 1, size(counts)
      options%seed = 1000 + s
      call search%start(options, RESTARTS_IPOP, 20, region)
      if (s == 1) lambda = search%state%lambda
      counts(s) = NEVER
      do while (search%state%stop_code == RUNNING)
        call search%ask(x)
        if (.not. allocated(f)) allocate (f(size(x, 2)))
        if (size(f) < size(x, 2)) then
          deallocate (f)
          allocate (f(size(x, 2)))
        end if
        do k = 1, size(x, 2)
          f(k) = value_of('rastrigin', x(:, k))
          if (f(k) <= target .and. counts(s) == NEVER) counts(s) = search%evaluations() + k
        end do
        call search%tell(f(:size(x, 2)))
      end do
    end do
  end subroutine ipop_evaluations

  !> Returns a quantile by the nearest rank.
  real(rp) function median_of(counts, fraction) result(value)
    integer(i8), intent(in) :: counts(:)
    real(rp), intent(in) :: fraction
    real(rp) :: values(size(counts))
    values = real(counts, rp)
    call sort_values(values)
    value = values(1 + nint(fraction*(size(counts) - 1)))
  end function median_of

  !> Measures the time of ask and tell on the ellipsoid without the evaluations: the median of 2000 generations, and the time that
  !> the fastest twentieth of them did not exceed, which is less disturbed by other load on the machine.
  function milliseconds_per_generation(n, lambda) result(ms)
    integer, intent(in) :: n, lambda
    real(rp) :: ms(2)
    integer, parameter :: N_RUNS = 10, N_GENERATIONS = 200
    type(cmaes_options_t) :: options
    type(cmaes_t) :: run
    real(rp), allocatable :: x(:, :), f(:), mean(:)
    integer(i8) :: ticks(N_RUNS*N_GENERATIONS), begun, asked, ended, rate
    integer :: s, g, k
    options%lambda = lambda
    options%tolfun = 0
    options%tolfunhist = 0
    options%tolx = 0
    allocate (x(n, lambda), f(lambda), mean(n))
    mean = 1
    do s = 1, N_RUNS
      options%seed = s
      call run%start(options, derive_params(options, n), mean, has_box=.false.)
      do g = 1, N_GENERATIONS
        call system_clock(begun, rate)
        call run%ask(x)
        call system_clock(asked)
        ticks((s - 1)*N_GENERATIONS + g) = asked - begun
        do k = 1, lambda
          f(k) = value_of('elli', x(:, k))
        end do
        call system_clock(begun)
        call run%tell(f)
        call system_clock(ended)
        ticks((s - 1)*N_GENERATIONS + g) = ticks((s - 1)*N_GENERATIONS + g) + ended - begun
      end do
      call require(run%state%generation == N_GENERATIONS, 'a run that goes on')
    end do
    ms = 1.0e3_rp*[median_of(ticks, 0.5_rp), median_of(ticks, 0.05_rp)]/rate
  end function milliseconds_per_generation

  !> Returns the median of a variant at the target 1e-10, or NO_REFERENCE if the table has none.
  real(rp) function reference_median(path, variant, name, n, lambda) result(value)
    character(*), intent(in) :: path, variant, name
    integer, intent(in) :: n, lambda
    character(300) :: line, key
    integer :: unit, state, comma, i
    value = NO_REFERENCE
    write (key, '(4a,i0,a,i0,a)') trim(variant), ',', trim(name), ',', n, ',', lambda, ','
    open (newunit=unit, file=trim(path), status='old', action='read', iostat=state)
    call require(state == 0, 'a readable table of reference medians')
    do
      read (unit, '(a)', iostat=state) line
      if (state /= 0) exit
      if (index(line, trim(key)) /= 1 .or. index(line, ',1e-10,') == 0) cycle
      comma = index(line, ',1e-10,') + len(',1e-10,') - 1
      do i = 1, 3 ! reached, least, first quartile
        comma = comma + index(line(comma + 1:), ',')
      end do
      read (line(comma + 1:), *) value
    end do
    close (unit)
  end function reference_median
end module bench_optimiser_runs

! SPDX-License-Identifier: GPL-3.0-or-later
!> CMA-ES learns, generation by generation, what an independent implementation of the tutorial learns
!> from the same candidates and values. Argument: the file with 40 generations.
program test_cmaes_trace
  use base_kinds, only: rp
  use cmaes_optimiser, only: cmaes_t
  use cmaes_options, only: cmaes_options_t
  use cmaes_params, only: derive_params
  use testkit, only: testkit_t
  implicit none
  ! Both work in double precision; cond(C) stays below 1e4, and the inverse root takes its square root.
  real(rp), parameter :: TOLERANCE = 1.0e-10_rp
  integer, parameter :: N = 11, LAMBDA = 16, N_GENERATIONS = 40
  type :: trace_t
    real(rp) :: x(N, LAMBDA), f(LAMBDA), mean(N), p_sigma(N), p_c(N), c(N, N), sigma
    logical :: has_c = .false. ! the file has C after some generations only
  end type trace_t
  type(testkit_t) :: t
  type(cmaes_options_t) :: options
  type(cmaes_t) :: run
  type(trace_t) :: trace(N_GENERATIONS)
  real(rp) :: errors(5)
  integer :: g, n_lines

  call t%start(parallel=.false.)
  call read_trace()
  call t%check('the whole trace was read', n_lines == N_GENERATIONS*(LAMBDA + 4) + count(trace%has_c)*N)
  call t%check('it has C after several generations, the last one included', &
               count(trace%has_c) > 1 .and. trace(N_GENERATIONS)%has_c)
  options%lambda = LAMBDA
  options%sigma0 = 1
  call run%start(options, derive_params(options, N), [(1.0_rp, g=1, N)], has_box=.false.)
  errors = 0
  do g = 1, N_GENERATIONS
    call run%tell(trace(g)%f, x=trace(g)%x)
    call note(1, run%state%mean - trace(g)%mean, norm2(trace(g)%mean))
    call note(2, run%state%p_sigma - trace(g)%p_sigma, norm2(trace(g)%p_sigma))
    call note(3, run%state%p_c - trace(g)%p_c, norm2(trace(g)%p_c))
    call note(4, [run%state%sigma - trace(g)%sigma], trace(g)%sigma)
    if (trace(g)%has_c) call note(5, reshape(run%state%c - trace(g)%c, [N*N]), norm2(trace(g)%c))
  end do
  call t%check_below('the mean is that of the trace', errors(1), TOLERANCE)
  call t%check_below('the path of sigma is that of the trace', errors(2), TOLERANCE)
  call t%check_below('the path of C is that of the trace', errors(3), TOLERANCE)
  call t%check_below('sigma is that of the trace', errors(4), TOLERANCE)
  call t%check_below('C is that of the trace', errors(5), TOLERANCE)
  call t%check('all generations were replayed', run%state%generation == N_GENERATIONS)
  call t%finish()

contains

  !> Largest relative error so far, by norm.
  subroutine note(i, difference, size_of_it)
    integer, intent(in) :: i
    real(rp), intent(in) :: difference(:), size_of_it
    errors(i) = max(errors(i), norm2(difference)/size_of_it)
  end subroutine note

  !> Lines: a letter for what it is, generation, for X and C the candidate or row, numbers, for X also f.
  subroutine read_trace()
    character(600) :: line
    character(500) :: path
    integer :: unit, state, generation, row
    call get_command_argument(1, path)
    open (newunit=unit, file=trim(path), status='old', action='read')
    n_lines = 0
    do
      read (unit, '(a)', iostat=state) line
      if (state /= 0) exit
      if (line(1:1) == '#') cycle
      n_lines = n_lines + 1
      read (line(3:), *) generation
      associate (it => trace(generation))
        select case (line(1:1))
        case ('X')
          read (line(3:), *) generation, row
          read (line(3:), *) generation, row, it%x(:, row), it%f(row)
        case ('C')
          it%has_c = .true.
          read (line(3:), *) generation, row
          read (line(3:), *) generation, row, it%c(row, :)
        case ('M')
          read (line(3:), *) generation, it%mean
        case ('P')
          read (line(3:), *) generation, it%p_sigma
        case ('Q')
          read (line(3:), *) generation, it%p_c
        case ('S')
          read (line(3:), *) generation, it%sigma
        end select
      end associate
    end do
    close (unit)
  end subroutine read_trace
end program test_cmaes_trace

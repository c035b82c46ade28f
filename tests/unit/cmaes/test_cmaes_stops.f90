! SPDX-License-Identifier: GPL-3.0-or-later
!> Every criterion that ends a run, in a case made for it.
program test_cmaes_stops
  use base_kinds, only: rp, i8
  use base_random, only: random_uniforms
  use cmaes_optimiser, only: cmaes_t, MOST_ATTEMPTS
  use cmaes_options, only: cmaes_options_t
  use cmaes_params, only: derive_params
  use cmaes_stop, only: RUNNING, FTARGET, MAXFEVALS, MAXITER, TOLFUN, TOLFUNHIST, TOLX, TOLFACUPX, TOLUPSIGMA, &
                        STAGNATION, FLAT_FITNESS, NOEFFECTAXIS, NOEFFECTCOORD, CONDITIONCOV, TOO_MANY_FAILED, N_STOPS, &
                        stop_name, stop_text
  use search_functions, only: value_of
  use testkit, only: testkit_t
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  implicit none
  integer, parameter :: N = 3
  type(testkit_t) :: t
  type(cmaes_options_t) :: none
  type(cmaes_t) :: run
  logical :: was_seen(N_STOPS) = .false.

  call t%start(parallel=.false.)
  none = cmaes_options_t(sigma0=1.0_rp, tolfun=0.0_rp, tolfunhist=0.0_rp, tolx=0.0_rp, tolfacupx=1.0e300_rp, &
                         tolupsigma=1.0e300_rp, condition_limit=1.0e300_rp, tolflatfitness=huge(1), &
                         tolstagnation=100000, max_iterations=100000)
  call test_all()
  call test_failures()
  call test_repairs()
  call t%check('every criterion was seen to fire', all(was_seen))
  call t%check('a running run has no reason', stop_name(RUNNING) == 'running' .and. stop_name(N_STOPS + 1) == 'unknown')
  call t%finish()

contains

  subroutine test_all()
    type(cmaes_options_t) :: o
    real(rp) :: start(N)
    start = 1
    o = none
    o%f_target = 1.0e-3_rp
    call expect('sphere', o, start, FTARGET)
    call t%check('the target is kept', run%state%best%f <= 1.0e-3_rp)
    o = none
    o%max_evaluations = 100
    call expect('sphere', o, start, MAXFEVALS)
    call t%check('the allowed evaluations are not exceeded, and used up but for less than a generation', &
                 run%state%counts%evaluations <= 100 .and. run%state%counts%evaluations > 100 - run%params%lambda)
    o = none
    o%max_iterations = 5
    call expect('sphere', o, start, MAXITER)
    call t%check('as many generations as allowed', run%state%generation == 5)
    o = none
    o%tolfun = 1.0e-6_rp
    call expect('raised', o, start, TOLFUN)
    o = none
    o%tolfunhist = 1.0e-6_rp
    call expect('raised', o, start, TOLFUNHIST)
    o = none
    o%tolx = 1.0e-6_rp
    call expect('sphere', o, start, TOLX)
    call t%check('the step has become short', run%state%sigma*maxval(run%state%d) < 1.1e-6_rp)
    o = none
    o%tolfacupx = 1.0e3_rp
    call expect('slope', o, start, TOLFACUPX)
    o = none
    o%tolupsigma = 10.0_rp
    call expect('slope', o, start, TOLUPSIGMA)
    o = none
    o%tolstagnation = 50
    call expect('noise', o, start, STAGNATION)
    o = none
    o%tolflatfitness = 1
    call expect('flat', o, start, FLAT_FITNESS)
    call t%check('one flat generation is tolerated', run%state%generation == 2)
    call expect('sphere', none, [1.0e20_rp, 1.0e20_rp, 1.0e20_rp], NOEFFECTAXIS)
    call expect('sphere', none, [1.0e16_rp, 1.0_rp, 1.0_rp], NOEFFECTCOORD) ! its neighbours are 2 apart
    o = none
    o%condition_limit = 1.0e3_rp
    call expect('elli', o, start, CONDITIONCOV)
    call t%check('C is ill-conditioned', run%state%condition > 1.0e3_rp)
  end subroutine test_all

  !> Runs until it stops, for that reason.
  subroutine expect(name, options, start, code)
    character(*), intent(in) :: name
    type(cmaes_options_t), intent(in) :: options
    real(rp), intent(in) :: start(:)
    integer, intent(in) :: code
    real(rp), allocatable :: x(:, :), f(:)
    real(rp) :: u(2)
    integer :: k
    call run%start(options, derive_params(options, N), start, has_box=.false.)
    allocate (x(N, run%params%lambda), f(run%params%lambda))
    do while (run%state%stop_code == RUNNING .and. run%state%generation < 5000)
      call run%ask(x)
      do k = 1, size(f)
        select case (name)
        case ('raised')
          f(k) = 1 + value_of('sphere', x(:, k))
        case ('slope')
          f(k) = x(1, k)
        case ('flat')
          f(k) = 1
        case ('noise')
          u = random_uniforms(5_i8, 5_i8, run%state%counts%evaluations + k)
          f(k) = u(1)
        case default
          f(k) = value_of(name, x(:, k))
        end select
      end do
      call run%tell(f)
    end do
    call t%check(stop_name(code)//' fires (got '//stop_name(run%state%stop_code)//')', run%state%stop_code == code)
    if (run%state%stop_code /= RUNNING) was_seen(run%state%stop_code) = .true.
    call t%check('and says so', index(stop_text(code), stop_name(code)//': ') == 1)
  end subroutine expect

  !> More than half failed: half the step, another sample, the same state; then the run ends.
  subroutine test_failures()
    real(rp), allocatable :: x(:, :), f(:)
    real(rp) :: mean(N), sigma
    integer :: i, half
    call run%start(none, derive_params(none, N, lambda=8), [(1.0_rp, i=1, N)], has_box=.false.)
    allocate (x(N, 8), f(8))
    half = 4
    call run%ask(x)
    f = [(real(i, rp), i=1, size(f))]
    f(:half) = ieee_value(1.0_rp, ieee_quiet_nan)
    call run%tell(f)
    call t%check('half of the candidates may fail', run%state%generation == 1 .and. run%state%counts%n_redone == 0)
    mean = run%state%mean
    sigma = run%state%sigma
    do i = 1, MOST_ATTEMPTS
      call run%ask(x)
      f(half + 1) = ieee_value(1.0_rp, ieee_quiet_nan)
      call run%tell(f)
    end do
    call t%check('a generation with more failures is repeated from the same mean', &
                 run%state%stop_code == RUNNING .and. run%state%generation == 1 .and. &
                 run%state%counts%n_redone == MOST_ATTEMPTS .and. all(abs(run%state%mean - mean) <= 0))
    call t%check('with half the step each time', abs(run%state%sigma - sigma/2**MOST_ATTEMPTS) <= 0)
    call run%ask(x)
    call run%tell(f)
    call t%check('in the end the run ends', run%state%stop_code == TOO_MANY_FAILED)
    call t%check('failed evaluations are counted', run%state%counts%evaluations == 5*size(f) .and. &
                 run%state%counts%n_failed == half + 4*(half + 1))
    was_seen(run%state%stop_code) = .true.
  end subroutine test_failures

  !> Matrices that cannot be or can hardly be decomposed.
  subroutine test_repairs()
    integer :: i
    real(rp) :: x(N, 7), f(7), smallest
    call run%start(none, derive_params(none, N), [(1.0_rp, i=1, N)], has_box=.false.)
    run%state%c(1, 2) = 5
    run%state%c(2, 1) = 5
    call run%ask(x)
    f = [(real(i, rp), i=1, 7)]
    call run%tell(f)
    call t%check('a matrix that is not positive is replaced by the last good one', run%state%counts%n_repairs == 1 .and. &
                 all(abs(run%state%c - reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])) <= 0))
    run%state%c = 0
    do i = 1, N
      run%state%c(i, i) = 1.0e-17_rp**(i - 1)
    end do
    run%state%p_c = 0
    run%params%c_mu = 0 ! C stays as it is
    run%params%c_1 = 0
    call run%ask(x)
    call run%tell(f)
    smallest = minval([(run%state%c(i, i), i=1, N)])
    call t%check('eigenvalues are raised to 1e-14 of the largest', run%state%counts%n_floored == 1 .and. &
                 run%state%condition > 1.0e16_rp .and. smallest > 0.9e-14_rp .and. smallest < 1.1e-14_rp)
  end subroutine test_repairs
end program test_cmaes_stops

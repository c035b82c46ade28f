! SPDX-License-Identifier: GPL-3.0-or-later
!> Who is better than whom, the box, and the schedules of restarts.
program test_cmaes_rules
  use base_kinds, only: rp, i8
  use cmaes_box, only: bound_side, box_problem, clip, cmaes_box_t, make_box
  use cmaes_optimiser, only: cmaes_t
  use cmaes_options, only: cmaes_options_t
  use cmaes_params, only: derive_params
  use cmaes_ranking, only: classify, rank, FAILED, FEASIBLE, INFEASIBLE
  use cmaes_search, only: cmaes_search_t, start_region_t, FIRST_RUN, LARGE_RUN, SMALL_RUN, RESTARTS_BIPOP, RESTARTS_IPOP
  use cmaes_stop, only: RUNNING, FTARGET, MAXFEVALS
  use search_functions, only: value_of
  use testkit, only: testkit_t
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_ranking()
  call test_infeasible_search()
  call test_maps()
  call test_bounds()
  call test_rastrigin()
  call test_bipop()
  call test_budget()
  call t%finish()

contains

  subroutine test_ranking()
    real(rp) :: f(9), violation(9), keys(9), nan
    integer :: classes(9), order(9), merged(9)
    integer(i8) :: bits(9)
    logical :: has_failed(9)
    nan = ieee_value(1.0_rp, ieee_quiet_nan)
    f = [3.0_rp, nan, 1.0_rp, -9.0_rp, 1.0_rp, nan, ieee_value(1.0_rp, ieee_positive_inf), -7.0_rp, 0.5_rp]
    violation = [0.0_rp, 0.0_rp, -1.0_rp, 2.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, nan]
    has_failed = .false.
    has_failed(8) = .true.
    call classify(f, violation, has_failed, classes, keys)
    call t%check('feasible, infeasible and failed are told apart', &
                 all(classes == [FEASIBLE, FAILED, FEASIBLE, INFEASIBLE, FEASIBLE, INFEASIBLE, FAILED, FAILED, FAILED]))
    call rank(classes, keys, order, merged, bits)
    call t%check('feasible by f, infeasible by violation, failed last, equals by index', &
                 all(order == [3, 5, 1, 6, 4, 2, 7, 8, 9]))
    call classify(f(:5), classes=classes(:5), keys=keys(:5))
    call rank(classes(:5), keys(:5), order(:5), merged(:5), bits(:5))
    call t%check('without violations f alone counts', all(order(:5) == [4, 3, 5, 1, 2]))
    f(:6) = [0.0_rp, -0.0_rp, -1.0e-300_rp, 1.0e-300_rp, -2.0_rp, -0.0_rp]
    call classify(f(:6), classes=classes(:6), keys=keys(:6))
    call rank(classes(:6), keys(:6), order(:6), merged(:6), bits(:6))
    call t%check('also of negative numbers, and both zeros are equal', all(order(:6) == [5, 3, 1, 2, 6, 4]))
  end subroutine test_ranking

  !> From a start where everything is infeasible to the minimum, which lies where feasibility ends: of
  !> sum x^2 for x_1 >= 1.
  subroutine test_infeasible_search()
    type(cmaes_options_t) :: options
    type(cmaes_t) :: run
    real(rp) :: x(4, 12), f(12), violation(12)
    integer :: k
    options%lambda = 12
    options%max_iterations = 400
    call run%start(options, derive_params(options, 4), [-20.0_rp, 1.0_rp, 1.0_rp, 1.0_rp], has_box=.false.)
    do while (run%state%stop_code == RUNNING)
      call run%ask(x)
      do k = 1, 12
        f(k) = value_of('sphere', x(:, k))
        violation(k) = 1 - x(1, k)
      end do
      call run%tell(f, violation)
    end do
    call t%check('an infeasible start is left', run%state%counts%n_infeasible > 100 .and. run%state%best%is_seen)
    call t%check_close('the best is feasible and at the edge', run%state%best%f, 1.0_rp, atol=1.0e-3_rp)
    call t%check('and not beyond it', run%state%best%x(1) >= 1)
  end subroutine test_infeasible_search

  !> E of 0.1 to 100 GPa, joints over four decades, a linear one.
  subroutine test_maps()
    type(cmaes_box_t) :: box
    real(rp) :: u(3), value(3)
    integer :: i
    box = make_box([1.0e8_rp, 1.0e-6_rp, -2.0_rp], [1.0e11_rp, 1.0e-2_rp, 3.0_rp], [.true., .true., .false.])
    value = box%value([0.0_rp, 0.0_rp, 0.0_rp])
    call t%check('0 is exactly the lower bound', all(abs(value - box%lower) <= 0))
    value = box%value([1.0_rp, 1.0_rp, 1.0_rp])
    call t%check('1 is exactly the upper bound', all(abs(value - box%upper) <= 0))
    value = box%value([0.5_rp, 0.25_rp, 0.4_rp])
    call t%check_below('known values', maxval(abs(value/[10.0_rp**9.5_rp, 1.0e-5_rp, 1.0_rp] - 1) &
                                              *[1.0_rp, 1.0_rp, 0.0_rp]), 1.0e-14_rp)
    call t%check_close('a linear one goes through zero', value(3), 0.0_rp, atol=1.0e-15_rp)
    do i = -5, 25 ! also outside; the logarithm of 1e3 has the error of 7 eps
      u = i/20.0_rp
      if (any(abs(box%coordinate(box%value(u)) - u) > 1.0e-14_rp)) call t%check('there and back', .false.)
    end do
    call t%check('coordinates to values and back', t%n_failed == 0)
    call t%check('clipping', all(abs(clip([-0.1_rp, 0.3_rp, 1.7_rp]) - [0.0_rp, 0.3_rp, 1.0_rp]) <= 0))
    call t%check('sides', all(bound_side([0.0_rp, 0.3_rp, 0.999_rp], 0.01_rp) == [-1, 0, 1]))
    call t%check('bad bounds have sentences', index(box_problem(1.0_rp, 1.0_rp, .false.), 'exceed') > 0 .and. &
                 index(box_problem(0.0_rp, 1.0_rp, .true.), 'positive') > 0 .and. &
                 index(box_problem(0.0_rp, ieee_value(1.0_rp, ieee_positive_inf), .false.), 'finite') > 0)
  end subroutine test_maps

  !> A bowl, steep in some directions, whose minimum lies outside in one coordinate, at a bound in one and
  !> inside in the others: the best of the box is found.
  subroutine test_bounds()
    real(rp), parameter :: CENTRE(5) = [1.4_rp, 0.0_rp, 0.3_rp, 0.5_rp, 0.9_rp]
    real(rp), parameter :: STEEP(5) = [1.0_rp, 10.0_rp, 100.0_rp, 1.0_rp, 30.0_rp]
    type(cmaes_options_t) :: options
    type(cmaes_t) :: run
    real(rp) :: x(5, 10), f(10)
    integer :: k
    logical :: is_inside
    options%lambda = 10
    options%max_evaluations = 6000
    call run%start(options, derive_params(options, 5), [(0.5_rp, k=1, 5)], has_box=.true.)
    is_inside = .true.
    do while (run%state%stop_code == RUNNING)
      call run%ask(x)
      is_inside = is_inside .and. all(x >= 0) .and. all(x <= 1)
      do k = 1, 10
        f(k) = sum(STEEP*(x(:, k) - CENTRE)**2)
      end do
      call run%tell(f)
    end do
    call t%check('candidates are in the box', is_inside)
    call t%check_below('the best point of the box is found', maxval(abs(run%state%best%x - clip(CENTRE))), 1.0e-4_rp)
    call t%check_below('with its value', run%state%best%f - 0.16_rp, 1.0e-6_rp)
    call t%check('the penalty was needed', run%state%penalty%is_on .and. all(run%state%penalty%weights > 0))
    call t%check_below('the mean stays near the box', maxval(abs(run%state%mean - clip(run%state%mean))), 0.1_rp)
  end subroutine test_bounds

  !> Restarts solve what a single run does not.
  subroutine test_rastrigin()
    type(cmaes_search_t) :: search
    integer :: seed, n_solved, n_at_once
    n_solved = 0
    n_at_once = 0
    do seed = 1, 7
      call search_rastrigin(RESTARTS_IPOP, 5, seed, 300000_i8, search)
      if (search%state%stop_code == FTARGET) n_solved = n_solved + 1
      if (search%state%restart == 0) n_at_once = n_at_once + 1
    end do
    call t%check('IPOP solves Rastrigin n = 5 for every seed', n_solved == 7)
    call t%check('a single run does not', n_at_once < 7)
    call t%check('the reason is told', index(search%stop_sentence(), 'ftarget: ') == 1)
    call search_rastrigin(RESTARTS_BIPOP, 5, 1, 300000_i8, search)
    call t%check('BIPOP solves it too', search%state%stop_code == FTARGET)
  end subroutine test_rastrigin

  subroutine search_rastrigin(restarts, n, seed, budget, search)
    integer, intent(in) :: restarts
    integer, intent(in) :: n, seed
    integer(i8), intent(in) :: budget
    type(cmaes_search_t), intent(out) :: search
    call start_search(restarts, n, seed, budget, search)
    do while (search%state%stop_code == RUNNING)
      call advance(search)
    end do
  end subroutine search_rastrigin

  subroutine start_search(restarts, n, seed, budget, search)
    integer, intent(in) :: restarts
    integer, intent(in) :: n, seed
    integer(i8), intent(in) :: budget
    type(cmaes_search_t), intent(out) :: search
    type(start_region_t) :: region
    allocate (region%lower(n), region%upper(n))
    region%lower = -5
    region%upper = 5
    call search%start(cmaes_options_t(sigma0=2.0_rp, seed=int(seed, i8), f_target=1.0e-10_rp, f_scale=1.0_rp, &
                                      tolfun=1.0e-12_rp, tolfunhist=1.0e-12_rp, max_evaluations=budget), &
                      restarts, 50, region)
  end subroutine start_search

  subroutine advance(search)
    type(cmaes_search_t), intent(inout) :: search
    real(rp), allocatable :: x(:, :), f(:)
    integer :: k
    call search%ask(x)
    allocate (f(size(x, 2)))
    do k = 1, size(f)
      f(k) = value_of('rastrigin', x(:, k))
    end do
    call search%tell(f)
  end subroutine advance

  !> Regimes, populations and steps of many runs; n = 10 is not solved in this time.
  subroutine test_bipop()
    type(cmaes_search_t) :: search
    integer :: last, n_small, n_large, lambda_large
    logical :: is_right, is_balanced
    call start_search(RESTARTS_BIPOP, 10, 3, 60000_i8, search)
    last = -1
    n_small = 0
    n_large = 0
    lambda_large = 10
    is_right = .true.
    is_balanced = .true.
    do while (search%state%stop_code == RUNNING)
      if (search%state%restart /= last) then
        last = search%state%restart
        associate (s => search%state)
          select case (s%regime)
          case (FIRST_RUN)
            is_right = is_right .and. last == 0 .and. s%lambda == 10
          case (LARGE_RUN)
            n_large = n_large + 1
            lambda_large = 2*lambda_large
            is_right = is_right .and. s%lambda == lambda_large .and. abs(s%sigma0 - 2) <= 0
            is_balanced = is_balanced .and. s%spent_small >= s%spent_large
          case (SMALL_RUN)
            n_small = n_small + 1
            is_right = is_right .and. s%lambda >= 10 .and. s%lambda <= lambda_large/2 .and. s%sigma0 < 2 .and. &
                       s%sigma0 >= 0.02_rp .and. s%run_limit <= max(s%last_large/2, int(s%lambda, i8))
            is_balanced = is_balanced .and. s%spent_small < s%spent_large
          end select
        end associate
      end if
      call advance(search)
    end do
    call t%check('large populations double, small ones have small steps', is_right)
    call t%check('both regimes are launched, each when it has spent less', &
                 is_balanced .and. n_small > 1 .and. n_large > 1)
    call t%check('the budget ends the search', search%state%stop_code == MAXFEVALS)
  end subroutine test_bipop

  !> One budget for all runs together.
  subroutine test_budget()
    type(cmaes_search_t) :: search
    integer(i8), parameter :: BUDGET = 5000
    logical :: has_best
    real(rp) :: f, x(10)
    integer(i8) :: evaluation
    call search_rastrigin(RESTARTS_IPOP, 10, 2, BUDGET, search)
    call t%check('restarts do not renew the budget', search%state%restart > 0 .and. search%evaluations() <= BUDGET)
    call t%check('it is used up but for less than a generation', search%evaluations() > BUDGET - search%state%lambda)
    call search%best(has_best, f, x, evaluation)
    call t%check('the best of all runs is kept', has_best .and. evaluation <= BUDGET)
    call t%check_close('with its place', value_of('rastrigin', x), f, atol=0.0_rp)
  end subroutine test_budget
end program test_cmaes_rules

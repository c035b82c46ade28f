! SPDX-License-Identifier: GPL-3.0-or-later
!> A search that is stored and restored at any generation continues to the last bit; what does not fit is refused.
!> Budgets may change on the way.
program test_cmaes_resume
  use base_errors, only: failure_t
  use base_kinds, only: rp, i8
  use base_named_kinds, only: word_of
  use base_packing, only: pack_value, unpack_value
  use cmaes_options, only: cmaes_options_t
  use cmaes_search, only: cmaes_search_t, start_region_t, RESTART_RULES, RESTARTS_BIPOP, RESTARTS_IPOP, &
                          RESTARTS_NONE
  use cmaes_stop, only: MAXFEVALS, RUNNING
  use search_functions, only: value_of
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_resume(3, 260, RESTARTS_IPOP)
  call test_resume(3, 260, RESTARTS_BIPOP)
  call test_resume(101, 20, RESTARTS_NONE) ! where C is decomposed in some generations only
  call test_budget()
  call test_misfits()
  call t%finish()

contains

  !> Every generation of the resumed search begins from what was stored of the last one.
  subroutine test_resume(n, n_generations, restarts)
    integer, intent(in) :: n, n_generations
    integer, intent(in) :: restarts
    type(cmaes_search_t) :: straight, resumed, next
    real(rp), allocatable :: stored(:)
    type(failure_t) :: failure
    integer :: g, n_different, most_restarts
    n_different = 0
    call begin(n, restarts, straight)
    call begin(n, restarts, resumed)
    do g = 1, n_generations
      if (straight%state%stop_code /= RUNNING) exit
      call advance(straight)
      call advance(resumed)
      call pack_value(resumed, stored)
      call begin(n, restarts, next)
      call unpack_value(stored, next, failure)
      if (failure%failed) n_different = n_different + 1
      resumed = next
      if (.not. same(straight, resumed)) n_different = n_different + 1
    end do
    most_restarts = straight%state%restart
    call t%check('resumed in every generation and equal to the last bit: '//word_of(RESTART_RULES, restarts), n_different == 0)
    if (restarts /= RESTARTS_NONE) call t%check('through a restart', most_restarts > 0)
  end subroutine test_resume

  !> A search goes on with the budget with which it is continued, smaller or larger than the one it began with.
  subroutine test_budget()
    integer(i8), parameter :: BEFORE(2) = [10000_i8, 30_i8], AFTER(2) = [40_i8, 70_i8]
    type(cmaes_search_t) :: search, next
    real(rp), allocatable :: stored(:)
    type(failure_t) :: failure
    integer :: i
    do i = 1, 2
      call begin(3, RESTARTS_NONE, search, BEFORE(i))
      call advance(search)
      call advance(search)
      call pack_value(search, stored)
      call begin(3, RESTARTS_NONE, next, AFTER(i))
      call unpack_value(stored, next, failure)
      do while (next%state%stop_code == RUNNING)
        call advance(next)
      end do
      call t%check('the new budget is spent, and no more', next%state%stop_code == MAXFEVALS .and. &
                   next%evaluations() <= AFTER(i) .and. next%evaluations() > AFTER(i) - next%state%lambda)
    end do
  end subroutine test_budget

  subroutine begin(n, restarts, search, budget)
    integer, intent(in) :: n
    integer, intent(in) :: restarts
    type(cmaes_search_t), intent(out) :: search
    integer(i8), intent(in), optional :: budget
    type(cmaes_options_t) :: options
    type(start_region_t) :: region
    options%seed = 12
    options%sigma0 = 0.2_rp
    options%tolfun = 1.0e-6_rp
    options%tolfunhist = 1.0e-6_rp
    if (present(budget)) options%max_evaluations = budget
    region%is_box = .true.
    allocate (region%lower(n), region%upper(n))
    region%lower = 0
    region%upper = 1
    call search%start(options, restarts, 9, region)
  end subroutine begin

  !> One generation on Rastrigin's function with the minimum outside the box in one coordinate; some
  !> candidates are infeasible, some fail.
  subroutine advance(search)
    type(cmaes_search_t), intent(inout) :: search
    real(rp), allocatable :: x(:, :), f(:), violation(:)
    logical, allocatable :: has_failed(:)
    integer :: k
    call search%ask(x)
    allocate (f(size(x, 2)), violation(size(x, 2)), has_failed(size(x, 2)))
    do k = 1, size(f)
      f(k) = value_of('rastrigin', 4*x(:, k) - 1.5_rp) + 30*x(1, k)
      violation(k) = x(2, k) - 0.9_rp
      has_failed(k) = modulo(int(1.0e6_rp*x(3, k)), 10) == 0
    end do
    call search%tell(f, violation, has_failed)
  end subroutine advance

  !> Both have the same numbers.
  logical function same(a, b)
    type(cmaes_search_t), intent(inout) :: a, b
    real(rp), allocatable :: of_a(:), of_b(:)
    call pack_value(a, of_a)
    call pack_value(b, of_b)
    same = size(of_a) == size(of_b)
    if (same) same = all(abs(of_a - of_b) <= 0)
  end function same

  subroutine test_misfits()
    type(cmaes_search_t) :: search, other
    type(failure_t) :: failure, fewer, more
    real(rp), allocatable :: stored(:)
    call begin(4, RESTARTS_IPOP, search)
    call advance(search)
    call pack_value(search, stored)
    call begin(4, RESTARTS_IPOP, other)
    call unpack_value(stored(:size(stored) - 1), other, failure)
    call t%check('a stored search without its end is refused', failure%failed)
    call t%check('with the name of what is missing', index(failure%reason, 'spreads') > 0)
    call begin(5, RESTARTS_IPOP, other)
    call unpack_value(stored, other, more)
    call t%check('one with fewer parameters is refused', more%failed)
    call begin(3, RESTARTS_IPOP, other)
    call unpack_value(stored, other, fewer)
    call t%check('and one with more', fewer%failed)
  end subroutine test_misfits
end program test_cmaes_resume

! SPDX-License-Identifier: GPL-3.0-or-later
!> A search that is stored and restored at any generation continues to the last bit; archives that do
!> not fit are refused with the name of what is wrong. Budgets may change on the way.
program test_cmaes_resume
  use base_kinds, only: rp, i8
  use cmaes_archive, only: archive_t
  use cmaes_options, only: cmaes_options_t
  use cmaes_search, only: cmaes_search_t, start_region_t
  use cmaes_stop, only: MAXFEVALS, RUNNING
  use search_functions, only: value_of
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_resume(3, 260, 'ipop')
  call test_resume(3, 260, 'bipop')
  call test_resume(101, 20, 'none') ! where C is decomposed in some generations only
  call test_budget()
  call test_misfits()
  call t%finish()

contains

  !> Every generation of the resumed search begins from an archive.
  subroutine test_resume(n, n_generations, restarts)
    integer, intent(in) :: n, n_generations
    character(*), intent(in) :: restarts
    type(cmaes_search_t) :: straight, resumed, next
    type(archive_t) :: stored
    integer :: g, n_different, most_restarts
    n_different = 0
    call begin(n, restarts, straight)
    call begin(n, restarts, resumed)
    do g = 1, n_generations
      if (straight%state%stop_code /= RUNNING) exit
      call advance(straight)
      call advance(resumed)
      stored = archive_t()
      call resumed%visit(stored)
      call reverse(stored)
      stored%is_reading = .true.
      call begin(n, restarts, next)
      call next%visit(stored)
      if (stored%failure%failed) n_different = n_different + 1
      resumed = next
      if (.not. same(straight, resumed)) n_different = n_different + 1
    end do
    most_restarts = straight%state%restart
    call t%check('resumed in every generation and equal to the last bit: '//restarts, n_different == 0)
    if (restarts /= 'none') call t%check('through a restart', most_restarts > 0)
  end subroutine test_resume

  !> A search goes on with the budget with which it is continued, smaller or larger than the one it began with.
  subroutine test_budget()
    integer(i8), parameter :: BEFORE(2) = [10000_i8, 30_i8], AFTER(2) = [40_i8, 70_i8]
    type(cmaes_search_t) :: search, next
    type(archive_t) :: stored
    integer :: i
    do i = 1, 2
      stored = archive_t()
      call begin(3, 'none', search, BEFORE(i))
      call advance(search)
      call advance(search)
      call search%visit(stored)
      stored%is_reading = .true.
      call begin(3, 'none', next, AFTER(i))
      call next%visit(stored)
      do while (next%state%stop_code == RUNNING)
        call advance(next)
      end do
      call t%check('the new budget is spent, and no more', next%state%stop_code == MAXFEVALS .and. &
                   next%evaluations() <= AFTER(i) .and. next%evaluations() > AFTER(i) - next%state%lambda)
    end do
  end subroutine test_budget

  subroutine begin(n, restarts, search, budget)
    integer, intent(in) :: n
    character(*), intent(in) :: restarts
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

  !> Fields may come in any order.
  subroutine reverse(archive)
    type(archive_t), intent(inout) :: archive
    integer :: i
    archive%fields = [(archive%fields(i), i=size(archive%fields), 1, -1)]
  end subroutine reverse

  !> Both have the same numbers, by their archives.
  logical function same(a, b)
    type(cmaes_search_t), intent(inout) :: a, b
    type(archive_t) :: stored_a, stored_b
    integer :: i
    call a%visit(stored_a)
    call b%visit(stored_b)
    same = size(stored_a%fields) == size(stored_b%fields)
    do i = 1, size(stored_a%fields)
      if (.not. same) return
      associate (p => stored_a%fields(i), q => stored_b%fields(i))
        same = p%name == q%name
        if (allocated(p%reals)) same = same .and. all(abs(p%reals - q%reals) <= 0)
        if (allocated(p%integers)) same = same .and. all(p%integers == q%integers)
      end associate
    end do
  end function same

  subroutine test_misfits()
    type(cmaes_search_t) :: search, other
    type(archive_t) :: stored
    integer :: i
    call begin(4, 'ipop', search)
    call advance(search)
    call search%visit(stored)
    stored%is_reading = .true.
    i = stored%find('p_sigma')
    stored%fields(i)%name = 'something'
    call begin(4, 'ipop', other)
    call other%visit(stored)
    call check_refused(stored, 'p_sigma', 'a missing field')
    stored%fields(i)%name = 'p_sigma'
    call begin(5, 'ipop', other)
    call other%visit(stored)
    call check_refused(stored, 'best_x', 'another number of parameters')
    i = stored%find('sigma')
    deallocate (stored%fields(i)%reals)
    call begin(4, 'ipop', other)
    call other%visit(stored)
    call check_refused(stored, 'sigma is not real', 'a field of another type')
    stored = archive_t()
    call search%visit(stored)
    stored%is_reading = .true.
    i = stored%find('generation')
    stored%fields(i)%integers = 2_i8**40
    call begin(4, 'ipop', other)
    call other%visit(stored)
    call check_refused(stored, 'generation is out of range', 'an integer that is too large')
  end subroutine test_misfits

  subroutine check_refused(stored, word, what)
    type(archive_t), intent(inout) :: stored
    character(*), intent(in) :: word, what
    logical :: is_named
    is_named = .false.
    if (stored%failure%failed) is_named = index(stored%failure%reason, word) > 0
    call t%check('refused with its name: '//what, is_named)
    stored%failure%failed = .false.
  end subroutine check_refused
end program test_cmaes_resume

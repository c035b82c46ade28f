! SPDX-License-Identifier: GPL-3.0-or-later
!> Solutions with a factor in single precision are as accurate as that precision, for right-hand sides of any size.
program test_rough_factor
  use base_kinds, only: rp
  use base_lapack, only: factorise, solve_factorised
  use base_rough_factor, only: rough_factor_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 60
  ! Eigenvalues are between 1 and 4 (Gershgorin): 6e-8 for each of the roundings in the order of N^(1/2), times the condition.
  real(rp), parameter :: SINGLE = 2.0e-6_rp
  type(testkit_t) :: t
  type(rough_factor_t) :: rough
  real(rp) :: a(N, N), b(N), exact(N), x(N)
  logical :: ok
  integer :: i, j

  call t%start(parallel=.false.)
  do j = 1, N
    do i = 1, N
      a(i, j) = merge(2.5_rp, 0.75_rp*0.5_rp**abs(i - j), i == j)
    end do
  end do
  b = [(sin(3.0_rp*i), i=1, N)]
  call factorise(a, ok)
  exact = b
  call solve_factorised(a, exact)
  call t%check('there is no copy before init', .not. rough%memory_bytes() > 0)
  call rough%init(N)
  call rough%take(a)
  x = b
  call rough%solve(x)
  call t%check('a rough solution has the accuracy of single precision', maxval(abs(x - exact)) < SINGLE*maxval(abs(exact)))
  call t%check('and not that of double precision', maxval(abs(x - exact)) > 1.0e-10_rp*maxval(abs(exact)))
  x = 1.0e-200_rp*b
  call rough%solve(x)
  call t%check('a small right-hand side does not vanish', maxval(abs(1.0e200_rp*x - exact)) < SINGLE*maxval(abs(exact)))
  x = 0
  call rough%solve(x)
  call t%check('the solution for 0 is 0', .not. maxval(abs(x)) > 0)
  call t%finish()
end program test_rough_factor

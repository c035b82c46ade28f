! SPDX-License-Identifier: GPL-3.0-or-later
!> Solutions with a sparse factor in single precision are as accurate as that precision; a nearly singular matrix is solved in
!> double precision.
program test_rough_solutions
  use base_kinds, only: rp
  use solid_cholesky, only: cholesky_t, CHOLESKY_SUPERNODAL
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: SIDE = 21, N = SIDE**2
  ! Of the solution: 6e-8 times the condition (9) times the roundings, in the order of SIDE.
  real(rp), parameter :: SINGLE = 1.0e-5_rp
  type(testkit_t) :: t
  type(cholesky_t) :: cholesky
  integer :: colptr(N + 1), rowind(3*N), i
  real(rp) :: values(3*N), b(N), exact(N), x(N)
  logical :: is_spd

  call t%start(parallel=.false.)
  b = [(sin(7.0_rp*i), i=1, N)]
  call make_grid(1.0_rp)
  call cholesky%init(colptr, rowind(:colptr(N + 1)), CHOLESKY_SUPERNODAL)
  call solve_both()
  call t%check('a rough solution has the accuracy of single precision', maxval(abs(x - exact)) < SINGLE*maxval(abs(exact)))
  call t%check('and not that of double precision', maxval(abs(x - exact)) > 1.0e-10_rp*maxval(abs(exact)))
  x = 1.0e-200_rp*b
  call cholesky%solve_roughly(x)
  call t%check('a small right-hand side does not vanish', maxval(abs(1.0e200_rp*x - exact)) < SINGLE*maxval(abs(exact)))
  x = 0
  call cholesky%solve_roughly(x)
  call t%check('the solution for 0 is 0', .not. maxval(abs(x)) > 0)
  call make_grid(3.0_rp)
  call solve_both()
  call t%check('a rough solution follows a new factorisation', maxval(abs(x - exact)) < SINGLE*maxval(abs(exact)))
  call make_grid(1.0_rp)
  values(1) = 1.0e9_rp ! the square root of its pivot is 2e4 times the others
  call solve_both()
  call t%check('a matrix of a large condition is solved in double precision', .not. any(abs(x - exact) > 0))
  call cholesky%free()
  call t%finish()

contains

  !> Sets the upper triangle of the matrix of a square grid of springs, whose points are held by a spring `ground` each.
  subroutine make_grid(ground)
    real(rp), intent(in) :: ground
    integer :: k, column
    k = 0
    do column = 0, N - 1
      colptr(column + 1) = k
      if (column >= SIDE) call add(column - SIDE, -1.0_rp, k)
      if (mod(column, SIDE) > 0) call add(column - 1, -1.0_rp, k)
      call add(column, 4 + ground, k)
    end do
    colptr(N + 1) = k
  end subroutine make_grid

  !> Appends a value to the present column.
  subroutine add(row, value, k)
    integer, intent(in) :: row
    real(rp), intent(in) :: value
    integer, intent(inout) :: k
    k = k + 1
    rowind(k) = row
    values(k) = value
  end subroutine add

  !> Factorises the matrix, and solves with it in both precisions.
  subroutine solve_both()
    call cholesky%factorise(values(:colptr(N + 1)), is_spd)
    call t%check('the matrix is positive definite', is_spd)
    exact = b
    call cholesky%solve(1, exact)
    x = b
    call cholesky%solve_roughly(x)
  end subroutine solve_both
end program test_rough_solutions

! SPDX-License-Identifier: GPL-3.0-or-later
!> Factors of a wing are made by one thread, inside a parallel region too, and other regions keep their threads.
program test_solid_threads
  use base_kinds, only: rp
  use omp_lib, only: omp_get_max_active_levels, omp_get_num_threads
  use solid_cholesky, only: cholesky_t, CHOLESKY_SUPERNODAL
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 900, N_THREADS = 2
  real(rp), parameter :: DIAGONAL = 4.5_rp
  ! Rows are diagonally dominant by 0.5: the residual of a backward stable solution, in units of it.
  real(rp), parameter :: TOLERANCE = 100*epsilon(1.0_rp)*2*DIAGONAL/0.5_rp
  type(testkit_t) :: t
  type(cholesky_t) :: factors(N_THREADS)
  real(rp) :: error(N_THREADS)
  integer :: levels, seen(N_THREADS), i

  call t%start(parallel=.false.)
  levels = omp_get_max_active_levels()
  call solve_grid(factors(1), error(1))
  call t%check('a system is solved', error(1) <= TOLERANCE)
  call t%check('and the levels of parallel regions are what they were', omp_get_max_active_levels() == levels)
  seen = 0
  error = huge(error)
  !$omp parallel do num_threads(N_THREADS) schedule(static, 1)
  do i = 1, N_THREADS
    call solve_grid(factors(i), error(i))
    seen(i) = omp_get_num_threads()
  end do
  !$omp end parallel do
  call t%check('other regions have their threads', all(seen == N_THREADS))
  call t%check('each of which may solve', all(error <= TOLERANCE))
  do i = 1, N_THREADS
    call factors(i)%free()
  end do
  call t%finish()

contains

  !> Five-point stencil on a grid of 30 x 30 points, with a constant solution.
  subroutine solve_grid(cholesky, error)
    type(cholesky_t), intent(inout) :: cholesky
    real(rp), intent(out) :: error
    integer, parameter :: SIDE = 30
    integer :: colptr(N + 1), rowind(3*N), rows(3), j, k, nnz
    real(rp) :: values(3*N), b(N)
    logical :: is_spd
    b = 0
    nnz = 0
    colptr(1) = 0
    do j = 1, N
      rows = [j - SIDE, merge(j - 1, 0, modulo(j - 1, SIDE) > 0), j]
      do k = 1, 3
        if (rows(k) < 1) cycle
        nnz = nnz + 1
        rowind(nnz) = rows(k) - 1
        values(nnz) = merge(DIAGONAL, -1.0_rp, k == 3)
        b(j) = b(j) + values(nnz)
        if (k < 3) b(rows(k)) = b(rows(k)) - 1
      end do
      colptr(j + 1) = nnz
    end do
    call cholesky%init(colptr, rowind(:nnz), CHOLESKY_SUPERNODAL)
    call cholesky%factorise(values(:nnz), is_spd)
    error = huge(error)
    if (.not. is_spd) return
    call cholesky%solve(1, b)
    error = maxval(abs(b - 1))
  end subroutine solve_grid
end program test_solid_threads

! SPDX-License-Identifier: GPL-3.0-or-later
!> Products of matrices have the same bits before and after the first factorisation of a wing, as the BLAS is set up at the start.
program test_solid_blas
  use base_kinds, only: rp
  use base_lapack, only: gram_upper
  use solid_cholesky, only: cholesky_t, CHOLESKY_SUPERNODAL
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: ROWS = 999, COLUMNS = 37, N = 50
  type(testkit_t) :: t
  real(rp) :: a(ROWS, COLUMNS), before(COLUMNS, COLUMNS), after(COLUMNS, COLUMNS)
  integer :: i, j

  call t%start(parallel=.true.)
  a = reshape([((sin(real(i*j, rp)), i=1, ROWS), j=1, COLUMNS)], shape(a))
  call gram_upper(a, before)
  call factorise_chain()
  call gram_upper(a, after)
  call t%check('a product before the first factorisation has the bits of one after it', all(.not. abs(after - before) > 0))
  call t%finish()

contains

  !> Factorises the matrix of a chain of N springs, with the second difference (-1, 2, -1).
  subroutine factorise_chain()
    type(cholesky_t) :: cholesky
    integer :: colptr(N + 1), rowind(2*N - 1), k
    real(rp) :: values(2*N - 1)
    logical :: is_spd
    colptr(:2) = [0, 1]
    rowind(1) = 0
    values(1) = 2
    do k = 2, N
      rowind(2*k - 2:2*k - 1) = [k - 2, k - 1]
      values(2*k - 2:2*k - 1) = [-1.0_rp, 2.0_rp]
      colptr(k + 1) = 2*k - 1
    end do
    call cholesky%init(colptr, rowind, CHOLESKY_SUPERNODAL)
    call cholesky%factorise(values, is_spd)
    call t%check('the matrix of a chain is positive definite', is_spd)
    call cholesky%free()
  end subroutine factorise_chain
end program test_solid_blas

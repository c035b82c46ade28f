! SPDX-License-Identifier: GPL-3.0-or-later
!> The dense LAPACK routines that are needed: singular values, symmetric eigenproblems, Cholesky's factors.
!>
!> LAPACK tests the arithmetic of infinities by dividing by zero, so traps are off while it runs.
module base_lapack
  use base_errors, only: require
  use base_kinds, only: rp
  use, intrinsic :: ieee_exceptions, only: ieee_get_halting_mode, ieee_set_halting_mode, ieee_usual
  implicit none
  private
  public :: singular_values, symmetric_eigen, try_symmetric_eigen, symmetric_eigen_work, cholesky_factorise, &
            cholesky_solve

  interface
    subroutine dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
      import :: rp
      character, intent(in) :: jobu, jobvt
      integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
      real(rp), intent(inout) :: a(lda, *)
      real(rp), intent(out) :: s(*), u(ldu, *), vt(ldvt, *), work(*)
      integer, intent(out) :: info
    end subroutine dgesvd
    subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      import :: rp
      character, intent(in) :: jobz, uplo
      integer, intent(in) :: n, lda, lwork
      real(rp), intent(inout) :: a(lda, *)
      real(rp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsyev
    subroutine dpotrf(uplo, n, a, lda, info)
      import :: rp
      character, intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(rp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotrf
    subroutine dpotrs(uplo, n, nrhs, a, lda, b, ldb, info)
      import :: rp
      character, intent(in) :: uplo
      integer, intent(in) :: n, nrhs, lda, ldb
      real(rp), intent(in) :: a(lda, *)
      real(rp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dpotrs
  end interface

contains

  !> Singular values, largest first, of a matrix, such as the stacked derivatives of all observations;
  !> their ratios tell which combinations of parameters the data can see.
  function singular_values(matrix) result(values)
    real(rp), intent(in) :: matrix(:, :)
    real(rp), allocatable :: values(:), a(:, :), work(:)
    real(rp) :: left(1, 1), right(1, 1)
    logical :: halting(size(ieee_usual))
    integer :: info
    allocate (a(size(matrix, 1), size(matrix, 2)), values(min(size(matrix, 1), size(matrix, 2))), &
              work(8*(size(matrix, 1) + size(matrix, 2)) + 64))
    a(:, :) = matrix
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dgesvd('N', 'N', size(a, 1), size(a, 2), a, size(a, 1), values, left, 1, right, 1, work, &
                size(work), info)
    call ieee_set_halting_mode(ieee_usual, halting)
    call require(info == 0, 'the singular values did not converge')
  end function singular_values

  !> Eigenvalues, smallest first, of the symmetric matrix a(n, n), which is replaced by the
  !> eigenvectors.
  subroutine symmetric_eigen(a, values)
    real(rp), intent(inout), contiguous :: a(:, :)
    real(rp), intent(out), contiguous :: values(:)
    real(rp), allocatable :: work(:)
    logical :: converged
    allocate (work(symmetric_eigen_work(size(a, 1))))
    call try_symmetric_eigen(a, values, work, converged)
    call require(converged, 'the eigenvalues did not converge')
  end subroutine symmetric_eigen

  !> As `symmetric_eigen`, with work space of `symmetric_eigen_work(n)` numbers from the caller;
  !> if not `converged`, `a` and `values` are undefined. Reads the upper triangle only, which must be
  !> finite.
  subroutine try_symmetric_eigen(a, values, work, converged)
    real(rp), intent(inout), contiguous :: a(:, :)
    real(rp), intent(out), contiguous :: values(:), work(:)
    logical, intent(out) :: converged
    logical :: halting(size(ieee_usual))
    integer :: info
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dsyev('V', 'U', size(a, 1), a, size(a, 1), values, work, size(work), info)
    call ieee_set_halting_mode(ieee_usual, halting)
    converged = info == 0
  end subroutine try_symmetric_eigen

  !> Work space for eigenproblems of order n: enough for LAPACK's blocks of up to 32 columns.
  pure integer function symmetric_eigen_work(n) result(length)
    integer, intent(in) :: n
    length = 34*n + 64
  end function symmetric_eigen_work

  !> The upper triangle of a(n, n) becomes the factor U of A = U^T U, unless A is not positive definite.
  subroutine cholesky_factorise(a, is_positive)
    real(rp), intent(inout), contiguous :: a(:, :)
    logical, intent(out) :: is_positive
    integer :: info
    call dpotrf('U', size(a, 1), a, max(1, size(a, 1)), info)
    is_positive = info == 0
  end subroutine cholesky_factorise

  !> b becomes A^-1 b, by the factor that `cholesky_factorise` has left in `a`.
  subroutine cholesky_solve(a, b)
    real(rp), intent(in), contiguous :: a(:, :)
    real(rp), intent(inout), contiguous :: b(:)
    integer :: info
    call dpotrs('U', size(a, 1), 1, a, max(1, size(a, 1)), b, max(1, size(b)), info)
    call require(info == 0, 'cholesky_solve: an argument is wrong')
  end subroutine cholesky_solve
end module base_lapack

! SPDX-License-Identifier: GPL-3.0-or-later
!> Wraps the dense LAPACK and BLAS routines that this project needs: singular values, symmetric eigenproblems, least squares,
!> Cholesky factors, orthonormal bases, products of tall matrices.
!>
!> LAPACK tests the arithmetic of infinities by dividing by zero, so traps are off while it runs.
module base_lapack
  use base_errors, only: require
  use base_kinds, only: rp
  use, intrinsic :: ieee_exceptions, only: ieee_get_halting_mode, ieee_set_halting_mode, ieee_usual
  implicit none
  private
  public :: singular_values, symmetric_eigen, try_symmetric_eigen, symmetric_eigen_work
  public :: triangle_of, solve_least_squares, singular_vectors
  public :: factorise, solve_factorised, solve_lower, orthogonalise, decompose, gram_upper, multiply, multiply_transposed

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
    subroutine dgeqrf(m, n, a, lda, tau, work, lwork, info)
      import :: rp
      integer, intent(in) :: m, n, lda, lwork
      real(rp), intent(inout) :: a(lda, *)
      real(rp), intent(out) :: tau(*), work(*)
      integer, intent(out) :: info
    end subroutine dgeqrf
    subroutine dorgqr(m, n, k, a, lda, tau, work, lwork, info)
      import :: rp
      integer, intent(in) :: m, n, k, lda, lwork
      real(rp), intent(inout) :: a(lda, *)
      real(rp), intent(in) :: tau(*)
      real(rp), intent(out) :: work(*)
      integer, intent(out) :: info
    end subroutine dorgqr
    subroutine dgels(trans, m, n, nrhs, a, lda, b, ldb, work, lwork, info)
      import :: rp
      character, intent(in) :: trans
      integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
      real(rp), intent(inout) :: a(lda, *), b(ldb, *)
      real(rp), intent(out) :: work(*)
      integer, intent(out) :: info
    end subroutine dgels
    subroutine dpotrf(uplo, n, a, lda, info)
      import :: rp
      character, intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(rp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotrf
    subroutine dtrsv(uplo, trans, diag, n, a, lda, x, incx)
      import :: rp
      character, intent(in) :: uplo, trans, diag
      integer, intent(in) :: n, lda, incx
      real(rp), intent(in) :: a(lda, *)
      real(rp), intent(inout) :: x(*)
    end subroutine dtrsv
    subroutine dtrtrs(uplo, trans, diag, n, nrhs, a, lda, b, ldb, info)
      import :: rp
      character, intent(in) :: uplo, trans, diag
      integer, intent(in) :: n, nrhs, lda, ldb
      real(rp), intent(in) :: a(lda, *)
      real(rp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dtrtrs
    subroutine dsyrk(uplo, trans, n, k, alpha, a, lda, beta, c, ldc)
      import :: rp
      character, intent(in) :: uplo, trans
      integer, intent(in) :: n, k, lda, ldc
      real(rp), intent(in) :: alpha, a(lda, *), beta
      real(rp), intent(inout) :: c(ldc, *)
    end subroutine dsyrk
    subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
      import :: rp
      character, intent(in) :: transa, transb
      integer, intent(in) :: m, n, k, lda, ldb, ldc
      real(rp), intent(in) :: alpha, a(lda, *), b(ldb, *), beta
      real(rp), intent(inout) :: c(ldc, *)
    end subroutine dgemm
  end interface

contains

  !> Returns the singular values, largest first, of a matrix, such as the stacked derivatives of all observations; their ratios tell
  !> which combinations of parameters the data determine.
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

  !> Finds the eigenvalues, smallest first, of the symmetric matrix a(n, n), which is replaced by the eigenvectors.
  subroutine symmetric_eigen(a, values)
    real(rp), intent(inout), contiguous :: a(:, :)
    real(rp), intent(out), contiguous :: values(:)
    real(rp), allocatable :: work(:)
    logical :: converged
    allocate (work(symmetric_eigen_work(size(a, 1))))
    call try_symmetric_eigen(a, values, work, converged)
    call require(converged, 'the eigenvalues did not converge')
  end subroutine symmetric_eigen

  !> Does what `symmetric_eigen` does, with work space of `symmetric_eigen_work(n)` numbers from the caller. If not `converged`,
  !> `a` and `values` are undefined. Reads the upper triangle only, which must be finite.
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

  !> Returns the size of the work space for eigenproblems of order n: enough for LAPACK's blocks of up to 32 columns.
  pure integer function symmetric_eigen_work(n) result(length)
    integer, intent(in) :: n
    length = 34*n + 64
  end function symmetric_eigen_work

  !> Returns the triangle R(n, n) of the QR factorisation of a(m, n); R^T R = a^T a. Rows of zeros if m < n.
  function triangle_of(a) result(r)
    real(rp), intent(in) :: a(:, :)
    real(rp), allocatable :: r(:, :), copy(:, :), tau(:), work(:)
    logical :: halting(size(ieee_usual))
    integer :: i, n, info
    n = size(a, 2)
    allocate (copy(max(size(a, 1), n), n), r(n, n), tau(n), work(64*(n + 1)), source=0.0_rp)
    if (n == 0) return
    copy(:size(a, 1), :) = a
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dgeqrf(size(copy, 1), n, copy, size(copy, 1), tau, work, size(work), info)
    call ieee_set_halting_mode(ieee_usual, halting)
    call require(info == 0, 'base_lapack: dgeqrf was called wrongly')
    do i = 1, n
      r(:i, i) = copy(:i, i)
    end do
  end function triangle_of

  !> Finds x(n) that minimises |a x - b|, a(m, n) with m >= n. `ok` is false if the columns of a are dependent.
  subroutine solve_least_squares(a, b, x, ok)
    real(rp), intent(in) :: a(:, :), b(:)
    real(rp), intent(out) :: x(:)
    logical, intent(out) :: ok
    real(rp), allocatable :: copy(:, :), right(:, :), work(:)
    logical :: halting(size(ieee_usual))
    integer :: info
    ok = .true.
    x = 0
    if (size(x) == 0) return
    copy = a
    allocate (right(size(b), 1))
    right(:, 1) = b
    allocate (work(64*(size(a, 1) + size(a, 2))))
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dgels('N', size(a, 1), size(a, 2), 1, copy, size(a, 1), right, size(b), work, size(work), info)
    call ieee_set_halting_mode(ieee_usual, halting)
    call require(info >= 0, 'base_lapack: dgels was called wrongly')
    ok = info == 0
    if (ok) x = right(:size(x), 1)
  end subroutine solve_least_squares

  !> Finds the singular values(n), largest first, and right singular vectors(n, n), one a column, of a(n, n).
  subroutine singular_vectors(a, values, vectors)
    real(rp), intent(in) :: a(:, :)
    real(rp), intent(out) :: values(:), vectors(:, :)
    real(rp), allocatable :: copy(:, :), transposed(:, :), work(:)
    real(rp) :: left(1, 1)
    logical :: halting(size(ieee_usual))
    integer :: n, info
    n = size(a, 1)
    if (n == 0) return
    copy = a
    allocate (transposed(n, n), work(64*n + 64))
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dgesvd('N', 'A', n, n, copy, n, values, left, 1, transposed, n, work, size(work), info)
    call ieee_set_halting_mode(ieee_usual, halting)
    call require(info == 0, 'the singular values did not converge')
    vectors = transpose(transposed)
  end subroutine singular_vectors

  !> Replaces the lower triangle of the symmetric a(n, n) by its Cholesky factor L, a = L L^T. `ok` is false if a is not
  !> positive definite.
  subroutine factorise(a, ok)
    real(rp), intent(inout), contiguous :: a(:, :)
    logical, intent(out) :: ok
    logical :: halting(size(ieee_usual))
    integer :: info
    info = 0
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    if (size(a, 1) > 0) call dpotrf('L', size(a, 1), a, size(a, 1), info)
    call ieee_set_halting_mode(ieee_usual, halting)
    call require(info >= 0, 'base_lapack: dpotrf was called wrongly')
    ok = info == 0
  end subroutine factorise

  !> Replaces b(n, :) by L^-1 b, with the factor l(n, n) of `factorise`.
  subroutine solve_lower(l, b)
    real(rp), intent(in), contiguous :: l(:, :)
    real(rp), intent(inout), contiguous :: b(:, :)
    logical :: halting(size(ieee_usual))
    integer :: info
    info = 0
    if (size(b) == 0) return
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dtrtrs('L', 'N', 'N', size(l, 1), size(b, 2), l, size(l, 1), b, size(b, 1), info)
    call ieee_set_halting_mode(ieee_usual, halting)
    call require(info == 0, 'base_lapack: dtrtrs')
  end subroutine solve_lower

  !> Replaces b by A^-1 b, by the factor of A that `factorise` has left in the lower triangle of `a`. For one right-hand side this
  !> takes half the time of LAPACK's dpotrs, which OpenBLAS makes of products of matrices.
  subroutine solve_factorised(a, b)
    real(rp), intent(in), contiguous :: a(:, :)
    real(rp), intent(inout), contiguous :: b(:)
    if (size(b) == 0) return
    call dtrsv('L', 'N', 'N', size(b), a, size(a, 1), b, 1)
    call dtrsv('L', 'T', 'N', size(b), a, size(a, 1), b, 1)
  end subroutine solve_factorised

  !> Finds the QR factorisation of a(m, n): q(m, k) with orthonormal columns, r(k, n), k = min(m, n).
  subroutine orthogonalise(a, q, r)
    real(rp), intent(in) :: a(:, :)
    real(rp), allocatable, intent(out) :: q(:, :), r(:, :)
    real(rp), allocatable :: copy(:, :), tau(:), work(:)
    logical :: halting(size(ieee_usual))
    integer :: m, n, k, i, info
    m = size(a, 1)
    n = size(a, 2)
    k = min(m, n)
    allocate (q(m, k), r(k, n), source=0.0_rp)
    if (k == 0) return
    copy = a
    allocate (tau(k), work(64*(n + 1)))
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dgeqrf(m, n, copy, m, tau, work, size(work), info)
    do i = 1, n
      r(:min(i, k), i) = copy(:min(i, k), i)
    end do
    q = copy(:, :k)
    if (info == 0) call dorgqr(m, k, k, q, m, tau, work, size(work), info)
    call ieee_set_halting_mode(ieee_usual, halting)
    call require(info == 0, 'base_lapack: dgeqrf or dorgqr')
  end subroutine orthogonalise

  !> Finds the singular value decomposition a(m, n) = u diag(s) vt with u(m, k), s(k) from the largest, vt(k, n), k = min(m, n).
  subroutine decompose(a, u, s, vt)
    real(rp), intent(in) :: a(:, :)
    real(rp), allocatable, intent(out) :: u(:, :), s(:), vt(:, :)
    real(rp), allocatable :: copy(:, :), work(:)
    logical :: halting(size(ieee_usual))
    integer :: m, n, k, info
    m = size(a, 1)
    n = size(a, 2)
    k = min(m, n)
    allocate (u(m, k), s(k), vt(k, n), source=0.0_rp)
    if (k == 0) return
    copy = a
    allocate (work(64*(m + n) + 64))
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dgesvd('S', 'S', m, n, copy, m, s, u, m, vt, k, work, size(work), info)
    call ieee_set_halting_mode(ieee_usual, halting)
    call require(info == 0, 'the singular values did not converge')
  end subroutine decompose

  !> Sets the upper triangle of c(n, n) to that of a^T a, a(m, n), and the rest to 0.
  subroutine gram_upper(a, c)
    real(rp), intent(in), contiguous :: a(:, :)
    real(rp), intent(out), contiguous :: c(:, :)
    logical :: halting(size(ieee_usual))
    c = 0
    if (size(a) == 0) return
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dsyrk('U', 'T', size(a, 2), size(a, 1), 1.0_rp, a, size(a, 1), 0.0_rp, c, size(c, 1))
    call ieee_set_halting_mode(ieee_usual, halting)
  end subroutine gram_upper

  !> Adds factor a(m, k) b(k, n) to c(m, n).
  subroutine multiply(factor, a, b, c)
    real(rp), intent(in) :: factor
    real(rp), intent(in), contiguous :: a(:, :), b(:, :)
    real(rp), intent(inout), contiguous :: c(:, :)
    logical :: halting(size(ieee_usual))
    if (size(a) == 0 .or. size(b) == 0) return
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dgemm('N', 'N', size(a, 1), size(b, 2), size(a, 2), factor, a, size(a, 1), b, size(b, 1), 1.0_rp, &
               c, size(c, 1))
    call ieee_set_halting_mode(ieee_usual, halting)
  end subroutine multiply

  !> Sets c(k, n) to a^T b, a(m, k), b(m, n).
  subroutine multiply_transposed(a, b, c)
    real(rp), intent(in), contiguous :: a(:, :), b(:, :)
    real(rp), intent(out), contiguous :: c(:, :)
    logical :: halting(size(ieee_usual))
    c = 0
    if (size(a) == 0 .or. size(b) == 0) return
    call ieee_get_halting_mode(ieee_usual, halting)
    call ieee_set_halting_mode(ieee_usual, .false.)
    call dgemm('T', 'N', size(a, 2), size(b, 2), size(a, 1), 1.0_rp, a, size(a, 1), b, size(b, 1), 0.0_rp, &
               c, size(c, 1))
    call ieee_set_halting_mode(ieee_usual, halting)
  end subroutine multiply_transposed
end module base_lapack

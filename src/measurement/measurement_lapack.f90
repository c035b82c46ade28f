! SPDX-License-Identifier: GPL-3.0-or-later
!> The dense LAPACK routines of least squares.
!>
!> LAPACK tests the arithmetic of infinities by dividing by zero, so traps are off while it runs.
module measurement_lapack
  use base_errors, only: require
  use base_kinds, only: rp
  use, intrinsic :: ieee_exceptions, only: ieee_get_halting_mode, ieee_set_halting_mode, ieee_usual
  implicit none
  private
  public :: triangle_of, solve_least_squares, singular_vectors

  interface
    subroutine dgeqrf(m, n, a, lda, tau, work, lwork, info)
      import :: rp
      integer, intent(in) :: m, n, lda, lwork
      real(rp), intent(inout) :: a(lda, *)
      real(rp), intent(out) :: tau(*), work(*)
      integer, intent(out) :: info
    end subroutine dgeqrf
    subroutine dgels(trans, m, n, nrhs, a, lda, b, ldb, work, lwork, info)
      import :: rp
      character, intent(in) :: trans
      integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
      real(rp), intent(inout) :: a(lda, *), b(ldb, *)
      real(rp), intent(out) :: work(*)
      integer, intent(out) :: info
    end subroutine dgels
    subroutine dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
      import :: rp
      character, intent(in) :: jobu, jobvt
      integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
      real(rp), intent(inout) :: a(lda, *)
      real(rp), intent(out) :: s(*), u(ldu, *), vt(ldvt, *), work(*)
      integer, intent(out) :: info
    end subroutine dgesvd
  end interface

contains

  !> The triangle R(n, n) of the QR factorisation of a(m, n); R^T R = a^T a. Rows of zeros if m < n.
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
    call require(info == 0, 'measurement_lapack: dgeqrf was called wrongly')
    do i = 1, n
      r(:i, i) = copy(:i, i)
    end do
  end function triangle_of

  !> x(n) that minimises |a x - b|, a(m, n) with m >= n. `ok` is false if the columns of a are dependent.
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
    call require(info >= 0, 'measurement_lapack: dgels was called wrongly')
    ok = info == 0
    if (ok) x = right(:size(x), 1)
  end subroutine solve_least_squares

  !> Singular values(n), largest first, and right singular vectors(n, n), one a column, of a(n, n).
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
end module measurement_lapack

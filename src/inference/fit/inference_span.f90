! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds what columns with errors span, without the directions that are nothing but errors.
!>
!> Column j of a(n, m) has the error e(j), a length. In b = a diag(1/e) every column has an error of length 1, and all errors
!> together have a Frobenius norm of sqrt(m) at most. No singular value of b is then wrong by more than sqrt(m) (Weyl). A singular
!> value up to sqrt(m) may be 0 in truth, and its direction is arbitrary: rounding decides it. The span has the directions of all
!> others. If the smallest of these is t sqrt(m) and all others are far below sqrt(m), errors d times as large as e turn the span by
!> an angle whose sine is d/(t - d) at most (Wedin, BIT 12 (1972) 99, doi:10.1007/BF01932678).
!>
!> What is left of a column of length l outside the span of others has errors of both: its own, and l/t, by which the others turn
!> the part that they take.
module inference_span
  use base_kinds, only: i8, rp
  use base_lapack, only: decompose, orthogonalise
  use base_random, only: fill_gaussians
  implicit none
  private
  public :: find_span

contains

  !> Returns the orthonormal basis(n, k) of the span of a(n, m), whose columns have errors of the lengths error(m). A column of
  !> length 0 does not count. `margin` is t of the module, or 0 if nothing is kept. The basis depends on the span alone, not on the
  !> columns that span it: rounding errors of columns do not turn it within the span.
  subroutine find_span(a, error, basis, margin)
    real(rp), intent(in) :: a(:, :), error(:)
    real(rp), allocatable, intent(out) :: basis(:, :)
    real(rp), intent(out) :: margin
    real(rp) :: scaled(size(a, 1), size(a, 2))
    real(rp), allocatable :: u(:, :), s(:), vt(:, :), mixed(:, :), r(:, :)
    integer :: i, k
    scaled = 0
    do i = 1, size(a, 2)
      if (norm2(a(:, i)) > 0) scaled(:, i) = a(:, i)/error(i)
    end do
    call decompose(scaled, u, s, vt)
    k = count(s > sqrt(real(size(a, 2), rp)))
    margin = 0
    if (k > 0) margin = s(k)/sqrt(real(size(a, 2), rp))
    ! Singular vectors of neighbouring singular values turn into each other. The same mixtures of fixed vectors do not.
    allocate (mixed(size(a, 1), k))
    do i = 1, k
      call fill_gaussians(1_i8, int(i, i8), 0_i8, mixed(:, i))
    end do
    mixed = matmul(u(:, :k), matmul(transpose(u(:, :k)), mixed))
    call orthogonalise(mixed, basis, r)
  end subroutine find_span
end module inference_span

! SPDX-License-Identifier: GPL-3.0-or-later
!> Solves dense equations roughly, for preconditioners and for tangents of iterations: with a copy of Cholesky's factor in single
!> precision. A solution reads the whole factor, twice; the copy has half the bytes, and the memory sets the time.
module base_rough_factor
  use base_kinds, only: rp, sp
  implicit none
  private
  public :: rough_factor_t

  !> A copy of the factor L of A = L L^T.
  type :: rough_factor_t
    private
    real(sp), allocatable :: factor(:, :) !< (n, n) L in the lower triangle; the rest is undefined
    real(sp), allocatable :: x(:)         !< (n) work space
  contains
    procedure :: init => rough_init
    procedure :: take => rough_take
    procedure :: solve => rough_solve
    procedure :: memory_bytes => rough_memory_bytes
  end type rough_factor_t

  interface
    subroutine strsv(uplo, trans, diag, n, a, lda, x, incx)
      import :: sp
      character, intent(in) :: uplo, trans, diag
      integer, intent(in) :: n, lda, incx
      real(sp), intent(in) :: a(lda, *)
      real(sp), intent(inout) :: x(*)
    end subroutine strsv
  end interface

contains

  !> Makes room for a factor of order n. Nothing else allocates.
  subroutine rough_init(self, n)
    class(rough_factor_t), intent(out) :: self
    integer, intent(in) :: n
    allocate (self%factor(n, n), self%x(n), source=0.0_sp)
  end subroutine rough_init

  !> Copies the factor in the lower triangle of a(n, n), which `factorise` of base_lapack has left there. Its numbers must be within
  !> the range of single precision, 1e-38 to 1e38.
  pure subroutine rough_take(self, a)
    class(rough_factor_t), intent(inout) :: self
    real(rp), intent(in) :: a(:, :)
    integer :: j
    do j = 1, size(a, 2)
      self%factor(j:, j) = real(a(j:, j), sp)
    end do
  end subroutine rough_take

  !> Replaces b(n) by an approximation of A^-1 b: its error over its size is about the condition of A times 1e-7.
  subroutine rough_solve(self, b)
    class(rough_factor_t), intent(inout) :: self
    real(rp), intent(inout) :: b(:)
    real(rp) :: largest
    if (size(b) == 0) return
    largest = maxval(abs(b)) ! b may be out of the range of single precision
    if (.not. abs(largest) > 0) return
    self%x = real(b/largest, sp)
    call strsv('L', 'N', 'N', size(b), self%factor, size(b), self%x, 1)
    call strsv('L', 'T', 'N', size(b), self%factor, size(b), self%x, 1)
    b = largest*real(self%x, rp)
  end subroutine rough_solve

  !> Returns the bytes of the copy; 0 before `init`.
  pure real(rp) function rough_memory_bytes(self) result(bytes)
    class(rough_factor_t), intent(in) :: self
    bytes = 0
    if (allocated(self%factor)) bytes = 4*real(size(self%factor), rp)
  end function rough_memory_bytes
end module base_rough_factor

! SPDX-License-Identifier: GPL-3.0-or-later
!> Solves with an assembled tangent by the factors of an older one: GMRES (Saad & Schultz 1986, doi:10.1137/0907058),
!> preconditioned from the right, so that it minimises the residual.
module solid_krylov
  use base_kinds, only: rp
  use solid_cholesky, only: cholesky_t
  use solid_pattern, only: pattern_t
  use solid_vectors, only: cross
  implicit none
  private
  public :: krylov_t

  integer, parameter :: MOST = 16

  !> Work space; nothing is allocated after `init`.
  type :: krylov_t
    private
    real(rp), allocatable :: basis(:, :, :), image(:, :) !< (3, n, MOST + 1), (3, n)
  contains
    procedure :: init => krylov_init
    procedure :: free => krylov_free
    procedure :: solve => krylov_solve
  end type krylov_t

contains

  !> Allocates the work space for n free points.
  subroutine krylov_init(self, n)
    class(krylov_t), intent(inout) :: self
    integer, intent(in) :: n
    call self%free()
    allocate (self%basis(3, n, MOST + 1), self%image(3, n), source=0.0_rp)
  end subroutine krylov_init

  !> Releases the arrays.
  subroutine krylov_free(self)
    class(krylov_t), intent(inout) :: self
    if (allocated(self%basis)) deallocate (self%basis, self%image)
  end subroutine krylov_free

  !> Finds x(3, n_free) with A x = b, where A y = B y + t x y. B is the symmetric matrix of `blocks`, and turns(3, n_free) are the
  !> vectors t of the points. `cholesky` has the factors of a matrix near A. On return |A x - b| = left |b|. If 16 steps do not
  !> suffice, `left` is above `enough`, and x is the best approximation found.
  subroutine krylov_solve(self, pattern, blocks, turns, cholesky, b, enough, x, left)
    class(krylov_t), intent(inout) :: self
    type(pattern_t), intent(in) :: pattern
    real(rp), intent(in) :: blocks(:, :, :), turns(:, :), b(:, :), enough
    type(cholesky_t), intent(inout) :: cholesky
    real(rp), intent(inout) :: x(:, :)
    real(rp), intent(out) :: left
    real(rp) :: h(MOST + 1, MOST), s(MOST + 1), rotation(2, MOST), size_b
    integer :: k, i, n_done
    size_b = norm2(b)
    left = 0
    x = 0
    if (.not. size_b > 0) return
    self%basis(:, :, 1) = b/size_b
    s = 0
    s(1) = size_b
    n_done = 0
    do k = 1, MOST
      x = self%basis(:, :, k)
      call cholesky%solve(1, x)
      self%image = 0
      call pattern%multiply(blocks, 1.0_rp, x, self%image)
      do i = 1, size(x, 2)
        self%image(:, i) = self%image(:, i) + cross(turns(:, i), x(:, i))
      end do
      do i = 1, k
        h(i, k) = sum(self%basis(:, :, i)*self%image)
        self%image = self%image - h(i, k)*self%basis(:, :, i)
      end do
      h(k + 1, k) = norm2(self%image)
      if (.not. h(k + 1, k) <= huge(left)) exit
      if (h(k + 1, k) > 0) self%basis(:, :, k + 1) = self%image/h(k + 1, k)
      do i = 1, k - 1
        h(i:i + 1, k) = [rotation(1, i)*h(i, k) + rotation(2, i)*h(i + 1, k), &
                         rotation(1, i)*h(i + 1, k) - rotation(2, i)*h(i, k)]
      end do
      if (.not. norm2(h(k:k + 1, k)) > 0) exit
      rotation(:, k) = h(k:k + 1, k)/norm2(h(k:k + 1, k))
      h(k, k) = norm2(h(k:k + 1, k))
      s(k:k + 1) = [rotation(1, k)*s(k), -rotation(2, k)*s(k)]
      n_done = k
      if (abs(s(k + 1)) <= enough*size_b) exit
    end do
    left = 1
    if (n_done > 0) left = abs(s(n_done + 1))/size_b
    x = 0
    do k = n_done, 1, -1
      s(k) = (s(k) - dot_product(h(k, k + 1:n_done), s(k + 1:n_done)))/h(k, k)
      x = x + s(k)*self%basis(:, :, k)
    end do
    call cholesky%solve(1, x)
  end subroutine krylov_solve
end module solid_krylov

! SPDX-License-Identifier: GPL-3.0-or-later
!> Multiplies small square matrices, four columns or vectors at a time. Loops over about ten elements are too short to outweigh
!> their overhead.
module cmaes_products
  use base_kinds, only: rp
  implicit none
  private
  public :: multiply, add_outers, mirror

  integer, parameter :: WIDTH = 4

contains

  !> Computes product(n) = a(n, n) v(n).
  pure subroutine multiply(a, v, product)
    real(rp), intent(in), contiguous :: a(:, :)
    real(rp), intent(in), contiguous :: v(:)
    real(rp), intent(out), contiguous :: product(:)
    integer :: i, j, n
    n = size(v)
    product = 0
    do j = 1, n - WIDTH + 1, WIDTH
      do i = 1, n
        product(i) = product(i) + &
                     ((v(j)*a(i, j) + v(j + 1)*a(i, j + 1)) + (v(j + 2)*a(i, j + 2) + v(j + 3)*a(i, j + 3)))
      end do
    end do
    do j = n - modulo(n, WIDTH) + 1, n
      product = product + v(j)*a(:, j)
    end do
  end subroutine multiply

  !> Adds sum_k weights(k) v_k v_k^T, v_k = v(n, k), to the upper triangle of c(n, n); the lower triangle is undefined afterwards.
  pure subroutine add_outers(weights, v, c)
    real(rp), intent(in), contiguous :: weights(:), v(:, :)
    real(rp), intent(inout), contiguous :: c(:, :)
    real(rp) :: f(WIDTH)
    integer :: i, j, k, n, m
    n = size(c, 1)
    m = size(weights)
    do k = 1, m - WIDTH + 1, WIDTH
      do j = 1, n
        f = weights(k:k + WIDTH - 1)*v(j, k:k + WIDTH - 1)
        do i = 1, j
          c(i, j) = c(i, j) + ((f(1)*v(i, k) + f(2)*v(i, k + 1)) + (f(3)*v(i, k + 2) + f(4)*v(i, k + 3)))
        end do
      end do
    end do
    do k = m - modulo(m, WIDTH) + 1, m
      do j = 1, n
        f(1) = weights(k)*v(j, k)
        do i = 1, j
          c(i, j) = c(i, j) + f(1)*v(i, k)
        end do
      end do
    end do
  end subroutine add_outers

  !> Copies the upper triangle of c to the lower one.
  pure subroutine mirror(c)
    real(rp), intent(inout), contiguous :: c(:, :)
    integer :: i, j
    do j = 1, size(c, 2)
      do i = 1, j - 1
        c(j, i) = c(i, j)
      end do
    end do
  end subroutine mirror
end module cmaes_products

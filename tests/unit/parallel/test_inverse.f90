! SPDX-License-Identifier: GPL-3.0-or-later
!> The inverse of a matrix whose rows are on several ranks, against one that is known: the inverse of min(i, j) is the matrix
!> of second differences, 2 on the diagonal, 1 in its last place, and -1 beside it.
program test_inverse
  use base_kinds, only: rp
  use parallel_inverse, only: shared_inverse_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 50
  type(testkit_t) :: t

  call t%start(parallel=.true.)
  call test_product(6)  ! the last block has two rows
  call test_product(25)
  call test_product(64) ! one block, so that one rank has everything
  call test_indefinite()
  call t%finish()

contains

  subroutine test_product(width)
    integer, intent(in) :: width
    type(shared_inverse_t) :: inverse
    real(rp) :: v(N), wanted(N), error(1)
    logical :: is_positive
    integer :: i, k
    call inverse%init(t%world, N, width)
    call t%check('every row is on one rank', t%world%sum_int8(int(size(inverse%own), 8)) == N)
    do k = 1, size(inverse%own)
      inverse%rows(:, k) = [(real(min(i, inverse%own(k)), rp), i=1, N)]
    end do
    call inverse%invert(is_positive)
    call t%check('it is positive definite', is_positive)
    error(1) = 0
    if (t%world%is_root) then
      do k = 1, 3
        v = [(sin(real(k*i, rp)), i=1, N)]
        wanted = 2*v - [0.0_rp, v(:N - 1)] - [v(2:), 0.0_rp]
        wanted(N) = v(N) - v(N - 1)
        call inverse%multiply(v)
        error(1) = max(error(1), maxval(abs(v - wanted)))
      end do
      call inverse%release()
    else
      call inverse%serve()
    end if
    call t%world%max_reals(error)
    ! The matrix has the condition 4 N^2; the sweep is as stable as Cholesky's factors.
    call t%check_below('the product is that of second differences', error(1), 4*N**2*epsilon(1.0_rp))
  end subroutine test_product

  !> A matrix with a negative eigenvalue, which shows in its third block only.
  subroutine test_indefinite()
    type(shared_inverse_t) :: inverse
    logical :: is_positive
    integer :: i, k
    call inverse%init(t%world, N, 6)
    do k = 1, size(inverse%own)
      inverse%rows(:, k) = [(real(min(i, inverse%own(k)), rp), i=1, N)]
      if (inverse%own(k) == 15) inverse%rows(15, k) = 14
    end do
    call inverse%invert(is_positive)
    call t%check('all ranks know that it is not positive definite', .not. is_positive)
  end subroutine test_indefinite
end program test_inverse

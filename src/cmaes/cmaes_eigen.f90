! SPDX-License-Identifier: GPL-3.0-or-later
!> Decomposes C = B diag(d)^2 B^T, and repairs C where it is nearly singular.
!>
!> LAPACK finds eigenvalues to about eps times the largest, so nothing below 1e-14 of the largest can be
!> trusted: such eigenvalues are raised to that floor and C is rebuilt. A decomposition that does not
!> converge or has an eigenvalue that is not positive is replaced by the last good one.
module cmaes_eigen
  use base_kinds, only: rp
  use base_lapack, only: try_symmetric_eigen
  use cmaes_state, only: cmaes_state_t, cmaes_work_t
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  implicit none
  private
  public :: decompose, build_roots

  real(rp), parameter :: FLOOR = 1.0e-14_rp

contains

  !> Finds B, d and both roots for the present C. `condition` is the condition number before the floor was applied.
  subroutine decompose(state, work)
    type(cmaes_state_t), intent(inout) :: state
    type(cmaes_work_t), intent(inout) :: work
    logical :: is_good
    real(rp) :: largest
    state%last_eigen = state%generation
    is_good = all(ieee_is_finite(state%c))
    if (is_good) then
      work%matrix = state%c
      call try_symmetric_eigen(work%matrix, work%eigenvalues, work%lapack, is_good)
    end if
    if (is_good) is_good = all(ieee_is_finite(work%eigenvalues)) ! before any comparison
    if (is_good) is_good = all(work%eigenvalues > 0)
    if (.not. is_good) then
      state%counts%n_repairs = state%counts%n_repairs + 1
      call rebuild(state)
      return
    end if
    largest = maxval(work%eigenvalues)
    state%condition = largest/max(minval(work%eigenvalues), largest*epsilon(1.0_rp)**2)
    state%b = work%matrix
    state%d = sqrt(max(work%eigenvalues, FLOOR*largest))
    if (state%condition > 1/FLOOR) then
      state%counts%n_floored = state%counts%n_floored + 1
      call rebuild(state)
    end if
    call build_roots(state, work)
  end subroutine decompose

  !> Computes C from B and d.
  subroutine rebuild(state)
    type(cmaes_state_t), intent(inout) :: state
    call build(state%b, state%d**2, state%c)
  end subroutine rebuild

  !> Makes both roots from B and d. Call it once after a state was restored.
  subroutine build_roots(state, work)
    type(cmaes_state_t), intent(in) :: state
    type(cmaes_work_t), intent(inout) :: work
    call build(state%b, state%d, work%root)
    work%z = 1/state%d ! an expression as an argument would allocate memory
    call build(state%b, work%z, work%inverse_root)
  end subroutine build_roots

  !> Computes product = B diag(values) B^T, symmetric to the last bit.
  pure subroutine build(b, values, product)
    real(rp), intent(in), contiguous :: b(:, :)
    real(rp), intent(in), contiguous :: values(:)
    real(rp), intent(out), contiguous :: product(:, :)
    real(rp) :: factor
    integer :: i, j, k, n
    n = size(values)
    product = 0
    do k = 1, n
      do j = 1, n
        factor = values(k)*b(j, k)
        do i = 1, j
          product(i, j) = product(i, j) + factor*b(i, k)
        end do
      end do
    end do
    do j = 1, n
      do i = 1, j - 1
        product(j, i) = product(i, j)
      end do
    end do
  end subroutine build
end module cmaes_eigen

! SPDX-License-Identifier: GPL-3.0-or-later
!> Ranks candidates: feasible ones by f, then infeasible ones by their violation, then failed ones; equal ones by their index.
!> NaN never takes part in a comparison.
module cmaes_ranking
  use base_kinds, only: i8, rp
  use base_sort, only: key_of_real, sort_order
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  implicit none
  private
  public :: classify, rank, sort_values, FEASIBLE, INFEASIBLE, FAILED

  integer, parameter :: FEASIBLE = 1, INFEASIBLE = 2, FAILED = 3

contains

  !> Finds the class and the key of every candidate. Infeasible: violation > 0, and then f does not count. Failed: marked as failed,
  !> or f or the violation is not finite.
  pure subroutine classify(f, violation, has_failed, classes, keys)
    real(rp), intent(in) :: f(:)
    real(rp), intent(in), optional :: violation(:)
    logical, intent(in), optional :: has_failed(:)
    integer, intent(out) :: classes(:)
    real(rp), intent(out) :: keys(:)
    integer :: k
    do k = 1, size(f)
      classes(k) = FAILED
      keys(k) = 0
      if (present(has_failed)) then
        if (has_failed(k)) cycle
      end if
      if (present(violation)) then
        if (.not. ieee_is_finite(violation(k))) cycle
        if (violation(k) > 0) then
          classes(k) = INFEASIBLE
          keys(k) = violation(k)
          cycle
        end if
      end if
      if (.not. ieee_is_finite(f(k))) cycle
      classes(k) = FEASIBLE
      keys(k) = f(k)
    end do
  end subroutine classify

  !> Ranks the candidates: order(1) is the best one, order(lambda) the worst. `merged` and `bits` are work space of the caller, of
  !> the same size.
  pure subroutine rank(classes, keys, order, merged, bits)
    integer, intent(in) :: classes(:)
    real(rp), intent(in) :: keys(:)
    integer, intent(out) :: order(:), merged(:)
    integer(i8), intent(out) :: bits(:)
    integer :: class_of, k, n
    bits = key_of_real(keys)
    call sort_order(bits, order, merged)
    merged = order
    n = 0
    do class_of = FEASIBLE, FAILED
      do k = 1, size(keys)
        if (classes(merged(k)) /= class_of) cycle
        n = n + 1
        order(n) = merged(k)
      end do
    end do
  end subroutine rank

  !> Sorts a few values in ascending order (insertion sort).
  pure subroutine sort_values(values)
    real(rp), intent(inout) :: values(:)
    real(rp) :: value
    integer :: i, j
    do i = 2, size(values)
      value = values(i)
      j = i - 1
      do while (j >= 1)
        if (values(j) <= value) exit
        values(j + 1) = values(j)
        j = j - 1
      end do
      values(j + 1) = value
    end do
  end subroutine sort_values
end module cmaes_ranking

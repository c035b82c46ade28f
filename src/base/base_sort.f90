! SPDX-License-Identifier: GPL-3.0-or-later
!> Sorting by keys.
module base_sort
  use base_kinds, only: i8, rp
  implicit none
  private
  public :: sorting_order, sort_order, sort_reals, key_of_real

contains

  !> Returns the order in which `keys` increase; equal keys keep their order.
  pure function sorting_order(keys) result(order)
    integer(i8), intent(in) :: keys(:)
    integer, allocatable :: order(:), merged(:)
    allocate (order(size(keys)), merged(size(keys)))
    call sort_order(keys, order, merged)
  end function sorting_order

  !> Finds the same order without allocations (merge sort); `merged` is work space as large as `keys`.
  pure subroutine sort_order(keys, order, merged)
    integer(i8), intent(in) :: keys(:)
    integer, intent(out) :: order(:), merged(:)
    integer :: width, left, middle, right, i, j, k

    do k = 1, size(keys)
      order(k) = k
    end do
    width = 1
    do while (width < size(keys))
      do left = 1, size(keys), 2*width
        middle = min(left + width, size(keys) + 1)
        right = min(left + 2*width, size(keys) + 1)
        i = left
        j = middle
        do k = left, right - 1
          if (i >= middle) then
            merged(k) = order(j)
            j = j + 1
          else if (j >= right) then
            merged(k) = order(i)
            i = i + 1
          else if (keys(order(i)) <= keys(order(j))) then
            merged(k) = order(i)
            i = i + 1
          else
            merged(k) = order(j)
            j = j + 1
          end if
        end do
      end do
      order = merged
      width = 2*width
    end do
  end subroutine sort_order

  !> Returns an integer that increases with a finite number; both zeros have the same.
  pure elemental integer(i8) function key_of_real(value) result(key)
    real(rp), intent(in) :: value
    ! The bits of a positive number increase with it, those of a negative one decrease. -0 + 0 is 0.
    key = transfer(value + 0.0_rp, key)
    if (key < 0) key = ieor(key, huge(key))
  end function key_of_real

  !> Sorts finite numbers so that they increase.
  pure subroutine sort_reals(values)
    real(rp), intent(inout) :: values(:)
    values = values(sorting_order(key_of_real(values)))
  end subroutine sort_reals
end module base_sort

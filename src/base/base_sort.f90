! SPDX-License-Identifier: GPL-3.0-or-later
!> Sorting by keys.
module base_sort
  use base_kinds, only: i8, rp
  implicit none
  private
  public :: sorting_order, sort_reals

contains

  !> The order in which `keys` increase; equal keys keep their order (merge sort).
  pure function sorting_order(keys) result(order)
    integer(i8), intent(in) :: keys(:)
    integer, allocatable :: order(:), merged(:)
    integer :: width, left, middle, right, i, j, k

    order = [(i, i=1, size(keys))]
    allocate (merged(size(keys)))
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
  end function sorting_order

  !> Sorts finite numbers so that they increase.
  pure subroutine sort_reals(values)
    real(rp), intent(inout) :: values(:)
    integer(i8) :: keys(size(values))
    integer :: i
    do i = 1, size(values)
      ! The bits of a positive number increase with it, those of a negative one decrease.
      keys(i) = transfer(values(i), keys(i))
      if (keys(i) < 0) keys(i) = ieor(keys(i), huge(keys(i)))
    end do
    values = values(sorting_order(keys))
  end subroutine sort_reals
end module base_sort

! SPDX-License-Identifier: GPL-3.0-or-later
!> Joins the numbers 1 to n into disjoint sets, stored as a forest: parent(i) is a smaller number of the same set, or i itself for
!> the smallest number.
module solid_sets
  implicit none
  private
  public :: unite, top

contains

  !> Joins the sets of two numbers. The smallest number is the top of the set.
  pure subroutine unite(parent, a, b)
    integer, intent(inout) :: parent(:)
    integer, intent(in) :: a, b
    integer :: i, j
    i = top(parent, a)
    j = top(parent, b)
    parent(max(i, j)) = min(i, j)
    parent(a) = min(i, j) ! shortens later searches
    parent(b) = min(i, j)
  end subroutine unite

  !> Returns the smallest number in the set of i.
  pure integer function top(parent, i)
    integer, intent(in) :: parent(:), i
    top = i
    do while (parent(top) /= top)
      top = parent(top)
    end do
  end function top
end module solid_sets

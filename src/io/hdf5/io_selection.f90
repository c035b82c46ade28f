! SPDX-License-Identifier: GPL-3.0-or-later
!> Turns the rows that a rank owns into as few regular patterns as possible.
!>
!> A file stores rows in global order, so a rank's rows are sorted first. Neighbouring rows are then joined to segments, and equal
!> segments at equal distances to patterns. The rows of a pencil need one or two patterns, however many runs describe them. This
!> matters because HDF5 needs a long time to join many patterns.
module io_selection
  use base_errors, only: require
  use base_kinds, only: i8
  use base_sort, only: sorting_order
  use parallel_block, only: rows_t
  implicit none
  private
  public :: row_patterns_t, row_patterns, row_indices

  !> Pattern k: `count(k)` segments of `length(k)` rows, the first at `start(k)` (0-based), the next
  !> ones every `stride(k)` rows.
  type :: row_patterns_t
    integer :: n = 0
    integer, allocatable :: start(:), count(:), stride(:), length(:)
    integer, allocatable :: order(:) !< local row of the i-th row in file order; unallocated: i itself
  end type row_patterns_t

contains

  !> Returns the global 0-based indices of the local rows, in local order.
  function row_indices(rows) result(indices)
    type(rows_t), intent(in) :: rows
    integer, allocatable :: indices(:)
    integer :: run, i, n
    allocate (indices(rows%n_local))
    if (rows%n_local == 0) return
    n = 0
    do run = 1, size(rows%start)
      do i = 1, rows%count(run)
        n = n + 1
        indices(n) = rows%start(run) + (i - 1)*rows%stride(run)
      end do
    end do
    call require(n == rows%n_local, 'io_selection: n_local is not the sum of the runs')
  end function row_indices

  !> Returns the patterns of `rows`. Every row may be listed once only.
  function row_patterns(rows) result(patterns)
    type(rows_t), intent(in) :: rows
    type(row_patterns_t) :: patterns
    integer, allocatable :: indices(:), first(:), length(:)
    integer :: n_segments, i, k

    allocate (indices(rows%n_local))
    indices(:) = row_indices(rows)
    if (rows%n_local == 0) return
    if (any(indices(2:) <= indices(:rows%n_local - 1))) then
      patterns%order = sorting_order(int(indices, i8))
      indices = indices(patterns%order)
    end if
    call require(indices(1) >= 0 .and. indices(rows%n_local) < rows%n .and. &
                 all(indices(2:) > indices(:rows%n_local - 1)), &
                 'io_selection: rows outside of the table or listed twice')

    n_segments = 1 + count(indices(2:) /= indices(:rows%n_local - 1) + 1)
    allocate (first(n_segments), length(n_segments))
    k = 0
    do i = 1, rows%n_local
      if (i > 1) then
        if (indices(i) == indices(i - 1) + 1) then
          length(k) = length(k) + 1
          cycle
        end if
      end if
      k = k + 1
      first(k) = indices(i)
      length(k) = 1
    end do
    call group(first, length, patterns)
  end function row_patterns

  !> Joins equal segments at equal distances.
  subroutine group(first, length, patterns)
    integer, intent(in) :: first(:), length(:)
    type(row_patterns_t), intent(inout) :: patterns
    integer :: i, next, stride, n

    n = size(first)
    allocate (patterns%start(n), patterns%count(n), patterns%stride(n), patterns%length(n))
    i = 1
    do while (i <= n)
      stride = length(i) + 1
      next = i + 1
      if (next <= n) then
        if (length(next) == length(i)) stride = first(next) - first(i)
      end if
      do while (next <= n)
        if (length(next) /= length(i) .or. first(next) - first(next - 1) /= stride) exit
        next = next + 1
      end do
      patterns%n = patterns%n + 1
      patterns%start(patterns%n) = first(i)
      patterns%count(patterns%n) = next - i
      patterns%stride(patterns%n) = stride
      patterns%length(patterns%n) = length(i)
      i = next
    end do
  end subroutine group
end module io_selection

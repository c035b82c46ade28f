! SPDX-License-Identifier: GPL-3.0-or-later
!> Tells which rank owns which part of a global array: boxes of grid points and lists of rows.
module parallel_block
  use base_kinds, only: rp
  use base_memory, only: check_allocation, REAL_BYTES
  implicit none
  private
  public :: block_t, rows_t, split_evenly, allocate_fields

  !> A box of a global three-dimensional array; all numbers count points, `start` from 0.
  type :: block_t
    integer :: n(3) = 0     !< global extent
    integer :: start(3) = 0 !< first owned index, 0-based
    integer :: count(3) = 0 !< owned extent
  end type block_t

  !> The rows of a global table that a rank owns, as regular runs. Local rows are stored in the
  !> order of the runs.
  type :: rows_t
    integer :: n = 0                    !< global number of rows
    integer :: n_local = 0              !< owned number of rows, sum of count
    integer, allocatable :: start(:)    !< first row of each run, 0-based
    integer, allocatable :: count(:)    !< rows in each run
    integer, allocatable :: stride(:)   !< distance between the rows of a run
  end type rows_t

contains

  !> Makes room for `n` fields, which hold `what`, on the points of this rank. Ends the program if there is none. Not collective.
  subroutine allocate_fields(fields, block, n, what)
    real(rp), allocatable, intent(out) :: fields(:, :, :, :)
    type(block_t), intent(in) :: block
    integer, intent(in) :: n
    character(*), intent(in) :: what
    integer :: status
    allocate (fields(block%count(1), block%count(2), block%count(3), n), stat=status)
    call check_allocation(status, [block%count, n], REAL_BYTES, what)
  end subroutine allocate_fields

  !> Splits `n` items over `parts`; part `which` (0-based) gets `count` items from `start` (0-based).
  !> The first mod(n, parts) parts get one more.
  pure subroutine split_evenly(n, parts, which, start, count)
    integer, intent(in) :: n, parts, which
    integer, intent(out) :: start, count
    integer :: base, rest
    base = n/parts
    rest = mod(n, parts)
    count = base + merge(1, 0, which < rest)
    start = which*base + min(which, rest)
  end subroutine split_evenly
end module parallel_block

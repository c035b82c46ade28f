! SPDX-License-Identifier: GPL-3.0-or-later
!> Who owns which part of a global array: boxes of grid points and lists of rows.
module parallel_block
  implicit none
  private
  public :: block_t, rows_t, split_evenly

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

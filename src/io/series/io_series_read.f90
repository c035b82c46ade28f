! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads time series (`*.t`, see io_series) back.
module io_series_read
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text_lines, only: count_words, read_line
  implicit none
  private
  public :: read_series

contains

  !> Reads the records of the series `path` as values (column, record), on the calling rank alone. Lines that begin with % are
  !> skipped, as is an incomplete last record. Fails if the file cannot be read.
  subroutine read_series(path, n_columns, values, failure)
    character(*), intent(in) :: path
    integer, intent(in) :: n_columns
    real(rp), allocatable, intent(out) :: values(:, :)
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: line
    real(rp), allocatable :: larger(:, :)
    integer :: unit, status, n
    logical :: found
    allocate (values(n_columns, 1024))
    n = 0
    open (newunit=unit, file=path, status='old', action='read', iostat=status)
    if (status /= 0) then
      call failure%raise(path//': cannot be read')
      return
    end if
    do
      call read_line(unit, line, found)
      if (.not. found) exit
      if (index(adjustl(line), '%') == 1 .or. count_words(line) /= n_columns) cycle
      if (n == size(values, 2)) then
        allocate (larger(n_columns, 2*n))
        larger(:, :n) = values
        call move_alloc(larger, values)
      end if
      read (line, *, iostat=status) values(:, n + 1)
      if (status == 0) n = n + 1
    end do
    close (unit)
    larger = values(:, :n)
    call move_alloc(larger, values)
  end subroutine read_series
end module io_series_read

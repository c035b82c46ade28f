! SPDX-License-Identifier: GPL-3.0-or-later
!> Tables of rows are stored in global order, whichever ranks own which rows in which order.
program test_rows
  use base_errors, only: failure_t
  use base_kinds, only: rp, i8
  use io_datasets, only: write_rows, read_rows
  use io_attributes, only: put_attribute, get_attribute, attribute_names
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use io_selection, only: row_patterns_t, row_patterns, row_indices
  use parallel_block, only: rows_t, split_evenly
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.true.)
  call test_patterns()
  call test_tables()
  call test_attributes()
  call t%finish()

contains

  function runs(n, start, count, stride) result(rows)
    integer, intent(in) :: n, start(:), count(:), stride(:)
    type(rows_t) :: rows
    rows%n = n
    rows%start = start
    rows%count = count
    rows%stride = stride
    rows%n_local = sum(count)
  end function runs

  !> Contiguous rows of this rank.
  function slab_rows(n) result(rows)
    integer, intent(in) :: n
    type(rows_t) :: rows
    integer :: start, count
    call split_evenly(n, t%world%size, t%world%rank, start, count)
    rows = runs(n, [start], [count], [1])
  end function slab_rows

  !> Every size-th row, in two runs of which the later rows come first: local order is not file order.
  function comb_rows(n) result(rows)
    integer, intent(in) :: n
    type(rows_t) :: rows
    integer :: mine, half
    mine = (n - t%world%rank + t%world%size - 1)/t%world%size
    half = mine/2
    rows = runs(n, [t%world%rank + half*t%world%size, t%world%rank], [mine - half, half], &
                [t%world%size, t%world%size])
  end function comb_rows

  !> Rows without any regularity, each in a run of its own.
  function scattered_rows(n) result(rows)
    integer, intent(in) :: n
    type(rows_t) :: rows
    integer :: i
    logical :: mine(n)
    mine = [(mod(shiftr(i*i*i + 7*i, 2), t%world%size) == t%world%rank, i=0, n - 1)]
    rows = runs(n, pack([(i, i=0, n - 1)], mine), pack([(1, i=0, n - 1)], mine), pack([(1, i=0, n - 1)], &
                                                                                      mine))
  end function scattered_rows

  subroutine test_patterns()
    type(row_patterns_t) :: p
    p = row_patterns(runs(100, [3], [5], [1]))
    call t%check('one segment is one pattern', p%n == 1 .and. p%start(1) == 3 .and. p%length(1) == 5 .and. &
                 p%count(1) == 1)
    p = row_patterns(runs(100, [0, 10, 20, 30], [3, 3, 3, 3], [1, 1, 1, 1]))
    call t%check('equal runs at equal distances are one pattern', p%n == 1 .and. p%count(1) == 4 .and. &
                 p%stride(1) == 10 .and. p%length(1) == 3)
    p = row_patterns(runs(100, [0, 10, 30], [3, 3, 2], [1, 1, 1]))
    call t%check('a shorter last run is a second pattern', p%n == 2 .and. p%count(1) == 2 &
                 .and. p%length(2) == 2)
    p = row_patterns(runs(100, [1, 0], [3, 3], [2, 2]))
    call t%check('interleaved runs join to one segment', p%n == 1 .and. p%length(1) == 6 &
                 .and. p%start(1) == 0)
    call t%check('and are reordered', all(p%order == [4, 1, 5, 2, 6, 3]))
  end subroutine test_patterns

  !> The value of row i (0-based), column c.
  pure real(rp) function cell(c, i)
    integer, intent(in) :: c, i
    cell = sqrt(real(i + 1, rp)) + c
  end function cell

  function filled(rows, ncol) result(data)
    type(rows_t), intent(in) :: rows
    integer, intent(in) :: ncol
    real(rp), allocatable :: data(:, :)
    integer, allocatable :: indices(:)
    integer :: i, c
    allocate (indices(rows%n_local), data(ncol, rows%n_local))
    indices(:) = row_indices(rows)
    do i = 1, rows%n_local
      data(:, i) = [(cell(c, indices(i)), c=1, ncol)]
    end do
  end function filled

  subroutine test_tables()
    integer, parameter :: NROWS(3) = [37, 2, 1]
    type(hdf5_file_t) :: file
    type(failure_t) :: failure
    type(rows_t) :: rows, other, scattered
    real(rp), allocatable :: data(:, :)
    integer :: k
    do k = 1, size(NROWS)
      rows = comb_rows(NROWS(k))
      other = slab_rows(NROWS(k))
      scattered = scattered_rows(NROWS(k))
      call file%create(t%world, 'rows.h5', failure)
      call write_rows(file, 'comb', filled(rows, 4), rows, failure)
      call write_rows(file, 'slab', filled(other, 4), other, failure)
      call write_rows(file, 'scattered', filled(scattered, 4), scattered, failure)
      call file%close(failure)
      call file%open(t%world, 'rows.h5', failure)
      allocate (data(4, other%n_local))
      call read_rows(file, 'comb', data, other, failure)
      call t%check('rows written in any order are read in global order', all(abs(data - filled(other, &
                                                                                               4)) <= 0))
      call read_rows(file, 'scattered', data, other, failure)
      call t%check('scattered rows are written in global order', all(abs(data - filled(other, 4)) <= 0))
      deallocate (data)
      allocate (data(4, scattered%n_local))
      call read_rows(file, 'slab', data, scattered, failure)
      call t%check('rows can be read scattered', all(abs(data - filled(scattered, 4)) <= 0))
      deallocate (data)
      allocate (data(4, rows%n_local))
      call read_rows(file, 'slab', data, rows, failure)
      call t%check('rows written in order are read in any order', all(abs(data - filled(rows, 4)) <= 0))
      deallocate (data)
      call file%close(failure)
      call t%check('without failure',.not. failure%failed)
    end do
  end subroutine test_tables

  subroutine test_attributes()
    type(hdf5_file_t) :: file
    type(failure_t) :: failure, wrong
    real(rp) :: x, xs(3)
    integer :: i
    integer(i8) :: long
    character(:), allocatable :: text
    character(NAME_LENGTH), allocatable :: names(:)
    call file%create(t%world, 'attributes.h5', failure, checked=.true.)
    call put_attribute(file, '/', 'real', 1.0_rp/3, failure)
    call put_attribute(file, '/', 'array', [1.0_rp, -2.0_rp, 1.0e-300_rp], failure)
    call put_attribute(file, '/', 'integer', -7, failure)
    call put_attribute(file, '/', 'long', huge(1_i8), failure)
    call put_attribute(file, '/', 'text', 'with blanks  ', failure)
    call put_attribute(file, '/', 'empty', '', failure)
    call put_attribute(file, '/', 'book', repeat('0123456789', 20000), failure)
    call file%close(failure)
    call file%open(t%world, 'attributes.h5', failure)
    call get_attribute(file, '/', 'real', x, failure)
    call get_attribute(file, '/', 'array', xs, failure)
    call get_attribute(file, '/', 'integer', i, failure)
    call get_attribute(file, '/', 'long', long, failure)
    call t%check_close('a real comes back exactly', x, 1.0_rp/3, atol=0.0_rp)
    call t%check('an array comes back exactly', all(abs(xs - [1.0_rp, -2.0_rp, 1.0e-300_rp]) <= 0))
    call t%check('integers of both kinds come back', i == -7 .and. long == huge(1_i8))
    call get_attribute(file, '/', 'text', text, failure)
    call t%check('a text keeps its trailing blanks', text == 'with blanks' .and. len(text) == 13)
    call get_attribute(file, '/', 'empty', text, failure)
    call t%check('an empty text is empty', len(text) == 0)
    call get_attribute(file, '/', 'book', text, failure)
    call t%check('a text may be long', text == repeat('0123456789', 20000))
    call attribute_names(file, '/', names, failure)
    call t%check('attributes are listed', size(names) == 7)
    if (size(names) == 7) call t%check('by name', names(1) == 'array' .and. names(7) == 'text')
    call t%check('nothing failed',.not. failure%failed)
    call get_attribute(file, '/', 'text', x, wrong)
    call t%check('another type is a failure', wrong%failed)
    call file%close(failure)
  end subroutine test_attributes
end program test_rows

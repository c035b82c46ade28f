! SPDX-License-Identifier: GPL-3.0-or-later
!> A time series survives kills and restarts without losing, doubling or mutilating records.
program test_series
  use base_errors, only: failure_t
  use base_files, only: file_exists
  use base_kinds, only: rp
  use base_text_lines, only: read_line, ends_with_newline
  use io_series, only: series_t
  use testkit, only: testkit_t
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  implicit none
  type(testkit_t) :: t
  character(16), parameter :: COLUMNS(3) = [character(16) :: 'time [-]', 'force x [-]', 'power [-]']

  call t%start(parallel=.true.)
  call test_layout()
  call test_restart()
  call test_failures()
  call t%finish()

contains

  subroutine test_layout()
    type(series_t) :: series
    type(failure_t) :: failure
    character(:), allocatable :: line
    real(rp) :: values(3)
    call series%open(t%world, 'layout.t', COLUMNS, failure)
    call series%write([0.0_rp, -1.0_rp/3, 1.5e-7_rp])
    call series%write([0.1_rp, -1.0e-200_rp, 1.23456789e123_rp])
    call series%write([0.2_rp, ieee_value(0.0_rp, ieee_quiet_nan), 1.0_rp])
    call t%check('records are on the disk at once', last_line('layout.t', 4) .and. lines('layout.t') == 4)
    call series%close(failure)
    call t%check('writing succeeds',.not. failure%failed)
    line = line_of('layout.t', 1)
    call t%check('the header begins with % and names the columns', line(1:1) == '%' .and. &
                 index(line, 'time [-]') > 0 .and. index(line, 'force x [-]') > 0 .and. index(line, &
                                                                                              'power [-]') > 0)
    line = line_of('layout.t', 2)
    call t%check('records are es15.8, one blank apart', &
                 line == ' 0.00000000E+00 -3.33333333E-01  1.50000000E-07')
    line = line_of('layout.t', 3)
    read (line, *) values
    call t%check('exponents keep their letter', index(line, 'E-200') > 0 .and. index(line, 'E+123') > 0)
    call t%check_close('and their value', values(3), 1.23456789e123_rp, rtol=1.0e-7_rp)
    call t%check('NaN is written as such', index(line_of('layout.t', 4), 'NaN') > 0)
    call series%open(t%world, 'layout.t', COLUMNS, failure, digits=16)
    call series%write([0.1_rp, 0.2_rp, 0.3_rp])
    call series%close(failure)
    call t%check('a fresh start truncates', lines('layout.t') == 2)
    line = line_of('layout.t', 2)
    read (line, *) values
    call t%check('more digits can be asked for', all(abs(values - [0.1_rp, 0.2_rp, 0.3_rp]) <= 0))
  end subroutine test_layout

  !> Steps of 1/3, whose decimals must be rounded.
  pure function record(i) result(values)
    integer, intent(in) :: i
    real(rp) :: values(3)
    values = [i/3.0_rp, sin(real(i, rp)), cos(real(i, rp))]
  end function record

  subroutine test_restart()
    type(series_t) :: series, whole
    type(failure_t) :: failure
    integer :: i, unit
    logical :: same

    call whole%open(t%world, 'whole.t', COLUMNS, failure)
    do i = 0, 20
      call whole%write(record(i))
    end do
    call whole%close(failure)
    call series%open(t%world, 'parts.t', COLUMNS, failure)
    do i = 0, 14
      call series%write(record(i))
    end do
    call series%close(failure)
    if (t%world%is_root) then ! as a kill in the middle of a record would leave it
      open (newunit=unit, file='parts.t', access='stream', form='unformatted', status='old', &
            position='append')
      write (unit) ' 5.00000000E+00  1.00'
      close (unit)
    end if
    call t%world%barrier()
    call series%open(t%world, 'parts.t', COLUMNS, failure, restart_time=13/3.0_rp)
    do i = 13, 20
      call series%write(record(i))
    end do
    call series%close(failure)
    call t%check('a restart succeeds',.not. failure%failed)
    same = lines('parts.t') == lines('whole.t') .and. lines('whole.t') == 22
    do i = 1, 22
      if (same) same = line_of('parts.t', i) == line_of('whole.t', i)
    end do
    call t%check('an interrupted and restarted series is the uninterrupted one', same)

    call series%open(t%world, 'parts.t', COLUMNS, failure, restart_time=1.0e9_rp)
    call series%close(failure)
    call t%check('a late restart keeps everything', lines('parts.t') == 22)
    if (t%world%is_root) then ! cut off, but looking like a record
      open (newunit=unit, file='parts.t', access='stream', form='unformatted', status='old', &
            position='append')
      write (unit) ' 6.00000000E+00  1.00000000E+00  1.0'
      close (unit)
    end if
    call t%world%barrier()
    call series%open(t%world, 'parts.t', COLUMNS, failure, restart_time=1.0e9_rp)
    call series%close(failure)
    call t%check('a record without its end is dropped', lines('parts.t') == 22)
    call series%open(t%world, 'parts.t', COLUMNS, failure, restart_time=0.0_rp)
    call series%close(failure)
    call t%check('a restart from the beginning keeps only the header', lines('parts.t') == 1)
    call series%open(t%world, 'absent.t', COLUMNS, failure, restart_time=1.0_rp)
    call series%write(record(1))
    call series%close(failure)
    call t%check('a missing series begins at the restart', lines('absent.t') == 2 .and. .not. failure%failed)
    call t%world%barrier()
    if (t%world%is_root) then
      open (newunit=unit, file='absent.t', status='old')
      close (unit, status='delete')
    end if
  end subroutine test_restart

  subroutine test_failures()
    type(series_t) :: series
    type(failure_t) :: missing, full, columns_differ
    call series%open(t%world, 'no/such/folder/x.t', COLUMNS, missing)
    call series%write(record(1))
    call t%check('a missing folder is a failure on all ranks', missing%failed)
    call t%check('that names the file', index(missing%reason, 'no/such/folder/x.t: cannot be written') == 1)
    call series%open(t%world, '/dev/full', COLUMNS, full)
    call t%check('a full disk is a failure when opening', full%failed)
    call t%check('that says so', index(full%reason, '/dev/full: cannot be written; ') == 1 .and. &
                 index(full%reason, 'disk full') > 0)
    call series%close(full)
    call series%open(t%world, 'whole.t', COLUMNS(:2), columns_differ, restart_time=1.0_rp)
    call t%check('another number of columns is a failure', columns_differ%failed)
    call t%check('that names both', index(columns_differ%reason, '3 columns, this run writes 2') > 0)
    call t%check('and leaves the series alone', lines('whole.t') == 22 &
                 .and. .not. file_exists('whole.t.part'))
  end subroutine test_failures

  !> Number of lines of a file.
  integer function lines(path) result(n)
    character(*), intent(in) :: path
    character(:), allocatable :: line
    integer :: unit
    logical :: found
    call t%world%barrier()
    n = 0
    open (newunit=unit, file=path, status='old', action='read')
    do
      call read_line(unit, line, found)
      if (.not. found) exit
      n = n + 1
    end do
    close (unit)
    call t%world%barrier()
  end function lines

  function line_of(path, number) result(line)
    character(*), intent(in) :: path
    integer, intent(in) :: number
    character(:), allocatable :: line
    integer :: unit, i
    logical :: found
    call t%world%barrier()
    open (newunit=unit, file=path, status='old', action='read')
    do i = 1, number
      call read_line(unit, line, found)
    end do
    close (unit)
  end function line_of

  !> Whether line `number` is complete on the disk.
  logical function last_line(path, number)
    character(*), intent(in) :: path
    integer, intent(in) :: number
    last_line = len(line_of(path, number)) > 0 .and. ends_with_newline(path)
  end function last_line
end program test_series

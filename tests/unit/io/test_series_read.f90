! SPDX-License-Identifier: GPL-3.0-or-later
!> A time series is read back as it was written, whatever a kill has left at its end.
program test_series_read
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use io_series, only: series_t
  use io_series_read, only: read_series
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: RECORDS = 3000 !< more than the reader's first buffer
  type(testkit_t) :: t
  type(series_t) :: series
  type(failure_t) :: failure, missing
  real(rp), allocatable :: values(:, :)
  real(rp) :: worst
  integer :: i, unit

  call t%start(parallel=.true.)
  call series%open(t%world, 'run.t', [character(8) :: 'time [T]', 'a', 'b'], failure, digits=16)
  do i = 1, RECORDS
    call series%write([i/3.0_rp, sin(real(i, rp)), 1.0e150_rp/i])
  end do
  call series%close(failure)
  if (t%world%is_root) then
    call read_series('run.t', 3, values, failure)
    worst = huge(worst)
    if (size(values, 2) == RECORDS) then
      worst = 0
      do i = 1, RECORDS
        worst = max(worst, maxval(abs(values(:, i)/[i/3.0_rp, sin(real(i, rp)), 1.0e150_rp/i] - 1)))
      end do
    end if
    open (newunit=unit, file='run.t', access='stream', form='unformatted', status='old', position='append')
    write (unit) ' 5.00000000E+00  1.00'
    close (unit)
  else
    worst = 0
  end if
  call t%check('a series can be read',.not. failure%failed)
  call t%check_below('every record as it was written', worst, 1.0e-15_rp)
  if (t%world%is_root) then
    call read_series('run.t', 3, values, failure)
  else
    allocate (values(3, RECORDS))
  end if
  call t%check('half a record at the end is left out', size(values, 2) == RECORDS .and. .not. failure%failed)
  if (t%world%is_root) then
    open (newunit=unit, file='odd.t', status='replace')
    write (unit, '(a)') '% time [T] a', '  1.0  2.0', '', ' % 3.0 4.0', '  5.0 what', '  6.0  7.0 8.0', '  9.0  1.0E1'
    close (unit)
    call read_series('odd.t', 2, values, failure)
  else
    values = reshape([1.0_rp, 2.0_rp, 9.0_rp, 10.0_rp], [2, 2])
  end if
  call t%check('comments, blank lines and what are no records are left out', size(values, 2) == 2)
  if (size(values, 2) == 2) call t%check('the rest is read', all(abs(values - reshape([1.0_rp, 2.0_rp, 9.0_rp, &
                                                                                       10.0_rp], [2, 2])) <= 0))
  call read_series('no/such/file.t', 2, values, missing)
  call t%check('a missing file is a failure that names it', missing%failed .and. &
               index(missing%reason, 'no/such/file.t') > 0)
  call t%finish()
end program test_series_read

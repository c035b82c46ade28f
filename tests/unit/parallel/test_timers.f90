! SPDX-License-Identifier: GPL-3.0-or-later
!> Timers count calls and time, nested too, and the table shows the spread over the ranks.
program test_timers
  use base_kinds, only: rp, i8
  use base_text_lines, only: read_line, count_words
  use base_timers, only: timers_t
  use parallel_report, only: report_timers
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(timers_t) :: timers
  integer :: whole, inner, unused, unit, i
  character(:), allocatable :: line
  logical :: found, has_line, has_spread
  real(rp) :: least, mean, largest
  integer(i8) :: calls
  character(16) :: name

  call t%start(parallel=.true.)
  whole = timers%region('whole run')
  inner = timers%region('inner')
  unused = timers%region('never entered')
  call t%check('a name has one number', timers%region('inner') == inner .and. timers%count() == 3)
  call t%check('regions have names', timers%name(whole) == 'whole run')
  call timers%start(whole)
  do i = 1, 3
    call timers%start(inner)
    call wait(0.01_rp*(1 + t%world%rank))
    call timers%stop(inner)
  end do
  call wait(0.02_rp)
  call timers%stop(whole)
  call t%check('calls are counted', timers%calls(inner) == 3 .and. timers%calls(whole) == 1)
  call t%check('time is measured', timers%seconds(inner) >= 0.03_rp*(1 + t%world%rank))
  call t%check('an outer region holds the inner one', &
               timers%seconds(whole) >= timers%seconds(inner) + 0.02_rp)
  call t%check('a region that was never entered took no time', abs(timers%seconds(unused)) <= 0)

  open (newunit=unit, status='scratch', action='readwrite')
  call report_timers(t%world, timers, whole, unit)
  rewind (unit)
  has_line = .true.
  has_spread = .true.
  if (t%world%is_root) then
    do i = 0, inner
      call read_line(unit, line, found)
    end do
    read (line, *) name, calls, least, mean, largest
    has_line = name == 'inner' .and. calls == 3 .and. count_words(line) == 6
    has_spread = least >= 0.0295_rp .and. mean >= least .and. largest >= mean .and. &
                 largest >= 0.0295_rp*t%world%size
  end if
  call t%check('the table has a line for each region', has_line)
  call t%check('min, mean and max are over the ranks', has_spread)
  close (unit)
  call t%finish()

contains

  subroutine wait(seconds)
    real(rp), intent(in) :: seconds
    integer(i8) :: began, now, rate
    call system_clock(began, rate)
    do
      call system_clock(now)
      if (real(now - began, rp)/real(rate, rp) >= seconds) exit
    end do
  end subroutine wait
end program test_timers

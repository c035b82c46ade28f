! SPDX-License-Identifier: GPL-3.0-or-later
!> Averages over wing beats: unevenly spaced records, beats cut by them, incomplete beats.
program test_beats
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use fsi_beats, only: beat_statistics, beat_t, complete_beats
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call test_count()
  call test_line()
  call test_sine()
  call kit%finish()

contains

  subroutine test_count()
    call kit%check('no record, no beat', complete_beats([real(rp) ::], 1.0_rp) == 0)
    call kit%check('one record is no beat', complete_beats([0.0_rp], 1.0_rp) == 0)
    call kit%check('a beat must be finished', complete_beats([0.0_rp, 0.9_rp], 1.0_rp) == 0)
    call kit%check('a record may miss its end by a thousandth', complete_beats([0.0_rp, 0.9991_rp], 1.0_rp) == 1 .and. &
                   complete_beats([0.0_rp, 0.9989_rp], 1.0_rp) == 0)
    call kit%check('the period counts', complete_beats([0.0_rp, 0.5_rp, 1.0_rp], 0.25_rp) == 4 .and. &
                   complete_beats([0.0_rp, 0.5_rp, 1.0_rp], 0.3_rp) == 3)
    call kit%check('a series that begins later has no whole beats from 0', &
                   complete_beats([0.1_rp, 5.0_rp], 1.0_rp) == 0 .and. complete_beats([0.0009_rp, 5.0_rp], 1.0_rp) == 5)
  end subroutine test_count

  !> Between records the quantity is a straight line, so that a line is averaged exactly wherever the records are,
  !> also when the ends of the beat lie between two of them.
  subroutine test_line()
    real(rp), parameter :: TIMES(6) = [0.0_rp, 0.3_rp, 0.9_rp, 1.7_rp, 2.4_rp, 3.1_rp]
    type(beat_t) :: beat
    beat = beat_statistics(TIMES, 2*TIMES + 1, 1.0_rp, 2)
    call kit%check_close('the mean of a line is its value in the middle', beat%mean, 4.0_rp, rtol=1.0e-15_rp)
    call kit%check_close('extremes are those of the records inside', beat%largest, 4.4_rp, rtol=1.0e-15_rp)
    call kit%check_close('here only one', beat%smallest, 4.4_rp, rtol=1.0e-15_rp)
    beat = beat_statistics(TIMES, 2*TIMES + 1, 1.55_rp, 2)
    call kit%check_close('with another period too', beat%mean, 2*2.325_rp + 1, rtol=1.0e-15_rp)
    beat = beat_statistics(TIMES, [9.0_rp, 8.0_rp, 5.0_rp, 1.0_rp, 0.0_rp, 0.0_rp], 1.7_rp, 1, start=0.3_rp)
    call kit%check('extremes after the start', abs(beat%largest - 8) <= 0 .and. abs(beat%smallest - 1) <= 0)
    beat = beat_statistics(TIMES, [9.0_rp, 8.0_rp, 5.0_rp, 1.0_rp, 0.0_rp, 0.0_rp], 1.7_rp, 1, start=0.4_rp)
    call kit%check('a record before it has no part', abs(beat%largest - 5) <= 0)
    call kit%check_close('the mean is that of the whole beat', beat%mean, (2.55_rp + 3.9_rp + 2.4_rp)/1.7_rp, rtol=1.0e-14_rp)
    ! The last record misses the end: the mean is that of what is covered.
    beat = beat_statistics([0.0_rp, 0.5_rp, 0.9995_rp], [0.0_rp, 0.5_rp, 0.9995_rp], 1.0_rp, 1)
    call kit%check_close('what a last record does not reach is left out', beat%mean, 0.9995_rp/2, rtol=1.0e-14_rp)
  end subroutine test_line

  !> Smooth functions to second order of the record's distance, at distances that vary by a factor of three and
  !> never meet the ends of a beat.
  subroutine test_sine()
    integer, parameter :: RECORDS(3) = [67, 134, 268]
    real(rp) :: h(3), error(3, 3)
    real(rp), allocatable :: times(:), values(:)
    type(beat_t) :: beat
    integer :: i, k, n
    do i = 1, size(RECORDS)
      n = RECORDS(i)
      times = [(3.2_rp*(real(k, rp)/n + 0.5_rp/(7*TWO_PI)*sin(7*TWO_PI*k/n)), k=0, n)]
      values = 2 + sin(TWO_PI*times/1.05_rp) + 3*sin(TWO_PI*times)**2
      h(i) = 3.2_rp/n
      do k = 1, 3
        beat = beat_statistics(times, values, 1.0_rp, k)
        error(i, k) = abs(beat%mean - exact(k))
      end do
    end do
    call kit%check('the records are uneven', maxval(times(2:) - times(:n)) > 2.5_rp*minval(times(2:) - times(:n)))
    do k = 1, 3
      ! The error of a polygon is below h^2/8 max|f''| = h^2/8 (36 + 3 (4 pi)^2/2); the largest h is 1.5 times the mean.
      call kit%check_below('the mean of a beat to h^2', maxval(error(:, k)/h**2), 1.5_rp**2/8*273.0_rp)
      call kit%check_below('also on the finest series', error(3, k), 1.5e-3_rp)
    end do
    call kit%check_below('four times the records, a sixteenth of the error', sum(error(3, :))/sum(error(1, :)), &
                         1.6_rp/16)
    times = [(2 + real(k, rp)/10000, k=0, 10000)]
    values = 2 + sin(TWO_PI*times/1.05_rp) + 3*sin(TWO_PI*times)**2
    call kit%check_close('extremes are met to h^2 as well', beat%largest, maxval(values), atol=1.5_rp**2/8*273*h(3)**2)
    call kit%check_close('on both sides', beat%smallest, minval(values), atol=1.5_rp**2/8*273*h(3)**2)
  end subroutine test_sine

  real(rp) function exact(k)
    integer, intent(in) :: k
    real(rp), parameter :: W = TWO_PI/1.05_rp
    exact = 3.5_rp + (cos(W*(k - 1)) - cos(W*k))/W
  end function exact
end program test_beats

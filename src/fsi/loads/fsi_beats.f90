! SPDX-License-Identifier: GPL-3.0-or-later
!> Averages time series over wing beats.
module fsi_beats
  use base_kinds, only: rp
  implicit none
  private
  public :: beat_t, complete_beats, beat_statistics

  !> One quantity over one wing beat.
  type :: beat_t
    real(rp) :: mean = 0
    real(rp) :: smallest = 0, largest = 0 !< of the records
  end type beat_t

contains

  !> Returns the number of whole periods from 0 that the records at `times` (ascending) cover. A record may miss the end of the
  !> last period by a thousandth of it.
  pure integer function complete_beats(times, period) result(n)
    real(rp), intent(in) :: times(:), period
    n = 0
    if (size(times) < 2) return
    if (times(1) > 1.0e-3_rp*period) return
    n = int(times(size(times))/period + 1.0e-3_rp)
  end function complete_beats

  !> Returns the statistics of period k = 1, 2, .. that begins at (k-1) period. The mean is the integral of the polygon through
  !> the records, cut at both ends of the period, over its length. Extremes are those after the first `start` of the period.
  pure type(beat_t) function beat_statistics(times, values, period, k, start) result(beat)
    real(rp), intent(in) :: times(:), values(:) !< of the same size, times strictly ascending
    real(rp), intent(in) :: period
    integer, intent(in) :: k
    real(rp), intent(in), optional :: start !< of the same unit as times
    real(rp) :: from, upto, a, b, integral, span, slope, settled
    integer :: i
    from = (k - 1)*period
    upto = k*period
    integral = 0
    span = 0
    settled = from
    if (present(start)) settled = from + start
    beat%smallest = huge(1.0_rp)
    beat%largest = -huge(1.0_rp)
    do i = 1, size(times)
      if (times(i) < settled .or. times(i) > upto) cycle
      beat%smallest = min(beat%smallest, values(i))
      beat%largest = max(beat%largest, values(i))
    end do
    do i = 1, size(times) - 1
      a = max(times(i), from)
      b = min(times(i + 1), upto)
      if (b <= a) cycle
      slope = (values(i + 1) - values(i))/(times(i + 1) - times(i))
      integral = integral + (b - a)*(values(i) + slope*((a + b)/2 - times(i)))
      span = span + b - a
    end do
    if (span > 0) beat%mean = integral/span
  end function beat_statistics
end module fsi_beats

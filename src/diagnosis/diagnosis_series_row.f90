! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds a measured record of a vibrating wing and the computed ones, for reports.
module diagnosis_series_row
  use base_kinds, only: rp
  implicit none
  private
  public :: series_row_t

  !> Holds the motion of the baseline (1) and of the extended wing (2) where a record was taken, with the most probable errors of
  !> size and time of the excitation. Without an extended wing both are those of the baseline.
  type :: series_row_t
    real(rp) :: size_error(2) = 0           !< relative
    real(rp) :: late(2) = 0                 !< [s]
    real(rp) :: rms(2) = 0                  !< root mean square of the residuals, in units of the sd
    real(rp), allocatable :: seen(:, :, :)  !< (samples, traces, 2) simulated, in the units of the record
  end type series_row_t
end module diagnosis_series_row

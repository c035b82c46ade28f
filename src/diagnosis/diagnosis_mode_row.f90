! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds a measured natural mode and the computed ones that belong to it, for reports.
module diagnosis_mode_row
  use base_kinds, only: rp
  implicit none
  private
  public :: mode_row_t

  !> Holds the modes of the baseline (1) and of the extended wing (2) that belong to a measured mode. Without an extended wing both
  !> are those of the baseline.
  type :: mode_row_t
    integer :: number(2) = 0                !< of the computed mode, or of the first of its cluster
    real(rp) :: frequency(2) = 0            !< [Hz]
    real(rp) :: mac(2) = 0
    real(rp) :: damping(2) = 0              !< ratio, where one was measured
    real(rp), allocatable :: shape(:, :)    !< (places, 2) in the units of the measured one, scaled to the same length along it
  end type mode_row_t
end module diagnosis_mode_row

! SPDX-License-Identifier: GPL-3.0-or-later
!> Made by bench/diagnosis/run --write-map; do not edit.
!> Calibration error of its 127 even cases: 0.070 without, 0.065 with this map.
module inference_probability_of_vibration
  use base_kinds, only: rp
  implicit none
  private
  public :: VERDICT, RAW, RIGHT, PROVENANCE

  integer, parameter :: KNOTS = 5
  integer, parameter :: VERDICT(KNOTS) = [ &
             0, &
             0, &
             0, &
             10, &
             11] !< exit code
  real(rp), parameter :: RAW(KNOTS) = [ &
             0.629503523_rp, &
             0.732678704_rp, &
             0.793961155_rp, &
             0.999341010_rp, &
             0.834515075_rp]   !< probability by the odds, ascending for each verdict
  real(rp), parameter :: RIGHT(KNOTS) = [ &
             0.590909091_rp, &
             0.850000000_rp, &
             0.983333333_rp, &
             0.953125000_rp, &
             0.712121212_rp] !< share of right verdicts
  character(*), parameter :: PROVENANCE = 'study of seed 29112026, 128 odd of 255 cases, program 86be67317b31'
end module inference_probability_of_vibration

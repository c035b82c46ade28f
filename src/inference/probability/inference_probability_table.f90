! SPDX-License-Identifier: GPL-3.0-or-later
!> Made by bench/diagnosis/run --write-map; do not edit.
!> Calibration error of its 380 even cases: 0.071 without, 0.046 with this map.
module inference_probability_table
  use base_kinds, only: rp
  implicit none
  private
  public :: VERDICT, RAW, RIGHT, PROVENANCE

  integer, parameter :: KNOTS = 19
  integer, parameter :: VERDICT(KNOTS) = [ &
             0, &
             0, &
             0, &
             0, &
             0, &
             0, &
             0, &
             10, &
             10, &
             10, &
             10, &
             11, &
             11, &
             11, &
             11, &
             11, &
             12, &
             12, &
             12] !< exit code
  real(rp), parameter :: RAW(KNOTS) = [ &
             0.342684515_rp, &
             0.535581482_rp, &
             0.615702931_rp, &
             0.669137198_rp, &
             0.759199427_rp, &
             0.806132241_rp, &
             0.820000822_rp, &
             0.945738487_rp, &
             0.987560071_rp, &
             0.999935867_rp, &
             0.999999975_rp, &
             0.220827745_rp, &
             0.398590939_rp, &
             0.628144322_rp, &
             0.904778437_rp, &
             0.996806713_rp, &
             0.769718584_rp, &
             0.981040584_rp, &
             0.999999874_rp]   !< probability by the odds, ascending for each verdict
  real(rp), parameter :: RIGHT(KNOTS) = [ &
             0.083333333_rp, &
             0.300000000_rp, &
             0.346153846_rp, &
             0.500000000_rp, &
             0.720183486_rp, &
             0.725000000_rp, &
             0.976190476_rp, &
             0.250000000_rp, &
             0.833333333_rp, &
             0.863636364_rp, &
             0.991071429_rp, &
             0.357142857_rp, &
             0.527777778_rp, &
             0.611111111_rp, &
             0.847826087_rp, &
             0.979166667_rp, &
             0.642857143_rp, &
             0.928571429_rp, &
             0.979166667_rp] !< share of right verdicts
  character(*), parameter :: PROVENANCE = 'study of seed 23112026, 381 odd of 762 cases, program dc0c3f3f111e'
end module inference_probability_table

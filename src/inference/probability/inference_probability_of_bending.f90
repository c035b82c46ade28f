! SPDX-License-Identifier: GPL-3.0-or-later
!> Made by bench/diagnosis/run --write-map; do not edit.
!> Calibration error of its 380 even cases: 0.071 without, 0.051 with this map.
module inference_probability_of_bending
  use base_kinds, only: rp
  implicit none
  private
  public :: VERDICT, RAW, RIGHT, PROVENANCE

  integer, parameter :: KNOTS = 14
  integer, parameter :: VERDICT(KNOTS) = [ &
             0, &
             0, &
             0, &
             0, &
             0, &
             10, &
             10, &
             10, &
             11, &
             11, &
             11, &
             11, &
             12, &
             12] !< exit code
  real(rp), parameter :: RAW(KNOTS) = [ &
             0.535437318_rp, &
             0.669137198_rp, &
             0.759199427_rp, &
             0.806132241_rp, &
             0.820000822_rp, &
             0.982913229_rp, &
             0.999935867_rp, &
             0.999999975_rp, &
             0.352217932_rp, &
             0.628144322_rp, &
             0.904778437_rp, &
             0.996806713_rp, &
             0.932273969_rp, &
             0.999999874_rp]   !< probability by the odds, ascending for each verdict
  real(rp), parameter :: RIGHT(KNOTS) = [ &
             0.250000000_rp, &
             0.500000000_rp, &
             0.720183486_rp, &
             0.725000000_rp, &
             0.976190476_rp, &
             0.750000000_rp, &
             0.863636364_rp, &
             0.991071429_rp, &
             0.479166667_rp, &
             0.611111111_rp, &
             0.847826087_rp, &
             0.979166667_rp, &
             0.870370370_rp, &
             0.979166667_rp] !< share of right verdicts
  character(*), parameter :: PROVENANCE = 'study of seed 23112026, 381 odd of 762 cases, program dc0c3f3f111e'
end module inference_probability_of_bending

! SPDX-License-Identifier: GPL-3.0-or-later
!> Made by bench/diagnosis/run --write-map; do not edit. No study: every probability stays as the odds give it.
module inference_probability_of_vibration
  use base_kinds, only: rp
  implicit none
  private
  public :: VERDICT, RAW, RIGHT, PROVENANCE

  integer, parameter :: KNOTS = 0
  integer, parameter :: VERDICT(KNOTS) = [integer ::] !< exit code
  real(rp), parameter :: RAW(KNOTS) = [real(rp) ::]   !< probability by the odds, ascending for each verdict
  real(rp), parameter :: RIGHT(KNOTS) = [real(rp) ::] !< share of right verdicts
  character(*), parameter :: PROVENANCE = 'none: probabilities as the odds give them'
end module inference_probability_of_vibration

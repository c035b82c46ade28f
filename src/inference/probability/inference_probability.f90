! SPDX-License-Identifier: GPL-3.0-or-later
!> Maps the probability that the odds give to a verdict to the fraction of such verdicts that were right in a study of blind
!> cases, by isotonic regression (Zadrozny and Elkan 2002, DOI 10.1145/775047.775151), with one map for each kind of verdict.
!> bench/diagnosis/run learns the map and writes inference_probability_table.
module inference_probability
  use base_kinds, only: rp
  use inference_probability_table, only: RAW, RIGHT, VERDICT, PROVENANCE
  implicit none
  private
  public :: calibrated_probability, follow_knots, PROVENANCE

contains

  !> Returns the probability to print for a verdict (its exit code) of probability `p`, from 0 to 1. Kinds without a map keep p.
  pure real(rp) function calibrated_probability(code, p) result(probability)
    integer, intent(in) :: code
    real(rp), intent(in) :: p
    probability = follow_knots(pack(RAW, VERDICT == code), pack(RIGHT, VERDICT == code), p)
  end function calibrated_probability

  !> Returns the value at p of the straight lines between the points (x, y), x ascending, and beyond them the last value; p itself
  !> without points.
  pure real(rp) function follow_knots(x, y, p) result(value)
    real(rp), intent(in) :: x(:), y(:), p
    integer :: i
    value = p
    if (size(x) == 0) return
    i = count(x <= p)
    if (i == 0) then
      value = y(1)
    else if (i == size(x)) then
      value = y(i)
    else
      value = y(i) + (y(i + 1) - y(i))*(p - x(i))/(x(i + 1) - x(i))
    end if
  end function follow_knots
end module inference_probability

! SPDX-License-Identifier: GPL-3.0-or-later
!> Maps the probability that the odds give to a verdict to the fraction of such verdicts that were right in a study of blind
!> cases, by isotonic regression (Zadrozny and Elkan 2002, DOI 10.1145/775047.775151), with one map for each kind of verdict.
!> Bending tests, and natural modes and records without them, have studies of their own; flights alone have none and take the map
!> of bending. bench/diagnosis/run learns a map and writes it as a module of this folder.
module inference_probability
  use base_kinds, only: rp
  use inference_probability_of_bending, only: BENDING_RAW => RAW, BENDING_RIGHT => RIGHT, BENDING_VERDICT => VERDICT, &
                                              BENDING_PROVENANCE => PROVENANCE
  use inference_probability_of_vibration, only: VIBRATION_RAW => RAW, VIBRATION_RIGHT => RIGHT, VIBRATION_VERDICT => VERDICT, &
                                                VIBRATION_PROVENANCE => PROVENANCE
  implicit none
  private
  public :: calibrated_probability, follow_knots, provenance_of

  integer, parameter, public :: MAP_OF_BENDING = 1, MAP_OF_VIBRATION = 2 !< the maps, by the data of their studies

contains

  !> Returns the probability to print for a verdict (its exit code) of probability `p`, from 0 to 1, by a map. Kinds of verdicts
  !> that are not in the map keep p.
  pure real(rp) function calibrated_probability(map, code, p) result(probability)
    integer, intent(in) :: map, code
    real(rp), intent(in) :: p
    if (map == MAP_OF_VIBRATION) then
      probability = follow_knots(pack(VIBRATION_RAW, VIBRATION_VERDICT == code), &
                                 pack(VIBRATION_RIGHT, VIBRATION_VERDICT == code), p)
    else
      probability = follow_knots(pack(BENDING_RAW, BENDING_VERDICT == code), pack(BENDING_RIGHT, BENDING_VERDICT == code), p)
    end if
  end function calibrated_probability

  !> Returns the words that tell from which study a map was learned.
  pure function provenance_of(map) result(words)
    integer, intent(in) :: map
    character(:), allocatable :: words
    words = BENDING_PROVENANCE
    if (map == MAP_OF_VIBRATION) words = VIBRATION_PROVENANCE
  end function provenance_of

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

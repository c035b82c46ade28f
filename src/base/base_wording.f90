! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the words for the value of a parameter: a scale converts it into a number that readers know, and words are placed
!> around it.
!>
!> Scales, for a value v, its reference r at which nothing happens, and a constant c of the wording:
!>
!> | scale | what is displayed |
!> |---|---|
!> | FACTOR | v/r, as per cent more or less, or as "3.1 times" |
!> | EXPONENT | the factor exp(v) |
!> | LINEAR | the factor 1 + c v |
!> | CONTRAST | the factor (1 + v)/(1 - v) of the stiffness along over that across |
!> | HALF | the factor 2^(r - v) by which a vein of half the diameter is stiffer |
!> | PLAIN | c (v - r), with a unit |
!> | FRACTION | v itself |
!>
!> Directions are those of the wing file: x points to the tip, z up. The word `up` of a wording is used if the displayed number is
!> larger than without the cause.
module base_wording
  use base_kinds, only: rp
  implicit none
  private
  public :: wording_t, displayed, word_by_name, word_degrees, word_factor, word_fraction, word_plain

  integer, parameter, public :: SCALE_FACTOR = 1, SCALE_EXPONENT = 2, SCALE_LINEAR = 3, SCALE_CONTRAST = 4, SCALE_HALF = 5, &
                                SCALE_PLAIN = 6, SCALE_FRACTION = 7
  real(rp), parameter, public :: DEGREES = 57.295779513082323_rp !< of one rad
  character(*), parameter, public :: UNIT_OF_PARAMETER = '@'
  character(*), parameter, public :: ASSUMED = 'than was assumed'

  type :: wording_t
    integer :: scale = SCALE_PLAIN
    real(rp) :: reference = 0            !< value at which nothing happens
    logical :: is_natural = .false.      !< `reference` is the value of the law of nature, not an assumption of the model
    real(rp) :: factor = 1               !< c
    character(:), allocatable :: unit    !< of the number, or empty; UNIT_OF_PARAMETER: that of the parameter
    character(:), allocatable :: up, down    !< words before the number
    character(:), allocatable :: more, less  !< behind it, and then `than`
    character(:), allocatable :: than
    character(:), allocatable :: times       !< behind ".. times", in their place
    logical :: is_known = .false.        !< the parameter has its own words
  end type wording_t

contains

  !> Returns what is displayed of a value: a factor, a share, or an amount in the unit of the wording; see the table above.
  pure elemental real(rp) function displayed(w, value) result(shown)
    type(wording_t), intent(in) :: w
    real(rp), intent(in) :: value
    real(rp), parameter :: LARGEST = 300.0_rp, ALMOST = 1.0e-12_rp
    select case (w%scale)
    case (SCALE_FACTOR)
      shown = value/w%reference
    case (SCALE_EXPONENT)
      shown = exp(min(LARGEST, max(-LARGEST, value)))
    case (SCALE_LINEAR)
      shown = 1 + w%factor*value
    case (SCALE_CONTRAST)
      shown = (1 + value)/max(ALMOST, 1 - value)
    case (SCALE_HALF)
      shown = 2.0_rp**(w%reference - value)
    case (SCALE_PLAIN)
      shown = w%factor*(value - w%reference)
    case default
      shown = value
    end select
  end function displayed

  !> Gives `w` the words of a number that is a factor on one of the scales of factors. The texts are in the order of the sentence.
  !> `reference` is the value at which nothing happens, if the law itself defines it.
  pure subroutine word_factor(w, scale, up, down, more, less, than, times, reference)
    type(wording_t), intent(inout) :: w
    integer, intent(in) :: scale
    character(*), intent(in) :: up, down, more, less, than, times
    real(rp), intent(in), optional :: reference
    call word_plain(w, '%', up, down, more, less, than, reference)
    w%scale = scale
    w%times = times
  end subroutine word_factor

  !> Gives `w` the words of a number without a unit that is displayed as it is.
  pure subroutine word_fraction(w, up, down, than, reference)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: up, down, than
    real(rp), intent(in), optional :: reference
    call word_plain(w, '', up, down, '', '', than, reference)
    w%scale = SCALE_FRACTION
  end subroutine word_fraction

  !> Gives `w` the words of an amount in `unit`. The texts are in the order of the sentence. `reference` is the value at which
  !> nothing happens, if the law itself defines it.
  pure subroutine word_plain(w, unit, up, down, more, less, than, reference)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: unit, up, down, more, less, than
    real(rp), intent(in), optional :: reference
    w%unit = trim(unit)
    w%up = up
    w%down = down
    w%more = more
    w%less = less
    w%than = than
    w%times = than
    w%is_natural = present(reference)
    if (present(reference)) w%reference = reference
  end subroutine word_plain

  !> Gives `w` the words of an angle in rad, which is displayed in degrees. It is 0 when nothing happens.
  pure subroutine word_degrees(w, lead, more, less)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: lead, more, less
    call word_plain(w, 'degrees', lead, lead, more, less, '', 0.0_rp)
    w%factor = DEGREES
  end subroutine word_degrees

  !> Gives `w` the words of a parameter that people know by its name.
  pure subroutine word_by_name(w, name)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name
    call word_plain(w, UNIT_OF_PARAMETER, name//' is', name//' is', 'more', 'less', ASSUMED)
  end subroutine word_by_name
end module base_wording

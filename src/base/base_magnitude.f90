! SPDX-License-Identifier: GPL-3.0-or-later
!> Warns of values that are wrong by orders of magnitude, as happens when a user confuses units.
module base_magnitude
  use base_kinds, only: rp
  use base_text, only: number_text
  implicit none
  private
  public :: magnitude_doubt, rounded

  integer, parameter :: POWERS(6) = [3, 6, 9, -3, -6, -9]
  character(1), parameter :: PREFIXES(6) = ['k', 'M', 'G', 'm', 'u', 'n']

contains

  !> Returns '' if `value` lies between `least` and `most`, both positive. Otherwise it returns a sentence that names this range,
  !> which is usual for `whose`. If another power of a thousand brings the value into the range, the sentence suggests that unit.
  !> All values are in the same `unit`. Without `has_prefixes` the unit takes no prefixes such as kilo.
  pure function magnitude_doubt(value, least, most, unit, whose, has_prefixes) result(text)
    real(rp), intent(in) :: value, least, most
    character(*), intent(in) :: unit, whose
    logical, intent(in) :: has_prefixes
    character(:), allocatable :: text
    real(rp) :: off(size(POWERS))
    integer :: k
    text = ''
    if (value >= least .and. value <= most) return
    text = number_text(value)//' '//unit//' is too '//trim(merge('large', 'small', value > most))//' for '//whose//', which '// &
           'have '//number_text(least)//' to '//number_text(most)//' '//unit
    if (.not. value > 0) return
    off = abs(log10(value) + POWERS - log10(least*most)/2)
    k = minloc(off, 1)
    if (off(k) > log10(most/least)/2) return
    if (has_prefixes) then
      text = text//'; if the value is in '//with_prefix(k, unit)//', write '//shifted(value, POWERS(k))
    else
      text = text//'; is the value in another unit? '//shifted(value, POWERS(k))//' would be usual'
    end if
  end function magnitude_doubt

  !> Returns the positive number `x` rounded to its first `digits` digits; other numbers stay as they are.
  elemental real(rp) function rounded(x, digits) result(y)
    real(rp), intent(in) :: x
    integer, intent(in) :: digits
    integer :: n
    y = x
    if (.not. (x > 0 .and. x <= huge(x))) return
    n = digits - 1 - floor(log10(x))
    if (n >= 0) then
      y = anint(x*10.0_rp**n)/10.0_rp**n
    else
      y = anint(x/10.0_rp**(-n))*10.0_rp**(-n)
    end if
  end function rounded

  !> Returns the name of the unit times 10^POWERS(k).
  pure function with_prefix(k, unit) result(text)
    integer, intent(in) :: k
    character(*), intent(in) :: unit
    character(:), allocatable :: text
    character(2), parameter :: OF_MASS(6) = [character(2) :: 't', 'kt', 'Mt', 'g', 'mg', 'ug']
    text = PREFIXES(k)//unit
    if (unit == 'kg') text = trim(OF_MASS(k))
  end function with_prefix

  !> Returns the number with another decimal exponent, as a user would write it.
  pure function shifted(value, power) result(text)
    real(rp), intent(in) :: value
    integer, intent(in) :: power
    character(:), allocatable :: text
    text = number_text(value)
    if (scan(text, 'eE') > 0) then
      text = number_text(value*10.0_rp**power)
    else
      text = text//'e'//number_text(power)
    end if
  end function shifted
end module base_magnitude

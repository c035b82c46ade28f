! SPDX-License-Identifier: GPL-3.0-or-later
!> Numbers in sentences for people.
module base_decimal
  use base_kinds, only: rp
  implicit none
  private
  public :: fixed

contains

  !> Returns a number below 1e24 with `decimals` digits, at most 12, after the decimal point.
  pure function fixed(x, decimals) result(text)
    real(rp), intent(in) :: x
    integer, intent(in) :: decimals
    character(:), allocatable :: text
    character(40) :: buffer, form
    write (form, '(a,i0,a)') '(f40.', decimals, ')'
    write (buffer, form) x
    text = trim(adjustl(buffer))
    if (text(len(text):) == '.') text = text(:len(text) - 1)
  end function fixed
end module base_decimal

! SPDX-License-Identifier: GPL-3.0-or-later
!> Numbers in sentences for people.
module base_decimal
  use base_kinds, only: rp
  implicit none
  private
  public :: one_decimal

contains

  !> Returns a number below 1e12 with one decimal.
  pure function one_decimal(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    character(16) :: buffer
    write (buffer, '(f15.1)') x
    text = trim(adjustl(buffer))
  end function one_decimal
end module base_decimal

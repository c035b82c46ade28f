! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes numbers for the line of JSON that ends a benchmark.
module bench_json
  use base_kinds, only: rp
  implicit none
  private
  public :: number

contains

  !> Writes a number in the form that JSON requires: with a digit before the decimal point.
  function number(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    character(20) :: buffer
    write (buffer, '(f20.4)') x
    text = trim(adjustl(buffer))
  end function number
end module bench_json

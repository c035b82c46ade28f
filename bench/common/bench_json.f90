! SPDX-License-Identifier: GPL-3.0-or-later
!> Numbers in the line of JSON that ends a benchmark.
module bench_json
  use base_kinds, only: rp
  implicit none
  private
  public :: number

contains

  !> A number as JSON wants it: with a digit before the point.
  function number(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    character(20) :: buffer
    write (buffer, '(f20.4)') x
    text = trim(adjustl(buffer))
  end function number
end module bench_json

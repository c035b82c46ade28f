! SPDX-License-Identifier: GPL-3.0-or-later
!> What a test takes from its command line, and a small generator for reproducible damage.
module test_pick
  use base_kinds, only: i8
  implicit none
  private
  public :: picker_t, argument, asked_transform

  !> A linear congruential generator, the same everywhere.
  type :: picker_t
    integer(i8) :: state = 1
  contains
    procedure :: pick => picker_pick
  end type picker_t

contains

  !> Equally distributed in 1 .. n.
  integer function picker_pick(self, n) result(number)
    class(picker_t), intent(inout) :: self
    integer, intent(in) :: n
    self%state = modulo(1103515245_i8*self%state + 12345_i8, 2147483648_i8)
    number = 1 + int(modulo(self%state/65536_i8, int(n, i8)))
  end function picker_pick

  !> Argument `number` of the command line, or `default`.
  integer function argument(number, default) result(value)
    integer, intent(in) :: number, default
    character(20) :: text
    value = default
    if (command_argument_count() < number) return
    call get_command_argument(number, text)
    read (text, *) value
  end function argument

  !> The transform that the test was started for: its first argument, or `builtin`.
  function asked_transform() result(name)
    character(:), allocatable :: name
    character(20) :: text
    name = 'builtin'
    if (command_argument_count() < 1) return
    call get_command_argument(1, text)
    name = trim(text)
  end function asked_transform
end module test_pick

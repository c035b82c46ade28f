! SPDX-License-Identifier: GPL-3.0-or-later
!> The arguments with which a program was called.
module app_arguments
  implicit none
  private
  public :: argument_text

contains

  !> Argument i as long as it is; empty if there is none.
  function argument_text(i) result(text)
    integer, intent(in) :: i
    character(:), allocatable :: text
    integer :: length
    call get_command_argument(i, length=length)
    allocate (character(length) :: text)
    call get_command_argument(i, text)
  end function argument_text
end module app_arguments

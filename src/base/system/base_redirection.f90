! SPDX-License-Identifier: GPL-3.0-or-later
!> Sends everything that the program prints to a file for a while, and changes the current folder. With it a program runs a part
!> that was written as a separate program. Not collective.
module base_redirection
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_errors, only: require
  implicit none
  private
  public :: change_folder, redirection_t

  !> Output and errors.
  type :: redirection_t
    integer(c_int), private :: kept(2) = -1
  contains
    procedure :: begin => redirection_begin
    procedure :: finish => redirection_finish
  end type redirection_t

  integer(c_int), parameter :: STREAMS(2) = [1_c_int, 2_c_int], MODE = 438 !< 666 octal, less the mask of the process

  interface
    integer(c_int) function c_creat(path, mode) bind(C, name='creat') ! mode_t is an unsigned int
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function c_creat

    integer(c_int) function c_dup(descriptor) bind(C, name='dup')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_dup

    integer(c_int) function c_dup2(from, to) bind(C, name='dup2')
      import :: c_int
      integer(c_int), value :: from, to
    end function c_dup2

    integer(c_int) function c_close(descriptor) bind(C, name='close')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_close

    integer(c_int) function c_chdir(path) bind(C, name='chdir')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: path(*)
    end function c_chdir
  end interface

contains

  !> Sends output and errors to the new file `path`. If the file cannot be created, they are not redirected.
  subroutine redirection_begin(self, path)
    class(redirection_t), intent(inout) :: self
    character(*), intent(in) :: path
    integer(c_int) :: file, i, ignored
    flush (output_unit)
    flush (error_unit)
    file = c_creat(path//c_null_char, MODE)
    if (file < 0) return
    do i = 1, 2
      self%kept(i) = c_dup(STREAMS(i))
      if (self%kept(i) >= 0) ignored = c_dup2(file, STREAMS(i))
    end do
    ignored = c_close(file)
  end subroutine redirection_begin

  !> Restores the previous destinations of output and errors.
  subroutine redirection_finish(self)
    class(redirection_t), intent(inout) :: self
    integer(c_int) :: i, ignored
    flush (output_unit)
    flush (error_unit)
    do i = 1, 2
      if (self%kept(i) < 0) cycle
      ignored = c_dup2(self%kept(i), STREAMS(i))
      ignored = c_close(self%kept(i))
    end do
    self%kept = -1
  end subroutine redirection_finish

  !> Changes the current folder of the process to `path`, which exists.
  subroutine change_folder(path)
    character(*), intent(in) :: path
    call require(c_chdir(path//c_null_char) == 0, 'base_redirection: a folder that can be entered: '//path)
  end subroutine change_folder
end module base_redirection

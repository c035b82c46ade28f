! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes text files, and reports when one cannot be written.
!>
!> The files are written through the C library, because the run-time library of gfortran 12 reports success for a WRITE, a FLUSH and
!> a CLOSE on a full disk.
module base_text_file
  use base_errors, only: failure_t, require
  use base_files, only: replace_file, remove_file
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_ptr, c_size_t, c_null_char, c_null_ptr, c_associated
  implicit none
  private
  public :: text_file_t, write_text, reserve_space

  character(*), parameter :: UNWRITABLE = ': cannot be written; is the folder missing or read-only, or the disk full?'

  !> A text file open for writing.
  type :: text_file_t
    private
    type(c_ptr) :: stream = c_null_ptr
    character(:), allocatable :: path
  contains
    procedure :: create => text_file_create
    procedure :: create_new => text_file_create_new
    procedure :: append => text_file_append
    procedure :: is_open => text_file_is_open
    procedure :: write => text_file_write
    procedure :: flush => text_file_flush
    procedure :: close => text_file_close
  end type text_file_t

  interface
    type(c_ptr) function c_fopen(path, mode) bind(C, name='fopen')
      import :: c_ptr, c_char
      character(kind=c_char), intent(in) :: path(*), mode(*)
    end function c_fopen

    integer(c_size_t) function c_fwrite(text, size, count, stream) bind(C, name='fwrite')
      import :: c_size_t, c_ptr, c_char
      character(kind=c_char), intent(in) :: text(*)
      integer(c_size_t), value :: size, count
      type(c_ptr), value :: stream
    end function c_fwrite

    integer(c_int) function c_fflush(stream) bind(C, name='fflush')
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
    end function c_fflush

    integer(c_int) function c_fclose(stream) bind(C, name='fclose')
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
    end function c_fclose
  end interface

contains

  !> Opens a new, empty file, replacing an existing one. Does nothing after a failure; fails if there can be no such file.
  subroutine text_file_create(self, path, failure)
    class(text_file_t), intent(inout) :: self
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    call open_stream(self, path, 'w', failure)
  end subroutine text_file_create

  !> Does the same, but fails if something of this name exists.
  subroutine text_file_create_new(self, path, failure)
    class(text_file_t), intent(inout) :: self
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    call open_stream(self, path, 'wx', failure)
  end subroutine text_file_create_new

  !> Opens a file behind its last character; a missing one is created. Does nothing after a failure; fails if it cannot.
  subroutine text_file_append(self, path, failure)
    class(text_file_t), intent(inout) :: self
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    call open_stream(self, path, 'a', failure)
  end subroutine text_file_append

  !> Opens the file in this mode of fopen.
  subroutine open_stream(self, path, mode, failure)
    class(text_file_t), intent(inout) :: self
    character(*), intent(in) :: path, mode
    type(failure_t), intent(inout) :: failure
    if (failure%failed) return
    self%path = path
    self%stream = c_fopen(path//c_null_char, mode//c_null_char)
    if (.not. c_associated(self%stream)) call failure%raise(path//UNWRITABLE)
  end subroutine open_stream

  !> Tells whether the file is open.
  logical function text_file_is_open(self) result(is_open)
    class(text_file_t), intent(in) :: self
    is_open = c_associated(self%stream)
  end function text_file_is_open

  !> Writes `text` and ends the line. Does nothing after a failure. Success may still turn into failure at the next flush.
  subroutine text_file_write(self, text, failure)
    class(text_file_t), intent(inout) :: self
    character(*), intent(in) :: text
    type(failure_t), intent(inout) :: failure
    integer(c_size_t) :: length
    if (failure%failed) return
    call require(c_associated(self%stream), 'base_text_file: the file is not open')
    length = len(text) + 1
    if (c_fwrite(text//new_line('a'), 1_c_size_t, length, self%stream) /= length) call failure%raise(self%path//UNWRITABLE)
  end subroutine text_file_write

  !> Hands everything written to the operating system. Does nothing after a failure; fails if not all could be written.
  subroutine text_file_flush(self, failure)
    class(text_file_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    if (failure%failed) return
    call require(c_associated(self%stream), 'base_text_file: the file is not open')
    if (c_fflush(self%stream) /= 0) call failure%raise(self%path//UNWRITABLE)
  end subroutine text_file_flush

  !> Closes the file, also after a failure. Fails if not all could be written; closing a closed one is a success.
  subroutine text_file_close(self, failure)
    class(text_file_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    if (.not. c_associated(self%stream)) return
    if (c_fclose(self%stream) /= 0) call failure%raise(self%path//UNWRITABLE)
    self%stream = c_null_ptr
  end subroutine text_file_close

  !> Replaces the file `path` by one that holds `text`, also after a failure, so that one lost file does not cost the others.
  !> If that fails, the old file is untouched.
  subroutine write_text(path, text, failure)
    character(*), intent(in) :: path, text
    type(failure_t), intent(inout) :: failure
    type(text_file_t) :: file
    type(failure_t) :: own
    call file%create(path//'.part', own)
    call file%write(text, own)
    call file%close(own)
    call replace_file(path//'.part', path, .false., own)
    if (.not. own%failed) return
    call remove_file(path//'.part')
    call failure%raise(path//UNWRITABLE)
  end subroutine write_text

  !> Writes a file of `kilobytes`, whose removal then frees that much of the disk for certain. Does nothing after a failure; if
  !> it fails, there is no file.
  subroutine reserve_space(path, kilobytes, failure)
    character(*), intent(in) :: path
    integer, intent(in) :: kilobytes
    type(failure_t), intent(inout) :: failure
    type(text_file_t) :: file
    integer :: i
    if (failure%failed) return
    call file%create(path, failure)
    do i = 1, kilobytes
      call file%write(repeat('0', 1023), failure)
    end do
    call file%close(failure)
    if (failure%failed) call remove_file(path)
  end subroutine reserve_space
end module base_text_file

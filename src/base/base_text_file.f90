! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes text files, and reports when one cannot be written.
!>
!> The files are written through the C library, because the run-time library of gfortran 12 reports success for a WRITE, a FLUSH and
!> a CLOSE on a full disk.
module base_text_file
  use base_files, only: replace_file, remove_file
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_ptr, c_size_t, c_null_char, c_null_ptr, c_associated
  implicit none
  private
  public :: text_file_t, write_text, reserve_space

  !> A text file open for writing.
  type :: text_file_t
    private
    type(c_ptr) :: stream = c_null_ptr
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

  !> Opens a new, empty file, replacing an existing one.
  subroutine text_file_create(self, path, ok)
    class(text_file_t), intent(inout) :: self
    character(*), intent(in) :: path
    logical, intent(out) :: ok
    self%stream = c_fopen(path//c_null_char, 'w'//c_null_char)
    ok = c_associated(self%stream)
  end subroutine text_file_create

  !> Opens a new, empty file; `ok` is false if something of this name exists.
  subroutine text_file_create_new(self, path, ok)
    class(text_file_t), intent(inout) :: self
    character(*), intent(in) :: path
    logical, intent(out) :: ok
    self%stream = c_fopen(path//c_null_char, 'wx'//c_null_char)
    ok = c_associated(self%stream)
  end subroutine text_file_create_new

  !> Opens a file behind its last character; a missing one is created.
  subroutine text_file_append(self, path, ok)
    class(text_file_t), intent(inout) :: self
    character(*), intent(in) :: path
    logical, intent(out) :: ok
    self%stream = c_fopen(path//c_null_char, 'a'//c_null_char)
    ok = c_associated(self%stream)
  end subroutine text_file_append

  !> Tells whether the file is open.
  logical function text_file_is_open(self) result(is_open)
    class(text_file_t), intent(in) :: self
    is_open = c_associated(self%stream)
  end function text_file_is_open

  !> Writes `text` and ends the line. Success may still turn into failure at the next flush.
  subroutine text_file_write(self, text, ok)
    class(text_file_t), intent(inout) :: self
    character(*), intent(in) :: text
    logical, intent(out) :: ok
    integer(c_size_t) :: length
    ok = c_associated(self%stream)
    if (.not. ok) return
    length = len(text) + 1
    ok = c_fwrite(text//new_line('a'), 1_c_size_t, length, self%stream) == length
  end subroutine text_file_write

  !> Hands everything written to the operating system.
  subroutine text_file_flush(self, ok)
    class(text_file_t), intent(inout) :: self
    logical, intent(out) :: ok
    ok = c_associated(self%stream)
    if (ok) ok = c_fflush(self%stream) == 0
  end subroutine text_file_flush

  !> Closes the file; closing a closed one is a success.
  subroutine text_file_close(self, ok)
    class(text_file_t), intent(inout) :: self
    logical, intent(out) :: ok
    ok = .true.
    if (c_associated(self%stream)) ok = c_fclose(self%stream) == 0
    self%stream = c_null_ptr
  end subroutine text_file_close

  !> Replaces the file `path` by one that holds `text`; on failure the old one is untouched.
  subroutine write_text(path, text, ok)
    character(*), intent(in) :: path, text
    logical, intent(out) :: ok
    type(text_file_t) :: file
    logical :: closed, removed
    call file%create(path//'.part', ok)
    if (.not. ok) return
    call file%write(text, ok)
    call file%close(closed)
    ok = ok .and. closed
    if (ok) call replace_file(path//'.part', path, .false., ok)
    if (.not. ok) call remove_file(path//'.part', removed)
  end subroutine write_text

  !> Writes a file of `kilobytes`, whose removal then frees that much of the disk for certain; on failure
  !> there is no file.
  subroutine reserve_space(path, kilobytes, ok)
    character(*), intent(in) :: path
    integer, intent(in) :: kilobytes
    logical, intent(out) :: ok
    type(text_file_t) :: file
    logical :: done
    integer :: i
    call file%create(path, ok)
    if (.not. ok) return
    do i = 1, kilobytes
      call file%write(repeat('0', 1023), done)
      ok = ok .and. done
    end do
    call file%close(done)
    ok = ok .and. done
    if (.not. ok) call remove_file(path, done)
  end subroutine reserve_space
end module base_text_file

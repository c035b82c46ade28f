! SPDX-License-Identifier: GPL-3.0-or-later
!> Reading text files line by line, lines of any length.
module base_text_lines
  use base_kinds, only: rp, i8
  use, intrinsic :: iso_fortran_env, only: iostat_eor
  implicit none
  private
  public :: read_line, ends_with_newline, count_words, real_text

contains

  !> Reads the next line of an open formatted file; `found` is false at the end of the file.
  subroutine read_line(unit, line, found)
    integer, intent(in) :: unit
    character(:), allocatable, intent(out) :: line
    logical, intent(out) :: found
    character(1024) :: buffer
    integer :: length, status
    line = ''
    do
      read (unit, '(a)', advance='no', size=length, iostat=status) buffer
      if (status == 0) length = len(buffer)
      if (status /= 0 .and. status /= iostat_eor) exit
      line = line//buffer(:length)
      if (status == iostat_eor) exit
    end do
    found = status == iostat_eor
  end subroutine read_line

  !> Tells whether the last line of a file is ended, as every line written completely is.
  logical function ends_with_newline(path) result(ended)
    character(*), intent(in) :: path
    character(1) :: last
    integer(i8) :: bytes
    integer :: unit, status
    ended = .false.
    open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', &
          iostat=status)
    if (status /= 0) return
    inquire (unit=unit, size=bytes)
    if (bytes > 0) then
      read (unit, pos=bytes, iostat=status) last
      ended = status == 0 .and. last == new_line('a')
    end if
    close (unit)
  end function ends_with_newline

  !> Returns the number of words separated by blanks or tabs.
  pure integer function count_words(text) result(n)
    character(*), intent(in) :: text
    logical :: inside, blank
    integer :: i
    n = 0
    inside = .false.
    do i = 1, len(text)
      blank = text(i:i) == ' ' .or. text(i:i) == achar(9)
      if (.not. blank .and. .not. inside) n = n + 1
      inside = .not. blank
    end do
  end function count_words

  !> Returns a real number with all its digits, without blanks.
  pure function real_text(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    character(32) :: digits
    write (digits, '(es24.16e3)') x
    text = trim(adjustl(digits))
  end function real_text
end module base_text_lines

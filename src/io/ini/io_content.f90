! SPDX-License-Identifier: GPL-3.0-or-later
!> Distinguishes text files of keys from files of other kinds by their first bytes.
module io_content
  implicit none
  private
  public :: foreign_content

  character(*), parameter :: BINARY = char(137)//'HDF', ARCHIVE = 'PK'//char(3)//char(4)
  character(*), parameter :: UTF16(2) = [char(255)//char(254), char(254)//char(255)]
  character(*), parameter :: BLANK_CHARACTERS = ' '//achar(9)//achar(10)//achar(13)
  character(*), parameter :: SAVE_AS_TEXT = '; save it as plain text in an editor'

contains

  !> Returns a text that says what kind of file this is and what to do, if it is not a text of keys. It is empty for a possible text
  !> of keys.
  pure function foreign_content(text) result(what)
    character(*), intent(in) :: text
    character(:), allocatable :: what
    integer :: first
    what = ''
    first = verify(text, BLANK_CHARACTERS)
    if (first == 0) return
    if (begins(text, BINARY)) then
      what = 'is an HDF5 file and not an input; an input is a text that names such files, for instance by [Wing] file'
    else if (begins(text, ARCHIVE)) then
      what = 'is an archive or a document of a word processor and not an input'//SAVE_AS_TEXT
    else if (begins(text(first:), '{\rtf')) then
      what = 'is a document of a word processor and not an input'//SAVE_AS_TEXT
    else if (begins(text, UTF16(1)) .or. begins(text, UTF16(2))) then
      what = 'is written in UTF-16; save it as UTF-8'
    else if (begins(text(first:), '<?xml') .or. begins(text(first:), '<svg')) then
      what = 'is XML and not an input; make_wing makes a wing file from a drawing'
    else if (begins(text(first:), '{')) then
      what = 'is JSON and not an input; the tools read descriptions of bending tests'
    end if
  end function foreign_content

  !> Tells whether a text begins with `start`.
  pure logical function begins(text, start)
    character(*), intent(in) :: text, start
    begins = .false.
    if (len(text) >= len(start)) begins = text(:len(start)) == start
  end function begins
end module io_content

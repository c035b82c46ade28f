! SPDX-License-Identifier: GPL-3.0-or-later
!> Splits the texts of keys into words.
module common_words
  use base_text, only: BLANKS, next_word
  implicit none
  private
  public :: find_words

contains

  !> Finds the words of `text` between blanks: word i is text(first(i):last(i)). `n` is their number; words behind the last that
  !> `first` and `last` have room for do not count.
  pure subroutine find_words(text, first, last, n)
    character(*), intent(in) :: text
    integer, intent(out) :: first(:), last(:), n
    integer :: position, begin, finish
    logical :: found
    first = 1
    last = 0
    position = 1
    do n = 0, size(first) - 1
      call next_word(text, BLANKS, position, begin, finish, found)
      if (.not. found) return
      first(n + 1) = begin
      last(n + 1) = finish
    end do
  end subroutine find_words
end module common_words

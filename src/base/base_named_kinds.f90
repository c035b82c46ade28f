! SPDX-License-Identifier: GPL-3.0-or-later
!> Maps the words of a key to kinds. Each key has one table, and no other code maps words to kinds. Programs decide by kinds, which
!> are named integer parameters; words are for inputs, outputs and files.
!>
!>     integer, parameter :: MEAN_FREE = 1, MEAN_FIXED = 2
!>     type(named_kind_t), parameter :: MEAN_FLOWS(2) = [named_kind_t('free', MEAN_FREE), named_kind_t('fixed', MEAN_FIXED)]
!>
!> Several words may mean the same kind; the first of them is its name in outputs. A word that ends in '*' stands for all words that
!> begin with the part before it.
module base_named_kinds
  implicit none
  private
  public :: named_kind_t, kind_of, word_of, words_of

  type :: named_kind_t
    character(24) :: word = ''
    integer :: kind = 0
  end type named_kind_t

contains

  !> Returns the kind that `word` means in the table, 0 if it is not there. Trailing blanks do not count.
  pure integer function kind_of(table, word) result(kind)
    type(named_kind_t), intent(in) :: table(:)
    character(*), intent(in) :: word
    integer :: i, n
    kind = 0
    do i = 1, size(table)
      n = len_trim(table(i)%word)
      if (table(i)%word(n:n) == '*') then
        if (index(word, table(i)%word(:n - 1)) /= 1) cycle
      else if (word /= table(i)%word) then
        cycle
      end if
      kind = table(i)%kind
      return
    end do
  end function kind_of

  !> Returns the first word of the table that means `kind`, empty if none does.
  pure function word_of(table, kind) result(word)
    type(named_kind_t), intent(in) :: table(:)
    integer, intent(in) :: kind
    character(:), allocatable :: word
    integer :: i
    word = ''
    do i = 1, size(table)
      if (table(i)%kind /= kind) cycle
      word = trim(table(i)%word)
      return
    end do
  end function word_of

  !> Returns all words of the table as 'a|b|c*', the form in which keys are declared.
  pure function words_of(table) result(words)
    type(named_kind_t), intent(in) :: table(:)
    character(:), allocatable :: words
    integer :: i
    words = ''
    do i = 1, size(table)
      if (i > 1) words = words//'|'
      words = words//trim(table(i)%word)
    end do
  end function words_of
end module base_named_kinds

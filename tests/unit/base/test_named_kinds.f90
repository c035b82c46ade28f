! SPDX-License-Identifier: GPL-3.0-or-later
!> Words mean kinds, and kinds have words, by one table.
program test_named_kinds
  use base_named_kinds, only: kind_of, named_kind_t, word_of, words_of
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: ROUND = 3, FLAT = 5, FILE = 7
  type(named_kind_t), parameter :: SHAPES(4) = [named_kind_t('round', ROUND), named_kind_t('Round', ROUND), &
                                                named_kind_t('flat', FLAT), named_kind_t('from_file::*', FILE)]
  type(testkit_t) :: t
  call t%start(parallel=.false.)
  call t%check('a word means its kind', kind_of(SHAPES, 'flat') == FLAT .and. kind_of(SHAPES, 'round') == ROUND)
  call t%check('so does another word for it', kind_of(SHAPES, 'Round') == ROUND)
  call t%check('blanks behind it do not count', kind_of(SHAPES, 'flat     ') == FLAT)
  call t%check('unknown words mean none', kind_of(SHAPES, 'fla') == 0 .and. kind_of(SHAPES, 'flatter') == 0 .and. &
               kind_of(SHAPES, '') == 0)
  call t%check('a star stands for any end', kind_of(SHAPES, 'from_file::a.h5') == FILE .and. &
               kind_of(SHAPES, 'from_file::') == FILE .and. kind_of(SHAPES, 'a from_file::') == 0)
  call t%check('the first word of a kind is its name', word_of(SHAPES, ROUND) == 'round' .and. word_of(SHAPES, FLAT) == 'flat')
  call t%check('a kind that is not in the table has none', word_of(SHAPES, 0) == '')
  call t%check('all words, as keys are declared', words_of(SHAPES) == 'round|Round|flat|from_file::*')
  call t%finish()
end program test_named_kinds

! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes one ini key: the kind of its value, its default, its limits and one line of help.
module io_key
  use base_errors, only: require
  use base_kinds, only: rp
  use base_text, only: next_word, number_text
  implicit none
  private
  public :: key_t, describe, matches_pattern, matches_any, spaced_choices, set_limits, set_lower, set_upper

  integer, parameter, public :: KEY_INTEGER = 1, KEY_REAL = 2, KEY_LENGTH = 3, KEY_SWITCH = 4, KEY_WORD = 5, &
                                KEY_TEXT = 6, KEY_REALS = 7, KEY_MATRIX = 8, KEY_INERT = 9

  type :: key_t
    integer :: kind = KEY_INERT
    character(:), allocatable :: section, name, help
    character(:), allocatable :: unit         !< empty: a pure number
    character(:), allocatable :: default_text !< in the form of a file
    character(:), allocatable :: allowed      !< KEY_WORD: a|b|c*
    character(:), allocatable :: unbuilt      !< words (for a switch: physics) that FLUSI has and this program lacks
    character(:), allocatable :: instead      !< 'a: what to give instead|b*: ...' for words of `unbuilt`
    logical :: is_required = .false.
    logical :: is_computed = .false.          !< the default is a sentence; the program computes the value
    logical :: in_checkpoint = .false.        !< the state in a checkpoint depends on it
    logical :: has_lower = .false., has_upper = .false.
    logical :: is_lower_open = .false., is_upper_open = .false. !< the limit itself is not allowed
    real(rp) :: lower = 0, upper = 0
    integer :: length = 0                     !< KEY_REALS: how many numbers, 0 is any
    integer :: columns = 0                    !< KEY_MATRIX: numbers in a row, 0 is any
  contains
    procedure :: is_in_range => key_is_in_range
    procedure :: range_text => key_range_text
    procedure :: kind_text => key_kind_text
    procedure :: choices_text => key_choices_text
  end type key_t

contains

  !> Makes a new key with the components that keys of every kind have.
  subroutine describe(new, kind, section, name, default_text, help, unit, required)
    type(key_t), intent(out) :: new
    integer, intent(in) :: kind
    character(*), intent(in) :: section, name, default_text, help
    character(*), intent(in), optional :: unit
    logical, intent(in), optional :: required
    new%kind = kind
    new%section = section
    new%name = name
    new%default_text = default_text
    new%help = help
    new%unit = ''
    new%allowed = ''
    new%unbuilt = ''
    new%instead = ''
    if (present(unit)) new%unit = unit
    if (present(required)) new%is_required = required
  end subroutine describe

  !> Sets the limits: min <= value <= max or above < value < below. Each may be given once.
  subroutine set_limits(new, min, max, above, below)
    type(key_t), intent(inout) :: new
    real(rp), intent(in), optional :: min, max, above, below
    if (present(min)) call set_lower(new, min, is_open=.false.)
    if (present(max)) call set_upper(new, max, is_open=.false.)
    if (present(above)) call set_lower(new, above, is_open=.true.)
    if (present(below)) call set_upper(new, below, is_open=.true.)
  end subroutine set_limits

  !> Sets the lower limit: the value is at least `limit`, or larger if it is open.
  subroutine set_lower(new, limit, is_open)
    type(key_t), intent(inout) :: new
    real(rp), intent(in) :: limit
    logical, intent(in) :: is_open
    call require(.not. new%has_lower, 'io_key: '//new%name//' has two lower limits')
    new%has_lower = .true.
    new%is_lower_open = is_open
    new%lower = limit
  end subroutine set_lower

  !> Sets the upper limit: the value is at most `limit`, or smaller if it is open.
  subroutine set_upper(new, limit, is_open)
    type(key_t), intent(inout) :: new
    real(rp), intent(in) :: limit
    logical, intent(in) :: is_open
    call require(.not. new%has_upper, 'io_key: '//new%name//' has two upper limits')
    new%has_upper = .true.
    new%is_upper_open = is_open
    new%upper = limit
  end subroutine set_upper

  !> Tells whether `x` respects the limits.
  pure logical function key_is_in_range(self, x) result(is_in)
    class(key_t), intent(in) :: self
    real(rp), intent(in) :: x
    is_in = .true.
    if (self%has_lower) is_in = x > self%lower .or. (.not. self%is_lower_open .and. x >= self%lower)
    if (self%has_upper) &
      is_in = is_in .and. (x < self%upper .or. (.not. self%is_upper_open .and. x <= self%upper))
  end function key_is_in_range

  !> Returns the limits in words, '> 0 and <= 1'; empty if there are none.
  function key_range_text(self) result(text)
    class(key_t), intent(in) :: self
    character(:), allocatable :: text
    text = ''
    if (self%has_lower) &
      text = trim(merge('> ', '>=', self%is_lower_open))//' '//limit_text(self, self%lower)
    if (self%has_lower .and. self%has_upper) text = text//' and '
    if (self%has_upper) &
      text = text//trim(merge('< ', '<=', self%is_upper_open))//' '//limit_text(self, self%upper)
  end function key_range_text

  !> Returns a limit of the key as text.
  function limit_text(key, x) result(text)
    class(key_t), intent(in) :: key
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    if (key%kind == KEY_INTEGER) then
      text = number_text(nint(x))
    else
      text = number_text(x)
    end if
  end function limit_text

  !> Returns the kind of the value in words.
  function key_kind_text(self) result(text)
    class(key_t), intent(in) :: self
    character(:), allocatable :: text
    select case (self%kind)
    case (KEY_INTEGER)
      text = 'integer'
    case (KEY_REAL)
      text = 'real'
    case (KEY_LENGTH)
      text = 'real or N*dx'
    case (KEY_SWITCH)
      text = 'switch'
    case (KEY_WORD)
      text = 'word'
    case (KEY_TEXT)
      text = 'text'
    case (KEY_REALS)
      text = 'reals'
      if (self%length > 0) text = number_text(self%length)//' reals'
    case (KEY_MATRIX)
      text = 'matrix (/ rows /)'
      if (self%columns > 0) text = 'matrix (/ rows of '//number_text(self%columns)//' /)'
    case default
      text = 'without effect'
    end select
  end function key_kind_text

  !> Returns the valid values of the key: 'a | b | c', 'integer >= 1', '3 reals'.
  function key_choices_text(self) result(text)
    class(key_t), intent(in) :: self
    character(:), allocatable :: text, limits
    select case (self%kind)
    case (KEY_SWITCH)
      text = 'yes | no | 1 | 0 | true | false'
    case (KEY_WORD)
      text = spaced_choices(self%allowed)
    case default
      text = self%kind_text()
      limits = self%range_text()
      if (len(limits) > 0) text = text//' '//limits
    end select
  end function key_choices_text

  !> Returns 'a|b' as 'a | b'.
  pure function spaced_choices(choices) result(text)
    character(*), intent(in) :: choices
    character(:), allocatable :: text
    integer :: position, first, last
    logical :: found
    text = ''
    position = 1
    do
      call next_word(choices, '|', position, first, last, found)
      if (.not. found) return
      if (len(text) > 0) text = text//' | '
      text = text//choices(first:last)
    end do
  end function spaced_choices

  !> Tells whether `word` equals `pattern`, or begins with the part before a final '*'.
  pure logical function matches_pattern(word, pattern) result(matches)
    character(*), intent(in) :: word, pattern
    integer :: n
    n = len(pattern) - 1
    matches = .false.
    if (len(pattern) == 0) return
    if (pattern(n + 1:) /= '*') then
      matches = word == pattern .and. len(word) == len(pattern)
    else if (len(word) >= n) then
      matches = word(:n) == pattern(:n)
    end if
  end function matches_pattern

  !> Tells whether `word` matches one of the patterns a|b|c*.
  pure logical function matches_any(word, patterns) result(matches)
    character(*), intent(in) :: word, patterns
    integer :: position, first, last
    logical :: found
    matches = .false.
    position = 1
    do while (.not. matches)
      call next_word(patterns, '|', position, first, last, found)
      if (.not. found) return
      matches = matches_pattern(word, patterns(first:last))
    end do
  end function matches_any
end module io_key

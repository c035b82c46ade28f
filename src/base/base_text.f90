! SPDX-License-Identifier: GPL-3.0-or-later
!> Strings and numbers as text.
!>
!> The readers in this module accept any sequence of bytes. They return either a number or a sentence that says what is wrong. They
!> never cause a run-time error or a floating-point exception.
module base_text
  use base_kinds, only: rp
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  implicit none
  private
  public :: to_lower, next_word, count_words, printable, quoted, edit_distance
  public :: parse_integer, parse_real, parse_reals, number_text

  character(*), parameter, public :: BLANKS = ' '//achar(9) !< separators of words: blank and tab

  character(*), parameter :: DIGITS = '0123456789'
  character(*), parameter :: LARGEST_DIGITS = '17976931348623157' ! of huge(1.0_rp) = 1.797...e308
  integer, parameter :: LARGEST_EXPONENT = 308
  integer, parameter :: MAX_EXPONENT = 100000000 ! exponents are clipped here; far beyond any real
  integer, parameter :: KEPT_DIGITS = 60         ! significant digits handed to the run-time library

  !> number_text(i) or number_text(x): shortest text that reads back as exactly the same number; a
  !> real always shows a point or an exponent.
  interface number_text
    module procedure integer_text, real_text
  end interface number_text

contains

  !> Returns the text with ASCII letters in lower case, everything else unchanged.
  pure function to_lower(text) result(lower)
    character(*), intent(in) :: text
    character(len(text)) :: lower
    integer :: i
    do i = 1, len(text)
      lower(i:i) = text(i:i)
      if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') lower(i:i) = achar(iachar(text(i:i)) + 32)
    end do
  end function to_lower

  !> Finds the next word text(first:last) at or behind `position` and moves `position` behind it;
  !> words are separated by any of `separators`. At the end `found` is false.
  pure subroutine next_word(text, separators, position, first, last, found)
    character(*), intent(in) :: text, separators
    integer, intent(inout) :: position
    integer, intent(out) :: first, last
    logical, intent(out) :: found
    integer :: skip
    first = 1
    last = 0
    found = .false.
    if (position > len(text)) return
    skip = verify(text(position:), separators)
    if (skip == 0) then
      position = len(text) + 1
      return
    end if
    found = .true.
    first = position + skip - 1
    skip = scan(text(first:), separators)
    last = len(text)
    if (skip > 0) last = first + skip - 2
    position = last + 1
  end subroutine next_word

  !> Returns the number of words in `text`.
  pure integer function count_words(text, separators) result(n)
    character(*), intent(in) :: text, separators
    integer :: position, first, last
    logical :: found
    n = 0
    position = 1
    do
      call next_word(text, separators, position, first, last, found)
      if (.not. found) exit
      n = n + 1
    end do
  end function count_words

  !> Returns `text` in a form for messages: control bytes become '?', and text beyond `limit` bytes becomes '...'.
  pure function printable(text, limit) result(shown)
    character(*), intent(in) :: text
    integer, intent(in) :: limit
    character(:), allocatable :: shown
    integer :: i, n
    n = len(text)
    if (n > limit) then
      n = limit
      do while (n > 1 .and. is_utf8_continuation(text(n + 1:n + 1))) ! do not cut a character in two
        n = n - 1
      end do
    end if
    shown = text(:n)
    do i = 1, n
      if (ichar(shown(i:i)) < 32 .or. ichar(shown(i:i)) == 127) shown(i:i) = '?'
    end do
    if (n < len(text)) shown = shown//'...'
  end function printable

  !> Returns `printable`, at most 60 bytes, between quotes.
  pure function quoted(text) result(shown)
    character(*), intent(in) :: text
    character(:), allocatable :: shown
    shown = "'"//printable(text, 60)//"'"
  end function quoted

  !> Tells whether a byte continues a UTF-8 character rather than begins one.
  pure logical function is_utf8_continuation(byte) result(is_it)
    character, intent(in) :: byte
    is_it = ichar(byte) >= 128 .and. ichar(byte) < 192
  end function is_utf8_continuation

  !> Returns the number of single-character insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`
  !> (Damerau-Levenshtein, each place edited once). Names longer than 64 characters are not compared: the result is then their
  !> summed length.
  pure integer function edit_distance(a, b) result(distance)
    character(*), intent(in) :: a, b
    integer, parameter :: LIMIT = 64
    integer, dimension(-1:LIMIT) :: before, last, row ! distances of a(:i) for b(:j-2), b(:j-1), b(:j)
    integer :: i, j
    distance = len(a) + len(b)
    if (len(a) > LIMIT .or. len(b) > LIMIT) return
    last = 0
    row = [(i, i=-1, LIMIT)]
    do j = 1, len(b)
      before = last
      last = row
      row(0) = j
      do i = 1, len(a)
        row(i) = min(last(i) + 1, row(i - 1) + 1, last(i - 1) + merge(0, 1, a(i:i) == b(j:j)))
        if (i > 1 .and. j > 1) then
          if (a(i:i) == b(j - 1:j - 1) .and. a(i - 1:i - 1) == b(j:j)) row(i) = min(row(i), before(i - 2) + 1)
        end if
      end do
    end do
    distance = row(len(a))
  end function edit_distance

  !> Reads [sign] digits and nothing else. On success `problem` is not allocated; otherwise it says
  !> what is wrong and `value` is 0.
  pure subroutine parse_integer(text, value, problem)
    character(*), intent(in) :: text
    integer, intent(out) :: value
    character(:), allocatable, intent(out) :: problem
    integer :: i, digit, start, magnitude
    logical :: negative
    value = 0
    call read_sign(text, start, negative)
    if (start > len(text)) then
      problem = quoted(text)//' is not an integer'
    else if (verify(text(start:), DIGITS) /= 0) then
      problem = quoted(text)//' is not an integer'
    end if
    if (allocated(problem)) return
    magnitude = 0
    do i = start, len(text)
      digit = iachar(text(i:i)) - iachar('0')
      if (magnitude > (huge(magnitude) - digit)/10) then
        problem = quoted(text)//' is too large for an integer'
        return
      end if
      magnitude = 10*magnitude + digit
    end do
    value = merge(-magnitude, magnitude, negative)
  end subroutine parse_integer

  !> Reads a decimal number such as 2, +2, .5, 1.e3, 1.0d-3; no infinity, no NaN, nothing behind it.
  !> A number too large for a real is a problem, one too small becomes 0. On success `problem` is not
  !> allocated; otherwise it says what is wrong and `value` is 0.
  pure subroutine parse_real(text, value, problem)
    character(*), intent(in) :: text
    real(rp), intent(out) :: value
    character(:), allocatable, intent(out) :: problem
    character(KEPT_DIGITS) :: kept    ! significant digits, the first one not zero
    character(KEPT_DIGITS + 24) :: normal
    integer :: start, split, n_kept, exponent, leading, status
    logical :: negative, well_formed
    value = 0
    call read_sign(text, start, negative)
    split = scan(text, 'eEdD')
    if (split == 0) split = len(text) + 1
    call read_mantissa(text(start:split - 1), kept, n_kept, leading, well_formed)
    exponent = 0
    if (well_formed .and. split <= len(text)) call read_exponent(text(split + 1:), exponent, well_formed)
    if (.not. well_formed) then
      problem = quoted(text)//' is not a number'
      return
    end if
    if (n_kept == 0) return
    exponent = exponent + leading
    ! The library would raise a floating-point exception here, which may be trapped.
    if (exponent < -400) return
    if (exponent > LARGEST_EXPONENT .or. &
        (exponent == LARGEST_EXPONENT .and. kept(:len(LARGEST_DIGITS)) > LARGEST_DIGITS)) then
      problem = quoted(text)//' is too large for a number'
      return
    end if
    write (normal, '(a,a,".",a,"e",i0)') merge('-', '+', negative), kept(1:1), kept(2:n_kept)//'0', exponent
    read (normal, '(e84.0)', iostat=status) value
    if (status /= 0) problem = quoted(text)//' is not a number'
  end subroutine parse_real

  !> Reads one number from each of the first words of `text`, which has as many; `problem` tells the first column that
  !> holds none.
  pure subroutine parse_reals(text, separators, values, problem)
    character(*), intent(in) :: text
    character(*), intent(in) :: separators
    real(rp), intent(out) :: values(:)
    character(:), allocatable, intent(out) :: problem
    integer :: i, position, first, last
    logical :: found
    values = 0
    position = 1
    do i = 1, size(values)
      call next_word(text, separators, position, first, last, found)
      call parse_real(text(first:last), values(i), problem)
      if (allocated(problem)) then
        problem = 'column '//number_text(i)//': '//problem
        return
      end if
    end do
  end subroutine parse_reals

  !> Reads the sign at the beginning of a number, if there is one.
  pure subroutine read_sign(text, start, negative)
    character(*), intent(in) :: text
    integer, intent(out) :: start !< where the digits begin
    logical, intent(out) :: negative
    start = 1
    negative = .false.
    if (len(text) == 0) return
    negative = text(1:1) == '-'
    if (negative .or. text(1:1) == '+') start = 2
  end subroutine read_sign

  !> Reads digits with at most one point: value = 0.d1d2d3... * 10**(leading+1), so that `leading` is
  !> the decimal exponent of the first significant digit.
  pure subroutine read_mantissa(text, kept, n_kept, leading, well_formed)
    character(*), intent(in) :: text
    character(*), intent(out) :: kept
    integer, intent(out) :: n_kept, leading
    logical, intent(out) :: well_formed
    integer :: i, point, n_digits
    kept = ''
    n_kept = 0
    n_digits = 0
    leading = 0
    point = index(text, '.')
    if (point == 0) point = len(text) + 1
    well_formed = .false.
    do i = 1, len(text)
      if (i == point) cycle
      if (index(DIGITS, text(i:i)) == 0) return
      n_digits = n_digits + 1
      if (n_kept == 0 .and. text(i:i) == '0') cycle
      if (n_kept == 0) leading = merge(point - i - 1, point - i, i < point)
      if (n_kept < len(kept)) then
        n_kept = n_kept + 1
        kept(n_kept:n_kept) = text(i:i)
      else if (text(i:i) /= '0') then
        kept(n_kept:n_kept) = '1' ! stands for the digits that are left out, which decide ties
      end if
    end do
    well_formed = n_digits > 0
  end subroutine read_mantissa

  !> Reads a decimal exponent with an optional sign, and limits it to MAX_EXPONENT.
  pure subroutine read_exponent(text, exponent, well_formed)
    character(*), intent(in) :: text
    integer, intent(out) :: exponent
    logical, intent(out) :: well_formed
    integer :: i, start
    logical :: negative
    exponent = 0
    call read_sign(text, start, negative)
    well_formed = start <= len(text) .and. verify(text(start:), DIGITS) == 0
    if (.not. well_formed) return
    do i = start, len(text)
      exponent = min(10*exponent + iachar(text(i:i)) - iachar('0'), MAX_EXPONENT)
    end do
    if (negative) exponent = -exponent
  end subroutine read_exponent

  !> Returns an integer as text, without blanks.
  pure function integer_text(value) result(text)
    integer, intent(in) :: value
    character(:), allocatable :: text
    character(12) :: buffer
    write (buffer, '(i0)') value
    text = trim(buffer)
  end function integer_text

  !> Returns a real with as few digits as give the same number when they are read again.
  pure function real_text(value) result(text)
    real(rp), intent(in) :: value
    character(:), allocatable :: text, problem
    character(32) :: buffer
    character(16) :: form
    real(rp) :: again
    integer :: n_digits
    if (ieee_is_nan(value)) then
      text = 'nan'
      return
    else if (abs(value) > huge(value)) then
      text = merge('-inf', 'inf ', value < 0)
      text = trim(text)
      return
    end if
    do n_digits = 2, 17
      write (form, '("(es32.",i0,"e3)")') n_digits - 1
      write (buffer, form) value
      buffer = adjustl(buffer)
      call parse_real(trim(buffer), again, problem)
      if (allocated(problem)) cycle ! rounded up beyond the largest real
      if (.not. (again < value .or. again > value)) exit
    end do
    text = plain_form(trim(buffer))
  end function real_text

  !> Rewrites d.ddde+ddd in the usual form: 0.001, 12.5, 32.0, 1e-5, 1.25e+10.
  pure function plain_form(scientific) result(text)
    character(*), intent(in) :: scientific
    character(:), allocatable :: text, figures, sign
    character(:), allocatable :: problem
    integer :: e, exponent, start, last
    e = scan(scientific, 'eE')
    call parse_integer(scientific(e + 1:), exponent, problem)
    start = verify(scientific, '-')
    sign = scientific(:start - 1)
    figures = scientific(start:start)//scientific(start + 2:e - 1)
    last = max(1, verify(figures, '0', back=.true.))
    figures = figures(:last)
    if (exponent < -3 .or. exponent > 6) then
      text = sign//figures(1:1)
      if (last > 1) text = text//'.'//figures(2:)
      text = text//'e'//integer_text(exponent)
    else if (exponent < 0) then
      text = sign//'0.'//repeat('0', -exponent - 1)//figures
    else
      figures = figures//repeat('0', max(0, exponent + 2 - last))
      text = sign//figures(:exponent + 1)//'.'//figures(exponent + 2:)
    end if
  end function plain_form
end module base_text

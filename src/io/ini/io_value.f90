! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the value of one key: reads it strictly from its text, and writes it.
module io_value
  use base_kinds, only: rp
  use base_text, only: BLANKS, count_words, next_word, number_text, parse_integer, parse_real, quoted
  use io_key, only: KEY_INTEGER, KEY_LENGTH, KEY_MATRIX, KEY_REAL, KEY_REALS, KEY_SWITCH, KEY_TEXT, &
                    KEY_WORD, key_t, matches_any
  use io_suggest, only: number_hint, suggestion_t
  implicit none
  private
  public :: value_t, is_length, read_value, input_text, effective_line

  !> Only the component that belongs to the kind of the key is used.
  type :: value_t
    integer :: line = 0          !< line of `file` that gives the key first, 0: none
    integer :: depth = 0         !< of `file`: 0 is the file itself, 1 one that it includes, and so on
    character(:), allocatable :: file
    logical :: is_given = .false. !< the file gives a valid value
    logical :: is_known = .false. !< there is a value: given or default
    logical :: is_excused = .false. !< the file gives an invalid value, which is reported: do not report it as missing
    logical :: is_unbuilt = .false. !< the file requests a feature of FLUSI that this program lacks
    character(:), allocatable :: spelling !< the key as the file writes it (it may be an alias)
    character(:), allocatable :: origin !< origin of a value that the program has computed
    integer :: whole = 0
    real(rp) :: number = 0
    real(rp) :: unit = 1         !< numbers and reals are given in this many units of the key
    logical :: switch = .false.
    character(:), allocatable :: text
    real(rp), allocatable :: reals(:)
    real(rp), allocatable :: matrix(:, :) !< (row, column)
  end type value_t

  character(*), parameter :: NEWLINE = achar(10)
  character(*), parameter :: TRUE_WORDS = 'yes|1|true|.true.', FALSE_WORDS = 'no|0|false|.false.'

contains

  !> Reads `raw` as a value of `key` into `value`. On success `problem` is not allocated; otherwise it says what is wrong and what
  !> is valid, and `value` keeps its value. `spacing` is the length that dx stands for, <= 0 if it is not known; `line` is where the
  !> value begins.
  subroutine read_value(key, raw, is_matrix, line, spacing, value, problem)
    type(key_t), intent(in) :: key
    character(*), intent(in) :: raw
    logical, intent(in) :: is_matrix
    integer, intent(in) :: line
    real(rp), intent(in) :: spacing
    type(value_t), intent(inout) :: value
    character(:), allocatable, intent(out) :: problem

    if (is_matrix .neqv. key%kind == KEY_MATRIX) then
      problem = 'one value is expected, not a matrix (/ /)'
      if (.not. is_matrix) problem = 'a matrix is expected, not '//quoted(raw)
      problem = problem//'; valid: '//key%choices_text()
      return
    end if
    select case (key%kind)
    case (KEY_INTEGER)
      call read_integer(key, raw, value%whole, problem)
    case (KEY_REAL, KEY_LENGTH)
      call read_number(key, raw, spacing, value%number, problem)
    case (KEY_SWITCH)
      call read_switch(key, raw, value%switch, value%is_unbuilt, problem)
    case (KEY_WORD)
      call check_word(key, raw, value%is_unbuilt, problem)
      if (.not. allocated(problem)) value%text = raw
    case (KEY_TEXT)
      value%text = raw
    case (KEY_REALS)
      call read_reals(key, raw, value%reals, problem)
    case (KEY_MATRIX)
      call read_matrix(key, raw, line, value%matrix, problem)
    end select
  end subroutine read_value

  !> Reads an integer and checks its range.
  subroutine read_integer(key, raw, whole, problem)
    type(key_t), intent(in) :: key
    character(*), intent(in) :: raw
    integer, intent(inout) :: whole
    character(:), allocatable, intent(out) :: problem
    integer :: x
    call parse_integer(raw, x, problem)
    if (.not. allocated(problem)) call check_range(key, real(x, rp), raw, problem)
    if (allocated(problem)) then
      problem = problem//'; valid: '//key%choices_text()
    else
      whole = x
    end if
  end subroutine read_integer

  !> Reads a real, or N*dx if the key is a length.
  subroutine read_number(key, raw, spacing, number, problem)
    type(key_t), intent(in) :: key
    character(*), intent(in) :: raw
    real(rp), intent(in) :: spacing
    real(rp), intent(inout) :: number
    character(:), allocatable, intent(out) :: problem
    real(rp) :: x
    logical :: in_dx
    call split_length(raw, x, in_dx, problem)
    if (in_dx .and. .not. allocated(problem)) then
      if (key%kind /= KEY_LENGTH) then
        problem = quoted(raw)//' is given in units of dx, but this key is not a length'
      else if (spacing <= 0) then
        problem = quoted(raw)//' cannot be computed, because dx = yl/ny is not known'
      else if (abs(x) > huge(x)/max(spacing, 1.0_rp)) then
        problem = quoted(raw)//' is too large for a number'
      else
        x = x*spacing
      end if
    end if
    if (.not. allocated(problem)) call check_range(key, x, raw, problem)
    if (allocated(problem)) then
      problem = problem//'; valid: '//key%choices_text()//number_hint(raw)
    else
      number = x
    end if
  end subroutine read_number

  !> Reads x or x*dx.
  subroutine split_length(raw, x, in_dx, problem)
    character(*), intent(in) :: raw
    real(rp), intent(out) :: x
    logical, intent(out) :: in_dx
    character(:), allocatable, intent(out) :: problem
    integer :: star
    star = index(raw, '*')
    in_dx = .false.
    if (star > 0) in_dx = adjustl(raw(star + 1:)) == 'dx'
    if (.not. in_dx) star = len(raw) + 1
    call parse_real(trim(raw(:star - 1)), x, problem)
    if (in_dx .and. allocated(problem)) problem = quoted(raw)//' is not a number times dx'
  end subroutine split_length

  !> Tells whether `text` is a number or N*dx.
  logical function is_length(text) result(is_it)
    character(*), intent(in) :: text
    real(rp) :: x
    logical :: in_dx
    character(:), allocatable :: problem
    call split_length(text, x, in_dx, problem)
    is_it = .not. allocated(problem)
  end function is_length

  !> Sets `problem` if a number is outside the range of its key.
  subroutine check_range(key, x, raw, problem)
    type(key_t), intent(in) :: key
    real(rp), intent(in) :: x
    character(*), intent(in) :: raw
    character(:), allocatable, intent(inout) :: problem
    if (.not. key%is_in_range(x)) problem = quoted(raw)//' is out of range'
  end subroutine check_range

  !> Reads yes or no. `is_unbuilt` is set if yes asks for something that does not exist here.
  subroutine read_switch(key, raw, switch, is_unbuilt, problem)
    type(key_t), intent(in) :: key
    character(*), intent(in) :: raw
    logical, intent(inout) :: switch, is_unbuilt
    character(:), allocatable, intent(out) :: problem
    logical :: is_on
    type(suggestion_t) :: suggestion
    is_on = matches_any(raw, TRUE_WORDS)
    if (.not. is_on .and. .not. matches_any(raw, FALSE_WORDS)) then
      call suggestion%start(raw)
      call offer_all(suggestion, TRUE_WORDS//'|'//FALSE_WORDS)
      problem = quoted(raw)//' is neither yes nor no; valid: '//key%choices_text()//suggestion%hint()
    else if (is_on .and. len(key%unbuilt) > 0) then
      problem = quoted(raw)//' asks for '//key%unbuilt//', which this program does not have'//instead_of(raw, key%instead)// &
                '; valid: no'
      is_unbuilt = .true.
    else
      switch = is_on
    end if
  end subroutine read_switch

  !> Checks that a word is allowed. `is_unbuilt` is set if only FLUSI knows it.
  subroutine check_word(key, raw, is_unbuilt, problem)
    type(key_t), intent(in) :: key
    character(*), intent(in) :: raw
    logical, intent(inout) :: is_unbuilt
    character(:), allocatable, intent(out) :: problem
    type(suggestion_t) :: suggestion
    if (matches_any(raw, key%allowed)) return
    if (matches_any(raw, key%unbuilt)) then
      problem = quoted(raw)//' is a value of FLUSI that this program does not have'//instead_of(raw, key%instead)// &
                '; valid: '//key%choices_text()
      is_unbuilt = .true.
      return
    end if
    call suggestion%start(raw)
    call offer_all(suggestion, key%allowed)
    problem = quoted(raw)//' is unknown; valid: '//key%choices_text()//suggestion%hint()
  end subroutine check_word

  !> Returns '; use instead: ' and the sentence that belongs to `raw` in 'a: sentence|b*: sentence', or nothing.
  function instead_of(raw, sentences) result(text)
    character(*), intent(in) :: raw, sentences
    character(:), allocatable :: text
    integer :: position, first, last, colon
    logical :: found
    text = ''
    position = 1
    do
      call next_word(sentences, '|', position, first, last, found)
      if (.not. found) return
      colon = first + index(sentences(first:last), ': ') - 1
      if (.not. matches_any(raw, sentences(first:colon - 1))) cycle
      text = '; use instead: '//sentences(colon + 2:last)
      return
    end do
  end function instead_of

  !> Offers all words of a list, separated by |, as suggestions.
  subroutine offer_all(suggestion, choices)
    type(suggestion_t), intent(inout) :: suggestion
    character(*), intent(in) :: choices
    integer :: position, first, last
    logical :: found
    position = 1
    do
      call next_word(choices, '|', position, first, last, found)
      if (.not. found) return
      call suggestion%offer(choices(first:last))
    end do
  end subroutine offer_all

  !> Reads a list of reals and checks their number and range.
  subroutine read_reals(key, raw, reals, problem)
    type(key_t), intent(in) :: key
    character(*), intent(in) :: raw
    real(rp), allocatable, intent(inout) :: reals(:)
    character(:), allocatable, intent(out) :: problem
    real(rp), allocatable :: x(:)
    integer :: n
    n = count_words(raw, BLANKS//',')
    if (key%length > 0 .and. n /= key%length) then
      problem = number_text(n)//trim(merge(' number is  ', ' numbers are', n == 1))//' given, not '// &
                number_text(key%length)
    else
      allocate (x(n))
      call read_list(key, raw, x, problem)
    end if
    if (allocated(problem)) then
      problem = problem//'; valid: '//key%choices_text()
    else
      call move_alloc(x, reals)
    end if
  end subroutine read_reals

  !> Reads exactly size(x) numbers, each in range.
  subroutine read_list(key, raw, x, problem)
    type(key_t), intent(in) :: key
    character(*), intent(in) :: raw
    real(rp), intent(out) :: x(:)
    character(:), allocatable, intent(out) :: problem
    integer :: i, position, first, last
    logical :: found
    position = 1
    do i = 1, size(x)
      call next_word(raw, BLANKS//',', position, first, last, found)
      call parse_real(raw(first:last), x(i), problem)
      if (.not. allocated(problem)) call check_range(key, x(i), raw(first:last), problem)
      if (allocated(problem)) return
    end do
  end subroutine read_list

  !> Reads a matrix, one row a line, and checks that its rows are equally long.
  subroutine read_matrix(key, raw, line, matrix, problem)
    type(key_t), intent(in) :: key
    character(*), intent(in) :: raw
    integer, intent(in) :: line
    real(rp), allocatable, intent(inout) :: matrix(:, :)
    character(:), allocatable, intent(out) :: problem
    real(rp), allocatable :: rows(:, :), row(:)
    integer :: n_rows, n_columns, pass, at_line, first, last, n
    n_columns = key%columns
    do pass = 1, 2 ! first count and check, then read
      n_rows = 0
      at_line = line
      first = 1
      do while (first <= len(raw))
        last = index(raw(first:), NEWLINE)
        last = merge(len(raw), first + last - 2, last == 0)
        n = count_words(raw(first:last), BLANKS//',')
        if (n > 0) then
          if (n_columns == 0) n_columns = n
          n_rows = n_rows + 1
          if (n /= n_columns) then
            problem = 'the row in line '//number_text(at_line)//' has '//number_text(n)// &
                      trim(merge(' number ', ' numbers', n == 1))//', not '//number_text(n_columns)
          else if (pass == 2) then
            call read_list(key, raw(first:last), row, problem)
            if (allocated(problem)) then
              problem = 'in line '//number_text(at_line)//': '//problem
            else
              rows(n_rows, :) = row
            end if
          end if
        end if
        if (allocated(problem)) then
          problem = problem//'; valid: '//key%choices_text()
          return
        end if
        first = last + 2
        at_line = at_line + 1
      end do
      if (pass == 1) allocate (rows(n_rows, n_columns), row(n_columns))
    end do
    call move_alloc(rows, matrix)
  end subroutine read_matrix

  !> Returns the value in the form of a file, with each row of a matrix on a separate line.
  function value_text(key, value) result(text)
    type(key_t), intent(in) :: key
    type(value_t), intent(in) :: value
    character(:), allocatable :: text
    integer :: i
    select case (key%kind)
    case (KEY_INTEGER)
      text = number_text(value%whole)
    case (KEY_REAL, KEY_LENGTH)
      text = number_text(value%number)
    case (KEY_SWITCH)
      text = trim(merge('yes', 'no ', value%switch))
    case (KEY_WORD, KEY_TEXT)
      text = value%text
    case (KEY_REALS)
      text = list_text(value%reals)
    case (KEY_MATRIX)
      text = '(/'
      do i = 1, size(value%matrix, 1)
        if (i > 1) text = text//NEWLINE//'   '
        text = text//' '//list_text(value%matrix(i, :))
      end do
      text = text//' /)'
    case default
      text = ''
    end select
  end function value_text

  !> Returns the value in one line, in L, T and M.
  function input_text(key, value) result(text)
    type(key_t), intent(in) :: key
    type(value_t), intent(in) :: value
    character(:), allocatable :: text
    type(value_t) :: scaled
    integer :: k
    scaled = value
    scaled%number = value%number/value%unit
    scaled%reals = value%reals/value%unit
    text = value_text(key, scaled)
    do k = 1, len(text) ! of matrices
      if (text(k:k) == new_line('a')) text(k:k) = ' '
    end do
  end function input_text

  !> Returns `key = value`, and behind ';' the unit and where the value comes from, the file `name` or the default. `scale` is the
  !> value of one unit of the key in SI units; with it the file is in SI units, and so is the result.
  function effective_line(key, value, scale) result(text)
    type(key_t), intent(in) :: key
    type(value_t), intent(in) :: value
    real(rp), intent(in), optional :: scale
    character(:), allocatable :: text, remark
    type(value_t) :: shown
    integer, parameter :: REMARK_COLUMN = 40
    integer :: last_line
    text = '  '//key%name//' = '
    shown = value
    if (present(scale) .and. .not. value%is_given) then
      shown%number = value%number*scale
      shown%reals = value%reals*scale
    end if
    if (value%is_known .and. (value%is_given .or. key%kind /= KEY_MATRIX)) text = text//value_text(key, shown)
    text = text//'; '
    remark = 'default'
    if (value%is_given) remark = value%file//':'//number_text(value%line)
    if (allocated(value%origin)) remark = remark//', '//value%origin
    if (.not. value%is_known) remark = 'default: '//key%default_text//', computed by the program'
    if (present(scale)) then
      if (abs(scale - 1) > 0) remark = 'in SI units, '//remark
    end if
    if (len(key%unit) > 0) remark = key%unit//trim(merge(' ', ',', index(remark, 'in SI') == 1))//' '//remark
    last_line = len(text) - index(text, achar(10), back=.true.)
    text = text//repeat(' ', max(0, REMARK_COLUMN - last_line))//remark
  end function effective_line

  !> Returns reals, separated by blanks.
  function list_text(x) result(text)
    real(rp), intent(in) :: x(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(x)
      if (i > 1) text = text//' '
      text = text//number_text(x(i))
    end do
  end function list_text
end module io_value

! SPDX-License-Identifier: GPL-3.0-or-later
!> Parses the syntax of ini files: text to a list of (section, key, value, line), without meaning.
!>
!>     [Section]                  ; comments begin with ; # ! % in the first column that is not blank
!>     key = value; comment       the first ; of a line ends the value
!>     key = value # comment      without any ; in the line, a blank and # ! % end it too
!>     key = (/ 1 2 3             a matrix, one row a line, with the same comments
!>              4 5 6 /)
!>
!> This is FLUSI's format with blanks around `=` allowed and `;` optional. Carriage returns, tabs, a
!> UTF-8 byte order mark and bytes above 127 are tolerated. No byte sequence stops the program.
module io_ini
  use base_errors, only: message_list_t
  use base_text, only: BLANKS, number_text, quoted
  use io_content, only: foreign_content
  implicit none
  private
  public :: ini_document_t, ini_entry_t

  type :: ini_section_t
    character(:), allocatable :: name !< empty: the header is broken and its keys belong to no section
    character(:), allocatable :: file !< file that contains it
    integer :: line = 0
  end type ini_section_t

  type :: ini_entry_t
    character(:), allocatable :: key
    character(:), allocatable :: value !< trimmed; of a matrix the rows, one a line of the file
    character(:), allocatable :: file  !< file that contains it
    integer :: section = 0             !< index of its section header in `sections`
    integer :: line = 0
    integer :: depth = 0               !< 0: the file itself, 1: a file that it includes, and so on
    logical :: is_matrix = .false.
  end type ini_entry_t

  !> The parsed document: every section header and every entry, in the order of the file.
  type :: ini_document_t
    character(:), allocatable :: name !< of the file, for messages
    type(ini_section_t), allocatable :: sections(:)
    type(ini_entry_t), allocatable :: entries(:)
    integer :: n_sections = 0
    integer :: n_entries = 0
    logical :: is_foreign = .false.    !< the file is of another kind
  contains
    procedure :: parse => ini_document_parse
    procedure :: append => ini_document_append
  end type ini_document_t

  character(*), parameter :: NEWLINE = achar(10), return = achar(13)
  character(*), parameter :: BYTE_ORDER_MARK = char(239)//char(187)//char(191)
  character(*), parameter :: COMMENT_SIGNS = ';#!%'
  integer, parameter :: MAX_BROKEN_LINES = 50 ! more than that is not an ini file

contains

  !> Parses `text`, whose file is called `name` in messages. Every broken line adds one message
  !> `name:line: problem` to `errors` and is left out of the document. A file of another kind is one mistake.
  subroutine ini_document_parse(self, text, name, errors)
    class(ini_document_t), intent(inout) :: self
    character(*), intent(in) :: text, name
    type(message_list_t), intent(inout) :: errors
    integer :: position, line, first, last, n_broken, stop_line
    character(:), allocatable :: problem

    self%name = name
    self%n_sections = 0
    self%n_entries = 0
    if (allocated(self%sections)) deallocate (self%sections)
    if (allocated(self%entries)) deallocate (self%entries)
    allocate (self%sections(16), self%entries(64))
    problem = foreign_content(text)
    self%is_foreign = problem /= ''
    if (self%is_foreign) then
      call errors%add(name//':1: '//problem)
      return
    end if
    n_broken = 0
    position = 1
    line = 0
    if (len(text) >= 3) then
      if (text(1:3) == BYTE_ORDER_MARK) position = 4
    end if
    do
      call next_line(text, position, line, first, last)
      if (line < 0) exit
      stop_line = line
      call parse_line(self, text, first, last, position, stop_line, line, problem)
      if (allocated(problem)) then
        n_broken = n_broken + 1
        if (n_broken > MAX_BROKEN_LINES) then
          call errors%add(name//':'//number_text(line)//': too many broken lines; is this an ini file?')
          return
        end if
        call errors%add(name//':'//number_text(line)//': '//problem)
      end if
      line = stop_line
    end do
    if (self%n_sections == 0 .and. n_broken == 0) &
      call errors%add(name//': is empty: no [Section] and no key was found')
  end subroutine ini_document_parse

  !> Appends the content of another file, which is included at `depth`.
  subroutine ini_document_append(self, other, depth)
    class(ini_document_t), intent(inout) :: self
    type(ini_document_t), intent(in) :: other
    integer, intent(in) :: depth
    integer :: i, e
    e = 1
    do i = 1, other%n_sections
      call add_section(self, other%sections(i)%name, other%sections(i)%line)
      self%sections(self%n_sections)%file = other%name
      do while (e <= other%n_entries)
        associate (entry => other%entries(e))
          if (entry%section /= i) exit
          call add_entry(self, entry%key, entry%value, entry%is_matrix, entry%line)
        end associate
        self%entries(self%n_entries)%file = other%name
        self%entries(self%n_entries)%depth = depth
        e = e + 1
      end do
    end do
  end subroutine ini_document_append

  !> Finds the next line text(first:last), trimmed of blanks and line ends; `line` is -1 at the end.
  subroutine next_line(text, position, line, first, last)
    character(*), intent(in) :: text
    integer, intent(inout) :: position, line
    integer, intent(out) :: first, last
    integer :: step
    first = position
    last = position - 1
    if (position > len(text)) then
      line = -1
      return
    end if
    line = line + 1
    step = index(text(position:), NEWLINE)
    if (step == 0) step = len(text) - position + 2
    last = position + step - 2
    position = position + step
    call trim_range(text, first, last, BLANKS//return)
  end subroutine next_line

  !> Trims the characters of `set` from both ends of text(first:last), which may become empty.
  subroutine trim_range(text, first, last, set)
    character(*), intent(in) :: text, set
    integer, intent(inout) :: first, last
    integer :: step
    if (last < first) return
    step = verify(text(first:last), set)
    if (step == 0) then
      last = first - 1
      return
    end if
    last = first - 1 + verify(text(first:last), set, back=.true.)
    first = first - 1 + step
  end subroutine trim_range

  !> Reads one line, or all lines of a matrix. In the latter case `position` and `stop_line` move to its last line.
  subroutine parse_line(self, text, first, last, position, stop_line, line, problem)
    class(ini_document_t), intent(inout) :: self
    character(*), intent(in) :: text
    integer, intent(in) :: first, last, line
    integer, intent(inout) :: position, stop_line
    character(:), allocatable, intent(out) :: problem
    integer :: from, upto, equals, value_from
    logical :: is_matrix
    character(:), allocatable :: value

    if (last < first) return
    if (index(COMMENT_SIGNS, text(first:first)) > 0) return
    if (text(first:first) == '[') then
      call parse_header(self, text(first:last), line, problem)
      if (allocated(problem)) call add_section(self, '', line)
      return
    end if
    from = first
    upto = end_of_content(text, first, last)
    equals = index(text(from:upto), '=')
    if (has_control_bytes(text(from:upto))) then
      problem = 'holds bytes that are not text: '//quoted(text(from:upto))
    else if (equals == 0) then
      problem = "expected '[Section]', 'key = value' or a comment, found "//quoted(text(from:upto))
    else if (equals == 1) then
      problem = "there is no key before '=': "//quoted(text(from:upto))
    end if
    if (allocated(problem)) return

    value_from = from + equals
    upto = end_of_value(text, value_from, last)
    call trim_range(text, value_from, upto, BLANKS)
    is_matrix = starts_matrix(text, value_from, upto)
    if (is_matrix) then
      call read_matrix(text, value_from + 2, upto, position, stop_line, value, problem)
      if (allocated(problem)) return
    else
      value = text(value_from:upto)
    end if
    upto = from + equals - 2
    call trim_range(text, from, upto, BLANKS)
    if (self%n_sections == 0) then
      problem = 'the key '//quoted(text(from:upto))//' stands before any [Section]'
      return
    end if
    call add_entry(self, text(from:upto), value, is_matrix, line)
  end subroutine parse_line

  !> Reads the line of a section. `problem` says what is wrong with it.
  subroutine parse_header(self, header, line, problem)
    class(ini_document_t), intent(inout) :: self
    character(*), intent(in) :: header !< begins with [
    integer, intent(in) :: line
    character(:), allocatable, intent(out) :: problem
    integer :: closing, first, last, rest
    closing = index(header, ']')
    if (closing == 0) then
      problem = "']' is missing: "//quoted(header)
      return
    end if
    first = 2
    last = closing - 1
    call trim_range(header, first, last, BLANKS)
    rest = verify(header(closing + 1:), BLANKS)
    if (last < first) then
      problem = 'the section has no name: '//quoted(header)
    else if (has_control_bytes(header(first:last))) then
      problem = 'holds bytes that are not text: '//quoted(header)
    else if (rest > 0) then
      if (index(COMMENT_SIGNS, header(closing + rest:closing + rest)) == 0) &
        problem = "only a comment may follow ']': "//quoted(header)
    end if
    if (.not. allocated(problem)) call add_section(self, header(first:last), line)
  end subroutine parse_header

  !> Reads the rows of a matrix whose '(/' has been read. The value keeps the line breaks, so that a message can name the line of
  !> a row. It ends at '/)'. A line with '=' or a [Section] means that '/)' was forgotten.
  subroutine read_matrix(text, content_from, content_upto, position, stop_line, value, problem)
    character(*), intent(in) :: text
    integer, intent(in) :: content_from, content_upto
    integer, intent(inout) :: position, stop_line
    character(:), allocatable, intent(out) :: value, problem
    character(:), allocatable :: rows
    integer :: from, upto, first, last, line, next, n, closing
    from = content_from
    upto = content_upto
    allocate (character(len(text) - from + 2) :: rows) ! long enough for all that may follow
    n = 0
    do
      closing = index(text(from:upto), '/)')
      if (has_control_bytes(text(from:upto))) then
        problem = 'the matrix that begins here holds bytes that are not text in line '//number_text(stop_line)
        return
      end if
      if (closing > 0) then
        if (verify(text(from + closing + 1:upto), BLANKS) > 0) then
          problem = "only a comment may follow '/)': "//quoted(text(from + closing + 1:upto))
          return
        end if
        upto = from + closing - 2
      end if
      rows(n + 1:n + upto - from + 1) = text(from:upto)
      n = n + max(0, upto - from + 1)
      if (closing > 0) exit
      next = position
      line = stop_line
      call next_line(text, next, line, first, last)
      from = first
      upto = first - 1
      if (line > 0 .and. last >= first) then
        if (index(COMMENT_SIGNS, text(first:first)) == 0) upto = end_of_value(text, first, last)
        if (text(first:first) == '[' .or. index(text(first:upto), '=') > 0) line = -1
      end if
      if (line < 0) then
        problem = "the matrix that begins here is not closed by '/)'"
        return
      end if
      position = next
      stop_line = line
      n = n + 1
      rows(n:n) = NEWLINE
    end do
    value = rows(:n)
  end subroutine read_matrix

  !> Tells whether a value begins with (/.
  logical function starts_matrix(text, first, last) result(is_matrix)
    character(*), intent(in) :: text
    integer, intent(in) :: first, last
    is_matrix = .false.
    if (last > first) is_matrix = text(first:first + 1) == '(/'
  end function starts_matrix

  !> Returns the last character in front of the first ';'.
  integer function end_of_content(text, first, last) result(upto)
    character(*), intent(in) :: text
    integer, intent(in) :: first, last
    upto = index(text(first:last), ';')
    upto = merge(last, first + upto - 2, upto == 0)
  end function end_of_content

  !> Returns the last character of a value that begins after text(first-1:first-1): in front of the first ';' or, without any, in
  !> front of a comment sign that follows a blank.
  integer function end_of_value(text, first, last) result(upto)
    character(*), intent(in) :: text
    integer, intent(in) :: first, last
    integer :: i, step
    upto = end_of_content(text, first, last)
    if (upto < last) return
    i = first
    do
      step = scan(text(i:last), COMMENT_SIGNS)
      if (step == 0) return
      i = i + step - 1
      if (i > first) then
        if (index(BLANKS, text(i - 1:i - 1)) > 0) then
          upto = i - 1
          return
        end if
      end if
      i = i + 1
    end do
  end function end_of_value

  !> Tells whether `text` holds bytes below 32 other than tab, or 127.
  pure logical function has_control_bytes(text) result(has)
    character(*), intent(in) :: text
    integer :: i, code
    has = .true.
    do i = 1, len(text)
      code = ichar(text(i:i))
      if ((code < 32 .and. code /= 9) .or. code == 127) return
    end do
    has = .false.
  end function has_control_bytes

  !> Adds a section.
  subroutine add_section(self, name, line)
    class(ini_document_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: line
    type(ini_section_t), allocatable :: larger(:)
    integer :: i
    if (self%n_sections == size(self%sections)) then
      allocate (larger(2*self%n_sections))
      do i = 1, self%n_sections
        call move_alloc(self%sections(i)%name, larger(i)%name)
        call move_alloc(self%sections(i)%file, larger(i)%file)
        larger(i)%line = self%sections(i)%line
      end do
      call move_alloc(larger, self%sections)
    end if
    self%n_sections = self%n_sections + 1
    self%sections(self%n_sections)%name = name
    self%sections(self%n_sections)%file = self%name
    self%sections(self%n_sections)%line = line
  end subroutine add_section

  !> Adds a key with its value to the last section.
  subroutine add_entry(self, key, value, is_matrix, line)
    class(ini_document_t), intent(inout) :: self
    character(*), intent(in) :: key, value
    logical, intent(in) :: is_matrix
    integer, intent(in) :: line
    type(ini_entry_t), allocatable :: larger(:)
    integer :: i
    if (self%n_entries == size(self%entries)) then
      allocate (larger(2*self%n_entries))
      do i = 1, self%n_entries
        call move_alloc(self%entries(i)%key, larger(i)%key)
        call move_alloc(self%entries(i)%value, larger(i)%value)
        call move_alloc(self%entries(i)%file, larger(i)%file)
        larger(i)%section = self%entries(i)%section
        larger(i)%line = self%entries(i)%line
        larger(i)%depth = self%entries(i)%depth
        larger(i)%is_matrix = self%entries(i)%is_matrix
      end do
      call move_alloc(larger, self%entries)
    end if
    self%n_entries = self%n_entries + 1
    associate (entry => self%entries(self%n_entries))
      entry%key = key
      entry%value = value
      entry%file = self%name
      entry%section = self%n_sections
      entry%line = line
      entry%is_matrix = is_matrix
    end associate
  end subroutine add_entry
end module io_ini

! SPDX-License-Identifier: GPL-3.0-or-later
!> Turns the entries of an ini document into the values of registered keys. Nothing here is collective.
module io_entries
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text, printable
  use io_ini, only: ini_document_t, ini_entry_t
  use io_key, only: KEY_INERT
  use io_lookup, only: note_inert, report_unknown_key, report_unknown_section
  use io_peek, only: key_counts, section_counts
  use io_registry, only: registry_t
  use io_value, only: read_value, value_t
  implicit none
  private
  public :: read_section, reading_t

  !> How entries are read, and the messages about them.
  type :: reading_t
    real(rp) :: spacing = 0                   !< what dx means, 0 if unknown
    logical :: first_wins = .false.           !< the first of equal keys counts, with a notice, instead of being a mistake
    type(message_list_t) :: errors, notices
    character(:), allocatable :: inert        !< the keys that have no effect
  contains
    procedure :: begin => reading_begin
  end type reading_t

contains

  !> Begins to read; the messages so far are kept.
  subroutine reading_begin(self, spacing, errors, notices, first_wins)
    class(reading_t), intent(out) :: self
    real(rp), intent(in) :: spacing
    type(message_list_t), intent(in) :: errors, notices
    logical, intent(in), optional :: first_wins
    self%spacing = spacing
    self%errors = errors
    self%notices = notices
    self%inert = ''
    if (present(first_wins)) self%first_wins = first_wins
  end subroutine reading_begin

  !> Reads section i of the document, whose entries begin at index e, into `values`, which have the indices of the registry; e moves
  !> to the entries of the next section.
  subroutine read_section(registry, document, i, e, reading, values)
    type(registry_t), intent(in) :: registry
    type(ini_document_t), intent(in) :: document
    integer, intent(in) :: i
    integer, intent(inout) :: e
    type(reading_t), intent(inout) :: reading
    type(value_t), intent(inout) :: values(:)
    character(:), allocatable :: name, meant
    integer :: s, k
    logical :: is_inert, counts

    name = document%sections(i)%name
    s = registry%find_section(name)
    meant = name
    if (s == 0 .and. len(name) > 0) &
      call report_unknown_section(registry, document%sections(i)%file, document%sections(i)%line, name, &
                                  meant, reading%errors)
    is_inert = .false.
    counts = .true.
    if (s > 0) then
      is_inert = registry%sections(s)%is_inert
      counts = section_counts(registry, document, s)
    end if
    do while (e <= document%n_entries)
      associate (entry => document%entries(e))
        if (entry%section /= i) exit
        e = e + 1
        if (len(meant) == 0) cycle ! the header was broken or unknown, which has been reported
        k = registry%find(meant, entry%key)
        if (k > 0 .and. counts) then
          call read_entry(registry, entry, k, key_counts(registry, document, k), reading, values)
        else if (k > 0) then
          call note_inert(reading%inert, '['//printable(name, 60)//']', '')
          call read_quietly(registry, reading%spacing, entry, k, values)
        else if (is_inert .or. .not. counts) then
          call note_inert(reading%inert, '['//printable(name, 60)//']', '')
        else
          call report_unknown_key(registry, entry%file, entry%line, meant, entry%key, k, reading%errors)
          if (k > 0) values(k)%is_excused = .true.
        end if
      end associate
    end do
  end subroutine read_section

  !> Reads the value of key k. If the key has no effect, its mistakes are not reported.
  subroutine read_entry(registry, entry, k, counts, reading, values)
    type(registry_t), intent(in) :: registry
    type(ini_entry_t), intent(in) :: entry
    integer, intent(in) :: k
    logical, intent(in) :: counts
    type(reading_t), intent(inout) :: reading
    type(value_t), intent(inout) :: values(:)
    character(:), allocatable :: problem, place, here
    associate (key => registry%keys(k)%key, value => values(k))
      here = ' (line '//number_text(entry%line)//')'
      if (key%kind == KEY_INERT) then
        call note_inert(reading%inert, '['//key%section//'] '//printable(entry%key, 60), here)
        return
      end if
      place = entry%file//':'//number_text(entry%line)//': ['//key%section//'] '//entry%key//': '
      if (value%line > 0) then
        if (entry%depth <= value%depth) call report_twice(entry, value, place, reading)
        return ! the including file has priority over the files that it includes
      end if
      value%line = entry%line
      value%file = entry%file
      value%depth = entry%depth
      value%spelling = entry%key
      if (len(entry%value) == 0 .and. .not. entry%is_matrix) return ! "key=;" asks for the default
      call read_value(key, entry%value, entry%is_matrix, entry%line, reading%spacing, value, problem)
      value%is_unbuilt = value%is_unbuilt .and. counts
      value%is_given = .not. allocated(problem)
      value%is_excused = .not. value%is_given
      value%is_known = value%is_known .or. value%is_given
      if (.not. allocated(problem)) return
      if (counts) call reading%errors%add(place//problem)
      if (.not. counts) call note_inert(reading%inert, '['//key%section//'] '//printable(entry%key, 60), here)
    end associate
  end subroutine read_entry

  !> Reports that a key is given again.
  subroutine report_twice(entry, value, place, reading)
    type(ini_entry_t), intent(in) :: entry
    type(value_t), intent(in) :: value
    character(*), intent(in) :: place
    type(reading_t), intent(inout) :: reading
    character(:), allocatable :: problem
    problem = 'is given twice, first in '//line_text(value, entry%file)
    if (value%spelling /= entry%key) problem = problem//' under the name '//value%spelling
    if (reading%first_wins) then
      call reading%notices%add(place//problem//'; the first one counts')
    else
      call reading%errors%add(place//problem)
    end if
  end subroutine report_twice

  !> Returns the line of a value as text, with its file unless that is `file`.
  function line_text(value, file) result(text)
    type(value_t), intent(in) :: value
    character(*), intent(in) :: file
    character(:), allocatable :: text
    text = 'line '//number_text(value%line)
    if (value%file /= file) text = text//' of '//value%file
  end function line_text

  !> Does `read_entry` for a key whose mistakes have no effect.
  subroutine read_quietly(registry, spacing, entry, k, values)
    type(registry_t), intent(in) :: registry
    real(rp), intent(in) :: spacing
    type(ini_entry_t), intent(in) :: entry
    integer, intent(in) :: k
    type(value_t), intent(inout) :: values(:)
    type(message_list_t) :: none
    type(reading_t) :: reading
    call reading%begin(spacing, none, none, first_wins=.true.)
    call read_entry(registry, entry, k, .false., reading, values)
  end subroutine read_quietly
end module io_entries

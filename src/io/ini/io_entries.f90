! SPDX-License-Identifier: GPL-3.0-or-later
!> From the entries of an ini document to the values of registered keys. Nothing here is collective.
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
  public :: read_section

contains

  !> Reads section i of the document, whose entries begin at index e, into `values`, of the keys with the same indices in the
  !> registry; e moves to the entries of the next one. `spacing`: what dx means, 0 if unknown. With `first_wins` the first of
  !> equal keys counts, with a notice, instead of being a mistake. Keys that have no effect are added to `inert`.
  subroutine read_section(registry, spacing, document, i, e, first_wins, values, errors, notices, inert)
    type(registry_t), intent(in) :: registry
    real(rp), intent(in) :: spacing
    type(ini_document_t), intent(in) :: document
    integer, intent(in) :: i
    integer, intent(inout) :: e
    logical, intent(in) :: first_wins
    type(value_t), intent(inout) :: values(:)
    type(message_list_t), intent(inout) :: errors, notices
    character(:), allocatable, intent(inout) :: inert
    character(:), allocatable :: name, meant
    integer :: s, k
    logical :: is_inert, counts

    name = document%sections(i)%name
    s = registry%find_section(name)
    meant = name
    if (s == 0 .and. len(name) > 0) &
      call report_unknown_section(registry, document%sections(i)%file, document%sections(i)%line, name, &
                                  meant, errors)
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
        if (len(meant) == 0) cycle ! the header was broken or unknown, which is mistake enough
        k = registry%find(meant, entry%key)
        if (k > 0 .and. counts) then
          call read_entry(registry, spacing, entry, k, key_counts(registry, document, k), first_wins, values, errors, &
                          notices, inert)
        else if (k > 0) then
          call note_inert(inert, '['//printable(name, 60)//']', '')
          call read_quietly(registry, spacing, entry, k, values)
        else if (is_inert .or. .not. counts) then
          call note_inert(inert, '['//printable(name, 60)//']', '')
        else
          call report_unknown_key(registry, entry%file, entry%line, meant, entry%key, k, errors)
          if (k > 0) values(k)%is_excused = .true.
        end if
      end associate
    end do
  end subroutine read_section

  subroutine read_entry(registry, spacing, entry, k, counts, first_wins, values, errors, notices, inert)
    type(registry_t), intent(in) :: registry
    real(rp), intent(in) :: spacing
    type(ini_entry_t), intent(in) :: entry
    integer, intent(in) :: k
    logical, intent(in) :: counts, first_wins
    type(value_t), intent(inout) :: values(:)
    type(message_list_t), intent(inout) :: errors, notices
    character(:), allocatable, intent(inout) :: inert
    character(:), allocatable :: problem, place
    associate (key => registry%keys(k)%key, value => values(k))
      if (key%kind == KEY_INERT) then
        call note_inert(inert, '['//key%section//'] '//printable(entry%key, 60), &
                        ' (line '//number_text(entry%line)//')')
        return
      end if
      place = entry%file//':'//number_text(entry%line)//': ['//key%section//'] '//entry%key//': '
      if (value%line > 0) then
        if (entry%depth > value%depth) return ! a file has the last word on what it includes
        problem = 'is given twice, first in '//line_text(value, entry%file)
        if (value%spelling /= entry%key) problem = problem//' under the name '//value%spelling
        if (first_wins) then
          call notices%add(place//problem//'; the first one counts')
        else
          call errors%add(place//problem)
        end if
        return
      end if
      value%line = entry%line
      value%file = entry%file
      value%depth = entry%depth
      value%spelling = entry%key
      if (len(entry%value) == 0 .and. .not. entry%is_matrix) return ! "key=;" asks for the default
      call read_value(key, entry%value, entry%is_matrix, entry%line, spacing, value, problem)
      value%is_unbuilt = value%is_unbuilt .and. counts
      value%is_given = .not. allocated(problem)
      value%is_excused = .not. value%is_given
      value%is_known = value%is_known .or. value%is_given
      if (.not. allocated(problem)) return
      if (counts) call errors%add(place//problem)
      if (.not. counts) call note_inert(inert, '['//key%section//'] '//printable(entry%key, 60), &
                                        ' (line '//number_text(entry%line)//')')
    end associate
  end subroutine read_entry

  !> Where a value stands, as seen from `file`.
  function line_text(value, file) result(text)
    type(value_t), intent(in) :: value
    character(*), intent(in) :: file
    character(:), allocatable :: text
    text = 'line '//number_text(value%line)
    if (value%file /= file) text = text//' of '//value%file
  end function line_text

  !> `read_entry` where mistakes do not matter.
  subroutine read_quietly(registry, spacing, entry, k, values)
    type(registry_t), intent(in) :: registry
    real(rp), intent(in) :: spacing
    type(ini_entry_t), intent(in) :: entry
    integer, intent(in) :: k
    type(value_t), intent(inout) :: values(:)
    type(message_list_t) :: errors, notices
    character(:), allocatable :: inert
    inert = ''
    call read_entry(registry, spacing, entry, k, .false., .true., values, errors, notices, inert)
  end subroutine read_quietly
end module io_entries

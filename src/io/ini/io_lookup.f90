! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes messages about sections and keys that are not registered, or have no effect.
module io_lookup
  use base_errors, only: message_list_t
  use base_text, only: number_text, printable, to_lower
  use io_ini, only: ini_document_t
  use io_key, only: KEY_INERT
  use io_registry, only: registry_t
  use io_suggest, only: suggestion_t
  implicit none
  private
  public :: report_unbuilt_sections, report_unknown_section, report_unknown_key, note_inert

contains

  !> Adds the mistake that the document has a section of other equations, and sets `is_foreign`. `is_all`: the other sections of
  !> the document are not checked.
  subroutine report_unbuilt_sections(registry, document, errors, is_foreign, is_all)
    type(registry_t), intent(in) :: registry
    type(ini_document_t), intent(in) :: document
    type(message_list_t), intent(inout) :: errors
    logical, intent(inout) :: is_foreign
    logical, intent(out) :: is_all
    integer :: i, s
    is_all = .false.
    do i = 1, document%n_sections
      s = registry%find_section(document%sections(i)%name)
      if (s == 0) cycle
      if (.not. allocated(registry%sections(s)%unbuilt)) cycle
      is_foreign = .true.
      is_all = is_all .or. .not. registry%sections(s)%can_go
      call errors%add(document%sections(i)%file//':'//number_text(document%sections(i)%line)//': ['// &
                      document%sections(i)%name//']: '//registry%sections(s)%unbuilt)
    end do
  end subroutine report_unbuilt_sections

  !> Adds the mistake that section `name` in this line of `file` is unknown. `meant` becomes the known
  !> section that was most likely meant, empty if none is near.
  subroutine report_unknown_section(registry, file, line, name, meant, errors)
    type(registry_t), intent(in) :: registry
    character(*), intent(in) :: file, name
    integer, intent(in) :: line
    character(:), allocatable, intent(out) :: meant
    type(message_list_t), intent(inout) :: errors
    type(suggestion_t) :: suggestion
    character(:), allocatable :: choices
    integer :: i
    call suggestion%start(name)
    choices = ''
    do i = 1, registry%n_sections
      call suggestion%offer(registry%sections(i)%name)
      if (.not. registry%sections(i)%is_inert) choices = choices//' | '//registry%sections(i)%name
    end do
    meant = ''
    if (allocated(suggestion%best)) meant = suggestion%best
    call errors%add(file//':'//number_text(line)//': ['//printable(name, 60)//']: '// &
                    what_is_wrong('section', name, meant)//'; valid: '//choices(4:)//suggestion%hint())
  end subroutine report_unknown_section

  !> Adds the mistake that `key` is unknown in the known section `section`. `meant` becomes the index
  !> of the key that was most likely meant, 0 if none is near.
  subroutine report_unknown_key(registry, file, line, section, key, meant, errors)
    type(registry_t), intent(in) :: registry
    character(*), intent(in) :: file, section, key
    integer, intent(in) :: line
    integer, intent(out) :: meant
    type(message_list_t), intent(inout) :: errors
    type(suggestion_t) :: suggestion
    character(:), allocatable :: choices, elsewhere, text
    integer :: i
    call suggestion%start(key)
    choices = ''
    elsewhere = ''
    do i = 1, registry%n_keys
      associate (known => registry%keys(i)%key)
        if (known%section == section) then
          call suggestion%offer(known%name)
          if (known%kind /= KEY_INERT) choices = choices//' | '//known%name
        else if (known%name == key) then
          elsewhere = elsewhere//' or ['//known%section//']'
        end if
      end associate
    end do
    do i = 1, registry%n_aliases
      if (registry%aliases(i)%section == section) call suggestion%offer(registry%aliases(i)%old_name)
    end do
    meant = 0
    text = ''
    if (allocated(suggestion%best)) then
      meant = registry%find(section, suggestion%best)
      text = suggestion%best
    end if
    text = what_is_wrong('key', key, text)
    if (len(elsewhere) > 0) text = text//', it belongs to '//elsewhere(5:)
    if (len(choices) > 0) text = text//'; valid: '//choices(4:)
    if (len(elsewhere) == 0) text = text//suggestion%hint() ! a name that another section has is no misspelling
    call errors%add(file//':'//number_text(line)//': ['//section//'] '//printable(key, 60)//': '//text)
  end subroutine report_unknown_key

  !> Returns the beginning of a message about an unknown name.
  function what_is_wrong(thing, name, meant) result(text)
    character(*), intent(in) :: thing, name, meant
    character(:), allocatable :: text
    text = 'unknown '//thing
    if (len(meant) == 0 .or. len(name) > 60) return
    if (to_lower(name) == to_lower(meant)) text = text//' (names are case-sensitive)'
  end function what_is_wrong
  !> Adds `name` to the list of keys without effect, unless the list has it.
  subroutine note_inert(inert, name, place)
    character(:), allocatable, intent(inout) :: inert
    character(*), intent(in) :: name, place
    if (index(inert//',', ', '//name//',') > 0 .or. index(inert, ', '//name//' (') > 0) return
    inert = inert//', '//name//place
  end subroutine note_inert
end module io_lookup

! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the sections and keys of a registry, and lists them: as Markdown tables for the documentation, and those of checkpoints.
module io_key_table
  use base_errors, only: message_list_t
  use io_key, only: KEY_INERT, KEY_SWITCH, KEY_WORD, key_t, spaced_choices
  implicit none
  private
  public :: condition_t, key_entry_t, section_t, list_state_keys, write_key_tables

  !> A condition on which a section or a key depends.
  type :: condition_t
    integer :: key = 0                 !< index of the deciding key
    character(:), allocatable :: words !< a|b: the values with which it counts
  end type condition_t

  type :: section_t
    character(:), allocatable :: name, help
    character(:), allocatable :: unbuilt !< message to a file with this section, if its physics is not built here
    logical :: can_go = .false.   !< the file is valid without this section, so that its other sections are checked
    logical :: is_inert = .false. !< keys that are not declared are accepted without effect
    logical :: in_checkpoint = .false. !< the state in a checkpoint depends on every key of the section
    type(condition_t), allocatable :: conditions(:) !< without them the section always counts
  end type section_t

  !> A key in a list: lists grow by moving keys instead of copying them.
  type :: key_entry_t
    type(key_t), allocatable :: key
    type(condition_t), allocatable :: conditions(:) !< all must hold; without them the key always counts
  end type key_entry_t

contains

  !> Lists the keys on which the state in a checkpoint depends, as patterns `[section] key`, and `[section] *` for all of a
  !> section.
  subroutine list_state_keys(sections, keys, patterns)
    type(section_t), intent(in) :: sections(:)
    type(key_entry_t), intent(in) :: keys(:)
    type(message_list_t), intent(out) :: patterns
    integer :: i
    do i = 1, size(sections)
      if (sections(i)%in_checkpoint) call patterns%add('['//sections(i)%name//'] *')
    end do
    do i = 1, size(keys)
      if (keys(i)%key%in_checkpoint) call patterns%add('['//keys(i)%key%section//'] '//keys(i)%key%name)
    end do
  end subroutine list_state_keys

  !> Writes for each section its heading, its help, the table of its keys, and the names of keys without effect.
  subroutine write_key_tables(unit, section, keys)
    integer, intent(in) :: unit
    type(section_t), intent(in) :: section
    type(key_entry_t), intent(in) :: keys(:)
    character(:), allocatable :: inert
    logical :: has_table
    integer :: i
    write (unit, '(a)') '## ['//section%name//']', ''
    if (len(section%help) > 0) write (unit, '(a)') section%help, ''
    if (section%is_inert) &
      write (unit, '(a)') 'All other keys of this section are accepted without effect.', ''
    if (allocated(section%conditions)) call write_conditions(unit, section%conditions, keys)
    has_table = .false.
    inert = ''
    do i = 1, size(keys)
      if (keys(i)%key%section /= section%name) cycle
      if (keys(i)%key%kind == KEY_INERT) then
        inert = inert//', `'//keys(i)%key%name//'`'
        cycle
      end if
      if (.not. has_table) write (unit, '(a)') '| key | type | unit | default | allowed | meaning |', &
        '|---|---|---|---|---|---|'
      has_table = .true.
      call write_row(unit, keys(i)%key)
    end do
    if (has_table) write (unit, '(a)') ''
    if (len(inert) > 0) write (unit, '(a)') 'Accepted from FLUSI files, without effect: '//inert(3:)//'.', ''
  end subroutine write_key_tables

  !> Writes when a section has an effect.
  subroutine write_conditions(unit, conditions, keys)
    integer, intent(in) :: unit
    type(condition_t), intent(in) :: conditions(:)
    type(key_entry_t), intent(in) :: keys(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(conditions)
      associate (key => keys(conditions(i)%key)%key)
        text = text//' and ['//key%section//'] `'//key%name//'` is '//spaced_choices(conditions(i)%words)
      end associate
    end do
    write (unit, '(a)') 'This section has no effect unless'//text(5:)//'.', ''
  end subroutine write_conditions

  !> Writes the table row of a key.
  subroutine write_row(unit, key)
    integer, intent(in) :: unit
    type(key_t), intent(in) :: key
    character(:), allocatable :: default, allowed
    default = '`'//key%default_text//'`'
    if (len(key%default_text) == 0) default = 'none'
    if (key%is_computed) default = key%default_text
    if (key%is_required) default = 'required'
    allowed = key%range_text()
    if (key%kind == KEY_WORD) allowed = spaced_choices(key%allowed)
    if (key%kind == KEY_SWITCH) allowed = 'yes | no'
    if (key%kind == KEY_SWITCH .and. len(key%unbuilt) > 0) allowed = 'no'
    write (unit, '(a)') '| `'//key%name//'` | '//key%kind_text()//' | '//escaped(key%unit)//' | '// &
      escaped(default)//' | '//escaped(allowed)//' | '//escaped(key%help)//' |'
  end subroutine write_row

  !> Returns the text with escaped bars, because a bar inside a cell would end it.
  pure function escaped(text) result(cell)
    character(*), intent(in) :: text
    character(:), allocatable :: cell
    integer :: i
    cell = ''
    do i = 1, len(text)
      if (text(i:i) == '|') cell = cell//'\'
      cell = cell//text(i:i)
    end do
  end function escaped
end module io_key_table

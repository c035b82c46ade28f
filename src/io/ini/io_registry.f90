! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the register of ini keys. Each key is declared once, with all its properties. Reading, error messages, `--check` and the
!> parameter table of the documentation use the register.
module io_registry
  use base_errors, only: require
  use base_kinds, only: rp
  use base_text, only: number_text
  use io_foreign, only: foreign_inputs_t
  use io_key, only: KEY_INERT, KEY_INTEGER, KEY_LENGTH, KEY_MATRIX, KEY_REAL, KEY_REALS, KEY_SWITCH, &
                    KEY_TEXT, KEY_WORD, describe, key_t, matches_pattern, set_limits, set_lower, set_upper
  use io_key_table, only: condition_t, key_entry_t, section_t, write_key_tables
  use io_value, only: is_length, read_value, value_t
  implicit none
  private
  public :: registry_t

  !> FLUSI's older name of a key.
  type :: alias_t
    character(:), allocatable :: section, name, old_name
  end type alias_t

  !> All sections, keys and aliases, in the order of their declaration. A second declaration, or a default that the key itself would
  !> refuse, is a programmer error.
  type :: registry_t
    type(section_t), allocatable :: sections(:)
    type(key_entry_t), allocatable :: keys(:) !< the first n_keys slots are filled
    type(alias_t), allocatable :: aliases(:)
    integer :: n_sections = 0, n_keys = 0, n_aliases = 0
    type(foreign_inputs_t) :: foreign !< what distinguishes inputs of this program from those of others
    integer :: points_key = 0, length_key = 0 !< N*dx means N*(length/points); 0: no such lattice
  contains
    procedure :: add_section => registry_add_section
    procedure :: add_integer => registry_add_integer
    procedure :: add_real => registry_add_real
    procedure :: add_length => registry_add_length
    procedure :: add_switch => registry_add_switch
    procedure :: add_word => registry_add_word
    procedure :: add_text => registry_add_text
    procedure :: add_reals => registry_add_reals
    procedure :: add_matrix => registry_add_matrix
    procedure :: add_inert => registry_add_inert
    procedure :: add_inert_section => registry_add_inert_section
    procedure :: add_unbuilt_section => registry_add_unbuilt_section
    procedure :: add_alias => registry_add_alias
    procedure :: only_if => registry_only_if
    procedure :: key_only_if => registry_key_only_if
    procedure :: set_lattice => registry_set_lattice
    procedure :: find_section => registry_find_section
    procedure :: find => registry_find
    procedure :: write_markdown => registry_write_markdown
  end type registry_t

contains

  !> Declares a section with its line of help; of several declarations the first help counts. Keys
  !> declare their section by themselves, without help.
  subroutine registry_add_section(self, section, help)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, help
    type(section_t), allocatable :: larger(:)
    integer :: i
    i = self%find_section(section)
    if (i > 0) then
      if (len(self%sections(i)%help) == 0) self%sections(i)%help = help
      return
    end if
    if (.not. allocated(self%sections)) allocate (self%sections(16))
    if (self%n_sections == size(self%sections)) then
      allocate (larger(2*self%n_sections))
      larger(:self%n_sections) = self%sections(:self%n_sections)
      call move_alloc(larger, self%sections)
    end if
    self%n_sections = self%n_sections + 1
    self%sections(self%n_sections)%name = section
    self%sections(self%n_sections)%help = help
  end subroutine registry_add_section

  !> Declares an integer key, min <= value <= max.
  subroutine registry_add_integer(self, section, key, default, help, unit, min, max, required)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, help
    integer, intent(in) :: default
    character(*), intent(in), optional :: unit
    integer, intent(in), optional :: min, max
    logical, intent(in), optional :: required
    type(key_t) :: new
    call describe(new, KEY_INTEGER, section, key, number_text(default), help, unit, required)
    if (present(min)) call set_lower(new, real(min, rp), is_open=.false.)
    if (present(max)) call set_upper(new, real(max, rp), is_open=.false.)
    call add_key(self, new)
  end subroutine registry_add_integer

  !> Declares a real key, min <= value <= max or above < value < below.
  subroutine registry_add_real(self, section, key, default, help, unit, min, max, above, below, required)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, help
    real(rp), intent(in) :: default
    character(*), intent(in), optional :: unit
    real(rp), intent(in), optional :: min, max, above, below
    logical, intent(in), optional :: required
    type(key_t) :: new
    call describe(new, KEY_REAL, section, key, number_text(default), help, unit, required)
    call set_limits(new, min, max, above, below)
    call add_key(self, new)
  end subroutine registry_add_real

  !> Declares a real that may also be written N*dx. A default that is not such a number, 'xl/2', describes a value that the
  !> program computes; get_real may then be called only if the key is given.
  subroutine registry_add_length(self, section, key, default_text, help, unit, min, max, above, below, &
                                 required)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, default_text, help
    character(*), intent(in), optional :: unit
    real(rp), intent(in), optional :: min, max, above, below
    logical, intent(in), optional :: required
    type(key_t) :: new
    call describe(new, KEY_LENGTH, section, key, default_text, help, unit, required)
    call set_limits(new, min, max, above, below)
    call add_key(self, new)
  end subroutine registry_add_length

  !> Declares a key yes|no|1|0|true|false|.true.|.false. With `unbuilt`, the name of some physics, yes is a mistake, and `instead`
  !> says what to give. With `computed`, a sentence, the program computes the default; get_switch may then be called only if the
  !> key is given.
  subroutine registry_add_switch(self, section, key, default, help, unbuilt, computed, instead)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, help
    logical, intent(in) :: default
    character(*), intent(in), optional :: unbuilt, computed, instead
    type(key_t) :: new
    call describe(new, KEY_SWITCH, section, key, trim(merge('yes', 'no ', default)), help)
    if (present(unbuilt)) new%unbuilt = unbuilt
    if (present(computed)) new%default_text = computed
    new%is_computed = present(computed)
    if (present(instead)) new%instead = '*: '//instead
    call add_key(self, new)
  end subroutine registry_add_switch

  !> Declares a key with one of the words of `allowed`, 'a|b|from_file::*'. Words of `unbuilt` are known but refused; `instead`,
  !> 'a: sentence|b*: sentence', says for some of them what to give.
  subroutine registry_add_word(self, section, key, default, allowed, help, unbuilt, required, instead)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, default, allowed, help
    character(*), intent(in), optional :: unbuilt, instead
    logical, intent(in), optional :: required
    type(key_t) :: new
    call describe(new, KEY_WORD, section, key, default, help, required=required)
    new%allowed = allowed
    if (present(unbuilt)) new%unbuilt = unbuilt
    if (present(instead)) new%instead = instead
    call add_key(self, new)
  end subroutine registry_add_word

  !> Declares a key of free text, such as the name of a file. If it is `computed`, `default` is a sentence and the program computes
  !> the default; get_text may then be called only if the key is given.
  subroutine registry_add_text(self, section, key, default, help, required, computed)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, default, help
    logical, intent(in), optional :: required, computed
    type(key_t) :: new
    call describe(new, KEY_TEXT, section, key, default, help, required=required)
    if (present(computed)) new%is_computed = computed
    call add_key(self, new)
  end subroutine registry_add_text

  !> Declares a key that is a list of reals separated by blanks or commas: exactly `length` of them, or any number.
  subroutine registry_add_reals(self, section, key, default, help, unit, length, min, max)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, help
    real(rp), intent(in) :: default(:)
    character(*), intent(in), optional :: unit
    integer, intent(in), optional :: length
    real(rp), intent(in), optional :: min, max
    type(key_t) :: new
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(default)
      text = text//' '//number_text(default(i))
    end do
    call describe(new, KEY_REALS, section, key, trim(adjustl(text)), help, unit)
    if (present(length)) new%length = length
    call set_limits(new, min, max)
    call add_key(self, new)
  end subroutine registry_add_reals

  !> Declares a key that is a matrix of reals over several lines; `columns` numbers in each row, 0 for any equal number. The
  !> default has no rows.
  subroutine registry_add_matrix(self, section, key, columns, help)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, help
    integer, intent(in) :: columns
    type(key_t) :: new
    call describe(new, KEY_MATRIX, section, key, '', help)
    new%columns = columns
    call add_key(self, new)
  end subroutine registry_add_matrix

  !> Declares a key of FLUSI that has no effect here: any value is accepted. `key` may end in '*'.
  subroutine registry_add_inert(self, section, key, help)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, help
    type(key_t) :: new
    call describe(new, KEY_INERT, section, key, '', help)
    call add_key(self, new)
  end subroutine registry_add_inert

  !> Declares a section of FLUSI in which all keys that are not declared are accepted without effect. `section` may end in '*'.
  subroutine registry_add_inert_section(self, section, help)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, help
    integer :: i
    call self%add_section(section, help)
    i = self%find_section(section)
    call require(.not. self%sections(i)%is_inert, 'io_registry: ['//section//'] is declared inert twice')
    self%sections(i)%is_inert = .true.
  end subroutine registry_add_inert_section

  !> Declares a section of FLUSI that belongs to other equations: `physics` is their name, `instead` says what to give. A file with
  !> this section is refused by one message, unless it is valid without the section (`can_go`).
  subroutine registry_add_unbuilt_section(self, section, physics, instead, can_go)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, physics, instead
    logical, intent(in), optional :: can_go
    call self%add_inert_section(section, 'This program does not have '//physics//'.')
    self%sections(self%n_sections)%unbuilt = 'asks for '//physics//', which this program does not have; use instead: '//instead
    if (present(can_go)) self%sections(self%n_sections)%can_go = can_go
  end subroutine registry_add_unbuilt_section

  !> Declares an older name of the declared key [section] key.
  subroutine registry_add_alias(self, section, key, old_name)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, old_name
    type(alias_t), allocatable :: larger(:)
    integer :: i
    call require(self%find(section, key) > 0, 'io_registry: alias of the unknown key ['//section//'] '//key)
    call require(self%find(section, old_name) == 0, 'io_registry: ['//section//'] '//old_name// &
                 ' is declared twice')
    if (.not. allocated(self%aliases)) allocate (self%aliases(8))
    if (self%n_aliases == size(self%aliases)) then
      allocate (larger(2*self%n_aliases))
      do i = 1, self%n_aliases
        call move_alloc(self%aliases(i)%section, larger(i)%section)
        call move_alloc(self%aliases(i)%name, larger(i)%name)
        call move_alloc(self%aliases(i)%old_name, larger(i)%old_name)
      end do
      call move_alloc(larger, self%aliases)
    end if
    self%n_aliases = self%n_aliases + 1
    self%aliases(self%n_aliases)%section = section
    self%aliases(self%n_aliases)%name = key
    self%aliases(self%n_aliases)%old_name = old_name
  end subroutine registry_add_alias

  !> Makes a section count only if [deciding_section] deciding_key has one of the values `words`, 'a|b'. If there are several such
  !> conditions all must hold. Otherwise the section has no effect: valid values are kept, and invalid values and unknown keys are
  !> not mistakes.
  subroutine registry_only_if(self, section, deciding_section, deciding_key, words)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, deciding_section, deciding_key, words
    integer :: s, k
    s = self%find_section(section)
    k = self%find(deciding_section, deciding_key)
    call require(s > 0 .and. k > 0, 'io_registry: a condition on unknown names: ['//section//'] '//deciding_key)
    call add_condition(self%sections(s)%conditions, condition_t(k, words))
  end subroutine registry_only_if

  !> Makes a wrong or missing value of [section] key a mistake only if [deciding_section] deciding_key has one of the values
  !> `words`. If there are several such conditions all must hold.
  subroutine registry_key_only_if(self, section, key, deciding_section, deciding_key, words)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: section, key, deciding_section, deciding_key, words
    integer :: k, d
    k = self%find(section, key)
    d = self%find(deciding_section, deciding_key)
    call require(k > 0 .and. d > 0, 'io_registry: a condition on unknown keys: '//key//', '//deciding_key)
    call add_condition(self%keys(k)%conditions, condition_t(d, words))
  end subroutine registry_key_only_if

  !> Adds a condition to a list.
  subroutine add_condition(conditions, condition)
    type(condition_t), allocatable, intent(inout) :: conditions(:)
    type(condition_t), intent(in) :: condition
    if (.not. allocated(conditions)) allocate (conditions(0))
    conditions = [conditions, condition]
  end subroutine add_condition

  !> Declares what dx stands for: N*dx is N times the value of the real [length_section] length_key
  !> divided by the integer [points_section] points_key.
  subroutine registry_set_lattice(self, points_section, points_key, length_section, length_key)
    class(registry_t), intent(inout) :: self
    character(*), intent(in) :: points_section, points_key, length_section, length_key
    self%points_key = self%find(points_section, points_key)
    self%length_key = self%find(length_section, length_key)
    call require(self%points_key > 0 .and. self%length_key > 0, 'io_registry: the lattice has unknown keys')
    call require(self%keys(self%points_key)%key%kind == KEY_INTEGER, &
                 'io_registry: '//points_key//' is no integer')
    associate (kind => self%keys(self%length_key)%key%kind)
      call require(kind == KEY_REAL .or. kind == KEY_LENGTH, 'io_registry: '//length_key//' is no real')
    end associate
  end subroutine registry_set_lattice

  !> Returns the index of the section in `sections`, 0 if it is unknown. An inert pattern counts only if no section has exactly
  !> this name.
  integer function registry_find_section(self, section) result(found)
    class(registry_t), intent(in) :: self
    character(*), intent(in) :: section
    integer :: i
    found = 0
    do i = 1, self%n_sections
      if (self%sections(i)%name == section) found = i
    end do
    do i = 1, self%n_sections
      if (found > 0) return
      if (self%sections(i)%is_inert .and. matches_pattern(section, self%sections(i)%name)) found = i
    end do
  end function registry_find_section

  !> Returns the index in `keys` of the key with this exact name or alias, or of the inert pattern that it matches; 0 if there is
  !> none.
  recursive integer function registry_find(self, section, name) result(found)
    class(registry_t), intent(in) :: self
    character(*), intent(in) :: section, name
    integer :: i
    do found = 1, self%n_keys
      associate (key => self%keys(found)%key)
        if (key%name == name .and. key%section == section) return
      end associate
    end do
    do i = 1, self%n_aliases
      if (self%aliases(i)%old_name == name .and. self%aliases(i)%section == section) then
        found = self%find(section, self%aliases(i)%name)
        return
      end if
    end do
    do found = 1, self%n_keys
      associate (key => self%keys(found)%key)
        if (key%kind == KEY_INERT .and. key%section == section) then
          if (matches_pattern(name, key%name)) return
        end if
      end associate
    end do
    found = 0
  end function registry_find

  !> Writes one Markdown table a section to `unit`: key, kind, unit, default, limits or choices, help.
  subroutine registry_write_markdown(self, unit)
    class(registry_t), intent(in) :: self
    integer, intent(in) :: unit
    integer :: i, j
    do i = 1, self%n_sections
      call write_key_tables(unit, self%sections(i), self%keys(:self%n_keys))
      do j = 1, self%n_aliases
        if (self%aliases(j)%section == self%sections(i)%name) write (unit, '(a)') 'Older name of `'// &
          self%aliases(j)%name//'`: `'//self%aliases(j)%old_name//'`.', ''
      end do
    end do
  end subroutine registry_write_markdown

  !> Adds a key, which must be new, and its section.
  subroutine add_key(self, new)
    class(registry_t), intent(inout) :: self
    type(key_t), intent(inout) :: new
    type(key_entry_t), allocatable :: larger(:)
    integer :: i
    call require(self%find(new%section, new%name) == 0, 'io_registry: ['//new%section//'] '//new%name// &
                 ' is declared twice')
    call check_default(new)
    call self%add_section(new%section, '')
    if (.not. allocated(self%keys)) allocate (self%keys(64))
    if (self%n_keys == size(self%keys)) then
      allocate (larger(2*self%n_keys))
      do i = 1, self%n_keys
        call move_alloc(self%keys(i)%key, larger(i)%key)
        call move_alloc(self%keys(i)%conditions, larger(i)%conditions)
      end do
      call move_alloc(larger, self%keys)
    end if
    self%n_keys = self%n_keys + 1
    allocate (self%keys(self%n_keys)%key, source=new)
  end subroutine add_key

  !> Checks that the default passes the checks of a value from a file.
  subroutine check_default(new)
    type(key_t), intent(inout) :: new
    character(:), allocatable :: problem
    type(value_t) :: unused
    if (new%kind == KEY_INERT .or. new%kind == KEY_MATRIX .or. new%is_required) return
    if (new%kind == KEY_LENGTH) new%is_computed = .not. is_length(new%default_text)
    if (new%is_computed) return
    call read_value(new, new%default_text, .false., 0, 1.0_rp, unused, problem)
    call require(.not. allocated(problem), 'io_registry: ['//new%section//'] '//new%name// &
                 ' has a default that it would refuse: '//new%default_text)
  end subroutine check_default
end module io_registry

! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the values of all registered keys, from one ini file and the defaults.
!>
!> Loading never stops the program. It returns all mistakes of the file together, each as `file:line: [section] key: problem; valid:
!> a | b; did you mean 'b'?`, and a key with a mistake has its default. Nothing here is collective: every rank loads the same text.
module io_config
  use base_errors, only: message_list_t, require
  use base_files, only: real_path
  use base_kinds, only: rp
  use base_text, only: number_text
  use io_entries, only: read_section, reading_t
  use io_lookup, only: report_unbuilt_sections
  use io_ini, only: ini_document_t
  use io_include, only: add_included, INCLUDE_SECTION
  use io_key, only: KEY_INERT, KEY_INTEGER, KEY_LENGTH, KEY_MATRIX, KEY_REAL, KEY_REALS, KEY_SWITCH, KEY_TEXT, KEY_WORD
  use io_key_table, only: list_state_keys
  use io_peek, only: find_spacing, key_counts
  use io_registry, only: registry_t
  use io_broadcast_text, only: add_named_files, content_note, read_text_file
  use io_units, only: unit_scales_t, unit_value
  use io_value, only: effective_line, input_text, read_value, value_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: config_t

  type :: config_t
    private
    type(registry_t) :: registry
    type(value_t), allocatable :: values(:) !< of the key with the same index in the registry
    character(:), allocatable :: name       !< of the file
    type(message_list_t) :: sources         !< real paths of the file and of those that it includes
    real(rp) :: spacing = 0                 !< the length that dx stands for, 0 if unknown
    type(unit_scales_t) :: scales           !< of the numbers of the file
    logical :: has_scales = .false.
    logical :: is_foreign = .false.         !< the file belongs to another program or other equations
  contains
    procedure :: load_file => config_load_file
    procedure :: load_text => config_load_text
    procedure :: get_integer => config_get_integer
    procedure :: get_real => config_get_real
    procedure :: get_switch => config_get_switch
    procedure :: get_word => config_get_word
    procedure :: get_text => config_get_text
    procedure :: get_reals => config_get_reals
    procedure :: get_matrix => config_get_matrix
    procedure :: set_units => config_set_units
    procedure :: is_given => config_is_given
    procedure :: file_name => config_file_name
    procedure :: line_of => config_line_of
    procedure :: print_effective => config_print_effective
    procedure :: asks_for_unbuilt => config_asks_for_unbuilt
    procedure :: complain => config_complain
    procedure :: settle => config_settle
    procedure :: reads => config_reads
    procedure :: inputs => config_inputs
    procedure :: state_keys => config_state_keys
    procedure :: named_files => config_named_files
  end type config_t

contains

  !> Reads the file at `path` on the calling rank; see `load_text`.
  subroutine config_load_file(self, path, registry, errors, notices, flusi_compat)
    class(config_t), intent(inout) :: self
    character(*), intent(in) :: path
    type(registry_t), intent(in) :: registry
    type(message_list_t), intent(inout) :: errors, notices
    logical, intent(in), optional :: flusi_compat
    character(:), allocatable :: text, problem
    call read_text_file(path, text, problem)
    if (allocated(problem)) then
      call start(self, path, registry)
      call errors%add(problem)
    else
      call self%load_text(text, path, registry, errors, notices, flusi_compat)
    end if
  end subroutine config_load_file

  !> Reads `text`, the content of the file called `name`, by the rules of `registry`. Adds every mistake to `errors` and what the
  !> user should know to `notices`. With `flusi_compat` the first of several equal keys counts, with a notice, instead of being a
  !> mistake. Values that were loaded before are discarded. Files that [include] names, if the registry knows it, are read by root
  !> if there is a `world`, which makes the call collective, and else by the calling rank.
  subroutine config_load_text(self, text, name, registry, errors, notices, flusi_compat, world)
    class(config_t), intent(inout) :: self
    character(*), intent(in) :: text, name
    type(registry_t), intent(in) :: registry
    type(message_list_t), intent(inout) :: errors, notices
    logical, intent(in), optional :: flusi_compat
    type(world_t), intent(in), optional :: world
    type(ini_document_t) :: document
    type(reading_t) :: reading
    logical :: is_all
    integer :: i, j

    call start(self, name, registry)
    call document%parse(text, name, errors)
    self%sources = message_list_t()
    call self%sources%add(real_path(name))
    if (registry%find_section(INCLUDE_SECTION) > 0) call add_included(document, errors, self%sources, world)
    call report_unbuilt_sections(registry, document, errors, self%is_foreign, is_all)
    self%is_foreign = self%is_foreign .or. document%is_foreign
    is_all = is_all .or. document%is_foreign
    if (.not. self%is_foreign) call registry%foreign%report(document, errors, is_all)
    self%is_foreign = self%is_foreign .or. is_all
    if (is_all) return
    ! The spacing is read first, because every length may need it and its keys may come later in the file.
    self%spacing = find_spacing(registry, document)
    do i = 1, registry%n_keys
      if (registry%keys(i)%key%kind == KEY_LENGTH) call set_default(self, i)
    end do
    call reading%begin(self%spacing, errors, notices, flusi_compat)
    j = 1
    do i = 1, document%n_sections
      call read_section(registry, document, i, j, reading, self%values)
    end do
    errors = reading%errors
    notices = reading%notices
    do i = 1, registry%n_keys
      associate (key => self%registry%keys(i)%key)
        if (key%is_required .and. key_counts(registry, document, i) .and. &
            .not. (self%values(i)%is_given .or. self%values(i)%is_excused)) &
          call self%complain(errors, key%section, key%name, 'is missing; valid: '//key%choices_text())
      end associate
    end do
    if (len(reading%inert) > 0) call notices%add(name//': accepted, but without effect here: '//reading%inert(3:))
  end subroutine config_load_text

  !> Sets all keys to their defaults.
  subroutine start(self, name, registry)
    class(config_t), intent(inout) :: self
    character(*), intent(in) :: name
    type(registry_t), intent(in) :: registry
    integer :: i
    self%name = name
    self%registry = registry
    self%spacing = 0
    self%scales = unit_scales_t()
    self%has_scales = .false.
    self%is_foreign = .false.
    if (allocated(self%values)) deallocate (self%values)
    allocate (self%values(registry%n_keys))
    do i = 1, registry%n_keys
      call set_default(self, i)
    end do
  end subroutine start

  !> Sets a default in N*dx again, once the spacing is known.
  subroutine set_default(self, i)
    class(config_t), intent(inout) :: self
    integer, intent(in) :: i
    character(:), allocatable :: problem
    associate (key => self%registry%keys(i)%key, value => self%values(i))
      value%text = ''
      if (.not. allocated(value%reals)) allocate (value%reals(key%length), source=0.0_rp)
      if (.not. allocated(value%matrix)) allocate (value%matrix(0, key%columns))
      value%is_known = .not. key%is_computed
      if (key%is_computed .or. key%kind == KEY_MATRIX .or. key%kind == KEY_INERT) return
      call read_value(key, key%default_text, .false., 0, self%spacing, value, problem)
    end associate
  end subroutine set_default

  !> Returns the value of an integer key.
  integer function config_get_integer(self, section, key) result(value)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    value = self%values(value_index(self, section, key, KEY_INTEGER, KEY_INTEGER))%whole
  end function config_get_integer

  !> Returns the value of a real or length key.
  real(rp) function config_get_real(self, section, key) result(value)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    integer :: i
    i = value_index(self, section, key, KEY_REAL, KEY_LENGTH)
    associate (found => self%values(i))
      value = found%number/found%unit
    end associate
  end function config_get_real

  !> Returns the value of a switch.
  logical function config_get_switch(self, section, key) result(value)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    value = self%values(value_index(self, section, key, KEY_SWITCH, KEY_SWITCH))%switch
  end function config_get_switch

  !> Returns the value of a word key: one of its allowed words.
  function config_get_word(self, section, key) result(value)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    character(:), allocatable :: value
    value = self%values(value_index(self, section, key, KEY_WORD, KEY_WORD))%text
  end function config_get_word

  !> Returns the value of a text key, trimmed.
  function config_get_text(self, section, key) result(value)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    character(:), allocatable :: value
    value = self%values(value_index(self, section, key, KEY_TEXT, KEY_TEXT))%text
  end function config_get_text

  !> Returns the value of a list of reals; its size is the registered length, if there is one.
  function config_get_reals(self, section, key) result(value)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    real(rp), allocatable :: value(:)
    integer :: i
    i = value_index(self, section, key, KEY_REALS, KEY_REALS)
    associate (found => self%values(i))
      value = found%reals/found%unit
    end associate
  end function config_get_reals

  !> Returns the value of a matrix, (row, column); no rows if it is not given.
  function config_get_matrix(self, section, key) result(value)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    real(rp), allocatable :: value(:, :)
    value = self%values(value_index(self, section, key, KEY_MATRIX, KEY_MATRIX))%matrix
  end function config_get_matrix

  !> Makes later calls read the numbers of the file in the units of `scales`. Defaults and results are always in L, T and M.
  subroutine config_set_units(self, scales)
    class(config_t), intent(inout) :: self
    type(unit_scales_t), intent(in) :: scales
    integer :: i
    self%scales = scales
    self%has_scales = .true.
    do i = 1, self%registry%n_keys
      if (self%values(i)%is_given) self%values(i)%unit = unit_value(self%registry%keys(i)%key%unit, scales)
    end do
  end subroutine config_set_units

  !> Tells whether the file gives a valid value, so that it is not the default.
  logical function config_is_given(self, section, key) result(is_given)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    is_given = self%values(find(self, section, key))%is_given
  end function config_is_given

  !> Returns the name of the file; files that it names may be in its folder.
  function config_file_name(self) result(name)
    class(config_t), intent(in) :: self
    character(:), allocatable :: name
    name = self%name
  end function config_file_name

  !> Tells whether `path` is the file itself, or one that it includes.
  logical function config_reads(self, path) result(reads)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: path
    integer :: i
    reads = .false.
    do i = 1, self%sources%count()
      reads = reads .or. self%sources%text(i) == real_path(path)
    end do
  end function config_reads

  !> Gives a key a value that the program has computed, from the keys of the file or because a key is missing. --check prints its
  !> `origin`.
  subroutine config_settle(self, section, key, text, origin)
    class(config_t), intent(inout) :: self
    character(*), intent(in) :: section, key, text, origin
    character(:), allocatable :: problem
    integer :: i
    i = find(self, section, key)
    call read_value(self%registry%keys(i)%key, text, .false., 0, self%spacing, self%values(i), problem)
    call require(.not. allocated(problem), 'io_config: ['//section//'] '//key//' cannot be '//text)
    self%values(i)%is_known = .true.
    self%values(i)%origin = origin
  end subroutine config_settle

  !> Returns the line of the file that gives the key, with a valid value or not; 0 if there is none.
  integer function config_line_of(self, section, key) result(line)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    line = self%values(find(self, section, key))%line
  end function config_line_of

  !> Tells whether the file requests a feature of FLUSI that this program lacks, or is not an input of this program. The other keys
  !> of the file then belong to another run.
  logical function config_asks_for_unbuilt(self) result(asks)
    class(config_t), intent(in) :: self
    asks = self%is_foreign .or. any(self%values%is_unbuilt)
  end function config_asks_for_unbuilt

  !> Adds the mistake `file:line: [section] key: text`, without the line if the key is not in the file. If the key already has a
  !> mistake, it has its default value, and no second message is added.
  subroutine config_complain(self, errors, section, key, text)
    class(config_t), intent(in) :: self
    type(message_list_t), intent(inout) :: errors
    character(*), intent(in) :: section, key, text
    character(:), allocatable :: place
    integer :: i
    do i = 1, errors%count()
      if (index(errors%text(i), ': ['//section//'] '//key//': ') > 0) return
    end do
    place = self%name
    i = find(self, section, key)
    associate (value => self%values(i))
      if (value%line > 0) place = value%file//':'//number_text(value%line)
    end associate
    call errors%add(place//': ['//section//'] '//key//': '//text)
  end subroutine config_complain

  !> Writes every key with its value, and behind ';' its unit and where the value comes from (file:line or default). The output is a
  !> valid ini file that gives the same values. If the file has other units, defaults are written in these units, too.
  subroutine config_print_effective(self, unit)
    class(config_t), intent(in) :: self
    integer, intent(in) :: unit
    integer :: s, i
    logical :: has_header
    do s = 1, self%registry%n_sections
      has_header = .false.
      do i = 1, self%registry%n_keys
        associate (key => self%registry%keys(i)%key)
          if (key%section /= self%registry%sections(s)%name .or. key%kind == KEY_INERT .or. &
              key%section == INCLUDE_SECTION) cycle ! what was included is printed
          if (.not. has_header) write (unit, '(a)') '['//key%section//']'
          has_header = .true.
          if (self%has_scales) then
            write (unit, '(a)') effective_line(key, self%values(i), unit_value(key%unit, self%scales))
          else
            write (unit, '(a)') effective_line(key, self%values(i))
          end if
        end associate
      end do
      if (has_header) write (unit, '(a)') ''
    end do
  end subroutine config_print_effective

  !> Returns all values in one text, of which each line is `[section] key = value`, in L, T and M. The name of a file is followed by
  !> a checksum of its content. Names of output files are left out. The calling rank reads the files; not collective.
  function config_inputs(self) result(text)
    class(config_t), intent(in) :: self
    character(:), allocatable :: text, line
    integer :: i
    text = ''
    do i = 1, self%registry%n_keys
      associate (key => self%registry%keys(i)%key, value => self%values(i))
        if (key%kind == KEY_INERT .or. key%section == INCLUDE_SECTION .or. .not. value%is_known) cycle
        line = input_text(key, value)
        if (any(key%kind == [KEY_TEXT, KEY_WORD]) .and. key%section /= 'Saving') line = line//content_note(value%text, self%name)
        text = text//'['//key%section//'] '//key%name//' = '//line//new_line('a')
      end associate
    end do
  end function config_inputs

  !> Returns the keys on which the state in a checkpoint depends, as patterns `[section] key`.
  function config_state_keys(self) result(patterns)
    class(config_t), intent(in) :: self
    type(message_list_t) :: patterns
    call list_state_keys(self%registry%sections(:self%registry%n_sections), self%registry%keys(:self%registry%n_keys), patterns)
  end function config_state_keys

  !> Adds the paths of all files that are read: the file itself, those that it includes, and the existing files that values name.
  !> Not collective.
  subroutine config_named_files(self, paths)
    class(config_t), intent(in) :: self
    type(message_list_t), intent(inout) :: paths
    integer :: i
    do i = 1, self%sources%count()
      call paths%add(self%sources%text(i))
    end do
    do i = 1, self%registry%n_keys
      associate (key => self%registry%keys(i)%key)
        if (any(key%kind == [KEY_TEXT, KEY_WORD]) .and. self%values(i)%is_known .and. key%section /= 'Saving') &
          call add_named_files(self%values(i)%text, self%name, paths)
      end associate
    end do
  end subroutine config_named_files

  !> Returns the number of a key, which must be registered.
  integer function find(self, section, key) result(i)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    call require(allocated(self%values), 'io_config: nothing was loaded')
    i = self%registry%find(section, key)
    call require(i > 0, 'io_config: ['//section//'] '//key//' is not registered')
  end function find

  !> Returns the index of a key of one of two kinds that has a value.
  integer function value_index(self, section, key, kind, or_kind) result(i)
    class(config_t), intent(in) :: self
    character(*), intent(in) :: section, key
    integer, intent(in) :: kind, or_kind
    i = find(self, section, key)
    associate (its_kind => self%registry%keys(i)%key%kind)
      call require(its_kind == kind .or. its_kind == or_kind, 'io_config: ['//section//'] '//key// &
                   ' is asked for as another type than it was registered with')
    end associate
    call require(self%values(i)%is_known, 'io_config: ['//section//'] '//key// &
                 ' has no value: its default is computed by the program, ask is_given first')
  end function value_index
end module io_config

! SPDX-License-Identifier: GPL-3.0-or-later
!> Binds ini keys to variables: one statement for each key has its name, the variable, the default, the help, the unit and the
!> range. A procedure of such statements either declares the keys or reads them.
!>
!>     subroutine solver_keys(keys, options)
!>       call keys%section('Solver', 'path of the static solution')
!>       call keys%real('tolerance', options%tolerance, 1.0e-8_rp, 'of the residual', min=1.0e-12_rp)
!>     end subroutine solver_keys
!>
!>     keys = declaring(registry)  or  keys = reading(config)
!>     call solver_keys(keys, options)
!>
!> When keys are declared, variables keep their values. If the program computes the default of a key (the default is a sentence),
!> the variable also keeps its value unless the file gives the key. `given` tells whether the file gives a valid value.
module io_keys
  use base_errors, only: require
  use base_kinds, only: i8, rp
  use base_named_kinds, only: kind_of, named_kind_t, words_of
  use io_config, only: config_t
  use io_registry, only: registry_t
  use io_value, only: is_length
  implicit none
  private
  public :: keys_t, declaring, reading

  type :: keys_t
    type(registry_t), pointer, private :: registry => null()
    type(config_t), pointer, private :: config => null()
    character(:), allocatable, private :: name
  contains
    procedure :: section => keys_section
    procedure :: inert_section => keys_inert_section
    generic :: integer => integer_key, long_key
    procedure :: real => keys_real
    procedure :: length => keys_length
    procedure :: reals => keys_reals
    procedure :: list => keys_list
    procedure :: matrix => keys_matrix
    procedure :: switch => keys_switch
    procedure :: word => keys_word
    procedure :: kind => keys_kind
    procedure :: text => keys_text
    procedure :: inert => keys_inert
    procedure :: older_name => keys_older_name
    procedure :: in_checkpoint => keys_in_checkpoint
    procedure, private :: integer_key => keys_integer
    procedure, private :: long_key => keys_long
    procedure, private :: note => keys_note
  end type keys_t

contains

  !> Returns keys that are declared in the registry, which must live as long as they do.
  function declaring(registry) result(keys)
    type(registry_t), intent(inout), target :: registry
    type(keys_t) :: keys
    keys%registry => registry
  end function declaring

  !> Returns keys that give variables the values of the configuration, which must live as long as they do.
  function reading(config) result(keys)
    type(config_t), intent(in), target :: config
    type(keys_t) :: keys
    keys%config => config
  end function reading

  !> Begins the section of the keys that follow. `help` is its line in the reference; without it another procedure declares the
  !> section. With `in_checkpoint`, which needs `help`, the state in a checkpoint depends on all keys of the section: a restart with
  !> other values makes no sense.
  subroutine keys_section(self, name, help, in_checkpoint)
    class(keys_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(*), intent(in), optional :: help
    logical, intent(in), optional :: in_checkpoint
    self%name = name
    call require(present(help) .or. .not. present(in_checkpoint), &
                 'keys_t: who declares ['//name//'] says whether checkpoints depend on it')
    if (.not. associated(self%registry) .or. .not. present(help)) return
    call self%registry%add_section(name, help)
    if (present(in_checkpoint)) self%registry%sections(self%registry%find_section(name))%in_checkpoint = in_checkpoint
  end subroutine keys_section

  !> Declares a section of FLUSI in which keys that are not declared are accepted without effect.
  subroutine keys_inert_section(self, name, help)
    class(keys_t), intent(inout) :: self
    character(*), intent(in) :: name, help
    self%name = name
    if (associated(self%registry)) call self%registry%add_inert_section(name, help)
  end subroutine keys_inert_section

  !> Declares an integer key, or reads it: min <= value <= max.
  subroutine keys_integer(self, key, value, default, help, unit, min, max, required, given)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    integer, intent(inout) :: value
    integer, intent(in) :: default
    character(*), intent(in), optional :: unit
    integer, intent(in), optional :: min, max
    logical, intent(in), optional :: required
    logical, intent(inout), optional :: given
    if (associated(self%registry)) call self%registry%add_integer(self%name, key, default, help, unit, min, max, required)
    if (.not. associated(self%config)) return
    call self%note(key, given)
    value = self%config%get_integer(self%name, key)
  end subroutine keys_integer

  !> Does the same for a variable for larger numbers.
  subroutine keys_long(self, key, value, default, help, min, max)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    integer(i8), intent(inout) :: value
    integer, intent(in) :: default
    integer, intent(in), optional :: min, max
    integer :: short
    call self%integer(key, short, default, help, min=min, max=max)
    if (associated(self%config)) value = short
  end subroutine keys_long

  !> Declares a real key, or reads it into `value`: min <= value <= max or above < value. `scale` is the unit of the key in units
  !> of the variable.
  subroutine keys_real(self, key, value, default, help, unit, min, max, above, required, scale, given)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    real(rp), intent(inout) :: value
    real(rp), intent(in) :: default !< in the unit of the key
    character(*), intent(in), optional :: unit
    real(rp), intent(in), optional :: min, max, above, scale
    logical, intent(in), optional :: required
    logical, intent(inout), optional :: given
    if (associated(self%registry)) &
      call self%registry%add_real(self%name, key, default, help, unit=unit, min=min, max=max, above=above, required=required)
    if (.not. associated(self%config)) return
    call self%note(key, given)
    value = self%config%get_real(self%name, key)
    if (present(scale)) value = scale*value
  end subroutine keys_real

  !> Declares a real key that may also be written N*dx, or reads it into `value`: min <= value or above < value. A `default` that is
  !> not such a number, for instance 'xl/2', describes the value that the program computes.
  subroutine keys_length(self, key, value, default, help, unit, min, above, given)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, default, help
    real(rp), intent(inout) :: value
    character(*), intent(in), optional :: unit
    real(rp), intent(in), optional :: min, above
    logical, intent(inout), optional :: given
    if (associated(self%registry)) call self%registry%add_length(self%name, key, default, help, unit=unit, min=min, above=above)
    if (.not. associated(self%config)) return
    call self%note(key, given)
    if (.not. is_length(default) .and. .not. self%config%is_given(self%name, key)) return
    value = self%config%get_real(self%name, key)
  end subroutine keys_length

  !> Declares a key of as many reals as the variable has, or reads it.
  subroutine keys_reals(self, key, values, default, help, unit, min, given)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    real(rp), intent(inout) :: values(:)
    real(rp), intent(in) :: default(:)
    character(*), intent(in), optional :: unit
    real(rp), intent(in), optional :: min
    logical, intent(inout), optional :: given
    if (associated(self%registry)) &
      call self%registry%add_reals(self%name, key, default, help, unit=unit, length=size(values), min=min)
    if (.not. associated(self%config)) return
    call self%note(key, given)
    values = self%config%get_reals(self%name, key)
  end subroutine keys_reals

  !> Declares a key of any number of reals, or reads it.
  subroutine keys_list(self, key, values, default, help, unit, given)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    real(rp), allocatable, intent(inout) :: values(:)
    real(rp), intent(in) :: default(:)
    character(*), intent(in), optional :: unit
    logical, intent(inout), optional :: given
    if (associated(self%registry)) call self%registry%add_reals(self%name, key, default, help, unit=unit)
    if (.not. associated(self%config)) return
    call self%note(key, given)
    values = self%config%get_reals(self%name, key)
  end subroutine keys_list

  !> Declares a key that is a matrix over several lines, (row, column), or reads it: `columns` numbers in each row, 0 for any
  !> equal number. It has no rows unless the file gives it.
  subroutine keys_matrix(self, key, rows, columns, help, given)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    real(rp), allocatable, intent(inout) :: rows(:, :)
    integer, intent(in) :: columns
    logical, intent(inout), optional :: given
    if (associated(self%registry)) call self%registry%add_matrix(self%name, key, columns, help)
    if (.not. associated(self%config)) return
    call self%note(key, given)
    rows = self%config%get_matrix(self%name, key)
  end subroutine keys_matrix

  !> Declares a key that is yes or no, or reads it. With `unbuilt`, the name of some physics, yes is a mistake, and `instead` says
  !> what to give. With `computed`, a sentence, the program computes the default.
  subroutine keys_switch(self, key, value, default, help, unbuilt, computed, instead, given)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    logical, intent(inout) :: value
    logical, intent(in) :: default
    character(*), intent(in), optional :: unbuilt, computed, instead
    logical, intent(inout), optional :: given
    if (associated(self%registry)) call self%registry%add_switch(self%name, key, default, help, unbuilt, computed, instead)
    if (.not. associated(self%config)) return
    call self%note(key, given)
    if (present(computed) .and. .not. self%config%is_given(self%name, key)) return
    value = self%config%get_switch(self%name, key)
  end subroutine keys_switch

  !> Declares a key that is one of the words of `allowed`, 'a|b|from_file::*', or reads it. Words of `unbuilt` are known but
  !> refused; `instead`, 'a: sentence|b*: sentence', says for some of them what to give.
  subroutine keys_word(self, key, value, default, allowed, help, unbuilt, required, instead, given)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, default, allowed, help
    character(:), allocatable, intent(inout) :: value
    character(*), intent(in), optional :: unbuilt, instead
    logical, intent(in), optional :: required
    logical, intent(inout), optional :: given
    if (associated(self%registry)) &
      call self%registry%add_word(self%name, key, default, allowed, help, unbuilt, required, instead)
    if (.not. associated(self%config)) return
    call self%note(key, given)
    value = self%config%get_word(self%name, key)
  end subroutine keys_word

  !> Declares a key that is one of the words of `table`, or reads the kind that it means. `default` is one of the words, or, for a
  !> required key, another word with the kind 0. `word` is the text that the user gives, which a kind 'from_file::*' needs.
  subroutine keys_kind(self, key, kind, default, table, help, unbuilt, required, instead, given, word)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, default, help
    integer, intent(inout) :: kind
    type(named_kind_t), intent(in) :: table(:)
    character(*), intent(in), optional :: unbuilt, instead
    logical, intent(in), optional :: required
    logical, intent(inout), optional :: given
    character(:), allocatable, intent(inout), optional :: word
    character(:), allocatable :: found
    call self%word(key, found, default, words_of(table), help, unbuilt, required, instead, given)
    if (.not. associated(self%config)) return
    kind = kind_of(table, found)
    if (present(word)) word = found
  end subroutine keys_kind

  !> Declares a key that is free text, or reads it. If it is `computed`, `default` is a sentence, and the variable keeps its value
  !> unless the key is given.
  subroutine keys_text(self, key, value, default, help, required, computed, given)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, default, help
    character(:), allocatable, intent(inout) :: value
    logical, intent(in), optional :: required, computed
    logical, intent(inout), optional :: given
    if (associated(self%registry)) call self%registry%add_text(self%name, key, default, help, required=required, computed=computed)
    if (.not. associated(self%config)) return
    call self%note(key, given)
    if (present(computed)) then
      if (computed .and. .not. self%config%is_given(self%name, key)) return
    end if
    value = self%config%get_text(self%name, key)
  end subroutine keys_text

  !> Declares a key of FLUSI that has no effect here: any value is accepted. `key` may end in '*'.
  subroutine keys_inert(self, key, help)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    if (associated(self%registry)) call self%registry%add_inert(self%name, key, help)
  end subroutine keys_inert

  !> Declares an older name of the key that was stated last.
  subroutine keys_older_name(self, name)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: name
    if (.not. associated(self%registry)) return
    associate (r => self%registry)
      call r%add_alias(self%name, r%keys(r%n_keys)%key%name, name)
    end associate
  end subroutine keys_older_name

  !> Says that the state in a checkpoint depends on the key that was stated last: a restart with another value makes no sense.
  subroutine keys_in_checkpoint(self)
    class(keys_t), intent(in) :: self
    if (.not. associated(self%registry)) return
    associate (r => self%registry)
      call require(r%n_keys > 0, 'keys_t: in_checkpoint follows the statement of a key')
      call require(r%keys(r%n_keys)%key%section == self%name, 'keys_t: in_checkpoint follows the statement of a key of its section')
      r%keys(r%n_keys)%key%in_checkpoint = .true.
    end associate
  end subroutine keys_in_checkpoint

  !> Sets `given` of a key.
  subroutine keys_note(self, key, given)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key
    logical, intent(inout), optional :: given
    if (present(given)) given = self%config%is_given(self%name, key)
  end subroutine keys_note
end module io_keys

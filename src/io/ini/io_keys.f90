! SPDX-License-Identifier: GPL-3.0-or-later
!> Binds ini keys to variables: one statement for each key tells its name, the variable, the default, what it is for, its
!> unit and its range. A procedure that consists of such statements declares the keys or reads them.
!>
!>     subroutine solver_keys(keys, options)
!>       call keys%section('Solver', 'path of the static solution')
!>       call keys%real('tolerance', options%tolerance, 1.0e-8_rp, 'of the residual', min=1.0e-12_rp)
!>     end subroutine solver_keys
!>
!>     keys = declaring(registry)  or  keys = reading(config)
!>     call solver_keys(keys, options)
!>
!> Variables keep their values where keys are declared.
module io_keys
  use base_kinds, only: i8, rp
  use io_config, only: config_t
  use io_registry, only: registry_t
  implicit none
  private
  public :: keys_t, declaring, reading

  type :: keys_t
    type(registry_t), pointer, private :: registry => null()
    type(config_t), pointer, private :: config => null()
    character(:), allocatable, private :: name
  contains
    procedure :: section => keys_section
    generic :: integer => integer_key, long_key
    procedure :: real => keys_real
    procedure :: reals => keys_reals
    procedure :: switch => keys_switch
    procedure :: word => keys_word
    procedure :: text => keys_text
    procedure, private :: integer_key => keys_integer
    procedure, private :: long_key => keys_long
  end type keys_t

contains

  !> Keys go to the registry, which must live as long as this.
  function declaring(registry) result(keys)
    type(registry_t), intent(inout), target :: registry
    type(keys_t) :: keys
    keys%registry => registry
  end function declaring

  !> Variables get the values of the configuration, which must live as long as this.
  function reading(config) result(keys)
    type(config_t), intent(in), target :: config
    type(keys_t) :: keys
    keys%config => config
  end function reading

  !> The section to which the keys that follow belong. `help` is its line in the reference; without it the section is declared
  !> elsewhere too.
  subroutine keys_section(self, name, help)
    class(keys_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(*), intent(in), optional :: help
    self%name = name
    if (associated(self%registry) .and. present(help)) call self%registry%add_section(name, help)
  end subroutine keys_section

  !> An integer, min <= value <= max.
  subroutine keys_integer(self, key, value, default, help, min, max)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    integer, intent(inout) :: value
    integer, intent(in) :: default
    integer, intent(in), optional :: min, max
    if (associated(self%registry)) call self%registry%add_integer(self%name, key, default, help, min=min, max=max)
    if (associated(self%config)) value = self%config%get_integer(self%name, key)
  end subroutine keys_integer

  !> The same in a variable for larger numbers.
  subroutine keys_long(self, key, value, default, help, min, max)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    integer(i8), intent(inout) :: value
    integer, intent(in) :: default
    integer, intent(in), optional :: min, max
    integer :: short
    call self%integer(key, short, default, help, min, max)
    if (associated(self%config)) value = short
  end subroutine keys_long

  !> A real, min <= value <= max or above < value; `scale` is the unit of the key in units of the variable.
  subroutine keys_real(self, key, value, default, help, unit, min, max, above, required, scale)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    real(rp), intent(inout) :: value
    real(rp), intent(in) :: default !< in the unit of the key
    character(*), intent(in), optional :: unit
    real(rp), intent(in), optional :: min, max, above, scale
    logical, intent(in), optional :: required
    if (associated(self%registry)) &
      call self%registry%add_real(self%name, key, default, help, unit=unit, min=min, max=max, above=above, required=required)
    if (.not. associated(self%config)) return
    value = self%config%get_real(self%name, key)
    if (present(scale)) value = scale*value
  end subroutine keys_real

  !> As many reals as the variable has.
  subroutine keys_reals(self, key, values, default, help, unit)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    real(rp), intent(inout) :: values(:)
    real(rp), intent(in) :: default(:)
    character(*), intent(in), optional :: unit
    if (associated(self%registry)) &
      call self%registry%add_reals(self%name, key, default, help, unit=unit, length=size(values))
    if (associated(self%config)) values = self%config%get_reals(self%name, key)
  end subroutine keys_reals

  !> yes or no.
  subroutine keys_switch(self, key, value, default, help)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, help
    logical, intent(inout) :: value
    logical, intent(in) :: default
    if (associated(self%registry)) call self%registry%add_switch(self%name, key, default, help)
    if (associated(self%config)) value = self%config%get_switch(self%name, key)
  end subroutine keys_switch

  !> One of the words of `allowed`, 'a|b'.
  subroutine keys_word(self, key, value, default, allowed, help)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, default, allowed, help
    character(:), allocatable, intent(inout) :: value
    if (associated(self%registry)) call self%registry%add_word(self%name, key, default, allowed, help)
    if (associated(self%config)) value = self%config%get_word(self%name, key)
  end subroutine keys_word

  !> Free text. If it is `computed`, `default` is a sentence, and the variable is left as it is unless the key is given.
  subroutine keys_text(self, key, value, default, help, required, computed)
    class(keys_t), intent(in) :: self
    character(*), intent(in) :: key, default, help
    character(:), allocatable, intent(inout) :: value
    logical, intent(in), optional :: required, computed
    if (associated(self%registry)) call self%registry%add_text(self%name, key, default, help, required=required, computed=computed)
    if (.not. associated(self%config)) return
    if (present(computed)) then
      if (computed .and. .not. self%config%is_given(self%name, key)) return
    end if
    value = self%config%get_text(self%name, key)
  end subroutine keys_text
end module io_keys

! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads [units], the SI values of the units of a run.
module simulation_units
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  use io_units, only: unit_scales_t
  implicit none
  private
  public :: units_t, units_keys, scale_keys, read_units

  integer, parameter :: INPUT_DIMENSIONLESS = 1, INPUT_SI = 2
  type(named_kind_t), parameter :: INPUTS(2) = [named_kind_t('dimensionless', INPUT_DIMENSIONLESS), named_kind_t('SI', INPUT_SI)]

  !> Holds the length [m], the frequency [1/s] and the density [kg/m^3] that make the units of a run.
  type :: units_t
    logical :: has(3) = .false.   !< the user says what length, frequency and density are
    logical :: given = .false.    !< the user says all three
    logical :: si_input = .false. !< numbers of the parameter file are in SI units
    real(rp) :: length = 1, frequency = 1, density = 1
  contains
    procedure :: scales => units_scales
    procedure :: note => units_note
  end type units_t

contains

  !> Declares and reads the keys of [units].
  subroutine units_keys(keys, u)
    type(keys_t), intent(inout) :: keys
    type(units_t), intent(inout) :: u
    integer :: input
    input = INPUT_DIMENSIONLESS
    call keys%section('units', 'SI values of the units; without this section all quantities are dimensionless')
    call keys%kind('input', input, 'dimensionless', INPUTS, 'units of the values in this file: L, T and M as '// &
                   'defined below, or m, s and kg instead; results are in L, T and M, and those in summary.txt in both')
    call scale_keys(keys, u%length, u%frequency, u%has(1), u%has(2))
    call keys%real('density', u%density, 1.0_rp, 'density of the fluid', unit='kg/m^3', above=0.0_rp, given=u%has(3))
    call keys%in_checkpoint()
    u%si_input = input == INPUT_SI
  end subroutine units_keys

  !> Declares and reads the keys of [units], which must be the present section of `keys`, that every program with a wing beat has:
  !> the `length` [m] of one L and the `frequency` [1/s] of one 1/T. The time of wings depends on both.
  subroutine scale_keys(keys, length, frequency, has_length, has_frequency)
    type(keys_t), intent(in) :: keys
    real(rp), intent(inout) :: length, frequency
    logical, intent(inout), optional :: has_length, has_frequency
    call keys%real('length', length, 1.0_rp, 'one L, for instance the wing length', unit='m', above=0.0_rp, given=has_length)
    call keys%in_checkpoint()
    call keys%real('frequency', frequency, 1.0_rp, '1/T, for instance the wing beat frequency', unit='1/s', above=0.0_rp, &
                   given=has_frequency)
    call keys%in_checkpoint()
  end subroutine scale_keys

  !> Reads the SI values of the units. With input = SI, `c` reads all numbers of the file in SI units from here on. Adds
  !> mistakes to `errors` and remarks to `notices`.
  subroutine read_units(c, units, errors, notices)
    type(config_t), intent(inout), target :: c
    type(units_t), intent(inout) :: units
    type(message_list_t), intent(inout) :: errors, notices
    type(keys_t) :: keys
    keys = reading(c)
    call units_keys(keys, units)
    units%given = all(units%has)
    call check_units_together(c, units, errors)
    if (units%si_input) then
      call c%set_units(units%scales())
    else if (.not. units%given) then
      call notices%add('no [units] section: all quantities are dimensionless, fluid density 1')
    end if
  end subroutine read_units

  !> Adds a mistake unless all three values or none are given. With input = SI, all three must be given.
  subroutine check_units_together(c, units, errors)
    type(config_t), intent(in) :: c
    type(units_t), intent(in) :: units
    type(message_list_t), intent(inout) :: errors
    character(9), parameter :: NAMES(3) = ['length   ', 'frequency', 'density  ']
    integer :: i
    if (units%given .or. .not. (units%si_input .or. any(units%has))) return
    do i = 1, 3
      if (units%has(i)) cycle
      if (units%si_input) then
        call c%complain(errors, 'units', trim(NAMES(i)), 'is missing: input = SI needs the value of every unit')
      else
        call c%complain(errors, 'units', trim(NAMES(i)), &
                        'is missing; valid: all of length, frequency and density, or none of them')
      end if
    end do
  end subroutine check_units_together

  !> Returns one line with the SI values of the units for the head of files; it is empty if the user gave none.
  function units_note(self) result(text)
    class(units_t), intent(in) :: self
    character(:), allocatable :: text
    character(200) :: line
    text = ''
    if (.not. self%given) return
    associate (u => self)
      write (line, '(5(a,es12.5),a)') 'units: L =', u%length, ' m, 1/T =', u%frequency, ' 1/s, rho =', u%density, &
        ' kg/m^3, force rho L^4/T^2 =', u%density*u%length**4*u%frequency**2, ' N, power rho L^5/T^3 =', &
        u%density*u%length**5*u%frequency**3, ' W'
    end associate
    text = trim(line)
  end function units_note

  !> Returns the SI values of one L, T and M: m, s and kg.
  pure type(unit_scales_t) function units_scales(self) result(scales)
    class(units_t), intent(in) :: self
    scales = unit_scales_t(self%length, 1/self%frequency, self%density*self%length**3)
  end function units_scales
end module simulation_units

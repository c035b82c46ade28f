! SPDX-License-Identifier: GPL-3.0-or-later
!> Registers all ini keys of `flusi`.
module simulation_keys
  use common_diagnose_keys, only: write_diagnose_reference
  use common_effects_reference, only: write_effects_reference
  use common_foreign_inputs, only: register_foreign_inputs, INPUT_OF_FLOW
  use common_instrument, only: register_idle_instrument
  use common_train_keys, only: write_train_reference
  use fluid_params, only: register_fluid_keys
  use fsi_flight_keys, only: register_flight_keys
  use io_include, only: register_include
  use io_keys, only: declaring, keys_t
  use io_registry, only: registry_t
  use simulation_flexible, only: register_flexible_keys
  use simulation_legacy_keys, only: register_flusi_legacy
  use simulation_output_params, only: output_keys, output_params_t
  use simulation_solid_keys, only: write_solid_reference
  use simulation_static_keys, only: write_static_reference
  use simulation_units, only: units_keys, units_t
  implicit none
  private
  public :: register_all_keys, write_reference

contains

  !> Fills `registry` with every key that `flusi` accepts.
  subroutine register_all_keys(registry)
    type(registry_t), intent(inout), target :: registry
    type(units_t) :: units
    type(output_params_t) :: output
    type(keys_t) :: keys
    keys = declaring(registry)
    call register_include(registry)
    call register_foreign_inputs(registry, INPUT_OF_FLOW)
    call units_keys(keys, units)
    call register_fluid_keys(registry)
    call output_keys(keys, output)
    call register_flight_keys(registry)
    call register_flexible_keys(registry)
    call register_idle_instrument(registry)
    call registry%set_lattice('Resolution', 'ny', 'Geometry', 'yl')
    call register_flusi_legacy(registry)
    call set_conditions(registry)
  end subroutine register_all_keys

  !> Declares on which conditions keys of optional parts have an effect. FLUSI files often contain the keys of insects, elastic
  !> wings and other parts without using them.
  subroutine set_conditions(registry)
    type(registry_t), intent(inout) :: registry
    character(13), parameter :: SECTIONS(2) = ['Insects      ', 'Flexible_wing']
    character(8), parameter :: BODIES(3) = ['iMask   ', 'iCavity ', 'iChannel']
    character(*), parameter :: YES = 'yes|1|true|.true.'
    integer :: i
    do i = 1, size(SECTIONS)
      call registry%only_if(trim(SECTIONS(i)), 'Penalization', 'iPenalization', YES)
      call registry%only_if(trim(SECTIONS(i)), 'Penalization', 'iMask', 'Insect|insect|Flexible_wing')
    end do
    do i = 1, size(BODIES)
      call registry%key_only_if('Penalization', trim(BODIES(i)), 'Penalization', 'iPenalization', YES)
    end do
    ! The section of the beam, which is refused, may stand alone.
    call registry%key_only_if('Penalization', 'iMask', 'SolidModel', 'use_solid_model', 'no|0|false|.false.')
    call registry%key_only_if('InitialCondition', 'inicond', 'SolidModel', 'use_solid_model', 'no|0|false|.false.')
    call registry%key_only_if('Sponge', 'iSpongeType', 'Sponge', 'iVorticitySponge', YES)
  end subroutine set_conditions

  !> Writes the reference of all keys, docs/formats/parameters.md, to `unit`.
  subroutine write_reference(unit)
    integer, intent(in) :: unit
    type(registry_t) :: registry
    call register_all_keys(registry)
    write (unit, '(a)') '# Parameters', '', '<!-- Written by `flusi --parameters`; a test compares. -->', ''
    call registry%write_markdown(unit)
    call write_static_reference(unit)
    call write_solid_reference(unit)
    call write_train_reference(unit)
    call write_diagnose_reference(unit)
    call write_effects_reference(unit)
  end subroutine write_reference
end module simulation_keys

! SPDX-License-Identifier: GPL-3.0-or-later
!> The register of all ini keys of `flusi`, and those that concern output and running.
module flusi_keys
  use base_kinds, only: rp
  use common_diagnose_keys, only: write_diagnose_reference
  use common_effects_reference, only: write_effects_reference
  use common_foreign_inputs, only: register_foreign_inputs, INPUT_OF_FLOW
  use common_instrument, only: register_idle_instrument
  use common_solver_keys, only: register_limits
  use common_train_keys, only: write_train_reference
  use fluid_params, only: register_fluid_keys
  use flusi_averages, only: register_average_keys
  use flusi_flexible, only: register_flexible_keys
  use flusi_legacy_keys, only: register_flusi_legacy
  use flusi_solid_keys, only: write_solid_reference
  use flusi_static_keys, only: write_static_reference
  use fsi_flight_params, only: register_flight_keys
  use io_include, only: register_include
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_all_keys, write_reference

contains

  !> Fills `registry` with every key that `flusi` accepts.
  subroutine register_all_keys(registry)
    type(registry_t), intent(inout) :: registry
    call register_include(registry)
    call register_foreign_inputs(registry, INPUT_OF_FLOW)
    call register_units(registry)
    call register_fluid_keys(registry)
    call register_saving(registry)
    call register_slices(registry)
    call register_average_keys(registry)
    call register_flight_keys(registry)
    call register_flexible_keys(registry)
    call register_idle_instrument(registry)
    call registry%set_lattice('Resolution', 'ny', 'Geometry', 'yl')
    call register_flusi_legacy(registry)
    call set_conditions(registry)
  end subroutine register_all_keys

  !> FLUSI files carry the keys of insects, elastic wings and other parts along, whether they are used or not.
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
    ! The beam, which is refused, may be alone.
    call registry%key_only_if('Penalization', 'iMask', 'SolidModel', 'use_solid_model', 'no|0|false|.false.')
    call registry%key_only_if('InitialCondition', 'inicond', 'SolidModel', 'use_solid_model', 'no|0|false|.false.')
    call registry%key_only_if('Sponge', 'iSpongeType', 'Sponge', 'iVorticitySponge', YES)
  end subroutine set_conditions

  !> Writes the reference of all keys, docs/formats/parameters.md.
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

  subroutine register_units(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('units', 'SI values of the units; without this section all is dimensionless')
    call r%add_word('units', 'input', 'dimensionless', 'dimensionless|SI', &
                    'units of the numbers in this file: L, T and M as named below, or m, s and kg in their place; '// &
                    'results are in L, T and M, and those of summary.txt in both')
    call r%add_real('units', 'length', 1.0_rp, 'one L, for instance the wing length', unit='m', above=0.0_rp)
    call r%add_real('units', 'frequency', 1.0_rp, '1/T, for instance the wing beat frequency', unit='1/s', above=0.0_rp)
    call r%add_real('units', 'density', 1.0_rp, 'density of the fluid', unit='kg/m^3', above=0.0_rp)
  end subroutine register_units

  subroutine register_saving(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Saving', 'fields, time series, backups, and when to stop')
    call r%add_real('Saving', 'tsave', 9.0e9_rp, 'interval of fields', unit='T', above=0.0_rp)
    call r%add_real('Saving', 'tsave_first', 0.0_rp, 'no fields before this time', unit='T')
    call r%add_real('Saving', 'tintegral', 0.01_rp, 'interval of forces and other integrals', unit='T', above=0.0_rp)
    call r%add_integer('Saving', 'itdrag', 99999, 'integrals also every so many steps', min=1)
    call r%add_switch('Saving', 'iSaveVelocity', .false., 'save ux uy uz')
    call r%add_switch('Saving', 'iSavePress', .false., 'save p')
    call r%add_switch('Saving', 'iSaveVorticity', .false., 'save vorx vory vorz')
    call r%add_switch('Saving', 'iSaveMagVorticity', .false., 'save vorabs')
    call r%add_switch('Saving', 'iSaveMask', .false., 'save mask')
    call r%add_switch('Saving', 'iSaveSolidVelocity', .false., 'save usx usy usz')
    call r%add_switch('Saving', 'iSaveWingSides', .false., 'save pressure and traction on both sides of the wings with '// &
                      'their surfaces')
    call r%add_switch('Saving', 'iSaveQ', .false., 'save Q, the Q criterion -1/2 A_ij A_ji of the velocity gradient A')
    call r%add_switch('Saving', 'iSaveSpectrae', .false., 'with the integrals, energy spectra: spectrum_tot.t, _x.t, '// &
                      '_y.t, _z.t have the mean of u^2/2 in each shell of wavenumbers of spectrum_k.t')
    call r%add_word('Saving', 'field_precision', 'single', 'single|double', 'of the saved fields')
    call r%add_integer('Saving', 'striding', 1, 'save every so many-th point in each direction', min=1)
    call r%add_word('Saving', 'naming', 'time', 'time|step', 'number in the file names: 1000 t, or the time step')
    call r%add_switch('Saving', 'save_only_one_period', .false., &
                      'overwrite the fields of the period before: times in file names are taken modulo tsave_period')
    call r%add_real('Saving', 'tsave_period', 1.0_rp, 'that period', unit='T', above=0.0_rp)
    call r%add_switch('Saving', 'iDoBackup', .true., 'write backups')
    call r%add_inert('Saving', 'backup_type', 'there is one kind of backup: one file, double precision')
    call r%add_real('Saving', 'truntime', 1.0_rp, 'wall time between backups', unit='h', above=0.0_rp)
    call register_limits(r)
  end subroutine register_saving

  subroutine register_slices(r)
    type(registry_t), intent(inout) :: r
    integer :: i
    character(6) :: key
    call r%add_inert_section('DryRun', 'drawing the mask without a flow')
    call r%add_switch('DryRun', 'dry_run_without_fluid', .false., &
                      'no flow: save mask, velocity of the solids and surfaces of the wings every tsave until Tmax')
    call r%add_section('SaveSlices', 'y-z planes of the velocity, saved more often than fields')
    call r%add_switch('SaveSlices', 'use_slicing', .false., 'save slices')
    call r%add_alias('SaveSlices', 'use_slicing', 'save_slices')
    do i = 1, 4
      write (key, '(a,i1)') 'slice', i
      call r%add_integer('SaveSlices', key, -2, 'x index of the plane, from 0; negative: no such slice', min=-2)
    end do
    call r%add_integer('SaveSlices', 'itslice', 99999, 'every so many steps', min=1)
    call r%add_real('SaveSlices', 'tslice', 9.0e9_rp, 'interval in time', unit='T', above=0.0_rp)
    call r%add_real('SaveSlices', 'tslice_first', 0.0_rp, 'no slices before this time', unit='T')
    call r%add_integer('SaveSlices', 'ncache_slices', 1, 'so many slices are stacked in one file, whose x is the time, '// &
                       'and slice_times.t has their times; 1: a file for every slice', min=1)
    call r%add_alias('SaveSlices', 'ncache_slices', 'nslice_cache')
  end subroutine register_slices
end module flusi_keys

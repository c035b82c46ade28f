! SPDX-License-Identifier: GPL-3.0-or-later
!> Keys of FLUSI that no package of this program handles, so that existing FLUSI files can be read.
!>
!> Three sorts: keys that FLUSI itself ignores, sections of physics that is not built here, which do no
!> harm as long as nothing switches them on, and the switches of that physics, which are refused.
module app_flusi_keys
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_flusi_legacy

contains

  !> Registers them all. Fluid, time and output keys that do have an effect belong to their packages.
  subroutine register_flusi_legacy(registry)
    type(registry_t), intent(inout) :: registry
    call register_dead_keys(registry)
    call register_unbuilt_flow_physics(registry)
    call register_unbuilt_solids(registry)
  end subroutine register_flusi_legacy

  subroutine register_dead_keys(registry)
    type(registry_t), intent(inout) :: registry
    call registry%add_inert('Time', 'itdrag', 'stands in [Saving]')
    call registry%add_inert('Time', 'tstart', 'belongs to the dry run of the mask')
    call registry%add_inert('Time', 'M_krylov_max', 'belongs to a time stepper that does not exist')
    call registry%add_inert('Time', 'krylov_err_threshold', 'belongs to a time stepper that does not exist')
    call registry%add_inert('Penalization', 'iSmoothing', 'the mask has one way of smoothing')
    call registry%add_inert('Penalization', 'pseud*', 'pseudo-penalization, never used')
    call registry%add_inert('MeanFlow', 'ax', 'mean acceleration, not used by FLUSI either')
    call registry%add_inert('MeanFlow', 'ay', 'mean acceleration, not used by FLUSI either')
    call registry%add_inert('MeanFlow', 'az', 'mean acceleration, not used by FLUSI either')
    call registry%add_inert('Saving', 'iSaveXMF', 'descriptions for viewers are written by a tool')
    call registry%add_inert('Saving', 'iDrag', 'forces have a switch in [Penalization]')
    call registry%add_inert('Saving', 'iKinDiss', 'energy and dissipation are always written')
    call registry%add_inert('Saving', 'itbeam', 'output of the elastic beam')
    call registry%add_inert('Saving', 'itkine', 'kinematics are written with the integrals')
    call registry%add_inert_section('DryRun', 'Drawing the mask without a flow.')
    call registry%add_switch('DryRun', 'dry_run_without_fluid', .false., 'draw the mask without a flow', &
                             unbuilt='a dry run of the mask')
  end subroutine register_dead_keys

  subroutine register_unbuilt_flow_physics(registry)
    type(registry_t), intent(inout) :: registry
    call registry%add_section('FSI-equation', 'Which equations govern the flow.')
    call registry%add_word('FSI-equation', 'equation', 'navier-stokes', 'navier-stokes', &
                           'equations of the flow: incompressible Navier-Stokes', unbuilt='artificial-compressibility')
    call registry%add_inert_section('artificial-compressibility', 'Only for the equation of this name.')
    call registry%add_inert_section('Forcing', 'Forcing of isotropic turbulence.')
    call registry%add_word('Forcing', 'forcing_type', 'none', 'none', 'forcing of isotropic turbulence', &
                           unbuilt='machiels|kaneda')
    call registry%add_inert_section('TurbulentInlet', 'Turbulence read from a file and imposed at an inlet.')
    call registry%add_switch('TurbulentInlet', 'use_turbulent_inlet', .false., 'turbulent inflow', &
                             unbuilt='a turbulent inlet')
    call registry%add_inert_section('Averaging', 'Averages over time, computed while running.')
    call registry%add_switch('Averaging', 'time_avg', .false., 'averages over time', &
                             unbuilt='averaging over time')
    call registry%add_inert_section('PassiveScalar', 'Transported scalars.')
    call registry%add_switch('PassiveScalar', 'use_passive_scalar', .false., 'transport scalars', &
                             unbuilt='transport of passive scalars')
    call registry%add_inert_section('Scalar*', 'One transported scalar.')
  end subroutine register_unbuilt_flow_physics

  !> The masks that draw these solids are refused by [Penalization] iMask. The mask's keys of [Flexible_wing] count.
  subroutine register_unbuilt_solids(registry)
    type(registry_t), intent(inout) :: registry
    call registry%add_inert_section('SolidModel', 'The elastic beam.')
    call registry%add_switch('SolidModel', 'use_solid_model', .false., 'an elastic beam in the flow', &
                             unbuilt='the elastic beam')
    call registry%add_inert_section('Flexible_wing', 'FLUSI''s mass-spring wing.')
    call registry%add_switch('Flexible_wing', 'use_flexible_wing_model', .false., &
                             'a flexible wing in the flow', &
                             unbuilt='FLUSI''s flexible wing')
  end subroutine register_unbuilt_solids
end module app_flusi_keys

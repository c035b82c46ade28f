! SPDX-License-Identifier: GPL-3.0-or-later
!> Registers keys of FLUSI that no package of this program handles, so that the program can read existing FLUSI files.
!>
!> There are three kinds. FLUSI itself ignores the first kind. The second kind belongs to physics that this program does not have;
!> these keys have no effect as long as nothing switches that physics on. The third kind switches it on, and the program refuses it.
module simulation_legacy_keys
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_flusi_legacy

contains

  !> Adds all these keys to `registry`. The keys of fluid, time and output that have an effect belong to other packages.
  subroutine register_flusi_legacy(registry)
    type(registry_t), intent(inout) :: registry
    call register_dead_keys(registry)
    call register_unbuilt_flow_physics(registry)
    call register_unbuilt_solids(registry)
  end subroutine register_flusi_legacy

  !> Registers the keys of FLUSI that have no effect.
  subroutine register_dead_keys(registry)
    type(registry_t), intent(inout) :: registry
    character(10), parameter :: TAKE_OFF(6) = [character(10) :: 'ilegs', 'anglegsend', 'kzlegsmax', 'dzlegsmax', &
                                               't0legs', 'tlinlegs']
    integer :: i
    call registry%add_inert('Time', 'itdrag', 'belongs in [Saving]')
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
    call registry%add_inert('Insects', 'itkine', 'kinematics are written with the integrals')
    call registry%add_inert('Insects', 'smoothing_thickness', 'the mask has one way of smoothing')
    do i = 1, size(TAKE_OFF)
      call registry%add_inert('Insects', trim(TAKE_OFF(i)), 'take-off of a fruit fly')
    end do
    call registry%add_inert('Saving', 'iSaveCurrent', 'magnetohydrodynamics')
    call registry%add_inert('Saving', 'iSaveMagneticField', 'magnetohydrodynamics')
    call registry%add_inert('Saving', 'iSaveAcc', 'accelerations of particles')
    call registry%add_inert('InitialCondition', 'file_b*', 'magnetohydrodynamics')
    call registry%add_inert('Geometry', 'b0', 'magnetohydrodynamics')
    call registry%add_inert('Geometry', 'bc', 'magnetohydrodynamics')
    call registry%add_inert('Geometry', 'ay', 'magnetohydrodynamics')
  end subroutine register_dead_keys

  !> Registers the sections of FLUSI for flows that this program does not compute, and says what to use instead.
  subroutine register_unbuilt_flow_physics(registry)
    type(registry_t), intent(inout) :: registry
    character(*), parameter :: DECAY = 'forcing_type = none and turbulence that decays, inicond = turbulence_rogallo'
    call registry%add_section('FSI-equation', 'Which equations govern the flow.')
    call registry%add_word('FSI-equation', 'equation', 'navier-stokes', 'navier-stokes', &
                           'equations of the flow: incompressible Navier-Stokes', unbuilt='artificial-compressibility|'// &
                           'navier-stokes-adjoint', instead='artificial-compressibility: navier-stokes, whose pressure is '// &
                           'exact in the periodic box|navier-stokes-adjoint: nothing, these are other equations')
    call registry%add_inert_section('artificial-compressibility', 'Only for the equation of this name.')
    call registry%add_inert_section('Forcing', 'Forcing of isotropic turbulence.')
    call registry%add_word('Forcing', 'forcing_type', 'none', 'none', 'forcing of isotropic turbulence', &
                           unbuilt='machiels|kaneda', instead='machiels: '//DECAY//'|kaneda: '//DECAY)
    call registry%add_inert_section('TurbulentInlet', 'Turbulence read from a file and imposed at an inlet.')
    call registry%add_switch('TurbulentInlet', 'use_turbulent_inlet', .false., 'turbulent inflow', &
                             unbuilt='a turbulent inlet', &
                             instead='turbulence that fills the box at the start, inicond = infile')
    call registry%add_inert_section('PassiveScalar', 'Transported scalars.')
    call registry%add_switch('PassiveScalar', 'use_passive_scalar', .false., 'transport scalars', &
                             unbuilt='transport of passive scalars', instead='nothing; another program can transport '// &
                             'scalars with the saved velocities')
    call registry%add_inert_section('Scalar*', 'One transported scalar.')
    call registry%add_inert_section('Adjoint', 'The adjoint equations.')
    call registry%add_word('Adjoint', 'adjoint', 'F', 'F|no|0|false|.false.', 'solve the adjoint equations, too', &
                           unbuilt='T|yes|1|true|.true.', instead='*: nothing, these are other equations')
    call registry%add_inert_section('Lagrangian', 'Particles in the flow.')
    call registry%add_switch('Lagrangian', 'use_lagrangian', .false., 'particles that go with the flow', &
                             unbuilt='particles that go with the flow', &
                             instead='particles of the viewer in the saved velocity, '// &
                             'such as ParaView''s Particle Tracer')
    call registry%add_unbuilt_section('MHD', 'magnetohydrodynamics', 'nothing, these are other equations')
    call registry%add_inert_section('MHDGeometry', 'magnetohydrodynamics')
    call registry%add_unbuilt_section('Incompressibility', 'artificial compressibility', 'the same file without this section, '// &
                                      'with the pressure of the incompressible flow', can_go=.true.)
  end subroutine register_unbuilt_flow_physics

  !> Registers the keys of solids that this program does not have. [Penalization] iMask refuses the masks of these solids.
  subroutine register_unbuilt_solids(registry)
    type(registry_t), intent(inout) :: registry
    call registry%add_inert_section('SolidModel', 'The elastic beam.')
    call registry%add_switch('SolidModel', 'use_solid_model', .false., 'an elastic beam in the flow', &
                             unbuilt='FLUSI''s elastic beam', instead='a filament or plate of masses and springs, iMask = '// &
                             'Insect with [Insects] wings = flexible as in ini/flag.ini; alone, flusi --solid')
    call register_flusi_wing(registry)
  end subroutine register_unbuilt_solids

  !> Registers the keys of FLUSI's mass-spring wing one by one, because this section also has keys that matter and may be
  !> misspelt.
  subroutine register_flusi_wing(registry)
    type(registry_t), intent(inout) :: registry
    character(*), parameter :: S = 'Flexible_wing'
    character(27), parameter :: PLACE(13) = [character(27) :: 'x0', 'y0', 'z0', 'Wing_angle_x', 'Wing_angle_y', &
                                  'Wing_angle_z', 'Motion', 'Left_wing_motion', 'Right_wing_motion', 'Gravity', 'tau', &
                                                'ControlPoint', 'Rotation_angle*']
    character(27), parameter :: MATERIAL(19) = [character(27) :: 'EIy', 'EIz', 'EIy_with_BC', 'EIz_with_BC', &
                                                      'ke_veins', 'ke_veins_with_BC', 'ke_membranes', 'density_veins', &
                                                 'density_veins_with_BC', 'density_membranes', 'damping', 'damping_*', &
                                        'Young_modulus*', 'vein_diameters_given', 'Joint_stiffness_IDs', 'OptJoint_*', &
                                                                   'stiff_coef', 'm_coef', 'ke_membranes_cross_springs']
    character(27), parameter :: METHOD(8) = [character(27) :: 'wing_interp', 'activate_press_force', &
                                                                  'activate_noninertial_force', 'load_mass_from_file', &
                                       'TimeMethodFlexibleSolid', 'Sparse_Solver', 'HB_matrix_given', 'Solid_time_step']
    integer :: i
    call registry%add_section(S, 'the mask of wings, and how the flow bends them')
    do i = 1, size(PLACE)
      call registry%add_inert(S, trim(PLACE(i)), 'place and motion of wings are in [Insects]')
    end do
    do i = 1, size(MATERIAL)
      call registry%add_inert(S, trim(MATERIAL(i)), 'material is in [Wing], [Mass] and [Damping]')
    end do
    do i = 1, size(METHOD)
      call registry%add_inert(S, trim(METHOD(i)), 'there is one method')
    end do
  end subroutine register_flusi_wing
end module simulation_legacy_keys

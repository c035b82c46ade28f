! SPDX-License-Identifier: GPL-3.0-or-later
!> Every word that FLUSI's sources know for a key is taken, or refused by one message that tells what to give instead.
program test_flusi_words
  use base_errors, only: message_list_t
  use base_text, only: next_word
  use io_config, only: config_t
  use io_registry, only: registry_t
  use simulation_keys, only: register_all_keys
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10), INSECT = '[Penalization]'//NL//'iPenalization=1;'//NL//'iMask=Insect;'//NL
  type(testkit_t) :: kit
  type(registry_t) :: registry
  integer :: i
  character(5), parameter :: SIDES(2) = [character(5) :: 'left', 'right']

  call kit%start(parallel=.false.)
  call register_all_keys(registry)
  call words('Time', 'iTimeMethodFluid', 'AB2|RK2|RK4|Euler|AB2_rigid_solid|FSI_AB2_iteration|FSI_AB2_staggered|'// &
             'FSI_AB2_semiimplicit|FSI_RK2_semiimplicit|FSI_RK4_semiimplicit|krylov')
  call words('InitialCondition', 'inicond', 'quiescent|MeanFlow|VortexRing|2VortexRings|taylor_green_2d|infile|infile_inlet|'// &
             'infile_perturbed|turbulence|turbulence-meanflow|turbulence_rogallo|random-given-spectrum|half_HIT|orszag|vortex|'// &
             'three-vortices|couette|blob|pressure-blob|backup::runtime_backup0.h5|orszagtang|constant|smc|smcnum|TaylorCouette')
  call words('Penalization', 'iMask', 'none|empty|no|sphere|Sphere|cylinder|cylinder_x|plate|Plate|couette|Insect|insect|'// &
             'Flexible_wing|Flexibility|Flapper|active_grid|cylinder_asym_z|floor_yz|floor_zy|flooryz|floorzy|fractal_tree|'// &
             'moving_cylinder|moving_cylinder_x|noncircular_cylinder|oscillating_cylinder_2D|romain_open_cavity|'// &
             'rotating_cylinder|turek_wan|from_file::mask.h5|smc|smclinear|smcnum|TaylorCouette')
  call words('Penalization', 'iCavity', 'no|yes|0|1|freestream|freestream_smooth')
  call words('Penalization', 'iChannel', 'no|0|1|xy|xz|xy_sliding|xz_sliding|turek|inlet_x|cylinder')
  call words('Sponge', 'iSpongeType', 'cavity|cavity_open_z|xmin_xmax|xmin_xmax_ymin_ymax|xmin_xmax_zmin_zmax|outlet_x|'// &
             'top_cover|2D_frame|moving_insect|moving_insect_vertical', '[Sponge]'//NL//'iVorticitySponge=yes;'//NL)
  call words('MeanFlow', 'iMeanFlow_x', 'free|fixed|sinusoidal|dynamic|accelerate_to_unity')
  call words('FSI-equation', 'equation', 'navier-stokes|artificial-compressibility|navier-stokes-adjoint')
  call words('Forcing', 'forcing_type', 'none|machiels|kaneda')
  call words('Insects', 'BodyType', 'nobody|suzuki_thin_rod|jerry|Jerry|hawkmoth|Hawkmoth|particle|platicle|coin|sphere|SPHERE|'// &
             'Sphere|drosophila|drosophila_maeda|drosophila_slim|bumblebee|paratuposa_simple|mosquito_iams|pyramid|cone|'// &
             'birch_seed', INSECT)
  call words('Insects', 'WingShape', 'pointcloud|mosquito_iams|rectangular|suzuki|TwoEllipses|drosophila|drosophila_mutated|'// &
             'drosophila_sandberg|drosophila_maeda|drosophila_sun|bumblebee|b_ignitus|paratuposa_flatwing|'// &
             'paratuposa_flatelytra|flapper_sane|flapper_dickinsonII|robofly_dickinson|hawkmoth1|hawkmoth2|'// &
             'pieris-brassicae1|whitney_wood|from_file::wing.ini', INSECT)
  call words('Insects', 'BodyMotion', 'tethered|fixed|fixed45|forward|hovering|x0y0z0|flapper|free_flight|takeoff|wheeling|'// &
             'yawpitchroll|roll|pitch|yaw|roll_param|pitch_param|buffeting|casting|command-line', INSECT)
  do i = 1, 2
    call words('Insects', 'FlappingMotion_'//trim(SIDES(i)), 'none|debug|debug2|from_file|from_file_hermite|kinematics_loader|'// &
             'Drosophila_hovering_fry|Drosophila_hovering_maeda|Drosophila_hovering_sun|flapper_sane|flapper_dickinson|'// &
               'flapper_ramamurti|suzuki|simplified|simplified2|takeoff|revolving-clock|revolving-anticlock|revolving-set1|'// &
               'revolving-set2|revolving-set3|command-line-left|command-line-right', INSECT)
  end do
  call words('Insects', 'LeftWing2', 'no|yes', INSECT)
  call words('Insects', 'RightWing2', 'no|yes', INSECT)
  call words('Insects', 'wing_fsi', 'no|yes', INSECT)
  call words('TurbulentInlet', 'use_turbulent_inlet', 'no|yes')
  call words('PassiveScalar', 'use_passive_scalar', '0|1')
  call words('SolidModel', 'use_solid_model', 'no|yes')
  call words('Adjoint', 'adjoint', 'F|T')
  call words('Lagrangian', 'use_lagrangian', '0|1')
  call one_message('magnetohydrodynamics', '[MHD]'//NL//'eta=0.01;'//NL//'[MHDGeometry]'//NL//'r1=1;'//NL//'[Time]'//NL// &
                   'CFL=-1;'//NL, 'f.ini:1: [MHD]: asks for magnetohydrodynamics, which this program does not have; use instead: ')
  call one_message('artificial compressibility', '[Incompressibility]'//NL//'c_0=20;'//NL, &
                   'f.ini:1: [Incompressibility]: asks for artificial compressibility, which this program does not have; '// &
                   'use instead: ')
  call check_both()
  call one_message('a beam in its mask', '[Penalization]'//NL//'iPenalization=1;'//NL//'iMask=Flexibility;'//NL// &
                   '[SolidModel]'//NL//'use_solid_model=yes;'//NL, 'f.ini:5: [SolidModel] use_solid_model: ')
  call kit%finish()

contains

  !> Loads `key` of `section` with each word, behind `before`.
  subroutine words(section, key, list, before)
    character(*), intent(in) :: section, key, list
    character(*), intent(in), optional :: before
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    character(:), allocatable :: text, place
    integer :: position, first, last, n, m
    logical :: found
    place = ': ['//section//'] '//key//': '
    position = 1
    do
      call next_word(list, '|', position, first, last, found)
      if (.not. found) exit
      text = ''
      if (present(before)) text = before
      if (section == 'Penalization') text = text//'[Penalization]'//NL//'iPenalization=1;'//NL//key//'='//list(first:last)//';'
      if (section /= 'Penalization') text = text//'['//section//']'//NL//key//'='//list(first:last)//';'
      errors = message_list_t()
      call c%load_text(text//NL, 'f.ini', registry, errors, notices)
      n = 0
      do m = 1, errors%count()
        if (index(errors%text(m), place) == 0) cycle
        n = n + 1
        if (index(errors%text(m), 'does not have; use instead: ') == 0) n = 9
      end do
      call kit%check(key//' = '//list(first:last)//' is taken, or refused with what to give instead', n <= 1)
      call kit%check(key//' = '//list(first:last)//': a refusal is known as such', (n == 1) .eqv. c%asks_for_unbuilt())
    end do
  end subroutine words

  !> What a file asks for beside a section that it can do without.
  subroutine check_both()
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    logical :: holds
    call c%load_text('[Incompressibility]'//NL//'c_0=20;'//NL//'[SolidModel]'//NL//'use_solid_model=yes;'//NL// &
                     '[InitialCondition]'//NL//'inicond=quiescent;'//NL//'[Resolution]'//NL//'nx=32;'//NL//'ny=32;'//NL// &
                     'nz=32;'//NL, 'f.ini', registry, errors, notices)
    holds = errors%count() == 2
    if (holds) holds = index(errors%text(2), 'f.ini:4: [SolidModel] use_solid_model: ') == 1
    call kit%check('artificial compressibility and a beam are told together', holds)
  end subroutine check_both

  subroutine one_message(name, text, begin)
    character(*), intent(in) :: name, text, begin
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    logical :: holds
    call c%load_text(text//'[InitialCondition]'//NL//'inicond=quiescent;'//NL//'[Resolution]'//NL//'nx=32;'//NL//'ny=32;'//NL// &
                     'nz=32;'//NL, 'f.ini', registry, errors, notices)
    holds = errors%count() == 1
    if (holds) holds = index(errors%text(1), begin) == 1
    if (.not. holds) call errors%print(0, 'but: ')
    call kit%check(name//' is refused by one message', holds)
  end subroutine one_message
end program test_flusi_words

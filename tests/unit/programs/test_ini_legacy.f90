! SPDX-License-Identifier: GPL-3.0-or-later
!> FLUSI's keys without effect here: harmless as they stand in FLUSI files, refused when they ask for
!> physics that is not built; sections of insects and elastic bodies without effect where no wings are.
program test_ini_legacy
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fsi_flight_keys, only: register_flight_keys
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t
  use io_registry, only: registry_t
  use fluid_average_keys, only: average_keys, average_params_t
  use simulation_flexible, only: register_flexible_keys
  use simulation_keys, only: register_all_keys
  use simulation_legacy_keys, only: register_flusi_legacy
  use simulation_translations, only: translate_words
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10)
  type(testkit_t) :: kit
  type(registry_t), target :: registry
  type(registry_t) :: everything
  type(keys_t) :: keys
  type(average_params_t) :: averages
  !> What FLUSI's users carry along in every file: refused words, unknown keys and keys given twice.
  character(*), parameter :: INSECT_BLOCK = &
                   '[Insects]'//NL//'WingShape=pointcloud;'//NL//'FlappingMotion_right=command-line-right;'//NL// &
        'FlappingMotion_left=flapper;'//NL//'BodyType=particle;'//NL//'BodyMotion=yes;'//NL//'LeftWing2=yes;'//NL// &
                             'LeftWing2=yes;'//NL//'wing_length=-1;'//NL//'WingThicknes=0.1;'//NL// &
                             '[Flexible_wing]'//NL//'T_relase=1;'//NL//'use_flexible_wing_model=yes;'//NL
  character(*), parameter :: BODY_KEYS = 'infile=beat.ini;'//NL//'HasEye=yes;'//NL//'HasHead=yes;'//NL// &
                      'pointcloudfile=none;'//NL//'body_pitch_const=0;'//NL//'KineFromFile=no;'//NL//'mass_solid=1;'// &
                             NL//'eta_stroke=-45;'//NL

  call kit%start(parallel=.false.)
  call register_flight_keys(registry)
  call register_flexible_keys(registry)
  call register_flusi_legacy(registry)
  keys = declaring(registry)
  call average_keys(keys, averages)
  call check_harmless(kit)
  call refuses(kit, 'FSI-equation', 'equation=artificial-compressibility;', 'equation')
  call refuses(kit, 'Forcing', 'forcing_type=machiels; none', 'forcing_type')
  call refuses(kit, 'Forcing', 'forcing_type=kaneda;', 'forcing_type')
  call refuses(kit, 'TurbulentInlet', 'use_turbulent_inlet=yes;', 'use_turbulent_inlet')
  call refuses(kit, 'PassiveScalar', 'use_passive_scalar=1; 0=off, 1=on', 'use_passive_scalar')
  call refuses(kit, 'SolidModel', 'use_solid_model=yes;', 'use_solid_model')
  call refuses(kit, 'Insects', 'WingShape=pointcloud;', 'WingShape')
  call refuses(kit, 'Insects', 'BodyType=particle;', 'BodyType')
  call refuses(kit, 'Insects', 'LeftWing2=yes;', 'LeftWing2')
  call register_all_keys(everything)
  call check_carried_along(kit, 'a sphere', with_mask('1', 'sphere'))
  call check_carried_along(kit, 'no penalization', with_mask('no', 'Insect'))
  call check_carried_along(kit, 'no word on the mask', '')
  call check_insect_block(kit, with_mask('yes', 'Insect'))
  call check_insect_block(kit, with_mask('1', 'insect'))
  call check_wing_keys(kit)
  call check_beam(kit, with_mask('1', 'sphere'))
  call check_beam(kit, with_mask('1', 'Insect'))
  call check_idle(kit)
  call check_translations(kit)
  call kit%finish()

contains

  !> [Penalization], to stand behind the sections that it decides on.
  function with_mask(penalization, mask) result(text)
    character(*), intent(in) :: penalization, mask
    character(:), allocatable :: text
    text = '[Penalization]'//NL//'iPenalization='//penalization//';'//NL//'iMask='//mask//';'//NL
  end function with_mask

  subroutine load(text, c, errors, notices)
    character(*), intent(in) :: text
    type(config_t), intent(out) :: c
    type(message_list_t), intent(out) :: errors, notices
    call c%load_text(text//'[Resolution]'//NL//'nx=8'//NL//'ny=8'//NL//'nz=8'//NL//'[InitialCondition]'//NL// &
                     'inicond=quiescent'//NL, 'f.ini', everything, errors, notices)
  end subroutine load

  subroutine check_carried_along(kit, sentence, mask)
    type(testkit_t), intent(inout) :: kit
    character(*), intent(in) :: sentence, mask
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    call load(INSECT_BLOCK//mask, c, errors, notices)
    call errors%print(0, 'but: ')
    call kit%check(sentence//': insects in the file are no mistake', errors%count() == 0)
    call kit%check(sentence//': there is one notice', notices%count() == 1)
    if (notices%count() == 1) call kit%check(sentence//': it names the sections', notices%text(1) == &
                                   'f.ini: accepted, but without effect here: [Insects], [Flexible_wing]')
  end subroutine check_carried_along

  !> With wings every mistake of the block is reported.
  subroutine check_insect_block(kit, mask)
    type(testkit_t), intent(inout) :: kit
    character(*), intent(in) :: mask
    character(24), parameter :: KEYS(10) = [character(24) :: '2: [Insects] WingShape', '3: [Insects] Flapp', &
                        '4: [Insects] Flapp', '5: [Insects] BodyType', '6: [Insects] BodyMotion', '7: [Insects] Left', &
                                     '8: [Insects] LeftWing2', '9: [Insects] wing_length', '10: [Insects] WingThickn', &
                                                                 '12: [Flexible_wing] T_re']
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    integer :: i, k
    call load(INSECT_BLOCK//mask, c, errors, notices)
    call kit%check('with wings there is one message a mistake', errors%count() == size(KEYS))
    do k = 1, size(KEYS)
      call kit%check('reported: '//trim(KEYS(k)), any([(index(errors%text(i), 'f.ini:'//trim(KEYS(k))) == 1, &
                                                        i=1, errors%count())]))
    end do
    call load('[Insects]'//NL//BODY_KEYS//mask, c, errors, notices)
    call errors%print(0, 'but: ')
    call kit%check('keys of bodies are accepted beside wings', errors%count() == 0 .and. notices%count() == 1)
  end subroutine check_insect_block

  !> An elastic beam that is switched on is refused whatever the mask is, with what to give instead.
  subroutine check_beam(kit, mask)
    type(testkit_t), intent(inout) :: kit
    character(*), intent(in) :: mask
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    call load('[SolidModel]'//NL//'use_solid_model=yes;'//NL//'ns=32;'//NL//mask, c, errors, notices)
    call kit%check('a beam is one mistake', errors%count() == 1)
    if (errors%count() == 1) call kit%check('which tells what to give instead', index(errors%text(1), &
      'f.ini:2: [SolidModel] use_solid_model: ') == 1 .and. index(errors%text(1), 'ini/flag.ini') > 0)
    errors = message_list_t()
    call c%load_text('[SolidModel]'//NL//'use_solid_model=yes;'//NL//'[Resolution]'//NL//'nx=8'//NL//'ny=8'//NL// &
                     'nz=8'//NL, 'f.ini', everything, errors, notices)
    call kit%check('alone as well, without an initial flow', errors%count() == 1)
    call load(with_mask('1', 'Flexibility'), c, errors, notices)
    call kit%check('its mask is one mistake', errors%count() == 1)
    if (errors%count() == 1) call kit%check('with the same advice', index(errors%text(1), 'ini/flag.ini') > 0)
  end subroutine check_beam

  !> Words for parts that are switched off are no mistakes; with these parts they are.
  subroutine check_idle(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    character(*), parameter :: OFF = '[Penalization]'//NL//'iPenalization=0;'//NL//'iMask=Flapper;'//NL// &
                               'iCavity=freestream;'//NL//'iChannel=inlet_x;'//NL//'[Sponge]'//NL// &
                               'iVorticitySponge=no;'//NL//'iSpongeType=moving_insect;'//NL
    call load(OFF, c, errors, notices)
    call errors%print(0, 'but: ')
    call kit%check('words for parts that are switched off are no mistakes', errors%count() == 0)
    call kit%check('the keys are at their defaults', c%get_word('Penalization', 'iMask') == 'none' .and. &
                   c%get_word('Sponge', 'iSpongeType') == 'top_cover')
    call load('[Penalization]'//NL//'iPenalization=1;'//NL//'iMask=Flapper;'//NL//'[Sponge]'//NL// &
              'iVorticitySponge=yes;'//NL//'iSpongeType=moving_insect;'//NL, c, errors, notices)
    call kit%check('with these parts they are', errors%count() == 2)
  end subroutine check_idle

  !> Words of FLUSI that stand for several keys.
  subroutine check_translations(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    call load('[Time]'//NL//'iTimeMethodFluid=FSI_AB2_staggered;'//NL//'[Insects]'//NL//'WingShape=none;'//NL// &
              with_mask('1', 'Flexible_wing'), c, errors, notices)
    call translate_words(c, notices)
    call kit%check('a flexible wing of FLUSI is no mistake', errors%count() == 0)
    call kit%check('it is Insect, flexible, AB2 and weak', c%get_word('Penalization', 'iMask') == 'Insect' .and. &
                   c%get_word('Insects', 'wings') == 'flexible' .and. c%get_word('Time', 'iTimeMethodFluid') == 'AB2' &
                   .and. c%get_word('Flexible_wing', 'coupling') == 'weak')
    call kit%check('a notice for each word', notices%count() == 2)
    if (notices%count() == 2) call kit%check('with its line', index(notices%text(1), &
      'f.ini:2: [Time] iTimeMethodFluid: FSI_AB2_staggered is read as AB2 with [Flexible_wing] coupling = weak') == 1)
    call load('[Time]'//NL//'iTimeMethodFluid=FSI_AB2_iteration;'//NL//with_mask('1', 'Insect'), c, errors, notices)
    call translate_words(c, notices)
    call kit%check('iteration is strong', c%get_word('Flexible_wing', 'coupling') == 'strong')
    call load('[Time]'//NL//'iTimeMethodFluid=FSI_AB2_iteration;'//NL//'[Flexible_wing]'//NL// &
              'coupling=extrapolated;'//NL//with_mask('1', 'Insect'), c, errors, notices)
    call translate_words(c, notices)
    call kit%check('but what the file says about the coupling counts', &
                   c%get_word('Flexible_wing', 'coupling') == 'extrapolated')
    call load('[Geometry]'//NL//'xl=2;'//NL//'yl=3;'//NL//'zl=4;'//NL//'[Insects]'//NL//'BodyMotion=hovering;'//NL// &
              'body_pitch_const=20;'//NL//with_mask('1', 'Insect'), c, errors, notices)
    call translate_words(c, notices)
    call kit%check('it is told', notices%count() == 1)
    call load('[Insects]'//NL//'BodyMotion=fixed;'//NL//with_mask('1', 'sphere'), c, errors, notices)
    notices = message_list_t()
    call translate_words(c, notices)
    call kit%check('beside a sphere nothing is told of bodies', notices%count() == 0)
    call load('[Geometry]'//NL//'xl=2;'//NL//'yl=3;'//NL//'zl=4;'//NL//'[Insects]'//NL//'BodyMotion=hovering;'//NL// &
              'body_pitch_const=20;'//NL//with_mask('1', 'Insect'), c, errors, notices)
    call translate_words(c, notices)
    call kit%check('a still pose of early FLUSI', errors%count() == 0 .and. &
      maxval(abs(c%get_reals('Insects', 'x0') - [1.0_rp, 1.5_rp, 2.7_rp])) <= 1.0e-14_rp .and. &
      maxval(abs(c%get_reals('Insects', 'yawpitchroll_0') - [45.0_rp, -20.0_rp, 0.0_rp])) <= 1.0e-14_rp .and. &
      abs(c%get_real('Insects', 'eta0') + 45) <= 1.0e-14_rp .and. c%get_word('Insects', 'BodyMotion') == 'tethered')
  end subroutine check_translations

  !> FLUSI's keys of its elastic wing are known; others have a nearest known name.
  subroutine check_wing_keys(kit)
    type(testkit_t), intent(inout) :: kit
    character(*), parameter :: KNOWN = '[Flexible_wing]'//NL//'x0=1'//NL//'Wing_angle_y=3'//NL//'EIy_with_BC=1'//NL// &
                               'Young_modulus_LC1=3'//NL//'OptJoint_2=1'//NL//'damping_veins=0'//NL//'tau=1'//NL// &
                               'ke_membranes_cross_springs=1'//NL//'Solid_time_step=1e-3'//NL//'Gravity=no'//NL// &
                               'Joint_stiffness_IDs=1 2'//NL//'Sparse_Solver=yes'//NL
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    call load(KNOWN//with_mask('1', 'Insect'), c, errors, notices)
    call errors%print(0, 'but: ')
    call kit%check('keys of the elastic wing are accepted', errors%count() == 0 .and. notices%count() == 1)
    call load('[Flexible_wing]'//NL//'T_relase=1'//NL//with_mask('1', 'Insect'), c, errors, notices)
    call kit%check('one message on a misspelt key', errors%count() == 1)
    if (errors%count() == 1) &
      call kit%check('with the right name', index(errors%text(1), 'did you mean ''T_release''?') > 0)
  end subroutine check_wing_keys

  subroutine check_harmless(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    character(*), parameter :: TEXT = '[Time]'//NL//'itdrag=10;'//NL//'tstart=0;'//NL//'M_krylov_max=20;'// &
                               NL// &
                             '[Penalization]'//NL//'iSmoothing=cos;'//NL//'pseudoeps=1.0;'//NL//'pseuderrmin=1;'//NL// &
                               '[MeanFlow]'//NL//'ax=0.0;'//NL//'ay=0.0;'//NL//'az=0.0;'//NL// &
                               '[Saving]'//NL//'iSaveXMF=0;'//NL//'iDrag=1;'//NL//'iKinDiss=1;'//NL//'itbeam=2;'//NL// &
                               '[FSI-equation]'//NL//'equation=navier-stokes; artificial-compressibility'//NL// &
                               '[artificial-compressibility]'//NL//'c_0=20.0;'//NL//'acm_sponge=0;'//NL// &
                               '[Forcing]'//NL//'forcing_type=none; machiels'//NL//'kf=0;'//NL// &
                             '[PassiveScalar]'//NL//'use_passive_scalar=0;'//NL//'n_scalars=1;'//NL//'[Scalar1]'//NL// &
                               'kappa=0.1;'//NL// &
                      '[Insects]'//NL//'L_chord=1.0;'//NL//'HasDetails=all; legs; no;'//NL//'x_eye_r=; (vector)'//NL// &
                         'pointcloudfile=cloud.txt'//NL//'[SolidModel]'//NL//'use_solid_model=no;'//NL//'ns=32;'//NL// &
                               '[Flexible_wing]'//NL//'x0= 2.0;'//NL//'EIy= 1e-5; 1e-5;'//NL// &
                               '[TurbulentInlet]'//NL//'use_turbulent_inlet=no;'//NL//'rescale=1.d0;'//NL// &
                               '[Averaging]'//NL//'time_avg=no;'//NL//'vel_avg=yes;'
    call c%load_text(TEXT, 'f.ini', registry, errors, notices, flusi_compat=.true.)
    call errors%print(0, 'but: ')
    call kit%check('what stands in FLUSI files is accepted', errors%count() == 0)
    call kit%check('with one notice', notices%count() == 1)
    if (notices%count() > 0) call kit%check('which names the keys', &
                    index(notices%text(1), '[MeanFlow] ay (line 11)') > 0 .and. index(notices%text(1), '[Insects]') > 0)
  end subroutine check_harmless

  subroutine refuses(kit, section, line, key)
    type(testkit_t), intent(inout) :: kit
    character(*), intent(in) :: section, line, key
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    logical :: holds
    call c%load_text('['//section//']'//NL//line, 'f.ini', registry, errors, notices)
    holds = errors%count() == 1
    if (holds) holds = index(errors%text(1), 'f.ini:2: ['//section//'] '//key//': ') == 1 .and. &
                       index(errors%text(1), 'this program does not have') > 0
    call kit%check('refused: ['//section//'] '//line, holds)
  end subroutine refuses
end program test_ini_legacy

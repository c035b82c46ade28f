! SPDX-License-Identifier: GPL-3.0-or-later
!> FLUSI's keys without effect here: harmless as they stand in FLUSI files, refused when they ask for
!> physics that is not built.
program test_ini_legacy
  use app_flexible, only: register_flexible_keys
  use app_flusi_keys, only: register_flusi_legacy
  use base_errors, only: message_list_t
  use fsi_flight_params, only: register_flight_keys
  use io_config, only: config_t
  use io_registry, only: registry_t
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10)
  type(testkit_t) :: kit
  type(registry_t) :: registry

  call kit%start(parallel=.false.)
  call register_flight_keys(registry)
  call register_flexible_keys(registry)
  call register_flusi_legacy(registry)
  call check_harmless(kit)
  call refuses(kit, 'FSI-equation', 'equation=artificial-compressibility;', 'equation')
  call refuses(kit, 'Forcing', 'forcing_type=machiels; none', 'forcing_type')
  call refuses(kit, 'Forcing', 'forcing_type=kaneda;', 'forcing_type')
  call refuses(kit, 'TurbulentInlet', 'use_turbulent_inlet=yes;', 'use_turbulent_inlet')
  call refuses(kit, 'Averaging', 'time_avg=yes;', 'time_avg')
  call refuses(kit, 'PassiveScalar', 'use_passive_scalar=1; 0=off, 1=on', 'use_passive_scalar')
  call refuses(kit, 'SolidModel', 'use_solid_model=yes;', 'use_solid_model')
  call refuses(kit, 'Insects', 'WingShape=drosophila;', 'WingShape')
  call refuses(kit, 'Insects', 'BodyType=jerry;', 'BodyType')
  call refuses(kit, 'Insects', 'LeftWing2=yes;', 'LeftWing2')
  call refuses(kit, 'DryRun', 'dry_run_without_fluid=yes;', 'dry_run_without_fluid')
  call kit%finish()

contains

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
                               '[DryRun]'//NL//'dry_run_without_fluid=no;'//NL// &
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
                       index(errors%text(1), 'not built here') > 0
    call kit%check('refused: ['//section//'] '//line, holds)
  end subroutine refuses
end program test_ini_legacy

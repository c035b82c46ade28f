! SPDX-License-Identifier: GPL-3.0-or-later
!> Kinematics files, tables and [Insects]: what they mean, and every mistake with its line and key. The
!> argument is the shipped file of the blowfly, which must do what the paper states.
program test_kinematics_files
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fsi_kinematics, only: body_t, pose_wing, wing_mount_t, wing_pose_t
  use fsi_kinematics_keys, only: motion_file, read_body, read_motion, read_mounts, register_kinematics_keys
  use fsi_rotation, only: angle_t
  use fsi_wing_motion, only: wing_motion_t
  use fsi_wing_motion_file, only: read_motion_file
  use fsi_wing_motion_table, only: read_motion_table
  use io_broadcast_text, only: read_text_file
  use io_config, only: config_t
  use io_registry, only: registry_t
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10), REST = '0 0 0 0 0 0 0 0 0'
  character(*), parameter :: FOURIER = '[kinematics]'//NL//'format=2015-10-09; unused'//NL//'type=fourier;'//NL
  character(*), parameter :: SERIES = 'nfft_phi=2;'//NL//'a0_phi=10;'//NL//'ai_phi=60 1;'//NL//'bi_phi=0 -2;'//NL// &
                             'nfft_alpha=0;'//NL//'a0_alpha=90;'//NL// &
                             'nfft_theta=1;'//NL//'a0_theta=4;'//NL//'ai_theta=5;'//NL//'bi_theta=0;'//NL
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call check_meaning(kit)
  call check_old_files(kit)
  call check_file_mistakes(kit)
  call check_table_meaning(kit)
  call check_table_mistakes(kit)
  call check_insects(kit)
  call check_calliphora(kit)
  call kit%finish()

contains

  subroutine read_series(text, motion, errors, notices)
    character(*), intent(in) :: text
    type(wing_motion_t), intent(inout) :: motion
    type(message_list_t), intent(out) :: errors, notices
    call read_motion_file(text, 'k.ini', motion, errors, notices)
  end subroutine read_series

  !> phi, alpha, theta at time t, in degrees.
  function degrees(motion, t) result(angles)
    type(wing_motion_t), intent(in) :: motion
    real(rp), intent(in) :: t
    real(rp) :: angles(3)
    type(angle_t) :: phi, alpha, theta
    call motion%evaluate(t, phi, alpha, theta)
    angles = [phi%value, alpha%value, theta%value]*180/PI
  end function degrees

  subroutine check_meaning(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_motion_t) :: motion
    type(message_list_t) :: errors, notices
    type(angle_t) :: phi, alpha, theta
    call read_series(FOURIER//SERIES, motion, errors, notices)
    call kit%check('FLUSI''s format, with the defaults degree and flusi', errors%count() == 0)
    call kit%check_below('Fourier: half of a0 and the cosines at t = 0', &
                         maxval(abs(degrees(motion, 0.0_rp) - [66.0_rp, 45.0_rp, 7.0_rp])), 1.0e-12_rp)
    call kit%check_below('Fourier: sines', &
            maxval(abs(degrees(motion, 1.125_rp) - [5 + 60*sqrt(0.5_rp) - 2, 45.0_rp, 2 + 5*sqrt(0.5_rp)])), 1.0e-12_rp)
    call read_series(FOURIER//'convention=SISC;'//NL//SERIES, motion, errors, notices)
    call kit%check_below('SISC: theta has the other sign', &
                         maxval(abs(degrees(motion, 0.0_rp) - [66.0_rp, 45.0_rp, -7.0_rp])), 1.0e-12_rp)
    call read_series(FOURIER//'units=radian;'//NL//SERIES, motion, errors, notices)
    call kit%check_below('radian', maxval(abs(degrees(motion, 0.0_rp)*PI/180 - [66.0_rp, 45.0_rp, 7.0_rp])), 1.0e-12_rp)
    call read_series('[kinematics]'//NL//'type=hermite; units=degree'//NL//'nfft_phi=2; ai_phi'//NL// &
                 'ai_phi=1 2;'//NL//'bi_phi=10 -20;'//NL//'nfft_alpha=1; '//NL//'ai_alpha=3;'//NL//'bi_alpha=0;'//NL// &
                     'nfft_theta=1;'//NL//'ai_theta=4;'//NL//'bi_theta=7;'//NL, motion, errors, notices)
    call kit%check('a Hermite file', errors%count() == 0 .and. notices%count() == 0)
    call motion%evaluate(1.5_rp, phi, alpha, theta)
    call kit%check_below('Hermite: value, and slope per cycle, at t = 3/2', maxval(abs([phi%value, phi%rate, &
               alpha%value, theta%value, theta%rate]*180/PI - [2.0_rp, -20.0_rp, 3.0_rp, 4.0_rp, -3.5_rp])), 1.0e-12_rp)
    call read_series('[kinematics]'//NL//'type=hermite;'//NL//'a0_phi=3;'//NL//hermite_ones(), motion, errors, notices)
    call kit%check('Hermite: a0 is noticed', errors%count() == 0 .and. notices%count() == 1)
    if (notices%count() == 1) call kit%check('with its line and key', notices%text(1) == &
                                           'k.ini:3: [kinematics] a0_phi: has no effect with type=hermite, as in FLUSI')
  end subroutine check_meaning

  !> Files of before 2015: numbers in a fixed order.
  subroutine check_old_files(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_motion_t) :: motion, named
    type(message_list_t) :: errors, notices
    type(angle_t) :: phi, alpha, theta
    character(*), parameter :: COUNTS = '% a comment'//NL//'2 % nfft_phi'//NL//'0'//NL//'1 # nfft_theta'//NL
    integer :: i
    call read_series(COUNTS//'1d1'//NL//'60 1'//NL//'%---'//NL//'0 -2'//NL//'90'//NL//'4'//NL//'5'//NL//'0', motion, &
                     errors, notices)
    call kit%check('a Fourier file of before 2015', errors%count() == 0)
    call read_series(FOURIER//SERIES, named, errors, notices)
    do i = 0, 3
      call kit%check_below('is the same motion as with names', &
                           maxval(abs(degrees(motion, 0.23_rp*i) - degrees(named, 0.23_rp*i))), 1.0e-12_rp)
    end do
    call read_series('2 1 1'//NL//'1 2'//NL//'10 -20'//NL//'3 0'//NL//'4 7'//NL, motion, errors, notices)
    call kit%check('a Hermite file of before 2015', errors%count() == 0)
    call motion%evaluate(1.5_rp, phi, alpha, theta)
    call kit%check_below('its values and slopes at t = 3/2', maxval(abs([phi%value, phi%rate, alpha%value, theta%value, &
                                           theta%rate]*180/PI - [2.0_rp, -20.0_rp, 3.0_rp, 4.0_rp, -3.5_rp])), 1.0e-12_rp)
  end subroutine check_old_files

  function hermite_ones() result(text)
    character(:), allocatable :: text
    text = 'nfft_phi=1;'//NL//'ai_phi=1;'//NL//'bi_phi=0;'//NL//'nfft_alpha=1;'//NL//'ai_alpha=1;'//NL// &
           'bi_alpha=0;'//NL//'nfft_theta=1;'//NL//'ai_theta=1;'//NL//'bi_theta=0;'//NL
  end function hermite_ones

  !> The file gives exactly the one mistake that begins with `want`.
  subroutine expect(kit, text, want)
    type(testkit_t), intent(inout) :: kit
    character(*), intent(in) :: text, want
    type(wing_motion_t) :: motion
    type(message_list_t) :: errors, notices
    call read_series(text, motion, errors, notices)
    call report(kit, errors, want)
  end subroutine expect

  subroutine report(kit, errors, want)
    type(testkit_t), intent(inout) :: kit
    type(message_list_t), intent(in) :: errors
    character(*), intent(in) :: want
    logical :: holds
    integer :: i
    holds = errors%count() == 1
    if (holds) holds = index(errors%text(1), want) == 1
    call kit%check(want, holds)
    if (holds) return
    do i = 1, errors%count()
      call kit%check('    but: '//errors%text(i), .false.)
    end do
  end subroutine report

  subroutine check_file_mistakes(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_motion_t) :: motion
    type(message_list_t) :: errors, notices
    character(*), parameter :: ALPHA_THETA = 'nfft_alpha=0;'//NL//'nfft_theta=0;'//NL
    call expect(kit, '10'//NL//'0.3 0.1 0.2'//NL, 'k.ini: has no section [kinematics], and as a file of before 2015 does not begin')
    call expect(kit, '1 x 0', 'k.ini: has no section [kinematics], and as a file of before 2015 column 2: ''x''')
    call expect(kit, '1 0 0'//NL//'3 4 5', 'k.ini: has no section [kinematics], and as a file of before 2015 it has 6 numbers; '// &
                'valid: 8 for Fourier, 5 for Hermite series of 1, 0 and 0 coefficients')
    call expect(kit, '[kinematics]'//NL//SERIES, 'k.ini: [kinematics] type: is missing; valid: fourier')
    call expect(kit, '[kinematics]'//NL//'type=spline;'//NL//SERIES, &
                'k.ini:2: [kinematics] type: ''spline'' is unknown')
    call expect(kit, FOURIER//'convention=english;'//NL//SERIES, &
                'k.ini:4: [kinematics] convention: ''english'' is unknown')
    call expect(kit, FOURIER//'units=grad;'//NL//SERIES, 'k.ini:4: [kinematics] units: ''grad'' is unknown')
    call expect(kit, FOURIER//SERIES//'ai_psi=3;'//NL, 'k.ini:14: [kinematics] ai_psi: unknown key')
    call expect(kit, FOURIER//ALPHA_THETA//'nfft_phi=3;'//NL//'ai_phi=1 2;'//NL//'bi_phi=1 2 3;'//NL, &
                'k.ini:7: [kinematics] ai_phi: has 2 numbers, but nfft_phi asks for 3 numbers')
    call expect(kit, FOURIER//ALPHA_THETA//'nfft_phi=1;'//NL//'ai_phi=1;'//NL, &
                'k.ini: [kinematics] bi_phi: is missing; nfft_phi asks for 1 number')
    call expect(kit, FOURIER//ALPHA_THETA//'nfft_phi=0;'//NL//'ai_phi=1;'//NL, &
                'k.ini:7: [kinematics] ai_phi: has 1 number, but nfft_phi is 0')
    call read_series(FOURIER//ALPHA_THETA//'nfft_phi=0;'//NL//'ai_phi=0.0;'//NL//'bi_phi=0.0;'//NL, motion, errors, &
                     notices)
    call kit%check('zeros beside nfft = 0 are no mistake', errors%count() == 0)
    call expect(kit, FOURIER//ALPHA_THETA//'ai_phi=1;'//NL, 'k.ini: [kinematics] nfft_phi: is missing')
    call expect(kit, FOURIER//ALPHA_THETA//'nfft_phi=-1;'//NL//'ai_phi=1;'//NL, 'k.ini:6: [kinematics] nfft_phi: ')
    call expect(kit, FOURIER//ALPHA_THETA//'nfft_phi=2;'//NL//'ai_phi=1 x;'//NL//'bi_phi=1 2;'//NL, &
                'k.ini:7: [kinematics] ai_phi: ''x'' is not a number')
    call expect(kit, '[kinematics]'//NL//'type=hermite;'//NL//'nfft_alpha=1;'//NL//hermite_ones(), &
                'k.ini:7: [kinematics] nfft_alpha: is given twice, first in line 3')
    call read_series('[kinematics]'//NL//'type=hermite;'//NL//'nfft_phi=0;'//NL//ALPHA_THETA, motion, errors, notices)
    call kit%check('Hermite without values: a mistake for each angle', errors%count() == 3)
    call motion%set_constant(1.0_rp, 2.0_rp, 3.0_rp)
    call read_series(FOURIER//ALPHA_THETA//'nfft_phi=2;'//NL, motion, errors, notices)
    call kit%check('two missing keys are two mistakes', errors%count() == 2)
    call kit%check_below('an angle with mistakes keeps what it had', &
                         maxval(abs(degrees(motion, 0.3_rp)*PI/180 - [1.0_rp, 0.0_rp, 0.0_rp])), 1.0e-15_rp)
  end subroutine check_file_mistakes

  subroutine check_table_meaning(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_motion_t) :: motion
    type(message_list_t) :: errors
    type(angle_t) :: phi, alpha, theta
    call read_motion_table('4.0  ; period in ms'//NL//' 2.83 '//NL//'3 '//NL//NL// &
                   '0.0e+00  10 20 30 0 0 0  1 2 3 0 0 0'//achar(13)//NL//'0.5d0 11 21 31 0 0 0  -1 -2 -3 0 0 0'//NL// &
                           '1.0 12'//achar(9)//'22 32 0 0 0 0 0 0 0 0 0', 't.dat', motion, errors)
    call kit%check('a table', errors%count() == 0)
    motion%frequency = 0.25_rp ! so that t is in the unit of the table
    call motion%evaluate(0.5_rp, phi, alpha, theta)
    call kit%check_below('table: phi, alpha, -theta in degrees', maxval(abs([phi%value, alpha%value, theta%value] &
                                                                   *180/PI - [11.0_rp, 21.0_rp, -31.0_rp])), 1.0e-12_rp)
    call kit%check_below('table: rates are per unit of its time', maxval(abs([phi%rate, alpha%rate, theta%rate] &
                                                                     *180/PI - [-1.0_rp, -2.0_rp, 3.0_rp])), 1.0e-12_rp)
  end subroutine check_table_meaning

  subroutine expect_table(kit, text, want)
    type(testkit_t), intent(inout) :: kit
    character(*), intent(in) :: text, want
    type(wing_motion_t) :: motion
    type(message_list_t) :: errors
    call read_motion_table(text, 't.dat', motion, errors)
    call report(kit, errors, want)
    call kit%check_below('    and the motion stays as it was', maxval(abs(degrees(motion, 0.1_rp))), 0.0_rp)
  end subroutine expect_table

  subroutine check_table_mistakes(kit)
    type(testkit_t), intent(inout) :: kit
    character(*), parameter :: HEADER = '1'//NL//'1'//NL//'2'//NL, ROW_0 = '0 1 2 3 '//REST//NL, &
                               ROW_1 = '1 1 2 3 '//REST//NL
    character(:), allocatable :: many
    type(wing_motion_t) :: motion
    type(message_list_t) :: errors
    integer :: i
    call expect_table(kit, 'T'//NL//'1'//NL//'2'//NL//ROW_0//ROW_1, 't.dat:1: period: ''T'' is not a number')
    call expect_table(kit, '1'//NL//'-9'//NL//'2'//NL//ROW_0//ROW_1, 't.dat:2: wing length: -9.0 is not positive')
    call expect_table(kit, '1'//NL//'1'//NL//'1'//NL//ROW_0, 't.dat:3: number of rows: 1 is too small')
    call expect_table(kit, '1'//NL//'1'//NL//'999999999'//NL//ROW_0, &
                      't.dat:3: number of rows: 999999999 rows do not fit into this file')
    call expect_table(kit, '1'//NL//'1'//NL//'2.5'//NL//ROW_0, 't.dat:3: number of rows: ''2.5''')
    call expect_table(kit, '1'//NL//'1', 't.dat: ends before the three header lines')
    call expect_table(kit, '', 't.dat: ends before the three header lines')
    call expect_table(kit, HEADER//ROW_0, 't.dat: 1 rows, but the third line announces 2')
    call expect_table(kit, HEADER//ROW_0//ROW_1//ROW_1, 't.dat:6: more rows than the 2 announced')
    call expect_table(kit, HEADER//ROW_0//'1 2 3'//NL, 't.dat:5: 3 numbers in a row, not 13')
    call expect_table(kit, HEADER//ROW_0//'1 2 x 3 '//REST, 't.dat:5: column 3: ''x'' is not a number')
    call expect_table(kit, HEADER//ROW_0//ROW_0, 't.dat:5: time 0.0 does not follow 0.0')
    call expect_table(kit, HEADER//'0.5 1 2 3 '//REST//NL//ROW_1, 't.dat:4: the first time is 0.5; valid: 0')
    many = '1'//NL//'1'//NL//'30'//NL
    do i = 1, 30
      many = many//'x y z 1 1 1 1 1 1 1 1 1 1'//NL
    end do
    call read_motion_table(many, 't.dat', motion, errors)
    call kit%check('a file of something else does not drown the user', errors%count() == 10)
  end subroutine check_table_mistakes

  subroutine check_insects(kit)
    type(testkit_t), intent(inout) :: kit
    type(registry_t) :: registry
    type(config_t) :: config
    type(message_list_t) :: errors, notices
    type(wing_mount_t) :: mounts(2)
    type(wing_motion_t) :: motions(2)
    type(body_t) :: body
    type(wing_pose_t) :: pose
    call register_kinematics_keys(registry)
    call config%load_text('[Insects]'//NL//'BodyMotion=tethered;'//NL//'x0=18 18 9;'//NL// &
                 'yawpitchroll_0=180 0 0;'//NL//'eta0=-70;'//NL//'x_pivot_l=0 4.5 0;'//NL//'x_pivot_r=0 -4.5 0;'//NL// &
                 'FlappingMotion_left=from_file::a/k.ini;'//NL//'FlappingMotion_right=kinematics_loader::t.dat;'//NL// &
                          'wing_frequency=158;'//NL, 'run.ini', registry, errors, notices)
    call read_body(config, body)
    call read_mounts(config, [0.0_rp, 0.0_rp, 0.0_rp], mounts, motions, errors)
    call kit%check('[Insects] without mistakes', errors%count() == 0)
    call kit%check('the files of both wings', motion_file(config, 1) == 'a/k.ini' .and. &
                   motion_file(config, 2) == 't.dat')
    call read_motion(config, 1, FOURIER//SERIES, 'a/k.ini', motions(1), errors, notices)
    call read_motion(config, 2, '1'//NL//'1'//NL//'2'//NL//'0 1 2 3 '//REST//NL//'1 1 2 3 '//REST//NL, 't.dat', &
                     motions(2), errors, notices)
    call kit%check('are read by their kind', errors%count() == 0 .and. motions(1)%phi%is_periodic() &
                   .and. .not. motions(2)%phi%is_periodic())
    call pose_wing(body, mounts(1), motions(1), 0.0_rp, pose)
    call kit%check_below('the left hinge of an insect that faces -x is at smaller y', &
                         maxval(abs(pose%hinge - [18.0_rp, 13.5_rp, 9.0_rp])), 1.0e-14_rp)
    call kit%check_close('rates use wing_frequency', motions(1)%frequency, 158.0_rp, atol=0.0_rp)
    call config%load_text('[Insects]'//NL//'FlappingMotion_left=from_file;'//NL//'FlappingMotion_right='// &
                          'kinematics_loader;'//NL//'infile=k.ini; (string)'//NL, 'run.ini', registry, errors, notices)
    call kit%check('FLUSI''s other spelling: one file for both', errors%count() == 0 .and. &
                   motion_file(config, 1) == 'k.ini' .and. motion_file(config, 2) == 'k.ini')
    call read_motion(config, 1, FOURIER//SERIES, 'k.ini', motions(1), errors, notices)
    call read_motion(config, 2, '1'//NL//'1'//NL//'2'//NL//'0 1 2 3 '//REST//NL//'1 1 2 3 '//REST//NL, 'k.ini', &
                     motions(2), errors, notices)
    call kit%check('which is read by the kind', errors%count() == 0 .and. motions(1)%phi%is_periodic() &
                   .and. .not. motions(2)%phi%is_periodic())
    call config%load_text('[Insects]'//NL//'FlappingMotion_left=simplified;'//NL, 'run.ini', registry, errors, notices)
    call read_motion(config, 1, '', '', motions(1), errors, notices)
    call kit%check('a motion by its name needs no file', motion_file(config, 1) == '')
    call kit%check_below('simplified: 80 and 0 degrees', &
                         maxval(abs(degrees(motions(1), 0.0_rp) - [80.0_rp, 0.0_rp, 0.0_rp])), 1.0e-12_rp)
    call config%load_text('[Insects]'//NL//'x_pivot_l=1 2 3;'//NL//'x_pivot_r=1 2 3;'//NL, 'run.ini', registry, &
                          errors, notices)
    call read_mounts(config, [0.0_rp, 0.0_rp, 0.0_rp], mounts, motions, errors)
    call report(kit, errors, 'run.ini:3: [Insects] x_pivot_r: is the same point as x_pivot_l')
    call read_motion(config, 1, '', '', motions(1), errors, notices)
    call kit%check_below('none: at rest with alpha = 45 degrees', &
                         maxval(abs(degrees(motions(1), 0.3_rp) - [0.0_rp, 45.0_rp, 0.0_rp])), 1.0e-13_rp)
  end subroutine check_insects

  !> Stroke amplitude, downstroke first, mean tip velocity, fast rotations, as the paper states.
  subroutine check_calliphora(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_motion_t) :: motion
    type(message_list_t) :: errors, notices
    type(body_t) :: body
    type(wing_pose_t) :: pose
    character(400) :: path
    character(:), allocatable :: text, problem
    real(rp) :: smallest, largest, angles(3), path_length, tip(3), before(3), turned
    integer :: i
    integer, parameter :: N = 2000
    call get_command_argument(1, path)
    call read_text_file(trim(path), text, problem)
    call kit%check('the blowfly''s file is there',.not. allocated(problem))
    if (allocated(problem)) return
    call read_motion_file(text, 'calliphora.ini', motion, errors, notices)
    call kit%check('the blowfly''s file has no mistakes', errors%count() == 0)
    call motion%stroke_extremes(smallest, largest)
    call kit%check_close('blowfly: stroke amplitude in degrees', (largest - smallest)*180/PI, 135.0_rp, atol=1.0e-10_rp)
    angles = degrees(motion, 0.0_rp)
    call kit%check_close('blowfly: the downstroke begins at t = 0', angles(1), largest*180/PI, atol=1.0e-10_rp)
    angles = degrees(motion, 0.5_rp)
    call kit%check_close('blowfly: it ends at t = 0.5', angles(1), smallest*180/PI, atol=1.0e-10_rp)
    ! Largest left-out term of the series and tail of the error function: 0.002 degrees.
    angles = degrees(motion, 0.25_rp)
    call kit%check_close('blowfly: alpha in the downstroke', angles(2), 45.0_rp, atol=0.01_rp)
    angles = degrees(motion, 0.75_rp)
    call kit%check_close('blowfly: alpha in the upstroke', angles(2), -70.0_rp, atol=0.01_rp)
    angles = degrees(motion, 0.5_rp + 0.064_rp) - degrees(motion, 0.5_rp - 0.064_rp)
    turned = -angles(2)/115
    call kit%check_close('blowfly: 80 % of the supination in 0.128 cycles', turned, 0.80_rp, atol=0.005_rp)
    ! Tip of a wing of 9 mm at 158 Hz; the polygon of 2000 chords is short by 1e-6.
    path_length = 0
    call pose_wing(body, wing_mount_t(), motion, 0.0_rp, pose)
    before = pose%point_to_space([9.0e-3_rp, 0.0_rp, 0.0_rp])
    do i = 1, N
      call pose_wing(body, wing_mount_t(), motion, real(i, rp)/N, pose)
      tip = pose%point_to_space([9.0e-3_rp, 0.0_rp, 0.0_rp])
      path_length = path_length + norm2(tip - before)
      before = tip
    end do
    call kit%check_close('blowfly: mean tip velocity of Table 1, 6.701 m/s', path_length*158, 6.701_rp, atol=5.0e-4_rp)
  end subroutine check_calliphora
end program test_kinematics_files

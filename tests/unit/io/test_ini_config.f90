! SPDX-License-Identifier: GPL-3.0-or-later
!> Values from an ini file: every kind of value, every kind of mistake with its exact place.
program test_ini_config
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use io_config, only: config_t
  use io_registry, only: registry_t
  use test_ini_sample, only: register_sample, sample_text
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10)
  character(*), parameter :: MINIMAL = '[Resolution]'//NL//'ny=4;'//NL//'[Time]'//NL//'Tmax=1;'//NL ! 4 lines
  type(testkit_t) :: kit
  type(registry_t) :: registry

  call kit%start(parallel=.false.)
  call register_sample(registry)
  call check_sample(kit)
  call check_defaults(kit)
  call check_lengths(kit)
  call check_wrong_values(kit)
  call check_unknown_names(kit)
  call check_duplicates(kit)
  call check_notices(kit)
  call check_collecting(kit)
  call check_files(kit)
  call kit%finish()

contains

  !> MINIMAL//text gives exactly the one mistake `want`.
  subroutine expect(kit, text, want)
    type(testkit_t), intent(inout) :: kit
    character(*), intent(in) :: text, want
    call expect_whole(kit, MINIMAL//text, want)
  end subroutine expect

  subroutine expect_whole(kit, text, want)
    type(testkit_t), intent(inout) :: kit
    character(*), intent(in) :: text, want
    type(config_t) :: config
    type(message_list_t) :: errors, notices
    logical :: holds
    integer :: i
    call config%load_text(text, 'f.ini', registry, errors, notices)
    holds = errors%count() == 1
    if (holds) holds = errors%text(1) == want
    call kit%check(want, holds)
    if (holds) return
    do i = 1, errors%count()
      call kit%check('    but: '//errors%text(i), .false.)
    end do
  end subroutine expect_whole

  logical function is_accepted(text) result(holds)
    character(*), intent(in) :: text
    type(config_t) :: config
    type(message_list_t) :: errors, notices
    call config%load_text(MINIMAL//text, 'f.ini', registry, errors, notices)
    holds = errors%count() == 0 .and. notices%count() == 0
  end function is_accepted

  logical function same(x, y)
    real(rp), intent(in) :: x, y
    same = .not. (x < y .or. x > y)
  end function same

  subroutine check_sample(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    real(rp), allocatable :: v(:), m(:, :)
    call c%load_text(sample_text(), 'f.ini', registry, errors, notices)
    call kit%check('a file without mistakes', errors%count() == 0)
    call kit%check('integers', c%get_integer('Resolution', 'nx') == 32 .and. c%get_integer('Resolution', &
                                                                                           'ny') == 64)
    call kit%check('reals', same(c%get_real('Geometry', 'yl'), 2.0_rp) .and. &
                   same(c%get_real('Time', 'Tmax'), 20.0_rp) .and. same(c%get_real('Time', 'CFL'), 0.5_rp))
    call kit%check('words', c%get_word('Time', 'iTimeMethodFluid') == 'RK4' .and. &
                   c%get_word('InitialCondition', 'inicond') == 'backup::file.h5')
    call kit%check('switches', c%get_switch('Time', 'intelligent_dt') .and. &
                   .not. c%get_switch('Penalization', 'iMoving'))
    call kit%check('text keeps its blanks', c%get_text('InitialCondition', 'file_ux') == 'my file.h5')
    call kit%check('a key under its old name', c%get_switch('SaveSlices', 'use_slicing') .and. &
                   c%is_given('SaveSlices', 'use_slicing') .and. c%line_of('SaveSlices', 'use_slicing') == 30)
    v = c%get_reals('Penalization', 'us_fixed')
    call kit%check('a list of fixed length', size(v) == 3 .and. same(v(2), -1.5_rp) .and. same(v(3), 3.0_rp))
    v = c%get_reals('Penalization', 'weights')
    call kit%check('a list with commas', size(v) == 4 .and. same(sum(v), 10.0_rp))
    m = c%get_matrix('Wing', 'profile')
    call kit%check('a matrix', all(shape(m) == [3, 3]) .and. same(m(2, 1), 3.0_rp) .and. same(m(3, 3), &
                                                                                              8.0_rp))
    m = c%get_matrix('Wing', 'table')
    call kit%check('a matrix of one row', all(shape(m) == [1, 2]) .and. same(m(1, 2), 2.0_rp))
    call kit%check('given or not', c%is_given('Time', 'CFL') .and. .not. c%is_given('Geometry', 'thickness'))
    call kit%check('lines', c%line_of('Time', 'CFL') == 16 .and. c%line_of('Geometry', 'thickness') == 10)
  end subroutine check_sample

  subroutine check_defaults(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    call c%load_text(MINIMAL, 'f.ini', registry, errors, notices)
    call kit%check('a file with the required keys only', errors%count() == 0 .and. notices%count() == 0)
    call kit%check('defaults', c%get_integer('Resolution', 'nx') == 8 .and. same(c%get_real('Time', 'CFL'), &
                                                                                 0.1_rp) &
                   .and. c%get_word('Time', 'iTimeMethodFluid') == 'AB2' .and. .not. c%get_switch('Time', &
                                                                                                  'intelligent_dt') &
                   .and. c%get_text('InitialCondition', 'file_ux') == 'none' &
                   .and. size(c%get_matrix('Wing', 'profile'), 1) == 0)
    call kit%check('default of a list', all(abs(c%get_reals('Penalization', 'us_fixed') - &
                                                [0.0_rp, 0.5_rp, 0.0_rp]) <= 0.0_rp))
    call kit%check('defaults are not given',.not. c%is_given('Time', 'CFL') .and. c%line_of('Time', &
                                                                                            'CFL') == 0 &
                   .and. .not. c%is_given('Geometry', 'y0'))
    call c%load_text(sample_text(), 'f.ini', registry, errors, notices)
    call c%load_text(MINIMAL, 'f.ini', registry, errors, notices)
    call kit%check('loading again forgets the first file',.not. c%is_given('Time', 'CFL') .and. &
                   same(c%get_real('Time', 'CFL'), 0.1_rp) .and. size(c%get_reals('Penalization', 'weights')) == 1)
  end subroutine check_defaults

  subroutine check_lengths(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    call c%load_text('[Geometry]'//NL//'thickness=3*dx;'//NL//'y0 = -2.5d0 * dx'//NL//'yl=2.0'//NL// &
                     '[Resolution]'//NL//'ny=16;'//NL//'[Time]'//NL//'Tmax=1;', 'f.ini', registry, errors, notices)
    call kit%check('N*dx is N*yl/ny, also in front of yl and ny', errors%count() == 0 .and. &
                   same(c%get_real('Geometry', 'thickness'), 0.375_rp) .and. same(c%get_real('Geometry', 'y0'), &
                                                                                  -0.3125_rp))
    call c%load_text('[Geometry]'//NL//'yl=2.0'//NL//'[Resolution]'//NL//'ny=16;'//NL//'[Time]'//NL// &
                     'Tmax=1;', &
                     'f.ini', registry, errors, notices)
    call kit%check('a default in N*dx', same(c%get_real('Geometry', 'thickness'), 0.5_rp))
    call expect(kit, 'CFL=3*dx;', &
                "f.ini:5: [Time] CFL: '3*dx' is given in units of dx, but this key is not a "// &
                'length; valid: real > 0.0 and <= 1.0')
    call expect(kit, '[Geometry]'//NL//'y0=x*dx;', &
                "f.ini:6: [Geometry] y0: 'x*dx' is not a number times dx; "// &
                'valid: real or N*dx')
    call expect(kit, '[Geometry]'//NL//'y0=3*dy;', "f.ini:6: [Geometry] y0: '3*dy' is not a number; "// &
                'valid: real or N*dx')
    call expect(kit, '[Geometry]'//NL//'thickness=-1*dx;', &
                "f.ini:6: [Geometry] thickness: '-1*dx' is out of "// &
                'range; valid: real or N*dx >= 0.0')
    call expect(kit, '[Geometry]'//NL//'yl=1e300;'//NL//'y0=1e300*dx;', &
                "f.ini:7: [Geometry] y0: '1e300*dx' is "// &
                'too large for a number; valid: real or N*dx')
    call c%load_text('[Resolution]'//NL//'ny=x;'//NL//'[Time]'//NL//'Tmax=1;'//NL//'[Geometry]'//NL// &
                     'y0=3*dx;', &
                     'f.ini', registry, errors, notices)
    call kit%check('N*dx without a valid ny', &
                   errors%text(errors%count()) == "f.ini:6: [Geometry] y0: '3*dx' "// &
                   'cannot be computed, because dx = yl/ny is not known; valid: real or N*dx')
  end subroutine check_lengths

  subroutine check_wrong_values(kit)
    type(testkit_t), intent(inout) :: kit
    call expect(kit, 'CFL=0.1.2;', &
                "f.ini:5: [Time] CFL: '0.1.2' is not a number; valid: real > 0.0 and <= 1.0")
    call expect(kit, 'CFL=nan;', "f.ini:5: [Time] CFL: 'nan' is not a number; valid: real > 0.0 and <= 1.0")
    call expect(kit, 'CFL=1e999;', "f.ini:5: [Time] CFL: '1e999' is too large for a number; "// &
                'valid: real > 0.0 and <= 1.0')
    call expect(kit, 'CFL=0;', "f.ini:5: [Time] CFL: '0' is out of range; valid: real > 0.0 and <= 1.0")
    call expect(kit, 'CFL=1.5;', "f.ini:5: [Time] CFL: '1.5' is out of range; valid: real > 0.0 and <= 1.0")
    call kit%check('the end of a closed range is allowed', is_accepted('CFL=1.0;'))
    call expect(kit, '[Resolution]'//NL//'nx=3.5;', "f.ini:6: [Resolution] nx: '3.5' is not an integer; "// &
                'valid: integer >= 1 and <= 4096')
    call expect(kit, '[Resolution]'//NL//'nx=0;', "f.ini:6: [Resolution] nx: '0' is out of range; "// &
                'valid: integer >= 1 and <= 4096')
    call expect(kit, '[Resolution]'//NL//'nx=99999999999;', &
                "f.ini:6: [Resolution] nx: '99999999999' is too "// &
                'large for an integer; valid: integer >= 1 and <= 4096')
    call expect(kit, 'iTimeMethodFluid=RK5;', "f.ini:5: [Time] iTimeMethodFluid: 'RK5' is unknown; "// &
                "valid: AB2 | RK4; did you mean 'RK4'?")
    call expect(kit, 'iTimeMethodFluid=ab2;', "f.ini:5: [Time] iTimeMethodFluid: 'ab2' is unknown; "// &
                "valid: AB2 | RK4; did you mean 'AB2'?")
    call expect(kit, 'iTimeMethodFluid=Newmark;', &
                "f.ini:5: [Time] iTimeMethodFluid: 'Newmark' is unknown; "// &
                'valid: AB2 | RK4')
    call expect(kit, 'iTimeMethodFluid=FSI_AB2_staggered;', "f.ini:5: [Time] iTimeMethodFluid: "// &
                "'FSI_AB2_staggered' is a value of FLUSI that this program does not have; valid: AB2 | RK4")
    call expect(kit, '[InitialCondition]'//NL//'inicond=backup:file.h5', &
                "f.ini:6: [InitialCondition] inicond: "// &
                "'backup:file.h5' is unknown; valid: quiescent | backup::*")
    call expect(kit, 'intelligent_dt=yse;', &
                "f.ini:5: [Time] intelligent_dt: 'yse' is neither yes nor no; "// &
                "valid: yes | no | 1 | 0 | true | false; did you mean 'yes'?")
    call expect(kit, '[Penalization]'//NL//'iMoving=1;', &
                "f.ini:6: [Penalization] iMoving: '1' asks for moving "// &
                'bodies, which this program does not have; valid: no')
    call kit%check('all spellings of a switch', is_accepted('intelligent_dt=yes;') .and. &
                   is_accepted('intelligent_dt=1;') .and. is_accepted('intelligent_dt=true;') .and. &
                   is_accepted('intelligent_dt=.true.;') .and. is_accepted('intelligent_dt=no;') .and. &
                   is_accepted('intelligent_dt=0;') .and. is_accepted('intelligent_dt=false;') .and. &
                   is_accepted('intelligent_dt=.false.;'))
    call expect(kit, '[Penalization]'//NL//'us_fixed=1 2;', &
                'f.ini:6: [Penalization] us_fixed: 2 numbers are '// &
                'given, not 3; valid: 3 reals')
    call expect(kit, '[Penalization]'//NL//'us_fixed=1 2 x;', &
                "f.ini:6: [Penalization] us_fixed: 'x' is not a "// &
                'number; valid: 3 reals')
    call expect(kit, '[Penalization]'//NL//'weights=1 -2;', &
                "f.ini:6: [Penalization] weights: '-2' is out of "// &
                'range; valid: reals >= 0.0')
    call expect(kit, '[Wing]'//NL//'profile=(/ 1 2 3'//NL//NL//'4 5 /);', &
                'f.ini:6: [Wing] profile: the row in '// &
                'line 8 has 2 numbers, not 3; valid: matrix (/ rows of 3 /)')
    call expect(kit, '[Wing]'//NL//'table=(/ 1 2'//NL//'4 5x /);', &
                "f.ini:6: [Wing] table: in line 7: '5x' is "// &
                'not a number; valid: matrix (/ rows /)')
    call expect(kit, '[Wing]'//NL//'table=1 2 3;', &
                "f.ini:6: [Wing] table: a matrix is expected, not '1 2 3'; "// &
                'valid: matrix (/ rows /)')
    call expect(kit, 'CFL=(/ 1 2 /);', 'f.ini:5: [Time] CFL: one value is expected, not a matrix (/ /); '// &
                'valid: real > 0.0 and <= 1.0')
  end subroutine check_wrong_values

  subroutine check_unknown_names(kit)
    type(testkit_t), intent(inout) :: kit
    character(*), &
      parameter :: SECTIONS = 'Resolution | Geometry | Time | InitialCondition | Penalization | '// &
                   'SaveSlices | Wing | Saving'
    call expect(kit, 'CLF=0.1;', "f.ini:5: [Time] CLF: unknown key; "// &
                "valid: Tmax | CFL | iTimeMethodFluid | intelligent_dt; did you mean 'CFL'?")
    call expect(kit, 'cfl=0.1;', "f.ini:5: [Time] cfl: unknown key (names are case-sensitive); "// &
                "valid: Tmax | CFL | iTimeMethodFluid | intelligent_dt; did you mean 'CFL'?")
    call expect(kit, 'temperature=0.1;', 'f.ini:5: [Time] temperature: unknown key; '// &
                'valid: Tmax | CFL | iTimeMethodFluid | intelligent_dt')
    call expect(kit, 'yl=0.1;', 'f.ini:5: [Time] yl: unknown key, it belongs to [Geometry]; '// &
                'valid: Tmax | CFL | iTimeMethodFluid | intelligent_dt')
    call expect(kit, '[Geometri]'//NL//'yl=1', 'f.ini:5: [Geometri]: unknown section; valid: '//SECTIONS// &
                "; did you mean 'Geometry'?")
    call expect(kit, '[geometry]'//NL//'yl=1', 'f.ini:5: [geometry]: unknown section (names are '// &
                'case-sensitive); valid: '//SECTIONS//"; did you mean 'Geometry'?")
    call expect(kit, '[Chemistry]'//NL//'k=1'//NL//'l=2', 'f.ini:5: [Chemistry]: unknown section; '// &
                'valid: '//SECTIONS)
    call expect_whole(kit, '[resolution]'//NL//'ny=4;'//NL//'[Time]'//NL//'Tmax=1;', &
                      'f.ini:1: [resolution]: unknown section (names are case-sensitive); valid: '//SECTIONS// &
                      "; did you mean 'Resolution'?")
    call expect_whole(kit, '[Resolution]'//NL//'ny=4;'//NL//'[Time]'//NL//'tmax=1;', &
                      "f.ini:4: [Time] tmax: "// &
                   "unknown key (names are case-sensitive); valid: Tmax | CFL | iTimeMethodFluid | intelligent_dt; "// &
                      "did you mean 'Tmax'?")
  end subroutine check_unknown_names

  subroutine check_duplicates(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    character(*), parameter :: TWICE = MINIMAL//'CFL=0.2;'//NL//'[Time]'//NL//'CFL=0.3;'
    call expect_whole(kit, TWICE, 'f.ini:7: [Time] CFL: is given twice, first in line 5')
    call expect(kit, '[SaveSlices]'//NL//'save_slices=no;'//NL//'use_slicing=yes;', &
                'f.ini:7: [SaveSlices] use_slicing: is given twice, first in line 6 under the name save_slices')
    call expect(kit, 'CFL=;'//NL//'CFL=0.2;', 'f.ini:6: [Time] CFL: is given twice, first in line 5')
    call c%load_text(TWICE, 'f.ini', registry, errors, notices, flusi_compat=.true.)
    call kit%check('as in FLUSI the first one counts, with a notice', errors%count() == 0 .and. &
                   notices%count() == 1 .and. same(c%get_real('Time', 'CFL'), 0.2_rp))
    if (notices%count() > 0) call kit%check(notices%text(1), notices%text(1) == &
                                           'f.ini:7: [Time] CFL: is given twice, first in line 5; the first one counts')
  end subroutine check_duplicates

  subroutine check_notices(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    character(*), &
      parameter :: WANT = 'f.ini: accepted, but without effect here: [Saving] iSaveXMF (line 6), '// &
                   '[Saving] pseudoeps (line 7), [Insects], [Scalar1], [Scalar12]'
    call c%load_text(MINIMAL//'[Saving]'//NL//'iSaveXMF=1;'//NL//'pseudoeps=(/ 1'//NL//'2 /);'//NL// &
                  'iSaveXMF=2;'//NL//'[Insects]'//NL//'a=1;'//NL//'b=;'//NL//'a=2;'//NL//'[Scalar1]'//NL//'k=1;'//NL// &
                     '[Scalar12]'//NL//'k=2;', 'f.ini', registry, errors, notices)
    call kit%check('keys without effect give one notice', errors%count() == 0 .and. notices%count() == 1)
    if (notices%count() > 0) call kit%check(notices%text(1), notices%text(1) == WANT)
    call expect(kit, '[Insects]'//NL//'use_insects=yes;', &
                "f.ini:6: [Insects] use_insects: 'yes' asks for "// &
                'insects, which this program does not have; valid: no')
    call kit%check('a registered key of an inert section is quiet', is_accepted('[Insects]'//NL// &
                                                                                'use_insects=no;'))
  end subroutine check_notices

  subroutine check_collecting(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c
    type(message_list_t) :: errors, later, notices
    call expect_whole(kit, '[Time]'//NL//'Tmax=1;', 'f.ini: [Resolution] ny: is missing; valid: integer >= 1')
    call expect_whole(kit, '[Resolution]'//NL//'ny=;'//NL//'[Time]'//NL//'Tmax=1;', &
                      'f.ini:2: [Resolution] ny: is missing; valid: integer >= 1')
    call expect_whole(kit, '[Resolution]'//NL//'ny=a;'//NL//'[Time]'//NL//'Tmax=1;', &
                      "f.ini:2: [Resolution] ny: 'a' is not an integer; valid: integer >= 1")
    call c%load_text('[Resolution'//NL//'[Time]'//NL//'CFL=2;'//NL//'x 3'//NL//'CLF=1;'//NL//'CFL=3;'//NL// &
                     '[Xyz]', &
                     'f.ini', registry, errors, notices)
    call kit%check('all mistakes at once', errors%count() == 8)
    call kit%check('after mistakes there are defaults', same(c%get_real('Time', 'CFL'), 0.1_rp) .and. &
                   .not. c%is_given('Time', 'CFL') .and. c%line_of('Time', 'CFL') == 3)
    call c%complain(errors, 'Time', 'CFL', 'does not go with nx')
    call kit%check('a key with a mistake gets no second one', errors%count() == 8)
    call c%load_text(MINIMAL//'CFL=0.5', 'g.ini', registry, later, notices)
    call c%complain(later, 'Time', 'CFL', 'does not go with nx')
    call kit%check('complaint about a given key', &
                   later%text(1) == 'g.ini:5: [Time] CFL: does not go with nx')
    call c%complain(later, 'Resolution', 'nx', 'is odd')
    call kit%check('complaint about a default', later%text(2) == 'g.ini: [Resolution] nx: is odd')
  end subroutine check_collecting

  subroutine check_files(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    integer :: unit
    open (newunit=unit, file='minimal.ini', access='stream', form='unformatted', status='replace')
    write (unit) MINIMAL
    close (unit)
    call c%load_file('minimal.ini', registry, errors, notices)
    call kit%check('a file is loaded', errors%count() == 0 .and. c%get_integer('Resolution', 'ny') == 4)
    call c%load_file('missing.ini', registry, errors, notices)
    call kit%check('a missing file is one mistake', errors%count() == 1)
    call kit%check('and leaves the defaults', c%get_integer('Resolution', 'nx') == 8)
  end subroutine check_files
end program test_ini_config

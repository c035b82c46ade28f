! SPDX-License-Identifier: GPL-3.0-or-later
!> What is written from the register: the effective values, which are an ini file again, and the
!> parameter tables of the documentation.
program test_ini_report
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use io_broadcast_text, only: read_text_file
  use io_config, only: config_t
  use io_registry, only: registry_t
  use test_ini_sample, only: register_sample, sample_text
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10)
  type(testkit_t) :: kit
  type(registry_t) :: registry

  call kit%start(parallel=.false.)
  call register_sample(registry)
  call check_effective(kit)
  call check_markdown(kit)
  call kit%finish()

contains

  function effective(c, path) result(text)
    type(config_t), intent(in) :: c
    character(*), intent(in) :: path
    character(:), allocatable :: text, problem
    integer :: unit
    open (newunit=unit, file=path, status='replace')
    call c%print_effective(unit)
    close (unit)
    call read_text_file(path, text, problem)
  end function effective

  !> text has this line; runs of blanks count as one.
  logical function has_line(text, line) result(has)
    character(*), intent(in) :: text, line
    character(:), allocatable :: squeezed
    integer :: i
    squeezed = text(1:1)
    do i = 2, len(text)
      if (text(i:i) == ' ' .and. text(i - 1:i - 1) == ' ') cycle
      squeezed = squeezed//text(i:i)
    end do
    has = index(NL//squeezed, NL//line//NL) > 0
  end function has_line

  subroutine check_effective(kit)
    type(testkit_t), intent(inout) :: kit
    type(config_t) :: c, again
    type(message_list_t) :: errors, notices, more_notices
    character(:), allocatable :: text
    call c%load_text(sample_text(), 'f.ini', registry, errors, notices)
    text = effective(c, 'effective.ini')
    call kit%check('a given value with unit and place', has_line(text, ' nx = 32; points, f.ini:3'))
    call kit%check('a length is shown worked out', has_line(text, ' y0 = 0.5; L, f.ini:9'))
    call kit%check('a default', has_line(text, ' thickness = 0.125; L, default'))
    call kit%check('a switch under its own name', has_line(text, ' use_slicing = yes; f.ini:30'))
    call kit%check('a word and a text', has_line(text, ' iTimeMethodFluid = RK4; f.ini:17') .and. &
                   has_line(text, ' file_ux = my file.h5; f.ini:22'))
    call kit%check('a list', has_line(text, ' us_fixed = 0.0 -1.5 3.0; L/T, f.ini:26'))
    call kit%check('a matrix', has_line(text, ' profile = (/ 0.0 1.0 2.0') .and. &
                   has_line(text, ' 6.0 7.0 8.0 /); f.ini:33'))
    call kit%check('keys without effect are not shown', index(text, 'iSaveXMF') == 0)
    call again%load_text(text, 'e.ini', registry, errors, more_notices)
    call kit%check('it is an ini file without mistakes', errors%count() == 0 .and. more_notices%count() == 0)
    call errors%print(0, 'but: ')
    call kit%check('with the same values', &
                   .not. abs(again%get_real('Geometry', 'thickness') - 0.125_rp) > 0 .and. &
                   again%get_text('InitialCondition', 'file_ux') == 'my file.h5' .and. &
                   .not. any(abs(again%get_matrix('Wing', 'profile') - c%get_matrix('Wing', 'profile')) > 0))

    call c%load_text('[Resolution]'//NL//'ny=4;'//NL//'[Time]'//NL//'Tmax=1', 'f.ini', registry, errors, &
                     notices)
    text = effective(c, 'effective.ini')
    call kit%check('a value that the program works out', &
                   has_line(text, ' y0 = ; L, default: yl/2, computed by the program'))
    call kit%check('a matrix that is not given', has_line(text, ' profile = ; default'))
    call again%load_text(text, 'e.ini', registry, errors, notices)
    call kit%check('defaults can be read again', errors%count() == 0 .and. .not. again%is_given('Geometry', &
                                                                                                'y0'))
  end subroutine check_effective

  subroutine check_markdown(kit)
    type(testkit_t), intent(inout) :: kit
    character(:), allocatable :: text, problem
    integer :: unit
    open (newunit=unit, file='keys.md', status='replace')
    call registry%write_markdown(unit)
    close (unit)
    call read_text_file('keys.md', text, problem)
    call kit%check('a heading and its help', has_line(text, '## [Resolution]'//NL//NL//'Points of the grid.'))
    call kit%check('an integer', has_line(text, &
                                          '| `nx` | integer | points | `8` | >= 1 and <= 4096 | points in x |'))
    call kit%check('a required key', has_line(text, &
                                              '| `ny` | integer | points | required | >= 1 | points in y |'))
    call kit%check('a default that is worked out', has_line(text, &
                                                            '| `y0` | real or N*dx | L | yl/2 | | centre |'))
    call kit%check('words', has_line(text, &
                                     '| `inicond` | word | | `quiescent` | quiescent \| backup::* | initial flow |'))
    call kit%check('switches', has_line(text, &
                                        '| `intelligent_dt` | switch | | `no` | yes \| no | meet output times |') &
                   .and. has_line(text, '| `iMoving` | switch | | `no` | no | moving body |'))
    call kit%check('a bar in the help', has_line(text, &
                                                 '| `file_ux` | text | | `none` | | file \| with u_x |'))
    call kit%check('lists and matrices', &
                   has_line(text, '| `us_fixed` | 3 reals | L/T | `0.0 0.5 0.0` | | velocity |') .and. &
                   has_line(text, '| `profile` | matrix (/ rows of 3 /) | | none | | rows of x y z |'))
    call kit%check('keys without effect', has_line(text, &
                                                   'Accepted from FLUSI files, without effect: `iSaveXMF`, `pseud*`.'))
    call kit%check('sections without effect', has_line(text, '## [Scalar*]'//NL//NL//'Not built.'))
    call kit%check('aliases', has_line(text, 'Older name of `use_slicing`: `save_slices`.'))
  end subroutine check_markdown
end program test_ini_report

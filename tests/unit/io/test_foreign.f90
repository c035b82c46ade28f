! SPDX-License-Identifier: GPL-3.0-or-later
!> Inputs of other programs and files of other kinds are told by one message; what may be an input is read as one.
program test_foreign
  use base_errors, only: message_list_t
  use io_config, only: config_t
  use io_registry, only: registry_t
  use io_suggest, only: number_hint
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = new_line('a'), BINARY(2) = [char(137)//'HDF', 'PK'//char(3)//char(4)]
  type(testkit_t) :: t
  call t%start(parallel=.false.)
  call t%check('an input of its own, with a section of another program', answer('[Bend]'//NL//'k = 1'//NL//'[Fly]'//NL) == &
               'a.ini:3: [Fly]: unknown section; valid: Common | Bend')
  call t%check('one of another program', answer('[Common]'//NL//'x = 2'//NL//'[Fly]'//NL//'y = 2') == &
               'a.ini:3: [Fly]: is for fly; run fly a.ini, now')
  call t%check('the first program counts', answer('[Swim]'//NL//'[Fly]'//NL) == 'a.ini:2: [Fly]: is for fly; run fly a.ini, now')
  call t%check('another one', answer('[Swim]'//NL) == 'a.ini:1: [Swim]: is for swim')
  call t%check('a part of an input', answer('[Common]'//NL//'x = 2') == 'a.ini:1: [Common]: is a part; include a.ini')
  call t%check('not with an unknown section', index(answer('[Common]'//NL//'x = 2'//NL//'[Cimmon]'), 'is a part') == 0)
  call t%check('HDF5', index(answer(BINARY(1)//NL//char(0)//char(1)//NL), 'a.ini:1: is an HDF5 file') == 1)
  call t%check('an archive', index(answer(BINARY(2)//NL//'b'), 'a.ini:1: is an archive') == 1)
  call t%check('UTF-16', index(answer(char(255)//char(254)//'['//char(0)), 'a.ini:1: is written in UTF-16') == 1)
  call t%check('a drawing', index(answer(NL//' <svg width="1">'), 'a.ini:1: is XML') == 1)
  call t%check('JSON', index(answer('{"wing": 1}'), 'a.ini:1: is JSON') == 1)
  call t%check('RTF', index(answer('{\rtf1 [Bend]}'), 'a.ini:1: is a document') == 1)
  call t%check('units and decimal commas', number_hint('9 mm^2') /= '' .and. number_hint('-70deg') /= '' .and. &
               number_hint('0,5') == '; did you mean ''0.5''?')
  call t%check('no hint where there is nothing to say', number_hint('9') == '' .and. number_hint('') == '' .and. &
               number_hint('mm') == '' .and. number_hint('1 2') == '' .and. number_hint('-') == '' .and. &
               number_hint('3*dy') == '' .and. number_hint('0.1.2') == '' .and. number_hint('1,2,3') == '')
  call t%finish()

contains

  !> All mistakes of this input of a program with the sections Common and Bend.
  function answer(text) result(told)
    character(*), intent(in) :: text
    character(:), allocatable :: told
    type(registry_t) :: registry
    type(config_t) :: config
    type(message_list_t) :: errors, notices
    integer :: i
    call registry%add_integer('Common', 'x', 1, 'a number')
    call registry%add_integer('Bend', 'k', 1, 'a number', required=.true.)
    call registry%foreign%set_own('Bend')
    call registry%foreign%add('Fly|Walk', 'is for fly; run fly *, now')
    call registry%foreign%add('Swim', 'is for swim')
    call registry%foreign%set_fragment('Common', 'is a part; include *')
    call config%load_text(text, 'a.ini', registry, errors, notices)
    told = ''
    do i = 1, errors%count()
      told = told//NL//errors%text(i)
    end do
    told = told(2:)
  end function answer
end program test_foreign

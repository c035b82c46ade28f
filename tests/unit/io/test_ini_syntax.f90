! SPDX-License-Identifier: GPL-3.0-or-later
!> Syntax of ini files: what is an entry, what is a comment, what is broken and where.
program test_ini_syntax
  use base_errors, only: message_list_t
  use io_ini, only: ini_document_t
  use io_broadcast_text, only: read_text_file
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10), TAB = achar(9), CR = achar(13)
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call check_values(kit)
  call check_layout(kit)
  call check_matrices(kit)
  call check_broken_lines(kit)
  call check_files(kit)
  call kit%finish()

contains

  !> value_is(line, key, value): the line gives this entry.
  logical function value_is(line, key, value) result(holds)
    character(*), intent(in) :: line, key, value
    type(ini_document_t) :: document
    type(message_list_t) :: errors
    call document%parse('[S]'//NL//line, 'f.ini', errors)
    holds = errors%count() == 0 .and. document%n_entries == 1
    if (holds) holds = document%entries(1)%key == key .and. document%entries(1)%value == value .and. &
                       len(document%entries(1)%value) == len(value) .and. document%entries(1)%line == 2
  end function value_is

  !> The text gives exactly one message, which begins with `start`.
  logical function complains(text, start) result(holds)
    character(*), intent(in) :: text, start
    type(ini_document_t) :: document
    type(message_list_t) :: errors
    call document%parse(text, 'f.ini', errors)
    holds = errors%count() == 1
    if (holds) holds = index(errors%text(1), start) == 1
  end function complains

  subroutine check_values(kit)
    type(testkit_t), intent(inout) :: kit
    call kit%check('FLUSI form', value_is('nu=1.0e-2;', 'nu', '1.0e-2'))
    call kit%check('what stands behind ; is a comment', value_is('nu=1.0e-2; nu=3; the inverse of Re', 'nu', &
                                                                 '1.0e-2'))
    call kit%check('blanks and tabs around = and in front', value_is('  nu'//TAB//'= '//TAB//'1.0  ;', 'nu', &
                                                                     '1.0'))
    call kit%check('no semicolon', value_is('BodyType=drosophila', 'BodyType', 'drosophila'))
    call kit%check('a list keeps its blanks', value_is('v=0 1  2;', 'v', '0 1  2'))
    call kit%check('an empty value', value_is('dt_fixed=;', 'dt_fixed', ''))
    call kit%check('an empty value with a comment', value_is('x_pivot_r=; (vector) of the hinge', &
                                                             'x_pivot_r', ''))
    call kit%check('an empty value at the end of the text', value_is('dt_fixed=', 'dt_fixed', ''))
    call kit%check('# ends a value behind a blank', value_is('nx = 32 # points; or more'//NL, 'nx', &
                                                             '32 # points') &
                   .and. value_is('nx = 32 # points', 'nx', '32'))
    call kit%check('! and % end a value behind a blank', value_is('nx=32 !points', 'nx', '32') .and. &
                   value_is('nx=32'//TAB//'% points', 'nx', '32'))
    call kit%check('# without a blank belongs to the value', value_is('file=a#1.h5', 'file', 'a#1.h5'))
    call kit%check('# behind ; is in the comment', value_is('file=a #1.h5; x', 'file', 'a #1.h5'))
    call kit%check('only a comment behind =', value_is('nx = # points', 'nx', ''))
    call kit%check('the first = counts', value_is('a=b=c;', 'a', 'b=c'))
    call kit%check('a carriage return is no part of the value', value_is('nx=32'//CR//NL, 'nx', '32'))
    call kit%check('bytes above 127 are kept', value_is('file='//char(195)//char(188)//char(228)//';', &
                                                        'file', &
                                                        char(195)//char(188)//char(228)))
    call kit%check('control bytes in a comment do no harm', value_is('nx=32; '//achar(0)//achar(7), 'nx', &
                                                                     '32'))
  end subroutine check_values

  subroutine check_layout(kit)
    type(testkit_t), intent(inout) :: kit
    type(ini_document_t) :: document
    type(message_list_t) :: errors
    character(:), allocatable :: long_value
    integer :: i
    call document%parse(char(239)//char(187)//char(191)//'[ A ] ; comment'//CR//NL//CR//NL//'; nt=;'//NL// &
                '# nt=;'//NL//'  ! [X]'//NL//'% b'//NL//TAB//NL//'x=1;'//NL//'[B]#no blank'//NL//'x=2', 'f.ini', errors)
    call kit%check('a file with mark, comments and empty lines', errors%count() == 0 .and. &
                   document%n_sections == 2 .and. document%n_entries == 2)
    call kit%check('section names and lines', document%sections(1)%name == 'A' .and. &
                   document%sections(1)%line == 1 &
                   .and. document%sections(2)%name == 'B' .and. document%sections(2)%line == 9)
    call kit%check('entries belong to sections and lines', document%entries(1)%section == 1 .and. &
                   document%entries(1)%line == 8 .and. document%entries(2)%section == 2 .and. &
                   document%entries(2)%line == 10)
    long_value = repeat('1 ', 500000)
    call document%parse('[A]'//NL//'x='//long_value//';'//NL//'y=2;', 'f.ini', errors)
    call kit%check('a line of a megabyte', errors%count() == 0 .and. document%n_entries == 2 .and. &
                   len(document%entries(1)%value) == 999999)
    call document%parse('[A]'//NL//repeat('x=1;'//NL, 5000), 'f.ini', errors)
    call kit%check('five thousand entries', errors%count() == 0 .and. document%n_entries == 5000 .and. &
                   document%entries(5000)%line == 5001)
    call document%parse(repeat('[A]'//NL, 1000), 'f.ini', errors)
    call kit%check('a thousand sections', errors%count() == 0 .and. document%n_sections == 1000 .and. &
                   all([(document%sections(i)%line == i, i=1, 1000)]))
  end subroutine check_layout

  subroutine check_matrices(kit)
    type(testkit_t), intent(inout) :: kit
    type(ini_document_t) :: document
    type(message_list_t) :: errors
    call document%parse('[A]'//NL//'m = (/ 1 2 ; first'//NL//'; a comment'//NL//' 3  4'//CR//NL//NL// &
                        '5 6 # last'//NL//'/); end'//NL//'n=1;', 'f.ini', errors)
    call kit%check('a matrix over several lines', errors%count() == 0 .and. document%n_entries == 2)
    associate (m => document%entries(1))
      call kit%check('its rows keep their lines', m%is_matrix .and. m%line == 2 .and. &
                     m%value == ' 1 2'//NL//NL//'3  4'//NL//NL//'5 6 '//NL)
    end associate
    call kit%check('the line behind the matrix', document%entries(2)%line == 8 .and. &
                   document%entries(2)%key == 'n')
    call document%parse('[A]'//NL//'m=(/ 1 2 /);', 'f.ini', errors)
    call kit%check('a matrix on one line', errors%count() == 0 .and. document%entries(1)%is_matrix .and. &
                   document%entries(1)%value == ' 1 2 ')
    call document%parse('[A]'//NL//'m=(//)', 'f.ini', errors)
    call kit%check('an empty matrix', errors%count() == 0 .and. document%entries(1)%is_matrix .and. &
                   document%entries(1)%value == '')
    call kit%check('a matrix that is not closed at the end', &
                   complains('[A]'//NL//'m=(/ 1 2'//NL//'3 4', &
                             "f.ini:2: the matrix that begins here is not closed by '/)'"))
    call kit%check('a matrix that is not closed before a key or a section', &
                 complains('[A]'//NL//'m=(/ 1 2'//NL//'3 4'//NL//'n=1;', 'f.ini:2: the matrix that begins here') .and. &
                   complains('[A]'//NL//'m=(/ 1 2'//NL//'[B]', 'f.ini:2: the matrix that begins here'))
    call document%parse('[A]'//NL//'m=(/ 1 2'//NL//'3 4'//NL//'n=1;'//NL//'[B]'//NL//'k=(/ 1'//NL//'[C]', &
                        'f.ini', errors)
    call kit%check('what stands behind a matrix that is not closed is read', document%n_entries == 1 .and. &
                   document%n_sections == 3)
    call kit%check('and at its line', document%entries(1)%key == 'n' .and. &
                   document%entries(1)%line == 4 .and. &
                   document%sections(3)%line == 7)
    call kit%check('text behind a matrix', complains('[A]'//NL//'m=(/ 1'//NL//'2 /) 3', &
                                                     "f.ini:2: only a comment may"))
    call kit%check('binary in a matrix', complains('[A]'//NL//'m=(/ 1'//NL//achar(1)//' /)', &
                                        'f.ini:2: the matrix that begins here holds bytes that are not text in line 3'))
  end subroutine check_matrices

  subroutine check_broken_lines(kit)
    type(testkit_t), intent(inout) :: kit
    type(ini_document_t) :: document
    type(message_list_t) :: errors
    call kit%check('no =', complains('[A]'//NL//NL//'nx 32;', "f.ini:3: expected '[Section]', 'key = value'"))
    call kit%check('= only in the comment', complains('[A]'//NL//'nx 32; nx=32', &
                                                      "f.ini:2: expected '[Section]'"))
    call kit%check('no key', complains('[A]'//NL//'= 32;', "f.ini:2: there is no key before '='"))
    call kit%check('section not closed', complains('[A'//NL//'x=1;', "f.ini:1: ']' is missing: '[A'"))
    call kit%check('section without name', complains('[ ]', 'f.ini:1: the section has no name'))
    call kit%check('text behind a section', complains('[A] x=1;', "f.ini:1: only a comment may follow ']'"))
    call kit%check('a key before any section', complains('nx=1;', &
                                                         "f.ini:1: the key 'nx' stands before any [Section]"))
    call kit%check('control bytes in a key or value', complains('[A]'//NL//'a'//achar(0)//'b=1;', &
                      "f.ini:2: holds bytes that are not text: 'a?b=1'") .and. complains('[A]'//NL//'x=1'//achar(127), &
                                                                                                'f.ini:2: holds bytes'))
    call kit%check('control bytes in a section', complains('[A'//achar(1)//']', 'f.ini:1: holds bytes'))
    call kit%check('nothing', complains('', 'f.ini: is empty') .and. complains('; only'//NL//NL, &
                                                                               'f.ini: is empty'))
    call document%parse('[A'//NL//'x=1'//NL//'[B]'//NL//'y=2', 'f.ini', errors)
    call kit%check('keys behind a broken section belong to no section', &
                   document%sections(1)%name == '' .and. &
                   document%sections(2)%name == 'B' .and. document%entries(2)%section == 2)
    call errors_of(repeat('garbage'//NL, 1000), errors)
    call kit%check('a thousand broken lines end in one message', errors%count() == 51 .and. &
                   index(errors%text(51), 'f.ini:51: too many broken lines') == 1)
  end subroutine check_broken_lines

  subroutine errors_of(text, errors)
    character(*), intent(in) :: text
    type(message_list_t), intent(out) :: errors
    type(ini_document_t) :: document
    call document%parse(text, 'f.ini', errors)
  end subroutine errors_of

  subroutine check_files(kit)
    type(testkit_t), intent(inout) :: kit
    character(:), allocatable :: text, problem
    integer :: unit
    open (newunit=unit, file='some.ini', access='stream', form='unformatted', status='replace')
    write (unit) 'a'//CR//NL//achar(0)//'b'
    close (unit)
    call read_text_file('some.ini', text, problem)
    call kit%check('a file is read byte by byte',.not. allocated(problem) .and. text == 'a'//CR//NL// &
                   achar(0)//'b')
    open (newunit=unit, file='none.ini', access='stream', form='unformatted', status='replace')
    close (unit)
    call read_text_file('none.ini', text, problem)
    call kit%check('an empty file is read',.not. allocated(problem) .and. len(text) == 0)
    call read_text_file('missing.ini', text, problem)
    call kit%check('a missing file is named', allocated(problem) .and. len(text) == 0)
    if (allocated(problem)) call kit%check(problem, index(problem, 'missing.ini: cannot be opened') == 1)
    call read_text_file('.', text, problem)
    call kit%check('a directory is refused', allocated(problem))
    if (allocated(problem)) call kit%check(problem, index(problem, '.: ') == 1)
    call read_text_file('', text, problem)
    call kit%check('no name is refused', allocated(problem))
    call read_text_file('/dev/zero', text, problem)
    call kit%check('an endless device gives no text', len(text) == 0)
  end subroutine check_files
end program test_ini_syntax

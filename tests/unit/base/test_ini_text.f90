! SPDX-License-Identifier: GPL-3.0-or-later
!> Numbers and words as text: strict reading, exact writing.
program test_ini_text
  use base_kinds, only: i8, rp
  use base_text, only: BLANKS, count_words, edit_distance, next_word, number_text, parse_integer, &
                       parse_real, &
                       printable, quoted, to_lower
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call check_integers(kit)
  call check_reals(kit)
  call check_written_reals(kit)
  call check_words(kit)
  call kit%finish()

contains

  subroutine check_integers(kit)
    type(testkit_t), intent(inout) :: kit
    call kit%check('integers of every sign are read', integer_is('0', 0) .and. integer_is('+2', 2) .and. &
                   integer_is('-17', -17) .and. integer_is('0042', 42) .and. integer_is('2147483647', 2147483647))
    call kit%check('a number with a point, an exponent, a blank, only a sign or nothing is no integer', &
                   .not. (is_integer('1.0') .or. is_integer('1e3') .or. is_integer('1 2') .or. is_integer('+') .or. &
                          is_integer('') .or. is_integer('--1') .or. is_integer('0x1F') .or. is_integer('12a')))
    call kit%check('an integer beyond 32 bits is refused',.not. (is_integer('2147483648') .or. &
                                                is_integer('99999999999999999999') .or. is_integer(repeat('9', 10000))))
  end subroutine check_integers

  subroutine check_reals(kit)
    type(testkit_t), intent(inout) :: kit
    character(*), parameter :: bad(*) = [character(12) :: '1.2.3', '1e', '1e+', 'nan', 'inf', '-Infinity', &
                                                                                               '1.0x', &
                              '.', '+', '-.', '', 'e5', '1 2', '1.0e5.0', '1,5', '0x10', '1e5e5', '--1', '1e--5', '2*3']
    character(*), parameter :: huge_ones(*) = [character(24) :: '1e309', '-1d400', '1.7976931348623159e308', &
                                                         '17976931348623159e292', '1e99999999999999999999', '0.001e312']
    integer :: i
    logical :: all_refused
    call kit%check('all Fortran and C spellings of a real are read', real_is('1.0d-3', 1.0e-3_rp) .and. &
                   real_is('1.e3', 1.0e3_rp) .and. real_is('.5', 0.5_rp) .and. real_is('+2', 2.0_rp) .and. &
                   real_is('-1E+2', -100.0_rp) .and. real_is('0.d0', 0.0_rp) .and. real_is('5D0', 5.0_rp) .and. &
                   real_is('000123.4500', 123.45_rp) .and. real_is('1e0003', 1000.0_rp) .and. &
                   real_is('0.00000123e-4', 1.23e-10_rp) .and. real_is('63.24528806534019d0', 63.24528806534019_rp))
    all_refused = .true.
    do i = 1, size(bad)
      if (is_real(trim(bad(i)))) all_refused = .false.
    end do
    call kit%check('malformed numbers are refused', all_refused)
    call kit%check('a number that begins with a blank byte or holds a zero byte is refused', &
                   .not. (is_real(' 1') .or. is_real('1'//achar(0)) .or. is_real(char(255)//'1')))
    all_refused = .true.
    do i = 1, size(huge_ones)
      if (is_real(trim(huge_ones(i)))) all_refused = .false.
    end do
    call kit%check('overflow is refused', all_refused)
    call kit%check('the largest real is read', real_is('1.7976931348623157e308', huge(1.0_rp)) .and. &
                   real_is('-17976931348623157'//repeat('0', 292), -huge(1.0_rp)))
    call kit%check('underflow is zero, and a zero may have any exponent', real_is('1e-999999999999', &
                                                                                  0.0_rp) .and. &
                   real_is('1e-345', 0.0_rp) .and. real_is('0e99999', 0.0_rp) .and. real_is('4.9406564584124654e-324', &
                                                                                            transfer(1_i8, 1.0_rp)))
    call kit%check('very long numbers are read', real_is('0.'//repeat('3', 100000), 1.0_rp/3.0_rp) .and. &
                   real_is('1'//repeat('0', 100000)//'e-100000', 1.0_rp) .and. &
                   real_is('0.'//repeat('0', 1000)//'5e1001', 5.0_rp) .and. .not. is_real(repeat('1', 100000)))
    call kit%check('a digit far behind the others decides a tie', &
                   real_is('9007199254740993.'//repeat('0', 100)//'1', 9007199254740994.0_rp))
  end subroutine check_reals

  subroutine check_written_reals(kit)
    type(testkit_t), intent(inout) :: kit
    integer(i8) :: bits
    real(rp) :: x
    logical :: exact
    integer :: i
    call kit%check('reals are written shortly', number_text(0.1_rp) == '0.1' .and. &
                   number_text(32.0_rp) == '32.0' &
                   .and. number_text(0.0_rp) == '0.0' .and. number_text(-2.5_rp) == '-2.5' .and. &
                   number_text(1.0e-5_rp) == '1e-5' .and. number_text(9.0e9_rp) == '9e9' .and. &
                   number_text(0.001_rp) == '0.001' .and. number_text(1234567.0_rp) == '1234567.0' .and. &
                   number_text(-1.25e-10_rp) == '-1.25e-10' .and. number_text(acos(-1.0_rp)) == '3.141592653589793')
    call kit%check('integers are written', number_text(-12) == '-12' .and. &
                   number_text(-huge(1) - 1) == '-2147483648')
    exact = real_is(number_text(huge(x)), huge(x)) .and. real_is(number_text(tiny(x)), tiny(x)) .and. &
            real_is(number_text(transfer(1_i8, x)), transfer(1_i8, x))
    bits = 88172645463325252_i8
    do i = 1, 2000
      bits = ieor(bits, ishft(bits, 13))
      bits = ieor(bits, ishft(bits, -7))
      bits = ieor(bits, ishft(bits, 17))
      if (ibits(bits, 52, 11) == 2047) cycle ! infinity or not a number
      x = transfer(bits, x)
      if (.not. real_is(number_text(x), x)) exact = .false.
    end do
    call kit%check('2000 random bit patterns survive writing and reading', exact)
  end subroutine check_written_reals

  subroutine check_words(kit)
    type(testkit_t), intent(inout) :: kit
    character(:), allocatable :: list
    integer :: position, first, last
    logical :: found
    list = ' one '//achar(9)//'two  '
    position = 1
    call next_word(list, BLANKS, position, first, last, found)
    call kit%check('the first word is found', found .and. list(first:last) == 'one')
    call next_word(list, BLANKS, position, first, last, found)
    call kit%check('the second word is found', found .and. list(first:last) == 'two')
    call next_word(list, BLANKS, position, first, last, found)
    call kit%check('then there is none',.not. found)
    call kit%check('words are counted', count_words(list, BLANKS) == 2 .and. count_words('', &
                                                                                         BLANKS) == 0 .and. &
                   count_words('a', BLANKS) == 1 .and. count_words('1, 2,3 ', BLANKS//',') == 3)
    call kit%check('letters are lowered', to_lower('aBcZ09_'//char(200)) == 'abcz09_'//char(200))
    call kit%check('edit distances', edit_distance('', '') == 0 .and. edit_distance('nu', 'mu') == 1 .and. &
                   edit_distance('CLF', 'CFL') == 1 .and. edit_distance('tsave', 'tsav') == 1 .and. &
                   edit_distance('kitten', 'sitting') == 3 .and. edit_distance('abc', '') == 3 .and. &
                   edit_distance('', 'ab') == 2 .and. edit_distance('ca', 'abc') == 3)
    call kit%check('long names are not compared', edit_distance(repeat('a', 100000), 'a') == 100001)
    call kit%check('control bytes are not printed', printable('a'//achar(0)//achar(27)//'b', 10) == 'a??b')
    call kit%check('long text is cut', printable(repeat('x', 100), 5) == 'xxxxx...')
    call kit%check('a letter of two bytes is not cut in two', &
                   printable('abc'//char(195)//char(188)//'d', 4) == 'abc...')
    call kit%check('quotes', quoted('a') == "'a'")
  end subroutine check_words

  logical function is_integer(text)
    character(*), intent(in) :: text
    character(:), allocatable :: problem
    integer :: value
    call parse_integer(text, value, problem)
    is_integer = .not. allocated(problem)
  end function is_integer

  logical function integer_is(text, want)
    character(*), intent(in) :: text
    integer, intent(in) :: want
    character(:), allocatable :: problem
    integer :: value
    call parse_integer(text, value, problem)
    integer_is = .not. allocated(problem) .and. value == want
  end function integer_is

  logical function is_real(text)
    character(*), intent(in) :: text
    character(:), allocatable :: problem
    real(rp) :: value
    call parse_real(text, value, problem)
    is_real = .not. allocated(problem)
  end function is_real

  !> Equal to the last bit.
  logical function real_is(text, want)
    character(*), intent(in) :: text
    real(rp), intent(in) :: want
    character(:), allocatable :: problem
    real(rp) :: value
    call parse_real(text, value, problem)
    real_is = .not. allocated(problem) .and. transfer(value, 1_i8) == transfer(want, 1_i8)
  end function real_is
end program test_ini_text

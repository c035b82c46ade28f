! SPDX-License-Identifier: GPL-3.0-or-later
!> What is said about ends of a polish: equal ones, higher minima, and others that fit as well.
program test_train_ends
  use app_train_ends, only: end_lines, END_LENGTH
  use base_kinds, only: rp
  use testkit, only: testkit_t
  implicit none
  character(7), parameter :: NAMES(2) = [character(7) :: 'E', 'joint:a']
  real(rp), parameter :: BEST(2) = [23.0_rp, -9.0_rp], SD(2) = [0.1_rp, 2.0_rp], CHI2 = 100.0_rp
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_alone()
  call test_equal()
  call test_others()
  call t%finish()

contains

  subroutine test_alone()
    character(END_LENGTH), allocatable :: lines(:)
    lines = end_lines(NAMES, BEST, CHI2, SD, reshape([CHI2, BEST], [3, 1]))
    call t%check('about a single start nothing is said', size(lines) == 0)
  end subroutine test_alone

  !> Distances count in sd of each parameter: 0.4 and 0.45 of them are the same end.
  subroutine test_equal()
    character(END_LENGTH), allocatable :: lines(:)
    lines = end_lines(NAMES, BEST, CHI2, SD, &
                      reshape([CHI2, BEST, CHI2 + 50, 23.04_rp, -9.0_rp, CHI2, 23.0_rp, -9.9_rp], [3, 3]))
    call t%check('equal ends are counted, and nothing else is said', size(lines) == 1 .and. &
                 has(lines, 'polish    3 of 3 starts end at this point'))
  end subroutine test_equal

  !> The threshold of chi^2 is 2.7; 0.06 is 0.6 sd of the first parameter, 3 are 1.5 sd of the second.
  subroutine test_others()
    character(END_LENGTH), allocatable :: lines(:)
    lines = end_lines(NAMES, BEST, CHI2, SD, &
                      reshape([CHI2, BEST, CHI2 + 2.6_rp, 23.06_rp, -12.0_rp, CHI2 + 2.8_rp, 23.06_rp, -9.0_rp, &
                               CHI2, BEST], [3, 4]))
    call t%check('every other end has its line', size(lines) == 3)
    call t%check('one that fits as well is a warning with the parameter that differs most', &
                 has(lines, 'warning   another start ends where the data fit as well, 1.5 sd away in joint:a'))
    call t%check('one that does not is a higher minimum', &
                 has(lines, 'not the lowest: chi^2 = 1.0280E+02 against 1.0000E+02, first of all in E'))
    call t%check('the others agree', has(lines, '2 of 4 starts end at this point'))
  end subroutine test_others

  logical function has(lines, sentence)
    character(*), intent(in) :: lines(:), sentence
    integer :: i
    has = .false.
    do i = 1, size(lines)
      has = has .or. index(lines(i), sentence) > 0
    end do
  end function has
end program test_train_ends

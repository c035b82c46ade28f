! SPDX-License-Identifier: GPL-3.0-or-later
!> Numbers that are orders of magnitude off are doubted, and the unit in which they would be usual is named.
program test_magnitude
  use base_kinds, only: rp
  use base_magnitude, only: magnitude_doubt, rounded
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: RANGE = ', which have 1e7 to 1e11 Pa'
  type(testkit_t) :: t
  call t%start(parallel=.false.)
  call t%check('what is usual is not doubted', of(12.58e9_rp) == '' .and. of(1.0e7_rp) == '' .and. of(1.0e11_rp) == '')
  call t%check('GPa, not MPa, which are in the range, too', of(12.58_rp) == &
               '12.58 Pa is too small for veins'//RANGE//'; if the value is in GPa, write 12.58e9')
  call t%check('MPa', of(2.0e3_rp) == '2000.0 Pa is too small for veins'//RANGE//'; if the value is in MPa, write 2000.0e6')
  call t%check('a large one', of(1.258e14_rp) == '1.258e14 Pa is too large for veins'//RANGE// &
               '; if the value is in uPa, write 1.258e8')
  call t%check('no power of a thousand helps', of(1.0e22_rp) == '1e22 Pa is too large for veins'//RANGE)
  call t%check('nor for 0', of(0.0_rp) == '0.0 Pa is too small for veins'//RANGE)
  call t%check('units without prefixes', magnitude_doubt(1.3_rp, 100.0_rp, 1.0e4_rp, 'kg/m^3', 'veins', .false.) == &
               '1.3 kg/m^3 is too small for veins, which have 100.0 to 10000.0 kg/m^3; is the value in another '// &
               'unit? 1.3e3 would be usual')
  call t%check('masses have prefixes of grams', magnitude_doubt(81.0_rp, 3.0e-9_rp, 3.0e-6_rp, 'kg', 'membranes', .true.) == &
               '81.0 kg is too large for membranes, which have 3e-9 to 3e-6 kg; if the value is in ug, write 81.0e-9')
  call t%check('rounded numbers', all(abs(rounded([1.2345e-9_rp, 1.2345e12_rp, 0.996_rp, 0.0_rp], 2) - &
                                          [1.2e-9_rp, 1.2e12_rp, 1.0_rp, 0.0_rp]) <= 0))
  call t%finish()

contains

  function of(value) result(text)
    real(rp), intent(in) :: value
    character(:), allocatable :: text
    text = magnitude_doubt(value, 1.0e7_rp, 1.0e11_rp, 'Pa', 'veins', .true.)
  end function of
end program test_magnitude

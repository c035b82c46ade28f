! SPDX-License-Identifier: GPL-3.0-or-later
!> The checksum sees every bit and every place, and does not see how the work was split.
program test_checksum
  use base_checksum, only: checksum_reals, checksum_integers, checksum_text, checksum_add
  use base_crc32, only: crc32_t
  use base_kinds, only: rp, i8
  use, intrinsic :: iso_fortran_env, only: int8
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  real(rp) :: values(1000), changed(1000)
  integer(i8) :: whole, parts
  integer :: i, n_same

  call t%start(parallel=.false.)
  values = [(sin(real(i, rp)), i=1, 1000)]
  whole = checksum_reals(values, 5000000000_i8)
  parts = checksum_add(checksum_reals(values(701:), 5000000700_i8), checksum_reals(values(:700), &
                                                                                   5000000000_i8))
  call t%check('parts in any order add up to the whole', whole == parts)
  n_same = 0
  do i = 0, 63
    changed = values
    changed(17) = transfer(ieor(transfer(values(17), 0_i8), shiftl(1_i8, i)), 0.0_rp)
    if (checksum_reals(changed, 5000000000_i8) == whole) n_same = n_same + 1
  end do
  call t%check('every bit counts', n_same == 0)
  n_same = 0
  do i = 2, 1000
    changed = values
    changed([1, i]) = values([i, 1])
    if (checksum_reals(changed, 5000000000_i8) == whole) n_same = n_same + 1
  end do
  call t%check('exchanged numbers are seen', n_same == 0)
  call t%check('the position counts, in all its bits', checksum_reals(values, 705032704_i8) /= whole)
  changed = 0
  call t%check('zeros have a checksum that counts them', checksum_reals(changed, &
                                                                        0_i8) /= checksum_reals(changed(:999), 0_i8))
  call t%check('sums wrap at 2**64', checksum_add(-1_i8, 1_i8) == 0 .and. &
               checksum_add(huge(1_i8), 1_i8) == -huge(1_i8) - 1 .and. checksum_add(-5_i8, 3_i8) == -2)
  call t%check('texts: content and length count', checksum_text('ab') /= checksum_text('ba') .and. &
               checksum_text('ab') /= checksum_text('ab ') .and. checksum_text('') /= checksum_text(' '))
  call t%check('integers are words too', checksum_integers([transfer(1.5_rp, 0_i8)], &
                                                           3_i8) == checksum_reals([1.5_rp], 3_i8))
  call sum_of_bytes()
  call t%finish()

contains

  !> The check value of the standard, and of all bytes; Python's zlib.crc32 gives the same.
  subroutine sum_of_bytes()
    integer(int8), parameter :: DIGIT_CODES(9) = [(int(48 + i, int8), i=1, 9)]
    integer(int8) :: bytes(256)
    type(crc32_t) :: none, digit_sum, byte_sum
    bytes = [(int(i - merge(256, 0, i > 127), int8), i=0, 255)]
    call digit_sum%add(DIGIT_CODES(:4))
    call digit_sum%add(DIGIT_CODES(5:))
    call byte_sum%add(bytes)
    call t%check('CRC-32 of nothing, of 123456789 in parts, and of all bytes', none%value() == '00000000' .and. &
                 digit_sum%value() == 'cbf43926' .and. byte_sum%value() == '29058c73')
  end subroutine sum_of_bytes
end program test_checksum

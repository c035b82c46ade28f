! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes a 64-bit checksum of words at positions. It does not depend on the order in which ranks add their words.
!>
!> Every 64-bit word is scrambled together with its position by a four-round Feistel network (for a fixed position it is a
!> bijection, so that a changed word always changes its term), and the terms are added modulo 2**64. Ranks therefore sum their own
!> words and add up the sums. It detects damage, not malice.
module base_checksum
  use base_kinds, only: rp, i8
  implicit none
  private
  public :: checksum_reals, checksum_integers, checksum_text, checksum_add

  integer(i8), parameter :: LOW_HALF = int(z'FFFFFFFF', i8)
  ! Odd and below 2**31, so that a product with a 32-bit number stays below 2**63.
  integer(i8), parameter :: FACTOR(4) = [int(z'7FEB352D', i8), int(z'46CA6B6B', i8), &
                                         int(z'5F356495', i8), int(z'2C1B3C6D', i8)]

contains

  !> Returns the checksum of real words; `first` is the 0-based global position of the first one.
  pure integer(i8) function checksum_reals(values, first) result(total)
    real(rp), intent(in) :: values(:)
    integer(i8), intent(in) :: first
    integer(i8) :: i
    total = 0
    do i = 1, size(values, kind=i8)
      total = checksum_add(total, scrambled(transfer(values(i), 0_i8), first + i - 1))
    end do
  end function checksum_reals

  !> Returns the checksum of integer words; `first` is the 0-based global position of the first one.
  pure integer(i8) function checksum_integers(values, first) result(total)
    integer(i8), intent(in) :: values(:)
    integer(i8), intent(in) :: first
    integer(i8) :: i
    total = 0
    do i = 1, size(values, kind=i8)
      total = checksum_add(total, scrambled(values(i), first + i - 1))
    end do
  end function checksum_integers

  !> Returns the checksum of a text: its length, then its characters.
  pure integer(i8) function checksum_text(text) result(total)
    character(*), intent(in) :: text
    integer :: i
    total = scrambled(len(text, kind=i8), 0_i8)
    do i = 1, len(text)
      total = checksum_add(total, scrambled(int(ichar(text(i:i)), i8), int(i, i8)))
    end do
  end function checksum_text

  !> Returns a + b modulo 2**64. It adds halves, because an overflowing sum of Fortran integers is not defined.
  pure elemental integer(i8) function checksum_add(a, b) result(total)
    integer(i8), intent(in) :: a, b
    integer(i8) :: low, high
    low = iand(a, LOW_HALF) + iand(b, LOW_HALF)
    high = shiftr(a, 32) + shiftr(b, 32) + shiftr(low, 32)
    total = ior(shiftl(iand(high, LOW_HALF), 32), iand(low, LOW_HALF))
  end function checksum_add

  !> Returns the term that one word at one position adds to the checksum.
  pure elemental integer(i8) function scrambled(word, position)
    integer(i8), intent(in) :: word, position
    integer(i8) :: left, right, key, mixed
    integer :: round
    left = shiftr(word, 32)
    right = iand(word, LOW_HALF)
    do round = 1, 4
      key = merge(iand(position, LOW_HALF), shiftr(position, 32), mod(round, 2) == 1) + 16777619*round
      mixed = iand(iand(ieor(right, key), LOW_HALF)*FACTOR(round), LOW_HALF)
      mixed = ieor(mixed, shiftr(mixed, 15))
      key = ieor(left, mixed)
      left = right
      right = key
    end do
    scrambled = ior(shiftl(left, 32), right)
  end function scrambled
end module base_checksum

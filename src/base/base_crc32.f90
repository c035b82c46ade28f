! SPDX-License-Identifier: GPL-3.0-or-later
!> The checksum of bytes that gzip, PNG and Python's zlib.crc32 use (ISO 3309, polynomial EDB88320 reflected). It detects every
!> change of up to 32 neighbouring bits, and all but one in 2**32 of the other changes. It detects damage, not malice.
module base_crc32
  use, intrinsic :: iso_fortran_env, only: int8, int32
  implicit none
  private
  public :: crc32_t

  !> A checksum of all bytes that were added to it.
  type :: crc32_t
    private
    integer(int32) :: state = not(0_int32)
    integer(int32) :: table(0:255) = 0
    logical :: is_ready = .false.
  contains
    procedure :: add => crc32_add
    procedure :: value => crc32_value
  end type crc32_t

contains

  !> Adds the next bytes.
  pure subroutine crc32_add(self, bytes)
    class(crc32_t), intent(inout) :: self
    integer(int8), intent(in) :: bytes(:)
    integer :: i
    if (.not. self%is_ready) call fill(self)
    do i = 1, size(bytes)
      self%state = ieor(shiftr(self%state, 8), self%table(iand(ieor(self%state, int(bytes(i), int32)), 255_int32)))
    end do
  end subroutine crc32_add

  !> Fills the table of the remainders of all bytes.
  pure subroutine fill(self)
    class(crc32_t), intent(inout) :: self
    integer(int32), parameter :: POLYNOMIAL = not(int(z'12477CDF', int32)) ! EDB88320
    integer(int32) :: term
    integer :: i, bit
    do i = 0, 255
      term = int(i, int32)
      do bit = 1, 8
        term = merge(ieor(shiftr(term, 1), POLYNOMIAL), shiftr(term, 1), btest(term, 0))
      end do
      self%table(i) = term
    end do
    self%is_ready = .true.
  end subroutine fill

  !> Returns the sum as eight hexadecimal digits, in lower case.
  pure function crc32_value(self) result(digits)
    class(crc32_t), intent(in) :: self
    character(8) :: digits
    character(*), parameter :: DIGIT = '0123456789abcdef'
    integer :: i, place
    do i = 1, 8
      place = int(ibits(not(self%state), 32 - 4*i, 4)) + 1
      digits(i:i) = DIGIT(place:place)
    end do
  end function crc32_value
end module base_crc32

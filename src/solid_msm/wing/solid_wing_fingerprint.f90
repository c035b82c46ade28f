! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes a number that distinguishes wings. It depends on everything that affects bending: points, membrane, veins with their
!> diameters, joints and root. Titles, `z_side` and masses are not part of it, nor is the layout of the file.
module solid_wing_fingerprint
  use base_checksum, only: checksum_add, checksum_integers, checksum_reals, checksum_text
  use base_kinds, only: i8, rp
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_fingerprint, FINGERPRINT_LENGTH

  integer, parameter :: FINGERPRINT_LENGTH = 16 !< hexadecimal digits

contains

  !> Returns 16 hexadecimal digits, the same for the same wing on every machine. `wing` must have the coordinates of its file,
  !> without scaling. Different wings have the same digits in one of 2**64 cases.
  function wing_fingerprint(wing) result(text)
    type(wing_t), intent(in) :: wing
    character(FINGERPRINT_LENGTH) :: text
    integer(i8) :: total, place
    integer :: i
    total = 0
    place = 0
    call add_reals(reshape(wing%points, [size(wing%points)]))
    call add_integers(reshape(wing%triangles, [size(wing%triangles)]))
    if (size(wing%triangles) == 0) call add_reals(wing%plane_normal)
    do i = 1, size(wing%veins)
      call add_text(wing%veins(i)%name)
      call add_integers(wing%veins(i)%nodes)
      call add_reals(wing%veins(i)%diameters)
    end do
    do i = 1, size(wing%joints)
      call add_text(wing%joints(i)%name)
      call add_integers(wing%joints(i)%nodes)
    end do
    call add_integers(wing%root)
    write (text, '(z16.16)') total

  contains

    !> Adds a list to the checksum, with its length first, so that two lists cannot be mistaken for one.
    subroutine add_words(n, checksum)
      integer, intent(in) :: n
      integer(i8), intent(in) :: checksum
      total = checksum_add(checksum_add(total, checksum_integers([int(n, i8)], place)), checksum)
      place = place + 1 + n
    end subroutine add_words

    subroutine add_reals(values)
      real(rp), intent(in) :: values(:)
      call add_words(size(values), checksum_reals(values + 0.0_rp, place + 1)) ! + 0: there is one zero
    end subroutine add_reals

    subroutine add_integers(values)
      integer, intent(in) :: values(:)
      call add_words(size(values), checksum_integers(int(values, i8), place + 1))
    end subroutine add_integers

    subroutine add_text(word)
      character(*), intent(in) :: word
      call add_words(1, checksum_integers([checksum_text(word)], place + 1))
    end subroutine add_text
  end function wing_fingerprint
end module solid_wing_fingerprint

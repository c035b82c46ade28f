! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes a number that distinguishes wings. It depends on everything that affects bending: points, membrane, veins with their
!> diameters, joints and root. Titles, `z_side` and masses are not part of it, nor is the layout of the file.
module solid_wing_fingerprint
  use base_checksum, only: checksum_add, checksum_integers, checksum_reals, checksum_text
  use base_fingerprint, only: fingerprint_t
  use base_kinds, only: i8, rp
  use base_text, only: number_text
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
    type(wing_t) :: visited
    type(fingerprint_t) :: entries
    integer(i8) :: total, place
    integer :: i
    visited = wing
    call visited%visit(entries)
    call entries%omit('z_side')
    call entries%omit_part('mass')
    total = 0
    place = 0
    call add_reals('points')
    call add_integers('triangles')
    if (size(wing%triangles) == 0) call add_reals('plane_normal')
    call entries%omit('plane_normal')
    do i = 1, size(wing%veins)
      call add_text('veins_'//number_text(i)//'_name')
      call add_integers('veins_'//number_text(i)//'_nodes')
      call add_reals('veins_'//number_text(i)//'_diameters')
    end do
    do i = 1, size(wing%joints)
      call add_text('joints_'//number_text(i)//'_name')
      call add_integers('joints_'//number_text(i)//'_nodes')
    end do
    call add_integers('root')
    total = checksum_add(total, entries%rest())
    write (text, '(z16.16)') total

  contains

    !> Adds a list to the checksum, with its length first, so that two lists cannot be mistaken for one.
    subroutine add_words(n, checksum)
      integer, intent(in) :: n
      integer(i8), intent(in) :: checksum
      total = checksum_add(checksum_add(total, checksum_integers([int(n, i8)], place)), checksum)
      place = place + 1 + n
    end subroutine add_words

    subroutine add_reals(name)
      character(*), intent(in) :: name
      real(rp), allocatable :: values(:)
      values = entries%numbers(name)
      call add_words(size(values), checksum_reals(values + 0.0_rp, place + 1)) ! + 0: there is one zero
    end subroutine add_reals

    subroutine add_integers(name)
      character(*), intent(in) :: name
      integer(i8), allocatable :: values(:)
      values = nint(entries%numbers(name), i8)
      call add_words(size(values), checksum_integers(values, place + 1))
    end subroutine add_integers

    subroutine add_text(name)
      character(*), intent(in) :: name
      call add_words(1, checksum_integers([checksum_text(entries%text(name))], place + 1))
    end subroutine add_text
  end function wing_fingerprint
end module solid_wing_fingerprint

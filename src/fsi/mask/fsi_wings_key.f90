! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads [Insects] wings, which says whether the flow bends the wings.
module fsi_wings_key
  use base_named_kinds, only: named_kind_t
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  implicit none
  private
  public :: wings_key, has_flexible_wings, says_rigid_wings

  character(*), parameter :: SECTION = 'Insects'

  integer, parameter :: WINGS_RIGID = 1, WINGS_FLEXIBLE = 2
  type(named_kind_t), parameter :: WINGS_ARE(2) = [named_kind_t('rigid', WINGS_RIGID), named_kind_t('flexible', WINGS_FLEXIBLE)]

contains

  !> Declares and reads the last key of [Insects], the present section of `keys`, which says whether wings bend.
  subroutine wings_key(keys, wings, given)
    type(keys_t), intent(in) :: keys
    integer, intent(inout) :: wings !< WINGS_*
    logical, intent(inout), optional :: given
    call keys%kind('wings', wings, 'rigid', WINGS_ARE, 'flexible: the wing of [Wing], which the flow bends', given=given)
  end subroutine wings_key

  !> Tells whether [Insects] requests flexible wings.
  logical function has_flexible_wings(config) result(has)
    type(config_t), intent(in) :: config
    integer :: wings
    logical :: is_given
    call read_wings(config, wings, is_given)
    has = wings == WINGS_FLEXIBLE
  end function has_flexible_wings

  !> Tells whether [Insects] says that the wings are rigid; if it says nothing, another section may ask for flexible ones.
  logical function says_rigid_wings(config) result(says)
    type(config_t), intent(in) :: config
    integer :: wings
    call read_wings(config, wings, says)
    says = says .and. wings == WINGS_RIGID
  end function says_rigid_wings

  !> Returns what the wings are, WINGS_*, and whether the user says so.
  subroutine read_wings(config, wings, is_given)
    type(config_t), intent(in), target :: config
    integer, intent(out) :: wings
    logical, intent(out) :: is_given
    type(keys_t) :: keys
    wings = WINGS_RIGID
    is_given = .false.
    keys = reading(config)
    call keys%section(SECTION)
    call wings_key(keys, wings, is_given)
  end subroutine read_wings
end module fsi_wings_key

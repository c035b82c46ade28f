! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives a value of any visited type to all ranks.
module parallel_broadcast
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_packing, only: pack_value, unpack_value
  use base_visitor, only: visited_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: broadcast_value

contains

  !> Gives the value of rank 0 to all ranks. On the other ranks `value` must be on entry as it was declared. Collective.
  subroutine broadcast_value(world, value)
    type(world_t), intent(in) :: world
    class(visited_t), intent(inout) :: value
    real(rp), allocatable :: words(:)
    type(failure_t) :: failure
    integer :: n
    n = 0
    if (world%is_root) then
      call pack_value(value, words)
      n = size(words)
    end if
    call world%broadcast_integer(n)
    if (.not. world%is_root) allocate (words(n))
    call world%broadcast_reals(words)
    if (world%is_root) return
    call unpack_value(words, value, failure)
    if (failure%failed) call require(.false., 'parallel_broadcast: '//failure%reason)
  end subroutine broadcast_value
end module parallel_broadcast

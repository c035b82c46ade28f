! SPDX-License-Identifier: GPL-3.0-or-later
!> Tells all ranks what failed on one.
module parallel_failure
  use base_errors, only: failure_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: broadcast_failure

contains

  !> Raises on all ranks what `own` says on rank 0; on the other ranks `own` does not count. Collective.
  subroutine broadcast_failure(world, own, failure)
    type(world_t), intent(in) :: world
    type(failure_t), intent(in) :: own
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: reason
    reason = ''
    if (own%failed) reason = own%reason
    call world%broadcast_text(reason)
    if (reason /= '') call failure%raise(reason)
  end subroutine broadcast_failure
end module parallel_failure

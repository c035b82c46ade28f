! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the planes that a pipeline needs. If its kernels need some lines only, planes beyond all of these lines are neither sent
!> between ranks nor transformed. Each column of ranks keeps the planes from its first to its last that has such a line.
module spectral_pencil_planes
  use base_kinds, only: rp
  use parallel_block, only: block_t
  use parallel_world, only: world_t
  use spectral_pencil_stages, only: stages_t
  use spectral_transform, only: kernels_t
  implicit none
  private
  public :: is_wanted, leave_out_planes

contains

  !> Tells whether any of the lines first .. first+count-1 of plane z is wanted.
  pure logical function is_wanted(kernels, first, count, z)
    class(kernels_t), intent(in) :: kernels
    integer, intent(in) :: first, count, z
    is_wanted = .true.
    if (associated(kernels%lines)) is_wanted = any(kernels%lines(first:first + count - 1, z))
  end function is_wanted

  !> Removes planes without a wanted line, on any rank of a column, from both ends of the planes of `stages`, which must be all
  !> planes. Collective if only some lines are wanted.
  subroutine leave_out_planes(world, block, kernels, stages, column)
    type(world_t), intent(in) :: world
    type(block_t), intent(in) :: block
    class(kernels_t), intent(in) :: kernels
    type(stages_t), intent(inout) :: stages
    integer, intent(in) :: column !< number of this rank's column, from 0
    real(rp) :: reach(0:2*size(stages%z_count) - 1) !< planes up to the last, and down to the first, of each column
    integer :: z, q, low, high
    if (.not. associated(kernels%lines)) return
    reach = 0
    do z = 1, block%count(3)
      if (.not. is_wanted(kernels, 1, block%count(2), z)) cycle
      reach(2*column) = z
      reach(2*column + 1) = max(reach(2*column + 1), real(block%count(3) + 1 - z, rp))
    end do
    call world%max_reals(reach)
    do q = 0, size(stages%z_count) - 1
      high = nint(reach(2*q))
      low = min(stages%z_count(q) + 1 - nint(reach(2*q + 1)), high + 1)
      stages%z_start(q) = stages%z_start(q) + low - 1
      stages%z_count(q) = high - low + 1
    end do
  end subroutine leave_out_planes
end module spectral_pencil_planes

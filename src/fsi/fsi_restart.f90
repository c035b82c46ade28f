! SPDX-License-Identifier: GPL-3.0-or-later
!> The flexible wings' part of a checkpoint: their whole motion, double precision.
module fsi_restart
  use base_errors, only: failure_t
  use base_kinds, only: i8
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use solid_restart, only: load_motion, save_motion, wing_mark
  implicit none
  private
  public :: save_wings, load_wings, has_flexible_wings

contains

  !> Puts the states of the wings into an open checkpoint. Collective.
  subroutine save_wings(writer, wings, coupler)
    type(checkpoint_writer_t), intent(inout) :: writer
    type(flapping_wings_t), intent(in) :: wings
    type(coupler_t), intent(in) :: coupler
    character(:), allocatable :: side
    integer :: i
    call writer%put_integer('wing_mesh', wing_mark(coupler%params%model))
    do i = 1, size(coupler%states)
      side = trim(wings%params%wings(i)%side)//'_'
      call save_motion(writer, side, coupler%states(i))
    end do
  end subroutine save_wings

  !> Restores the states and gives the deformation to `wings`. Fails if the checkpoint has no flexible wings or
  !> others. Collective.
  subroutine load_wings(reader, wings, coupler, failure)
    type(checkpoint_reader_t), intent(inout) :: reader
    type(flapping_wings_t), intent(inout) :: wings
    type(coupler_t), intent(inout) :: coupler
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: side
    integer(i8) :: mesh
    integer :: i
    if (.not. has_flexible_wings(reader)) then
      call failure%raise('the checkpoint has no flexible wings')
      return
    end if
    call reader%get_integer('wing_mesh', mesh, failure)
    if (.not. failure%failed .and. mesh /= wing_mark(coupler%params%model)) &
      call failure%raise('the checkpoint has other wings')
    do i = 1, size(coupler%states)
      side = trim(wings%params%wings(i)%side)//'_'
      call load_motion(reader, side, coupler%states(i), failure)
    end do
    if (.not. failure%failed) call coupler%deform(wings)
  end subroutine load_wings

  !> Whether an open checkpoint holds flexible wings.
  logical function has_flexible_wings(reader)
    type(checkpoint_reader_t), intent(inout) :: reader
    has_flexible_wings = reader%has('wing_mesh')
  end function has_flexible_wings
end module fsi_restart

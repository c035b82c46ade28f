! SPDX-License-Identifier: GPL-3.0-or-later
!> The flexible wings' part of a checkpoint: their whole motion, double precision.
module fsi_restart
  use base_checksum, only: checksum_reals
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
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
    call writer%put_integer('wing_mesh', checksum_reals([coupler%params%model%points], 0_i8))
    do i = 1, size(coupler%states)
      side = trim(wings%params%wings(i)%side)//'_'
      associate (state => coupler%states(i))
        call writer%put_reals(side//'times', [state%time, state%old_step])
        call writer%put_reals(side//'u', [state%u])
        call writer%put_reals(side//'v', [state%v])
        call writer%put_reals(side//'g', [state%g])
        call writer%put_reals(side//'old_u', [state%old_u])
        call writer%put_reals(side//'old_v', [state%old_v])
        call writer%put_reals(side//'old_g', [state%old_g])
      end associate
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
    real(rp) :: times(2, 1)
    integer(i8) :: mesh
    integer :: i
    if (.not. has_flexible_wings(reader)) then
      call failure%raise('the checkpoint has no flexible wings')
      return
    end if
    call reader%get_integer('wing_mesh', mesh, failure)
    if (.not. failure%failed .and. mesh /= checksum_reals([coupler%params%model%points], 0_i8)) &
      call failure%raise('the checkpoint has other wings')
    do i = 1, size(coupler%states)
      side = trim(wings%params%wings(i)%side)//'_'
      associate (state => coupler%states(i))
        call get('times', times)
        state%time = times(1, 1)
        state%old_step = times(2, 1)
        call get('u', state%u)
        call get('v', state%v)
        call get('g', state%g)
        call get('old_u', state%old_u)
        call get('old_v', state%old_v)
        call get('old_g', state%old_g)
      end associate
    end do
    if (.not. failure%failed) call coupler%deform(wings)

  contains

    subroutine get(name, values)
      character(*), intent(in) :: name
      real(rp), intent(inout) :: values(:, :)
      real(rp), allocatable :: flat(:)
      if (failure%failed) return
      call reader%get_reals(side//name, flat, failure)
      if (failure%failed) return
      if (size(flat) /= size(values)) then
        call failure%raise('the checkpoint has another number of points')
      else
        values(:, :) = reshape(flat, shape(values))
      end if
    end subroutine get
  end subroutine load_wings

  !> Whether an open checkpoint holds flexible wings.
  logical function has_flexible_wings(reader)
    type(checkpoint_reader_t), intent(inout) :: reader
    has_flexible_wings = reader%has('wing_mesh')
  end function has_flexible_wings
end module fsi_restart

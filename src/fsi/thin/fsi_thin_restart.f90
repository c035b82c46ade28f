! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves and loads the part of a checkpoint that belongs to wings without thickness: the forces of their markers and the loads
!> in the last step, which the records at its end need, and the shapes for which the response of the flow was made.
module fsi_thin_restart
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_thin_wings, only: thin_wings_t
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  implicit none
  private
  public :: save_thin_wings, load_thin_wings, has_thin_wings

  integer, parameter :: N_LOAD = 7 !< numbers of a load: force, moment, power

contains

  !> Puts forces and loads into an open checkpoint. Collective.
  subroutine save_thin_wings(writer, wings, thin)
    type(checkpoint_writer_t), intent(inout) :: writer
    type(flapping_wings_t), intent(in) :: wings
    type(thin_wings_t), intent(in) :: thin
    integer :: i
    call writer%put_reals('marker_forces', [thin%force])
    call writer%put_reals('marker_slip', [thin%slip%before, thin%slip%after, thin%slip%speed, thin%slip%received, &
                                           real(thin%slip%iterations, rp), thin%slip%left])
    call writer%put_reals('marker_shape', [(thin%wings(i)%shape, i=1, size(thin%wings))])
    call writer%put_reals('marker_loads', [(wings%marker_loads(i)%force, wings%marker_loads(i)%moment, &
                                            wings%marker_loads(i)%power, i=1, size(wings%marker_loads))])
  end subroutine save_thin_wings

  !> Restores forces, loads and responses. Fails if the checkpoint has no wings without thickness, or different ones. Collective.
  subroutine load_thin_wings(reader, wings, thin, failure)
    type(checkpoint_reader_t), intent(inout) :: reader
    type(flapping_wings_t), intent(inout) :: wings
    type(thin_wings_t), intent(inout) :: thin
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: numbers(:)
    integer :: i
    logical :: has_factor(size(thin%wings))
    if (.not. has_thin_wings(reader)) then
      call failure%raise('the checkpoint has no wings without thickness: set [Insects] surface as in the run that wrote it')
      return
    end if
    call reader%get_reals('marker_forces', numbers, failure)
    if (failure%failed) return
    if (size(numbers) /= size(thin%force)) then
      call failure%raise('the checkpoint has another number of markers: set the wings and [Insects] marker_spacing as in the '// &
                         'run that wrote it')
      return
    end if
    thin%force = reshape(numbers, shape(thin%force))
    call reader%get_reals('marker_slip', numbers, failure)
    if (failure%failed) return
    thin%slip%before = numbers(1)
    thin%slip%after = numbers(2)
    thin%slip%speed = numbers(3)
    thin%slip%received = numbers(4)
    thin%slip%iterations = nint(numbers(5))
    thin%slip%left = numbers(6)
    call reader%get_reals('marker_shape', numbers, failure)
    if (failure%failed) return
    do i = 1, size(thin%wings)
      associate (wing => thin%wings(i))
        wing%shape = reshape(numbers(3*wing%first - 2:3*wing%last), shape(wing%shape))
      end associate
    end do
    call thin%rebuild_responses([(.true., i=1, size(thin%wings))], has_factor)
    if (.not. all(has_factor)) call failure%raise('the markers of the checkpoint touch each other: give an earlier checkpoint')
    call reader%get_reals('marker_loads', numbers, failure)
    if (failure%failed) return
    do i = 1, size(wings%marker_loads)
      associate (load => wings%marker_loads(i), first => N_LOAD*(i - 1))
        load%force = numbers(first + 1:first + 3)
        load%moment = numbers(first + 4:first + 6)
        load%power = numbers(first + 7)
      end associate
    end do
  end subroutine load_thin_wings

  !> Tells whether an open checkpoint holds wings without thickness.
  logical function has_thin_wings(reader)
    type(checkpoint_reader_t), intent(inout) :: reader
    has_thin_wings = reader%has('marker_forces')
  end function has_thin_wings
end module fsi_thin_restart

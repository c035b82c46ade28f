! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves and loads the part of a checkpoint that belongs to wings without thickness: the forces and velocities of their markers and
!> the loads in the last step, which the next step and the records need, and the shapes for which the response of the flow was made.
module fsi_thin_restart
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use base_text, only: number_text
  use base_visitor, only: visitor_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_thin_wing, only: thin_wing_t
  use fsi_thin_wings, only: thin_wings_t
  use fsi_wing_mirror, only: mirror_vectors
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use io_checkpoint_values, only: checkpoint_loader_t, checkpoint_saver_t
  implicit none
  private
  public :: save_thin_wings, mark_without_markers, load_thin_wings, has_thin_wings

  character(*), parameter :: PREFIX = 'marker_'
  character(*), parameter :: EARLIER = 'marker_slip' !< a table that only earlier versions write
  character(*), parameter :: WITHOUT = 'markers_are_unknown' !< mark of a checkpoint after a step that failed
  character(*), parameter :: LATEST = 'marker_velocities' !< numbers that earlier versions do not write

contains

  !> Puts forces and loads into an open checkpoint. Collective.
  subroutine save_thin_wings(writer, wings, thin)
    type(checkpoint_writer_t), intent(inout), target :: writer
    type(flapping_wings_t), intent(inout) :: wings !< they stay as they are
    type(thin_wings_t), intent(inout) :: thin      !< the same
    type(checkpoint_saver_t) :: saver
    integer :: i
    call writer%put_reals('marker_forces', [thin%force])
    call writer%put_reals('marker_velocities', [thin%u_before])
    call writer%put_reals('marker_shape', [(thin%wings(i)%shape, i=1, size(thin%wings))])
    call writer%put_reals('marker_last_forces', [(along_frame(thin%wings(i)), i=1, size(thin%wings))])
    call saver%begin(writer, PREFIX)
    call visit_step(saver, wings, thin)
  end subroutine save_thin_wings

  !> Marks an open checkpoint of wings without thickness whose markers do not belong to a whole step: a run that continues from it
  !> begins with markers without forces, as a new run does. Collective.
  subroutine mark_without_markers(writer)
    type(checkpoint_writer_t), intent(inout) :: writer
    call writer%put_integer(WITHOUT, 1_i8)
  end subroutine mark_without_markers

  !> Returns the last forces of a wing along its frame (3, n), or, with `given` forces along the frame, along the axes of its file.
  pure function along_frame(wing, given) result(force)
    type(thin_wing_t), intent(in) :: wing
    real(rp), intent(in), optional :: given(:)
    real(rp) :: force(3, wing%markers%n)
    force = wing%last_force
    if (present(given)) force = reshape(given, shape(force))
    if (wing%is_mirrored) call mirror_vectors(force)
  end function along_frame

  !> Shows the slip and the loads of the last step to the visitor.
  subroutine visit_step(visitor, wings, thin)
    class(visitor_t), intent(inout) :: visitor
    type(flapping_wings_t), intent(inout) :: wings
    type(thin_wings_t), intent(inout) :: thin
    integer :: i
    call visitor%visit('slip', thin%slip)
    do i = 1, size(wings%marker_loads)
      call visitor%visit('loads_'//number_text(i), wings%marker_loads(i))
    end do
  end subroutine visit_step

  !> Restores forces, loads and responses; they stay as they are if the checkpoint is marked. Fails if the
  !> checkpoint has no wings without thickness, or different ones. Collective.
  subroutine load_thin_wings(reader, wings, thin, failure)
    type(checkpoint_reader_t), intent(inout), target :: reader
    type(flapping_wings_t), intent(inout) :: wings
    type(thin_wings_t), intent(inout) :: thin
    type(failure_t), intent(inout) :: failure
    type(checkpoint_loader_t) :: loader
    real(rp), allocatable :: numbers(:)
    integer :: i
    logical :: has_factor(size(thin%wings))
    if (reader%has(WITHOUT)) return
    if (.not. has_thin_wings(reader)) then
      call failure%raise('the checkpoint has no wings without thickness: set [Insects] surface as in the run that wrote '// &
                         'it, or it is a failed_backup.h5 of an earlier version: give a periodic backup')
      return
    else if (reader%has(EARLIER) .or. .not. reader%has(LATEST)) then
      call failure%raise('an earlier version of flusi-msm wrote the wings without thickness of the checkpoint: restart with '// &
                         'that version, or begin the run again')
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
    call reader%get_reals('marker_velocities', numbers, failure)
    if (failure%failed) return
    thin%u_before = reshape(numbers, shape(thin%u))
    thin%u = thin%u_before
    call reader%get_reals('marker_shape', numbers, failure)
    if (failure%failed) return
    do i = 1, size(thin%wings)
      associate (wing => thin%wings(i))
        wing%shape = reshape(numbers(3*wing%first - 2:3*wing%last), shape(wing%shape))
      end associate
    end do
    call reader%get_reals('marker_last_forces', numbers, failure)
    if (failure%failed) return
    do i = 1, size(thin%wings)
      associate (wing => thin%wings(i))
        wing%last_force = along_frame(wing, numbers(3*wing%first - 2:3*wing%last))
      end associate
    end do
    call thin%rebuild_responses([(.true., i=1, size(thin%wings))], has_factor)
    if (.not. all(has_factor)) call failure%raise('the markers of the checkpoint touch each other: give an earlier checkpoint')
    call loader%begin(reader, PREFIX)
    call visit_step(loader, wings, thin)
    if (loader%failure%failed) call failure%raise(loader%failure%reason)
  end subroutine load_thin_wings

  !> Tells whether an open checkpoint is one of wings without thickness, with or without the state of their markers.
  logical function has_thin_wings(reader)
    type(checkpoint_reader_t), intent(inout) :: reader
    has_thin_wings = reader%has('marker_forces') .or. reader%has(WITHOUT)
  end function has_thin_wings
end module fsi_thin_restart

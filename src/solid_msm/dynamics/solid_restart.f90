! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves and loads the motion of a wing in a checkpoint: all of `dynamic_state_t`, double precision.
module solid_restart
  use base_checksum, only: checksum_reals
  use base_errors, only: failure_t
  use base_kinds, only: i8
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use io_checkpoint_values, only: checkpoint_loader_t, checkpoint_saver_t
  use solid_dynamics, only: dynamic_state_t
  use solid_model, only: solid_model_t
  implicit none
  private
  public :: save_motion, load_motion, points_fingerprint

contains

  !> Puts the state into an open checkpoint, under names that begin with `prefix`. Collective.
  subroutine save_motion(writer, prefix, state)
    type(checkpoint_writer_t), intent(inout), target :: writer
    character(*), intent(in) :: prefix
    type(dynamic_state_t), intent(inout) :: state !< stays as it is
    type(checkpoint_saver_t) :: saver
    call saver%begin(writer, prefix)
    call state%visit(saver)
  end subroutine save_motion

  !> Restores an initialised state from an open checkpoint. Fails if it has another number of points. Collective.
  subroutine load_motion(reader, prefix, state, failure)
    type(checkpoint_reader_t), intent(inout), target :: reader
    character(*), intent(in) :: prefix
    type(dynamic_state_t), intent(inout) :: state
    type(failure_t), intent(inout) :: failure
    type(checkpoint_loader_t) :: loader
    if (failure%failed) return
    call loader%begin(reader, prefix)
    call state%visit(loader)
    if (loader%failure%failed) call failure%raise('the motion of the wing does not fit: '//loader%failure%reason)
  end subroutine load_motion

  !> Returns a number that distinguishes wings by their unloaded points.
  integer(i8) function points_fingerprint(model) result(mark)
    type(solid_model_t), intent(in) :: model
    mark = checksum_reals([model%points], 0_i8)
  end function points_fingerprint
end module solid_restart

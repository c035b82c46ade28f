! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes and reads the checkpoint of `flusi --solid`: the motion of the wing, the number of steps and the work done. A
!> checkpoint belongs to one wing; the time step, stiffness, motion and loads may change at a restart. Vectors have components
!> along the frame of the wing that moves, as in checkpoints of flights.
module flusi_solid_restart
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use base_packing, only: count_packed, pack_value, unpack_value
  use fsi_wing_mirror, only: mirror_state
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use solid_balance, only: work_t
  use solid_dynamics, only: dynamic_state_t
  use solid_model, only: solid_model_t
  use solid_restart, only: load_motion, save_motion, points_fingerprint
  implicit none
  private
  public :: save_solid, load_solid

  character(*), parameter :: SCHEMA = 'flusi-msm wing in motion'

contains

  !> Writes the state, the number `step` of steps and the `work` into an open checkpoint. Collective.
  subroutine save_solid(writer, model, is_mirrored, state, step, work)
    type(checkpoint_writer_t), intent(inout) :: writer
    type(solid_model_t), intent(in) :: model
    logical, intent(in) :: is_mirrored !< the wing that moves is the mirror image of the one in the file
    type(dynamic_state_t), intent(in) :: state
    integer, intent(in) :: step
    type(work_t), intent(in) :: work
    type(dynamic_state_t) :: moving
    type(work_t) :: sums
    real(rp), allocatable :: numbers(:)
    call writer%put_text('schema', SCHEMA)
    call writer%put_integer('wing', points_fingerprint(model))
    call writer%put_integer('step', int(step, i8))
    sums = work
    call pack_value(sums, numbers)
    call writer%put_reals('work', numbers)
    moving = state
    if (is_mirrored) call mirror_state(moving)
    call save_motion(writer, '', moving)
  end subroutine save_solid

  !> Restores `state`, which must be initialised, with `step` and `work` from an open checkpoint. Fails if the checkpoint
  !> belongs to another kind of run or to another wing. Collective.
  subroutine load_solid(reader, model, is_mirrored, state, step, work, failure)
    type(checkpoint_reader_t), intent(inout) :: reader
    type(solid_model_t), intent(in) :: model
    logical, intent(in) :: is_mirrored
    type(dynamic_state_t), intent(inout) :: state
    integer, intent(out) :: step
    type(work_t), intent(inout) :: work
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: text
    real(rp), allocatable :: numbers(:)
    integer(i8) :: number
    step = 0
    text = ''
    if (reader%has('schema')) call reader%get_text('schema', text, failure)
    if (.not. failure%failed .and. text /= SCHEMA) &
      call failure%raise('the checkpoint was not written by flusi --solid: give a checkpoint of flusi --solid')
    if (failure%failed) return
    call reader%get_integer('wing', number, failure)
    if (.not. failure%failed .and. number /= points_fingerprint(model)) &
      call failure%raise('the checkpoint belongs to another wing: give the [Wing] file of the run that wrote it')
    call reader%get_integer('step', number, failure)
    step = int(number)
    call reader%get_reals('work', numbers, failure)
    if (failure%failed) return
    if (size(numbers) /= count_packed(work)) &
      call failure%raise('the checkpoint is not complete, because it has no energy balance: give another checkpoint')
    call unpack_value(numbers, work, failure)
    if (failure%failed) return
    call load_motion(reader, '', state, failure)
    if (is_mirrored) call mirror_state(state)
  end subroutine load_solid
end module flusi_solid_restart

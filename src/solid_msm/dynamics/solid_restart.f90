! SPDX-License-Identifier: GPL-3.0-or-later
!> The motion of a wing in a checkpoint: all of `dynamic_state_t`, double precision.
module solid_restart
  use base_checksum, only: checksum_reals
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use solid_dynamics, only: dynamic_state_t
  use solid_model, only: solid_model_t
  implicit none
  private
  public :: save_motion, load_motion, points_fingerprint

contains

  !> Puts the state into an open checkpoint, under names that begin with `prefix`. Collective.
  subroutine save_motion(writer, prefix, state)
    type(checkpoint_writer_t), intent(inout) :: writer
    character(*), intent(in) :: prefix
    type(dynamic_state_t), intent(in) :: state
    call writer%put_real(prefix//'time', state%time)
    call writer%put_real(prefix//'old_step', state%old_step)
    call writer%put_reals(prefix//'u', [state%u])
    call writer%put_reals(prefix//'v', [state%v])
    call writer%put_reals(prefix//'g', [state%g])
    call writer%put_reals(prefix//'old_u', [state%old_u])
    call writer%put_reals(prefix//'old_v', [state%old_v])
    call writer%put_reals(prefix//'old_g', [state%old_g])
    call writer%put_reals(prefix//'a', [state%a])
  end subroutine save_motion

  !> Restores an initialised state from an open checkpoint. Fails if it has another number of points. Collective.
  subroutine load_motion(reader, prefix, state, failure)
    type(checkpoint_reader_t), intent(inout) :: reader
    character(*), intent(in) :: prefix
    type(dynamic_state_t), intent(inout) :: state
    type(failure_t), intent(inout) :: failure
    call reader%get_real(prefix//'time', state%time, failure)
    call reader%get_real(prefix//'old_step', state%old_step, failure)
    call get('u', state%u)
    call get('v', state%v)
    call get('g', state%g)
    call get('old_u', state%old_u)
    call get('old_v', state%old_v)
    call get('old_g', state%old_g)
    call get('a', state%a)

  contains

    subroutine get(name, values)
      character(*), intent(in) :: name
      real(rp), intent(inout) :: values(:, :)
      real(rp), allocatable :: flat(:)
      if (failure%failed) return
      call reader%get_reals(prefix//name, flat, failure)
      if (failure%failed) return
      if (size(flat) /= size(values)) then
        call failure%raise('the checkpoint has another number of points')
      else
        values(:, :) = reshape(flat, shape(values))
      end if
    end subroutine get
  end subroutine load_motion

  !> A number that tells wings apart: by their unloaded points.
  integer(i8) function points_fingerprint(model) result(mark)
    type(solid_model_t), intent(in) :: model
    mark = checksum_reals([model%points], 0_i8)
  end function points_fingerprint
end module solid_restart

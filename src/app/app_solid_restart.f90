! SPDX-License-Identifier: GPL-3.0-or-later
!> The checkpoint of `flusi --solid`: motion of the wing, steps made, work done. It belongs to one wing; time
!> step, stiffness, motion and loads may change at a restart.
module app_solid_restart
  use base_checksum, only: checksum_reals
  use base_errors, only: failure_t
  use base_kinds, only: rp, i8
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use solid_balance, only: work_t
  use solid_dynamics, only: dynamic_state_t
  use solid_model, only: solid_model_t
  implicit none
  private
  public :: save_solid, load_solid

  character(*), parameter :: SCHEMA = 'flusi-msm wing in motion'

contains

  !> Puts the state into an open checkpoint. Collective.
  subroutine save_solid(writer, model, state, step, work)
    type(checkpoint_writer_t), intent(inout) :: writer
    type(solid_model_t), intent(in) :: model
    type(dynamic_state_t), intent(in) :: state
    integer, intent(in) :: step
    type(work_t), intent(in) :: work
    call writer%put_text('schema', SCHEMA)
    call writer%put_integer('wing', wing_mark(model))
    call writer%put_integer('step', int(step, i8))
    call writer%put_real('time', state%time)
    call writer%put_real('old_step', state%old_step)
    call writer%put_reals('work', [work%start, work%loads, work%weight, work%frame, work%damped])
    call put('u', state%u)
    call put('v', state%v)
    call put('g', state%g)
    call put('old_u', state%old_u)
    call put('old_v', state%old_v)
    call put('old_g', state%old_g)

  contains

    subroutine put(name, values)
      character(*), intent(in) :: name
      real(rp), intent(in) :: values(:, :)
      call writer%put_reals(name, [values])
    end subroutine put
  end subroutine save_solid

  !> Restores an initialised state from an open checkpoint. Fails if it belongs to something else. Collective.
  subroutine load_solid(reader, model, state, step, work, failure)
    type(checkpoint_reader_t), intent(inout) :: reader
    type(solid_model_t), intent(in) :: model
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
      call failure%raise('the checkpoint is not one of a wing without a fluid')
    if (failure%failed) return
    call reader%get_integer('wing', number, failure)
    if (.not. failure%failed .and. number /= wing_mark(model)) &
      call failure%raise('the checkpoint belongs to another wing')
    call reader%get_integer('step', number, failure)
    step = int(number)
    call reader%get_real('time', state%time, failure)
    call reader%get_real('old_step', state%old_step, failure)
    call reader%get_reals('work', numbers, failure)
    if (failure%failed) return
    if (size(numbers) /= 5) then
      call failure%raise('the checkpoint has no complete energy balance')
      return
    end if
    work = work_t(start=numbers(1), loads=numbers(2), weight=numbers(3), frame=numbers(4), damped=numbers(5))
    call get('u', state%u)
    call get('v', state%v)
    call get('g', state%g)
    call get('old_u', state%old_u)
    call get('old_v', state%old_v)
    call get('old_g', state%old_g)

  contains

    subroutine get(name, values)
      character(*), intent(in) :: name
      real(rp), intent(inout) :: values(:, :)
      real(rp), allocatable :: flat(:)
      call reader%get_reals(name, flat, failure)
      if (failure%failed) return
      if (size(flat) /= size(values)) then
        call failure%raise('the checkpoint has another number of points')
      else
        values(:, :) = reshape(flat, shape(values))
      end if
    end subroutine get
  end subroutine load_solid

  !> A number that tells wings apart: by their unloaded points.
  integer(i8) function wing_mark(model) result(mark)
    type(solid_model_t), intent(in) :: model
    mark = checksum_reals([model%points], 0_i8)
  end function wing_mark
end module app_solid_restart

! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves the positions and angular velocities of the wings in checkpoints, and compares them at a restart. A restart computes both
!> from its own kinematics; a difference means a sudden displacement of a wing, which `find_jumps` reports.
module fsi_pose_restart
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_body_motion, only: body_motion_t
  use fsi_flight_params, only: flight_params_t
  use fsi_kinematics, only: pose_wing, wing_pose_t
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  implicit none
  private
  public :: save_poses, find_jumps

  integer, parameter :: N = 15 !< numbers of a pose
  real(rp), parameter :: SMALL = 1.0e-6_rp !< of L and of 1/T: far above round-off, far below any effect on the flow

contains

  !> Puts the poses at `time` into an open checkpoint. Collective.
  subroutine save_poses(writer, params, motion, time)
    type(checkpoint_writer_t), intent(inout) :: writer
    type(flight_params_t), intent(in) :: params
    type(body_motion_t), intent(in) :: motion !< of the body
    real(rp), intent(in) :: time
    integer :: i
    do i = 1, size(params%wings)
      call writer%put_reals(pose_name(params%wings(i)%side), pose_numbers(params, motion, i, time))
    end do
  end subroutine save_poses

  !> Adds a sentence to `jumps` for each wing whose position or angular velocity at `time` differs from that in an open checkpoint,
  !> and for each wing that only one of them has. It says nothing about checkpoints without poses. Collective.
  subroutine find_jumps(reader, params, motion, time, jumps, failure)
    type(checkpoint_reader_t), intent(inout) :: reader
    type(flight_params_t), intent(in) :: params
    type(body_motion_t), intent(in) :: motion
    real(rp), intent(in) :: time
    type(message_list_t), intent(inout) :: jumps
    type(failure_t), intent(inout) :: failure
    character(5), parameter :: SIDES(2) = ['left ', 'right']
    real(rp), allocatable :: was(:)
    real(rp) :: change(N), turn
    integer :: s, i
    if (.not. (reader%has(pose_name(SIDES(1))) .or. reader%has(pose_name(SIDES(2))))) return
    do s = 1, 2
      i = number_of(params, SIDES(s))
      if (reader%has(pose_name(SIDES(s))) .neqv. i > 0) then
        call jumps%add('the '//trim(SIDES(s))//' wing would '//trim(merge('appear   ', 'disappear', i > 0)))
        cycle
      end if
      if (i == 0) cycle
      call reader%get_reals(pose_name(SIDES(s)), was, failure)
      if (failure%failed) return
      if (size(was) /= N) cycle
      change = pose_numbers(params, motion, i, time) - was
      turn = maxval(abs(change(4:12)))
      if (norm2(change(:3)) > SMALL .or. turn > SMALL) then
        call jumps%add('the '//trim(SIDES(s))//' wing would jump, its hinge by '//number_text(norm2(change(:3)))// &
                       ' L, its tip by about '//number_text(turn)//' wing lengths')
      else if (maxval(abs(change(13:))) > SMALL) then
        call jumps%add('the '//trim(SIDES(s))//' wing would change its angular velocity suddenly, by '// &
                       number_text(norm2(change(13:)))//' 1/T')
      end if
    end do
  end subroutine find_jumps

  !> Returns hinge [L], rotation matrix and angular velocity [1/T] of wing i.
  function pose_numbers(params, motion, i, time) result(numbers)
    type(flight_params_t), intent(in) :: params
    type(body_motion_t), intent(in) :: motion
    integer, intent(in) :: i
    real(rp), intent(in) :: time
    real(rp) :: numbers(N)
    type(wing_pose_t) :: pose
    call pose_wing(motion%at(time, params%body), params%wings(i)%mount, params%wings(i)%motion, time, pose)
    numbers = [pose%hinge, reshape(pose%matrix, [9]), pose%omega]
  end function pose_numbers

  !> Returns the number of the wing on a side, 0 if there is none.
  pure integer function number_of(params, side) result(i)
    type(flight_params_t), intent(in) :: params
    character(*), intent(in) :: side
    do i = size(params%wings), 1, -1
      if (params%wings(i)%side == side) return
    end do
  end function number_of

  !> Returns the name of a wing's pose in the checkpoint.
  pure function pose_name(side) result(name)
    character(*), intent(in) :: side
    character(:), allocatable :: name
    name = trim(side)//'_pose'
  end function pose_name
end module fsi_pose_restart

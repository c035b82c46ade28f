! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the whole state of a flow with its wings into a checkpoint, and restores it if a run may continue from it.
module simulation_checkpoints
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use common_run, only: run_t
  use fluid_restart, only: load_fluid, save_fluid
  use fsi_coupler, only: coupler_t
  use fsi_flight_restart, only: has_flight, load_flight, save_flight
  use fsi_pose_restart, only: find_jumps, save_poses
  use fsi_restart, only: has_flexible_wings, load_wings, save_wings
  use fsi_thin_restart, only: has_thin_wings, load_thin_wings, mark_without_markers, save_thin_wings
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use io_identity, only: identity_t
  use parallel_world, only: world_t
  use simulation_parts, only: run_parts_t
  use simulation_settings, only: settings_t
  implicit none
  private
  public :: put_state, restore_state, result_names

contains

  !> Writes the state of the flow, of the means over time and of the wings into the open checkpoint `writer`. It writes the
  !> state of wings without thickness only if `has_markers` says that their markers belong to a whole step. Collective.
  subroutine put_state(writer, settings, parts, has_markers)
    type(checkpoint_writer_t), intent(inout) :: writer
    type(settings_t), intent(in) :: settings
    type(run_parts_t), intent(inout) :: parts !< stay unchanged
    logical, intent(in) :: has_markers
    associate (fluid => parts%fluid)
      call save_fluid(writer, settings%fluid, fluid%transform%sticks, fluid%rhs%state)
      if (allocated(parts%averages)) call parts%averages%save(writer)
      if (.not. allocated(parts%wings)) return
      call save_poses(writer, parts%wings%params, parts%wings%motion, fluid%rhs%state%time)
    end associate
    if (allocated(parts%wings%flyer)) call save_flight(writer, parts%wings)
    if (allocated(parts%coupler)) call save_wings(writer, parts%wings, parts%coupler)
    if (.not. allocated(parts%thin)) return
    if (has_markers) then
      call save_thin_wings(writer, parts%wings, parts%thin)
    else
      call mark_without_markers(writer)
    end if
  end subroutine put_state

  !> Restores the state from the checkpoint at `path`. fsi_pose_restart compares the motions themselves, that is the position and
  !> the velocity of the wings at the time of the checkpoint. Fails if the file cannot be read. Also fails if the checkpoint does
  !> not fit this run, unless the user `accepts` the differences and the run can go on with them. Adds a line to `remarks` for every
  !> difference that does no harm or is accepted. Collective.
  subroutine restore_state(world, path, settings, run, accepts, parts, remarks, failure)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    type(settings_t), intent(in) :: settings
    type(run_t), intent(inout) :: run
    logical, intent(in) :: accepts
    type(run_parts_t), intent(inout) :: parts
    type(message_list_t), intent(inout) :: remarks
    type(failure_t), intent(inout) :: failure
    type(checkpoint_reader_t) :: reader
    type(identity_t) :: was
    type(message_list_t) :: jumps
    call reader%open(world, path, failure)
    if (failure%failed) return
    call was%load(reader, failure)
    call load_flow(reader, settings, parts, jumps, failure)
    call run%judge(was, jumps, accepts, remarks, failure)
    if (failure%failed) return
    if (allocated(parts%coupler)) then
      call load_wings(reader, parts%wings, parts%coupler, failure)
      call set_clocks(parts%coupler, parts%fluid%rhs%state%time)
    else if (has_flexible_wings(reader)) then
      call failure%raise('the checkpoint has flexible wings and this run has none: set [Insects] wings = flexible')
    end if
    if (failure%failed) return
    if (allocated(parts%thin)) then
      call load_thin_wings(reader, parts%wings, parts%thin, failure)
    else if (has_thin_wings(reader)) then
      call failure%raise('the checkpoint has wings without thickness: set [Insects] surface = thin')
    end if
    if (allocated(parts%averages)) call parts%averages%load(reader, failure)
    call reader%close(failure)
  end subroutine restore_state

  !> Loads the flow and, if there is one, the free flight. Adds to `jumps` how the motion of the wings at that time differs from
  !> the motion in this run.
  subroutine load_flow(reader, settings, parts, jumps, failure)
    type(checkpoint_reader_t), intent(inout) :: reader
    type(settings_t), intent(in) :: settings
    type(run_parts_t), intent(inout) :: parts
    type(message_list_t), intent(inout) :: jumps
    type(failure_t), intent(inout) :: failure
    associate (fluid => parts%fluid, time => parts%fluid%rhs%state%time)
      call load_fluid(reader, settings%fluid, fluid%transform%sticks, fluid%rhs%state, failure)
      if (.not. allocated(parts%wings) .or. failure%failed) return
      if (allocated(parts%wings%flyer) .and. has_flight(reader)) call load_flight(reader, time, parts%wings, failure)
      if (.not. failure%failed) call find_jumps(reader, parts%wings%params, parts%wings%motion, time, jumps, failure)
    end associate
  end subroutine load_flow

  !> Sets the clocks of the wings, which count in seconds. If the time of a wing differs from that of the flow, for instance after
  !> a change of the units, this sets it to that of the flow; otherwise the wing keeps its time to the last bit.
  subroutine set_clocks(coupler, time)
    type(coupler_t), intent(inout) :: coupler
    real(rp), intent(in) :: time !< [T] of the flow
    real(rp), parameter :: SMALL = 1.0e-9_rp !< [T] far above the round-off of the sum of steps
    associate (own => time*coupler%params%units%time)
      where (abs(coupler%states%time - own) > SMALL*coupler%params%units%time*max(1.0_rp, abs(time))) &
        coupler%states%time = own
    end associate
  end subroutine set_clocks

  !> Adds to `patterns` the names of the files that a run writes in the current folder (see matches_name).
  subroutine result_names(patterns)
    type(message_list_t), intent(inout) :: patterns
    character(18), parameter :: NAMES(6) = [character(18) :: '*.t', '*.xmf', '*_#.h5', 'failed_backup.h5', 'failed-*', &
                                                                                                       'summary.txt']
    integer :: i
    do i = 1, size(NAMES)
      call patterns%add(trim(NAMES(i)))
    end do
  end subroutine result_names
end module simulation_checkpoints

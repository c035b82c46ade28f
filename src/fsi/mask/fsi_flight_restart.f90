! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves and loads a free flight's part of a checkpoint.
module fsi_flight_restart
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_packing, only: count_packed, pack_value, unpack_value
  use base_visitor, only: visited_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_free_body, only: free_body_t
  use fsi_kinematics, only: body_t
  use fsi_moments, only: moments_t
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  implicit none
  private
  public :: save_flight, load_flight, has_flight

contains

  !> Puts state, displaced fluid and the frame of the wings into an open checkpoint. Collective.
  subroutine save_flight(writer, wings)
    type(checkpoint_writer_t), intent(inout) :: writer
    type(flapping_wings_t), intent(in) :: wings
    type(free_body_t) :: state
    type(moments_t) :: displaced
    type(body_t) :: frame
    associate (flyer => wings%flyer)
      state = flyer%state
      displaced = flyer%displaced
      frame = flyer%carried%known(2)
      call put('flight_state', state)
      call put('flight_displaced', displaced)
      call put('flight_frame', frame)
      call writer%put_reals('flight_masses', [flyer%params%mass, flyer%body%mass, flyer%params%inertia])
      call writer%put_real('flight_share', flyer%fraction)
      if (flyer%params%carries_fluid) call writer%put_real('flight_carries_fluid', 1.0_rp)
      call writer%put_reals('flight_markers', [flyer%marker_force, flyer%marker_moment])
    end associate

  contains

    subroutine put(name, value)
      character(*), intent(in) :: name
      class(visited_t), intent(inout) :: value
      real(rp), allocatable :: x(:)
      call pack_value(value, x)
      call writer%put_reals(name, x)
    end subroutine put
  end subroutine save_flight

  !> Restores them at `time` [T], the flow's. Fails if the insect has other masses. Collective.
  subroutine load_flight(reader, time, wings, failure)
    type(checkpoint_reader_t), intent(inout) :: reader
    real(rp), intent(in) :: time
    type(flapping_wings_t), intent(inout) :: wings
    type(failure_t), intent(inout) :: failure
    type(body_t) :: frame
    real(rp), allocatable :: x(:)
    associate (flyer => wings%flyer)
      call get('flight_state', flyer%state)
      call get_numbers('flight_masses', 5)
      if (failure%failed) return
      if (any(abs(x - [flyer%params%mass, flyer%body%mass, flyer%params%inertia]) > 1.0e-9_rp*x(1))) &
        call failure%raise('the checkpoint belongs to an insect of another mass, wing mass or J_body_yawpitchroll: set '// &
                           'these keys of [Insects] as in the run that wrote it')
      if (reader%has('flight_carries_fluid') .neqv. flyer%params%carries_fluid) &
        call failure%raise('the checkpoint was made with another [Penalization] unst_corrections: set it as in the run '// &
                           'that wrote it')
      call get('flight_displaced', flyer%displaced)
      call get('flight_frame', frame)
      if (failure%failed) return
      call flyer%carried%show(time, frame)
      call reader%get_real('flight_share', flyer%fraction, failure)
      call get_numbers('flight_markers', 6)
      if (failure%failed) return
      flyer%marker_force = x(1:3)
      flyer%marker_moment = x(4:6)
      flyer%state%acceleration = flyer%carried%known(2)%acceleration
      flyer%state%omega_rate = flyer%carried%known(2)%rotation%omega_rate
      call wings%motion%show(time, flyer%state%body())
      flyer%is_restored = .true.
    end associate

  contains

    subroutine get(name, value)
      character(*), intent(in) :: name
      class(visited_t), intent(inout) :: value
      call get_numbers(name, count_packed(value))
      if (.not. failure%failed) call unpack_value(x, value, failure)
    end subroutine get

    !> Reads n numbers of the checkpoint into `x`.
    subroutine get_numbers(name, n)
      character(*), intent(in) :: name
      integer, intent(in) :: n
      if (failure%failed) return
      call reader%get_reals(name, x, failure)
      if (failure%failed) return
      if (size(x) /= n) call failure%raise('the checkpoint has another kind of free flight: '// &
                                           'set [Insects] as in the run that wrote it')
    end subroutine get_numbers
  end subroutine load_flight

  !> Tells whether an open checkpoint holds a free flight.
  logical function has_flight(reader)
    type(checkpoint_reader_t), intent(inout) :: reader
    has_flight = reader%has('flight_state')
  end function has_flight
end module fsi_flight_restart

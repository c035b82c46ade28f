! SPDX-License-Identifier: GPL-3.0-or-later
!> A free flight's part of a checkpoint.
module fsi_flight_restart
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_free_body, only: N_STATE
  use fsi_kinematics, only: body_t
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  implicit none
  private
  public :: save_flight, load_flight, has_flight

  integer, parameter :: N_BODY = 27, N_MOMENTS = 13

contains

  !> Puts state, displaced fluid and the frame of the wings into an open checkpoint. Collective.
  subroutine save_flight(writer, wings)
    type(checkpoint_writer_t), intent(inout) :: writer
    type(flapping_wings_t), intent(in) :: wings
    associate (flyer => wings%flyer)
      call writer%put_reals('flight_state', flyer%state%pack())
      call writer%put_reals('flight_displaced', [flyer%displaced%mass, flyer%displaced%first, flyer%displaced%second])
      call writer%put_reals('flight_frame', body_numbers(flyer%carried%known(2)))
      call writer%put_reals('flight_masses', [flyer%params%mass, flyer%body%mass, flyer%params%inertia])
      call writer%put_real('flight_share', flyer%fraction)
      if (flyer%params%carries_fluid) call writer%put_real('flight_carries_fluid', 1.0_rp)
      call writer%put_reals('flight_markers', [flyer%marker_force, flyer%marker_moment])
    end associate
  end subroutine save_flight

  !> Restores them at `time` [T], the flow's. Fails if the insect has other masses. Collective.
  subroutine load_flight(reader, time, wings, failure)
    type(checkpoint_reader_t), intent(inout) :: reader
    real(rp), intent(in) :: time
    type(flapping_wings_t), intent(inout) :: wings
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: x(:)
    associate (flyer => wings%flyer)
      call get('flight_state', N_STATE)
      if (failure%failed) return
      call flyer%state%unpack(x)
      call get('flight_masses', 5)
      if (failure%failed) return
      if (any(abs(x - [flyer%params%mass, flyer%body%mass, flyer%params%inertia]) > 1.0e-9_rp*x(1))) &
        call failure%raise('the checkpoint belongs to an insect of another mass, wing mass or J_body_yawpitchroll: set '// &
                           'these keys of [Insects] as in the run that wrote it')
      if (reader%has('flight_carries_fluid') .neqv. flyer%params%carries_fluid) &
        call failure%raise('the checkpoint was made with another [Penalization] unst_corrections: set it as in the run '// &
                           'that wrote it')
      call get('flight_displaced', N_MOMENTS)
      if (failure%failed) return
      flyer%displaced%mass = x(1)
      flyer%displaced%first = x(2:4)
      flyer%displaced%second = reshape(x(5:13), [3, 3])
      call get('flight_frame', N_BODY)
      if (failure%failed) return
      call flyer%carried%show(time, body_of(x))
      call reader%get_real('flight_share', flyer%fraction, failure)
      if (failure%failed) return
      call get('flight_markers', 6)
      if (failure%failed) return
      flyer%marker_force = x(1:3)
      flyer%marker_moment = x(4:6)
      flyer%state%acceleration = flyer%carried%known(2)%acceleration
      flyer%state%omega_rate = flyer%carried%known(2)%rotation%omega_rate
      call wings%motion%show(time, flyer%state%body())
      flyer%is_restored = .true.
    end associate

  contains

    subroutine get(name, n)
      character(*), intent(in) :: name
      integer, intent(in) :: n
      if (failure%failed) return
      call reader%get_reals(name, x, failure)
      if (failure%failed) return
      if (size(x) /= n) call failure%raise('the checkpoint has another kind of free flight: '// &
                                           'set [Insects] as in the run that wrote it')
    end subroutine get
  end subroutine load_flight

  !> Whether an open checkpoint holds a free flight.
  logical function has_flight(reader)
    type(checkpoint_reader_t), intent(inout) :: reader
    has_flight = reader%has('flight_state')
  end function has_flight

  pure function body_numbers(body) result(x)
    type(body_t), intent(in) :: body
    real(rp) :: x(N_BODY)
    x = [body%centre, body%velocity, body%acceleration, body%angles, reshape(body%rotation%matrix, [9]), &
         body%rotation%omega, body%rotation%omega_rate]
  end function body_numbers

  pure type(body_t) function body_of(x) result(body)
    real(rp), intent(in) :: x(N_BODY)
    body%centre = x(1:3)
    body%velocity = x(4:6)
    body%acceleration = x(7:9)
    body%angles = x(10:12)
    body%rotation%matrix = reshape(x(13:21), [3, 3])
    body%rotation%omega = x(22:24)
    body%rotation%omega_rate = x(25:27)
  end function body_of
end module fsi_flight_restart

! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the time series of a free flight: `rigidsolidsolver.t` with FLUSI's columns, from which BodyMotion = from_file::
!> repeats the flight, and `free_flight.t` with forces, accelerations and momenta.
module simulation_body_series
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fsi_flyer, only: flyer_t
  use fsi_quaternion, only: angles_of
  use io_series, only: series_t
  use simulation_opening, only: opening_t
  implicit none
  private
  public :: body_series_t

  character(*), parameter :: XYZ = 'xyz'

  !> Writes the two series of a free flight.
  type :: body_series_t
    private
    type(series_t) :: state, loads
    logical :: is_open = .false.
  contains
    procedure :: open => series_open
    procedure :: write => series_write
    procedure :: close => series_close
  end type body_series_t

contains

  !> Opens both files through `opening`, which keeps the first failure. Collective.
  subroutine series_open(self, opening)
    class(body_series_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    character(40) :: state(14), loads(22)
    integer :: c
    self%is_open = .true.
    state(1) = 'time [T]'
    loads(1:4) = [character(40) :: 'time [T]', 'roll [rad]', 'pitch [rad]', 'yaw [rad]']
    do c = 1, 3
      state(1 + c) = XYZ(c:c)//' [L]'
      state(4 + c) = 'v'//XYZ(c:c)//' [L/T]'
      state(8 + c) = 'quaternion '//achar(iachar('0') + c)//' [-]'
      state(11 + c) = 'omega '//XYZ(c:c)//', body frame [rad/T]'
      loads(4 + c) = 'a'//XYZ(c:c)//' [L/T^2]'
      loads(7 + c) = 'omega rate '//XYZ(c:c)//', body frame [rad/T^2]'
      loads(10 + c) = 'F'//XYZ(c:c)//' of the flow [rho L^4/T^2]'
      loads(13 + c) = 'M'//XYZ(c:c)//' of the flow [rho L^5/T^2]'
      loads(16 + c) = 'momentum '//XYZ(c:c)//' [rho L^4/T]'
      loads(19 + c) = 'angular momentum '//XYZ(c:c)//' [rho L^5/T]'
    end do
    state(8) = 'quaternion 0 [-]'
    call opening%open(self%state, 'rigidsolidsolver.t', state)
    call opening%open(self%loads, 'free_flight.t', loads)
  end subroutine series_open

  !> Writes one record to each file at `time` [T]. The forces are those that the flow exerts on the solids by penalization and
  !> on markers. The momenta leave out the displaced fluid; the angular momentum is about the centre of the body. A failure
  !> shows in `close`.
  subroutine series_write(self, time, flyer)
    class(body_series_t), intent(inout) :: self
    real(rp), intent(in) :: time
    type(flyer_t), intent(in) :: flyer
    associate (s => flyer%state)
      call self%state%write([time, s%centre, s%velocity, s%attitude, s%omega])
      call self%loads%write([time, angles_of(s%attitude), s%acceleration, s%omega_rate, &
                             flyer%force + flyer%marker_force, flyer%moment + flyer%marker_moment, s%momentum, s%spin])
    end associate
  end subroutine series_write

  !> Closes both files if they are open. Fails if one of them could not be written completely. Collective.
  subroutine series_close(self, failure)
    class(body_series_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    if (.not. self%is_open) return
    call self%state%close(failure)
    call self%loads%close(failure)
  end subroutine series_close
end module simulation_body_series

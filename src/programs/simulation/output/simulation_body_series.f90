! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the rows of the series of a free flight: `rigidsolidsolver.t` with FLUSI's columns, from which BodyMotion = from_file::
!> repeats the flight, and `free_flight.t` with forces, accelerations and momenta.
module simulation_body_series
  use base_kinds, only: rp
  use fsi_quaternion, only: angles_of
  use simulation_series_table, only: moment_t, series_table_t, EVERY_PASS, TIME_COLUMN
  implicit none
  private
  public :: add_body_series

  character(*), parameter :: XYZ = 'xyz'

contains

  !> Adds both series of a free flight.
  subroutine add_body_series(table)
    type(series_table_t), intent(inout) :: table
    character(40) :: state(14), loads(22)
    integer :: c
    state(1) = TIME_COLUMN
    loads(1:4) = [character(40) :: TIME_COLUMN, 'roll [rad]', 'pitch [rad]', 'yaw [rad]']
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
    call table%add('rigidsolidsolver.t', state, EVERY_PASS, state_values)
    call table%add('free_flight.t', loads, EVERY_PASS, load_values)
  end subroutine add_body_series

  !> Returns place, velocity and attitude of the body, and how it turns.
  subroutine state_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    associate (s => now%wings%flyer%state)
      values = [now%wings%time, s%centre, s%velocity, s%attitude, s%omega]
    end associate
  end subroutine state_values

  !> Returns angles, accelerations, forces and momenta. The forces are those that the flow exerts on the solids by penalization and
  !> on markers. The momenta leave out the displaced fluid; the angular momentum is about the centre of the body.
  subroutine load_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    associate (flyer => now%wings%flyer, s => now%wings%flyer%state)
      values = [now%wings%time, angles_of(s%attitude), s%acceleration, s%omega_rate, flyer%force + flyer%marker_force, &
                flyer%moment + flyer%marker_moment, s%momentum, s%spin]
    end associate
  end subroutine load_values
end module simulation_body_series

! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the rows of the series of flapping wings: `kinematics.t` with FLUSI's columns, `aero_power.t`, `slip.t`, and
!> `wing_left.t`, `wing_right.t`, `bending_left.t`, `bending_right.t`, `landmarks_left.t` and `landmarks_right.t` with the state of
!> each wing.
module simulation_flight_series
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flight_params, only: flight_params_t
  use fsi_kinematics, only: swap_flusi_wing
  use fsi_wing_shape, only: section_t, SPAN
  use simulation_force_series, only: body_power
  use simulation_series_table, only: moment_t, series_table_t, EVERY_INTEGRAL, EVERY_SLIP, TIME_COLUMN
  use solid_inertia, only: momenta_t
  implicit none
  private
  public :: add_flight_series, landmarks_file

  character(*), parameter :: XYZ = 'xyz', T = TIME_COLUMN

contains

  !> Adds the series of the wings, and those of bending if they are `flexible`. Makes in `now` what these need; without `wings`,
  !> nothing can be written.
  subroutine add_flight_series(table, now, flight, flexible, wings)
    type(series_table_t), intent(inout) :: table
    type(moment_t), intent(inout) :: now
    type(flight_params_t), intent(in) :: flight
    logical, intent(in) :: flexible
    type(flapping_wings_t), intent(in), optional :: wings
    character(*), parameter :: P = ' power [rho L^5/T^3]'
    integer :: i
    call table%add('slip.t', &
                   [character(40) :: T, 'largest slip after the step [L/T]', 'before its forces [L/T]', &
                    'largest wing speed [L/T]', 'power to the flow [rho L^5/T^3]', 'iterations of the forces', &
                    'share of the slip that they leave', 'power from the wings [rho L^5/T^3]'], &
                   EVERY_SLIP, slip_values, exists=flight%thin%is_thin)
    call table%add('kinematics.t', kinematics_columns(), EVERY_INTEGRAL, kinematics_values)
    call table%add('aero_power.t', [character(40) :: T, 'aerodynamic'//P, 'inertial'//P], EVERY_INTEGRAL, power_values)
    do i = 1, size(flight%wings)
      call table%add('bending_'//trim(flight%wings(i)%side)//'.t', bending_columns(), EVERY_INTEGRAL, bending_values, item=i, &
                     exists=flexible)
      call table%add('wing_'//trim(flight%wings(i)%side)//'.t', wing_columns(), EVERY_INTEGRAL, wing_values, item=i)
      call table%add(landmarks_file(flight%wings(i)%side), landmark_columns(flight%wings(i)%landmarks%count()), EVERY_INTEGRAL, &
                     landmark_values, item=i, exists=flight%wings(i)%landmarks%count() > 0)
    end do
    if (.not. (flexible .and. present(wings))) return
    allocate (now%shapes(size(flight%wings)))
    do i = 1, size(now%shapes)
      associate (wing => wings%params%wings(i))
        call now%shapes(i)%init(wing%points, wing%triangles, SPAN, wing%mount%dorsal_sign())
      end associate
    end do
  end subroutine add_flight_series

  !> Returns the slip of wings without thickness in the step that was measured.
  subroutine slip_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    associate (slip => now%thin%slip)
      values = [slip%time, slip%after, slip%before, slip%speed, slip%received, real(slip%iterations, rp), slip%left, slip%lost]
    end associate
  end subroutine slip_values

  !> Returns the column titles of the kinematics file.
  function kinematics_columns() result(columns)
    character(40) :: columns(26)
    character(5), parameter :: SIDES(2) = ['left ', 'right']
    character(5), parameter :: ANGLES(3) = ['alpha', 'phi  ', 'theta']
    integer :: i, c
    columns(1) = T
    columns(5:8) = [character(40) :: 'roll [rad]', 'pitch [rad]', 'yaw [rad]', 'eta [rad]']
    do c = 1, 3
      columns(1 + c) = XYZ(c:c)//'c [L]'
      do i = 1, 2
        columns(8 + 3*(i - 1) + c) = trim(ANGLES(c))//' '//trim(SIDES(i))//' [rad]'
        columns(14 + 3*(i - 1) + c) = 'omega'//XYZ(c:c)//' '//trim(SIDES(i))//' [rad/T]'
        columns(20 + 3*(i - 1) + c) = 'omega rate '//XYZ(c:c)//' '//trim(SIDES(i))//' [rad/T^2]'
      end do
    end do
  end function kinematics_columns

  !> Returns where the body is and how it and the wings move.
  subroutine kinematics_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    real(rp) :: eta, angles(3, 2), omega(3, 2), omega_rate(3, 2)
    integer :: i, side
    angles = 0
    omega = 0
    omega_rate = 0
    eta = 0
    associate (wings => now%wings)
      do i = 1, size(now%loads)
        associate (pose => wings%poses(i))
          side = merge(2, 1, wings%params%wings(i)%mount%is_right)
          angles(:, side) = [pose%alpha%value, pose%phi%value, pose%theta%value]
          omega(:, side) = swap_flusi_wing(pose%omega_relative)
          omega_rate(:, side) = swap_flusi_wing(pose%omega_relative_rate)
        end associate
      end do
      if (size(now%loads) > 0) eta = wings%params%wings(1)%mount%eta
      values = [wings%time, wings%body%centre, wings%body%angles, eta, angles, omega, omega_rate]
    end associate
  end subroutine kinematics_values

  !> Returns the powers of all wings; the aerodynamic one contains that of the body.
  subroutine power_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    values = [now%wings%time, sum(now%loads%power) + body_power(now%fluid, now%wings), sum(now%loads%inertial_power)]
  end subroutine power_values

  !> Returns the column titles of the files of forces and powers of a wing.
  function wing_columns() result(columns)
    character(40) :: columns(16)
    integer :: c
    columns(1) = T
    do c = 1, 3
      columns(1 + c) = 'F'//XYZ(c:c)//' [rho L^4/T^2]'
      columns(4 + c) = 'F'//XYZ(c:c)//' wing frame [rho L^4/T^2]'
      columns(7 + c) = 'M'//XYZ(c:c)//' hinge [rho L^5/T^2]'
      columns(10 + c) = 'M'//XYZ(c:c)//' hinge, wing frame [rho L^5/T^2]'
    end do
    columns(14:16) = [character(40) :: 'aerodynamic power [rho L^5/T^3]', 'of it unsteady [rho L^5/T^3]', &
                      'inertial power [rho L^5/T^3]']
  end function wing_columns

  !> Returns forces, moments and powers of a wing.
  subroutine wing_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    associate (pose => now%wings%poses(now%item), l => now%loads(now%item))
      values = [now%wings%time, l%force, pose%vector_to_wing(l%force), l%torque, pose%vector_to_wing(l%torque), l%power, &
                l%unsteady_power, l%inertial_power]
    end associate
  end subroutine wing_values

  !> Returns the name of the series of the landmarks on the wing of this side.
  pure function landmarks_file(side) result(name)
    character(*), intent(in) :: side
    character(:), allocatable :: name
    name = 'landmarks_'//trim(side)//'.t'
  end function landmarks_file

  !> Returns the column titles of the files of n landmarks.
  function landmark_columns(n) result(columns)
    integer, intent(in) :: n
    character(40) :: columns(1 + 3*n)
    integer :: i, c
    columns(1) = T
    do i = 1, n
      do c = 1, 3
        columns(3*i - 2 + c) = XYZ(c:c)//' of landmark '//number_text(i)//' [L]'
      end do
    end do
  end function landmark_columns

  !> Returns where the landmarks of a wing are in space: x, y and z of the box, of one landmark after the other.
  subroutine landmark_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    associate (i => now%item, wings => now%wings)
      values = [wings%time, wings%params%wings(i)%landmarks%places(wings%surfaces(i)%points)]
    end associate
  end subroutine landmark_values

  !> Returns the column titles of the files of bending.
  function bending_columns() result(columns)
    character(40) :: columns(30)
    character(9) :: place
    integer :: c
    columns(1) = T
    do c = 1, 3
      write (place, '(a,i0,a)') ' at ', nint(100*SPAN(c)), ' %'
      columns(10 + 3*c) = 'trailing edge'//trim(place)//' [L]'
      columns(11 + 3*c) = 'twist'//trim(place)//' [rad]'
      columns(12 + 3*c) = 'camber'//trim(place)//' [chord]'
      columns(1 + c) = 'tip u'//XYZ(c:c)//', wing frame [L]'
      columns(7 + c) = 'F'//XYZ(c:c)//' of the pressure [rho L^4/T^2]'
    end do
    columns(5:7) = [character(40) :: 'largest |u| [L]', 'elastic energy [rho L^5/T^2]', &
                    'kinetic, in the frame [rho L^5/T^2]']
    columns(11:12) = [character(40) :: 'elastic energy [J]', 'tip |u| [m]']
    columns(22:26) = [character(40) :: 'kinetic energy, in space [rho L^5/T^2]', 'power of the hinge [rho L^5/T^3]', &
                     'power of the load [rho L^5/T^3]', 'damping power [rho L^5/T^3]', 'energy imbalance [rho L^5/T^2]']
    do c = 1, 3
      columns(26 + c) = 'F'//XYZ(c:c)//' pressure - penalty [rho L^4/T^2]'
    end do
    columns(30) = 'power pressure - penalty [rho L^5/T^3]'
  end function bending_columns

  !> Returns the bending of a flexible wing, the load that bends it and its energy.
  subroutine bending_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    type(momenta_t) :: m
    type(section_t) :: sections(size(SPAN))
    real(rp) :: joule, watt
    integer :: c, tip
    m = now%coupler%measure(now%item)
    associate (i => now%item, u => now%coupler%params%units, wings => now%wings)
      joule = u%mass*u%length**2/u%time**2
      watt = joule/u%time
      tip = maxloc(wings%params%wings(i)%points(1, :), 1)
      associate (bent => wings%deformation(i)%u, e => now%coupler%energies(i), load => now%coupler%loads(i), l => now%loads(i))
        call now%shapes(i)%measure(bent, sections)
        values = [wings%time, bent(:, tip), sqrt(maxval(sum(bent**2, 1))), m%elastic/joule, m%relative_kinetic/joule, &
                  now%coupler%surface_load(i), m%elastic, norm2(bent(:, tip))*u%length, &
                  (sections(c)%trailing, sections(c)%twist, sections(c)%camber, c=1, size(SPAN)), &
                  e%kinetic/joule, e%hinge_power/watt, e%load_power/watt, e%damping_power/watt, e%imbalance()/joule, &
                  load%force - l%force, load%power - l%power]
      end associate
    end associate
  end subroutine bending_values
end module simulation_flight_series

! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the time series of flapping wings: `kinematics.t` with FLUSI's columns, `aero_power.t`, and `wing_left.t` and
!> `wing_right.t` with the state of each wing.
module simulation_flight_series
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flight_params, only: flight_params_t
  use fsi_kinematics, only: swap_flusi_wing
  use fsi_wing_loads, only: wing_loads_t
  use fsi_wing_shape, only: section_t, SPAN, wing_shape_t
  use io_series, only: series_t
  use simulation_opening, only: opening_t
  use solid_inertia, only: momenta_t
  implicit none
  private
  public :: flight_series_t

  character(*), parameter :: XYZ = 'xyz'

  !> Writes the series of flapping wings.
  type :: flight_series_t
    private
    type(series_t) :: kinematics, power
    type(series_t), allocatable :: wing(:), bending(:)
    type(wing_shape_t), allocatable :: shapes(:) !< of flexible wings
    type(wing_loads_t), allocatable :: loads(:)  !< of the last record
  contains
    procedure :: open => series_open
    procedure :: write => series_write
    procedure :: write_bending => series_write_bending
    procedure :: close => series_close
  end type flight_series_t

contains

  !> Opens all files through `opening`, and the files on bending if the wings are `flexible`. Without `wings`, nothing can be
  !> written. Collective.
  subroutine series_open(self, opening, flight, flexible, wings)
    class(flight_series_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    type(flight_params_t), intent(in) :: flight
    logical, intent(in) :: flexible
    type(flapping_wings_t), intent(in), optional :: wings
    character(*), parameter :: T = 'time [T]', P = ' power [rho L^5/T^3]'
    integer :: i
    call opening%open(self%kinematics, 'kinematics.t', kinematics_columns())
    call opening%open(self%power, 'aero_power.t', [character(40) :: T, 'aerodynamic'//P, 'inertial'//P])
    allocate (self%wing(size(flight%wings)), self%loads(size(flight%wings)))
    if (flexible) allocate (self%bending(size(flight%wings)), self%shapes(size(flight%wings)))
    do i = 1, size(self%wing)
      if (flexible .and. present(wings)) then
        associate (wing => wings%params%wings(i))
          call self%shapes(i)%init(wing%points, wing%triangles, SPAN, wing%mount%dorsal_sign())
        end associate
      end if
      if (flexible) call opening%open(self%bending(i), 'bending_'//trim(flight%wings(i)%side)//'.t', bending_columns())
      call opening%open(self%wing(i), 'wing_'//trim(flight%wings(i)%side)//'.t', wing_columns())
    end do
  end subroutine series_open

  !> Returns the column titles of the kinematics file.
  function kinematics_columns() result(columns)
    character(40) :: columns(26)
    character(5), parameter :: SIDES(2) = ['left ', 'right']
    character(5), parameter :: ANGLES(3) = ['alpha', 'phi  ', 'theta']
    integer :: i, c
    columns(1) = 'time [T]'
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

  !> Returns the column titles of the files of forces and powers of a wing.
  function wing_columns() result(columns)
    character(40) :: columns(16)
    integer :: c
    columns(1) = 'time [T]'
    do c = 1, 3
      columns(1 + c) = 'F'//XYZ(c:c)//' [rho L^4/T^2]'
      columns(4 + c) = 'F'//XYZ(c:c)//' wing frame [rho L^4/T^2]'
      columns(7 + c) = 'M'//XYZ(c:c)//' hinge [rho L^5/T^2]'
      columns(10 + c) = 'M'//XYZ(c:c)//' hinge, wing frame [rho L^5/T^2]'
    end do
    columns(14:16) = [character(40) :: 'aerodynamic power [rho L^5/T^3]', 'of it unsteady [rho L^5/T^3]', &
                      'inertial power [rho L^5/T^3]']
  end function wing_columns

  !> Returns the column titles of the files of bending.
  function bending_columns() result(columns)
    character(40) :: columns(30)
    character(9) :: place
    integer :: c
    columns(1) = 'time [T]'
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

  !> Writes one record for every wing on its bending, on the load that bends it and on its energy. The caller must have called
  !> `write` for the same time.
  subroutine series_write_bending(self, wings, coupler)
    class(flight_series_t), intent(inout) :: self
    type(flapping_wings_t), intent(in) :: wings
    type(coupler_t), intent(in) :: coupler
    type(momenta_t) :: m
    type(wing_loads_t) :: l
    type(section_t) :: sections(size(SPAN))
    real(rp) :: joule, watt
    integer :: i, c, tip
    associate (u => coupler%params%units)
      joule = u%mass*u%length**2/u%time**2
      watt = joule/u%time
      do i = 1, size(self%bending)
        m = coupler%measure(i)
        l = self%loads(i)
        associate (bent => wings%deformation(i)%u, e => coupler%energies(i), load => coupler%loads(i))
          call self%shapes(i)%measure(bent, sections)
          tip = maxloc(wings%params%wings(i)%points(1, :), 1)
          call self%bending(i)%write([wings%time, bent(:, tip), sqrt(maxval(sum(bent**2, 1))), m%elastic/joule, &
                                      m%relative_kinetic/joule, coupler%surface_load(i), m%elastic, &
                                      norm2(bent(:, tip))*u%length, &
                                      (sections(c)%trailing, sections(c)%twist, sections(c)%camber, c=1, size(SPAN)), &
                                      e%kinetic/joule, e%hinge_power/watt, e%load_power/watt, e%damping_power/watt, &
                                      e%imbalance()/joule, load%force - l%force, load%power - l%power])
        end associate
      end do
    end associate
  end subroutine series_write_bending

  !> Writes one record to every file. `loads` are the loads on the wings in the order of the wings, and `of_body` is the power of
  !> the body.
  subroutine series_write(self, wings, loads, of_body)
    class(flight_series_t), intent(inout) :: self
    type(flapping_wings_t), intent(in) :: wings
    type(wing_loads_t), intent(in) :: loads(:)
    real(rp), intent(in) :: of_body
    real(rp) :: eta
    real(rp) :: angles(3, 2), omega(3, 2), omega_rate(3, 2)
    integer :: i, side
    self%loads = loads
    angles = 0
    omega = 0
    omega_rate = 0
    do i = 1, size(loads)
      associate (pose => wings%poses(i), l => loads(i), wing => wings%params%wings(i))
        side = merge(2, 1, wing%mount%is_right)
        angles(:, side) = [pose%alpha%value, pose%phi%value, pose%theta%value]
        omega(:, side) = swap_flusi_wing(pose%omega_relative)
        omega_rate(:, side) = swap_flusi_wing(pose%omega_relative_rate)
        call self%wing(i)%write([wings%time, l%force, pose%vector_to_wing(l%force), l%torque, &
                                 pose%vector_to_wing(l%torque), l%power, l%unsteady_power, l%inertial_power])
      end associate
    end do
    eta = 0
    if (size(loads) > 0) eta = wings%params%wings(1)%mount%eta
    associate (body => wings%body)
      call self%kinematics%write([wings%time, body%centre, body%angles, eta, angles, omega, omega_rate])
    end associate
    call self%power%write([wings%time, sum(loads%power) + of_body, sum(loads%inertial_power)])
  end subroutine series_write

  !> Closes all files. Fails if any of them could not be written completely. Collective.
  subroutine series_close(self, failure)
    class(flight_series_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    integer :: i
    call self%kinematics%close(failure)
    call self%power%close(failure)
    do i = 1, size(self%wing)
      call self%wing(i)%close(failure)
      if (allocated(self%bending)) call self%bending(i)%close(failure)
    end do
  end subroutine series_close
end module simulation_flight_series

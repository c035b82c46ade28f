! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the rows of the series of forces, `forces.t` of all solids and `forces_part*.t` of each colour, with FLUSI's columns.
module simulation_force_series
  use base_kinds, only: rp
  use fluid_penalty, only: COLOR_BODY, N_COLORS
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_surface_load, only: surface_load_t
  use parallel_world, only: world_t
  use simulation_series_table, only: moment_t, series_table_t, EVERY_INTEGRAL, TIME_COLUMN
  implicit none
  private
  public :: add_force_series, body_power

  character(*), parameter :: XYZ = 'xyz'

contains

  !> Adds the series of all solids, which has powers if there are `moving_wings`, and that of each part. Only a run, which has
  !> `fluid`, knows the parts. Collective.
  subroutine add_force_series(table, world, moving_wings, fluid, wings)
    type(series_table_t), intent(inout) :: table
    type(world_t), intent(in) :: world
    logical, intent(in) :: moving_wings
    type(fluid_t), intent(in), optional :: fluid
    type(flapping_wings_t), intent(in), optional :: wings
    logical :: has_color(0:N_COLORS - 1)
    character(16) :: name
    integer :: c
    call table%add('forces.t', force_columns(moving_wings), EVERY_INTEGRAL, force_values)
    if (.not. present(fluid)) then
      call table%add_name('forces_part*.t')
      return
    end if
    call find_colors(world, fluid, wings, has_color)
    do c = COLOR_BODY, N_COLORS - 1
      write (name, '(a,i1,a)') 'forces_part', c, '.t'
      call table%add(trim(name), force_columns(wing_of(wings, c) > 0 .or. is_body(wings, c)), EVERY_INTEGRAL, part_values, &
                     item=c, exists=has_color(c))
    end do
  end subroutine add_force_series

  !> Finds which colours the solids have. Collective.
  subroutine find_colors(world, fluid, wings, has_color)
    type(world_t), intent(in) :: world
    type(fluid_t), intent(in) :: fluid
    type(flapping_wings_t), intent(in), optional :: wings
    logical, intent(out) :: has_color(0:N_COLORS - 1)
    real(rp) :: points(0:N_COLORS - 1)
    integer :: c
    points = fluid%rhs%penalty%count_colors()
    call world%sum_reals(points)
    has_color = points > 0.5_rp
    do c = 0, N_COLORS - 1
      has_color(c) = has_color(c) .or. wing_of(wings, c) > 0
    end do
  end subroutine find_colors

  !> Returns the column titles of the files of forces, with powers if `has_power`.
  function force_columns(has_power) result(columns)
    logical, intent(in) :: has_power
    character(40), allocatable :: columns(:)
    integer :: c
    allocate (columns(13))
    columns(1) = TIME_COLUMN
    do c = 1, 3
      columns(1 + c) = 'F'//XYZ(c:c)//' [rho L^4/T^2]'
      columns(4 + c) = 'F'//XYZ(c:c)//' unsteady [rho L^4/T^2]'
      columns(7 + c) = 'M'//XYZ(c:c)//' [rho L^5/T^2]'
      columns(10 + c) = 'M'//XYZ(c:c)//' unsteady [rho L^5/T^2]'
    end do
    if (has_power) columns = [character(40) :: columns, 'aerodynamic power [rho L^5/T^3]', 'inertial power [rho L^5/T^3]']
  end function force_columns

  !> Returns force and moment on all solids. With wings, also the aerodynamic power of wings and body, and the inertial power of the
  !> wings.
  subroutine force_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    real(rp) :: force(3), moment(3)
    force = 0
    moment = 0
    if (associated(now%wings)) call now%wings%marker_total(now%wings%poses, now%fluid%rhs%params%solids%centre, force, moment)
    associate (fluid => now%fluid, s => now%fluid%sums)
      values = [fluid%sums_time, sum(s%force(:, COLOR_BODY:), 2) + force, sum(fluid%unsteady_force(:, COLOR_BODY:), 2), &
                sum(s%moment(:, COLOR_BODY:), 2) + moment, sum(fluid%unsteady_moment(:, COLOR_BODY:), 2)]
      if (associated(now%wings)) values = [values, sum(now%loads%power) + body_power(fluid, now%wings), &
                                           sum(now%loads%inertial_power)]
    end associate
  end subroutine force_values

  !> Returns force and moment on one colour. As in FLUSI, moments of a wing are about its hinge. Wings and body also have powers.
  subroutine part_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    type(surface_load_t) :: at_markers
    integer :: i
    i = wing_of(now%wings, now%item)
    if (i > 0) then
      associate (l => now%loads(i))
        values = [now%fluid%sums_time, l%force - l%unsteady_force, l%unsteady_force, l%torque - l%unsteady_torque, &
                  l%unsteady_torque, l%power, l%inertial_power]
      end associate
      return
    end if
    at_markers = marker_part(now%wings, now%item)
    associate (fluid => now%fluid, s => now%fluid%sums, c => now%item)
      values = [fluid%sums_time, s%force(:, c) + at_markers%force, fluid%unsteady_force(:, c), &
                s%moment(:, c) + at_markers%moment, fluid%unsteady_moment(:, c)]
      if (is_body(now%wings, c)) values = [values, body_power(fluid, now%wings), 0.0_rp]
    end associate
  end subroutine part_values

  !> Returns the number of the wing that has this colour; 0 if there is none.
  pure integer function wing_of(wings, color) result(i)
    type(flapping_wings_t), intent(in), optional :: wings
    integer, intent(in) :: color
    i = 0
    if (.not. present(wings)) return
    do i = size(wings%surfaces), 1, -1
      if (wings%surfaces(i)%color == color) return
    end do
  end function wing_of

  !> Tells whether this colour is that of the body of an insect.
  pure logical function is_body(wings, color)
    type(flapping_wings_t), intent(in), optional :: wings
    integer, intent(in) :: color
    is_body = .false.
    if (present(wings)) is_body = color == COLOR_BODY .and. wings%has_body()
  end function is_body

  !> Returns the load on the body by markers of wings without thickness that lie inside it.
  pure type(surface_load_t) function marker_part(wings, color) result(load)
    type(flapping_wings_t), intent(in), optional :: wings
    integer, intent(in) :: color
    if (.not. is_body(wings, color)) return
    if (allocated(wings%marker_loads)) load = wings%marker_loads(size(wings%marker_loads))
  end function marker_part

  !> Returns the aerodynamic power of the body of an insect; it is 0 if there is none.
  pure real(rp) function body_power(fluid, wings) result(power)
    type(fluid_t), intent(in) :: fluid
    type(flapping_wings_t), intent(in), optional :: wings
    type(surface_load_t) :: at_markers
    power = 0
    if (.not. is_body(wings, COLOR_BODY)) return
    at_markers = marker_part(wings, COLOR_BODY)
    power = sum(fluid%sums%power(:, COLOR_BODY)) - wings%params%solid%power_of_fluid(wings%body) + at_markers%power
  end function body_power
end module simulation_force_series

! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks during the motion of wings whether they touch each other or leave the box.
module fsi_flight_faults
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flight_params, only: flight_params_t
  use fsi_kinematics, only: pose_wing, wing_pose_t
  use fsi_surface, only: surface_t
  use fsi_wing_gap, only: gap_t, smallest_gap
  use io_config, only: config_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: check_flight, foresee_flight

  real(rp), parameter :: CELLS = 4       !< of thickness that a wing in the mask should have
  real(rp), parameter :: ROUNDING = 1.0e-9_rp
  integer, parameter :: N_SAMPLES = 64   !< in one beat
  character(*), parameter :: AXES = 'xyz'

contains

  !> Fails if a wing leaves the box. Also fails if two wings, or a wing and a periodic image of a wing, are closer to each other
  !> than `least_gap`. No rank waits for another.
  subroutine check_flight(wings, grid, failure)
    type(flapping_wings_t), intent(in) :: wings
    type(grid_t), intent(in) :: grid
    type(failure_t), intent(inout) :: failure
    type(gap_t) :: gap
    integer :: i, axis
    do i = 1, size(wings%surfaces)
      axis = way_out(wings%surfaces(i), grid)
      if (axis == 0) cycle
      call failure%raise('at t = '//rounded(wings%time)//' the '//trim(wings%params%wings(i)%side)// &
                         ' wing leaves the box'//direction(wings%surfaces(i), grid, axis))
      return
    end do
    gap = smallest_gap(wings%surfaces, least_gap(wings%params, grid, allocated(wings%deformation)), periods(grid))
    if (gap%first == 0) return
    if (wings%params%thin%is_thin) then
      call failure%raise('at t = '//rounded(wings%time)//' the '//contact(gap, wings%params, grid, ' wing comes too close to ')// &
                         ': set a larger distance between them ([Insects] x_pivot_l, x_pivot_r, or the motion), a finer grid '// &
                         'or stiffer wings ([Wing])')
    else
      call failure%raise('at t = '//rounded(wings%time)//' the '//contact(gap, wings%params, grid, ' wing touches '))
    end if
  end subroutine check_flight

  !> Returns the smallest distance [L] between wings that the flow can represent: for wings in the mask their thickness, because
  !> the mask cannot separate closer ones; for flexible wings without thickness a grid spacing, because the flow cannot enter a
  !> smaller gap. It is 0 for rigid wings without thickness, whose forces show in each step whether they are too close
  !> (fsi_thin_wings).
  pure real(rp) function least_gap(flight, grid, flexible)
    type(flight_params_t), intent(in) :: flight
    type(grid_t), intent(in) :: grid
    logical, intent(in) :: flexible
    least_gap = 2*flight%half_thickness
    if (flight%thin%is_thin) least_gap = merge(grid%max_spacing(), 0.0_rp, flexible)
  end function least_gap

  !> Finds faults of a flight before it begins. It moves the wings, without bending them, over the ramp and the first beat until
  !> `t_end` [T], and checks whether they leave the box, whether they touch, and whether they are thinner than the mask resolves. It
  !> is a mistake if flexible wings leave the box, because the run would stop, and a remark if rigid wings leave it, because the
  !> flow is periodic.
  subroutine foresee_flight(config, flight, grid, t_end, flexible, errors, notices)
    type(config_t), intent(in) :: config
    type(flight_params_t), intent(in) :: flight
    type(grid_t), intent(in) :: grid
    real(rp), intent(in) :: t_end
    logical, intent(in) :: flexible
    type(message_list_t), intent(inout) :: errors, notices
    type(surface_t) :: surfaces(size(flight%wings))
    type(gap_t) :: gap
    logical :: has_left(size(flight%wings)), have_touched
    real(rp) :: time
    integer :: i, k
    if (size(flight%wings) == 0) return
    if (.not. flight%thin%is_thin .and. 2*flight%half_thickness < (CELLS - ROUNDING)*grid%max_spacing()) &
      call notices%add('the wings are '//rounded(2*flight%half_thickness/grid%max_spacing())// &
                       ' cells thick: with less than 4 the mask resolves them badly and more of the flow leaks through')
    do i = 1, size(flight%wings)
      if (size(flight%wings(i)%points) == 0) return ! the shape could not be read, which has been reported
      call surfaces(i)%init(flight%wings(i)%points, flight%wings(i)%triangles, flight%wings(i)%color)
    end do
    has_left = .false.
    have_touched = .false.
    do k = 0, N_SAMPLES
      time = duration(flight, t_end)*k/N_SAMPLES
      call place(flight, time, surfaces)
      do i = 1, size(surfaces)
        if (has_left(i) .or. way_out(surfaces(i), grid) == 0) cycle
        has_left(i) = .true.
        call tell_leaving(i)
      end do
      if (have_touched) cycle
      gap = smallest_gap(surfaces, least_gap(flight, grid, flexible), periods(grid))
      have_touched = gap%first > 0
      if (have_touched) call notices%add('at t = '//rounded(time)//' the '// &
                                         contact(gap, flight, grid, ' wing, if it does not bend, '// &
                                                 trim(merge('comes too close to ', 'touches            ', &
                                                            flight%thin%is_thin))//' '))
    end do

  contains

    !> Reports that a wing leaves the box: a mistake for flexible wings, a notice for rigid ones.
    subroutine tell_leaving(wing)
      integer, intent(in) :: wing
      character(:), allocatable :: what
      what = direction(surfaces(wing), grid, way_out(surfaces(wing), grid))
      if (flexible) then
        call config%complain(errors, 'Insects', 'x0', 'the '//trim(flight%wings(wing)%side)// &
                             ' wing, if it does not bend, leaves the box at t = '//rounded(time)//what)
      else
        call notices%add('at t = '//rounded(time)//' the '//trim(flight%wings(wing)%side)//' wing leaves the box'// &
                         what//'; because of periodicity, it enters again from the other side')
      end if
    end subroutine tell_leaving
  end subroutine foresee_flight

  !> Sets the surfaces of the unbent wings at `time` [T].
  subroutine place(flight, time, surfaces)
    type(flight_params_t), intent(in) :: flight
    real(rp), intent(in) :: time
    type(surface_t), intent(inout) :: surfaces(:)
    type(wing_pose_t) :: pose
    integer :: i
    do i = 1, size(surfaces)
      call pose_wing(flight%motion%at(time, flight%body), flight%wings(i)%mount, flight%wings(i)%motion, time, pose)
      call surfaces(i)%place_at(flight%wings(i)%points, pose)
    end do
  end subroutine place

  !> Returns the time [T] of the longest ramp and beat, but no more than the run lasts.
  pure real(rp) function duration(flight, t_end)
    type(flight_params_t), intent(in) :: flight
    real(rp), intent(in) :: t_end
    integer :: i
    duration = 0
    do i = 1, size(flight%wings)
      associate (motion => flight%wings(i)%motion)
        duration = max(duration, motion%ramp + 1/motion%frequency)
      end associate
    end do
    duration = min(duration, t_end)
  end function duration

  !> Returns the first direction in which points of a surface lie outside the box, or 0 if all points lie inside. It ignores x in a
  !> two-dimensional flow, where the wing is a section without a position along x.
  pure integer function way_out(surface, grid) result(axis)
    type(surface_t), intent(in) :: surface
    type(grid_t), intent(in) :: grid
    do axis = merge(2, 1, grid%is_2d), 3
      if (minval(surface%points(axis, :)) < -ROUNDING*grid%length(axis)) return
      if (maxval(surface%points(axis, :)) > (1 + ROUNDING)*grid%length(axis)) return
    end do
    axis = 0
  end function way_out

  !> Returns how far a surface that leaves the box reaches along this axis.
  function direction(surface, grid, axis) result(text)
    type(surface_t), intent(in) :: surface
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: axis
    character(:), allocatable :: text
    text = ' in the direction '//AXES(axis:axis)//': it reaches from '//rounded(minval(surface%points(axis, :)))// &
           ' to '//rounded(maxval(surface%points(axis, :)))//', the box from 0 to '//number_text(grid%length(axis))
  end function direction

  !> Returns the periods of the flow [L]. A two-dimensional flow has none along x.
  pure function periods(grid) result(length)
    type(grid_t), intent(in) :: grid
    real(rp) :: length(3)
    length = grid%length
    if (grid%is_2d) length(1) = 0
  end function periods

  !> Returns which wings do what `verb` says, and their distance.
  function contact(gap, flight, grid, verb) result(text)
    type(gap_t), intent(in) :: gap
    type(flight_params_t), intent(in) :: flight
    type(grid_t), intent(in) :: grid
    character(*), intent(in) :: verb
    character(:), allocatable :: text
    text = trim(flight%wings(gap%first)%side)//verb//'the '//trim(flight%wings(gap%second)%side)//' wing'
    if (gap%is_image) text = text//' beyond a periodic boundary of the box'
    text = text//': '//rounded(gap%distance)//' L are between them, and '
    if (flight%thin%is_thin) then
      text = text//'the flow cannot enter a gap below a grid spacing, '//rounded(grid%max_spacing())//' L'
    else
      text = text//'the wings are '//rounded(2*flight%half_thickness)//' L thick'
    end if
  end function contact

  !> Returns a number with four digits as text.
  function rounded(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    character(16) :: buffer
    real(rp) :: y
    write (buffer, '(es16.3)') x
    read (buffer, *) y
    text = number_text(y)
  end function rounded
end module fsi_flight_faults

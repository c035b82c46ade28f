! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks whether wings are in the box and fit into it.
module fsi_flight_checks
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_flight_params, only: flapping_wing_t, flight_params_t
  use fsi_kinematics, only: pose_wing, wing_pose_t
  use io_config, only: config_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: check_place, check_room

  character(*), parameter :: SECTION = 'Insects'
  character(*), parameter :: TWO_D = 'is 1: a two-dimensional flow uses the section of the wings at x = 0, and for this '
  integer, parameter :: N_SAMPLES = 64 !< in one beat
  real(rp), parameter :: ROUNDING = 1.0e-9_rp

contains

  !> Reports a body whose centre is outside of the box, unless another message says that the body does not fit into it.
  subroutine check_place(config, flight, grid, errors)
    type(config_t), intent(in) :: config
    type(flight_params_t), intent(in) :: flight
    type(grid_t), intent(in) :: grid
    type(message_list_t), intent(inout) :: errors
    integer :: i
    do i = 1, errors%count()
      if (index(errors%text(i), ': ['//SECTION//'] BodyType: is larger than the box') > 0) return
    end do
    if (any(flight%body%centre < 0 .or. flight%body%centre > grid%length)) &
      call config%complain(errors, SECTION, 'x0', 'is outside of the box, which begins at 0 and has the size '// &
                           number_text(grid%length(1))//' x '//number_text(grid%length(2))//' x '// &
                           number_text(grid%length(3))//' L')
  end subroutine check_place

  !> Reports a wing that does not fit into the box. At some time in the first beats it is longer than the box in the direction of x,
  !> y or z, so that it meets its own periodic image.
  subroutine check_room(config, flight, grid, t_end, errors)
    type(config_t), intent(in) :: config
    type(flight_params_t), intent(in) :: flight
    type(grid_t), intent(in) :: grid
    real(rp), intent(in) :: t_end !< end of the run, T
    type(message_list_t), intent(inout) :: errors
    character(2), parameter :: BOX(3) = ['xl', 'yl', 'zl']
    real(rp) :: extent(3), margin
    integer :: i, axis
    margin = 2*(flight%half_thickness + flight%smoothing)
    do i = 1, size(flight%wings)
      if (size(flight%wings(i)%points) == 0) cycle ! its shape could not be read, which has been reported
      if (grid%is_2d) call check_section(config, flight, flight%wings(i), t_end, errors)
      extent = largest_extent(flight, flight%wings(i), t_end) + margin
      do axis = merge(2, 1, grid%is_2d), 3
        if (extent(axis) <= grid%length(axis)) cycle
        call config%complain(errors, 'Geometry', BOX(axis), 'is too small: with its thickness the '// &
                             trim(flight%wings(i)%side)//' wing extends over '//number_text(extent(axis))// &
                             ' L in this direction, and the box over '//number_text(grid%length(axis))//' L')
      end do
    end do
  end subroutine check_room

  !> Reports a wing that a two-dimensional flow cannot represent as a section. The wing must be a flat strip, one unit wide along y
  !> of its frame, so that results are per unit depth, and this axis must lie along x at all times.
  subroutine check_section(config, flight, wing, t_end, errors)
    type(config_t), intent(in) :: config
    type(flight_params_t), intent(in) :: flight
    type(flapping_wing_t), intent(in) :: wing
    real(rp), intent(in) :: t_end
    type(message_list_t), intent(inout) :: errors
    type(wing_pose_t) :: pose
    real(rp) :: width, lean, reach, x(2)
    integer :: i
    width = maxval(wing%points(2, :)) - minval(wing%points(2, :))
    if (abs(width - 1) > ROUNDING .or. any(abs(wing%points(3, :)) > ROUNDING)) then
      call config%complain(errors, 'Resolution', 'nx', TWO_D//'a wing must be a flat strip 1 L wide; this one is '// &
                           number_text(width)//' L wide')
      return
    end if
    lean = 0
    do i = 0, N_SAMPLES
      call pose_at(flight, wing, duration(wing, t_end)*i/N_SAMPLES, pose)
      lean = max(lean, 1 - abs(pose%matrix(2, 1)))
    end do
    reach = flight%half_thickness + flight%smoothing
    x = pose%hinge(1) + sign(1.0_rp, pose%matrix(2, 1))*[minval(wing%points(2, :)), maxval(wing%points(2, :))]
    if (lean > ROUNDING) then
      call config%complain(errors, 'Resolution', 'nx', TWO_D//'the chord of the wing (y of its file) must lie along x at all times')
    else if (maxval(x) < reach .or. minval(x) > -reach) then
      call config%complain(errors, SECTION, 'x0', 'puts the wing between x = '//number_text(minval(x))//' and '// &
                           number_text(maxval(x))//' L; in a two-dimensional flow it must reach at least from '// &
                           number_text(-reach)//' to '//number_text(reach))
    end if
  end subroutine check_section

  !> Returns the wing at `time`.
  subroutine pose_at(flight, wing, time, pose)
    type(flight_params_t), intent(in) :: flight
    type(flapping_wing_t), intent(in) :: wing
    real(rp), intent(in) :: time
    type(wing_pose_t), intent(out) :: pose
    call pose_wing(flight%motion%at(time, flight%body), wing%mount, wing%motion, time, pose)
  end subroutine pose_at

  !> Returns the time of the ramp and one beat, or of the run if it is shorter, T.
  pure real(rp) function duration(wing, t_end)
    type(flapping_wing_t), intent(in) :: wing
    real(rp), intent(in) :: t_end
    duration = min(t_end, wing%motion%ramp + 1/wing%motion%frequency)
  end function duration

  !> Returns the largest extents [L] of the points of a wing along x, y and z, over the time of its ramp and one beat, as far as
  !> the run goes.
  function largest_extent(flight, wing, t_end) result(extent)
    type(flight_params_t), intent(in) :: flight
    type(flapping_wing_t), intent(in) :: wing
    real(rp), intent(in) :: t_end
    real(rp) :: extent(3)
    type(wing_pose_t) :: pose
    real(rp), allocatable :: placed(:, :)
    integer :: i
    extent = 0
    do i = 0, N_SAMPLES
      call pose_at(flight, wing, duration(wing, t_end)*i/N_SAMPLES, pose)
      placed = matmul(transpose(pose%matrix), wing%points)
      extent = max(extent, maxval(placed, 2) - minval(placed, 2))
    end do
  end function largest_extent
end module fsi_flight_checks

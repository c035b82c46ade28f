! SPDX-License-Identifier: GPL-3.0-or-later
!> What can go wrong with wings on their way: they touch, or they leave the box.
module app_flight_faults
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flight_params, only: flight_params_t
  use fsi_kinematics, only: pose_wing, wing_pose_t
  use fsi_wing_gap, only: gap_t, smallest_gap
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: check_gaps, notice_flight

  real(rp), parameter :: CELLS = 4       !< of thickness that a wing in the mask should have
  real(rp), parameter :: ROUNDING = 1.0e-9_rp
  integer, parameter :: LOOKS = 64       !< in one beat
  character(*), parameter :: AXES = 'xyz'

contains

  !> Fails if wings are closer to each other, or to a periodic image of a wing, than they are thick in the mask,
  !> which then cannot tell them apart.
  subroutine check_gaps(wings, grid, failure)
    type(flapping_wings_t), intent(in) :: wings
    type(grid_t), intent(in) :: grid
    type(failure_t), intent(inout) :: failure
    type(gap_t) :: gap
    real(rp) :: thickness, length(3)
    character(:), allocatable :: other
    thickness = 2*wings%params%half_thickness
    length = grid%length
    if (grid%is_2d) length(1) = 0
    gap = smallest_gap(wings%surfaces, thickness, length)
    if (gap%first == 0) return
    other = 'the '//trim(wings%params%wings(gap%second)%side)//' wing'
    if (gap%is_image) other = other//' beyond a side of the periodic box'
    call failure%raise('at t = '//number_text(wings%time)//' the '//trim(wings%params%wings(gap%first)%side)// &
                     ' wing touches '//other//': '//number_text(gap%distance)//' L are between them, and wings are '// &
                       number_text(thickness)//' L thick')
  end subroutine check_gaps

  !> Remarks on wings that are thinner than the mask resolves, and on wings that leave the box while they are not
  !> bent, over ramp and first beat until `t_end` [T].
  subroutine notice_flight(flight, grid, t_end, notices)
    type(flight_params_t), intent(in) :: flight
    type(grid_t), intent(in) :: grid
    real(rp), intent(in) :: t_end
    type(message_list_t), intent(inout) :: notices
    type(wing_pose_t) :: pose
    real(rp) :: low(3), high(3), point(3), duration
    integer :: i, k, p, axis
    if (2*flight%half_thickness < (CELLS - ROUNDING)*grid%max_spacing()) &
      call notices%add('the wings are '//number_text(2*flight%half_thickness/grid%max_spacing())// &
                       ' cells thick: with less than 4 the mask resolves them badly and more of the flow leaks through')
    do i = 1, size(flight%wings)
      associate (wing => flight%wings(i))
        if (size(wing%points) == 0) cycle
        low = huge(1.0_rp)
        high = -huge(1.0_rp)
        duration = min(t_end, wing%motion%ramp + 1/wing%motion%frequency)
        do k = 0, LOOKS
          call pose_wing(flight%body, wing%mount, wing%motion, duration*k/LOOKS, pose)
          do p = 1, size(wing%points, 2)
            point = pose%point_to_space(wing%points(:, p))
            low = min(low, point)
            high = max(high, point)
          end do
        end do
        do axis = merge(2, 1, grid%is_2d), 3
          if (low(axis) < -flight%half_thickness .or. high(axis) > grid%length(axis) + flight%half_thickness) &
            call notices%add('the '//trim(wing%side)//' wing leaves the box in the direction '//AXES(axis:axis)// &
                             ' and comes in again from the other side, as the flow does: it reaches from '// &
                             number_text(low(axis))//' to '//number_text(high(axis))//', the box from 0 to '// &
                             number_text(grid%length(axis)))
        end do
      end associate
    end do
  end subroutine notice_flight
end module app_flight_faults

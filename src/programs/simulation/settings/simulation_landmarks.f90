! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds on the wings of a run the landmarks that [Saving] names.
module simulation_landmarks
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_flight_params, only: flight_params_t
  use fsi_kinematics_keys, only: SIDES
  use fsi_wing_source, only: source_choices, source_choices_t
  use io_config, only: config_t
  use simulation_output_params, only: landmarks_key, output_params_t
  implicit none
  private
  public :: mark_wings, mark_wing

contains

  !> Gives the wings of `flight` the landmarks of `output`, whose lengths are in units of `file_unit` [L]. Adds a mistake for a wing
  !> that is not there, and for a point that is not on its wing.
  subroutine mark_wings(config, file_unit, output, flight, errors)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: file_unit
    type(output_params_t), intent(in) :: output
    type(flight_params_t), intent(inout) :: flight
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: fault
    integer :: i
    do i = 1, size(output%landmarks)
      if (size(output%landmarks(i)%rows) == 0) cycle
      call mark_wing(config, i, transpose(output%landmarks(i)%rows)/file_unit, flight, fault)
      if (fault /= '') call config%complain(errors, 'Saving', landmarks_key(i), fault)
    end do
  end subroutine mark_wings

  !> Gives the wing of SIDES(side) the landmarks sites(2, n) [L], points of the flat wing before it is stretched. `fault` says what
  !> is wrong with the first one that is wrong, or is empty.
  subroutine mark_wing(config, side, sites, flight, fault)
    type(config_t), intent(in) :: config
    integer, intent(in) :: side
    real(rp), intent(in) :: sites(:, :)
    type(flight_params_t), intent(inout) :: flight
    character(:), allocatable, intent(out) :: fault
    type(source_choices_t) :: source
    real(rp) :: stretched(2, size(sites, 2))
    integer :: w, c, lost
    fault = ''
    source = source_choices(config)
    do c = 1, 2
      stretched(c, :) = sites(c, :)*source%stretch(c)
    end do
    do w = 1, size(flight%wings)
      if (flight%wings(w)%side /= SIDES(side)) cycle
      associate (wing => flight%wings(w))
        call wing%landmarks%find(wing%points, wing%triangles, stretched, lost)
        if (lost > 0) fault = 'point '//number_text(lost)//' is not on the wing, which reaches from '//extent(wing%points)// &
                              ' of its frame'
      end associate
      return
    end do
    fault = 'there is no '//trim(SIDES(side))//' wing'

  contains

    !> Returns in words the smallest and the largest x and y of a wing before it is stretched.
    function extent(points) result(text)
      real(rp), intent(in) :: points(:, :)
      character(:), allocatable :: text
      real(rp), parameter :: DIGITS = 1.0e4_rp !< shown of one L
      real(rp) :: least(2), most(2)
      least = nint(DIGITS*minval(points(:2, :), 2)/source%stretch)/DIGITS
      most = nint(DIGITS*maxval(points(:2, :), 2)/source%stretch)/DIGITS
      text = number_text(least(1))//' to '//number_text(most(1))//' L in x and '//number_text(least(2))//' to '// &
             number_text(most(2))//' L in y'
    end function extent

  end subroutine mark_wing
end module simulation_landmarks

! SPDX-License-Identifier: GPL-3.0-or-later
!> Maps points of a surface as a profilometer shows them: (x, y) at scale R (x, y) + shift, R the rotation by the angle
!> `map_rotation`, and the height z as height_scale z.
module measurement_map
  use base_kinds, only: rp
  use measurement_instrument, only: instrument_t
  use measurement_instrument_causes, only: HEIGHT_SCALE, MAP_ROTATION, MAP_SCALE, MAP_SHIFT_X, MAP_SHIFT_Y, PISTON, TILT_X, &
                                           TILT_Y
  implicit none
  private
  public :: map_positions, map_position_derivatives, map_parameter_derivatives, plane_height, plane_slope

contains

  !> Returns seen(3, n) [m], where the instrument shows positions(3, n) [m]. It equals positions to the last bit if the instrument
  !> has no effect.
  pure subroutine map_positions(instrument, positions, seen)
    type(instrument_t), intent(in) :: instrument
    real(rp), intent(in) :: positions(:, :)
    real(rp), intent(out) :: seen(:, :)
    if (instrument%is_null(MAP_SHIFT_X, MAP_SCALE)) then
      seen(:2, :) = positions(:2, :)
    else
      seen(:2, :) = matmul(turning(instrument), positions(:2, :))
      seen(1, :) = seen(1, :) + instrument%values(MAP_SHIFT_X)
      seen(2, :) = seen(2, :) + instrument%values(MAP_SHIFT_Y)
    end if
    seen(3, :) = instrument%values(HEIGHT_SCALE)*positions(3, :)
  end subroutine map_positions

  !> Returns the derivatives of the shown positions for the derivatives motion(3, n) of the true positions.
  pure subroutine map_position_derivatives(instrument, motion, seen)
    type(instrument_t), intent(in) :: instrument
    real(rp), intent(in) :: motion(:, :)
    real(rp), intent(out) :: seen(:, :)
    if (instrument%is_null(MAP_SHIFT_X, MAP_SCALE)) then
      seen(:2, :) = motion(:2, :)
    else
      seen(:2, :) = matmul(turning(instrument), motion(:2, :))
    end if
    seen(3, :) = instrument%values(HEIGHT_SCALE)*motion(3, :)
  end subroutine map_position_derivatives

  !> Returns motion(3, n), the derivatives of the shown positions of positions(3, n) with respect to the coordinate of parameter
  !> `number`, per log unit of both scales; 0 for parameters of anything but the map.
  pure subroutine map_parameter_derivatives(instrument, number, positions, motion)
    type(instrument_t), intent(in) :: instrument
    integer, intent(in) :: number
    real(rp), intent(in) :: positions(:, :)
    real(rp), intent(out) :: motion(:, :)
    real(rp) :: m(2, 2)
    motion = 0
    select case (number)
    case (MAP_SHIFT_X)
      motion(1, :) = 1
    case (MAP_SHIFT_Y)
      motion(2, :) = 1
    case (MAP_ROTATION)
      m = turning(instrument)
      motion(:2, :) = matmul(reshape([m(1, 2), m(2, 2), -m(1, 1), -m(2, 1)], [2, 2]), positions(:2, :))
    case (MAP_SCALE)
      motion(:2, :) = matmul(turning(instrument), positions(:2, :))
    case (HEIGHT_SCALE)
      motion(3, :) = instrument%values(HEIGHT_SCALE)*positions(3, :)
    end select
  end subroutine map_parameter_derivatives

  !> Returns scale times rotation.
  pure function turning(instrument) result(m)
    type(instrument_t), intent(in) :: instrument
    real(rp) :: m(2, 2)
    associate (angle => instrument%values(MAP_ROTATION))
      m(:, 1) = [cos(angle), sin(angle)]
      m(:, 2) = [-sin(angle), cos(angle)]
    end associate
    m = instrument%values(MAP_SCALE)*m
  end function turning

  !> Returns the height [m] that loaded maps show in addition at (x, y) [m].
  pure real(rp) function plane_height(instrument, x, y) result(height)
    type(instrument_t), intent(in) :: instrument
    real(rp), intent(in) :: x, y
    height = instrument%values(TILT_X)*y - instrument%values(TILT_Y)*x + instrument%values(PISTON)
  end function plane_height

  !> Returns the derivative of this additional height with respect to parameter `number`.
  pure real(rp) function plane_slope(number, x, y) result(slope)
    integer, intent(in) :: number
    real(rp), intent(in) :: x, y
    slope = 0
    if (number == TILT_X) slope = y
    if (number == TILT_Y) slope = -x
    if (number == PISTON) slope = 1
  end function plane_slope
end module measurement_map

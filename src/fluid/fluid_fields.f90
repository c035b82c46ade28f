! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes dense fields from sparse lists, for output.
module fluid_fields
  use base_kinds, only: rp
  use fluid_penalty, only: penalty_t
  implicit none
  private
  public :: mask_field, solid_velocity_field

contains

  !> Sets the field to the mask chi on this rank's block, (nx, ny_local, nz_local).
  subroutine mask_field(penalty, field)
    type(penalty_t), intent(in) :: penalty
    real(rp), intent(inout) :: field(:, :, :)
    call spread_points(penalty, penalty%chi, field)
  end subroutine mask_field

  !> Sets the field to component `c` of the velocity of the solids [L/T] where chi > 0, and to zero elsewhere.
  subroutine solid_velocity_field(penalty, c, field)
    type(penalty_t), intent(in) :: penalty
    integer, intent(in) :: c
    real(rp), intent(inout) :: field(:, :, :)
    call spread_points(penalty, penalty%us(c, :), field)
  end subroutine solid_velocity_field

  !> Makes a field that has the values at the points of the penalty and is 0 elsewhere.
  subroutine spread_points(penalty, values, field)
    type(penalty_t), intent(in) :: penalty
    real(rp), intent(in) :: values(:)
    real(rp), intent(inout) :: field(:, :, :)
    integer :: y, z, i, line
    field = 0
    do z = 1, size(field, 3)
      do y = 1, size(field, 2)
        line = y + size(field, 2)*(z - 1)
        do i = penalty%line_first(line), penalty%line_last(line)
          field(penalty%x(i), y, z) = values(i)
        end do
      end do
    end do
  end subroutine spread_points
end module fluid_fields

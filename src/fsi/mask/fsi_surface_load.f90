! SPDX-License-Identifier: GPL-3.0-or-later
!> Sums forces on the points of a moving surface to force, moment and power.
module fsi_surface_load
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  use fsi_rotation, only: cross
  implicit none
  private
  public :: surface_load_t, total_load

  !> Loads of one wing at one time, code units with density 1; comparable to wing_loads_t, which has the loads from the
  !> penalization.
  type, extends(visited_t) :: surface_load_t
    real(rp) :: force(3) = 0  !< in space, rho L^4/T^2
    real(rp) :: moment(3) = 0 !< about the hinge, in space, rho L^5/T^2
    real(rp) :: power = 0     !< from the wing to the flow: minus the sum of force times velocity, rho L^5/T^3
  contains
    procedure :: visit => load_visit
  end type surface_load_t

contains

  !> Shows every component to the visitor.
  subroutine load_visit(self, visitor)
    class(surface_load_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('force', self%force)
    call visitor%visit('moment', self%moment)
    call visitor%visit('power', self%power)
  end subroutine load_visit

  !> Returns the sums over n points. All arrays are (3, n); `hinge` and `points` are in space.
  pure type(surface_load_t) function total_load(forces, points, velocities, hinge) result(total)
    real(rp), intent(in) :: forces(:, :), points(:, :), velocities(:, :), hinge(3)
    integer :: p
    do p = 1, size(points, 2)
      total%force = total%force + forces(:, p)
      total%moment = total%moment + cross(points(:, p) - hinge, forces(:, p))
      total%power = total%power - dot_product(forces(:, p), velocities(:, p))
    end do
  end function total_load
end module fsi_surface_load

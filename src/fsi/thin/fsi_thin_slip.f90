! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds what a step leaves between the flow and wings without thickness: the slip, and the power that passes from wings to flow.
module fsi_thin_slip
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  implicit none
  private
  public :: slip_t

  !> Slip of the flow relative to the wings after a step, L/T, and the power that the flow receives.
  type, extends(visited_t) :: slip_t
    real(rp) :: before = 0   !< largest |U - I u*|, before the forces act
    real(rp) :: after = 0    !< largest |U - I u(n+1)|
    real(rp) :: speed = 0    !< largest |U|
    logical :: is_measured = .false. !< `after`, `received` and `lost` are of the last step; otherwise of an earlier one
    real(rp) :: lost = 0     !< rho L^5/T^3 power that the wings lose, F.(U(n) + U(n+1))/2
    real(rp) :: received = 0 !< that the flow receives: less by F.(U - I u(n+1)), the power of the slip
    integer :: iterations = 0 !< iterations for the forces of several rigid wings together
    real(rp) :: left = 0      !< share of the earlier slip that the last iteration left
  contains
    procedure :: visit => slip_visit
  end type slip_t

contains

  !> Shows every component to the visitor.
  subroutine slip_visit(self, visitor)
    class(slip_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('before', self%before)
    call visitor%visit('after', self%after)
    call visitor%visit('speed', self%speed)
    call visitor%visit('is_measured', self%is_measured)
    call visitor%visit('received', self%received)
    call visitor%visit('lost', self%lost)
    call visitor%visit('iterations', self%iterations)
    call visitor%visit('left', self%left)
  end subroutine slip_visit
end module fsi_thin_slip

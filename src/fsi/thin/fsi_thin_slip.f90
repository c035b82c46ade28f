! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds what a step leaves between the flow and wings without thickness: the slip, and the power that passes from wings to flow.
module fsi_thin_slip
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  implicit none
  private
  public :: slip_t, largest

  !> Slip of the flow relative to the wings after a step, L/T, and the power that the flow receives.
  type, extends(visited_t) :: slip_t
    real(rp) :: before = 0   !< largest |U - I u*|, before the forces act
    real(rp) :: after = 0    !< largest |U - I u(n+1)|
    real(rp) :: speed = 0    !< largest |U|
    real(rp) :: time = 0     !< T at which the last step began
    logical :: is_due = .false. !< the slip after the last step is wanted, and has not been taken yet
    logical :: is_measured = .false. !< `after` and `received` are of the last step that was due; otherwise of the one before
    real(rp) :: lost = 0     !< rho L^5/T^3 power that the wings lose, F.(U(n) + U(n+1))/2
    real(rp) :: received = 0 !< that the flow receives: less by F.(U - I u(n+1)), the power of the slip
    integer :: iterations = 0 !< iterations for the forces of several rigid wings together
    real(rp) :: left = 0      !< share of the earlier slip that the last iteration left
  contains
    procedure :: measure => slip_measure
    procedure :: visit => slip_visit
  end type slip_t

contains

  !> Sets what the slip after a step, slip(3, n) [L/T] at the markers, says; `lost` must be set. The forces(3, n) [rho L^4/T^2] of
  !> the step have acted on the flow at the markers.
  pure subroutine slip_measure(self, slip, forces)
    class(slip_t), intent(inout) :: self
    real(rp), intent(in) :: slip(:, :), forces(:, :)
    self%after = largest(slip)
    self%received = self%lost - sum(forces*slip)
    self%is_measured = .true.
  end subroutine slip_measure

  !> Returns the largest length of the vectors v(3, n).
  pure real(rp) function largest(v)
    real(rp), intent(in) :: v(:, :)
    integer :: i
    largest = 0
    do i = 1, size(v, 2)
      largest = max(largest, norm2(v(:, i)))
    end do
  end function largest

  !> Shows every component to the visitor.
  subroutine slip_visit(self, visitor)
    class(slip_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('before', self%before)
    call visitor%visit('after', self%after)
    call visitor%visit('speed', self%speed)
    call visitor%leave_out('time is_due') ! a checkpoint follows a pass, which measures what is due
    call visitor%visit('is_measured', self%is_measured)
    call visitor%visit('received', self%received)
    call visitor%visit('lost', self%lost)
    call visitor%visit('iterations', self%iterations)
    call visitor%visit('left', self%left)
  end subroutine slip_visit
end module fsi_thin_slip

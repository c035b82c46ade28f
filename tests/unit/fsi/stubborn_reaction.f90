! SPDX-License-Identifier: GPL-3.0-or-later
!> The load of the flow on a wing without thickness that forces the wing to make its step in parts: a load that is not a number
!> makes every attempt fail that is not to succeed. It records what the wing feels.
module stubborn_reaction
  use base_kinds, only: rp
  use fsi_flow_reaction, only: flow_reaction_t
  use solid_motion, only: frame_t, motion_t
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  implicit none
  private
  public :: stubborn_reaction_t, speeding_motion_t

  !> Fails in a part that is longer than the step over `least`, and in the second half if `splits_later`.
  type, extends(flow_reaction_t) :: stubborn_reaction_t
    integer :: least = 1
    logical :: splits_later = .false.
    real(rp), allocatable :: felt(:, :)          !< (3, n_all) [N] mean force of the step, as the loads on the wing imply it
    real(rp), allocatable, private :: load(:, :) !< (3, n_all) [N] last load
    real(rp), allocatable, private :: force_before(:, :) !< (3, n_all) [N] mean force of the last part that has ended
    real(rp), private :: r = 0
    integer, private :: n = 1, k = 0
  contains
    procedure :: begin_part => stubborn_begin_part
    procedure :: end_part => stubborn_end_part
    procedure :: force => stubborn_force
  end type stubborn_reaction_t

  !> A frame that does not turn and gains speed evenly, from `velocity` [m/s] at time 0.
  type, extends(motion_t) :: speeding_motion_t
    real(rp) :: velocity(3) = 0, acceleration(3) = 0
  contains
    procedure :: at => speeding_at
  end type speeding_motion_t

contains

  subroutine stubborn_begin_part(self, frame, u, v, parts, done, ratio)
    class(stubborn_reaction_t), intent(inout) :: self
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :), ratio
    integer, intent(in) :: parts, done
    call self%flow_reaction_t%begin_part(frame, u, v, parts, done, ratio)
    self%n = parts
    self%k = done
    self%r = ratio
    if (done == 0) self%felt = 0*u
    if (.not. allocated(self%force_before)) self%force_before = 0*u
  end subroutine stubborn_begin_part

  !> The load is ((1 + 2 r) F - r F_before)/(1 + r).
  subroutine stubborn_end_part(self)
    class(stubborn_reaction_t), intent(inout) :: self
    call self%flow_reaction_t%end_part()
    self%force_before = ((1 + self%r)*self%load + self%r*self%force_before)/(1 + 2*self%r)
    self%felt = self%felt + self%force_before/self%n
  end subroutine stubborn_end_part

  subroutine stubborn_force(self, frame, u, v, f)
    class(stubborn_reaction_t), intent(inout) :: self
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :)
    real(rp), intent(inout) :: f(:, :)
    call self%flow_reaction_t%force(frame, u, v, f)
    self%load = f
    if (self%n < self%least .or. self%splits_later .and. self%n == 2 .and. self%k == 1) f = ieee_value(f, ieee_quiet_nan)
  end subroutine stubborn_force

  function speeding_at(self, time) result(frame)
    class(speeding_motion_t), intent(in) :: self
    real(rp), intent(in) :: time
    type(frame_t) :: frame
    frame%velocity = self%velocity + time*self%acceleration
    frame%acceleration = self%acceleration
  end function speeding_at
end module stubborn_reaction

! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes rotating frames with exact angular velocity and acceleration.
!>
!> A frame is reached from its parent by a chain of turns about coordinate axes. M takes components from
!> the parent into the frame, v_frame = M v_parent (a passive rotation), and M' = -[omega]x M. For
!> M = R(axis e, angle a) N the chain rule gives, in components of the new frame,
!>
!>     omega  = R omega_N + a' e,     omega' = R omega_N' - a' e x R omega_N + a'' e.
!>
!> R about x is [1 0 0; 0 c s; 0 -s c], and cyclic: FLUSI's matrices (Engels et al., SIAM J. Sci. Comput.
!> 38, S3, 2016).
module fsi_rotation
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  implicit none
  private
  public :: angle_t, rotation_t, cross

  real(rp), parameter :: IDENTITY(3, 3) = &
                         reshape([1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp], [3, 3])

  !> An angle and its derivatives in time.
  type :: angle_t
    real(rp) :: value = 0        !< rad
    real(rp) :: rate = 0         !< rad/T
    real(rp) :: acceleration = 0 !< rad/T^2
  contains
    procedure, private :: angle_negative
    generic :: operator(-) => angle_negative
  end type angle_t

  !> A frame that turns relative to its parent; the default is the parent itself.
  type, extends(visited_t) :: rotation_t
    real(rp) :: matrix(3, 3) = IDENTITY !< takes components from the parent into the frame
    real(rp) :: omega(3) = 0      !< angular velocity relative to the parent, components in the frame, 1/T
    real(rp) :: omega_rate(3) = 0 !< angular acceleration relative to the parent, in the frame, 1/T^2
  contains
    procedure :: visit => rotation_visit
    procedure :: turn => rotation_turn
    procedure :: turn_half => rotation_turn_half
    procedure :: after => rotation_after
    procedure :: to_frame => rotation_to_frame
    procedure :: to_parent => rotation_to_parent
  end type rotation_t

contains

  !> Shows every component to the visitor.
  subroutine rotation_visit(self, visitor)
    class(rotation_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('matrix', self%matrix)
    call visitor%visit('omega', self%omega)
    call visitor%visit('omega_rate', self%omega_rate)
  end subroutine rotation_visit

  !> Returns the opposite angle.
  pure type(angle_t) function angle_negative(self) result(negative)
    class(angle_t), intent(in) :: self
    negative = angle_t(-self%value, -self%rate, -self%acceleration)
  end function angle_negative

  !> Turns the frame about its own axis (1 x, 2 y, 3 z) by `angle`, by the right-hand rule.
  pure subroutine rotation_turn(self, axis, angle)
    class(rotation_t), intent(inout) :: self
    integer, intent(in) :: axis
    type(angle_t), intent(in) :: angle
    type(rotation_t) :: step, whole
    real(rp) :: c, s
    integer :: i, j
    i = modulo(axis, 3) + 1
    j = modulo(axis + 1, 3) + 1
    c = cos(angle%value)
    s = sin(angle%value)
    step%matrix(i, i) = c
    step%matrix(i, j) = s
    step%matrix(j, i) = -s
    step%matrix(j, j) = c
    step%omega(axis) = angle%rate
    step%omega_rate(axis) = angle%acceleration
    whole = step%after(self)
    self%matrix = whole%matrix
    self%omega = whole%omega
    self%omega_rate = whole%omega_rate
  end subroutine rotation_turn

  !> Turns the frame about its own axis by exactly half a turn.
  pure subroutine rotation_turn_half(self, axis)
    class(rotation_t), intent(inout) :: self
    integer, intent(in) :: axis
    integer :: i
    do i = 1, 3
      if (i == axis) cycle
      self%matrix(i, :) = -self%matrix(i, :)
      self%omega(i) = -self%omega(i)
      self%omega_rate(i) = -self%omega_rate(i)
    end do
  end subroutine rotation_turn_half

  !> Returns the frame `self`, whose parent is the frame `first`, relative to the parent of `first`.
  pure type(rotation_t) function rotation_after(self, first) result(whole)
    class(rotation_t), intent(in) :: self
    class(rotation_t), intent(in) :: first
    real(rp) :: carried(3)
    carried = matmul(self%matrix, first%omega)
    whole%matrix = matmul(self%matrix, first%matrix)
    whole%omega = carried + self%omega
    whole%omega_rate = matmul(self%matrix, first%omega_rate) - cross(self%omega, carried) + self%omega_rate
  end function rotation_after

  !> Returns the components in the frame of a vector given in the parent.
  pure function rotation_to_frame(self, v) result(w)
    class(rotation_t), intent(in) :: self
    real(rp), intent(in) :: v(3)
    real(rp) :: w(3)
    w = matmul(self%matrix, v)
  end function rotation_to_frame

  !> Returns the components in the parent of a vector given in the frame.
  pure function rotation_to_parent(self, w) result(v)
    class(rotation_t), intent(in) :: self
    real(rp), intent(in) :: w(3)
    real(rp) :: v(3)
    v = matmul(w, self%matrix)
  end function rotation_to_parent

  !> Returns the cross product a x b.
  pure function cross(a, b) result(c)
    real(rp), intent(in) :: a(3), b(3)
    real(rp) :: c(3)
    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross
end module fsi_rotation

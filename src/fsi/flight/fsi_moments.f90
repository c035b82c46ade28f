! SPDX-License-Identifier: GPL-3.0-or-later
!> Sums mass, momentum and inertia of an insect: of one rigid part in its own frame, and of the whole with moving parts in the
!> frame of the body.
!>
!> A part has mass m = sum mu, first moment S = sum mu x and second moment E = sum mu x x', from which its tensor of inertia is J =
!> tr(E) 1 - E. Masses may be negative, because the displaced fluid is subtracted. In the body's frame a mass is at r and moves with
!> r' and r'' there; the whole has
!>
!>     sum mu r,  sum mu r',  sum mu r'',  sum mu r r^T,  sum mu r r'^T,  sum mu r r''^T.
module fsi_moments
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  use fsi_rotation, only: cross
  implicit none
  private
  public :: moments_t, whole_t, second_of_inertia, inertia_of_second, moments_of_points, cross_matrix

  !> Moments of a rigid part about the origin of its frame; rho L^3, rho L^4, rho L^5.
  type, extends(visited_t) :: moments_t
    real(rp) :: mass = 0
    real(rp) :: first(3) = 0
    real(rp) :: second(3, 3) = 0
  contains
    procedure :: visit => moments_visit
    procedure :: minus => moments_minus
  end type moments_t

  !> Sums over the whole insect at one time, about the body's origin, along the body's axes.
  type :: whole_t
    real(rp) :: mass = 0
    real(rp) :: first(3) = 0, first_rate(3) = 0, first_rate2(3) = 0
    real(rp) :: second(3, 3) = 0, mixed(3, 3) = 0, mixed2(3, 3) = 0
    real(rp) :: heavy(3) = 0 !< first moment of the parts that have weight, without displaced fluid
  contains
    procedure :: add_part => whole_add_part
    procedure :: add_moving => whole_add_moving
    procedure :: add_point => whole_add_point
    procedure :: inertia => whole_inertia
    procedure :: spin => whole_spin
    procedure :: spin_rate => whole_spin_rate
    procedure :: coriolis => whole_coriolis
  end type whole_t

contains

  !> Shows every component to the visitor.
  subroutine moments_visit(self, visitor)
    class(moments_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('mass', self%mass)
    call visitor%visit('first', self%first)
    call visitor%visit('second', self%second)
  end subroutine moments_visit

  !> Returns the difference of the moments of two parts, in the same frame.
  pure type(moments_t) function moments_minus(self, other) result(rest)
    class(moments_t), intent(in) :: self
    type(moments_t), intent(in) :: other
    rest%mass = self%mass - other%mass
    rest%first = self%first - other%first
    rest%second = self%second - other%second
  end function moments_minus

  !> Returns the moments of masses mu(n) at x(3, n).
  pure type(moments_t) function moments_of_points(mu, x) result(m)
    real(rp), intent(in) :: mu(:), x(:, :)
    integer :: i
    do i = 1, size(mu)
      m%mass = m%mass + mu(i)
      m%first = m%first + mu(i)*x(:, i)
      m%second = m%second + mu(i)*outer(x(:, i), x(:, i))
    end do
  end function moments_of_points

  !> Returns E = tr(J)/2 1 - J.
  pure function second_of_inertia(inertia) result(second)
    real(rp), intent(in) :: inertia(3, 3)
    real(rp) :: second(3, 3)
    integer :: i
    second = -inertia
    do i = 1, 3
      second(i, i) = second(i, i) + (inertia(1, 1) + inertia(2, 2) + inertia(3, 3))/2
    end do
  end function second_of_inertia

  !> Returns J = tr(E) 1 - E.
  pure function inertia_of_second(second) result(inertia)
    real(rp), intent(in) :: second(3, 3)
    real(rp) :: inertia(3, 3)
    integer :: i
    inertia = -second
    do i = 1, 3
      inertia(i, i) = inertia(i, i) + second(1, 1) + second(2, 2) + second(3, 3)
    end do
  end function inertia_of_second

  !> Adds a part that is fixed to the body, in the body's frame.
  pure subroutine whole_add_part(self, part)
    class(whole_t), intent(inout) :: self
    type(moments_t), intent(in) :: part
    self%mass = self%mass + part%mass
    self%first = self%first + part%first
    self%second = self%second + part%second
  end subroutine whole_add_part

  !> Adds a rigid part that turns about `hinge` in the body.
  pure subroutine whole_add_moving(self, part, hinge, turn, omega, omega_rate)
    class(whole_t), intent(inout) :: self
    type(moments_t), intent(in) :: part   !< in its frame, whose origin is the hinge
    real(rp), intent(in) :: hinge(3)      !< in the body
    real(rp), intent(in) :: turn(3, 3)    !< takes components from the part's frame to the body's
    real(rp), intent(in) :: omega(3)      !< relative to the body, along the part's axes, 1/T
    real(rp), intent(in) :: omega_rate(3) !< the same of the angular acceleration, 1/T^2
    real(rp) :: w(3, 3), b(3, 3), s(3), s1(3), s2(3)
    w = cross_matrix(omega)
    b = cross_matrix(omega_rate) + matmul(w, w)
    s = matmul(turn, part%first)
    s1 = matmul(turn, matmul(w, part%first))
    s2 = matmul(turn, matmul(b, part%first))
    self%mass = self%mass + part%mass
    self%first = self%first + part%mass*hinge + s
    self%first_rate = self%first_rate + s1
    self%first_rate2 = self%first_rate2 + s2
    self%second = self%second + part%mass*outer(hinge, hinge) + outer(hinge, s) + outer(s, hinge) + carried(part%second)
    self%mixed = self%mixed + outer(hinge, s1) + carried(matmul(part%second, transpose(w)))
    self%mixed2 = self%mixed2 + outer(hinge, s2) + carried(matmul(part%second, transpose(b)))

  contains

    pure function carried(tensor)
      real(rp), intent(in) :: tensor(3, 3)
      real(rp) :: carried(3, 3)
      carried = matmul(turn, matmul(tensor, transpose(turn)))
    end function carried
  end subroutine whole_add_moving

  !> Adds a mass at r with the velocity v and the acceleration a in the body's frame.
  pure subroutine whole_add_point(self, mu, r, v, a)
    class(whole_t), intent(inout) :: self
    real(rp), intent(in) :: mu, r(3), v(3), a(3)
    self%mass = self%mass + mu
    self%first = self%first + mu*r
    self%first_rate = self%first_rate + mu*v
    self%first_rate2 = self%first_rate2 + mu*a
    self%second = self%second + mu*outer(r, r)
    self%mixed = self%mixed + mu*outer(r, v)
    self%mixed2 = self%mixed2 + mu*outer(r, a)
  end subroutine whole_add_point

  !> Returns the tensor of inertia about the origin of the body.
  pure function whole_inertia(self) result(inertia)
    class(whole_t), intent(in) :: self
    real(rp) :: inertia(3, 3)
    inertia = inertia_of_second(self%second)
  end function whole_inertia

  !> Returns sum mu r x r'.
  pure function whole_spin(self) result(spin)
    class(whole_t), intent(in) :: self
    real(rp) :: spin(3)
    spin = axial(self%mixed)
  end function whole_spin

  !> Returns sum mu r x r''.
  pure function whole_spin_rate(self) result(rate)
    class(whole_t), intent(in) :: self
    real(rp) :: rate(3)
    rate = axial(self%mixed2)
  end function whole_spin_rate

  !> Returns sum mu r x (omega x r').
  pure function whole_coriolis(self, omega) result(moment)
    class(whole_t), intent(in) :: self
    real(rp), intent(in) :: omega(3)
    real(rp) :: moment(3)
    associate (k => self%mixed)
      moment = (k(1, 1) + k(2, 2) + k(3, 3))*omega - matmul(transpose(k), omega)
    end associate
  end function whole_coriolis

  !> Returns the vector with components epsilon_ijk t_jk, which is a x b for t = a b^T.
  pure function axial(t) result(v)
    real(rp), intent(in) :: t(3, 3)
    real(rp) :: v(3)
    v = [t(2, 3) - t(3, 2), t(3, 1) - t(1, 3), t(1, 2) - t(2, 1)]
  end function axial

  !> Returns the matrix that takes x to v x x.
  pure function cross_matrix(v) result(m)
    real(rp), intent(in) :: v(3)
    real(rp) :: m(3, 3)
    real(rp), parameter :: UNIT(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])
    integer :: i
    do i = 1, 3
      m(:, i) = cross(v, UNIT(:, i))
    end do
  end function cross_matrix

  !> Returns the outer product a b^T.
  pure function outer(a, b) result(t)
    real(rp), intent(in) :: a(3), b(3)
    real(rp) :: t(3, 3)
    integer :: i
    do i = 1, 3
      t(:, i) = a*b(i)
    end do
  end function outer
end module fsi_moments

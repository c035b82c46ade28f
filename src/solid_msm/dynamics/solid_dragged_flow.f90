! SPDX-License-Identifier: GPL-3.0-or-later
!> Solves x' = A x + F(x) at equal intervals of time, where F is the drag of the air on the modes of a wing, and differentiates this
!> solution.
!>
!> The states from r + 1 to 2 r are the rates p of r modes. Across the wing, point i moves with w_i = (Phi p)_i, and
!>
!>     F = -Phi^T (c a_i |w_i| w_i)
!>
!> acts on p. There are STEPS steps between two samples, of the classical Runge-Kutta method for exp(-A t) x (Lawson 1967,
!> doi:10.1137/0704033). The linear part therefore has no error, and without drag the solution is that of base_linear_flow. The
!> derivatives are those of the steps, exact but for rounding.
module solid_dragged_flow
  use base_kinds, only: rp
  use base_linear_flow, only: linear_flow_t
  implicit none
  private
  public :: drag_t, drag_change_t, dragged_flow_t

  integer, parameter :: STEPS = 4 !< of time between two samples

  !> Drag of the air on the modes of a wing.
  type :: drag_t
    real(rp) :: strength = 0                  !< [kg/m^3] c, half the density of the air times the drag coefficient
    real(rp), allocatable :: area(:)          !< (points) [m^2]
    real(rp), allocatable :: across(:, :)     !< (points, r) Phi, motion of the modes across the wing
  contains
    procedure :: force => drag_force
    procedure :: slope => drag_slope
  end type drag_t

  !> Its change; arrays of size 0 are zero.
  type :: drag_change_t
    real(rp) :: strength = 0
    real(rp), allocatable :: across(:, :)     !< (points, r)
    real(rp), allocatable :: mass(:, :)       !< (r, r) of the modes
  end type drag_change_t

  type :: dragged_flow_t
    integer, private :: r = 0, steps = 0
    logical, private :: is_driven = .false.
    type(linear_flow_t), private :: half      !< over half a step
    real(rp), allocatable, private :: x(:, :) !< (n, steps) states before each step
    real(rp), allocatable, private :: k(:, :, :) !< (r, 4, steps) forces of its stages
  contains
    procedure :: init => flow_init
    procedure :: march => flow_march
    procedure :: tangent => flow_tangent
  end type dragged_flow_t

contains

  !> Returns F(r) of the rates p(r).
  pure function drag_force(self, p) result(f)
    class(drag_t), intent(in) :: self
    real(rp), intent(in) :: p(:)
    real(rp) :: f(size(p)), w(size(self%area))
    w = matmul(self%across, p)
    f = -self%strength*matmul(self%area*abs(w)*w, self%across)
  end function drag_force

  !> Returns the derivative of F(r) at p(r), where it is f, along the change dp(r) of the rates and the `change` of the drag.
  pure function drag_slope(self, change, p, dp, f) result(df)
    class(drag_t), intent(in) :: self
    type(drag_change_t), intent(in) :: change
    real(rp), intent(in) :: p(:), dp(:), f(:)
    real(rp) :: df(size(p)), w(size(self%area)), dw(size(self%area))
    w = matmul(self%across, p)
    dw = matmul(self%across, dp)
    if (size(change%across) > 0) dw = dw + matmul(change%across, p)
    df = -matmul(self%area*abs(w)*(2*self%strength*dw + change%strength*w), self%across)
    if (size(change%across) > 0) df = df - self%strength*matmul(self%area*abs(w)*w, change%across)
    if (size(change%mass) > 0) df = df - matmul(change%mass, f)
  end function drag_slope

  !> Prepares the flow of a(n, n) [1/s] for r modes over intervals [s] >= 0, for a record that has a sample in every `sampling` [s].
  !> If it `is_driven`, the last two states belong to an input (base_linear_flow).
  subroutine flow_init(self, a, r, interval, sampling, is_driven)
    class(dragged_flow_t), intent(inout) :: self
    real(rp), intent(in) :: a(:, :), interval, sampling
    integer, intent(in) :: r
    logical, intent(in) :: is_driven
    self%r = r
    self%steps = max(1, ceiling((interval/sampling - 1.0e-9_rp)*STEPS))
    self%is_driven = is_driven
    call self%half%init(a, interval/(2*self%steps))
  end subroutine flow_init

  !> Computes x(n, :) at the times 0, h, 2 h, .. from x(:, 1), which is given, under the input(size(x, 2)) of a driven flow.
  subroutine flow_march(self, drag, x, input)
    class(dragged_flow_t), intent(inout) :: self
    type(drag_t), intent(in) :: drag
    real(rp), intent(inout) :: x(:, :)
    real(rp), intent(in) :: input(:)
    real(rp) :: y(size(x, 1)), a(size(x, 1)), e(size(x, 1)), s(size(x, 1)), h
    integer :: i, j, n
    n = (size(x, 2) - 1)*self%steps
    h = 2*self%half%interval
    if (allocated(self%x)) deallocate (self%x, self%k)
    allocate (self%x(size(x, 1), n), self%k(self%r, 4, n))
    n = 0
    do i = 1, size(x, 2) - 1
      if (self%is_driven) x(size(x, 1) - 1:, i) = [input(i), input(i + 1) - input(i)]
      y = x(:, i)
      do j = 1, self%steps
        n = n + 1
        self%x(:, n) = y
        associate (k => self%k(:, :, n), p => self%r + 1, q => 2*self%r)
          k(:, 1) = drag%force(y(p:q))
          a = matmul(self%half%step, y)
          e = matmul(self%half%step(:, p:q), k(:, 1))
          s = a + 0.5_rp*h*e
          k(:, 2) = drag%force(s(p:q))
          k(:, 3) = drag%force(a(p:q) + 0.5_rp*h*k(:, 2))
          s = a
          s(p:q) = s(p:q) + h*k(:, 3)
          s = matmul(self%half%step, s)
          k(:, 4) = drag%force(s(p:q))
          s = a + h/6*e
          s(p:q) = s(p:q) + h/3*(k(:, 2) + k(:, 3))
          y = matmul(self%half%step, s)
          y(p:q) = y(p:q) + h/6*k(:, 4)
        end associate
      end do
      x(:, i + 1) = y
    end do
  end subroutine flow_march

  !> Computes dx(n, :) for a change da(n, n) of A and a `change` of the drag along the motion that `march` has found, from dx(:, 1),
  !> which is given.
  subroutine flow_tangent(self, drag, da, change, dx)
    class(dragged_flow_t), intent(in) :: self
    type(drag_t), intent(in) :: drag
    type(drag_change_t), intent(in) :: change
    real(rp), intent(in) :: da(:, :)
    real(rp), intent(inout) :: dx(:, :)
    real(rp), dimension(size(dx, 1)) :: dy, a, e, s, b, d_a, d_e, d_s
    real(rp) :: d(size(dx, 1), size(dx, 1)), dk(self%r, 4), h
    integer :: i, j, n
    h = 2*self%half%interval
    call self%half%derivative(da, d)
    n = 0
    do i = 1, size(dx, 2) - 1
      if (self%is_driven) dx(size(dx, 1) - 1:, i) = 0
      dy = dx(:, i)
      do j = 1, self%steps
        n = n + 1
        associate (x => self%x(:, n), k => self%k(:, :, n), p => self%r + 1, q => 2*self%r, step => self%half%step)
          dk(:, 1) = drag%slope(change, x(p:q), dy(p:q), k(:, 1))
          a = matmul(step, x)
          d_a = matmul(step, dy) + matmul(d, x)
          e = matmul(step(:, p:q), k(:, 1))
          d_e = matmul(step(:, p:q), dk(:, 1)) + matmul(d(:, p:q), k(:, 1))
          s = a + 0.5_rp*h*e
          d_s = d_a + 0.5_rp*h*d_e
          dk(:, 2) = drag%slope(change, s(p:q), d_s(p:q), k(:, 2))
          dk(:, 3) = drag%slope(change, a(p:q) + 0.5_rp*h*k(:, 2), d_a(p:q) + 0.5_rp*h*dk(:, 2), k(:, 3))
          b = a
          b(p:q) = b(p:q) + h*k(:, 3)
          d_s = d_a
          d_s(p:q) = d_s(p:q) + h*dk(:, 3)
          s = matmul(step, b)
          d_s = matmul(step, d_s) + matmul(d, b)
          dk(:, 4) = drag%slope(change, s(p:q), d_s(p:q), k(:, 4))
          s = a + h/6*e
          s(p:q) = s(p:q) + h/3*(k(:, 2) + k(:, 3))
          d_s = d_a + h/6*d_e
          d_s(p:q) = d_s(p:q) + h/3*(dk(:, 2) + dk(:, 3))
          dy = matmul(step, d_s) + matmul(d, s)
          dy(p:q) = dy(p:q) + h/6*dk(:, 4)
        end associate
      end do
      dx(:, i + 1) = dy
    end do
  end subroutine flow_tangent
end module solid_dragged_flow

! SPDX-License-Identifier: GPL-3.0-or-later
!> Solves x' = A x at equal intervals of time, exactly but for rounding, and differentiates the solution exactly with respect to
!> A and x(0).
!>
!> x(t + h) = E x(t), E = exp(A h). E is the 2^s-th power of exp(A h/2^s), which is a Taylor polynomial of degree DEGREE at a norm
!> below REACH, where the remainder is 1e-17. A change dA of A changes the polynomial and the squarings: with E_h and D_h known,
!> E_2h = E_h E_h, D_2h = E_h D_h + D_h E_h (Higham 2008, Functions of Matrices, chapter 10, ISBN 978-0-89871-646-7). Then dx(t + h)
!> = E dx(t) + D x(t). Because there is no time integration, there is no numerical damping.
!>
!> An input u(t) that is linear between values at the same intervals adds two states at the end: u, and its change w over an
!> interval, with u' = w/h and w' = 0. A contains these equations (`join_input`). The two states are set at the beginning of every
!> interval.
module base_linear_flow
  use base_kinds, only: rp
  use base_lapack, only: multiply
  implicit none
  private
  public :: linear_flow_t

  integer, parameter :: DEGREE = 9
  real(rp), parameter :: REACH = 0.12_rp

  type :: linear_flow_t
    integer :: n = 0                                 !< states
    real(rp) :: interval = 0                         !< [s] h
    real(rp), allocatable :: step(:, :)              !< (n, n) E
    logical, private :: is_driven = .false.
    integer, private :: squarings = 0
    real(rp), allocatable, private :: a(:, :)        !< A h/2^s
    real(rp), allocatable, private :: partial(:, :, :) !< (n, n, DEGREE) partial results of Horner's rule, from the innermost
    real(rp), allocatable, private :: powers(:, :, :)  !< (n, n, 0:s) E of h/2^s, .., h
  contains
    procedure :: init => flow_init
    procedure :: march => flow_march
    procedure :: tangent => flow_tangent
    procedure :: derivative => flow_derivative
  end type linear_flow_t

contains

  !> Prepares the flow of a(n, n) [1/s] over an interval [s] >= 0. If the flow `is_driven`, the last two states belong to an input.
  subroutine flow_init(self, a, interval, is_driven)
    class(linear_flow_t), intent(inout) :: self
    real(rp), intent(in) :: a(:, :), interval
    logical, intent(in), optional :: is_driven
    real(rp) :: norm
    integer :: k
    self%n = size(a, 1)
    self%interval = interval
    self%is_driven = .false.
    if (present(is_driven)) self%is_driven = is_driven
    norm = interval*maxval(sum(abs(a), 1))
    self%squarings = 0
    do while (norm > REACH*2.0_rp**self%squarings)
      self%squarings = self%squarings + 1
    end do
    self%a = interval/2.0_rp**self%squarings*a
    if (allocated(self%powers)) deallocate (self%powers, self%partial)
    allocate (self%powers(self%n, self%n, 0:self%squarings), self%partial(self%n, self%n, DEGREE))
    self%partial(:, :, 1) = identity(self%n)
    do k = 2, DEGREE ! 1 + A/m (1 + A/(m + 1) (..)), m = DEGREE + 1 - k + 1
      self%partial(:, :, k) = identity(self%n)
      call multiply(1/real(DEGREE + 2 - k, rp), self%a, self%partial(:, :, k - 1), self%partial(:, :, k))
    end do
    self%powers(:, :, 0) = identity(self%n)
    call multiply(1.0_rp, self%a, self%partial(:, :, DEGREE), self%powers(:, :, 0))
    do k = 1, self%squarings
      self%powers(:, :, k) = 0
      call multiply(1.0_rp, self%powers(:, :, k - 1), self%powers(:, :, k - 1), self%powers(:, :, k))
    end do
    self%step = self%powers(:, :, self%squarings)
  end subroutine flow_init

  !> Computes x(n, :) at the times 0, h, 2 h, .. from x(:, 1), which is given, under the input(size(x, 2)) of a driven flow.
  subroutine flow_march(self, x, input)
    class(linear_flow_t), intent(in) :: self
    real(rp), intent(inout) :: x(:, :)
    real(rp), intent(in), optional :: input(:)
    integer :: k
    do k = 1, size(x, 2) - 1
      if (self%is_driven .and. present(input)) x(self%n - 1:, k) = [input(k), input(k + 1) - input(k)]
      x(:, k + 1) = matmul(self%step, x(:, k))
    end do
  end subroutine flow_march

  !> Computes dx(n, :) for a change da(n, n) of A along x(n, :), which `march` has given, from dx(:, 1), which is given.
  subroutine flow_tangent(self, da, x, dx)
    class(linear_flow_t), intent(in) :: self
    real(rp), intent(in) :: da(:, :), x(:, :)
    real(rp), intent(inout) :: dx(:, :)
    real(rp) :: d(self%n, self%n)
    integer :: k
    call self%derivative(da, d)
    do k = 1, size(x, 2) - 1
      if (self%is_driven) dx(self%n - 1:, k) = 0
      dx(:, k + 1) = matmul(self%step, dx(:, k)) + matmul(d, x(:, k))
    end do
  end subroutine flow_tangent

  !> Returns d(n, n) = D, the derivative of E along the change da(n, n) of A.
  subroutine flow_derivative(self, da, d)
    class(linear_flow_t), intent(in) :: self
    real(rp), intent(in) :: da(:, :)
    real(rp), intent(out) :: d(:, :)
    real(rp) :: small(self%n, self%n), next(self%n, self%n)
    integer :: k
    small = self%interval/2.0_rp**self%squarings*da
    d = 0
    do k = 2, DEGREE
      next = 0
      call multiply(1/real(DEGREE + 2 - k, rp), small, self%partial(:, :, k - 1), next)
      call multiply(1/real(DEGREE + 2 - k, rp), self%a, d, next)
      d = next
    end do
    next = 0
    call multiply(1.0_rp, small, self%partial(:, :, DEGREE), next)
    call multiply(1.0_rp, self%a, d, next)
    d = next
    do k = 1, self%squarings
      next = 0
      call multiply(1.0_rp, self%powers(:, :, k - 1), d, next)
      call multiply(1.0_rp, d, self%powers(:, :, k - 1), next)
      d = next
    end do
  end subroutine flow_derivative

  !> Returns the unit matrix (n, n).
  pure function identity(n) result(e)
    integer, intent(in) :: n
    real(rp) :: e(n, n)
    integer :: i
    e = 0
    do i = 1, n
      e(i, i) = 1
    end do
  end function identity
end module base_linear_flow

! SPDX-License-Identifier: GPL-3.0-or-later
!> Tabulates the Green tensor of the filtered projection: the instantaneous velocity at one point of the flow due to a force at
!> another.
!>
!> For |k| < K, Phi^2 = 1 + (k/K)^2 (fluid_point_forces), in an unbounded flow and for a force for a unit of time,
!>
!>     G(r) = (2 pi)^-3 int Phi^2 (1 - k k/k^2) exp(i k.r) d^3k = a(r) 1 + b(r) r r/r^2,
!>     a = (2 pi^2)^-1 int_0^K Phi^2 k^2 (j0 - j1/x) dk,  b = (2 pi^2)^-1 int_0^K Phi^2 k^2 j2 dk,  x = k r,
!>
!> with spherical Bessel functions; in the plane, for forces per unit depth,
!>
!>     a = (2 pi)^-1 int_0^K Phi^2 k (J0 - J1/x) dk,      b = (2 pi)^-1 int_0^K Phi^2 k J2 dk,
!>
!> and (2 pi)^-1 int Phi^2 k J0 dk for the component across it. Images in a periodic box add terms of the order (K L)^-2 G(0). Both
!> functions are tabulated on a fine mesh in r and interpolated by cubics.
module fsi_green
  use base_constants, only: PI
  use base_kinds, only: rp
  implicit none
  private
  public :: green_t

  real(rp), parameter :: PHASE_STEP = 0.1_rp !< K times the mesh of the table: cubics are then exact to 1e-6 of G(0)

  type :: green_t
    real(rp) :: radius = 0     !< K, 1/L
    logical :: is_2d = .false.
    real(rp), allocatable, private :: table(:, :) !< (3, -1:n+2) a, b and the component across the plane, 1/L^3 or 1/L^2
  contains
    procedure :: init => green_init
    procedure :: at => green_at
  end type green_t

contains

  !> Tabulates G for distances up to `largest` [L] and cut-off `radius` [1/L].
  subroutine green_init(self, radius, largest, is_2d)
    class(green_t), intent(inout) :: self
    real(rp), intent(in) :: radius, largest
    logical, intent(in) :: is_2d
    integer :: i, n
    self%radius = radius
    self%is_2d = is_2d
    n = ceiling(radius*largest/PHASE_STEP) + 3
    if (allocated(self%table)) deallocate (self%table)
    allocate (self%table(3, 0:n))
    do i = 0, n
      if (is_2d) then
        self%table(:, i) = radius**2/(2*PI)*plane_integrals(i*PHASE_STEP)
      else
        self%table(:, i) = radius**3/(2*PI**2)*space_integrals(i*PHASE_STEP)
      end if
    end do
  end subroutine green_init

  !> Returns int_0^1 (1 + s^2) s^2 [j0 - j1/x, j2, 0] ds, x = s `p`, in closed form; by its series for small p.
  pure function space_integrals(p) result(f)
    real(rp), intent(in) :: p
    real(rp) :: f(3), sines, j1_part, c, s
    f = 0
    if (p < 0.5_rp) then
      ! j0 - j1/x = 2/3 - 2 x^2/15 + x^4/140 - ..., j2 = x^2/15 - x^4/210 + ...
      f(1) = 2/3.0_rp*(1/3.0_rp + 1/5.0_rp) - 2/15.0_rp*p**2*(1/5.0_rp + 1/7.0_rp) + &
             p**4/140*(1/7.0_rp + 1/9.0_rp) - p**6/5670*(1/9.0_rp + 1/11.0_rp)
      f(2) = p**2/15*(1/5.0_rp + 1/7.0_rp) - p**4/210*(1/7.0_rp + 1/9.0_rp) + p**6/7560*(1/9.0_rp + 1/11.0_rp)
      return
    end if
    c = cos(p)
    s = sin(p)
    ! The integrals of s^2 j0 (1 + s^2) = (s + s^3) sin(p s)/p and of s^2 j1/x (1 + s^2) = (1 + s^2)(sin/p^3/s - cos/p^2).
    sines = (s/p**2 - c/p + (3/p**2 - 6/p**4)*s - (1/p - 6/p**3)*c)/p
    j1_part = (sine_integral(p) + s/p**2 - c/p)/p**3 - (s/p + (1/p - 2/p**3)*s + 2*c/p**2)/p**2
    f(1) = sines - j1_part
    f(2) = 3*j1_part - sines
  end function space_integrals

  !> Returns Si(p) = int_0^p sin(t)/t dt to the accuracy of the table.
  pure real(rp) function sine_integral(p) result(si)
    real(rp), intent(in) :: p
    integer, parameter :: PANEL = 8
    real(rp), parameter :: NODES(4) = [0.1834346424956498_rp, 0.5255324099163290_rp, 0.7966664774136267_rp, &
                                       0.9602898564975363_rp]
    real(rp), parameter :: WEIGHTS(4) = [0.3626837833783620_rp, 0.3137066458778873_rp, 0.2223810344533745_rp, &
                                         0.1012285362903763_rp]
    real(rp) :: half, centre, t(2)
    integer :: i, j, n
    n = max(1, ceiling(PANEL*p/20))
    half = p/(2*n)
    si = 0
    do i = 1, n
      centre = (2*i - 1)*half
      do j = 1, 4
        t = centre + half*[-NODES(j), NODES(j)]
        si = si + WEIGHTS(j)*half*sum(sin(t)/t)
      end do
    end do
  end function sine_integral

  !> Returns int_0^1 (1 + s^2) s [J0 - J1/x, J2, J0] ds, x = s `p`, by Gauss's rule on panels shorter than a wave.
  pure function plane_integrals(p) result(f)
    real(rp), intent(in) :: p
    real(rp), parameter :: NODES(4) = [0.1834346424956498_rp, 0.5255324099163290_rp, 0.7966664774136267_rp, &
                                       0.9602898564975363_rp]
    real(rp), parameter :: WEIGHTS(4) = [0.3626837833783620_rp, 0.3137066458778873_rp, 0.2223810344533745_rp, &
                                         0.1012285362903763_rp]
    real(rp) :: f(3), half, s, x, weight, ratio
    integer :: i, j, side, n
    n = 1 + ceiling(p/3)
    half = 0.5_rp/n
    f = 0
    do i = 1, n
      do j = 1, 4
        do side = -1, 1, 2
          s = (2*i - 1)*half + side*half*NODES(j)
          x = s*p
          weight = WEIGHTS(j)*half*(1 + s*s)*s
          ratio = 0.5_rp
          if (x > 1.0e-6_rp) ratio = bessel_j1(x)/x
          f = f + weight*[bessel_j0(x) - ratio, 2*ratio - bessel_j0(x), bessel_j0(x)]
        end do
      end do
    end do
  end function plane_integrals

  !> Returns G(r) [1/L^3, 1/L^2 in the plane]; beyond the largest distance of the table the value there.
  pure function green_at(self, r) result(g)
    class(green_t), intent(in) :: self
    real(rp), intent(in) :: r(3)
    real(rp) :: g(3, 3), f(3), square, t, w(4)
    integer :: i, k
    square = r(2)**2 + r(3)**2
    if (.not. self%is_2d) square = square + r(1)**2
    t = min(self%radius*sqrt(square)/PHASE_STEP, ubound(self%table, 2) - 2.0_rp)
    i = max(1, int(t))
    t = t - i
    w = [-t*(t - 1)*(t - 2)/6, (t + 1)*(t - 1)*(t - 2)/2, -(t + 1)*t*(t - 2)/2, (t + 1)*t*(t - 1)/6]
    f = self%table(:, i - 1)*w(1) + self%table(:, i)*w(2) + self%table(:, i + 1)*w(3) + self%table(:, i + 2)*w(4)
    if (square > 0) f(2) = f(2)/square
    do k = 1, 3
      g(:, k) = (f(2)*r(k))*r
      g(k, k) = g(k, k) + f(1)
    end do
    if (.not. self%is_2d) return
    g(:, 1) = [f(3), 0.0_rp, 0.0_rp]
    g(1, :) = g(:, 1)
  end function green_at
end module fsi_green

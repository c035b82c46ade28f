! SPDX-License-Identifier: GPL-3.0-or-later
!> Interpolates a flow on the grid at any point as fluid_point_forces does: with the filter Phi(k) of each mode, |k| < K.
!>
!> The filter is not separable, but to 2.4e-4 a sum of two products of factors of each direction (s = (k/K)^2, sum of three parts):
!>
!>     Phi = sqrt(1 + s) = c_1 exp(-a_1 s) + c_2 exp(-a_2 s) + e(s),    |e(0)| < 1e-5,
!>
!> the least squares fit with the weight 1/(0.02 + s). In each direction the weights h_m of W points around a place x, in cells,
!> give a mode exp(i theta x) the factor exp(-a (theta/theta_K)^2) with the least error
!>
!>     int rho(theta) |sum_m h_m exp(i theta m) - exp(-a (theta/theta_K)^2) exp(i theta x)|^2 dtheta
!>
!> over the modes inside K. Modes beyond it, of which the flow has none, may get any factor: at an oversampling of 1.5
!> the error falls by about 1.7 for each point. rho = 1/(0.05 + s)^2 is the decay of the power of a flow with a kink, that of a
!> boundary layer at a wing. The weights are polynomials of the place inside its cell: with d = x - floor(x) - 1/2 their right-hand
!> sides are Taylor series with an error of (theta/2)^14/14!, 3e-11 (theta = 2 pi/3). `fluid_point_reader` has the sums.
module fluid_point_kernel
  use base_errors, only: require
  use base_kinds, only: rp
  use base_lapack, only: factorise, solve_factorised
  implicit none
  private
  public :: point_kernel_t, KERNEL_WIDTH, KERNEL_TERMS, KERNEL_STRENGTHS, KERNEL_DECAYS

  integer, parameter :: KERNEL_WIDTH = 16 !< W, cells; even
  integer, parameter :: KERNEL_TERMS = 2  !< products of factors
  real(rp), parameter :: KERNEL_STRENGTHS(KERNEL_TERMS) = [1.33333115_rp, -0.33332248_rp] !< c
  real(rp), parameter :: KERNEL_DECAYS(KERNEL_TERMS) = [-0.15113745_rp, 0.89328342_rp]    !< a
  integer, parameter :: DEGREE = 13

  type :: point_kernel_t
    private
    real(rp) :: powers(KERNEL_WIDTH, KERNEL_TERMS, 0:DEGREE) = 0 !< coefficients of d^p
  contains
    procedure :: init => kernel_init
    procedure :: weights => kernel_weights
  end type point_kernel_t

contains

  !> Makes the weights for modes inside K, which is `cutoff` radians per cell.
  subroutine kernel_init(self, cutoff)
    class(point_kernel_t), intent(inout) :: self
    real(rp), intent(in) :: cutoff
    integer, parameter :: N = 400 !< frequencies of the sums that stand for the integral
    real(rp) :: a(KERNEL_WIDTH, KERNEL_WIDTH), c(KERNEL_WIDTH), theta, rho, factor
    real(rp), parameter :: QUARTER = acos(0.0_rp)
    integer :: i, j, m, p
    logical :: ok
    a = 0
    self%powers = 0
    c = [(m - (KERNEL_WIDTH + 1)/2.0_rp, m=1, KERNEL_WIDTH)] ! points, from the middle of the cell
    do i = 1, N
      theta = cutoff*(i - 0.5_rp)/N
      rho = 1/(0.05_rp + (theta/cutoff)**2)**2
      do m = 1, KERNEL_WIDTH
        a(:, m) = a(:, m) + rho*cos(theta*(c - c(m)))
      end do
      do j = 1, KERNEL_TERMS
        factor = rho*exp(-KERNEL_DECAYS(j)*(theta/cutoff)**2)
        do p = 0, DEGREE
          ! The p-th derivative of cos(theta (c - d)) by d, over p!.
          self%powers(:, j, p) = self%powers(:, j, p) + factor*cos(theta*c - p*QUARTER)
          factor = factor*theta/(p + 1)
        end do
      end do
    end do
    call factorise(a, ok)
    call require(ok, 'point_kernel_t: the weights follow from the band')
    do p = 0, DEGREE
      do j = 1, KERNEL_TERMS
        call solve_factorised(a, self%powers(:, j, p))
      end do
    end do
  end subroutine kernel_init

  !> Returns the weights of the cells first .. first + W - 1 (0-based, not wrapped) for a point at `s` cells from the origin.
  pure subroutine kernel_weights(self, s, first, w)
    class(point_kernel_t), intent(in) :: self
    real(rp), intent(in) :: s
    integer, intent(out) :: first
    real(rp), intent(out) :: w(KERNEL_WIDTH, KERNEL_TERMS)
    real(rp) :: d
    integer :: p
    first = floor(s)
    d = s - first - 0.5_rp
    first = first + 1 - KERNEL_WIDTH/2
    w = self%powers(:, :, DEGREE)
    do p = DEGREE - 1, 0, -1
      w = self%powers(:, :, p) + d*w
    end do
  end subroutine kernel_weights
end module fluid_point_kernel

! SPDX-License-Identifier: GPL-3.0-or-later
!> Linear differential equations at equal intervals: a damped oscillator against its closed solution over one and many turns an
!> interval, an input that is a ramp, and derivatives against differences, whose error falls with the square of their step.
program test_linear_flow
  use base_kinds, only: rp
  use base_linear_flow, only: linear_flow_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: W = 3.0_rp, D = 0.4_rp
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_oscillator(0.05_rp)
  call test_oscillator(7.0_rp)
  call test_ramp()
  call test_tangent()
  call t%finish()

contains

  !> x'' + 2 D x' + W^2 x = 0 from (1, 0): exp(-D t) (cos v t + D/v sin v t).
  subroutine test_oscillator(h)
    real(rp), intent(in) :: h
    integer, parameter :: N = 40
    type(linear_flow_t) :: flow
    real(rp) :: x(2, N), exact(N), v, times(N)
    integer :: k
    call flow%init(reshape([0.0_rp, -W**2, 1.0_rp, -2*D], [2, 2]), h)
    x(:, 1) = [1.0_rp, 0.0_rp]
    call flow%march(x)
    v = sqrt(W**2 - D**2)
    times = [(k*h, k=0, N - 1)]
    exact = exp(-D*times)*(cos(v*times) + D/v*sin(v*times))
    ! Squaring s times doubles rounding s times.
    call t%check_below('a damped oscillator follows its closed solution', maxval(abs(x(1, :) - exact)), 1.0e-11_rp)
  end subroutine test_oscillator

  !> x' = u with u = t: t^2/2, at intervals that the input bends at.
  subroutine test_ramp()
    integer, parameter :: N = 11
    real(rp), parameter :: H = 0.3_rp
    type(linear_flow_t) :: flow
    real(rp) :: a(3, 3), x(3, N), input(N)
    integer :: k
    a = 0
    a(1, 2) = 1
    a(2, 3) = 1/H
    input = [(k*H, k=0, N - 1)]
    call flow%init(a, H, .true.)
    x = 0
    call flow%march(x, input)
    call t%check_below('a ramp is integrated exactly', maxval(abs(x(1, :) - 0.5_rp*input**2)), 1.0e-14_rp)
    input = [(real(mod(k, 2), rp), k=0, N - 1)]
    x = 0
    call flow%march(x, input)
    call t%check_close('so is a saw', x(1, N), 0.5_rp*(N - 1)*H, rtol=1.0e-14_rp)
  end subroutine test_ramp

  subroutine test_tangent()
    integer, parameter :: N = 30, M = 5
    real(rp), parameter :: STEP(2) = [2.0e-3_rp, 1.0e-3_rp]
    type(linear_flow_t) :: flow, other
    real(rp) :: a(M, M), da(M, M), begin(M), dbegin(M), x(M, N), dx(M, N), plus(M, N), minus(M, N), error(2), input(N)
    integer :: i, k
    a = reshape([(sin(1.7_rp*i) - 0.1_rp*i/M, i=1, M*M)], [M, M])
    da = reshape([(cos(0.9_rp*i**2), i=1, M*M)], [M, M])
    a(M - 1:, :) = 0
    a(M - 1, M) = 1/0.4_rp
    da(M - 1:, :) = 0
    input = [(sin(0.3_rp*i), i=1, N)]
    begin = [1.0_rp, -0.5_rp, 0.3_rp, 0.0_rp, 0.0_rp]
    dbegin = [0.2_rp, 0.7_rp, -0.4_rp, 0.0_rp, 0.0_rp]
    call flow%init(a, 0.4_rp, .true.)
    x(:, 1) = begin
    call flow%march(x, input)
    dx(:, 1) = dbegin
    call flow%tangent(da, x, dx)
    do k = 1, 2
      call other%init(a + STEP(k)*da, 0.4_rp, .true.)
      plus(:, 1) = begin + STEP(k)*dbegin
      call other%march(plus, input)
      call other%init(a - STEP(k)*da, 0.4_rp, .true.)
      minus(:, 1) = begin - STEP(k)*dbegin
      call other%march(minus, input)
      error(k) = maxval(abs((plus - minus)/(2*STEP(k)) - dx))/maxval(abs(dx))
    end do
    call t%check_below('the derivative is that of differences', error(2), 1.0e-3_rp)
    call t%check_close('whose error falls with the square of their step', error(1)/error(2), 4.0_rp, rtol=0.05_rp)
  end subroutine test_tangent
end program test_linear_flow

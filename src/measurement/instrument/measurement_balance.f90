! SPDX-License-Identifier: GPL-3.0-or-later
!> Models what a force balance shows of forces, torques and power that repeat in every beat of frequency f. They are Fourier
!> series,
!>
!>     x(s) = Re sum_{h=0}^{H} x_h exp(2 pi i h s),   s = t f,
!>
!> and the balance shows
!>
!>     y_h = L_h [ g (M (x_h + m a_h)) + o delta_{h0} ],   L_h = exp(-2 pi i h f d)/(1 + 2 pi i h f T),   M = I + turn + cross-talk,
!>
!> where g is the gain, o are the offsets, d is the delay, T is the time constant of a first-order filter, and m is the mass whose
!> inertia m a_h has not been subtracted. Turn and cross-talk mix forces among themselves and torques among themselves. All
!> derivatives are exact.
module measurement_balance
  use base_constants, only: PI, TWO_PI
  use base_kinds, only: rp
  use measurement_balance_causes, only: cross_number, BALANCE_CROSS, BALANCE_DELAY, BALANCE_GAIN, BALANCE_LOWPASS, BALANCE_MASS, &
                                        BALANCE_OFFSET, BALANCE_TURN, N_BALANCE
  use measurement_flight, only: N_COMPONENTS
  implicit none
  private
  public :: apply_balance, balance_harmonics, balance_values, move_torques, without_additions

  real(rp), parameter :: DEGREE = PI/180

contains

  !> Returns the Fourier coefficients x(0:n_harmonics, k) of samples(n, k), which are taken at s = 0, 1/n, .. of the beat. n must
  !> be larger than twice n_harmonics.
  pure function balance_harmonics(samples, n_harmonics) result(x)
    real(rp), intent(in) :: samples(:, :)
    integer, intent(in) :: n_harmonics
    complex(rp) :: x(0:n_harmonics, size(samples, 2))
    real(rp) :: angle
    integer :: h, i, n
    n = size(samples, 1)
    x = 0
    do h = 0, n_harmonics
      do i = 1, n
        angle = TWO_PI*modulo(h*(i - 1), n)/n
        x(h, :) = x(h, :) + cmplx(cos(angle), -sin(angle), rp)*samples(i, :)
      end do
      x(h, :) = x(h, :)*merge(1, 2, h == 0)/n
    end do
  end function balance_harmonics

  !> Returns values(size(s)) of the series x(0:H) at the fractions s of the beat.
  pure function balance_values(x, s) result(values)
    complex(rp), intent(in) :: x(0:)
    real(rp), intent(in) :: s(:)
    real(rp) :: values(size(s))
    integer :: h
    values = 0
    do h = 0, ubound(x, 1)
      values = values + real(x(h), rp)*cos(TWO_PI*h*s) - aimag(x(h))*sin(TWO_PI*h*s)
    end do
  end function balance_values

  !> Converts the series x(0:H, 7) with torques about the origin into one with torques about `reference` [m].
  pure subroutine move_torques(x, reference)
    complex(rp), intent(inout) :: x(0:, :)
    real(rp), intent(in) :: reference(3)
    integer :: i, j, k
    do i = 1, 3
      j = modulo(i, 3) + 1
      k = modulo(i + 1, 3) + 1
      x(:, 3 + i) = x(:, 3 + i) - (reference(j)*x(:, k) - reference(k)*x(:, j))
    end do
  end subroutine move_torques

  !> Returns the coordinates of the balance without the offsets and the mass, which add to the forces of a flight.
  pure function without_additions(p) result(rest)
    real(rp), intent(in) :: p(N_BALANCE)
    real(rp) :: rest(N_BALANCE)
    rest = p
    rest(BALANCE_MASS) = 0
    rest(BALANCE_OFFSET + 1:BALANCE_OFFSET + N_COMPONENTS) = 0
  end function without_additions

  !> Returns in y(0:H, 7) what the balance with the coordinates p(N_BALANCE) indicates for the series x(0:H, 7) at the frequency
  !> [Hz] of the beat. a(0:H, 7) is the series of the inertia of a unit mass. With `number`, y is the derivative with respect to
  !> that coordinate instead.
  pure subroutine apply_balance(p, frequency, x, a, y, number)
    real(rp), intent(in) :: p(:), frequency
    complex(rp), intent(in) :: x(0:, :), a(0:, :)
    complex(rp), intent(out) :: y(0:, :)
    integer, intent(in), optional :: number
    complex(rp) :: filter(0:ubound(x, 1)), w(0:ubound(x, 1))
    integer :: h, wanted
    wanted = 0
    if (present(number)) wanted = number
    w = [(cmplx(0.0_rp, TWO_PI*h*frequency, rp), h=0, ubound(x, 1))]
    filter = exp(-w*p(BALANCE_DELAY))/(1 + w*p(BALANCE_LOWPASS))
    if (wanted == BALANCE_LOWPASS) filter = -w/(1 + w*p(BALANCE_LOWPASS))*filter
    if (wanted == BALANCE_DELAY) filter = -w*filter
    select case (wanted)
    case (0, BALANCE_LOWPASS, BALANCE_DELAY)
      y = mixed(p, x + p(BALANCE_MASS)*a)
      y(0, :) = y(0, :) + p(BALANCE_OFFSET + 1:BALANCE_OFFSET + N_COMPONENTS)
    case (BALANCE_GAIN)
      y = mixed(p, x + p(BALANCE_MASS)*a)
    case (BALANCE_OFFSET + 1:BALANCE_OFFSET + N_COMPONENTS)
      y = 0
      y(0, wanted - BALANCE_OFFSET) = 1
    case (BALANCE_MASS)
      y = mixed(p, a)
    case default
      y = exp(p(BALANCE_GAIN))*of_matrix(mixing_direction(wanted), x + p(BALANCE_MASS)*a)
    end select
    do h = 0, ubound(x, 1)
      y(h, :) = filter(h)*y(h, :)
    end do
  end subroutine apply_balance

  !> Returns g M x.
  pure function mixed(p, x) result(y)
    real(rp), intent(in) :: p(:)
    complex(rp), intent(in) :: x(0:, :)
    complex(rp) :: y(0:ubound(x, 1), size(x, 2))
    real(rp) :: matrix(N_COMPONENTS, N_COMPONENTS)
    integer :: i
    matrix = 0
    do i = 1, N_COMPONENTS
      matrix(i, i) = 1
    end do
    do i = 1, N_BALANCE
      if (i > BALANCE_TURN .and. i <= BALANCE_TURN + 3 .or. i > BALANCE_CROSS) matrix = matrix + p(i)*mixing_direction(i)
    end do
    y = exp(p(BALANCE_GAIN))*of_matrix(matrix, x)
  end function mixed

  !> Multiplies every row of `x` with a matrix.
  pure function of_matrix(matrix, x) result(y)
    real(rp), intent(in) :: matrix(:, :)
    complex(rp), intent(in) :: x(0:, :)
    complex(rp) :: y(0:ubound(x, 1), size(x, 2))
    y = matmul(x, cmplx(transpose(matrix), kind=rp))
  end function of_matrix

  !> Returns the derivative of M with respect to the coordinate of a turn or of a cross-talk. A balance that is turned by small
  !> angles against the axes indicates x - angles x x.
  pure function mixing_direction(number) result(matrix)
    integer, intent(in) :: number
    real(rp) :: matrix(N_COMPONENTS, N_COMPONENTS)
    integer :: i, j, k, first
    matrix = 0
    do first = 0, 3, 3
      do i = 1, 3
        do j = 1, 3
          if (i == j) cycle
          if (cross_number(first + i, first + j) == number) matrix(first + i, first + j) = 1
          k = 6 - i - j
          if (number /= BALANCE_TURN + k) cycle
          matrix(first + i, first + j) = DEGREE*merge(1, -1, modulo(i - k, 3) == 1)
        end do
      end do
    end do
  end function mixing_direction
end module measurement_balance

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
  use base_parameter, only: define_effect, parameter_t
  use measurement_flight, only: component_unit, COMPONENT_NAMES, N_COMPONENTS
  implicit none
  private
  public :: apply_balance, balance_harmonics, balance_values, describe_balance, cross_number

  !> These are the numbers of the parameters. The offset of a component is BALANCE_OFFSET + component. The turns about x, y and z
  !> are BALANCE_TURN + 1 to 3. `cross_number` returns the number of a cross-talk.
  integer, parameter, public :: BALANCE_GAIN = 1, BALANCE_OFFSET = 1, BALANCE_TURN = 8, BALANCE_LOWPASS = 12, BALANCE_DELAY = 13, &
                                BALANCE_MASS = 14, BALANCE_CROSS = 14, N_BALANCE = 14 + 12
  real(rp), parameter :: DEGREE = PI/180

contains

  !> Returns the number of the cross-talk that adds a share of component j to the indication of component i. Both must be forces
  !> (1 to 3) or both torques (4 to 6), and they must differ.
  pure integer function cross_number(i, j) result(number)
    integer, intent(in) :: i, j
    integer :: own, other
    own = modulo(i - 1, 3)
    other = modulo(j - 1, 3)
    number = BALANCE_CROSS + 6*((i - 1)/3) + 2*own + merge(other, other - 1, other < own) + 1
  end function cross_number

  !> Describes parameter `number` by its coordinate, which is 0 where the balance is right. `sizes` are those of the components in
  !> the record, in their units, and scale the offsets; `period` [s] is that of the beat; `mass` [kg, or kg/m if `is_per_length`]
  !> is the prior sd of the mass. Bounds and sd are documented in docs/theory/flight-records.md.
  function describe_balance(number, sizes, period, mass, is_per_length) result(p)
    integer, intent(in) :: number
    real(rp), intent(in) :: sizes(N_COMPONENTS), period, mass
    logical, intent(in) :: is_per_length
    type(parameter_t) :: p
    integer :: i, j, last
    select case (number)
    case (BALANCE_GAIN)
      call define_effect(p, 'balance_gain', '1', .true., 0.5_rp, 2.0_rp, 0.1_rp)
    case (BALANCE_OFFSET + 1:BALANCE_OFFSET + N_COMPONENTS)
      i = number - BALANCE_OFFSET
      call define_effect(p, 'balance_offset:'//trim(COMPONENT_NAMES(i)), component_unit(i, is_per_length), .false., -sizes(i), &
                         sizes(i), 0.1_rp*sizes(i))
    case (BALANCE_TURN + 1:BALANCE_TURN + 3)
      i = number - BALANCE_TURN
      call define_effect(p, 'balance_turn:'//COMPONENT_NAMES(i) (2:2), 'degree', .false., -15.0_rp, 15.0_rp, 2.0_rp)
    case (BALANCE_LOWPASS)
      call define_effect(p, 'balance_lowpass', 's', .false., 0.0_rp, 0.2_rp*period, 0.02_rp*period)
    case (BALANCE_DELAY)
      call define_effect(p, 'balance_delay', 's', .false., -0.25_rp*period, 0.25_rp*period, 0.02_rp*period)
    case (BALANCE_MASS)
      call define_effect(p, 'inertia_mass', trim(merge('kg/m', 'kg  ', is_per_length)), .false., -10*mass, 10*mass, mass)
    case default
      do i = 1, 6
        last = 3*((i - 1)/3) + 3
        do j = last - 2, last
          if (i /= j .and. cross_number(i, j) == number) exit
        end do
        if (j <= last) exit
      end do
      call define_effect(p, 'cross_talk:'//trim(COMPONENT_NAMES(j))//'-'//trim(COMPONENT_NAMES(i)), '1', .false., -0.5_rp, 0.5_rp, &
                         0.05_rp)
    end select
    p = p%as_coordinate(p%null)
  end function describe_balance

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

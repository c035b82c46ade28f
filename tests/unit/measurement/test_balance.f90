! SPDX-License-Identifier: GPL-3.0-or-later
!> A force balance: series give back what they were made of, delay and filter do what they do to a sine, turn and cross-talk mix
!> what they should, and all derivatives are those of finite differences.
program test_balance
  use base_cause, only: parameter_of
  use base_constants, only: PI, TWO_PI
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use measurement_balance, only: apply_balance, balance_harmonics, balance_values
  use measurement_balance_causes, only: balance_scales_t, cross_components, cross_number, list_balance_causes, &
                                        BALANCE_CROSS, BALANCE_DELAY, BALANCE_GAIN, BALANCE_LOWPASS, BALANCE_MASS, &
                                        BALANCE_OFFSET, BALANCE_TURN, N_BALANCE
  use measurement_flight, only: N_COMPONENTS
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 64, H = 8
  real(rp), parameter :: FREQUENCY = 25.0_rp !< [Hz]
  type(testkit_t) :: t
  real(rp) :: samples(N, N_COMPONENTS), inertia(N, N_COMPONENTS), s(N)
  complex(rp), dimension(0:H, N_COMPONENTS) :: x, a
  integer :: i, c

  call t%start(parallel=.false.)
  do i = 1, N
    s(i) = real(i - 1, rp)/N
    do c = 1, N_COMPONENTS
      samples(i, c) = 0.3_rp*c + cos(TWO_PI*s(i) + c) + 0.2_rp*c*sin(2*TWO_PI*s(i)) + 0.1_rp*cos(5*TWO_PI*s(i) - c)
      inertia(i, c) = merge(0.0_rp, 4*sin(TWO_PI*s(i) - c), c == N_COMPONENTS)
    end do
  end do
  x = balance_harmonics(samples, H)
  a = balance_harmonics(inertia, H)
  call test_series()
  call test_parts()
  call test_derivatives()
  call test_parameters()
  call t%finish()

contains

  subroutine test_series()
    real(rp) :: error
    integer :: k
    error = 0
    do k = 1, N_COMPONENTS
      error = max(error, maxval(abs(balance_values(x(:, k), s) - samples(:, k))))
    end do
    call t%check('a series gives back what it was made of', error < 1.0e-13_rp*N)
  end subroutine test_series

  !> What the balance with p shows of component k.
  function shown(p, k) result(values)
    real(rp), intent(in) :: p(:)
    integer, intent(in) :: k
    real(rp) :: values(N)
    complex(rp) :: y(0:H, N_COMPONENTS)
    call apply_balance(p, FREQUENCY, x, a, y)
    values = balance_values(y(:, k), s)
  end function shown

  subroutine test_parts()
    real(rp) :: p(N_BALANCE)
    complex(rp) :: y(0:H, N_COMPONENTS)
    p = 0
    call t%check('a balance that is right shows what is', maxval(abs(shown(p, 2) - samples(:, 2))) < 1.0e-13_rp*N)
    p(BALANCE_DELAY) = 4.0_rp/N/FREQUENCY
    call t%check('a delay of four samples shifts by four samples', &
                 maxval(abs(shown(p, 3) - cshift(samples(:, 3), -4))) < 1.0e-13_rp*N)
    p = 0
    p(BALANCE_LOWPASS) = 1/(TWO_PI*FREQUENCY)
    call apply_balance(p, FREQUENCY, x, a, y)
    call t%check('the filter leaves the mean and the first harmonic over root 2', &
                 abs(abs(y(1, 1)) - abs(x(1, 1))/sqrt(2.0_rp)) + abs(y(0, 1) - x(0, 1)) < 1.0e-14_rp)
    call t%check('and later', aimag(y(1, 1)/x(1, 1)) < 0)
    p = 0
    p(BALANCE_TURN + 1) = 3
    call t%check('a balance turned about x shows a share of z in y', &
                 maxval(abs(shown(p, 2) - samples(:, 2) - 3*PI/180*samples(:, 3))) < 1.0e-13_rp*N)
    call t%check('and minus a share of y in z, and all in x', &
                 maxval(abs(shown(p, 3) - samples(:, 3) + 3*PI/180*samples(:, 2))) + &
                 maxval(abs(shown(p, 1) - samples(:, 1))) < 1.0e-13_rp*N)
    p = 0
    p(cross_number(6, 4)) = 0.1_rp
    call t%check('cross-talk shows a share of Mx in Mz', &
                 maxval(abs(shown(p, 6) - samples(:, 6) - 0.1_rp*samples(:, 4))) < 1.0e-13_rp*N)
    p = 0
    p(BALANCE_MASS) = 0.5_rp
    p(BALANCE_GAIN) = log(1.2_rp)
    p(BALANCE_OFFSET + 5) = 7
    call t%check('inertia has the gain, an offset has not', &
                 maxval(abs(shown(p, 5) - 1.2_rp*(samples(:, 5) + 0.5_rp*inertia(:, 5)) - 7)) < 1.0e-13_rp*N)
  end subroutine test_parts

  !> Central differences of third order error; everything is released at once, so that no product is 0.
  subroutine test_derivatives()
    complex(rp), dimension(0:H, N_COMPONENTS) :: d, above, below
    real(rp) :: p(N_BALANCE), q(N_BALANCE), step
    integer :: k
    do k = 1, N_BALANCE
      p(k) = 0.03_rp*cos(1.0_rp*k)
    end do
    p(BALANCE_LOWPASS) = 1.3e-3_rp
    p(BALANCE_DELAY) = -2.0e-3_rp
    do k = 1, N_BALANCE
      step = merge(1.0e-6_rp, 1.0e-4_rp, any(k == [BALANCE_LOWPASS, BALANCE_DELAY]))
      q = p
      q(k) = p(k) + step
      call apply_balance(q, FREQUENCY, x, a, above)
      q(k) = p(k) - step
      call apply_balance(q, FREQUENCY, x, a, below)
      call apply_balance(p, FREQUENCY, x, a, d, k)
      call t%check('the derivative is that of differences', &
                   maxval(abs((above - below)/(2*step) - d)) < 1.0e-6_rp*maxval(abs(d)))
    end do
  end subroutine test_derivatives

  subroutine test_parameters()
    type(parameter_t) :: p
    integer :: k, m
    logical :: is_null, is_unique
    character(40) :: names(N_BALANCE)
    is_null = .true.
    do k = 1, N_BALANCE
      p = parameter_of(list_balance_causes(balance_scales_t(spread(2.0_rp, 1, N_COMPONENTS), 1/FREQUENCY, 1.0e-6_rp)), k)
      p = p%as_coordinate(p%null)
      names(k) = p%name
      is_null = is_null .and. abs(p%null) <= 0 .and. p%lower <= 0 .and. p%upper > 0 .and. p%prior_sd > 0
    end do
    call t%check('every parameter is 0 where the balance is right', is_null)
    is_unique = .true.
    do k = 1, N_BALANCE
      do m = 1, k - 1
        is_unique = is_unique .and. names(k) /= names(m)
      end do
    end do
    call t%check('every parameter has a name of its own', is_unique)
    call t%check('cross-talk is named from where to where', names(cross_number(2, 3)) == 'cross_talk:Fz-Fy')
    call t%check('a number tells them', all(cross_components(cross_number(6, 4)) == [6, 4]) .and. &
                 all(cross_components(BALANCE_MASS) == 0))
    call t%check('their numbers follow the others', cross_number(1, 2) == BALANCE_CROSS + 1 .and. cross_number(6, 5) == N_BALANCE)
  end subroutine test_parameters
end program test_balance

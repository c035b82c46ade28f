! SPDX-License-Identifier: GPL-3.0-or-later
!> Series of wing angles: Fourier against direct sums, Hermite and tables against what defines them, all
!> derivatives against differences, the start-up ramp.
program test_kinematics_motion
  use base_constants, only: TWO_PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fsi_rotation, only: angle_t
  use fsi_wing_motion, only: wing_motion_t
  use fsi_wing_motion_series, only: angle_series_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: A0 = 0.7_rp, A(4) = [1.2_rp, -0.3_rp, 0.11_rp, 0.04_rp], &
                         B(4) = [0.5_rp, 0.25_rp, -0.07_rp, 0.02_rp]
  real(rp), parameter :: VALUES(5) = [0.1_rp, 1.3_rp, -0.4_rp, -1.0_rp, 0.6_rp], &
                         SLOPES(5) = [4.0_rp, -3.0_rp, -6.0_rp, 2.0_rp, 5.0_rp]
  real(rp), parameter :: TIMES(4) = [0.0_rp, 0.3_rp, 1.1_rp, 2.5_rp]
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call check_constant(kit)
  call check_fourier(kit)
  call check_hermite_nodes(kit)
  call check_hermite_period(kit)
  call check_hermite_order(kit)
  call check_table(kit)
  call check_frequency(kit)
  call check_ramp(kit)
  call check_alteration(kit)
  call check_extremes(kit)
  call check_change_of_kind(kit)
  call kit%finish()

contains

  subroutine check_constant(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_motion_t) :: motion
    type(angle_t) :: phi, alpha, theta
    call motion%set_constant(1.0_rp, 2.0_rp, 3.0_rp)
    call motion%evaluate(17.3_rp, phi, alpha, theta)
    call kit%check_below('constant angles do not move', &
                   maxval(abs([phi%value - 1, alpha%value - 2, theta%value - 3, phi%rate, theta%acceleration])), 0.0_rp)
  end subroutine check_constant

  !> The sum with complex argument, without reduction to one period.
  pure complex(rp) function direct_sum(x) result(f)
    complex(rp), intent(in) :: x
    integer :: i
    f = A0/2
    do i = 1, size(A)
      f = f + A(i)*cos(TWO_PI*i*x) + B(i)*sin(TWO_PI*i*x)
    end do
  end function direct_sum

  !> mean + factor (f(x + lead) - mean) + offset, of a Fourier and of a Hermite series; then as it was.
  subroutine check_alteration(kit)
    type(testkit_t), intent(inout) :: kit
    type(angle_series_t) :: series, original
    real(rp), parameter :: FACTOR = 1.3_rp, OFFSET = -0.2_rp, LEAD = 0.07_rp, AT(3) = [-0.4_rp, 0.31_rp, 2.9_rp]
    real(rp) :: f(0:2), g(0:2), worst, mean
    integer :: i, k
    do k = 1, 2
      if (k == 1) call series%set_fourier(A0, A, B)
      if (k == 2) call series%set_hermite(VALUES, SLOPES)
      mean = sum(VALUES)/size(VALUES) ! slopes at both ends of all intervals cancel
      if (k == 1) mean = A0/2
      original = series
      call series%alter(FACTOR, OFFSET, LEAD)
      worst = 0
      do i = 1, size(AT)
        call original%evaluate(AT(i) + LEAD, f)
        call series%evaluate(AT(i), g)
        worst = max(worst, maxval(abs(g - FACTOR*f - [mean - FACTOR*mean + OFFSET, 0.0_rp, 0.0_rp])))
      end do
      call kit%check_below('an altered angle is that about its mean, earlier and aside', worst, 1.0e-5_rp)
    end do
    call series%alter(1.0_rp, 0.0_rp, 0.0_rp)
    call series%evaluate(AT(2), g)
    call original%evaluate(AT(2), f)
    call kit%check_below('without alterations it is what it was, to the bit', maxval(abs(f - g)), 0.0_rp)
    call series%alter(FACTOR, 0.0_rp, LEAD)
    call series%evaluate(AT(2), f)
    call series%add_wave(0.3_rp, -0.1_rp)
    call series%evaluate(AT(2), g)
    associate (w => TWO_PI*AT(2))
      call kit%check_below('a wave is added to the altered angle', maxval(abs(g - f - [ &
        0.3_rp*cos(w) - 0.1_rp*sin(w), TWO_PI*(-0.3_rp*sin(w) - 0.1_rp*cos(w)), &
        TWO_PI**2*(-0.3_rp*cos(w) + 0.1_rp*sin(w))])), 1.0e-12_rp)
    end associate
  end subroutine check_alteration

  subroutine check_fourier(kit)
    type(testkit_t), intent(inout) :: kit
    type(angle_series_t) :: series
    real(rp), parameter :: WEIGHTS(4) = [4.0_rp/5, -1.0_rp/5, 4.0_rp/105, -1.0_rp/280], H = 0.002_rp
    real(rp) :: f(0:2), x, worst(0:2), second
    integer :: i, j
    call series%set_fourier(A0, A, B)
    worst = 0
    do i = -200, 400
      x = 0.0137_rp*i
      call series%evaluate(x, f)
      worst(0) = max(worst(0), abs(f(0) - real(direct_sum(cmplx(x, kind=rp)), rp)))
      worst(1) = max(worst(1), abs(f(1) - direct_rate(x)))
      second = 0
      do j = 1, 4
        second = second + WEIGHTS(j)/H*(direct_rate(x + j*H) - direct_rate(x - j*H))
      end do
      worst(2) = max(worst(2), abs(f(2) - second))
    end do
    ! The argument of the direct sum reaches 2 pi 4 5.5: round-off 1e-14 times the frequencies.
    call kit%check_below('Fourier: value is the direct sum', worst(0), 1.0e-13_rp)
    call kit%check_below('Fourier: rate is the derivative of the direct sum', worst(1), 1.0e-12_rp)
    call kit%check_below('Fourier: acceleration is the second derivative', worst(2), 1.0e-9_rp)
  end subroutine check_fourier

  !> Derivative of the direct sum by a complex step, exact to round-off.
  real(rp) function direct_rate(x) result(rate)
    real(rp), intent(in) :: x
    real(rp), parameter :: STEP = 1.0e-30_rp
    rate = aimag(direct_sum(cmplx(x, STEP, rp)))/STEP
  end function direct_rate

  subroutine check_hermite_nodes(kit)
    type(testkit_t), intent(inout) :: kit
    type(angle_series_t) :: series
    real(rp) :: f(0:2), worst(3), x, d(0:2)
    integer :: i
    real(rp), parameter :: H = 0.02_rp
    call series%set_hermite(VALUES, SLOPES)
    worst = 0
    do i = 1, 5
      call series%evaluate((i - 1)/5.0_rp, f)
      worst(1) = max(worst(1), abs(f(0) - VALUES(i)), abs(f(1) - SLOPES(i)))
      ! Inside one piece five-point differences are exact for cubics.
      x = (i - 0.5_rp)/5
      call series%evaluate(x, f)
      d = differences(series, x, H)
      worst(2) = max(worst(2), abs(f(1) - d(1)))
      worst(3) = max(worst(3), abs(f(2) - d(2)))
    end do
    call kit%check_below('Hermite: values and slopes at the nodes are those given', worst(1), 1.0e-14_rp)
    call kit%check_below('Hermite: rate is the derivative', worst(2), 1.0e-12_rp)
    call kit%check_below('Hermite: acceleration is the second derivative', worst(3), 1.0e-11_rp)
  end subroutine check_hermite_nodes

  !> First and second derivative of a cubic, by five points.
  function differences(series, x, h) result(d)
    type(angle_series_t), intent(in) :: series
    real(rp), intent(in) :: x, h
    real(rp) :: d(0:2), f(0:2), g(-2:2)
    integer :: i
    do i = -2, 2
      call series%evaluate(x + i*h, f)
      g(i) = f(0)
    end do
    d(0) = g(0)
    d(1) = (8*(g(1) - g(-1)) - (g(2) - g(-2)))/(12*h)
    d(2) = (16*(g(1) + g(-1)) - (g(2) + g(-2)) - 30*g(0))/(12*h**2)
  end function differences

  subroutine check_hermite_period(kit)
    type(testkit_t), intent(inout) :: kit
    type(angle_series_t) :: series
    real(rp) :: f(0:2), g(0:2), worst(3)
    integer :: i, n
    call series%set_hermite(VALUES, SLOPES)
    worst = 0
    do i = 0, 31
      call series%evaluate(i/32.0_rp, f)
      do n = -3, 1000, 59 ! i/32 + n is exact
        call series%evaluate(i/32.0_rp + n, g)
        worst(1) = max(worst(1), maxval(abs(f - g)))
      end do
    end do
    do n = -3, 100
      call series%evaluate(real(n, rp), g)
      worst(2) = max(worst(2), abs(g(0) - VALUES(1)), abs(g(1) - SLOPES(1)))
      call series%evaluate(n - 1.0e-9_rp, f)
      worst(3) = max(worst(3), abs(f(0) + 1.0e-9_rp*f(1) - g(0)), 1.0e-3_rp*abs(f(1) - g(1)))
    end do
    call kit%check_below('Hermite: the same in every period', worst(1), 0.0_rp)
    call kit%check_below('Hermite: at t = n as at t = 0', worst(2), 1.0e-14_rp)
    call kit%check_below('Hermite: value and slope are continuous across t = n', worst(3), 1.0e-9_rp)
    call series%evaluate(-1.0e-20_rp, f)
    call kit%check_below('Hermite: a time that rounds to the end of the period', abs(f(0) - VALUES(1)), 1.0e-14_rp)
    call series%set_hermite([0.3_rp], [2.0_rp])
    call series%evaluate(1.0_rp, f)
    call kit%check_below('Hermite: one node', maxval(abs(f(0:1) - [0.3_rp, 2.0_rp])), 1.0e-15_rp)
  end subroutine check_hermite_period

  !> Samples of the Fourier series: value, rate and acceleration converge with orders 4, 3 and 2.
  subroutine check_hermite_order(kit)
    type(testkit_t), intent(inout) :: kit
    type(angle_series_t) :: series, exact
    real(rp) :: errors(0:2, 3), h(3), f(0:2), g(0:2)
    real(rp), allocatable :: a_h(:), b_h(:)
    integer :: level, n, i
    call exact%set_fourier(A0, A, B)
    errors = 0
    do level = 1, 3
      n = 40*2**level
      h(level) = 1.0_rp/n
      allocate (a_h(n), b_h(n))
      do i = 1, n
        call exact%evaluate((i - 1)*h(level), f)
        a_h(i) = f(0)
        b_h(i) = f(1)
      end do
      call series%set_hermite(a_h, b_h)
      deallocate (a_h, b_h)
      do i = 1, 10000
        call exact%evaluate(i*1.0e-4_rp, f)
        call series%evaluate(i*1.0e-4_rp, g)
        errors(:, level) = max(errors(:, level), abs(f - g))
      end do
    end do
    call kit%check_order('Hermite: value', h, errors(0, :), 4.0_rp, 0.1_rp)
    call kit%check_order('Hermite: rate', h, errors(1, :), 3.0_rp, 0.1_rp)
    call kit%check_order('Hermite: acceleration', h, errors(2, :), 2.0_rp, 0.1_rp)
  end subroutine check_hermite_order

  subroutine check_table(kit)
    type(testkit_t), intent(inout) :: kit
    type(angle_series_t) :: series
    type(wing_motion_t) :: motion
    type(message_list_t) :: errors
    real(rp) :: f(0:2), d(0:2), x, worst(3)
    integer :: i
    call series%set_table(TIMES, VALUES(:4), SLOPES(:4))
    worst = 0
    do i = 1, 4
      call series%evaluate(TIMES(i), f)
      worst(1) = max(worst(1), abs(f(0) - VALUES(i)), abs(f(1) - SLOPES(i)))
    end do
    call kit%check_below('table: between them the cubics of the Hermite basis', distance_to_basis(series), 1.0e-14_rp)
    do i = 1, 3
      x = (TIMES(i) + TIMES(i + 1))/2
      d = differences(series, x, 0.05_rp)
      call series%evaluate(x, f)
      worst(2) = max(worst(2), abs(f(1) - d(1)))
      worst(3) = max(worst(3), abs(f(2) - d(2)))
    end do
    call kit%check_below('table: values and slopes are those given', worst(1), 1.0e-14_rp)
    call kit%check_below('table: rate is the derivative', worst(2), 1.0e-12_rp)
    call kit%check_below('table: acceleration is the second derivative', worst(3), 1.0e-11_rp)
    call kit%check('a table has no period',.not. series%is_periodic())
    motion%phi = series
    motion%frequency = 2
    call motion%check_span(1.25_rp, 'motion of the left wing', errors)
    call kit%check('a run as long as the table', errors%count() == 0)
    call motion%check_span(1.5_rp, 'motion of the left wing', errors)
    call kit%check('a run longer than the table is a mistake', errors%count() == 1)
    if (errors%count() == 1) call kit%check('which says how long both are', errors%text(1) == 'motion of the left '// &
                     'wing: the table ends after 2.5 cycles, the run after 3.0; valid: a shorter run or a longer table')
  end subroutine check_table

  !> Largest distance of the table from y1 (1 + 2 s) r^2 + d1 h s r^2 + y2 s^2 (1 + 2 r) - d2 h s^2 r, r = 1 - s.
  real(rp) function distance_to_basis(series) result(worst)
    type(angle_series_t), intent(in) :: series
    real(rp) :: f(0:2), s, h, want
    integer :: i, j
    worst = 0
    do i = 1, 3
      h = TIMES(i + 1) - TIMES(i)
      do j = 1, 19
        s = j/20.0_rp
        call series%evaluate(TIMES(i) + s*h, f)
      want = (1 - s)**2*(VALUES(i)*(1 + 2*s) + SLOPES(i)*h*s) + s**2*(VALUES(i + 1)*(3 - 2*s) - SLOPES(i + 1)*h*(1 - s))
        worst = max(worst, abs(f(0) - want))
      end do
    end do
  end function distance_to_basis

  subroutine check_frequency(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_motion_t) :: motion
    type(angle_t) :: phi, alpha, theta
    real(rp) :: f(0:2)
    motion%frequency = 158
    call motion%phi%set_fourier(A0, A, B)
    call motion%alpha%set_hermite(VALUES, SLOPES)
    call motion%evaluate(0.0043_rp, phi, alpha, theta)
    call motion%phi%evaluate(0.0043_rp*158, f)
    call kit%check_close('rates are per time', phi%rate, 158*f(1), rtol=1.0e-15_rp)
    call kit%check_close('accelerations are per time squared', phi%acceleration, 158.0_rp**2*f(2), rtol=1.0e-15_rp)
    call motion%alpha%evaluate(0.0043_rp*158, f)
    call kit%check_close('each angle has its own series', alpha%value, f(0), rtol=1.0e-15_rp)
  end subroutine check_frequency

  subroutine check_ramp(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_motion_t) :: motion, free
    type(angle_t) :: p, q, alpha, theta
    real(rp), parameter :: WEIGHTS(4) = [4.0_rp/5, -1.0_rp/5, 4.0_rp/105, -1.0_rp/280], H = 0.001_rp, RAMP = 0.6_rp
    real(rp) :: f(0:2), worst(2), t, d(2)
    integer :: i, j
    motion%frequency = 1.5_rp
    call motion%phi%set_fourier(A0, A, B)
    free = motion
    motion%ramp = RAMP
    call motion%phi%evaluate(0.0_rp, f)
    call motion%evaluate(0.0_rp, p, alpha, theta)
    call kit%check_close('ramp: the wing starts in its place', p%value, f(0), atol=1.0e-15_rp)
    call kit%check_below('ramp: it starts at rest, smoothly', max(abs(p%rate), abs(p%acceleration)), 0.0_rp)
    worst = 0
    do i = 1, 50
      t = RAMP*i/51
      if (t < 5*H) cycle
      d = 0
      do j = 1, 4
        call motion%evaluate(t + j*H, p, alpha, theta)
        call motion%evaluate(t - j*H, q, alpha, theta)
        d = d + WEIGHTS(j)/H*[p%value - q%value, p%rate - q%rate]
      end do
      call motion%evaluate(t, p, alpha, theta)
      worst(1) = max(worst(1), abs(p%rate - d(1)))
      worst(2) = max(worst(2), abs(p%acceleration - d(2)))
    end do
    ! Round-off 1e-15/H times the size of angle and rate.
    call kit%check_below('ramp: rate is the derivative', worst(1), 1.0e-11_rp)
    call kit%check_below('ramp: acceleration is the derivative of the rate', worst(2), 1.0e-10_rp)
    call motion%evaluate(RAMP*(1 - 1.0e-9_rp), p, alpha, theta)
    call free%evaluate(RAMP, q, alpha, theta)
    call kit%check_below('ramp: it joins the motion with value, rate and acceleration', &
                     max(abs(p%value - q%value), abs(p%rate - q%rate), abs(p%acceleration - q%acceleration)), 1.0e-4_rp)
    call motion%evaluate(1.7_rp, p, alpha, theta)
    call free%evaluate(1.7_rp, q, alpha, theta)
    call kit%check_below('ramp: afterwards it is the motion', max(abs(p%value - q%value), abs(p%rate - q%rate), &
                                                                  abs(p%acceleration - q%acceleration)), 0.0_rp)
  end subroutine check_ramp

  subroutine check_extremes(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_motion_t) :: motion
    real(rp) :: smallest, largest
    call motion%phi%set_fourier(0.4_rp, [0.3_rp], [0.4_rp])
    call motion%stroke_extremes(smallest, largest)
    call kit%check_close('smallest angle of a stroke', smallest, 0.2_rp - 0.5_rp, atol=1.0e-15_rp)
    call kit%check_close('largest angle of a stroke', largest, 0.2_rp + 0.5_rp, atol=1.0e-15_rp)
    call motion%phi%set_table([0.0_rp, 1.0_rp, 3.0_rp], [0.0_rp, 1.0_rp, -2.0_rp], [0.0_rp, 0.0_rp, 0.0_rp])
    call motion%stroke_extremes(smallest, largest)
    call kit%check_close('of a table the whole counts', largest - smallest, 3.0_rp, atol=1.0e-12_rp)
    call motion%set_constant(0.3_rp, 0.0_rp, 0.0_rp)
    call motion%stroke_extremes(smallest, largest)
    call kit%check_below('a wing at rest has no amplitude', largest - smallest, 0.0_rp)
  end subroutine check_extremes

  subroutine check_change_of_kind(kit)
    type(testkit_t), intent(inout) :: kit
    type(angle_series_t) :: series
    real(rp) :: f(0:2)
    call series%set_fourier(A0, A, B)
    call series%set_table(TIMES, VALUES(:4), SLOPES(:4))
    call series%set_constant(0.2_rp)
    call series%evaluate(0.4_rp, f)
    call kit%check_below('a series that was another', maxval(abs(f - [0.2_rp, 0.0_rp, 0.0_rp])), 0.0_rp)
    call series%set_hermite(VALUES, SLOPES)
    call series%evaluate(0.0_rp, f)
    call kit%check_below('a Hermite series that was a constant', abs(f(0) - VALUES(1)), 1.0e-15_rp)
  end subroutine check_change_of_kind
end program test_kinematics_motion

! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes tails of the distributions that tests need, as logarithms, so that very small probabilities keep their digits.
!>
!> Integer degrees of freedom have finite sums (Abramowitz and Stegun 26.4.4 and 26.4.5); the tail of F is an incomplete
!> beta function by its continued fraction (26.5.8); a non-central chi^2 is a Poisson mixture of central ones (26.4.25).
module inference_distributions
  use base_constants, only: PI
  use base_kinds, only: i8, rp
  use base_random, only: random_stream_t
  implicit none
  private
  public :: log_chi2_tail, log_f_tail, chi2_threshold, noncentral_chi2_tail, detectable_noncentrality, log_add, &
            draw_chi2

contains

  !> Returns log(exp(a) + exp(b)).
  pure elemental real(rp) function log_add(a, b) result(c)
    real(rp), intent(in) :: a, b
    c = max(a, b)
    if (abs(a - b) < 700) c = c + log(1 + exp(-abs(a - b)))
  end function log_add

  !> Returns the logarithm of the probability that a chi^2 variable with `df` >= 1 degrees of freedom exceeds x.
  pure elemental real(rp) function log_chi2_tail(x, df) result(log_p)
    real(rp), intent(in) :: x
    integer, intent(in) :: df
    real(rp) :: half, term
    integer :: i
    log_p = 0
    if (.not. x > 0) return
    half = x/2
    if (modulo(df, 2) == 0) then
      term = 0
      log_p = 0
      do i = 1, df/2 - 1
        term = term + log(half/i)
        log_p = log_add(log_p, term)
      end do
    else
      log_p = log(erfc_scaled(sqrt(half)))
      term = log(2*sqrt(half/PI))
      do i = 1, (df - 1)/2
        if (i > 1) term = term + log(half/(i - 0.5_rp))
        log_p = log_add(log_p, term)
      end do
    end if
    log_p = min(0.0_rp, log_p - half)
  end function log_chi2_tail

  !> Returns the x that a chi^2 variable with `df` degrees of freedom exceeds with probability exp(log_p).
  pure real(rp) function chi2_threshold(log_p, df) result(x)
    real(rp), intent(in) :: log_p
    integer, intent(in) :: df
    real(rp) :: lower, upper
    integer :: i
    lower = 0
    upper = df + 10
    do while (log_chi2_tail(upper, df) > log_p)
      upper = 2*upper
    end do
    do i = 1, 200
      x = (lower + upper)/2
      if (log_chi2_tail(x, df) > log_p) then
        lower = x
      else
        upper = x
      end if
      if (upper - lower <= 1.0e-12_rp*upper) exit
    end do
  end function chi2_threshold

  !> Returns the probability that a non-central chi^2 variable exceeds x.
  pure real(rp) function noncentral_chi2_tail(x, df, noncentrality) result(p)
    real(rp), intent(in) :: x, noncentrality
    integer, intent(in) :: df
    real(rp) :: log_weight, half
    integer :: j
    half = noncentrality/2
    p = 0
    log_weight = -half
    do j = 0, int(half + 12*sqrt(half) + 40)
      if (j > 0) log_weight = log_weight + log(max(half, tiny(half))/j)
      if (log_weight > -700) p = p + exp(max(-700.0_rp, log_weight + log_chi2_tail(x, df + 2*j)))
    end do
    p = min(1.0_rp, p)
  end function noncentral_chi2_tail

  !> Returns the non-centrality with which a chi^2 test with `df` degrees of freedom at the level exp(log_p) rejects with
  !> probability `power` (Mendler, Doehler and Ventura 2021, DOI 10.1016/j.ymssp.2020.107561).
  pure real(rp) function detectable_noncentrality(log_p, df, power) result(noncentrality)
    real(rp), intent(in) :: log_p, power
    integer, intent(in) :: df
    real(rp) :: x, lower, upper
    integer :: i
    x = chi2_threshold(log_p, df)
    lower = 0
    upper = x + 10
    do while (noncentral_chi2_tail(x, df, upper) < power)
      upper = 2*upper
    end do
    do i = 1, 60
      noncentrality = (lower + upper)/2
      if (noncentral_chi2_tail(x, df, noncentrality) < power) then
        lower = noncentrality
      else
        upper = noncentrality
      end if
    end do
  end function detectable_noncentrality

  !> Returns the logarithm of the probability that an F variable with these degrees of freedom exceeds x.
  pure real(rp) function log_f_tail(x, df, df_below) result(log_p)
    real(rp), intent(in) :: x
    integer, intent(in) :: df, df_below
    real(rp) :: a, b, fraction, front
    log_p = 0
    if (.not. x > 0) return
    a = 0.5_rp*df_below
    b = 0.5_rp*df
    fraction = df_below/(df_below + df*x)
    front = log_gamma(a + b) - log_gamma(a) - log_gamma(b) + a*log(fraction) + b*log(df*x/(df_below + df*x))
    if (fraction < (a + 1)/(a + b + 2)) then
      log_p = front + log(beta_fraction(fraction, a, b)/a)
    else
      log_p = log(max(tiny(a), 1 - exp(front)*beta_fraction(1 - fraction, b, a)/b))
    end if
    log_p = min(0.0_rp, log_p)
  end function log_f_tail

  !> Evaluates the continued fraction of the incomplete beta function, by Lentz's method.
  pure real(rp) function beta_fraction(x, a, b) result(f)
    real(rp), intent(in) :: x, a, b
    real(rp), parameter :: SMALL = 1.0e-280_rp
    real(rp) :: c, d, term
    integer :: i, m
    f = 1
    c = 1
    d = 0
    do i = 1, 5000
      m = i/2
      if (modulo(i, 2) == 0) then
        term = m*(b - m)*x/((a + i - 1)*(a + i))
      else
        term = -(a + m)*(a + b + m)*x/((a + i - 1)*(a + i))
      end if
      d = 1 + term*d
      if (abs(d) < SMALL) d = SMALL
      d = 1/d
      c = 1 + term/c
      if (abs(c) < SMALL) c = SMALL
      f = f*c*d
      if (abs(1 - c*d) < 1.0e-14_rp) exit
    end do
    f = 1/f
  end function beta_fraction

  !> Draws a chi^2 variable with df >= 2 degrees of freedom from a stream: twice a gamma variable by the rejection of Marsaglia
  !> and Tsang, ACM Trans. Math. Softw. 26 (2000) 363.
  subroutine draw_chi2(stream, df, x)
    type(random_stream_t), intent(inout) :: stream
    integer, intent(in) :: df
    real(rp), intent(out) :: x
    real(rp) :: d, c, g, v
    integer(i8) :: first
    first = stream%position
    d = 0.5_rp*df - 1.0_rp/3
    c = 1/sqrt(9*d)
    do
      g = stream%gaussian()
      v = (1 + c*g)**3
      if (.not. v > 0) cycle
      if (log(stream%uniform()) < 0.5_rp*g**2 + d - d*v + d*log(v)) exit
      if (stream%position - first > 100000_i8) exit
    end do
    x = 2*d*v
  end subroutine draw_chi2
end module inference_distributions

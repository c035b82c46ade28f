! SPDX-License-Identifier: GPL-3.0-or-later
!> Averages the evidence for a signal of unknown strength over strengths whose variances are uniform in their logarithm.
module inference_effect_size
  use base_kinds, only: rp
  implicit none
  private
  public :: effect_size_prior_t, effect_variance

  integer, parameter :: N_SCALES = 13
  real(rp), parameter :: LARGEST_SCALE = 1.0e6_rp   !< variance of a signal in units of that of the noise

  !> Strengths over which the evidence of signals of unknown strength is averaged, uniform in their logarithm.
  type :: effect_size_prior_t
    real(rp), allocatable :: gain(:, :)   !< (m, N_SCALES) half of tau s^2/(1 + tau s^2)
    real(rp), allocatable :: offset(:)    !< (N_SCALES) half of the sum of log(1 + tau s^2)
  contains
    procedure :: init => prior_init
    procedure :: log_evidence => prior_log_evidence
    procedure :: log_likelihood => prior_log_likelihood
  end type effect_size_prior_t

contains

  !> Takes s(m), the sd of the directions for unit strength.
  subroutine prior_init(self, s)
    class(effect_size_prior_t), intent(out) :: self
    real(rp), intent(in) :: s(:)
    real(rp) :: tau
    integer :: i
    allocate (self%gain(size(s), N_SCALES), self%offset(N_SCALES))
    do i = 1, N_SCALES
      tau = effect_variance(i)
      self%gain(:, i) = 0.5_rp*tau*s**2/(1 + tau*s**2)
      self%offset(i) = 0.5_rp*sum(log(1 + tau*s**2))
    end do
  end subroutine prior_init

  !> Returns the logarithm of the probability density of projections w(m) on the directions, over that without a signal, averaged
  !> over strengths.
  pure real(rp) function prior_log_evidence(self, w) result(log_evidence)
    class(effect_size_prior_t), intent(in) :: self
    real(rp), intent(in) :: w(:)
    real(rp) :: terms(N_SCALES), most
    terms = matmul(w**2, self%gain) - self%offset
    most = maxval(terms)
    log_evidence = most + log(sum(exp(max(-700.0_rp, terms - most)))/N_SCALES)
  end function prior_log_evidence

  !> Returns this logarithm at the most likely strength, at least 0.
  pure real(rp) function prior_log_likelihood(self, w) result(log_likelihood)
    class(effect_size_prior_t), intent(in) :: self
    real(rp), intent(in) :: w(:)
    log_likelihood = max(0.0_rp, maxval(matmul(w**2, self%gain) - self%offset))
  end function prior_log_likelihood

  !> Returns number i of the variances that are averaged.
  pure real(rp) function effect_variance(i)
    integer, intent(in) :: i
    effect_variance = LARGEST_SCALE**(real(i - 1, rp)/(N_SCALES - 1))
  end function effect_variance
end module inference_effect_size

! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimates the fraction of the error variance that neighbours do not have in common. The scatter of neighbours shows only the
!> independent part. The declared sd gives the rest only where it is right. Therefore the rest is what makes the data most
!> probable, under normal priors of the parameters of the baseline and of unknown causes of unit strength everywhere. A bound keeps
!> it from taking in a misfit.
module inference_noise_fraction
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: find_noise_fraction

  integer, parameter :: MOST_EVALUATIONS = 9
  real(rp), parameter :: LARGEST = 0.9_rp !< of the variance that neighbours have in common

contains

  !> Finds independent_fraction (see `covariance` of simulator_t) at the baseline q by golden section. `is_new` tells whether it
  !> differs from `known`, the one of the fit, by more than a thousandth. It is `known` if neighbours have no errors in common, or
  !> if something fails, and otherwise at least `least` and 0.1.
  subroutine find_noise_fraction(simulator, q, from, known, least, independent_fraction, is_new)
    class(simulator_t), intent(inout) :: simulator
    real(rp), intent(in) :: q(:), known, least
    class(solver_state_t), intent(in) :: from !< near q
    real(rp), intent(out) :: independent_fraction
    logical, intent(out) :: is_new
    real(rp), parameter :: GOLDEN = 0.6180339887498949_rp
    real(rp), allocatable :: residuals(:), jacobian(:, :), nuisances(:, :), patterns(:, :), directions(:, :)
    real(rp) :: ends(2), inner(2), values(2)
    integer :: i, n, m
    logical :: is_valid
    is_new = .false.
    independent_fraction = known
    if (.not. simulator%has_common_errors()) return
    n = simulator%n_observations
    m = simulator%n_baseline
    allocate (residuals(n), jacobian(n, m), nuisances(n, simulator%n_nuisances), patterns(n, simulator%n_patterns))
    call simulator%evaluate(q, [(i, i=1, m)], from, residuals, jacobian, is_valid)
    if (is_valid) call simulator%directions(q, from, nuisances, patterns, is_valid)
    if (.not. is_valid) return
    do i = 1, m
      jacobian(:, i) = jacobian(:, i)*simulator%parameters(i)%prior_sd
    end do
    directions = reshape([nuisances, jacobian, patterns], [n, size(nuisances, 2) + m + size(patterns, 2)])
    ends = [0.0_rp, min(LARGEST, 1 - least)]
    inner = ends(2) - (ends(2) - ends(1))*[GOLDEN, 1 - GOLDEN]
    values = [log_likelihood(inner(1)), log_likelihood(inner(2))]
    do i = 3, MOST_EVALUATIONS
      if (values(1) > values(2)) then
        ends(2) = inner(2)
        inner = [ends(2) - GOLDEN*(ends(2) - ends(1)), inner(1)]
        values = [log_likelihood(inner(1)), values(1)]
      else
        ends(1) = inner(1)
        inner = [inner(2), ends(1) + GOLDEN*(ends(2) - ends(1))]
        values = [values(2), log_likelihood(inner(2))]
      end if
    end do
    if (maxval(values) > -huge(1.0_rp)) independent_fraction = 1 - sum(ends)/2
    is_new = abs(independent_fraction - known) > 1.0e-3_rp

  contains

    !> Returns the logarithm of the probability density of the data, without a constant, if neighbours have the fraction `common` of
    !> the variance in common.
    real(rp) function log_likelihood(common) result(value)
      real(rp), intent(in) :: common
      type(whitener_t) :: whitener
      type(failure_t) :: failure
      real(rp) :: left(n)
      integer :: k
      value = -huge(1.0_rp)
      call whitener%init(simulator, [(k, k=1, n)], 1 - common, failure)
      if (failure%failed) return
      call whitener%add_directions(directions)
      left = residuals
      call whitener%apply_one(left)
      value = -0.5_rp*(whitener%log_determinant + sum(left**2))
    end function log_likelihood
  end subroutine find_noise_fraction
end module inference_noise_fraction

! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimates the fraction of the error variance that neighbours have in common. The scatter of neighbours shows only the
!> independent part. The declared sd gives the rest only where it is right. Therefore the rest is what makes the data most
!> probable, under normal priors of the parameters of the baseline and of unknown causes of unit strength everywhere.
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
  real(rp), parameter :: LARGEST = 0.9_rp !< of the variance

contains

  !> Sets the fraction at the baseline q by golden section. `is_new` tells whether it differs from the previous one by more than a
  !> thousandth. Where something fails the fraction stays.
  subroutine find_noise_fraction(simulator, q, from, is_new)
    class(simulator_t), intent(inout) :: simulator
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from !< near q
    logical, intent(out) :: is_new
    real(rp), parameter :: GOLDEN = 0.6180339887498949_rp
    real(rp), allocatable :: residuals(:), jacobian(:, :), nuisances(:, :), patterns(:, :), directions(:, :)
    real(rp) :: ends(2), inner(2), values(2), before
    integer :: i, n, m
    logical :: is_valid
    is_new = .false.
    before = simulator%common_fraction()
    if (before < 0) return
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
    ends = [0.0_rp, LARGEST]
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
    call simulator%set_common_fraction(merge(sum(ends)/2, before, maxval(values) > -huge(1.0_rp)))
    is_new = abs(simulator%common_fraction() - before) > 1.0e-3_rp

  contains

    !> Returns the logarithm of the probability density of the data, without a constant.
    real(rp) function log_likelihood(fraction) result(value)
      real(rp), intent(in) :: fraction
      type(whitener_t) :: whitener
      type(failure_t) :: failure
      real(rp) :: left(n)
      integer :: k
      call simulator%set_common_fraction(fraction)
      value = -huge(1.0_rp)
      call whitener%init(simulator, [(k, k=1, n)], failure)
      if (failure%failed) return
      call whitener%add_directions(directions)
      left = residuals
      call whitener%apply_one(left)
      value = -0.5_rp*(whitener%log_determinant + sum(left**2))
    end function log_likelihood
  end subroutine find_noise_fraction
end module inference_noise_fraction

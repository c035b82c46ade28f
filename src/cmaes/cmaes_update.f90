! SPDX-License-Identifier: GPL-3.0-or-later
!> Updates mean, paths, covariance and step size from the ranked candidates of one generation (tutorial, figure 6; h_sigma stops
!> p_c while the step size is still growing fast).
!>
!>     m   <- m + c_m sigma y_w,   y_w = sum_{i<=mu} w_i y_i,   y_i = (x_i - m)/sigma
!>     p_s <- (1 - c_s) p_s + sqrt(c_s (2 - c_s) mu_eff) C^(-1/2) y_w
!>     p_c <- (1 - c_c) p_c + h sqrt(c_c (2 - c_c) mu_eff) y_w
!>     C   <- (1 + c_1 (1 - h) c_c (2 - c_c) - c_1 - c_mu sum w) C + c_1 p_c p_c^T + c_mu sum w'_i y_i y_i^T
!>     sigma <- sigma exp(min(1, c_s/d_s (|p_s|/chi - 1)))
!>
!> with w'_i = w_i n/|C^(-1/2) y_i|^2 for negative weights, and C^(-1/2) before the update. Failed candidates carry no information
!> about directions, so that the others get the weights of a population of their number.
module cmaes_update
  use base_kinds, only: rp
  use cmaes_params, only: cmaes_params_t, weights_of_valid
  use cmaes_products, only: add_outers, mirror, multiply
  use cmaes_ranking, only: FAILED
  use cmaes_state, only: cmaes_state_t, cmaes_work_t
  implicit none
  private
  public :: update_distribution

contains

  !> Moves the state by one generation; work%x holds the candidates, work%classes their classes and
  !> work%order their ranks.
  subroutine update_distribution(p, state, work)
    type(cmaes_params_t), intent(in) :: p
    type(cmaes_state_t), intent(inout) :: state
    type(cmaes_work_t), intent(inout) :: work
    real(rp) :: length, h, mu_eff
    integer :: i, mu, n_valid, n_used

    n_valid = count(work%classes /= FAILED)
    call weights_of_valid(p, work%weights(:n_valid), mu, mu_eff)
    do i = 1, n_valid
      work%y(:, i) = (work%x(:, work%order(i)) - state%mean)/state%sigma
    end do
    work%step = 0
    do i = 1, mu
      work%step = work%step + work%weights(i)*work%y(:, i)
    end do
    work%old_mean = state%mean
    state%mean = state%mean + p%c_m*state%sigma*work%step

    call multiply(work%inverse_root, work%step, work%z)
    state%p_sigma = (1 - p%c_sigma)*state%p_sigma + sqrt(p%c_sigma*(2 - p%c_sigma)*mu_eff)*work%z
    length = norm2(state%p_sigma)
    h = merge(1.0_rp, 0.0_rp, length < (1.4_rp + 2.0_rp/(p%n + 1))*p%chi* &
              sqrt(1 - (1 - p%c_sigma)**(2*real(state%generation + 1, rp))))
    state%p_c = (1 - p%c_c)*state%p_c + h*sqrt(p%c_c*(2 - p%c_c)*mu_eff)*work%step

    state%c = (1 + p%c_1*(1 - h)*p%c_c*(2 - p%c_c) - p%c_1 - p%c_mu*sum(work%weights(:n_valid)))*state%c
    work%weights(:n_valid) = p%c_mu*work%weights(:n_valid)
    do i = mu + 1, n_valid
      if (.not. work%weights(i) < 0) cycle
      call multiply(work%inverse_root, work%y(:, i), work%z)
      work%weights(i) = work%weights(i)*p%n/max(sum(work%z**2), tiny(1.0_rp))
    end do
    n_used = n_valid
    if (.not. any(work%weights(mu + 1:n_valid) < 0)) n_used = mu
    work%weights(n_used + 1) = p%c_1 ! the path is one more vector
    work%y(:, n_used + 1) = state%p_c
    call add_outers(work%weights(:n_used + 1), work%y(:, :n_used + 1), state%c)
    call mirror(state%c)

    state%sigma = state%sigma*exp(min(1.0_rp, p%c_sigma/p%d_sigma*(length/p%chi - 1)))
    state%generation = state%generation + 1
    state%attempt = 0
  end subroutine update_distribution
end module cmaes_update

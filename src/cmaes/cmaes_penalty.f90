! SPDX-License-Identifier: GPL-3.0-or-later
!> Penalises candidates outside the box [0, 1]^n. They are evaluated at the nearest point inside and ranked with
!>
!>     f + sum_i gamma_i (x_i - clip(x_i))^2/xi_i,   xi_i = exp(0.9 (log C_ii - mean_j log C_jj)),
!>
!> where the weights gamma follow the spread of f: Hansen, Niederberger, Guzzella and Koumoutsakos,
!> IEEE Trans. Evol. Comput. 13 (2009), section IV-B. While the mean has never left the box they are 0.
module cmaes_penalty
  use base_kinds, only: rp
  use cmaes_box, only: clip
  use cmaes_params, only: cmaes_params_t
  use cmaes_ranking, only: FEASIBLE, rank, sort_values
  use cmaes_state, only: cmaes_state_t, cmaes_work_t
  implicit none
  private
  public :: penalise

contains

  !> Adds the penalty to the keys of feasible candidates; infeasible and failed ones keep theirs. work%classes, work%keys and work%x
  !> must belong to this generation; work%order is overwritten.
  subroutine penalise(p, state, work)
    type(cmaes_params_t), intent(in) :: p
    type(cmaes_state_t), intent(inout) :: state
    type(cmaes_work_t), intent(inout) :: work
    real(rp) :: mean_log, scale
    integer :: i, k
    call note_spread(p, state, work)
    call adapt_weights(p, state, work)
    if (.not. state%penalty%is_on) return
    mean_log = 0
    do i = 1, p%n
      mean_log = mean_log + log(state%c(i, i))
    end do
    mean_log = mean_log/p%n
    work%distances = 0
    do i = 1, p%n
      scale = state%penalty%weights(i)/exp(0.9_rp*(log(state%c(i, i)) - mean_log))
      do k = 1, p%lambda
        work%distances(k) = work%distances(k) + scale*excess(work%x(i, k))**2
      end do
    end do
    where (work%classes == FEASIBLE) work%keys = work%keys + work%distances
  end subroutine penalise

  !> Returns how far a coordinate lies outside the box, with sign.
  pure real(rp) function excess(x)
    real(rp), intent(in) :: x
    excess = x - clip(x)
  end function excess

  !> Adds the interquartile range of f over the variance of the sample to the ring. A generation with fewer than four feasible
  !> candidates or with equal quartiles adds nothing.
  subroutine note_spread(p, state, work)
    type(cmaes_params_t), intent(in) :: p
    type(cmaes_state_t), intent(inout) :: state
    type(cmaes_work_t), intent(inout) :: work
    real(rp) :: range, variance
    integer :: n_feasible, i
    n_feasible = count(work%classes == FEASIBLE)
    if (n_feasible < 4) return
    call rank(work%classes, work%keys, work%order, work%merged, work%bits)
    range = work%keys(work%order((3*n_feasible + 3)/4)) - work%keys(work%order((n_feasible + 3)/4))
    variance = 0
    do i = 1, p%n
      variance = variance + state%sigma**2*state%c(i, i)/p%n
    end do
    if (.not. range > 0) return
    state%penalty%spreads(modulo(state%penalty%n, size(state%penalty%spreads)) + 1) = range/variance
    state%penalty%n = state%penalty%n + 1
  end subroutine note_spread

  !> Sets the weights when the mean leaves the box for the first time, and raises those of coordinates whose mean is far outside.
  subroutine adapt_weights(p, state, work)
    type(cmaes_params_t), intent(in) :: p
    type(cmaes_state_t), intent(inout) :: state
    type(cmaes_work_t), intent(inout) :: work
    real(rp) :: limit, factor
    integer :: i, n
    if (state%penalty%n == 0) return
    do i = 1, p%n
      if (abs(excess(state%mean(i))) > 0) exit
    end do
    if (i > p%n) return
    if (.not. state%penalty%is_on) then
      n = min(state%penalty%n, size(state%penalty%spreads))
      work%sorted(:n) = state%penalty%spreads(:n)
      call sort_values(work%sorted(:n))
      state%penalty%weights = 2*(work%sorted((n + 1)/2) + work%sorted(n/2 + 1))/(2*p%n)
      state%penalty%is_on = .true.
    end if
    factor = 1.1_rp**max(1.0_rp, p%mu_eff/(10*p%n))
    do i = 1, p%n
      limit = 3*state%sigma*sqrt(state%c(i, i))*max(1.0_rp, sqrt(real(p%n, rp))/p%mu_eff)
      if (abs(excess(state%mean(i))) > limit) state%penalty%weights(i) = factor*state%penalty%weights(i)
    end do
  end subroutine adapt_weights
end module cmaes_penalty

! SPDX-License-Identifier: GPL-3.0-or-later
!> Derives the constants of one CMA-ES run from the options, the number of parameters n and the population lambda: table 1 and
!> equations (49) to (58) of the tutorial, Hansen, arXiv:1604.00772v2.
module cmaes_params
  use base_errors, only: require
  use base_kinds, only: rp
  use cmaes_options, only: cmaes_options_t, default_lambda, option_problem, option_problem_t, CONSTANTS_PAPER, OPTION_NONE, &
                           WEIGHTS_ACTIVE, WEIGHTS_PAPER
  implicit none
  private
  public :: cmaes_params_t, derive_params, default_lambda, weights_of_valid

  !> Constants of a run; set once.
  type :: cmaes_params_t
    integer :: n = 0      !< parameters
    integer :: lambda = 0 !< candidates of a generation
    integer :: mu = 0     !< parents
    real(rp), allocatable :: weights(:) !< lambda numbers, best first; the first mu sum to 1
    real(rp) :: mu_eff = 0        !< variance effective number of parents
    real(rp) :: mu_eff_minus = 0  !< the same for the negative weights
    logical :: is_paper = .false. !< weights of the paper
    real(rp) :: alpha_minus = 0   !< sum of the absolute values of the negative weights
    real(rp) :: c_m = 1, c_sigma = 0, d_sigma = 1, c_c = 0, c_1 = 0, c_mu = 0
    real(rp) :: chi = 0           !< expected length of a normal vector
    real(rp) :: sigma0 = 0        !< first step size
    integer :: eigen_interval = 1 !< generations between two eigen-decompositions
    integer :: max_iterations = 0
    integer :: n_recent = 0       !< number of generations whose best f tolfun and tolfunhist compare
    integer :: tolstagnation = 0
  end type cmaes_params_t

  integer, parameter :: LARGEST_EAGER = 100 ! up to this n C is decomposed in every generation

contains

  !> Returns the constants for n parameters; `lambda` and `sigma0` replace those of the options (restarts). The options must be
  !> valid.
  function derive_params(options, n, lambda, sigma0) result(p)
    type(cmaes_options_t), intent(in) :: options
    integer, intent(in) :: n
    integer, intent(in), optional :: lambda
    real(rp), intent(in), optional :: sigma0
    type(cmaes_params_t) :: p
    type(option_problem_t) :: problem
    problem = option_problem(options, n)
    call require(problem%option == OPTION_NONE, 'derive_params: options without mistakes')
    p%n = n
    p%lambda = merge(options%lambda, default_lambda(n), options%lambda > 0)
    if (present(lambda)) p%lambda = lambda
    p%mu = p%lambda/2
    if (options%mu > 0) p%mu = min(options%mu, p%mu)
    p%sigma0 = options%sigma0
    if (present(sigma0)) p%sigma0 = sigma0
    p%is_paper = options%weights == WEIGHTS_PAPER
    allocate (p%weights(p%lambda))
    call raw_weights(p%is_paper, p%mu, p%weights)
    p%mu_eff = effective(p%weights(:p%mu))
    p%mu_eff_minus = effective(p%weights(p%mu + 1:))
    if (options%constants == CONSTANTS_PAPER) then
      call paper_constants(p)
    else
      call tutorial_constants(p)
    end if
    call override(p%c_sigma, options%c_sigma)
    call override(p%c_c, options%c_c)
    call override(p%c_1, options%c_1)
    call override(p%c_mu, options%c_mu)
    p%d_sigma = damping(n, p%mu_eff, p%c_sigma)
    call override(p%d_sigma, options%d_sigma)
    p%c_m = options%c_m
    if (options%weights == WEIGHTS_ACTIVE .and. p%c_mu > 0) &
      p%alpha_minus = min(1 + p%c_1/p%c_mu, 1 + 2*p%mu_eff_minus/(p%mu_eff + 2), &
                          (1 - p%c_1 - p%c_mu)/(p%n*p%c_mu))
    call override(p%alpha_minus, options%alpha_minus)
    call scale_weights(p%alpha_minus, p%mu, p%weights)
    p%chi = sqrt(real(n, rp))*(1 - 1/(4*real(n, rp)) + 1/(21*real(n, rp)**2))
    if (n > LARGEST_EAGER .and. p%c_1 + p%c_mu > 0) &
      p%eigen_interval = max(1, int(min(1.0e6_rp, 1/(10*n*(p%c_1 + p%c_mu)))))
    p%max_iterations = int(100 + 150*real(n + 3, rp)**2/sqrt(real(p%lambda, rp)))
    if (options%max_iterations > 0) p%max_iterations = options%max_iterations
    p%n_recent = 10 + ceiling(30*real(n, rp)/p%lambda)
    p%tolstagnation = int(100 + 100*real(n, rp)**1.5_rp/p%lambda)
    if (options%tolstagnation > 0) p%tolstagnation = options%tolstagnation
  end function derive_params

  !> Computes w'_i = ln(mu + 1/2) - ln i, which is ln((lambda + 1)/2) - ln i for even lambda and the default mu; the paper has ln(mu
  !> + 1) - ln i, which equals the formula of the tutorial for odd lambda.
  pure subroutine raw_weights(is_paper, mu, weights)
    logical, intent(in) :: is_paper
    integer, intent(in) :: mu
    real(rp), intent(out) :: weights(:)
    real(rp) :: middle
    integer :: i
    middle = mu + 0.5_rp
    if (is_paper .or. size(weights) == 2*mu + 1) middle = mu + 1
    do i = 1, size(weights)
      weights(i) = log(middle) - log(real(i, rp))
    end do
  end subroutine raw_weights

  !> Returns the weights for a generation in which only size(weights) candidates, at least two, are valid. They are the weights of a
  !> population of this size, as if the failed candidates had not been drawn.
  pure subroutine weights_of_valid(p, weights, mu, mu_eff)
    type(cmaes_params_t), intent(in) :: p
    real(rp), intent(out) :: weights(:)
    integer, intent(out) :: mu
    real(rp), intent(out) :: mu_eff
    mu = p%mu
    mu_eff = p%mu_eff
    weights = p%weights(:size(weights))
    if (size(weights) == p%lambda) return
    mu = max(1, (p%mu*size(weights))/p%lambda)
    call raw_weights(p%is_paper, mu, weights)
    mu_eff = effective(weights(:mu))
    call scale_weights(p%alpha_minus, mu, weights)
  end subroutine weights_of_valid

  !> Returns the effective number of weights: sum(w)^2/sum(w^2).
  pure real(rp) function effective(w)
    real(rp), intent(in) :: w(:)
    effective = sum(w)**2/sum(w**2)
  end function effective

  !> Sets the learning rates of Hansen's tutorial.
  pure subroutine tutorial_constants(p)
    type(cmaes_params_t), intent(inout) :: p
    real(rp) :: n
    n = p%n
    p%c_1 = 2/((n + 1.3_rp)**2 + p%mu_eff)
    p%c_mu = min(1 - p%c_1, 2*(0.25_rp + p%mu_eff + 1/p%mu_eff - 2)/((n + 2)**2 + p%mu_eff))
    p%c_sigma = (p%mu_eff + 2)/(n + p%mu_eff + 5)
    p%c_c = (4 + p%mu_eff/n)/(n + 4 + 2*p%mu_eff/n)
  end subroutine tutorial_constants

  !> Sets the learning rates of the paper: one rate c_cov for both updates, of which the rank-one update has the share 1/mu_eff.
  pure subroutine paper_constants(p)
    type(cmaes_params_t), intent(inout) :: p
    real(rp) :: n, c_cov, fraction
    n = p%n
    fraction = 1/p%mu_eff
    c_cov = fraction*2/(n + 1.41_rp)**2 + (1 - fraction)*min(1.0_rp, (2*p%mu_eff - 1)/((n + 2)**2 + p%mu_eff))
    p%c_1 = fraction*c_cov
    p%c_mu = (1 - fraction)*c_cov
    p%c_sigma = (p%mu_eff + 2)/(n + p%mu_eff + 3)
    p%c_c = 4/(n + 4)
  end subroutine paper_constants

  !> Returns the damping of the step size.
  pure real(rp) function damping(n, mu_eff, c_sigma) result(d)
    integer, intent(in) :: n
    real(rp), intent(in) :: mu_eff, c_sigma
    d = 1 + 2*max(0.0_rp, sqrt(max(0.0_rp, (mu_eff - 1)/(n + 1))) - 1) + c_sigma
  end function damping

  !> Scales the positive weights to the sum 1 and the negative ones to the sum -alpha_minus: the largest sum for which C stays
  !> positive definite and the negative weights do not act faster than the positive ones, or 0.
  pure subroutine scale_weights(alpha_minus, mu, weights)
    real(rp), intent(in) :: alpha_minus
    integer, intent(in) :: mu
    real(rp), intent(inout) :: weights(:)
    real(rp) :: total
    weights(:mu) = weights(:mu)/sum(weights(:mu))
    total = abs(sum(weights(mu + 1:)))
    if (total > 0) weights(mu + 1:) = alpha_minus*weights(mu + 1:)/total
  end subroutine scale_weights

  !> Replaces constants by those that the user has set.
  pure subroutine override(constant, value)
    real(rp), intent(inout) :: constant
    real(rp), intent(in) :: value
    if (value >= 0) constant = value
  end subroutine override
end module cmaes_params

! SPDX-License-Identifier: GPL-3.0-or-later
!> The constants of CMA-ES: published tables, and the same formulas evaluated with 40 digits.
program test_cmaes_constants
  use base_kinds, only: rp
  use cmaes_options, only: cmaes_options_t, option_problem, option_problem_t, CONSTANTS_PAPER, OPTION_ALPHA_MINUS, OPTION_C_1, &
                           OPTION_C_M, OPTION_C_SIGMA, OPTION_CONSTANTS, OPTION_D_SIGMA, OPTION_EVALUATIONS, OPTION_FACTORS, &
                           OPTION_LAMBDA, OPTION_MU, OPTION_NONE, OPTION_SIGMA0, OPTION_TOLERANCES, OPTION_WEIGHTS, &
                           WEIGHTS_PAPER, WEIGHTS_POSITIVE
  use cmaes_params, only: cmaes_params_t, default_lambda, derive_params
  use testkit, only: testkit_t
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  implicit none
  integer, parameter :: LAMBDAS(3) = [11, 16, 64], MUS(3) = [5, 8, 32]
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_tutorial()
  call test_exact()
  call test_paper()
  call test_weights()
  call test_overrides()
  call test_problems()
  call t%finish()

contains

  !> n = 11 to the five digits of the reference table: mu_eff, c_1, c_mu, c_sigma, d_sigma, c_c, alpha.
  subroutine test_tutorial()
    real(rp), parameter :: SMALL(7) = [3.41477_rp, 0.01293_rp, 0.02271_rp, 0.27890_rp, &
      1.27890_rp, 0.27594_rp, 1.56930_rp]
    real(rp), parameter :: MIDDLE(7) = [4.84091_rp, 0.01281_rp, 0.03794_rp, 0.32824_rp, &
      1.32824_rp, 0.27960_rp, 1.33766_rp]
    real(rp), parameter :: LARGE(7) = [17.62165_rp, 0.01184_rp, 0.17070_rp, 0.58360_rp, &
      1.93744_rp, 0.30773_rp, 0.43534_rp]
    real(rp), parameter :: TABLE(7, 3) = reshape([SMALL, MIDDLE, LARGE], [7, 3])
    type(cmaes_options_t) :: options
    type(cmaes_params_t) :: p
    real(rp) :: got(7)
    integer :: i
    call t%check('lambda is 8, 10, 12, 15 for n = 5, 10, 20, 40', &
                 all([default_lambda(5), default_lambda(10), default_lambda(20), default_lambda(40)] == &
                     [8, 10, 12, 15]))
    do i = 1, 3
      options%lambda = LAMBDAS(i)
      p = derive_params(options, 11)
      got = [p%mu_eff, p%c_1, p%c_mu, p%c_sigma, p%d_sigma, p%c_c, p%alpha_minus]
      call t%check('mu is half of lambda', p%mu == MUS(i))
      call t%check_below('constants of the tutorial to five digits', maxval(abs(got - TABLE(:, i))), 0.51e-5_rp)
    end do
  end subroutine test_tutorial

  !> The same in 40 digits: mu_eff, c_1, c_mu, c_sigma, d_sigma, c_c, alpha, first and last weight, sum.
  subroutine test_exact()
    real(rp), parameter :: SMALL(10) = [3.41477208633760886644_rp, 0.0129278494323616623295_rp, &
      0.0227082328911627264842_rp, 0.278899595743801918256_rp, 1.27889959574380191826_rp, 0.275940742988234206043_rp, &
      1.56930230962149162002_rp, 0.429544041986649872409_rp, -0.484259039747031506817_rp, -0.569302309621491620020_rp]
    real(rp), parameter :: MIDDLE(10) = [4.84091450090117466606_rp, 0.0128097629248719744492_rp, &
      0.0379368349443483284723_rp, 0.328244449186976372087_rp, 1.32824444918697637209_rp, 0.279599285054413067093_rp, &
      1.33766029621773493604_rp, 0.328436208515218832163_rp, -0.287132149060667510475_rp, -0.337660296217734936039_rp]
    real(rp), parameter :: LARGE(10) = [17.6216524068556573511_rp, 0.0118405093520879292814_rp, &
      0.170702601424270195932_rp, 0.583601667443765621989_rp, 1.93743913045713586293_rp, 0.307733896342666738957_rp, &
      0.435343468914052791941_rp, 0.116656804379777297201_rp, -0.0241600319829829911769_rp, 0.564656531085947208059_rp]
    real(rp), parameter :: EXACT(10, 3) = reshape([SMALL, MIDDLE, LARGE], [10, 3])
    type(cmaes_options_t) :: options
    type(cmaes_params_t) :: p
    real(rp) :: got(10)
    integer :: i
    do i = 1, 3
      options%lambda = LAMBDAS(i)
      p = derive_params(options, 11)
      got = [p%mu_eff, p%c_1, p%c_mu, p%c_sigma, p%d_sigma, p%c_c, p%alpha_minus, p%weights(1), &
             p%weights(p%lambda), sum(p%weights)]
      call t%check_below('constants to round-off', maxval(abs(got/EXACT(:, i) - 1)), 1.0e-14_rp)
      call t%check_close('length of a normal vector', p%chi, 3.242552198126880114_rp, rtol=1.0e-14_rp)
    end do
  end subroutine test_exact

  !> pCMALib's, which are the paper's: mu_eff, c_sigma, c_c, c_1, c_mu.
  subroutine test_paper()
    real(rp), parameter :: TABLE(5, 3) = reshape([ &
                                                 3.41477_rp, 0.31093_rp, 0.26667_rp, 0.00812_rp, 0.01960_rp, &
                                                 5.09619_rp, 0.37160_rp, 0.26667_rp, 0.00883_rp, 0.03616_rp, &
                                                 17.87836_rp, 0.62357_rp, 0.26667_rp, 0.00986_rp, 0.16645_rp], [5, 3])
    type(cmaes_options_t) :: options
    type(cmaes_params_t) :: p
    integer :: i
    options%weights = WEIGHTS_PAPER
    options%constants = CONSTANTS_PAPER
    do i = 1, 3
      options%lambda = LAMBDAS(i)
      p = derive_params(options, 11)
      call t%check_below('constants of the paper to five digits', &
                         maxval(abs([p%mu_eff, p%c_sigma, p%c_c, p%c_1, p%c_mu] - TABLE(:, i))), 0.51e-5_rp)
      call t%check('the paper has no negative weights', all(p%weights >= 0))
    end do
  end subroutine test_paper

  subroutine test_weights()
    type(cmaes_options_t) :: options
    type(cmaes_params_t) :: active, positive, paper
    integer :: lambda
    do lambda = 3, 40
      options = cmaes_options_t(lambda=lambda)
      active = derive_params(options, 7)
      options%weights = WEIGHTS_POSITIVE
      positive = derive_params(options, 7)
      options%weights = WEIGHTS_PAPER
      paper = derive_params(options, 7)
      if (abs(sum(active%weights(:active%mu)) - 1) > 1.0e-14_rp .or. &
          any(active%weights(2:) > active%weights(:lambda - 1)) .or. &
          abs(sum(active%weights(active%mu + 1:)) + active%alpha_minus) > 1.0e-14_rp) &
        call t%check('active weights fall and sum to 1 and -alpha', .false.)
      if (any(abs(positive%weights(positive%mu + 1:)) > 0) .or. &
          any(abs(positive%weights(:positive%mu) - active%weights(:active%mu)) > 0)) &
        call t%check('positive weights are the first mu of the active ones', .false.)
      if (mod(lambda, 2) == 1 .neqv. maxval(abs(paper%weights - positive%weights)) <= 1.0e-14_rp) &
        call t%check('the weights of the paper differ for even lambda only', .false.)
    end do
    call t%check('weights for lambda from 3 to 40', t%n_failed == 0)
  end subroutine test_weights

  subroutine test_overrides()
    type(cmaes_options_t) :: options
    type(cmaes_params_t) :: p
    options%lambda = 20
    options%mu = 4
    options%c_m = 0.9_rp
    options%c_sigma = 0.11_rp
    options%d_sigma = 2.5_rp
    options%c_c = 0.12_rp
    options%c_1 = 0.13_rp
    options%c_mu = 0.14_rp
    options%sigma0 = 0.15_rp
    options%alpha_minus = 0.16_rp
    p = derive_params(options, 6)
    call t%check('every constant can be chosen', p%lambda == 20 .and. p%mu == 4 .and. &
                 all(abs([p%c_m, p%c_sigma, p%d_sigma, p%c_c, p%c_1, p%c_mu, p%sigma0, p%alpha_minus] - &
                         [0.9_rp, 0.11_rp, 2.5_rp, 0.12_rp, 0.13_rp, 0.14_rp, 0.15_rp, 0.16_rp]) <= 0))
    call t%check_close('the negative weights sum to the chosen value', sum(p%weights(5:)), -0.16_rp, atol=1.0e-14_rp)
    call t%check('weights are positive up to the chosen mu', all(p%weights(:4) > 0) .and. all(p%weights(5:) < 0))
    p = derive_params(options, 6, lambda=40, sigma0=0.5_rp)
    call t%check('a restart chooses lambda and sigma0', p%lambda == 40 .and. abs(p%sigma0 - 0.5_rp) <= 0)
    options = cmaes_options_t()
    p = derive_params(options, 101)
    call t%check('C is decomposed lazily above n = 100', p%eigen_interval == int(1/(1010*(p%c_1 + p%c_mu))))
    p = derive_params(options, 100)
    call t%check('and in every generation up to there', p%eigen_interval == 1)
  end subroutine test_overrides

  subroutine test_problems()
    type(cmaes_options_t) :: good
    type(option_problem_t) :: none
    none = option_problem(good, 11)
    call t%check('the defaults are without mistakes', none%option == OPTION_NONE .and. none%text == '')
    call refused(cmaes_options_t(weights=0), OPTION_WEIGHTS, 'active, positive or paper')
    call refused(cmaes_options_t(constants=3), OPTION_CONSTANTS, 'tutorial or paper')
    call refused(cmaes_options_t(lambda=2), OPTION_LAMBDA, 'at least 3')
    call refused(cmaes_options_t(lambda=8, mu=5), OPTION_MU, 'lambda/2 = 4')
    call refused(cmaes_options_t(mu=6), OPTION_MU, 'lambda/2 = 5') ! lambda is 11 for n = 11
    call refused(cmaes_options_t(alpha_minus=-0.5_rp), OPTION_ALPHA_MINUS, 'alpha_minus')
    call refused(cmaes_options_t(alpha_minus=0.5_rp, weights=WEIGHTS_POSITIVE), OPTION_ALPHA_MINUS, 'needs active weights')
    call refused(cmaes_options_t(sigma0=0.0_rp), OPTION_SIGMA0, 'sigma0')
    call refused(cmaes_options_t(sigma0=ieee_value(1.0_rp, ieee_quiet_nan)), OPTION_SIGMA0, 'sigma0')
    call refused(cmaes_options_t(c_m=0.0_rp), OPTION_C_M, 'c_m')
    call refused(cmaes_options_t(c_sigma=1.5_rp), OPTION_C_SIGMA, 'c_sigma')
    call refused(cmaes_options_t(d_sigma=0.0_rp), OPTION_D_SIGMA, 'd_sigma')
    call refused(cmaes_options_t(c_1=0.6_rp, c_mu=0.5_rp), OPTION_C_1, 'c_1 + c_mu')
    call refused(cmaes_options_t(tolx=-1.0_rp), OPTION_TOLERANCES, 'tolerances')
    call refused(cmaes_options_t(condition_limit=0.5_rp), OPTION_FACTORS, 'condition_limit')
    call refused(cmaes_options_t(max_evaluations=0), OPTION_EVALUATIONS, 'max_evaluations')
  end subroutine test_problems

  subroutine refused(options, option, word)
    type(cmaes_options_t), intent(in) :: options
    integer, intent(in) :: option !< OPTION_* that is wrong
    character(*), intent(in) :: word
    type(option_problem_t) :: problem
    problem = option_problem(options, 11)
    call t%check('refused: '//word, index(problem%text, word) > 0 .and. problem%option == option)
  end subroutine refused
end program test_cmaes_constants

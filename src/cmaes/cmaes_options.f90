! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the options of CMA-ES, with the defaults of the tutorial (Hansen, arXiv:1604.00772v2).
module cmaes_options
  use base_kinds, only: rp, i8
  use base_named_kinds, only: kind_of, named_kind_t, word_of
  use base_text, only: number_text
  use base_visitor, only: visited_t, visitor_t
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  implicit none
  private
  public :: cmaes_options_t, option_problem_t, option_problem, default_lambda, WEIGHTINGS, WEIGHTS_ACTIVE, WEIGHTS_POSITIVE, &
            WEIGHTS_PAPER, CONSTANT_SETS, CONSTANTS_TUTORIAL, CONSTANTS_PAPER

  integer, parameter :: WEIGHTS_ACTIVE = 1, WEIGHTS_POSITIVE = 2, WEIGHTS_PAPER = 3
  type(named_kind_t), parameter :: WEIGHTINGS(3) = [named_kind_t('active', WEIGHTS_ACTIVE), &
                                                    named_kind_t('positive', WEIGHTS_POSITIVE), &
                                                    named_kind_t('paper', WEIGHTS_PAPER)]
  integer, parameter :: CONSTANTS_TUTORIAL = 1, CONSTANTS_PAPER = 2 !< the latter: those of pCMALib
  type(named_kind_t), parameter :: CONSTANT_SETS(2) = [named_kind_t('tutorial', CONSTANTS_TUTORIAL), &
                                                       named_kind_t('paper', CONSTANTS_PAPER)]

  !> Options that may be wrong. OPTION_TOLERANCES, OPTION_FACTORS and OPTION_LIMITS stand for the several options of one check.
  integer, parameter, public :: OPTION_NONE = 0, OPTION_WEIGHTS = 1, OPTION_CONSTANTS = 2, OPTION_LAMBDA = 3, OPTION_MU = 4, &
                                OPTION_SIGMA0 = 5, OPTION_C_M = 6, OPTION_C_SIGMA = 7, OPTION_D_SIGMA = 8, OPTION_C_C = 9, &
                                OPTION_C_1 = 10, OPTION_C_MU = 11, OPTION_ALPHA_MINUS = 12, OPTION_TOLERANCES = 13, &
                                OPTION_FACTORS = 14, OPTION_TARGET = 15, OPTION_SCALE = 16, OPTION_LIMITS = 17, &
                                OPTION_EVALUATIONS = 18

  real(rp), parameter :: UNSET = -1 !< marks a constant that is computed from n and lambda

  !> Constants that are UNSET, and lambda or mu of 0, follow from the number of parameters. Lengths are
  !> in the coordinates of the search, in which a box has the side 1. The tolerances of f are relative to
  !> `f_scale`.
  type, extends(visited_t) :: cmaes_options_t
    integer :: weights = WEIGHTS_ACTIVE
    integer :: constants = CONSTANTS_TUTORIAL
    integer :: lambda = 0                  !< candidates of a generation; default 4 + floor(3 ln n)
    integer :: mu = 0                      !< parents; default lambda/2, rounded down
    real(rp) :: sigma0 = 0.3_rp            !< first standard deviation of the sample
    real(rp) :: c_m = 1                    !< learning rate of the mean
    real(rp) :: c_sigma = UNSET            !< cumulation of the step size path
    real(rp) :: d_sigma = UNSET            !< damping of the step size
    real(rp) :: c_c = UNSET                !< cumulation of the covariance path
    real(rp) :: c_1 = UNSET                !< learning rate of the rank-one update
    real(rp) :: c_mu = UNSET               !< learning rate of the rank-mu update
    real(rp) :: alpha_minus = UNSET        !< sum of the absolute values of the negative weights
    integer(i8) :: seed = 1                !< seed of all random numbers
    real(rp) :: f_target = -huge(1.0_rp)   !< stop at f <= f_target
    real(rp) :: f_scale = UNSET            !< scale of f; default: median |f| of the first generation
    real(rp) :: tolfun = 1.0e-11_rp        !< range of f in a generation and of the recent best, over f_scale
    real(rp) :: tolfunhist = 1.0e-12_rp    !< range of the recent best f, over f_scale
    real(rp) :: tolx = 1.0e-11_rp          !< standard deviation of every coordinate, over sigma0
    real(rp) :: tolfacupx = 1.0e3_rp       !< standard deviation of a coordinate, over sigma0
    real(rp) :: tolupsigma = 1.0e20_rp     !< sigma over sigma0 and the longest axis
    real(rp) :: condition_limit = 1.0e14_rp !< condition number of C
    integer :: tolflatfitness = 1          !< successive generations with equal parents that are tolerated
    integer :: tolstagnation = 0           !< generations; default 100 + 100 n^1.5/lambda
    integer :: max_iterations = 0          !< of one run; default 100 + 150 (n + 3)^2/sqrt(lambda)
    integer(i8) :: max_evaluations = huge(1_i8) !< of the whole search, restarts included
  contains
    procedure :: visit => options_visit
  end type cmaes_options_t

  !> What is wrong with the options: OPTION_NONE and an empty text if nothing is.
  type :: option_problem_t
    integer :: option = OPTION_NONE   !< OPTION_*
    character(:), allocatable :: text !< begins with the name of the component and says what is valid
  end type option_problem_t

contains

  !> Shows the options that define a search to the visitor, but not its limits and tolerances. Kinds are shown as words, which files
  !> keep.
  subroutine options_visit(self, visitor)
    class(cmaes_options_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    character(8) :: weights, constants
    weights = word_of(WEIGHTINGS, self%weights)
    constants = word_of(CONSTANT_SETS, self%constants)
    call visitor%visit('weights', weights)
    call visitor%visit('constants', constants)
    self%weights = kind_of(WEIGHTINGS, weights)
    self%constants = kind_of(CONSTANT_SETS, constants)
    call visitor%visit('lambda', self%lambda)
    call visitor%visit('mu', self%mu)
    call visitor%visit('sigma0', self%sigma0)
    call visitor%visit('c_m', self%c_m)
    call visitor%visit('c_sigma', self%c_sigma)
    call visitor%visit('d_sigma', self%d_sigma)
    call visitor%visit('c_c', self%c_c)
    call visitor%visit('c_1', self%c_1)
    call visitor%visit('c_mu', self%c_mu)
    call visitor%visit('alpha_minus', self%alpha_minus)
    call visitor%visit('seed', self%seed)
    call visitor%leave_out('f_target f_scale tolfun tolfunhist tolx tolfacupx tolupsigma condition_limit tolflatfitness')
    call visitor%leave_out('tolstagnation max_iterations max_evaluations')
  end subroutine options_visit

  !> Returns the population of the tutorial: 4 + floor(3 ln n).
  pure integer function default_lambda(n) result(lambda)
    integer, intent(in) :: n
    lambda = 4 + int(3*log(real(n, rp)))
  end function default_lambda

  !> Returns the first mistake in the options for n parameters.
  function option_problem(options, n) result(problem)
    type(cmaes_options_t), intent(in) :: options
    integer, intent(in) :: n
    type(option_problem_t) :: problem
    integer :: lambda
    problem%text = ''
    lambda = merge(options%lambda, default_lambda(max(1, n)), options%lambda > 0)
    call refuse(n < 1, OPTION_LAMBDA, 'there must be at least one parameter')
    call refuse(all(options%weights /= WEIGHTINGS%kind), &
                OPTION_WEIGHTS, 'weights must be active, positive or paper')
    call refuse(all(options%constants /= CONSTANT_SETS%kind), &
                OPTION_CONSTANTS, 'constants must be tutorial or paper')
    call refuse(options%lambda /= 0 .and. options%lambda < 3, OPTION_LAMBDA, 'lambda must be at least 3, or 0 for the default')
    call refuse(options%mu < 0, OPTION_MU, 'mu must not be negative')
    call refuse(options%mu > lambda/2, OPTION_MU, 'mu must be at most lambda/2 = '//number_text(lambda/2))
    call refuse(outside(options%sigma0, huge(1.0_rp)) .or. is_below(options%sigma0, 0.0_rp), &
                OPTION_SIGMA0, 'sigma0 must be positive')
    call refuse(outside(options%c_m, 1.0_rp) .or. is_below(options%c_m, 0.0_rp), OPTION_C_M, 'c_m must lie in (0, 1]')
    call refuse(outside(options%c_sigma, 1.0_rp), OPTION_C_SIGMA, 'c_sigma must lie in [0, 1]')
    call refuse(outside(options%d_sigma, huge(1.0_rp)), OPTION_D_SIGMA, 'd_sigma must be positive')
    call refuse(abs(options%d_sigma) <= 0, OPTION_D_SIGMA, 'd_sigma must be positive')
    call refuse(outside(options%c_c, 1.0_rp), OPTION_C_C, 'c_c must lie in [0, 1]')
    call refuse(outside(options%c_1, 1.0_rp), OPTION_C_1, 'c_1 must lie in [0, 1]')
    call refuse(outside(options%c_mu, 1.0_rp), OPTION_C_MU, 'c_mu must lie in [0, 1]')
    call refuse(max(options%c_1, 0.0_rp) + max(options%c_mu, 0.0_rp) > 1, OPTION_C_1, 'c_1 + c_mu must not exceed 1')
    call refuse(outside(options%alpha_minus, huge(1.0_rp)), OPTION_ALPHA_MINUS, 'alpha_minus must not be negative')
    call refuse(options%alpha_minus > 0 .and. options%weights /= WEIGHTS_ACTIVE, OPTION_ALPHA_MINUS, &
                'alpha_minus needs active weights')
    call refuse(is_below(options%tolfun, -tiny(1.0_rp)) .or. is_below(options%tolfunhist, -tiny(1.0_rp)) .or. &
                is_below(options%tolx, -tiny(1.0_rp)), OPTION_TOLERANCES, 'tolerances must not be negative')
    call refuse(is_below(options%tolfacupx, 1.0_rp) .or. is_below(options%tolupsigma, 1.0_rp) .or. &
                is_below(options%condition_limit, 1.0_rp), OPTION_FACTORS, &
                'tolfacupx, tolupsigma and condition_limit must exceed 1')
    call refuse(is_below(options%f_target, -huge(1.0_rp), or_equal=.false.), OPTION_TARGET, 'f_target must be finite')
    call refuse(outside(options%f_scale, huge(1.0_rp)), OPTION_SCALE, 'f_scale must not be negative')
    call refuse(min(options%tolflatfitness, options%tolstagnation, options%max_iterations) < 0, &
                OPTION_LIMITS, 'tolflatfitness, tolstagnation and max_iterations must not be negative')
    call refuse(options%max_evaluations < 1, OPTION_EVALUATIONS, 'max_evaluations must be positive')

  contains

    subroutine refuse(is_wrong, option, sentence)
      logical, intent(in) :: is_wrong
      integer, intent(in) :: option
      character(*), intent(in) :: sentence
      if (.not. is_wrong .or. problem%option /= OPTION_NONE) return
      problem = option_problem_t(option, sentence)
    end subroutine refuse

  end function option_problem

  !> Tells whether x is not finite, or at most `least`, or below it if not `or_equal`.
  pure logical function is_below(value, least, or_equal)
    real(rp), intent(in) :: value, least
    logical, intent(in), optional :: or_equal
    is_below = .true.
    if (.not. ieee_is_finite(value)) return
    is_below = value <= least
    if (present(or_equal)) is_below = value < least
  end function is_below

  !> Tells whether x is neither UNSET nor in [0, most].
  pure logical function outside(value, most)
    real(rp), intent(in) :: value, most
    outside = .true.
    if (.not. ieee_is_finite(value)) return
    outside = (value < 0 .and. value > UNSET) .or. value < UNSET .or. value > most
  end function outside
end module cmaes_options

! SPDX-License-Identifier: GPL-3.0-or-later
!> Declares the ini keys of `msm_train`. All units are SI. Keys whose default is `preset`, -1 or 0 follow [Train] preset.
module common_train_keys
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use cmaes_options, only: cmaes_options_t, CONSTANT_SETS, WEIGHTINGS
  use cmaes_search, only: RESTART_RULES, RESTARTS_NONE
  use common_foreign_inputs, only: register_foreign_inputs, INPUT_OF_TRAIN
  use common_instrument, only: register_instrument_keys
  use common_measurement_keys, only: register_measurement_keys
  use common_solver_keys, only: limit_keys, solver_keys
  use common_wing_keys, only: register_wing_keys
  use io_include, only: register_include
  use io_keys, only: declaring, keys_t
  use io_registry, only: registry_t
  use io_stop, only: job_limits_t
  use least_squares_fit, only: fit_options_t
  use solid_statics, only: static_options_t
  implicit none
  private
  public :: train_choices_t, train_keys, register_train_keys, write_train_reference, SCALES, COSTS, POLISHES

  integer, parameter, public :: BY_PRESET = 0 !< the kind of every choice that [Train] preset, or the measurement, decides
  integer, parameter, public :: PRESET_DEFAULT = 1, PRESET_PAPER = 2
  type(named_kind_t), parameter :: PRESETS(2) = [named_kind_t('default', PRESET_DEFAULT), named_kind_t('paper', PRESET_PAPER)]
  integer, parameter, public :: SCALE_LOG = 1, SCALE_LINEAR = 2
  type(named_kind_t), parameter :: SCALES(3) = [named_kind_t('preset', BY_PRESET), named_kind_t('log', SCALE_LOG), &
                                                named_kind_t('linear', SCALE_LINEAR)]
  integer, parameter, public :: COST_H = 1, COST_CHI2 = 2
  type(named_kind_t), parameter :: COSTS(3) = [named_kind_t('auto', BY_PRESET), named_kind_t('h', COST_H), &
                                               named_kind_t('chi2', COST_CHI2)]
  integer, parameter, public :: START_RANDOM = 1, START_WING = 2
  type(named_kind_t), parameter :: STARTS(2) = [named_kind_t('random', START_RANDOM), named_kind_t('wing', START_WING)]
  !> The kind is the number of stages.
  type(named_kind_t), parameter :: STAGES(3) = [named_kind_t('preset', BY_PRESET), named_kind_t('1', 1), named_kind_t('2', 2)]
  integer, parameter, public :: POLISH_YES = 1, POLISH_NO = 2
  type(named_kind_t), parameter :: POLISHES(3) = [named_kind_t('preset', BY_PRESET), named_kind_t('yes', POLISH_YES), &
                                                  named_kind_t('no', POLISH_NO)]

  !> Holds what a user chooses.
  type :: train_choices_t
    integer :: preset = PRESET_DEFAULT
    character(:), allocatable :: parameters
    integer :: scale = BY_PRESET, cost = BY_PRESET, stages = BY_PRESET, polish = BY_PRESET
    integer :: start = START_RANDOM
    integer :: weights = BY_PRESET, constants = BY_PRESET
    integer :: restarts = RESTARTS_NONE
    integer :: max_restarts = 0
    logical :: moves = .true., intervals = .true.
    real(rp) :: prior_decades = 1
    integer :: polish_starts = 1
    type(cmaes_options_t) :: search
    logical :: has_tolfun = .false.
    type(fit_options_t) :: fit
    type(static_options_t) :: solver
    character(:), allocatable :: name, result
    integer :: checkpoint_every = 1
    type(job_limits_t) :: limits
    real(rp) :: progress_seconds = 30
  end type train_choices_t

contains

  !> Fills `registry` with every key that `msm_train` accepts.
  subroutine register_train_keys(registry)
    type(registry_t), intent(inout), target :: registry
    type(train_choices_t) :: unused
    type(keys_t) :: keys
    call register_include(registry)
    call register_foreign_inputs(registry, INPUT_OF_TRAIN)
    call register_wing_keys(registry, required=.true.)
    call register_measurement_keys(registry, is_training=.true.)
    call register_instrument_keys(registry)
    keys = declaring(registry)
    call train_keys(keys, unused)
  end subroutine register_train_keys

  !> Writes the reference of these keys, a part of docs/formats/parameters.md, to `unit`.
  subroutine write_train_reference(unit)
    integer, intent(in) :: unit
    type(registry_t) :: registry
    call register_train_keys(registry)
    write (unit, '(a)') '# Parameters of `msm_train`', '', &
      'The training of a wing on bending tests. All numbers are in SI units.', ''
    call registry%write_markdown(unit)
  end subroutine write_train_reference

  !> Declares and reads all keys of a training except those of the wing, the measurement and the instrument.
  subroutine train_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(train_choices_t), intent(inout) :: c
    call keys%section('Train', 'free parameters and their bounds')
    call keys%kind('preset', c%preset, 'default', PRESETS, 'paper: as Truong et al.: linear box, their weights, '// &
                   'population 16, end at h < 1e-6 m (1e-4 cm in the paper) or after 100 generations, no polish, two stages, '// &
                   'cross-springs')
    call keys%text('parameters', c%parameters, 'E, joint:*', 'free parameters: NAME, or NAME LOWER UPPER, or NAME LOWER '// &
                   'UPPER log|linear, separated by commas; names as in [Wing] and [Instrument] parameters, or E, D; '// &
                   'joint:*, E:* and hardening:* mean all joints and all veins')
    call keys%kind('scale', c%scale, 'preset', SCALES, 'scale of parameters whose bounds name none; paper: linear')
    call keys%kind('cost', c%cost, 'auto', COSTS, 'cost that the search minimises: h [m] of the paper, or the sum of '// &
                   'squares in units of the declared errors; auto: h unless there are scalar observations')
    call keys%kind('start', c%start, 'random', STARTS, &
                   'start of the first run: a random point of the box at which the wing has an equilibrium under all loads, '// &
                   'or the values of [Wing]')
    call keys%integer('seed', c%search%seed, 1, 'seed of all random numbers', min=0)
    call keys%kind('stages', c%stages, 'preset', STAGES, '2: after the first search, a second one with E fixed, as in '// &
                   'the paper')
    call search_keys(keys, c)
    call keys%section('Polish', 'least squares with exact derivatives after the search')
    call keys%kind('polish', c%polish, 'preset', POLISHES, 'least squares after the search; preset: yes with [Train] '// &
                   'preset = default, no with paper')
    call keys%switch('moves', c%moves, .true., 'look for a lower minimum: move every parameter to the other side of its prior '// &
                     'and repeat the fit from there and, where the wing snaps, leave out each load in turn, until no move '// &
                     'finds a lower minimum')
    call keys%switch('intervals', c%intervals, .true., '90 % intervals by profile likelihood')
    call keys%real('prior_decades', c%prior_decades, 1.0_rp, 'standard deviation of the prior about the values of [Wing]', &
                   unit='decades', &
                   above=0.0_rp)
    call keys%integer('starts', c%polish_starts, 3, &
                      'largest number of candidates from which the fit starts, one after another; it stops when one result '// &
                      'fits within the errors and the fits have cost as much as the search; different results are reported', &
                      min=1, max=1000)
    call keys%integer('iterations', c%fit%most_iterations, 100, 'largest number of trial steps in every stage', min=1, max=10000)
    call solver_keys(keys, c%solver, 300)
    call keys%section('Saving', 'what is written, and when to stop')
    call keys%text('name', c%name, 'train', 'first part of the names of all other output files; it may contain a folder')
    call keys%text('result', c%result, 'trained.ini', 'file of the trained wing, a fragment for [include]')
    call keys%integer('checkpoint_every', c%checkpoint_every, 1, 'generations between backups', min=1)
    call limit_keys(keys, c%limits, c%progress_seconds)
  end subroutine train_keys

  !> Visits the keys of [CMAES], the global search.
  subroutine search_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(train_choices_t), intent(inout) :: c
    associate (o => c%search)
      call keys%section('CMAES', 'the global search; lengths are fractions of the box')
      call keys%integer('lambda', o%lambda, 0, 'candidates in a generation; 0: 4 + 3 ln n for n parameters; paper: 16', min=0, &
                        max=100000)
      call keys%real('sigma0', o%sigma0, 0.3_rp, 'initial step size', above=0.0_rp, max=10.0_rp)
      call keys%kind('weights', c%weights, 'preset', [named_kind_t('preset', BY_PRESET), WEIGHTINGS], 'recombination weights '// &
                     'of the ranked candidates')
      call keys%kind('constants', c%constants, 'preset', [named_kind_t('preset', BY_PRESET), CONSTANT_SETS], 'learning rates')
      call keys%kind('restarts', c%restarts, 'none', RESTART_RULES, 'restarts after a run that ends before its target')
      call keys%integer('max_restarts', c%max_restarts, 9, 'largest number of restarts', min=0, max=1000)
      call keys%integer('max_generations', o%max_iterations, 0, 'largest number of generations in a run; 0: no limit; paper: 100', &
                        min=0)
      call keys%integer('max_evaluations', o%max_evaluations, 0, &
                        'largest number of candidates in a search with its restarts; 0: at most 15 for every parameter, and '// &
                        'if [Polish] moves follow, the search ends at the first candidate that has an equilibrium under all '// &
                        'loads; paper: no limit', min=0)
      call keys%real('target', o%f_target, -1.0_rp, 'the search ends when the cost is below this value; -1: no target; paper: '// &
                     '1e-6 m', min=-1.0_rp)
      call keys%real('tolfun', o%tolfun, 1.0e-3_rp, &
                     'a run ends when the costs of a generation and the best costs of recent generations differ by less than '// &
                     'this, relative to the median cost of the first generation; the polish does the rest; paper: '// &
                     '1e-11', min=0.0_rp, &
                     given=c%has_tolfun)
      call keys%real('tolfunhist', o%tolfunhist, 1.0e-12_rp, 'the same for the best costs alone', min=0.0_rp)
      call keys%real('tolx', o%tolx, 1.0e-11_rp, 'a run ends when the step is shorter than this times sigma0', min=0.0_rp)
      call keys%integer('tolstagnation', o%tolstagnation, 0, 'a run ends after so many generations without progress; 0: '// &
                        'computed from n and lambda', min=0)
      call keys%real('condition_limit', o%condition_limit, 1.0e14_rp, 'a run ends when the condition number of the covariance '// &
                     'matrix exceeds this', above=1.0_rp)
    end associate
    call strategy_keys(keys, c%search)
  end subroutine search_keys

  !> Declares and reads the constants of the search that follow from n and lambda unless the user gives them; see
  !> docs/theory/optimiser.md.
  subroutine strategy_keys(keys, o)
    type(keys_t), intent(in) :: keys
    type(cmaes_options_t), intent(inout) :: o
    character(*), parameter :: AUTO = '; -1: computed from n and lambda'
    call keys%integer('mu', o%mu, 0, 'parents in a generation; 0: half of lambda', min=0, max=50000)
    call keys%real('c_m', o%c_m, 1.0_rp, 'learning rate of the mean', above=0.0_rp, max=1.0_rp)
    call keys%real('c_sigma', o%c_sigma, -1.0_rp, 'cumulation constant of the path of the step size'//AUTO, min=-1.0_rp, max=1.0_rp)
    call keys%real('d_sigma', o%d_sigma, -1.0_rp, 'damping of the step size'//AUTO//' and c_sigma', min=-1.0_rp)
    call keys%real('c_c', o%c_c, -1.0_rp, 'cumulation constant of the path of the covariance'//AUTO, min=-1.0_rp, max=1.0_rp)
    call keys%real('c_1', o%c_1, -1.0_rp, 'learning rate of the rank-one update'//AUTO, min=-1.0_rp, max=1.0_rp)
    call keys%real('c_mu', o%c_mu, -1.0_rp, 'learning rate of the rank-mu update'//AUTO//'; c_1 + c_mu is at most 1', &
                   min=-1.0_rp, max=1.0_rp)
    call keys%real('alpha_minus', o%alpha_minus, -1.0_rp, 'sum of the absolute values of the negative weights'//AUTO// &
                   '; larger values can make the covariance indefinite; the program then repairs it', min=-1.0_rp, max=10.0_rp)
    call keys%real('tolfacupx', o%tolfacupx, 1.0e3_rp, 'a run ends when the step is longer than this times sigma0', above=1.0_rp)
    call keys%real('tolupsigma', o%tolupsigma, 1.0e20_rp, 'a run ends when sigma/sigma0 exceeds this times the length of the '// &
                   'longest axis', above=1.0_rp)
    call keys%integer('tolflatfitness', o%tolflatfitness, 1, 'a run ends after more than this number of consecutive '// &
                      'generations in which all parents have equal costs', &
                      min=0)
  end subroutine strategy_keys
end module common_train_keys

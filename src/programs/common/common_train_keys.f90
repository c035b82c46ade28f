! SPDX-License-Identifier: GPL-3.0-or-later
!> The register of the ini keys of `msm_train`. All units are SI. Keys whose default is `preset`, -1 or 0 follow
!> [Train] preset.
module common_train_keys
  use base_kinds, only: rp
  use common_foreign_inputs, only: register_foreign_inputs, INPUT_OF_TRAIN
  use common_instrument, only: register_instrument_keys
  use common_outliers, only: register_outliers
  use common_wing_keys, only: register_wing_keys
  use io_include, only: register_include
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_train_keys, write_train_reference

contains

  !> Fills `registry` with every key that `msm_train` accepts.
  subroutine register_train_keys(registry)
    type(registry_t), intent(inout) :: registry
    call register_include(registry)
    call register_foreign_inputs(registry, INPUT_OF_TRAIN)
    call register_wing_keys(registry, required=.true.)
    call registry%add_section('Measurement', 'what the wing did in the experiment')
    call registry%add_text('Measurement', 'file', '', 'measurement file (docs/formats/measurement-format.md); looked for '// &
                         'here and then in the folder of the input file. Several individuals: a list, separated by '// &
                           'commas; [Wing] file may then be a list as long', required=.true.)
    call register_outliers(registry, 'preset|leave_out|keep', 'preset')
    call register_instrument_keys(registry)
    call register_train(registry)
    call register_search(registry)
    call register_polish(registry)
    call register_solver(registry)
    call register_saving(registry)
  end subroutine register_train_keys

  !> Writes the reference of these keys, a part of docs/formats/parameters.md.
  subroutine write_train_reference(unit)
    integer, intent(in) :: unit
    type(registry_t) :: registry
    call register_train_keys(registry)
    write (unit, '(a)') '# Parameters of `msm_train`', '', &
      'The training of a wing on bending tests. All numbers are in SI units.', ''
    call registry%write_markdown(unit)
  end subroutine write_train_reference

  subroutine register_train(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Train', 'what is sought, and where')
    call r%add_word('Train', 'preset', 'default', 'default|paper', 'paper: as Truong et al.: linear box, their '// &
                    'weights, population 16, end at h < 1e-6 m (their 1e-4 in cm) or after 100 generations, no '// &
                    'polish, two stages, cross-springs')
    call r%add_text('Train', 'parameters', 'E, joint:*', 'what is sought: NAME, or NAME LOWER UPPER, or NAME LOWER '// &
                  'UPPER log|linear, separated by commas; names as in [Wing] and [Instrument] parameters, or E, D; '// &
                    'joint:*, E:* and hardening:* mean all joints and all veins')
    call r%add_word('Train', 'scale', 'preset', 'preset|log|linear', 'of bounds that do not say it; paper: linear')
    call r%add_word('Train', 'cost', 'auto', 'auto|h|chi2', &
                    'what the search makes small: h [m] of the paper, or the '// &
                    'sum of squares in units of the declared errors; auto: h unless there are scalar observations')
    call r%add_word('Train', 'start', 'random', 'random|wing', &
                  'where the first run begins: at a random point of the box that bears all loads, or at the values '// &
                    'of [Wing]')
    call r%add_integer('Train', 'seed', 1, 'of all random numbers', min=0)
    call r%add_word('Train', 'stages', 'preset', 'preset|1|2', '2: a second search with E fixed follows, as in the '// &
                    'paper')
  end subroutine register_train

  subroutine register_search(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('CMAES', 'the global search; lengths are fractions of the box')
    call r%add_integer('CMAES', 'lambda', 0, 'candidates of a generation; 0: 4 + 3 ln n, paper: 16', min=0, max=100000)
    call r%add_real('CMAES', 'sigma0', 0.3_rp, 'first step', above=0.0_rp, max=10.0_rp)
    call r%add_word('CMAES', 'weights', 'preset', 'preset|active|positive|paper', 'of the ranks')
    call r%add_word('CMAES', 'constants', 'preset', 'preset|tutorial|paper', 'learning rates')
    call r%add_word('CMAES', 'restarts', 'none', 'none|ipop|bipop', 'what follows a run that ends before its target')
    call r%add_integer('CMAES', 'max_restarts', 9, 'at most', min=0, max=1000)
    call r%add_integer('CMAES', 'max_generations', 0, 'of a run; 0: without limit, paper: 100', min=0)
    call r%add_integer('CMAES', 'max_evaluations', 0, &
                       'of candidates in a search, restarts included; 0: 15 for every '// &
                       'parameter, the polish does the rest, paper: without limit', min=0)
    call r%add_real('CMAES', 'target', -1.0_rp, 'the search ends at a cost below; -1: none, paper: 1e-6 m', min=-1.0_rp)
    call r%add_real('CMAES', 'tolfun', 1.0e-3_rp, &
                    'the run ends when costs of a generation and best costs of recent '// &
                    'ones differ less, relative to the first; the polish does the rest. Paper: 1e-11', min=0.0_rp)
    call r%add_real('CMAES', 'tolfunhist', 1.0e-12_rp, 'the same of the best costs alone', min=0.0_rp)
    call r%add_real('CMAES', 'tolx', 1.0e-11_rp, 'the run ends when the step is shorter, over sigma0', min=0.0_rp)
    call r%add_integer('CMAES', 'tolstagnation', 0, 'generations without progress that end a run; 0: by n and '// &
                       'lambda', min=0)
    call r%add_real('CMAES', 'condition_limit', 1.0e14_rp, 'of the covariance matrix', above=1.0_rp)
    call register_strategy(r)
  end subroutine register_search

  !> The constants that follow from n and lambda unless they are given; see docs/theory/optimiser.md.
  subroutine register_strategy(r)
    type(registry_t), intent(inout) :: r
    character(*), parameter :: AUTO = '; -1: by n and lambda'
    call r%add_integer('CMAES', 'mu', 0, 'parents of a generation; 0: half of lambda', min=0, max=50000)
    call r%add_real('CMAES', 'c_m', 1.0_rp, 'learning rate of the mean', above=0.0_rp, max=1.0_rp)
    call r%add_real('CMAES', 'c_sigma', -1.0_rp, 'cumulation of the path of the step size'//AUTO, min=-1.0_rp, &
                    max=1.0_rp)
    call r%add_real('CMAES', 'd_sigma', -1.0_rp, 'damping of the step size'//AUTO//' and c_sigma', min=-1.0_rp)
    call r%add_real('CMAES', 'c_c', -1.0_rp, 'cumulation of the path of the covariance'//AUTO, min=-1.0_rp, &
                    max=1.0_rp)
    call r%add_real('CMAES', 'c_1', -1.0_rp, 'learning rate of the rank-one update'//AUTO, min=-1.0_rp, max=1.0_rp)
    call r%add_real('CMAES', 'c_mu', -1.0_rp, 'learning rate of the rank-mu update'//AUTO// &
                    '; c_1 + c_mu is at most 1', &
                    min=-1.0_rp, max=1.0_rp)
    call r%add_real('CMAES', 'alpha_minus', -1.0_rp, 'what the negative weights sum to, sign changed'//AUTO// &
                    '; larger values can make the covariance indefinite, which is repaired', min=-1.0_rp, max=10.0_rp)
    call r%add_real('CMAES', 'tolfacupx', 1.0e3_rp, 'the run ends when the step is longer, over sigma0', above=1.0_rp)
    call r%add_real('CMAES', 'tolupsigma', 1.0e20_rp, 'the same of sigma over sigma0, over the longest axis', &
                    above=1.0_rp)
    call r%add_integer('CMAES', 'tolflatfitness', 1, 'generations in a row with equal parents that do not end a run', &
                       min=0)
  end subroutine register_strategy

  subroutine register_polish(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Polish', 'least squares with exact derivatives behind the search')
    call r%add_word('Polish', 'polish', 'preset', 'preset|yes|no', 'default: yes, paper: no')
    call r%add_switch('Polish', 'intervals', .true., '90 % intervals by profile likelihood')
    call r%add_real('Polish', 'prior_decades', 1.0_rp, 'sd of the prior about the values of [Wing]', unit='decades', &
                    above=0.0_rp)
    call r%add_integer('Polish', 'starts', 3, &
                     'candidates from which it begins, one after another: until one end fits within the errors and '// &
                       'polishing has cost as much as the search; ends that differ are told', min=1, max=1000)
    call r%add_integer('Polish', 'iterations', 100, 'steps tried at most in every stage', min=1, max=10000)
  end subroutine register_polish

  subroutine register_solver(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Solver', 'path of the static solution')
    call r%add_real('Solver', 'tolerance', 1.0e-8_rp, 'of the residual, relative to the load; soft wings do '// &
                    'not reach much less', min=1.0e-12_rp, max=1.0e-3_rp)
    call r%add_real('Solver', 'step_limit', 0.025_rp, 'largest movement in one stage, relative to the wing''s size', &
                    above=0.0_rp, max=0.2_rp)
    call r%add_integer('Solver', 'factorisation_limit', 300, 'give up after so many for one load', min=1)
  end subroutine register_solver

  subroutine register_saving(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Saving', 'what is written, and when to stop')
    call r%add_text('Saving', 'name', 'train', 'first part of the names of all other files, with a folder if wanted')
    call r%add_text('Saving', 'result', 'trained.ini', 'the trained wing, a fragment for [include]')
    call r%add_integer('Saving', 'checkpoint_every', 1, 'generations between backups', min=1)
    call r%add_real('Saving', 'wtimemax', 8760.0_rp, 'stop with a backup after this wall time', unit='h', above=0.0_rp)
    call r%add_real('Saving', 'job_end_margin', 300.0_rp, &
                    'stop this long before the end of the job that SLURM announces in SLURM_JOB_END_TIME', unit='s', &
                    min=0.0_rp)
    call r%add_real('Saving', 'progress_interval', 30.0_rp, 'wall time between progress lines in a log', unit='s', &
                    min=0.0_rp)
  end subroutine register_saving
end module common_train_keys

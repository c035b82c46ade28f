! SPDX-License-Identifier: GPL-3.0-or-later
!> What `msm_train` is to do: from the ini file, the wing file and the measurement file to an experiment and the
!> choices of search and fit. Whatever a user can do wrong is found here. SI units.
module train_settings
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: i8, rp
  use base_text, only: number_text
  use cmaes_options, only: cmaes_options_t, default_lambda, option_problem
  use common_instrument, only: read_instrument
  use common_outliers, only: choose_heights
  use common_overwrite_guard, only: refuse_overwriting
  use common_sought, only: read_sought
  use common_train_keys, only: register_train_keys
  use common_wing_settings, only: check_name, find_beside, load_wing
  use io_config, only: config_t
  use io_registry, only: registry_t
  use io_shared_text, only: read_shared_text
  use io_stop, only: job_limits_t
  use measurement_data, only: measurement_t
  use measurement_instrument, only: instrument_t
  use measurement_outliers, only: outliers_t
  use measurement_broadcast, only: load_measurement
  use parallel_world, only: world_t
  use solid_params, only: N_COMMON, PARAM_YOUNG
  use solid_statics, only: static_options_t
  use solid_wing_case, only: wing_case_t
  use train_files, only: choose_individual, individual_files, of_individual
  use training_case, only: training_case_t
  implicit none
  private
  public :: train_settings_t, load_train_settings, masses_of

  integer, parameter :: UNLIMITED = 1000000000 !< generations

  type, extends(training_case_t) :: train_settings_t
    type(config_t) :: config
    type(wing_case_t) :: setup
    type(measurement_t) :: measurement
    type(instrument_t) :: instrument        !< what the measurement is taken to have done
    character(:), allocatable :: measurement_path
    integer :: n_individuals = 1            !< in the lists of [Measurement] and [Wing]
    character(:), allocatable :: individual !< name of this one, part of the names of its files; empty if it is the only one
    type(static_options_t) :: options
    logical :: is_paper = .false.
    character(:), allocatable :: result     !< the fragment to write; all other files begin with `name`
    type(job_limits_t) :: limits
    real(rp) :: progress_seconds = 30       !< wall time between progress lines in a log
  end type train_settings_t

contains

  !> Reads the ini file `path` and what it names for one individual on all ranks; all mistakes go to `errors`, remarks to
  !> `notices`. Collective.
  subroutine load_train_settings(path, number, writes, world, s, errors, notices)
    character(*), intent(in) :: path
    integer, intent(in) :: number !< of the individual
    logical, intent(in) :: writes !< files of results, which must not be among those that are read
    type(world_t), intent(in) :: world
    type(train_settings_t), intent(out) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t) :: registry
    type(outliers_t) :: outliers
    character(:), allocatable :: text, problem, scale, wing, measurement
    logical :: found
    call register_train_keys(registry)
    call read_shared_text(path, text, problem, world)
    if (allocated(problem)) then
      call errors%add(problem)
      return
    end if
    call s%config%load_text(text, path, registry, errors, notices, .false., world)
    if (s%config%asks_for_unbuilt()) return
    s%is_paper = s%config%get_word('Train', 'preset') == 'paper'
    call choose_individual(s%config, number, s%n_individuals, s%individual, wing, measurement, errors)
    if (number > s%n_individuals) return
    call read_options(s, errors)
    if (writes) call check_outputs(s, path, world, errors)
    call load_wing(s%config, path, .false., s%setup, found, errors, notices, world, wing)
    if (.not. found) return
    scale = s%config%get_word('Train', 'scale')
    call read_measurement_file(s, path, measurement, world, errors)
    if (errors%count() == 0) &
      call choose_heights(s%config, s%measurement_path, s%is_paper, s%measurement, outliers, notices)
    if (allocated(s%measurement%loads)) call s%instrument%set_scales(s%measurement, s%setup%model%size)
    call read_instrument(s%config, s%instrument, errors)
    call read_sought(s%config, 'Train', s%setup%asked, s%instrument, &
                     scale == 'log' .or. (scale == 'preset' .and. .not. s%is_paper), s%sought, errors)
    if (errors%count() > 0) return
    call make_experiment(s, errors)
    if (errors%count() > 0) return
    call read_search(s, errors)
    if (errors%count() > 0) return
    call settle_choices(s)
    call add_notices(s, notices)
  end subroutine load_train_settings

  subroutine read_options(s, errors)
    type(train_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    associate (c => s%config)
      s%options%tolerance = c%get_real('Solver', 'tolerance')
      s%options%step_limit = c%get_real('Solver', 'step_limit')
      s%options%factorisation_limit = c%get_integer('Solver', 'factorisation_limit')
      s%starts_at_wing = c%get_word('Train', 'start') == 'wing'
      s%n_stages = 1
      if (c%get_word('Train', 'stages') == '2' .or. (c%get_word('Train', 'stages') == 'preset' .and. s%is_paper)) &
        s%n_stages = 2
      s%polish = c%get_word('Polish', 'polish') == 'yes' .or. &
                 (c%get_word('Polish', 'polish') == 'preset' .and. .not. s%is_paper)
      s%intervals = c%get_switch('Polish', 'intervals')
      s%prior_decades = c%get_real('Polish', 'prior_decades')
      s%fit%most_iterations = c%get_integer('Polish', 'iterations')
      s%polish_starts = c%get_integer('Polish', 'starts')
      s%name = of_individual(c%get_text('Saving', 'name'), s%individual, '')
      s%result = of_individual(c%get_text('Saving', 'result'), s%individual, '.ini')
      call check_name(c, s%name, errors)
      if (s%result == '') call c%complain(errors, 'Saving', 'result', 'must be the name of a file')
      s%checkpoint_every = c%get_integer('Saving', 'checkpoint_every')
      s%limits%stop_seconds = 3600*c%get_real('Saving', 'wtimemax')
      s%limits%job_end_margin = c%get_real('Saving', 'job_end_margin')
      s%progress_seconds = c%get_real('Saving', 'progress_interval')
    end associate
  end subroutine read_options

  !> No result may take the place of an input, not even of another individual.
  subroutine check_outputs(s, ini, world, errors)
    type(train_settings_t), intent(in) :: s
    character(*), intent(in) :: ini
    type(world_t), intent(in) :: world
    type(message_list_t), intent(inout) :: errors
    character(12), parameter :: ENDINGS(4) = [character(12) :: '.log', '_history.h5', '_backup0.h5', '_backup1.h5']
    type(message_list_t) :: inputs
    integer :: i
    call individual_files(s%config, ini, world, inputs)
    call refuse_overwriting(s%config, 'Saving', 'result', s%result, inputs, errors)
    do i = 1, size(ENDINGS)
      call refuse_overwriting(s%config, 'Saving', 'name', s%name//trim(ENDINGS(i)), inputs, errors)
    end do
  end subroutine check_outputs

  subroutine read_measurement_file(s, ini, file, world, errors)
    type(train_settings_t), intent(inout) :: s
    character(*), intent(in) :: ini, file
    type(world_t), intent(in) :: world
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: problem
    if (.not. s%config%is_given('Measurement', 'file')) return
    call find_beside(ini, file, s%measurement_path, problem, world)
    if (allocated(problem)) then
      call s%config%complain(errors, 'Measurement', 'file', problem)
    else
      call load_measurement(world, s%measurement_path, s%setup%wing, s%measurement, errors)
      if (allocated(s%measurement%loads) .and. s%measurement%moves()) then
        if (size(s%measurement%loads) == 0) call s%config%complain(errors, 'Measurement', 'file', &
          'holds modes or records of motion and no bending test; a training needs bending tests, msm_diagnose takes all')
      end if
    end if
  end subroutine read_measurement_file

  subroutine make_experiment(s, errors)
    type(train_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    type(failure_t) :: failure
    if (s%is_paper .and. s%config%get_word('Wing', 'cross_springs') == 'preset') s%setup%asked%cross_springs = .true.
    call s%experiment%init(s%measurement, s%setup%wing, s%setup%asked, s%sought%numbers, s%options, failure, &
                           s%instrument, s%sought%instrument_numbers, masses_of(s))
    if (failure%failed) call errors%add(failure%reason)
    s%setup%model = s%experiment%model
    select case (s%config%get_word('Train', 'cost'))
    case ('h')
      if (sum(s%experiment%comparisons%n_heights) == 0) &
        call s%config%complain(errors, 'Train', 'cost', 'h compares heights, of which this measurement has none')
    case ('chi2')
      s%use_chi2 = .true.
    case default
      s%use_chi2 = size(s%measurement%observations) > 0
    end select
    if (s%n_stages == 2 .and. .not. (any(s%sought%numbers == PARAM_YOUNG) .and. s%sought%count() > 1)) &
     call s%config%complain(errors, 'Train', 'stages', 'the second stage fixes E, and must have something left to seek')
  end subroutine make_experiment

  !> [kg] of all points, or none if the wing has no valid mass.
  pure function masses_of(s) result(masses)
    type(train_settings_t), intent(in) :: s
    real(rp), allocatable :: masses(:)
    allocate (masses(0))
    if (s%setup%has_mass) masses = s%setup%mass%nodal
  end function masses_of

  subroutine read_search(s, errors)
    type(train_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: problem
    integer :: n
    n = s%experiment%count()
    associate (c => s%config, o => s%search)
      o%seed = int(c%get_integer('Train', 'seed'), i8)
      o%lambda = c%get_integer('CMAES', 'lambda')
      if (o%lambda == 0 .and. s%is_paper) o%lambda = 16
      o%sigma0 = c%get_real('CMAES', 'sigma0')
      o%weights = preset_word(s, 'weights', 'active')
      o%constants = preset_word(s, 'constants', 'tutorial')
      s%restarts = c%get_word('CMAES', 'restarts')
      s%max_restarts = c%get_integer('CMAES', 'max_restarts')
      o%max_iterations = c%get_integer('CMAES', 'max_generations')
      if (o%max_iterations == 0) o%max_iterations = merge(100, UNLIMITED, s%is_paper)
      if (c%get_integer('CMAES', 'max_evaluations') > 0) then
        o%max_evaluations = c%get_integer('CMAES', 'max_evaluations')
      else if (.not. s%is_paper) then
        o%max_evaluations = 15*n
      end if
      o%f_target = c%get_real('CMAES', 'target')
      if (o%f_target < 0) o%f_target = merge(1.0e-6_rp, -1.0_rp, s%is_paper .and. .not. s%use_chi2)
      o%tolfun = c%get_real('CMAES', 'tolfun')
      if (s%is_paper .and. .not. c%is_given('CMAES', 'tolfun')) o%tolfun = 1.0e-11_rp
      o%tolfunhist = c%get_real('CMAES', 'tolfunhist')
      o%tolx = c%get_real('CMAES', 'tolx')
      o%tolstagnation = c%get_integer('CMAES', 'tolstagnation')
      o%condition_limit = c%get_real('CMAES', 'condition_limit')
      call read_strategy(c, o)
      problem = option_problem(o, n)
      if (problem /= '') call c%complain(errors, 'CMAES', key_of(problem), problem)
    end associate
  end subroutine read_search

  !> The constants that usually follow from n and lambda.
  subroutine read_strategy(c, o)
    type(config_t), intent(in) :: c
    type(cmaes_options_t), intent(inout) :: o
    o%mu = c%get_integer('CMAES', 'mu')
    o%c_m = c%get_real('CMAES', 'c_m')
    o%c_sigma = c%get_real('CMAES', 'c_sigma')
    o%d_sigma = c%get_real('CMAES', 'd_sigma')
    o%c_c = c%get_real('CMAES', 'c_c')
    o%c_1 = c%get_real('CMAES', 'c_1')
    o%c_mu = c%get_real('CMAES', 'c_mu')
    o%alpha_minus = c%get_real('CMAES', 'alpha_minus')
    o%tolfacupx = c%get_real('CMAES', 'tolfacupx')
    o%tolupsigma = c%get_real('CMAES', 'tolupsigma')
    o%tolflatfitness = c%get_integer('CMAES', 'tolflatfitness')
  end subroutine read_strategy

  !> The key that a sentence of `option_problem` is about: its first word, unless that stands for several.
  pure function key_of(problem) result(key)
    character(*), intent(in) :: problem
    character(:), allocatable :: key
    key = problem(:scan(problem//' ', ' ,') - 1)
    if (key == 'tolerances') key = 'tolfun'
    if (key == 'there') key = 'lambda'
  end function key_of

  function preset_word(s, key, usual) result(word)
    type(train_settings_t), intent(in) :: s
    character(*), intent(in) :: key, usual
    character(:), allocatable :: word
    word = s%config%get_word('CMAES', key)
    if (word /= 'preset') return
    word = usual
    if (s%is_paper) word = 'paper'
  end function preset_word

  !> Gives --check what was chosen where the file leaves the choice, or nothing says otherwise. Constants that follow from
  !> lambda, which restarts change, stay open.
  subroutine settle_choices(s)
    type(train_settings_t), intent(inout) :: s
    associate (o => s%search)
      call settle_integer('lambda', merge(o%lambda, default_lambda(s%experiment%count()), o%lambda > 0))
      if (o%max_iterations < UNLIMITED) call settle_integer('max_generations', o%max_iterations)
      if (.not. s%is_paper) call settle_integer('max_evaluations', int(o%max_evaluations))
      call settle_real('target', o%f_target)
      call settle_real('tolfun', o%tolfun)
      call settle_word('CMAES', 'weights', trim(o%weights))
      call settle_word('CMAES', 'constants', trim(o%constants))
    end associate
    call settle_word('Train', 'scale', trim(merge('linear', 'log   ', s%is_paper)))
    call settle_word('Train', 'cost', trim(merge('chi2', 'h   ', s%use_chi2)))
    call settle_word('Train', 'stages', number_text(s%n_stages))
    call settle_word('Polish', 'polish', trim(merge('yes', 'no ', s%polish)))
    call settle_word('Measurement', 'outliers', trim(merge('keep     ', 'leave_out', s%is_paper)))
    call settle_word('Wing', 'cross_springs', trim(merge('yes', 'no ', s%setup%asked%cross_springs)))

  contains

    !> Words that leave the choice.
    subroutine settle_word(section, key, word)
      character(*), intent(in) :: section, key, word
      character(:), allocatable :: given
      given = s%config%get_word(section, key)
      if (given == 'preset' .or. given == 'auto') call s%config%settle(section, key, word, origin())
    end subroutine settle_word

    subroutine settle_integer(key, value)
      character(*), intent(in) :: key
      integer, intent(in) :: value
      if (s%config%get_integer('CMAES', key) /= value) &
        call s%config%settle('CMAES', key, number_text(value), origin())
    end subroutine settle_integer

    subroutine settle_real(key, value)
      character(*), intent(in) :: key
      real(rp), intent(in) :: value
      if (abs(s%config%get_real('CMAES', key) - value) > 0) &
        call s%config%settle('CMAES', key, number_text(value), origin())
    end subroutine settle_real

    function origin() result(text)
      character(:), allocatable :: text
      text = trim(merge('by the preset', 'worked out   ', s%is_paper))
    end function origin
  end subroutine settle_choices

  !> A joint that is not sought but was never set stays as stiff as a vein of the E of [Wing], also if E is sought.
  subroutine add_notices(s, notices)
    type(train_settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: notices
    integer :: i, number
    if (.not. any(s%sought%numbers == PARAM_YOUNG)) return
    do i = 1, size(s%setup%asked%joint)
      number = N_COMMON + size(s%setup%asked%vein_factor) + i
      if (s%setup%asked%joint(i) < 0 .and. .not. any(s%sought%numbers == number)) &
       call notices%add('joint:'//trim(s%setup%asked%joint_names(i))//' is not sought and keeps the stiffness of a '// &
                         'vein of the E of [Wing], '//number_text(s%experiment%model%params%joint(i))//' N m/rad')
    end do
  end subroutine add_notices
end module train_settings

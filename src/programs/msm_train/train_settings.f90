! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads what `msm_train` has to do: it turns the ini file, the wing file and the measurement file into an experiment and the
!> settings of search and fit. All mistakes that a user can make are found here. Quantities are in SI units.
module train_settings
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: i8, rp
  use base_named_kinds, only: named_kind_t, word_of
  use base_text, only: number_text
  use cmaes_options, only: default_lambda, option_problem, option_problem_t, CONSTANT_SETS, CONSTANTS_PAPER, CONSTANTS_TUTORIAL, &
                           OPTION_ALPHA_MINUS, OPTION_C_1, OPTION_C_C, OPTION_C_M, OPTION_C_MU, OPTION_C_SIGMA, &
                           OPTION_CONSTANTS, OPTION_D_SIGMA, OPTION_EVALUATIONS, OPTION_FACTORS, OPTION_LAMBDA, OPTION_LIMITS, &
                           OPTION_MU, OPTION_NONE, OPTION_SIGMA0, OPTION_TARGET, OPTION_TOLERANCES, OPTION_WEIGHTS, WEIGHTINGS, &
                           WEIGHTS_ACTIVE, WEIGHTS_PAPER
  use cmaes_search, only: RESTARTS_NONE
  use common_bending_case, only: bending_input_t, load_bending_case, load_input
  use common_measurement_keys, only: read_measurement_keys, OUTLIERS, OUTLIERS_KEEP, OUTLIERS_LEAVE_OUT, OUTLIERS_PRESET
  use common_overwrite_guard, only: refuse_overwriting
  use common_train_keys, only: register_train_keys, train_choices_t, train_keys, BY_PRESET, COST_CHI2, COST_H, COSTS, POLISHES, &
                               POLISH_NO, POLISH_YES, PRESET_PAPER, SCALE_LINEAR, SCALE_LOG, SCALES, START_WING
  use common_wing_keys, only: read_wing_keys, CROSS_PRESET
  use common_wing_settings, only: check_name
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  use io_registry, only: registry_t
  use io_stop, only: job_limits_t
  use parallel_world, only: world_t
  use solid_usual_causes, only: N_COMMON, PARAM_YOUNG
  use train_files, only: choose_individual, individual_files, of_individual
  use training_case, only: training_case_t
  implicit none
  private
  public :: train_settings_t, load_train_settings

  integer, parameter :: UNLIMITED = 1000000000 !< generations

  !> The key of [CMAES] for each option that may be wrong; the scale of f has none.
  type(named_kind_t), parameter :: OPTION_KEYS(17) = [ &
    named_kind_t('weights', OPTION_WEIGHTS), named_kind_t('constants', OPTION_CONSTANTS), named_kind_t('lambda', OPTION_LAMBDA), &
    named_kind_t('mu', OPTION_MU), named_kind_t('sigma0', OPTION_SIGMA0), named_kind_t('c_m', OPTION_C_M), &
    named_kind_t('c_sigma', OPTION_C_SIGMA), named_kind_t('d_sigma', OPTION_D_SIGMA), named_kind_t('c_c', OPTION_C_C), &
    named_kind_t('c_1', OPTION_C_1), named_kind_t('c_mu', OPTION_C_MU), named_kind_t('alpha_minus', OPTION_ALPHA_MINUS), &
    named_kind_t('tolfun', OPTION_TOLERANCES), named_kind_t('tolfacupx', OPTION_FACTORS), named_kind_t('target', OPTION_TARGET), &
    named_kind_t('tolflatfitness', OPTION_LIMITS), named_kind_t('max_evaluations', OPTION_EVALUATIONS)]

  type, extends(training_case_t) :: train_settings_t
    type(config_t) :: config
    type(train_choices_t) :: choices
    integer :: n_individuals = 1            !< in the lists of [Measurement] and [Wing]
    character(:), allocatable :: individual !< name of this individual, part of the names of its files; empty if there is only one
    logical :: is_paper = .false.
    character(:), allocatable :: result     !< the fragment to write; all other files begin with `name`
    type(job_limits_t) :: limits
  end type train_settings_t

contains

  !> Reads the ini file `path`, and the files that it names for one individual, on all ranks. All mistakes go to `errors` and
  !> remarks to `notices`. Collective.
  subroutine load_train_settings(path, number, writes, world, s, errors, notices)
    character(*), intent(in) :: path
    integer, intent(in) :: number !< of the individual
    logical, intent(in) :: writes !< results will be written; they must not overwrite files that are read
    type(world_t), intent(in) :: world
    type(train_settings_t), intent(out) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t) :: registry
    type(bending_input_t) :: input
    type(message_list_t) :: inputs
    character(:), allocatable :: wings, measurements
    logical :: can_go_on
    call register_train_keys(registry)
    call load_input(path, registry, world, s%config, errors, notices, can_go_on)
    if (.not. can_go_on) return
    call read_wing_keys(s%config, input%wing)
    call read_measurement_keys(s%config, .true., input%measurement)
    wings = input%wing%file
    measurements = input%measurement%file
    call choose_individual(s%config, number, input%wing%file, input%measurement%file, s%n_individuals, s%individual, errors)
    if (number > s%n_individuals) return
    call read_options(s, errors)
    if (writes) then
      call individual_files(wings, measurements, path, world, inputs)
      call check_output_files(s, inputs, errors)
    end if
    input%section = 'Train'
    input%parameters = s%choices%parameters
    input%keeps_outliers = s%is_paper
    input%scale_is_log = s%choices%scale == SCALE_LOG .or. (s%choices%scale == BY_PRESET .and. .not. s%is_paper)
    call load_bending_case(input, s%config, world, s, errors, notices)
    if (.not. allocated(s%free_parameters%numbers)) return
    call check_tests(s, errors)
    if (errors%count() > 0) return
    call make_experiment(s, input%wing%cross_springs == CROSS_PRESET, errors)
    if (errors%count() > 0) return
    call read_search(s, errors)
    if (errors%count() > 0) return
    call settle_choices(s, input)
    call add_notices(s, notices)
  end subroutine load_train_settings

  !> Reads the options of the training.
  subroutine read_options(s, errors)
    type(train_settings_t), intent(inout), target :: s
    type(message_list_t), intent(inout) :: errors
    type(keys_t) :: keys
    keys = reading(s%config)
    call train_keys(keys, s%choices)
    associate (c => s%choices)
      s%is_paper = c%preset == PRESET_PAPER
      s%starts_at_wing = c%start == START_WING
      s%n_stages = c%stages
      if (c%stages == BY_PRESET) s%n_stages = merge(2, 1, s%is_paper)
      s%polish = c%polish == POLISH_YES .or. (c%polish == BY_PRESET .and. .not. s%is_paper)
      s%moves = s%polish .and. c%moves
      s%intervals = c%intervals
      s%prior_decades = c%prior_decades
      s%fit = c%fit
      s%polish_starts = c%polish_starts
      s%name = of_individual(c%name, s%individual, '')
      s%result = of_individual(c%result, s%individual, '.ini')
      call check_name(s%config, s%name, errors)
      if (s%result == '') call s%config%complain(errors, 'Saving', 'result', 'is empty: give the name of a file')
      s%checkpoint_every = c%checkpoint_every
      s%limits = c%limits
    end associate
  end subroutine read_options

  !> Adds a mistake if a result would overwrite one of the `inputs`, also one of another individual.
  subroutine check_output_files(s, inputs, errors)
    type(train_settings_t), intent(in) :: s
    type(message_list_t), intent(in) :: inputs
    type(message_list_t), intent(inout) :: errors
    character(12), parameter :: ENDINGS(4) = [character(12) :: '.log', '_history.h5', '_backup0.h5', '_backup1.h5']
    integer :: i
    call refuse_overwriting(s%config, 'Saving', 'result', s%result, inputs, errors)
    do i = 1, size(ENDINGS)
      call refuse_overwriting(s%config, 'Saving', 'name', s%name//trim(ENDINGS(i)), inputs, errors)
    end do
  end subroutine check_output_files

  !> Adds a mistake if the measurement has no bending tests, which a training needs.
  subroutine check_tests(s, errors)
    type(train_settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: errors
    if (.not. allocated(s%measurement%loads)) return
    if (s%measurement%moves() .and. size(s%measurement%loads) == 0) call s%config%complain(errors, 'Measurement', 'file', &
      'has modes or records of motion but no bending test; a training needs bending tests, and msm_diagnose accepts all three')
  end subroutine check_tests

  !> Makes the experiment that the training simulates, and chooses the cost. With `crosses_by_preset` the preset decides whether the
  !> wing has cross-springs.
  subroutine make_experiment(s, crosses_by_preset, errors)
    type(train_settings_t), intent(inout) :: s
    logical, intent(in) :: crosses_by_preset
    type(message_list_t), intent(inout) :: errors
    type(failure_t) :: failure
    if (s%is_paper .and. crosses_by_preset) s%wing_case%requested%cross_springs = .true.
    call s%experiment%init(s%measurement, s%wing_case%wing, s%wing_case%requested, s%free_parameters%numbers, &
                           s%choices%solver, failure, s%instrument, s%free_parameters%instrument_numbers, s%masses())
    if (failure%failed) call errors%add(failure%reason)
    s%wing_case%model = s%experiment%model
    select case (s%choices%cost)
    case (COST_H)
      if (sum(s%experiment%comparisons%n_heights) == 0) &
        call s%config%complain(errors, 'Train', 'cost', 'h compares heights, and this measurement has none; set cost = chi2')
    case (COST_CHI2)
      s%use_chi2 = .true.
    case default
      s%use_chi2 = size(s%measurement%observations) > 0
    end select
    if (s%n_stages == 2 .and. .not. (any(s%free_parameters%numbers == PARAM_YOUNG) .and. s%free_parameters%count() > 1)) &
     call s%config%complain(errors, 'Train', 'stages', 'two stages need E and another free parameter, as the second stage fixes E')
  end subroutine make_experiment

  !> Sets the options of the global search, with the defaults of the preset.
  subroutine read_search(s, errors)
    type(train_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    type(option_problem_t) :: problem
    integer :: n
    n = s%experiment%count()
    s%search = s%choices%search
    s%restarts = s%choices%restarts
    s%max_restarts = s%choices%max_restarts
    s%search_is_short = s%moves .and. s%choices%search%max_evaluations == 0 .and. s%choices%search%max_iterations == 0 .and. &
                        s%n_stages == 1 .and. s%restarts == RESTARTS_NONE .and. .not. (s%is_paper .or. s%choices%has_tolfun .or. &
                        s%choices%search%f_target >= 0)
    associate (o => s%search)
      if (o%lambda == 0 .and. s%is_paper) o%lambda = 16
      o%weights = preset_kind(s, s%choices%weights, WEIGHTS_ACTIVE, WEIGHTS_PAPER)
      o%constants = preset_kind(s, s%choices%constants, CONSTANTS_TUTORIAL, CONSTANTS_PAPER)
      if (o%max_iterations == 0) o%max_iterations = merge(100, UNLIMITED, s%is_paper)
      if (o%max_evaluations == 0) o%max_evaluations = merge(huge(o%max_evaluations), 15_i8*n, s%is_paper)
      if (o%f_target < 0) o%f_target = merge(1.0e-6_rp, -1.0_rp, s%is_paper .and. .not. s%use_chi2)
      if (s%is_paper .and. .not. s%choices%has_tolfun) o%tolfun = 1.0e-11_rp
      problem = option_problem(o, n)
    end associate
    if (problem%option /= OPTION_NONE) &
      call s%config%complain(errors, 'CMAES', word_of(OPTION_KEYS, problem%option), problem%text)
  end subroutine read_search

  !> Returns the kind `given`, or that of the preset if `given` leaves it to it.
  pure integer function preset_kind(s, given, usual, paper) result(kind)
    type(train_settings_t), intent(in) :: s
    integer, intent(in) :: given, usual, paper
    kind = given
    if (given == BY_PRESET) kind = merge(paper, usual, s%is_paper)
  end function preset_kind

  !> Records for --check the values that are used where the file leaves the choice or is silent. Constants that follow from lambda
  !> stay open, because restarts change lambda.
  subroutine settle_choices(s, input)
    type(train_settings_t), intent(inout) :: s
    type(bending_input_t), intent(in) :: input
    associate (o => s%search, given => s%choices%search, c => s%choices)
      call settle_integer('lambda', given%lambda, merge(o%lambda, default_lambda(s%experiment%count()), o%lambda > 0))
      if (o%max_iterations < UNLIMITED) call settle_integer('max_generations', given%max_iterations, o%max_iterations)
      if (.not. s%is_paper) call settle_integer('max_evaluations', int(given%max_evaluations), int(o%max_evaluations))
      call settle_real('target', given%f_target, o%f_target)
      call settle_real('tolfun', given%tolfun, o%tolfun)
      call settle('CMAES', 'weights', c%weights == BY_PRESET, word_of(WEIGHTINGS, o%weights))
      call settle('CMAES', 'constants', c%constants == BY_PRESET, word_of(CONSTANT_SETS, o%constants))
      call settle('Train', 'scale', c%scale == BY_PRESET, word_of(SCALES, merge(SCALE_LINEAR, SCALE_LOG, s%is_paper)))
      call settle('Train', 'cost', c%cost == BY_PRESET, word_of(COSTS, merge(COST_CHI2, COST_H, s%use_chi2)))
      call settle('Train', 'stages', c%stages == BY_PRESET, number_text(s%n_stages))
      call settle('Polish', 'polish', c%polish == BY_PRESET, word_of(POLISHES, merge(POLISH_YES, POLISH_NO, s%polish)))
    end associate
    call settle('Measurement', 'outliers', input%measurement%outliers == OUTLIERS_PRESET, &
                word_of(OUTLIERS, merge(OUTLIERS_KEEP, OUTLIERS_LEAVE_OUT, s%is_paper)))
    call settle('Wing', 'cross_springs', input%wing%cross_springs == CROSS_PRESET, &
                trim(merge('yes', 'no ', s%wing_case%requested%cross_springs)))

  contains

    !> Records the choice for a key that leaves it open.
    subroutine settle(section, key, is_open, word)
      character(*), intent(in) :: section, key, word
      logical, intent(in) :: is_open
      if (is_open) call s%config%settle(section, key, word, origin())
    end subroutine settle

    subroutine settle_integer(key, given, used)
      character(*), intent(in) :: key
      integer, intent(in) :: given, used
      call settle('CMAES', key, used /= given, number_text(used))
    end subroutine settle_integer

    subroutine settle_real(key, given, used)
      character(*), intent(in) :: key
      real(rp), intent(in) :: given, used
      call settle('CMAES', key, abs(used - given) > 0, number_text(used))
    end subroutine settle_real

    function origin() result(text)
      character(:), allocatable :: text
      text = trim(merge('by the preset', 'computed     ', s%is_paper))
    end function origin
  end subroutine settle_choices

  !> If E is free, adds a notice if its bounds exclude the value of [Wing], and one for each joint that is neither free nor given.
  !> Such a joint keeps the stiffness of a vein with the E of [Wing].
  subroutine add_notices(s, notices)
    type(train_settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: notices
    character(:), allocatable :: name, role
    integer :: i, number
    i = findloc(s%free_parameters%numbers, PARAM_YOUNG, 1)
    if (i == 0) return
    name = 'the E of [Wing]'
    if (.not. s%config%is_given('Wing', 'E')) name = 'the default E'
    role = ''
    if (s%polish) role = ', at which the prior of the fit is centred'
    associate (young => s%wing_case%requested%young, low => s%free_parameters%lower(i), high => s%free_parameters%upper(i))
      if (young < low .or. young > high) call s%config%complain(notices, 'Train', 'parameters', 'the bounds of E, '// &
        number_text(low)//' and '//number_text(high)//' Pa, exclude '//name//', '//number_text(young)// &
        ' Pa'//role//'; are they in pascals?')
    end associate
    do i = 1, size(s%wing_case%requested%joint)
      number = N_COMMON + size(s%wing_case%requested%vein_factor) + i
      if (s%wing_case%requested%joint(i) < 0 .and. .not. any(s%free_parameters%numbers == number)) &
       call notices%add('joint:'//trim(s%wing_case%requested%joint_names(i))//' is not fitted: it keeps '// &
                         'the stiffness of a vein with the E of [Wing], '//number_text(s%experiment%model%params%joint(i))// &
                         ' N m/rad; to fit it, add it to the parameters')
    end do
  end subroutine add_notices
end module train_settings

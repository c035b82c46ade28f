! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads what `msm_train` has to do: it turns the ini file, the wing file and the measurement file into an experiment and the
!> settings of search and fit. All mistakes that a user can make are found here. Quantities are in SI units.
module train_settings
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: i8, rp
  use base_named_kinds, only: word_of
  use base_text, only: number_text
  use cmaes_options, only: default_lambda, option_problem, CONSTANT_SETS, CONSTANTS_PAPER, CONSTANTS_TUTORIAL, WEIGHTINGS, &
                           WEIGHTS_ACTIVE, WEIGHTS_PAPER
  use cmaes_search, only: RESTARTS_NONE
  use common_bending_case, only: bending_input_t, load_bending_case, load_input
  use common_overwrite_guard, only: refuse_overwriting
  use common_train_keys, only: register_train_keys, train_choices_t, train_keys
  use common_wing_keys, only: read_wing_keys, wing_choices_t, CROSS_PRESET
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
    logical :: can_go_on
    call register_train_keys(registry)
    call load_input(path, registry, world, s%config, errors, notices, can_go_on)
    if (.not. can_go_on) return
    call choose_individual(s%config, number, s%n_individuals, s%individual, input%wing, input%measurement, errors)
    if (number > s%n_individuals) return
    call read_options(s, errors)
    if (writes) call check_output_files(s, path, world, errors)
    input%section = 'Train'
    input%parameters = s%choices%parameters
    input%keeps_outliers = s%is_paper
    input%scale_is_log = s%choices%scale == 'log' .or. (s%choices%scale == 'preset' .and. .not. s%is_paper)
    call load_bending_case(input, s%config, world, s, errors, notices)
    if (.not. allocated(s%free_parameters%numbers)) return
    call check_tests(s, errors)
    if (errors%count() > 0) return
    call make_experiment(s, errors)
    if (errors%count() > 0) return
    call read_search(s, errors)
    if (errors%count() > 0) return
    call settle_choices(s)
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
      s%is_paper = c%preset == 'paper'
      s%starts_at_wing = c%start == 'wing'
      s%n_stages = 1
      if (c%stages == '2' .or. (c%stages == 'preset' .and. s%is_paper)) s%n_stages = 2
      s%polish = c%polish == 'yes' .or. (c%polish == 'preset' .and. .not. s%is_paper)
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

  !> Adds a mistake if a result would overwrite an input, also one of another individual.
  subroutine check_output_files(s, ini, world, errors)
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
  end subroutine check_output_files

  !> Adds a mistake if the measurement has no bending tests, which a training needs.
  subroutine check_tests(s, errors)
    type(train_settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: errors
    if (.not. allocated(s%measurement%loads)) return
    if (s%measurement%moves() .and. size(s%measurement%loads) == 0) call s%config%complain(errors, 'Measurement', 'file', &
      'has modes or records of motion but no bending test; a training needs bending tests, and msm_diagnose accepts all three')
  end subroutine check_tests

  !> Makes the experiment that the training simulates, and chooses the cost.
  subroutine make_experiment(s, errors)
    type(train_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    type(failure_t) :: failure
    type(wing_choices_t) :: wing
    call read_wing_keys(s%config, wing)
    if (s%is_paper .and. wing%cross_springs == CROSS_PRESET) s%wing_case%requested%cross_springs = .true.
    call s%experiment%init(s%measurement, s%wing_case%wing, s%wing_case%requested, s%free_parameters%numbers, &
                           s%choices%solver, failure, s%instrument, s%free_parameters%instrument_numbers, s%masses())
    if (failure%failed) call errors%add(failure%reason)
    s%wing_case%model = s%experiment%model
    select case (s%choices%cost)
    case ('h')
      if (sum(s%experiment%comparisons%n_heights) == 0) &
        call s%config%complain(errors, 'Train', 'cost', 'h compares heights, and this measurement has none; set cost = chi2')
    case ('chi2')
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
    character(:), allocatable :: problem
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
    if (problem /= '') call s%config%complain(errors, 'CMAES', key_of(problem), problem)
  end subroutine read_search

  !> Returns the key to which a message of `option_problem` belongs: its first word, unless that word stands for several keys.
  pure function key_of(problem) result(key)
    character(*), intent(in) :: problem
    character(:), allocatable :: key
    key = problem(:scan(problem//' ', ' ,') - 1)
    if (key == 'tolerances') key = 'tolfun'
    if (key == 'there') key = 'lambda'
  end function key_of

  !> Returns the kind `given`, or that of the preset if `given` is 0.
  pure integer function preset_kind(s, given, usual, paper) result(kind)
    type(train_settings_t), intent(in) :: s
    integer, intent(in) :: given, usual, paper
    kind = given
    if (given == 0) kind = merge(paper, usual, s%is_paper)
  end function preset_kind

  !> Records for --check the values that are used where the file leaves the choice or is silent. Constants that follow from lambda
  !> stay open, because restarts change lambda.
  subroutine settle_choices(s)
    type(train_settings_t), intent(inout) :: s
    associate (o => s%search)
      call settle_integer('lambda', merge(o%lambda, default_lambda(s%experiment%count()), o%lambda > 0))
      if (o%max_iterations < UNLIMITED) call settle_integer('max_generations', o%max_iterations)
      if (.not. s%is_paper) call settle_integer('max_evaluations', int(o%max_evaluations))
      call settle_real('target', o%f_target)
      call settle_real('tolfun', o%tolfun)
      call settle_word('CMAES', 'weights', word_of(WEIGHTINGS, o%weights))
      call settle_word('CMAES', 'constants', word_of(CONSTANT_SETS, o%constants))
    end associate
    call settle_word('Train', 'scale', trim(merge('linear', 'log   ', s%is_paper)))
    call settle_word('Train', 'cost', trim(merge('chi2', 'h   ', s%use_chi2)))
    call settle_word('Train', 'stages', number_text(s%n_stages))
    call settle_word('Polish', 'polish', trim(merge('yes', 'no ', s%polish)))
    call settle_word('Measurement', 'outliers', trim(merge('keep     ', 'leave_out', s%is_paper)))
    call settle_word('Wing', 'cross_springs', trim(merge('yes', 'no ', s%wing_case%requested%cross_springs)))

  contains

    !> Records the choice for words that leave it open.
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
      text = trim(merge('by the preset', 'computed     ', s%is_paper))
    end function origin
  end subroutine settle_choices

  !> If E is free, adds a notice for each joint that is neither free nor given. Such a joint keeps the stiffness of a vein with the
  !> E of [Wing].
  subroutine add_notices(s, notices)
    type(train_settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: notices
    integer :: i, number
    if (.not. any(s%free_parameters%numbers == PARAM_YOUNG)) return
    do i = 1, size(s%wing_case%requested%joint)
      number = N_COMMON + size(s%wing_case%requested%vein_factor) + i
      if (s%wing_case%requested%joint(i) < 0 .and. .not. any(s%free_parameters%numbers == number)) &
       call notices%add('joint:'//trim(s%wing_case%requested%joint_names(i))//' is not fitted: it keeps '// &
                         'the stiffness of a vein with the E of [Wing], '//number_text(s%experiment%model%params%joint(i))// &
                         ' N m/rad; to fit it, add it to the parameters')
    end do
  end subroutine add_notices
end module train_settings

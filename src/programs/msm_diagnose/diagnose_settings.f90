! SPDX-License-Identifier: GPL-3.0-or-later
!> What `msm_diagnose` is to do: from the ini file, the wing file and the measurement file to an experiment, a catalogue
!> and the choices of the statistics. Whatever a user can do wrong is found here. SI units.
module diagnose_settings
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: i8, rp
  use common_diagnose_keys, only: register_diagnose_keys
  use common_instrument, only: read_instrument
  use common_outliers, only: choose_heights
  use common_overwrite_guard, only: refuse_overwriting
  use common_sought, only: read_sought
  use common_wing_settings, only: check_name, find_beside, load_wing
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_noise, only: estimate_noise, plan_noise
  use diagnosis_wing_bins, only: make_bins, usual_size
  use diagnosis_wing_catalogue, only: make_catalogue
  use diagnosis_wing_lattice, only: make_patterns
  use io_config, only: config_t
  use io_registry, only: registry_t
  use io_shared_text, only: read_shared_text
  use measurement_data, only: measurement_t
  use measurement_outliers, only: outliers_t
  use measurement_broadcast, only: load_measurement
  use parallel_world, only: world_t
  use solid_effect, only: effect_t, NEED_UNSTRESSED_REST
  use solid_effects, only: is_active, list_effects
  use solid_mass, only: lump_mass
  use solid_statics, only: static_options_t
  use solid_wing_refine, only: refine_params, refine_wing
  implicit none
  private
  public :: diagnose_settings_t, load_diagnose_settings

  type, extends(diagnosis_case_t) :: diagnose_settings_t
    type(config_t) :: config
    character(:), allocatable :: measurement_path
    type(outliers_t) :: outliers
    integer :: n_starts = 1
    logical :: finds_band = .false.         !< what another mesh changes counts as an error
    character(:), allocatable :: name       !< first part of the names of the files to write
    character(:), allocatable :: draws_path !< of the file with the null distribution; empty: it is not kept
  end type diagnose_settings_t

contains

  !> Reads the ini file `path` and what it names on all ranks; all mistakes go to `errors`, remarks to `notices`.
  !> `refine` goes before [Diagnose] refine unless it is empty. What `may_plan` needs no heights. Collective.
  subroutine load_diagnose_settings(path, refine, may_plan, world, s, errors, notices)
    character(*), intent(in) :: path, refine
    logical, intent(in) :: may_plan
    type(world_t), intent(in) :: world
    type(diagnose_settings_t), intent(out) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t) :: registry
    character(:), allocatable :: text, problem
    logical :: found
    call register_diagnose_keys(registry)
    call read_shared_text(path, text, problem, world)
    if (allocated(problem)) then
      call errors%add(problem)
      return
    end if
    call s%config%load_text(text, path, registry, errors, notices, .false., world)
    if (s%config%asks_for_unbuilt()) return
    call read_options(s, refine, errors)
    call load_wing(s%config, path, .false., s%setup, found, errors, notices, world)
    if (.not. found) return
    if (s%config%is_given('Measurement', 'file')) then
      call find_beside(path, s%config%get_text('Measurement', 'file'), s%measurement_path, problem, world)
      if (allocated(problem)) then
        call s%config%complain(errors, 'Measurement', 'file', problem)
      else
        call load_measurement(world, s%measurement_path, s%setup%wing, s%measurement, errors, may_plan)
        if (errors%count() == 0) then
          if (s%measurement%is_plan .and. size(s%measurement%x) > 0) &
            call notices%add(s%measurement_path//': the plan of an experiment, without heights, for --plan alone')
          call choose_heights(s%config, s%measurement_path, .false., s%measurement, s%outliers, notices)
        end if
      end if
    end if
    call check_outputs(s, errors)
    if (allocated(s%measurement%loads)) call s%instrument%set_scales(s%measurement, s%setup%model%size)
    call read_instrument(s%config, s%instrument, errors)
    call read_sought(s%config, 'Diagnose', s%setup%asked, s%instrument, .true., s%sought, errors)
    if (size(s%sought%instrument_numbers) > 0) call s%config%complain(errors, 'Diagnose', 'parameters', &
                                               'the baseline seeks parameters of the wing only, not of the measurement')
    if (errors%count() > 0) return
    if (s%fits_finer) call take_finer(s)
    call check_modes(s, errors)
    if (errors%count() == 0) call make_all(s, errors, notices)
  end subroutine load_diagnose_settings

  !> What natural modes and records of motion need.
  subroutine check_modes(s, errors)
    type(diagnose_settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: errors
    type(effect_t), allocatable :: list(:)
    integer :: e
    if (.not. s%measurement%moves()) return
    if (.not. s%setup%has_mass) call s%config%complain(errors, 'Mass', 'membrane_law', &
                                  'the measurement holds natural modes or records of motion, which need a valid mass of the wing')
    list = list_effects()
    do e = 1, size(list)
      if (all(list(e)%needs /= NEED_UNSTRESSED_REST) .or. .not. is_active(list, e, s%setup%asked%effects)) cycle
      call s%config%complain(errors, 'Wing', 'parameters', &
        'motion is that about a wing which is flat and free of stress at rest: without pretension and camber')
      exit
    end do
  end subroutine check_modes

  !> No result may take the place of what is read.
  subroutine check_outputs(s, errors)
    type(diagnose_settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: errors
    character(22), parameter :: ENDINGS(6) = [character(22) :: &
                                              '.json', '.h5', '_baseline.ini', '_extended.ini', &
                                              '_next_measurements.csv', '_plan.json']
    type(message_list_t) :: inputs
    integer :: i
    call inputs%add(s%setup%path)
    if (allocated(s%measurement_path)) call inputs%add(s%measurement_path)
    do i = 1, size(ENDINGS)
      call refuse_overwriting(s%config, 'Saving', 'name', s%name//trim(ENDINGS(i)), inputs, errors)
    end do
    call refuse_overwriting(s%config, 'Saving', 'draws', s%draws_path, inputs, errors)
  end subroutine check_outputs

  !> The finer wing takes the place of that of the file.
  subroutine take_finer(s)
    type(diagnose_settings_t), intent(inout) :: s
    type(message_list_t) :: messages
    s%file_wing = s%setup%wing
    s%file_asked = s%setup%asked
    call refine_wing(s%file_wing, s%setup%wing)
    s%setup%asked = refine_params(s%file_asked)
    if (s%setup%has_mass) call lump_mass(s%setup%wing, s%setup%material, s%setup%mass, messages)
  end subroutine take_finer

  subroutine read_options(s, refine, errors)
    type(diagnose_settings_t), intent(inout) :: s
    character(*), intent(in) :: refine
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: choice
    associate (c => s%config, o => s%options)
      s%membrane_sd = c%get_real('Diagnose', 'membrane_sd')
      s%prior_decades = c%get_real('Diagnose', 'prior_decades')
      choice = c%get_word('Diagnose', 'refine')
      if (refine /= '') choice = refine
      s%finds_band = choice /= 'no'
      s%fits_finer = choice == 'fit'
      s%n_starts = c%get_integer('Diagnose', 'starts')
      o%is_scale_known = c%get_word('Diagnose', 'noise') == 'declared'
      o%n_draws = c%get_integer('Diagnose', 'draws')
      o%most_refits = c%get_integer('Diagnose', 'refits')
      o%validates = c%get_switch('Diagnose', 'validation')
      o%finds_intervals = c%get_switch('Diagnose', 'intervals')
      o%seed = int(c%get_integer('Diagnose', 'seed'), i8)
      o%fit%most_iterations = c%get_integer('Diagnose', 'iterations')
      s%name = c%get_text('Saving', 'name')
      if (s%name == '') call c%complain(errors, 'Saving', 'name', 'must be the first part of names of files')
      call check_name(c, s%name, errors)
      s%draws_path = ''
      if (c%is_given('Saving', 'draws')) s%draws_path = c%get_text('Saving', 'draws')
      if (s%draws_path == '') s%draws_path = s%name//'_draws.h5'
      if (s%draws_path == 'none') s%draws_path = ''
    end associate
  end subroutine read_options

  !> The experiment, what is averaged, the catalogue, and what neighbouring heights say about their errors.
  subroutine make_all(s, errors, notices)
    type(diagnose_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(static_options_t) :: options
    type(failure_t) :: failure
    real(rp), allocatable :: values(:, :), masses(:)
    integer :: l
    options%tolerance = s%config%get_real('Solver', 'tolerance')
    options%step_limit = s%config%get_real('Solver', 'step_limit')
    options%factorisation_limit = s%config%get_integer('Solver', 'factorisation_limit')
    if (is_loaded_from_both_sides(s%measurement) .and. size(s%setup%wing%joints) > 0) &
      s%setup%asked%effects%has_sides = .true.
    allocate (masses(0))
    if (s%setup%has_mass) masses = s%setup%mass%nodal
    if (s%setup%has_mass) call s%parts%init(s%setup%wing, s%setup%mass)
    call s%experiment%init(s%measurement, s%setup%wing, s%setup%asked, [integer ::], options, failure, s%instrument, &
                           masses=masses)
    if (failure%failed) then
      call errors%add(failure%reason)
      return
    end if
    s%setup%model = s%experiment%model
    call make_bins(s%experiment, usual_size(s%experiment, s%config%get_integer('Diagnose', 'observations')), s%bins)
    call make_catalogue(s%experiment, s%setup%wing, s%sought%numbers, s%prior_decades, s%catalogue)
    call make_patterns(s%experiment, s%setup%wing, s%patterns)
    if (s%measurement%is_plan) then
      call plan_noise(s%experiment, s%noise)
      return
    end if
    allocate (values(maxval(s%experiment%comparisons%n), size(s%experiment%comparisons)), source=0.0_rp)
    do l = 1, size(values, 2)
      values(:s%experiment%comparisons(l)%n, l) = s%experiment%comparisons(l)%measured
    end do
    call estimate_noise(s%experiment, values, s%noise)
    s%options%noise_freedom = s%noise%freedom
    if (s%noise%warning /= '') call notices%add(s%measurement_path//': '//s%noise%warning)
  end subroutine make_all

  !> Whether one-way joints could show.
  pure logical function is_loaded_from_both_sides(m) result(is_it)
    type(measurement_t), intent(in) :: m
    integer :: l
    associate (up => [(m%loads(l)%force*m%loads(l)%direction(3), l=1, size(m%loads))])
      is_it = any(up > 0) .and. any(up < 0)
    end associate
  end function is_loaded_from_both_sides
end module diagnose_settings

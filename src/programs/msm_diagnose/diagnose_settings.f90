! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads what `msm_diagnose` has to do: it turns the ini file, the wing file and the measurement file into an experiment, a
!> catalogue and the settings of the statistics. All mistakes that a user can make are found here. Quantities are in SI units.
module diagnose_settings
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use common_bending_case, only: bending_input_t, load_bending_case, load_input
  use common_diagnose_keys, only: diagnose_choices_t, diagnose_keys, register_diagnose_keys, DRAWS_NONE, NOISE_DECLARED, &
                                  REFINE_AUTO, REFINE_FIT, REFINE_NO, REFINE_UNSTATED
  use common_measurement_keys, only: read_measurement_keys
  use common_overwrite_guard, only: refuse_overwriting
  use common_wing_fragment, only: wing_lines
  use common_wing_keys, only: read_wing_keys
  use common_wing_settings, only: check_name
  use diagnose_flight_effects, only: check_effects, take_structure
  use diagnose_flight_settings, only: load_flights
  use diagnose_flights, only: flusi_runner_t
  use diagnose_results, only: PLAN_RESULT, RESULTS
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_flight_runner, only: flight_request_t
  use diagnosis_noise, only: estimate_noise, assume_noise
  use diagnosis_wing_bins, only: make_bins, default_bin_size
  use diagnosis_wing_catalogue, only: make_catalogue
  use diagnosis_wing_lattice, only: make_patterns
  use diagnosis_wing_parameters, only: place_on_file, relate_to_file
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  use io_registry, only: registry_t
  use measurement_data, only: measurement_t
  use parallel_world, only: world_t
  use simulation_settings, only: settings_t
  use solid_effect, only: NEED_UNSTRESSED_REST
  use solid_effects, only: active_needs, clamp_axis, clamp_compliance
  use solid_mass, only: lump_mass
  use solid_params, only: solid_params_t
  use solid_usual_causes, only: PARAM_PLATE, PARAM_THICKNESS
  use solid_wing, only: MEMBRANE_UNSTATED
  use solid_wing_refine, only: coarsen_params, refine_params, refine_wing
  implicit none
  private
  public :: diagnose_settings_t, load_diagnose_settings

  type, extends(diagnosis_case_t) :: diagnose_settings_t
    type(config_t) :: config
    type(diagnose_choices_t) :: choices
    logical :: finds_discretisation = .false. !< the change by another mesh counts as an error
    character(:), allocatable :: name       !< first part of the names of the files to write
    type(flusi_runner_t) :: runner          !< simulates flights
    character(:), allocatable :: draws_path !< of the file with the null distribution; empty: it is not kept
  end type diagnose_settings_t

contains

  !> Reads the ini file `path` and the files that it names on all ranks. All mistakes go to `errors` and remarks to `notices`.
  !> `refine` replaces [Diagnose] refine unless it is REFINE_UNSTATED. With `may_plan` the measurement needs no heights. Collective.
  subroutine load_diagnose_settings(path, refine, may_plan, world, s, errors, notices)
    character(*), intent(in) :: path
    integer, intent(in) :: refine !< REFINE_*
    logical, intent(in) :: may_plan
    type(world_t), intent(in) :: world
    type(diagnose_settings_t), intent(out) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t) :: registry
    type(bending_input_t) :: input
    logical :: can_go_on
    call register_diagnose_keys(registry)
    call load_input(path, registry, world, s%config, errors, notices, can_go_on)
    if (.not. can_go_on) return
    call read_options(s, refine, errors)
    call read_wing_keys(s%config, input%wing)
    call read_measurement_keys(s%config, .false., input%measurement)
    input%section = 'Diagnose'
    input%parameters = s%choices%parameters
    input%may_plan = may_plan
    call load_bending_case(input, s%config, world, s, errors, notices)
    if (.not. allocated(s%free_parameters%numbers)) return
    call check_output_files(s, list_inputs(s), errors)
    if (size(s%free_parameters%instrument_numbers) > 0) call s%config%complain(errors, 'Diagnose', 'parameters', &
                                               'must hold parameters of the wing only, none of the measurement')
    if (errors%count() > 0) return
    if (s%fits_finer) call take_finer(s)
    s%chooses_mesh = s%chooses_mesh .and. s%measurement%moves() .and. size(s%measurement%loads) == 0 .and. &
                     s%measurement%count_flights() == 0
    call check_modes(s, errors)
    s%flights%free = s%free_parameters%numbers
    if (errors%count() == 0) call load_flights(s%config, s%choices%flight, s%measurement, world, s%runner, s%flights, &
                                               errors, notices)
    if (errors%count() == 0 .and. allocated(s%flights%cases)) then
      call check_output_files(s, list_cases(s), errors)
      call check_effects(s%config, s%choices%flight%effects, s%wing_case%requested, s%flights%free, s%flights, errors)
      call find_thickness(s)
    end if
    if (errors%count() == 0) call make_all(s, errors, notices)
    if (errors%count() == 0 .and. s%choices%flight%compare) call check_compared_wing(s, world, errors)
  end subroutine load_diagnose_settings

  !> Adds a mistake if a measurement of natural modes or motion lacks what it needs: the mass of the wing, a wing that is flat and
  !> free of stress at rest and, for modes under loads, a stiff clamp.
  subroutine check_modes(s, errors)
    type(diagnose_settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: errors
    integer :: i
    if (.not. s%measurement%moves()) return
    if (.not. s%wing_case%has_mass) call s%config%complain(errors, 'Mass', 'membrane_law', &
                                  'the measurement has natural modes or records of motion, which need a valid mass of the wing')
    if (any(active_needs(s%wing_case%requested%effects) == NEED_UNSTRESSED_REST)) &
      call s%config%complain(errors, 'Wing', 'parameters', &
        'must not hold pretension or camber: modes and records of motion need a wing that is flat and free of stress at rest')
    if (.not. s%measurement%has_loaded_modes()) return
    associate (free => s%free_parameters%numbers, params => s%wing_case%requested)
      if (any(clamp_compliance(params%effects) > 0) .or. &
          any([(clamp_axis(params%effects, free(i) - params%count_basic()) > 0, i=1, size(free))])) &
        call s%config%complain(errors, 'Wing', 'parameters', &
          'must not hold root_flap or root_twist: the clamp of a wing with natural modes under loads is stiff')
    end associate
  end subroutine check_modes

  !> Finds the thickness that is D of each case that bends. A thickness that the baseline fits is one of the wing of the diagnosis,
  !> whose membrane may have another modulus than that of the case.
  subroutine find_thickness(s)
    type(diagnose_settings_t), intent(inout) :: s
    type(solid_params_t) :: params
    integer :: k
    params = s%wing_case%requested
    do k = 1, size(s%flights%cases)
      if (.not. s%flights%cases(k)%facts%is_flexible) cycle
      call params%set(PARAM_PLATE, s%flights%cases(k)%facts%material(2))
      s%flights%cases(k)%facts%material(3) = params%get(PARAM_THICKNESS)
    end do
  end subroutine find_thickness

  !> Returns the paths of the wing and of the measurement.
  function list_inputs(s) result(paths)
    type(diagnose_settings_t), intent(in) :: s
    type(message_list_t) :: paths
    call paths%add(s%wing_case%path)
    if (allocated(s%measurement_path)) call paths%add(s%measurement_path)
  end function list_inputs

  !> Returns the paths of the cases that are flown.
  function list_cases(s) result(paths)
    type(diagnose_settings_t), intent(in) :: s
    type(message_list_t) :: paths
    integer :: k
    do k = 1, size(s%flights%cases)
      call paths%add(s%flights%cases(k)%facts%path)
    end do
  end function list_cases

  !> Adds a mistake if a result would overwrite a file that is read, the input itself or one of `inputs`.
  subroutine check_output_files(s, inputs, errors)
    type(diagnose_settings_t), intent(in) :: s
    type(message_list_t), intent(in) :: inputs
    type(message_list_t), intent(inout) :: errors
    integer :: i
    do i = 1, size(RESULTS)
      call refuse_overwriting(s%config, 'Saving', 'name', s%name//trim(RESULTS(i)), inputs, errors)
    end do
    call refuse_overwriting(s%config, 'Saving', 'name', s%name//PLAN_RESULT, inputs, errors)
    call refuse_overwriting(s%config, 'Saving', 'draws', s%draws_path, inputs, errors)
  end subroutine check_output_files

  !> Adds a mistake if the case of [Flight] cannot be flown with the wing of this diagnosis. Collective.
  subroutine check_compared_wing(s, world, errors)
    type(diagnose_settings_t), intent(in) :: s
    type(world_t), intent(in) :: world
    type(message_list_t), intent(inout) :: errors
    type(solid_params_t) :: params
    type(settings_t), allocatable :: unused
    type(flight_request_t) :: request
    type(message_list_t) :: of_case
    integer :: i
    params = s%experiment%model%params
    if (s%fits_finer) params = coarsen_params(params)
    request%wing = wing_lines(params, s%wing_case)
    allocate (unused)
    call s%runner%cases(1)%read(request, unused, of_case, world)
    do i = 1, of_case%count()
      call s%config%complain(errors, 'Flight', 'compare', 'the case cannot be simulated with the wing of this diagnosis: '// &
                             of_case%text(i))
    end do
  end subroutine check_compared_wing

  !> Replaces the wing of the file by one with a finer mesh, and keeps the wing of the file with the stiffness of all its joints.
  subroutine take_finer(s)
    type(diagnose_settings_t), intent(inout) :: s
    type(message_list_t) :: messages
    s%file_wing = s%wing_case%wing
    s%file_requested = s%wing_case%requested
    s%file_requested%joint = s%wing_case%model%params%joint
    call refine_wing(s%file_wing, s%wing_case%wing)
    s%wing_case%requested = refine_params(s%wing_case%requested)
    if (s%wing_case%has_mass) call lump_mass(s%wing_case%wing, s%wing_case%material, s%wing_case%mass, messages)
  end subroutine take_finer

  !> Reads the options of the diagnosis. `refine` replaces the key of that name unless it is REFINE_UNSTATED.
  subroutine read_options(s, refine, errors)
    type(diagnose_settings_t), intent(inout), target :: s
    integer, intent(in) :: refine
    type(message_list_t), intent(inout) :: errors
    integer :: choice
    type(keys_t) :: keys
    keys = reading(s%config)
    call diagnose_keys(keys, s%choices)
    associate (c => s%choices)
      s%membrane_sd = c%membrane_sd
      s%prior_decades = c%prior_decades
      choice = c%refine
      if (refine /= REFINE_UNSTATED) choice = refine
      s%finds_discretisation = choice /= REFINE_NO
      s%fits_finer = choice == REFINE_FIT
      s%chooses_mesh = choice == REFINE_AUTO
      s%options = c%options
      s%proposals = c%proposals
      s%options%is_scale_known = c%noise == NOISE_DECLARED
      s%name = c%name
      if (s%name == '') call s%config%complain(errors, 'Saving', 'name', &
                                                     'is empty: give the first part of the names of the result files')
      call check_name(s%config, s%name, errors)
      s%draws_path = ''
      if (allocated(c%draws)) s%draws_path = c%draws
      if (s%draws_path == '') s%draws_path = s%name//'_draws.h5'
      if (s%draws_path == DRAWS_NONE) s%draws_path = ''
    end associate
  end subroutine read_options

  !> Makes the experiment, the averages and the catalogue, and estimates the errors of heights from neighbouring heights.
  subroutine make_all(s, errors, notices)
    type(diagnose_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(failure_t) :: failure
    real(rp), allocatable :: values(:, :)
    integer :: l
    if (is_loaded_from_both_sides(s%measurement) .and. size(s%wing_case%wing%joints) > 0) &
      s%wing_case%requested%effects%has_sides = .true.
    if (s%wing_case%has_mass) call s%parts%init(s%wing_case%wing, s%wing_case%mass)
    s%states_mass = size(s%wing_case%wing%triangles) == 0 .or. s%wing_case%wing%mass%law /= MEMBRANE_UNSTATED .or. &
                    s%config%is_given('Mass', 'membrane_mass') .or. s%config%is_given('Mass', 'areal_density')
    if (s%only_flies()) then ! neither the mechanics nor the mesh matters
      s%free_parameters%numbers = [integer ::]
      s%finds_discretisation = .false.
    end if
    call s%experiment%init(s%measurement, s%wing_case%wing, s%wing_case%requested, [integer ::], s%choices%solver, failure, &
                           s%instrument, masses=s%masses())
    if (failure%failed) then
      call errors%add(failure%reason)
      return
    end if
    s%wing_case%model = s%experiment%model
    call make_bins(s%experiment, default_bin_size(s%experiment, s%choices%observations), s%bins)
    call make_catalogue(s%experiment, s%wing_case%wing, s%free_parameters%numbers, s%prior_decades, s%catalogue, s%flights, &
                        s%membrane_sd)
    if (s%fits_finer) then
      call relate_to_file(s%catalogue%parameters, s%experiment%model%params, s%file_requested%joint)
      call place_on_file(s%catalogue%parameters, s%file_wing)
    end if
    s%runner%wing%size = s%experiment%model%size
    s%runner%wing%vein_names = s%experiment%model%params%vein_names
    call take_structure(s%config, s%catalogue, s%flights, s%runner, errors)
    call make_patterns(s%experiment, s%wing_case%wing, s%patterns)
    if (s%only_flies()) s%patterns%site = s%patterns%site(:, :0)
    if (s%measurement%is_plan) then
      call assume_noise(s%experiment, s%noise)
      return
    end if
    allocate (values(maxval(s%experiment%comparisons%n), size(s%experiment%comparisons)), source=0.0_rp)
    do l = 1, size(values, 2)
      values(:s%experiment%comparisons(l)%n, l) = s%experiment%comparisons(l)%measured
    end do
    call estimate_noise(s%experiment, values, s%noise)
    if (s%noise%dof > 0) s%options%noise_dof = s%noise%dof
    if (s%noise%warning /= '') call notices%add(s%measurement_path//': '//s%noise%warning)
  end subroutine make_all

  !> Tells whether some loads push up and others down, which the detection of one-way joints needs.
  pure logical function is_loaded_from_both_sides(m) result(is_it)
    type(measurement_t), intent(in) :: m
    integer :: l
    associate (up => [(m%loads(l)%force*m%loads(l)%direction(3), l=1, size(m%loads))])
      is_it = any(up > 0) .and. any(up < 0)
    end associate
  end function is_loaded_from_both_sides
end module diagnose_settings

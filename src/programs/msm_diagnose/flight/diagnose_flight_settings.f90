! SPDX-License-Identifier: GPL-3.0-or-later
!> Handles the section [Flight] of a diagnosis. It reads the cases that simulate the experiments in which forces were recorded,
!> checks that the records fit their cases, and starts the simulation of the flights.
module diagnose_flight_settings
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_outcome, only: outcome_t, OUTCOME_NOT_CONVERGED
  use base_text, only: number_text, quoted
  use common_diagnose_keys, only: flight_choices_t, WALL_BELOW
  use common_wing_settings, only: find_beside
  use diagnose_flight_case, only: flight_case_t
  use diagnose_flight_cases, only: group_records
  use diagnose_flight_cost, only: list_text
  use diagnose_flight_landmarks, only: rigid_places, take_marks
  use diagnose_flights, only: flusi_runner_t
  use diagnosis_flight_catalogue, only: exclude_unflown, flight_steps, uncounted_errors
  use diagnosis_flight_data, only: append_requests, flight_cases_t, flight_data_t
  use diagnosis_flight_changes, only: FLOW_DEVIATION, FLOW_FREQUENCY, FLOW_LEAD, FLOW_PITCH, FLOW_PITCH_MEAN, FLOW_PLANE, &
                                      FLOW_PLATE, FLOW_STROKE, FLOW_STROKE_MEAN, FLOW_YOUNG, is_of_flow, N_CHANGES, N_FLOW
  use diagnosis_flight_refinements, only: read_refinements, refinement_name, N_REFINEMENTS, REFINE_BEATS, REFINE_BOX
  use diagnosis_flight_runner, only: flight_facts_t, flight_record_t, flight_request_t
  use diagnosis_wing_entries, only: catalogue_t
  use io_config, only: config_t
  use io_suggest, only: suggestion_t
  use measurement_data, only: measurement_t
  use measurement_flight, only: COMPONENT_NAMES, COMPONENT_POWER, KINEMATIC_SD, measured_flight_t, N_KINEMATICS
  use parallel_failure, only: broadcast_failure
  use parallel_world, only: world_t
  use solid_usual_causes, only: PARAM_YOUNG
  implicit none
  private
  public :: fly_all, load_flights

  real(rp), parameter :: SAME_FREQUENCY = 0.01_rp !< relative

contains

  !> Reads the cases that the records of the measurement, or a comparison of two wings, need, and puts the records in the order of
  !> their cases. Mistakes go to `errors` and remarks to `notices`. Collective.
  subroutine load_flights(config, c, measurement, world, runner, data, errors, notices)
    type(config_t), intent(in) :: config
    type(flight_choices_t), intent(in) :: c
    type(measurement_t), intent(inout) :: measurement
    type(world_t), intent(in) :: world
    type(flusi_runner_t), intent(inout) :: runner
    type(flight_cases_t), intent(inout) :: data
    type(message_list_t), intent(inout) :: errors, notices
    logical :: is_named(N_REFINEMENTS), has_records
    character(:), allocatable :: unknown
    real(rp) :: prior_sd(N_CHANGES)
    integer :: k
    has_records = measurement%count_flights() > 0
    if (.not. (has_records .or. c%compare)) call notice_idle_case(config, c, notices)
    if (.not. (has_records .or. c%compare)) return
    if (has_records .and. c%compare) call config%complain(errors, 'Flight', 'compare', &
      'must be left out: with /flight both flights are always compared')
    if (.not. has_records .and. c%records /= '') call config%complain(errors, 'Flight', 'records', &
      'must be left out: the measurement has no records in /flight')
    if (has_records) then
      call group_records(config, c, measurement, world, data%cases, errors)
    else
      call find_compared(config, c, world, data%cases, errors)
    end if
    if (size(data%cases) == 0) return
    call check_refinements(config, c%refine, errors)
    allocate (runner%cases(size(data%cases)))
    runner%folder = c%folder
    runner%ranks = c%ranks
    do k = 1, size(data%cases)
      call load_case(c, world, runner%cases(k), data%cases(k)%facts, k, size(data%cases) > 1, errors, notices)
    end do
    if (errors%count() > 0) return
    if (.not. has_records) then
      if (.not. data%cases(1)%facts%is_flexible) call config%complain(errors, 'Flight', 'compare', &
        'needs a case whose wings bend, with [Insects] wings = flexible; in '//c%file//' they are rigid')
      return
    end if
    prior_sd = 0
    call take_kinematic_errors(measurement, prior_sd, errors)
    do k = 1, size(data%cases)
      call read_refinements(c%refine, c%wing_thickness > 0 .and. runner%cases(k)%settings%flight%thin%is_thin, &
                            data%cases(k)%refined, is_named, unknown)
      data%cases(k)%model_sd = c%model_sd
      data%cases(k)%response%n_harmonics = c%harmonics
      data%cases(k)%facts%prior_sd = prior_sd
      data%cases(k)%facts%is_alone = size(measurement%loads) == 0 .and. .not. measurement%moves()
      data%cases(k)%facts%shares = [any(data%free == PARAM_YOUNG), .true.] .and. data%cases(k)%facts%is_flexible .and. &
                                   .not. data%cases(k)%facts%is_alone
      associate (case => data%cases(k))
        call take_records(config, measurement%flights(case%first:case%last), is_named, world, runner%cases(k), data%cases(k), &
                          errors, notices)
        if (case%facts%is_section .neqv. data%cases(1)%facts%is_section) &
          call config%complain(errors, 'Flight', 'records', 'needs cases of one kind, but of '//data%cases(1)%facts%path// &
                               ' and '//case%facts%path//' one is two-dimensional and one is not')
      end associate
    end do
    data%has_records = .true.
    data%effects = c%effects
  end subroutine load_flights

  !> Adds a notice if the input names a case, which neither a record nor a comparison needs.
  subroutine notice_idle_case(config, c, notices)
    type(config_t), intent(in) :: config
    type(flight_choices_t), intent(in) :: c
    type(message_list_t), intent(inout) :: notices
    if (c%file /= '') call config%complain(notices, 'Flight', 'file', 'has no effect: the measurement has no records in '// &
      '/flight; compare = yes flies this case with both wings')
  end subroutine notice_idle_case

  !> Takes the records that a case simulates. Mistakes go to `errors` and remarks to `notices`, with the path of the case if there
  !> are several cases. Collective.
  subroutine take_records(config, flights, is_named, world, case, data, errors, notices)
    type(config_t), intent(in) :: config
    type(measured_flight_t), intent(in) :: flights(:)
    logical, intent(in) :: is_named(N_REFINEMENTS)
    type(world_t), intent(in) :: world
    type(flight_case_t), intent(inout) :: case
    type(flight_data_t), intent(inout) :: data
    type(message_list_t), intent(inout) :: errors, notices
    integer :: before, i
    before = errors%count()
    call take_marks(flights, case%settings, data%facts%is_section, case%marks, errors)
    if (errors%count() > before) return
    data%facts%rigid = rigid_places(case%settings, case%marks, case%beats)
    call case%judge(data%refined, world, data%facts)
    if (all(flights%side > 0) .and. .not. data%facts%is_flexible) then
      where (is_of_flow([(i, i=1, N_FLOW)]) .and. data%facts%missing == '') &
        data%facts%missing = 'needs records of forces: landmarks on rigid wings do not show it'
    end if
    call drop_refinements(config, data%facts, is_named, data%refined, errors, notices)
    call check_records(flights, data%facts, errors)
    data%response%wind = data%facts%wind
  end subroutine take_records

  !> Finds the case of a comparison of two wings. Collective.
  subroutine find_compared(config, c, world, cases, errors)
    type(config_t), intent(in) :: config
    type(flight_choices_t), intent(in) :: c
    type(world_t), intent(in) :: world
    type(flight_data_t), allocatable, intent(out) :: cases(:)
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: path, problem
    if (c%file == '') then
      problem = 'is missing: compare = yes simulates this flusi case with two wings'
    else
      call find_beside(config%file_name(), c%file, path, problem, world)
    end if
    allocate (cases(merge(0, 1, allocated(problem))))
    if (allocated(problem)) then
      call config%complain(errors, 'Flight', 'file', problem)
      return
    end if
    cases(1)%facts%path = path
  end subroutine find_compared

  !> Reads case `number`, whose path is in `facts`, and fills its facts. Mistakes go to `errors` and remarks to `notices`, with this
  !> path if there are other cases. Collective.
  subroutine load_case(c, world, case, facts, number, has_others, errors, notices)
    type(flight_choices_t), intent(in) :: c
    type(world_t), intent(in) :: world
    type(flight_case_t), intent(inout) :: case
    type(flight_facts_t), intent(inout) :: facts
    integer, intent(in) :: number
    logical, intent(in) :: has_others
    type(message_list_t), intent(inout) :: errors, notices
    type(message_list_t) :: of_case, remarks
    character(:), allocatable :: place
    integer :: i
    call case%load(facts%path, c%beats, world, of_case, remarks)
    do i = 1, of_case%count()
      call errors%add(of_case%text(i))
    end do
    if (of_case%count() > 0 .or. errors%count() > 0) return
    place = 'of [Flight] '//trim(merge('file   ', 'records', number == 1 .and. c%file /= ''))
    if (has_others) place = place//', '//facts%path
    do i = 1, remarks%count()
      call notices%add(place//': '//remarks%text(i))
    end do
    associate (length => case%settings%units%length, omitted => case%omitted)
      omitted%wall_distance = c%wall_distance/length
      omitted%wall_axis = merge(3, 2, c%wall_side == WALL_BELOW)
      omitted%body_length = c%body_length/length
      omitted%body_radius = c%body_radius/length
      case%wing_thickness = c%wing_thickness/length
    end associate
    call case%tell(facts)
  end subroutine load_case

  !> Adds a mistake for a word that is not a refinement.
  subroutine check_refinements(config, words, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: words
    type(message_list_t), intent(inout) :: errors
    logical :: wanted(N_REFINEMENTS), is_named(N_REFINEMENTS)
    type(suggestion_t) :: suggestion
    character(:), allocatable :: unknown, valid
    integer :: k
    call read_refinements(words, .false., wanted, is_named, unknown)
    if (unknown == '') return
    valid = 'yes, all, no'
    call suggestion%start(unknown)
    do k = 1, N_REFINEMENTS
      valid = valid//', '//refinement_name(k)
      call suggestion%offer(refinement_name(k))
    end do
    call config%complain(errors, 'Flight', 'refine', 'there is no refinement '//quoted(unknown)//suggestion%hint()//'; valid: '// &
                         valid)
  end subroutine check_refinements

  !> Leaves out the refinements that the case does not permit. Adds a mistake for one that the user names, and a remark for one
  !> that changes forces much.
  subroutine drop_refinements(config, facts, is_named, refined, errors, notices)
    type(config_t), intent(in) :: config
    type(flight_facts_t), intent(in) :: facts
    logical, intent(in) :: is_named(N_REFINEMENTS)
    logical, intent(inout) :: refined(N_REFINEMENTS)
    type(message_list_t), intent(inout) :: errors, notices
    character(:), allocatable :: of_case
    integer :: i
    of_case = ''
    if (facts%label /= '') of_case = ' '//facts%path
    do i = 1, N_REFINEMENTS
      if (.not. refined(i) .or. facts%unrefined(i) == '') cycle
      refined(i) = .false.
      if (is_named(i)) then
        call config%complain(errors, 'Flight', 'refine', 'names '//refinement_name(i)//', but the case'//of_case// &
                             ' cannot be flown so: '//trim(facts%unrefined(i)))
      else if (any(i == [REFINE_BOX, REFINE_BEATS])) then
        call notices%add('[Flight] refine leaves out '//refinement_name(i)//of_case//': '//trim(facts%unrefined(i))// &
                         '. Change the case, or allow for this error by [Flight] model_sd')
      end if
    end do
  end subroutine drop_refinements

  !> Adds a mistake for every record that does not belong to its case: another frequency of the beat, or components that the case
  !> does not have.
  subroutine check_records(flights, facts, errors)
    type(measured_flight_t), intent(in) :: flights(:)
    type(flight_facts_t), intent(in) :: facts
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: object
    integer :: r, k
    do r = 1, size(flights)
      associate (f => flights(r))
        object = '/flight/'//f%name
        if (any([(flights(k)%name == f%name, k=1, r - 1)])) cycle ! the landmarks of a flight that was checked
        if (abs(f%frequency/facts%frequency - 1) > SAME_FREQUENCY) &
          call errors%add(object//': attribute frequency is '//number_text(f%frequency)//' Hz, but the wings of '//facts%path// &
                          ' beat with '//number_text(facts%frequency)//' Hz: wing_frequency times the frequency of [units]')
        if (f%is_per_length .neqv. facts%is_section) &
          call errors%add(object//': attribute per_length must be '//trim(merge('1, as', '0, as', facts%is_section))//' '// &
                          facts%path//' is '//trim(merge('two-dimensional', 'a wing in space', facts%is_section)))
        if (.not. facts%is_section .or. f%side > 0) cycle
        do k = 1, size(f%component)
          if (all(f%component(k) /= [2, 3, 4, COMPONENT_POWER])) &
            call errors%add(object//': component '//trim(COMPONENT_NAMES(f%component(k)))//' does not exist for a section; '// &
                            'valid: Fy, Fz, Mx, power')
        end do
      end associate
    end do
  end subroutine check_records

  !> Takes the errors of the kinematics that records state as the prior sd of the changes. Adds a mistake if two records state
  !> different errors, because all records share them.
  subroutine take_kinematic_errors(measurement, prior_sd, errors)
    type(measurement_t), intent(in) :: measurement
    real(rp), intent(inout) :: prior_sd(N_CHANGES)
    type(message_list_t), intent(inout) :: errors
    integer, parameter :: OF_CHANGE(N_KINEMATICS) = [FLOW_STROKE, FLOW_STROKE_MEAN, FLOW_PITCH, FLOW_PITCH_MEAN, FLOW_LEAD, &
                                                     FLOW_DEVIATION, FLOW_PLANE, FLOW_FREQUENCY]
    integer :: r, k
    do r = 1, measurement%count_flights()
      do k = 1, N_KINEMATICS
        associate (sd => measurement%flights(r)%kinematic_sd(k), prior => prior_sd(OF_CHANGE(k)))
          if (.not. sd > 0) cycle
          if (prior > 0 .and. abs(prior - sd) > 0) &
            call errors%add('/flight/'//measurement%flights(r)%name//': attribute '//trim(KINEMATIC_SD(k))//' is '// &
                            number_text(sd)//', but '//number_text(prior)//' in another record: all records of a '// &
                            'measurement share this error')
          prior = sd
        end associate
      end do
    end do
  end subroutine take_kinematic_errors

  !> Simulates the flights that are needed and stores what they show in `data`. What needs a flight that failed is excluded from the
  !> catalogue. If the flight of a case itself failed, `failure` says why on all ranks. Collective.
  subroutine fly_all(world, runner, data, catalogue, outcome)
    type(world_t), intent(in) :: world
    type(flusi_runner_t), intent(inout) :: runner
    type(flight_cases_t), intent(inout) :: data
    type(catalogue_t), intent(inout) :: catalogue
    type(outcome_t), intent(inout) :: outcome
    type(flight_request_t), allocatable :: requests(:)
    type(flight_record_t), allocatable :: records(:)
    real(rp) :: steps(N_FLOW, size(data%cases))
    integer :: first(size(data%cases) + 1), k
    allocate (requests(0))
    first(1) = 0
    do k = 1, size(data%cases)
      associate (case => data%cases(k))
        steps(:, k) = flight_steps(case%facts, data%effects)
        call append_requests(requests, case%response%requests(steps(:, k), case%refined), k)
        first(k + 1) = size(requests)
      end associate
    end do
    call runner%fly(world, requests, records, outcome)
    do k = 1, size(data%cases)
      if (outcome%is_good()) call take_flights(world, steps(:, k), records(first(k) + 1:first(k + 1)), data%cases(k), &
                                               outcome)
    end do
    if (.not. outcome%is_good()) return
    call exclude_unflown(catalogue, data%cases)
    data%is_ready = .true.
  end subroutine fly_all

  !> Takes the flights of one case, which rank 0 has read. Fails if the flight of the case itself failed. Collective.
  subroutine take_flights(world, steps, records, data, outcome)
    type(world_t), intent(in) :: world
    real(rp), intent(in) :: steps(N_FLOW)
    type(flight_record_t), intent(in) :: records(:)
    type(flight_data_t), intent(inout) :: data
    type(outcome_t), intent(inout) :: outcome
    integer, parameter :: MATERIAL(2) = [FLOW_YOUNG, FLOW_PLATE]
    character(*), parameter :: NAMES = 'ED'
    type(failure_t) :: missing, failure
    character(:), allocatable :: reason, of_case
    integer :: j
    if (world%is_root) call data%response%take(steps, data%refined, records, missing)
    call broadcast_failure(world, missing, failure)
    if (failure%failed) then
      call outcome%fail(OUTCOME_NOT_CONVERGED, 'the flight of '//data%facts%path//' cannot be compared with the records: '// &
                        failure%reason)
      return
    end if
    do j = 1, N_FLOW
      reason = data%response%reason(j)
      call world%broadcast_text(reason)
      data%response%reason(j) = reason
    end do
    do j = 1, 2
      reason = trim(data%response%reason(MATERIAL(j)))
      if (world%is_root .and. data%facts%shares(j) .and. reason /= '') write (error_unit, '(a)') &
        'notice: the flights of '//data%facts%path//' do not follow '//NAMES(j:j)//' of the wing: '//reason
    end do
    reason = uncounted_errors(data%facts, data%response%reason)
    of_case = ''
    if (data%facts%label /= '') of_case = 'of '//data%facts%path//' '
    if (world%is_root .and. reason /= '') write (error_unit, '(a)') 'notice: '//of_case//'stated errors are not counted: '//reason
    if (.not. world%is_root .or. .not. any(data%refined)) return
    ! The largest root mean square over the beat, in percent of that of the component. Components below a hundredth of the largest
    ! force, or torque, do not count.
    if (of_case /= '') of_case = ' '//trim(of_case)
    write (output_unit, '(a)') 'numerics  change forces'//of_case//', in % of their rms: '// &
      list_text(data%refined, [(100*data%response%relative_size(j), j=1, N_REFINEMENTS)])
  end subroutine take_flights
end module diagnose_flight_settings

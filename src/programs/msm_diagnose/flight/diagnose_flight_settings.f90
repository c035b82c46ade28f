! SPDX-License-Identifier: GPL-3.0-or-later
!> Handles the section [Flight] of a diagnosis. It reads the case that simulates the experiment in which forces were recorded,
!> checks that the records fit the case, estimates the cost of the flights, and starts their simulation.
module diagnose_flight_settings
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_outcome, only: outcome_t, OUTCOME_NOT_CONVERGED
  use base_text, only: next_word, number_text, quoted
  use common_diagnose_keys, only: flight_choices_t, WALL_BELOW
  use common_wing_settings, only: find_beside
  use diagnose_flight_landmarks, only: rigid_places, take_marks
  use diagnose_flights, only: flusi_runner_t
  use diagnosis_flight_catalogue, only: exclude_unflown, flight_causes, flight_steps, uncounted_errors
  use diagnosis_flight_changes, only: FLOW_DEVIATION, FLOW_FREQUENCY, FLOW_LEAD, FLOW_PITCH, FLOW_PITCH_MEAN, FLOW_PLANE, &
                                      FLOW_STROKE, FLOW_STROKE_MEAN, is_of_flow, N_CHANGES, N_FLOW
  use diagnosis_flight_refinements, only: read_refinements, refinement_name, N_REFINEMENTS, NOT_REFINED, REFINE_BEATS, REFINE_BOX, &
                                          REFINE_GRID
  use diagnosis_flight_runner, only: flight_facts_t, flight_record_t, flight_request_t
  use diagnosis_wing_entries, only: catalogue_t
  use diagnosis_wing_flight, only: flight_data_t
  use io_config, only: config_t
  use io_suggest, only: suggestion_t
  use measurement_data, only: measurement_t
  use measurement_flight, only: COMPONENT_NAMES, COMPONENT_POWER, KINEMATIC_SD, N_KINEMATICS
  use parallel_failure, only: broadcast_failure
  use parallel_world, only: world_t
  implicit none
  private
  public :: fly_all, load_flights, print_cost, print_wing_cost

  real(rp), parameter :: SAME_FREQUENCY = 0.01_rp !< relative

contains

  !> Reads the case that the records of the measurement, or a comparison of two wings, need. Mistakes go to `errors` and remarks to
  !> `notices`. Collective.
  subroutine load_flights(config, c, measurement, world, runner, data, errors, notices)
    type(config_t), intent(in) :: config
    type(flight_choices_t), intent(in) :: c
    type(measurement_t), intent(in) :: measurement
    type(world_t), intent(in) :: world
    type(flusi_runner_t), intent(inout) :: runner
    type(flight_data_t), intent(inout) :: data
    type(message_list_t), intent(inout) :: errors, notices
    logical :: is_named(N_REFINEMENTS), has_records
    integer :: i
    has_records = measurement%count_flights() > 0
    if (.not. (has_records .or. c%compare)) return
    if (has_records .and. c%compare) call config%complain(errors, 'Flight', 'compare', &
      'must be left out: with /flight both flights are always compared')
    if (c%file == '') then
      if (has_records) then
        call config%complain(errors, 'Flight', 'file', 'is missing: the measurement holds records of a flight in /flight; '// &
                             'name the flusi case that simulates this experiment')
      else
        call config%complain(errors, 'Flight', 'file', 'is missing: compare = yes simulates this flusi case with two wings')
      end if
      return
    end if
    call check_effects(config, c%effects, errors)
    call take_refinements(config, c%refine, data%refined, is_named, errors)
    call load_case(config, c, world, runner, errors, notices)
    if (errors%count() > 0) return
    if (.not. has_records) then
      if (.not. runner%facts%is_flexible) call config%complain(errors, 'Flight', 'compare', &
        'needs a case whose wings bend, with [Insects] wings = flexible; in '//c%file//' they are rigid')
      data%refined = .false.
      data%facts = runner%facts
      return
    end if
    call take_marks(measurement, runner%case%settings, runner%facts%is_section, runner%case%marks, errors)
    if (errors%count() > 0) return
    runner%facts%rigid = rigid_places(runner%case%settings, runner%case%marks, c%beats)
    call runner%case%judge(data%refined, world, runner%facts)
    if (measurement%count_flights(has_landmarks=.false.) == 0 .and. .not. runner%facts%is_flexible) then
      where (is_of_flow([(i, i=1, N_FLOW)]) .and. runner%facts%missing == '') &
        runner%facts%missing = 'needs records of forces: landmarks on rigid wings do not show it'
    end if
    call drop_refinements(config, runner%facts, is_named, data%refined, errors, notices)
    call check_records(measurement, runner, errors)
    call take_kinematic_errors(measurement, runner%facts%prior_sd, errors)
    data%has_records = .true.
    data%facts = runner%facts
    data%effects = c%effects
    data%model_sd = c%model_sd
    data%response%n_harmonics = c%harmonics
    data%response%wind = runner%facts%wind
  end subroutine load_flights

  !> Reads the case of [Flight] and fills the facts of the runner. Mistakes go to `errors` and remarks to `notices`. Collective.
  subroutine load_case(config, c, world, runner, errors, notices)
    type(config_t), intent(in) :: config
    type(flight_choices_t), intent(in) :: c
    type(world_t), intent(in) :: world
    type(flusi_runner_t), intent(inout) :: runner
    type(message_list_t), intent(inout) :: errors, notices
    type(message_list_t) :: of_case, remarks
    character(:), allocatable :: path, problem
    integer :: i
    call find_beside(config%file_name(), c%file, path, problem, world)
    if (allocated(problem)) then
      call config%complain(errors, 'Flight', 'file', problem)
      return
    end if
    call runner%case%load(path, c%beats, world, of_case, remarks)
    do i = 1, of_case%count()
      call errors%add(of_case%text(i))
    end do
    if (of_case%count() > 0 .or. errors%count() > 0) return
    do i = 1, remarks%count()
      call notices%add('of [Flight] file: '//remarks%text(i))
    end do
    runner%folder = c%folder
    runner%ranks = c%ranks
    associate (length => runner%case%settings%units%length, omitted => runner%case%omitted)
      omitted%wall_distance = c%wall_distance/length
      omitted%wall_axis = merge(3, 2, c%wall_side == WALL_BELOW)
      omitted%body_length = c%body_length/length
      omitted%body_radius = c%body_radius/length
    end associate
    call runner%case%tell(runner%facts)
  end subroutine load_case

  !> Reads which numerical errors a flight of its own makes smaller, and which of them the user names. Adds a mistake for a word
  !> that is not a refinement.
  subroutine take_refinements(config, words, wanted, is_named, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: words
    logical, intent(out) :: wanted(N_REFINEMENTS), is_named(N_REFINEMENTS)
    type(message_list_t), intent(inout) :: errors
    type(suggestion_t) :: suggestion
    character(:), allocatable :: unknown, valid
    integer :: k
    call read_refinements(words, wanted, is_named, unknown)
    if (unknown == '') return
    valid = 'yes, all, no'
    call suggestion%start(unknown)
    do k = 1, N_REFINEMENTS
      valid = valid//', '//refinement_name(k)
      call suggestion%offer(refinement_name(k))
    end do
    call config%complain(errors, 'Flight', 'refine', 'there is no refinement '//quoted(unknown)//suggestion%hint()//'; valid: '// &
                         valid)
  end subroutine take_refinements

  !> Leaves out the refinements that the case does not permit. Adds a mistake for one that the user names, and a remark for one
  !> that changes forces much.
  subroutine drop_refinements(config, facts, is_named, refined, errors, notices)
    type(config_t), intent(in) :: config
    type(flight_facts_t), intent(in) :: facts
    logical, intent(in) :: is_named(N_REFINEMENTS)
    logical, intent(inout) :: refined(N_REFINEMENTS)
    type(message_list_t), intent(inout) :: errors, notices
    integer :: i
    do i = 1, N_REFINEMENTS
      if (.not. refined(i) .or. facts%unrefined(i) == '') cycle
      refined(i) = .false.
      if (is_named(i)) then
        call config%complain(errors, 'Flight', 'refine', 'names '//refinement_name(i)//', but the case cannot be flown so: '// &
                             trim(facts%unrefined(i)))
      else if (any(i == [REFINE_BOX, REFINE_BEATS])) then
        call notices%add('[Flight] refine leaves out '//refinement_name(i)//': '//trim(facts%unrefined(i))// &
                         '. Change the case, or allow for this error by [Flight] model_sd')
      end if
    end do
  end subroutine drop_refinements

  !> Adds a mistake for every name in `effects` that is not an effect of a flight.
  subroutine check_effects(config, effects, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: effects
    type(message_list_t), intent(inout) :: errors
    type(suggestion_t) :: suggestion
    character(:), allocatable :: valid
    integer :: position, first, last, at, begin, finish
    logical :: found, is_known
    valid = flight_causes()
    position = 1
    do
      call next_word(effects, ' ,', position, first, last, found)
      if (.not. found) return
      call suggestion%start(effects(first:last))
      is_known = .false.
      at = 1
      do
        call next_word(valid, ' ', at, begin, finish, found)
        if (.not. found) exit
        is_known = is_known .or. valid(begin:finish) == effects(first:last)
        call suggestion%offer(valid(begin:finish))
      end do
      if (.not. is_known) call config%complain(errors, 'Flight', 'effects', 'there is no effect '//quoted(effects(first:last))// &
                                               suggestion%hint()//'; valid: '//valid)
    end do
  end subroutine check_effects

  !> Adds a mistake for every record that does not belong to this case: another frequency of the beat, or components that the case
  !> does not have.
  subroutine check_records(measurement, runner, errors)
    type(measurement_t), intent(in) :: measurement
    type(flusi_runner_t), intent(in) :: runner
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: object
    integer :: r, k
    associate (facts => runner%facts)
      do r = 1, measurement%count_flights()
        associate (f => measurement%flights(r))
          object = '/flight/'//f%name
          if (any([(measurement%flights(k)%name == f%name, k=1, r - 1)])) cycle ! the landmarks of a flight that was checked
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
    end associate
  end subroutine check_records

  !> Takes the errors of the kinematics that records state as the prior sd of the changes. Adds a mistake if two records state
  !> different errors, because one case simulates all.
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
                            number_text(sd)//', but '//number_text(prior)//' in another record: one case simulates all '// &
                            'records, so that they share this error')
          prior = sd
        end associate
      end do
    end do
  end subroutine take_kinematic_errors

  !> Prints on `unit` how many flights are needed and how long they may take, and the same of `most_rounds` rounds with the fitted
  !> values that may follow. Not collective: rank 0 calls it.
  subroutine print_cost(unit, most_rounds, runner, data, world)
    integer, intent(in) :: unit, most_rounds
    type(flusi_runner_t), intent(inout) :: runner
    type(flight_data_t), intent(in) :: data
    type(world_t), intent(in) :: world
    type(flight_request_t), allocatable :: requests(:), of_round(:)
    logical, allocatable :: missing(:)
    real(rp) :: steps(size(data%response%is_known))
    logical :: of_grid(N_REFINEMENTS)
    integer :: ranks, n_groups
    steps = flight_steps(data%facts, data%effects)
    requests = data%response%requests(steps, data%refined)
    missing = runner%are_missing(requests)
    ranks = world%size
    if (runner%ranks > 0) ranks = min(ranks, runner%ranks)
    n_groups = world%size/ranks
    write (unit, '(a)') 'flights   '//number_text(size(requests))//' of '//data%facts%path//', of which '// &
      number_text(count(missing))//' are still to be simulated, '//number_text(n_groups)//' at a time on '// &
      number_text(ranks)//' ranks each'
    if (any(data%refined)) write (unit, '(a)') '          the case once, and with a smaller numerical error of each of these '// &
      'kinds (cost in flights of the case): '//list_text(data%refined, data%facts%cost)
    write (unit, '(a)') '          about '//number_text(nint(data%facts%steps))//' steps each, '// &
      time_text(seconds_of(data%facts, pack(requests%refinement, missing), n_groups)/ranks)//' for all, very roughly'
    if (most_rounds == 0 .or. size(requests) == 1 + count(data%refined)) return
    of_grid = .false.
    of_grid(REFINE_GRID) = data%refined(REFINE_GRID)
    of_round = data%response%requests(one_step(steps), of_grid)
    write (unit, '(a)') '          then up to '//number_text(most_rounds)//' rounds if a cause is clear, each of '// &
      trim(merge('2 flights', '1 flight ', of_grid(REFINE_GRID)))//' with the fitted values and up to 2 more for each of its '// &
      'parameters: '//time_text(seconds_of(data%facts, of_round%refinement, n_groups)/ranks)//' with one parameter'
  end subroutine print_cost

  !> Prints on `unit` how many flights the comparison of two wings needs at most, and how long they may take. Not collective.
  subroutine print_wing_cost(unit, directions, runner, facts, world)
    integer, intent(in) :: unit, directions
    type(flusi_runner_t), intent(in) :: runner
    type(flight_facts_t), intent(in) :: facts
    type(world_t), intent(in) :: world
    integer :: ranks
    ranks = world%size
    if (runner%ranks > 0) ranks = min(ranks, runner%ranks)
    associate (n => 2 + 2*directions)
      write (unit, '(a)') 'flights   after the diagnosis, if a cause is found: '//facts%path//' with both wings, and up to '// &
        number_text(2*directions)//' times for what the fit leaves of the extended wing', &
        '          about '//number_text(nint(facts%steps))//' steps each, '// &
        time_text(seconds_of(facts, spread(NOT_REFINED, 1, n), world%size/ranks)/ranks)//' for the flow of all '// &
        number_text(n)//', very roughly; the bending of the wings comes on top'
    end associate
    flush (unit)
  end subroutine print_wing_cost

  !> Returns the first of the steps that are above 0 alone.
  pure function one_step(steps)
    real(rp), intent(in) :: steps(:)
    real(rp) :: one_step(size(steps))
    integer :: first
    one_step = 0
    first = findloc(steps > 0, .true., 1)
    if (first > 0) one_step(first) = steps(first)
  end function one_step

  !> Returns how long flights take on one rank [s], if groups of ranks take turns in simulating them. A refined flight takes longer.
  pure real(rp) function seconds_of(facts, refinement, n_groups) result(seconds)
    type(flight_facts_t), intent(in) :: facts
    integer, intent(in) :: refinement(:) !< of each flight, NOT_REFINED for the case
    integer, intent(in) :: n_groups
    real(rp) :: busy(0:n_groups - 1)
    integer :: i
    busy = 0
    do i = 1, size(refinement)
      associate (own => busy(modulo(i - 1, n_groups)))
        if (refinement(i) == NOT_REFINED) then
          own = own + facts%seconds
        else
          own = own + facts%seconds*facts%cost(refinement(i))
        end if
      end associate
    end do
    seconds = maxval(busy)
  end function seconds_of

  !> Returns the names of the wanted refinements, each with its value in one decimal.
  function list_text(wanted, values) result(text)
    logical, intent(in) :: wanted(N_REFINEMENTS)
    real(rp), intent(in) :: values(N_REFINEMENTS)
    character(:), allocatable :: text
    integer :: k
    text = ''
    do k = 1, N_REFINEMENTS
      if (.not. wanted(k)) cycle
      if (text /= '') text = text//', '
      text = text//refinement_name(k)//' '//number_text(nint(10*values(k))/10.0_rp)
    end do
  end function list_text

  !> Returns a duration, rounded up, in seconds, minutes or hours.
  function time_text(seconds) result(text)
    real(rp), intent(in) :: seconds
    character(:), allocatable :: text
    if (seconds < 120) then
      text = number_text(ceiling(seconds))//' s'
    else if (seconds < 7200) then
      text = number_text(ceiling(seconds/60))//' min'
    else
      text = number_text(ceiling(seconds/3600))//' h'
    end if
  end function time_text

  !> Simulates the flights that are needed and stores what they show in `data`. Effects that need a flight that failed are
  !> excluded from the catalogue. If the flight of the case itself failed, `failure` says why on all ranks. Collective.
  subroutine fly_all(world, runner, data, catalogue, outcome)
    type(world_t), intent(in) :: world
    type(flusi_runner_t), intent(inout) :: runner
    type(flight_data_t), intent(inout) :: data
    type(catalogue_t), intent(inout) :: catalogue
    type(outcome_t), intent(inout) :: outcome
    type(flight_record_t), allocatable :: records(:)
    type(failure_t) :: missing, failure
    character(:), allocatable :: reason
    real(rp) :: steps(size(data%response%is_known))
    integer :: j
    steps = flight_steps(data%facts, data%effects)
    call runner%fly(world, data%response%requests(steps, data%refined), records, outcome)
    if (.not. outcome%is_good()) return
    if (world%is_root) call data%response%take(steps, data%refined, records, missing)
    call broadcast_failure(world, missing, failure)
    if (failure%failed) then
      call outcome%fail(OUTCOME_NOT_CONVERGED, 'the flight of '//data%facts%path//' cannot be compared with the records: '// &
                        failure%reason)
      return
    end if
    do j = 1, size(steps)
      reason = data%response%reason(j)
      call world%broadcast_text(reason)
      data%response%reason(j) = reason
    end do
    call exclude_unflown(catalogue, data%facts, data%response%reason)
    data%is_ready = .true.
    reason = uncounted_errors(data%facts, data%response%reason)
    if (world%is_root .and. reason /= '') write (error_unit, '(a)') 'notice: stated errors are not counted: '//reason
    if (.not. world%is_root .or. .not. any(data%refined)) return
    ! The largest root mean square over the beat, in percent of that of the component. Components below a hundredth of the largest
    ! force, or torque, do not count.
    write (output_unit, '(a)') 'numerics  change forces, in % of their rms: '// &
      list_text(data%refined, [(100*data%response%relative_size(j), j=1, N_REFINEMENTS)])
  end subroutine fly_all
end module diagnose_flight_settings

! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the entries of the catalogue that records over the beat can show: errors of the kinematics and of the flow and, if there
!> are forces, of the force balance. Without such records the catalogue has none of these entries.
module diagnosis_flight_catalogue
  use base_cause, only: cause_t
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use diagnosis_flight_changes, only: cause_of_change, change_parameter, change_scales_t, is_of_material, is_of_wing, &
                                      is_one_sided, list_change_causes, FLOW_FREQUENCY, FLOW_PLATE, &
                                      FLOW_STRUCTURE, FLOW_VISCOSITY, FLOW_WIND, FLOW_YOUNG, is_of_structure, N_CHANGES, N_FLOW, &
                                      NEED_RIGID
  use diagnosis_flight_data, only: change_t, flight_data_t
  use diagnosis_flight_runner, only: flight_facts_t
  use diagnosis_flight_structure, only: is_wanted, structure_step
  use diagnosis_wing_entries, only: append_variant, catalogue_t
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_BALANCE, KIND_FLIGHT
  use inference_simulator, only: variant_t
  use measurement_balance_causes, only: balance_scales_t, cross_components, list_balance_causes, BALANCE_OFFSET, BALANCE_TURN, &
                                        NEED_FORCES
  use measurement_flight, only: measured_flight_t, N_COMPONENTS
  implicit none
  private
  public :: enter_flights, exclude_unflown, flight_steps, rounded, flight_causes, stated_errors, uncounted_errors

contains

  !> Returns the step of each change, in its unit: the two flights for a change lie one step above and one step below the flight
  !> about which forces are approximated. It is 0, and no flight is made, if no effect in the list `wanted` needs the change and
  !> no record states its error, or if the case cannot make it. An empty `wanted` means all effects.
  !>
  !> Before the first flights the effect of a change is not known, and the step is its prior sd. Once the data have determined a
  !> change to sd(j), forces are needed over that range, and the step is STEP sd(j): forces then change by STEP times their noise.
  !> What a case leaves out keeps the prior sd as its step: a wall is sharp, so that a small step may not move it to other points.
  !> The step is never larger than the prior sd. It is never smaller than LEAST_STEP times the prior sd, where the difference of two
  !> flights would come near their own errors. It has one digit, so that data that differ little need the same flights. A change
  !> with sd(j) = 0 gets no step. For parameters of the structure structure_step takes the place of the prior sd.
  pure function flight_steps(facts, wanted, sd) result(steps)
    type(flight_facts_t), intent(in) :: facts
    character(*), intent(in) :: wanted
    real(rp), intent(in), optional :: sd(N_FLOW)
    real(rp) :: steps(N_FLOW)
    real(rp), parameter :: STEP = 2.0_rp, LEAST_STEP = 0.1_rp
    type(parameter_t) :: p
    real(rp) :: largest
    logical :: is_needed(N_CHANGES)
    integer :: j, n
    steps = 0
    is_needed = stated_errors(facts) > 0
    do j = 1, N_CHANGES
      if (.not. is_of_structure(j)) is_needed(j) = is_needed(j) .or. is_wanted(wanted, cause_of_change(j))
    end do
    n = facts%n_first
    if (present(sd) .and. allocated(facts%structure)) n = size(facts%structure)
    is_needed(FLOW_STRUCTURE + 1:FLOW_STRUCTURE + n) = .true.
    if (.not. facts%is_alone) is_needed([FLOW_YOUNG, FLOW_PLATE]) = facts%shares
    do j = 1, N_FLOW
      if (facts%missing(j) /= '') cycle
      if (.not. (is_needed(j) .or. is_needed(FLOW_FREQUENCY) .and. &
                 (j == FLOW_VISCOSITY .or. j > FLOW_WIND .and. j <= FLOW_WIND + 3 .and. norm2(facts%wind) > 0))) cycle
      if (is_of_structure(j)) then
        largest = structure_step(facts%structure(j - FLOW_STRUCTURE))
      else
        p = change_parameter(j, scales_of(facts))
        largest = p%prior_sd
      end if
      steps(j) = largest
      if (.not. present(sd)) cycle
      if (sd(j) > 0 .and. .not. is_one_sided(j)) &
        steps(j) = min(largest, max(rounded(STEP*sd(j), STEP*sd(j)), LEAST_STEP*largest))
      if (.not. sd(j) > 0) steps(j) = 0
    end do
  end function flight_steps

  !> Returns the error that records state of each change, one sd of its coordinate. It is 0 where none is stated or where the case
  !> cannot make the change.
  pure function stated_errors(facts) result(sd)
    type(flight_facts_t), intent(in) :: facts
    real(rp) :: sd(N_CHANGES)
    type(parameter_t) :: p
    integer :: j
    sd = 0
    do j = 1, N_CHANGES
      if (.not. facts%prior_sd(j) > 0 .or. first_reason(j, facts, facts%missing) /= '') cycle
      if (j == FLOW_FREQUENCY .and. facts%is_flexible) cycle
      p = change_parameter(j, scales_of(facts))
      sd(j) = p%prior_sd
    end do
  end function stated_errors

  !> Returns the names of the changes whose stated errors are not among the errors of the data, each with the reason: the case
  !> cannot make the change, or its flights failed for `reason`. Empty if all stated errors count.
  pure function uncounted_errors(facts, reason) result(text)
    type(flight_facts_t), intent(in) :: facts
    character(*), intent(in) :: reason(N_FLOW)
    character(:), allocatable :: text, why
    integer :: j
    text = ''
    do j = 1, N_CHANGES
      if (.not. facts%prior_sd(j) > 0) cycle
      why = first_reason(j, facts, facts%missing)
      if (why == '') why = first_reason(j, facts, reason)
      if (why == '' .and. j == FLOW_FREQUENCY .and. facts%is_flexible) why = 'the wings bend'
      if (why == '') cycle
      if (text /= '') text = text//'; '
      text = text//cause_of_change(j)//' ('//why//')'
    end do
  end function uncounted_errors

  !> Returns the multiple nearest to x of the power of ten that begins `scale`, which is above 0.
  pure elemental real(rp) function rounded(x, scale)
    real(rp), intent(in) :: x, scale
    real(rp) :: unit
    unit = 10.0_rp**floor(log10(scale))
    rounded = nint(x/unit)*unit
  end function rounded

  !> Returns what the changes of a case depend on.
  pure function scales_of(facts) result(scales)
    type(flight_facts_t), intent(in) :: facts
    type(change_scales_t) :: scales
    scales%speed = facts%speed
    scales%is_section = facts%is_section
    scales%prior_sd = facts%prior_sd
  end function scales_of

  !> Returns the names of all causes that records of forces can show, separated by blanks.
  pure function flight_causes() result(names)
    character(:), allocatable :: names
    type(change_scales_t) :: of_changes
    type(balance_scales_t) :: of_balance
    names = names_of(list_change_causes(of_changes))//names_of(list_balance_causes(of_balance))
    names = names(2:)

  contains

    pure function names_of(list) result(text)
      type(cause_t), intent(in) :: list(:)
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(list)
        text = text//' '//list(i)%name
      end do
    end function names_of

  end function flight_causes

  !> Adds to the catalogue all effects in the list `wanted` that records of forces can show. An empty `wanted` means all effects.
  !> `flights` are all records.
  subroutine enter_flights(c, cases, flights, wanted)
    type(catalogue_t), intent(inout) :: c
    type(flight_data_t), intent(in) :: cases(:)
    type(measured_flight_t), intent(in) :: flights(:)
    character(*), intent(in) :: wanted
    type(cause_t), allocatable :: list(:)
    type(change_scales_t) :: scales
    integer :: i
    scales = scales_of(cases(1)%facts)
    scales%speed = maxval(cases%facts%speed)
    list = list_change_causes(scales)
    do i = 1, size(list)
      if (is_of_material(list(i)%parameters(1)%number) .and. .not. all(cases%facts%is_alone)) cycle ! `enter_structure` enters them
      if (is_wanted(wanted, list(i)%name)) call enter_changes(c, list(i), cases)
    end do
    call enter_balance(c, cases(1)%facts, flights, wanted)
  end subroutine enter_flights

  !> Returns why the flights that change j needs cannot be made: the first such reason in reasons(N_FLOW), or an empty text. A
  !> beat of another frequency needs the flights with another viscosity and, if the case has wind, those with another wind.
  pure function first_reason(j, facts, reasons) result(reason)
    integer, intent(in) :: j
    type(flight_facts_t), intent(in) :: facts
    character(*), intent(in) :: reasons(N_FLOW)
    character(:), allocatable :: reason
    integer :: i
    if (j /= FLOW_FREQUENCY) then
      reason = trim(reasons(j))
      return
    end if
    reason = trim(reasons(FLOW_VISCOSITY))
    do i = 1, 3
      if (reason == '' .and. abs(facts%wind(i)) > 0) reason = trim(reasons(FLOW_WIND + i))
    end do
  end function first_reason

  !> Excludes from the test what needs a flight that failed: variants and, if none is left, effects. Other data of the wing show
  !> causes of the structure without flights.
  subroutine exclude_unflown(c, cases)
    type(catalogue_t), intent(inout) :: c
    type(flight_data_t), intent(in) :: cases(:)
    type(variant_t), allocatable :: left(:)
    character(:), allocatable :: missing
    logical, allocatable :: is_flown(:)
    type(change_t) :: change
    integer :: e, v, k, n
    do e = 1, size(c%effects)
      if (c%effects(e)%missing /= '' .or. size(c%effects(e)%variants) == 0) cycle
      associate (variants => c%effects(e)%variants)
        allocate (is_flown(size(variants)), source=.true.)
        missing = ''
        do v = 1, size(variants)
          do k = 1, size(variants(v)%columns)
            associate (p => c%parameters(variants(v)%columns(k)))
              change = change_t(p%number)
              if (p%kind /= KIND_FLIGHT) change = cases(1)%change_by(p)
              if (p%kind /= KIND_FLIGHT .and. .not. cases(1)%facts%is_alone .or. change%number == 0) cycle
              if (why_unflown(change%number, p%record) == '') cycle
              is_flown(v) = .false.
              missing = why_unflown(change%number, p%record)
            end associate
          end do
        end do
        allocate (left(count(is_flown)))
        n = 0
        do v = 1, size(variants)
          if (.not. is_flown(v)) cycle
          n = n + 1
          left(n) = variants(v)
        end do
      end associate
      if (size(left) == 0) c%effects(e)%missing = missing
      if (size(left) > 0) call move_alloc(left, c%effects(e)%variants)
      if (allocated(left)) deallocate (left)
      deallocate (is_flown)
    end do

  contains

    !> Returns why the flights of change j of a case failed, or of any case if `number` is 0. Empty if they did not.
    pure function why_unflown(j, number) result(why)
      integer, intent(in) :: j, number
      character(:), allocatable :: why
      integer :: i
      why = ''
      do i = 1, size(cases)
        if (any(number == [0, i]) .and. why == '') why = first_reason(j, cases(i)%facts, cases(i)%response%reason)
      end do
    end function why_unflown

  end subroutine exclude_unflown

  !> Enters a cause whose parameters are changes, which are fitted together. With several cases a cause acts on all of them or,
  !> unless the wing itself has it, on one of them alone.
  subroutine enter_changes(c, cause, cases)
    type(catalogue_t), intent(inout) :: c
    type(cause_t), intent(in) :: cause
    type(flight_data_t), intent(in) :: cases(:)
    type(variant_t), allocatable :: variants(:)
    character(:), allocatable :: missing, why
    integer :: k, n
    call require(all(cause%needs == NEED_RIGID), 'diagnosis_flight_catalogue: an unknown need of '//cause%name)
    allocate (variants(0))
    n = size(cases)
    if (n == 1 .or. is_of_wing(cause%parameters(1)%number)) n = 0
    missing = ''
    do k = 0, n
      why = why_not(cause, cases, k)
      if (k == 0) missing = why
      if (why == '') call append_changes(c, cause, cases, k, variants)
    end do
    if (size(variants) > 0) missing = ''
    if (size(variants) == 0) call append_changes(c, cause, cases, 0, variants)
    call c%enter(cause, missing, variants)
  end subroutine enter_changes

  !> Appends the changes of all cases (0), or those of case `number` alone, to the variants of a cause.
  subroutine append_changes(c, cause, cases, number, variants)
    type(catalogue_t), intent(inout) :: c
    type(cause_t), intent(in) :: cause
    type(flight_data_t), intent(in) :: cases(:)
    integer, intent(in) :: number
    type(variant_t), allocatable, intent(inout) :: variants(:)
    type(wing_parameter_t) :: p
    character(:), allocatable :: label
    integer, allocatable :: columns(:)
    integer :: k
    allocate (columns(0))
    do k = 1, size(cause%parameters)
      associate (one => cause%parameters(k))
        if (.not. one%is_tried) cycle
        p = wing_parameter(one%value%as_coordinate(one%value%null), KIND_FLIGHT, one%number)
        p%record = number
        columns = [columns, c%add(p)]
      end associate
    end do
    label = ''
    if (number > 0) label = cases(number)%facts%label
    call append_variant(variants, label, columns(1), [0.0_rp, 0.0_rp])
    variants(size(variants))%columns = columns
  end subroutine append_changes

  !> Returns why all cases together (0), or case `number`, cannot make the changes of a cause; empty if they can.
  pure function why_not(cause, cases, number) result(why)
    type(cause_t), intent(in) :: cause
    type(flight_data_t), intent(in) :: cases(:)
    integer, intent(in) :: number
    character(:), allocatable :: why
    integer :: i, k
    why = ''
    do i = 1, size(cases)
      if (all(number /= [0, i])) cycle
      do k = 1, size(cause%parameters)
        if (why == '' .and. cause%parameters(k)%is_tried) &
          why = first_reason(cause%parameters(k)%number, cases(i)%facts, cases(i)%facts%missing)
      end do
      if (why == '' .and. any(cause%needs == NEED_RIGID) .and. cases(i)%facts%is_flexible) why = 'needs wings that do not bend'
    end do
  end function why_not

  !> Enters the errors of the force balance that are wanted and that the records can show.
  subroutine enter_balance(c, facts, flights, wanted)
    type(catalogue_t), intent(inout) :: c
    type(flight_facts_t), intent(in) :: facts
    type(measured_flight_t), intent(in) :: flights(:)
    character(*), intent(in) :: wanted
    type(balance_scales_t) :: scales
    type(cause_t), allocatable :: list(:)
    type(variant_t), allocatable :: variants(:)
    logical :: is_there(N_COMPONENTS)
    integer, allocatable :: columns(:)
    integer :: i, k
    call find_sizes(facts, flights, scales%sizes, is_there, scales%mass)
    if (.not. any(is_there)) return
    scales%period = 1/facts%frequency
    scales%is_per_length = facts%is_section
    list = list_balance_causes(scales)
    do i = 1, size(list)
      if (.not. is_wanted(wanted, list(i)%name)) cycle
      call require(all(list(i)%needs == NEED_FORCES), 'diagnosis_flight_catalogue: an unknown need of '//list(i)%name)
      if (any(list(i)%needs == NEED_FORCES) .and. .not. any(is_there(:6))) cycle
      allocate (columns(0), variants(0))
      do k = 1, size(list(i)%parameters)
        associate (one => list(i)%parameters(k))
          if (.not. shows(one%number, is_there, facts%is_section)) cycle
          columns = [columns, c%add(wing_parameter(one%value%as_coordinate(one%value%null), KIND_BALANCE, one%number))]
        end associate
      end do
      if (size(columns) > 0) then
        call append_variant(variants, '', columns(1), [0.0_rp, 0.0_rp])
        variants(1)%columns = columns
        call c%enter(list(i), '', variants)
      end if
      deallocate (columns, variants)
    end do
  end subroutine enter_balance

  !> Tells whether records of these components can show parameter `number` of the balance. Flights of a section have only the
  !> forces 2 and 3, and a section feels turns about x alone.
  pure logical function shows(number, is_there, is_section)
    integer, intent(in) :: number
    logical, intent(in) :: is_there(N_COMPONENTS), is_section
    integer :: pair(2)
    shows = .true.
    pair = cross_components(number)
    if (any(pair > 0)) then
      shows = is_there(pair(1)) .and. (.not. is_section .or. any(pair(2) == [2, 3]))
    else if (number > BALANCE_OFFSET .and. number <= BALANCE_OFFSET + N_COMPONENTS) then
      shows = is_there(number - BALANCE_OFFSET)
    else if (number > BALANCE_TURN .and. number <= BALANCE_TURN + 3) then
      shows = .not. is_section .or. number == BALANCE_TURN + 1
    end if
  end function shows

  !> Returns for each component its largest root mean square over the beat in any record, in its unit, and whether it was measured
  !> at all. `mass` is the mass of the wings [kg, or kg/m for a section] whose inertia is a tenth of the forces.
  pure subroutine find_sizes(facts, flights, sizes, is_there, mass)
    type(flight_facts_t), intent(in) :: facts
    type(measured_flight_t), intent(in) :: flights(:)
    real(rp), intent(out) :: sizes(N_COMPONENTS), mass
    logical, intent(out) :: is_there(N_COMPONENTS)
    real(rp) :: acceleration
    integer :: r, k, first
    sizes = 0
    is_there = .false.
    do r = 1, size(flights)
      if (flights(r)%side > 0) cycle
      do k = 1, size(flights(r)%component)
        associate (i => flights(r)%component(k), f => flights(r))
          is_there(i) = .true.
          sizes(i) = max(sizes(i), sqrt(sum(f%mean(:, k)**2, f%is_known(:, k))/count(f%is_known(:, k))))
        end associate
      end do
    end do
    sizes = max(sizes, tiny(1.0_rp)**0.25_rp)
    first = merge(1, 4, any(is_there(:3))) ! of forces, or of torques if there are no forces
    acceleration = sqrt(sum(facts%inertia(:, first:first + 2)**2)/size(facts%inertia, 1))
    mass = 0.1_rp*maxval(sizes(first:first + 2))/max(acceleration, tiny(1.0_rp)**0.25_rp)
  end subroutine find_sizes
end module diagnosis_flight_catalogue

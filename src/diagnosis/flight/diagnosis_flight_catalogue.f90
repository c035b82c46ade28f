! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the entries of the catalogue that records of forces over the beat can show: errors of the kinematics, of the flow and of
!> the force balance. A separate procedure enters each of these groups. Without such records the catalogue has none of these
!> entries.
module diagnosis_flight_catalogue
  use base_kinds, only: rp
  use base_parameter, only: define_effect, parameter_t
  use base_text, only: next_word, quoted
  use diagnosis_flight_response, only: FLOW_FREQUENCY, N_CHANGES
  use diagnosis_flight_runner, only: flight_facts_t, FLOW_DEVIATION, FLOW_LEAD, FLOW_PITCH, FLOW_PITCH_MEAN, FLOW_PLANE, &
                                     FLOW_STROKE, FLOW_STROKE_MEAN, FLOW_VISCOSITY, FLOW_WIND, N_FLOW
  use diagnosis_wing_entries, only: append_variant, catalogue_t
  use diagnosis_wing_parameters, only: wing_parameter, KIND_BALANCE, KIND_FLIGHT
  use inference_simulator, only: variant_t
  use measurement_balance, only: cross_number, describe_balance, BALANCE_DELAY, BALANCE_GAIN, BALANCE_LOWPASS, BALANCE_MASS, &
                                 BALANCE_OFFSET, BALANCE_TURN
  use measurement_flight, only: measured_flight_t, N_COMPONENTS
  implicit none
  private
  public :: enter_flights, exclude_unflown, flight_steps, rounded, FLIGHT_EFFECTS

  character(*), parameter :: FLIGHT_EFFECTS = 'stroke_amplitude stroke_mean pitch_amplitude pitch_mean pitch_lead '// &
    'deviation_amplitude stroke_plane beat_frequency wind viscosity balance_gain balance_offset balance_turn cross_talk '// &
    'balance_lowpass balance_delay wing_inertia'
  real(rp), parameter :: WIND_SD = 0.05_rp !< of the speed of the tip

contains

  !> Returns the step of each change, in its unit: the two flights for a change lie one step above and one step below the flight
  !> about which forces are approximated. It is 0, and no flight is made, if no effect in the list `wanted` needs the change or
  !> if the case cannot make it. An empty `wanted` means all effects.
  !>
  !> About the case nobody knows yet what a change does, and the step is its prior sd. Once the data have determined a change to
  !> sd(j), forces are needed where the data leave it, and the step is STEP sd(j): forces then change by STEP times their noise. It
  !> is never larger than the prior sd, and never smaller than LEAST_STEP times that, where the difference of two flights would come
  !> near the errors that both have by themselves. It has one digit, so that data that differ little need the same flights. A change
  !> with sd(j) = 0 gets no step.
  pure function flight_steps(facts, wanted, sd) result(steps)
    type(flight_facts_t), intent(in) :: facts
    character(*), intent(in) :: wanted
    real(rp), intent(in), optional :: sd(N_FLOW)
    real(rp) :: steps(N_FLOW)
    real(rp), parameter :: STEP = 2.0_rp, LEAST_STEP = 0.1_rp
    type(parameter_t) :: p
    integer :: j
    steps = 0
    do j = 1, N_FLOW
      if (facts%missing(j) /= '') cycle
      if (.not. (is_wanted(wanted, effect_of(j)) .or. &
                 is_wanted(wanted, 'beat_frequency') .and. (j == FLOW_VISCOSITY .or. j > FLOW_WIND .and. j <= FLOW_WIND + 3 .and. &
                                                            norm2(facts%wind) > 0))) cycle
      p = flow_parameter(j, facts)
      steps(j) = p%prior_sd
      if (.not. present(sd)) cycle
      if (sd(j) > 0) steps(j) = min(p%prior_sd, max(rounded(STEP*sd(j), STEP*sd(j)), LEAST_STEP*p%prior_sd))
      if (.not. sd(j) > 0) steps(j) = 0
    end do
  end function flight_steps

  !> Returns the multiple nearest to x of the power of ten that begins `scale`, which is above 0.
  pure elemental real(rp) function rounded(x, scale)
    real(rp), intent(in) :: x, scale
    real(rp) :: unit
    unit = 10.0_rp**floor(log10(scale))
    rounded = nint(x/unit)*unit
  end function rounded

  !> Tells whether a list of names has this one; an empty list has all.
  pure logical function is_wanted(wanted, name)
    character(*), intent(in) :: wanted, name
    integer :: position, first, last
    logical :: found
    is_wanted = wanted == ''
    position = 1
    do
      call next_word(wanted, ' ,', position, first, last, found)
      if (.not. found) return
      is_wanted = is_wanted .or. wanted(first:last) == name
    end do
  end function is_wanted

  !> Returns the name of the effect to which change j belongs.
  pure function effect_of(j) result(name)
    integer, intent(in) :: j
    character(:), allocatable :: name
    character(19), parameter :: NAMES(N_CHANGES) = [character(19) :: 'stroke_amplitude', 'stroke_mean', 'pitch_amplitude', &
                                                    'pitch_mean', 'pitch_lead', 'deviation_amplitude', 'stroke_plane', 'wind', &
                                                    'wind', 'wind', 'viscosity', 'beat_frequency']
    name = trim(NAMES(j))
  end function effect_of

  !> Returns change j of the kinematics or the flow as a parameter. Its coordinate is 0 for the case as it is.
  pure function flow_parameter(j, facts) result(p)
    integer, intent(in) :: j
    type(flight_facts_t), intent(in) :: facts
    type(parameter_t) :: p
    type(parameter_t) :: q
    character(*), parameter :: AXES = 'xyz'
    select case (j)
    case (FLOW_STROKE, FLOW_PITCH, FLOW_DEVIATION)
      call define_effect(q, effect_of(j), '1', .false., -0.4_rp, 0.4_rp, 0.05_rp)
    case (FLOW_STROKE_MEAN, FLOW_PITCH_MEAN, FLOW_PLANE)
      call define_effect(q, effect_of(j), 'degree', .false., -20.0_rp, 20.0_rp, 3.0_rp)
    case (FLOW_LEAD)
      call define_effect(q, effect_of(j), 'beat', .false., -0.2_rp, 0.2_rp, 0.02_rp)
    case (FLOW_WIND + 1:FLOW_WIND + 3)
      call define_effect(q, 'wind:'//AXES(j - FLOW_WIND:j - FLOW_WIND), 'm/s', .false., -0.5_rp*facts%speed, &
                         0.5_rp*facts%speed, WIND_SD*facts%speed)
    case (FLOW_VISCOSITY)
      call define_effect(q, effect_of(j), '1', .true., 0.5_rp, 2.0_rp, 0.05_rp)
    case default
      call define_effect(q, effect_of(j), '1', .true., 0.7_rp, 1.4_rp, 0.05_rp)
    end select
    p = q%as_coordinate(q%null)
  end function flow_parameter

  !> Adds to the catalogue all effects in the list `wanted` that records of forces can show. An empty `wanted` means all effects.
  subroutine enter_flights(c, facts, flights, wanted)
    type(catalogue_t), intent(inout) :: c
    type(flight_facts_t), intent(in) :: facts
    type(measured_flight_t), intent(in) :: flights(:)
    character(*), intent(in) :: wanted
    call enter_kinematics(c, facts, wanted)
    call enter_flow(c, facts, wanted)
    call enter_balance(c, facts, flights, wanted)
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

  !> Excludes from the test every effect that needs a flight that failed. `reason(j)` says why the flights of change j failed; it
  !> is empty if they did not fail.
  subroutine exclude_unflown(c, facts, reason)
    type(catalogue_t), intent(inout) :: c
    type(flight_facts_t), intent(in) :: facts
    character(*), intent(in) :: reason(N_FLOW)
    character(:), allocatable :: why
    integer :: e, k, j
    do e = 1, size(c%effects)
      if (c%effects(e)%missing /= '' .or. size(c%effects(e)%variants) == 0) cycle
      associate (columns => c%effects(e)%variants(1)%columns)
        do k = 1, size(columns)
          if (c%parameters(columns(k))%kind /= KIND_FLIGHT) cycle
          j = c%parameters(columns(k))%number
          why = first_reason(j, facts, reason)
          if (why /= '') c%effects(e)%missing = why
        end do
      end associate
    end do
  end subroutine exclude_unflown

  !> Enters the changes of the kinematics that are wanted.
  subroutine enter_kinematics(c, facts, wanted)
    type(catalogue_t), intent(inout) :: c
    type(flight_facts_t), intent(in) :: facts
    character(*), intent(in) :: wanted
    call one(FLOW_STROKE, 'stroke of another amplitude', 'The wing swept farther, or less far, than the kinematics say.')
    call one(FLOW_STROKE_MEAN, 'stroke about another mean angle', 'The stroke lay farther forward or back than the kinematics say.')
    call one(FLOW_PITCH, 'pitch of another amplitude', 'The wing turned about its long axis more, or less, than the '// &
             'kinematics say.')
    call one(FLOW_PITCH_MEAN, 'pitch about another mean angle', 'The wing was pitched by a constant angle against the kinematics.')
    call one(FLOW_LEAD, 'pitch at another time', 'The wing turned about its long axis earlier, or later, in the beat than the '// &
             'kinematics say.')
    call one(FLOW_DEVIATION, 'deviation of another amplitude', 'The wing left the stroke plane more, or less, than the '// &
             'kinematics say.')
    call one(FLOW_PLANE, 'another stroke plane', 'The stroke plane was tilted against that of the kinematics.')
    call one(FLOW_FREQUENCY, 'another beat frequency', 'The wing beat faster, or slower, than was stated.')

  contains

    !> Enters change `j` of the flow as an effect.
    subroutine one(j, title, sentence)
      integer, intent(in) :: j
      character(*), intent(in) :: title, sentence
      call enter_changes(c, [j], title, sentence, facts, wanted)
    end subroutine one

  end subroutine enter_kinematics

  !> Enters wind and viscosity if they are wanted.
  subroutine enter_flow(c, facts, wanted)
    type(catalogue_t), intent(inout) :: c
    type(flight_facts_t), intent(in) :: facts
    character(*), intent(in) :: wanted
    integer :: j
    call enter_changes(c, pack([(j, j=FLOW_WIND + 1, FLOW_WIND + 3)], mask=.not. (facts%is_section .and. &
                                                                             [.true., .false., .false.])), &
                       'wind', 'The air moved against the wing as a whole.', facts, wanted)
    call enter_changes(c, [FLOW_VISCOSITY], 'another viscosity', 'The fluid was more, or less, viscous than was stated: its '// &
                       'temperature differs.', facts, wanted)
  end subroutine enter_flow

  !> Adds one effect whose parameters are the changes `numbers`, which are fitted together.
  subroutine enter_changes(c, numbers, title, sentence, facts, wanted)
    type(catalogue_t), intent(inout) :: c
    integer, intent(in) :: numbers(:)
    character(*), intent(in) :: title, sentence
    type(flight_facts_t), intent(in) :: facts
    character(*), intent(in) :: wanted
    type(variant_t), allocatable :: variants(:)
    integer, allocatable :: columns(:)
    character(:), allocatable :: missing
    integer :: k, j
    if (.not. is_wanted(wanted, effect_of(numbers(1)))) return
    allocate (columns(size(numbers)), variants(0))
    missing = ''
    do k = 1, size(numbers)
      j = numbers(k)
      columns(k) = c%add(wing_parameter(flow_parameter(j, facts), KIND_FLIGHT, j))
      if (missing == '') missing = first_reason(j, facts, facts%missing)
      if (missing == '' .and. j == FLOW_FREQUENCY .and. facts%is_flexible) missing = 'needs wings that do not bend'
    end do
    call append_variant(variants, '', columns(1), [0.0_rp, 0.0_rp])
    variants(1)%columns = columns
    call c%enter(effect_of(numbers(1)), title, sentence, .false., missing, variants)
  end subroutine enter_changes

  !> Enters the errors of the force balance that are wanted and that the records can show.
  subroutine enter_balance(c, facts, flights, wanted)
    type(catalogue_t), intent(inout) :: c
    type(flight_facts_t), intent(in) :: facts
    type(measured_flight_t), intent(in) :: flights(:)
    character(*), intent(in) :: wanted
    logical :: is_there(N_COMPONENTS), turns(3)
    real(rp) :: sizes(N_COMPONENTS), mass
    integer, allocatable :: pairs(:)
    integer :: i, j
    turns = .true. ! a section feels turns about x alone
    if (facts%is_section) turns(2:3) = .false.
    call find_sizes(facts, flights, sizes, is_there, mass)
    allocate (pairs(0))
    do i = 1, 6
      do j = 3*((i - 1)/3) + 1, 3*((i - 1)/3) + 3
        if (i /= j .and. is_there(i) .and. is_flown(j)) pairs = [pairs, cross_number(i, j)]
      end do
    end do
    call one('balance_gain', 'wrong gain of the force balance', [BALANCE_GAIN], &
             'All forces and torques were larger, or smaller, than the balance says, by one factor.')
    call one('balance_offset', 'zero error of the force balance', pack([(BALANCE_OFFSET + i, i=1, N_COMPONENTS)], is_there), &
             'The balance did not show 0 where there was no force.')
    call one('balance_turn', 'turned force balance', pack([(BALANCE_TURN + i, i=1, 3)], mask=turns), &
             'The axes of the balance were turned against those of the record.')
    call one('cross_talk', 'cross-talk of the force balance', pairs, 'The balance showed a share of one component in another.')
    call one('balance_lowpass', 'slow force balance', [BALANCE_LOWPASS], &
             'The balance smoothed the record, as a filter of first order.')
    call one('balance_delay', 'forces and kinematics that do not begin together', [BALANCE_DELAY], &
             'The record of the forces was late, or early, against that of the motion: balance and camera had different clocks.')
    call one('wing_inertia', 'inertia of the wing in the forces', [BALANCE_MASS], &
             'The inertia of the wing was not subtracted from what the balance shows, or too much of it.')

  contains

    !> Tells whether flights have the force or torque `component`, from 1 to 6: of a section they have only 2 and 3.
    pure logical function is_flown(component)
      integer, intent(in) :: component
      is_flown = .not. facts%is_section .or. any(component == [2, 3])
    end function is_flown

    !> Enters one error of the balance, if it is wanted and has parameters that the records can show.
    subroutine one(name, title, numbers, sentence)
      character(*), intent(in) :: name, title, sentence
      integer, intent(in) :: numbers(:)
      type(variant_t), allocatable :: variants(:)
      integer :: columns(size(numbers)), k
      if (.not. is_wanted(wanted, name)) return
      allocate (variants(0))
      if (size(numbers) == 0) return
      if (any(numbers(1) == [BALANCE_TURN + 1, BALANCE_MASS]) .and. .not. any(is_there(:6))) return ! power alone shows neither
      do k = 1, size(numbers)
        columns(k) = c%add(wing_parameter(describe_balance(numbers(k), sizes, 1/facts%frequency, mass, facts%is_section), &
                                          KIND_BALANCE, numbers(k)))
      end do
      call append_variant(variants, '', columns(1), [0.0_rp, 0.0_rp])
      variants(1)%columns = columns
      call c%enter(name, title, sentence, .true., '', variants)
    end subroutine one

  end subroutine enter_balance

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

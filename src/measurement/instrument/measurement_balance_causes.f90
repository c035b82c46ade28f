! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes what a force balance can get wrong: the causes, and their parameters. measurement_balance has the laws.
!> docs/theory/flight-records.md documents bounds and sd.
module measurement_balance_causes
  use base_cause, only: cause_t, enlist, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_factor, word_plain, SCALE_FACTOR, UNIT_OF_PARAMETER
  use measurement_flight, only: component_unit, COMPONENT_NAMES, N_COMPONENTS
  use measurement_instrument_causes, only: N_BENDING_NEEDS
  implicit none
  private
  public :: balance_scales_t, list_balance_causes, cross_number, cross_components

  !> These are the numbers of the parameters. The offset of a component is BALANCE_OFFSET + component. The turns about x, y and z
  !> are BALANCE_TURN + 1 to 3. `cross_number` returns the number of a cross-talk.
  integer, parameter, public :: BALANCE_GAIN = 1, BALANCE_OFFSET = 1, BALANCE_TURN = 8, BALANCE_LOWPASS = 12, BALANCE_DELAY = 13, &
                                BALANCE_MASS = 14, BALANCE_CROSS = 14, N_BALANCE = 14 + 12

  integer, parameter, public :: NEED_FORCES = N_BENDING_NEEDS + 1 !< forces or torques; power alone does not show the cause

  !> Holds quantities of the records. Bounds and priors are multiples of them.
  type :: balance_scales_t
    real(rp) :: sizes(N_COMPONENTS) = 1 !< of the components, in their units
    real(rp) :: period = 1              !< [s] of the beat
    real(rp) :: mass = 1                !< [kg, or kg/m if `is_per_length`] prior sd of the mass in `inertia`
    logical :: is_per_length = .false.  !< forces are those of a section, per length
  end type balance_scales_t

  real(rp), parameter :: TO_MILLI = 1.0e3_rp
  character(*), parameter :: OF_PERIOD = 'the period', OF_ONE = ''

contains

  !> Returns all causes, in the order in which the catalogue has them.
  pure function list_balance_causes(scales) result(list)
    type(balance_scales_t), intent(in) :: scales
    type(cause_t), allocatable :: list(:)
    call enlist(list, gain())
    call enlist(list, offset(scales))
    call enlist(list, turn())
    call enlist(list, cross_talk())
    call enlist(list, lowpass(scales))
    call enlist(list, delay(scales))
    call enlist(list, inertia(scales))
  end function list_balance_causes

  !> Returns the number of the cross-talk that adds a fraction of component j to the indication of component i. Both must be forces
  !> (1 to 3) or both torques (4 to 6), and they must differ.
  pure integer function cross_number(i, j) result(number)
    integer, intent(in) :: i, j
    integer :: own, other
    own = modulo(i - 1, 3)
    other = modulo(j - 1, 3)
    number = BALANCE_CROSS + 6*((i - 1)/3) + 2*own + merge(other, other - 1, other < own) + 1
  end function cross_number

  !> Returns the components [i, j] of the cross-talk with this number, or [0, 0] if no cross-talk has it.
  pure function cross_components(number) result(pair)
    integer, intent(in) :: number
    integer :: pair(2)
    integer :: i, j, first
    pair = 0
    do i = 1, 6
      first = 3*((i - 1)/3) + 1
      do j = first, first + 2
        if (i == j) cycle
        if (cross_number(i, j) == number) pair = [i, j]
      end do
    end do
  end function cross_components

  !> Returns an error of the balance, so far without parameters.
  pure function of_balance(name, title, sentence, data) result(cause)
    character(*), intent(in) :: name, title, sentence, data
    type(cause_t) :: cause
    cause = make_cause(name, title, sentence, data)
    cause%is_measurement = .true.
  end function of_balance

  !> Returns the wrong gain, one factor on all forces and torques.
  pure function gain() result(c)
    type(cause_t) :: c
    c = of_balance('balance_gain', 'wrong gain of the force balance', &
                   'All forces and torques were larger, or smaller, than the balance says, by one factor.', 'records of forces')
    call c%add(BALANCE_GAIN, effect_parameter('balance_gain', '1', .true., 0.5_rp, 2.0_rp, 0.1_rp), OF_ONE)
    call word_factor(c%parameters(1)%words, SCALE_FACTOR, 'The balance shows all forces', 'The balance shows all forces', &
                     'larger', 'smaller', 'than they are', 'as large as they are', 1.0_rp)
  end function gain

  !> Returns the zero error, with one offset for each component.
  pure function offset(scales) result(c)
    type(balance_scales_t), intent(in) :: scales
    type(cause_t) :: c
    character(:), allocatable :: lead
    integer :: i
    c = of_balance('balance_offset', 'zero error of the force balance', 'The balance did not show 0 where there was no force.', &
                   'records of forces')
    do i = 1, N_COMPONENTS
      call c%add(BALANCE_OFFSET + i, &
                 effect_parameter('balance_offset:'//trim(COMPONENT_NAMES(i)), component_unit(i, scales%is_per_length), .false., &
                                  -scales%sizes(i), scales%sizes(i), 0.1_rp*scales%sizes(i)), 'the root mean square')
      lead = 'The balance shows '//trim(COMPONENT_NAMES(i))//' where there is none:'
      call word_plain(c%parameters(i)%words, UNIT_OF_PARAMETER, lead, lead, 'too much', 'too little', '', 0.0_rp)
    end do
  end function offset

  !> Returns the turned balance, with one angle about each axis.
  pure function turn() result(c)
    type(cause_t) :: c
    character(:), allocatable :: lead
    character(*), parameter :: AXES = 'xyz'
    integer :: i
    c = of_balance('balance_turn', 'turned force balance', 'The axes of the balance were turned against those of the record.', &
                   'forces or torques')
    c%needs = [NEED_FORCES]
    do i = 1, 3
      call c%add(BALANCE_TURN + i, effect_parameter('balance_turn:'//AXES(i:i), 'degree', .false., &
                                                    -15.0_rp, 15.0_rp, 2.0_rp), OF_ONE)
      lead = 'The balance is turned about '//AXES(i:i)//':'
      call word_plain(c%parameters(i)%words, 'degrees', lead, lead, 'right-handed', 'left-handed', '', 0.0_rp)
    end do
  end function turn

  !> Returns the cross-talk: a fraction of each force adds to each other force, and the same holds for torques.
  pure function cross_talk() result(c)
    type(cause_t) :: c
    character(:), allocatable :: lead, from, to
    integer :: number, pair(2)
    c = of_balance('cross_talk', 'cross-talk of the force balance', 'The balance showed a fraction of one component in another.', &
                   'two forces, or two torques')
    do number = BALANCE_CROSS + 1, N_BALANCE
      pair = cross_components(number)
      to = trim(COMPONENT_NAMES(pair(1)))
      from = trim(COMPONENT_NAMES(pair(2)))
      call c%add(number, effect_parameter('cross_talk:'//from//'-'//to, '1', .false., -0.5_rp, 0.5_rp, 0.05_rp), OF_ONE)
      lead = 'The balance shows a fraction of '//from//' in '//to//':'
      call word_plain(c%parameters(size(c%parameters))%words, '', lead, lead, 'of it', 'of it, reversed', '', 0.0_rp)
    end do
  end function cross_talk

  !> Returns the slow balance, with the time constant of a filter of first order.
  pure function lowpass(scales) result(c)
    type(balance_scales_t), intent(in) :: scales
    type(cause_t) :: c
    c = of_balance('balance_lowpass', 'slow force balance', 'The balance smoothed the record, as a filter of first order.', &
                   'records of forces')
    call c%add(BALANCE_LOWPASS, effect_parameter('balance_lowpass', 's', .false., &
                                                 0.0_rp, 0.2_rp*scales%period, 0.02_rp*scales%period), OF_PERIOD)
    call word_plain(c%parameters(1)%words, 'ms', 'The balance is slow: it has a time constant of', 'The balance is fast:', '', &
                    'less', '', 0.0_rp)
    c%parameters(1)%words%factor = TO_MILLI
  end function lowpass

  !> Returns the delay of forces against the motion.
  pure function delay(scales) result(c)
    type(balance_scales_t), intent(in) :: scales
    type(cause_t) :: c
    c = of_balance('balance_delay', 'forces and kinematics that do not begin together', &
                   'The record of the forces was late, or early, against that of the motion: balance and camera had different '// &
                   'clocks.', 'records of forces')
    call c%add(BALANCE_DELAY, effect_parameter('balance_delay', 's', .false., &
                                               -0.25_rp*scales%period, 0.25_rp*scales%period, 0.02_rp*scales%period), OF_PERIOD)
    call word_plain(c%parameters(1)%words, 'ms', 'Forces come late against the motion by', &
                    'Forces come early against the motion by', '', '', '', 0.0_rp)
    c%parameters(1)%words%factor = TO_MILLI
  end function delay

  !> Returns the inertia of the wing in the forces, with the mass that was not subtracted.
  pure function inertia(scales) result(c)
    type(balance_scales_t), intent(in) :: scales
    type(cause_t) :: c
    c = of_balance('wing_inertia', 'inertia of the wing in the forces', &
                   'The inertia of the wing was not subtracted from what the balance shows, or too much of it.', &
                   'forces or torques')
    c%needs = [NEED_FORCES]
    call c%add(BALANCE_MASS, &
               effect_parameter('inertia_mass', trim(merge('kg/m', 'kg  ', scales%is_per_length)), .false., -10*scales%mass, &
                                10*scales%mass, scales%mass), 'the mass whose inertia is a tenth of the forces')
    call word_plain(c%parameters(1)%words, UNIT_OF_PARAMETER, 'The inertia of the wing is in the forces: that of', &
                    'Too much inertia of the wing was subtracted: that of', '', '', '', 0.0_rp)
  end function inertia
end module measurement_balance_causes

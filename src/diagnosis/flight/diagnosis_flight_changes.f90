! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes how a flight can differ from the simulated one in its kinematics or flow: the causes, and their parameters. A
!> program that simulates flights makes the changes: diagnosis_flight_runner.
module diagnosis_flight_changes
  use base_cause, only: cause_t, enlist, find_parameter, make_cause, parameter_of
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter, parameter_t
  use base_wording, only: word_factor, word_plain, SCALE_FACTOR, SCALE_LINEAR
  use measurement_balance_causes, only: NEED_FORCES
  implicit none
  private
  public :: change_scales_t, list_change_causes, change_parameter, cause_of_change, is_of_flow, is_of_material, is_of_structure, &
            is_of_wing, is_one_sided

  !> The numbers of the changes that a flight can make. Amplitudes change by a relative amount, angles by degrees, the lead by a
  !> fraction of a beat, the wind by m/s, and viscosity, area of the wings, E and D by the logarithm of a factor. What the case
  !> leaves out altogether (bending, a wall, a body) comes in parts of what a user states. FLOW_STRUCTURE + k is the k-th of the
  !> further parameters of wings that bend which flights of this diagnosis change (diagnosis_flight_structure), by its coordinate.
  integer, parameter, public :: FLOW_STROKE = 1, FLOW_STROKE_MEAN = 2, FLOW_PITCH = 3, FLOW_PITCH_MEAN = 4, FLOW_LEAD = 5, &
                                FLOW_DEVIATION = 6, FLOW_PLANE = 7, FLOW_WIND = 7, FLOW_VISCOSITY = 11, FLOW_AREA = 12, &
                                FLOW_DEVIATION_COS = 13, FLOW_DEVIATION_SIN = 14, &
                                FLOW_BENDING = 15, FLOW_WALL = 16, FLOW_BODY = 17, &
                                FLOW_YOUNG = 18, FLOW_PLATE = 19, FLOW_STRUCTURE = 19, N_STRUCTURE = 32, &
                                N_FLOW = FLOW_STRUCTURE + N_STRUCTURE
  integer, parameter, public :: FLOW_FREQUENCY = N_FLOW + 1, N_CHANGES = N_FLOW + 1 !< the changes that are flown, and this one

  integer, parameter, public :: NEED_RIGID = NEED_FORCES + 1 !< wings that do not bend

  !> What bounds and parameters depend on.
  type :: change_scales_t
    real(rp) :: speed = 1            !< [m/s] mean of the wing tip
    logical :: is_section = .false.  !< it feels no wind along x
    real(rp) :: prior_sd(N_CHANGES) = 0 !< in place of the usual prior sd, in units of the parameters; 0: the usual one
  end type change_scales_t

  real(rp), parameter :: WIND_SD = 0.05_rp !< of the speed of the tip
  character(*), parameter :: RECORDS = 'records of forces', MOTIONS = RECORDS//' or landmarks', &
                             BENT = RECORDS//', or landmarks on wings that bend'

contains

  !> Returns all causes, in the order in which the catalogue has them.
  pure function list_change_causes(scales) result(list)
    type(change_scales_t), intent(in) :: scales
    type(cause_t), allocatable :: list(:)
    integer :: i, k
    call enlist(list, amplitude(FLOW_STROKE, 'stroke_amplitude', 'The stroke was', 'stroke of another amplitude', &
                                'The wing swept farther, or less far, than the kinematics say.'))
    call enlist(list, angle(FLOW_STROKE_MEAN, 'stroke_mean', 'The middle of the stroke was displaced in phi by', &
                            'stroke about another mean angle', &
                            'The stroke lay farther forward or back than the kinematics say.'))
    call enlist(list, amplitude(FLOW_PITCH, 'pitch_amplitude', 'The pitch was', 'pitch of another amplitude', &
                                'The wing turned about its long axis more, or less, than the kinematics say.'))
    call enlist(list, angle(FLOW_PITCH_MEAN, 'pitch_mean', 'The mean pitch was displaced by', 'pitch about another mean angle', &
                            'The wing was pitched by a constant angle against the kinematics.'))
    call enlist(list, pitch_lead())
    call enlist(list, amplitude(FLOW_DEVIATION, 'deviation_amplitude', 'The deviation was', 'deviation of another amplitude', &
                                'The wing left the stroke plane more, or less, than the kinematics say.'))
    call enlist(list, angle(FLOW_PLANE, 'stroke_plane', 'The stroke plane was tilted in eta by', 'another stroke plane', &
                            'The stroke plane was tilted against that of the kinematics.'))
    call enlist(list, beat_frequency())
    call enlist(list, wind(scales))
    call enlist(list, viscosity())
    call enlist(list, deviation())
    call enlist(list, wing_area())
    call enlist(list, omission(FLOW_BENDING, 'wing_bending', 'bending of the wings', &
                               'The wings bent, and those of the simulation are rigid.', 'The wings bent', &
                               'as much as [Wing] of the case says', MOTIONS//', and [Wing] in the case'))
    call enlist(list, omission(FLOW_WALL, 'wall', 'a wall', &
                               'There was a wall near the wing that the simulation leaves out.', 'A wall acted', &
                               'as much as one at [Flight] wall_distance', BENT//', and [Flight] wall_distance'))
    call enlist(list, omission(FLOW_BODY, 'body', 'a body', &
                               'There was a body between the wings that the simulation leaves out.', 'A body displaced', &
                               'as much as [Flight] body_length and body_radius say', BENT//', and [Flight] body_length'))
    call enlist(list, stiffness(FLOW_YOUNG, 'vein_stiffness', 'veins of another stiffness', &
                                'The veins were stiffer, or softer, than those of the case.', &
                                'The veins are stiffer: E is', 'The veins are softer: E is'))
    call enlist(list, stiffness(FLOW_PLATE, 'membrane_stiffness', 'a membrane of another stiffness', &
                                'The membrane resists bending more, or less, than that of the case.', &
                                'The membrane is stiffer: D is', 'The membrane is softer: D is'))
    do i = 1, size(list)
      do k = 1, size(list(i)%parameters)
        associate (p => list(i)%parameters(k))
          if (scales%prior_sd(p%number) > 0) p%value%prior_sd = scales%prior_sd(p%number)
        end associate
      end do
    end do
  end function list_change_causes

  !> Tells whether a change acts on the flow alone: landmarks on rigid wings do not show it.
  pure elemental logical function is_of_flow(number)
    integer, intent(in) :: number
    is_of_flow = any(number == [FLOW_VISCOSITY, FLOW_WALL, FLOW_BODY]) .or. number > FLOW_WIND .and. number <= FLOW_WIND + 3
  end function is_of_flow

  !> Tells whether a change belongs to the wings or the body, so that no flight can have it alone.
  pure elemental logical function is_of_wing(number)
    integer, intent(in) :: number
    is_of_wing = any(number == [FLOW_AREA, FLOW_BENDING, FLOW_BODY]) .or. is_of_material(number)
  end function is_of_wing

  !> Tells whether a change is one of E or D of wings that bend: with other data of the wing, these are parameters of all data.
  pure elemental logical function is_of_material(number)
    integer, intent(in) :: number
    is_of_material = any(number == [FLOW_YOUNG, FLOW_PLATE])
  end function is_of_material

  !> Tells whether a change is one of a further parameter of wings that bend.
  pure elemental logical function is_of_structure(number)
    integer, intent(in) :: number
    is_of_structure = number > FLOW_STRUCTURE .and. number <= N_FLOW
  end function is_of_structure

  !> Tells whether a change cannot be made in both directions: what the case leaves out can only be added.
  pure elemental logical function is_one_sided(number)
    integer, intent(in) :: number
    is_one_sided = any(number == [FLOW_BENDING, FLOW_WALL, FLOW_BODY])
  end function is_one_sided

  !> Returns change `number`, none of the structure, as a parameter, by its coordinate, which is 0 for the case as it is.
  pure function change_parameter(number, scales) result(p)
    integer, intent(in) :: number
    type(change_scales_t), intent(in) :: scales
    type(parameter_t) :: p
    p = parameter_of(list_change_causes(scales), number)
    p = p%as_coordinate(p%null)
  end function change_parameter

  !> Returns the name of the cause to which change `number`, none of the structure, belongs.
  pure function cause_of_change(number) result(name)
    integer, intent(in) :: number
    character(:), allocatable :: name
    type(change_scales_t) :: scales
    type(cause_t), allocatable :: list(:)
    integer :: cause, k
    list = list_change_causes(scales)
    call find_parameter(list, number, cause, k)
    name = list(cause)%name
  end function cause_of_change

  !> Returns the cause of another amplitude of an angle.
  pure function amplitude(number, name, lead, title, sentence) result(c)
    integer, intent(in) :: number
    character(*), intent(in) :: name, lead, title, sentence
    type(cause_t) :: c
    c = make_cause(name, title, sentence, MOTIONS)
    call c%add(number, effect_parameter(name, '1', .false., -0.4_rp, 0.4_rp, 0.05_rp))
    call word_factor(c%parameters(1)%words, SCALE_LINEAR, lead, lead, 'larger', 'smaller', 'than the kinematics say', &
                     'what the kinematics say', 0.0_rp)
  end function amplitude

  !> Returns the cause of an angle that is added.
  pure function angle(number, name, lead, title, sentence) result(c)
    integer, intent(in) :: number
    character(*), intent(in) :: name, lead, title, sentence
    type(cause_t) :: c
    c = make_cause(name, title, sentence, MOTIONS)
    call c%add(number, effect_parameter(name, 'degree', .false., -20.0_rp, 20.0_rp, 3.0_rp))
    call word_plain(c%parameters(1)%words, 'degrees', lead//' plus', lead//' minus', '', '', '', 0.0_rp)
  end function angle

  pure function pitch_lead() result(c)
    type(cause_t) :: c
    c = make_cause('pitch_lead', 'pitch at another time', &
                   'The wing turned about its long axis earlier, or later, in the beat than the kinematics say.', MOTIONS)
    call c%add(FLOW_LEAD, effect_parameter(c%name, 'beat', .false., -0.2_rp, 0.2_rp, 0.02_rp))
    call word_plain(c%parameters(1)%words, 'beats', 'The pitch was early by', 'The pitch was late by', '', '', '', 0.0_rp)
  end function pitch_lead

  !> Needs no flight of its own: see diagnosis_flight_response.
  pure function beat_frequency() result(c)
    type(cause_t) :: c
    c = make_cause('beat_frequency', 'another beat frequency', 'The wing beat faster, or slower, than the measurement says.', &
                   'records of forces on wings that do not bend')
    c%needs = [NEED_RIGID]
    call c%add(FLOW_FREQUENCY, effect_parameter(c%name, '1', .true., 0.7_rp, 1.4_rp, 0.05_rp))
    call word_factor(c%parameters(1)%words, SCALE_FACTOR, 'The wing beat faster:', 'The wing beat slower:', &
                     'more beats in a second', 'fewer beats in a second', &
                     'than the measurement says', 'as many beats as the measurement says', 1.0_rp)
  end function beat_frequency

  pure function wind(scales) result(c)
    type(change_scales_t), intent(in) :: scales
    type(cause_t) :: c
    character(*), parameter :: AXES = 'xyz', LEAD = 'There was wind:'
    integer :: k
    c = make_cause('wind', 'wind', 'The air moved against the wing as a whole.', BENT)
    do k = 1, 3
      call c%add(FLOW_WIND + k, &
                 effect_parameter('wind:'//AXES(k:k), 'm/s', .false., -0.5_rp*scales%speed, 0.5_rp*scales%speed, &
                                  WIND_SD*scales%speed), 'the speed of the wing tip')
      call word_plain(c%parameters(k)%words, 'm/s', LEAD, LEAD, 'along +'//AXES(k:k), 'along -'//AXES(k:k), '', 0.0_rp)
    end do
    c%parameters(1)%is_tried = .not. scales%is_section
  end function wind

  pure function viscosity() result(c)
    type(cause_t) :: c
    c = make_cause('viscosity', 'another viscosity', &
                   'The fluid was more, or less, viscous than the measurement says: its temperature differs.', BENT)
    call c%add(FLOW_VISCOSITY, effect_parameter(c%name, '1', .true., 0.5_rp, 2.0_rp, 0.05_rp))
    call word_factor(c%parameters(1)%words, SCALE_FACTOR, 'The fluid was', 'The fluid was', 'more viscous', 'less viscous', &
                     'than the measurement says', 'as viscous as the measurement says', 1.0_rp)
  end function viscosity

  !> A deviation theta = a cos + b sin of the beat, which is added to that of the kinematics.
  pure function deviation() result(c)
    type(cause_t) :: c
    character(*), parameter :: PARTS(2) = ['cos', 'sin']
    integer :: k
    c = make_cause('deviation', 'a deviation from the stroke plane', &
                   'The wing left the stroke plane once in each beat, in another way than the kinematics say.', MOTIONS)
    do k = 1, 2
      call c%add(FLOW_DEVIATION_COS + k - 1, &
                 effect_parameter('deviation:'//PARTS(k), 'degree', .false., -20.0_rp, 20.0_rp, 3.0_rp))
      call word_plain(c%parameters(k)%words, 'degrees', 'The deviation had plus', 'The deviation had minus', &
                      'times the '//PARTS(k)//' of the beat', 'times the '//PARTS(k)//' of the beat', '', 0.0_rp)
    end do
  end function deviation

  !> All wings are longer along both axes by the same factor. In a section it is the chord.
  pure function wing_area() result(c)
    type(cause_t) :: c
    c = make_cause('wing_area', 'wings of another area', 'The wings were larger, or smaller, than those of the simulation.', &
                   MOTIONS//' on wings that do not bend')
    c%needs = [NEED_RIGID]
    call c%add(FLOW_AREA, effect_parameter(c%name, '1', .true., 0.6_rp, 1.6_rp, 0.1_rp))
    call word_factor(c%parameters(1)%words, SCALE_FACTOR, 'The area of the wings was', 'The area of the wings was', 'larger', &
                     'smaller', 'than in the simulation', 'that in the simulation', 1.0_rp)
  end function wing_area

  !> Returns the cause of another E or D of wings that bend.
  pure function stiffness(number, name, title, sentence, up, down) result(c)
    integer, intent(in) :: number
    character(*), intent(in) :: name, title, sentence, up, down
    type(cause_t) :: c
    c = make_cause(name, title, sentence, MOTIONS//' on wings that bend, without other data of the wing')
    call c%add(number, effect_parameter(name, '1', .true., 0.3_rp, 3.0_rp, 0.2_rp))
    call word_factor(c%parameters(1)%words, SCALE_FACTOR, up, down, 'higher', 'lower', 'than in the case', &
                     'that of the case', 1.0_rp)
  end function stiffness

  !> Returns the cause of something that the case leaves out. Its parameter is 0 without it and 1 for all of it.
  pure function omission(number, name, title, sentence, lead, than, data) result(c)
    integer, intent(in) :: number
    character(*), intent(in) :: name, title, sentence, lead, than, data
    type(cause_t) :: c
    c = make_cause(name, title, sentence, data)
    call c%add(number, effect_parameter(name, '1', .false., 0.0_rp, 3.0_rp, 1.0_rp))
    call word_plain(c%parameters(1)%words, '', lead, lead//' in the other sense', 'times '//than, 'times '//than, '', 0.0_rp)
  end function omission
end module diagnosis_flight_changes

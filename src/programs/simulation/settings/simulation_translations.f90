! SPDX-License-Identifier: GPL-3.0-or-later
!> Translates words of FLUSI that stand for several keys of this program.
module simulation_translations
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fluid_params, only: fluid_params_t, read_fluid_keys
  use fluid_solid_keys, only: solids_t, MASK_FLEXIBLE_WING, MASK_INSECT
  use fluid_time_keys, only: ALSO_COUPLING, ALSO_ITERATION, ALSO_RIGID_SOLID
  use fsi_body_motion, only: MOTION_FREE, MOTION_TAKEOFF
  use fsi_body_motion_keys, only: body_motion_choices, body_motion_choices_t
  use fsi_coupler_params, only: COUPLING_STRONG, COUPLING_WEAK
  use fsi_flight_keys, only: flight_choices, flight_choices_t
  use fsi_kinematics_keys, only: kinematics_choices, kinematics_choices_t, SIDES
  use fsi_thin_keys, only: surface_choice, SURFACE_AUTO
  use io_config, only: config_t
  use simulation_flexible, only: stated_coupling
  use simulation_output_params, only: output_params_t, wanted_output
  implicit none
  private
  public :: translate_words

  character(*), parameter :: F = 'Flexible_wing', MOTION_KEY = 'BodyMotion'

contains

  !> Replaces words of FLUSI in the loaded `config` by the keys that they stand for, and adds a notice for each.
  subroutine translate_words(config, notices)
    type(config_t), intent(inout) :: config
    type(message_list_t), intent(inout) :: notices
    type(fluid_params_t) :: fluid
    type(kinematics_choices_t) :: kinematics
    type(output_params_t) :: output
    real(rp) :: box(3)
    call translate_scheme(config, notices)
    call read_fluid_keys(config, fluid)
    box = fluid%box%length
    if (fluid%resolution%n(1) == 1) box(1) = 0 ! a plane flow, at x = 0
    if (.not. (fluid%solids%is_on .and. any(fluid%solids%mask == [MASK_INSECT, MASK_FLEXIBLE_WING]))) return
    if (fluid%solids%mask == MASK_FLEXIBLE_WING) call translate_flexible_wing(config, notices)
    kinematics = kinematics_choices(config)
    if (.not. kinematics%has_centre) call settle_place(config, box/2, 'the centre of the box')
    call translate_take_off(config, kinematics, box, notices)
    call translate_pose(config, fluid%solids, box, notices)
    output = wanted_output(config)
    if (output%mask_only .and. surface_choice(config) == SURFACE_AUTO) &
      call config%settle('Insects', 'surface', 'penalized', 'as [DryRun] dry_run_without_fluid draws a mask')
  end subroutine translate_words

  !> Translates iMask = Flexible_wing of FLUSI into an insect with flexible wings.
  subroutine translate_flexible_wing(config, notices)
    type(config_t), intent(inout) :: config
    type(message_list_t), intent(inout) :: notices
    call config%complain(notices, 'Penalization', 'iMask', 'Flexible_wing is read as Insect with [Insects] wings = '// &
                         'flexible; place and motion of the wing are in [Insects]')
    call config%settle('Penalization', 'iMask', 'Insect', 'as Flexible_wing')
    call config%settle('Insects', 'wings', 'flexible', 'as [Penalization] iMask = Flexible_wing')
    ! With this mask FLUSI draws no body and no wing of [Insects].
    call config%settle('Insects', 'WingShape', 'none', 'as [Penalization] iMask = Flexible_wing')
    call config%settle('Insects', 'BodyType', 'nobody', 'as [Penalization] iMask = Flexible_wing')
  end subroutine translate_flexible_wing

  !> Translates FLUSI's time stepper, which also names the coupling. For a wing of masses and springs, FLUSI's semi-implicit
  !> coupling also takes the load at the old time.
  subroutine translate_scheme(config, notices)
    type(config_t), intent(inout) :: config
    type(message_list_t), intent(inout) :: notices
    type(fluid_params_t) :: fluid
    type(body_motion_choices_t) :: motion
    character(:), allocatable :: word, coupling
    call read_fluid_keys(config, fluid)
    word = fluid%time%word
    motion = body_motion_choices(config)
    if (fluid%time%also == ALSO_RIGID_SOLID .and. any(motion%kind == [MOTION_FREE, MOTION_TAKEOFF])) &
      call config%settle('Time', 'iTimeMethodFluid', 'AB2', 'as '//word)
    if (all(fluid%time%also /= [ALSO_COUPLING, ALSO_ITERATION])) return
    coupling = stated_coupling(config, merge(COUPLING_STRONG, COUPLING_WEAK, fluid%time%also == ALSO_ITERATION))
    call config%complain(notices, 'Time', 'iTimeMethodFluid', word//' is read as AB2 with [Flexible_wing] coupling = '// &
                         coupling)
    call config%settle('Time', 'iTimeMethodFluid', 'AB2', 'as '//word)
    call config%settle(F, 'coupling', coupling, 'as [Time] iTimeMethodFluid = '//word)
  end subroutine translate_scheme

  !> Translates FLUSI's take-off, whose pitch, path and wings follow a table.
  subroutine translate_take_off(config, kinematics, box, notices)
    type(config_t), intent(inout) :: config
    type(kinematics_choices_t), intent(in) :: kinematics
    real(rp), intent(in) :: box(3)
    type(message_list_t), intent(inout) :: notices
    type(body_motion_choices_t) :: of_body
    type(flight_choices_t) :: flight
    character(:), allocatable :: motion
    real(rp) :: place(3)
    integer :: i
    of_body = body_motion_choices(config)
    if (of_body%from_file /= 'yes') return
    motion = 'kinematics_loader::data_kin.dat'
    if (kinematics%has_file) motion = 'kinematics_loader::'//kinematics%file
    do i = 1, 2
      if (kinematics%motion(i)%word == 'takeoff') &
        call config%settle('Insects', 'FlappingMotion_'//trim(SIDES(i)), motion, 'as takeoff')
    end do
    if (of_body%kind /= MOTION_TAKEOFF) return
    flight = flight_choices(config)
    place = [of_body%x_takeoff, box(2)/2, of_body%z_takeoff]
    call config%settle('Insects', MOTION_KEY, motion, 'as takeoff')
    call settle_place(config, place, 'as BodyMotion = takeoff')
    call settle_stroke(config, flight%stroke, 'as BodyMotion = takeoff')
    call config%complain(notices, 'Insects', MOTION_KEY, 'takeoff is read as '//motion//', x0 = '//numbers(place)// &
                         ', eta0 = eta_stroke')
  end subroutine translate_take_off

  !> Translates bodies that are held still: the name stands for a position, an attitude and a stroke plane.
  subroutine translate_pose(config, solids, box, notices)
    type(config_t), intent(inout) :: config
    type(solids_t), intent(in) :: solids
    real(rp), intent(in) :: box(3)
    type(message_list_t), intent(inout) :: notices
    type(body_motion_choices_t) :: of_body
    type(flight_choices_t) :: flight
    character(:), allocatable :: word
    real(rp) :: place(3), attitude(3), eta
    of_body = body_motion_choices(config)
    word = of_body%word
    if (word == 'tethered') return
    flight = flight_choices(config)
    place = box/2
    attitude = 0 ! yaw, pitch, roll
    eta = 0
    select case (word)
    case ('fixed')
      continue
    case ('fixed45')
      attitude = [45, -45, 0]
      eta = -45
    case ('forward')
      attitude = [180.0_rp, -flight%pitch, 0.0_rp]
      eta = flight%stroke
    case ('hovering')
      place(3) = box(3) - 1.3_rp
      attitude = [45.0_rp, -flight%pitch, 0.0_rp]
      eta = -45
    case ('x0y0z0')
      attitude = [0, -45, 0]
      eta = -45
    case ('flapper')
      place(3) = box(3) - 1
      attitude = [45, -90, 0]
    case ('wheeling') ! about the centre of the box
      call settle_place(config, place, 'as BodyMotion = '//word)
      return
    case default
      return
    end select
    if (any(word == [character(7) :: 'fixed45', 'forward', 'x0y0z0'])) place = merge(solids%centre, place, solids%has_centre)
    call settle_place(config, place, 'as BodyMotion = '//word)
    call config%settle('Insects', 'yawpitchroll_0', numbers(attitude), 'as BodyMotion = '//word)
    call settle_stroke(config, eta, 'as BodyMotion = '//word)
    call config%settle('Insects', MOTION_KEY, 'tethered', 'as '//word)
    call config%complain(notices, 'Insects', MOTION_KEY, word//' is read as tethered, x0 = '//numbers(place)// &
                         ', yawpitchroll_0 = '//numbers(attitude)//', eta0 = '//number_text(eta))
  end subroutine translate_pose

  !> Sets [Insects] x0. `origin` says where the value comes from.
  subroutine settle_place(config, place, origin)
    type(config_t), intent(inout) :: config
    real(rp), intent(in) :: place(3)
    character(*), intent(in) :: origin
    call config%settle('Insects', 'x0', numbers(place), origin)
  end subroutine settle_place

  !> Sets [Insects] eta0. `origin` says where the value comes from.
  subroutine settle_stroke(config, eta, origin)
    type(config_t), intent(inout) :: config
    real(rp), intent(in) :: eta
    character(*), intent(in) :: origin
    call config%settle('Insects', 'eta0', number_text(eta), origin)
  end subroutine settle_stroke

  !> Returns three numbers, separated by blanks.
  function numbers(x) result(text)
    real(rp), intent(in) :: x(3)
    character(:), allocatable :: text
    text = number_text(x(1))//' '//number_text(x(2))//' '//number_text(x(3))
  end function numbers
end module simulation_translations

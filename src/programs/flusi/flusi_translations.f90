! SPDX-License-Identifier: GPL-3.0-or-later
!> Words of FLUSI that mean several keys here. Each becomes these keys, and a notice says so.
module flusi_translations
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use io_config, only: config_t
  implicit none
  private
  public :: translate_words

  character(*), parameter :: F = 'Flexible_wing'


contains

  !> Replaces, in a loaded `config`, the words of FLUSI by the keys that they stand for.
  subroutine translate_words(config, notices)
    type(config_t), intent(inout) :: config
    type(message_list_t), intent(inout) :: notices
    logical :: has_wings
    call translate_scheme(config, notices)
    has_wings = config%get_switch('Penalization', 'iPenalization') .and. &
                any(config%get_word('Penalization', 'iMask') == [character(13) :: 'Insect', 'insect', F])
    if (.not. has_wings) return
    call translate_flexible_wing(config, notices)
    if (.not. config%is_given('Insects', 'x0')) &
      call config%settle('Insects', 'x0', numbers(box_of(config)/2), 'the centre of the box')
    call translate_take_off(config, notices)
    call translate_pose(config, notices)
    if (config%get_switch('DryRun', 'dry_run_without_fluid') .and. config%get_word('Insects', 'surface') == 'auto') &
      call config%settle('Insects', 'surface', 'penalized', 'as [DryRun] dry_run_without_fluid draws a mask')
  end subroutine translate_words

  subroutine translate_flexible_wing(config, notices)
    type(config_t), intent(inout) :: config
    type(message_list_t), intent(inout) :: notices
    if (config%get_word('Penalization', 'iMask') /= F) return
    call config%complain(notices, 'Penalization', 'iMask', 'Flexible_wing is read as Insect with [Insects] wings = '// &
                         'flexible; place and motion of the wing are in [Insects]')
    call config%settle('Penalization', 'iMask', 'Insect', 'as Flexible_wing')
    call config%settle('Insects', 'wings', 'flexible', 'as [Penalization] iMask = Flexible_wing')
    ! With this mask FLUSI draws no body and no wing of [Insects].
    call config%settle('Insects', 'WingShape', 'none', 'as [Penalization] iMask = Flexible_wing')
    call config%settle('Insects', 'BodyType', 'nobody', 'as [Penalization] iMask = Flexible_wing')
  end subroutine translate_flexible_wing

  !> FLUSI names the coupling by the time stepper. Its semi-implicit one takes the load of the old time, too, where the
  !> wing is one of masses and springs.
  subroutine translate_scheme(config, notices)
    type(config_t), intent(inout) :: config
    type(message_list_t), intent(inout) :: notices
    character(:), allocatable :: word, coupling
    word = config%get_word('Time', 'iTimeMethodFluid')
    if (word == 'AB2_rigid_solid' .and. any(config%get_word('Insects', 'BodyMotion') == &
                                            [character(11) :: 'free_flight', 'takeoff'])) &
      call config%settle('Time', 'iTimeMethodFluid', 'AB2', 'as '//word)
    if (index(word, 'FSI_') /= 1) return
    coupling = 'weak'
    if (word == 'FSI_AB2_iteration') coupling = 'strong'
    if (config%is_given(F, 'coupling')) coupling = config%get_word(F, 'coupling')
    call config%complain(notices, 'Time', 'iTimeMethodFluid', word//' is read as AB2 with [Flexible_wing] coupling = '// &
                         coupling)
    call config%settle('Time', 'iTimeMethodFluid', 'AB2', 'as '//word)
    call config%settle(F, 'coupling', coupling, 'as [Time] iTimeMethodFluid = '//word)
  end subroutine translate_scheme

  !> FLUSI's take-off with the pitch, the way and the wings of a table.
  subroutine translate_take_off(config, notices)
    type(config_t), intent(inout) :: config
    type(message_list_t), intent(inout) :: notices
    character(:), allocatable :: motion, key
    character(5), parameter :: SIDES(2) = ['left ', 'right']
    real(rp) :: place(3)
    integer :: i
    if (config%get_text('Insects', 'KineFromFile') /= 'yes') return
    motion = 'kinematics_loader::data_kin.dat'
    if (config%is_given('Insects', 'infile')) motion = 'kinematics_loader::'//config%get_text('Insects', 'infile')
    do i = 1, 2
      key = 'FlappingMotion_'//trim(SIDES(i))
      if (config%get_word('Insects', key) == 'takeoff') call config%settle('Insects', key, motion, 'as takeoff')
    end do
    if (config%get_word('Insects', 'BodyMotion') /= 'takeoff') return
    place = box_of(config)/2
    place(1) = config%get_real('Insects', 'x_takeoff')
    place(3) = config%get_real('Insects', 'z_takeoff')
    call config%settle('Insects', 'BodyMotion', motion, 'as takeoff')
    call config%settle('Insects', 'x0', numbers(place), 'as BodyMotion = takeoff')
    call config%settle('Insects', 'eta0', number_text(config%get_real('Insects', 'eta_stroke')), 'as BodyMotion = takeoff')
    call config%complain(notices, 'Insects', 'BodyMotion', 'takeoff is read as '//motion//', x0 = '//numbers(place)// &
                         ', eta0 = eta_stroke')
  end subroutine translate_take_off

  !> Bodies that are held still, with the place, attitude and stroke plane that the name stands for.
  subroutine translate_pose(config, notices)
    type(config_t), intent(inout) :: config
    type(message_list_t), intent(inout) :: notices
    character(:), allocatable :: word
    real(rp) :: place(3), attitude(3), eta, box(3)
    word = config%get_word('Insects', 'BodyMotion')
    if (word == 'tethered') return
    box = box_of(config)
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
      attitude = [180.0_rp, -config%get_real('Insects', 'body_pitch_const'), 0.0_rp]
      eta = config%get_real('Insects', 'eta_stroke')
    case ('hovering')
      place(3) = box(3) - 1.3_rp
      attitude = [45.0_rp, -config%get_real('Insects', 'body_pitch_const'), 0.0_rp]
      eta = -45
    case ('x0y0z0')
      attitude = [0, -45, 0]
      eta = -45
    case ('flapper')
      place(3) = box(3) - 1
      attitude = [45, -90, 0]
    case ('wheeling') ! about the centre of the box
      call config%settle('Insects', 'x0', numbers(place), 'as BodyMotion = '//word)
      return
    case default
      return
    end select
    if (any(word == [character(7) :: 'fixed45', 'forward', 'x0y0z0'])) place = geometry_centre(config, place)
    call config%settle('Insects', 'x0', numbers(place), 'as BodyMotion = '//word)
    call config%settle('Insects', 'yawpitchroll_0', numbers(attitude), 'as BodyMotion = '//word)
    call config%settle('Insects', 'eta0', number_text(eta), 'as BodyMotion = '//word)
    call config%settle('Insects', 'BodyMotion', 'tethered', 'as '//word)
    call config%complain(notices, 'Insects', 'BodyMotion', word//' is read as tethered, x0 = '//numbers(place)// &
                         ', yawpitchroll_0 = '//numbers(attitude)//', eta0 = '//number_text(eta))
  end subroutine translate_pose

  !> [Geometry] x0, y0, z0, where they are given, else those of `centre`.
  function geometry_centre(config, centre) result(place)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: centre(3)
    real(rp) :: place(3)
    character(2), parameter :: KEYS(3) = ['x0', 'y0', 'z0']
    integer :: i
    place = centre
    do i = 1, 3
      if (config%is_given('Geometry', KEYS(i))) place(i) = config%get_real('Geometry', KEYS(i))
    end do
  end function geometry_centre

  !> Lengths of the box, L; 0 in x where the flow is plane, at x = 0.
  function box_of(config) result(box)
    type(config_t), intent(in) :: config
    real(rp) :: box(3)
    box = [config%get_real('Geometry', 'xl'), config%get_real('Geometry', 'yl'), config%get_real('Geometry', 'zl')]
    if (config%get_integer('Resolution', 'nx') == 1) box(1) = 0
  end function box_of

  function numbers(x) result(text)
    real(rp), intent(in) :: x(3)
    character(:), allocatable :: text
    text = number_text(x(1))//' '//number_text(x(2))//' '//number_text(x(3))
  end function numbers
end module flusi_translations

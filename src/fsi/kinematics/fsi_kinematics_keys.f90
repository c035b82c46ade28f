! SPDX-License-Identifier: GPL-3.0-or-later
!> Declares the kinematic keys of [Insects], with FLUSI's names, and loads the files that they name.
!>
!> Reading is in two steps, so that only one rank touches the disk: `read_mounts` returns the motion of each wing; the rank that has
!> the text of its file passes it to `read_motion`.
module fsi_kinematics_keys
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_body_motion_keys, only: body_motion_choices, body_motion_choices_t, body_motion_keys
  use fsi_kinematics, only: body_rotation, body_t, wing_mount_t
  use fsi_named_motions, only: NAMED_MOTIONS, set_named_motion
  use fsi_rotation, only: angle_t
  use fsi_wing_motion, only: wing_motion_t
  use fsi_wing_motion_file, only: read_motion_file
  use fsi_wing_motion_table, only: read_motion_table
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  implicit none
  private
  public :: kinematics_choices_t, kinematics_choices, kinematics_keys, register_kinematics_keys, read_body, &
            keep_in_box, read_mounts, read_motion, motion_file

  character(*), parameter :: SECTION = 'Insects'
  character(*), parameter :: FILE_WORD = 'from_file::', TABLE_WORD = 'kinematics_loader::'
  character(5), parameter, public :: SIDES(2) = ['left ', 'right']

  type :: motion_word_t
    character(:), allocatable :: word
    logical :: is_given = .false.
  end type motion_word_t

  type :: kinematics_choices_t
    real(rp) :: centre(3) = 0, attitude(3) = 0 !< of the body: L; yaw, pitch, roll in degrees
    real(rp) :: eta = 0                        !< stroke plane, degrees
    type(motion_word_t) :: motion(2)           !< of the wings, left and right
    character(:), allocatable :: file          !< infile
    logical :: has_centre = .false., has_file = .false.
    real(rp) :: resting(3) = 0                 !< degrees
    real(rp) :: hinge(3, 2) = 0                !< L; counts if `has_hinge`
    logical :: has_hinge(2) = .false.
    real(rp) :: frequency = 1, ramp = 0        !< 1/T, T
    real(rp) :: factor(3) = 1, offset(3) = 0, lead(3) = 0 !< of phi, alpha, theta: 1, degrees, beats
    real(rp) :: deviation(2) = 0               !< added to theta: cosine and sine of the beat, degrees
  end type kinematics_choices_t

contains

  !> Declares and reads the keys of the attitude of the body, the hinges, the stroke plane and the motions.
  subroutine kinematics_keys(keys, motion, c)
    type(keys_t), intent(inout) :: keys
    type(body_motion_choices_t), intent(inout) :: motion
    type(kinematics_choices_t), intent(inout) :: c
    real(rp), parameter :: ZERO(3) = 0.0_rp
    integer :: i
    call body_motion_keys(keys, motion)
    call keys%section(SECTION)
    call keys%reals('x0', c%centre, ZERO, 'centre of the body; if it is not given, flusi takes the centre of the box', unit='L', &
                    given=c%has_centre)
    call keys%reals('yawpitchroll_0', c%attitude, ZERO, 'attitude of the body; positive pitch is nose down', unit='degree')
    call keys%real('eta0', c%eta, 0.0_rp, 'angle of the stroke plane in the body; -90: plane of the body axes x (forward) and '// &
                   'y (left)', unit='degree')
    do i = 1, 2
      call keys%word('FlappingMotion_'//trim(SIDES(i)), c%motion(i)%word, 'none', NAMED_MOTIONS//'|'//FILE_WORD//'*|'// &
                     TABLE_WORD//'*|from_file|from_file_hermite|kinematics_loader|takeoff', 'motion of the '//trim(SIDES(i))// &
                     ' wing: a motion of FLUSI by name (docs/guide/kinematics.md), a file with the section [kinematics] or a '// &
                     'table, the file that infile names, or none (at rest with alpha = 45 degrees)', unbuilt='command-line*', &
                     instead='command-line*: from_file::NAME.ini with the constant terms of alpha, phi and theta, one file '// &
                     'for each run', given=c%motion(i)%is_given)
    end do
    call keys%text('infile', c%file, 'none', 'file of a motion that is given by the word from_file, from_file_hermite or '// &
                   'kinematics_loader alone', given=c%has_file)
    call keys%reals('init_alpha_phi_theta', c%resting, ZERO, 'the first value is minus the angle alpha of revolving-set2 and '// &
                    'revolving-set3', unit='degree')
    call keys%reals('x_pivot_l', c%hinge(:, 1), ZERO, 'hinge of the left wing in the body frame; if it is not given and there '// &
                    'is a body, the hinge lies at the distance b_body beside its centre', unit='L', given=c%has_hinge(1))
    call keys%reals('x_pivot_r', c%hinge(:, 2), ZERO, 'hinge of the right wing in the body frame', unit='L', given=c%has_hinge(2))
    call keys%real('wing_frequency', c%frequency, 1.0_rp, 'wing beats per unit of time', unit='1/T', above=0.0_rp)
    call keys%real('wing_ramp', c%ramp, 0.0_rp, 'the wings start at rest and reach their motion after this time; 0: at once', &
                   unit='T', min=0.0_rp)
    call keys%reals('kinematics_factor', c%factor, [1.0_rp, 1.0_rp, 1.0_rp], 'factors on phi (position in the stroke plane), '// &
                    'alpha (feathering) and theta (deviation) of all wings, each about its mean over the beat')
    call keys%reals('kinematics_offset', c%offset, ZERO, 'angles that are added to phi, alpha and theta of all wings', &
                    unit='degree')
    call keys%reals('kinematics_lead', c%lead, ZERO, 'number of beats by which phi, alpha and theta of all wings are advanced '// &
                    'in time')
    call keys%reals('kinematics_deviation', c%deviation, [0.0_rp, 0.0_rp], 'a b: a cos(2 pi f t) + b sin(2 pi f t) is added to '// &
                    'theta of all wings at all times, also before a table begins', unit='degree')
  end subroutine kinematics_keys

  !> Visits these keys.
  subroutine register_kinematics_keys(registry)
    type(registry_t), intent(inout), target :: registry
    type(body_motion_choices_t) :: motion
    type(kinematics_choices_t) :: unused
    type(keys_t) :: keys
    keys = declaring(registry)
    call kinematics_keys(keys, motion, unused)
  end subroutine register_kinematics_keys

  !> Returns what the user chose.
  function kinematics_choices(config) result(c)
    type(config_t), intent(in), target :: config
    type(kinematics_choices_t) :: c
    type(body_motion_choices_t) :: motion
    type(keys_t) :: keys
    keys = reading(config)
    call kinematics_keys(keys, motion, c)
  end function kinematics_choices

  !> Returns the body at the start.
  subroutine read_body(config, body)
    type(config_t), intent(in) :: config
    type(body_t), intent(out) :: body
    type(kinematics_choices_t) :: c
    real(rp) :: attitude(3)
    c = kinematics_choices(config)
    body%centre = c%centre
    attitude = c%attitude*(PI/180)
    body%angles = attitude([3, 2, 1])
    body%rotation = body_rotation(roll=angle_t(value=attitude(3)), pitch=angle_t(value=attitude(2)), &
                                  yaw=angle_t(value=attitude(1)))
  end subroutine read_body

  !> Moves a body whose centre is in a periodic image of the box, of size `box` [L], to its image inside, with a notice.
  subroutine keep_in_box(config, box, body, notices)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: box(3)
    type(body_t), intent(inout) :: body
    type(message_list_t), intent(inout) :: notices
    associate (x => body%centre)
      if (all(x >= 0 .and. x <= box) .or. any(x < -box .or. x > 2*box)) return
      where (x < 0 .or. x > box) x = modulo(x, box)
      call config%complain(notices, SECTION, 'x0', 'is outside of the box; the body starts at its periodic image, at '// &
                           number_text(x(1))//' '//number_text(x(2))//' '//number_text(x(3)))
    end associate
  end subroutine keep_in_box

  !> Returns the mounts of the left and the right wing on the body, and the common parameters of their motions. With `errors`, it
  !> reports hinges at the same point, and a left hinge that is not on the left.
  subroutine read_mounts(config, pivot, mounts, motions, errors)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: pivot(3) !< L, hinge of the left wing in the body frame, if the user gives none
    type(wing_mount_t), intent(out) :: mounts(2)
    type(wing_motion_t), intent(out) :: motions(2)
    type(message_list_t), intent(inout), optional :: errors
    type(kinematics_choices_t) :: c
    c = kinematics_choices(config)
    mounts%eta = c%eta*(PI/180)
    mounts(1)%hinge = pivot
    mounts(2)%hinge = pivot*[1, -1, 1]
    if (c%has_hinge(1)) mounts(1)%hinge = c%hinge(:, 1)
    if (c%has_hinge(2)) mounts(2)%hinge = c%hinge(:, 2)
    mounts(2)%is_right = .true.
    motions%frequency = c%frequency
    motions%ramp = c%ramp
    if (.not. present(errors)) return
    if (norm2(mounts(1)%hinge - mounts(2)%hinge) <= 0) call config%complain(errors, SECTION, 'x_pivot_r', &
                                            'is the same point as x_pivot_l; valid: two different hinges, the left one at '// &
                                            'larger y')
    if (mounts(1)%hinge(2) < mounts(2)%hinge(2)) call config%complain(errors, SECTION, 'x_pivot_l', &
                              'is to the right of x_pivot_r, but the y axis of the body points to the left; valid: the left '// &
                              'hinge at larger y')
  end subroutine read_mounts

  !> Returns the name of the file with the motion of a wing (1 left, 2 right); it is empty if the motion needs none.
  function motion_file(config, wing) result(path)
    type(config_t), intent(in) :: config
    integer, intent(in) :: wing
    character(:), allocatable :: path
    type(kinematics_choices_t) :: c
    c = kinematics_choices(config)
    path = c%motion(wing)%word
    if (any(path == [character(17) :: 'from_file', 'from_file_hermite', 'kinematics_loader'])) then
      path = c%file
    else if (index(path, '::') > 0) then
      path = path(index(path, '::') + 2:)
    else
      path = ''
    end if
  end function motion_file

  !> Fills the series of the motion of a wing, by its name or from `text`, the content of its file called `name`.
  subroutine read_motion(config, wing, text, name, motion, errors, notices)
    type(config_t), intent(in) :: config
    integer, intent(in) :: wing
    character(*), intent(in) :: text, name
    type(wing_motion_t), intent(inout) :: motion
    type(message_list_t), intent(inout) :: errors, notices
    type(kinematics_choices_t) :: c
    logical :: known
    c = kinematics_choices(config)
    call set_named_motion(c%motion(wing)%word, c%resting(1)*(PI/180), motion, known)
    if (.not. known) call read_file_motion(config, wing, c%motion(wing)%word, text, name, motion, errors, notices)
    call motion%phi%alter(c%factor(1), c%offset(1)*(PI/180), c%lead(1))
    call motion%alpha%alter(c%factor(2), c%offset(2)*(PI/180), c%lead(2))
    call motion%theta%alter(c%factor(3), c%offset(3)*(PI/180), c%lead(3))
    call motion%theta%add_wave(c%deviation(1)*(PI/180), c%deviation(2)*(PI/180))
  end subroutine read_motion

  !> Sets the motion that `word` names, from the text of its file.
  subroutine read_file_motion(config, wing, word, text, name, motion, errors, notices)
    type(config_t), intent(in) :: config
    integer, intent(in) :: wing
    character(*), intent(in) :: word, text, name
    type(wing_motion_t), intent(inout) :: motion
    type(message_list_t), intent(inout) :: errors, notices
    type(body_motion_choices_t) :: of_body
    if (word == 'takeoff') then
      of_body = body_motion_choices(config)
      if (of_body%word /= 'takeoff') call config%complain(errors, SECTION, &
        'FlappingMotion_'//trim(SIDES(wing)), 'is takeoff; valid: KineFromFile = yes beside it, or another motion')
      return ! the mistake in the take-off of the body has been reported
    end if
    if (index(word, TABLE_WORD) == 1 .or. word == 'kinematics_loader') then
      call read_motion_table(text, name, motion, errors)
    else
      call read_motion_file(text, name, motion, errors, notices)
    end if
  end subroutine read_file_motion
end module fsi_kinematics_keys

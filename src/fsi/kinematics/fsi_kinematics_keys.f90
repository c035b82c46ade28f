! SPDX-License-Identifier: GPL-3.0-or-later
!> The kinematic keys of [Insects], with FLUSI's names, and the loading of the files they name.
!>
!> Reading is in two steps, so that only one rank touches the disk: `read_mounts` tells which motion each
!> wing has; whoever has the text of its file hands it to `read_motion`.
module fsi_kinematics_keys
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_body_motion_keys, only: register_body_motion_keys
  use fsi_kinematics, only: body_rotation, body_t, wing_mount_t
  use fsi_named_motions, only: NAMED_MOTIONS, set_named_motion
  use fsi_rotation, only: angle_t
  use fsi_wing_motion, only: wing_motion_t
  use fsi_wing_motion_file, only: read_motion_file
  use fsi_wing_motion_table, only: read_motion_table
  use io_config, only: config_t
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_kinematics_keys, read_body, keep_in_box, read_mounts, read_motion, motion_file

  character(*), parameter :: SECTION = 'Insects'
  character(*), parameter :: FILE_WORD = 'from_file::', TABLE_WORD = 'kinematics_loader::'
  character(5), parameter, public :: SIDES(2) = ['left ', 'right']

contains

  !> Adds body attitude, hinges, stroke plane and motions of [Insects] to `registry`.
  subroutine register_kinematics_keys(registry)
    type(registry_t), intent(inout) :: registry
    real(rp), parameter :: ZERO(3) = 0.0_rp
    integer :: i
    call register_body_motion_keys(registry)
    call registry%add_reals(SECTION, 'x0', ZERO, 'centre of the body; flusi: if it is not given, that of the box', &
                            unit='L', length=3)
    call registry%add_reals(SECTION, 'yawpitchroll_0', ZERO, 'attitude of the body; positive pitch is nose down', &
                            unit='degree', length=3)
    call registry%add_real(SECTION, 'eta0', 0.0_rp, &
           'angle of the stroke plane in the body; -90: plane of the body axes x (forward) and y (left)', unit='degree')
    do i = 1, 2
      call registry%add_word(SECTION, 'FlappingMotion_'//trim(SIDES(i)), 'none', &
                             NAMED_MOTIONS//'|'//FILE_WORD//'*|'//TABLE_WORD//'*|from_file|from_file_hermite|kinematics_loader|'// &
                             'takeoff', &
                             'motion of the '//trim(SIDES(i))//' wing: one of FLUSI''s by name (docs/guide/kinematics.md), '// &
                             'series of [kinematics], table, the file that infile names, or none (alpha = 45 degrees, '// &
                             'at rest)', unbuilt='command-line*', instead='command-line*: from_file::NAME.ini with '// &
                             'the constant terms of alpha, phi and theta, for each run a file')
    end do
    call registry%add_text(SECTION, 'infile', 'none', 'file of a motion that is given as from_file or kinematics_loader')
    call registry%add_reals(SECTION, 'init_alpha_phi_theta', ZERO, 'the first is minus the angle alpha of '// &
                            'revolving-set2 and revolving-set3', unit='degree', length=3)
    call registry%add_reals(SECTION, 'x_pivot_l', ZERO, 'hinge of the left wing in the body frame; not given: '// &
                            'b_body beside the centre of the body, if there is one', unit='L', length=3)
    call registry%add_reals(SECTION, 'x_pivot_r', ZERO, 'hinge of the right wing in the body frame', unit='L', length=3)
    call registry%add_real(SECTION, 'wing_frequency', 1.0_rp, 'wing beats per unit of time', unit='1/T', above=0.0_rp)
    call registry%add_real(SECTION, 'wing_ramp', 0.0_rp, &
                     'the wings start at rest and reach their motion after this time; 0: at once', unit='T', min=0.0_rp)
  end subroutine register_kinematics_keys

  !> The body at the start.
  subroutine read_body(config, body)
    type(config_t), intent(in) :: config
    type(body_t), intent(out) :: body
    real(rp) :: attitude(3)
    body%centre = config%get_reals(SECTION, 'x0')
    attitude = config%get_reals(SECTION, 'yawpitchroll_0')*(PI/180)
    body%angles = attitude([3, 2, 1])
    body%rotation = body_rotation(roll=angle_t(value=attitude(3)), pitch=angle_t(value=attitude(2)), &
                                  yaw=angle_t(value=attitude(1)))
  end subroutine read_body

  !> Moves a body whose centre is in one of the boxes beside the box, of size `box` [L], to its image inside, with a notice.
  subroutine keep_in_box(config, box, body, notices)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: box(3)
    type(body_t), intent(inout) :: body
    type(message_list_t), intent(inout) :: notices
    associate (x => body%centre)
      if (all(x >= 0 .and. x <= box) .or. any(x < -box .or. x > 2*box)) return
      where (x < 0 .or. x > box) x = modulo(x, box)
      call config%complain(notices, SECTION, 'x0', 'is outside of the box; the body is put to its image at '// &
                           number_text(x(1))//' '//number_text(x(2))//' '//number_text(x(3)))
    end associate
  end subroutine keep_in_box

  !> Left and right wing: how they hang on the body, and what all motions share. With `errors` complains if
  !> both hang at the same point or the left one is not on the left.
  subroutine read_mounts(config, pivot, mounts, motions, errors)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: pivot(3) !< L, hinge of the left wing in the body frame, where the user gives none
    type(wing_mount_t), intent(out) :: mounts(2)
    type(wing_motion_t), intent(out) :: motions(2)
    type(message_list_t), intent(inout), optional :: errors
    mounts%eta = config%get_real(SECTION, 'eta0')*(PI/180)
    mounts(1)%hinge = pivot
    mounts(2)%hinge = pivot*[1, -1, 1]
    if (config%is_given(SECTION, 'x_pivot_l')) mounts(1)%hinge = config%get_reals(SECTION, 'x_pivot_l')
    if (config%is_given(SECTION, 'x_pivot_r')) mounts(2)%hinge = config%get_reals(SECTION, 'x_pivot_r')
    mounts(2)%is_right = .true.
    motions%frequency = config%get_real(SECTION, 'wing_frequency')
    motions%ramp = config%get_real(SECTION, 'wing_ramp')
    if (.not. present(errors)) return
    if (norm2(mounts(1)%hinge - mounts(2)%hinge) <= 0) call config%complain(errors, SECTION, 'x_pivot_r', &
                                            'is the same point as x_pivot_l; valid: two hinges apart, left at larger y')
    if (mounts(1)%hinge(2) < mounts(2)%hinge(2)) call config%complain(errors, SECTION, 'x_pivot_l', &
                              'is to the right of x_pivot_r: y of the body points to the left; valid: left at larger y')
  end subroutine read_mounts

  !> Name of the file that the motion of a wing (1 left, 2 right) is in; empty if it needs none.
  function motion_file(config, wing) result(path)
    type(config_t), intent(in) :: config
    integer, intent(in) :: wing
    character(:), allocatable :: path
    path = config%get_word(SECTION, 'FlappingMotion_'//trim(SIDES(wing)))
    if (any(path == [character(17) :: 'from_file', 'from_file_hermite', 'kinematics_loader'])) then
      path = config%get_text(SECTION, 'infile')
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
    character(:), allocatable :: word
    real(rp) :: resting(3)
    logical :: known
    word = config%get_word(SECTION, 'FlappingMotion_'//trim(SIDES(wing)))
    resting = config%get_reals(SECTION, 'init_alpha_phi_theta')*(PI/180)
    call set_named_motion(word, resting(1), motion, known)
    if (known) return
    if (word == 'takeoff') then
      if (config%get_word(SECTION, 'BodyMotion') /= 'takeoff') call config%complain(errors, SECTION, &
        'FlappingMotion_'//trim(SIDES(wing)), 'is takeoff; valid: KineFromFile = yes beside it, or another motion')
      return ! why the take-off of the body cannot be has been reported
    end if
    if (index(word, TABLE_WORD) == 1 .or. word == 'kinematics_loader') then
      call read_motion_table(text, name, motion, errors)
    else
      call read_motion_file(text, name, motion, errors, notices)
    end if
  end subroutine read_motion
end module fsi_kinematics_keys

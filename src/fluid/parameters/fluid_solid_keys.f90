! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads solids and walls from the keys of [Geometry] and [Penalization].
module fluid_solid_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t, word_of
  use fluid_shapes, only: shape_t, LAST_SHAPE, NO_SHAPE, OBSTACLES, SHAPE_HELP, SHAPES
  use fluid_substitutes, only: FOR_CAVITIES, FOR_CHANNELS, FOR_MASKS, NO_MASKS
  use io_config, only: config_t
  use io_keys, only: keys_t
  implicit none
  private
  public :: box_t, solids_t, walls_t, geometry_keys, penalization_keys, check_solids, MASK_NONE, MASK_EMPTY, MASK_FILE, &
            MASK_INSECT, MASK_FLEXIBLE_WING, CHANNEL_NONE, CHANNEL_XY, CHANNEL_XY_SLIDING, CHANNEL_XZ_SLIDING

  !> Masks in addition to the shapes of fluid_shapes, whose kinds are masks, too.
  integer, parameter :: MASK_NONE = NO_SHAPE, MASK_EMPTY = LAST_SHAPE + 1, MASK_FILE = LAST_SHAPE + 2, &
                        MASK_INSECT = LAST_SHAPE + 3, MASK_FLEXIBLE_WING = LAST_SHAPE + 4
  character(*), parameter :: FILE_WORD = 'from_file::'
  type(named_kind_t), parameter :: MASKS(14) = [ &
    named_kind_t('none', MASK_NONE), named_kind_t('empty', MASK_EMPTY), named_kind_t('no', MASK_NONE), SHAPES, &
    named_kind_t(FILE_WORD//'*', MASK_FILE), named_kind_t('Insect', MASK_INSECT), named_kind_t('insect', MASK_INSECT), &
    named_kind_t('Flexible_wing', MASK_FLEXIBLE_WING)]

  integer, parameter :: CHANNEL_NONE = 0, CHANNEL_XY = 1, CHANNEL_XZ = 2, CHANNEL_XY_SLIDING = 3, CHANNEL_XZ_SLIDING = 4, &
                        CHANNEL_TUREK = 5
  type(named_kind_t), parameter :: CHANNELS(8) = [ &
    named_kind_t('no', CHANNEL_NONE), named_kind_t('xy', CHANNEL_XY), named_kind_t('xz', CHANNEL_XZ), &
    named_kind_t('xy_sliding', CHANNEL_XY_SLIDING), named_kind_t('xz_sliding', CHANNEL_XZ_SLIDING), &
    named_kind_t('turek', CHANNEL_TUREK), named_kind_t('0', CHANNEL_NONE), named_kind_t('1', CHANNEL_XY)]

  integer, parameter :: CAVITY_NO = 1, CAVITY_YES = 2
  type(named_kind_t), parameter :: CAVITIES(4) = [named_kind_t('no', CAVITY_NO), named_kind_t('yes', CAVITY_YES), &
                                                  named_kind_t('0', CAVITY_NO), named_kind_t('1', CAVITY_YES)]

  !> The periodic box.
  type :: box_t
    real(rp) :: length(3) = 0             !< L
    logical :: has_length(3) = .false.    !< the user gives it
  end type box_t

  !> Bodies by penalization, and the quantities that are computed for them.
  type :: solids_t
    logical :: is_on = .false.            !< there are solids or walls
    integer :: mask = MASK_NONE
    character(:), allocatable :: word     !< the word for it that the user gives
    integer :: obstacle = NO_SHAPE        !< a body at rest beside insects, or none
    logical :: is_moving = .false.        !< a layer above draws the body in every step
    logical :: may_move = .true.          !< the user does not forbid it
    real(rp) :: c_eta = 1.0e-2_rp         !< permeability, T
    logical :: has_c_eta = .false.        !< the user gives it
    real(rp) :: dt_fraction = 1           !< fraction of the stable step of explicit penalization that solids in free motion allow
    real(rp) :: us_fixed(3) = 0, omega = 0
    real(rp) :: centre(3) = 0, size = 0, alpha = 0, r1 = 1, r2 = 1
    logical :: has_centre(3) = .false.    !< the user gives the centre
    logical :: compute_forces = .true., periodic_torque = .false.
    logical :: unsteady_corrections = .false., has_corrections = .false. !< has_corrections: the user gives the former
  contains
    procedure :: shape => solids_shape
    procedure :: mask_word => solids_mask_word
    procedure :: mask_file => solids_mask_file
  end type solids_t

  !> Walls of the box: a cavity, or a channel.
  type :: walls_t
    logical :: has_cavity = .false.
    integer :: cavity_size = 0            !< points
    integer :: channel = CHANNEL_NONE
    real(rp) :: thickness = 0, position = 0 !< of the wall of a channel, L
    logical :: has_inflow = .false.       !< channel = turek
    real(rp) :: inflow_velocity = 1, inflow_length = 0, inflow_start = 0
    real(rp) :: cylinder(2:3) = 0         !< centre of the cylinder in this channel; the centre of `solids` may be that of an insect
  end type walls_t

contains

  !> Declares and reads the keys of [Geometry]: the `box`, and the body. If the centre of the body is not given, it is
  !> the centre of the box.
  subroutine geometry_keys(keys, box, s)
    type(keys_t), intent(inout) :: keys
    type(box_t), intent(inout) :: box
    type(solids_t), intent(inout) :: s
    real(rp), parameter :: LENGTH = 6.283185307179586_rp
    call keys%section('Geometry', 'the periodic box and the generic body', in_checkpoint=.true.)
    call keys%real('xl', box%length(1), LENGTH, 'length of the box in x', unit='L', above=0.0_rp, given=box%has_length(1))
    call keys%real('yl', box%length(2), LENGTH, 'length of the box in y', unit='L', above=0.0_rp, given=box%has_length(2))
    call keys%real('zl', box%length(3), LENGTH, 'length of the box in z', unit='L', above=0.0_rp, given=box%has_length(3))
    call keys%length('x0', s%centre(1), 'xl/2', 'centre of body or vortex, x', unit='L', given=s%has_centre(1))
    call keys%length('y0', s%centre(2), 'yl/2', 'centre of body or vortex, y', unit='L', given=s%has_centre(2))
    call keys%length('z0', s%centre(3), 'zl/2', 'centre of body or vortex, z', unit='L', given=s%has_centre(3))
    call keys%length('Size', s%size, '0.0', 'diameter of sphere and cylinder, side of the plate, radius of the ring', &
                     unit='L', min=0.0_rp)
    call keys%real('alpha', s%alpha, 0.0_rp, 'rotation of the plate about the z axis', unit='degree')
    call keys%real('r1', s%r1, 1.0_rp, 'inner radius of the couette body', unit='L', above=0.0_rp)
    call keys%real('r2', s%r2, 1.0681415_rp, 'outer radius of the couette body', unit='L', above=0.0_rp)
    call keys%inert('r3', 'used by a FLUSI body that does not exist here')
    where (.not. s%has_centre) s%centre = box%length/2
  end subroutine geometry_keys

  !> Declares and reads the keys of [Penalization].
  subroutine penalization_keys(keys, s, w)
    type(keys_t), intent(inout) :: keys
    type(solids_t), intent(inout) :: s
    type(walls_t), intent(inout) :: w
    integer :: cavity
    cavity = CAVITY_NO
    call keys%section('Penalization', 'solid bodies by volume penalization')
    call keys%switch('iPenalization', s%is_on, .false., 'whether there are solids at all')
    call keys%in_checkpoint()
    call keys%kind('iMask', s%mask, 'none', MASKS, 'body: '//SHAPE_HELP//'; mask from a file; Insect: the wings of [Insects]; '// &
                   'Flexible_wing: the same with wings = flexible', unbuilt=NO_MASKS, instead=FOR_MASKS, word=s%word)
    call keys%in_checkpoint()
    call keys%kind('obstacle', s%obstacle, 'none', OBSTACLES, 'iMask = Insect: a body at rest beside '// &
                   'the insect, with [Geometry] Size at x0, y0, z0; cylinder along z (2-D: along x) or x')
    call keys%switch('iMoving', s%may_move, .false., 'whether the body moves; the wings of Insect move; no effect on other '// &
                     'bodies', computed='as iMask says')
    call keys%in_checkpoint()
    call keys%real('eps', s%c_eta, 1.0e-2_rp, 'permeability C_eta', unit='T', above=0.0_rp, given=s%has_c_eta)
    call keys%kind('iCavity', cavity, 'no', CAVITIES, 'walls around the box, cavity_size points thick', unbuilt='freestream*', &
                   instead=FOR_CAVITIES)
    call keys%integer('cavity_size', w%cavity_size, 0, 'thickness of the cavity walls', unit='points', min=0)
    call keys%kind('iChannel', w%channel, 'no', CHANNELS, &
                   'one wall between pos_wall-thick_wall and pos_wall, normal z (xy) or y (xz); sliding: it moves with the '// &
                   'prescribed mean flow; turek: the wall xy, a parabolic inflow along y, and a cylinder along x with the '// &
                   'diameter [Geometry] Size at y0, z0; 0 = no, 1 = xy', unbuilt='inlet_x|cylinder', &
                   instead=FOR_CHANNELS)
    call keys%in_checkpoint()
    call keys%length('thick_wall', w%thickness, '0.2', 'thickness of the channel wall', unit='L', min=0.0_rp)
    call keys%length('pos_wall', w%position, '0.3', 'upper face of the channel wall', unit='L')
    call keys%real('inflow_velocity', w%inflow_velocity, 1.0_rp, 'turek: inflow velocity, averaged over the height of the '// &
                   'channel', unit='L/T', &
                   above=0.0_rp)
    call keys%length('inflow_length', w%inflow_length, '0.0', 'turek: length of the region at the end of y in which the '// &
                     'inflow is imposed', unit='L', &
                     min=0.0_rp)
    call keys%real('inflow_start', w%inflow_start, 0.0_rp, 'turek: duration over which the inflow grows from rest; 0: full '// &
                   'inflow from the beginning', unit='T', min=0.0_rp)
    call keys%switch('compute_forces', s%compute_forces, .true., 'write forces.t and the related time series')
    call keys%switch('unst_corrections', s%unsteady_corrections, .false., 'no effect on wings, whose unsteady correction is '// &
                     'exact and always written, or on bodies at rest. Free flight: if the file sets it to no, the insect '// &
                     'carries the fluid inside its mask along, as in FLUSI; if it is not given, it does not', &
                     given=s%has_corrections)
    call keys%switch('periodic', s%periodic_torque, .false., 'wrap lever arms of torques around the box')
    call keys%reals('us_fixed', s%us_fixed, [0.0_rp, 0.0_rp, 0.0_rp], 'velocity imposed inside the body', unit='L/T')
    call keys%real('omega', s%omega, 1.25_rp, 'angular velocity of the inner cylinder of the couette body', unit='1/T')
    s%is_moving = s%is_on .and. s%mask == MASK_INSECT
    w%has_cavity = cavity == CAVITY_YES
    w%has_inflow = s%is_on .and. w%channel == CHANNEL_TUREK
  end subroutine penalization_keys

  !> Adds mistakes of solids to `errors`.
  subroutine check_solids(c, s, w, errors)
    type(config_t), intent(in) :: c
    type(solids_t), intent(in) :: s
    type(walls_t), intent(in) :: w
    type(message_list_t), intent(inout) :: errors
    logical :: exists
    if (.not. s%is_on) return
    ! The reader of iMask has already reported a wrong mask. With iMoving FLUSI redraws bodies at rest in every step; the result
    ! is the same mask, so that the key has no effect here.
    if (s%is_moving .and. .not. s%may_move) call c%complain(errors, 'Penalization', 'iMoving', &
      'would hold the wings of Insect where they are at t = 0; valid: 1, for wings at rest with FlappingMotion_left and '// &
      'FlappingMotion_right = none')
    call check_bodies(c, s, w, errors)
    if (s%mask == MASK_FILE) then
      inquire (file=s%mask_file(), exist=exists)
      if (.not. exists) call c%complain(errors, 'Penalization', 'iMask', 'there is no file "'//s%mask_file()//'"')
    end if
    if (w%has_cavity .and. w%cavity_size == 0) &
      call c%complain(errors, 'Penalization', 'cavity_size', 'the cavity walls need a thickness of at least one point')
  end subroutine check_solids

  !> Returns the present name of the mask, also if the user gives its older name.
  pure function solids_mask_word(self) result(word)
    class(solids_t), intent(in) :: self
    character(:), allocatable :: word
    word = word_of(MASKS, self%mask)
    if (self%mask == MASK_FILE) word = self%word
  end function solids_mask_word

  !> Returns the name of the file that has the mask; it is empty if there is no such file.
  pure function solids_mask_file(self) result(path)
    class(solids_t), intent(in) :: self
    character(:), allocatable :: path
    path = ''
    if (self%mask == MASK_FILE) path = self%word(len(FILE_WORD) + 1:)
  end function solids_mask_file

  !> Returns the shape of the mask, or with an insect the shape of the obstacle beside it. Other masks have no shape.
  pure type(shape_t) function solids_shape(self) result(shape)
    class(solids_t), intent(in) :: self
    shape%kind = merge(self%obstacle, self%mask, self%mask == MASK_INSECT)
    if (shape%kind > LAST_SHAPE) shape%kind = NO_SHAPE
    shape%size = self%size
    shape%alpha = self%alpha
    shape%r1 = self%r1
    shape%r2 = self%r2
    shape%omega = self%omega
  end function solids_shape

  !> Checks the obstacle and the shape of [Geometry].
  subroutine check_bodies(c, s, w, errors)
    type(config_t), intent(in) :: c
    type(solids_t), intent(in) :: s
    type(walls_t), intent(in) :: w
    type(message_list_t), intent(inout) :: errors
    type(shape_t) :: shape
    character(:), allocatable :: key, text
    if (s%obstacle /= NO_SHAPE .and. .not. s%is_moving) call c%complain(errors, 'Penalization', 'obstacle', &
      'needs an insect (iMask = Insect) beside it; for a body without an insect set iMask = '//word_of(OBSTACLES, s%obstacle)// &
      ' and leave obstacle out')
    if (s%obstacle /= NO_SHAPE .and. w%has_inflow) call c%complain(errors, 'Penalization', 'obstacle', &
      'has no place beside iChannel = turek, which has its own cylinder; valid: none')
    shape = s%shape()
    call shape%mistake(key, text)
    if (key /= '') call c%complain(errors, 'Geometry', key, text)
    if (s%obstacle == NO_SHAPE .or. shape%kind == s%obstacle) return
    shape%kind = s%obstacle
    call shape%mistake(key, text)
    if (key /= '') call c%complain(errors, 'Geometry', key, text)
  end subroutine check_bodies
end module fluid_solid_keys

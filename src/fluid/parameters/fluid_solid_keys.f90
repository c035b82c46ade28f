! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads solids and walls from the keys of [Geometry] and [Penalization].
module fluid_solid_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fluid_shapes, only: shape_t, OBSTACLES, SHAPE_HELP, SHAPES
  use fluid_substitutes, only: FOR_CAVITIES, FOR_CHANNELS, FOR_MASKS, NO_MASKS
  use io_config, only: config_t
  use io_keys, only: keys_t
  implicit none
  private
  public :: solids_t, walls_t, geometry_keys, penalization_keys, check_solids

  !> Bodies by penalization, and what is computed of them.
  type :: solids_t
    logical :: is_on = .false.            !< there are solids or walls
    character(:), allocatable :: mask
    character(:), allocatable :: obstacle !< a body at rest in addition to insects, or none
    logical :: is_moving = .false.        !< a layer above draws the body in every step
    logical :: may_move = .true.          !< the user does not forbid it
    real(rp) :: c_eta = 1.0e-2_rp         !< permeability, T
    real(rp) :: dt_fraction = 1           !< of the largest step of the explicit penalization that solids which react allow
    real(rp) :: us_fixed(3) = 0, omega = 0
    real(rp) :: centre(3) = 0, size = 0, alpha = 0, r1 = 1, r2 = 1
    logical :: has_centre(3) = .false.    !< the user says where
    logical :: compute_forces = .true., periodic_torque = .false.
    logical :: unsteady_corrections = .false., has_corrections = .false. !< the latter: the user says which
  contains
    procedure :: body_name => solids_body_name
    procedure :: shape => solids_shape
  end type solids_t

  !> Walls of the box: a cavity, or a channel.
  type :: walls_t
    logical :: has_cavity = .false.
    integer :: cavity_size = 0            !< points
    character(:), allocatable :: channel
    real(rp) :: thickness = 0, position = 0 !< of the wall of a channel, L
    logical :: has_inflow = .false.       !< channel = turek
    real(rp) :: inflow_velocity = 1, inflow_length = 0, inflow_start = 0
    real(rp) :: cylinder(2:3) = 0         !< centre of the one in that channel; that of `solids` may become that of an insect
  end type walls_t

contains

  !> Declares and reads the keys of [Geometry]: the `length` of the box, and the body. Where the centre of the body is not given,
  !> it is that of the box.
  subroutine geometry_keys(keys, length, s)
    type(keys_t), intent(inout) :: keys
    real(rp), intent(inout) :: length(3)
    type(solids_t), intent(inout) :: s
    real(rp), parameter :: BOX = 6.283185307179586_rp
    call keys%section('Geometry', 'the periodic box and the generic body')
    call keys%real('xl', length(1), BOX, 'length of the box in x', unit='L', above=0.0_rp)
    call keys%real('yl', length(2), BOX, 'length of the box in y', unit='L', above=0.0_rp)
    call keys%real('zl', length(3), BOX, 'length of the box in z', unit='L', above=0.0_rp)
    call keys%length('x0', s%centre(1), 'xl/2', 'centre of body or vortex, x', unit='L', given=s%has_centre(1))
    call keys%length('y0', s%centre(2), 'yl/2', 'centre of body or vortex, y', unit='L', given=s%has_centre(2))
    call keys%length('z0', s%centre(3), 'zl/2', 'centre of body or vortex, z', unit='L', given=s%has_centre(3))
    call keys%length('Size', s%size, '0.0', 'diameter of sphere and cylinder, side of the plate, radius of the ring', &
                     unit='L', min=0.0_rp)
    call keys%real('alpha', s%alpha, 0.0_rp, 'turning of the plate about the z axis', unit='degree')
    call keys%real('r1', s%r1, 1.0_rp, 'inner radius of the couette body', unit='L', above=0.0_rp)
    call keys%real('r2', s%r2, 1.0681415_rp, 'outer radius of the couette body', unit='L', above=0.0_rp)
    call keys%inert('r3', 'used by a FLUSI body that does not exist here')
    where (.not. s%has_centre) s%centre = length/2
  end subroutine geometry_keys

  !> Declares and reads the keys of [Penalization].
  subroutine penalization_keys(keys, s, w)
    type(keys_t), intent(inout) :: keys
    type(solids_t), intent(inout) :: s
    type(walls_t), intent(inout) :: w
    character(:), allocatable :: cavity !< not allocated where keys are declared
    call keys%section('Penalization', 'solid bodies by volume penalization')
    call keys%switch('iPenalization', s%is_on, .false., 'whether there are solids at all')
    call keys%word('iMask', s%mask, 'none', &
                   'none|empty|no|'//SHAPES//'|from_file::*|Insect|insect|Flexible_wing', 'body: '//SHAPE_HELP//'; file; '// &
                   'Insect: the wings of [Insects]; Flexible_wing: these, with wings = flexible', unbuilt=NO_MASKS, &
                   instead=FOR_MASKS)
    call keys%word('obstacle', s%obstacle, 'none', 'none|'//OBSTACLES, 'iMask = Insect: a body at rest beside '// &
                   'the insect, with [Geometry] Size at x0, y0, z0; cylinder along z (2-D: along x) or x')
    call keys%switch('iMoving', s%may_move, .false., 'whether the body moves: the wings of Insect do; without effect on other '// &
                     'bodies', computed='as iMask says')
    call keys%real('eps', s%c_eta, 1.0e-2_rp, 'permeability C_eta', unit='T', above=0.0_rp)
    call keys%word('iCavity', cavity, 'no', 'no|yes|0|1', 'walls around the box, cavity_size points thick', unbuilt='freestream*', &
                   instead=FOR_CAVITIES)
    call keys%integer('cavity_size', w%cavity_size, 0, 'thickness of the cavity walls', unit='points', min=0)
    call keys%word('iChannel', w%channel, 'no', 'no|xy|xz|xy_sliding|xz_sliding|turek|0|1', &
                   'one wall between pos_wall-thick_wall and pos_wall, normal z (xy) or y (xz); sliding: it moves with the '// &
                   'prescribed mean flow; turek: the wall xy, with a parabola of the velocity that flows in along y, and a '// &
                   'cylinder along x of [Geometry] Size at y0, z0; 0 = no, 1 = xy', unbuilt='inlet_x|cylinder', &
                   instead=FOR_CHANNELS)
    call keys%length('thick_wall', w%thickness, '0.2', 'thickness of the channel wall', unit='L', min=0.0_rp)
    call keys%length('pos_wall', w%position, '0.3', 'upper face of the channel wall', unit='L')
    call keys%real('inflow_velocity', w%inflow_velocity, 1.0_rp, 'turek: mean over the height of the channel', unit='L/T', &
                   above=0.0_rp)
    call keys%length('inflow_length', w%inflow_length, '0.0', 'turek: the inflow is imposed on this last part of y', unit='L', &
                     min=0.0_rp)
    call keys%real('inflow_start', w%inflow_start, 0.0_rp, 'turek: time in which the inflow grows from rest; 0: it is there at '// &
                   'once', unit='T', min=0.0_rp)
    call keys%switch('compute_forces', s%compute_forces, .true., 'write forces.t and its relatives')
    call keys%switch('unst_corrections', s%unsteady_corrections, .false., 'without effect on wings: their unsteady correction '// &
                     'is exact and always written; other bodies do not move. Free flight: if it is set to no, the insect '// &
                     'carries the fluid in its mask along, as in FLUSI', given=s%has_corrections)
    call keys%switch('periodic', s%periodic_torque, .false., 'wrap lever arms of torques around the box')
    call keys%reals('us_fixed', s%us_fixed, [0.0_rp, 0.0_rp, 0.0_rp], 'velocity imposed inside the body', unit='L/T')
    call keys%real('omega', s%omega, 1.25_rp, 'angular velocity of the inner cylinder of the couette body', unit='1/T')
    if (allocated(cavity)) call settle_words(s, w, cavity)
  end subroutine penalization_keys

  !> Replaces names that mean the same by one of them, and sets what follows from them.
  subroutine settle_words(s, w, cavity)
    type(solids_t), intent(inout) :: s
    type(walls_t), intent(inout) :: w
    character(*), intent(in) :: cavity
    if (s%mask == 'insect') s%mask = 'Insect'
    if (s%mask == 'Sphere') s%mask = 'sphere'
    if (s%mask == 'Plate') s%mask = 'plate'
    if (s%mask == 'no') s%mask = 'none'
    s%is_moving = s%is_on .and. s%mask == 'Insect'
    w%has_cavity = any(cavity == ['yes', '1  '])
    if (w%channel == '0') w%channel = 'no'
    if (w%channel == '1') w%channel = 'xy'
    w%has_inflow = s%is_on .and. w%channel == 'turek'
  end subroutine settle_words

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
      'would hold the wings of Insect where they are at t = 0; valid: 1, and FlappingMotion_left and _right none')
    call check_bodies(c, s, w, errors)
    if (index(s%mask, 'from_file::') == 1) then
      inquire (file=s%mask(12:), exist=exists)
      if (.not. exists) call c%complain(errors, 'Penalization', 'iMask', 'there is no file "'//s%mask(12:)//'"')
    end if
    if (w%has_cavity .and. w%cavity_size == 0) &
      call c%complain(errors, 'Penalization', 'cavity_size', 'the cavity walls need a thickness of at least one point')
  end subroutine check_solids

  !> Returns the word for the body: that of the mask, or, for the body of an insect, that of the obstacle.
  pure function solids_body_name(self) result(name)
    class(solids_t), intent(in) :: self
    character(:), allocatable :: name
    name = self%mask
    if (self%mask == 'Insect') name = self%obstacle
  end function solids_body_name

  !> Returns that body as a shape.
  pure type(shape_t) function solids_shape(self) result(shape)
    class(solids_t), intent(in) :: self
    shape%name = self%body_name()
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
    if (s%obstacle /= 'none' .and. .not. s%is_moving) call c%complain(errors, 'Penalization', 'obstacle', &
      'needs an insect (iMask = Insect) beside it; for a body without an insect set iMask = '//s%obstacle// &
      ' and leave obstacle out')
    if (s%obstacle /= 'none' .and. w%has_inflow) call c%complain(errors, 'Penalization', 'obstacle', &
      'is of no use with iChannel = turek, which has a cylinder of its own; valid: none')
    shape = s%shape()
    call shape%mistake(key, text)
    if (key /= '') call c%complain(errors, 'Geometry', key, text)
    if (s%obstacle == 'none' .or. shape%name == s%obstacle) return
    shape%name = s%obstacle
    call shape%mistake(key, text)
    if (key /= '') call c%complain(errors, 'Geometry', key, text)
  end subroutine check_bodies
end module fluid_solid_keys

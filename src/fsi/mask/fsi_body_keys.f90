! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the keys of [Insects] that describe the body between the wings, with FLUSI's names.
module fsi_body_keys
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_body_catalogue, only: body_numbers_t, make_named_body, named_body_pivot, NAMED_BODIES
  use fsi_body_parts, only: make_revolution
  use fsi_closed_surface, only: make_closed_surface
  use fsi_kinematics_keys, only: kinematics_choices, kinematics_choices_t
  use fsi_mask_keys, only: mask_choices, mask_choices_t
  use fsi_rigid_body, only: rigid_body_t
  use fsi_scene, only: scene_t
  use fsi_solid_shape, only: shape_holder_t
  use fsi_stl, only: read_stl
  use fsi_wing_source, only: source_choices, source_choices_t
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  use io_broadcast_text, only: read_named_text
  use parallel_world, only: world_t
  implicit none
  private
  public :: body_choices_t, body_choices, body_keys, read_body_shape, wants_body, body_pivot

  character(*), parameter :: SECTION = 'Insects', FILE_WORD = 'from_file::', PROFILE = 'body_profile'
  character(*), parameter :: SURFACE = 'a closed surface, BodyType = from_file::NAME.stl'
  character(*), parameter :: UNBUILT = 'particle|birch_seed|pointcloud*'
  character(*), parameter :: INSTEAD = 'particle: BodyType = sphere, coin or ellipsoid, or '//SURFACE//'|birch_seed: '//SURFACE// &
                             '|pointcloud*: '//SURFACE

  type :: body_choices_t
    character(:), allocatable :: type
    type(body_numbers_t) :: numbers           !< lengths and radii
    character(:), allocatable :: head, left_eye, right_eye !< places
    character(:), allocatable :: details
    real(rp), allocatable :: profile(:, :)    !< rows x r
    real(rp) :: scale = 1                     !< of an STL file
    real(rp) :: smoothing = 0                 !< L, 0: not given
  end type body_choices_t

contains

  !> Declares and reads the keys of the body.
  subroutine body_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(body_choices_t), intent(inout) :: c
    call keys%section(SECTION)
    call keys%word('BodyType', c%type, 'nobody', 'nobody|'//NAMED_BODIES//'|revolution|'//FILE_WORD//'*', &
                   'body in the flow: one of FLUSI''s by name, a body of revolution (body_profile), or a closed surface from '// &
                   'an STL file', unbuilt=UNBUILT, instead=INSTEAD)
    call keys%in_checkpoint()
    call keys%length('L_body', c%numbers%length, '1.0', 'length of the bodies ellipsoid, sphere (diameter) and platicle', &
                     unit='L', above=0.0_rp)
    call keys%length('b_body', c%numbers%radius, '0.1', 'radius of the body ellipsoid, side of pyramid and cone; hinges that '// &
                     'are not given lie at this distance beside the centre of the body', unit='L', above=0.0_rp)
    call keys%length('R_head', c%numbers%head_radius, '0.0', 'radius of the head of the body ellipsoid; 0: none', unit='L', &
                     min=0.0_rp)
    call keys%length('R_eye', c%numbers%eye_radius, '0.0', 'radius of the eyes of the body ellipsoid; 0: none', unit='L', &
                     min=0.0_rp)
    call keys%text('x_head', c%head, 'none', 'centre of the head of the body ellipsoid, in the body frame; none: L_body/2 0 0')
    call keys%text('x_eye_l', c%left_eye, 'none', 'centre of the left eye of the body ellipsoid; none: on the head')
    call keys%text('x_eye_r', c%right_eye, 'none', 'centre of the right eye of the body ellipsoid; none: on the head')
    call keys%text('HasDetails', c%details, 'all', 'no: a bumblebee without legs, antennae and proboscis')
    call keys%matrix('body_profile', c%profile, 2, 'BodyType = revolution: rows x r of ascending positions along the x axis '// &
                     'of the body, and radii')
    call keys%in_checkpoint()
    call keys%real('body_scale', c%scale, 1.0_rp, 'length of one unit of an STL file', unit='L', above=0.0_rp)
    call keys%in_checkpoint()
    call keys%length('body_smoothing', c%smoothing, 'max(dx)', 'half the width of the smoothing layer of the mask at the body', &
                     unit='L', above=0.0_rp)
    call keys%inert('HasEye', 'R_eye says whether there are eyes')
    call keys%inert('HasHead', 'R_head says whether there is a head')
  end subroutine body_keys

  !> Returns what the user chose.
  function body_choices(config) result(c)
    type(config_t), intent(in), target :: config
    type(body_choices_t) :: c
    type(keys_t) :: keys
    keys = reading(config)
    call body_keys(keys, c)
  end function body_choices

  !> Tells whether the mask contains a body.
  logical function wants_body(config)
    type(config_t), intent(in) :: config
    type(body_choices_t) :: c
    c = body_choices(config)
    wants_body = c%type /= 'nobody'
  end function wants_body

  !> Makes the body, if there is one. Mistakes go to `errors`. With `world` the root rank reads files for all, and the call is
  !> collective.
  subroutine read_body_shape(config, scene, body, errors, notices, world)
    type(config_t), intent(in) :: config
    type(scene_t), intent(in) :: scene
    type(rigid_body_t), intent(inout) :: body
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(shape_holder_t), allocatable :: parts(:)
    type(body_choices_t) :: c
    type(body_numbers_t) :: numbers
    real(rp) :: extent(3)
    integer :: errors_before, i
    c = body_choices(config)
    if (c%type == 'nobody') return
    errors_before = errors%count()
    numbers = complete_numbers(config, c, scene, errors)
    if (index(c%type, FILE_WORD) == 1) then
      call read_surface(config, c%type(len(FILE_WORD) + 1:), c%scale/scene%file_unit, numbers%smoothing, parts, errors, &
                        notices, world)
    else if (c%type == 'revolution') then
      call take_revolution(config, c%profile, scene%file_unit, parts, errors)
    else
      call make_named_body(c%type, numbers, parts)
    end if
    if (errors%count() > errors_before) return
    extent = size_of(parts) + 2*numbers%smoothing
    do i = merge(2, 1, scene%grid%is_2d), 3
      if (extent(i) > maxval(scene%grid%length)) then
        call config%complain(errors, SECTION, 'BodyType', 'is larger than the box: it extends over '// &
                             number_text(extent(i))//' L, and the box over '//number_text(maxval(scene%grid%length))//' L')
        return ! its moments are sums over cells of this grid, which would take minutes
      end if
    end do
    call body%init(parts, numbers%smoothing)
    if (minval(body%high - body%low) < 2*scene%grid%max_spacing() .and. .not. scene%grid%is_2d) &
      call config%complain(notices, SECTION, 'BodyType', 'gives a body that is thinner than two grid spacings somewhere: '// &
                           'use a finer grid')
  end subroutine read_body_shape

  !> Returns the extent of all parts in x, y and z, L.
  pure function size_of(parts) result(extent)
    type(shape_holder_t), intent(in) :: parts(:)
    real(rp) :: extent(3), low(3), high(3)
    integer :: i
    low = huge(1.0_rp)
    high = -huge(1.0_rp)
    do i = 1, size(parts)
      low = min(low, parts(i)%shape%low)
      high = max(high, parts(i)%shape%high)
    end do
    extent = high - low
  end function size_of

  !> Returns the place [L] of the left wing's hinge if x_pivot_l is not given.
  function body_pivot(config) result(pivot)
    type(config_t), intent(in) :: config
    real(rp) :: pivot(3)
    type(body_choices_t) :: c
    c = body_choices(config)
    pivot = 0
    if (c%type /= 'nobody') pivot = named_body_pivot(c%type, c%numbers)
  end function body_pivot

  !> Returns the numbers of the user, and those that follow from other keys.
  function complete_numbers(config, c, scene, errors) result(numbers)
    type(config_t), intent(in) :: config
    type(body_choices_t), intent(in) :: c
    type(scene_t), intent(in) :: scene
    type(message_list_t), intent(inout) :: errors
    type(body_numbers_t) :: numbers
    type(mask_choices_t) :: mask
    type(source_choices_t) :: source
    type(kinematics_choices_t) :: kinematics
    real(rp) :: on_head
    numbers = c%numbers
    numbers%head = [numbers%length/2, 0.0_rp, 0.0_rp]
    call take_place(config, 'x_head', c%head, scene%file_unit, numbers%head, errors)
    on_head = sin(PI/4)*0.8_rp*numbers%head_radius
    numbers%eyes(:, 1) = numbers%head + on_head*[1, -1, 1]
    numbers%eyes(:, 2) = numbers%head + on_head*[1, 1, 1]
    call take_place(config, 'x_eye_l', c%left_eye, scene%file_unit, numbers%eyes(:, 1), errors)
    call take_place(config, 'x_eye_r', c%right_eye, scene%file_unit, numbers%eyes(:, 2), errors)
    source = source_choices(config)
    numbers%span = source%numbers%span
    if (c%type == 'platicle' .and. numbers%span <= 0) &
      call config%complain(errors, SECTION, 'L_span', 'is 0: platicle needs a positive length')
    mask = mask_choices(config)
    numbers%thickness = 4*scene%grid%max_spacing()
    if (mask%has_thickness) numbers%thickness = mask%thickness
    kinematics = kinematics_choices(config)
    numbers%eta = kinematics%eta*PI/180
    numbers%has_legs = any(c%details == [character(18) :: 'all', 'legs', 'antennae_proboscis'])
    numbers%smoothing = scene%grid%max_spacing()
    if (c%smoothing > 0) numbers%smoothing = c%smoothing
  end function complete_numbers

  !> Reads three numbers, which FLUSI's files may leave empty.
  subroutine take_place(config, key, text, file_unit, place, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: key, text
    real(rp), intent(in) :: file_unit
    real(rp), intent(inout) :: place(3)
    type(message_list_t), intent(inout) :: errors
    real(rp) :: given(3)
    integer :: status
    if (text == 'none' .or. text == '') return
    read (text, *, iostat=status) given
    if (status == 0) then
      place = given/file_unit
    else
      call config%complain(errors, SECTION, key, '"'//text//'" are not three numbers')
    end if
  end subroutine take_place

  !> Makes a closed surface from an STL file, one unit of which is `scale` [L].
  subroutine read_surface(config, name, scale, smoothing, parts, errors, notices, world)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: name
    real(rp), intent(in) :: scale, smoothing
    type(shape_holder_t), allocatable, intent(out) :: parts(:)
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    character(:), allocatable :: path, text, problem
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    integer :: errors_before
    errors_before = errors%count()
    call read_named_text(name, config%file_name(), path, text, problem, world)
    if (allocated(problem)) then
      call config%complain(errors, SECTION, 'BodyType', problem)
      return
    end if
    call read_stl(text, path, points, triangles, errors, notices)
    if (errors%count() > errors_before) return
    points = points*scale
    allocate (parts(1))
    allocate (parts(1)%shape, source=make_closed_surface(points, triangles, smoothing))
  end subroutine read_surface

  !> Makes a body of revolution from rows x r in units of the file, or adds an error.
  subroutine take_revolution(config, rows, file_unit, parts, errors)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: rows(:, :), file_unit
    type(shape_holder_t), allocatable, intent(out) :: parts(:)
    type(message_list_t), intent(inout) :: errors
    integer :: i, n
    if (size(rows) == 0) then
      call config%complain(errors, SECTION, PROFILE, 'is missing: BodyType = revolution needs rows x r')
      return
    end if
    n = size(rows, 1)
    if (n < 2 .or. any([(rows(i + 1, 1) <= rows(i, 1), i=1, n - 1)]) .or. any(rows(:, 2) < 0) .or. &
        maxval(rows(:, 2)) <= 0) then
      call config%complain(errors, SECTION, PROFILE, 'needs at least two rows x r with ascending x and r >= 0')
      return
    end if
    allocate (parts(1))
    allocate (parts(1)%shape, source=make_revolution(transpose(rows)/file_unit))
  end subroutine take_revolution
end module fsi_body_keys

! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the keys of [Insects] that describe the body beside the wings, with FLUSI's names.
module fsi_body_keys
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_body_catalogue, only: body_numbers_t, make_named_body, named_body_pivot, NAMED_BODIES
  use fsi_body_parts, only: make_revolution
  use fsi_closed_surface, only: make_closed_surface
  use fsi_rigid_body, only: rigid_body_t
  use fsi_solid_shape, only: shape_holder_t
  use fsi_stl, only: read_stl
  use io_config, only: config_t
  use io_registry, only: registry_t
  use io_broadcast_text, only: read_named_text
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: register_body_keys, read_body_shape, wants_body, body_pivot

  character(*), parameter :: SECTION = 'Insects', FILE_WORD = 'from_file::'
  character(*), parameter :: SURFACE = 'a closed surface, BodyType = from_file::NAME.stl'
  character(*), parameter :: UNBUILT = 'particle|birch_seed|pointcloud*'
  character(*), parameter :: INSTEAD = 'particle: BodyType = sphere, coin or ellipsoid, or '//SURFACE//'|birch_seed: '//SURFACE// &
                             '|pointcloud*: '//SURFACE

contains

  !> Declares the keys.
  subroutine register_body_keys(registry)
    type(registry_t), intent(inout) :: registry
    call registry%add_word(SECTION, 'BodyType', 'nobody', 'nobody|'//NAMED_BODIES//'|revolution|'//FILE_WORD//'*', &
                           'body in the flow: one of FLUSI''s by name, a body of revolution (body_profile), or a '// &
                           'closed surface from an STL file', unbuilt=UNBUILT, instead=INSTEAD)
    call registry%add_length(SECTION, 'L_body', '1.0', 'length of the bodies ellipsoid, sphere (diameter) and platicle', &
                             unit='L', above=0.0_rp)
    call registry%add_length(SECTION, 'b_body', '0.1', 'radius of the body ellipsoid, side of pyramid and cone; hinges '// &
                             'that are not given are that far beside the centre of a body', unit='L', above=0.0_rp)
    call registry%add_length(SECTION, 'R_head', '0.0', 'radius of the head of the body ellipsoid; 0: none', unit='L', &
                             min=0.0_rp)
    call registry%add_length(SECTION, 'R_eye', '0.0', 'radius of its eyes; 0: none', unit='L', min=0.0_rp)
    call registry%add_text(SECTION, 'x_head', 'none', 'centre of its head in the body frame; none: L_body/2 0 0')
    call registry%add_text(SECTION, 'x_eye_l', 'none', 'centre of its left eye; none: on the head')
    call registry%add_text(SECTION, 'x_eye_r', 'none', 'centre of its right eye; none: on the head')
    call registry%add_text(SECTION, 'HasDetails', 'all', 'no: a bumblebee without legs, antennae and proboscis')
    call registry%add_matrix(SECTION, 'body_profile', 2, 'BodyType = revolution: rows x r, places along the x axis of the '// &
                             'body, ascending, and radii')
    call registry%add_real(SECTION, 'body_scale', 1.0_rp, 'length of one unit of an STL file', unit='L', above=0.0_rp)
    call registry%add_length(SECTION, 'body_smoothing', 'max(dx)', 'half the width of the step of the mask at the body', &
                             unit='L', above=0.0_rp)
    call registry%add_inert(SECTION, 'HasEye', 'R_eye says whether there are eyes')
    call registry%add_inert(SECTION, 'HasHead', 'R_head says whether there is a head')
  end subroutine register_body_keys

  !> Whether there is a body in the mask.
  logical function wants_body(config)
    type(config_t), intent(in) :: config
    wants_body = config%get_word(SECTION, 'BodyType') /= 'nobody'
  end function wants_body

  !> Makes the body, if there is one. `file_unit` is one unit of length of the parameter file, L. With `world` root reads
  !> files, and this is collective.
  subroutine read_body_shape(config, ini, grid, file_unit, body, errors, notices, world)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: ini
    type(grid_t), intent(in) :: grid
    real(rp), intent(in) :: file_unit
    type(rigid_body_t), intent(inout) :: body
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(shape_holder_t), allocatable :: parts(:)
    type(body_numbers_t) :: numbers
    character(:), allocatable :: word
    real(rp) :: extent(3)
    integer :: errors_before, i
    if (.not. wants_body(config)) return
    errors_before = errors%count()
    word = config%get_word(SECTION, 'BodyType')
    numbers = read_numbers(config, grid, file_unit, errors)
    if (index(word, FILE_WORD) == 1) then
      call read_surface(config, word(len(FILE_WORD) + 1:), ini, file_unit, numbers%smoothing, parts, errors, notices, world)
    else if (word == 'revolution') then
      call read_revolution(config, file_unit, parts, errors)
    else
      call make_named_body(word, numbers, parts)
    end if
    if (errors%count() > errors_before) return
    extent = size_of(parts) + 2*numbers%smoothing
    do i = merge(2, 1, grid%is_2d), 3
      if (extent(i) > maxval(grid%length)) then
        call config%complain(errors, SECTION, 'BodyType', 'is larger than the box: it extends over '// &
                             number_text(extent(i))//' L, and the box over '//number_text(maxval(grid%length))//' L')
        return ! its moments are sums over cells of this grid, which would take minutes
      end if
    end do
    call body%init(parts, numbers%smoothing)
    if (minval(body%high - body%low) < 2*grid%max_spacing() .and. .not. grid%is_2d) &
      call config%complain(notices, SECTION, 'BodyType', 'is a body that is thinner than two grid spacings somewhere')
  end subroutine read_body_shape

  !> How far the parts extend together in x, y and z, L.
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

  !> Where the left wing hangs if x_pivot_l is not given, L.
  function body_pivot(config) result(pivot)
    type(config_t), intent(in) :: config
    real(rp) :: pivot(3)
    type(body_numbers_t) :: numbers
    numbers%radius = config%get_real(SECTION, 'b_body')
    pivot = 0
    if (wants_body(config)) pivot = named_body_pivot(config%get_word(SECTION, 'BodyType'), numbers)
  end function body_pivot

  function read_numbers(config, grid, file_unit, errors) result(numbers)
    type(config_t), intent(in) :: config
    type(grid_t), intent(in) :: grid
    real(rp), intent(in) :: file_unit
    type(message_list_t), intent(inout) :: errors
    type(body_numbers_t) :: numbers
    real(rp) :: on_head
    numbers%length = config%get_real(SECTION, 'L_body')
    numbers%radius = config%get_real(SECTION, 'b_body')
    numbers%head_radius = config%get_real(SECTION, 'R_head')
    numbers%eye_radius = config%get_real(SECTION, 'R_eye')
    numbers%head = [numbers%length/2, 0.0_rp, 0.0_rp]
    call read_place(config, 'x_head', file_unit, numbers%head, errors)
    on_head = sin(PI/4)*0.8_rp*numbers%head_radius
    numbers%eyes(:, 1) = numbers%head + on_head*[1, -1, 1]
    numbers%eyes(:, 2) = numbers%head + on_head*[1, 1, 1]
    call read_place(config, 'x_eye_l', file_unit, numbers%eyes(:, 1), errors)
    call read_place(config, 'x_eye_r', file_unit, numbers%eyes(:, 2), errors)
    numbers%span = config%get_real(SECTION, 'L_span')
    if (config%get_word(SECTION, 'BodyType') == 'platicle' .and. numbers%span <= 0) &
      call config%complain(errors, SECTION, 'L_span', 'is 0: platicle needs a positive length')
    numbers%thickness = 4*grid%max_spacing()
    if (config%is_given(SECTION, 'WingThickness')) numbers%thickness = config%get_real(SECTION, 'WingThickness')
    numbers%eta = config%get_real(SECTION, 'eta0')*PI/180
    numbers%has_legs = any(config%get_text(SECTION, 'HasDetails') == [character(18) :: 'all', 'legs', &
                                                                                      'antennae_proboscis'])
    numbers%smoothing = grid%max_spacing()
    if (config%is_given(SECTION, 'body_smoothing')) numbers%smoothing = config%get_real(SECTION, 'body_smoothing')
  end function read_numbers

  !> Three numbers, which FLUSI's files may leave empty.
  subroutine read_place(config, key, file_unit, place, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: key
    real(rp), intent(in) :: file_unit
    real(rp), intent(inout) :: place(3)
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: text
    real(rp) :: given(3)
    integer :: status
    text = config%get_text(SECTION, key)
    if (text == 'none' .or. text == '') return
    read (text, *, iostat=status) given
    if (status == 0) then
      place = given/file_unit
    else
      call config%complain(errors, SECTION, key, '"'//text//'" are not three numbers')
    end if
  end subroutine read_place

  subroutine read_surface(config, name, ini, file_unit, smoothing, parts, errors, notices, world)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: name, ini
    real(rp), intent(in) :: file_unit, smoothing
    type(shape_holder_t), allocatable, intent(out) :: parts(:)
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    character(:), allocatable :: path, text, problem
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    integer :: errors_before
    errors_before = errors%count()
    call read_named_text(name, ini, path, text, problem, world)
    if (allocated(problem)) then
      call config%complain(errors, SECTION, 'BodyType', problem)
      return
    end if
    call read_stl(text, path, points, triangles, errors, notices)
    if (errors%count() > errors_before) return
    points = points*(config%get_real(SECTION, 'body_scale')/file_unit)
    allocate (parts(1))
    allocate (parts(1)%shape, source=make_closed_surface(points, triangles, smoothing))
  end subroutine read_surface

  subroutine read_revolution(config, file_unit, parts, errors)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: file_unit
    type(shape_holder_t), allocatable, intent(out) :: parts(:)
    type(message_list_t), intent(inout) :: errors
    real(rp), allocatable :: rows(:, :)
    integer :: i, n
    rows = config%get_matrix(SECTION, 'body_profile')
    if (size(rows) == 0) then
      call config%complain(errors, SECTION, 'body_profile', 'is missing: BodyType = revolution needs rows x r')
      return
    end if
    n = size(rows, 1)
    if (n < 2 .or. any([(rows(i + 1, 1) <= rows(i, 1), i=1, n - 1)]) .or. any(rows(:, 2) < 0) .or. &
        maxval(rows(:, 2)) <= 0) then
      call config%complain(errors, SECTION, 'body_profile', 'needs at least two rows x r with ascending x and r >= 0')
      return
    end if
    allocate (parts(1))
    allocate (parts(1)%shape, source=make_revolution(transpose(rows)/file_unit))
  end subroutine read_revolution
end module fsi_body_keys

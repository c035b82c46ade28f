! SPDX-License-Identifier: GPL-3.0-or-later
!> Wings that flap in a flow, as the user gives them: where they hang, how they move, what they look like.
module fsi_flight_params
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_body_motion, only: body_motion_t
  use fsi_body_motion_keys, only: read_body_motion
  use fsi_flyer, only: flyer_params_t
  use fsi_flyer_keys, only: read_flyer, read_wing_mass, register_flyer_keys
  use fsi_kinematics, only: body_t, swap_flusi_wing, wing_mount_t
  use fsi_kinematics_keys, only: keep_in_box, motion_file, read_body, read_motion, read_mounts, register_kinematics_keys, SIDES
  use fsi_mask_keys, only: read_mask_keys, register_mask_keys
  use fsi_moments, only: moments_of_points, moments_t, second_of_inertia
  use fsi_planform, only: planform_t
  use fsi_planform_file, only: read_planform_text
  use fsi_planform_mesh, only: triangulate_planform
  use fsi_rotation, only: cross
  use fsi_thin_keys, only: read_thin_keys, register_thin_keys, thin_params_t
  use fsi_wing_motion, only: wing_motion_t
  use io_config, only: config_t
  use io_registry, only: registry_t
  use io_shared_text, only: named_path, read_named_text
  use parallel_world, only: world_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: load_wing, read_wing
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: flapping_wing_t, flight_params_t, register_flight_keys, read_flight_params

  character(*), parameter :: SECTION = 'Insects'
  character(*), parameter :: OUTLINE_WORD = 'from_file::', MESH_WORD = 'mesh::'
  integer, parameter, public :: COLOR_LEFT = 2, COLOR_RIGHT = 3

  !> One wing.
  type :: flapping_wing_t
    character(5) :: side = 'left'
    integer :: color = COLOR_LEFT
    type(wing_mount_t) :: mount
    type(wing_motion_t) :: motion
    real(rp), allocatable :: points(:, :)   !< (3, n) unloaded, in the wing frame, L
    integer, allocatable :: triangles(:, :) !< (3, m) counter-clockwise seen from +z
    real(rp) :: inertia(3, 3) = 0           !< about the hinge, in the wing frame, rho L^5
    type(moments_t) :: moments              !< of its mass, if it is rigid, about the hinge, in the wing frame
    logical :: is_mirrored = .false.        !< the wing is the mirror image of that in its file (fsi_wing_mirror)
  contains
    procedure :: length => wing_length
    procedure :: mean_chord => wing_mean_chord
  end type flapping_wing_t

  type :: flight_params_t
    type(body_t) :: body           !< at the start
    type(body_motion_t) :: motion  !< of the body
    type(flyer_params_t) :: flyer  !< of a free flight
    type(flapping_wing_t), allocatable :: wings(:)
    type(thin_params_t) :: thin    !< whether, and how, the wings are without thickness
    real(rp) :: half_thickness = 0 !< of the wings in the mask, L; 0 without a thickness
    real(rp) :: smoothing = 0      !< half the width of the mask's step, L
  contains
    procedure :: frequency => flight_frequency
    procedure :: tip_speed => flight_tip_speed
  end type flight_params_t

contains

  !> Adds every key of [Insects] and of the wings' mask to `registry`.
  subroutine register_flight_keys(registry)
    type(registry_t), intent(inout) :: registry
    integer :: i
    character(3), parameter :: INERTIA(4) = ['Jxx', 'Jyy', 'Jzz', 'Jxy']
    call registry%add_section(SECTION, 'flapping wings (iMask = Insect); docs/kinematics.md draws the frames')
    call registry%add_switch(SECTION, 'LeftWing', .true., 'there is a left wing')
    call registry%add_switch(SECTION, 'RightWing', .true., 'there is a right wing')
    call registry%add_word(SECTION, 'WingShape', 'none', OUTLINE_WORD//'*|'//MESH_WORD//'*|none', &
                           'planform file with section [Wing], or triangles of a wing file (docs/wing-format.md)', &
                           unbuilt='TwoEllipses|rectangular|suzuki|mosquito_iams|pointcloud|drosophila*|bumblebee|'// &
                           'b_ignitus|hawkmoth*|pieris*|flapper*|robofly*|paratuposa*')
    call registry%add_length(SECTION, 'wing_length', '0.0', 'the planform is scaled so that its largest x is this; '// &
                             '0: lengths of its file are in the units of this file; meshes are in metres', unit='L', &
                             min=0.0_rp)
    call registry%add_length(SECTION, 'wing_edge', 'max(dx, 1/40 of the wing)', &
                             'edge length of the triangles made from a planform', unit='L', above=0.0_rp)
    do i = 1, 4
      call registry%add_real(SECTION, INERTIA(i), 0.0_rp, 'inertia of a wing about its hinge, in FLUSI''s wing '// &
                             'frame (y to the tip, x to the leading edge)', unit='M L^2')
    end do
    call register_kinematics_keys(registry)
    call register_flyer_keys(registry)
    call registry%add_word(SECTION, 'BodyType', 'nobody', 'nobody', 'body in the flow', &
                           unbuilt='jerry|hawkmoth|particle|platicle|coin|sphere|drosophila*|bumblebee|paratuposa*|'// &
                           'mosquito*|pyramid|cone|birch_seed|suzuki*|ellipsoid')
    call registry%add_switch(SECTION, 'LeftWing2', .false., 'hind wing', unbuilt='a second pair of wings')
    call registry%add_switch(SECTION, 'RightWing2', .false., 'hind wing', unbuilt='a second pair of wings')
    call registry%add_switch(SECTION, 'wing_fsi', .false., 'passive wing', unbuilt='a passively rotating wing')
    call registry%add_inert(SECTION, 'HasDetails', 'details of a body')
    call registry%add_inert(SECTION, 'HasEye', 'details of a body')
    call registry%add_inert(SECTION, 'HasHead', 'details of a body')
    call registry%add_real(SECTION, 'body_pitch_const', 0.0_rp, 'BodyMotion = forward, hovering: nose up', unit='degree')
    call registry%add_real(SECTION, 'eta_stroke', 0.0_rp, 'BodyMotion = forward: stroke plane', unit='degree')
    call registry%add_inert(SECTION, 'KineFromFile', 'old name of the file of a motion')
    call registry%add_inert(SECTION, 'mass_solid', 'free flight')
    call registry%add_inert(SECTION, 'b_*', 'size of a body')
    call registry%add_inert(SECTION, 'L_*', 'size of a body or of a built-in wing')
    call registry%add_inert(SECTION, 'R_*', 'size of a body')
    call registry%add_inert(SECTION, 'x_head', 'place on a body')
    call registry%add_inert(SECTION, 'x_eye*', 'place on a body')
    call registry%add_inert(SECTION, 'gravity_*', 'other names of gravity')
    call registry%add_inert(SECTION, 'pointcloudfile', 'wing given by a cloud of points')
    call registry%add_inert(SECTION, 'infile2', 'second pair of wings')
    call registry%add_inert(SECTION, 'distance_from_sponge', 'sponge that moves with the body')
    call registry%add_inert(SECTION, 'WingShape2', 'second pair of wings')
    call registry%add_inert(SECTION, 'x_pivot_l2', 'second pair of wings')
    call registry%add_inert(SECTION, 'x_pivot_r2', 'second pair of wings')
    call registry%add_inert(SECTION, 'FlappingMotion_left2', 'second pair of wings')
    call registry%add_inert(SECTION, 'FlappingMotion_right2', 'second pair of wings')
    call register_mask_keys(registry)
    call register_thin_keys(registry)
  end subroutine register_flight_keys

  !> Reads the wings and the files they need; mistakes go to `errors`. `metre` is one metre in the units of the
  !> wings, 0 if unknown; `file_unit` one unit of length of the parameter file. With `world` root reads the
  !> files, and this is collective; `errors` then must be equal on all ranks.
  subroutine read_flight_params(config, ini, grid, t_end, metre, file_unit, params, errors, notices, world, mesh)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: ini            !< name of the parameter file
    type(grid_t), intent(in) :: grid
    real(rp), intent(in) :: t_end              !< end of the run, T
    real(rp), intent(in) :: metre, file_unit   !< L
    type(flight_params_t), intent(out) :: params
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(wing_t), intent(in), optional :: mesh !< the wing, in metres, if WingShape is none; empty: not readable
    type(wing_mount_t) :: mounts(2)
    type(wing_motion_t) :: motions(2)
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    logical :: is_there(2), z_is_dorsal
    integer :: i, n

    call read_body(config, params%body)
    call keep_in_box(config, grid%length, params%body, notices)
    call read_body_motion(config, ini, params%body, t_end, params%motion, errors, notices, world)
    call read_flyer(config, params%flyer, errors, notices)
    call read_thin_keys(config, grid, params%thin, notices)
    if (.not. params%thin%is_thin) call read_mask_keys(config, grid, params%half_thickness, params%smoothing, &
                                                         errors, notices)
    is_there = [config%get_switch(SECTION, 'LeftWing'), config%get_switch(SECTION, 'RightWing')]
    if (.not. any(is_there)) &
      call config%complain(errors, SECTION, 'LeftWing', 'there is no wing at all; valid: yes for LeftWing or RightWing')
    if (all(is_there)) then
      call read_mounts(config, mounts, motions, errors)
    else
      call read_mounts(config, mounts, motions) ! the other hinge does not matter
    end if
    call read_shape(config, ini, grid, metre, file_unit, points, triangles, z_is_dorsal, errors, notices, world, mesh)
    allocate (params%wings(count(is_there)))
    n = 0
    do i = 1, 2
      if (.not. is_there(i)) cycle
      n = n + 1
      associate (wing => params%wings(n))
        wing%side = SIDES(i)
        wing%color = merge(COLOR_LEFT, COLOR_RIGHT, i == 1)
        wing%mount = mounts(i)
        wing%motion = motions(i)
        wing%points = points
        wing%is_mirrored = wing%mount%mirrors(z_is_dorsal)
        if (wing%is_mirrored) wing%points(3, :) = -points(3, :)
        wing%triangles = triangles
        wing%inertia = read_inertia(config)
        wing%moments = read_moments(config, wing)
        call read_one_motion(config, ini, i, t_end, wing%motion, errors, notices, world)
      end associate
    end do
  end subroutine read_flight_params

  !> Inertia tensor in this program's wing frame, where mirror images have the same one: J has no products with z.
  function read_inertia(config) result(inertia)
    type(config_t), intent(in) :: config
    real(rp) :: inertia(3, 3), swap(3, 3), flusi(3, 3)
    real(rp), parameter :: UNIT(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])
    integer :: i
    flusi = 0
    flusi(1, 1) = config%get_real(SECTION, 'Jxx')
    flusi(2, 2) = config%get_real(SECTION, 'Jyy')
    flusi(3, 3) = config%get_real(SECTION, 'Jzz')
    flusi(1, 2) = config%get_real(SECTION, 'Jxy')
    flusi(2, 1) = flusi(1, 2)
    do i = 1, 3
      swap(:, i) = swap_flusi_wing(UNIT(:, i))
    end do
    inertia = matmul(swap, matmul(flusi, transpose(swap)))
  end function read_inertia

  !> Mass, first and second moment about the hinge of a rigid wing: its mass is spread evenly over its surface, and its
  !> inertia is that of the keys if they give one.
  function read_moments(config, wing) result(m)
    type(config_t), intent(in) :: config
    type(flapping_wing_t), intent(in) :: wing
    type(moments_t) :: m
    real(rp), allocatable :: area(:)
    integer :: i, k
    allocate (area(size(wing%points, 2)), source=0.0_rp)
    do i = 1, size(wing%triangles, 2)
      associate (c => wing%triangles(:, i), x => wing%points)
        do k = 1, 3
          area(c(k)) = area(c(k)) + norm2(cross(x(:, c(2)) - x(:, c(1)), x(:, c(3)) - x(:, c(1))))/6
        end do
      end associate
    end do
    m = moments_of_points(area, wing%points)
    if (.not. m%mass > 0) return
    associate (scale => read_wing_mass(config, m%mass, m%second(1, 1))/m%mass)
      m%mass = scale*m%mass
      m%first = scale*m%first
      m%second = scale*m%second
    end associate
    if (maxval(abs(wing%inertia)) > 0) m%second = second_of_inertia(wing%inertia)
  end function read_moments

  subroutine read_one_motion(config, ini, i, t_end, motion, errors, notices, world)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: ini
    integer, intent(in) :: i
    real(rp), intent(in) :: t_end
    type(wing_motion_t), intent(inout) :: motion
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    character(:), allocatable :: name, path, text, problem
    integer :: errors_before
    name = motion_file(config, i)
    text = ''
    path = ''
    errors_before = errors%count()
    if (name == 'none') then
      call config%complain(errors, SECTION, 'infile', 'is missing: FlappingMotion_'//trim(SIDES(i))//' needs a file')
      return
    else if (name /= '') then
      call read_named_text(name, ini, path, text, problem, world)
      if (allocated(problem)) then
        call config%complain(errors, SECTION, 'FlappingMotion_'//trim(SIDES(i)), problem)
        return
      end if
    end if
    call read_motion(config, i, text, path, motion, errors, notices)
    if (errors%count() == errors_before) call motion%check_span(t_end, path, errors)
  end subroutine read_one_motion

  !> Points and triangles of the wing, L, along axes of which z points to its dorsal side or not.
  subroutine read_shape(config, ini, grid, metre, file_unit, points, triangles, z_is_dorsal, errors, notices, world, &
                        mesh)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: ini
    type(grid_t), intent(in) :: grid
    real(rp), intent(in) :: metre, file_unit
    real(rp), allocatable, intent(out) :: points(:, :)
    integer, allocatable, intent(out) :: triangles(:, :)
    logical, intent(out) :: z_is_dorsal
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(wing_t), intent(in), optional :: mesh
    character(:), allocatable :: word, path, text, problem
    type(planform_t) :: planform
    type(wing_t) :: wing
    real(rp) :: length, edge
    integer :: errors_before
    allocate (points(3, 0), triangles(3, 0))
    z_is_dorsal = .false.
    errors_before = errors%count()
    word = config%get_word(SECTION, 'WingShape')
    length = config%get_real(SECTION, 'wing_length')
    if (index(word, OUTLINE_WORD) == 1) then
      call read_named_text(word(len(OUTLINE_WORD) + 1:), ini, path, text, problem, world)
      if (allocated(problem)) then
        call config%complain(errors, SECTION, 'WingShape', problem)
        return
      end if
      call read_planform_text(text, path, planform, errors, notices)
      if (errors%count() > errors_before) return
      planform%outline = planform%outline/file_unit
      if (length > 0) planform%outline = planform%outline*(length/maxval(planform%outline(1, :)))
      edge = max(grid%max_spacing(), maxval(planform%outline(1, :))/40)
      if (config%is_given(SECTION, 'wing_edge')) edge = config%get_real(SECTION, 'wing_edge')
      if (maxval(planform%outline(1, :)) < grid%max_spacing()) then
        call config%complain(errors, SECTION, 'wing_length', &
                             tip_text(length > 0)//number_text(maxval(planform%outline(1, :)))// &
                             ', less than one grid spacing from the hinge, which is '//number_text(grid%max_spacing()))
      else if (edge > maxval(planform%outline(1, :))) then
        call config%complain(errors, SECTION, 'wing_edge', 'is larger than the wing, whose tip is at x = '// &
                             number_text(maxval(planform%outline(1, :))))
      else
        call triangulate_planform(planform, edge, points, triangles)
        ! Chords of the outline cut its bulges; the mean chord is the planform's all the same.
        points(2, :) = points(2, :)*(planform%mean_chord()/mean_chord(points, triangles))
      end if
    else if (index(word, MESH_WORD) == 1) then
      path = named_path(word(len(MESH_WORD) + 1:), ini, world)
      if (path == '') then
        call config%complain(errors, SECTION, 'WingShape', &
                             'the wing file does not exist, neither here nor beside '//ini)
      else if (length <= 0 .and. metre <= 0) then
        call config%complain(errors, SECTION, 'wing_length', 'is needed: a wing file is in metres, and without '// &
                             '[units] length nothing tells what they are here')
      end if
      if (errors%count() > errors_before) return
      if (present(world)) then
        call load_wing(world, path, wing, errors)
      else
        call read_wing(path, wing, errors)
      end if
      if (errors%count() > errors_before) return
      if (length <= 0) length = metre*maxval(wing%points(1, :))
      call take_mesh(wing, length)
      if (size(triangles, 2) == 0) call config%complain(errors, SECTION, 'WingShape', path//' has no triangles')
    else if (present(mesh)) then
      if (.not. allocated(mesh%points)) return ! why not has been reported
      if (length <= 0) length = metre*maxval(mesh%points(1, :))
      call take_mesh(mesh, length)
    else
      call config%complain(errors, SECTION, 'WingShape', &
                           'is missing; valid: '//OUTLINE_WORD//'FILE | '//MESH_WORD//'FILE')
    end if

  contains

    function tip_text(is_scaled)
      logical, intent(in) :: is_scaled
      character(:), allocatable :: tip_text
      tip_text = 'is too small: the tip of the wing is at x = '
      if (.not. is_scaled) tip_text = 'is needed: the file of the planform has its tip at x = '
    end function tip_text

    !> The points of a mesh, scaled so that the tip is at x = tip.
    subroutine take_mesh(source, tip)
      type(wing_t), intent(in) :: source
      real(rp), intent(in) :: tip
      points = source%points*(tip/maxval(source%points(1, :)))
      triangles = source%triangles
      z_is_dorsal = source%z_is_dorsal()
    end subroutine take_mesh
  end subroutine read_shape

  !> Distance of the tip from the hinge along the wing, the largest x, L.
  pure real(rp) function wing_length(self) result(length)
    class(flapping_wing_t), intent(in) :: self
    length = maxval(self%points(1, :))
  end function wing_length

  !> Area of the triangles over their extent along x, L.
  pure real(rp) function wing_mean_chord(self) result(chord)
    class(flapping_wing_t), intent(in) :: self
    chord = mean_chord(self%points, self%triangles)
  end function wing_mean_chord

  pure real(rp) function mean_chord(points, triangles) result(chord)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: triangles(:, :)
    real(rp) :: area
    integer :: i
    area = 0
    do i = 1, size(triangles, 2)
      associate (a => points(:, triangles(1, i)), b => points(:, triangles(2, i)), c => points(:, triangles(3, i)))
        area = area + norm2(cross(b - a, c - a))/2
      end associate
    end do
    chord = area/(maxval(points(1, :)) - minval(points(1, :)))
  end function mean_chord

  !> Wing beats per T.
  pure real(rp) function flight_frequency(self) result(frequency)
    class(flight_params_t), intent(in) :: self
    frequency = self%wings(1)%motion%frequency
  end function flight_frequency

  !> Mean speed of the wing tips on the arc of their stroke, the largest of all wings, L/T: 2 (amplitude) R f; with
  !> the motion of a table, which may turn for ever, the arc of its last cycle times R f.
  real(rp) function flight_tip_speed(self) result(speed)
    class(flight_params_t), intent(in) :: self
    integer :: i
    speed = 0
    do i = 1, size(self%wings)
      associate (wing => self%wings(i))
        speed = max(speed, wing%motion%frequency*wing%motion%stroke_path()*wing%length())
      end associate
    end do
  end function flight_tip_speed
end module fsi_flight_params

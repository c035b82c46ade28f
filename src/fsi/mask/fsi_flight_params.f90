! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the wings that flap in a flow: their hinges, their motion, their shape.
module fsi_flight_params
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_body_keys, only: body_pivot, read_body_shape, register_body_keys, wants_body
  use fsi_body_motion, only: body_motion_t
  use fsi_body_motion_keys, only: read_body_motion
  use fsi_flyer, only: flyer_params_t
  use fsi_flyer_keys, only: read_flyer, read_wing_mass, register_flyer_keys
  use fsi_kinematics, only: body_t, swap_flusi_wing, wing_mount_t
  use fsi_kinematics_keys, only: keep_in_box, motion_file, read_body, read_motion, read_mounts, register_kinematics_keys, SIDES
  use fsi_mask_keys, only: read_mask_keys, register_mask_keys
  use fsi_moments, only: moments_of_points, moments_t, second_of_inertia
  use fsi_rigid_body, only: rigid_body_t
  use fsi_rotation, only: cross
  use fsi_thin_keys, only: read_thin_keys, register_thin_keys, thin_params_t
  use fsi_solid_shape, only: shape_holder_t, solid_shape_t
  use fsi_wing_motion, only: wing_motion_t
  use fsi_wing_solids, only: fourier_wing_t
  use fsi_wing_source, only: draws_to_outline, mean_chord, read_wing_shape, register_wing_source
  use io_config, only: config_t
  use io_registry, only: registry_t
  use io_broadcast_text, only: read_named_text
  use parallel_world, only: world_t
  use solid_wing, only: wing_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: flapping_wing_t, flight_params_t, register_flight_keys, read_flight_params

  character(*), parameter :: SECTION = 'Insects'
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
    type(rigid_body_t) :: solid             !< in the wing frame, of a rigid wing drawn up to its outline
    logical :: is_mirrored = .false.        !< the wing is the mirror image of that in its file (fsi_wing_mirror)
  contains
    procedure :: length => wing_length
    procedure :: mean_chord => wing_mean_chord
  end type flapping_wing_t

  type :: flight_params_t
    type(body_t) :: body           !< at the start
    type(body_motion_t) :: motion  !< of the body
    type(rigid_body_t) :: solid    !< the body, if it is in the mask
    type(flyer_params_t) :: flyer  !< of a free flight
    type(flapping_wing_t), allocatable :: wings(:)
    real(rp) :: beats = 1          !< of all wings per T
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
    character(*), parameter :: SECOND_PAIR = 'a second pair of wings', ONE_PAIR = 'LeftWing and RightWing alone, or, where '// &
                               'fore and hind wing beat as one, the outline of both in WingShape = from_file::NAME.ini'
    character(3), parameter :: INERTIA(4) = ['Jxx', 'Jyy', 'Jzz', 'Jxy']
    call registry%add_section(SECTION, 'flapping wings (iMask = Insect); docs/guide/kinematics.md draws the frames')
    call registry%add_switch(SECTION, 'LeftWing', .true., 'there is a left wing')
    call registry%add_switch(SECTION, 'RightWing', .true., 'there is a right wing')
    call register_wing_source(registry)
    do i = 1, 4
      call registry%add_real(SECTION, INERTIA(i), 0.0_rp, 'inertia of a wing about its hinge, in FLUSI''s wing '// &
                             'frame (y to the tip, x to the leading edge)', unit='M L^2')
    end do
    call register_kinematics_keys(registry)
    call register_flyer_keys(registry)
    call register_body_keys(registry)
    call registry%add_switch(SECTION, 'LeftWing2', .false., 'hind wing', unbuilt=SECOND_PAIR, instead=ONE_PAIR)
    call registry%add_switch(SECTION, 'RightWing2', .false., 'hind wing', unbuilt=SECOND_PAIR, instead=ONE_PAIR)
    call registry%add_switch(SECTION, 'wing_fsi', .false., 'passive wing', unbuilt='a wing that the flow turns about its root', &
                             instead='wings = flexible, whose root is as soft as the joints of the wing file make it')
    call registry%add_real(SECTION, 'body_pitch_const', 0.0_rp, 'BodyMotion = forward, hovering: nose up', unit='degree')
    call registry%add_real(SECTION, 'eta_stroke', 0.0_rp, 'BodyMotion = forward: stroke plane', unit='degree')
    call registry%add_inert(SECTION, 'mass_solid', 'free flight')
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
    class(solid_shape_t), allocatable :: solid
    logical :: is_there(2), z_is_dorsal, edges
    integer :: i, n

    call read_body_and_mask(config, ini, grid, t_end, file_unit, params, errors, notices, world)
    is_there = [config%get_switch(SECTION, 'LeftWing'), config%get_switch(SECTION, 'RightWing')]
    if (.not. any(is_there)) then
      allocate (params%wings(0))
      if (params%thin%is_thin) call read_mask_keys(config, grid, params%half_thickness, params%smoothing, errors, notices)
      params%thin%is_thin = .false.
      if (.not. wants_body(config)) call config%complain(errors, SECTION, 'LeftWing', &
        'there is neither a wing nor a body; valid: yes for LeftWing or RightWing, or a BodyType')
      return
    end if
    if (all(is_there)) then
      call read_mounts(config, body_pivot(config), mounts, motions, errors)
    else
      call read_mounts(config, body_pivot(config), mounts, motions) ! the other hinge does not matter
    end if
    edges = draws_to_outline(config, params%thin%is_thin)
    call notice_edges(config, params%thin%is_thin, notices)
    call read_wing_shape(config, ini, grid, metre, file_unit, points, triangles, z_is_dorsal, solid, &
                         merge(0.0_rp, 2*params%half_thickness, config%get_word(SECTION, 'wings') == 'flexible'), &
                         params%smoothing, edges, errors, notices, world, mesh)
    if (edges .and. .not. allocated(solid)) call complain_edges(config, errors)
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
        if (allocated(solid)) call make_solid(wing%solid, solid, params%smoothing, wing%is_mirrored)
        wing%inertia = read_inertia(config)
        wing%moments = read_moments(config, wing)
        call read_one_motion(config, ini, i, t_end, wing%motion, errors, notices, world)
      end associate
    end do
  end subroutine read_flight_params

  !> The body, its motion and shape, and how the wings are drawn.
  subroutine read_body_and_mask(config, ini, grid, t_end, file_unit, params, errors, notices, world)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: ini
    type(grid_t), intent(in) :: grid
    real(rp), intent(in) :: t_end, file_unit
    type(flight_params_t), intent(inout) :: params
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    logical :: is_soft
    call read_body(config, params%body)
    call keep_in_box(config, grid%length, params%body, notices)
    call read_body_motion(config, ini, params%body, t_end, params%motion, errors, notices, world)
    call read_flyer(config, params%flyer, errors, notices)
    call read_thin_keys(config, grid, params%thin, notices)
    is_soft = config%get_word(SECTION, 'wing_edges') == 'flusi' .and. draws_to_outline(config, params%thin%is_thin)
    if (.not. params%thin%is_thin) call read_mask_keys(config, grid, params%half_thickness, params%smoothing, &
                                                         errors, notices, is_soft)
    call read_body_shape(config, ini, grid, file_unit, params%solid, errors, notices, world)
    params%beats = config%get_real(SECTION, 'wing_frequency')
  end subroutine read_body_and_mask

  subroutine complain_edges(config, errors)
    type(config_t), intent(in) :: config
    type(message_list_t), intent(inout) :: errors
    if (errors%count() > 0) return
    if (config%get_word(SECTION, 'wing_edges') == 'round') then
      call config%complain(errors, SECTION, 'wing_edges', 'is round, which needs a flat wing in space (nx > 1); valid for '// &
                           'this wing: beyond')
    else
      call config%complain(errors, SECTION, 'wing_edges', 'is flusi, which needs the outline of one of FLUSI''s wings by '// &
                           'name, or a Fourier outline from a file; valid for this wing: beyond, or round if it is flat')
    end if
  end subroutine complain_edges

  !> Says which wing `round` is, and where a word has no effect.
  subroutine notice_edges(config, is_thin, notices)
    type(config_t), intent(in) :: config
    logical, intent(in) :: is_thin
    type(message_list_t), intent(inout) :: notices
    if (config%get_word(SECTION, 'wing_edges') == 'auto') return
    if (is_thin .or. config%get_word(SECTION, 'wings') == 'flexible') then
      call config%complain(notices, SECTION, 'wing_edges', 'is of no effect: it is for rigid wings in the mask, wings = rigid '// &
                           'with surface = penalized')
    else if (config%get_word(SECTION, 'wing_edges') == 'round') then
      call config%complain(notices, SECTION, 'wing_edges', 'is round: the wing ends at its outline; beyond is the wing that '// &
                           'reaches half its thickness farther')
    end if
  end subroutine notice_edges

  subroutine make_solid(solid, shape, smoothing, is_mirrored)
    type(rigid_body_t), intent(inout) :: solid
    class(solid_shape_t), intent(in) :: shape
    real(rp), intent(in) :: smoothing
    logical, intent(in) :: is_mirrored
    type(shape_holder_t), allocatable :: parts(:)
    allocate (parts(1))
    allocate (parts(1)%shape, source=shape)
    select type (wing => parts(1)%shape)
    type is (fourier_wing_t)
      if (is_mirrored) wing%side = -1
    end select
    call solid%init(parts, smoothing)
  end subroutine make_solid

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

  !> Wing beats per T.
  pure real(rp) function flight_frequency(self) result(frequency)
    class(flight_params_t), intent(in) :: self
    frequency = self%beats
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

! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the flapping wings: their hinges, motion and shape.
module fsi_flight_params
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fsi_body_keys, only: body_pivot, read_body_shape, wants_body
  use fsi_body_motion, only: body_motion_t
  use fsi_body_motion_keys, only: read_body_motion
  use fsi_flight_keys, only: flight_choices, flight_choices_t
  use fsi_flyer, only: flyer_params_t
  use fsi_flyer_keys, only: flyer_choices, flyer_choices_t, read_flyer
  use fsi_kinematics, only: body_t, swap_flusi_wing, wing_mount_t
  use fsi_kinematics_keys, only: keep_in_box, kinematics_choices, kinematics_choices_t, motion_file, read_body, read_motion, &
                                 read_mounts, SIDES
  use fsi_mask_keys, only: read_mask_keys
  use fsi_landmarks, only: landmarks_t
  use fsi_moments, only: moments_of_points, moments_t, second_of_inertia
  use fsi_rigid_body, only: rigid_body_t
  use fsi_rotation, only: cross
  use fsi_scene, only: scene_t
  use fsi_thin_keys, only: read_thin_keys, thin_params_t
  use fsi_solid_shape, only: shape_holder_t, solid_shape_t
  use fsi_wing_motion, only: wing_motion_t
  use fsi_wing_solids, only: fourier_wing_t
  use fsi_wing_source, only: draws_to_outline, drawing_t, mean_chord, read_wing_shape, source_choices, &
                             source_choices_t, wing_form_t, EDGES_AUTO, EDGES_FLUSI, EDGES_ROUND
  use fsi_wings_key, only: has_flexible_wings
  use io_config, only: config_t
  use io_broadcast_text, only: read_named_text
  use parallel_world, only: world_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: flapping_wing_t, flight_params_t, read_flight_params

  character(*), parameter :: SECTION = 'Insects', EDGES = 'wing_edges'
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
    type(landmarks_t) :: landmarks          !< whose path a run saves
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
    logical :: has_wing_mass = .false., has_jxx = .false. !< the user states mass or inertia of rigid wings
  contains
    procedure :: frequency => flight_frequency
    procedure :: tip_speed => flight_tip_speed
  end type flight_params_t

contains

  !> Reads the wings and the files that they need. Mistakes go to `errors`. With `world` the root rank reads the files for all,
  !> and the call is collective; `errors` must then be equal on all ranks.
  subroutine read_flight_params(config, scene, params, errors, notices, world, mesh)
    type(config_t), intent(in) :: config
    type(scene_t), intent(in) :: scene
    type(flight_params_t), intent(out) :: params
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(wing_t), intent(in), optional :: mesh !< the wing, in metres, if WingShape is none; empty: not readable
    type(flight_choices_t) :: c
    type(flyer_choices_t) :: flyer
    type(drawing_t) :: drawing
    type(wing_form_t) :: form
    c = flight_choices(config)
    flyer = flyer_choices(config)
    params%has_wing_mass = flyer%has_wing_mass
    params%has_jxx = c%has_inertia(1)
    call read_body_and_mask(config, scene, params, errors, notices, world)
    if (.not. any(c%has_wing)) then
      allocate (params%wings(0))
      if (params%thin%is_thin) call read_mask_keys(config, scene%grid, params%half_thickness, params%smoothing, errors, notices)
      params%thin%is_thin = .false.
      if (.not. wants_body(config)) call config%complain(errors, SECTION, 'LeftWing', &
        'there is neither a wing nor a body; valid: yes for LeftWing or RightWing, or a BodyType')
      return
    end if
    allocate (params%wings(count(c%has_wing)))
    call hang_wings(config, c%has_wing, params%wings, errors)
    drawing%ends_at_outline = draws_to_outline(config, params%thin%is_thin)
    call notice_edges(config, params%thin%is_thin, notices)
    drawing%thickness = merge(0.0_rp, 2*params%half_thickness, has_flexible_wings(config))
    drawing%smoothing = params%smoothing
    call read_wing_shape(config, scene, drawing, form, errors, notices, world, mesh)
    if (drawing%ends_at_outline .and. .not. allocated(form%solid)) call complain_edges(config, errors)
    call shape_wings(c, flyer, form, params)
    call move_wings(config, scene%t_end, params%wings, errors, notices, world)
  end subroutine read_flight_params

  !> Reads the sides, the hinges, and the common parameters of all motions.
  subroutine hang_wings(config, is_there, wings, errors)
    type(config_t), intent(in) :: config
    logical, intent(in) :: is_there(2)
    type(flapping_wing_t), intent(inout) :: wings(:)
    type(message_list_t), intent(inout) :: errors
    type(wing_mount_t) :: mounts(2)
    type(wing_motion_t) :: motions(2)
    integer :: i, n
    if (all(is_there)) then
      call read_mounts(config, body_pivot(config), mounts, motions, errors)
    else
      call read_mounts(config, body_pivot(config), mounts, motions) ! the position of the other hinge has no effect
    end if
    n = 0
    do i = 1, 2
      if (.not. is_there(i)) cycle
      n = n + 1
      wings(n)%side = SIDES(i)
      wings(n)%color = merge(COLOR_LEFT, COLOR_RIGHT, i == 1)
      wings(n)%mount = mounts(i)
      wings(n)%motion = motions(i)
    end do
  end subroutine hang_wings

  !> Makes points, triangles, solids, inertia and mass of the wings.
  subroutine shape_wings(c, flyer, form, params)
    type(flight_choices_t), intent(in) :: c
    type(flyer_choices_t), intent(in) :: flyer
    type(wing_form_t), intent(in) :: form
    type(flight_params_t), intent(inout) :: params
    integer :: i
    do i = 1, size(params%wings)
      associate (wing => params%wings(i))
        wing%points = form%points
        wing%is_mirrored = wing%mount%mirrors(form%z_is_dorsal)
        if (wing%is_mirrored) wing%points(3, :) = -form%points(3, :)
        wing%triangles = form%triangles
        if (allocated(form%solid)) call make_solid(wing%solid, form%solid, params%smoothing, wing%is_mirrored)
        wing%inertia = inertia_of(c%inertia)
        wing%moments = moments_of(flyer, c%inertia(1), wing)
      end associate
    end do
  end subroutine shape_wings

  !> Reads the motions of the wings. With `world` root reads files for all, and the call is collective.
  subroutine move_wings(config, t_end, wings, errors, notices, world)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: t_end
    type(flapping_wing_t), intent(inout) :: wings(:)
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    integer :: i
    do i = 1, size(wings)
      call read_one_motion(config, merge(1, 2, wings(i)%color == COLOR_LEFT), t_end, wings(i)%motion, errors, notices, world)
    end do
  end subroutine move_wings

  !> Reads the body, its motion and shape, and how the wings are drawn.
  subroutine read_body_and_mask(config, scene, params, errors, notices, world)
    type(config_t), intent(in) :: config
    type(scene_t), intent(in) :: scene
    type(flight_params_t), intent(inout) :: params
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(source_choices_t) :: source
    type(kinematics_choices_t) :: kinematics
    logical :: is_soft
    call read_body(config, params%body)
    call keep_in_box(config, scene%grid%length, params%body, notices)
    kinematics = kinematics_choices(config)
    params%beats = kinematics%frequency
    call read_body_motion(config, params%body, scene%t_end, params%beats, params%motion, errors, notices, world)
    call read_flyer(config, params%flyer, errors, notices)
    call read_thin_keys(config, scene%grid, params%thin, notices)
    source = source_choices(config)
    is_soft = source%edges == EDGES_FLUSI .and. draws_to_outline(config, params%thin%is_thin)
    if (.not. params%thin%is_thin) call read_mask_keys(config, scene%grid, params%half_thickness, params%smoothing, &
                                                       errors, notices, is_soft)
    call read_body_shape(config, scene, params%solid, errors, notices, world)
  end subroutine read_body_and_mask

  !> Adds an error if this wing cannot have the requested edges.
  subroutine complain_edges(config, errors)
    type(config_t), intent(in) :: config
    type(message_list_t), intent(inout) :: errors
    type(source_choices_t) :: c
    if (errors%count() > 0) return
    c = source_choices(config)
    if (c%edges == EDGES_ROUND) then
      call config%complain(errors, SECTION, EDGES, 'is round, which works for flat wings in three dimensions (nx > 1) '// &
                           'only; valid for this wing: beyond')
    else
      call config%complain(errors, SECTION, EDGES, 'is flusi, which needs one of FLUSI''s wings by name, or a Fourier outline '// &
                           'from a file; valid for this wing: beyond, or round if it is flat')
    end if
  end subroutine complain_edges

  !> Adds a notice if the key of the edges has no effect, or if it makes the wings end at their outline.
  subroutine notice_edges(config, is_thin, notices)
    type(config_t), intent(in) :: config
    logical, intent(in) :: is_thin
    type(message_list_t), intent(inout) :: notices
    type(source_choices_t) :: c
    c = source_choices(config)
    if (c%edges == EDGES_AUTO) return
    if (is_thin .or. has_flexible_wings(config)) then
      call config%complain(notices, SECTION, EDGES, 'has no effect here: it is for rigid wings in the mask (wings = rigid '// &
                           'with surface = penalized); remove it')
    else if (c%edges == EDGES_ROUND) then
      call config%complain(notices, SECTION, EDGES, 'is round: the round edges end at the outline of the wing; set beyond if '// &
                           'they should reach half the thickness beyond it')
    end if
  end subroutine notice_edges

  !> Makes the rigid body of one wing. Mirrored wings of FLUSI are turned over.
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

  !> Returns the inertia tensor in this program's wing frame, where mirror images have the same one: J has no products with z.
  pure function inertia_of(j) result(inertia)
    real(rp), intent(in) :: j(4) !< Jxx, Jyy, Jzz, Jxy
    real(rp) :: inertia(3, 3), swap(3, 3), flusi(3, 3)
    real(rp), parameter :: UNIT(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])
    integer :: i
    flusi = 0
    flusi(1, 1) = j(1)
    flusi(2, 2) = j(2)
    flusi(3, 3) = j(3)
    flusi(1, 2) = j(4)
    flusi(2, 1) = flusi(1, 2)
    do i = 1, 3
      swap(:, i) = swap_flusi_wing(UNIT(:, i))
    end do
    inertia = matmul(swap, matmul(flusi, transpose(swap)))
  end function inertia_of

  !> Returns mass, first and second moment about the hinge of a rigid wing. Its mass is spread evenly over its surface, and its
  !> inertia is that of the keys if they give one.
  function moments_of(flyer, jxx, wing) result(m)
    type(flyer_choices_t), intent(in) :: flyer
    real(rp), intent(in) :: jxx
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
    associate (scale => flyer%mass_of_wing(jxx, m%mass, m%second(1, 1))/m%mass)
      m%mass = scale*m%mass
      m%first = scale*m%first
      m%second = scale*m%second
    end associate
    if (maxval(abs(wing%inertia)) > 0) m%second = second_of_inertia(wing%inertia)
  end function moments_of

  !> Reads the motion of wing `i` from its file, or adds an error.
  subroutine read_one_motion(config, i, t_end, motion, errors, notices, world)
    type(config_t), intent(in) :: config
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
      call read_named_text(name, config%file_name(), path, text, problem, world)
      if (allocated(problem)) then
        call config%complain(errors, SECTION, 'FlappingMotion_'//trim(SIDES(i)), problem)
        return
      end if
    end if
    call read_motion(config, i, text, path, motion, errors, notices)
    if (errors%count() == errors_before) call motion%check_span(t_end, path, errors)
  end subroutine read_one_motion

  !> Returns the distance [L] of the tip from the hinge along the wing, the largest x.
  pure real(rp) function wing_length(self) result(length)
    class(flapping_wing_t), intent(in) :: self
    length = maxval(self%points(1, :))
  end function wing_length

  !> Returns the area of the triangles over their extent along x [L].
  pure real(rp) function wing_mean_chord(self) result(chord)
    class(flapping_wing_t), intent(in) :: self
    chord = mean_chord(self%points, self%triangles)
  end function wing_mean_chord

  !> Returns the number of wing beats per T.
  pure real(rp) function flight_frequency(self) result(frequency)
    class(flight_params_t), intent(in) :: self
    frequency = self%beats
  end function flight_frequency

  !> Returns the mean speed [L/T] of the wing tips on the arc of their stroke, the largest of all wings: 2 (amplitude) R f. With a
  !> table, which may describe a revolving wing, it is the arc of the last cycle times R f.
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

! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the shape of a wing: one of FLUSI's wings by name, a planform file, a wing file, or the wing of [Wing].
module fsi_wing_source
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: kind_of, named_kind_t, words_of
  use base_text, only: number_text
  use fsi_free_edges, only: find_free_edges
  use fsi_named_wings, only: has_chord, has_span, make_named_wing, NAMED_WINGS, wing_numbers_t
  use fsi_planform, only: planform_t
  use fsi_planform_file, only: read_planform_text
  use fsi_planform_mesh, only: triangulate_planform, triangulate_star
  use fsi_rotation, only: cross
  use fsi_round_wing, only: make_round_wing
  use fsi_scene, only: scene_t
  use fsi_solid_shape, only: solid_shape_t
  use fsi_wings_key, only: has_flexible_wings
  use fsi_wing_solids, only: make_fourier_wing
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  use io_broadcast_text, only: named_path, read_named_text
  use parallel_world, only: world_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: load_wing, read_wing
  implicit none
  private
  public :: source_choices_t, source_choices, source_keys, draws_to_outline, drawing_t, wing_form_t, &
            read_wing_shape, mean_chord, EDGES_AUTO, EDGES_FLUSI, EDGES_ROUND, SOURCE_NONE

  character(*), parameter :: SECTION = 'Insects'
  real(rp), parameter :: FLAT = 1.0e-9_rp !< of the length; smaller heights count as 0
  character(*), parameter :: OUTLINE_WORD = 'from_file::', MESH_WORD = 'mesh::'
  character(*), parameter :: SHAPE = 'WingShape', LENGTH = 'wing_length', STRETCH_KEY = 'wing_stretch'

  !> Sources of the shape; a name of FLUSI has the kind 0.
  integer, parameter :: SOURCE_NAME = 0, SOURCE_NONE = 1, SOURCE_OUTLINE = 2, SOURCE_MESH = 3
  type(named_kind_t), parameter :: SOURCES(3) = [named_kind_t(OUTLINE_WORD//'*', SOURCE_OUTLINE), &
                                                 named_kind_t(MESH_WORD//'*', SOURCE_MESH), named_kind_t('none', SOURCE_NONE)]

  integer, parameter :: EDGES_AUTO = 1, EDGES_FLUSI = 2, EDGES_ROUND = 3, EDGES_BEYOND = 4
  type(named_kind_t), parameter :: EDGES(4) = [named_kind_t('auto', EDGES_AUTO), named_kind_t('flusi', EDGES_FLUSI), &
                                               named_kind_t('round', EDGES_ROUND), named_kind_t('beyond', EDGES_BEYOND)]

  type :: source_choices_t
    character(:), allocatable :: shape   !< WingShape
    integer :: source = SOURCE_NONE      !< what that means, SOURCE_*
    integer :: edges = EDGES_AUTO        !< wing_edges
    real(rp) :: length = 0, edge = 0     !< L, 0: not given
    real(rp) :: stretch(2) = 1           !< factors along x and y of the finished wing
    type(wing_numbers_t) :: numbers
  end type source_choices_t

  !> How wings are drawn.
  type :: drawing_t
    real(rp) :: thickness = 0            !< of rigid wings in the mask, L; 0: of no use
    real(rp) :: smoothing = 0            !< L
    logical :: ends_at_outline = .false. !< requested; otherwise wings with Fourier outlines do so unless the file says beyond
  end type drawing_t

  !> A wing, L, along axes of which z points to its dorsal side or not.
  type :: wing_form_t
    real(rp), allocatable :: points(:, :)   !< (3, n)
    integer, allocatable :: triangles(:, :) !< (3, m)
    logical :: z_is_dorsal = .false.
    class(solid_shape_t), allocatable :: solid !< the wing up to its outline, if it is drawn so
  end type wing_form_t

contains

  !> Declares and reads the keys of the shape of the wings.
  subroutine source_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(source_choices_t), intent(inout) :: c
    call keys%section(SECTION)
    call keys%word('WingShape', c%shape, 'none', words_of(SOURCES)//'|'//NAMED_WINGS, &
                   'one of FLUSI''s wings by name, planform file with section [Wing], or triangles of a wing file '// &
                   '(docs/formats/wing-format.md)', unbuilt='pointcloud*|whitney_wood', instead='pointcloud*: the triangles of '// &
                   'the wing in a wing file, WingShape = mesh::NAME.h5, or its outline, WingShape = '// &
                   'from_file::NAME.ini|whitney_wood: its outline, WingShape = from_file::NAME.ini')
    call keys%in_checkpoint()
    if (allocated(c%shape)) c%source = kind_of(SOURCES, c%shape)
    call keys%length('wing_length', c%length, '0.0', 'the planform is scaled so that its largest x is this; 0: the lengths in '// &
                     'the file of the planform are in the units of this file; meshes are in metres', unit='L', min=0.0_rp)
    call keys%in_checkpoint()
    call keys%length('wing_edge', c%edge, 'max(dx, 1/40 of the wing)', 'edge length of the triangles made from a planform', &
                     unit='L', above=0.0_rp)
    call keys%length('L_span', c%numbers%span, '1.0', 'WingShape = rectangular, TwoEllipses, mosquito_iams: from hinge to tip; '// &
                     'BodyType = platicle: its extent along x', unit='L', min=0.0_rp)
    call keys%length('b_top', c%numbers%front, '0.0', 'WingShape = rectangular, TwoEllipses: chord before the axis', unit='L', &
                     min=0.0_rp)
    call keys%length('b_bot', c%numbers%back, '0.0', 'WingShape = rectangular, TwoEllipses: chord behind the axis', unit='L', &
                     min=0.0_rp)
    call keys%reals(STRETCH_KEY, c%stretch, [1.0_rp, 1.0_rp], 'factors on the lengths of rigid wings along x (span; chord of '// &
                    'a section) and y (chord), about the hinge', min=0.0_rp)
    call keys%in_checkpoint()
    call keys%inert('L_chord', 'chord that no wing of FLUSI uses')
    call keys%kind('wing_edges', c%edges, 'auto', EDGES, 'edges of rigid wings in the mask. flusi: smoothed edges at the '// &
                   'outline, as FLUSI draws them; round: round edges that end at the outline; beyond: round edges that reach '// &
                   'half the thickness beyond the outline; auto: flusi for FLUSI''s wings by name and for Fourier outlines '// &
                   'from files, else beyond')
  end subroutine source_keys

  !> Returns what the user chose.
  function source_choices(config) result(c)
    type(config_t), intent(in), target :: config
    type(source_choices_t) :: c
    type(keys_t) :: keys
    keys = reading(config)
    call source_keys(keys, c)
  end function source_choices

  !> Tells whether the keys alone, before a file is read, determine that rigid wings in the mask end at their outline.
  logical function draws_to_outline(config, is_thin) result(draws)
    type(config_t), intent(in) :: config
    logical, intent(in) :: is_thin
    type(source_choices_t) :: c
    c = source_choices(config)
    draws = any(c%edges == [EDGES_FLUSI, EDGES_ROUND])
    if (c%edges == EDGES_AUTO) draws = c%source == SOURCE_NAME
    draws = draws .and. .not. is_thin .and. .not. has_flexible_wings(config)
  end function draws_to_outline

  !> Makes the wing that the keys describe, or with WingShape = none the wing `mesh`, in metres, which is empty if its file is not
  !> readable. Mistakes go to `errors`. With `world` the root rank reads files for all, and the call is collective.
  subroutine read_wing_shape(config, scene, drawing, form, errors, notices, world, mesh)
    type(config_t), intent(in) :: config
    type(scene_t), intent(in) :: scene
    type(drawing_t), intent(in) :: drawing
    type(wing_form_t), intent(out) :: form
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(wing_t), intent(in), optional :: mesh
    type(source_choices_t) :: c
    type(planform_t) :: planform
    integer :: errors_before
    allocate (form%points(3, 0), form%triangles(3, 0))
    errors_before = errors%count()
    c = source_choices(config)
    select case (c%source)
    case (SOURCE_NAME)
      call take_named(config, c, drawing, planform, form%solid, errors)
      call take_planform(config, c, scene, drawing, planform, form, errors)
    case (SOURCE_OUTLINE)
      call read_outline(config, c, scene, planform, errors, notices, world)
      if (errors%count() > errors_before) return
      if (allocated(planform%fourier%ai)) call take_fourier(config, c, drawing, planform, form%solid, notices)
      call take_planform(config, c, scene, drawing, planform, form, errors)
    case (SOURCE_MESH)
      call read_mesh(config, c, scene, drawing, form, errors, world)
    case default
      if (.not. present(mesh)) then
        call config%complain(errors, SECTION, SHAPE, 'is missing; valid: '//OUTLINE_WORD//'FILE | '//MESH_WORD//'FILE')
      else if (allocated(mesh%points)) then ! the mistake has been reported
        call take_mesh(mesh, c, scene, drawing, form)
      end if
    end select
    if (errors%count() == errors_before .and. any(abs(c%stretch - 1) > 0)) call stretch_wing(config, c%stretch, form, errors)
  end subroutine read_wing_shape

  !> Stretches a wing that is made of triangles alone; other wings are mistakes.
  subroutine stretch_wing(config, stretch, form, errors)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: stretch(2)
    type(wing_form_t), intent(inout) :: form
    type(message_list_t), intent(inout) :: errors
    if (any(stretch <= 0)) then
      call config%complain(errors, SECTION, STRETCH_KEY, 'must be above 0')
    else if (has_flexible_wings(config)) then
      call config%complain(errors, SECTION, STRETCH_KEY, 'is for rigid wings; [Wing] length and mean_chord change flexible ones')
    else if (allocated(form%solid)) then
      call config%complain(errors, SECTION, STRETCH_KEY, 'does not work for wings that are drawn up to their outline; valid '// &
                           'for this wing: wing_edges = beyond')
    else
      form%points(1, :) = stretch(1)*form%points(1, :)
      form%points(2, :) = stretch(2)*form%points(2, :)
    end if
  end subroutine stretch_wing

  !> Makes one of FLUSI's wings.
  subroutine take_named(config, c, drawing, planform, solid, errors)
    type(config_t), intent(in) :: config
    type(source_choices_t), intent(in) :: c
    type(drawing_t), intent(in) :: drawing
    type(planform_t), intent(out) :: planform
    class(solid_shape_t), allocatable, intent(out) :: solid
    type(message_list_t), intent(inout) :: errors
    type(wing_numbers_t) :: numbers
    real(rp) :: factor
    numbers = c%numbers
    if (has_chord(c%shape) .and. numbers%front + numbers%back <= 0) then
      call config%complain(errors, SECTION, 'b_bot', 'is missing: '//c%shape//' has a chord of b_top + b_bot')
      numbers%back = 1
    end if
    if (has_span(c%shape) .and. numbers%span <= 0) then
      call config%complain(errors, SECTION, 'L_span', 'is 0: '//c%shape//' needs a positive length')
      numbers%span = 1
    end if
    call make_named_wing(c%shape, numbers, 1.0_rp, 0.0_rp, planform, solid)
    factor = 1
    if (c%length > 0) factor = c%length/maxval(planform%outline(1, :))
    call make_named_wing(c%shape, numbers, factor, merge(drawing%thickness, 0.0_rp, drawing%ends_at_outline .and. &
                                                         c%edges /= EDGES_ROUND), planform, solid)
  end subroutine take_named

  !> Reads the outline in a file of its own, L.
  subroutine read_outline(config, c, scene, planform, errors, notices, world)
    type(config_t), intent(in) :: config
    type(source_choices_t), intent(in) :: c
    type(scene_t), intent(in) :: scene
    type(planform_t), intent(inout) :: planform
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    character(:), allocatable :: path, text, problem
    real(rp) :: factor
    integer :: errors_before
    errors_before = errors%count()
    call read_named_text(c%shape(len(OUTLINE_WORD) + 1:), config%file_name(), path, text, problem, world)
    if (allocated(problem)) then
      call config%complain(errors, SECTION, SHAPE, problem)
      return
    end if
    call read_planform_text(text, path, planform, errors, notices)
    if (errors%count() > errors_before) return
    planform%outline = planform%outline/scene%file_unit
    factor = 1/scene%file_unit
    if (c%length > 0) factor = factor*(c%length/maxval(planform%outline(1, :)))
    if (c%length > 0) planform%outline = planform%outline*(c%length/maxval(planform%outline(1, :)))
    planform%relief = planform%relief%scaled(factor)
    if (allocated(planform%fourier%ai)) planform%fourier = planform%fourier%scaled(factor)
  end subroutine read_outline

  !> Makes the solid inside a Fourier outline.
  subroutine take_fourier(config, c, drawing, planform, solid, notices)
    type(config_t), intent(in) :: config
    type(source_choices_t), intent(in) :: c
    type(drawing_t), intent(in) :: drawing
    type(planform_t), intent(in) :: planform
    class(solid_shape_t), allocatable, intent(inout) :: solid
    type(message_list_t), intent(inout) :: notices
    if (drawing%thickness > 0 .and. any(c%edges == [EDGES_FLUSI, EDGES_AUTO])) then
      allocate (solid, source=make_fourier_wing(planform%fourier, planform%outline, drawing%thickness, planform%relief))
    else if (allocated(planform%relief%thickness)) then
      call config%complain(notices, SECTION, SHAPE, 'has a variable thickness, which counts only for rigid wings in the mask '// &
                           '(surface = penalized) that end at their outline (wing_edges = flusi)')
    end if
  end subroutine take_fourier

  !> Makes the triangles of a planform in L, and the solid with round edges if requested.
  subroutine take_planform(config, c, scene, drawing, planform, form, errors)
    type(config_t), intent(in) :: config
    type(source_choices_t), intent(in) :: c
    type(scene_t), intent(in) :: scene
    type(drawing_t), intent(in) :: drawing
    type(planform_t), intent(in) :: planform
    type(wing_form_t), intent(inout) :: form
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: fault
    real(rp) :: tip, edge, where_not
    tip = maxval(planform%outline(1, :))
    edge = max(scene%grid%max_spacing(), tip/40)
    if (c%edge > 0) edge = c%edge
    if (tip < scene%grid%max_spacing()) then
      fault = 'is too small: the tip of the wing is at x = '
      if (.not. c%length > 0) fault = 'is needed: the file of the planform has its tip at x = '
      call config%complain(errors, SECTION, LENGTH, fault//number_text(tip)//', less than one grid spacing from the hinge, '// &
                           'which is '//number_text(scene%grid%max_spacing()))
      return
    else if (edge > tip) then
      call config%complain(errors, SECTION, 'wing_edge', 'is larger than the wing, whose tip is at x = '//number_text(tip))
      return
    end if
    if (.not. planform%is_single(1000, where_not)) then
      call triangulate_star(planform, edge, form%points, form%triangles)
    else
      call triangulate_planform(planform, edge, form%points, form%triangles)
    end if
    ! The polygon cuts off the curved parts of the outline; the mean chord is still that of the planform.
    form%points(2, :) = form%points(2, :)*(planform%mean_chord()/mean_chord(form%points, form%triangles))
    if (planform%relief%exists()) call lift_points(planform, form%points)
    if (is_round(c, scene, drawing, form%points)) call round_outline(planform%outline, scene, drawing, form%solid)
  end subroutine take_planform

  !> Moves points to the height of the wing; points outside of the box of heights, at the rim, get the height at the edge of the
  !> box.
  subroutine lift_points(planform, points)
    type(planform_t), intent(in) :: planform
    real(rp), intent(inout) :: points(:, :)
    integer :: i
    associate (b => planform%relief%box)
      do i = 1, size(points, 2)
        points(3, i) = planform%relief%height_at(max(b(1), min(b(2), points(2, i))), max(b(3), min(b(4), points(1, i))))
      end do
    end associate
  end subroutine lift_points

  !> Tells whether the wing with these points is drawn with round edges at its outline.
  pure logical function is_round(c, scene, drawing, points)
    type(source_choices_t), intent(in) :: c
    type(scene_t), intent(in) :: scene
    type(drawing_t), intent(in) :: drawing
    real(rp), intent(in) :: points(:, :)
    is_round = drawing%thickness > 0 .and. c%edges == EDGES_ROUND .and. .not. scene%grid%is_2d .and. &
               all(abs(points(3, :)) <= FLAT*maxval(abs(points(1, :))))
  end function is_round

  !> Makes a flat planform with round edges.
  subroutine round_outline(outline, scene, drawing, solid)
    real(rp), intent(in) :: outline(:, :)
    type(scene_t), intent(in) :: scene
    type(drawing_t), intent(in) :: drawing
    class(solid_shape_t), allocatable, intent(inout) :: solid
    real(rp) :: segments(2, 2, size(outline, 2))
    segments(:, 1, :) = outline
    segments(:, 2, :) = cshift(outline, 1, 2)
    if (allocated(solid)) deallocate (solid)
    allocate (solid, source=make_round_wing(segments, drawing%thickness, drawing%smoothing, scene%grid%max_spacing()))
  end subroutine round_outline

  !> Takes the triangles of a wing file.
  subroutine read_mesh(config, c, scene, drawing, form, errors, world)
    type(config_t), intent(in) :: config
    type(source_choices_t), intent(in) :: c
    type(scene_t), intent(in) :: scene
    type(drawing_t), intent(in) :: drawing
    type(wing_form_t), intent(inout) :: form
    type(message_list_t), intent(inout) :: errors
    type(world_t), intent(in), optional :: world
    character(:), allocatable :: path
    type(wing_t) :: wing
    integer :: errors_before
    errors_before = errors%count()
    path = named_path(c%shape(len(MESH_WORD) + 1:), config%file_name(), world)
    if (path == '') then
      call config%complain(errors, SECTION, SHAPE, 'the wing file does not exist, neither here nor beside '//config%file_name())
    else if (c%length <= 0 .and. scene%metre <= 0) then
      call config%complain(errors, SECTION, LENGTH, 'is needed: a wing file is in metres, and without [units] length the '// &
                           'program cannot convert them')
    end if
    if (errors%count() > errors_before) return
    if (present(world)) then
      call load_wing(world, path, wing, errors)
    else
      call read_wing(path, wing, errors)
    end if
    if (errors%count() > errors_before) return
    call take_mesh(wing, c, scene, drawing, form)
    if (size(form%triangles, 2) == 0) call config%complain(errors, SECTION, SHAPE, path//' has no triangles')
  end subroutine read_mesh

  !> Takes the points of a mesh, scaled so that the tip is at x = wing_length; without this key, scaled from metres to L.
  subroutine take_mesh(source, c, scene, drawing, form)
    type(wing_t), intent(in) :: source
    type(source_choices_t), intent(in) :: c
    type(scene_t), intent(in) :: scene
    type(drawing_t), intent(in) :: drawing
    type(wing_form_t), intent(inout) :: form
    real(rp) :: tip
    tip = c%length
    if (tip <= 0) tip = scene%metre*maxval(source%points(1, :))
    form%points = source%points*(tip/maxval(source%points(1, :)))
    form%triangles = source%triangles
    form%z_is_dorsal = source%z_is_dorsal()
    if (is_round(c, scene, drawing, form%points) .and. size(form%triangles, 2) > 0) &
      call round_edges(scene, drawing, form)
  end subroutine take_mesh

  !> Makes a flat mesh with round edges.
  subroutine round_edges(scene, drawing, form)
    type(scene_t), intent(in) :: scene
    type(drawing_t), intent(in) :: drawing
    type(wing_form_t), intent(inout) :: form
    real(rp), allocatable :: segments(:, :, :)
    integer, allocatable :: edges(:, :)
    call find_free_edges(size(form%points, 2), form%triangles, edges)
    allocate (segments(2, 2, size(edges, 2)))
    segments(:, 1, :) = form%points(:2, edges(1, :))
    segments(:, 2, :) = form%points(:2, edges(2, :))
    allocate (form%solid, source=make_round_wing(segments, drawing%thickness, drawing%smoothing, scene%grid%max_spacing()))
  end subroutine round_edges

  !> Returns the area of the triangles(3, m) over their extent along x, in the unit of points(3, n).
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
end module fsi_wing_source

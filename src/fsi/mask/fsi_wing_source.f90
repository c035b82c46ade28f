! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the shape of a wing: one of FLUSI's wings by name, a planform file, a wing file, or the wing of [Wing].
module fsi_wing_source
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_free_edges, only: find_free_edges
  use fsi_named_wings, only: make_named_wing, NAMED_WINGS, wing_numbers_t
  use fsi_planform, only: planform_t
  use fsi_planform_file, only: read_planform_text
  use fsi_planform_mesh, only: triangulate_planform, triangulate_star
  use fsi_rotation, only: cross
  use fsi_round_wing, only: make_round_wing
  use fsi_solid_shape, only: solid_shape_t
  use fsi_wing_solids, only: make_fourier_wing
  use io_config, only: config_t
  use io_registry, only: registry_t
  use io_broadcast_text, only: named_path, read_named_text
  use parallel_world, only: world_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: load_wing, read_wing
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: register_wing_source, read_wing_shape, draws_to_outline, mean_chord

  character(*), parameter :: SECTION = 'Insects'
  real(rp), parameter :: FLAT = 1.0e-9_rp !< of the length, heights that are none
  character(*), parameter :: OUTLINE_WORD = 'from_file::', MESH_WORD = 'mesh::'

contains

  !> Declares the keys.
  subroutine register_wing_source(registry)
    type(registry_t), intent(inout) :: registry
    call registry%add_word(SECTION, 'WingShape', 'none', OUTLINE_WORD//'*|'//MESH_WORD//'*|none|'//NAMED_WINGS, &
                           'one of FLUSI''s wings by name, planform file with section [Wing], or triangles of a wing '// &
                           'file (docs/formats/wing-format.md)', &
                           unbuilt='pointcloud*|whitney_wood', &
                           instead='pointcloud*: the triangles of the wing in a wing file, WingShape = mesh::NAME.h5, or '// &
                           'its outline, WingShape = from_file::NAME.ini|'// &
                           'whitney_wood: its outline, WingShape = from_file::NAME.ini')
    call registry%add_length(SECTION, 'wing_length', '0.0', 'the planform is scaled so that its largest x is this; '// &
                             '0: lengths of its file are in the units of this file; meshes are in metres', unit='L', &
                             min=0.0_rp)
    call registry%add_length(SECTION, 'wing_edge', 'max(dx, 1/40 of the wing)', &
                             'edge length of the triangles made from a planform', unit='L', above=0.0_rp)
    call registry%add_length(SECTION, 'L_span', '1.0', 'WingShape = rectangular, TwoEllipses, mosquito_iams: from hinge '// &
                             'to tip; BodyType = platicle: its extent along x', unit='L', min=0.0_rp)
    call registry%add_length(SECTION, 'b_top', '0.0', 'WingShape = rectangular, TwoEllipses: chord before the axis', &
                             unit='L', min=0.0_rp)
    call registry%add_length(SECTION, 'b_bot', '0.0', 'WingShape = rectangular, TwoEllipses: chord behind the axis', &
                             unit='L', min=0.0_rp)
    call registry%add_inert(SECTION, 'L_chord', 'chord that no wing of FLUSI uses')
    call registry%add_word(SECTION, 'wing_edges', 'auto', 'auto|flusi|round|beyond', 'rigid wings in the mask. flusi: they '// &
                           'end, smoothed, at their outline, as FLUSI draws them; round: they end there with round edges; '// &
                           'beyond: their round edges reach half their thickness farther all around; auto: flusi for '// &
                           'FLUSI''s wings by name and Fourier outlines of files, else beyond')
  end subroutine register_wing_source

  !> Whether it is sure, before a file is read, that rigid wings in the mask end at their outline.
  logical function draws_to_outline(config, is_thin) result(draws)
    type(config_t), intent(in) :: config
    logical, intent(in) :: is_thin
    character(:), allocatable :: word
    word = config%get_word(SECTION, 'wing_edges')
    draws = any(word == ['flusi', 'round'])
    if (word == 'auto') draws = is_named(config%get_word(SECTION, 'WingShape'))
    draws = draws .and. .not. is_thin .and. config%get_word(SECTION, 'wings') /= 'flexible'
  end function draws_to_outline

  !> Whether `word` is one of FLUSI's wings.
  pure logical function is_named(word)
    character(*), intent(in) :: word
    is_named = index('|'//NAMED_WINGS//'|', '|'//word//'|') > 0
  end function is_named

  !> Points and triangles of the wing, L, along axes of which z points to its dorsal side or not.
  subroutine read_wing_shape(config, ini, grid, metre, file_unit, points, triangles, z_is_dorsal, solid, &
                             thickness, smoothing, ends_at_outline, errors, notices, world, mesh)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: ini
    type(grid_t), intent(in) :: grid
    real(rp), intent(in) :: metre, file_unit
    real(rp), allocatable, intent(out) :: points(:, :)
    integer, allocatable, intent(out) :: triangles(:, :)
    logical, intent(out) :: z_is_dorsal
    class(solid_shape_t), allocatable, intent(out) :: solid !< the wing up to its outline, of `thickness` [L]; 0: none
    real(rp), intent(in) :: thickness, smoothing
    logical, intent(in) :: ends_at_outline !< it is wanted; of other wings Fourier outlines are unless the file says beyond
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(wing_t), intent(in), optional :: mesh
    character(:), allocatable :: word, path, text, problem
    type(planform_t) :: planform
    type(wing_t) :: wing
    type(wing_numbers_t) :: numbers
    real(rp) :: length, edge, factor, where_not
    integer :: errors_before
    allocate (points(3, 0), triangles(3, 0))
    z_is_dorsal = .false.
    errors_before = errors%count()
    word = config%get_word(SECTION, 'WingShape')
    length = config%get_real(SECTION, 'wing_length')
    if (index(word, OUTLINE_WORD) == 1 .or. is_named(word)) then
      if (is_named(word)) then
        call take_named()
      else
        call read_named_text(word(len(OUTLINE_WORD) + 1:), ini, path, text, problem, world)
        if (allocated(problem)) then
          call config%complain(errors, SECTION, 'WingShape', problem)
          return
        end if
        call read_planform_text(text, path, planform, errors, notices)
        if (errors%count() > errors_before) return
        planform%outline = planform%outline/file_unit
        factor = 1/file_unit
        if (length > 0) factor = factor*(length/maxval(planform%outline(1, :)))
        if (length > 0) planform%outline = planform%outline*(length/maxval(planform%outline(1, :)))
        planform%relief = planform%relief%scaled(factor)
        if (allocated(planform%fourier%ai)) call take_fourier()
      end if
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
        if (.not. planform%is_single(1000, where_not)) then
          call triangulate_star(planform, edge, points, triangles)
        else
          call triangulate_planform(planform, edge, points, triangles)
        end if
        ! Chords of the outline cut its bulges; the mean chord is the planform's all the same.
        points(2, :) = points(2, :)*(planform%mean_chord()/mean_chord(points, triangles))
        if (planform%relief%exists()) call lift_points()
        if (is_round()) call take_outline()
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

    logical function is_round()
      is_round = thickness > 0 .and. config%get_word(SECTION, 'wing_edges') == 'round' .and. .not. grid%is_2d .and. &
                 all(abs(points(3, :)) <= FLAT*maxval(abs(points(1, :))))
    end function is_round

    !> A flat planform with round edges.
    subroutine take_outline()
      real(rp) :: segments(2, 2, size(planform%outline, 2))
      segments(:, 1, :) = planform%outline
      segments(:, 2, :) = cshift(planform%outline, 1, 2)
      if (allocated(solid)) deallocate (solid)
      allocate (solid, source=make_round_wing(segments, thickness, smoothing, grid%max_spacing()))
    end subroutine take_outline

    !> A flat mesh with round edges.
    subroutine take_free_edges()
      real(rp), allocatable :: segments(:, :, :)
      integer, allocatable :: edges(:, :)
      call find_free_edges(size(points, 2), triangles, edges)
      allocate (segments(2, 2, size(edges, 2)))
      segments(:, 1, :) = points(:2, edges(1, :))
      segments(:, 2, :) = points(:2, edges(2, :))
      allocate (solid, source=make_round_wing(segments, thickness, smoothing, grid%max_spacing()))
    end subroutine take_free_edges

    !> The wing of a file as a solid.
    subroutine take_fourier()
      character(:), allocatable :: edges
      edges = config%get_word(SECTION, 'wing_edges')
      if (thickness > 0 .and. (edges == 'flusi' .or. edges == 'auto')) then
        allocate (solid, source=make_fourier_wing(planform%fourier%scaled(factor), planform%outline, thickness, &
                                                  planform%relief))
      else if (allocated(planform%relief%thickness)) then
        call config%complain(notices, SECTION, 'WingShape', 'has a variable thickness, which counts only for rigid wings in '// &
                             'the mask (surface = penalized) that end at their outline (wing_edges = flusi)')
      end if
    end subroutine take_fourier

    !> Points go to the height of the wing there; those beside its box, at the rim, to that of the box.
    subroutine lift_points()
      integer :: i
      associate (b => planform%relief%box)
        do i = 1, size(points, 2)
          points(3, i) = planform%relief%height_at(max(b(1), min(b(2), points(2, i))), max(b(3), min(b(4), points(1, i))))
        end do
      end associate
    end subroutine lift_points

    subroutine take_named()
      numbers%span = config%get_real(SECTION, 'L_span')
      numbers%front = config%get_real(SECTION, 'b_top')
      numbers%back = config%get_real(SECTION, 'b_bot')
      if (any(word == [character(11) :: 'rectangular', 'TwoEllipses']) .and. numbers%front + numbers%back <= 0) then
        call config%complain(errors, SECTION, 'b_bot', 'is missing: '//word//' has a chord of b_top + b_bot')
        numbers%back = 1
      end if
      if (any(word == [character(13) :: 'rectangular', 'TwoEllipses', 'mosquito_iams']) .and. numbers%span <= 0) then
        call config%complain(errors, SECTION, 'L_span', 'is 0: '//word//' needs a positive length')
        numbers%span = 1
      end if
      call make_named_wing(word, numbers, 1.0_rp, 0.0_rp, planform, solid)
      factor = 1
      if (length > 0) factor = length/maxval(planform%outline(1, :))
      call make_named_wing(word, numbers, factor, merge(thickness, 0.0_rp, ends_at_outline .and. &
                                                            config%get_word(SECTION, 'wing_edges') /= 'round'), planform, solid)
    end subroutine take_named

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
      if (is_round() .and. size(triangles, 2) > 0) call take_free_edges()
    end subroutine take_mesh
  end subroutine read_wing_shape

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

! SPDX-License-Identifier: GPL-3.0-or-later
!> Files of wing planforms: section [Wing] with FLUSI's Fourier keys, and outlines that are easier to write.
module fsi_planform_file
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_planform, only: planform_t, fourier_planform, polygon_planform, curve_planform, rectangular_planform, &
                          elliptic_planform
  use io_config, only: config_t
  use io_ini, only: ini_document_t
  use io_registry, only: registry_t
  use io_broadcast_text, only: read_text_file
  implicit none
  private
  public :: read_planform, read_planform_text

  character(*), parameter :: W = 'Wing'
  character(8), parameter :: SERIES(2) = ['ai_wings', 'bi_wings']
  integer, parameter :: N_SAMPLES = 1000 !< places where an outline is checked

contains

  !> `read_planform_text` of the file at `path`, which is read by the calling rank.
  subroutine read_planform(path, planform, errors, notices)
    character(*), intent(in) :: path
    type(planform_t), intent(inout) :: planform
    type(message_list_t), intent(inout) :: errors, notices
    character(:), allocatable :: text, problem
    call read_text_file(path, text, problem)
    if (allocated(problem)) then
      call errors%add(problem)
    else
      call read_planform_text(text, path, planform, errors, notices)
    end if
  end subroutine read_planform

  !> Reads a planform from the content of the file called `name`. It is set, with one chord at every x, if no
  !> message was added to `errors`. Lengths are those of the file, see `length`.
  subroutine read_planform_text(text, name, planform, errors, notices)
    character(*), intent(in) :: text, name
    type(planform_t), intent(inout) :: planform
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t) :: registry
    type(config_t) :: config
    character(:), allocatable :: kind
    real(rp) :: tip, chord, root, front, where_not, span(2)
    integer :: errors_before
    logical :: as_matrix(2)
    errors_before = errors%count()
    as_matrix = [is_matrix(text, SERIES(1)), is_matrix(text, SERIES(2))]
    call register_wing_keys(registry, as_matrix)
    call config%load_text(text, name, registry, errors, notices)
    if (errors%count() > errors_before) return
    kind = config%get_word(W, 'type')
    tip = config%get_real(W, 'length')
    chord = config%get_real(W, 'mean_chord')
    root = config%get_real(W, 'root')
    front = config%get_real(W, 'front')
    select case (kind)
    case ('fourier')
      call read_fourier(config, as_matrix, planform, errors)
    case ('polygon', 'curve')
      call read_outline(config, kind, planform, errors)
    case default
      if (tip <= root) call config%complain(errors, W, 'length', 'must be given, and be larger than root')
      if (chord <= 0) call config%complain(errors, W, 'mean_chord', 'must be given, and be positive')
      if (errors%count() > errors_before) return
      if (kind == 'rectangular') planform = rectangular_planform(root, tip, chord, front)
      if (kind == 'ellipse') planform = elliptic_planform(root, tip, chord, front)
    end select
    if (errors%count() > errors_before) return
    call read_relief(config, kind, planform, errors)
    if (errors%count() > errors_before) return
    span = planform%span()
    if (span(2) <= 0 .or. planform%area() <= 0) then
      call config%complain(errors, W, 'type', 'the outline encloses nothing at positive x')
    else if (.not. planform%is_single(N_SAMPLES, where_not)) then
      call config%complain(errors, W, 'type', 'the outline has more than one chord at x = '//number_text(where_not)// &
                           '; every x must pass it twice')
    else if (kind /= 'rectangular' .and. kind /= 'ellipse') then
      call planform%rescale(tip, chord)
    end if
  end subroutine read_planform_text

  subroutine register_wing_keys(registry, as_matrix)
    type(registry_t), intent(inout) :: registry
    logical, intent(in) :: as_matrix(2) !< how the file writes `SERIES`
    character(*), parameter :: HARMONICS = 'coefficients of the outline R(theta), one for each harmonic'
    integer :: i
    call registry%add_section(W, 'The planform of a wing, x from root to tip, y toward the leading edge.')
 call registry%add_word(W, 'type', 'fourier', 'fourier|polygon|curve|rectangular|ellipse', 'how the outline is given', &
                           unbuilt='linear|bristled', required=.true., &
                           instead='linear: polygon, or curve|bristled: fourier, for a wing without bristles')
    call registry%add_real(W, 'length', 0.0_rp, 'largest x, to which the outline is scaled; 0: as it is', &
                           unit='length', min=0.0_rp)
    call registry%add_real(W, 'mean_chord', 0.0_rp, 'area over extent in x, to which y is scaled; 0: as it is', &
                           unit='length', min=0.0_rp)
    call registry%add_real(W, 'root', 0.0_rp, 'smallest x of rectangle and ellipse', unit='length')
    call registry%add_real(W, 'front', 0.5_rp, 'part of the largest chord before the x axis, rectangle and ellipse', &
                           min=0.0_rp, max=1.0_rp)
    call registry%add_matrix(W, 'outline', 2, 'rows x y: corners of a polygon, or points of a curve from the '// &
                             'leading edge at the root over the tip to the trailing edge')
    call registry%add_real(W, 'a0_wings', 0.0_rp, 'twice the mean of R(theta)', unit='length')
    do i = 1, 2
      if (as_matrix(i)) then
        call registry%add_matrix(W, SERIES(i), 0, HARMONICS)
      else
        call registry%add_reals(W, SERIES(i), [real(rp) ::], HARMONICS, unit='length')
      end if
    end do
    call registry%add_real(W, 'x0w', 0.0_rp, 'chordwise place of the centre of R(theta)', unit='length')
    call registry%add_real(W, 'y0w', 0.0_rp, 'spanwise place of the centre of R(theta)', unit='length')
    call registry%add_word(W, 'wing_thickness_distribution', 'constant', 'constant|variable', 'thickness over the wing')
    call registry%add_matrix(W, 'wing_thickness_profile', 0, 'variable: thickness on a lattice, rows along the chord from the '// &
                             'trailing edge, columns along the span from the root')
    call registry%add_switch(W, 'corrugated', .false., 'a corrugated wing')
    call registry%add_matrix(W, 'corrugation_profile', 0, 'corrugated: height on such a lattice, along FLUSI''s z_w of the '// &
                             'right wing, to its lower side; the left wing is its mirror image')
    call registry%add_reals(W, 'corrugation_array_bbox', [0.0_rp, 0.0_rp, 0.0_rp, 0.0_rp], 'box of the lattices: chordwise, '// &
                            'then spanwise ends; 0: that of the outline', unit='length', length=4)
    call registry%add_switch(W, 'bristled', .false., 'a bristled wing', unbuilt='bristles', instead='a membrane where they are')
    call registry%add_inert(W, 'wing_thickness_value', 'FLUSI''s thickness in the file of the wing')
    call registry%add_inert(W, 'bristle*', 'FLUSI''s bristles')
    call registry%add_inert(W, 'wing_bounding_box', 'FLUSI''s bounding box')
  end subroutine register_wing_keys

  !> Whether the file writes this key as a matrix; FLUSI's files do it in both ways.
  logical function is_matrix(text, key)
    character(*), intent(in) :: text, key
    type(ini_document_t) :: document
    type(message_list_t) :: ignored
    integer :: i
    call document%parse(text, '', ignored)
    is_matrix = .false.
    do i = 1, document%n_entries
      if (document%entries(i)%key == key) is_matrix = document%entries(i)%is_matrix
    end do
  end function is_matrix

  subroutine read_fourier(config, as_matrix, planform, errors)
    type(config_t), intent(in) :: config
    logical, intent(in) :: as_matrix(2)
    type(planform_t), intent(inout) :: planform
    type(message_list_t), intent(inout) :: errors
    real(rp), allocatable :: ai(:), bi(:)
    integer :: i
    ai = series_of(config, SERIES(1), as_matrix(1))
    bi = series_of(config, SERIES(2), as_matrix(2))
    if (.not. config%is_given(W, 'a0_wings')) call config%complain(errors, W, 'a0_wings', 'is missing')
    do i = 1, 2
      if (.not. config%is_given(W, SERIES(i))) call config%complain(errors, W, SERIES(i), 'is missing')
    end do
    if (size(ai) /= size(bi)) then
      call config%complain(errors, W, 'bi_wings', 'has '//number_text(size(bi))//' numbers, ai_wings has '// &
                           number_text(size(ai)))
    else
      planform = fourier_planform(config%get_real(W, 'a0_wings'), ai, bi, config%get_real(W, 'x0w'), &
                                  config%get_real(W, 'y0w'))
    end if
  end subroutine read_fourier

  !> Corrugation and variable thickness of a wing with a Fourier outline.
  subroutine read_relief(config, kind, planform, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: kind
    type(planform_t), intent(inout) :: planform
    type(message_list_t), intent(inout) :: errors
    character(*), parameter :: HEIGHT = 'corrugation_profile', THICKNESS = 'wing_thickness_profile'
    logical :: has(2)
    has = [config%get_switch(W, 'corrugated'), config%get_word(W, 'wing_thickness_distribution') == 'variable']
    if (.not. any(has)) return
    if (kind /= 'fourier' .or. config%get_real(W, 'mean_chord') > 0) then
      call config%complain(errors, W, trim(merge('corrugated                 ', 'wing_thickness_distribution', has(1))), &
                           'needs type = fourier, without mean_chord')
      return
    end if
    associate (relief => planform%relief, outline => planform%outline)
      if (has(1)) call take(HEIGHT, relief%height)
      if (has(2)) call take(THICKNESS, relief%thickness)
      if (allocated(relief%thickness)) then
        if (any(relief%thickness < 0) .or. .not. any(relief%thickness > 0)) &
          call config%complain(errors, W, THICKNESS, 'has a negative thickness, or none at all')
      end if
      relief%box = config%get_reals(W, 'corrugation_array_bbox')
      if (.not. any(abs(relief%box) > 0)) relief%box = [minval(outline(2, :)), maxval(outline(2, :)), &
                                                        minval(outline(1, :)), maxval(outline(1, :))]
      if (relief%box(2) <= relief%box(1) .or. relief%box(4) <= relief%box(3)) &
        call config%complain(errors, W, 'corrugation_array_bbox', 'is no box; valid: chord from, to, span from, to')
    end associate

  contains

    subroutine take(key, values)
      character(*), intent(in) :: key
      real(rp), allocatable, intent(out) :: values(:, :)
      values = config%get_matrix(W, key)
      if (minval(shape(values)) < 2) call config%complain(errors, W, key, 'is missing, or has less than two rows or columns')
    end subroutine take
  end subroutine read_relief

  !> The numbers of a list, or of a matrix row by row.
  function series_of(config, key, as_matrix) result(x)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: key
    logical, intent(in) :: as_matrix
    real(rp), allocatable :: x(:), rows(:, :)
    if (as_matrix) then
      rows = config%get_matrix(W, key)
      x = reshape(transpose(rows), [size(rows)])
    else
      x = config%get_reals(W, key)
    end if
  end function series_of

  subroutine read_outline(config, kind, planform, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: kind
    type(planform_t), intent(inout) :: planform
    type(message_list_t), intent(inout) :: errors
    real(rp), allocatable :: rows(:, :)
    integer :: i
    rows = config%get_matrix(W, 'outline')
    if (size(rows, 1) < 3) then
      call config%complain(errors, W, 'outline', 'must be given, with at least 3 points')
      return
    end if
    do i = 2, size(rows, 1)
      if (all(rows(i, :) <= rows(i - 1, :) .and. rows(i, :) >= rows(i - 1, :))) then
        call config%complain(errors, W, 'outline', 'row '//number_text(i)//' repeats the point before it')
        return
      end if
    end do
    if (kind == 'curve') then
      planform = curve_planform(transpose(rows))
    else
      planform = polygon_planform(transpose(rows))
    end if
  end subroutine read_outline
end module fsi_planform_file

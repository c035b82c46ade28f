! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads files of wing planforms: section [Wing] with FLUSI's Fourier keys, and outlines that are easier to write.
module fsi_planform_file
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_planform, only: planform_t, fourier_planform, polygon_planform, curve_planform, rectangular_planform, &
                          elliptic_planform
  use io_config, only: config_t
  use io_ini, only: ini_document_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  implicit none
  private
  public :: read_planform_text

  character(*), parameter :: W = 'Wing'
  character(8), parameter :: SERIES(2) = ['ai_wings', 'bi_wings']
  character(*), parameter :: OUTLINE = 'outline', BOX = 'corrugation_array_bbox'
  character(*), parameter :: HEIGHT = 'corrugation_profile', THICKNESS = 'wing_thickness_profile'
  character(*), parameter :: CORRUGATED = 'corrugated                 ', VARIABLE = 'wing_thickness_distribution'
  integer, parameter :: N_SAMPLES = 1000 !< places where an outline is checked

  type :: series_t
    real(rp), allocatable :: x(:)
  end type series_t

  !> Contents of a file; lengths are those of the file.
  type :: planform_choices_t
    character(:), allocatable :: type, thickness_kind
    real(rp) :: tip = 0, chord = 0, root = 0, front = 0
    real(rp), allocatable :: outline(:, :)              !< rows x y
    real(rp) :: a0 = 0, centre(2) = 0                   !< of R(theta)
    type(series_t) :: series(2)                         !< a_i and b_i of R(theta)
    logical :: has_a0 = .false., has_series(2) = .false.
    logical :: is_corrugated = .false.
    real(rp), allocatable :: thickness(:, :), heights(:, :) !< on a lattice
    real(rp) :: box(4) = 0                              !< of the lattice
  end type planform_choices_t

contains

  !> Reads a planform from the content of the file called `name`. It is set, with one chord at every x, if no
  !> message was added to `errors`. Lengths are those of the file, see `length`.
  subroutine read_planform_text(text, name, planform, errors, notices)
    character(*), intent(in) :: text, name
    type(planform_t), intent(inout) :: planform
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t), target :: registry
    type(config_t), target :: config
    type(keys_t) :: keys
    type(planform_choices_t) :: c
    real(rp) :: where_not, span(2)
    integer :: errors_before
    logical :: as_matrix(2)
    errors_before = errors%count()
    as_matrix = [is_matrix(text, SERIES(1)), is_matrix(text, SERIES(2))]
    keys = declaring(registry)
    call planform_keys(keys, as_matrix, c)
    call config%load_text(text, name, registry, errors, notices)
    if (errors%count() > errors_before) return
    keys = reading(config)
    call planform_keys(keys, as_matrix, c)
    select case (c%type)
    case ('fourier')
      call take_fourier(config, c, planform, errors)
    case ('polygon', 'curve')
      call take_outline(config, c, planform, errors)
    case default
      if (c%tip <= c%root) call config%complain(errors, W, 'length', 'must be given, and be larger than root')
      if (c%chord <= 0) call config%complain(errors, W, 'mean_chord', 'must be given, and be positive')
      if (errors%count() > errors_before) return
      if (c%type == 'rectangular') planform = rectangular_planform(c%root, c%tip, c%chord, c%front)
      if (c%type == 'ellipse') planform = elliptic_planform(c%root, c%tip, c%chord, c%front)
    end select
    if (errors%count() > errors_before) return
    call take_relief(config, c, planform, errors)
    if (errors%count() > errors_before) return
    span = planform%span()
    if (span(2) <= 0 .or. planform%area() <= 0) then
      call config%complain(errors, W, 'type', 'the outline encloses nothing at positive x')
    else if (.not. planform%is_single(N_SAMPLES, where_not)) then
      call config%complain(errors, W, 'type', 'the outline has more than one chord at x = '//number_text(where_not)// &
                           '; a line of constant x must cross the outline exactly twice')
    else if (c%type /= 'rectangular' .and. c%type /= 'ellipse') then
      call planform%rescale(c%tip, c%chord)
    end if
  end subroutine read_planform_text

  !> Visits the keys of a planform.
  subroutine planform_keys(keys, as_matrix, c)
    type(keys_t), intent(inout) :: keys
    logical, intent(in) :: as_matrix(2) !< how the file writes `SERIES`
    type(planform_choices_t), intent(inout) :: c
    character(*), parameter :: HARMONICS = 'coefficients of the outline R(theta), one for each harmonic'
    real(rp), allocatable :: rows(:, :) !< not allocated where keys are declared
    logical :: bristled
    integer :: i
    call keys%section(W, 'The planform of a wing, x from root to tip, y toward the leading edge.')
    call keys%word('type', c%type, 'fourier', 'fourier|polygon|curve|rectangular|ellipse', 'how the outline is given', &
                   unbuilt='linear|bristled', required=.true., instead='linear: polygon, or curve|bristled: fourier, for a '// &
                   'wing without bristles')
    call keys%real('length', c%tip, 0.0_rp, 'largest x, to which the outline is scaled; 0: as it is', unit='length', min=0.0_rp)
    call keys%real('mean_chord', c%chord, 0.0_rp, 'area over extent in x, to which y is scaled; 0: as it is', unit='length', &
                   min=0.0_rp)
    call keys%real('root', c%root, 0.0_rp, 'smallest x of rectangle and ellipse', unit='length')
    call keys%real('front', c%front, 0.5_rp, 'part of the largest chord before the x axis, rectangle and ellipse', min=0.0_rp, &
                   max=1.0_rp)
    call keys%matrix('outline', c%outline, 2, 'rows x y: corners of a polygon, or points of a curve from the leading edge at '// &
                     'the root over the tip to the trailing edge')
    call keys%real('a0_wings', c%a0, 0.0_rp, 'twice the mean of R(theta)', unit='length', given=c%has_a0)
    do i = 1, 2
      if (as_matrix(i)) then
        call keys%matrix(SERIES(i), rows, 0, HARMONICS, given=c%has_series(i))
        if (allocated(rows)) c%series(i)%x = reshape(transpose(rows), [size(rows)])
      else
        call keys%list(SERIES(i), c%series(i)%x, [real(rp) ::], HARMONICS, unit='length', given=c%has_series(i))
      end if
    end do
    call keys%real('x0w', c%centre(1), 0.0_rp, 'chordwise place of the centre of R(theta)', unit='length')
    call keys%real('y0w', c%centre(2), 0.0_rp, 'spanwise place of the centre of R(theta)', unit='length')
    call keys%word('wing_thickness_distribution', c%thickness_kind, 'constant', 'constant|variable', 'thickness over the wing')
    call keys%matrix('wing_thickness_profile', c%thickness, 0, 'variable: thickness on a lattice, rows along the chord from '// &
                     'the trailing edge, columns along the span from the root')
    call keys%switch('corrugated', c%is_corrugated, .false., 'a corrugated wing')
    call keys%matrix('corrugation_profile', c%heights, 0, 'corrugated: height on such a lattice, along FLUSI''s z_w of the '// &
                     'right wing, to its lower side; the left wing is its mirror image')
    call keys%reals('corrugation_array_bbox', c%box, [0.0_rp, 0.0_rp, 0.0_rp, 0.0_rp], 'box of the lattices: chordwise, then '// &
                    'spanwise ends; 0: that of the outline', unit='length')
    call keys%switch('bristled', bristled, .false., 'a bristled wing', unbuilt='bristles', instead='a membrane where they are')
    call keys%inert('wing_thickness_value', 'FLUSI''s thickness in the file of the wing')
    call keys%inert('bristle*', 'FLUSI''s bristles')
    call keys%inert('wing_bounding_box', 'FLUSI''s bounding box')
  end subroutine planform_keys

  !> Tells whether the file writes this key as a matrix; FLUSI's files do it in both ways.
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

  !> Makes a planform from Fourier coefficients, or adds errors.
  subroutine take_fourier(config, c, planform, errors)
    type(config_t), intent(in) :: config
    type(planform_choices_t), intent(in) :: c
    type(planform_t), intent(inout) :: planform
    type(message_list_t), intent(inout) :: errors
    integer :: i
    if (.not. c%has_a0) call config%complain(errors, W, 'a0_wings', 'is missing')
    do i = 1, 2
      if (.not. c%has_series(i)) call config%complain(errors, W, SERIES(i), 'is missing')
    end do
    associate (ai => c%series(1)%x, bi => c%series(2)%x)
      if (size(ai) /= size(bi)) then
        call config%complain(errors, W, SERIES(2), 'has '//number_text(size(bi))//' numbers, '//SERIES(1)//' has '// &
                             number_text(size(ai)))
      else
        planform = fourier_planform(c%a0, ai, bi, c%centre(1), c%centre(2))
      end if
    end associate
  end subroutine take_fourier

  !> Reads corrugation and variable thickness of a wing with a Fourier outline.
  subroutine take_relief(config, c, planform, errors)
    type(config_t), intent(in) :: config
    type(planform_choices_t), intent(in) :: c
    type(planform_t), intent(inout) :: planform
    type(message_list_t), intent(inout) :: errors
    logical :: has(2)
    has = [c%is_corrugated, c%thickness_kind == 'variable']
    if (.not. any(has)) return
    if (c%type /= 'fourier' .or. c%chord > 0) then
      call config%complain(errors, W, trim(merge(CORRUGATED, VARIABLE, has(1))), 'needs type = fourier, without mean_chord')
      return
    end if
    associate (relief => planform%relief, outline => planform%outline)
      if (has(1)) call take(HEIGHT, c%heights, relief%height)
      if (has(2)) call take(THICKNESS, c%thickness, relief%thickness)
      if (allocated(relief%thickness)) then
        if (any(relief%thickness < 0) .or. .not. any(relief%thickness > 0)) &
          call config%complain(errors, W, THICKNESS, 'has a negative thickness, or none at all')
      end if
      relief%box = c%box
      if (.not. any(abs(relief%box) > 0)) relief%box = [minval(outline(2, :)), maxval(outline(2, :)), &
                                                        minval(outline(1, :)), maxval(outline(1, :))]
      if (relief%box(2) <= relief%box(1) .or. relief%box(4) <= relief%box(3)) &
        call config%complain(errors, W, BOX, 'must have each first position before the last; valid: first and last '// &
                             'chordwise position, first and last spanwise position')
    end associate

  contains

    subroutine take(key, given, values)
      character(*), intent(in) :: key
      real(rp), intent(in) :: given(:, :)
      real(rp), allocatable, intent(out) :: values(:, :)
      values = given
      if (minval(shape(values)) < 2) call config%complain(errors, W, key, 'is missing, or has less than two rows or columns')
    end subroutine take
  end subroutine take_relief

  !> Makes a planform from the points of its outline, or adds errors.
  subroutine take_outline(config, c, planform, errors)
    type(config_t), intent(in) :: config
    type(planform_choices_t), intent(in) :: c
    type(planform_t), intent(inout) :: planform
    type(message_list_t), intent(inout) :: errors
    integer :: i
    associate (rows => c%outline)
      if (size(rows, 1) < 3) then
        call config%complain(errors, W, OUTLINE, 'must be given, with at least 3 points')
        return
      end if
      do i = 2, size(rows, 1)
        if (all(rows(i, :) <= rows(i - 1, :) .and. rows(i, :) >= rows(i - 1, :))) then
          call config%complain(errors, W, OUTLINE, 'row '//number_text(i)//' repeats the point before it')
          return
        end if
      end do
      if (c%type == 'curve') then
        planform = curve_planform(transpose(rows))
      else
        planform = polygon_planform(transpose(rows))
      end if
    end associate
  end subroutine take_outline
end module fsi_planform_file

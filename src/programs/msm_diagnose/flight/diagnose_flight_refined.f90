! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the numerical errors of a case of `flusi` smaller, one after another: the keys of the ini file for each of them.
module diagnose_flight_refined
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_flight_omitted, only: points_in_chord
  use diagnosis_flight_refinements, only: FINER, NOT_REFINED, REFINE_BEATS, REFINE_BOX, REFINE_GRID, REFINE_PENALTY, &
                                          REFINE_SPONGE, REFINE_STEP, REFINE_SURFACE, REFINE_THICKNESS, THICKER, &
                                          thickness_error_over_change, THINNER, TIGHTER, USUAL_ERROR, WIDER
  use fluid_solid_keys, only: CHANNEL_NONE
  use fluid_sponge_keys, only: sponge_faces
  use fsi_body_motion, only: MOTION_TETHERED
  use fsi_kinematics, only: body_t
  use fsi_mask_keys, only: mask_choices, mask_choices_t
  use simulation_settings, only: settings_t
  implicit none
  private
  public :: flight_shift, flown_beats, refined_error_over_change, refined_text, three, why_unrefined

  character(*), parameter :: NL = new_line('a')
  character(2), parameter :: POINTS(3) = ['nx', 'ny', 'nz'], LENGTHS(3) = ['xl', 'yl', 'zl'], CENTRES(3) = ['x0', 'y0', 'z0']
  !> Thickness of wings in the mask, in points: the least with which chi reaches 1 and falls over a point to each side, and that
  !> with which little of the flow leaks through.
  real(rp), parameter :: LEAST_CELLS = 2, USUAL_CELLS = 4
  real(rp), parameter :: MOST_OF_CHORD = 0.5_rp !< thickness of a wing whose forces are about linear in it
  real(rp), parameter :: SAME = 1.0e-6_rp   !< relative

contains

  !> Returns why this numerical error of the case cannot be made smaller, as far as its settings tell; empty if it can. The wings
  !> of the experiment are `of_wing` [L] thick; 0: not known.
  pure function why_unrefined(s, refinement, of_wing) result(why)
    type(settings_t), intent(in) :: s
    integer, intent(in) :: refinement
    real(rp), intent(in) :: of_wing
    character(:), allocatable :: why
    why = ''
    select case (refinement)
    case (REFINE_PENALTY)
      if (.not. s%fluid%solids%is_on .or. s%flight%thin%is_thin .and. .not. s%flight%solid%exists()) &
        why = 'needs wings or a body in the mask'
    case (REFINE_THICKNESS)
      if (s%flight%thin%is_thin) why = 'needs wings in the mask, and these have no thickness'
    case (REFINE_SPONGE)
      if (.not. s%fluid%sponge%is_on) then
        why = 'needs a sponge'
      else if (fills_box(s)) then
        why = 'a sponge twice as thick would fill the box'
      end if
    end select
    if (any(refinement == [REFINE_THICKNESS, REFINE_SURFACE]) .and. why == '' .and. of_wing > 0 .and. &
        abs(2*s%flight%half_thickness - of_wing) <= SAME*of_wing) why = 'its wings have the thickness of those of the experiment'
  end function why_unrefined

  !> Tells whether a thicker sponge would reach across the box along any axis on which it lies.
  pure logical function fills_box(s)
    type(settings_t), intent(in) :: s
    integer, parameter :: FEW = 4 !< points of an axis of a plane flow, on which no sponge lies
    logical :: both(3), last(3)
    associate (n => s%fluid%grid%n, thick => THICKER*s%fluid%sponge%thickness)
      call sponge_faces(s%fluid%sponge%kind, both, last)
      fills_box = any(n > FEW .and. (both .and. 2*thick >= n .or. last .and. thick >= n))
    end associate
  end function fills_box

  !> Returns the number of beats that are flown if the case flies `beats`.
  pure integer function flown_beats(beats, refinement)
    integer, intent(in) :: beats, refinement
    flown_beats = beats
    if (refinement == REFINE_BEATS) flown_beats = beats + 1
  end function flown_beats

  !> Returns the error of the case over the change that a refinement makes. For the thickness of the wings and their representation
  !> it follows from the thickness `of_wing` [L] of those of the experiment. If this is not known (0), it counts as 0 where the
  !> wings of the case have a thickness, and else as that in the further flight.
  pure real(rp) function refined_error_over_change(s, refinement, of_wing) result(ratio)
    type(settings_t), intent(in) :: s
    integer, intent(in) :: refinement
    real(rp), intent(in) :: of_wing
    ratio = USUAL_ERROR(refinement)
    if (.not. of_wing > 0) return
    associate (of_case => 2*s%flight%half_thickness)
      if (refinement == REFINE_THICKNESS) ratio = thickness_error_over_change(of_case, THINNER*of_case, of_wing)
      if (refinement == REFINE_SURFACE) ratio = thickness_error_over_change(of_case, other_thickness(s, of_wing), of_wing)
    end associate
  end function refined_error_over_change

  !> Returns the thickness [L] of wings in the other representation: 0 if those of the case are in the mask, and else that of the
  !> wings of the experiment, `of_wing`, but at least four points. If that is more than half a mean chord, beyond which forces are
  !> not linear in the thickness (docs/results/flight-study.md), it is at least two points: a mask that leaks errs less than a
  !> change that is scaled. If the thickness is not known it is four points.
  pure real(rp) function other_thickness(s, of_wing) result(thickness)
    type(settings_t), intent(in) :: s
    real(rp), intent(in) :: of_wing
    real(rp) :: cells
    thickness = 0
    if (.not. s%flight%thin%is_thin) return
    cells = USUAL_CELLS
    if (of_wing > 0 .and. USUAL_CELLS > (1 + SAME)*MOST_OF_CHORD*points_in_chord(s)) cells = LEAST_CELLS
    thickness = max(of_wing, cells*s%fluid%grid%max_spacing())
  end function other_thickness

  !> Returns sections with the keys of a refinement. `length` and `time` are one L and one T in the units of the file. The wings of
  !> the experiment are `of_wing` [L] thick; 0: not known.
  function refined_text(s, refinement, length, time, of_wing) result(text)
    type(settings_t), intent(in) :: s
    integer, intent(in) :: refinement
    real(rp), intent(in) :: length, time, of_wing
    character(:), allocatable :: text
    text = ''
    select case (refinement)
    case (NOT_REFINED, REFINE_BEATS)
    case (REFINE_GRID)
      text = finer_grid(s, time)
    case (REFINE_STEP)
      text = '[Time]'//NL//shorter_step(s, FINER, time)
    case (REFINE_PENALTY)
      text = '[Penalization]'//NL//line('eps', TIGHTER*s%fluid%solids%c_eta*time)
      if (s%fluid%time%dt_fixed > s%fluid%time%cfl_eta*TIGHTER*s%fluid%solids%c_eta) &
        text = text//'[Time]'//NL//line('dt_fixed', TIGHTER*s%fluid%time%dt_fixed*time)
    case (REFINE_THICKNESS)
      text = thickness_text(s, THINNER*2*s%flight%half_thickness, length)
    case (REFINE_SURFACE)
      text = other_wings(s, other_thickness(s, of_wing), length, time)
    case (REFINE_BOX)
      text = larger_box(s, length)
    case (REFINE_SPONGE)
      text = '[Sponge]'//NL//'sponge_thickness = '//number_text(THICKER*s%fluid%sponge%thickness)//NL
    end select
  end function refined_text

  !> Returns the keys of a grid with about 1.5 times as many points in each direction, in even numbers, of steps that are as much
  !> shorter if they are prescribed, and of a sponge of the same physical size.
  function finer_grid(s, time) result(text)
    type(settings_t), intent(in) :: s
    real(rp), intent(in) :: time
    character(:), allocatable :: text
    integer :: i
    text = '[Resolution]'//NL
    do i = 1, 3
      if (s%fluid%grid%n(i) == 1) cycle
      text = text//POINTS(i)//' = '//number_text(2*nint(FINER*s%fluid%grid%n(i)/2))//NL
    end do
    if (s%fluid%time%dt_fixed > 0) text = text//'[Time]'//NL//line('dt_fixed', s%fluid%time%dt_fixed/FINER*time)
    if (s%fluid%sponge%thickness > 0) text = text//'[Sponge]'//NL//'sponge_thickness = '// &
                                             number_text(nint(FINER*s%fluid%sponge%thickness))//NL
  end function finer_grid

  !> Returns the keys of steps that are shorter by `factor`, whatever limits them.
  function shorter_step(s, factor, time) result(text)
    type(settings_t), intent(in) :: s
    real(rp), intent(in) :: factor, time
    character(:), allocatable :: text
    associate (t => s%fluid%time)
      if (t%dt_fixed > 0) then
        text = line('dt_fixed', t%dt_fixed/factor*time)
        return
      end if
      text = line('CFL', t%cfl/factor)//line('CFL_eta', t%cfl_eta/factor)
      if (t%dt_max > 0) text = text//line('dt_max', t%dt_max/factor*time)
    end associate
  end function shorter_step

  !> Returns the keys of the other representation of the wings: a surface, or a sheet of this thickness [L] in the mask. Prescribed
  !> steps are as short as the permeability of the case demands.
  function other_wings(s, thickness, length, time) result(text)
    type(settings_t), intent(in) :: s
    real(rp), intent(in) :: thickness, length, time
    character(:), allocatable :: text
    if (.not. s%flight%thin%is_thin) then
      text = '[Insects]'//NL//'surface = thin'//NL
      return
    end if
    text = '[Insects]'//NL//'surface = penalized'//NL//thickness_text(s, thickness, length)
    associate (longest => s%fluid%time%cfl_eta*s%fluid%solids%c_eta)
      if (s%fluid%time%dt_fixed > longest) text = text//'[Time]'//NL//line('dt_fixed', longest*time)
    end associate
  end function other_wings

  !> Returns the keys of wings of this thickness [L] in the mask, in the form in which the case gives it.
  function thickness_text(s, thickness, length) result(text)
    type(settings_t), intent(in) :: s
    real(rp), intent(in) :: thickness, length
    character(:), allocatable :: text
    type(mask_choices_t) :: mask
    mask = mask_choices(s%config)
    text = ''
    if (mask%has_half) text = '[Flexible_wing]'//NL//line('t_wing', thickness/2*length)
    if (mask%has_thickness .or. .not. mask%has_half) text = text//'[Insects]'//NL//line('WingThickness', thickness*length)
  end function thickness_text

  !> Returns the keys of a box that is about 1.5 times as large in each direction, with the same distance of points. The wings stay
  !> where they are: a periodic box has no middle, and walls are where they were. Only if a sponge or a cavity has its place at the
  !> faces, and the body is at rest, does the case move to the middle of the larger box.
  function larger_box(s, length) result(text)
    type(settings_t), intent(in) :: s
    real(rp), intent(in) :: length
    character(:), allocatable :: text
    real(rp) :: size_of(3), shift(3)
    integer :: n(3)
    shift = flight_shift(s, REFINE_BOX, 1)
    associate (f => s%fluid)
      n = wider_grid(f%grid%n)
      size_of = f%grid%length*n/f%grid%n
      text = '[Resolution]'//NL//whole_numbers(POINTS, n)//'[Geometry]'//NL//lines(LENGTHS, size_of*length)// &
             lines(CENTRES, (f%solids%centre + shift)*length)//'[Insects]'//NL//'x0 = '// &
             three((s%flight%body%centre + shift)*length)//NL
    end associate
  end function larger_box

  !> Returns how far [L] a refined flight is from the place of the case, which makes `beats` beats. One more beat is elsewhere if
  !> the body has moved on.
  function flight_shift(s, refinement, beats) result(shift)
    type(settings_t), intent(in) :: s
    integer, intent(in) :: refinement, beats
    real(rp) :: shift(3)
    type(body_t) :: before, after
    logical :: is_central
    associate (f => s%fluid)
      is_central = (f%sponge%is_on .or. f%walls%has_cavity) .and. f%walls%channel == CHANNEL_NONE .and. &
                   s%flight%motion%kind == MOTION_TETHERED
      shift = 0
      if (refinement == REFINE_BOX .and. is_central) shift = f%grid%length*(wider_grid(f%grid%n) - f%grid%n)/(2*f%grid%n)
    end associate
    if (refinement /= REFINE_BEATS) return
    before = s%flight%motion%at((beats - 1)/s%flight%frequency(), s%flight%body)
    after = s%flight%motion%at(beats/s%flight%frequency(), s%flight%body)
    shift = after%centre - before%centre
  end function flight_shift

  !> Returns about 1.5 times as many points of a grid, in even numbers.
  pure elemental integer function wider_grid(n) result(larger)
    integer, intent(in) :: n
    larger = merge(1, 2*nint(WIDER*n/2), n == 1)
  end function wider_grid

  !> Returns three numbers, separated by blanks.
  function three(x) result(text)
    real(rp), intent(in) :: x(3)
    character(:), allocatable :: text
    text = number_text(x(1))//' '//number_text(x(2))//' '//number_text(x(3))
  end function three

  !> Returns a line KEY = VALUE.
  function line(key, value) result(text)
    character(*), intent(in) :: key
    real(rp), intent(in) :: value
    character(:), allocatable :: text
    text = key//' = '//number_text(value)//NL
  end function line

  !> Returns a line for each key.
  function lines(keys, values) result(text)
    character(*), intent(in) :: keys(:)
    real(rp), intent(in) :: values(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(keys)
      text = text//line(keys(i), values(i))
    end do
  end function lines

  !> Returns a line for each key with a whole number.
  function whole_numbers(keys, values) result(text)
    character(*), intent(in) :: keys(:)
    integer, intent(in) :: values(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(keys)
      text = text//trim(keys(i))//' = '//number_text(values(i))//NL
    end do
  end function whole_numbers
end module diagnose_flight_refined

! SPDX-License-Identifier: GPL-3.0-or-later
!> Adds to a case of `flusi` what it leaves out: wings of another area, wings that bend, a wall, or a body between the wings.
module diagnose_flight_omitted
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnosis_flight_changes, only: FLOW_AREA, FLOW_BENDING, FLOW_BODY, FLOW_WALL, N_FLOW
  use fluid_solid_keys, only: CHANNEL_NONE
  use fsi_kinematics, only: body_t, pose_wing, wing_pose_t
  use fsi_wing_source, only: source_choices, source_choices_t
  use simulation_settings, only: settings_t
  implicit none
  private
  public :: omitted_t, omitted_text, omission_fault, points_in_chord, why_not_added, JUDGED

  !> Changes that only the reader of the case can judge.
  integer, parameter :: JUDGED(4) = [FLOW_AREA, FLOW_BENDING, FLOW_WALL, FLOW_BODY]

  !> What a user states of things that the case leaves out. Lengths are in L; 0: not stated.
  type :: omitted_t
    real(rp) :: wall_distance = 0 !< from the centre of the body
    integer :: wall_axis = 3      !< along which the wall is below the body
    real(rp) :: body_length = 0, body_radius = 0
  end type omitted_t

  character(*), parameter :: NL = new_line('a')
  character(2), parameter :: CHANNELS(3) = ['  ', 'xz', 'xy'] !< by the axis normal to the wall
  integer, parameter :: WALL_POINTS = 4
  integer, parameter :: GAP_POINTS = 2  !< between a wall and wings
  real(rp), parameter :: LEAST_POINTS = 15.5_rp !< docs/results/flight-records.md

contains

  !> Returns why the case cannot have change j, as far as its settings tell; empty if it can.
  function why_not_added(s, omitted, j) result(why)
    type(settings_t), intent(in) :: s
    type(omitted_t), intent(in) :: omitted
    integer, intent(in) :: j
    character(:), allocatable :: why
    why = ''
    select case (j)
    case (FLOW_AREA)
      if (s%flexible) then
        why = 'needs wings that do not bend'
      else if (s%flight%thin%is_thin .and. points_in_chord(s) < LEAST_POINTS) then
        why = 'needs 16 points in a chord, as the markers of wings without thickness come in whole numbers'
      end if
    case (FLOW_BENDING)
      if (s%flexible) then
        why = 'the wings of the case bend already'
      else if (.not. s%config%is_given('Wing', 'file')) then
        why = 'needs [Wing] file in the case: the wings as they bend'
      end if
    case (FLOW_WALL)
      if (s%fluid%walls%channel /= CHANNEL_NONE .or. s%fluid%walls%has_cavity) then
        why = 'the case has walls already'
      else if (.not. omitted%wall_distance > 0) then
        why = 'needs [Flight] wall_distance'
      end if
    case (FLOW_BODY)
      if (s%fluid%grid%is_2d) then
        why = 'needs a three-dimensional flow, and this case is a section'
      else if (s%flight%solid%exists()) then
        why = 'the case has a body already'
      else if (.not. (omitted%body_length > 0 .and. omitted%body_radius > 0)) then
        why = 'needs [Flight] body_length and body_radius'
      end if
    end select
  end function why_not_added

  !> Returns how many points of the grid lie along the smallest mean chord of a wing; the chord of a section lies along x.
  pure real(rp) function points_in_chord(s) result(points)
    type(settings_t), intent(in) :: s
    integer :: w
    points = huge(1.0_rp)
    do w = 1, size(s%flight%wings)
      associate (wing => s%flight%wings(w))
        if (s%fluid%grid%is_2d) points = min(points, maxval(wing%points(1, :)) - minval(wing%points(1, :)))
        if (.not. s%fluid%grid%is_2d) points = min(points, wing%mean_chord())
      end associate
    end do
    points = points/s%fluid%grid%max_spacing()
  end function points_in_chord

  !> Returns what is wrong with a flight with the changes c; empty if nothing is. A wall must be inside the box, and not in the way
  !> of the wings.
  function omission_fault(s, omitted, c) result(fault)
    type(settings_t), intent(in) :: s
    type(omitted_t), intent(in) :: omitted
    real(rp), intent(in) :: c(N_FLOW)
    character(:), allocatable :: fault
    fault = ''
    if (.not. c(FLOW_WALL) > 0) return
    associate (axis => omitted%wall_axis, place => wall_place(s, omitted, c(FLOW_WALL)))
      associate (spacing => s%fluid%grid%length(axis)/s%fluid%grid%n(axis))
        if (place < WALL_POINTS*spacing) then
          fault = 'the wall would be outside of the box: its effect is smaller than that of the box, or the box must be larger'
        else if (place > end_of_wings(s, axis) - GAP_POINTS*spacing) then
          fault = 'the wall would be in the way of the wings: state a larger [Flight] wall_distance, or leave wall out of '// &
                  '[Flight] effects'
        end if
      end associate
    end associate
  end function omission_fault

  !> Returns the smallest coordinate [L] along an axis that any wing reaches in the first beat. Bending is left out.
  real(rp) function end_of_wings(s, axis) result(least)
    type(settings_t), intent(in) :: s
    integer, intent(in) :: axis
    integer, parameter :: N = 40 !< times of the beat
    type(body_t) :: body
    type(wing_pose_t) :: pose
    real(rp) :: t, at(3)
    integer :: i, w, k
    least = huge(1.0_rp)
    do i = 1, N
      t = real(i, rp)/(N*s%flight%frequency())
      body = s%flight%motion%at(t, s%flight%body)
      do w = 1, size(s%flight%wings)
        associate (wing => s%flight%wings(w))
          call pose_wing(body, wing%mount, wing%motion, t, pose)
          do k = 1, size(wing%points, 2)
            at = pose%point_to_space(wing%points(:, k))
            least = min(least, at(axis))
          end do
        end associate
      end do
    end do
  end function end_of_wings

  !> Returns the place [L] of the face of a wall that acts c times as much as the one that is stated. What a wall at the distance d
  !> changes falls as 1/d^2 far from it, like the flow of a pair of vortices about its mirror image: the distance is d c^(-1/2).
  pure real(rp) function wall_place(s, omitted, c) result(place)
    type(settings_t), intent(in) :: s
    type(omitted_t), intent(in) :: omitted
    real(rp), intent(in) :: c
    place = s%flight%body%centre(omitted%wall_axis) - omitted%wall_distance/sqrt(c)
  end function wall_place

  !> Returns sections with the keys of these changes. `length` is one L in the units of the file.
  function omitted_text(s, omitted, c, length) result(text)
    type(settings_t), intent(in) :: s
    type(omitted_t), intent(in) :: omitted
    real(rp), intent(in) :: c(N_FLOW), length
    character(:), allocatable :: text
    text = ''
    if (abs(c(FLOW_AREA)) > 0) text = text//stretched(s, exp(c(FLOW_AREA)))
    if (c(FLOW_BENDING) > 0) text = text//bent(s, c(FLOW_BENDING))
    if (c(FLOW_WALL) > 0) then
      associate (axis => omitted%wall_axis)
        text = text//'[Penalization]'//NL//'iChannel = '//CHANNELS(axis)//NL// &
               line('thick_wall', WALL_POINTS*s%fluid%grid%length(axis)/s%fluid%grid%n(axis)*length)// &
               line('pos_wall', wall_place(s, omitted, c(FLOW_WALL))*length)
      end associate
    end if
    if (c(FLOW_BODY) > 0) text = text//body_text(s, omitted, c(FLOW_BODY)**(1/3.0_rp), length)
  end function omitted_text

  !> Returns the key of wings whose area is `factor` times that of the case; in a section their chord is.
  function stretched(s, factor) result(text)
    type(settings_t), intent(in) :: s
    real(rp), intent(in) :: factor
    character(:), allocatable :: text
    type(source_choices_t) :: source
    real(rp) :: stretch(2)
    source = source_choices(s%config)
    stretch = sqrt(factor)
    if (s%fluid%grid%is_2d) stretch = [factor, 1.0_rp]
    stretch = stretch*source%stretch
    text = '[Insects]'//NL//'wing_stretch = '//number_text(stretch(1))//' '//number_text(stretch(2))//NL
  end function stretched

  !> Returns the keys of wings that the same load bends c times as much as [Wing] of the case says.
  function bent(s, c) result(text)
    type(settings_t), intent(in) :: s
    real(rp), intent(in) :: c
    character(:), allocatable :: text
    text = '[Insects]'//NL//'wings = flexible'//NL//'[Wing]'//NL//line('E', s%config%get_real('Wing', 'E')/c)// &
           line('D', s%config%get_real('Wing', 'D')/c)
  end function bent

  !> Returns the keys of an ellipsoid whose lengths are `factor` times those that are stated. The hinges stay.
  function body_text(s, omitted, factor, length) result(text)
    type(settings_t), intent(in) :: s
    type(omitted_t), intent(in) :: omitted
    real(rp), intent(in) :: factor, length
    character(:), allocatable :: text
    integer :: w
    text = '[Insects]'//NL//'BodyType = ellipsoid'//NL//line('L_body', factor*omitted%body_length*length)// &
           line('b_body', factor*omitted%body_radius*length)
    do w = 1, size(s%flight%wings)
      associate (hinge => s%flight%wings(w)%mount%hinge*length)
        text = text//'x_pivot_'//s%flight%wings(w)%side(1:1)//' = '//number_text(hinge(1))//' '//number_text(hinge(2))// &
               ' '//number_text(hinge(3))//NL
      end associate
    end do
  end function body_text

  !> Returns a line KEY = VALUE.
  function line(key, value) result(text)
    character(*), intent(in) :: key
    real(rp), intent(in) :: value
    character(:), allocatable :: text
    text = key//' = '//number_text(value)//NL
  end function line
end module diagnose_flight_omitted

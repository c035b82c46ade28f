! SPDX-License-Identifier: GPL-3.0-or-later
!> Asks flights for the places of the landmarks that were measured: keys of [Saving] in the file of a flight, and the series that
!> the flight writes. Landmarks are numbered as in the records.
module diagnose_flight_landmarks
  use base_errors, only: failure_t, message_list_t
  use base_files, only: join_path
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnosis_flight_runner, only: N_PHASES
  use fsi_flight_params, only: flight_params_t
  use fsi_kinematics, only: body_t, pose_wing, wing_pose_t
  use io_series_read, only: read_series
  use measurement_flight, only: measured_flight_t, N_COMPONENTS, SIDE_NAMES
  use simulation_flight_series, only: landmarks_file
  use simulation_landmarks, only: mark_wing
  use simulation_output_params, only: landmarks_key
  use simulation_settings, only: settings_t
  implicit none
  private
  public :: flight_marks_t, interpolated, read_marks, rigid_places, take_marks

  !> All landmarks of the records of a case.
  type :: flight_marks_t
    integer, allocatable :: side(:)     !< of SIDE_NAMES
    real(rp), allocatable :: site(:, :) !< (2, n) [m] on the flat wing
  contains
    procedure :: count => marks_count
    procedure :: text => marks_text
  end type flight_marks_t

  character(*), parameter :: NL = new_line('a')

contains

  !> Returns how many landmarks there are.
  pure integer function marks_count(self) result(n)
    class(flight_marks_t), intent(in) :: self
    n = 0
    if (allocated(self%side)) n = size(self%side)
  end function marks_count

  !> Takes the landmarks of all records of a case. Adds a mistake for every record whose landmarks the case does not have: a wing
  !> that is not there, a point that is not on it, or x in a section.
  subroutine take_marks(flights, settings, is_section, marks, errors)
    type(measured_flight_t), intent(in) :: flights(:)
    type(settings_t), intent(in) :: settings
    logical, intent(in) :: is_section
    type(flight_marks_t), intent(out) :: marks
    type(message_list_t), intent(inout) :: errors
    type(flight_params_t) :: marked
    character(:), allocatable :: fault, object
    integer :: r, k, at(2)
    allocate (marks%side(0), marks%site(2, 0))
    do r = 1, size(flights)
      associate (f => flights(r))
        if (f%side == 0) cycle
        object = '/flight/'//f%name//'/landmarks/'//trim(SIDE_NAMES(f%side))
        marks%side = [marks%side, (f%side, k=1, f%count_landmarks())]
        marks%site = reshape([marks%site, f%points], [2, size(marks%side)])
        marked = settings%flight
        call mark_wing(settings%config, f%side, f%points/settings%units%length, marked, fault)
        if (fault /= '') call errors%add(object//': '//fault//' (one L is '//number_text(settings%units%length)//' m)')
        do k = 1, size(f%component)
          at = f%landmark_of(k)
          if (.not. is_section .or. at(2) /= 1) cycle
          call errors%add(object//'/mean: holds x of point '//number_text(at(1))//', but a section lies in the plane '// &
                          'of y and z: NaN is valid for x')
          exit
        end do
      end associate
    end do
  end subroutine take_marks

  !> Returns where the landmarks are in the last of so many beats if the wings of a case do not bend: x, y, z [m] of one after the
  !> other from the origin of the box, at each phase.
  function rigid_places(settings, marks, beats) result(places)
    type(settings_t), intent(in) :: settings
    type(flight_marks_t), intent(in) :: marks
    integer, intent(in) :: beats
    real(rp) :: places(N_PHASES, 3*marks%count())
    type(flight_params_t) :: marked
    type(body_t) :: body
    type(wing_pose_t) :: pose
    character(:), allocatable :: fault
    real(rp) :: t, at_rest(3, 1)
    integer :: l, w, i
    marked = settings%flight
    places = 0
    do l = 1, marks%count()
      call mark_wing(settings%config, marks%side(l), marks%site(:, l:l)/settings%units%length, marked, fault)
      do w = 1, size(marked%wings)
        associate (wing => marked%wings(w))
          if (fault /= '' .or. wing%side /= SIDE_NAMES(marks%side(l))) cycle
          at_rest = wing%landmarks%places(wing%points)
          do i = 1, N_PHASES
            t = (beats - 1 + real(i - 1, rp)/N_PHASES)/marked%frequency()
            body = marked%motion%at(t, marked%body)
            call pose_wing(body, wing%mount, wing%motion, t, pose)
            places(i, 3*l - 2:3*l) = settings%units%length*pose%point_to_space(at_rest(:, 1))
          end do
        end associate
      end do
    end do
  end function rigid_places

  !> Returns the section of an input file that asks for the paths of the landmarks. Lengths of the file are `unit` metres.
  function marks_text(self, unit) result(text)
    class(flight_marks_t), intent(in) :: self
    real(rp), intent(in) :: unit
    character(:), allocatable :: text
    integer :: side, i
    text = ''
    if (self%count() == 0) return
    text = '[Saving]'//NL
    do side = 1, size(SIDE_NAMES)
      if (.not. any(self%side == side)) cycle
      text = text//landmarks_key(side)//' = (/'
      do i = 1, self%count()
        if (self%side(i) == side) text = text//' '//number_text(self%site(1, i)/unit)//' '//number_text(self%site(2, i)/unit)//NL
      end do
      text = text//'/)'//NL
    end do
  end function marks_text

  !> Reads the places of the landmarks in the flight of `folder` into values(N_PHASES, :), behind the components of the force, in
  !> metres. `times` are those of the phases in T, `length` is one L in metres, and `shift` [L] is how far the flight is from the
  !> place of the case. Fails if a series cannot be read.
  subroutine read_marks(folder, marks, times, length, shift, values, failure)
    character(*), intent(in) :: folder
    type(flight_marks_t), intent(in) :: marks
    real(rp), intent(in) :: times(N_PHASES), length, shift(3)
    real(rp), intent(inout) :: values(:, :)
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: rows(:, :)
    real(rp) :: x(N_PHASES)
    integer :: side, i, c, column
    if (marks%count() == 0) return
    do side = 1, size(SIDE_NAMES)
      if (.not. any(marks%side == side)) cycle
      call read_series(join_path(folder, landmarks_file(SIDE_NAMES(side))), 1 + 3*count(marks%side == side), rows, failure)
      if (.not. failure%failed .and. size(rows, 2) < 2) &
        call failure%raise(join_path(folder, landmarks_file(SIDE_NAMES(side)))//': is too short')
      if (failure%failed) return
      column = 1
      do i = 1, marks%count()
        if (marks%side(i) /= side) cycle
        do c = 1, 3
          column = column + 1
          x = interpolated(rows(1, :), rows(column, :), times)
          values(:, N_COMPONENTS + 3*(i - 1) + c) = (x - shift(c))*length
        end do
      end do
    end do
  end subroutine read_marks

  !> Returns values at ascending times, interpolated linearly between those that were recorded at `recorded`, two or more.
  pure function interpolated(recorded, values, times) result(x)
    real(rp), intent(in) :: recorded(:), values(:), times(:)
    real(rp) :: x(size(times)), share
    integer :: i, k
    k = 1
    do i = 1, size(times)
      do while (k < size(recorded) - 1 .and. recorded(k + 1) < times(i))
        k = k + 1
      end do
      share = (times(i) - recorded(k))/(recorded(k + 1) - recorded(k))
      x(i) = (1 - share)*values(k) + share*values(k + 1)
    end do
  end function interpolated
end module diagnose_flight_landmarks

! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads records of flapping wings, which are in the group `/flight` of a measurement file (docs/formats/measurement-format.md).
module measurement_flight_file
  use base_kinds, only: rp
  use base_text, only: next_word, number_text, quoted
  use io_arrays, only: is_group
  use io_attributes, only: has_attribute
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use io_suggest, only: suggestion_t
  use measurement_attributes, only: above_zero, check_names, from_zero, read_real, read_vector, read_whole, read_word
  use measurement_axes, only: read_axes
  use measurement_flight, only: component_unit, measured_flight_t, read_times, read_values, COMPONENT_NAMES, FAR, KINEMATIC_SD, &
                                KINEMATIC_UNITS, N_COMPONENTS, N_KINEMATICS
  use measurement_landmarks, only: has_landmarks, read_landmarks
  use solid_wing_datasets, only: check_members, read_names
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: read_flights

  real(rp), parameter :: MOST_SD(N_KINEMATICS) = [0.4_rp, 20.0_rp, 0.4_rp, 20.0_rp, 0.2_rp, 0.4_rp, 20.0_rp, 0.4_rp]
  integer, parameter :: MOST_FLIGHT_NUMBERS = 20000 !< of all records

contains

  !> Reads all records of a file: those of forces in alphabetical order, then those of landmarks. `flights` is empty if the file has
  !> none. Mistakes in the file go to `report`.
  subroutine read_flights(file, flights, report)
    type(hdf5_file_t), intent(in) :: file
    type(measured_flight_t), allocatable, intent(out) :: flights(:)
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    type(measured_flight_t), allocatable :: forces(:), landmarks(:), more(:)
    logical, allocatable :: has_forces(:)
    integer :: i, k, n, total
    call read_names(file, '/flight', names, report)
    allocate (forces(size(names)), landmarks(0), has_forces(size(names)))
    if (is_group(file, '/flight')) call check_names(file, '/flight', [character(1) ::], report)
    n = 0
    do i = 1, size(names)
      associate (f => forces(i), group => '/flight/'//trim(names(i)))
        f%name = trim(names(i))
        allocate (f%component(0), f%time(0), f%mean(0, 0), f%is_known(0, 0), f%sd(0, 0), f%points(2, 0))
        call read_one(file, group, f, has_forces(i), report)
        if (.not. is_group(file, group)) cycle
        if (.not. has_landmarks(file, group)) cycle
        call read_landmarks(file, group, f, n, more, report)
        n = n + sum([(more(k)%count_landmarks(), k=1, size(more))])
        call append(landmarks, more)
      end associate
    end do
    allocate (flights(0))
    do i = 1, size(forces)
      if (has_forces(i)) call append(flights, forces(i:i))
    end do
    call append(flights, landmarks)
    total = sum([(flights(i)%count(), i=1, size(flights))])
    if (total > MOST_FLIGHT_NUMBERS) &
      call report%add('/flight', 'holds '//number_text(total)//' numbers; at most '//number_text(MOST_FLIGHT_NUMBERS)// &
                      ' are valid: take fewer times of the beat')
  end subroutine read_flights

  !> Adds records to a list.
  subroutine append(list, records)
    type(measured_flight_t), allocatable, intent(inout) :: list(:)
    type(measured_flight_t), intent(in) :: records(:)
    type(measured_flight_t), allocatable :: longer(:)
    integer :: i, n
    n = size(list)
    allocate (longer(n + size(records)))
    do i = 1, n
      longer(i) = list(i)
    end do
    do i = 1, size(records)
      longer(n + i) = records(i)
    end do
    call move_alloc(longer, list)
  end subroutine append

  !> Reads one record of a flight, without its landmarks. `has_forces` says whether there is anything else.
  subroutine read_one(file, group, f, has_forces, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_flight_t), intent(inout) :: f
    logical, intent(out) :: has_forces
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: text
    integer :: per_length, i
    has_forces = .true.
    if (.not. is_group(file, group)) then
      call report%add(group, 'is not a group with the attributes frequency, beats, frame, reference, components and units')
      return
    end if
    call check_members(file, group, [character(9) :: 'time', 'mean', 'sd', 'spread', 'landmarks'], report)
    call check_names(file, group, [character(24) :: 'frequency', 'beats', 'frame', 'axes', 'reference', 'correlation_time', &
                                   'per_length', 'components', 'units', KINEMATIC_SD], report)
    call read_real(file, group, 'frequency', 'Hz', above_zero(1.0e9_rp), f%frequency, report)
    call read_beats(file, group, f, report)
    call read_word(file, group, 'frame', .true., text, report)
    if (len(text) > 0 .and. text /= 'lab') call report%add(group, 'attribute frame is '//quoted(text)//'; valid: lab')
    do i = 1, N_KINEMATICS
      if (has_attribute(file, group, trim(KINEMATIC_SD(i)))) &
        call read_real(file, group, trim(KINEMATIC_SD(i)), trim(KINEMATIC_UNITS(i)), above_zero(MOST_SD(i)), f%kinematic_sd(i), &
                       report)
    end do
    call read_whole(file, group, 'per_length', 0, 1, 0, per_length, report)
    f%is_per_length = per_length == 1
    call read_axes(file, group, f%is_per_length, f%axes, report)
    if (has_landmarks(file, group)) has_forces = begins_forces(file, group)
    if (.not. has_forces .and. has_attribute(file, group, 'axes')) &
      call report%add(group, 'attribute axes is of forces, and the record has none; valid: axes of the group landmarks')
    if (.not. has_forces) return
    call read_vector(file, group, 'reference', 'm', FAR, f%reference, report)
    call read_real(file, group, 'correlation_time', 's', from_zero(1.0e6_rp), f%correlation_time, report, 0.0_rp)
    call read_components(file, group, f, report)
    call read_times(file, group, f, report)
    if (size(f%component) > 0 .and. size(f%time) > 0) call read_values(file, group, f, report)
  end subroutine read_one

  !> Tells whether a group with landmarks has any part of a record of forces, too.
  logical function begins_forces(file, group)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    character(16), parameter :: SETS(4) = [character(16) :: 'time', 'mean', 'sd', 'spread']
    character(16), parameter :: NAMES(3) = [character(16) :: 'components', 'units', 'reference']
    integer :: i
    begins_forces = .false.
    do i = 1, size(SETS)
      begins_forces = begins_forces .or. file%has(group//'/'//trim(SETS(i)))
    end do
    do i = 1, size(NAMES)
      begins_forces = begins_forces .or. has_attribute(file, group, trim(NAMES(i)))
    end do
  end function begins_forces

  !> Reads the number of beats that were averaged.
  subroutine read_beats(file, group, f, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_flight_t), intent(inout) :: f
    type(wing_report_t), intent(inout) :: report
    if (.not. has_attribute(file, group, 'beats')) &
      call report%add(group, 'attribute beats is missing; it must hold the number of beats that were averaged')
    call read_whole(file, group, 'beats', 1, huge(1), 1, f%beats, report)
  end subroutine read_beats

  !> Reads the names of the components, and checks that the attribute `units` names their units.
  subroutine read_components(file, group, f, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_flight_t), intent(inout) :: f
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: text, units
    type(suggestion_t) :: suggestion
    integer :: at, first, last, i, c
    logical :: found
    call read_word(file, group, 'components', .true., text, report)
    call read_word(file, group, 'units', .true., units, report)
    at = 1
    do
      call next_word(text, ' ,', at, first, last, found)
      if (.not. found .and. at == 1 .and. len(text) > 0) &
        call report%add(group, 'attribute components names none; valid: Fx, Fy, Fz, Mx, My, Mz, power')
      if (.not. found) exit
      c = 0
      call suggestion%start(text(first:last))
      do i = 1, N_COMPONENTS
        if (text(first:last) == COMPONENT_NAMES(i)) c = i
        call suggestion%offer(trim(COMPONENT_NAMES(i)))
      end do
      if (c == 0) then
        call report%add(group, 'attribute components: unknown component '//quoted(text(first:last))//suggestion%hint()// &
                        '; valid: Fx, Fy, Fz, Mx, My, Mz, power')
      else if (any(f%component == c)) then
        call report%add(group, 'attribute components names '//quoted(text(first:last))//' twice')
      else
        f%component = [f%component, c]
      end if
    end do
    if (len(units) == 0 .or. size(f%component) == 0) return
    text = component_unit(f%component(1), f%is_per_length)
    do i = 2, size(f%component)
      text = text//', '//component_unit(f%component(i), f%is_per_length)
    end do
    if (units /= text) call report%add(group, 'attribute units is '//quoted(units)//'; it must be '//quoted(text))
  end subroutine read_components
end module measurement_flight_file

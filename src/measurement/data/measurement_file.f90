! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads a measurement file (docs/formats/measurement-format.md). All mistakes of a file are reported together, each with the
!> object; every measurement that this module returns has passed the checks of measurement_check.
module measurement_file
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_text, only: quoted
  use io_arrays, only: is_group
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use io_seal, only: guard_input
  use io_suggest, only: suggestion_t
  use measurement_attributes, only: above_zero, check_names, from_zero, read_direction, read_real, read_vector, read_whole, &
                                    read_word, valid_range_t
  use measurement_check, only: check_measurement
  use measurement_data, only: measurement_t, measured_load_t, observation_t, NOT_STATED, QUANTITY_DISPLACEMENT, &
                              QUANTITY_ROTATION
  use measurement_heights, only: read_reference, read_surface
  use measurement_flight_file, only: read_flights
  use measurement_modes, only: read_modes
  use measurement_series, only: read_series
  use solid_wing, only: wing_t
  use solid_wing_datasets, only: check_members, check_schema, read_names
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: read_measurement, read_measurement_unguarded

  character(*), parameter :: SCHEMA = 'flusi-msm measurement'
  integer, parameter :: VERSION = 1
  real(rp), parameter :: FAR = 1.0e4_rp         !< [m] largest coordinate
  real(rp), parameter :: LONG_AGO = 1.0e10_rp   !< [s]

contains

  !> Reads the measurement file `path` of the valid `wing` in this process alone; MPI need not run. If `messages` has no more
  !> entries than before, `measurement` is complete and checked; otherwise its content is undefined. With `may_be_plan`, the file
  !> may be the plan of an experiment without measured values: see `is_plan`.
  subroutine read_measurement(path, wing, measurement, messages, may_be_plan)
    character(*), intent(in) :: path
    type(wing_t), intent(in) :: wing
    type(measurement_t), intent(out) :: measurement
    type(message_list_t), intent(inout) :: messages
    logical, intent(in), optional :: may_be_plan
    type(wing_report_t) :: report
    type(failure_t) :: failure
    logical :: may_plan, is_read
    integer :: i
    may_plan = .false.
    if (present(may_be_plan)) may_plan = may_be_plan
    call guard_input(path, 'measurement', failure)
    call read_measurement_unguarded(path, may_plan, measurement, is_read, report, failure)
    if (failure%failed) call messages%add(failure%reason)
    if (is_read) call check_measurement(measurement, wing, report)
    do i = 1, report%messages%count()
      call messages%add(report%messages%text(i))
    end do
  end subroutine read_measurement

  !> Reads a measurement file without comparing it with a wing or checking it as a whole. Damage that the HDF5 library does not
  !> survive ends the process. `is_read` tells whether it is a measurement file; its mistakes are in `report`.
  subroutine read_measurement_unguarded(path, may_be_plan, measurement, is_read, report, failure)
    character(*), intent(in) :: path
    logical, intent(in) :: may_be_plan
    type(measurement_t), intent(inout) :: measurement
    logical, intent(out) :: is_read
    type(wing_report_t), intent(inout) :: report
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    type(failure_t) :: ignored
    is_read = .false.
    if (failure%failed) return
    report%path = path
    call file%open_serial(path, failure)
    if (failure%failed) return
    call check_schema(file, 'measurement', SCHEMA, VERSION, report)
    is_read = report%is_clean()
    if (is_read) then
      call check_members(file, '/', [character(11) :: 'reference', 'loads', 'points', 'modes', 'series', 'flight', &
                                     'accuracy', 'calibration', 'extra'], report)
      call read_accuracy(file, measurement, report)
      call read_calibration(file, measurement, report)
      call read_modes(file, measurement%modes, measurement%air_density, report)
      call read_series(file, measurement%series, measurement%series_air_density, report)
      call read_flights(file, measurement%flights, report)
      call read_all_heights(file, may_be_plan, measurement, report)
      call read_observations(file, measurement, report)
    end if
    call file%close(ignored)
  end subroutine read_measurement_unguarded

  !> Reads the declared errors in /accuracy.
  subroutine read_accuracy(file, m, report)
    type(hdf5_file_t), intent(in) :: file
    type(measurement_t), intent(inout) :: m
    type(wing_report_t), intent(inout) :: report
    character(*), parameter :: OBJECT = '/accuracy'
    if (.not. file%has(OBJECT)) then
      if (file%has('/reference')) call report%add(OBJECT, 'missing; it must have the attribute height, the '// &
                                                  'standard deviation of heights [m]')
      return
    end if
    call check_names(file, OBJECT, [character(18) :: 'height', 'correlation_length', 'force', 'force_gain', &
                                    'position', 'tilt', 'piston'], report)
    if (file%has('/reference')) call read_real(file, OBJECT, 'height', 'm', above_zero(FAR), m%accuracy%height, report)
    call read_real(file, OBJECT, 'correlation_length', 'm', from_zero(FAR), m%accuracy%correlation_length, report, 0.0_rp)
    call read_real(file, OBJECT, 'force', 'N', from_zero(1.0e6_rp), m%accuracy%force, report, 0.0_rp)
    call read_real(file, OBJECT, 'force_gain', '', from_zero(10.0_rp), m%accuracy%force_gain, report, 0.0_rp)
    call read_real(file, OBJECT, 'position', 'm', from_zero(FAR), m%accuracy%position, report, 0.0_rp)
    call read_real(file, OBJECT, 'tilt', 'rad', from_zero(1.0_rp), m%accuracy%tilt, report, 0.0_rp)
    call read_real(file, OBJECT, 'piston', 'm', from_zero(FAR), m%accuracy%piston, report, 0.0_rp)
  end subroutine read_accuracy

  !> Reads the answers in /calibration.
  subroutine read_calibration(file, m, report)
    type(hdf5_file_t), intent(in) :: file
    type(measurement_t), intent(inout) :: m
    type(wing_report_t), intent(inout) :: report
    character(*), parameter :: OBJECT = '/calibration'
    if (.not. file%has(OBJECT)) return
    call read_whole(file, OBJECT, 'force_by_weight', 0, 1, -1, m%calibration%force_by_weight, report)
    call read_whole(file, OBJECT, 'height_by_gauge', 0, 1, -1, m%calibration%height_by_gauge, report)
    call read_whole(file, OBJECT, 'position_by_marks', 0, 1, -1, m%calibration%position_by_marks, report)
    call read_whole(file, OBJECT, 'order_is_random', 0, 1, -1, m%calibration%order_is_random, report)
  end subroutine read_calibration

  !> Reads the reference and all loads. A file without heights is a plan, which is a mistake unless `may_be_plan`.
  subroutine read_all_heights(file, may_be_plan, m, report)
    type(hdf5_file_t), intent(in) :: file
    logical, intent(in) :: may_be_plan
    type(measurement_t), intent(inout) :: m
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    logical :: has_reference
    integer :: l, n_moving
    has_reference = is_group(file, '/reference')
    call read_names(file, '/loads', names, report)
    n_moving = m%count_modes() + m%count_series() + m%count_flights()
    if (size(names) + n_moving == 0) &
      call report%add('/loads', 'there is no load, no mode in /modes and no record in /series and /flight')
    m%is_plan = .not. has_heights(file, has_reference, names) .and. n_moving == 0
    if (m%is_plan .and. .not. may_be_plan) then
      m%is_plan = has_reference
      if (has_reference) call report%add('/reference/z', 'missing; without heights a file is the plan of an '// &
                                         'experiment, for msm_diagnose --plan')
    end if
    if (has_reference) then
      call check_members(file, '/reference', [character(5) :: 'x', 'y', 'z', 'sigma'], report)
      call read_reference(file, m, report)
    else
      if (file%has('/reference')) call report%add('/reference', 'is not a group with datasets x, y and z')
      allocate (m%x(0), m%y(0), m%unloaded(0, 0), m%unloaded_sigma(0, 0), m%has_unloaded(0, 0))
    end if
    allocate (m%loads(size(names)))
    do l = 1, size(names)
      call read_load(file, trim(names(l)), has_reference, m, m%loads(l), report)
    end do
  end subroutine read_all_heights

  !> Tells whether the file holds any heights.
  logical function has_heights(file, has_reference, names)
    type(hdf5_file_t), intent(in) :: file
    logical, intent(in) :: has_reference
    character(NAME_LENGTH), intent(in) :: names(:) !< of loads
    integer :: l
    has_heights = .false.
    if (has_reference) has_heights = file%has('/reference/z')
    do l = 1, size(names)
      if (is_group(file, '/loads/'//trim(names(l)))) &
        has_heights = has_heights .or. file%has('/loads/'//trim(names(l))//'/z')
    end do
  end function has_heights

  !> Reads one load with its heights.
  subroutine read_load(file, name, has_reference, m, load, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    logical, intent(in) :: has_reference
    type(measurement_t), intent(in) :: m
    type(measured_load_t), intent(inout) :: load
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: group
    group = '/loads/'//name
    load%name = name
    allocate (load%node(2, 0), load%height(0), load%sigma(0))
    if (.not. is_group(file, group)) then
      call report%add(group, 'is not a group with the attributes force, direction and point')
      return
    end if
    call check_members(file, group, [character(5) :: 'z', 'sigma'], report)
    call check_names(file, group, [character(9) :: 'force', 'direction', 'point', 'order', 'time', 'hold', &
                                   'replicate'], report)
    load%has_surface = file%has(group//'/z')
    call read_real(file, group, 'force', 'N', valid_range_t(0.0_rp, 1.0e6_rp, load%has_surface), load%force, report)
    if (m%is_plan .and. has_reference) load%has_surface = load%force > 0
    call read_direction(file, group, 'direction', load%direction, report)
    call read_vector(file, group, 'point', 'm', FAR, load%point, report)
    call read_whole(file, group, 'order', 1, huge(1), 0, load%order, report)
    call read_whole(file, group, 'replicate', 1, huge(1), 1, load%replicate, report)
    call read_real(file, group, 'time', 's', from_zero(LONG_AGO), load%time, report, NOT_STATED)
    call read_real(file, group, 'hold', 's', from_zero(LONG_AGO), load%hold, report, NOT_STATED)
    if (load%has_surface .and. has_reference) then
      call read_surface(file, group, m, load, report)
    else if (load%has_surface) then
      call report%add(group//'/z', 'needs the unloaded heights in /reference, which is missing')
    end if
  end subroutine read_load

  !> Reads all displacements and rotations at single points.
  subroutine read_observations(file, m, report)
    type(hdf5_file_t), intent(in) :: file
    type(measurement_t), intent(inout) :: m
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    integer :: i
    call read_names(file, '/points', names, report)
    allocate (m%observations(size(names)), m%zeros(0))
    do i = 1, size(names)
      call read_observation(file, trim(names(i)), m, m%observations(i), report)
    end do
  end subroutine read_observations

  !> Reads one displacement or rotation at a point.
  subroutine read_observation(file, name, m, observation, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    type(measurement_t), intent(inout) :: m
    type(observation_t), intent(inout) :: observation
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: group, text
    character(NAME_LENGTH) :: zero
    type(suggestion_t) :: suggestion
    real(rp), allocatable :: unread !< none: the value is needed
    integer :: l
    group = '/points/'//name
    observation%name = name
    if (.not. is_group(file, group)) then
      call report%add(group, 'is not a group with attributes')
      return
    end if
    call check_members(file, group, [character(1) ::], report)
    call check_names(file, group, [character(8) :: 'load', 'quantity', 'point', 'axis', 'value', 'units', 'sigma', &
                                   'zero'], report)
    call read_word(file, group, 'load', .true., text, report)
    call suggestion%start(text)
    do l = 1, size(m%loads)
      if (m%loads(l)%name == text) observation%load = l
      call suggestion%offer(m%loads(l)%name)
    end do
    if (observation%load == 0 .and. len(text) > 0) call report%add(group, 'there is no load '//quoted(text)// &
                                                                   suggestion%hint())
    call read_word(file, group, 'quantity', .true., text, report)
    select case (text)
    case ('displacement')
      observation%quantity = QUANTITY_DISPLACEMENT
    case ('rotation')
      observation%quantity = QUANTITY_ROTATION
    case default
      if (len(text) > 0) call report%add(group, 'attribute quantity is '//quoted(text)// &
                                         '; valid: displacement, rotation')
    end select
    call read_vector(file, group, 'point', 'm', FAR, observation%point, report)
    call read_direction(file, group, 'axis', observation%axis, report)
    call read_word(file, group, 'units', .true., text, report)
    if (len(text) > 0 .and. text /= trim(merge('m  ', 'rad', observation%quantity == QUANTITY_DISPLACEMENT))) &
      call report%add(group, 'attribute units is '//quoted(text)//'; valid: m for displacements, rad for rotations')
    if (m%is_plan) unread = 0
    call read_real(file, group, 'value', '', valid_range_t(-FAR, FAR), observation%value, report, unread)
    call read_real(file, group, 'sigma', '', above_zero(FAR), observation%sigma, report)
    call read_word(file, group, 'zero', .false., text, report)
    if (len(text) == 0) return
    zero = text
    do l = 1, size(m%zeros)
      if (m%zeros(l) == zero) observation%zero = l
    end do
    if (observation%zero > 0) return
    m%zeros = [m%zeros, zero]
    observation%zero = size(m%zeros)
  end subroutine read_observation
end module measurement_file

! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes a measurement file, so that a computed measurement can be read as a measured one.
module whole_measurement
  use base_errors, only: failure_t
  use base_kinds, only: rp, i8
  use io_attributes, only: put_attribute
  use io_datasets, only: write_slab
  use io_hdf5, only: hdf5_file_t
  use io_seal, only: write_seal
  use measurement_data, only: measurement_t, measured_load_t, observation_t, QUANTITY_DISPLACEMENT
  use measurement_flight, only: component_unit, measured_flight_t, COMPONENT_NAMES, KINEMATIC_SD, N_COMPONENTS, N_KINEMATICS, &
                                SIDE_NAMES
  use measurement_modes, only: measured_mode_t, MEDIUM_NAMES
  use measurement_series, only: measured_series_t
  use solid_ringing, only: EXCITED_BASE, EXCITED_RELEASE
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  implicit none
  private
  public :: write_measurement

contains

  !> Writes `m`, bending tests, modes and all records, to the file `path`, in this process alone. Heights are written where the
  !> load and the reference have them. Reading it gives `m` again if the loads are in alphabetical
  !> order, heights and numbers to the last bit, directions normalised.
  subroutine write_measurement(path, m, failure)
    character(*), intent(in) :: path
    type(measurement_t), intent(in) :: m
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    integer :: i
    call file%create_serial(path, failure)
    call put_attribute(file, '/', 'schema', 'flusi-msm measurement', failure)
    call put_attribute(file, '/', 'version', 1, failure)
    if (size(m%x) > 0) then
      call file%make_group('/reference', failure)
      call write_reals(file, '/reference/x', [size(m%x)], m%x, failure)
      call write_reals(file, '/reference/y', [size(m%y)], m%y, failure)
      if (.not. m%is_plan) call write_map(file, '/reference/z', m%unloaded, m%has_unloaded, failure)
      call write_map(file, '/reference/sigma', m%unloaded_sigma, m%unloaded_sigma > 0, failure)
    end if
    call write_accuracy(file, m, failure)
    if (size(m%loads) > 0) call file%make_group('/loads', failure)
    do i = 1, size(m%loads)
      call write_load(file, m, m%loads(i), failure)
    end do
    if (size(m%observations) > 0) call file%make_group('/points', failure)
    do i = 1, size(m%observations)
      call write_observation(file, m, m%observations(i), failure)
    end do
    if (m%count_modes() > 0) then
      call file%make_group('/modes', failure)
      call put_attribute(file, '/modes', 'air_density', m%air_density, failure)
    end if
    do i = 1, m%count_modes()
      call write_mode(file, m%modes(i), failure)
    end do
    if (m%count_series() > 0) then
      call file%make_group('/series', failure)
      call put_attribute(file, '/series', 'air_density', m%series_air_density, failure)
    end if
    do i = 1, m%count_series()
      call write_record(file, m%series(i), failure)
    end do
    if (m%count_flights() > 0) call file%make_group('/flight', failure)
    do i = 1, m%count_flights()
      call write_flight(file, m%flights(i), failure)
    end do
    call file%close(failure)
    call write_seal(path, failure)
  end subroutine write_measurement

  !> Writes one mode.
  subroutine write_mode(file, mode, failure)
    type(hdf5_file_t), intent(in) :: file
    type(measured_mode_t), intent(in) :: mode
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: group
    character(12) :: number
    integer :: n, i
    group = '/modes/'//mode%name
    call file%make_group(group, failure)
    call put_attribute(file, group, 'frequency', mode%frequency, failure)
    call put_attribute(file, group, 'frequency_sigma', mode%frequency_sigma, failure)
    call put_attribute(file, group, 'medium', trim(MEDIUM_NAMES(mode%medium)), failure)
    if (mode%damping >= 0) then
      call put_attribute(file, group, 'damping', mode%damping, failure)
      call put_attribute(file, group, 'damping_sigma', mode%damping_sigma, failure)
    end if
    if (mode%number > 0) call put_attribute(file, group, 'number', mode%number, failure)
    if (any(abs(mode%gravity) > 0)) call put_attribute(file, group, 'gravity', mode%gravity, failure)
    n = 0
    if (allocated(mode%load_size)) n = size(mode%load_size)
    if (n > 0) call file%make_group(group//'/loads', failure)
    do i = 1, n
      write (number, '(i0.4)') i ! alphabetical order is that of the numbers
      call file%make_group(group//'/loads/'//trim(number), failure)
      call put_attribute(file, group//'/loads/'//trim(number), 'force', mode%load_size(i), failure)
      call put_attribute(file, group//'/loads/'//trim(number), 'direction', mode%load_direction(:, i), failure)
      call put_attribute(file, group//'/loads/'//trim(number), 'point', mode%load_place(:, i), failure)
    end do
    n = size(mode%shape)
    if (n == 0) return
    call write_reals(file, group//'/points', [2, n], [mode%place], failure)
    call write_reals(file, group//'/shape', [n], mode%shape, failure, '1')
    call write_reals(file, group//'/sigma', [n], mode%sigma, failure, '1')
  end subroutine write_mode

  !> Writes one vibration record.
  subroutine write_record(file, s, failure)
    type(hdf5_file_t), intent(in) :: file
    type(measured_series_t), intent(in) :: s
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: group, units
    real(rp), allocatable :: by_sample(:, :)
    integer :: n, m
    group = '/series/'//s%name
    units = trim(merge('m/s', 'm  ', s%is_velocity))
    call file%make_group(group, failure)
    call put_attribute(file, group, 'medium', trim(MEDIUM_NAMES(s%medium)), failure)
    call put_attribute(file, group, 'units', units, failure)
    call put_attribute(file, group, 'direction', s%direction, failure)
    call put_attribute(file, group, 'axis', s%axis, failure)
    call put_attribute(file, group, 'rate', s%rate, failure)
    call put_attribute(file, group, 'trigger_sigma', s%trigger_sigma, failure)
    if (s%lowpass > 0) then
      call put_attribute(file, group, 'lowpass', s%lowpass, failure)
      call put_attribute(file, group, 'order', s%order, failure)
    end if
    if (s%excitation == EXCITED_BASE) then
      call put_attribute(file, group, 'excitation', 'base', failure)
      call write_reals(file, group//'/base', [size(s%base)], s%base, failure, 'm/s2')
    else
      call put_attribute(file, group, 'excitation', trim(merge('release', 'tap    ', s%excitation == EXCITED_RELEASE)), failure)
      call put_attribute(file, group, 'start', s%start, failure)
      call put_attribute(file, group, 'point', s%point, failure)
      call put_attribute(file, group, 'size', s%size, failure)
      call put_attribute(file, group, 'size_sigma', s%size_sigma, failure)
    end if
    n = size(s%values, 1)
    m = size(s%values, 2)
    by_sample = transpose(merge(s%values, ieee_value(0.0_rp, ieee_quiet_nan), s%is_known))
    call write_reals(file, group//'/points', [2, m], [s%place], failure)
    call write_reals(file, group//'/values', [m, n], [by_sample], failure, units)
    call write_reals(file, group//'/sigma', [m], s%sigma, failure, units)
  end subroutine write_record

  !> Writes one record of forces or landmarks over the beat.
  subroutine write_flight(file, f, failure)
    type(hdf5_file_t), intent(in) :: file
    type(measured_flight_t), intent(in) :: f
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: group, components, units
    real(rp), allocatable :: by_time(:, :)
    integer :: n, k
    group = '/flight/'//f%name
    if (.not. file%has(group)) call write_facts(file, group, f, failure)
    if (f%side > 0) then
      call write_landmarks(file, group//'/landmarks', f, failure)
      return
    end if
    n = size(f%time)
    components = ''
    units = ''
    do k = 1, size(f%component)
      components = components//', '//trim(COMPONENT_NAMES(f%component(k)))
      units = units//', '//component_unit(f%component(k), f%is_per_length)
    end do
    call put_attribute(file, group, 'reference', f%reference, failure)
    call put_attribute(file, group, 'axes', reshape(transpose(f%axes), [9]), failure)
    call put_attribute(file, group, 'correlation_time', f%correlation_time, failure)
    call put_attribute(file, group, 'components', components(3:), failure)
    call put_attribute(file, group, 'units', units(3:), failure)
    k = size(f%component)
    call write_reals(file, group//'/time', [n], f%time, failure, '1')
    by_time = transpose(merge(f%mean, ieee_value(0.0_rp, ieee_quiet_nan), f%is_known))
    call write_reals(file, group//'/mean', [k, n], [by_time], failure, '1')
    by_time = transpose(f%sd)
    call write_reals(file, group//'/sd', [k, n], [by_time], failure, '1')
  end subroutine write_flight

  !> Writes what forces and landmarks of a flight have in common.
  subroutine write_facts(file, group, f, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_flight_t), intent(in) :: f
    type(failure_t), intent(inout) :: failure
    integer :: k
    call file%make_group(group, failure)
    call put_attribute(file, group, 'frequency', f%frequency, failure)
    call put_attribute(file, group, 'beats', f%beats, failure)
    call put_attribute(file, group, 'frame', 'lab', failure)
    do k = 1, N_KINEMATICS
      if (f%kinematic_sd(k) > 0) call put_attribute(file, group, trim(KINEMATIC_SD(k)), f%kinematic_sd(k), failure)
    end do
    call put_attribute(file, group, 'per_length', merge(1, 0, f%is_per_length), failure)
  end subroutine write_facts

  !> Writes the landmarks of one wing, from the origin of the case.
  subroutine write_landmarks(file, group, f, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_flight_t), intent(in) :: f
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: wing
    real(rp) :: mean(3*f%count_landmarks(), size(f%time)), sd(3*f%count_landmarks(), size(f%time))
    integer :: k, row
    wing = group//'/'//trim(SIDE_NAMES(f%side))
    if (.not. file%has(group)) then
      call file%make_group(group, failure)
      call put_attribute(file, group, 'origin', [0.0_rp, 0.0_rp, 0.0_rp], failure)
      call put_attribute(file, group, 'axes', reshape(transpose(f%axes), [9]), failure)
      call put_attribute(file, group, 'beats', f%beats, failure)
      call put_attribute(file, group, 'correlation_time', f%correlation_time, failure)
      if (f%offset_sd > 0) call put_attribute(file, group, 'offset_sd', f%offset_sd, failure)
      if (f%turn_sd > 0) call put_attribute(file, group, 'turn_sd', f%turn_sd, failure)
    end if
    call file%make_group(wing, failure)
    mean = ieee_value(0.0_rp, ieee_quiet_nan)
    sd = 1
    do k = 1, size(f%component)
      row = f%component(k) - N_COMPONENTS - 3*f%first
      mean(row, :) = merge(f%mean(:, k), ieee_value(0.0_rp, ieee_quiet_nan), f%is_known(:, k))
      sd(row, :) = f%sd(:, k)
    end do
    call write_reals(file, wing//'/time', [size(f%time)], f%time, failure, '1')
    call write_reals(file, wing//'/points', [2, f%count_landmarks()], [f%points], failure)
    call write_reals(file, wing//'/mean', shape(mean), [mean], failure, '1')
    call write_reals(file, wing//'/sd', shape(sd), [sd], failure, '1')
  end subroutine write_landmarks

  !> Writes the declared errors.
  subroutine write_accuracy(file, m, failure)
    type(hdf5_file_t), intent(in) :: file
    type(measurement_t), intent(in) :: m
    type(failure_t), intent(inout) :: failure
    call file%make_group('/accuracy', failure)
    if (m%accuracy%height > 0) call put_attribute(file, '/accuracy', 'height', m%accuracy%height, failure)
    call put_attribute(file, '/accuracy', 'correlation_length', m%accuracy%correlation_length, failure)
    call put_attribute(file, '/accuracy', 'force', m%accuracy%force, failure)
    call put_attribute(file, '/accuracy', 'force_gain', m%accuracy%force_gain, failure)
    call put_attribute(file, '/accuracy', 'position', m%accuracy%position, failure)
    call put_attribute(file, '/accuracy', 'tilt', m%accuracy%tilt, failure)
    call put_attribute(file, '/accuracy', 'piston', m%accuracy%piston, failure)
    call file%make_group('/calibration', failure)
    call put_known('force_by_weight', m%calibration%force_by_weight)
    call put_known('height_by_gauge', m%calibration%height_by_gauge)
    call put_known('position_by_marks', m%calibration%position_by_marks)
    call put_known('order_is_random', m%calibration%order_is_random)

  contains

    subroutine put_known(name, value)
      character(*), intent(in) :: name
      integer, intent(in) :: value
      if (value >= 0) call put_attribute(file, '/calibration', name, value, failure)
    end subroutine put_known

  end subroutine write_accuracy

  !> Writes one load with its heights.
  subroutine write_load(file, m, load, failure)
    type(hdf5_file_t), intent(in) :: file
    type(measurement_t), intent(in) :: m
    type(measured_load_t), intent(in) :: load
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: map(:, :), sigma(:, :)
    logical, allocatable :: has(:, :)
    character(:), allocatable :: group
    integer :: k
    group = '/loads/'//load%name
    call file%make_group(group, failure)
    call put_attribute(file, group, 'force', load%force, failure)
    call put_attribute(file, group, 'direction', load%direction, failure)
    call put_attribute(file, group, 'point', load%point, failure)
    call put_attribute(file, group, 'replicate', load%replicate, failure)
    if (load%order > 0) call put_attribute(file, group, 'order', load%order, failure)
    if (load%time >= 0) call put_attribute(file, group, 'time', load%time, failure)
    if (load%hold >= 0) call put_attribute(file, group, 'hold', load%hold, failure)
    if (load%count() == 0) return
    allocate (map(size(m%x), size(m%y)), sigma(size(m%x), size(m%y)), source=0.0_rp)
    allocate (has(size(m%x), size(m%y)), source=.false.)
    do k = 1, load%count()
      has(load%node(1, k), load%node(2, k)) = .true.
      map(load%node(1, k), load%node(2, k)) = load%height(k)
      sigma(load%node(1, k), load%node(2, k)) = load%sigma(k)
    end do
    if (.not. m%is_plan) call write_map(file, group//'/z', map, has, failure)
    call write_map(file, group//'/sigma', sigma, has, failure)
  end subroutine write_load

  !> Writes one displacement or rotation at a point.
  subroutine write_observation(file, m, observation, failure)
    type(hdf5_file_t), intent(in) :: file
    type(measurement_t), intent(in) :: m
    type(observation_t), intent(in) :: observation
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: group
    logical :: is_displacement
    is_displacement = observation%quantity == QUANTITY_DISPLACEMENT
    group = '/points/'//observation%name
    call file%make_group(group, failure)
    call put_attribute(file, group, 'load', m%loads(observation%load)%name, failure)
    call put_attribute(file, group, 'quantity', trim(merge('displacement', 'rotation    ', is_displacement)), failure)
    call put_attribute(file, group, 'units', trim(merge('m  ', 'rad', is_displacement)), failure)
    call put_attribute(file, group, 'point', observation%point, failure)
    call put_attribute(file, group, 'axis', observation%axis, failure)
    call put_attribute(file, group, 'value', observation%value, failure)
    call put_attribute(file, group, 'sigma', observation%sigma, failure)
    if (observation%zero > 0) call put_attribute(file, group, 'zero', trim(m%zeros(observation%zero)), failure)
  end subroutine write_observation

  !> Returns values where `has`, NaN elsewhere.
  subroutine write_map(file, name, values, has, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    real(rp), intent(in) :: values(:, :)
    logical, intent(in) :: has(:, :)
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: flat(:)
    allocate (flat(size(values)), source=ieee_value(0.0_rp, ieee_quiet_nan))
    flat = unpack(pack(values, has), pack(has, .true.), flat)
    call write_reals(file, name, shape(values), flat, failure)
  end subroutine write_map

  !> Writes an array of reals with its units.
  subroutine write_reals(file, name, dims, values, failure, units)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(in) :: dims(:)
    real(rp), contiguous, intent(in) :: values(:)
    type(failure_t), intent(inout) :: failure
    character(*), intent(in), optional :: units !< m if absent
    integer(i8) :: start(size(dims))
    start = 0
    call write_slab(file, name, int(dims, i8), start, int(dims, i8), values, .false., failure)
    if (present(units)) then
      call put_attribute(file, name, 'units', units, failure)
    else
      call put_attribute(file, name, 'units', 'm', failure)
    end if
  end subroutine write_reals
end module whole_measurement

! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads records of the forces on a flapping wing: force, torque and power over the beat. They are in the group `/flight` of a
!> measurement file (docs/formats/measurement-format.md).
module measurement_flight
  use base_kinds, only: rp
  use base_text, only: next_word, number_text, quoted
  use base_visitor, only: visited_t, visitor_t
  use io_arrays, only: is_finite, is_group, is_infinite
  use io_attributes, only: has_attribute
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use io_suggest, only: suggestion_t
  use measurement_attributes, only: above_zero, check_names, from_zero, read_real, read_vector, read_whole, read_word
  use solid_wing_datasets, only: check_members, read_names, read_real_dataset
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: measured_flight_t, component_unit, read_flights

  integer, parameter, public :: N_COMPONENTS = 7
  character(5), parameter, public :: COMPONENT_NAMES(N_COMPONENTS) = [character(5) :: 'Fx', 'Fy', 'Fz', 'Mx', 'My', 'Mz', 'power']
  integer, parameter, public :: COMPONENT_POWER = 7
  integer, parameter, public :: N_KINEMATICS = 8 !< quantities of the kinematics whose errors a record may state
  character(24), parameter, public :: KINEMATIC_SD(N_KINEMATICS) = [character(24) :: & !< its attributes
    'stroke_amplitude_sd', 'stroke_mean_sd', 'pitch_amplitude_sd', 'pitch_mean_sd', 'pitch_lead_sd', 'deviation_amplitude_sd', &
    'stroke_plane_sd', 'beat_frequency_sd']
  character(6), parameter :: KINEMATIC_UNITS(N_KINEMATICS) = [character(6) :: '', 'degree', '', 'degree', 'beat', '', 'degree', '']
  real(rp), parameter :: MOST_SD(N_KINEMATICS) = [0.4_rp, 20.0_rp, 0.4_rp, 20.0_rp, 0.2_rp, 0.4_rp, 20.0_rp, 0.4_rp]
  integer, parameter :: MOST_FLIGHT_NUMBERS = 20000 !< of all records
  integer, parameter :: FEWEST = 4 !< times of a record

  !> A record holds the means over several beats at fixed times of the beat.
  type, extends(visited_t) :: measured_flight_t
    character(:), allocatable :: name
    real(rp) :: frequency = 0                 !< [Hz] of the beat
    integer :: beats = 1                      !< number of beats that were averaged
    real(rp) :: reference(3) = 0              !< [m] point about which torques act
    real(rp) :: correlation_time = 0          !< [s] of the errors of each component; 0: they are independent
    real(rp) :: kinematic_sd(N_KINEMATICS) = 0 !< of the kinematics as measured: relative, degrees, beats; 0: not stated
    logical :: is_per_length = .false.        !< values are per metre of span, from a two-dimensional section
    integer, allocatable :: component(:)      !< (k) numbers in COMPONENT_NAMES
    real(rp), allocatable :: time(:)          !< (n) of the beat, increasing, in [0, 1)
    real(rp), allocatable :: mean(:, :)       !< (n, k) [N], [N m] or [W]; 0 where unknown
    logical, allocatable :: is_known(:, :)    !< (n, k)
    real(rp), allocatable :: sd(:, :)         !< (n, k) of `mean`, in its unit; 1 where unknown
  contains
    procedure :: visit => flight_visit
    procedure :: count => flight_count
  end type measured_flight_t

  real(rp), parameter :: FAR = 1.0e4_rp       !< [m]

contains

  !> Passes every component of the type to the visitor.
  subroutine flight_visit(self, visitor)
    class(measured_flight_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit_allocatable('name', self%name)
    call visitor%visit('frequency', self%frequency)
    call visitor%visit('beats', self%beats)
    call visitor%visit('reference', self%reference)
    call visitor%visit('correlation_time', self%correlation_time)
    call visitor%visit('kinematic_sd', self%kinematic_sd)
    call visitor%visit('is_per_length', self%is_per_length)
    call visitor%visit_allocatable('component', self%component)
    call visitor%visit_allocatable('time', self%time)
    call visitor%visit_allocatable('mean', self%mean)
    call visitor%visit_allocatable('is_known', self%is_known)
    call visitor%visit_allocatable('sd', self%sd)
  end subroutine flight_visit

  !> Returns how many measured numbers are known.
  pure integer function flight_count(self) result(n)
    class(measured_flight_t), intent(in) :: self
    n = 0
    if (allocated(self%is_known)) n = count(self%is_known)
  end function flight_count

  !> Returns the unit of a component, for a wing or, if `is_per_length`, per metre of span.
  pure function component_unit(component, is_per_length) result(unit)
    integer, intent(in) :: component
    logical, intent(in) :: is_per_length
    character(:), allocatable :: unit
    select case (component)
    case (:3)
      unit = trim(merge('N/m', 'N  ', is_per_length))
    case (4:6)
      unit = trim(merge('N  ', 'N m', is_per_length))
    case default
      unit = trim(merge('W/m', 'W  ', is_per_length))
    end select
  end function component_unit

  !> Reads all records of a file in alphabetical order. `flights` is empty if the file has none. Mistakes in the file go to
  !> `report`.
  subroutine read_flights(file, flights, report)
    type(hdf5_file_t), intent(in) :: file
    type(measured_flight_t), allocatable, intent(out) :: flights(:)
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    integer :: i, total
    call read_names(file, '/flight', names, report)
    allocate (flights(size(names)))
    if (is_group(file, '/flight')) call check_names(file, '/flight', [character(1) ::], report)
    total = 0
    do i = 1, size(names)
      associate (f => flights(i))
        f%name = trim(names(i))
        allocate (f%component(0), f%time(0), f%mean(0, 0), f%is_known(0, 0), f%sd(0, 0))
        call read_one(file, '/flight/'//f%name, f, report)
        total = total + f%count()
      end associate
    end do
    if (total > MOST_FLIGHT_NUMBERS) &
      call report%add('/flight', 'holds '//number_text(total)//' numbers; at most '//number_text(MOST_FLIGHT_NUMBERS)// &
                      ' are valid: take fewer times of the beat')
  end subroutine read_flights

  !> Reads one record of a flight.
  subroutine read_one(file, group, f, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_flight_t), intent(inout) :: f
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: text
    integer :: per_length, i
    if (.not. is_group(file, group)) then
      call report%add(group, 'is not a group with the attributes frequency, beats, frame, reference, components and units')
      return
    end if
    call check_members(file, group, [character(6) :: 'time', 'mean', 'sd', 'spread'], report)
    call check_names(file, group, [character(24) :: 'frequency', 'beats', 'frame', 'reference', 'correlation_time', &
                                   'per_length', 'components', 'units', KINEMATIC_SD], report)
    call read_real(file, group, 'frequency', 'Hz', above_zero(1.0e9_rp), f%frequency, report)
    call read_beats(file, group, f, report)
    call read_word(file, group, 'frame', .true., text, report)
    if (len(text) > 0 .and. text /= 'lab') call report%add(group, 'attribute frame is '//quoted(text)//'; valid: lab')
    call read_vector(file, group, 'reference', 'm', FAR, f%reference, report)
    call read_real(file, group, 'correlation_time', 's', from_zero(1.0e6_rp), f%correlation_time, report, 0.0_rp)
    do i = 1, N_KINEMATICS
      if (has_attribute(file, group, trim(KINEMATIC_SD(i)))) &
        call read_real(file, group, trim(KINEMATIC_SD(i)), trim(KINEMATIC_UNITS(i)), above_zero(MOST_SD(i)), f%kinematic_sd(i), &
                       report)
    end do
    call read_whole(file, group, 'per_length', 0, 1, 0, per_length, report)
    f%is_per_length = per_length == 1
    call read_components(file, group, f, report)
    call read_times(file, group, f, report)
    if (size(f%component) > 0 .and. size(f%time) > 0) call read_values(file, group, f, report)
  end subroutine read_one

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

  !> Reads the times of a record, fractions of a beat in ascending order.
  subroutine read_times(file, group, f, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_flight_t), intent(inout) :: f
    type(wing_report_t), intent(inout) :: report
    real(rp), allocatable :: time(:)
    integer :: n
    call read_real_dataset(file, group//'/time', 0, time, report, has_units=.false.)
    n = size(time)
    if (n == 0) return
    if (.not. all(is_finite(time))) then
      call report%add(group//'/time', 'holds a number that is infinite or undefined')
    else if (n < FEWEST) then
      call report%add(group//'/time', 'holds '//number_text(n)//' times; at least '//number_text(FEWEST)//' make a record')
    else if (any(time < 0) .or. any(time >= 1)) then
      call report%add(group//'/time', 'holds '//number_text(merge(minval(time), maxval(time), any(time < 0)))// &
                      '; fractions of a beat, at least 0 and below 1, are valid')
    else if (.not. all(time(2:) > time(:n - 1))) then
      call report%add(group//'/time', 'is not strictly increasing')
    else
      f%time = time
    end if
  end subroutine read_times

  !> Reads the means and their sd. The sd is either given or computed from the spread over the beats.
  subroutine read_values(file, group, f, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_flight_t), intent(inout) :: f
    type(wing_report_t), intent(inout) :: report
    real(rp), allocatable :: mean(:), sd(:)
    logical, allocatable :: is_known(:)
    character(:), allocatable :: name
    integer :: n, k
    name = 'sd'
    if (file%has(group//'/spread')) name = 'spread'
    if (file%has(group//'/sd') .eqv. file%has(group//'/spread')) then
      call report%add(group, 'must have either sd, of the mean, or spread, of single beats')
      return
    end if
    if (name == 'spread' .and. f%beats < 2) &
      call report%add(group//'/spread', 'needs the attribute beats, at least 2: one beat has no spread')
    k = size(f%component)
    n = size(f%time)
    call read_real_dataset(file, group//'/mean', k, mean, report, has_units=.false.)
    call read_real_dataset(file, group//'/'//name, k, sd, report, has_units=.false.)
    if (min(size(mean), size(sd)) == 0) return
    if (size(mean) /= n*k .or. size(sd) /= n*k) then
      call report%add(group, 'time has '//number_text(n)//' numbers, mean '//number_text(size(mean)/k)//' rows and '//name//' '// &
                      number_text(size(sd)/k)//'; they must be as many')
      return
    end if
    is_known = is_finite(mean)
    if (any(is_infinite(mean))) then
      call report%add(group//'/mean', 'holds an infinite number; only NaN means missing')
    else if (.not. all(is_finite(pack(sd, is_known)))) then
      call report%add(group//'/'//name, 'holds a number that is infinite or undefined where the mean is known')
    else if (.not. all(pack(sd, is_known) > 0)) then
      call report%add(group//'/'//name, 'holds '//number_text(minval(pack(sd, is_known)))//'; standard deviations must be positive')
    else if (.not. all(any(reshape(is_known, [k, n]), 2))) then
      call report%add(group//'/mean', 'holds a column without any number; leave the component out')
    else
      where (.not. is_known)
        mean = 0
        sd = 1
      end where
      if (name == 'spread') sd = sd/sqrt(real(f%beats, rp))
      f%is_known = transpose(reshape(is_known, [k, n]))
      f%mean = transpose(reshape(mean, [k, n]))
      f%sd = transpose(reshape(sd, [k, n]))
    end if
  end subroutine read_values
end module measurement_flight

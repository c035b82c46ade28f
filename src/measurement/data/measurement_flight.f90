! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds what was recorded of a flapping wing over the beat: force, torque and power, or the places of landmarks. The records are in
!> the group `/flight` of a measurement file (docs/formats/measurement-format.md); measurement_flight_file reads them.
module measurement_flight
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_visitor, only: visited_t, visitor_t
  use io_arrays, only: is_finite, is_infinite
  use io_hdf5, only: hdf5_file_t
  use solid_wing_datasets, only: read_real_dataset
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: measured_flight_t, component_unit, read_times, read_values

  integer, parameter, public :: N_COMPONENTS = 7
  character(5), parameter, public :: COMPONENT_NAMES(N_COMPONENTS) = [character(5) :: 'Fx', 'Fy', 'Fz', 'Mx', 'My', 'Mz', 'power']
  integer, parameter, public :: COMPONENT_POWER = 7
  integer, parameter, public :: N_KINEMATICS = 8 !< quantities of the kinematics whose errors a record may state
  character(24), parameter, public :: KINEMATIC_SD(N_KINEMATICS) = [character(24) :: & !< its attributes
    'stroke_amplitude_sd', 'stroke_mean_sd', 'pitch_amplitude_sd', 'pitch_mean_sd', 'pitch_lead_sd', 'deviation_amplitude_sd', &
    'stroke_plane_sd', 'beat_frequency_sd']
  character(6), parameter, public :: KINEMATIC_UNITS(N_KINEMATICS) = [character(6) :: &
    '', 'degree', '', 'degree', 'beat', '', 'degree', '']
  character(5), parameter, public :: SIDE_NAMES(2) = [character(5) :: 'left', 'right'] !< of wings that have landmarks
  real(rp), parameter, public :: FAR = 1.0e4_rp !< [m]
  real(rp), parameter, public :: SAME_AXES(3, 3) = & !< those of the case
                                 reshape([1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp], [3, 3])
  integer, parameter :: FEWEST = 4 !< times of a record

  !> A record holds the means over several beats at fixed times of the beat: of components of the force, or of coordinates of
  !> landmarks on one wing. The coordinates have numbers behind the components of the force: N_COMPONENTS + 3 (l - 1) + 1, 2, 3 for
  !> x, y, z of landmark l, counted over all records of a file.
  type, extends(visited_t) :: measured_flight_t
    character(:), allocatable :: name
    real(rp) :: frequency = 0                 !< [Hz] of the beat
    integer :: beats = 1                      !< number of beats that were averaged
    real(rp) :: reference(3) = 0              !< [m] point about which torques act, along the axes of the case
    real(rp) :: axes(3, 3) = SAME_AXES        !< rows: axes of the record, or of its cameras, along those of the case
    real(rp) :: correlation_time = 0          !< [s] of the errors of each component; 0: they are independent
    real(rp) :: kinematic_sd(N_KINEMATICS) = 0 !< of the kinematics as measured: relative, degrees, beats; 0: not stated
    logical :: is_per_length = .false.        !< values are per metre of span, from a two-dimensional section
    integer :: side = 0                       !< number in SIDE_NAMES of the wing that has the landmarks; 0: forces
    integer :: first = 0                      !< number of landmarks in the records before
    real(rp) :: offset_sd = 0                 !< [m] of each coordinate of the origin of all landmarks of this flight
    real(rp) :: turn_sd = 0                   !< [degree] of the turn of their axes about x, y and z
    real(rp), allocatable :: points(:, :)     !< (2, landmarks) [m] (x, y) on the flat wing
    integer, allocatable :: component(:)      !< (k) numbers in COMPONENT_NAMES, or of coordinates
    real(rp), allocatable :: time(:)          !< (n) of the beat, increasing, in [0, 1)
    real(rp), allocatable :: mean(:, :)       !< (n, k) along `axes` [N], [N m], [W] or [m], from the origin of the case; 0 where
    !< unknown
    logical, allocatable :: is_known(:, :)    !< (n, k)
    real(rp), allocatable :: sd(:, :)         !< (n, k) of `mean`, in its unit; 1 where unknown
  contains
    procedure :: visit => flight_visit
    procedure :: count => flight_count
    procedure :: count_landmarks => flight_count_landmarks
    procedure :: component_name => flight_component_name
    procedure :: landmark_of => flight_landmark_of
  end type measured_flight_t

contains

  !> Passes every component of the type to the visitor.
  subroutine flight_visit(self, visitor)
    class(measured_flight_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit_allocatable('name', self%name)
    call visitor%visit('frequency', self%frequency)
    call visitor%visit('beats', self%beats)
    call visitor%visit('reference', self%reference)
    call visitor%visit('axes', self%axes)
    call visitor%visit('correlation_time', self%correlation_time)
    call visitor%visit('kinematic_sd', self%kinematic_sd)
    call visitor%visit('is_per_length', self%is_per_length)
    call visitor%visit('side', self%side)
    call visitor%visit('first', self%first)
    call visitor%visit('offset_sd', self%offset_sd)
    call visitor%visit('turn_sd', self%turn_sd)
    call visitor%visit_allocatable('points', self%points)
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

  !> Returns how many landmarks the record has.
  pure integer function flight_count_landmarks(self) result(n)
    class(measured_flight_t), intent(in) :: self
    n = 0
    if (allocated(self%points)) n = size(self%points, 2)
  end function flight_count_landmarks

  !> Returns [l, axis] of column k of a record of landmarks: the number of the landmark in the record, and 1 to 3 for x to z. For
  !> forces it is [0, 0].
  pure function flight_landmark_of(self, k) result(at)
    class(measured_flight_t), intent(in) :: self
    integer, intent(in) :: k
    integer :: at(2), number
    at = 0
    if (self%side == 0) return
    number = self%component(k) - N_COMPONENTS - 1 - 3*self%first
    at = [number/3 + 1, modulo(number, 3) + 1]
  end function flight_landmark_of

  !> Returns the name of column k: 'Fy', or 'left:3:y' for y of the third landmark on the left wing.
  pure function flight_component_name(self, k) result(name)
    class(measured_flight_t), intent(in) :: self
    integer, intent(in) :: k
    character(:), allocatable :: name
    character(*), parameter :: AXES = 'xyz'
    integer :: at(2)
    if (self%side == 0) then
      name = trim(COMPONENT_NAMES(self%component(k)))
      return
    end if
    at = self%landmark_of(k)
    name = trim(SIDE_NAMES(self%side))//':'//number_text(at(1))//':'//AXES(at(2):at(2))
  end function flight_component_name

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
    case (COMPONENT_POWER)
      unit = trim(merge('W/m', 'W  ', is_per_length))
    case default
      unit = 'm'
    end select
  end function component_unit

  !> Reads the times of a record, fractions of a beat in ascending order. There are none after a mistake, which goes to `report`.
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

  !> Reads the means of all components, and their sd, which is either given or computed from the spread over the beats. Nothing is
  !> read after a mistake, which goes to `report`.
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
    else if (.not. any(is_known)) then
      call report%add(group//'/mean', 'holds no number; leave the record out')
    else if (f%side == 0 .and. .not. all(any(reshape(is_known, [k, n]), 2))) then
      call report%add(group//'/mean', 'holds a column without any number; leave the component out')
    else
      if (name == 'spread') sd = sd/sqrt(real(f%beats, rp))
      where (.not. is_known)
        mean = 0
        sd = 1
      end where
      f%is_known = transpose(reshape(is_known, [k, n]))
      f%mean = transpose(reshape(mean, [k, n]))
      f%sd = transpose(reshape(sd, [k, n]))
    end if
  end subroutine read_values
end module measurement_flight

! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds what was measured on one wing: heights of its surface at fixed points, unloaded and under point forces, scalar readings,
!> natural modes and records, with their declared accuracy (docs/formats/measurement-format.md). SI units, frame of the wing.
module measurement_data
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_visitor, only: visited_t, visitor_t
  use io_hdf5, only: NAME_LENGTH
  use measurement_flight, only: measured_flight_t
  use measurement_modes, only: measured_mode_t, AIR_DENSITY, MEDIUM_AIR
  use measurement_series, only: measured_series_t
  implicit none
  private
  public :: measurement_t, measured_load_t, observation_t

  integer, parameter, public :: QUANTITY_DISPLACEMENT = 1, QUANTITY_ROTATION = 2
  real(rp), parameter, public :: NOT_STATED = -1 !< of a time

  !> Holds declared standard deviations.
  type, extends(visited_t) :: accuracy_t
    real(rp) :: height = 0             !< [m] of one height
    real(rp) :: correlation_length = 0 !< [m] of the errors of heights
    real(rp) :: force = 0              !< [N] of each force
    real(rp) :: force_gain = 0         !< relative, common to all forces
    real(rp) :: position = 0           !< [m] of x and y of each point of application
    real(rp) :: tilt = 0               !< [rad] of each scan
    real(rp) :: piston = 0             !< [m] of each scan
  contains
    procedure :: visit => accuracy_visit
  end type accuracy_t

  !> Holds the answers about the calibration of the instruments: 1 yes, 0 no, -1 not known.
  type, extends(visited_t) :: calibration_t
    integer :: force_by_weight = -1
    integer :: height_by_gauge = -1
    integer :: position_by_marks = -1
    integer :: order_is_random = -1
  contains
    procedure :: visit => calibration_visit
  end type calibration_t

  !> Holds a force and the surface under it.
  type, extends(visited_t) :: measured_load_t
    character(:), allocatable :: name
    real(rp) :: force = 0                 !< [N] magnitude
    real(rp) :: direction(3) = 0          !< unit vector, which the force keeps
    real(rp) :: point(2) = 0              !< [m] (x, y) on the unloaded wing
    integer :: order = 0                  !< in the sequence of measurements; 0: not declared
    integer :: replicate = 1
    real(rp) :: time = NOT_STATED         !< [s] since the start of the experiment
    real(rp) :: hold = NOT_STATED         !< [s] between force and scan
    logical :: has_surface = .false.      !< the file holds heights
    integer, allocatable :: node(:, :)    !< (2, n) grid point (i, j) of each height that is known loaded and unloaded
    real(rp), allocatable :: height(:)    !< (n) [m] under the force
    real(rp), allocatable :: sigma(:)     !< (n) [m] sd of `height`
  contains
    procedure :: visit => load_visit
    procedure :: count => load_count
  end type measured_load_t

  !> Holds a scalar reading under a load.
  type, extends(visited_t) :: observation_t
    character(:), allocatable :: name
    integer :: load = 0                   !< number of the load
    integer :: quantity = QUANTITY_DISPLACEMENT
    real(rp) :: point(2) = 0              !< [m] (x, y) on the unloaded wing
    real(rp) :: axis(3) = 0               !< unit vector
    real(rp) :: value = 0                 !< [m] or [rad]
    real(rp) :: sigma = 0                 !< its sd
    integer :: zero = 0                   !< number of the unknown offset that it contains; 0: none
  contains
    procedure :: visit => observation_visit
  end type observation_t

  !> Holds all measured data.
  type, extends(visited_t) :: measurement_t
    real(rp), allocatable :: x(:), y(:)               !< [m] grid lines; empty without heights
    logical, allocatable :: has_unloaded(:, :)        !< (nx, ny) where the unloaded height is known
    real(rp), allocatable :: unloaded(:, :)           !< (nx, ny) [m], 0 where it is not known
    real(rp), allocatable :: unloaded_sigma(:, :)     !< (nx, ny) [m] sd
    type(measured_load_t), allocatable :: loads(:)
    type(observation_t), allocatable :: observations(:)
    character(NAME_LENGTH), allocatable :: zeros(:)   !< names of the unknown offsets
    type(accuracy_t) :: accuracy
    type(calibration_t) :: calibration
    type(measured_mode_t), allocatable :: modes(:)    !< empty if there are none
    real(rp) :: air_density = AIR_DENSITY             !< [kg/m^3] around modes in air
    type(measured_series_t), allocatable :: series(:) !< records of a vibrating wing; may be empty
    real(rp) :: series_air_density = AIR_DENSITY      !< [kg/m^3] around vibrating wings in air
    type(measured_flight_t), allocatable :: flights(:) !< records over the beat: of forces, then of landmarks; may be empty
    logical :: is_plan = .false.                      !< of an experiment: all heights are 0, none has been measured
  contains
    procedure :: visit => measurement_visit
    procedure :: count_modes => measurement_count_modes
    procedure :: has_loaded_modes => measurement_has_loaded_modes
    procedure :: count_mode_observations => measurement_count_mode_observations
    procedure :: moves => measurement_moves
    procedure :: is_in_air => measurement_is_in_air
    procedure :: shows_damping => measurement_shows_damping
    procedure :: count_series => measurement_count_series
    procedure :: count_series_observations => measurement_count_series_observations
    procedure :: count_flights => measurement_count_flights
    procedure :: count_flight_observations => measurement_count_flight_observations
    procedure :: surface_name => measurement_surface_name
    procedure :: site => measurement_site
    procedure :: deformation => measurement_deformation
    procedure :: deformation_sigma => measurement_deformation_sigma
  end type measurement_t

contains

  !> Shows every component to the visitor.
  subroutine accuracy_visit(self, visitor)
    class(accuracy_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('height', self%height)
    call visitor%visit('correlation_length', self%correlation_length)
    call visitor%visit('force', self%force)
    call visitor%visit('force_gain', self%force_gain)
    call visitor%visit('position', self%position)
    call visitor%visit('tilt', self%tilt)
    call visitor%visit('piston', self%piston)
  end subroutine accuracy_visit

  !> Shows every component to the visitor.
  subroutine calibration_visit(self, visitor)
    class(calibration_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('force_by_weight', self%force_by_weight)
    call visitor%visit('height_by_gauge', self%height_by_gauge)
    call visitor%visit('position_by_marks', self%position_by_marks)
    call visitor%visit('order_is_random', self%order_is_random)
  end subroutine calibration_visit

  !> Shows every component to the visitor.
  subroutine load_visit(self, visitor)
    class(measured_load_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit_allocatable('name', self%name)
    call visitor%visit('force', self%force)
    call visitor%visit('direction', self%direction)
    call visitor%visit('point', self%point)
    call visitor%visit('order', self%order)
    call visitor%visit('replicate', self%replicate)
    call visitor%visit('time', self%time)
    call visitor%visit('hold', self%hold)
    call visitor%visit('has_surface', self%has_surface)
    call visitor%visit_allocatable('node', self%node)
    call visitor%visit_allocatable('height', self%height)
    call visitor%visit_allocatable('sigma', self%sigma)
  end subroutine load_visit

  !> Shows every component to the visitor.
  subroutine observation_visit(self, visitor)
    class(observation_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit_allocatable('name', self%name)
    call visitor%visit('load', self%load)
    call visitor%visit('quantity', self%quantity)
    call visitor%visit('point', self%point)
    call visitor%visit('axis', self%axis)
    call visitor%visit('value', self%value)
    call visitor%visit('sigma', self%sigma)
    call visitor%visit('zero', self%zero)
  end subroutine observation_visit

  !> Shows every component to the visitor; `modes`, `series` and `flights` are allocated afterwards.
  subroutine measurement_visit(self, visitor)
    class(measurement_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    if (.not. visitor%is_reading .and. .not. allocated(self%modes)) allocate (self%modes(0))
    if (.not. visitor%is_reading .and. .not. allocated(self%series)) allocate (self%series(0))
    if (.not. visitor%is_reading .and. .not. allocated(self%flights)) allocate (self%flights(0))
    call visitor%visit_allocatable('x', self%x)
    call visitor%visit_allocatable('y', self%y)
    call visitor%visit_allocatable('has_unloaded', self%has_unloaded)
    call visitor%visit_allocatable('unloaded', self%unloaded)
    call visitor%visit_allocatable('unloaded_sigma', self%unloaded_sigma)
    if (visitor%is_reading) allocate (self%loads(visitor%count_of('loads')))
    call visitor%visit_list('loads', self%loads)
    if (visitor%is_reading) allocate (self%observations(visitor%count_of('observations')))
    call visitor%visit_list('observations', self%observations)
    call visitor%visit_allocatable('zeros', self%zeros)
    call visitor%visit('accuracy', self%accuracy)
    call visitor%visit('calibration', self%calibration)
    if (visitor%is_reading) allocate (self%modes(visitor%count_of('modes')))
    call visitor%visit_list('modes', self%modes)
    call visitor%visit('air_density', self%air_density)
    if (visitor%is_reading) allocate (self%series(visitor%count_of('series')))
    call visitor%visit_list('series', self%series)
    call visitor%visit('series_air_density', self%series_air_density)
    if (visitor%is_reading) allocate (self%flights(visitor%count_of('flights')))
    call visitor%visit_list('flights', self%flights)
    call visitor%visit('is_plan', self%is_plan)
  end subroutine measurement_visit

  !> Returns the number of heights under the load.
  pure integer function load_count(self) result(n)
    class(measured_load_t), intent(in) :: self
    n = 0
    if (allocated(self%height)) n = size(self%height)
  end function load_count

  !> Returns the number of natural modes.
  pure integer function measurement_count_modes(self) result(n)
    class(measurement_t), intent(in) :: self
    n = 0
    if (allocated(self%modes)) n = size(self%modes)
  end function measurement_count_modes

  !> Tells whether a natural mode was measured about a shape under loads.
  pure logical function measurement_has_loaded_modes(self) result(has_some)
    class(measurement_t), intent(in) :: self
    integer :: i
    has_some = .false.
    do i = 1, self%count_modes()
      has_some = has_some .or. self%modes(i)%is_loaded()
    end do
  end function measurement_has_loaded_modes

  !> Returns how many numbers compare natural modes: for each mode its frequency, and one number less than its shape has points.
  pure integer function measurement_count_mode_observations(self) result(n)
    class(measurement_t), intent(in) :: self
    integer :: i
    n = 0
    do i = 1, self%count_modes()
      n = n + max(1, size(self%modes(i)%shape)) + merge(1, 0, self%modes(i)%damping >= 0)
    end do
  end function measurement_count_mode_observations

  !> Tells whether the wing moved, which means that there are modes or records; they depend on its mass.
  pure logical function measurement_moves(self) result(moves)
    class(measurement_t), intent(in) :: self
    moves = self%count_modes() + self%count_series() > 0
  end function measurement_moves

  !> Tells whether there are records of a vibrating wing or damping ratios of its modes.
  pure logical function measurement_shows_damping(self) result(shows)
    class(measurement_t), intent(in) :: self
    shows = self%count_series() > 0
    if (self%count_modes() > 0) shows = shows .or. any(self%modes%damping >= 0)
  end function measurement_shows_damping

  !> Tells whether the wing moved in air.
  pure logical function measurement_is_in_air(self) result(is_in_air)
    class(measurement_t), intent(in) :: self
    is_in_air = .false.
    if (self%count_modes() > 0) is_in_air = any(self%modes%medium == MEDIUM_AIR)
    if (self%count_series() > 0) is_in_air = is_in_air .or. any(self%series%medium == MEDIUM_AIR)
  end function measurement_is_in_air

  !> Returns the number of records of a vibrating wing.
  pure integer function measurement_count_series(self) result(n)
    class(measurement_t), intent(in) :: self
    n = 0
    if (allocated(self%series)) n = size(self%series)
  end function measurement_count_series

  !> Returns how many numbers the records of a vibrating wing have.
  pure integer function measurement_count_series_observations(self) result(n)
    class(measurement_t), intent(in) :: self
    integer :: i
    n = 0
    do i = 1, self%count_series()
      n = n + self%series(i)%count()
    end do
  end function measurement_count_series_observations

  !> Returns the number of records over the beat: of forces and landmarks, or of landmarks alone, or of forces alone.
  pure integer function measurement_count_flights(self, has_landmarks) result(n)
    class(measurement_t), intent(in) :: self
    logical, intent(in), optional :: has_landmarks
    n = 0
    if (.not. allocated(self%flights)) return
    n = size(self%flights)
    if (present(has_landmarks)) n = count((self%flights%side > 0) .eqv. has_landmarks)
  end function measurement_count_flights

  !> Returns how many numbers these records have.
  pure integer function measurement_count_flight_observations(self, has_landmarks) result(n)
    class(measurement_t), intent(in) :: self
    logical, intent(in), optional :: has_landmarks
    integer :: i
    n = 0
    do i = 1, self%count_flights()
      if (present(has_landmarks)) then
        if ((self%flights(i)%side > 0) .neqv. has_landmarks) cycle
      end if
      n = n + self%flights(i)%count()
    end do
  end function measurement_count_flight_observations

  !> Returns the name of group l of the data. The loads come first, then the modes, then the traces (name of the record and number
  !> of the trace), then the components and landmarks of flights.
  pure function measurement_surface_name(self, l) result(name)
    class(measurement_t), intent(in) :: self
    integer, intent(in) :: l
    character(:), allocatable :: name
    integer :: i, k
    if (l <= size(self%loads)) then
      name = self%loads(l)%name
    else if (l <= size(self%loads) + self%count_modes()) then
      name = self%modes(l - size(self%loads))%name
    else
      k = l - size(self%loads) - self%count_modes()
      do i = 1, self%count_series()
        name = self%series(i)%name//':'//number_text(k)
        if (k <= size(self%series(i)%sigma)) return
        k = k - size(self%series(i)%sigma)
      end do
      do i = 1, self%count_flights()
        associate (f => self%flights(i))
          if (k <= size(f%component)) then
            name = f%name//':'//f%component_name(k)
            return
          end if
          k = k - size(f%component)
        end associate
      end do
    end if
  end function measurement_surface_name

  !> Returns the point (x, y) [m] of height number k of load l.
  pure function measurement_site(self, l, k) result(site)
    class(measurement_t), intent(in) :: self
    integer, intent(in) :: l, k
    real(rp) :: site(2)
    site = [self%x(self%loads(l)%node(1, k)), self%y(self%loads(l)%node(2, k))]
  end function measurement_site

  !> Returns deformation number k of load l, the loaded minus the unloaded height [m].
  pure real(rp) function measurement_deformation(self, l, k) result(deformation)
    class(measurement_t), intent(in) :: self
    integer, intent(in) :: l, k
    associate (load => self%loads(l))
      deformation = load%height(k) - self%unloaded(load%node(1, k), load%node(2, k))
    end associate
  end function measurement_deformation

  !> Returns the standard deviation [m] of this deformation from the errors of both heights.
  pure real(rp) function measurement_deformation_sigma(self, l, k) result(sigma)
    class(measurement_t), intent(in) :: self
    integer, intent(in) :: l, k
    associate (load => self%loads(l))
      sigma = sqrt(load%sigma(k)**2 + self%unloaded_sigma(load%node(1, k), load%node(2, k))**2)
    end associate
  end function measurement_deformation_sigma
end module measurement_data

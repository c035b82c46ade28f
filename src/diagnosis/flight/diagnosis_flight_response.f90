! SPDX-License-Identifier: GPL-3.0-or-later
!> Approximates what a flight shows (forces, torques, power, places of landmarks) for other kinematics and another flow by a
!> quadratic function of the changes c. The value, the first derivative and the diagonal second derivative at the case come from
!> simulated flights, by central differences with the steps h_j:
!>
!>     F(c) = F_0 + sum_j (F_j+ - F_j-)/(2 h_j) c_j + (F_j+ - 2 F_0 + F_j-)/(2 h_j^2) c_j^2.
!>
!> What a case leaves out altogether can only be added: for such a change there is the flight with +h_j alone, and the second
!> derivative is 0.
!>
!> `move` makes the same approximation about other kinematics and another flow, where c_j counts from there. Derivatives with
!> respect to changes that are not flown again stay those at the case.
!>
!> A beat of a rigid wing whose frequency is exp(e) times that of the case needs no flight of its own. It is the case in a fluid
!> of viscosity nu exp(-e) with a wind that is exp(-e) times that of the case. Its forces are exp(2 e) times and its power is
!> exp(3 e) times as large, and landmarks are where they were.
module diagnosis_flight_response
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_flight_changes, only: FLOW_FREQUENCY, FLOW_VISCOSITY, FLOW_WIND, is_one_sided, N_CHANGES, N_FLOW
  use diagnosis_flight_refinements, only: refinement_name, N_REFINEMENTS
  use diagnosis_flight_runner, only: flight_record_t, flight_request_t
  use measurement_balance, only: balance_harmonics
  use measurement_flight, only: COMPONENT_POWER, N_COMPONENTS
  implicit none
  private
  public :: flight_response_t

  type :: flight_response_t
    integer :: n_harmonics = 0
    ! Fourier series over the beat (measurement_balance), harmonics along the first axis, components along the second.
    complex(rp), allocatable :: value(:, :)                      !< SI units
    real(rp), allocatable :: samples(:, :)                       !< (N_PHASES, components) of the case
    complex(rp), allocatable :: slope(:, :, :)                   !< per unit of each change
    complex(rp), allocatable :: curvature(:, :, :)
    complex(rp), allocatable :: refined(:, :, :)                 !< what a smaller numerical error of each kind changes
    logical :: is_known(N_FLOW) = .false.                        !< both flights came to their end
    character(200) :: reason(N_FLOW) = ''                        !< why not
    real(rp) :: wind(3) = 0                                      !< [m/s] of the case
    real(rp) :: origin(N_FLOW) = 0                               !< changes at which `value` is
  contains
    procedure :: seen => response_seen
    procedure :: move => response_move
    procedure :: requests => response_requests
    procedure :: take => response_take
    procedure :: at => response_at
    procedure :: derivative => response_derivative
    procedure :: knows => response_knows
    procedure :: relative_size => response_relative_size
  end type flight_response_t

contains

  !> Lists the flights that are needed: the case with the changes `origin`, the same with each of the refinements `refined`, and two
  !> flights about it for each change whose step is above 0, or one if it is one-sided. Without `origin` it is the case itself.
  pure function response_requests(self, steps, refined, origin) result(requests)
    class(flight_response_t), intent(in) :: self
    real(rp), intent(in) :: steps(N_FLOW)
    logical, intent(in) :: refined(N_REFINEMENTS)
    real(rp), intent(in), optional :: origin(N_FLOW)
    type(flight_request_t), allocatable :: requests(:)
    integer :: i, j, n
    associate (unused => self)
    end associate
    n = 1 + count(refined)
    allocate (requests(n + sum([(flights_of(steps(j), j), j=1, N_FLOW)])))
    requests(2:n)%refinement = pack([(j, j=1, N_REFINEMENTS)], refined)
    do j = 1, N_FLOW
      if (.not. steps(j) > 0) cycle
      requests(n + 1)%change(j) = steps(j)
      n = n + flights_of(steps(j), j)
      if (.not. is_one_sided(j)) requests(n)%change(j) = -steps(j)
    end do
    if (.not. present(origin)) return
    do i = 1, size(requests)
      requests(i)%change = requests(i)%change + origin
    end do
  end function response_requests

  !> Returns the number of flights that show change j.
  pure integer function flights_of(step, j)
    real(rp), intent(in) :: step
    integer, intent(in) :: j
    flights_of = 0
    if (step > 0) flights_of = merge(1, 2, is_one_sided(j))
  end function flights_of

  !> Takes the records of the flights that `requests` lists for `origin` into the approximation, which is then about these changes.
  !> What refinements change that are not among them stays as at the case. Fails, and takes nothing, if any of them is missing.
  subroutine response_move(self, origin, steps, refined, records, failure)
    class(flight_response_t), intent(inout) :: self
    real(rp), intent(in) :: origin(N_FLOW), steps(N_FLOW)
    logical, intent(in) :: refined(N_REFINEMENTS)
    type(flight_record_t), intent(in) :: records(:)
    type(failure_t), intent(out) :: failure
    type(flight_response_t) :: moved
    integer :: j
    moved%n_harmonics = self%n_harmonics
    call moved%take(steps, refined, records, failure)
    if (failure%failed) return
    do j = 1, N_FLOW
      if (steps(j) > 0 .and. .not. moved%is_known(j)) call failure%raise(trim(moved%reason(j)))
    end do
    if (failure%failed) return
    do j = 1, N_FLOW
      if (.not. steps(j) > 0) cycle
      self%slope(:, :, j) = moved%slope(:, :, j)
      self%curvature(:, :, j) = moved%curvature(:, :, j)
      self%is_known(j) = .true.
    end do
    self%value = moved%value
    self%samples = moved%samples
    do j = 1, N_REFINEMENTS
      if (refined(j)) self%refined(:, :, j) = moved%refined(:, :, j)
    end do
    self%origin = origin
  end subroutine response_move

  !> Takes the records of the flights in the order in which `requests` lists them. Fails, and takes nothing, if the flight of the
  !> case, or one with a refinement, is missing. If a flight of change j is missing, is_known(j) is false and self%reason(j)
  !> says why.
  subroutine response_take(self, steps, refined, records, failure)
    class(flight_response_t), intent(inout) :: self
    real(rp), intent(in) :: steps(N_FLOW)
    logical, intent(in) :: refined(N_REFINEMENTS)
    type(flight_record_t), intent(in) :: records(:)
    type(failure_t), intent(out) :: failure
    complex(rp), allocatable :: above(:, :), below(:, :)
    integer :: j, n, last
    n = 1
    if (.not. records(1)%is_flown) call failure%raise(records(1)%reason)
    do j = 1, N_REFINEMENTS
      if (.not. refined(j)) cycle
      n = n + 1
      if (.not. records(n)%is_flown .and. .not. failure%failed) &
        call failure%raise(records(n)%reason//'. This is the flight with the refinement '//refinement_name(j)//'; a list in '// &
                           '[Flight] refine without it leaves it out')
    end do
    if (failure%failed) return
    self%value = series(self, records(1))
    self%samples = records(1)%values
    if (allocated(self%slope)) deallocate (self%slope, self%curvature, self%refined)
    allocate (self%slope(size(self%value, 1), size(self%value, 2), N_FLOW), source=cmplx(0, kind=rp))
    allocate (self%curvature, source=self%slope)
    allocate (self%refined(size(self%value, 1), size(self%value, 2), N_REFINEMENTS), source=cmplx(0, kind=rp))
    n = 1
    do j = 1, N_REFINEMENTS
      if (.not. refined(j)) cycle
      n = n + 1
      self%refined(:, :, j) = series(self, records(n)) - self%value
    end do
    do j = 1, N_FLOW
      self%is_known(j) = .false.
      if (.not. steps(j) > 0) cycle
      last = n + flights_of(steps(j), j)
      self%is_known(j) = records(n + 1)%is_flown .and. records(last)%is_flown
      if (.not. self%is_known(j)) then
        self%reason(j) = records(merge(last, n + 1, records(n + 1)%is_flown))%reason
      else if (is_one_sided(j)) then
        self%slope(:, :, j) = (series(self, records(last)) - self%value)/steps(j)
      else
        above = series(self, records(n + 1))
        below = series(self, records(last))
        self%slope(:, :, j) = (above - below)/(2*steps(j))
        self%curvature(:, :, j) = (above - 2*self%value + below)/steps(j)**2
      end if
      n = last
    end do
  end subroutine response_take

  !> Returns the harmonics 0 to n_harmonics of a record, components in columns.
  pure function series(self, record) result(x)
    class(flight_response_t), intent(in) :: self
    type(flight_record_t), intent(in) :: record
    complex(rp) :: x(0:self%n_harmonics, size(record%values, 2))
    x = balance_harmonics(record%values, self%n_harmonics)
  end function series

  !> Returns the Fourier coefficients (harmonics from 0, components) of all that is recorded [SI units] for the changes c.
  pure function response_at(self, c) result(values)
    class(flight_response_t), intent(in) :: self
    real(rp), intent(in) :: c(N_CHANGES)
    complex(rp) :: values(0:self%n_harmonics, size(self%value, 2))
    real(rp) :: seen(N_FLOW)
    integer :: j
    seen = self%seen(c) - self%origin
    values = self%value
    do j = 1, N_FLOW
      if (abs(seen(j)) > 0) values = values + seen(j)*self%slope(:, :, j) + seen(j)**2/2*self%curvature(:, :, j)
    end do
    if (abs(c(FLOW_FREQUENCY)) > 0) values = values*sizes(self, c(FLOW_FREQUENCY))
  end function response_at

  !> Returns the derivative of what `at` returns with respect to change j, per unit of that change.
  pure function response_derivative(self, c, j) result(values)
    class(flight_response_t), intent(in) :: self
    real(rp), intent(in) :: c(N_CHANGES)
    integer, intent(in) :: j
    complex(rp) :: values(0:self%n_harmonics, size(self%value, 2))
    real(rp) :: seen(N_FLOW)
    integer :: i
    seen = self%seen(c) - self%origin
    if (j <= N_FLOW) then
      values = self%slope(:, :, j) + seen(j)*self%curvature(:, :, j)
      if (j > FLOW_WIND .and. j <= FLOW_WIND + 3) values = values*exp(-c(FLOW_FREQUENCY))
      values = values*sizes(self, c(FLOW_FREQUENCY))
      return
    end if
    values = self%at(c)
    do i = 1, size(values, 2)
      values(:, i) = exponent_of(i)*values(:, i)
    end do
    associate (e => c(FLOW_FREQUENCY))
      values = values - sizes(self, e)*(self%slope(:, :, FLOW_VISCOSITY) + &
                                        seen(FLOW_VISCOSITY)*self%curvature(:, :, FLOW_VISCOSITY))
      do i = 1, 3
        values = values - sizes(self, e)*(self%wind(i) + c(FLOW_WIND + i))*exp(-e)* &
                 (self%slope(:, :, FLOW_WIND + i) + seen(FLOW_WIND + i)*self%curvature(:, :, FLOW_WIND + i))
      end do
    end associate
  end function response_derivative

  !> Tells whether the flights that change j needs came to their end. A beat of another frequency needs those with another viscosity
  !> and, if the case has wind, those with another wind.
  pure logical function response_knows(self, j) result(knows)
    class(flight_response_t), intent(in) :: self
    integer, intent(in) :: j
    if (j <= N_FLOW) then
      knows = self%is_known(j)
    else
      knows = self%is_known(FLOW_VISCOSITY) .and. all(self%is_known(FLOW_WIND + 1:FLOW_WIND + 3) .or. .not. abs(self%wind) > 0)
    end if
  end function response_knows

  !> Returns how much refinement k changes forces: the largest rms over the beat of a component, relative to that of the component.
  !> Forces below a hundredth of the largest one do not count, nor do such torques, which are errors alone where symmetry lets the
  !> component vanish.
  pure real(rp) function response_relative_size(self, k) result(largest)
    class(flight_response_t), intent(in) :: self
    integer, intent(in) :: k
    real(rp), parameter :: LEAST = 0.01_rp
    integer, parameter :: FIRST(3) = [1, 4, COMPONENT_POWER], LAST(3) = [3, 6, COMPONENT_POWER]
    real(rp) :: size_of(N_COMPONENTS), change(N_COMPONENTS)
    integer :: i, group
    size_of = [(rms(self%value(:, i)), i=1, N_COMPONENTS)]
    change = [(rms(self%refined(:, i, k)), i=1, N_COMPONENTS)]
    largest = 0
    do group = 1, size(FIRST)
      do i = FIRST(group), LAST(group)
        if (size_of(i) > LEAST*maxval(size_of(FIRST(group):LAST(group)))) largest = max(largest, change(i)/size_of(i))
      end do
    end do
  end function response_relative_size

  !> Returns the root mean square over the beat of a Fourier series x(0:), whose real part is sum x_h exp(2 pi i h t).
  pure real(rp) function rms(x)
    complex(rp), intent(in) :: x(0:)
    rms = sqrt(real(x(0), rp)**2 + sum(abs(x(1:))**2)/2)
  end function rms

  !> Converts the changes c into the changes of viscosity and wind that give the same flow at the frequency of the case.
  pure function response_seen(self, c) result(seen)
    class(flight_response_t), intent(in) :: self
    real(rp), intent(in) :: c(N_CHANGES)
    real(rp) :: seen(N_FLOW)
    integer :: i
    seen = c(:N_FLOW)
    if (.not. abs(c(FLOW_FREQUENCY)) > 0) return
    seen(FLOW_VISCOSITY) = seen(FLOW_VISCOSITY) - c(FLOW_FREQUENCY)
    do i = 1, 3
      seen(FLOW_WIND + i) = (self%wind(i) + c(FLOW_WIND + i))*exp(-c(FLOW_FREQUENCY)) - self%wind(i)
    end do
  end function response_seen

  !> Returns n: component i grows as exp(n e) if the frequency changes by the factor exp(e).
  pure integer function exponent_of(i) result(n)
    integer, intent(in) :: i
    n = 2
    if (i == COMPONENT_POWER) n = 3
    if (i > N_COMPONENTS) n = 0 ! landmarks
  end function exponent_of

  !> Returns the factors on all harmonics if the frequency changes by the factor exp(e).
  pure function sizes(self, e) result(factors)
    class(flight_response_t), intent(in) :: self
    real(rp), intent(in) :: e
    real(rp) :: factors(0:self%n_harmonics, size(self%value, 2))
    integer :: i
    do i = 1, size(factors, 2)
      factors(:, i) = exp(exponent_of(i)*e)
    end do
  end function sizes
end module diagnosis_flight_response

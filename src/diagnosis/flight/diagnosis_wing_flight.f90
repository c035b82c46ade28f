! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the residuals of records over the beat, in units of their sd, and their derivatives. It takes the simulated forces and
!> places of landmarks from diagnosis_flight_response, and converts forces by the model of the balance in measurement_balance. Each
!> component of each record has its own surface, fold and block. The difference that a finer grid makes is a nuisance, and so are
!> the effect of an error of the kinematics that the records state, and an error of the axes of cameras. Without records there are
!> no observations here.
module diagnosis_wing_flight
  use base_kinds, only: rp
  use diagnosis_flight_axes, only: along_axes
  use diagnosis_flight_catalogue, only: stated_errors
  use diagnosis_flight_data, only: change_t, flight_data_t
  use diagnosis_flight_landmarks, only: count_patterns, find_cameras, put_misplacements, put_waves, put_wing_patterns, &
                                        N_MISPLACED, N_WAVES, UNKNOWN_SHARE
  use diagnosis_flight_response, only: flight_response_t
  use diagnosis_flight_changes, only: N_CHANGES
  use diagnosis_flight_refinements, only: N_REFINEMENTS
  use diagnosis_flight_runner, only: flight_facts_t, N_PHASES
  use diagnosis_wing_labels, only: append_surface
  use diagnosis_wing_parameters, only: wing_parameter_t, KIND_BALANCE, KIND_FLIGHT
  use inference_simulator, only: labels_t
  use measurement_balance, only: apply_balance, balance_harmonics, balance_values, without_additions
  use measurement_balance_causes, only: N_BALANCE
  use measurement_flight, only: measured_flight_t, N_COMPONENTS
  implicit none
  private
  public :: wing_flight_t

  !> Forces for other kinematics and another flow, near the flight about which they are approximated.
  type :: approximation_t
    type(flight_response_t) :: response
    real(rp), allocatable :: rest(:) !< (n) of this flight, what its series leaves, in sd
  end type approximation_t

  integer, parameter :: KIND_OF_OTHERS = 0 !< of changes of another case alone

  !> The records that one case simulates.
  type :: wing_flight_t
    integer :: n = 0                !< observations
    integer :: n_nuisances = 0
    integer :: n_patterns = 0       !< of unknown causes: waves over the beat in each component
    type(flight_data_t), private :: data
    type(measured_flight_t), allocatable, private :: flights(:)
    type(wing_parameter_t), allocatable, private :: parameters(:)
    integer, allocatable, private :: kind(:), number(:) !< of them
    type(change_t), allocatable, private :: change(:)   !< by each of them
    complex(rp), allocatable, private :: inertia(:, :)
    integer, allocatable, private :: camera(:)          !< (records), 0: an error of its axes is not stated
    integer, allocatable, private :: record(:)          !< (n) to which an observation belongs,
    real(rp), allocatable, private :: time(:)           !< (n) and when in the beat it is
    real(rp), allocatable, private :: rest(:)           !< (n) of the flight in use, what its series leaves, in sd
    type(approximation_t), allocatable, private :: approximations(:) !< the first is about the case
    integer, private :: in_use = 0
    real(rp), private :: stated(N_CHANGES) = 0          !< sd of the changes as the records state them; 0: not stated
  contains
    procedure :: init => flight_init
    procedure :: add => flight_add
    procedure :: use => flight_use
    procedure :: evaluate => flight_evaluate
    procedure :: nuisances => flight_nuisances
    procedure :: patterns => flight_patterns
    procedure :: append_labels => flight_append_labels
    procedure :: covariance => flight_covariance
    procedure, private :: show => flight_show
  end type wing_flight_t

contains

  !> Takes the measured records `flights`, the parameters of the model in the order of their coordinates, and the results of the
  !> simulated flights in `data`. Sets the numbers of observations, nuisances and patterns.
  subroutine flight_init(self, flights, parameters, data)
    class(wing_flight_t), intent(inout) :: self
    type(measured_flight_t), intent(in) :: flights(:)
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(flight_data_t), intent(in) :: data
    integer :: r, k
    self%data = data
    self%flights = flights
    self%parameters = parameters
    call take_changes(self)
    allocate (self%inertia(0:data%response%n_harmonics, N_COMPONENTS))
    self%inertia = balance_harmonics(data%facts%inertia, data%response%n_harmonics)
    allocate (self%record(0), self%time(0))
    do r = 1, size(flights)
      do k = 1, size(flights(r)%component)
        associate (known => flights(r)%is_known(:, k))
          self%time = [self%time, pack(flights(r)%time, known)]
          self%record = [self%record, spread(r, 1, count(known))]
        end associate
      end do
    end do
    self%n = size(self%time)
    call find_rest(self)
    allocate (self%approximations(1))
    self%approximations(1)%response = data%response
    self%approximations(1)%rest = self%rest
    self%in_use = 1
    self%stated = stated_errors(data%facts)
    self%n_nuisances = count(data%refined) + count(self%stated > 0)
    if (data%model_sd > 0) self%n_nuisances = self%n_nuisances + N_COMPONENTS + 1 + merge(1, 0, any(flights%side > 0))
    self%camera = find_cameras(flights)
    if (size(flights) > 0) self%n_nuisances = self%n_nuisances + N_MISPLACED*maxval(self%camera)
    self%n_patterns = sum([(count_patterns(flights(r)), r=1, size(flights))])
  end subroutine flight_init

  !> Finds how each parameter acts on the records.
  subroutine take_changes(self)
    class(wing_flight_t), intent(inout) :: self
    self%kind = self%parameters%kind
    self%number = self%parameters%number
    self%change = self%data%change_by(self%parameters)
    where (self%change%number > 0) self%kind = KIND_FLIGHT
    where (self%change%number == 0 .and. self%kind == KIND_FLIGHT) self%kind = KIND_OF_OTHERS
  end subroutine take_changes

  !> Keeps a further approximation, and what the changes of its structure are (facts%structure). Returns its number for `use`.
  subroutine flight_add(self, response, facts, number)
    class(wing_flight_t), intent(inout) :: self
    type(flight_response_t), intent(in) :: response
    type(flight_facts_t), intent(in) :: facts
    integer, intent(out) :: number
    type(approximation_t), allocatable :: more(:)
    integer :: i
    number = size(self%approximations) + 1
    self%data%response = response
    self%data%facts = facts
    call take_changes(self)
    call find_rest(self)
    allocate (more(number))
    do i = 1, number - 1
      more(i) = self%approximations(i)
    end do
    more(number)%response = response
    more(number)%rest = self%rest
    call move_alloc(more, self%approximations)
    self%in_use = number
  end subroutine flight_add

  !> Makes forces those of an approximation that `add` numbered; 1 is that about the case. Without records nothing happens.
  subroutine flight_use(self, number)
    class(wing_flight_t), intent(inout) :: self
    integer, intent(in) :: number
    if (self%n == 0 .or. number == self%in_use) return
    self%data%response = self%approximations(number)%response
    self%rest = self%approximations(number)%rest
    self%in_use = number
  end subroutine flight_use

  !> Finds, for the flight in use, the difference between its samples, joined by straight lines, and its Fourier series up to the
  !> last harmonic. This is what the series leaves out: higher frequencies, and the part that is not quite periodic.
  subroutine find_rest(self)
    type(wing_flight_t), intent(inout) :: self
    complex(rp), allocatable :: samples(:, :)
    real(rp) :: shown(self%n), share, nothing(N_BALANCE)
    integer :: r, k, at, i, j
    nothing = 0
    call self%show(nothing, self%data%response%value, shown)
    if (.not. allocated(self%rest)) allocate (self%rest(self%n))
    at = 0
    do r = 1, size(self%flights)
      associate (f => self%flights(r))
        samples = along_axes(f, cmplx(self%data%response%samples, kind=rp))
        do k = 1, size(f%component)
          do j = 1, size(f%time)
            if (.not. f%is_known(j, k)) cycle
            at = at + 1
            i = min(int(f%time(j)*N_PHASES), N_PHASES - 2)
            share = f%time(j)*N_PHASES - i
            associate (x => real(samples(i + 1:i + 2, f%component(k)), rp))
              self%rest(at) = ((1 - share)*x(1) + share*x(2))/f%sd(j, k) - shown(at)
            end associate
          end do
        end do
      end associate
    end do
  end subroutine find_rest

  !> Returns in values(n) what the balance with the coordinates p shows of the Fourier series `series`, and where landmarks are,
  !> along the axes of the records and in units of the sd. With `number` it returns the derivative with respect to that coordinate
  !> of the balance instead.
  subroutine flight_show(self, p, series, values, number)
    class(wing_flight_t), intent(in) :: self
    real(rp), intent(in) :: p(N_BALANCE)
    complex(rp), intent(in) :: series(0:, :)
    real(rp), intent(out) :: values(:)
    integer, intent(in), optional :: number
    complex(rp) :: y(0:ubound(series, 1), N_COMPONENTS), seen(0:ubound(series, 1), size(series, 2))
    integer :: r, k, at, n
    at = 0
    do r = 1, size(self%flights)
      associate (f => self%flights(r))
        seen = along_axes(f, series)
        if (f%side == 0) call apply_balance(p, f%frequency, seen(:, :N_COMPONENTS), along_axes(f, self%inertia), y, number)
        do k = 1, size(f%component)
          n = count(f%is_known(:, k))
          associate (time => self%time(at + 1:at + n), sd => pack(f%sd(:, k), f%is_known(:, k)))
            if (f%side == 0) values(at + 1:at + n) = balance_values(y(:, f%component(k)), time)/sd
            if (f%side > 0) values(at + 1:at + n) = balance_values(seen(:, f%component(k)), time)/sd*merge(0, 1, present(number))
          end associate
          at = at + n
        end do
      end associate
    end do
  end subroutine flight_show

  !> Splits the coordinates q of all parameters into the changes c of the flight and the coordinates p of the balance.
  pure subroutine split(self, q, c, p)
    class(wing_flight_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: c(N_CHANGES), p(N_BALANCE)
    integer :: i
    c = 0
    p = 0
    do i = 1, size(q)
      associate (j => self%change(i)%number)
        if (j > 0) c(j) = c(j) + self%change(i)%at(q(i))
      end associate
      if (self%kind(i) == KIND_BALANCE) p(self%number(i)) = q(i)
    end do
  end subroutine split

  !> Returns the residuals(n), simulated minus measured in units of the sd, at the coordinates q, and their derivatives
  !> jacobian(n, size(columns)) with respect to the coordinates q(columns).
  subroutine flight_evaluate(self, q, columns, residuals, jacobian)
    class(wing_flight_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    complex(rp) :: series(0:self%data%response%n_harmonics, size(self%data%response%value, 2))
    real(rp) :: c(N_CHANGES), p(N_BALANCE)
    integer :: k, i
    call split(self, q, c, p)
    series = self%data%response%at(c)
    call self%show(p, series, residuals)
    residuals = residuals + self%rest - observed(self)
    do k = 1, size(columns)
      i = columns(k)
      jacobian(:, k) = 0
      if (self%kind(i) == KIND_FLIGHT) &
        call self%show(without_additions(p), self%change(i)%slope(q(i))*self%data%response%derivative(c, self%change(i)%number), &
                       jacobian(:, k))
      if (self%kind(i) == KIND_BALANCE) call self%show(p, series, jacobian(:, k), self%number(i))
    end do
  end subroutine flight_evaluate

  !> Returns the measured means in units of their sd.
  pure function observed(self) result(values)
    class(wing_flight_t), intent(in) :: self
    real(rp) :: values(self%n)
    integer :: r, k, at, n
    at = 0
    do r = 1, size(self%flights)
      associate (f => self%flights(r))
        do k = 1, size(f%component)
          n = count(f%is_known(:, k))
          values(at + 1:at + n) = pack(f%mean(:, k)/f%sd(:, k), f%is_known(:, k))
          at = at + n
        end do
      end associate
    end do
  end function observed

  !> Returns nuisances(n, n_nuisances) at q. They are the errors that refinements show, if they are known, in the order of their
  !> numbers, the effects of errors of one sd of the kinematics as far as records state them, then the errors of the axes of each
  !> camera, and the effect of an error of one sd of the simulation, first on all components of the force together, with the bending
  !> that landmarks see, then on each one alone and on that bending alone. Errors of the kinematics whose flights failed are not
  !> known: their columns are 0.
  subroutine flight_nuisances(self, q, nuisances)
    class(wing_flight_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(inout) :: nuisances(:, :)
    complex(rp), dimension(0:self%data%response%n_harmonics, size(self%data%response%value, 2)) :: series, one
    real(rp) :: c(N_CHANGES), p(N_BALANCE)
    integer :: i, j, last
    if (self%n_nuisances == 0) return
    call split(self, q, c, p)
    last = 0
    do i = 1, N_REFINEMENTS
      if (.not. self%data%refined(i)) cycle
      last = last + 1
      call self%show(without_additions(p), self%data%facts%error_over_change(i)*self%data%response%refined(:, :, i), &
                     nuisances(:, last))
    end do
    do j = 1, N_CHANGES
      if (.not. self%stated(j) > 0) cycle
      last = last + 1
      nuisances(:, last) = 0
      if (self%data%response%knows(j)) &
        call self%show(without_additions(p), self%stated(j)*self%data%response%derivative(c, j), nuisances(:, last))
    end do
    series = self%data%response%at(c)
    do i = 1, maxval(self%camera)
      call put_misplacements(self%flights, self%camera, i, self%time, series, nuisances(:, last + 1:last + N_MISPLACED))
      last = last + N_MISPLACED
    end do
    if (.not. self%data%model_sd > 0) return
    one = 0
    if (any(self%flights%side > 0)) then
      one(:, N_COMPONENTS + 1:) = self%data%model_sd*bending(self)
      call self%show(without_additions(p), one, nuisances(:, self%n_nuisances))
    end if
    series(:, N_COMPONENTS + 1:) = one(:, N_COMPONENTS + 1:)/self%data%model_sd ! bends with the forces
    call self%show(without_additions(p), self%data%model_sd*series, nuisances(:, last + 1))
    do i = 1, N_COMPONENTS
      one = 0
      one(:, i) = self%data%model_sd*series(:, i)
      call self%show(without_additions(p), one, nuisances(:, last + 1 + i))
    end do
  end subroutine flight_nuisances

  !> Returns the Fourier series of how far [m] bending moves the landmarks in the flight of the case: 0 for rigid wings.
  pure function bending(self) result(x)
    class(wing_flight_t), intent(in) :: self
    complex(rp) :: x(0:self%data%response%n_harmonics, size(self%data%facts%rigid, 2))
    x = self%approximations(1)%response%value(:, N_COMPONENTS + 1:) - &
        balance_harmonics(self%data%facts%rigid, self%data%response%n_harmonics)
    if (.not. self%data%facts%is_flexible) x = 0
  end function bending

  !> Returns patterns(n, n_patterns): waves over the beat in each component of the force, and in motions of the wing that landmarks
  !> see, which stand for the effect of unknown causes.
  subroutine flight_patterns(self, patterns)
    class(wing_flight_t), intent(in) :: self
    real(rp), intent(inout) :: patterns(:, :)
    integer :: r, k, at, n, column
    real(rp), allocatable :: share(:)
    patterns = 0
    at = 0
    column = 0
    do r = 1, size(self%flights)
      associate (f => self%flights(r))
        if (f%side > 0) then
          n = f%count()
          k = count_patterns(f)
          call put_wing_patterns(f, self%time(at + 1:at + n), patterns(at + 1:at + n, column + 1:column + k))
          at = at + n
          column = column + k
          cycle
        end if
        do k = 1, size(f%component)
          n = count(f%is_known(:, k))
          share = UNKNOWN_SHARE*sqrt(sum(f%mean(:, k)**2, f%is_known(:, k))/n)/pack(f%sd(:, k), f%is_known(:, k))
          call put_waves(share, self%time(at + 1:at + n), patterns(at + 1:at + n, column + 1:column + 2*N_WAVES + 1))
          column = column + 2*N_WAVES + 1
          at = at + n
        end do
      end associate
    end do
  end subroutine flight_patterns

  !> Appends the labels of the observations. Each component of each record becomes a surface with its own fold and block.
  subroutine flight_append_labels(self, labels)
    class(wing_flight_t), intent(in) :: self
    type(labels_t), intent(inout) :: labels
    integer :: r, k
    do r = 1, size(self%flights)
      do k = 1, size(self%flights(r)%component)
        call append_surface(labels, count(self%flights(r)%is_known(:, k)), [0.0_rp, 0.0_rp])
      end do
    end do
  end subroutine flight_append_labels

  !> Returns in c the covariance, in units of the sd, of the observations `rows`, which belong to one block.
  pure subroutine flight_covariance(self, rows, c)
    class(wing_flight_t), intent(in) :: self
    integer, intent(in) :: rows(:)
    real(rp), intent(out) :: c(:, :)
    real(rp) :: apart
    integer :: i, j
    do j = 1, size(rows)
      associate (f => self%flights(self%record(rows(j))))
        do i = 1, size(rows)
          apart = abs(self%time(rows(i)) - self%time(rows(j)))
          apart = min(apart, 1 - apart)/f%frequency ! a beat follows itself
          c(i, j) = merge(1.0_rp, 0.0_rp, i == j)
          if (f%correlation_time > 0) c(i, j) = exp(-apart/f%correlation_time)
        end do
      end associate
    end do
  end subroutine flight_covariance
end module diagnosis_wing_flight

! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs what a diagnosis needs while it runs and its own simulator cannot compute: fits on the other mesh, and flights with the
!> parameters that were found. Rank 0 leads the diagnosis; the other ranks are in `serve` until it ends.
module diagnosis_further_runs
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_outcome, only: outcome_t
  use diagnosis_discretisation, only: discretisation_error_t
  use diagnosis_flight_catalogue, only: flight_steps, rounded
  use diagnosis_flight_data, only: append_requests, change_t, flight_cases_t, flight_data_t
  use diagnosis_flight_response, only: flight_response_t
  use diagnosis_flight_changes, only: FLOW_FREQUENCY, FLOW_STRUCTURE, FLOW_VISCOSITY, FLOW_WIND, is_of_structure, N_CHANGES, N_FLOW
  use diagnosis_flight_refinements, only: N_REFINEMENTS, REFINE_GRID
  use diagnosis_flight_runner, only: flight_record_t, flight_request_t, flight_runner_t
  use diagnosis_flight_structure, only: acts_in_flight, add_structure, structure_step
  use diagnosis_wing_parameters, only: disc_at, same_parameter, wing_parameter_t
  use diagnosis_wing_simulator, only: wing_simulator_t
  use diagnosis_wing_state, only: wing_state_t
  use inference_relinearisation, only: model_error_t
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: further_runs_t

  real(rp), parameter :: NEAR = 0.1_rp !< of an sd: unit to which the changes of a flight are rounded
  integer, parameter :: IS_OVER = 0, FIT_OTHER_MESH = 1, FLY = 2 !< what rank 0 asks for

  type, extends(model_error_t) :: further_runs_t
    type(outcome_t) :: outcome !< of the flights
    type(world_t), private :: world
    type(wing_simulator_t), pointer, private :: simulator => null()
    type(discretisation_error_t), pointer, private :: other_mesh => null() !< if there is one
    class(flight_runner_t), pointer, private :: runner => null()           !< if further flights may be made
    type(flight_cases_t), pointer, private :: flights => null()
  contains
    procedure :: init => runs_init
    procedure :: take_flights => runs_take_flights
    procedure :: take_runner => runs_take_runner
    procedure :: fly => runs_fly
    procedure :: renew => runs_renew
    procedure :: linearise => runs_linearise
    procedure :: serve => runs_serve
    procedure :: shut_down => runs_shut_down
  end type further_runs_t

contains

  !> Takes the simulator of the diagnosis and, if there is one, the other mesh. Both must live as long as this.
  subroutine runs_init(self, world, simulator, other_mesh)
    class(further_runs_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(wing_simulator_t), intent(in), target :: simulator
    type(discretisation_error_t), intent(in), target, optional :: other_mesh
    self%world = world
    self%simulator => simulator
    if (present(other_mesh)) self%other_mesh => other_mesh
  end subroutine runs_init

  !> Allows up to most_rounds rounds of flights with the parameters that were found, and adds their results to `flights`. `runner`
  !> and `flights` must live as long as this.
  subroutine runs_take_flights(self, most_rounds, runner, flights)
    class(further_runs_t), intent(inout) :: self
    integer, intent(in) :: most_rounds
    class(flight_runner_t), intent(in), target :: runner
    type(flight_cases_t), intent(in), target :: flights
    self%most_rounds = most_rounds
    self%runner => runner
    self%flights => flights
  end subroutine runs_take_flights

  !> Allows `fly`. `runner` must live as long as this.
  subroutine runs_take_runner(self, runner)
    class(further_runs_t), intent(inout) :: self
    class(flight_runner_t), intent(in), target :: runner
    self%runner => runner
  end subroutine runs_take_runner

  !> Simulates the requested flights that were not simulated before; see `flight_runner_t`. On rank 0, while the others are in
  !> `serve`.
  subroutine runs_fly(self, requests, records, failure)
    class(further_runs_t), intent(inout) :: self
    type(flight_request_t), intent(in) :: requests(:)
    type(flight_record_t), allocatable, intent(out) :: records(:)
    type(failure_t), intent(inout) :: failure
    integer :: asked
    call self%simulator%shut_down()
    asked = self%world%max_integer(FLY)
    call fly_requests(self, requests, records)
    failure = self%outcome%failure
  end subroutine runs_fly

  !> See `model_error_t`. On rank 0.
  subroutine runs_renew(self, whitener, q, state)
    class(further_runs_t), intent(inout) :: self
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(inout) :: state
    real(rp), allocatable :: q_other(:)
    real(rp) :: own(whitener%n)
    logical :: can_renew
    integer :: asked
    if (.not. associated(self%other_mesh)) return
    call self%other_mesh%begin_renewal(q, state, q_other, own, can_renew)
    if (.not. can_renew) return
    call self%simulator%shut_down()
    asked = self%world%max_integer(FIT_OTHER_MESH)
    call self%other_mesh%renew(whitener, q_other, own, state)
  end subroutine runs_renew

  !> Simulates the flight with the kinematics and the flow of q, and flights about it with changes of the fitted parameters; see
  !> `model_error_t`. On rank 0.
  subroutine runs_linearise(self, q, sd, state, rows, unmade, failure)
    class(further_runs_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), sd(:)
    class(solver_state_t), intent(inout) :: state
    integer, allocatable, intent(out) :: rows(:)
    type(failure_t), intent(out) :: unmade
    type(failure_t), intent(inout) :: failure
    type(flight_request_t), allocatable :: requests(:)
    type(flight_record_t), allocatable :: records(:)
    type(flight_response_t) :: responses(count_cases(self))
    real(rp), dimension(N_FLOW, size(responses)) :: sd_of, steps, origin
    real(rp) :: c(N_CHANGES)
    logical :: refined(N_REFINEMENTS, size(responses))
    integer :: first(size(responses) + 1), n_before, k
    allocate (rows(0), requests(0))
    if (size(responses) == 0) return
    first = 0
    n_before = 0
    if (allocated(self%flights%cases(1)%facts%structure)) n_before = size(self%flights%cases(1)%facts%structure)
    call add_found(self, q, sd)
    do k = 1, size(responses)
      associate (data => self%flights%cases(k))
        call find_changes(self, data, q, sd, c, sd_of(:, k))
        responses(k) = data%response
        first(k + 1) = size(requests)
        if (.not. any(sd_of(:, k) > 0)) cycle
        steps(:, k) = flight_steps(data%facts, self%flights%effects, sd_of(:, k))
        origin(:, k) = data%response%seen(c)
        ! After rounding, data that differ little need the same flights.
        where (sd_of(:, k) > 0) origin(:, k) = rounded(origin(:, k), NEAR*max(sd_of(:, k), tiny(1.0_rp)))
        call keep_within(data, origin(:, k), steps(:, k))
        refined(:, k) = .false. ! the others stay as at the case
        refined(REFINE_GRID, k) = data%refined(REFINE_GRID)
        call append_requests(requests, data%response%requests(steps(:, k), refined(:, k), origin(:, k)), k)
        first(k + 1) = size(requests)
      end associate
    end do
    if (size(requests) == 0) return
    call self%fly(requests, records, failure)
    if (failure%failed) return
    do k = 1, size(responses)
      if (first(k + 1) == first(k)) cycle
      if (.not. unmade%failed) &
        call responses(k)%move(origin(:, k), steps(:, k), refined(:, k), records(first(k) + 1:first(k + 1)), unmade)
    end do
    if (unmade%failed) then
      call forget_structure(self%flights, n_before)
      return
    end if
    do k = 1, size(responses)
      call append(self%flights%cases(k)%again, responses(k))
    end do
    call approximate_flights(self%simulator, self%flights, state, rows)
  end subroutine runs_linearise

  !> Makes the fitted parameters of the structure changes of flights, as far as they are not and cases can have them: flights then
  !> test what the other data have found.
  subroutine add_found(self, q, sd)
    class(further_runs_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), sd(:)
    character(:), allocatable :: reason
    type(wing_parameter_t) :: p
    logical :: is_full
    integer :: i
    if (.not. self%flights%bend()) return
    is_full = .false.
    do i = 1, size(q)
      p = self%simulator%wing_parameters(i)
      if (.not. (sd(i) > 0 .and. acts_in_flight(p))) cycle
      p%disc = disc_at(self%simulator%wing_parameters, i, q)
      call add_structure(p, .false., self%runner, self%flights%cases, is_full, reason)
    end do
  end subroutine add_found

  !> Takes back what was added to the first n parameters of the structure, as their flights failed.
  pure subroutine forget_structure(flights, n)
    type(flight_cases_t), intent(inout) :: flights
    integer, intent(in) :: n
    integer :: k
    do k = 1, size(flights%cases)
      associate (facts => flights%cases(k)%facts)
        if (.not. allocated(facts%structure)) cycle
        facts%structure = facts%structure(:n)
        facts%origin = facts%origin(:n)
        facts%missing(FLOW_STRUCTURE + n + 1:) = ''
      end associate
    end do
  end subroutine forget_structure

  !> Makes steps smaller with which a parameter of the structure would leave its bounds on either side of the flight at `origin`. No
  !> step falls below a tenth of the usual one, where two flights would differ by their errors: `origin` moves inward by it.
  pure subroutine keep_within(data, origin, steps)
    type(flight_data_t), intent(in) :: data
    real(rp), intent(inout) :: origin(N_FLOW), steps(N_FLOW)
    real(rp), parameter :: LEAST = 0.1_rp, INSIDE = 1.000001_rp !< round-off does not leave the bounds
    real(rp) :: step, value
    integer :: j
    do j = 1, N_FLOW
      if (.not. (is_of_structure(j) .and. steps(j) > 0)) cycle
      associate (p => data%facts%structure(j - FLOW_STRUCTURE), own => data%facts%origin(j - FLOW_STRUCTURE))
        step = min(steps(j), LEAST*structure_step(p))
        value = own + origin(j)
        if (value - step < p%lower) origin(j) = p%lower + INSIDE*step - own
        if (value + step > p%upper) origin(j) = p%upper - INSIDE*step - own
        value = own + origin(j)
        steps(j) = max(step, min(steps(j), value - p%lower, p%upper - value))
      end associate
    end do
  end subroutine keep_within

  !> Returns the number of cases whose flights may be made again.
  pure integer function count_cases(self) result(n)
    class(further_runs_t), intent(in) :: self
    n = 0
    if (associated(self%flights)) n = size(self%flights%cases)
  end function count_cases

  !> Appends a response to the others.
  subroutine append(responses, one)
    type(flight_response_t), allocatable, intent(inout) :: responses(:)
    type(flight_response_t), intent(in) :: one
    type(flight_response_t), allocatable :: more(:)
    integer :: i, n
    n = 0
    if (allocated(responses)) n = size(responses)
    allocate (more(n + 1))
    do i = 1, n
      more(i) = responses(i)
    end do
    more(n + 1) = one
    call move_alloc(more, responses)
  end subroutine append

  !> Gives `state` the approximations of forces over the beat that were appended to all cases. `rows` are the observations that this
  !> changes.
  subroutine approximate_flights(simulator, flights, state, rows)
    type(wing_simulator_t), intent(inout) :: simulator
    type(flight_cases_t), intent(in) :: flights
    class(solver_state_t), intent(inout) :: state
    integer, allocatable, intent(out) :: rows(:)
    integer :: i
    select type (state)
    type is (wing_state_t)
      call simulator%motion%flight%add(flights, size(flights%cases(1)%again), state%flight)
    class default
      call require(.false., 'approximate_flights: the state must be one of a wing')
    end select
    rows = [(i, i=simulator%n_observations - simulator%motion%flight%n + 1, simulator%n_observations)]
  end subroutine approximate_flights

  !> Finds the changes c of kinematics and flow of a case at q, and the standard deviations sd_of of those that flights simulate; 0
  !> for those that are not fitted. Both are 0 for a change whose first flights failed or that the case cannot make: it acts on no
  !> force, and a round does not fly it.
  subroutine find_changes(self, data, q, sd, c, sd_of)
    class(further_runs_t), intent(in) :: self
    type(flight_data_t), intent(in) :: data
    real(rp), intent(in) :: q(:), sd(:)
    real(rp), intent(out) :: c(N_CHANGES), sd_of(N_FLOW)
    type(change_t) :: change
    logical :: known(N_FLOW)
    integer :: i, k
    sd_of = 0
    known = data%response%is_known
    if (allocated(data%facts%structure)) &
      known(FLOW_STRUCTURE + data%facts%n_first + 1:FLOW_STRUCTURE + size(data%facts%structure)) = .true.
    known = known .and. data%facts%missing == ''
    associate (parameters => self%simulator%wing_parameters)
      c = data%changes_at(parameters, q)
      do i = 1, size(q)
        change = data%change_by(parameters(i))
        k = change%number
        if (k == 0) cycle
        if (k /= FLOW_FREQUENCY) then
          sd_of(k) = max(sd_of(k), change%slope(q(i))*sd(i))
        else
          sd_of(FLOW_VISCOSITY) = max(sd_of(FLOW_VISCOSITY), sd(i))
          sd_of(FLOW_WIND + 1:FLOW_WIND + 3) = max(sd_of(FLOW_WIND + 1:FLOW_WIND + 3), sd(i)*abs(data%facts%wind))
        end if
      end do
    end associate
    where (.not. known)
      sd_of = 0
      c(:N_FLOW) = 0
    end where
  end subroutine find_changes

  !> Simulates the flights that rank 0 requests, on all ranks. On the other ranks `requests` may be empty. Collective.
  subroutine fly_requests(self, requests, records)
    class(further_runs_t), intent(inout) :: self
    type(flight_request_t), intent(in) :: requests(:)
    type(flight_record_t), allocatable, intent(out) :: records(:)
    type(flight_request_t), allocatable :: shared(:)
    real(rp), allocatable :: numbers(:)
    character(:), allocatable :: wing
    integer :: i, n
    n = size(requests)
    call self%world%broadcast_integer(n)
    call share_structure(self)
    allocate (shared(n), numbers((N_FLOW + 2)*n))
    if (size(requests) > 0) numbers = &
      [([requests(i)%change, real([requests(i)%refinement, requests(i)%case], rp)], i=1, n)]
    call self%world%broadcast_reals(numbers)
    do i = 1, n
      associate (one => numbers((N_FLOW + 2)*(i - 1) + 1:(N_FLOW + 2)*i))
        shared(i)%change = one(:N_FLOW)
        shared(i)%refinement = nint(one(N_FLOW + 1))
        shared(i)%case = nint(one(N_FLOW + 2))
      end associate
      wing = ''
      if (i <= size(requests)) then
        if (allocated(requests(i)%wing)) wing = requests(i)%wing
      end if
      call self%world%broadcast_text(wing)
      if (wing /= '') shared(i)%wing = wing
    end do
    call self%runner%fly(self%world, shared, records, self%outcome)
  end subroutine fly_requests

  !> Tells the runners of all ranks which parameters of the structure the requests change. Collective.
  subroutine share_structure(self)
    class(further_runs_t), intent(inout) :: self
    integer, allocatable :: numbers(:)
    integer :: n, k
    n = 0
    if (self%world%is_root .and. count_cases(self) > 0) then
      if (allocated(self%flights%cases(1)%facts%structure)) n = size(self%flights%cases(1)%facts%structure)
    end if
    call self%world%broadcast_integer(n)
    allocate (numbers(n))
    do k = 1, n
      if (self%world%is_root) numbers(k) = number_of(self%simulator%wing_parameters, self%flights%cases(1)%facts%structure(k))
      call self%world%broadcast_integer(numbers(k))
    end do
    self%runner%structure = self%simulator%wing_parameters(numbers)
    do k = 1, n ! places that were searched
      if (self%world%is_root) self%runner%structure(k)%disc = self%flights%cases(1)%facts%structure(k)%disc
      call self%world%broadcast_reals(self%runner%structure(k)%disc)
    end do
  end subroutine share_structure

  !> Returns which of the parameters p is.
  pure integer function number_of(parameters, p) result(number)
    type(wing_parameter_t), intent(in) :: parameters(:), p
    do number = 1, size(parameters) - 1
      if (same_parameter(parameters(number), p)) return
    end do
  end function number_of

  !> Does on the other ranks what rank 0 asks for, until `shut_down`. The difference of the meshes is known before.
  subroutine runs_serve(self)
    class(further_runs_t), intent(inout) :: self
    type(flight_request_t) :: nothing(0)
    type(flight_record_t), allocatable :: records(:)
    do
      call self%simulator%serve()
      select case (self%world%max_integer(IS_OVER))
      case (FIT_OTHER_MESH)
        call self%other_mesh%serve()
      case (FLY)
        call fly_requests(self, nothing, records)
      case default
        exit
      end select
    end do
  end subroutine runs_serve

  !> Ends `serve`. On rank 0.
  subroutine runs_shut_down(self)
    class(further_runs_t), intent(in) :: self
    integer :: asked
    call self%simulator%shut_down()
    asked = self%world%max_integer(IS_OVER)
  end subroutine runs_shut_down
end module diagnosis_further_runs

! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds what is known of flights before the statistics begin: of each case that simulates records over the beat, its facts and what
!> its flights showed.
module diagnosis_flight_data
  use base_kinds, only: rp
  use diagnosis_flight_changes, only: FLOW_PLATE, FLOW_STRUCTURE, FLOW_YOUNG, N_CHANGES
  use diagnosis_flight_refinements, only: N_REFINEMENTS
  use diagnosis_flight_response, only: flight_response_t
  use diagnosis_flight_runner, only: flight_facts_t, flight_request_t
  use diagnosis_mesh_relation, only: mesh_relation_t
  use diagnosis_wing_parameters, only: same_parameter, wing_parameter_t, KIND_FLIGHT, KIND_MEMBRANE, KIND_PARAMETER
  use solid_usual_causes, only: PARAM_PLATE, PARAM_THICKNESS, PARAM_YOUNG
  implicit none
  private
  public :: append_requests, change_t, flight_cases_t, flight_data_t

  integer, parameter, public :: MOST_CASES = 9 !< that one diagnosis takes; each has a result file in diagnose_results

  !> How a parameter changes flights: change `number` is scale (x - origin), where x is its coordinate on the mesh of the wing file,
  !> which flights have. 0: it changes none.
  type :: change_t
    integer :: number = 0
    real(rp) :: origin = 0, scale = 1
    type(mesh_relation_t) :: on_file
  contains
    procedure :: at => change_at
    procedure :: slope => change_slope
  end type change_t

  !> The data of one case.
  type :: flight_data_t
    integer :: number = 1           !< of the case
    integer :: first = 1, last = 0  !< of the records of the measurement that this case simulates
    type(flight_response_t) :: response
    type(flight_facts_t) :: facts
    logical :: refined(N_REFINEMENTS) = .false. !< numerical errors whose effect a flight of its own shows
    real(rp) :: model_sd = 0        !< relative error of all simulated components together, and of each, the same over the beat
    type(flight_response_t), allocatable :: again(:) !< approximations about fitted values, in the order of their flights
  contains
    procedure :: change_by => data_change_by
    procedure :: changes_at => data_changes_at
  end type flight_data_t

  !> The data of all cases. The records of a measurement are in the order of their cases.
  type :: flight_cases_t
    integer, allocatable :: free(:)      !< parameters of the wing, by their numbers in it, that the baseline fits
    logical :: has_records = .false.     !< there are any; the rest counts then
    logical :: is_ready = .false.        !< flights have been flown
    character(:), allocatable :: effects !< of the catalogue that are tested; empty: all
    type(flight_data_t), allocatable :: cases(:)
  contains
    procedure :: case_of => cases_case_of
    procedure :: bend => cases_bend
  end type flight_cases_t

contains

  !> Returns how parameter p changes the flights of this case: as a change of all cases or of this one or, where wings bend and have
  !> other data, as E, D, its error or the thickness of the wing, on which D depends by its third power, or as a further parameter
  !> of the structure that flights change.
  pure elemental type(change_t) function data_change_by(self, p) result(change)
    class(flight_data_t), intent(in) :: self
    type(wing_parameter_t), intent(in) :: p
    integer :: k
    if (p%kind == KIND_FLIGHT .and. (p%record == 0 .or. p%record == self%number)) then
      change%number = p%number
    else if (p%kind == KIND_MEMBRANE .and. any(self%facts%shares)) then
      change = change_t(FLOW_PLATE, 0.0_rp, 1.0_rp)
    else if (p%kind == KIND_PARAMETER .and. any(self%facts%shares)) then
      associate (material => self%facts%material)
        if (p%number == PARAM_YOUNG) change = change_t(FLOW_YOUNG, log(material(1)), 1.0_rp)
        if (p%number == PARAM_PLATE) change = change_t(FLOW_PLATE, log(material(2)), 1.0_rp)
        if (p%number == PARAM_THICKNESS) change = change_t(FLOW_PLATE, log(material(3)), 3.0_rp)
      end associate
    end if
    if (change%number > 0 .or. .not. allocated(self%facts%structure)) return
    do k = 1, size(self%facts%structure)
      if (.not. same_parameter(self%facts%structure(k), p)) cycle
      change = change_t(FLOW_STRUCTURE + k, self%facts%origin(k), 1.0_rp, p%on_file)
    end do
  end function data_change_by

  !> Returns the change at the coordinate q of its parameter.
  pure elemental real(rp) function change_at(self, q) result(c)
    class(change_t), intent(in) :: self
    real(rp), intent(in) :: q
    c = self%scale*(self%on_file%at(q) - self%origin)
  end function change_at

  !> Returns its derivative with respect to q.
  pure elemental real(rp) function change_slope(self, q) result(slope)
    class(change_t), intent(in) :: self
    real(rp), intent(in) :: q
    slope = self%scale*self%on_file%slope(q)
  end function change_slope

  !> Returns the changes of this case whose parameters have the coordinates q.
  pure function data_changes_at(self, parameters, q) result(c)
    class(flight_data_t), intent(in) :: self
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    real(rp) :: c(N_CHANGES)
    type(change_t) :: change
    integer :: i
    c = 0
    do i = 1, size(q)
      change = self%change_by(parameters(i))
      if (change%number > 0) c(change%number) = c(change%number) + change%at(q(i))
    end do
  end function data_changes_at

  !> Returns the number of the case that simulates record r.
  pure integer function cases_case_of(self, r) result(k)
    class(flight_cases_t), intent(in) :: self
    integer, intent(in) :: r
    do k = 1, size(self%cases) - 1
      if (r <= self%cases(k)%last) return
    end do
  end function cases_case_of

  !> Tells whether records are simulated with wings that bend.
  pure logical function cases_bend(self) result(bend)
    class(flight_cases_t), intent(in) :: self
    bend = self%has_records
    if (bend) bend = any(self%cases%facts%is_flexible)
  end function cases_bend

  !> Appends requests for flights of case `number` to a list.
  pure subroutine append_requests(list, more, number)
    type(flight_request_t), allocatable, intent(inout) :: list(:)
    type(flight_request_t), intent(in) :: more(:)
    integer, intent(in) :: number
    type(flight_request_t), allocatable :: longer(:)
    integer :: i, n
    n = size(list)
    allocate (longer(n + size(more)))
    do i = 1, n
      longer(i) = list(i)
    end do
    do i = 1, size(more)
      longer(n + i) = more(i)
      longer(n + i)%case = number
    end do
    call move_alloc(longer, list)
  end subroutine append_requests
end module diagnosis_flight_data

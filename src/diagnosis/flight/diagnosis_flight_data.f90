! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds what is known of flights before the statistics begin: of each case that simulates records over the beat, its facts and what
!> its flights showed.
module diagnosis_flight_data
  use base_kinds, only: rp
  use diagnosis_flight_refinements, only: N_REFINEMENTS
  use diagnosis_flight_response, only: flight_response_t
  use diagnosis_flight_runner, only: flight_facts_t, flight_request_t
  implicit none
  private
  public :: append_requests, flight_cases_t, flight_data_t

  integer, parameter, public :: MOST_CASES = 9

  !> The data of one case.
  type :: flight_data_t
    integer :: number = 1           !< of the case
    integer :: first = 1, last = 0  !< of the records of the measurement that this case simulates
    type(flight_response_t) :: response
    type(flight_facts_t) :: facts
    logical :: refined(N_REFINEMENTS) = .false. !< numerical errors whose effect a flight of its own shows
    real(rp) :: model_sd = 0        !< relative error of all simulated components together, and of each, the same over the beat
    type(flight_response_t), allocatable :: again(:) !< approximations about fitted values, in the order of their flights
  end type flight_data_t

  !> The data of all cases. The records of a measurement are in the order of their cases.
  type :: flight_cases_t
    logical :: has_records = .false.     !< there are any; the rest counts then
    logical :: is_ready = .false.        !< flights have been flown
    character(:), allocatable :: effects !< of the catalogue that are tested; empty: all
    type(flight_data_t), allocatable :: cases(:)
  contains
    procedure :: case_of => cases_case_of
  end type flight_cases_t

contains

  !> Returns the number of the case that simulates record r.
  pure integer function cases_case_of(self, r) result(k)
    class(flight_cases_t), intent(in) :: self
    integer, intent(in) :: r
    do k = 1, size(self%cases) - 1
      if (r <= self%cases(k)%last) return
    end do
  end function cases_case_of

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

! SPDX-License-Identifier: GPL-3.0-or-later
!> A program that simulates no flight, and judges which parameters a case can have: case 2 no gradient, none of them taper.
module judging_runner
  use base_kinds, only: rp
  use base_outcome, only: outcome_t
  use diagnosis_flight_runner, only: flight_record_t, flight_request_t, flight_runner_t
  use diagnosis_wing_parameters, only: wing_parameter_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: judging_runner_t

  real(rp), parameter, public :: OWN_VALUE = 0.25_rp !< coordinate of every parameter in the wings of a case

  type, extends(flight_runner_t) :: judging_runner_t
  contains
    procedure :: fly => runner_fly
    procedure :: are_missing => runner_are_missing
    procedure :: judge_structure => runner_judge
  end type judging_runner_t

contains

  subroutine runner_fly(self, world, requests, records, outcome)
    class(judging_runner_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(flight_request_t), intent(in) :: requests(:)
    type(flight_record_t), allocatable, intent(out) :: records(:)
    type(outcome_t), intent(inout) :: outcome
    associate (unused => self, unused_too => world, unused_as_well => outcome)
    end associate
    allocate (records(size(requests)))
  end subroutine runner_fly

  function runner_are_missing(self, requests) result(missing)
    class(judging_runner_t), intent(inout) :: self
    type(flight_request_t), intent(in) :: requests(:)
    logical :: missing(size(requests))
    associate (unused => self)
    end associate
    missing = .true.
  end function runner_are_missing

  subroutine runner_judge(self, number, p, own, reason)
    class(judging_runner_t), intent(in) :: self
    integer, intent(in) :: number
    type(wing_parameter_t), intent(in) :: p
    real(rp), intent(out) :: own
    character(:), allocatable, intent(out) :: reason
    associate (unused => self)
    end associate
    own = OWN_VALUE
    reason = ''
    if (p%name == 'E_gradient' .and. number == 2) reason = 'no gradient here'
    if (p%name == 'diameter_exponent') reason = 'no taper anywhere'
  end subroutine runner_judge
end module judging_runner

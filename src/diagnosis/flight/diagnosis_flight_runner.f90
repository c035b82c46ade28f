! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines what a diagnosis needs from a program that simulates flights. The program changes the kinematics or the flow of given
!> cases, simulates the flight, and returns forces, torques, power and the places of landmarks over the last beat. A diagnosis does
!> not know the fluid solver; a program extends `flight_runner_t`.
module diagnosis_flight_runner
  use base_kinds, only: rp
  use base_outcome, only: outcome_t
  use diagnosis_flight_changes, only: N_CHANGES, N_FLOW
  use diagnosis_flight_refinements, only: USUAL_ERROR, N_REFINEMENTS, NOT_REFINED
  use diagnosis_wing_parameters, only: wing_parameter_t
  use measurement_flight, only: N_COMPONENTS
  use parallel_world, only: world_t
  implicit none
  private
  public :: flight_facts_t, flight_record_t, flight_request_t, flight_runner_t

  integer, parameter, public :: N_PHASES = 200 !< samples of a beat, at 0, 1/N_PHASES, ..

  !> A request asks for one flight: the case with these changes, with a smaller numerical error of one kind, and with another wing.
  type :: flight_request_t
    real(rp) :: change(N_FLOW) = 0
    integer :: refinement = NOT_REFINED                !< or REFINE_*
    integer :: case = 1                                !< number of the case
    character(:), allocatable :: wing                  !< sections of an input file that replace those of the case
  end type flight_request_t

  !> A record holds the result of one flight.
  type :: flight_record_t
    logical :: is_flown = .false.
    character(:), allocatable :: reason                !< why not
    real(rp), allocatable :: values(:, :)              !< (N_PHASES, components) SI units, torques about the origin of the box; per
    !< metre of a section. Behind the components of the force come x, y, z of each landmark, from the origin of the box
  end type flight_record_t

  !> The facts are what is known of the case before any flight. They are in SI units.
  type :: flight_facts_t
    character(:), allocatable :: path
    character(:), allocatable :: label                 !< which of the records it simulates, in words; empty: all
    logical :: is_section = .false.                    !< two-dimensional
    logical :: is_flexible = .false.                   !< its wings bend
    real(rp) :: frequency = 0                          !< [Hz] of the beat
    real(rp) :: speed = 0                              !< [m/s] mean of the wing tip, of the plate in a section
    real(rp) :: wind(3) = 0                            !< [m/s]
    real(rp) :: along(3) = [1, 0, 0]                   !< unit vector along which drag points
    logical :: is_alone = .true.                       !< the wing has no other data: E and D are causes here
    logical :: shares(2) = .false.                     !< E and D are parameters of other data, too, and the wings bend
    real(rp) :: material(3) = 1                        !< E [Pa] and D [N m] of wings that bend; the thickness [m] that is this D in
    !< the wing of the diagnosis
    type(wing_parameter_t), allocatable :: structure(:) !< what the changes behind FLOW_STRUCTURE are, the same in all cases
    real(rp), allocatable :: origin(:)                 !< their coordinates at which the case has its own wing
    integer :: n_first = 0                             !< of them are flown first; rounds fly the others
    real(rp) :: prior_sd(N_CHANGES) = 0                !< of changes as far as records state their errors, in units of parameters
    character(200) :: missing(N_FLOW) = ''             !< why this change cannot be made
    real(rp) :: inertia(N_PHASES, N_COMPONENTS) = 0    !< of the wings per kg of their mass, torques as in records
    real(rp), allocatable :: rigid(:, :)               !< (N_PHASES, 3 landmarks) [m] x, y, z from the origin of the box, unbent
    real(rp) :: steps = 0, seconds = 0                 !< of one flight, as far as they can be foreseen
    character(200) :: unrefined(N_REFINEMENTS) = ''    !< why this numerical error cannot be made smaller
    real(rp) :: cost(N_REFINEMENTS) = 1                !< of the flight that makes it smaller, in flights of the case
    real(rp) :: error_over_change(N_REFINEMENTS) = USUAL_ERROR !< the error of the case over the change by this flight
  end type flight_facts_t

  type, abstract :: flight_runner_t
    type(wing_parameter_t), allocatable :: structure(:) !< what the changes of requests behind FLOW_STRUCTURE are
  contains
    procedure(judge_interface), deferred :: judge_structure
    procedure(fly_interface), deferred :: fly
    procedure(missing_interface), deferred :: are_missing
  end type flight_runner_t

  abstract interface
    !> Simulates all requests that were not flown before. On rank 0, records(i) is the result of requests(i) and depends on
    !> nothing else. `outcome` becomes a failure if the machine failed or a stop was asked for, the same on all ranks.
    !> Collective.
    subroutine fly_interface(self, world, requests, records, outcome)
      import :: flight_runner_t, flight_request_t, flight_record_t, world_t, outcome_t
      class(flight_runner_t), intent(inout) :: self
      type(world_t), intent(in) :: world
      type(flight_request_t), intent(in) :: requests(:)
      type(flight_record_t), allocatable, intent(out) :: records(:)
      type(outcome_t), intent(inout) :: outcome
    end subroutine fly_interface

    !> Returns the coordinate `own` at which parameter p of the structure has the value of the wings of case `number`, and in
    !> `reason` why flights of this case cannot have another one; empty if they can. Not collective.
    subroutine judge_interface(self, number, p, own, reason)
      import :: flight_runner_t, rp, wing_parameter_t
      class(flight_runner_t), intent(in) :: self
      integer, intent(in) :: number
      type(wing_parameter_t), intent(in) :: p
      real(rp), intent(out) :: own
      character(:), allocatable, intent(out) :: reason
    end subroutine judge_interface

    !> Tells for each of the requests whether it has not been flown before. Not collective.
    function missing_interface(self, requests) result(missing)
      import :: flight_runner_t, flight_request_t
      class(flight_runner_t), intent(inout) :: self
      type(flight_request_t), intent(in) :: requests(:)
      logical :: missing(size(requests))
    end function missing_interface
  end interface
end module diagnosis_flight_runner

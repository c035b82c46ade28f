! SPDX-License-Identifier: GPL-3.0-or-later
!> Records of two cases in one fit: which parameters and which errors act on which records.
program test_wing_flights
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_flight_changes, only: FLOW_LEAD, FLOW_PLATE, FLOW_YOUNG, N_CHANGES, N_FLOW
  use diagnosis_flight_data, only: change_t, flight_cases_t
  use diagnosis_flight_refinements, only: N_REFINEMENTS, REFINE_BEATS, REFINE_BOX, REFINE_GRID, REFINE_SURFACE, &
                                          thickness_error_over_change, REFINE_THICKNESS, THINNER, USUAL_ERROR
  use diagnosis_flight_runner, only: flight_record_t, N_PHASES
  use diagnosis_wing_flights, only: wing_flights_t
  use diagnosis_wing_parameters, only: wing_parameter_t, KIND_FLIGHT, KIND_PARAMETER
  use measurement_flight, only: measured_flight_t, N_COMPONENTS
  use solid_usual_causes, only: PARAM_PLATE, PARAM_THICKNESS, PARAM_YOUNG
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 5, FZ = 3 !< times of each record, its component
  real(rp), parameter :: STEP = 0.1_rp, YOUNG = 2.0e9_rp, PLATE = 3.0e-7_rp, THICKNESS = 2.0e-5_rp
  type(testkit_t) :: t
  type(flight_cases_t) :: data
  type(wing_parameter_t) :: parameters(4) !< the lead of all, of the first and of the second case, and E
  type(measured_flight_t) :: flights(2)
  type(wing_flights_t) :: wing
  call t%start(parallel=.false.)
  call make()
  call check_derivatives()
  call check_plate()
  call check_errors()
  call t%finish()

contains

  !> Two cases whose force Fz is 1 and 2; a lead of 1 adds 3, E by a factor e adds 5, and a finer grid 0.1, times the case's force.
  subroutine make()
    real(rp), parameter :: FORCES(6) = [1.0_rp, 1.1_rp, 1 + 3*STEP, 1 - 3*STEP, 1 + 5*STEP, 1 - 5*STEP]
    type(flight_record_t) :: records(6)
    type(failure_t) :: failure
    real(rp) :: steps(N_FLOW)
    logical :: refined(N_REFINEMENTS)
    integer :: i, k
    steps = 0
    steps([FLOW_LEAD, FLOW_YOUNG]) = STEP
    refined = .false.
    refined(REFINE_GRID) = .true.
    allocate (data%cases(2))
    do k = 1, 2
      associate (f => flights(k), case => data%cases(k))
        f%frequency = 1
        f%component = [FZ]
        f%time = [(0.2_rp*i, i=0, N - 1)]
        allocate (f%mean(N, 1), source=real(k, rp))
        allocate (f%sd(N, 1), source=0.5_rp)
        allocate (f%is_known(N, 1), source=.true.)
        do i = 1, size(records)
          records(i)%is_flown = .true.
          if (.not. allocated(records(i)%values)) allocate (records(i)%values(N_PHASES, N_COMPONENTS))
          records(i)%values = 0
          records(i)%values(:, FZ) = k*FORCES(i)
        end do
        case%number = k
        case%first = k
        case%last = k
        case%refined = refined
        case%facts%shares(1) = k == 2
        case%facts%shares(2) = k == 2
        case%facts%material = [YOUNG, PLATE, THICKNESS]
        case%response%n_harmonics = 3
        call case%response%take(steps, refined, records, failure)
        call t%check('the flights are taken', .not. failure%failed)
      end associate
    end do
    parameters(:3)%kind = KIND_FLIGHT
    parameters(:3)%number = FLOW_LEAD
    parameters(:3)%record = [0, 1, 2]
    parameters(4)%kind = KIND_PARAMETER
    parameters(4)%number = PARAM_YOUNG
    call wing%init(flights, parameters, data)
  end subroutine make

  !> Residuals are in sd of 0.5. E acts on the second case alone, whose wings bend, and counts from the value of the case.
  subroutine check_derivatives()
    real(rp) :: q(4), residuals(2*N), jacobian(2*N, 4), c(N_CHANGES)
    integer :: i
    q = [0.01_rp, 0.02_rp, 0.04_rp, log(1.1_rp*YOUNG)]
    call wing%evaluate(q, [(i, i=1, 4)], residuals, jacobian)
    call close_to('the leads of all cases and of the first', residuals(:N), 2*3*0.03_rp)
    call close_to('those of all and of the second, and E', residuals(N + 1:), 2*2*(3*0.05_rp + 5*log(1.1_rp)))
    call close_to('the lead of all acts on the first', jacobian(:N, 1), 6.0_rp)
    call close_to('and on the second', jacobian(N + 1:, 1), 12.0_rp)
    call close_to('that of the first', jacobian(:N, 2), 6.0_rp)
    call close_to('does not act on the second', jacobian(N + 1:, 2), 0.0_rp)
    call close_to('that of the second', jacobian(N + 1:, 3), 12.0_rp)
    call close_to('does not act on the first', jacobian(:N, 3), 0.0_rp)
    call close_to('E does not act on rigid wings', jacobian(:N, 4), 0.0_rp)
    call close_to('but on wings that bend', jacobian(N + 1:, 4), 20.0_rp)
    c = data%cases(2)%changes_at(parameters, q)
    call t%check_close('a lead adds up', c(FLOW_LEAD), 0.05_rp, rtol=1.0e-13_rp)
    call t%check_close('E is a factor on that of the case', c(FLOW_YOUNG), log(1.1_rp), rtol=1.0e-13_rp)
  end subroutine check_derivatives

  !> D counts from that of the case. A thickness changes D by its third power, from the one that is this D. Neither acts on rigid
  !> wings, and E is another change.
  subroutine check_plate()
    integer, parameter :: NUMBERS(3) = [PARAM_YOUNG, PARAM_PLATE, PARAM_THICKNESS]
    type(wing_parameter_t) :: p(3)
    type(change_t) :: change(3)
    real(rp) :: c(N_CHANGES)
    p%kind = KIND_PARAMETER
    p%number = NUMBERS
    change = data%cases(2)%change_by(p)
    call t%check('E, D and thickness are changes of E, D and D', all(change%number == [FLOW_YOUNG, FLOW_PLATE, FLOW_PLATE]))
    change = data%cases(1)%change_by(p)
    call t%check('none of them changes rigid wings', all(change%number == 0))
    c = data%cases(2)%changes_at(p(2:2), [log(1.2_rp*PLATE)])
    call t%check_close('D is a factor on that of the case', c(FLOW_PLATE), log(1.2_rp), rtol=1.0e-13_rp)
    c = data%cases(2)%changes_at(p(3:3), [log(1.2_rp*THICKNESS)])
    call t%check_close('a plate that is thicker by f has f^3 times the D', c(FLOW_PLATE), log(1.2_rp**3), rtol=1.0e-13_rp)
    call t%check_close('and the same E', c(FLOW_YOUNG), 0.0_rp, atol=0.0_rp)
  end subroutine check_plate

  !> The error of the grid is one of each case by itself.
  subroutine check_errors()
    real(rp) :: nuisances(2*N, 2)
    call t%check_close('an error of first order is three times its change by 1.5 times the points', &
                       USUAL_ERROR(REFINE_GRID), 3.0_rp, rtol=1.0e-14_rp)
    call t%check_close('one that falls with the square of the box, 1.8 times', USUAL_ERROR(REFINE_BOX), 1.8_rp, &
                       rtol=1.0e-14_rp)
    call t%check_close('one of which no order is known is its change', USUAL_ERROR(REFINE_BEATS), 1.0_rp, rtol=1.0e-14_rp)
    call t%check_close('an error of the thickness is that of the whole thickness, unless it is known', &
                       USUAL_ERROR(REFINE_THICKNESS), thickness_error_over_change(0.2_rp, THINNER*0.2_rp, 0.0_rp), rtol=1.0e-14_rp)
    call t%check_close('and so is that of a surface', USUAL_ERROR(REFINE_SURFACE), &
                       thickness_error_over_change(0.2_rp, 0.0_rp, 0.0_rp), rtol=1.0e-14_rp)
    call t%check_close('wings of half the thickness of the mask err by half of what it changes', &
                       thickness_error_over_change(0.0_rp, 0.2_rp, 0.1_rp), 0.5_rp, rtol=1.0e-14_rp)
    call t%check_close('a mask that is half as thick again as the wings errs by a third of what a surface changes', &
                       thickness_error_over_change(0.3_rp, 0.0_rp, 0.2_rp), 1/3.0_rp, rtol=1.0e-14_rp)
    call t%check('one error for each case', wing%n_nuisances == 2 .and. wing%n == 2*N .and. all(wing%nuisance == [0, 1]))
    call wing%nuisances([0.0_rp, 0.0_rp, 0.0_rp, log(YOUNG)], nuisances)
    call close_to('that of the first', nuisances(:N, 1), 0.2_rp*USUAL_ERROR(REFINE_GRID))
    call close_to('is not one of the second', nuisances(N + 1:, 1), 0.0_rp)
    call close_to('that of the second', nuisances(N + 1:, 2), 0.4_rp*USUAL_ERROR(REFINE_GRID))
    call close_to('is not one of the first', nuisances(:N, 2), 0.0_rp)
  end subroutine check_errors

  subroutine close_to(name, values, value)
    character(*), intent(in) :: name
    real(rp), intent(in) :: values(:), value
    call t%check(name, all(abs(values - value) < 1.0e-11_rp))
  end subroutine close_to
end program test_wing_flights

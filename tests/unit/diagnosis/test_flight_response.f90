! SPDX-License-Identifier: GPL-3.0-or-later
!> Approximations of flights: about the case, about what was found, with the steps of both.
program test_flight_response
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_flight_catalogue, only: flight_steps, rounded, stated_errors
  use diagnosis_flight_response, only: flight_response_t
  use diagnosis_flight_changes, only: FLOW_FREQUENCY, FLOW_LEAD, FLOW_PITCH, FLOW_STRUCTURE, FLOW_VISCOSITY, FLOW_WALL, &
                                      FLOW_WIND, N_CHANGES, N_FLOW
  use diagnosis_flight_refinements, only: read_refinements, refinement_names, N_REFINEMENTS, REFINE_BOX, REFINE_GRID, &
                                          REFINE_SURFACE
  use diagnosis_flight_runner, only: flight_facts_t, flight_record_t, flight_request_t, N_PHASES
  use measurement_flight, only: N_COMPONENTS
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  call t%start(parallel=.false.)
  call check_steps()
  call check_stated()
  call check_rounding()
  call check_move()
  call check_one_sided()
  call check_refinements()
  call t%finish()

contains

  !> The step is the prior sd where nothing is known, then twice the sd of what was found, within the range of the prior.
  subroutine check_steps()
    type(flight_facts_t) :: facts
    real(rp) :: first(N_FLOW), steps(N_FLOW), sd(N_FLOW)
    facts%speed = 2
    facts%missing(FLOW_PITCH) = 'cannot'
    first = flight_steps(facts, '')
    call t%check('every change that can be made has a step', count(first > 0) == FLOW_STRUCTURE - 1 .and. &
                 .not. first(FLOW_PITCH) > 0)
    call t%check_close('that of the lead is its prior sd', first(FLOW_LEAD), 0.02_rp, rtol=1.0e-14_rp)
    call t%check_close('so is that of the wind', first(FLOW_WIND + 1), 0.1_rp, rtol=1.0e-14_rp)
    sd = 0
    sd(FLOW_LEAD) = 0.0019_rp
    sd(FLOW_PITCH) = 0.01_rp
    sd(FLOW_VISCOSITY) = 1
    sd(FLOW_WIND + 1) = 1.0e-5_rp
    steps = flight_steps(facts, '', sd)
    call t%check('only what was fitted has a step', count(steps > 0) == 3 .and. .not. steps(FLOW_PITCH) > 0)
    call t%check_close('twice the sd, with one digit', steps(FLOW_LEAD), 0.004_rp, rtol=1.0e-12_rp)
    call t%check_close('at most the prior sd', steps(FLOW_VISCOSITY), first(FLOW_VISCOSITY), rtol=1.0e-14_rp)
    call t%check_close('at least a tenth of it', steps(FLOW_WIND + 1), first(FLOW_WIND + 1)/10, rtol=1.0e-14_rp)
    steps = flight_steps(facts, 'balance_gain', sd)
    call t%check('what is not sought has none', .not. any(steps > 0))
  end subroutine check_steps

  !> An error that records state is needed whether its cause is sought or not. What the case cannot make is no error.
  subroutine check_stated()
    type(flight_facts_t) :: facts
    real(rp) :: steps(N_FLOW), sd(N_CHANGES)
    facts%missing(FLOW_PITCH) = 'cannot'
    facts%prior_sd(FLOW_PITCH) = 0.01_rp
    facts%prior_sd(FLOW_LEAD) = 0.03_rp
    steps = flight_steps(facts, 'balance_gain')
    call t%check('a stated error alone has a step', count(steps > 0) == 1)
    call t%check_close('which is its sd', steps(FLOW_LEAD), 0.03_rp, rtol=1.0e-14_rp)
    facts%prior_sd(FLOW_FREQUENCY) = 0.02_rp
    steps = flight_steps(facts, 'balance_gain')
    call t%check('that of the frequency needs flights with another viscosity', &
                 count(steps > 0) == 2 .and. steps(FLOW_VISCOSITY) > 0)
    sd = stated_errors(facts)
    call t%check('stated errors are those of changes that can be made', count(sd > 0) == 2)
    call t%check_close('with the sd that is stated', sd(FLOW_LEAD), 0.03_rp, rtol=1.0e-14_rp)
    facts%is_flexible = .true.
    sd = stated_errors(facts)
    call t%check('wings that bend have no other frequency', count(sd > 0) == 1)
  end subroutine check_stated

  subroutine check_rounding()
    call t%check_close('a multiple of 0.001', rounded(0.03612_rp, 0.0034_rp), 0.036_rp, rtol=1.0e-12_rp)
    call t%check_close('a negative one', rounded(-0.0367_rp, 0.0034_rp), -0.037_rp, rtol=1.0e-12_rp)
    call t%check_close('a multiple of 10', rounded(57.0_rp, 99.0_rp), 60.0_rp, rtol=1.0e-12_rp)
  end subroutine check_rounding

  !> Forces that are not quadratic: about what was found the approximation has their value and both derivatives there, and keeps
  !> the derivatives of what was not flown again.
  subroutine check_move()
    type(flight_response_t) :: response
    type(flight_record_t), allocatable :: records(:)
    type(failure_t) :: failure
    real(rp) :: steps(N_FLOW), c(N_CHANGES), origin(N_FLOW)
    real(rp), parameter :: FOUND = 0.3_rp
    logical, dimension(N_REFINEMENTS) :: box, grid
    box = .false.
    box(REFINE_BOX) = .true.
    grid = .false.
    grid(REFINE_GRID) = .true.
    response%n_harmonics = 2
    steps = 0
    steps([FLOW_LEAD, FLOW_VISCOSITY]) = 0.01_rp
    call fly(response%requests(steps, box), records)
    call response%take(steps, box, records, failure)
    call t%check('the flights about the case are taken', .not. failure%failed)
    c = 0
    c(FLOW_LEAD) = FOUND
    call t%check('far from the case the approximation errs', abs(error_at(response, c)) > 1.0e-3_rp)
    origin = response%seen(c)
    steps(FLOW_VISCOSITY) = 0
    call fly(response%requests(steps, grid, origin), records)
    call t%check('the flight, a finer one and two about it', size(records) == 4)
    call response%move(origin, steps, grid, records, failure)
    call t%check('they are taken', .not. failure%failed)
    call t%check_close('forces are those that were flown', error_at(response, c), 0.0_rp, atol=1.0e-14_rp)
    call t%check_close('a finer grid changes them as there', real(response%refined(1, 1, REFINE_GRID), rp), &
                       0.1_rp*force(c(:N_FLOW)), rtol=1.0e-12_rp)
    call t%check_close('a larger box changes them as at the case', real(response%refined(1, 1, REFINE_BOX), rp), &
                       -0.2_rp*force(0*origin), rtol=1.0e-12_rp)
    call t%check_close('which is so large', response%relative_size(REFINE_BOX), 0.2_rp*force(0*origin)/force(origin), &
                       rtol=1.0e-12_rp)
    c(FLOW_LEAD) = FOUND + 0.02_rp
    call t%check_close('and about it', error_at(response, c), 0.0_rp, atol=1.0e-5_rp)
    c(FLOW_VISCOSITY) = 0.02_rp
    call t%check_close('what was not flown again changes them as at the case', error_at(response, c), 0.0_rp, atol=1.0e-4_rp)
    call check_derivative(response, c, FLOW_LEAD)
    call check_derivative(response, c, FLOW_VISCOSITY)
    call check_derivative(response, c, FLOW_FREQUENCY)
    records(3)%is_flown = .false.
    records(3)%reason = 'it diverged'
    call response%move(0*origin, steps, grid, records, failure)
    call t%check('without one of the flights nothing is taken', failure%failed .and. &
                 abs(response%origin(FLOW_LEAD) - FOUND) <= 0)
    if (failure%failed) call t%check('and why', failure%reason == 'it diverged')
  end subroutine check_move

  !> A wall can only be added: one flight, whose difference is a straight line. About what was found the flight is beyond it.
  subroutine check_one_sided()
    type(flight_response_t) :: response
    type(flight_record_t), allocatable :: records(:)
    type(failure_t) :: failure
    real(rp) :: steps(N_FLOW), c(N_CHANGES), origin(N_FLOW)
    logical :: none(N_REFINEMENTS)
    none = .false.
    response%n_harmonics = 2
    steps = 0
    steps([FLOW_LEAD, FLOW_WALL]) = [0.01_rp, 1.0_rp]
    call fly(response%requests(steps, none), records)
    call t%check('two flights for the lead, one for the wall', size(records) == 4)
    call response%take(steps, none, records, failure)
    c = 0
    c(FLOW_WALL) = 1
    call t%check_close('forces with the wall are those that were flown', error_at(response, c), 0.0_rp, atol=1.0e-14_rp)
    call check_derivative(response, c, FLOW_WALL)
    origin = c(:N_FLOW)
    origin(FLOW_WALL) = 0.5_rp
    steps = 0
    steps(FLOW_WALL) = 0.2_rp
    call fly(response%requests(steps, none, origin), records)
    call response%move(origin, steps, none, records, failure)
    c(FLOW_WALL) = 0.7_rp
    call t%check_close('and so they are about what was found', error_at(response, c), 0.0_rp, atol=1.0e-14_rp)
  end subroutine check_one_sided

  !> Words for refinements.
  subroutine check_refinements()
    logical, dimension(N_REFINEMENTS) :: wanted, is_named
    character(:), allocatable :: unknown
    call read_refinements('yes', .true., wanted, is_named, unknown)
    call t%check('the usual ones are all but the step', count(wanted) == N_REFINEMENTS - 1 .and. .not. any(is_named))
    call read_refinements('yes', .false., wanted, is_named, unknown)
    call t%check('and without a known thickness all but the surface', count(wanted) == N_REFINEMENTS - 2 .and. &
                 .not. wanted(REFINE_SURFACE))
    call read_refinements('all', .false., wanted, is_named, unknown)
    call t%check('all', all(wanted) .and. .not. any(is_named))
    call read_refinements('no', .true., wanted, is_named, unknown)
    call t%check('none', .not. any(wanted) .and. unknown == '')
    call read_refinements('box, grid sponges', .true., wanted, is_named, unknown)
    call t%check('those that are named', refinement_names(wanted) == 'grid, box' .and. all(is_named .eqv. wanted))
    call t%check('and what is unknown', unknown == 'sponges')
  end subroutine check_refinements

  subroutine check_derivative(response, c, j)
    type(flight_response_t), intent(in) :: response
    real(rp), intent(in) :: c(N_CHANGES)
    integer, intent(in) :: j
    real(rp), parameter :: H = 1.0e-5_rp
    complex(rp), dimension(0:2, N_COMPONENTS) :: above, below, slope
    real(rp) :: d(N_CHANGES)
    d = 0
    d(j) = H
    above = response%at(c + d)
    below = response%at(c - d)
    slope = response%derivative(c, j)
    call t%check('derivative is that of the approximation', maxval(abs((above - below)/(2*H) - slope)) < 1.0e-8_rp)
  end subroutine check_derivative

  !> The same force, without a wave, at all times and in all components; a tenth more on the finer grid, a fifth less in the larger
  !> box.
  subroutine fly(requests, records)
    type(flight_request_t), intent(in) :: requests(:)
    type(flight_record_t), allocatable, intent(out) :: records(:)
    integer :: i
    allocate (records(size(requests)))
    do i = 1, size(requests)
      records(i)%is_flown = .true.
      allocate (records(i)%values(N_PHASES, N_COMPONENTS), source=force(requests(i)%change))
      if (requests(i)%refinement == REFINE_GRID) records(i)%values = 1.1_rp*records(i)%values
      if (requests(i)%refinement == REFINE_BOX) records(i)%values = 0.8_rp*records(i)%values
    end do
  end subroutine fly

  pure real(rp) function force(change)
    real(rp), intent(in) :: change(N_FLOW)
    force = exp(change(FLOW_LEAD)) + 0.5_rp*sin(change(FLOW_VISCOSITY)) + 0.3_rp*sqrt(1 + change(FLOW_WALL))
  end function force

  real(rp) function error_at(response, c)
    type(flight_response_t), intent(in) :: response
    real(rp), intent(in) :: c(N_CHANGES)
    complex(rp) :: series(0:2, N_COMPONENTS)
    series = response%at(c)
    error_at = real(series(0, 1), rp) - force(c(:N_FLOW))
  end function error_at
end program test_flight_response

! SPDX-License-Identifier: GPL-3.0-or-later
!> Tells a user before anything is flown how many flights a diagnosis needs and how long they may take.
module diagnose_flight_cost
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_flights, only: flusi_runner_t
  use diagnosis_flight_catalogue, only: flight_steps
  use diagnosis_flight_changes, only: FLOW_STRUCTURE
  use diagnosis_flight_data, only: append_requests, flight_cases_t
  use diagnosis_flight_refinements, only: refinement_name, N_REFINEMENTS, NOT_REFINED, REFINE_GRID
  use diagnosis_flight_runner, only: flight_facts_t, flight_request_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: list_text, print_cost, print_wing_cost

contains

  !> Prints on `unit` how many flights are needed and how long they may take, and the same of `most_rounds` rounds with the fitted
  !> values that may follow. Not collective: rank 0 calls it.
  subroutine print_cost(unit, most_rounds, runner, data, world)
    integer, intent(in) :: unit, most_rounds
    type(flusi_runner_t), intent(inout) :: runner
    type(flight_cases_t), intent(in) :: data
    type(world_t), intent(in) :: world
    type(flight_request_t), allocatable :: all(:), of_rounds(:), requests(:)
    logical, allocatable :: missing(:), all_missing(:)
    real(rp), allocatable :: steps(:)
    logical :: of_grid(N_REFINEMENTS)
    character(:), allocatable :: turns
    integer :: ranks, n_groups, n_fitted, k
    ranks = ranks_of(runner, world)
    n_groups = world%size/ranks
    turns = number_text(n_groups)//' at a time on '//number_text(ranks)//' ranks each'
    allocate (all(0), of_rounds(0), all_missing(0))
    n_fitted = 0
    do k = 1, size(data%cases)
      associate (case => data%cases(k))
        steps = flight_steps(case%facts, data%effects)
        requests = case%response%requests(steps, case%refined)
        requests%case = k
        missing = runner%are_missing(requests)
        write (unit, '(a)') 'flights   '//number_text(size(requests))//' of '//case%facts%path//', of which '// &
          number_text(count(missing))//' are still to be simulated, '//turns
        if (any(case%refined)) &
          write (unit, '(a)') '          the case once, and with a smaller numerical error of each of these kinds '// &
          '(cost in flights of the case): '//list_text(case%refined, case%facts%cost)
        if (case%facts%n_first > 0) write (unit, '(a)') '          two for each of these parameters of the wing: '// &
          structure_names(case%facts)
        write (unit, '(a)') '          about '//number_text(nint(case%facts%steps))//' steps each, '// &
          time_text(seconds_of(data, requests, missing, n_groups)/ranks)//' for all, very roughly'
        call append_requests(all, requests, k)
        all_missing = [all_missing, missing]
        if (size(requests) == 1 + count(case%refined)) cycle
        of_grid = .false.
        of_grid(REFINE_GRID) = case%refined(REFINE_GRID)
        n_fitted = n_fitted + merge(2, 1, of_grid(REFINE_GRID))
        call append_requests(of_rounds, case%response%requests(one_step(steps), of_grid), k)
      end associate
    end do
    if (size(data%cases) > 1) write (unit, '(a)') '          of all '//number_text(size(data%cases))//' cases '// &
      number_text(size(all))//' flights, of which '//number_text(count(all_missing))//' are still to be simulated, '// &
      time_text(seconds_of(data, all, all_missing, n_groups)/ranks)//', very roughly'
    if (most_rounds == 0 .or. size(of_rounds) == 0) return
    write (unit, '(a)') '          then up to '//number_text(most_rounds)//' rounds if a cause is clear, each of '// &
      counted_flights(n_fitted)//' with the fitted values and up to '//number_text(2*count_sought(of_rounds))// &
      ' more for each of its parameters: '// &
      time_text(seconds_of(data, of_rounds, spread(.true., 1, size(of_rounds)), n_groups)/ranks)//' with one parameter'
  end subroutine print_cost

  !> Returns the names of the parameters of the structure, beside E and D, that the first flights of a case change.
  function structure_names(facts) result(names)
    type(flight_facts_t), intent(in) :: facts
    character(:), allocatable :: names
    integer :: k
    names = ''
    do k = 1, facts%n_first
      if (facts%missing(FLOW_STRUCTURE + k) == '') names = names//', '//facts%structure(k)%name
    end do
    names = names(3:)
  end function structure_names

  !> Returns how many cases these requests are for.
  pure integer function count_sought(requests) result(n)
    type(flight_request_t), intent(in) :: requests(:)
    integer :: i
    n = 0
    do i = 1, size(requests)
      if (all(requests(:i - 1)%case /= requests(i)%case)) n = n + 1
    end do
  end function count_sought

  !> Returns '1 flight', or '2 flights'.
  function counted_flights(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text
    text = number_text(n)//' flight'
    if (n /= 1) text = text//'s'
  end function counted_flights

  !> Returns how many ranks compute a flight.
  pure integer function ranks_of(runner, world) result(ranks)
    type(flusi_runner_t), intent(in) :: runner
    type(world_t), intent(in) :: world
    ranks = world%size
    if (runner%ranks > 0) ranks = min(ranks, runner%ranks)
  end function ranks_of

  !> Prints on `unit` how many flights the comparison of two wings needs at most, and how long they may take. Not collective.
  subroutine print_wing_cost(unit, directions, runner, data, world)
    integer, intent(in) :: unit, directions
    type(flusi_runner_t), intent(in) :: runner
    type(flight_cases_t), intent(in) :: data
    type(world_t), intent(in) :: world
    type(flight_request_t) :: requests(2 + 2*directions)
    integer :: ranks
    ranks = ranks_of(runner, world)
    associate (n => size(requests), facts => data%cases(1)%facts)
      write (unit, '(a)') 'flights   after the diagnosis, if a cause is found: '//facts%path//' with both wings, and up to '// &
        number_text(2*directions)//' times for what the fit leaves of the extended wing', &
        '          about '//number_text(nint(facts%steps))//' steps each, '// &
        time_text(seconds_of(data, requests, spread(.true., 1, n), world%size/ranks)/ranks)//' for the flow of all '// &
        number_text(n)//', very roughly; the bending of the wings comes on top'
    end associate
    flush (unit)
  end subroutine print_wing_cost

  !> Returns the first of the steps that are above 0 alone.
  pure function one_step(steps)
    real(rp), intent(in) :: steps(:)
    real(rp) :: one_step(size(steps))
    integer :: first
    one_step = 0
    first = findloc(steps > 0, .true., 1)
    if (first > 0) one_step(first) = steps(first)
  end function one_step

  !> Returns how long the flights that are missing take on one rank [s], if groups of ranks take turns in simulating them. A refined
  !> flight takes longer.
  pure real(rp) function seconds_of(data, requests, missing, n_groups) result(seconds)
    type(flight_cases_t), intent(in) :: data
    type(flight_request_t), intent(in) :: requests(:)
    logical, intent(in) :: missing(:)
    integer, intent(in) :: n_groups
    real(rp) :: busy(0:n_groups - 1)
    integer :: i, n
    busy = 0
    n = 0
    do i = 1, size(requests)
      if (.not. missing(i)) cycle
      associate (own => busy(modulo(n, n_groups)), facts => data%cases(requests(i)%case)%facts)
        if (requests(i)%refinement == NOT_REFINED) then
          own = own + facts%seconds
        else
          own = own + facts%seconds*facts%cost(requests(i)%refinement)
        end if
      end associate
      n = n + 1
    end do
    seconds = maxval(busy)
  end function seconds_of

  !> Returns the names of the wanted refinements, each with its value in one decimal.
  function list_text(wanted, values) result(text)
    logical, intent(in) :: wanted(N_REFINEMENTS)
    real(rp), intent(in) :: values(N_REFINEMENTS)
    character(:), allocatable :: text
    integer :: k
    text = ''
    do k = 1, N_REFINEMENTS
      if (.not. wanted(k)) cycle
      if (text /= '') text = text//', '
      text = text//refinement_name(k)//' '//number_text(nint(10*values(k))/10.0_rp)
    end do
  end function list_text

  !> Returns a duration, rounded up, in seconds, minutes or hours.
  function time_text(seconds) result(text)
    real(rp), intent(in) :: seconds
    character(:), allocatable :: text
    if (seconds < 120) then
      text = number_text(ceiling(seconds))//' s'
    else if (seconds < 7200) then
      text = number_text(ceiling(seconds/60))//' min'
    else
      text = number_text(ceiling(seconds/3600))//' h'
    end if
  end function time_text
end module diagnose_flight_cost

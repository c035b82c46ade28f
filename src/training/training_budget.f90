! SPDX-License-Identifier: GPL-3.0-or-later
!> Counts how many candidates a search may still evaluate, and what ends when none are left.
module training_budget
  use base_kinds, only: i8
  use cmaes_params, only: cmaes_params_t, derive_params
  use cmaes_search, only: cmaes_search_t, RESTARTS_NONE
  use cmaes_stop, only: RUNNING
  implicit none
  private
  public :: budget_t, find_budget

  type :: budget_t
    integer(i8) :: evaluations = 0  !< largest number of candidates
    logical :: is_of_search = .true. !< after them the whole search ends, not only the present run
  contains
    procedure :: subject => budget_subject
  end type budget_t

contains

  !> Finds the remaining budget of a search of which `n_coming` more stages follow with the same options. If max_generations ends
  !> a run before max_evaluations ends the search, restarts may follow: the budget is then that of the present run. The same holds
  !> if a coming stage may restart in this way.
  function find_budget(search, n_coming) result(budget)
    type(cmaes_search_t), intent(in) :: search
    integer, intent(in) :: n_coming
    type(budget_t) :: budget
    type(cmaes_params_t) :: first
    integer(i8) :: of_run, next_run
    associate (run => search%run, state => search%state, options => search%options)
      of_run = 0
      if (state%stop_code == RUNNING) then
        of_run = max(0_i8, min(state%run_limit - run%state%counts%evaluations, &
                               int(run%params%max_iterations - run%state%generation, i8)*run%params%lambda))
        if (may_restart(search, state%restart)) &
          budget%is_of_search = options%max_evaluations - search%evaluations() <= of_run
      end if
      budget%evaluations = of_run
      if (.not. budget%is_of_search .or. n_coming == 0) return
      ! No later stage has more unknowns than this one.
      first = derive_params(options, run%params%n)
      next_run = int(first%max_iterations, i8)*first%lambda
      if (may_restart(search, 0)) budget%is_of_search = options%max_evaluations <= next_run
      if (budget%is_of_search) budget%evaluations = of_run + n_coming*min(options%max_evaluations, next_run)
    end associate
  end function find_budget

  !> Tells whether a run may follow run `number`, from 0.
  pure logical function may_restart(search, number)
    type(cmaes_search_t), intent(in) :: search
    integer, intent(in) :: number
    may_restart = search%restarts /= RESTARTS_NONE .and. number < search%max_restarts
  end function may_restart

  !> Returns 'the search' or 'this run'.
  pure function budget_subject(self) result(words)
    class(budget_t), intent(in) :: self
    character(:), allocatable :: words
    words = trim(merge('the search', 'this run  ', self%is_of_search))
  end function budget_subject
end module training_budget

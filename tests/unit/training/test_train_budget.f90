! SPDX-License-Identifier: GPL-3.0-or-later
!> How many candidates a search may still evaluate: with a second stage to come, and with restarts.
program test_train_budget
  use base_kinds, only: i8, rp
  use cmaes_options, only: cmaes_options_t
  use cmaes_search, only: cmaes_search_t, start_region_t, RESTARTS_IPOP, RESTARTS_NONE
  use testkit, only: testkit_t
  use training_budget, only: budget_t, find_budget
  implicit none
  integer, parameter :: LAMBDA = 8, GENERATIONS = 10, N = 3
  integer(i8), parameter :: ONE = LAMBDA, RUN = LAMBDA*GENERATIONS
  type(testkit_t) :: t
  type(cmaes_search_t) :: search

  call t%start(parallel=.false.)
  call begin(RESTARTS_NONE, 0, huge(1_i8))
  call expect('a run by its generations', 0, RUN, 'the search')
  call expect('with a stage to come', 1, 2*RUN, 'the search')
  call make_generations(1)
  call expect('less by a generation', 1, 2*RUN - ONE, 'the search')
  call make_generations(GENERATIONS - 1)
  call expect('at the end of the first stage the second is left', 1, RUN, 'the search')
  call expect('behind the last stage nothing is left', 0, 0_i8, 'the search')

  call begin(RESTARTS_NONE, 0, 60_i8)
  call make_generations(1)
  call expect('max_evaluations counts in each stage', 1, 60 - ONE + 60, 'the search')

  call begin(RESTARTS_IPOP, 2, huge(1_i8))
  call make_generations(1)
  call expect('restarts may follow', 0, RUN - ONE, 'this run')
  call expect('and a stage', 1, RUN - ONE, 'this run')
  call make_generations(GENERATIONS - 1)
  call expect('a restart has twice the population', 0, 2*RUN, 'this run')
  call make_generations(GENERATIONS)
  call expect('the last one ends the search', 0, 4*RUN, 'the search')
  call expect('but not that of a stage to come', 1, 4*RUN, 'this run')

  call begin(RESTARTS_IPOP, 9, 200_i8)
  call expect('generations end the run first', 0, RUN, 'this run')
  call make_generations(GENERATIONS + 1)
  call expect('evaluations are nearer, and end the search', 0, 200 - RUN - 2*ONE, 'the search')
  call begin(RESTARTS_IPOP, 9, 60_i8)
  call expect('evaluations end both stages before any restart', 1, 120_i8, 'the search')
  call t%finish()

contains

  subroutine begin(restarts, max_restarts, max_evaluations)
    integer, intent(in) :: restarts
    integer, intent(in) :: max_restarts
    integer(i8), intent(in) :: max_evaluations
    type(cmaes_options_t) :: options
    type(start_region_t) :: region
    options%lambda = LAMBDA
    options%max_iterations = GENERATIONS
    options%max_evaluations = max_evaluations
    allocate (region%lower(N), source=0.0_rp)
    allocate (region%upper(N), source=1.0_rp)
    region%is_box = .true.
    call search%start(options, restarts, max_restarts, region)
  end subroutine begin

  !> Costs that no criterion but the budget ends.
  subroutine make_generations(n_generations)
    integer, intent(in) :: n_generations
    real(rp), allocatable :: x(:, :)
    integer :: i
    do i = 1, n_generations
      call search%ask(x)
      call search%tell(1 + sum((x - 0.4_rp)**2, 1))
    end do
  end subroutine make_generations

  subroutine expect(sentence, n_coming, evaluations, subject)
    character(*), intent(in) :: sentence, subject
    integer, intent(in) :: n_coming
    integer(i8), intent(in) :: evaluations
    type(budget_t) :: budget
    budget = find_budget(search, n_coming)
    call t%check(sentence, budget%evaluations == evaluations .and. budget%subject() == subject)
  end subroutine expect
end program test_train_budget

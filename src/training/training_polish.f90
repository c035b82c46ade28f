! SPDX-License-Identifier: GPL-3.0-or-later
!> Refines the result of the search by least squares with exact derivatives, finds what the data say about every parameter, and
!> solves the final point cold. On rank 0; the others serve the pool.
module training_polish
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use base_text, only: number_text
  use cmaes_box, only: bound_side
  use least_squares_continuation, only: fit_by_continuation
  use least_squares_fit, only: fit_report_t
  use least_squares_posterior, only: find_posterior, posterior_t
  use least_squares_problem, only: unknowns_t
  use least_squares_profile, only: interval_t, profile_interval, profile_sentence, THRESHOLD_90
  use least_squares_state, only: solver_state_t
  use measurement_evaluation, only: evaluation_t
  use measurement_experiment, only: experiment_t
  use measurement_problem, only: wing_problem_t, wing_unknowns
  use training_case, only: training_case_t
  use training_pool, only: worker_pool_t
  use training_agreement, only: agreement_lines, AGREEMENT_LENGTH
  use training_listener, only: training_listener_t
  use training_objective, only: full_results, train_objective_t
  use training_space, only: search_space_t
  implicit none
  private
  public :: pool_problem_t, trained_t, polish_points, make_unknowns, interval_sentence, left_out_names

  real(rp), parameter :: AT_BOUND = 1.0e-3_rp !< of the box's side: nearer to a bound is at it

  !> The problem of least squares whose loads are solved by the pool. With a log it tells how far it is.
  type, extends(wing_problem_t) :: pool_problem_t
    type(worker_pool_t), pointer :: pool => null()
    class(training_listener_t), pointer :: log => null()
    integer :: part = 0, n_parts = 0         !< the present start or interval, of so many
    character(:), allocatable :: name        !< of the parameter whose interval is sought, if one is
    integer :: n_solved = 0                  !< points so far
    real(rp) :: lowest = huge(1.0_rp)        !< chi^2 from the present start
    real(rp), private :: begun = 0           !< [s] wall time of the first start or interval
  contains
    procedure :: run => problem_run
  end type pool_problem_t

  !> The outcome of a training.
  type :: trained_t
    real(rp), allocatable :: coordinates(:)  !< of the experiment
    real(rp), allocatable :: values(:)       !< of the unknowns, in their units
    integer, allocatable :: sides(:)         !< (unknowns) -1 or 1: the value is at the lower or upper bound of its box
    logical :: is_cold = .false.             !< all solutions of the polish were cold
    logical :: is_polished = .false.         !< least squares came to its end, and what follows is known
    character(:), allocatable :: reason      !< why least squares ended; not allocated if they were not asked for
    real(rp), allocatable :: path(:, :)      !< of least squares, see fit_by_continuation
    real(rp), allocatable :: local_minima(:, :)      !< (1 + unknowns, starts) chi^2 and coordinates where each start ended
    type(posterior_t) :: posterior
    real(rp), allocatable :: prior_sd(:)     !< of the coordinates that the posterior belongs to; 0: nothing was known
    logical :: has_intervals = .false.
    type(interval_t), allocatable :: intervals(:)
    logical, allocatable :: is_left_out(:, :) !< (loads, unknowns) the load does not count in the interval, as it jumps
    logical :: is_solved = .false.           !< all shapes were found cold, and lie in no excluded zone
    type(evaluation_t), allocatable :: evaluations(:) !< (loads) of the cold solution
    real(rp) :: h = 0                        !< [m] of the cold solution
    real(rp) :: chi2 = 0
    logical :: fits = .false.                !< within the declared errors: chi2 is no more than three sd too large
    real(rp) :: cold_difference = 0          !< [m] largest distance of a point between warm and cold solution
    integer :: n_evaluations = 0             !< points at which all loads were solved
  contains
    procedure :: determines => trained_determines
    procedure :: has_failed_polish => trained_has_failed_polish
    procedure :: bound => trained_bound
  end type trained_t

contains

  !> Whether the data determine unknown i: its interval has two ends, or, if intervals were not asked, the data take
  !> away half of the standard deviation that it had before, and it is not its box that holds it. A polish that failed
  !> determines nothing. If none was asked for, true but at a bound.
  pure logical function trained_determines(self, i) result(is_determined)
    class(trained_t), intent(in) :: self
    integer, intent(in) :: i
    if (self%has_intervals) then
      is_determined = self%intervals(i)%has_lower .and. self%intervals(i)%has_upper
      return
    end if
    is_determined = self%bound(i) == 0 .and. .not. self%has_failed_polish()
    if (.not. self%is_polished) return
    if (self%prior_sd(i) > 0) is_determined = is_determined .and. self%posterior%sd(i) <= self%prior_sd(i)/2
  end function trained_determines

  !> Whether a polish was asked for, but least squares accepted no step, so that nothing is known but the search's point.
  pure logical function trained_has_failed_polish(self) result(has_failed)
    class(trained_t), intent(in) :: self
    has_failed = allocated(self%reason) .and. .not. self%is_polished
  end function trained_has_failed_polish

  !> -1, 0 or 1: unknown i is at the lower bound of its box, inside, at the upper one.
  pure integer function trained_bound(self, i) result(side)
    class(trained_t), intent(in) :: self
    integer, intent(in) :: i
    side = 0
    if (allocated(self%sides)) side = self%sides(i)
  end function trained_bound

  !> See `wing_problem_t`.
  subroutine problem_run(self, p)
    class(pool_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    type(evaluation_t), allocatable :: evaluations(:)
    real(rp), allocatable :: shapes(:, :, :)
    call self%pool%poll()
    call full_results(self%experiment, self%pool, p, self%is_start .and. .not. self%is_cold, self%shapes, &
                      evaluations, shapes, self%is_left_out)
    call move_alloc(evaluations, self%evaluations)
    call move_alloc(shapes, self%trial_shapes)
    if (associated(self%log)) call tell_progress(self)
  end subroutine problem_run

  subroutine tell_progress(self)
    type(pool_problem_t), intent(inout) :: self
    real(rp) :: chi2
    integer :: l
    self%n_solved = self%n_solved + 1
    if (allocated(self%name)) then
      call self%log%interval_progress(self%name, self%part - 1, self%n_parts, self%n_solved, self%begun)
      return
    end if
    chi2 = 0
    do l = 1, size(self%evaluations)
      if (.not. self%evaluations(l)%is_feasible()) chi2 = huge(chi2)
      if (.not. chi2 < huge(chi2)) exit
      chi2 = chi2 + sum((self%evaluations(l)%residuals/self%experiment%comparisons(l)%sigma)**2)
    end do
    self%lowest = min(self%lowest, chi2)
    call self%log%polish_progress(self%part, self%n_parts, self%n_solved, self%lowest, self%begun)
  end subroutine tell_progress

  !> The box and the priors about the values of [Wing], as coordinates of the experiment.
  function make_unknowns(settings, space) result(unknowns)
    class(training_case_t), intent(in) :: settings
    type(search_space_t), intent(in) :: space
    type(unknowns_t) :: unknowns
    real(rp) :: lower(size(space%is_log)), upper(size(space%is_log))
    lower = space%box%lower
    upper = space%box%upper
    where (space%is_log)
      lower = log(merge(lower, 1.0_rp, space%is_log))
      upper = log(merge(upper, 1.0_rp, space%is_log))
    end where
    unknowns = wing_unknowns(settings%experiment, max(lower, min(upper, settings%experiment%start())), &
                             settings%prior_decades)
    unknowns%lower = lower
    unknowns%upper = upper
  end function make_unknowns

  !> From points of the search, starts(unknowns, :) as coordinates of the experiment, the best first, to the outcome.
  !> The first is polished by continuation, which leads to one point from nearly all starts. Others are tried as long as
  !> what was found does not fit within the errors, and while polishing has cost fewer evaluations than the search;
  !> with the declared errors at once, so that they may end elsewhere, which is told. If the pool is stopped afterwards
  !> the outcome is not complete.
  subroutine polish_points(settings, pool, space, objective, starts, log, trained)
    class(training_case_t), intent(in), target :: settings
    type(worker_pool_t), intent(inout), target :: pool
    type(search_space_t), intent(in) :: space
    type(train_objective_t), intent(in) :: objective
    real(rp), intent(in) :: starts(:, :)
    class(training_listener_t), intent(inout), target :: log
    type(trained_t), intent(out) :: trained
    type(pool_problem_t) :: problem
    type(unknowns_t) :: unknowns
    type(trained_t) :: one
    real(rp), allocatable :: local_minima(:, :)
    real(rp) :: n_residuals
    integer :: i, n_evaluations
    call problem%init(settings%experiment)
    problem%pool => pool
    if (settings%polish) problem%log => log
    problem%n_parts = size(starts, 2)
    problem%begun = wall_seconds()
    unknowns = make_unknowns(settings, space)
    n_residuals = problem%n_residuals
    n_evaluations = 0
    allocate (local_minima(1 + size(starts, 1), 0))
    do i = 1, merge(size(starts, 2), 1, settings%polish)
      problem%part = i
      problem%lowest = huge(1.0_rp)
      call polish_from_start(settings, problem, unknowns, objective, starts(:, i), i == 1, trained%fits, log, one)
      if (pool%is_stopped) return
      n_evaluations = n_evaluations + one%n_evaluations
      if (i == 1 .or. is_better(one, trained)) trained = one
      if (one%is_solved) local_minima = reshape([local_minima, one%chi2, one%coordinates], &
                                                [size(local_minima, 1), size(local_minima, 2) + 1])
      trained%fits = trained%is_solved .and. trained%chi2 <= n_residuals + 3*sqrt(2*n_residuals)
      if (trained%fits .and. n_evaluations*size(settings%experiment%loads) > objective%n_warm + objective%n_cold) exit
    end do
    trained%local_minima = local_minima
    if (trained%is_polished .and. trained%is_solved) call report_start_agreement(space, trained, log)
    trained%n_evaluations = n_evaluations
    trained%values = trained%coordinates
    where (space%is_log) trained%values = exp(merge(trained%coordinates, 0.0_rp, space%is_log))
    trained%sides = bound_side(space%box%coordinate(trained%values), AT_BOUND)
    if (trained%is_polished .and. trained%is_solved .and. settings%intervals) then
      problem%is_cold = trained%is_cold
      problem%is_start = .false.
      call problem%solve(trained%coordinates)
      call problem%accept()
      call find_intervals(settings, pool, problem, unknowns, space, log, trained)
    end if
    call problem%free()
  end subroutine polish_points

  !> Says whether all starts came to the same end, and what those tell that did not.
  subroutine report_start_agreement(space, trained, log)
    type(search_space_t), intent(in) :: space
    type(trained_t), intent(in) :: trained
    class(training_listener_t), intent(inout) :: log
    character(AGREEMENT_LENGTH), allocatable :: lines(:)
    integer :: i
    lines = agreement_lines(space%names, trained%coordinates, trained%chi2, trained%posterior%sd, trained%local_minima)
    do i = 1, size(lines)
      call log%say(trim(lines(i)))
    end do
  end subroutine report_start_agreement

  pure logical function is_better(one, other)
    type(trained_t), intent(in) :: one, other
    is_better = one%is_solved .and. (.not. other%is_solved .or. one%chi2 < other%chi2)
  end function is_better

  !> From one point to an outcome, by continuation if `has_stages`. A wing that snaps has several shapes, of which warm
  !> solutions may follow a wrong one: if the cold solution of the end is another shape, the fit goes on from there; if
  !> that ends in the same way, it is repeated with every solution cold. Not so a start that `is_check` only.
  subroutine polish_from_start(settings, problem, unknowns, objective, start, has_stages, is_check, log, trained)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    type(train_objective_t), intent(in) :: objective
    real(rp), intent(in) :: start(:)
    logical, intent(in) :: has_stages, is_check
    class(training_listener_t), intent(inout) :: log
    type(trained_t), intent(out) :: trained
    real(rp), parameter :: SAME = 1.0e-4_rp !< of the wing's size: shapes that differ more are two shapes
    integer, parameter :: LAST = 3
    real(rp), allocatable :: from(:)
    integer :: n_evaluations, attempt
    n_evaluations = 0
    do attempt = 1, LAST
      from = start
      if (attempt == 2) from = trained%coordinates
      problem%is_cold = attempt == LAST
      problem%is_start = .false.
      trained = trained_t()
      trained%is_cold = problem%is_cold
      trained%coordinates = from
      if (settings%polish) call polish_once(settings, problem, unknowns, from, has_stages .and. attempt /= 2, log, &
                                            trained)
      if (problem%pool%is_stopped) return
      if (.not. trained%is_polished) then ! the search's own solution, warm from its mean
        problem%shapes = objective%shapes
        problem%is_start = objective%is_start
        call problem%solve(trained%coordinates)
        call problem%accept()
      end if
      call solve_cold(problem, trained)
      if (problem%pool%is_stopped) return
      n_evaluations = n_evaluations + trained%n_evaluations + 1
      if (is_check .or. .not. settings%polish .or. attempt == LAST) exit
      if (trained%cold_difference <= SAME*settings%experiment%model%size) exit
      call log%say('          its cold solution is another shape: the wing snaps. '// &
                   trim(merge('It goes on from there        ', 'All loads are now solved cold', attempt == 1)))
    end do
    trained%n_evaluations = n_evaluations
  end subroutine polish_from_start

  !> One fit from a point, and what it tells, in `trained`.
  subroutine polish_once(settings, problem, unknowns, from, has_stages, log, trained)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    real(rp), intent(in) :: from(:)
    logical, intent(in) :: has_stages
    class(training_listener_t), intent(inout) :: log
    type(trained_t), intent(inout) :: trained
    type(fit_report_t) :: report
    real(rp), allocatable :: path(:, :)
    call fit_by_continuation(problem, unknowns, from, settings%fit, has_stages, report, path)
    if (problem%pool%is_stopped) return
    trained%n_evaluations = report%n_evaluations
    trained%reason = report%reason
    trained%path = path
    trained%is_polished = report%is_converged .or. report%n_accepted > 0
    call log%say('polish    '//counted(report%n_evaluations, 'evaluation')//', '// &
                 counted(count_stages(path), 'stage')// &
                 trim(merge(', all cold; ', ';           ', trained%is_cold))//' '//report%reason)
    if (.not. trained%is_polished) return
    trained%coordinates = report%p
    trained%posterior = find_posterior(unknowns, report)
    trained%prior_sd = unknowns%prior_sd
  end subroutine polish_once

  !> '1 stage', '2 stages'.
  function counted(n, thing) result(text)
    integer, intent(in) :: n
    character(*), intent(in) :: thing
    character(:), allocatable :: text
    text = number_text(n)//' '//thing
    if (n /= 1) text = text//'s'
  end function counted

  !> Stages of a path, see fit_by_continuation.
  pure integer function count_stages(path) result(n)
    real(rp), intent(in) :: path(:, :)
    integer :: last
    last = size(path, 2)
    n = min(1, last) + count(path(4, 2:) < path(4, :last - 1))
  end function count_stages

  !> The final point without any warm start.
  subroutine solve_cold(problem, trained)
    type(pool_problem_t), intent(inout) :: problem
    type(trained_t), intent(inout) :: trained
    real(rp), allocatable :: residuals(:)
    integer :: l
    call problem%cold_difference(trained%coordinates, trained%cold_difference)
    trained%evaluations = problem%evaluations
    trained%is_solved = .true.
    allocate (residuals(0))
    do l = 1, size(trained%evaluations)
      associate (evaluation => trained%evaluations(l))
        trained%is_solved = trained%is_solved .and. evaluation%is_feasible()
        residuals = [residuals, evaluation%residuals]
        trained%chi2 = trained%chi2 + sum((evaluation%residuals/problem%experiment%comparisons(l)%sigma)**2)
      end associate
    end do
    trained%h = problem%experiment%cost(residuals)
  end subroutine solve_cold

  !> 90 % intervals of all unknowns, each from all loads but those that jump between its ends.
  subroutine find_intervals(settings, pool, problem, unknowns, space, log, trained)
    class(training_case_t), intent(in) :: settings
    type(worker_pool_t), intent(in) :: pool
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    type(search_space_t), intent(in) :: space
    class(training_listener_t), intent(inout) :: log
    type(trained_t), intent(inout) :: trained
    class(solver_state_t), allocatable :: at_end
    integer :: i, l
    call problem%get_state(at_end)
    problem%n_parts = size(trained%coordinates)
    problem%begun = wall_seconds()
    allocate (trained%intervals(size(trained%coordinates)))
    allocate (trained%is_left_out(size(problem%is_left_out), size(trained%coordinates)))
    do i = 1, size(trained%coordinates)
      call problem%set_state(at_end)
      problem%is_left_out = .false.
      problem%part = i
      problem%name = trim(space%names(i))
      call profile_interval(problem, unknowns, trained%coordinates, i, trained%posterior%sd(i), THRESHOLD_90, &
                            settings%fit, trained%intervals(i))
      if (pool%is_stopped) return
      trained%n_evaluations = trained%n_evaluations + trained%intervals(i)%n_evaluations
      trained%is_left_out(:, i) = problem%is_left_out
      call log%say('          '//interval_sentence(settings%experiment, space, trained, i))
    end do
    trained%has_intervals = .true.
    do l = 1, size(problem%is_left_out)
      i = count(trained%is_left_out(l, :))
      if (i > 0) call log%say('warning   the shape under '//settings%experiment%measurement%loads(l)%name// &
                              ' jumps: it is left out of '//counted(i, 'interval'))
    end do
  end subroutine find_intervals

  !> What can be said about parameter i, and from which loads alone.
  function interval_sentence(experiment, space, trained, i) result(sentence)
    type(experiment_t), intent(in) :: experiment
    type(search_space_t), intent(in) :: space
    type(trained_t), intent(in) :: trained
    integer, intent(in) :: i
    character(:), allocatable :: sentence, names
    sentence = profile_sentence(trim(space%names(i)), trim(space%units(i)), space%is_log(i), trained%intervals(i))
    names = left_out_names(experiment, trained, i)
    if (names /= '') sentence = sentence//'; without '//names//', where the shape snaps as the parameter moves'
  end function interval_sentence

  !> Names of the loads that do not count in interval i, with a blank between them; empty if all count.
  function left_out_names(experiment, trained, i) result(names)
    type(experiment_t), intent(in) :: experiment
    type(trained_t), intent(in) :: trained
    integer, intent(in) :: i
    character(:), allocatable :: names
    integer :: l
    names = ''
    do l = 1, size(trained%is_left_out, 1)
      if (trained%is_left_out(l, i)) names = names//' '//experiment%measurement%loads(l)%name
    end do
    names = trim(adjustl(names))
  end function left_out_names
end module training_polish

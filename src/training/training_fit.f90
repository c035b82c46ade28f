! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes one fit from one point to an outcome: least squares, and then the solution of its final point from the unloaded wing. On
!> rank 0.
module training_fit
  use base_kinds, only: rp
  use base_text, only: number_text
  use least_squares_continuation, only: fit_by_continuation
  use least_squares_fit, only: fit_report_t
  use least_squares_posterior, only: find_posterior
  use least_squares_problem, only: unknowns_t
  use least_squares_state, only: solver_state_t
  use measurement_bending_state, only: bending_state_t
  use measurement_problem, only: wing_point_t
  use training_case, only: training_case_t
  use training_listener, only: training_listener_t
  use training_outcome, only: trained_t
  use training_pool_problem, only: pool_problem_t
  implicit none
  private
  public :: counted, is_better, join_paths, polish_from_start, solve_again, start_t

  !> The start of a fit, and its method.
  type :: start_t
    real(rp), allocatable :: coordinates(:)
    logical :: has_stages = .false. !< it approaches the measured forces by continuation
    logical :: is_check = .false.   !< it only shows whether other starts end at the same minimum
  end type start_t

contains

  !> Fits from one start to an outcome. A wing that snaps has several shapes, and warm solutions, which begin at the shape of an
  !> earlier point, may follow a wrong one. If the cold solution of the final point, which begins at the unloaded wing, is another
  !> shape, the fit continues from there. If the second fit ends in the same way, a third one makes every solution cold. A start
  !> that only checks other starts is fitted once. `trained` is the outcome, with all evaluations counted; it is incomplete if the
  !> pool was stopped. On rank 0, while the other ranks serve the pool.
  subroutine polish_from_start(settings, problem, unknowns, mean_state, start, log, trained)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    type(bending_state_t), intent(in) :: mean_state !< of the search
    type(start_t), intent(in) :: start
    class(training_listener_t), intent(inout) :: log
    type(trained_t), intent(out) :: trained
    real(rp), parameter :: SAME = 1.0e-4_rp !< of the wing's size: shapes that differ by more are two shapes
    integer, parameter :: LAST = 3
    class(solver_state_t), allocatable :: state
    real(rp), allocatable :: from(:), path(:, :)
    integer :: n_evaluations, attempt
    logical :: has_snapped
    n_evaluations = 0
    has_snapped = .false.
    do attempt = 1, LAST
      from = start%coordinates
      if (attempt == 2) from = trained%coordinates
      problem%is_cold = attempt == LAST
      trained = trained_t()
      trained%is_cold = problem%is_cold
      trained%coordinates = from
      if (settings%polish) call polish_once(settings, problem, unknowns, from, start%has_stages .and. attempt /= 2, &
                                            log, trained, state)
      if (problem%pool%is_stopped) return
      if (.not. trained%is_polished) call solve_near_mean(problem, mean_state, trained%coordinates, state)
      call solve_cold(problem, state, trained)
      if (problem%pool%is_stopped) return
      if (.not. trained%is_polished) trained%prior_chi2 = sum(((trained%coordinates - unknowns%prior)/ &
        merge(unknowns%prior_sd, 1.0_rp, unknowns%prior_sd > 0))**2, unknowns%prior_sd > 0 .and. .not. unknowns%is_fixed)
      if (allocated(trained%path)) call join_paths(path, trained%path, n_evaluations)
      n_evaluations = n_evaluations + trained%n_evaluations + 1
      has_snapped = has_snapped .or. (trained%is_polished .and. trained%is_solved .and. &
                                      trained%cold_difference > SAME*settings%experiment%model%size)
      if (start%is_check .or. .not. settings%polish .or. attempt == LAST) exit
      if (trained%cold_difference <= SAME*settings%experiment%model%size) exit
      call log%say('          the solution from the unloaded wing has another shape, because the wing snaps. '// &
                   trim(merge('The fit continues from this solution                ', &
                              'The next fit solves all loads from the unloaded wing', attempt == 1)))
    end do
    trained%n_evaluations = n_evaluations
    trained%has_snapped = has_snapped
    if (allocated(path)) call move_alloc(path, trained%path)
  end subroutine polish_from_start

  !> Appends the path `next` of a fit to the path of those before it, which took n evaluations and may have no path.
  pure subroutine join_paths(path, next, n)
    real(rp), allocatable, intent(inout) :: path(:, :)
    real(rp), intent(in) :: next(:, :)
    integer, intent(in) :: n
    integer :: before
    before = 0
    if (allocated(path)) before = size(path, 2)
    if (before == 0) then
      path = next
    else
      path = reshape([path, next], [size(next, 1), before + size(next, 2)])
    end if
    path(1, before + 1:) = path(1, before + 1:) + n
  end subroutine join_paths

  !> Solves the loads of an outcome again from the unloaded wing, which gives its evaluations.
  subroutine solve_again(problem, trained)
    type(pool_problem_t), intent(inout) :: problem
    type(trained_t), intent(inout) :: trained
    type(wing_point_t) :: cold
    call problem%solve(trained%coordinates, problem%initial_state(), cold)
    call move_alloc(cold%evaluations, trained%evaluations)
  end subroutine solve_again

  !> Makes one fit from a point, at which solutions begin at the unloaded wing, and puts its results into `trained`. `state` is the
  !> state of the solver at its final point.
  subroutine polish_once(settings, problem, unknowns, from, has_stages, log, trained, state)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    real(rp), intent(in) :: from(:)
    logical, intent(in) :: has_stages
    class(training_listener_t), intent(inout) :: log
    type(trained_t), intent(inout) :: trained
    class(solver_state_t), allocatable, intent(out) :: state
    type(fit_report_t) :: report
    real(rp), allocatable :: path(:, :)
    call fit_by_continuation(problem, unknowns, from, problem%initial_state(), settings%fit, has_stages, report, path)
    if (problem%pool%is_stopped) return
    trained%n_evaluations = report%n_evaluations
    trained%reason = report%reason
    trained%path = path
    trained%is_polished = report%is_converged .or. report%n_accepted > 0
    call log%say('polish    '//counted(report%n_evaluations, 'evaluation')//', '// &
                 counted(count_stages(path), 'stage')// &
                 trim(merge(', all from the unloaded wing; ', ';                             ', trained%is_cold))//' '// &
                 report%reason)
    if (.not. trained%is_polished) return
    trained%coordinates = report%p
    trained%prior_chi2 = report%prior_chi2
    trained%posterior = find_posterior(unknowns, report)
    trained%prior_sd = unknowns%prior_sd
    call move_alloc(report%state, state)
  end subroutine polish_once

  !> Repeats the search's own solution of a point, warm from its mean.
  subroutine solve_near_mean(problem, mean_state, coordinates, state)
    type(pool_problem_t), intent(inout) :: problem
    type(bending_state_t), intent(in) :: mean_state
    real(rp), intent(in) :: coordinates(:)
    class(solver_state_t), allocatable, intent(out) :: state
    type(wing_point_t) :: mean
    type(wing_point_t), allocatable :: at
    mean = problem%initial_state()
    call mean%take_shapes(mean_state)
    allocate (at)
    call problem%solve(coordinates, mean, at)
    call move_alloc(at, state)
  end subroutine solve_near_mean

  !> Solves the final point without any warm start, and compares with the warm shapes of `state`.
  subroutine solve_cold(problem, state, trained)
    type(pool_problem_t), intent(inout) :: problem
    class(solver_state_t), intent(in) :: state
    type(trained_t), intent(inout) :: trained
    type(wing_point_t) :: cold
    real(rp), allocatable :: residuals(:)
    integer :: l
    call problem%solve_cold(trained%coordinates, state, cold, trained%cold_difference)
    call move_alloc(cold%evaluations, trained%evaluations)
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

  !> Tells whether `one` is the better end of two fits: all its shapes were found, and those of the other were not; or its sum of
  !> squares, chi^2 and priors, is lower.
  pure logical function is_better(one, other)
    type(trained_t), intent(in) :: one, other
    is_better = one%is_solved .and. (.not. other%is_solved .or. one%cost() < other%cost())
  end function is_better

  !> Returns a number with its noun: '1 stage', '2 stages'.
  function counted(n, thing) result(text)
    integer, intent(in) :: n
    character(*), intent(in) :: thing
    character(:), allocatable :: text
    text = number_text(n)//' '//thing
    if (n /= 1) text = text//'s'
  end function counted

  !> Counts the stages of a path, see fit_by_continuation.
  pure integer function count_stages(path) result(n)
    real(rp), intent(in) :: path(:, :)
    integer :: last
    last = size(path, 2)
    n = min(1, last) + count(path(4, 2:) < path(4, :last - 1))
  end function count_stages
end module training_fit

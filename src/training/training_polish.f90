! SPDX-License-Identifier: GPL-3.0-or-later
!> Refines the result of the search by least squares with exact derivatives, finds what the data tell about every parameter, and
!> solves the final point from the unloaded wing. Rank 0 does this while the other ranks serve the pool.
module training_polish
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use cmaes_box, only: bound_side
  use least_squares_problem, only: unknowns_t
  use least_squares_state, only: solver_point_t
  use measurement_bending_pool, only: bending_pool_t
  use measurement_problem, only: wing_point_t
  use training_agreement, only: agreement_lines, AGREEMENT_LENGTH
  use training_case, only: training_case_t
  use training_fit, only: is_better, join_paths, polish_from_start, solve_again, start_t
  use training_intervals, only: find_intervals
  use training_listener, only: training_listener_t
  use training_moves, only: try_moves
  use training_outcome, only: trained_t
  use training_pool_problem, only: make_unknowns, pool_problem_t
  use training_search, only: train_search_t
  use training_space, only: search_space_t
  implicit none
  private
  public :: polish_points

  real(rp), parameter :: AT_BOUND = 1.0e-3_rp !< of the box's side: a value nearer to a bound than this is at the bound

contains

  !> Finds the outcome from points of the search, starts(unknowns, :), which are coordinates of the experiment, the best one first.
  !> Then moves search for a lower minimum, if wanted (training_moves). If the checkpoint from which the search continued has moves
  !> of the same polish, it continues with these. The outcome is not complete if the pool is stopped, or if search%failure says that
  !> files failed.
  subroutine polish_points(settings, pool, search, starts, log, trained)
    class(training_case_t), intent(in), target :: settings
    type(bending_pool_t), intent(inout), target :: pool
    type(train_search_t), intent(inout) :: search
    real(rp), intent(in) :: starts(:, :)
    class(training_listener_t), intent(inout), target :: log
    type(trained_t), intent(out) :: trained
    type(pool_problem_t) :: problem
    type(unknowns_t) :: unknowns
    real(rp), allocatable :: local_minima(:, :)
    call problem%init(settings%experiment)
    problem%pool => pool
    if (settings%polish) problem%log => log
    unknowns = make_unknowns(settings, search%space)
    associate (moves => search%moves, space => search%space)
      if (moves%is_of(settings)) then
        call log%say('restart   continues after '//moves%text())
        call solve_again(problem, moves%trained)
        trained = moves%trained
      else
        call polish_starts(settings, problem, unknowns, search, starts, log, trained, local_minima)
        if (.not. pool%is_stopped) call moves%begin(settings, trained, local_minima)
      end if
      if (pool%is_stopped) return
      if (settings%moves .and. trained%is_polished .and. trained%is_solved) then
        call try_moves(settings, problem, unknowns, search, log)
        if (pool%is_stopped .or. search%failure%failed) return
        trained = moves%trained
        trained%fits = fits_within_errors(trained, problem%n_residuals)
      end if
      trained%local_minima = moves%local_minima
      trained%n_evaluations = moves%n_evaluations
      if (trained%is_polished .and. trained%is_solved) call report_start_agreement(space, trained, log)
      trained%values = trained%coordinates
      where (space%is_log) trained%values = exp(merge(trained%coordinates, 0.0_rp, space%is_log))
      trained%sides = bound_side(space%box%coordinate(trained%values), AT_BOUND)
      if (trained%is_polished .and. trained%is_solved .and. settings%intervals) then
        problem%is_cold = trained%is_cold
        call find_intervals(settings, problem, unknowns, space, solved_at(problem, trained%coordinates), log, trained)
      end if
    end associate
    call problem%free()
  end subroutine polish_points

  !> Fits from each of starts(unknowns, :). The first start is polished by continuation, which leads to the same point from nearly
  !> all starts. Further starts are tried as long as the result does not fit within the errors and polishing has cost fewer
  !> evaluations than the search. They use the declared errors from the beginning, so that they may end elsewhere; the log then says
  !> so. `trained` is the best end, with path and evaluations of all fits. If the pool is stopped it is not complete.
  subroutine polish_starts(settings, problem, unknowns, search, starts, log, trained, local_minima)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    type(train_search_t), intent(in) :: search
    real(rp), intent(in) :: starts(:, :)
    class(training_listener_t), intent(inout) :: log
    type(trained_t), intent(out) :: trained
    real(rp), allocatable, intent(out) :: local_minima(:, :) !< see trained_t
    type(trained_t) :: one
    real(rp), allocatable :: path(:, :)
    integer :: i, n_evaluations
    logical :: has_snapped
    has_snapped = .false.
    problem%n_parts = size(starts, 2)
    problem%kind_of_part = 'start'
    problem%begun = wall_seconds()
    n_evaluations = 0
    allocate (local_minima(1 + size(starts, 1), 0))
    do i = 1, merge(size(starts, 2), 1, settings%polish)
      problem%part = i
      problem%lowest = huge(1.0_rp)
      call polish_from_start(settings, problem, unknowns, search%mean_state, start_t(starts(:, i), i == 1, trained%fits), log, one)
      if (problem%pool%is_stopped) return
      if (allocated(one%path)) call join_paths(path, one%path, n_evaluations)
      n_evaluations = n_evaluations + one%n_evaluations
      has_snapped = has_snapped .or. one%has_snapped
      if (i == 1 .or. is_better(one, trained)) trained = one
      if (one%is_solved) local_minima = reshape([local_minima, one%chi2, one%coordinates], &
                                                [size(local_minima, 1), size(local_minima, 2) + 1])
      trained%fits = fits_within_errors(trained, problem%n_residuals)
      associate (counts => search%objective%counts)
        if (trained%fits .and. n_evaluations*size(settings%experiment%loads) > counts%n_warm + counts%n_cold) exit
      end associate
    end do
    trained%n_evaluations = n_evaluations
    trained%has_snapped = has_snapped
    if (allocated(path)) call move_alloc(path, trained%path)
  end subroutine polish_starts

  !> Returns the point with its state, at which solutions begin at the unloaded wing.
  function solved_at(problem, coordinates) result(point)
    type(pool_problem_t), intent(inout) :: problem
    real(rp), intent(in) :: coordinates(:)
    type(solver_point_t) :: point
    type(wing_point_t), allocatable :: at
    allocate (at)
    call problem%solve(coordinates, problem%initial_state(), at)
    point%p = coordinates
    call move_alloc(at, point%state)
  end function solved_at

  !> Writes to the log whether all starts ended at the same point, and describes the starts that did not.
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

  !> Tells whether the sum of squares is no more than three standard deviations too large for noise.
  pure logical function fits_within_errors(trained, n_residuals) result(fits)
    type(trained_t), intent(in) :: trained
    integer, intent(in) :: n_residuals
    fits = trained%is_solved .and. trained%chi2 <= n_residuals + 3*sqrt(2*real(n_residuals, rp))
  end function fits_within_errors
end module training_polish

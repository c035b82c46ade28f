! SPDX-License-Identifier: GPL-3.0-or-later
!> Leaves a minimum that is not the lowest one. The sum of squares of a wing has several minima. Two of them usually differ by one
!> parameter, which is soft in one minimum and stiff in the other, and by values of other parameters that follow from it. Therefore
!> each parameter in turn is moved to the opposite side of its prior, and the fit is repeated from there.
!>
!> Where a wing snaps, a load may have the wrong one of two shapes in a minimum, and other parameters make up for it. Then each load
!> in turn is left out of a fit, and all loads are fitted from its end. On rank 0.
module training_moves
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use base_text, only: number_text
  use least_squares_continuation, only: fit_by_continuation
  use least_squares_problem, only: unknowns_t
  use least_squares_profile, only: THRESHOLD_90
  use least_squares_report, only: fit_options_t, fit_report_t
  use measurement_problem, only: wing_point_t
  use training_case, only: training_case_t
  use training_fit, only: join_paths, polish_from_start, start_t
  use training_listener, only: training_listener_t
  use training_moves_state, only: moves_state_t
  use training_outcome, only: trained_t
  use training_pool_problem, only: pool_problem_t
  use training_search, only: train_search_t
  implicit none
  private
  public :: try_moves

  !> Differences of the cost. Minima that differ by less than this, or by less than a millionth of the cost, are the same minimum. A
  !> change of one sd changes the cost by 1.
  real(rp), parameter :: LOWER = 0.1_rp, RELATIVELY_LOWER = 1.0e-6_rp
  integer, parameter :: MOST_ROUNDS = 5 !< in each of which all moves are made

contains

  !> Replaces the minimum of search%moves, which must be polished and solved, by the lowest minimum to which moves lead. Appends to
  !> its local_minima(1 + unknowns, :), see trained_t, all other minima that fit as well, that is within the threshold of the 90 %
  !> interval. After a lower minimum, all moves are made again from there. It ends when no move leads lower, if the pool is stopped,
  !> or if search%failure says that files failed. Parameters that are fixed or have no prior are not moved. Loads are left out if
  !> the wing has snapped in a fit, and there are others. Every move begins at the unloaded wing and therefore depends on the
  !> minimum alone. A checkpoint follows each move, from which the next ones continue.
  subroutine try_moves(settings, problem, unknowns, search, log)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    type(train_search_t), intent(inout) :: search
    class(training_listener_t), intent(inout) :: log
    integer :: i, n, n_loads
    logical :: is_tried
    n_loads = size(settings%experiment%loads)
    n = size(unknowns%prior) + n_loads ! moves
    problem%kind_of_part = 'move'
    problem%begun = wall_seconds()
    associate (state => search%moves)
      if (state%first_chi2 <= LOWER) return
      do while (state%n_done < MOST_ROUNDS*n .and. state%n_in_vain < n)
        i = modulo(state%n_done, n) + 1
        problem%n_parts = merge(n, n - n_loads, state%trained%has_snapped)
        problem%part = state%n_in_vain + 1
        if (i > n - n_loads) then
          is_tried = state%trained%has_snapped .and. n_loads > 1
        else
          is_tried = .not. unknowns%is_fixed(i) .and. unknowns%prior_sd(i) > 0
        end if
        if (is_tried) call try_move(settings, problem, unknowns, search, i, log)
        if (problem%pool%is_stopped) return
        if (.not. is_tried) state%n_in_vain = state%n_in_vain + 1
        state%n_done = state%n_done + 1
        if (is_tried) call search%back_up()
        if (search%failure%failed) return
      end do
      if (state%n_tried + state%n_without > 0) call tell_moves(log, state)
    end associate
  end subroutine try_moves

  !> Moves unknown i from the minimum of search%moves, or leaves out load i less their number, and enters what comes of it. If the
  !> pool is stopped, nothing changes.
  subroutine try_move(settings, problem, unknowns, search, i, log)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    type(train_search_t), intent(inout) :: search
    integer, intent(in) :: i
    class(training_listener_t), intent(inout) :: log
    type(moves_state_t) :: state
    type(trained_t) :: one
    type(fit_report_t) :: report
    real(rp), allocatable :: path(:, :)
    state = search%moves
    state%n_in_vain = state%n_in_vain + 1
    if (i <= size(unknowns%prior)) then
      state%n_tried = state%n_tried + 1
      call move(settings, problem, unknowns, i, state%trained, report, path)
    else
      state%n_without = state%n_without + 1
      call leave_out_load(settings, problem, unknowns, i - size(unknowns%prior), state%trained, report, path)
    end if
    if (problem%pool%is_stopped) return
    call join_paths(state%trained%path, path, state%n_evaluations)
    state%n_evaluations = state%n_evaluations + report%n_evaluations
    if (ends_elsewhere(report, state%trained)) then
      call polish_from_start(settings, problem, unknowns, search%mean_state, &
                             start_t(report%p, is_check=report%cost() >= state%trained%cost()), log, one)
      if (problem%pool%is_stopped) return
      if (allocated(one%path)) call join_paths(state%trained%path, one%path, state%n_evaluations)
      state%n_evaluations = state%n_evaluations + one%n_evaluations
      ! If the wing snaps for the first time, the loads that were kept have their turn.
      if (one%has_snapped .and. .not. state%trained%has_snapped) state%n_in_vain = 0
      one%has_snapped = one%has_snapped .or. state%trained%has_snapped
      state%trained%has_snapped = one%has_snapped
      if (one%is_solved .and. one%is_polished) call take_minimum(one, state)
    end if
    search%moves = state
  end subroutine try_move

  !> Enters a minimum: among those that were met, and in place of the lowest one if it is lower.
  subroutine take_minimum(one, state)
    type(trained_t), intent(inout) :: one
    type(moves_state_t), intent(inout) :: state
    associate (cost => state%trained%cost())
      state%local_minima = reshape([state%local_minima, one%chi2, one%coordinates], &
                                   [size(state%local_minima, 1), size(state%local_minima, 2) + 1])
      if (one%cost() >= cost - max(LOWER, RELATIVELY_LOWER*cost)) return
    end associate
    one%path = state%trained%path
    state%trained = one
    state%n_in_vain = 0
    state%n_lower = state%n_lower + 1
  end subroutine take_minimum

  !> Writes to the log what the moves have achieved.
  subroutine tell_moves(log, state)
    class(training_listener_t), intent(inout) :: log
    type(moves_state_t), intent(in) :: state
    character(20) :: text
    write (text, '(f20.1)') state%first_chi2 - state%trained%chi2
    if (state%n_lower > 0) then
      call log%say('polish    '//state%text()//', '//number_text(state%n_lower)// &
                   ' of them to a lower minimum; chi^2 fell by '//trim(adjustl(text)))
    else
      call log%say('polish    '//state%text()//', none to a lower minimum')
    end if
  end subroutine tell_moves

  !> Fits by continuation from `trained` with unknown i moved to one standard deviation of its prior on the opposite side, and
  !> returns the fit's path, see fit_by_continuation.
  subroutine move(settings, problem, unknowns, i, trained, report, path)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    integer, intent(in) :: i
    type(trained_t), intent(in) :: trained
    type(fit_report_t), intent(out) :: report
    real(rp), allocatable, intent(out) :: path(:, :)
    type(fit_options_t) :: options
    real(rp) :: start(size(unknowns%prior))
    start = trained%coordinates
    start(i) = unknowns%prior(i) - sign(unknowns%prior_sd(i), start(i) - unknowns%prior(i))
    start = max(unknowns%lower, min(unknowns%upper, start))
    ! A parameter at a bound that is also the value of its prior can move to one side only.
    if (abs(start(i) - trained%coordinates(i)) < unknowns%prior_sd(i)/10) &
      start(i) = max(unknowns%lower(i), min(unknowns%upper(i), unknowns%prior(i) + unknowns%prior_sd(i)))
    problem%is_cold = .false.
    problem%lowest = huge(1.0_rp)
    options = settings%fit
    options%known = trained%coordinates
    options%known_sd = trained%posterior%sd
    call fit_by_continuation(problem, unknowns, start, problem%initial_state(), options, .true., report, path)
  end subroutine move

  !> Fits by continuation from `trained` without load l, and all loads from where this fit ends. `path` is that of both fits, of
  !> which the first has no chi^2 of the load, and `report` that of the second. If the first one ends where it began, or near it,
  !> there is no second, and it leads to the known minimum.
  subroutine leave_out_load(settings, problem, unknowns, l, trained, report, path)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    integer, intent(in) :: l
    type(trained_t), intent(in) :: trained
    type(fit_report_t), intent(out) :: report
    real(rp), allocatable, intent(out) :: path(:, :)
    type(fit_options_t) :: options
    type(fit_report_t) :: without
    type(wing_point_t) :: start
    real(rp), allocatable :: next(:, :)
    problem%is_cold = .false.
    problem%lowest = huge(1.0_rp)
    start = problem%initial_state()
    start%is_left_out(l) = .true.
    call fit_by_continuation(problem, unknowns, trained%coordinates, start, settings%fit, .true., without, path)
    report = without
    if (problem%pool%is_stopped) return
    report%leads_to_known = size(path) == 0
    if (.not. report%leads_to_known) report%leads_to_known = all(abs(without%p - trained%coordinates) <= trained%posterior%sd)
    if (report%leads_to_known) return
    options = settings%fit
    options%known = trained%coordinates
    options%known_sd = trained%posterior%sd
    problem%lowest = huge(1.0_rp)
    call fit_by_continuation(problem, unknowns, without%p, problem%initial_state(), options, .false., report, next)
    call join_paths(path, next, without%n_evaluations)
    report%n_evaluations = report%n_evaluations + without%n_evaluations
  end subroutine leave_out_load

  !> Tells whether a fit ended in another minimum that is lower or that fits as well.
  pure logical function ends_elsewhere(report, trained)
    type(fit_report_t), intent(in) :: report
    type(trained_t), intent(in) :: trained
    ends_elsewhere = .false.
    if (report%leads_to_known .or. size(report%path) == 0) return
    ends_elsewhere = report%cost() <= trained%cost() + THRESHOLD_90
    if (report%cost() >= trained%cost() - LOWER) &
      ends_elsewhere = ends_elsewhere .and. any(abs(report%p - trained%coordinates) > trained%posterior%sd)
  end function ends_elsewhere
end module training_moves

! SPDX-License-Identifier: GPL-3.0-or-later
!> Leaves a minimum that is not the lowest one. The sum of squares of a wing has several minima. Two of them usually differ by one
!> parameter, which is soft in one minimum and stiff in the other, and by values of other parameters that follow from it. Therefore
!> each parameter in turn is moved to the opposite side of its prior, and the fit is repeated from there. On rank 0.
module training_moves
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use base_text, only: number_text
  use least_squares_continuation, only: fit_by_continuation
  use least_squares_problem, only: unknowns_t
  use least_squares_profile, only: THRESHOLD_90
  use least_squares_report, only: fit_options_t, fit_report_t
  use measurement_bending_state, only: bending_state_t
  use training_case, only: training_case_t
  use training_fit, only: counted, polish_from_start, start_t
  use training_listener, only: training_listener_t
  use training_outcome, only: trained_t
  use training_pool_problem, only: pool_problem_t
  implicit none
  private
  public :: try_moves

  !> Differences of the cost. Minima that differ by less than this, or by less than a millionth of the cost, are the same minimum. A
  !> change of one sd changes the cost by 1.
  real(rp), parameter :: LOWER = 0.1_rp, RELATIVELY_LOWER = 1.0e-6_rp
  integer, parameter :: MOST_ROUNDS = 5 !< largest number of moves of each parameter

contains

  !> Replaces `trained`, which must be polished and solved, by the lowest minimum to which moves lead. Appends to local_minima(1 +
  !> unknowns, :), see trained_t, all other minima that fit as well, that is within the threshold of the 90 % interval. After a
  !> lower minimum, all parameters are moved again from there. It ends when no move leads lower, or if the pool is stopped.
  !> Parameters that are fixed or have no prior are not moved. n_evaluations grows by the number of solved points. Every move begins
  !> at the unloaded wing and therefore depends on the minimum alone.
  subroutine try_moves(settings, problem, unknowns, mean_state, log, trained, local_minima, n_evaluations)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    type(bending_state_t), intent(in) :: mean_state !< of the search
    class(training_listener_t), intent(inout) :: log
    type(trained_t), intent(inout) :: trained
    real(rp), allocatable, intent(inout) :: local_minima(:, :)
    integer, intent(inout) :: n_evaluations
    type(trained_t) :: one
    type(fit_report_t) :: report
    real(rp), allocatable :: path(:, :)
    real(rp) :: first_chi2
    integer :: i, k, n, n_tried, n_in_vain, n_lower, n_before
    if (trained%chi2 <= LOWER) return
    n = size(unknowns%prior)
    first_chi2 = trained%chi2
    n_tried = 0
    n_in_vain = 0
    n_lower = 0
    problem%n_parts = n
    problem%kind_of_part = 'move'
    problem%begun = wall_seconds()
    do k = 1, MOST_ROUNDS*n
      if (n_in_vain >= n) exit
      i = modulo(k - 1, n) + 1
      n_in_vain = n_in_vain + 1
      if (unknowns%is_fixed(i) .or. .not. unknowns%prior_sd(i) > 0) cycle
      n_tried = n_tried + 1
      problem%part = n_in_vain
      call move(settings, problem, unknowns, i, trained, report, path)
      call delay(path, n_evaluations)
      n_evaluations = n_evaluations + report%n_evaluations
      if (problem%pool%is_stopped) return
      if (.not. ends_elsewhere(report, trained)) cycle
      call polish_from_start(settings, problem, unknowns, mean_state, &
                             start_t(report%p, is_check=report%cost() >= trained%cost()), log, one)
      n_before = n_evaluations
      n_evaluations = n_evaluations + one%n_evaluations
      if (problem%pool%is_stopped) return
      if (.not. (one%is_solved .and. one%is_polished)) cycle
      local_minima = reshape([local_minima, one%chi2, one%coordinates], [1 + n, size(local_minima, 2) + 1])
      if (one%cost() >= trained%cost() - max(LOWER, RELATIVELY_LOWER*trained%cost())) cycle
      call delay(one%path, n_before)
      one%path = reshape([trained%path, path, one%path], &
                         [size(path, 1), size(trained%path, 2) + size(path, 2) + size(one%path, 2)])
      trained = one
      n_in_vain = 0
      n_lower = n_lower + 1
    end do
    if (n_tried > 0) call tell_moves(log, n_tried, n_lower, first_chi2 - trained%chi2)
  end subroutine try_moves

  !> Counts the evaluations of a path from the first one of the whole polish, with n earlier ones.
  pure subroutine delay(path, n)
    real(rp), intent(inout) :: path(:, :)
    integer, intent(in) :: n
    path(1, :) = path(1, :) + n
  end subroutine delay

  !> Writes to the log what the moves of single parameters have achieved.
  subroutine tell_moves(log, n_tried, n_lower, fall)
    class(training_listener_t), intent(inout) :: log
    integer, intent(in) :: n_tried, n_lower
    real(rp), intent(in) :: fall !< of chi^2
    character(20) :: text
    write (text, '(f20.1)') fall
    if (n_lower > 0) then
      call log%say('polish    '//counted(n_tried, 'move')//' of single parameters, '//number_text(n_lower)// &
                   ' of them to a lower minimum; chi^2 fell by '//trim(adjustl(text)))
    else
      call log%say('polish    '//counted(n_tried, 'move')//' of single parameters, none to a lower minimum')
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

! SPDX-License-Identifier: GPL-3.0-or-later
!> Leaves a minimum that is not the lowest. The sum of squares of a wing has several minima; two of them differ by one
!> parameter that is soft in one and stiff in the other, and by what the others make of that. So one parameter after another
!> is moved to the other side of its prior, and the fit is repeated from there. On rank 0.
module training_moves
  use base_kinds, only: rp
  use base_text, only: number_text
  use least_squares_continuation, only: fit_by_continuation, KNOWN_MINIMUM
  use least_squares_fit, only: fit_report_t
  use least_squares_problem, only: unknowns_t
  use training_case, only: training_case_t
  use training_fit, only: counted, polish_from_start
  use training_listener, only: training_listener_t
  use training_objective, only: train_objective_t
  use training_outcome, only: trained_t
  use training_pool_problem, only: pool_problem_t
  implicit none
  private
  public :: try_moves

  real(rp), parameter :: LOWER = 0.1_rp !< of chi^2: minima that differ less are one minimum, with 1 as the change of one sd
  integer, parameter :: MOST_ROUNDS = 5 !< every parameter is moved so often at most

contains

  !> Replaces `trained`, which must be polished and solved, by the lowest minimum that moves lead to, and appends what it
  !> meets on the way to local_minima(1 + unknowns, :), see trained_t. A lower minimum is the next one from which all
  !> parameters are moved. It ends when no move leads lower, or if the pool is stopped. Parameters that are fixed or have no prior
  !> are not moved. n_evaluations grows by the points that were solved. Every move begins cold: it depends on the minimum alone.
  subroutine try_moves(settings, problem, unknowns, objective, log, trained, local_minima, n_evaluations)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    type(train_objective_t), intent(in) :: objective
    class(training_listener_t), intent(inout) :: log
    type(trained_t), intent(inout) :: trained
    real(rp), allocatable, intent(inout) :: local_minima(:, :)
    integer, intent(inout) :: n_evaluations
    type(trained_t) :: one
    type(fit_report_t) :: report
    real(rp) :: first_chi2
    character(15) :: fall
    integer :: i, n, n_tried, n_in_vain, n_lower
    n = size(unknowns%prior)
    first_chi2 = trained%chi2
    n_tried = 0
    n_in_vain = 0
    n_lower = 0
    i = 0
    problem%n_parts = n
    do while (n_in_vain < n .and. n_tried < MOST_ROUNDS*n)
      i = modulo(i, n) + 1
      n_tried = n_tried + 1
      n_in_vain = n_in_vain + 1
      if (unknowns%is_fixed(i) .or. .not. unknowns%prior_sd(i) > 0) cycle
      problem%part = n_in_vain
      call move(settings, problem, unknowns, i, trained, report)
      n_evaluations = n_evaluations + report%n_evaluations
      if (problem%pool%is_stopped) return
      if (.not. leads_lower(report, trained)) cycle
      call polish_from_start(settings, problem, unknowns, objective, report%p, .false., .false., log, one)
      n_evaluations = n_evaluations + one%n_evaluations
      if (problem%pool%is_stopped) return
      if (.not. (one%is_solved .and. one%is_polished)) cycle
      local_minima = reshape([local_minima, one%chi2, one%coordinates], [1 + n, size(local_minima, 2) + 1])
      if (one%chi2 >= trained%chi2 - LOWER) cycle
      trained = one
      n_in_vain = 0
      n_lower = n_lower + 1
    end do
    write (fall, '(f0.1)') first_chi2 - trained%chi2
    call log%say('polish    '//counted(n_tried, 'move')//' of single parameters, '//number_text(n_lower)// &
                 ' of them to a lower minimum'//trim(merge('; chi^2 fell by '//fall, repeat(' ', 31), n_lower > 0)))
  end subroutine try_moves

  !> A fit by continuation from `trained` with unknown i one standard deviation of its prior on the other side of it.
  subroutine move(settings, problem, unknowns, i, trained, report)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    integer, intent(in) :: i
    type(trained_t), intent(in) :: trained
    type(fit_report_t), intent(out) :: report
    real(rp), allocatable :: path(:, :)
    real(rp) :: start(size(unknowns%prior))
    start = trained%coordinates
    start(i) = unknowns%prior(i) - sign(unknowns%prior_sd(i), start(i) - unknowns%prior(i))
    start = max(unknowns%lower, min(unknowns%upper, start))
    problem%is_cold = .false.
    problem%is_start = .false.
    problem%lowest = huge(1.0_rp)
    call fit_by_continuation(problem, unknowns, start, settings%fit, .true., report, path, trained%coordinates, &
                             trained%posterior%sd)
  end subroutine move

  !> Whether a fit ended somewhere else, with a smaller sum of squares.
  pure logical function leads_lower(report, trained)
    type(fit_report_t), intent(in) :: report
    type(trained_t), intent(in) :: trained
    leads_lower = .false.
    if (report%reason == KNOWN_MINIMUM .or. size(report%path) == 0) return
    leads_lower = report%chi2 < trained%chi2 - LOWER
  end function leads_lower
end module training_moves

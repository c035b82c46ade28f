! SPDX-License-Identifier: GPL-3.0-or-later
!> Fits from a start far from the data, by continuation from a heavily regularised problem to the declared one. With r the
!> residuals in units of the declared errors, a stage minimises
!>
!>     |r(p)|^2/s^2 + |(p - prior)/prior_sd|^2,
!>
!> which is the problem of data with errors s times as large, or of priors s times as narrow. Such data can determine some unknowns
!> only if others are right. These unknowns stay at their prior until then. With the declared errors, the misfit of the others would
!> drive them far away, often to a bound, from which they do not return.
!>
!> s begins as |r| at the start, so that all data together first have the weight of one prior. The misfit far from the data is not
!> scatter, which n residuals determine better than one, but a single error that all residuals have in common. s then decreases with
!> |r|, at least by a factor of STEP, until the residuals are within the declared errors. The last stage has s = 1 and is solved to
!> the full tolerances. The stages thus decide which of several minima is found, but not its position. (Iterated regularisation:
!> Kaltenbacher, Neubauer and Scherzer, Iterative Regularization Methods for Nonlinear Ill-Posed Problems, 2008.)
module least_squares_continuation
  use base_kinds, only: rp
  use least_squares_fit, only: fit
  use least_squares_problem, only: least_squares_t, unknowns_t
  use least_squares_report, only: fit_options_t, fit_report_t, leads_to_known
  use least_squares_state, only: solver_point_t, solver_state_t
  implicit none
  private
  public :: fit_by_continuation

  real(rp), parameter :: STEP = 10 !< s falls by this factor at least, so that there are finitely many stages
  ! A stage needs to converge only as far as the next one needs for its start.
  real(rp), parameter :: STAGE_REDUCTION = 1.0e-3_rp, STAGE_STEP = 1.0e-2_rp

contains

  !> Fits as `fit` does, in stages, each of which begins at the point and in the state where the one before has ended. `report` is
  !> that of the last stage, but n_evaluations counts those of all stages. path(4, :) has a column for every point that any stage
  !> has accepted: the number of evaluations so far, chi^2 and the priors' chi^2 as declared, and s. Within a stage chi^2/s^2 plus
  !> the priors' chi^2 decreases.
  subroutine fit_by_continuation(problem, unknowns, start, from, options, has_stages, report, path)
    class(least_squares_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    real(rp), intent(in) :: start(:)
    class(solver_state_t), intent(in) :: from
    type(fit_options_t), intent(in) :: options
    logical, intent(in) :: has_stages !< otherwise only the last stage is run
    type(fit_report_t), intent(out) :: report
    real(rp), allocatable, intent(out) :: path(:, :)
    type(unknowns_t) :: narrowed
    type(fit_options_t) :: rough
    type(solver_point_t) :: at
    real(rp) :: s
    integer :: n_evaluations
    allocate (path(4, 0))
    n_evaluations = 0
    at%p = start
    allocate (at%state, source=from)
    s = 1
    rough = options
    if (has_stages) then
      rough%most_iterations = 0
      call fit(problem, unknowns, at%p, at%state, rough, report) ! evaluates the start only
      n_evaluations = report%n_evaluations
      if (size(report%path) == 0) return
      at = report%solver_point_t
      s = sqrt(report%chi2)
    end if
    rough%most_iterations = options%most_iterations
    rough%reduction_tolerance = max(options%reduction_tolerance, STAGE_REDUCTION)
    rough%step_tolerance = max(options%step_tolerance, STAGE_STEP)
    narrowed = unknowns
    if (allocated(options%known)) narrowed%prior = start
    if (allocated(rough%known)) deallocate (rough%known, rough%known_sd) ! a known minimum belongs to the declared priors
    do while (s > 1)
      if (report%chi2 <= size(report%residuals)) exit
      narrowed%prior_sd = unknowns%prior_sd/s
      call fit(problem, narrowed, at%p, at%state, rough, report)
      call add_stage(s, report, n_evaluations, path)
      if (size(report%path) == 0) return
      at = report%solver_point_t
      if (allocated(options%known)) then
        if (leads_to_known(options%known, options%known_sd, unknowns, report)) return
      end if
      s = min(s/STEP, sqrt(report%chi2))
    end do
    call fit(problem, unknowns, at%p, at%state, options, report)
    call add_stage(1.0_rp, report, n_evaluations, path)
  end subroutine fit_by_continuation

  !> Appends the points that a stage accepted to the path, and counts its evaluations in the report too.
  subroutine add_stage(s, report, n_evaluations, path)
    real(rp), intent(in) :: s
    type(fit_report_t), intent(inout) :: report
    integer, intent(inout) :: n_evaluations
    real(rp), allocatable, intent(inout) :: path(:, :)
    real(rp), allocatable :: rows(:, :)
    report%path(1, :) = report%path(1, :) + n_evaluations
    n_evaluations = n_evaluations + report%n_evaluations
    report%n_evaluations = n_evaluations
    allocate (rows(4, size(report%path, 2)))
    rows(:2, :) = report%path(:2, :)
    rows(3, :) = report%path(3, :)/s**2
    rows(4, :) = s
    path = reshape([path, rows], [4, size(path, 2) + size(rows, 2)])
  end subroutine add_stage
end module least_squares_continuation

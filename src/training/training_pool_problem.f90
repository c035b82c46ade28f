! SPDX-License-Identifier: GPL-3.0-or-later
!> Poses the fit of a training as a problem of least squares. All ranks solve the loads, and the log receives the progress. On
!> rank 0.
module training_pool_problem
  use base_kinds, only: rp
  use least_squares_problem, only: unknowns_t
  use measurement_bending_pool, only: bending_pool_t
  use measurement_evaluation, only: evaluation_t
  use measurement_problem, only: wing_point_t, wing_problem_t, wing_unknowns
  use training_case, only: training_case_t
  use training_listener, only: training_listener_t
  use training_objective, only: full_results
  use training_space, only: search_space_t
  implicit none
  private
  public :: pool_problem_t, make_unknowns

  !> Poses the problem of least squares; the pool solves its loads. With a log it reports its progress.
  type, extends(wing_problem_t) :: pool_problem_t
    type(bending_pool_t), pointer :: pool => null()
    class(training_listener_t), pointer :: log => null()
    integer :: part = 0, n_parts = 0         !< number of the present start, move or interval, and of all of them
    character(:), allocatable :: kind_of_part !< 'start' or 'move', for messages about a fit
    character(:), allocatable :: name        !< of the parameter whose interval is computed, if one is
    integer :: n_solved = 0                  !< points so far
    real(rp) :: lowest = huge(1.0_rp)        !< chi^2 from the present start or move
    real(rp) :: begun = 0           !< [s] wall time of the first start, move or interval
  contains
    procedure :: run => problem_run
  end type pool_problem_t

contains

  !> See `wing_problem_t`.
  subroutine problem_run(self, p, from, evaluations, shapes)
    class(pool_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    type(wing_point_t), intent(in) :: from
    type(evaluation_t), allocatable, intent(out) :: evaluations(:)
    real(rp), allocatable, intent(out) :: shapes(:, :, :)
    call self%pool%poll()
    call full_results(self%experiment, self%pool, p, from%is_start .and. .not. self%is_cold, from%shapes, evaluations, shapes, &
                      from%is_left_out)
    if (associated(self%log)) call tell_progress(self, evaluations, from%is_left_out)
  end subroutine problem_run

  !> Writes the progress of the fit to the log, after all loads of a point were solved that are not left out.
  subroutine tell_progress(self, evaluations, is_left_out)
    type(pool_problem_t), intent(inout) :: self
    type(evaluation_t), intent(in) :: evaluations(:)
    logical, intent(in) :: is_left_out(:)
    real(rp) :: chi2
    integer :: l
    self%n_solved = self%n_solved + 1
    if (allocated(self%name)) then
      call self%log%interval_progress(self%name, self%part - 1, self%n_parts, self%n_solved, self%begun)
      return
    end if
    chi2 = 0
    do l = 1, size(evaluations)
      if (is_left_out(l)) cycle
      if (.not. evaluations(l)%is_feasible()) chi2 = huge(chi2)
      if (.not. chi2 < huge(chi2)) exit
      chi2 = chi2 + sum((evaluations(l)%residuals/self%experiment%comparisons(l)%sigma)**2)
    end do
    self%lowest = min(self%lowest, chi2)
    call self%log%polish_progress(self%kind_of_part, self%part, self%n_parts, self%n_solved, self%lowest, self%begun)
  end subroutine tell_progress

  !> Returns the box and the priors about the values of [Wing], as coordinates of the experiment.
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
end module training_pool_problem

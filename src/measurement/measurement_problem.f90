! SPDX-License-Identifier: GPL-3.0-or-later
!> The fit of a wing's parameters to an experiment as a problem of least squares, solved by one process.
!> Residuals are in units of the declared standard deviations.
!>
!> Every load is solved warm from its own shape at the point where the solver stands (see `accept`), so that results
!> do not depend on how loads are spread: an extension that computes them elsewhere overrides `run`.
module measurement_problem
  use base_kinds, only: rp
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use measurement_least_squares, only: least_squares_t, unknowns_t
  use solid_params, only: parameter_t
  implicit none
  private
  public :: wing_problem_t, wing_unknowns

  real(rp), parameter, public :: ONE_DECADE = 2.302585092994046_rp !< ln 10, sd of the usual prior

  type, extends(least_squares_t) :: wing_problem_t
    type(experiment_t), pointer :: experiment => null()
    type(evaluation_t), allocatable :: evaluations(:)  !< (loads) of the last point
    real(rp), allocatable :: shapes(:, :, :)           !< (3, n_all, loads) [m] where the solver stands
    real(rp), allocatable :: tried(:, :, :)            !< those of the last point
    logical, allocatable :: is_start(:)                !< (loads) `shapes` is the start of a warm solution
    integer :: n_factorisations = 0
    type(evaluation_work_t), private :: work
  contains
    procedure :: init => problem_init
    procedure :: free => problem_free
    procedure :: run => problem_run
    procedure :: evaluate => problem_evaluate
    procedure :: accept => problem_accept
    procedure :: cold_difference => problem_cold_difference
  end type wing_problem_t

contains

  !> The first point will be solved cold. The experiment must live as long as the problem.
  subroutine problem_init(self, experiment)
    class(wing_problem_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: experiment
    integer :: l, n_loads
    call self%free()
    self%experiment => experiment
    self%n_residuals = experiment%count_residuals(0)
    n_loads = size(experiment%loads)
    allocate (self%evaluations(n_loads))
    do l = 1, n_loads
      call self%evaluations(l)%init(experiment, l, .true.)
    end do
    allocate (self%shapes(3, experiment%model%n_all, n_loads), source=0.0_rp)
    allocate (self%tried, source=self%shapes)
    allocate (self%is_start(n_loads), source=.false.)
    call self%work%init(experiment)
  end subroutine problem_init

  !> Releases everything.
  subroutine problem_free(self)
    class(wing_problem_t), intent(inout) :: self
    call self%work%free()
    if (allocated(self%evaluations)) deallocate (self%evaluations, self%shapes, self%tried, self%is_start)
  end subroutine problem_free

  !> All loads at p: `evaluations` and `tried`, warm from `shapes` where `is_start`.
  subroutine problem_run(self, p)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    integer :: l
    do l = 1, size(self%evaluations)
      self%tried(:, :, l) = self%shapes(:, :, l)
      call evaluate(self%experiment, self%work, p, l, self%is_start(l), self%tried(:, :, l), self%evaluations(l))
    end do
  end subroutine problem_run

  subroutine problem_evaluate(self, p, residuals, jacobian, is_valid)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    integer :: l, k, first
    call self%run(p)
    residuals = 0
    jacobian = 0
    is_valid = .true.
    first = 0
    do l = 1, size(self%evaluations)
      associate (evaluation => self%evaluations(l), sigma => self%experiment%comparisons(l)%sigma)
        is_valid = is_valid .and. evaluation%is_feasible()
        self%n_factorisations = self%n_factorisations + evaluation%factorisations
        do k = 1, size(sigma)
          residuals(first + k) = evaluation%residuals(k)/sigma(k)
          jacobian(first + k, :) = evaluation%jacobian(k, :)/sigma(k)
        end do
        first = first + size(sigma)
      end associate
    end do
  end subroutine problem_evaluate

  !> The shapes of the last point become the starts of what follows.
  subroutine problem_accept(self)
    class(wing_problem_t), intent(inout) :: self
    integer :: l
    self%shapes = self%tried
    do l = 1, size(self%evaluations)
      self%is_start(l) = self%evaluations(l)%is_start
    end do
  end subroutine problem_accept

  !> Solves every load cold at p and compares with the shapes where the solver stands: the largest distance [m]
  !> of a point of the wing; huge if a shape is not found. The shapes stay as they are; what follows starts cold.
  subroutine problem_cold_difference(self, p, difference)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    real(rp), intent(out) :: difference
    integer :: l
    self%is_start = .false.
    call self%run(p)
    difference = 0
    do l = 1, size(self%evaluations)
      if (.not. self%evaluations(l)%is_solved) difference = huge(difference)
    end do
    if (difference > 0) return
    difference = sqrt(maxval(sum((self%tried - self%shapes)**2, 1)))
  end subroutine problem_cold_difference

  !> Bounds of all unknowns, and normal priors about `centre` with standard deviation `decades` ln 10 for those that are
  !> logarithms, and with their own usual one for effects; the others have none.
  function wing_unknowns(experiment, centre, decades) result(unknowns)
    type(experiment_t), intent(in) :: experiment
    real(rp), intent(in) :: centre(:), decades
    type(unknowns_t) :: unknowns
    type(parameter_t) :: p
    integer :: i
    call unknowns%init(experiment%count())
    unknowns%prior = centre
    do i = 1, experiment%count()
      p = experiment%describe(i)
      unknowns%lower(i) = p%lower
      unknowns%upper(i) = p%upper
      if (p%is_effect) unknowns%prior_sd(i) = p%prior_sd
      if (p%is_effect .and. .not. p%is_log) unknowns%unit(i) = p%prior_sd
      if (.not. p%is_log) cycle
      unknowns%lower(i) = log(p%lower)
      unknowns%upper(i) = log(p%upper)
      if (.not. p%is_effect) unknowns%prior_sd(i) = decades*ONE_DECADE
    end do
  end function wing_unknowns
end module measurement_problem

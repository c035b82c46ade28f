! SPDX-License-Identifier: GPL-3.0-or-later
!> Poses the fit of a wing's parameters to an experiment as a problem of least squares, solved by one process. Residuals are in
!> units of the declared standard deviations.
!>
!> Each evaluation of a point begins at a state. Every load is solved warm from its own shape in this state, so that results do not
!> depend on how loads are distributed. An extension that solves loads on other ranks overrides `run`.
!>
!> If the wing snaps, the shape under a load jumps as a parameter changes (see solid_statics). A load has jumped if its shape was
!> not reached directly from the shape before and its residuals changed by far more than their derivatives at both ends predict.
!> Such loads can be left out.
module measurement_problem
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use least_squares_problem, only: least_squares_t, unknowns_t
  use least_squares_state, only: solver_state_t
  use measurement_bending_state, only: bending_state_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  implicit none
  private
  public :: wing_point_t, wing_problem_t, wing_unknowns

  !> Smallest size of a jump, in units of the residuals' sd. It changes the sum of squares by far less than 1.
  real(rp), parameter :: SHORTEST_JUMP = 0.3_rp
  real(rp), parameter :: CURVED = 2 !< a change by up to this multiple of the linear prediction may be smooth

  real(rp), parameter, public :: ONE_DECADE = 2.302585092994046_rp !< ln 10, sd of the usual prior

  !> Holds the shapes and the results at a point.
  type, extends(bending_state_t) :: wing_point_t
    real(rp), allocatable :: p(:)                      !< the point; not allocated before the first one
    type(evaluation_t), allocatable :: evaluations(:)  !< (loads)
  end type wing_point_t

  type, extends(least_squares_t) :: wing_problem_t
    type(experiment_t), pointer :: experiment => null()
    logical :: is_cold = .false.                       !< all solutions begin at the unloaded wing
    type(evaluation_work_t), private :: work
  contains
    procedure :: init => problem_init
    procedure :: free => problem_free
    procedure :: initial_state => problem_initial_state
    procedure :: run => problem_run
    procedure :: solve => problem_solve
    procedure :: evaluate => problem_evaluate
    procedure :: solve_cold => problem_solve_cold
  end type wing_problem_t

contains

  !> Begins with this experiment, which must live as long as the problem.
  subroutine problem_init(self, experiment)
    class(wing_problem_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: experiment
    call self%free()
    self%experiment => experiment
    self%n_residuals = experiment%count_residuals(0)
    call self%work%init(experiment)
  end subroutine problem_init

  !> Releases everything.
  subroutine problem_free(self)
    class(wing_problem_t), intent(inout) :: self
    call self%work%free()
  end subroutine problem_free

  !> Returns the state before the first point: all loads are solved from the unloaded wing, and none is left out.
  pure type(wing_point_t) function problem_initial_state(self) result(rest)
    class(wing_problem_t), intent(in) :: self
    call rest%init_shapes(self%experiment%model%n_all, size(self%experiment%loads))
    allocate (rest%is_left_out(size(self%experiment%loads)), source=.false.)
  end function problem_initial_state

  !> Solves all loads that are not left out at p, warm from the shapes of `from` where they are starts. Loads that are left out are
  !> not solved and keep their shapes.
  subroutine problem_run(self, p, from, evaluations, shapes)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    type(wing_point_t), intent(in) :: from
    type(evaluation_t), allocatable, intent(out) :: evaluations(:) !< (loads)
    real(rp), allocatable, intent(out) :: shapes(:, :, :)          !< (3, n_all, loads) [m]
    integer :: l
    shapes = from%shapes
    allocate (evaluations(size(shapes, 3)))
    do l = 1, size(evaluations)
      call evaluations(l)%init(self%experiment, l, .true.)
      if (from%is_left_out(l)) cycle
      call evaluate(self%experiment, self%work, p, l, from%is_start(l) .and. .not. self%is_cold, shapes(:, :, l), evaluations(l))
    end do
  end subroutine problem_run

  !> Solves all loads at p as `run` does; `to` is the state there. Stops the program if `from` is a state of another problem.
  subroutine problem_solve(self, p, from, to)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    class(solver_state_t), intent(in) :: from
    type(wing_point_t), intent(out) :: to
    integer :: l
    select type (from)
    type is (wing_point_t)
      call self%run(p, from, to%evaluations, to%shapes)
      to%p = p
      to%is_start = to%evaluations%is_start
      to%is_left_out = from%is_left_out
      to%jumped = [(is_jump(self, from, to, l), l=1, size(to%evaluations))]
    class default
      call require(.false., 'wing_problem_t: the state must be one of this problem')
    end select
  end subroutine problem_solve

  !> Returns residuals and derivatives over their sd at p; see `least_squares_t`. `is_valid` is false if a load has no shape
  !> outside the excluded zones.
  subroutine problem_evaluate(self, p, from, residuals, jacobian, is_valid, to)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out) :: to
    type(wing_point_t), allocatable :: at
    integer :: l, k, first
    allocate (at)
    call self%solve(p, from, at)
    residuals = 0
    jacobian = 0
    is_valid = .true.
    first = 0
    do l = 1, size(at%evaluations)
      associate (evaluation => at%evaluations(l), sigma => self%experiment%comparisons(l)%sigma)
        if (.not. at%is_left_out(l)) then
          is_valid = is_valid .and. evaluation%is_feasible()
          do k = 1, size(sigma)
            residuals(first + k) = evaluation%residuals(k)/sigma(k)
            jacobian(first + k, :) = evaluation%jacobian(k, :)/sigma(k)
          end do
        end if
        first = first + size(sigma)
      end associate
    end do
    call move_alloc(at, to)
  end subroutine problem_evaluate

  !> Tells whether load l, unless it is left out, jumped from the point `from` to the point `to`, or has no shape at `to`.
  logical function is_jump(self, from, to, l)
    class(wing_problem_t), intent(in) :: self
    type(wing_point_t), intent(in) :: from, to
    integer, intent(in) :: l
    real(rp), allocatable :: change(:), step(:)
    real(rp) :: expected
    is_jump = .false.
    if (from%is_left_out(l) .or. .not. allocated(from%p)) return
    associate (old => from%evaluations(l), new => to%evaluations(l), sigma => self%experiment%comparisons(l)%sigma)
      ! A shape that was solved directly from the one before has not jumped.
      if (from%is_start(l) .and. new%is_start .and. .not. (new%was_redone_cold .or. self%is_cold)) return
      is_jump = .not. new%is_solved
      if (is_jump) return
      change = (new%residuals - old%residuals)/sigma
      ! Derivatives diverge in front of a fold, but not behind it.
      step = to%p - from%p
      expected = min(norm2(matmul(old%jacobian, step)/sigma), norm2(matmul(new%jacobian, step)/sigma))
      is_jump = norm2(change) > SHORTEST_JUMP + CURVED*expected
    end associate
  end function is_jump

  !> Solves every load at p from the unloaded wing: `to` is the state there. `difference` is the largest distance [m] of a point of
  !> the wing from its place in the shapes of `warm`; huge if a shape is not found.
  subroutine problem_solve_cold(self, p, warm, to, difference)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    class(solver_state_t), intent(in) :: warm
    type(wing_point_t), intent(out) :: to
    real(rp), intent(out) :: difference
    call self%solve(p, self%initial_state(), to)
    difference = huge(difference)
    if (.not. all(to%evaluations%is_solved)) return
    select type (warm)
    class is (bending_state_t)
      difference = sqrt(maxval(sum((to%shapes - warm%shapes)**2, 1)))
    class default
      call require(.false., 'wing_problem_t: the warm state must be one of a wing')
    end select
  end subroutine problem_solve_cold

  !> Returns the bounds of all unknowns, and their normal priors: about `centre`, with the standard deviation `decades` ln 10 for
  !> logarithms, and with the usual sd of each effect. Other unknowns have no prior.
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

! SPDX-License-Identifier: GPL-3.0-or-later
!> Poses the fit of a wing's parameters to an experiment as a problem of least squares, solved by one process. Residuals are in
!> units of the declared standard deviations.
!>
!> Every load is solved warm from its own shape at the point of the solver (see `accept`), so that results do not depend on how
!> loads are distributed. An extension that computes them elsewhere overrides `run`.
!>
!> If the wing snaps, the shape under a load jumps as a parameter moves (see solid_statics). A load has jumped if its shape was
!> not reached directly from the one before and its residuals changed by far more than their derivatives at both ends predict.
!> Such loads can be left out.
module measurement_problem
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use least_squares_problem, only: least_squares_t, unknowns_t
  use least_squares_state, only: solver_state_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  implicit none
  private
  public :: wing_problem_t, wing_unknowns

  !> Smallest size of a jump, in units of the residuals' sd: far less than what changes the sum of squares by 1.
  real(rp), parameter :: SHORTEST_JUMP = 0.3_rp
  real(rp), parameter :: CURVED = 2 !< a change by so many times that of the derivatives may still be smooth

  real(rp), parameter, public :: ONE_DECADE = 2.302585092994046_rp !< ln 10, sd of the usual prior

  !> The point of the solver, and the results there.
  type, extends(solver_state_t) :: wing_problem_state_t
    real(rp), allocatable :: p(:)                      !< not allocated: no point so far
    type(evaluation_t), allocatable :: evaluations(:)
    real(rp), allocatable :: shapes(:, :, :)
    logical, allocatable :: is_start(:)
  end type wing_problem_state_t

  type, extends(least_squares_t) :: wing_problem_t
    type(experiment_t), pointer :: experiment => null()
    type(evaluation_t), allocatable :: evaluations(:)  !< (loads) of the last point
    real(rp), allocatable :: shapes(:, :, :)           !< (3, n_all, loads) [m] at the point of the solver
    real(rp), allocatable :: trial_shapes(:, :, :)            !< those of the last point
    logical, allocatable :: is_start(:)                !< (loads) `shapes` is the start of a warm solution
    logical :: is_cold = .false.                       !< no solution is warm
    logical, allocatable :: is_left_out(:)             !< (loads) its residuals are 0, whatever the shape
    integer :: n_factorisations = 0
    real(rp), allocatable, private :: p(:)             !< the last point
    type(wing_problem_state_t), private :: current        !< without shapes and starts, which are above
    type(evaluation_work_t), private :: work
  contains
    procedure :: init => problem_init
    procedure :: free => problem_free
    procedure :: run => problem_run
    procedure :: solve => problem_solve
    procedure :: evaluate => problem_evaluate
    procedure :: accept => problem_accept
    procedure :: get_state => problem_get_state
    procedure :: set_state => problem_set_state
    procedure :: has_jumped => problem_has_jumped
    procedure :: leave_out => problem_leave_out
    procedure, private :: is_jump => problem_is_jump
    procedure :: cold_difference => problem_cold_difference
  end type wing_problem_t

contains

  !> Begins with this experiment, which must live as long as the problem. The first point will be solved cold.
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
    allocate (self%trial_shapes, source=self%shapes)
    allocate (self%is_start(n_loads), self%is_left_out(n_loads), source=.false.)
    call self%work%init(experiment)
  end subroutine problem_init

  !> Releases everything.
  subroutine problem_free(self)
    class(wing_problem_t), intent(inout) :: self
    call self%work%free()
    self%current = wing_problem_state_t()
    if (allocated(self%evaluations)) deallocate (self%evaluations, self%shapes, self%trial_shapes, self%is_start, &
                                                 self%is_left_out)
  end subroutine problem_free

  !> Solves all loads that are not left out at p: `evaluations` and `trial_shapes`, warm from `shapes` where `is_start`.
  subroutine problem_run(self, p)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    integer :: l
    do l = 1, size(self%evaluations)
      self%trial_shapes(:, :, l) = self%shapes(:, :, l)
      if (self%is_left_out(l)) cycle
      call evaluate(self%experiment, self%work, p, l, self%is_start(l) .and. .not. self%is_cold, self%trial_shapes(:, :, l), &
                    self%evaluations(l))
    end do
  end subroutine problem_run

  !> Solves all loads at p, and makes it the last point.
  subroutine problem_solve(self, p)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    call self%run(p)
    self%p = p
  end subroutine problem_solve

  !> Returns residuals and derivatives over their sd at p; see `least_squares_t`. `is_valid` is false if a load has no shape
  !> outside the excluded zones.
  subroutine problem_evaluate(self, p, residuals, jacobian, is_valid)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    integer :: l, k, first
    call self%solve(p)
    residuals = 0
    jacobian = 0
    is_valid = .true.
    first = 0
    do l = 1, size(self%evaluations)
      associate (evaluation => self%evaluations(l), sigma => self%experiment%comparisons(l)%sigma)
        if (.not. self%is_left_out(l)) then
          is_valid = is_valid .and. evaluation%is_feasible()
          self%n_factorisations = self%n_factorisations + evaluation%factorisations
          do k = 1, size(sigma)
            residuals(first + k) = evaluation%residuals(k)/sigma(k)
            jacobian(first + k, :) = evaluation%jacobian(k, :)/sigma(k)
          end do
        end if
        first = first + size(sigma)
      end associate
    end do
  end subroutine problem_evaluate

  !> Makes later solutions start from the shapes of the last point.
  subroutine problem_accept(self)
    class(wing_problem_t), intent(inout) :: self
    integer :: l
    self%shapes = self%trial_shapes
    do l = 1, size(self%evaluations)
      self%is_start(l) = self%evaluations(l)%is_start
    end do
    self%current%p = self%p
    self%current%evaluations = self%evaluations
  end subroutine problem_accept

  !> See `least_squares_t`.
  subroutine problem_get_state(self, state)
    class(wing_problem_t), intent(in) :: self
    class(solver_state_t), allocatable, intent(out) :: state
    type(wing_problem_state_t), allocatable :: current
    allocate (current, source=self%current)
    current%shapes = self%shapes
    current%is_start = self%is_start
    call move_alloc(current, state)
  end subroutine problem_get_state

  !> See `least_squares_t`.
  subroutine problem_set_state(self, state)
    class(wing_problem_t), intent(inout) :: self
    class(solver_state_t), intent(in) :: state
    select type (state)
    type is (wing_problem_state_t)
      if (allocated(self%current%p)) deallocate (self%current%p, self%current%evaluations)
      if (allocated(state%p)) self%current%p = state%p
      if (allocated(state%evaluations)) self%current%evaluations = state%evaluations
      self%shapes = state%shapes
      self%is_start = state%is_start
    class default
      call require(.false., 'wing_problem_t: the state must be one of a wing')
    end select
  end subroutine problem_set_state

  !> See `least_squares_t`.
  logical function problem_has_jumped(self) result(has_jumped)
    class(wing_problem_t), intent(in) :: self
    integer :: l
    has_jumped = .false.
    do l = 1, size(self%evaluations)
      has_jumped = has_jumped .or. self%is_jump(l)
    end do
  end function problem_has_jumped

  !> Tells whether load l counts and jumped from the point of the solver to the last point, or has no shape there.
  logical function problem_is_jump(self, l) result(is_jump)
    class(wing_problem_t), intent(in) :: self
    integer, intent(in) :: l
    real(rp), allocatable :: change(:), step(:)
    real(rp) :: expected
    is_jump = .false.
    if (self%is_left_out(l) .or. .not. allocated(self%current%p)) return
    associate (old => self%current%evaluations(l), new => self%evaluations(l), &
               sigma => self%experiment%comparisons(l)%sigma)
      ! Was it solved directly from there?
      if (self%is_start(l) .and. new%is_start .and. .not. (new%was_redone_cold .or. self%is_cold)) return
      is_jump = .not. new%is_solved
      if (is_jump) return
      change = (new%residuals - old%residuals)/sigma
      ! Derivatives diverge in front of a fold, but not behind it.
      step = self%p - self%current%p
      expected = min(norm2(matmul(old%jacobian, step)/sigma), norm2(matmul(new%jacobian, step)/sigma))
      is_jump = norm2(change) > SHORTEST_JUMP + CURVED*expected
    end associate
  end function problem_is_jump

  !> See `least_squares_t`.
  subroutine problem_leave_out(self, is_done)
    class(wing_problem_t), intent(inout) :: self
    logical, intent(out) :: is_done
    logical :: jumped(size(self%evaluations))
    integer :: l
    jumped = [(self%is_jump(l), l=1, size(jumped))]
    is_done = any(jumped) .and. .not. all(jumped .or. self%is_left_out)
    if (is_done) self%is_left_out = jumped .or. self%is_left_out
  end subroutine problem_leave_out

  !> Solves every load cold at p and compares with the shapes at the point of the solver. Returns the largest distance [m] of a
  !> point of the wing; huge if a shape is not found. The shapes stay as they are; later solutions start cold.
  subroutine problem_cold_difference(self, p, difference)
    class(wing_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    real(rp), intent(out) :: difference
    integer :: l
    self%is_start = .false.
    call self%solve(p)
    difference = 0
    do l = 1, size(self%evaluations)
      if (.not. self%evaluations(l)%is_solved) difference = huge(difference)
    end do
    if (difference > 0) return
    difference = sqrt(maxval(sum((self%trial_shapes - self%shapes)**2, 1)))
  end subroutine problem_cold_difference

  !> Returns the bounds of all unknowns, and their normal priors: about `centre`, with the standard deviation `decades` ln 10 for
  !> logarithms, and with their own usual one for effects. Other unknowns have none.
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

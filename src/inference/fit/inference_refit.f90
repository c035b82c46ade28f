! SPDX-License-Identifier: GPL-3.0-or-later
!> Fits nested models without linearisation: the unknowns of the baseline and, with them, parameters of effects.
!>
!> Residuals are whitened, so that the sum of squares is minus twice the log likelihood with nuisances integrated out. The
!> directions of nuisances depend on the point, and are computed again at the optimum of the baseline until it stays the same.
!> Effects have no prior here: a name must not rest on earlier assumptions about its strength.
module inference_refit
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use least_squares_posterior, only: find_posterior, posterior_t
  use least_squares_problem, only: least_squares_t, unknowns_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: nested_problem_t, nested_fit_t, fit_baseline, fit_nested, fit_loosely, nested_unknowns, loose_options, &
            relinearise_nuisances, update_directions

  real(rp), parameter :: LOOSE_TOLERANCE = 1.0e-3_rp !< of the sum of squares
  real(rp), parameter :: SETTLED = 0.05_rp           !< in units of the sum of squares

  !> A model with the parameters `active` free and all others at q.
  type, extends(least_squares_t) :: nested_problem_t
    class(simulator_t), pointer :: simulator => null()
    type(whitener_t), pointer :: whitener => null()
    integer, allocatable :: active(:)
    real(rp), allocatable :: q(:)
    logical, allocatable, private :: is_wanted(:)  !< (surfaces) those to which the observations belong; not allocated: all
    real(rp), allocatable, private :: raw(:), raw_jacobian(:, :)
  contains
    procedure :: init => nested_init
    procedure :: evaluate => nested_evaluate
  end type nested_problem_t

  !> A model that was fitted.
  type :: nested_fit_t
    logical :: is_found = .false.
    integer, allocatable :: active(:)
    real(rp), allocatable :: q(:)            !< all parameters
    real(rp) :: chi2 = 0, prior_chi2 = 0     !< of whitened residuals, of priors
    real(rp), allocatable :: squares(:)      !< (surfaces) what each contributes to chi2
    real(rp), allocatable :: covariance(:, :) !< (active, active) in the linear approximation
    logical, allocatable :: is_at_bound(:)   !< (active)
    integer :: n_evaluations = 0
    class(solver_state_t), allocatable :: state !< where the fit has ended
  contains
    procedure :: cost => nested_cost
  end type nested_fit_t

contains

  !> Makes the problem over the observations of the whitener; parameters that are not active stay as in q. is_wanted(surfaces),
  !> where given, are those to which the observations belong. Simulator and whitener must live as long as the problem.
  subroutine nested_init(self, simulator, whitener, active, q, is_wanted)
    class(nested_problem_t), intent(inout) :: self
    class(simulator_t), intent(in), target :: simulator
    type(whitener_t), intent(in), target :: whitener
    integer, intent(in) :: active(:)
    real(rp), intent(in) :: q(:)
    logical, intent(in), optional :: is_wanted(:)
    self%simulator => simulator
    self%whitener => whitener
    self%n_residuals = whitener%n
    self%active = active
    self%q = q
    if (allocated(self%is_wanted)) deallocate (self%is_wanted)
    if (present(is_wanted)) self%is_wanted = is_wanted
    if (allocated(self%raw)) deallocate (self%raw, self%raw_jacobian)
    allocate (self%raw(simulator%n_observations), self%raw_jacobian(simulator%n_observations, size(active)))
  end subroutine nested_init

  !> Returns whitened residuals and derivatives with the active parameters at p; see `least_squares_t`.
  subroutine nested_evaluate(self, p, from, residuals, jacobian, is_valid, to)
    class(nested_problem_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out) :: to
    real(rp) :: both(size(residuals), size(p) + 1)
    self%q(self%active) = p
    residuals = 0
    jacobian = 0
    call self%simulator%evaluate(self%q, self%active, from, self%raw, self%raw_jacobian, is_valid, to, self%is_wanted)
    if (.not. is_valid) return
    both(:, 1) = self%raw(self%whitener%rows)
    both(:, 2:) = self%raw_jacobian(self%whitener%rows, :)
    call self%whitener%apply(both)
    residuals = both(:, 1)
    jacobian = both(:, 2:)
  end subroutine nested_evaluate

  !> Returns the sum of squares with priors.
  pure real(rp) function nested_cost(self) result(cost)
    class(nested_fit_t), intent(in) :: self
    cost = self%chi2 + self%prior_chi2
  end function nested_cost

  !> Returns bounds and priors of the parameters `active`, and usual changes for a search that starts at q.
  function nested_unknowns(simulator, active, q) result(unknowns)
    class(simulator_t), intent(in) :: simulator
    integer, intent(in) :: active(:)
    real(rp), intent(in) :: q(:)
    type(unknowns_t) :: unknowns
    integer :: i
    call unknowns%init(size(active))
    do i = 1, size(active)
      associate (one => simulator%parameters(active(i)))
        unknowns%lower(i) = one%lower
        unknowns%upper(i) = one%upper
        unknowns%prior(i) = one%null
        if (active(i) <= simulator%n_baseline) then
          unknowns%prior_sd(i) = one%prior_sd
        else if (.not. one%is_log) then
          unknowns%unit(i) = max(one%prior_sd, abs(q(active(i)) - one%null))
        end if
      end associate
    end do
  end function nested_unknowns

  !> Fits the parameters `active` over the observations of the whitener, from q and the state `from`. typical(parameters), where
  !> given, is a point at which effects are as strong as expected; is_wanted(surfaces) are those of the observations.
  subroutine fit_nested(simulator, whitener, active, q, from, options, found, typical, is_wanted)
    class(simulator_t), intent(inout), target :: simulator
    type(whitener_t), intent(in), target :: whitener
    integer, intent(in) :: active(:)
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    type(fit_options_t), intent(in) :: options
    type(nested_fit_t), intent(out) :: found
    real(rp), intent(in), optional :: typical(:)
    logical, intent(in), optional :: is_wanted(:)
    type(nested_problem_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_report_t) :: report
    type(posterior_t) :: posterior
    call problem%init(simulator, whitener, active, q, is_wanted)
    if (present(typical)) then
      unknowns = nested_unknowns(simulator, active, typical)
    else
      unknowns = nested_unknowns(simulator, active, q)
    end if
    call fit(problem, unknowns, q(active), from, options, report)
    found%is_found = report%is_converged .or. report%n_accepted > 0
    found%active = active
    found%q = q
    found%q(active) = report%p
    found%chi2 = report%chi2
    found%prior_chi2 = report%prior_chi2
    found%squares = squares_of(simulator, whitener, report%residuals)
    found%is_at_bound = report%is_at_bound
    found%n_evaluations = report%n_evaluations
    posterior = find_posterior(unknowns, report)
    found%covariance = posterior%covariance
    call move_alloc(report%state, found%state)
  end subroutine fit_nested

  !> Returns the sums of squares(surfaces) of whitened residuals(:) over the observations of each surface.
  pure function squares_of(simulator, whitener, residuals) result(squares)
    class(simulator_t), intent(in) :: simulator
    type(whitener_t), intent(in) :: whitener
    real(rp), intent(in) :: residuals(:)
    real(rp) :: squares(size(simulator%labels%fold))
    integer :: i
    squares = 0
    do i = 1, size(residuals)
      associate (square => squares(simulator%labels%surface(whitener%rows(i))))
        square = square + residuals(i)**2
      end associate
    end do
  end function squares_of

  !> Fits the baseline from several starts (parameters, :), each as `fit_loosely` does, and continues the most probable of these
  !> fits to convergence, in passes. Each pass begins with solutions from rest and with nuisances about their most probable errors.
  !> The passes end if two of them agree. Where the nuisances have a kink, passes may alternate between two results; the most
  !> probable pass counts. `whitener`, of the noise of all observations, then has the directions of `nuisances` at this point, and
  !> the fit is the best one with these. spread(starts) says by how much less probable than the best fit that of each start is (sum
  !> of squares and log determinant); it is huge for a start without a fit. `state` holds the errors about which nuisances are
  !> linear, before and after, and the solutions of the fit afterwards. Fails if no start leads to a fit.
  subroutine fit_baseline(simulator, starts, options, state, whitener, found, spread, failure, nuisances)
    class(simulator_t), intent(inout), target :: simulator
    real(rp), intent(in) :: starts(:, :)
    type(fit_options_t), intent(in) :: options
    class(solver_state_t), allocatable, intent(inout) :: state
    type(whitener_t), intent(inout), target :: whitener
    type(nested_fit_t), intent(out) :: found
    real(rp), allocatable, intent(out) :: spread(:)
    type(failure_t), intent(out) :: failure
    real(rp), allocatable, intent(out), optional :: nuisances(:, :)
    type(nested_fit_t) :: again
    real(rp), allocatable :: seen(:)
    logical :: is_valid
    call fit_best_start(simulator, starts, options, state, whitener, found, spread, failure)
    if (failure%failed) return
    call settle_baseline(simulator, options, whitener, found)
    call copy_state(found%state, state)
    call update_directions(simulator, found%q, state, whitener, is_valid, seen, nuisances)
    if (.not. is_valid) then
      call failure%raise('the model cannot be computed at the best fit of the baseline: check the loads, their units and the input')
      return
    end if
    ! If the passes do not converge, these directions may differ from those of the fit.
    call whitener%apply_one(seen)
    if (abs(sum(seen**2) + found%prior_chi2 - found%cost()) <= SETTLED) return
    call fit_nested(simulator, whitener, found%active, found%q, state, options, again)
    call copy_state(again%state, state)
    if (again%is_found) found = again
  end subroutine fit_baseline

  !> Makes `to` the same state as `from`.
  subroutine copy_state(from, to)
    class(solver_state_t), intent(in) :: from
    class(solver_state_t), allocatable, intent(inout) :: to
    if (allocated(to)) deallocate (to)
    allocate (to, source=from)
  end subroutine copy_state

  !> Finds the most probable of the loose fits of the baseline from these starts, and `spread` as in `fit_baseline`.
  subroutine fit_best_start(simulator, starts, options, state, whitener, found, spread, failure)
    class(simulator_t), intent(inout), target :: simulator
    real(rp), intent(in) :: starts(:, :)
    type(fit_options_t), intent(in) :: options
    class(solver_state_t), intent(in) :: state
    type(whitener_t), intent(inout), target :: whitener
    type(nested_fit_t), intent(out) :: found
    real(rp), allocatable, intent(out) :: spread(:)
    type(failure_t), intent(out) :: failure
    type(nested_fit_t) :: one
    type(failure_t) :: failed
    real(rp) :: least
    integer :: s
    allocate (spread(size(starts, 2)), source=huge(1.0_rp))
    least = huge(least)
    do s = 1, size(starts, 2)
      call fit_loosely(simulator, starts(:, s), state, options, whitener, one, failed)
      if (failed%failed) cycle
      spread(s) = one%cost() + whitener%log_determinant
      if (found%is_found .and. .not. spread(s) < least) cycle
      least = spread(s)
      found = one
    end do
    if (.not. found%is_found) then
      call failure%raise('the baseline cannot be fitted from any of its starting values: check the loads, their units and the '// &
                         'starting values')
      return
    end if
    where (spread < huge(1.0_rp)) spread = spread - least
  end subroutine fit_best_start

  !> Continues a loose fit of the baseline to convergence, in the passes of `fit_baseline`, and returns the most probable of them.
  subroutine settle_baseline(simulator, options, whitener, found)
    class(simulator_t), intent(inout), target :: simulator
    type(fit_options_t), intent(in) :: options
    type(whitener_t), intent(inout), target :: whitener
    type(nested_fit_t), intent(inout) :: found
    integer, parameter :: MOST_PASSES = 6
    type(nested_fit_t) :: one
    class(solver_state_t), allocatable :: state
    real(rp), allocatable :: q(:)
    real(rp) :: before, least
    integer :: pass
    logical :: is_valid
    least = huge(least)
    one = found
    allocate (state, source=found%state)
    do pass = 1, MOST_PASSES
      before = one%cost()
      q = one%q
      call state%begin_at_rest()
      call update_directions(simulator, q, state, whitener, is_valid)
      if (.not. is_valid) exit
      call fit_nested(simulator, whitener, found%active, q, state, options, one)
      if (.not. one%is_found) exit
      if (pass == 1 .or. one%cost() + whitener%log_determinant < least) then
        least = one%cost() + whitener%log_determinant
        found = one
      end if
      if (pass > 1 .and. abs(one%cost() - before) <= SETTLED) exit
      call copy_state(one%state, state)
      call relinearise_nuisances(simulator, whitener, one%q, state, is_valid)
    end do
  end subroutine settle_baseline

  !> Fits the baseline roughly from q with a whitener over all observations, which then has the nuisances at the end of the fit.
  !> They are linear about the errors that `from` holds. The fit may follow a branch of solutions that a solver does not reach from
  !> rest. At its end all solutions are therefore found from rest. If they differ, the fit continues from them, if that is possible.
  subroutine fit_loosely(simulator, q, from, options, whitener, found, failure)
    class(simulator_t), intent(inout), target :: simulator
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    type(fit_options_t), intent(in) :: options
    type(whitener_t), intent(inout), target :: whitener
    type(nested_fit_t), intent(out) :: found
    type(failure_t), intent(out) :: failure
    real(rp), parameter :: SAME = 0.01_rp ! sum of squares of the difference, in units of the noise
    type(nested_fit_t) :: one
    class(solver_state_t), allocatable :: state
    real(rp) :: followed(simulator%n_observations), nothing(simulator%n_observations, 0)
    real(rp), allocatable :: from_rest(:)
    integer :: i, active(simulator%n_baseline)
    logical :: is_valid
    active = [(i, i=1, simulator%n_baseline)]
    allocate (state, source=from)
    call state%begin_at_rest()
    call update_directions(simulator, q, state, whitener, is_valid)
    if (is_valid) call fit_nested(simulator, whitener, active, q, state, loose_options(options), found)
    if (.not. found%is_found) then
      call failure%raise('the baseline cannot be fitted from this start: check the loads, their units and the start')
      return
    end if
    check: block
      call simulator%evaluate(found%q, [integer ::], found%state, followed, nothing, is_valid)
      call found%state%begin_at_rest()
      if (is_valid) call update_directions(simulator, found%q, found%state, whitener, is_valid, from_rest)
      if (.not. is_valid) exit check
      followed = followed - from_rest
      call whitener%apply_one(followed)
      if (sum(followed**2) <= SAME) then
        call whitener%apply_one(from_rest)
        found%chi2 = sum(from_rest**2)
        found%squares = squares_of(simulator, whitener, from_rest)
        exit check
      end if
      call fit_nested(simulator, whitener, active, found%q, found%state, loose_options(options), one)
      if (one%is_found) found = one
    end block check
  end subroutine fit_loosely

  !> Returns the same options, but with a looser criterion to stop.
  pure function loose_options(options) result(loose)
    type(fit_options_t), intent(in) :: options
    type(fit_options_t) :: loose
    loose = options
    loose%reduction_tolerance = max(LOOSE_TOLERANCE, options%reduction_tolerance)
  end function loose_options

  !> Linearises the nuisances about their most probable errors at q, to which `state` belongs, because their effect is not linear.
  !> `state` then holds these errors. Unless all nuisances are linear anyway, the whitener, over all observations, then has the
  !> directions at q about the previous errors. If there is no result (`is_valid` is false), the errors stay as they were.
  subroutine relinearise_nuisances(simulator, whitener, q, state, is_valid)
    class(simulator_t), intent(inout) :: simulator
    type(whitener_t), intent(inout) :: whitener
    real(rp), intent(in) :: q(:)
    class(solver_state_t), allocatable, intent(inout) :: state
    logical, intent(out) :: is_valid
    real(rp), allocatable :: residuals(:), jacobian(:, :), nuisances(:, :), patterns(:, :)
    integer :: n
    is_valid = .true.
    if (.not. simulator%has_nonlinear_nuisances()) return
    n = simulator%n_observations
    allocate (residuals(n), jacobian(n, 0), nuisances(n, simulator%n_nuisances), patterns(n, 0))
    call simulator%evaluate(q, [integer ::], state, residuals, jacobian, is_valid)
    if (is_valid) call simulator%directions(q, state, nuisances, patterns, is_valid)
    if (.not. is_valid) return
    call whitener%add_directions(nuisances)
    call whitener%apply(nuisances)
    call whitener%apply_one(residuals)
    call simulator%linearise_at(-matmul(residuals, nuisances), q, state, is_valid)
  end subroutine relinearise_nuisances

  !> Computes the nuisances at q and gives their directions to the whitener; `state` then belongs to q. `seen` are the residuals
  !> there, `directions` the nuisances of all observations.
  subroutine update_directions(simulator, q, state, whitener, is_valid, seen, directions)
    class(simulator_t), intent(inout) :: simulator
    real(rp), intent(in) :: q(:)
    class(solver_state_t), allocatable, intent(inout) :: state
    type(whitener_t), intent(inout) :: whitener
    logical, intent(out) :: is_valid
    real(rp), allocatable, intent(out), optional :: seen(:), directions(:, :)
    real(rp), allocatable :: residuals(:), jacobian(:, :), nuisances(:, :), patterns(:, :)
    class(solver_state_t), allocatable :: next
    integer :: n
    n = simulator%n_observations
    allocate (residuals(n), jacobian(n, 0), nuisances(n, simulator%n_nuisances), patterns(n, 0))
    call simulator%evaluate(q, [integer ::], state, residuals, jacobian, is_valid, next)
    if (.not. is_valid) return
    call move_alloc(next, state)
    if (present(seen)) seen = residuals
    call simulator%directions(q, state, nuisances, patterns, is_valid)
    if (is_valid) call whitener%add_directions(nuisances(whitener%rows, :))
    if (present(directions)) call move_alloc(nuisances, directions)
  end subroutine update_directions
end module inference_refit

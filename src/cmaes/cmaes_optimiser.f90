! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes one run of CMA-ES, which minimises f. `ask` gives the candidates of a generation, the caller evaluates them in any way,
!> and `tell` learns from the values.
!>
!> Algorithm and constants: Hansen, The CMA Evolution Strategy: A Tutorial, arXiv:1604.00772v2. With a box the coordinates are in
!> [0, 1]^n; `cmaes_box` defines their meaning.
module cmaes_optimiser
  use base_errors, only: require
  use base_kinds, only: rp
  use cmaes_box, only: clip
  use cmaes_eigen, only: build_roots, decompose
  use cmaes_options, only: cmaes_options_t
  use cmaes_params, only: cmaes_params_t
  use cmaes_penalty, only: penalise
  use cmaes_ranking, only: classify, rank, FEASIBLE, INFEASIBLE, FAILED
  use cmaes_sampling, only: draw_candidate
  use cmaes_state, only: cmaes_state_t, cmaes_work_t
  use cmaes_stop, only: find_stop, note_history, RUNNING, MAXFEVALS, TOO_MANY_FAILED
  use cmaes_update, only: update_distribution
  implicit none
  private
  public :: cmaes_t, MOST_ATTEMPTS

  integer, parameter :: MOST_ATTEMPTS = 3 !< how often a generation is repeated with half the step

  !> Parameters, state and work space of a run. Only `state` changes from generation to generation.
  type :: cmaes_t
    type(cmaes_options_t) :: options
    type(cmaes_params_t) :: params
    logical :: has_box = .false. !< coordinates are confined to [0, 1]
    type(cmaes_state_t) :: state
    type(cmaes_work_t) :: work
  contains
    procedure :: start => cmaes_start
    procedure :: restored => cmaes_restored
    procedure :: ask => cmaes_ask
    procedure :: tell => cmaes_tell
  end type cmaes_t

contains

  !> Begins a run at `mean(n)`. `restart` is the number of the run in a search, from 0: runs have different random numbers.
  subroutine cmaes_start(self, options, params, mean, has_box, restart)
    class(cmaes_t), intent(out) :: self
    type(cmaes_options_t), intent(in) :: options
    type(cmaes_params_t), intent(in) :: params
    real(rp), intent(in) :: mean(:)
    logical, intent(in) :: has_box
    integer, intent(in), optional :: restart
    integer :: number
    call require(size(mean) == params%n, 'cmaes_start: a mean of n numbers')
    number = 0
    if (present(restart)) number = restart
    self%options = options
    self%params = params
    self%has_box = has_box
    call self%state%reset(params, mean, options%seed, number)
    self%state%history%f_scale = options%f_scale
    call self%work%allocate(params)
    call build_roots(self%state, self%work)
  end subroutine cmaes_start

  !> Completes a run whose `state` was restored from a checkpoint.
  subroutine cmaes_restored(self)
    class(cmaes_t), intent(inout) :: self
    call build_roots(self%state, self%work)
  end subroutine cmaes_restored

  !> Returns the candidates x(n, lambda) of the present generation for evaluation: they are clipped to the box. It changes the work
  !> space only, so that it returns the same candidates after a restart.
  subroutine cmaes_ask(self, x)
    class(cmaes_t), intent(inout) :: self
    real(rp), intent(out) :: x(:, :)
    integer :: k
    do k = 1, self%params%lambda
      call draw_candidate(self%state, self%work, k, self%work%x(:, k))
    end do
    x = self%work%x
    if (self%has_box) x = clip(x)
  end subroutine cmaes_ask

  !> Updates the state from f(lambda) of the candidates that `ask` returned last, or of x(n, lambda) if present. Candidates with
  !> violation > 0 are infeasible, and those marked in `has_failed` or with f that is not finite have failed; f of both is ignored.
  !> If more than half failed the step is halved and the generation will be repeated with new random numbers, up to MOST_ATTEMPTS
  !> times. state%stop_code says whether the run has ended.
  subroutine cmaes_tell(self, f, violation, has_failed, x)
    class(cmaes_t), intent(inout) :: self
    real(rp), intent(in) :: f(:)
    real(rp), intent(in), optional :: violation(:), x(:, :)
    logical, intent(in), optional :: has_failed(:)
    integer :: n_failed
    call require(self%state%stop_code == RUNNING, 'cmaes_tell: a run that has not ended')
    call require(size(f) == self%params%lambda, 'cmaes_tell: lambda values')
    if (present(x)) self%work%x = x
    associate (p => self%params, state => self%state, work => self%work)
      call classify(f, violation, has_failed, work%classes, work%keys)
      n_failed = count(work%classes == FAILED)
      state%counts%n_failed = state%counts%n_failed + n_failed
      state%counts%n_infeasible = state%counts%n_infeasible + count(work%classes == INFEASIBLE)
      call note_best(state, work, f, self%has_box)
      state%counts%evaluations = state%counts%evaluations + p%lambda
      if (2*n_failed > p%lambda) then
        call repeat_generation(self%options, p%lambda, state)
        return
      end if
      if (self%has_box) call penalise(p, state, work)
      call rank(work%classes, work%keys, work%order, work%merged, work%bits)
      call note_history(p, state, work, f)
      call update_distribution(p, state, work)
      if (state%generation - state%last_eigen >= p%eigen_interval) call decompose(state, work)
      state%stop_code = find_stop(self%options, p, state, work, f)
    end associate
  end subroutine cmaes_tell

  !> Prepares the repetition of a generation with half the step, or ends the run if too many failed in a row.
  subroutine repeat_generation(options, lambda, state)
    type(cmaes_options_t), intent(in) :: options
    integer, intent(in) :: lambda
    type(cmaes_state_t), intent(inout) :: state
    if (state%counts%evaluations > options%max_evaluations - lambda) state%stop_code = MAXFEVALS
    if (state%attempt == MOST_ATTEMPTS) then
      state%stop_code = TOO_MANY_FAILED
      return
    end if
    state%attempt = state%attempt + 1
    state%counts%n_redone = state%counts%n_redone + 1
    state%sigma = state%sigma/2
  end subroutine repeat_generation

  !> Keeps the best feasible candidate of the run; of equal ones it keeps the first.
  subroutine note_best(state, work, f, has_box)
    type(cmaes_state_t), intent(inout) :: state
    type(cmaes_work_t), intent(in) :: work
    real(rp), intent(in) :: f(:)
    logical, intent(in) :: has_box
    integer :: k
    do k = 1, size(f)
      if (work%classes(k) /= FEASIBLE) cycle
      if (state%best%is_seen .and. f(k) >= state%best%f) cycle
      state%best%is_seen = .true.
      state%best%f = f(k)
      state%best%x = work%x(:, k)
      if (has_box) state%best%x = clip(state%best%x)
      state%best%evaluation = state%counts%evaluations + k
    end do
  end subroutine note_best
end module cmaes_optimiser

! SPDX-License-Identifier: GPL-3.0-or-later
!> Linearises about the fit of the top candidate instead of that of the baseline: the nuisances, and a simulator that is itself an
!> approximation.
!>
!> What an error of a force, of a place or of the mesh does depends on the wing. Seen from a baseline that is wrong, as one
!> cause is missing, it is wrong too: the rest then looks like a second cause, and intervals are too narrow. So where a
!> cause is clear the nuisances are taken anew at its fit, and all hypotheses are compared once more with these.
!>
!> A simulator that is an approximation about the baseline, as one of flights, errs where a cause is strong. Where a cause is clear
!> the approximation is made anew about its fit, and the cause is fitted again, until it stays. Others are not fitted again: about
!> the baseline, where they are judged, nothing has changed.
module inference_relinearisation
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_design, only: build_design, design_t
  use inference_record, only: diagnosis_options_t, diagnosis_t, rounds_t
  use inference_refit, only: fit_nested, nested_fit_t, relinearise_nuisances
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: is_clear, model_error_t, relinearise, relinearise_simulator

  !> What only other models or further runs tell of a simulator: directions of its errors, from one on another mesh for instance,
  !> and its values far from where it is an approximation.
  type, abstract :: model_error_t
    integer :: most_rounds = 0 !< of `linearise`; 0: the simulator is exact
  contains
    !> Gives `state` new ones at q, to which it belongs after a fit with the whitener. If that cannot be done the old ones stay.
    procedure(renew_interface), deferred :: renew
    !> Makes `state`, which belongs to q, one of an approximation about q. sd(parameters) are how well they are known, 0 for those
    !> that are not fitted. `rows` are the observations that it now sees in another way; none if it is exact along these parameters,
    !> or if there is no result; `unmade` then says why. `failure`: the diagnosis cannot go on.
    procedure(linearise_interface), deferred :: linearise
  end type model_error_t

  abstract interface
    subroutine renew_interface(self, whitener, q, state)
      import :: model_error_t, rp, solver_state_t, whitener_t
      class(model_error_t), intent(inout) :: self
      type(whitener_t), intent(in), target :: whitener
      real(rp), intent(in) :: q(:)
      class(solver_state_t), intent(inout) :: state
    end subroutine renew_interface

    subroutine linearise_interface(self, q, sd, state, rows, unmade, failure)
      import :: failure_t, model_error_t, rp, solver_state_t
      class(model_error_t), intent(inout) :: self
      real(rp), intent(in) :: q(:), sd(:)
      class(solver_state_t), intent(inout) :: state
      integer, allocatable, intent(out) :: rows(:)
      type(failure_t), intent(out) :: unmade
      type(failure_t), intent(inout) :: failure
    end subroutine linearise_interface
  end interface

  !> Decrease of the sum of squares, in units of the noise, below which a cause does not change nuisances significantly.
  real(rp), parameter :: CLEAR = 25.0_rp

contains

  !> Computes all nuisances anew at the best of the refits: errors that converge, directions, the whitener, the fit of the
  !> baseline and the design are then new, and so is this refit. `is_new` is false if nothing has changed, because no cause is
  !> clear or a result is missing.
  subroutine relinearise(simulator, options, d, is_new, model_error)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout), target :: d
    logical, intent(out) :: is_new
    class(model_error_t), intent(inout), optional :: model_error
    type(whitener_t), target :: whitener
    type(nested_fit_t) :: baseline, top_fit
    class(solver_state_t), allocatable :: state
    type(design_t) :: design
    type(failure_t) :: failure
    real(rp) :: nuisances(simulator%n_observations, simulator%n_nuisances)
    integer :: i
    is_new = .false.
    if (size(d%refits) == 0) return
    i = maxloc(d%refits%gain, 1)
    if (d%refits(i)%gain < CLEAR) return
    top_fit = d%refits(i)%found
    whitener = d%whitener
    call iterate_relinearisation(simulator, options, d%scale, whitener, top_fit, nuisances, is_new, model_error)
    if (is_new) then
      allocate (state, source=top_fit%state)
      call state%take_shapes(d%baseline%state)
      call fit_nested(simulator, whitener, d%baseline%active, d%baseline%q, state, options%fit, baseline)
      is_new = baseline%is_found
    end if
    if (is_new) call build_design(simulator, baseline%q, baseline%state, design, failure, d%design, nuisances)
    is_new = is_new .and. .not. failure%failed
    if (.not. is_new) return
    design%residual_dof = d%design%residual_dof ! of the scan, as the scale is
    d%design = design
    d%whitener = whitener
    d%baseline = baseline
    d%refits(i)%found = top_fit
  end subroutine relinearise

  !> Alternates between the fit of the top candidate and the nuisances about it, until it stays or becomes less probable: the larger
  !> the errors that a cause brings with it, the better it fits, which the determinant of the covariance counts against it.
  !> `is_new` false: it has not become more probable.
  subroutine iterate_relinearisation(simulator, options, scale, whitener, top_fit, nuisances, is_new, model_error)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    real(rp), intent(in) :: scale
    type(whitener_t), intent(inout), target :: whitener
    type(nested_fit_t), intent(inout) :: top_fit
    real(rp), intent(out) :: nuisances(:, :)
    logical, intent(out) :: is_new
    class(model_error_t), intent(inout), optional :: model_error
    integer, parameter :: MOST_ROUNDS = 4
    real(rp), parameter :: STAYS = 0.3_rp ! of the sd of a parameter
    type(whitener_t), target :: trial_whitener
    type(nested_fit_t) :: found
    class(solver_state_t), allocatable :: state, next_state
    real(rp), dimension(size(nuisances, 1), size(nuisances, 2)) :: next
    real(rp) :: residuals(size(next, 1)), nothing(size(next, 1), 0), moved, score
    integer :: round, k
    logical :: is_valid
    is_new = .false.
    score = minus_two_log_posterior(top_fit, whitener, scale)
    allocate (state, source=top_fit%state)
    do round = 1, MOST_ROUNDS
      trial_whitener = whitener
      call simulator%evaluate(top_fit%q, [integer ::], state, residuals, nothing, is_valid, next_state)
      call move_alloc(next_state, state)
      ! Twice: what the errors did for the baseline is another thing than what they do for the top candidate.
      if (is_valid) call relinearise_nuisances(simulator, trial_whitener, top_fit%q, state, is_valid)
      if (is_valid) call relinearise_nuisances(simulator, trial_whitener, top_fit%q, state, is_valid)
      if (is_valid .and. present(model_error)) call model_error%renew(trial_whitener, top_fit%q, state)
      if (is_valid) call simulator%directions(top_fit%q, state, next, nothing, is_valid)
      if (is_valid) then
        call trial_whitener%add_directions(next)
        call fit_nested(simulator, trial_whitener, top_fit%active, top_fit%q, state, options%fit, found)
        is_valid = found%is_found
      end if
      if (is_valid) is_valid = minus_two_log_posterior(found, trial_whitener, scale) < score
      if (.not. is_valid) exit
      moved = maxval([(abs(found%q(found%active(k)) - top_fit%q(found%active(k)))/ &
                       sqrt(max(tiny(moved), found%covariance(k, k))), &
                       k=simulator%n_baseline + 1, size(found%active))])
      is_new = .true.
      score = minus_two_log_posterior(found, trial_whitener, scale)
      whitener = trial_whitener
      top_fit = found
      deallocate (state)
      allocate (state, source=found%state)
      nuisances = next
      if (moved < STAYS) exit
    end do
  end subroutine iterate_relinearisation

  !> Tells whether a gain of the sum of squares, in units of the noise, makes a cause so clear that one linearises about it.
  pure logical function is_clear(gain)
    real(rp), intent(in) :: gain
    is_clear = gain >= CLEAR
  end function is_clear

  !> Makes the simulator an approximation about the fit `found` of causes, and fits them again, until none of their parameters moves
  !> by more than SETTLED of its sd or `model_error` makes no more rounds. `rounds` is what comes out; rounds%found is not found if
  !> there is nothing to do, and everything is then as before.
  subroutine relinearise_simulator(simulator, options, whitener, nuisances, found, model_error, rounds, failure)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(whitener_t), intent(in) :: whitener
    real(rp), intent(in) :: nuisances(:, :) !< (n, :) directions of errors that the whitener has
    type(nested_fit_t), intent(in) :: found
    class(model_error_t), intent(inout) :: model_error
    type(rounds_t), intent(out), target :: rounds
    type(failure_t), intent(inout) :: failure
    real(rp), parameter :: SETTLED = 0.1_rp ! of the sd of a parameter
    type(failure_t) :: unmade
    type(nested_fit_t) :: last, next
    type(whitener_t), target :: trial
    integer, allocatable :: rows(:)
    real(rp) :: directions(simulator%n_observations, simulator%n_nuisances), nothing(simulator%n_observations, 0)
    real(rp) :: errors(simulator%n_observations, simulator%n_nuisances)
    real(rp) :: sd(size(found%q)), moved
    integer :: round
    logical :: is_valid
    rounds%whitener = whitener
    rounds%nuisances = nuisances
    rounds%reason = ''
    allocate (rounds%moved(0))
    last = found
    do round = 1, model_error%most_rounds
      sd = parameter_sd(simulator, last)
      call model_error%linearise(last%q, sd, last%state, rows, unmade, failure)
      if (unmade%failed) rounds%reason = unmade%reason
      if (failure%failed .or. size(rows) == 0) exit
      call simulator%directions(last%q, last%state, directions, nothing, is_valid)
      if (.not. is_valid) exit
      errors = rounds%nuisances
      errors(rows, :) = directions(rows, :)
      trial = rounds%whitener
      call trial%add_directions(errors)
      call fit_nested(simulator, trial, last%active, last%q, last%state, options%fit, next)
      if (.not. next%is_found) exit
      sd = parameter_sd(simulator, next)
      moved = maxval(abs(next%q - last%q)/max(sd, tiny(sd)), mask=sd > 0)
      rounds%moved = [rounds%moved, moved]
      rounds%found = next
      rounds%whitener = trial
      rounds%nuisances = errors
      last = next
      rounds%has_settled = moved < SETTLED
      if (rounds%has_settled) exit
    end do
  end subroutine relinearise_simulator

  !> Returns the sd(parameters) of those that a fit has beside the baseline, 0 for all others.
  pure function parameter_sd(simulator, found) result(sd)
    class(simulator_t), intent(in) :: simulator
    type(nested_fit_t), intent(in) :: found
    real(rp) :: sd(size(found%q))
    integer :: k
    sd = 0
    do k = simulator%n_baseline + 1, size(found%active)
      sd(found%active(k)) = sqrt(max(tiny(1.0_rp), found%covariance(k, k)))
    end do
  end function parameter_sd

  !> Twice the negative logarithm of the probability density of data and parameters, without a constant.
  real(rp) function minus_two_log_posterior(found, whitener, scale)
    type(nested_fit_t), intent(in) :: found
    type(whitener_t), intent(in) :: whitener
    real(rp), intent(in) :: scale
    minus_two_log_posterior = found%cost()/scale + whitener%log_determinant
  end function minus_two_log_posterior
end module inference_relinearisation

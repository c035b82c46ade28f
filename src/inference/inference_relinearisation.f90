! SPDX-License-Identifier: GPL-3.0-or-later
!> Linearises about the fit of the top candidate instead of that of the baseline. This concerns the nuisances, and a simulator that
!> is itself an approximation.
!>
!> The effect of an error of a force, of a position or of the mesh depends on the model about which it is computed. If the baseline
!> lacks a cause, the directions of errors at its fit are wrong as well: what they do not cover looks like a second cause, and
!> intervals are too narrow. Where a cause is clear, the nuisances are therefore computed again at its fit, and all hypotheses are
!> compared again with these nuisances.
!>
!> A simulator that is an approximation about the baseline, for instance one of flights, is inaccurate where a cause is strong.
!> Where a cause is clear, the approximation is therefore made again about its fit, and the cause is fitted again, until the fit
!> stays the same. Other causes are not fitted again: they are judged about the baseline, where the approximation has not changed.
module inference_relinearisation
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_design, only: build_design, design_t
  use inference_record, only: diagnosis_options_t, model_t, refit_t, rounds_t
  use inference_refit, only: fit_nested, nested_fit_t, relinearise_nuisances
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: model_about, model_error_t, relinearise, relinearise_extended, relinearise_simulator

  !> Errors of a simulator that only other models or further runs show. These are the directions of its errors, for instance from a
  !> model with another mesh, and its values far from the point about which it is an approximation.
  type, abstract :: model_error_t
    integer :: most_rounds = 0 !< largest number of calls of `linearise`; 0: the simulator is exact
  contains
    !> Replaces the directions of errors in `state` by those at q, where a fit with the whitener has ended in this state. If they
    !> cannot be computed, the old directions stay.
    procedure(renew_interface), deferred :: renew
    !> Makes `state`, which belongs to q, the state of an approximation about q. sd(parameters) are the standard deviations of the
    !> parameters, 0 for those that are not fitted. `rows` are the observations whose approximation has changed. There are none if
    !> the simulator is exact along these parameters, or if there is no result. In the second case `unmade` says why. After a
    !> `failure` the diagnosis cannot go on.
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

  !> Computes all nuisances again at the best of the refits, about their most probable errors. The directions of errors in `model`,
  !> its whitener, its fit of the baseline and its design, and this refit are then replaced by new ones. `scale` is the variance of
  !> the noise over that of the whitener. `is_new` is false if nothing has changed, because no cause is clear or because a result is
  !> missing.
  subroutine relinearise(simulator, options, scale, model, refits, is_new, model_error)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    real(rp), intent(in) :: scale
    type(model_t), intent(inout) :: model
    type(refit_t), intent(inout) :: refits(:)
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
    if (size(refits) == 0) return
    i = maxloc(refits%gain, 1)
    if (.not. is_clear(refits(i)%gain)) return
    top_fit = refits(i)%found
    whitener = model%whitener
    call iterate_relinearisation(simulator, options, scale, whitener, top_fit, nuisances, is_new, model_error)
    if (is_new) then
      allocate (state, source=top_fit%state)
      call state%take_shapes(model%baseline%state)
      call fit_nested(simulator, whitener, model%baseline%active, model%baseline%q, state, options%fit, baseline)
      is_new = baseline%is_found
    end if
    if (is_new) call build_design(simulator, baseline%q, baseline%state, whitener%independent_fraction, design, &
                                  failure, model%design, nuisances)
    is_new = is_new .and. .not. failure%failed
    if (.not. is_new) return
    design%residual_dof = model%design%residual_dof ! that of the scan, to which the scale belongs, too
    model%design = design
    model%whitener = whitener
    model%baseline = baseline
    refits(i)%found = top_fit
  end subroutine relinearise

  !> Alternates between the fit of the top candidate and the nuisances at this fit, until the fit stays the same or becomes less
  !> probable. A cause fits better if it makes the errors larger, for which the determinant of the covariance penalises it. `is_new`
  !> is false if the fit has not become more probable.
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
      ! Twice, because the first result depends on the linearisation about the most probable errors of the baseline.
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

  !> Tells whether the gain of a cause, a decrease of the sum of squares in units of the noise, suffices to linearise about its fit.
  pure logical function is_clear(gain)
    real(rp), intent(in) :: gain
    is_clear = gain >= CLEAR
  end function is_clear

  !> Makes an approximate simulator an approximation about the fit `found` of causes, if its `gain`, in units of the noise, is
  !> clear, and fits the causes again. Repeats both until no parameter of the causes moves by more than SETTLED of its sd, or until
  !> `model_error` allows no more rounds. `rounds` holds the results. If there is nothing to do, rounds%found is not found.
  subroutine relinearise_simulator(simulator, options, model, found, gain, model_error, rounds, failure)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in) :: model
    type(nested_fit_t), intent(in) :: found
    real(rp), intent(in) :: gain
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
    if (model_error%most_rounds == 0 .or. .not. is_clear(gain)) return
    rounds%whitener = model%whitener
    rounds%nuisances = model%design%nuisances
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

  !> Does what `relinearise_simulator` does for the causes of the verdict, unless `rounds` are already about them. `extended` is
  !> then the last of their fits. For `scale` see `relinearise`.
  subroutine relinearise_extended(simulator, options, model, scale, model_error, extended, rounds, failure)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in) :: model
    real(rp), intent(in) :: scale
    class(model_error_t), intent(inout) :: model_error
    type(nested_fit_t), intent(inout) :: extended
    type(rounds_t), intent(inout) :: rounds
    type(failure_t), intent(inout) :: failure
    if (rounds%found%is_found) then
      if (has_same(rounds%found%active, extended%active)) return
    end if
    call relinearise_simulator(simulator, options, model, extended, (model%baseline%cost() - extended%cost())/scale, model_error, &
                               rounds, failure)
    if (rounds%found%is_found) extended = rounds%found
  end subroutine relinearise_extended

  !> Tells whether two lists are equal.
  pure logical function has_same(a, b)
    integer, intent(in) :: a(:), b(:)
    has_same = size(a) == size(b)
    if (has_same) has_same = all(a == b)
  end function has_same

  !> Returns the model with the errors of the last of the `rounds`, if there was one.
  function model_about(model, rounds) result(about)
    type(model_t), intent(in) :: model
    type(rounds_t), intent(in) :: rounds
    type(model_t) :: about
    about = model
    if (.not. rounds%found%is_found) return
    about%whitener = rounds%whitener
    about%design%nuisances = rounds%nuisances
  end function model_about

  !> Returns sd(parameters), the standard deviations of the parameters that a fit has besides those of the baseline; 0 for all
  !> others.
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

  !> Returns twice the negative logarithm of the probability density of data and parameters, without a constant.
  real(rp) function minus_two_log_posterior(found, whitener, scale)
    type(nested_fit_t), intent(in) :: found
    type(whitener_t), intent(in) :: whitener
    real(rp), intent(in) :: scale
    minus_two_log_posterior = found%cost()/scale + whitener%log_determinant
  end function minus_two_log_posterior
end module inference_relinearisation

! SPDX-License-Identifier: GPL-3.0-or-later
!> Fits the causes of a verdict together, finds their intervals, validates the fit on locations that were left out, and withdraws a
!> name that these do not support.
module inference_causes
  use base_kinds, only: rp
  use inference_decision, only: decision_t, reject_catalogue, withdraw_name, AT_BOUND, LEVEL, NO_FIT, NO_GAIN, NO_INTERVAL, &
                                VERDICT_NAMED, VERDICT_SET
  use inference_intervals, only: find_intervals, find_support, refit_from_better
  use inference_place_intervals, only: widen_over_places
  use inference_record, only: diagnosis_options_t, model_t, prediction_t, refit_t, support_t, tests_t, LARGEST_SCALE
  use inference_refit, only: nested_fit_t
  use inference_simulator, only: simulator_t
  use inference_top_candidates, only: fit_extended
  use inference_validation, only: compare_folds, validate
  use least_squares_profile, only: interval_t
  implicit none
  private
  public :: find_cause_intervals, fit_causes, reject_misfit, validate_causes, withdraw_unsupported

contains

  !> Fits the causes of the verdict together. A single cause that was fitted already is not fitted again. Withdraws a name if there
  !> is no fit.
  subroutine fit_causes(simulator, options, model, tests, refits, decision, extended)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in), target :: model
    type(tests_t), intent(in) :: tests
    type(refit_t), intent(in) :: refits(:)
    type(decision_t), intent(inout) :: decision
    type(nested_fit_t), intent(out) :: extended
    integer :: i
    if (size(decision%causes) == 1) then
      do i = 1, size(refits)
        if (refits(i)%candidate == decision%causes(1)) extended = refits(i)%found
      end do
    end if
    if (.not. extended%is_found) call fit_extended(simulator, options, model, tests, decision%causes, extended)
    if (.not. extended%is_found .and. decision%verdict == VERDICT_NAMED) call withdraw_name(decision, NO_FIT)
  end subroutine fit_causes

  !> Rejects the catalogue if most of the misfit has another origin, whatever the causes explain: their fit leaves extended_scale
  !> times the variance of the noise model.
  subroutine reject_misfit(extended_scale, decision)
    real(rp), intent(in) :: extended_scale
    type(decision_t), intent(inout) :: decision
    if (extended_scale > LARGEST_SCALE .and. any(decision%verdict == [VERDICT_NAMED, VERDICT_SET])) &
      call reject_catalogue(decision, max(1 - LEVEL, decision%posterior_unknown))
  end subroutine reject_misfit

  !> Finds the intervals of the parameters of the `causes`, which `extended` fits jointly, and whether they support these causes. If
  !> the search finds a better fit, it replaces `extended`. If most of the misfit is left, an interval in units of the noise has no
  !> meaning, and its search advances slowly from one local minimum to the next. What the extended model leaves beyond the noise is
  !> an error of the model, of which only the size is known; `scale`, the variance over that of the noise model, includes it. The
  !> place of a cause is an unknown of its interval, too.
  subroutine find_cause_intervals(simulator, options, model, scale, causes, extended, intervals, support)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in), target :: model
    real(rp), intent(in) :: scale
    integer, intent(in) :: causes(:)
    type(nested_fit_t), intent(inout) :: extended
    type(interval_t), allocatable, intent(out) :: intervals(:)
    type(support_t), intent(out) :: support
    logical :: is_better
    integer :: i, k
    call find_intervals(simulator, model%whitener, scale, options%fit, extended, intervals)
    call refit_from_better(simulator, model%whitener, options%fit, intervals, extended, is_better)
    if (is_better) call find_intervals(simulator, model%whitener, scale, options%fit, extended, intervals)
    do i = 1, size(causes)
      k = findloc(extended%active(simulator%n_baseline + 1:), model%design%candidates(causes(i))%columns(1), 1)
      call widen_over_places(simulator, model%design, model%whitener, scale, options%fit, causes(i), extended, intervals(k))
    end do
    call find_support(simulator%parameters, model%design%candidates(causes), simulator%n_baseline, extended, intervals, &
                      support%is_null_excluded, support%is_at_bound)
  end subroutine find_cause_intervals

  !> Measures how well the causes predict locations that were left out of their fit, and compares this with the baseline, which
  !> `prediction` has.
  subroutine validate_causes(simulator, options, model, extended, prediction)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in) :: model
    type(nested_fit_t), intent(in) :: extended
    type(prediction_t), intent(inout) :: prediction
    call validate(simulator, extended%active, extended%q, extended%state, model%design%nuisances, &
                  model%whitener%independent_fraction, options%fit, prediction%extended)
    call compare_folds(prediction%baseline, prediction%extended, prediction%gain, prediction%gain_error, prediction%has_gain)
  end subroutine validate_causes

  !> Withdraws a name if a cause has no interval that excludes its null, if such an estimate lies at a bound, or if the fit does
  !> not predict better than the baseline. If one of several causes fails, the others get no name either, because they have been
  !> found to explain too little. Where the baseline can take the values that the data show, though these are far from what was
  !> known, the extended fit gains more of the priors than of the data. It then cannot predict better, and must not predict worse.
  subroutine withdraw_unsupported(options, support, prediction, baseline, extended, decision)
    type(diagnosis_options_t), intent(in) :: options
    type(support_t), intent(in) :: support
    type(prediction_t), intent(in) :: prediction
    type(nested_fit_t), intent(in) :: baseline, extended
    type(decision_t), intent(inout) :: decision
    real(rp) :: least
    if (decision%verdict /= VERDICT_NAMED) return
    least = prediction%gain_error
    if (baseline%prior_chi2 - extended%prior_chi2 > max(0.0_rp, baseline%chi2 - extended%chi2)) least = -prediction%gain_error
    if (options%finds_intervals .and. .not. support%is_null_excluded) then
      call withdraw_name(decision, NO_INTERVAL)
    else if (support%is_at_bound) then
      call withdraw_name(decision, AT_BOUND)
    else if (options%validates .and. .not. (prediction%has_gain .and. prediction%gain > least)) then
      call withdraw_name(decision, NO_GAIN)
    end if
  end subroutine withdraw_unsupported
end module inference_causes

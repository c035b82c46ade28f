! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs the whole diagnosis of one set of data, with any simulator: baseline, design, calibration, odds and nonlinear refits of
!> the top candidates. It repeats them once with the nuisances linearised about the best candidate. It then decides, validates on
!> locations that were left out, and finds intervals.
module inference_engine
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_residual_checks, only: combined_log_p
  use inference_calibration, only: find_detectable, find_statistics, statistics_t
  use inference_calibration_store, only: calibrate, calibration_store_t
  use inference_fit_checks, only: check_fit
  use inference_decision, only: decide, reject_catalogue, withdraw_name, LEVEL, NO_FIT, NO_GAIN, NO_INTERVAL, AT_BOUND, &
                                VERDICT_ADEQUATE, VERDICT_INSUFFICIENT, VERDICT_NAMED, VERDICT_SET
  use inference_design, only: build_design, design_t
  use inference_intervals, only: find_intervals, find_support, refit_from_better
  use inference_noise_fraction, only: find_noise_fraction
  use inference_record, only: compress_at, diagnosis_options_t, diagnosis_t, refit_t, rounds_t, LARGEST_SCALE
  use inference_refine_location, only: add_finer
  use inference_refit, only: fit_baseline, nested_fit_t
  use inference_relinearisation, only: is_clear, model_error_t, relinearise, relinearise_simulator
  use inference_simulator, only: simulator_t
  use inference_top_candidates, only: replace_refit, fit_extended, refit_top_candidates
  use inference_validation, only: compare_folds, validate
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: diagnosis_options_t, diagnosis_t, refit_t, run_diagnosis

  integer, parameter :: FEWEST_REST = 30    !< smallest number of degrees of freedom with which the size of the noise is estimated

contains

  !> Runs the diagnosis. The fit of the baseline begins at each of starts(parameters, :). Fails if none of them leads to a fit.
  !> `store` keeps the draws of the calibration. `model_error` renews the directions of model errors and the linearisation of an
  !> approximate simulator. Each fit in `d` holds the state in which it ended.
  subroutine run_diagnosis(simulator, starts, options, d, failure, store, model_error)
    class(simulator_t), intent(inout), target :: simulator
    real(rp), intent(in) :: starts(:, :)
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(out), target :: d
    type(failure_t), intent(out) :: failure
    class(calibration_store_t), intent(inout), optional :: store
    class(model_error_t), intent(inout), optional :: model_error
    type(refit_t), allocatable :: before(:)
    integer :: n_effects
    class(solver_state_t), allocatable :: state !< of the simulator, near the fit of the baseline
    real(rp), allocatable :: nuisances(:, :)
    logical :: is_scale_known, has_finer, is_new
    n_effects = size(simulator%effects)
    allocate (d%refits(0))
    call simulator%initial_state(state)
    call find_baseline(simulator, starts, options, state, d%whitener, d%baseline, d%spread, nuisances, failure)
    if (failure%failed) return
    call build_design(simulator, d%baseline%q, state, d%design, failure, nuisances=nuisances)
    if (failure%failed) return
    deallocate (d%baseline%state)
    allocate (d%baseline%state, source=state) ! all refits begin here
    d%initial_baseline = d%baseline
    ! If the tests leave too few degrees of freedom to estimate the size of the noise, the noise model is trusted.
    is_scale_known = options%is_scale_known .or. d%design%residual_dof < FEWEST_REST
    if (simulator%n_observations < 2*simulator%n_baseline) then
      d%decision%verdict = VERDICT_INSUFFICIENT
      d%decision%causes = [integer ::]
      d%decision%set = [integer ::]
      return
    end if
    call calibrate(d%design, n_effects, is_scale_known, options%n_draws, options%seed, d%calibration, store)
    call find_detectable(d%design, d%calibration, n_effects, LEVEL, d%detectable_snr)
    call test_hypotheses(simulator, options, is_scale_known, state, d, failure)
    if (failure%failed) return
    if (d%linear%verdict == VERDICT_ADEQUATE .or. d%linear%verdict == VERDICT_INSUFFICIENT .or. &
        d%linear%is_rejected_by_checks) then
      if (options%validates) call validate_baseline(simulator, options, d)
      return
    end if
    call refine_design(simulator, d%baseline%q, d%hypotheses%best, state, d%design, has_finer, failure)
    if (failure%failed) return
    if (has_finer) call test_hypotheses(simulator, options, is_scale_known, state, d, failure)
    if (failure%failed) return
    call refit_top_candidates(simulator, options, d)
    if (options%validates) call validate_baseline(simulator, options, d)
    call relinearise(simulator, options, d, is_new, model_error)
    if (is_new) then
      deallocate (state)
      allocate (state, source=d%baseline%state)
      call test_hypotheses(simulator, options, is_scale_known, state, d, failure)
      if (failure%failed) return
      call move_alloc(d%refits, before)
      call refit_top_candidates(simulator, options, d, before)
    end if
    if (present(model_error)) call relinearise_best(simulator, options, d, model_error, failure)
    if (failure%failed) return
    call validate_causes(simulator, options, d, failure, model_error)
  end subroutine run_diagnosis

  !> Validates the baseline: measures how well it predicts locations that were left out of its fit.
  subroutine validate_baseline(simulator, options, d)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout) :: d
    call validate(simulator, d%initial_baseline%active, d%initial_baseline%q, d%baseline%state, d%design%nuisances, options%fit, &
                  d%prediction%baseline)
  end subroutine validate_baseline

  !> Fits the baseline. If the data then show another fraction of correlated noise than before, fits the baseline again from there.
  !> For `state` see fit_baseline.
  subroutine find_baseline(simulator, starts, options, state, whitener, baseline, spread, nuisances, failure)
    class(simulator_t), intent(inout), target :: simulator
    real(rp), intent(in) :: starts(:, :)
    type(diagnosis_options_t), intent(in) :: options
    class(solver_state_t), allocatable, intent(inout) :: state
    type(whitener_t), intent(out), target :: whitener
    type(nested_fit_t), intent(out) :: baseline
    real(rp), allocatable, intent(out) :: spread(:), nuisances(:, :) !< see fit_baseline
    type(failure_t), intent(out) :: failure
    real(rp), allocatable :: again(:), best(:, :)
    logical :: is_new
    call fit_baseline(simulator, starts, options%fit, state, whitener, baseline, spread, failure, nuisances)
    if (failure%failed .or. options%is_scale_known) return
    call find_noise_fraction(simulator, baseline%q, state, is_new)
    best = reshape(baseline%q, [size(baseline%q), 1])
    if (is_new) call fit_baseline(simulator, best, options%fit, state, whitener, baseline, again, failure, nuisances)
  end subroutine find_baseline

  !> Adds to the design finer positions about those of the leading candidates, `best` of each effect, at the baseline q. The
  !> residual degrees of freedom stay those of the scan.
  subroutine refine_design(simulator, q, best, state, design, has_finer, failure)
    class(simulator_t), intent(inout) :: simulator
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: best(:)
    class(solver_state_t), allocatable, intent(inout) :: state
    type(design_t), intent(inout) :: design
    logical, intent(out) :: has_finer
    type(failure_t), intent(out) :: failure
    type(design_t) :: finer
    call add_finer(simulator, design, best, has_finer)
    if (.not. has_finer) return
    call build_design(simulator, q, state, finer, failure, design)
    finer%residual_dof = design%residual_dof
    design = finer
  end subroutine refine_design

  !> Computes z, the test statistics, the odds and a first verdict, from the tangents and the checks of residuals. If the statistics
  !> exist already, those of the scan, which give the global p, and its residual sum of squares are kept, as are the checks: with
  !> finer positions, the tests may leave no degrees of freedom to estimate the noise.
  subroutine test_hypotheses(simulator, options, is_scale_known, from, d, failure)
    class(simulator_t), intent(inout) :: simulator
    type(diagnosis_options_t), intent(in) :: options
    logical, intent(in) :: is_scale_known
    class(solver_state_t), intent(in) :: from !< near the baseline
    type(diagnosis_t), intent(inout) :: d
    type(failure_t), intent(out) :: failure
    type(statistics_t) :: scan
    real(rp) :: residual_square
    integer :: n_effects
    n_effects = size(simulator%effects)
    scan = d%statistics
    residual_square = d%residual_square
    if (allocated(d%z)) deallocate (d%z)
    allocate (d%z(d%design%k))
    call compress_at(simulator, d%baseline%q, from, d%design, d%z, d%residual_square, failure)
    if (failure%failed) return
    if (allocated(scan%effect)) d%residual_square = residual_square
    call find_statistics(d%design, n_effects, is_scale_known, d%z, d%residual_square, d%statistics)
    if (allocated(scan%effect)) then
      d%statistics%effect = scan%effect
      d%statistics%unknown = scan%unknown
    end if
    if (.not. is_scale_known) d%scale = d%residual_square/d%design%residual_dof
    d%z = d%z/sqrt(d%scale)
    if (.not. allocated(d%checks)) call check_fit(simulator, d%design, d%baseline, d%scale, &
                                                  noise_dof(options, is_scale_known), d%checks)
    call d%hypotheses%init(d%design, n_effects, d%z)
    call decide(d%design, d%calibration, d%statistics, d%hypotheses, d%z, options%seed, d%linear, &
                combined_log_p(d%checks))
    d%decision = d%linear
  end subroutine test_hypotheses

  !> Returns the degrees of freedom with which the size of the noise is known. They are huge if the declared noise is trusted or if
  !> the data cannot show its size.
  pure integer function noise_dof(options, is_scale_known)
    type(diagnosis_options_t), intent(in) :: options
    logical, intent(in) :: is_scale_known
    noise_dof = merge(huge(1), options%noise_dof, is_scale_known)
  end function noise_dof

  !> Linearises an approximate simulator again about the best of the refits, if its gain is clear, fits this candidate again, and
  !> decides again with the result.
  subroutine relinearise_best(simulator, options, d, model_error, failure)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout) :: d
    class(model_error_t), intent(inout) :: model_error
    type(failure_t), intent(inout) :: failure
    type(nested_fit_t) :: found
    integer :: i
    if (size(d%refits) == 0 .or. model_error%most_rounds == 0) return
    i = maxloc(d%refits%gain, 1)
    if (.not. is_clear(d%refits(i)%gain)) return
    call relinearise_simulator(simulator, options, d%whitener, d%design%nuisances, d%refits(i)%found, model_error, d%rounds, &
                               failure)
    found = d%rounds%found
    if (found%is_found) call replace_refit(simulator, options, d, i, found)
  end subroutine relinearise_best

  !> Does what `relinearise_best` does for the causes of the verdict, unless the simulator has already been linearised about them.
  subroutine relinearise_extended(simulator, options, d, model_error, failure)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout) :: d
    class(model_error_t), intent(inout) :: model_error
    type(failure_t), intent(inout) :: failure
    type(rounds_t) :: none
    if (model_error%most_rounds == 0) return
    if (d%rounds%found%is_found) then
      if (has_same(d%rounds%found%active, d%extended%active)) return
    end if
    d%rounds = none
    if (.not. is_clear((d%baseline%cost() - d%extended%cost())/d%scale)) return
    call relinearise_simulator(simulator, options, d%whitener, d%design%nuisances, d%extended, model_error, d%rounds, failure)
    if (d%rounds%found%is_found) d%extended = d%rounds%found
  end subroutine relinearise_extended

  !> Tells whether two lists are equal.
  pure logical function has_same(a, b)
    integer, intent(in) :: a(:), b(:)
    has_same = size(a) == size(b)
    if (has_same) has_same = all(a == b)
  end function has_same

  !> Fits the causes of the verdict together, finds intervals unless most of the misfit is left, and validates the fit on locations
  !> that were left out. Withdraws a name if a cause has no interval that excludes its null, if such an estimate lies at a bound, or
  !> if the fit does not predict better than the baseline. If one of several causes fails, the others get no name either, because
  !> they have been found to explain too little.
  subroutine validate_causes(simulator, options, d, failure, model_error)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout), target :: d
    type(failure_t), intent(inout) :: failure
    class(model_error_t), intent(inout), optional :: model_error
    type(whitener_t), target :: whitener
    real(rp), allocatable :: nuisances(:, :)
    logical :: is_better
    if (size(d%decision%causes) == 0) return
    call reuse_fit(d)
    if (.not. d%extended%is_found) call fit_extended(simulator, options, d, d%decision%causes, d%extended)
    if (.not. d%extended%is_found) then
      if (d%decision%verdict == VERDICT_NAMED) call withdraw_name(d%decision, NO_FIT)
      return
    end if
    if (present(model_error)) call relinearise_extended(simulator, options, d, model_error, failure)
    if (failure%failed) return
    whitener = d%whitener
    nuisances = d%design%nuisances
    if (d%rounds%found%is_found) then
      whitener = d%rounds%whitener
      nuisances = d%rounds%nuisances
    end if
    d%extended_scale = d%extended%chi2/max(1, simulator%n_observations - size(d%extended%active))
    ! Most of the misfit has another origin, whatever the causes explain.
    if (d%extended_scale > LARGEST_SCALE .and. any(d%decision%verdict == [VERDICT_NAMED, VERDICT_SET])) then
      call reject_catalogue(d%decision, max(1 - LEVEL, d%decision%posterior_unknown))
    end if
    ! An interval in units of the noise has no meaning then either, and its search advances slowly from one local minimum to the
    ! next. What the extended model leaves beyond the noise is an error of the model, of which only the size is known. Intervals
    ! therefore include it.
    if (options%finds_intervals .and. .not. d%extended_scale > LARGEST_SCALE) then
      call find_intervals(simulator, whitener, max(d%scale, d%extended_scale), options%fit, d%extended, d%intervals)
      call refit_from_better(simulator, whitener, options%fit, d%intervals, d%extended, is_better)
      if (is_better) call find_intervals(simulator, whitener, max(d%scale, d%extended_scale), options%fit, d%extended, d%intervals)
      call find_support(simulator%parameters, d%design%candidates(d%decision%causes), simulator%n_baseline, &
                        d%extended, d%intervals, d%is_null_excluded, d%is_at_bound)
    end if
    if (options%validates) then
      call validate(simulator, d%extended%active, d%extended%q, d%extended%state, nuisances, options%fit, d%prediction%extended)
      call compare_folds(d%prediction%baseline, d%prediction%extended, d%prediction%gain, d%prediction%gain_error, &
                         d%prediction%has_gain)
    end if
    if (d%decision%verdict /= VERDICT_NAMED) return
    if (options%finds_intervals .and. .not. d%is_null_excluded) then
      call withdraw_name(d%decision, NO_INTERVAL)
    else if (d%is_at_bound) then
      call withdraw_name(d%decision, AT_BOUND)
    else if (options%validates .and. .not. (d%prediction%has_gain .and. d%prediction%gain > d%prediction%gain_error)) then
      call withdraw_name(d%decision, NO_GAIN)
    end if
  end subroutine validate_causes

  !> Reuses a fit: if the verdict has a single cause that was fitted already, this fit becomes the extended model.
  subroutine reuse_fit(d)
    type(diagnosis_t), intent(inout) :: d
    integer :: i
    if (size(d%decision%causes) > 1) return
    do i = 1, size(d%refits)
      if (d%refits(i)%candidate /= d%decision%causes(1)) cycle
      d%extended = d%refits(i)%found
    end do
  end subroutine reuse_fit
end module inference_engine

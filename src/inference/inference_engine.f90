! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs the whole diagnosis of one set of data, with any simulator: baseline, design, calibration, odds and nonlinear refits of
!> the top candidates. It repeats them once with the nuisances linearised about the best candidate. It then decides, validates on
!> locations that were left out, and finds intervals.
!>
!> `run_diagnosis` has the order. Each step takes the parts of the diagnosis that it needs, and returns others.
module inference_engine
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_calibration, only: find_detectable
  use inference_calibration_store, only: calibrate, calibration_store_t
  use inference_causes, only: find_cause_intervals, fit_causes, reject_misfit, validate_causes, withdraw_unsupported
  use inference_decision, only: LEVEL
  use inference_design, only: build_design, design_t
  use inference_growing_fit, only: grow_fit
  use inference_noise_fraction, only: find_noise_fraction
  use inference_record, only: diagnosis_options_t, diagnosis_t, model_t, refit_t, tests_t, LARGEST_SCALE
  use inference_places, only: find_places
  use inference_refine_location, only: add_finer
  use inference_refit, only: fit_baseline, nested_fit_t
  use inference_relinearisation, only: model_about, model_error_t, relinearise, relinearise_extended, relinearise_simulator
  use inference_simulator, only: simulator_t
  use inference_tests, only: needs_no_cause, test_again, test_hypotheses
  use inference_top_candidates, only: replace_refit, refit_top_candidates
  use inference_validation, only: validate, validation_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: diagnosis_options_t, diagnosis_t, refit_t, run_diagnosis

  integer, parameter :: FEWEST_REST = 30    !< smallest number of degrees of freedom with which the size of the noise is estimated
  !> Largest ratio of the variance of errors that neighbours have in common, with that of independent ones, to the declared one. A
  !> larger variance is a misfit. The ratio is not 1, because pixels show a part of the common errors as independent ones: this is
  !> worth 40 % of the variance of an average if the correlation length is half the distance of pixels, 24 % if it is this
  !> distance, and less otherwise.
  real(rp), parameter :: LARGEST_GROWTH = 1.5_rp

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
    class(solver_state_t), allocatable :: state !< of the simulator, near the fit of the baseline
    type(model_t) :: about !< the causes
    logical :: is_new
    integer :: best
    call d%begin()
    call find_model(simulator, starts, options, state, d%model, d%spread, failure)
    if (failure%failed) return
    d%initial_baseline = d%model%baseline
    if (simulator%n_observations < 2*simulator%n_baseline) return
    call calibrate_model(options, size(simulator%effects), d%model, d%detectable_snr, store)
    call test_hypotheses(simulator, options, d%model, state, d%tests, failure)
    if (failure%failed) return
    d%hypotheses = d%tests%hypotheses
    d%decision = d%tests%decision
    if (needs_no_cause(d%decision)) then
      if (options%validates) call validate_baseline(simulator, options, d%initial_baseline, d%model, d%prediction%baseline)
      return
    end if
    call refine_design(simulator, d%tests, state, d%model, is_new, failure)
    if (is_new .and. .not. failure%failed) call test_again(simulator, options, d%model, state, d%tests, failure)
    if (failure%failed) return
    call refit_top_candidates(simulator, options, d%model, d%tests, d%hypotheses, d%refits, d%decision)
    if (options%validates) call validate_baseline(simulator, options, d%initial_baseline, d%model, d%prediction%baseline)
    call relinearise(simulator, options, d%tests%scale, d%model, d%refits, is_new, model_error)
    if (is_new) then
      call test_again(simulator, options, d%model, d%model%baseline%state, d%tests, failure)
      if (failure%failed) return
      call refit_top_candidates(simulator, options, d%model, d%tests, d%hypotheses, d%refits, d%decision)
    end if
    if (present(model_error) .and. size(d%refits) > 0) then
      best = maxloc(d%refits%gain, 1)
      call relinearise_simulator(simulator, options, d%model, d%refits(best)%found, d%refits(best)%gain, model_error, d%rounds, &
                                 failure)
      if (failure%failed) return
      if (d%rounds%found%is_found) call replace_refit(simulator, options, d%model, d%tests, d%rounds%found, d%refits(best), &
                                                       d%hypotheses, d%decision)
    end if
    if (size(d%decision%causes) == 0) return
    call fit_causes(simulator, options, d%model, d%tests, d%refits, d%decision, d%extended)
    if (.not. d%extended%is_found) return
    if (present(model_error)) call relinearise_extended(simulator, options, d%model, d%tests%scale, model_error, d%extended, &
                                                        d%rounds, failure)
    if (failure%failed) return
    about = model_about(d%model, d%rounds)
    d%extended_scale = d%extended%chi2/max(1, simulator%n_observations - size(d%extended%active))
    call reject_misfit(d%extended_scale, d%decision)
    if (options%finds_intervals .and. .not. d%extended_scale > LARGEST_SCALE) call find_cause_intervals(simulator, options, about, &
                       max(d%tests%scale, d%extended_scale), d%decision%causes, d%extended, d%intervals, d%support)
    if (options%validates) call validate_causes(simulator, options, about, d%extended, d%prediction)
    call withdraw_unsupported(options, d%support, d%prediction, d%model%baseline, d%extended, d%decision)
  end subroutine run_diagnosis

  !> Makes the model of which everything else is a test: fits the baseline, and builds the design about its fit. `state` then
  !> belongs to this fit; all refits begin there. For `spread` see fit_baseline. Fails as fit_baseline and build_design do.
  subroutine find_model(simulator, starts, options, state, model, spread, failure)
    class(simulator_t), intent(inout), target :: simulator
    real(rp), intent(in) :: starts(:, :)
    type(diagnosis_options_t), intent(in) :: options
    class(solver_state_t), allocatable, intent(out) :: state
    type(model_t), intent(out), target :: model
    real(rp), allocatable, intent(out) :: spread(:)
    type(failure_t), intent(out) :: failure
    real(rp), allocatable :: nuisances(:, :)
    call simulator%initial_state(state)
    call find_baseline(simulator, starts, options, state, model, spread, nuisances, failure)
    if (failure%failed) return
    call build_design(simulator, model%baseline%q, state, model%whitener%independent_fraction, model%design, failure, &
                      nuisances=nuisances)
    if (failure%failed) return
    deallocate (model%baseline%state)
    allocate (model%baseline%state, source=state)
  end subroutine find_model

  !> Fits the baseline of the model. If the data then show another fraction of correlated noise than before, fits the baseline again
  !> from there. For `state`, `spread` and `nuisances` see fit_baseline.
  subroutine find_baseline(simulator, starts, options, state, model, spread, nuisances, failure)
    class(simulator_t), intent(inout), target :: simulator
    real(rp), intent(in) :: starts(:, :)
    type(diagnosis_options_t), intent(in) :: options
    class(solver_state_t), allocatable, intent(inout) :: state
    type(model_t), intent(inout), target :: model
    real(rp), allocatable, intent(out) :: spread(:), nuisances(:, :)
    type(failure_t), intent(out) :: failure
    real(rp), allocatable :: again(:), best(:, :), begun(:, :)
    real(rp) :: independent_fraction
    integer :: all(simulator%n_observations), i
    logical :: is_new
    all = [(i, i=1, size(all))]
    call model%whitener%init(simulator, all, simulator%independent_fraction(), failure)
    if (failure%failed) return
    begun = starts
    do i = 1, size(begun, 2)
      call grow_fit(simulator, state, simulator%independent_fraction(), options%fit, begun(:, i))
    end do
    call fit_baseline(simulator, begun, options%fit, state, model%whitener, model%baseline, spread, failure, nuisances)
    if (failure%failed .or. options%is_scale_known) return
    call find_noise_fraction(simulator, model%baseline%q, state, model%whitener%independent_fraction, &
                             model%whitener%independent_fraction/LARGEST_GROWTH, independent_fraction, is_new)
    if (.not. is_new) return
    best = reshape(model%baseline%q, [size(model%baseline%q), 1])
    call model%whitener%init(simulator, all, independent_fraction, failure)
    if (failure%failed) return
    call fit_baseline(simulator, best, options%fit, state, model%whitener, model%baseline, again, failure, nuisances)
  end subroutine find_baseline

  !> Finds what the statistics of the model are if the baseline is true, and detectable_snr(effects), the signal-to-noise ratio from
  !> which each effect shows.
  subroutine calibrate_model(options, n_effects, model, detectable_snr, store)
    type(diagnosis_options_t), intent(in) :: options
    integer, intent(in) :: n_effects
    type(model_t), intent(inout) :: model
    real(rp), allocatable, intent(out) :: detectable_snr(:)
    class(calibration_store_t), intent(inout), optional :: store
    logical :: is_scale_known
    ! If the tests leave too few degrees of freedom to estimate the size of the noise, the noise model is trusted.
    is_scale_known = options%is_scale_known .or. model%design%residual_dof < FEWEST_REST
    call calibrate(model%design, n_effects, is_scale_known, options%n_draws, options%seed, model%calibration, store)
    call find_detectable(model%design, model%calibration, n_effects, LEVEL, detectable_snr)
  end subroutine calibrate_model

  !> Validates the baseline: measures how well it predicts locations that were left out of its fit. `baseline` is the fit whose
  !> parameters count, and the fit of the model has the state and the nuisances.
  subroutine validate_baseline(simulator, options, baseline, model, validation)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(nested_fit_t), intent(in) :: baseline
    type(model_t), intent(in) :: model
    type(validation_t), intent(out) :: validation
    call validate(simulator, baseline%active, baseline%q, model%baseline%state, model%design%nuisances, &
                  model%whitener%independent_fraction, options%fit, validation)
  end subroutine validate_baseline

  !> Adds to the design finer positions about the best one of each effect by the `tests` of the scan, and the places that
  !> searches find. The residual degrees of freedom stay those of the scan. `state` belongs to the fit of the baseline, before and
  !> after. Fails as build_design does.
  subroutine refine_design(simulator, tests, state, model, has_finer, failure)
    class(simulator_t), intent(inout), target :: simulator
    type(tests_t), intent(in) :: tests
    class(solver_state_t), allocatable, intent(inout) :: state
    type(model_t), intent(inout), target :: model
    logical, intent(out) :: has_finer
    type(failure_t), intent(out) :: failure
    type(design_t) :: finer
    logical :: has_place
    call add_finer(simulator, model%design, tests%hypotheses%best, has_finer)
    call find_places(simulator, tests, model, has_place)
    has_finer = has_finer .or. has_place
    if (.not. has_finer) return
    call build_design(simulator, model%baseline%q, state, model%whitener%independent_fraction, finer, failure, model%design)
    if (failure%failed) return
    finer%residual_dof = model%design%residual_dof
    model%design = finer
  end subroutine refine_design
end module inference_engine

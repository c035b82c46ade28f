! SPDX-License-Identifier: GPL-3.0-or-later
!> Tests all hypotheses with the tangents at the fit of the baseline, before any of them is fitted.
module inference_tests
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_calibration, only: find_statistics
  use inference_decision, only: decide, decision_t, VERDICT_ADEQUATE, VERDICT_INSUFFICIENT
  use inference_fit_checks, only: check_fit
  use inference_record, only: compress_at, diagnosis_options_t, model_t, tests_t
  use inference_residual_checks, only: combined_log_p
  use inference_simulator, only: simulator_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: needs_no_cause, test_again, test_hypotheses

contains

  !> Computes z, the test statistics, the odds and a first verdict, from the tangents and the checks of residuals. Fails if the
  !> simulator has no result at the fit of the baseline.
  subroutine test_hypotheses(simulator, options, model, from, tests, failure)
    class(simulator_t), intent(inout) :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in) :: model
    class(solver_state_t), intent(in) :: from !< near the baseline
    type(tests_t), intent(out) :: tests
    type(failure_t), intent(out) :: failure
    allocate (tests%z(model%design%k))
    call compress_at(simulator, model%baseline%q, from, model%design, tests%z, tests%residual_square, failure)
    if (failure%failed) return
    call find_statistics(model%design, size(simulator%effects), model%calibration%is_scale_known, tests%z, tests%residual_square, &
                         tests%statistics)
    if (.not. model%calibration%is_scale_known) tests%scale = tests%residual_square/model%design%residual_dof
    tests%z = tests%z/sqrt(tests%scale)
    call check_fit(simulator, model%design, model%baseline, tests%scale, noise_dof(options), tests%checks)
    call weigh(options, size(simulator%effects), model, tests)
  end subroutine test_hypotheses

  !> Does what `test_hypotheses` does with another design, where `tests` are those of the scan, or with that design too. The
  !> statistics of the scan, which give the global p, its residual sum of squares and its checks stay: with finer positions, the
  !> tests may leave no degrees of freedom to estimate the noise.
  subroutine test_again(simulator, options, model, from, tests, failure)
    class(simulator_t), intent(inout) :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in) :: model
    class(solver_state_t), intent(in) :: from !< near the baseline
    type(tests_t), intent(inout) :: tests
    type(failure_t), intent(out) :: failure
    type(tests_t) :: again
    real(rp) :: residual_square
    allocate (again%z(model%design%k))
    call compress_at(simulator, model%baseline%q, from, model%design, again%z, residual_square, failure)
    if (failure%failed) return
    again%residual_square = tests%residual_square
    call find_statistics(model%design, size(simulator%effects), model%calibration%is_scale_known, again%z, again%residual_square, &
                         again%statistics)
    again%statistics%effect = tests%statistics%effect
    again%statistics%unknown = tests%statistics%unknown
    if (.not. model%calibration%is_scale_known) again%scale = again%residual_square/model%design%residual_dof
    again%z = again%z/sqrt(again%scale)
    again%checks = tests%checks
    call weigh(options, size(simulator%effects), model, again)
    tests = again
  end subroutine test_again

  !> Computes the odds and the first verdict of tests that have their z, statistics and checks.
  subroutine weigh(options, n_effects, model, tests)
    type(diagnosis_options_t), intent(in) :: options
    integer, intent(in) :: n_effects
    type(model_t), intent(in) :: model
    type(tests_t), intent(inout) :: tests
    call tests%hypotheses%init(model%design, n_effects, tests%z)
    call decide(model%design, model%calibration, tests%statistics, tests%hypotheses, tests%z, options%seed, tests%decision, &
                combined_log_p(tests%checks))
  end subroutine weigh

  !> Returns the degrees of freedom with which the size of the noise is known. They are huge if the declared noise is trusted.
  pure integer function noise_dof(options)
    type(diagnosis_options_t), intent(in) :: options
    noise_dof = merge(huge(1), options%noise_dof, options%is_scale_known)
  end function noise_dof

  !> Tells whether a first verdict leaves nothing to fit: the baseline is adequate, the data are insufficient, or only the checks of
  !> residuals speak against the baseline.
  pure logical function needs_no_cause(decision)
    type(decision_t), intent(in) :: decision
    needs_no_cause = decision%verdict == VERDICT_ADEQUATE .or. decision%verdict == VERDICT_INSUFFICIENT .or. &
                     decision%is_rejected_by_checks
  end function needs_no_cause
end module inference_tests

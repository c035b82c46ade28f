! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the options and all results of a diagnosis.
module inference_record
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use inference_residual_checks, only: residual_check_t
  use inference_calibration, only: calibration_t, statistics_t
  use inference_decision, only: decision_t
  use inference_design, only: design_t
  use inference_hypotheses, only: hypotheses_t
  use inference_refit, only: nested_fit_t
  use inference_simulator, only: simulator_t
  use inference_validation, only: validation_t
  use inference_whitener, only: whitener_t
  use least_squares_fit, only: fit_options_t
  use least_squares_profile, only: interval_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: compress_at, diagnosis_options_t, diagnosis_t, refit_t, rounds_t

  real(rp), parameter, public :: LARGEST_SCALE = 2 !< times the variance of the noise, as far as that may be wrong

  type :: diagnosis_options_t
    !> Finds a sum of squares of about a thousand to a hundredth: log evidences are compared in units of one.
    type(fit_options_t) :: fit = fit_options_t(reduction_tolerance=1.0e-5_rp, most_rejections=4)
    integer :: n_draws = 4000            !< of the bootstrap
    integer(i8) :: seed = 1
    integer :: most_refits = 5           !< top candidates that are fitted in full
    logical :: is_scale_known = .false.  !< the declared noise is believed; otherwise its scale is estimated
    !> Degrees of freedom of an estimate of the noise that does not come from the fits, see check_residuals.
    integer :: noise_dof = 0
    logical :: validates = .true.
    logical :: finds_intervals = .true.
  end type diagnosis_options_t

  !> A top candidate that was fitted without linearisation.
  type :: refit_t
    integer :: candidate = 0
    type(nested_fit_t) :: found
    real(rp) :: gain = 0                 !< of the sum of squares over the baseline, in units of the noise
    real(rp) :: linear_gain = 0             !< the same by the tangents
    real(rp) :: remainder_log_p = 0
  end type refit_t

  !> Prediction of locations that a fit did not use.
  type :: prediction_t
    type(validation_t) :: baseline, extended
    real(rp) :: gain = 0, gain_error = 0 !< log predictive density per location left out, of the extended over the baseline
    logical :: has_gain = .false.
  end type prediction_t

  !> A fit about which a simulator that is an approximation was linearised anew, in rounds.
  type :: rounds_t
    type(nested_fit_t) :: found          !< the last of them; not found: there was none
    type(whitener_t) :: whitener         !< with the directions of errors there
    real(rp), allocatable :: nuisances(:, :) !< (n, :) these directions
    real(rp), allocatable :: moved(:)    !< (rounds) largest change of a parameter of the causes, in units of its sd
    logical :: has_settled = .false.     !< the last change is small
    character(:), allocatable :: reason  !< why there were no more rounds, if one failed
  end type rounds_t

  !> Everything that came out.
  type :: diagnosis_t
    type(whitener_t) :: whitener
    type(nested_fit_t) :: initial_baseline !< the baseline for itself
    type(nested_fit_t) :: baseline       !< the same with the nuisances of the refits, which may be those about the top candidate
    real(rp), allocatable :: spread(:)   !< of the starts, see fit_baseline
    type(design_t) :: design
    type(calibration_t) :: calibration
    real(rp) :: scale = 1                !< estimated over declared variance of the noise
    real(rp), allocatable :: z(:)        !< in units of the noise
    real(rp) :: residual_square = 0
    real(rp) :: extended_scale = 0       !< variance of what the extended model leaves over that of the noise model
    type(statistics_t) :: statistics
    type(residual_check_t), allocatable :: checks(:) !< of the residuals of the baseline
    type(hypotheses_t) :: hypotheses
    type(decision_t) :: linear, decision !< before and after the refits
    type(refit_t), allocatable :: refits(:)
    type(rounds_t) :: rounds             !< of the best refit, or of the extended model if that is another
    type(nested_fit_t) :: extended       !< with the causes of the verdict; not found: none
    type(interval_t), allocatable :: intervals(:) !< of the parameters of the causes
    logical :: is_null_excluded = .false. !< for each of the causes
    logical :: is_at_bound = .false.     !< a parameter that excludes its null
    type(prediction_t) :: prediction
    real(rp), allocatable :: detectable_snr(:) !< (effects)
  end type diagnosis_t

contains

  !> Returns z and the residual sum of squares of the data at the point q, found from the state `from`.
  subroutine compress_at(simulator, q, from, design, z, residual_square, failure)
    class(simulator_t), intent(inout) :: simulator
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    type(design_t), intent(in) :: design
    real(rp), intent(out) :: z(:), residual_square
    type(failure_t), intent(out) :: failure
    real(rp) :: residuals(simulator%n_observations), jacobian(simulator%n_observations, 0)
    logical :: is_valid
    call simulator%evaluate(q, [integer ::], from, residuals, jacobian, is_valid)
    if (.not. is_valid) then
      z = 0
      residual_square = 0
      call failure%raise('the wing cannot be computed again at a point that the fit had reached: check loads, units and [Wing]')
      return
    end if
    call design%compress(residuals, q(:simulator%n_baseline), z, residual_square)
  end subroutine compress_at
end module inference_record

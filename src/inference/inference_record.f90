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
  public :: compress_at, diagnosis_options_t, diagnosis_t, model_t, prediction_t, refit_t, rounds_t, support_t, tests_t

  real(rp), parameter, public :: LARGEST_SCALE = 2 !< largest ratio of misfit to noise variance that a wrong noise model may explain

  type :: diagnosis_options_t
    !> The tolerance gives a sum of squares of about 1000 to within 0.01. This suffices, as log evidences are compared in units of
    !> 1.
    type(fit_options_t) :: fit = fit_options_t(reduction_tolerance=1.0e-5_rp, most_rejections=4)
    integer :: n_draws = 4000            !< number of draws of the bootstrap
    integer(i8) :: seed = 1
    integer :: most_refits = 5           !< top candidates that are fitted in full
    logical :: is_scale_known = .false.  !< the size of the noise is as declared; otherwise it is estimated
    !> Degrees of freedom of an estimate of the noise that does not come from the fits, such as the scatter of pixels; huge: there
    !> is none, and the declared size of the errors holds. See check_residuals.
    integer :: noise_dof = huge(1)
    logical :: validates = .true.
    logical :: finds_intervals = .true.
  end type diagnosis_options_t

  !> The fit of the baseline, and what is linear about it.
  type :: model_t
    type(whitener_t) :: whitener         !< with the directions of the nuisances
    type(nested_fit_t) :: baseline
    type(design_t) :: design
    type(calibration_t) :: calibration   !< of the tests, from the first design
  end type model_t

  !> What the tangents of a model and the residuals of its baseline say, before any other hypothesis is fitted.
  type :: tests_t
    real(rp), allocatable :: z(:)        !< in units of the noise
    real(rp) :: residual_square = 0
    real(rp) :: scale = 1                !< ratio of estimated to declared variance of the noise
    type(statistics_t) :: statistics
    type(residual_check_t), allocatable :: checks(:) !< of the residuals of the baseline
    type(hypotheses_t) :: hypotheses
    type(decision_t) :: decision
  end type tests_t

  !> A top candidate that was fitted without linearisation.
  type :: refit_t
    integer :: candidate = 0
    type(nested_fit_t) :: found
    real(rp) :: gain = 0                 !< decrease of the sum of squares from that of the baseline, in units of the noise
    real(rp) :: linear_gain = 0             !< the same in the linear approximation
    real(rp) :: remainder_log_p = 0
  end type refit_t

  !> Prediction of locations that a fit did not use.
  type :: prediction_t
    type(validation_t) :: baseline, extended
    real(rp) :: gain = 0, gain_error = 0 !< of the log predictive density per left-out location, extended model over baseline
    logical :: has_gain = .false.
  end type prediction_t

  !> The rounds in which an approximate simulator was linearised again about a fit and the fit was repeated.
  type :: rounds_t
    type(nested_fit_t) :: found          !< fit of the last round; not found if there was no round
    type(whitener_t) :: whitener         !< with the directions of errors at this fit
    real(rp), allocatable :: nuisances(:, :) !< (n, :) these directions
    real(rp), allocatable :: moved(:)    !< (rounds) largest change of a parameter of the causes, in units of its sd
    logical :: has_settled = .false.     !< the last change is small
    character(:), allocatable :: reason  !< why the rounds ended, if one of them failed
  end type rounds_t

  !> What the intervals say about the causes.
  type :: support_t
    logical :: is_null_excluded = .false. !< each cause has an interval that excludes its null
    logical :: is_at_bound = .false.     !< a parameter whose interval excludes its null lies at a bound
  end type support_t

  !> All results of a diagnosis.
  type :: diagnosis_t
    real(rp), allocatable :: spread(:)   !< of the starts, see fit_baseline
    type(nested_fit_t) :: initial_baseline !< the baseline with the nuisances at its own fit
    type(model_t) :: model               !< with the nuisances of the refits, which may be those about the top candidate
    real(rp), allocatable :: detectable_snr(:) !< (effects)
    type(tests_t) :: tests               !< before the refits
    type(hypotheses_t) :: hypotheses     !< after the refits
    type(refit_t), allocatable :: refits(:)
    type(decision_t) :: decision
    type(rounds_t) :: rounds             !< of the best refit, or of the extended model if that is another
    type(nested_fit_t) :: extended       !< the baseline with the causes of the verdict; not found if there is none
    real(rp) :: extended_scale = 0       !< variance of the extended model's residuals over that of the noise model
    type(interval_t), allocatable :: intervals(:) !< of the parameters of the causes
    type(support_t) :: support           !< by these intervals
    type(prediction_t) :: prediction
  contains
    procedure :: begin => diagnosis_begin
  end type diagnosis_t

contains

  !> Makes the diagnosis of data that are insufficient: there are no refits and no causes.
  subroutine diagnosis_begin(self)
    class(diagnosis_t), intent(inout) :: self
    allocate (self%refits(0))
    self%decision%causes = [integer ::]
    self%decision%set = [integer ::]
    self%decision%wider = [integer ::]
  end subroutine diagnosis_begin

  !> Computes z and the residual sum of squares of the data at the point q, starting from the state `from`. Fails if the simulator
  !> has no result there.
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
      call failure%raise('the model cannot be computed again at a point that the fit has reached: '// &
                         'check the loads, their units and the input')
      return
    end if
    call design%compress(residuals, q(:simulator%n_baseline), z, residual_square)
  end subroutine compress_at
end module inference_record

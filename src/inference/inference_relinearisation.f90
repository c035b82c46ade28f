! SPDX-License-Identifier: GPL-3.0-or-later
!> Linearises the nuisances about the fit of the top candidate instead of that of the baseline.
!>
!> The effect of an error of a force, of a place or of the mesh depends on the wing. If the baseline lacks a cause, it gives wrong
!> directions for these errors; the rest then looks like a second cause, and intervals are too narrow. Where a cause is clear, the
!> nuisances are therefore computed anew at its fit, and all hypotheses are compared again with these.
module inference_relinearisation
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_design, only: build_design, design_t
  use inference_record, only: diagnosis_options_t, diagnosis_t
  use inference_refit, only: fit_nested, nested_fit_t, relinearise_nuisances
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: model_error_t, relinearise

  !> Directions of errors of a simulator that require fits of other models, such as one on another mesh.
  type, abstract :: model_error_t
  contains
    !> Gives `state` new ones at q, to which it belongs after a fit with the whitener. If that cannot be done the old ones stay.
    procedure(renew_interface), deferred :: renew
  end type model_error_t

  abstract interface
    subroutine renew_interface(self, whitener, q, state)
      import :: model_error_t, rp, solver_state_t, whitener_t
      class(model_error_t), intent(inout) :: self
      type(whitener_t), intent(in), target :: whitener
      real(rp), intent(in) :: q(:)
      class(solver_state_t), intent(inout) :: state
    end subroutine renew_interface
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

  !> Returns twice the negative logarithm of the probability density of data and parameters, without a constant.
  real(rp) function minus_two_log_posterior(found, whitener, scale)
    type(nested_fit_t), intent(in) :: found
    type(whitener_t), intent(in) :: whitener
    real(rp), intent(in) :: scale
    minus_two_log_posterior = found%cost()/scale + whitener%log_determinant
  end function minus_two_log_posterior
end module inference_relinearisation

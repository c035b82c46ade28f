! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks whether a fit leaves nothing but noise, whatever the catalogue says. It tests the residuals and the size of errors
!> with a declared sd.
module inference_fit_checks
  use base_kinds, only: rp
  use inference_declared_errors, only: check_declared_errors
  use inference_residual_checks, only: check_residuals, residual_check_t
  use inference_design, only: design_t
  use inference_refit, only: nested_fit_t
  use inference_simulator, only: simulator_t
  implicit none
  private
  public :: check_fit

contains

  !> Returns the checks of the residuals of a fit, with the whitener of the design. There are none if the simulator has no result
  !> there. For `scale` and `noise_dof` see check_residuals.
  subroutine check_fit(simulator, design, fitted, scale, noise_dof, checks)
    class(simulator_t), intent(inout) :: simulator
    type(design_t), intent(in) :: design
    type(nested_fit_t), intent(in) :: fitted
    real(rp), intent(in) :: scale
    integer, intent(in) :: noise_dof
    type(residual_check_t), allocatable, intent(out) :: checks(:)
    real(rp) :: residuals(simulator%n_observations), nothing(simulator%n_observations, 0)
    real(rp) :: responses(simulator%n_observations)
    logical :: is_valid
    call simulator%evaluate(fitted%q, [integer ::], fitted%state, residuals, nothing, is_valid)
    allocate (checks(0))
    if (.not. is_valid) return
    responses = simulator%labels%observed + residuals
    call design%whitener%apply_one(residuals)
    call check_residuals(simulator%labels, design, residuals, responses, simulator%n_baseline, scale, noise_dof, checks)
    if (.not. allocated(simulator%nuisance_kind)) return
    call check_declared_errors(design, simulator%nuisance_kind, simulator%nuisance_names, residuals, checks)
  end subroutine check_fit
end module inference_fit_checks

! SPDX-License-Identifier: GPL-3.0-or-later
!> Differentiates an equilibrium shape with respect to parameters, with one back-substitution for each.
!>
!> The equilibrium g(u, p) = F gives du/dp = -K^-1 dg/dp; K is already factorised at the end of the statics. Any parameter that
!> changes the stiffness is possible, also one that the model does not have (see solid_stiffness_effects). For a parameter that
!> changes the load: du/dp = K^-1 dF/dp.
module solid_sensitivity
  use base_kinds, only: rp
  use solid_equilibrium, only: equilibrium_t
  use solid_model, only: solid_model_t
  use solid_stiffness, only: stiffness_t
  implicit none
  private
  public :: direction_sensitivity, force_sensitivity

contains

  !> Returns the derivative(3, n_all) [m] of the equilibrium u when the stiffness changes along `direction`. Call it
  !> right after a converged `solve_static` of the same model, whose factorisation it uses.
  subroutine direction_sensitivity(work, model, u, direction, derivative)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :)
    type(stiffness_t), intent(in) :: direction
    real(rp), intent(out) :: derivative(:, :)
    call model%gradient(u, work%g, direction)
    call work%newton_step(model, work%g)
    derivative = work%du
  end subroutine direction_sensitivity

  !> Returns the derivative(3, n_all) [m] of the equilibrium when the dead load changes along force(3, n_all) [N]; see
  !> `direction_sensitivity`.
  subroutine force_sensitivity(work, model, force, derivative)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: force(:, :)
    real(rp), intent(out) :: derivative(:, :)
    work%g = -force
    call work%newton_step(model, work%g)
    derivative = work%du
  end subroutine force_sensitivity
end module solid_sensitivity

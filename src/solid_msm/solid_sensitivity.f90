! SPDX-License-Identifier: GPL-3.0-or-later
!> Derivatives of an equilibrium shape with respect to the parameters, by one back-substitution each.
!>
!> The equilibrium g(u, p) = F gives du/dp = -K^-1 dg/dp; K is factorised already when the statics end.
module solid_sensitivity
  use base_kinds, only: rp
  use solid_equilibrium, only: equilibrium_t
  use solid_model, only: solid_model_t
  use solid_params, only: parameter_t
  use solid_stiffness, only: stiffness_t
  implicit none
  private
  public :: shape_sensitivities

contains

  !> derivatives(3, n_all, size(numbers)) [m per unit] of the equilibrium u with respect to the
  !> parameters with these numbers, per log unit where the parameter's scale is logarithmic. Right
  !> after a converged `solve_static` of the same model, whose factorisation it uses.
  subroutine shape_sensitivities(work, model, u, numbers, derivatives)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :)
    integer, intent(in) :: numbers(:)
    real(rp), intent(out) :: derivatives(:, :, :)
    type(parameter_t) :: parameter
    type(stiffness_t) :: dk
    integer :: p
    do p = 1, size(numbers)
      parameter = model%params%describe(numbers(p))
      call model%stiffness_derivative(numbers(p), parameter%is_log, dk)
      call model%gradient(u, work%g, dk)
      call work%newton_step(model, work%g)
      derivatives(:, :, p) = work%du
    end do
  end subroutine shape_sensitivities
end module solid_sensitivity

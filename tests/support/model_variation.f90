! SPDX-License-Identifier: GPL-3.0-or-later
!> Varies single parameters of a wing's model, and differentiates its equilibria with respect to them.
module model_variation
  use base_kinds, only: rp
  use solid_equilibrium, only: equilibrium_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_sensitivity, only: direction_sensitivity
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: parameter_direction
  implicit none
  private
  public :: set_parameter, shape_sensitivities

contains

  !> Sets the parameter of the model with this number to a value, in its unit.
  subroutine set_parameter(model, number, value)
    type(solid_model_t), intent(inout) :: model
    integer, intent(in) :: number
    real(rp), intent(in) :: value
    type(solid_params_t) :: params
    params = model%params
    call params%set(number, value)
    call model%set_params(params)
  end subroutine set_parameter

  !> Returns derivatives(3, n_all, size(numbers)) of the equilibrium u with respect to the parameters with these numbers: [m] per
  !> unit, or per log unit where the scale of the parameter is logarithmic. Call it right after a converged `solve_static` of the
  !> same model, whose factorisation it uses.
  subroutine shape_sensitivities(work, model, u, numbers, derivatives)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :)
    integer, intent(in) :: numbers(:)
    real(rp), intent(out) :: derivatives(:, :, :)
    type(stiffness_t) :: dk
    integer :: p
    do p = 1, size(numbers)
      call parameter_direction(model, numbers(p), dk)
      call direction_sensitivity(work, model, u, dk, derivatives(:, :, p))
    end do
  end subroutine shape_sensitivities
end module model_variation

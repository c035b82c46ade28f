! SPDX-License-Identifier: GPL-3.0-or-later
!> How far gradients and tangents of a wing's model are from differences of eighth order.
module derivative_checks
  use base_kinds, only: rp
  use solid_extension, only: extension_axial
  use solid_model, only: solid_model_t
  use solid_tangent, only: assemble_tangent
  implicit none
  private
  public :: derivative_errors

  !> The derivative is sum over s of STENCIL(s) (f(x + s h) - f(x - s h))/h, with an error of h^8.
  real(rp), parameter, public :: STENCIL(4) = [4/5.0_rp, -1/5.0_rp, 4/105.0_rp, -1/280.0_rp]

contains

  !> Relative errors, at displacements u(3, n_all) [m] along `direction` (3, n_all), zero at clamped points, of the
  !> gradient as the derivative of the energy (of its component along the direction), and of the assembled tangent as
  !> the derivative of the gradient (largest component). Steps of the differences are h times the direction. A model
  !> without energy has infinite errors.
  subroutine derivative_errors(model, u, direction, h, gradient_error, tangent_error)
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :), direction(:, :), h
    real(rp), intent(out) :: gradient_error, tangent_error
    real(rp), dimension(3, model%n_all) :: v, g, gp, gm, fd
    real(rp) :: slope, axial(model%springs%n), blocks(3, 3, size(model%pattern%rows)), hv(3, model%n_free)
    integer :: s
    gradient_error = huge(h)
    tangent_error = huge(h)
    call model%gradient(u, g)
    slope = 0
    fd = 0
    do s = 1, 4
      v = u + s*h*direction
      slope = slope + STENCIL(s)*model%energy(v)/h
      call model%gradient(v, gp)
      v = u - s*h*direction
      slope = slope - STENCIL(s)*model%energy(v)/h
      call model%gradient(v, gm)
      fd = fd + STENCIL(s)*(gp - gm)/h
    end do
    call extension_axial(model%springs, model%stiffness%extension, u, axial)
    call assemble_tangent(model, u, axial, .false., blocks)
    hv = 0
    call model%pattern%multiply(blocks, 1.0_rp, direction(:, model%movable), hv)
    if (.not. (abs(slope) > 0 .and. maxval(abs(hv)) > 0)) return
    gradient_error = abs(sum(g*direction) - slope)/abs(slope)
    tangent_error = maxval(abs(hv - fd(:, model%movable)))/maxval(abs(hv))
  end subroutine derivative_errors
end module derivative_checks

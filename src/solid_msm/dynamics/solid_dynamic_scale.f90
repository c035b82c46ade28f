! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the sizes of forces that the tolerance of Newton's method refers to in a time step of a wing.
module solid_dynamic_scale
  use base_kinds, only: rp
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  implicit none
  private
  public :: hinge_forces, momentum_norm

contains

  !> Returns the 2-norm of the forces [N] if all hinges turn by 1 rad: multiplied by the rounding error of directions, it is the
  !> smallest residual that a wing without motion can reach.
  pure real(rp) function hinge_forces(model) result(norm)
    type(solid_model_t), intent(in) :: model
    integer :: h
    norm = 0
    do h = 1, size(model%plans)
      norm = norm + (model%stiffness%hinge(h)/ &
                     minval(model%plans(h)%lengths, mask=model%plans(h)%lengths > 0))**2
    end do
    norm = sqrt(norm)
  end function hinge_forces

  !> Returns the 2-norm of mass times velocity.
  pure real(rp) function momentum_norm(inertia, v) result(norm)
    type(inertia_t), intent(in) :: inertia
    real(rp), intent(in) :: v(:, :)
    integer :: i
    norm = 0
    do i = 1, size(v, 2)
      norm = norm + inertia%mass(i)**2*(v(1, i)**2 + v(2, i)**2 + v(3, i)**2)
    end do
    norm = sqrt(norm)
  end function momentum_norm
end module solid_dynamic_scale

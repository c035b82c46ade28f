! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the sizes of forces that the tolerances of Newton's method refer to in a time step of a wing.
module solid_dynamic_scale
  use base_kinds, only: rp
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  implicit none
  private
  public :: linear_tolerance, momentum_norm, rounding_forces

contains

  !> Returns the smallest residuals [N] that rounding permits: for each m of displacement, and in a wing that does not move.
  pure function rounding_forces(model) result(smallest)
    type(solid_model_t), intent(in) :: model
    real(rp) :: smallest(2)
    smallest(1) = 4*epsilon(smallest)*model%params%k_vein*sqrt(real(model%n_free, rp))
    smallest(2) = 8*epsilon(smallest)*hinge_forces(model)
  end function rounding_forces

  !> Returns the share of the residual to which the equations of an iteration are solved. It is large, because Newton's method
  !> corrects the rest; near the end of the step it is the share that ends the step.
  pure real(rp) function linear_tolerance(size_r, small)
    real(rp), intent(in) :: size_r, small !< [N] residual, now and in the end
    real(rp), parameter :: USUAL = 3.0e-3_rp, FINEST = 1.0e-3_rp, COARSEST = 0.1_rp
    linear_tolerance = min(0.5_rp*small/size_r, COARSEST)
    if (linear_tolerance < FINEST) linear_tolerance = USUAL
  end function linear_tolerance

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

! SPDX-License-Identifier: GPL-3.0-or-later
!> Minimises the potential to find a stable equilibrium after the loading path of a wing has met a fold.
!>
!> Steps follow Newton directions of the exact tangent if it is positive definite and the residual is small, and of its positive
!> semidefinite part otherwise. There is a line search on the potential, and a proximal shift after failures.
module solid_descent
  use base_kinds, only: rp
  use solid_equilibrium, only: equilibrium_t
  use solid_extension, only: extension_axial
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_vectors, only: longest
  implicit none
  private
  public :: descend

contains

  !> Moves u(3, n_all) [m] downhill in potential until the residual at the stage of `work` is below `tolerance` times its force
  !> scale. `converged` is false after `limit` factorisations. On exit the axial forces of `work` follow the law of the springs.
  subroutine descend(work, model, load, tolerance, limit, u, converged)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: tolerance
    integer, intent(in) :: limit
    real(rp), intent(inout) :: u(:, :)
    logical, intent(out) :: converged
    integer, parameter :: CAUTION = 5 ! iterations without the exact tangent after it failed
    real(rp), parameter :: EXACT_BELOW = 0.3_rp
    real(rp) :: potential, size_g, shift, least_shift, shift_unit
    integer :: start, since_failure
    logical :: is_spd, exact, accepted
    start = work%cholesky%n_factorisations
    shift_unit = work%force_scale/model%size
    least_shift = 1.0e-13_rp*model%params%k_vein
    shift = least_shift
    since_failure = CAUTION
    call work%law_axial(model, u)
    call work%residual(model, load, u, work%g)
    size_g = norm2(work%g)
    potential = work%potential(model, load, u)
    do
      converged = size_g <= tolerance*work%force_scale
      if (converged .or. work%cholesky%n_factorisations - start >= limit) exit
      exact = size_g < EXACT_BELOW*work%force_scale .and. since_failure >= CAUTION
      since_failure = since_failure + 1
      call work%factorise(model, load, u,.not. exact, shift, is_spd)
      if (.not. is_spd .and. exact) then
        since_failure = 0
        call work%factorise(model, load, u, .true., shift, is_spd)
      end if
      if (.not. is_spd) then
        shift = max(10*shift, 1.0e-5_rp*shift_unit)
        cycle
      end if
      call work%newton_step(model, work%g)
      call search_line(work, model, load, u, size_g, potential, accepted)
      if (accepted) then
        shift = 0.2_rp*shift
        if (shift < 1.0e-6_rp*shift_unit) shift = least_shift
      else
        since_failure = 0
        shift = max(10*shift, 1.0e-5_rp*shift_unit)
        call work%law_axial(model, u)
      end if
      call work%residual(model, load, u, work%g)
      size_g = norm2(work%g)
    end do
    call work%law_axial(model, u)
  end subroutine descend

  !> Moves from u along the step of `work` as far as the potential decreases sufficiently or, if rounding hides this, the size of
  !> the residual does. If no such point exists, u and the axial forces stay.
  subroutine search_line(work, model, load, u, size_g, potential, accepted)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(inout) :: u(:, :)
    real(rp), intent(in) :: size_g         !< [N] of the residual at u
    real(rp), intent(inout) :: potential   !< [J] at u
    logical, intent(out) :: accepted
    real(rp), parameter :: ARMIJO = 1.0e-3_rp, ROUNDING = 1.0e-11_rp
    real(rp) :: new_potential, slope, largest, limit_step, step
    integer :: halving
    limit_step = model%size/6
    largest = longest(work%du)
    if (largest > limit_step) work%du = work%du*(limit_step/largest)
    slope = sum(work%g*work%du)
    accepted = .false.
    step = 1
    do halving = 1, 12
      work%trial = u + step*work%du
      new_potential = work%potential(model, load, work%trial)
      accepted = new_potential <= potential + ARMIJO*step*slope
      if (.not. accepted .and. abs(new_potential - potential) < ROUNDING*abs(potential)) then
        call work%residual(model, load, work%trial, work%g)
        accepted = norm2(work%g) < size_g
      end if
      if (accepted) exit
      step = 0.5_rp*step
    end do
    if (.not. accepted) return
    work%du = step*work%du
    call extension_axial(model%springs, model%stiffness%extension, u, work%axial, work%du)
    u = work%trial
    potential = new_potential
  end subroutine search_line
end module solid_descent

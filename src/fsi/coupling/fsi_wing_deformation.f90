! SPDX-License-Identifier: GPL-3.0-or-later
!> Converts the motion of a wing within its frame from the mechanics (SI units, axes of the wing file) to the flow (L and T,
!> axes of the wing frame).
module fsi_wing_deformation
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fsi_flapping_wings, only: deformation_t, flapping_wings_t
  use fsi_kinematics, only: wing_pose_t
  use fsi_wing_mirror, only: mirror_vectors
  use io_units, only: unit_scales_t
  use solid_dynamics, only: dynamic_state_t
  implicit none
  private
  public :: check_deflections, set_deformation, predict_deformation, rotate_forces_to_space

contains

  !> Fails if a point of a wing is displaced by more than `limit` times the length of the wing.
  subroutine check_deflections(wings, limit, failure)
    type(flapping_wings_t), intent(in) :: wings
    real(rp), intent(in) :: limit
    type(failure_t), intent(inout) :: failure
    integer :: i
    do i = 1, size(wings%deformation)
      if (.not. sqrt(maxval(sum(wings%deformation(i)%u**2, 1))) > limit*wings%params%wings(i)%length()) cycle
      call failure%raise('the '//trim(wings%params%wings(i)%side)//' wing bends beyond the limit [Flexible_wing] '// &
                         'largest_deflection: check the stiffness in [Wing] and [units], or raise the limit')
    end do
  end subroutine check_deflections

  !> Sets `bent` to the displacements and velocities that `state` holds.
  pure subroutine set_deformation(state, units, is_mirrored, bent)
    type(dynamic_state_t), intent(in) :: state
    type(unit_scales_t), intent(in) :: units
    logical, intent(in) :: is_mirrored
    type(deformation_t), intent(inout) :: bent
    integer :: n
    n = size(bent%u, 2)
    bent%u = state%u(:, :n)/units%length
    bent%v = state%v(:, :n)*(units%time/units%length)
    bent%a = state%a(:, :n)*(units%time**2/units%length)
    if (.not. is_mirrored) return
    call mirror_vectors(bent%u)
    call mirror_vectors(bent%v)
    call mirror_vectors(bent%a)
  end subroutine set_deformation

  !> Sets the displacement in `bent` to the value that is extrapolated to the end of a step dt [T] from the velocity in the last
  !> step, to second order, or in the first step to first order.
  pure subroutine predict_deformation(state, units, dt, is_mirrored, bent)
    type(dynamic_state_t), intent(in) :: state
    type(unit_scales_t), intent(in) :: units
    real(rp), intent(in) :: dt
    logical, intent(in) :: is_mirrored
    type(deformation_t), intent(inout) :: bent
    real(rp) :: h
    integer :: n
    n = size(bent%u, 2)
    h = dt*units%time
    bent%u = (state%u(:, :n) + h*state%v(:, :n))/units%length
    if (state%old_step > 0) bent%u = bent%u + (h**2/(2*state%old_step*units%length))*(state%v(:, :n) - state%old_v(:, :n))
    if (is_mirrored) call mirror_vectors(bent%u)
  end subroutine predict_deformation

  !> Sets on_points(3, n) [rho L^4/T^2], in space, to the forces force(3, at least n) [N] of the wing whose frame is at `pose`.
  pure subroutine rotate_forces_to_space(force, units, is_mirrored, pose, on_points)
    real(rp), intent(in) :: force(:, :)
    type(unit_scales_t), intent(in) :: units
    logical, intent(in) :: is_mirrored
    type(wing_pose_t), intent(in) :: pose
    real(rp), intent(inout) :: on_points(:, :)
    integer :: p
    on_points = force(:, :size(on_points, 2))/(units%mass*units%length/units%time**2)
    if (is_mirrored) call mirror_vectors(on_points)
    do p = 1, size(on_points, 2)
      on_points(:, p) = pose%vector_to_space(on_points(:, p))
    end do
  end subroutine rotate_forces_to_space
end module fsi_wing_deformation

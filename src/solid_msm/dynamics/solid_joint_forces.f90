! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the elastic forces of the joints of a wing that moves in its natural modes, and how they change with stiffness. Joints
!> have the stiffness of the flat wing.
module solid_joint_forces
  use base_kinds, only: rp
  use solid_modal, only: modal_t
  use solid_model, only: solid_model_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: keep_joints
  use solid_tangent, only: assemble_tangent
  implicit none
  private
  public :: apply_joints

contains

  !> Computes stiff(3, n_all, modes) = K_joints Phi for the first modes, with the parameters of the model; or dK_joints Phi if all
  !> stiffness changes along `direction` (solid_stiffness_effects), which is 0 if the hinges of joints do not change.
  subroutine apply_joints(modal, stiff, direction)
    class(modal_t), intent(in) :: modal
    real(rp), intent(out) :: stiff(:, :, :)
    type(stiffness_t), intent(in), optional :: direction
    type(solid_model_t), allocatable :: probe
    real(rp), allocatable :: blocks(:, :, :), rest(:, :), axial(:), f(:, :)
    integer :: i
    stiff = 0
    if (.not. any(modal%model%plans%joint > 0)) return
    if (present(direction)) then
      if (.not. any(modal%model%plans%joint > 0 .and. abs(direction%hinge) > 0)) return
    end if
    call keep_joints(modal%model, probe)
    if (present(direction)) probe%stiffness%hinge = merge(direction%hinge, 0.0_rp, probe%plans%joint > 0)
    allocate (blocks(3, 3, size(probe%pattern%rows)), rest(3, probe%n_all), f(3, probe%n_free))
    rest = 0
    axial = probe%springs%tension
    call assemble_tangent(probe, rest, axial, .false., blocks)
    do i = 1, size(stiff, 3)
      f = 0
      call probe%pattern%multiply(blocks, 1.0_rp, modal%shapes(:, probe%movable, i), f)
      stiff(:, probe%movable, i) = f
    end do
  end subroutine apply_joints
end module solid_joint_forces

! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes K'[du], the derivative of the tangent stiffness of a wing when its displacements change along a given direction.
!>
!> Springs are differentiated exactly, because they are 1e5 times stiffer than the elements that bend, and differences would lose
!> this factor in accuracy. The tangent of the plate is constant. Hinges, and the additional terms of veins and edges, are
!> differentiated by central differences of fourth order, (f(-2h) - 8 f(-h) + 8 f(h) - f(2h))/(12 h), where h turns no segment by
!> more than TURN. Their error is TURN^4/30 times a fifth derivative, plus 3/2 epsilon/TURN from rounding, about 1e-12 of the
!> bending stiffness per radian.
module solid_tangent_change
  use base_kinds, only: rp
  use solid_extension, only: extension_tangent_change
  use solid_model, only: solid_model_t
  use solid_tangent, only: assemble_tangent
  implicit none
  private
  public :: add_tangent_change

  real(rp), parameter :: TURN = 1.0e-3_rp !< [rad]
  real(rp), parameter :: WEIGHTS(4) = [1.0_rp, -8.0_rp, 8.0_rp, -1.0_rp]/12, AT(4) = [-2.0_rp, -1.0_rp, 1.0_rp, 2.0_rp]

contains

  !> Adds the derivative along du(3, n_all) of the tangent of `model` at displacements u(3, n_all) [m], where `axial` are the axial
  !> forces [N] of the springs' law, to blocks(3, 3, :) [N/m, per unit of the direction]. `probe` is a copy of the model as work
  !> space; its stiffness is undefined afterwards.
  subroutine add_tangent_change(model, probe, u, axial, du, blocks)
    type(solid_model_t), intent(in) :: model
    type(solid_model_t), intent(inout) :: probe
    real(rp), intent(in) :: u(:, :), axial(:), du(:, :)
    real(rp), intent(inout) :: blocks(:, :, :)
    real(rp), allocatable :: beside(:, :, :), none(:)
    real(rp) :: rate
    integer :: n
    rate = largest_turn(model, du)
    if (.not. rate > 0) return
    call extension_tangent_change(model%springs, model%stiffness%extension, u, axial, du, blocks)
    probe%stiffness = model%stiffness
    probe%stiffness%extension = 0
    probe%stiffness%plate = 0
    probe%stiffness%has_edges = .false.
    allocate (beside(3, 3, size(blocks, 3)), none(size(axial)))
    none = 0
    do n = 1, size(AT)
      call assemble_tangent(probe, u + (AT(n)*TURN/rate)*du, none, .false., beside)
      blocks = blocks + (WEIGHTS(n)*rate/TURN)*beside
    end do
  end subroutine add_tangent_change

  !> Returns the largest change of a segment over its length.
  pure real(rp) function largest_turn(model, du) result(rate)
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: du(:, :)
    integer :: s
    rate = 0
    associate (springs => model%springs)
      do s = 1, springs%n
        rate = max(rate, norm2(du(:, springs%nodes(2, s)) - du(:, springs%nodes(1, s)))/springs%l0(s))
      end do
    end associate
  end function largest_turn
end module solid_tangent_change

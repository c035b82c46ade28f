! SPDX-License-Identifier: GPL-3.0-or-later
!> Assembles the tangent stiffness of a wing in the blocks of the model's pattern.
module solid_tangent
  use base_kinds, only: rp
  use solid_arch, only: arch_tangent
  use solid_twist, only: camber_evaluate, twist_evaluate
  use solid_extension, only: extension_tangent
  use solid_hinge, only: hinge_evaluate, HINGE_NODES
  use solid_model, only: solid_model_t
  use solid_plate, only: edges_tangent
  implicit none
  private
  public :: assemble_tangent

contains

  !> Sets blocks(3, 3, :) [N/m] to the tangent at displacements u(3, n_all) [m], with the geometric stiffness of the given axial
  !> forces [N] of the springs; those of `extension_axial` at u make it the exact Hessian. With `semidefinite` every element
  !> contributes its positive semidefinite part: bending without its indefinite part, and no compression.
  subroutine assemble_tangent(model, u, axial, semidefinite, blocks)
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(in) :: axial(:)
    logical, intent(in) :: semidefinite
    real(rp), intent(out) :: blocks(:, :, :)
    real(rp) :: local(3, HINGE_NODES), energy, h(3*HINGE_NODES, 3*HINGE_NODES), d
    integer :: b, n, i
    d = model%stiffness%plate
    do b = 1, size(blocks, 3)
      blocks(:, :, b) = 0
      blocks(1, 1, b) = d*model%plate%tangent(b)
      blocks(2, 2, b) = blocks(1, 1, b)
      blocks(3, 3, b) = blocks(1, 1, b)
    end do
    if (model%stiffness%has_edges) call edges_tangent(model%plate, model%stiffness%edge, blocks)
    if (model%stiffness%has_arch .and. .not. semidefinite) &
      call arch_tangent(model%plate, model%points, model%stiffness%arch, u, blocks)
    call extension_tangent(model%springs, model%stiffness%extension, u, axial, semidefinite, blocks)
    local = 0
    do n = 1, size(model%hinges)
      associate (hinge => model%hinges(n))
        do i = 1, hinge%n_nodes
          local(:, i) = u(:, hinge%nodes(i))
        end do
        call hinge_evaluate(hinge, model%stiffness%hinge(n), local, energy, h=h, semidefinite=semidefinite, &
                            cubic=model%stiffness%cubic(n), lift=model%stiffness%lift(n))
        call add_blocks(hinge%n_nodes, hinge%blocks, h, blocks)
      end associate
    end do
    if (.not. (model%stiffness%has_twist .or. model%stiffness%has_arch)) return
    do n = 1, size(model%twists)
      associate (twist => model%twists(n))
        if (twist%n_nodes == 0) cycle
        do i = 1, twist%n_nodes
          local(:, i) = u(:, twist%nodes(i))
        end do
        if (twist%is_twistable) then
          call twist_evaluate(twist, model%stiffness%twist(n), local, energy, h=h, semidefinite=semidefinite)
          call add_blocks(twist%n_nodes, twist%blocks, h, blocks)
        end if
        if (semidefinite) cycle
        call camber_evaluate(twist, model%stiffness%camber_moment(n), local, energy, h=h)
        call add_blocks(twist%n_nodes, twist%blocks, h, blocks)
      end associate
    end do
  end subroutine assemble_tangent

  !> Adds the Hessian h of an element of n nodes; the upper part of places(:, :) has the numbers of its blocks.
  pure subroutine add_blocks(n, places, h, blocks)
    integer, intent(in) :: n, places(:, :)
    real(rp), intent(in) :: h(:, :)
    real(rp), intent(inout) :: blocks(:, :, :)
    integer :: b, i, j
    do j = 1, n
      do i = 1, j
        b = places(i, j)
        if (b > 0) then
          blocks(:, :, b) = blocks(:, :, b) + h(3*i - 2:3*i, 3*j - 2:3*j)
        else if (b < 0) then
          blocks(:, :, -b) = blocks(:, :, -b) + h(3*j - 2:3*j, 3*i - 2:3*i)
        end if
      end do
    end do
  end subroutine add_blocks
end module solid_tangent

! SPDX-License-Identifier: GPL-3.0-or-later
!> Projects sites, forces, masses and joints onto the modes of a wing, given as shapes(3, n_all, modes).
module measurement_series_projections
  use base_kinds, only: rp
  use measurement_material_point, only: material_point_t
  use solid_modal, only: modal_t
  use solid_model, only: solid_model_t
  use solid_stiffness_effects, only: keep_joints
  use solid_tangent, only: assemble_tangent
  implicit none
  private
  public :: displacement_along, apply_joints, inertia_along, no_matrix, products

contains

  !> Computes stiff(3, n_all, modes) = K_joints Phi for the first modes, with the parameters of the model.
  subroutine apply_joints(modal, stiff)
    class(modal_t), intent(in) :: modal
    real(rp), intent(out) :: stiff(:, :, :)
    type(solid_model_t), allocatable :: probe
    real(rp), allocatable :: blocks(:, :, :), rest(:, :), axial(:), f(:, :)
    integer :: i
    stiff = 0
    if (.not. any(modal%model%plans%joint > 0)) return
    call keep_joints(modal%model, probe)
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

  !> Returns the matrix of the products of a(:, :, i) and b(:, :, j).
  pure function products(a, b) result(c)
    real(rp), intent(in) :: a(:, :, :), b(:, :, :)
    real(rp) :: c(size(a, 3), size(b, 3))
    integer :: n
    n = size(a, 1)*size(a, 2)
    c = matmul(transpose(reshape(a, [n, size(a, 3)])), reshape(b, [n, size(b, 3)]))
  end function products

  !> Returns the displacements of a site along an axis.
  pure function displacement_along(site, axis, shapes) result(values)
    type(material_point_t), intent(in) :: site
    real(rp), intent(in) :: axis(3), shapes(:, :, :)
    real(rp) :: values(size(shapes, 3))
    integer :: c
    values = 0
    do c = 1, 3
      values = values + site%weight(c)*matmul(axis, shapes(:, site%corner(c), :))
    end do
  end function displacement_along

  !> Returns the products of the masses(3, n_all) [kg] that move along a direction.
  pure function inertia_along(mass, direction, shapes) result(values)
    real(rp), intent(in) :: mass(:, :), direction(3), shapes(:, :, :)
    real(rp) :: values(size(shapes, 3))
    integer :: i
    values = [(sum(direction*sum(mass*shapes(:, :, i), 2)), i=1, size(values))]
  end function inertia_along

  !> Returns a matrix of size 0.
  pure function no_matrix() result(matrix)
    real(rp), allocatable :: matrix(:, :)
    allocate (matrix(0, 0))
  end function no_matrix
end module measurement_series_projections

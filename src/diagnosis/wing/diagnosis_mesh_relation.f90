! SPDX-License-Identifier: GPL-3.0-or-later
!> Relates a coordinate of a wing on a finer mesh to that of the same wing on the mesh of its file. Most are equal. A hinge that
!> stands for a piece of vein, which has another length on each mesh, turns by the same angle beside that of its vein.
module diagnosis_mesh_relation
  use base_kinds, only: rp
  use solid_wing_refine, only: equal_rotation
  implicit none
  private
  public :: mesh_relation_t

  type :: mesh_relation_t
    real(rp) :: null = 0      !< where nothing differs from the vein, on the mesh of the fits
    real(rp) :: file_null = 0 !< the same on the mesh of the file
    real(rp) :: ratio = 1     !< of the stiffness of the hinge on the mesh of the file to that here, both at their null; at most 1
  contains
    procedure :: at => relation_at
    procedure :: slope => relation_slope
  end type mesh_relation_t

contains

  !> Returns the coordinate on the mesh of the file, where q is that on the mesh of the fits.
  pure elemental real(rp) function relation_at(self, q) result(coordinate)
    class(mesh_relation_t), intent(in) :: self
    real(rp), intent(in) :: q
    coordinate = self%file_null + (q - self%null)
    if (self%ratio < 1) coordinate = self%file_null + log(equal_rotation(exp(q - self%null), 1.0_rp, self%ratio)/self%ratio)
  end function relation_at

  !> Returns its derivative with respect to q.
  pure elemental real(rp) function relation_slope(self, q) result(slope)
    class(mesh_relation_t), intent(in) :: self
    real(rp), intent(in) :: q
    slope = 1
    if (self%ratio < 1) slope = equal_rotation(exp(q - self%null), 1.0_rp, self%ratio)*exp(self%null - q)
  end function relation_slope
end module diagnosis_mesh_relation

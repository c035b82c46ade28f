! SPDX-License-Identifier: GPL-3.0-or-later
!> A wing as it lies on the bench: points, membrane triangles, veins, joints, root. Immutable once read.
!>
!> Wing frame: x from root to tip, y toward the leading edge, z their right-handed normal. SI units.
module solid_wing
  use base_kinds, only: rp
  implicit none
  private
  public :: wing_t, vein_t, joint_t

  !> A vein: a chain of points with a circular cross-section at each of them.
  type :: vein_t
    character(:), allocatable :: name
    integer, allocatable :: nodes(:)      !< point numbers along the vein, 1-based
    real(rp), allocatable :: diameters(:) !< [m] at the nodes
  end type vein_t

  !> A joint: the bending hinge nodes(1)-nodes(2)-nodes(3) that has its own stiffness.
  type :: joint_t
    character(:), allocatable :: name
    integer :: nodes(3) = 0
  end type joint_t

  !> The unloaded wing.
  type :: wing_t
    real(rp), allocatable :: points(:, :)    !< (3, n) [m]
    integer, allocatable :: triangles(:, :)  !< (3, m) points, counter-clockwise from +z; m = 0: veins only
    type(vein_t), allocatable :: veins(:)
    type(joint_t), allocatable :: joints(:)
    integer, allocatable :: root(:)          !< clamped points
    real(rp) :: plane_normal(3) = [0.0_rp, 0.0_rp, 1.0_rp] !< normal of the plane of a vein-only structure
  end type wing_t
end module solid_wing

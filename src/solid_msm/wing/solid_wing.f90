! SPDX-License-Identifier: GPL-3.0-or-later
!> A wing as it lies on the bench: points, membrane triangles, veins, joints, root. Immutable once read.
!>
!> Wing frame: x from root to tip, y toward the leading edge, z normal to both. SI units.
!>
!> The wings of a fly are mirror images: one that bends more easily to its dorsal side does so left and right. To which
!> side +z points, `z_side`, therefore says for both of them what "up" means to the effects of the wing in the file.
module solid_wing
  use base_kinds, only: rp
  implicit none
  private
  public :: wing_t, vein_t, joint_t, wing_mass_t, z_side_choices

  !> Sides of wings to which +z of a wing file may point. The first is meant where nothing is said. In true right-handed
  !> axes these are the first two; the others belong to coordinates of a mirror image.
  character(13), parameter, public :: Z_SIDES(4) = [character(13) :: 'left ventral', 'right dorsal', 'left dorsal', &
                                                    'right ventral']

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

  !> What is known of the mass of this very wing: it comes from its file.
  type :: wing_mass_t
    character(8) :: law = ''              !< of the membrane: uniform, bilinear; '': nothing is stated
    real(rp) :: membrane = 0              !< mass of the membrane [kg]
    real(rp) :: weights(3) = 0            !< of the bilinear law: areal density ~ w1 + w2 x + w3 y [-], [1/m], [1/m]
    real(rp) :: vein_density = 0          !< [kg/m^3]; 0: not stated
    character(:), allocatable :: source   !< where this comes from, for people
  end type wing_mass_t

  !> The unloaded wing.
  type :: wing_t
    real(rp), allocatable :: points(:, :)    !< (3, n) [m]
    integer, allocatable :: triangles(:, :)  !< (3, m) points, counter-clockwise from +z; m = 0: veins only
    type(vein_t), allocatable :: veins(:)
    type(joint_t), allocatable :: joints(:)
    integer, allocatable :: root(:)          !< clamped points
    real(rp) :: plane_normal(3) = [0.0_rp, 0.0_rp, 1.0_rp] !< normal of the plane of a vein-only structure
    character(len(Z_SIDES)) :: z_side = ''   !< which side of which wing +z points to, of Z_SIDES; '': not stated
    type(wing_mass_t) :: mass
  contains
    procedure :: z_is_dorsal => wing_z_is_dorsal
  end type wing_t

contains

  !> Whether +z points to the dorsal (upper) side.
  pure logical function wing_z_is_dorsal(self) result(is_dorsal)
    class(wing_t), intent(in) :: self
    is_dorsal = index(self%z_side, 'dorsal') > 0
  end function wing_z_is_dorsal

  !> Z_SIDES with `between` between them.
  pure function z_side_choices(between) result(text)
    character(*), intent(in) :: between
    character(:), allocatable :: text
    integer :: i
    text = trim(Z_SIDES(1))
    do i = 2, size(Z_SIDES)
      text = text//between//trim(Z_SIDES(i))
    end do
  end function z_side_choices
end module solid_wing

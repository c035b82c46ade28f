! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a wing: points, membrane triangles, veins, joints, root. It does not change after reading.
!>
!> Wing frame: x from root to tip, y toward the leading edge, z normal to both. SI units.
!>
!> The wings of a fly are mirror images: if a wing bends more easily to its dorsal side, both the left and the right wing do so.
!> `z_side`, the side to which +z points, therefore defines the meaning of "up" in the effects for both wings.
module solid_wing
  use base_kinds, only: rp
  use base_named_kinds, only: kind_of, named_kind_t, word_of
  use base_visitor, only: visited_t, visitor_t
  implicit none
  private
  public :: wing_t, vein_t, joint_t, wing_mass_t, z_side_choices

  integer, parameter, public :: MEMBRANE_BILINEAR = 1 !< areal density proportional to w1 + w2 x + w3 y, given mass
  integer, parameter, public :: MEMBRANE_UNIFORM = 2  !< constant areal density
  integer, parameter, public :: MEMBRANE_UNSTATED = 0
  type(named_kind_t), parameter, public :: MEMBRANE_LAWS(2) = [named_kind_t('bilinear', MEMBRANE_BILINEAR), &
                                                               named_kind_t('uniform', MEMBRANE_UNIFORM)]

  !> Sides of wings to which +z of a wing file may point. The first is the default. The first two have right-handed axes; the others
  !> have the coordinates of a mirror image.
  integer, parameter, public :: SIDE_UNSTATED = 0, SIDE_LEFT_VENTRAL = 1, SIDE_RIGHT_DORSAL = 2, SIDE_LEFT_DORSAL = 3, &
                                SIDE_RIGHT_VENTRAL = 4
  type(named_kind_t), parameter, public :: Z_SIDES(4) = [named_kind_t('left ventral', SIDE_LEFT_VENTRAL), &
                                                         named_kind_t('right dorsal', SIDE_RIGHT_DORSAL), &
                                                         named_kind_t('left dorsal', SIDE_LEFT_DORSAL), &
                                                         named_kind_t('right ventral', SIDE_RIGHT_VENTRAL)]

  !> A vein: a chain of points with a circular cross-section at each of them.
  type, extends(visited_t) :: vein_t
    character(:), allocatable :: name
    integer, allocatable :: nodes(:)      !< point numbers along the vein, 1-based
    real(rp), allocatable :: diameters(:) !< [m] at the nodes
  contains
    procedure :: visit => vein_visit
  end type vein_t

  !> A joint: the bending hinge nodes(1)-nodes(2)-nodes(3) that has its own stiffness.
  type, extends(visited_t) :: joint_t
    character(:), allocatable :: name
    integer :: nodes(3) = 0
  contains
    procedure :: visit => joint_visit
  end type joint_t

  !> Known data of the mass of this individual wing, from its file.
  type, extends(visited_t) :: wing_mass_t
    integer :: law = MEMBRANE_UNSTATED    !< of the membrane: MEMBRANE_*
    real(rp) :: membrane = 0              !< mass of the membrane [kg]
    real(rp) :: weights(3) = 0            !< of the bilinear law: areal density ~ w1 + w2 x + w3 y [-], [1/m], [1/m]
    real(rp) :: vein_density = 0          !< [kg/m^3]; 0: not stated
    character(:), allocatable :: source   !< origin of these data, as a text
  contains
    procedure :: visit => mass_visit
  end type wing_mass_t

  !> The unloaded wing.
  type, extends(visited_t) :: wing_t
    real(rp), allocatable :: points(:, :)    !< (3, n) [m]
    integer, allocatable :: triangles(:, :)  !< (3, m) points, counter-clockwise from +z; m = 0: veins only
    type(vein_t), allocatable :: veins(:)
    type(joint_t), allocatable :: joints(:)
    integer, allocatable :: root(:)          !< clamped points
    real(rp) :: plane_normal(3) = [0.0_rp, 0.0_rp, 1.0_rp] !< normal of the plane of a vein-only structure
    integer :: z_side = SIDE_UNSTATED        !< which side of which wing +z points to: SIDE_*
    type(wing_mass_t) :: mass
  contains
    procedure :: visit => wing_visit
    procedure :: z_is_dorsal => wing_z_is_dorsal
  end type wing_t

contains

  !> Shows every component to the visitor.
  subroutine vein_visit(self, visitor)
    class(vein_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit_allocatable('name', self%name)
    call visitor%visit_allocatable('nodes', self%nodes)
    call visitor%visit_allocatable('diameters', self%diameters)
  end subroutine vein_visit

  !> Shows every component to the visitor.
  subroutine joint_visit(self, visitor)
    class(joint_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit_allocatable('name', self%name)
    call visitor%visit('nodes', self%nodes)
  end subroutine joint_visit

  !> Shows every component to the visitor, the law as a word.
  subroutine mass_visit(self, visitor)
    class(wing_mass_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    character(8) :: law
    law = word_of(MEMBRANE_LAWS, self%law)
    call visitor%visit('law', law)
    self%law = kind_of(MEMBRANE_LAWS, law)
    call visitor%visit('membrane', self%membrane)
    call visitor%visit('weights', self%weights)
    call visitor%visit('vein_density', self%vein_density)
    call visitor%visit_allocatable('source', self%source)
  end subroutine mass_visit

  !> Shows every component to the visitor, the side of z as words.
  subroutine wing_visit(self, visitor)
    class(wing_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    character(13) :: z_side
    call visitor%visit_allocatable('points', self%points)
    call visitor%visit_allocatable('triangles', self%triangles)
    if (visitor%is_reading) allocate (self%veins(visitor%count_of('veins')))
    call visitor%visit_list('veins', self%veins)
    if (visitor%is_reading) allocate (self%joints(visitor%count_of('joints')))
    call visitor%visit_list('joints', self%joints)
    call visitor%visit_allocatable('root', self%root)
    call visitor%visit('plane_normal', self%plane_normal)
    z_side = word_of(Z_SIDES, self%z_side)
    call visitor%visit('z_side', z_side)
    self%z_side = kind_of(Z_SIDES, z_side)
    call visitor%visit('mass', self%mass)
  end subroutine wing_visit

  !> Tells whether +z points to the dorsal (upper) side.
  pure logical function wing_z_is_dorsal(self) result(is_dorsal)
    class(wing_t), intent(in) :: self
    is_dorsal = any(self%z_side == [SIDE_RIGHT_DORSAL, SIDE_LEFT_DORSAL])
  end function wing_z_is_dorsal

  !> Returns the words of Z_SIDES as one text, with `between` between them.
  pure function z_side_choices(between) result(text)
    character(*), intent(in) :: between
    character(:), allocatable :: text
    integer :: i
    text = trim(Z_SIDES(1)%word)
    do i = 2, size(Z_SIDES)
      text = text//between//trim(Z_SIDES(i)%word)
    end do
  end function z_side_choices
end module solid_wing

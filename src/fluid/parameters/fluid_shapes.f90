! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines bodies of simple shape that do not move: their names, the checks of their sizes, and the signed distance of a point from
!> their surface. A new body needs a kind, a word in SHAPES, its words in SHAPE_HELP and a case in `shape_distance`. It needs a case
!> in `shape_mistake` if its sizes need a check, and a word in OBSTACLES if a flow with an insect may contain it.
module fluid_shapes
  use base_constants, only: PI
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: shape_t, NO_SHAPE, SHAPE_COUETTE, LAST_SHAPE, SHAPES, OBSTACLES, SHAPE_HELP

  integer, parameter :: NO_SHAPE = 0, SHAPE_SPHERE = 1, SHAPE_CYLINDER = 2, SHAPE_CYLINDER_X = 3, SHAPE_PLATE = 4, &
                        SHAPE_COUETTE = 5

  !> Words of the input for the shapes. A name that begins with a capital letter is the older name of the same shape.
  type(named_kind_t), parameter :: SHAPES(7) = [ &
    named_kind_t('sphere', SHAPE_SPHERE), named_kind_t('Sphere', SHAPE_SPHERE), named_kind_t('cylinder', SHAPE_CYLINDER), &
    named_kind_t('cylinder_x', SHAPE_CYLINDER_X), named_kind_t('plate', SHAPE_PLATE), named_kind_t('Plate', SHAPE_PLATE), &
    named_kind_t('couette', SHAPE_COUETTE)]
  integer, parameter :: LAST_SHAPE = maxval(SHAPES%kind) !< kinds of other masks begin behind it (fluid_solid_keys)
  !> Words of the shapes that may be an obstacle beside an insect.
  type(named_kind_t), parameter :: OBSTACLES(4) = [ &
    named_kind_t('none', NO_SHAPE), named_kind_t('sphere', SHAPE_SPHERE), named_kind_t('cylinder', SHAPE_CYLINDER), &
    named_kind_t('cylinder_x', SHAPE_CYLINDER_X)]
  character(*), parameter :: SHAPE_HELP = 'sphere; cylinder along z (2-D: along x); cylinder along x; square plate; '// &
                                          'Couette device'

  !> One body, with the sizes that the user gives.
  type :: shape_t
    integer :: kind = NO_SHAPE
    real(rp) :: size = 0              !< diameter, or side length of the plate, L
    real(rp) :: alpha = 0             !< rotation of the plate about z, degree
    real(rp) :: r1 = 1, r2 = 1        !< inner and outer radius of the Couette device, L
    real(rp) :: omega = 0             !< angular velocity of its inner cylinder, rad/T
  contains
    procedure :: mistake => shape_mistake
    procedure :: reach => shape_reach
    procedure :: distance => shape_distance
  end type shape_t

contains

  !> Returns the key of [Geometry] with a wrong size, and a text that says what is wrong. Both texts are empty if the sizes are
  !> valid.
  pure subroutine shape_mistake(self, key, text)
    class(shape_t), intent(in) :: self
    character(:), allocatable, intent(out) :: key, text
    key = ''
    text = ''
    select case (self%kind)
    case (SHAPE_SPHERE, SHAPE_CYLINDER, SHAPE_CYLINDER_X, SHAPE_PLATE)
      if (self%size > 0) return
      key = 'Size'
      text = 'the body needs a size above 0'
    case (SHAPE_COUETTE)
      if (self%r2 > self%r1) return
      key = 'r2'
      text = 'the outer radius must be larger than r1'
    end select
  end subroutine shape_mistake

  !> Returns a distance [L] from the centre, in y or in z, beyond which the body has no point. It is huge for bodies that extend
  !> without limit.
  pure real(rp) function shape_reach(self) result(reach)
    class(shape_t), intent(in) :: self
    select case (self%kind)
    case (SHAPE_SPHERE)
      reach = self%size/2
    case (SHAPE_PLATE)
      reach = self%size/2*sqrt(2.0_rp)
    case default
      reach = huge(reach)
    end select
  end function shape_reach

  !> Returns the signed distance [L] of a point from the surface, negative inside. `point` [L] is the position of the point relative
  !> to the centre. The distance is huge if there is no shape. Sets `velocity` [L/T] where a part of the body has its own velocity.
  pure subroutine shape_distance(self, point, grid, distance, velocity)
    class(shape_t), intent(in) :: self
    real(rp), intent(in) :: point(3)
    type(grid_t), intent(in) :: grid
    real(rp), intent(out) :: distance
    real(rp), intent(inout) :: velocity(3)
    real(rp) :: r
    distance = huge(distance)
    select case (self%kind)
    case (SHAPE_SPHERE)
      distance = norm2(point(merge(2, 1, grid%is_2d):)) - self%size/2
    case (SHAPE_CYLINDER, SHAPE_CYLINDER_X)
      r = merge(hypot(point(2), point(3)), hypot(point(1), point(2)), self%kind == SHAPE_CYLINDER_X .or. grid%is_2d)
      distance = r - self%size/2
    case (SHAPE_PLATE)
      ! In two dimensions the plate is a line in the y-z plane with its normal along y.
      if (grid%is_2d) then
        distance = plate_distance([point(2), point(3), 0.0_rp], self%alpha*PI/180, self%size, 2*grid%max_spacing())
      else
        distance = plate_distance(point, self%alpha*PI/180, self%size, 2*grid%max_spacing())
      end if
    case (SHAPE_COUETTE)
      r = hypot(point(2), point(3))
      distance = min(r - self%r1, self%r2 - r)
      velocity = 0
      if (r < (self%r1 + self%r2)/2) velocity = self%omega*[0.0_rp, -point(3), point(2)]
    end select
  end subroutine shape_distance

  !> Returns the signed distance from a square plate of side length `side` and half thickness `half`. Its normal is along x, rotated
  !> by `angle` about z.
  pure real(rp) function plate_distance(point, angle, side, half) result(d)
    real(rp), intent(in) :: point(3), angle, side, half
    real(rp) :: q(3)
    q(1) = abs(cos(angle)*point(1) + sin(angle)*point(2)) - half
    q(2) = abs(-sin(angle)*point(1) + cos(angle)*point(2)) - side/2
    q(3) = abs(point(3)) - side/2
    d = norm2(max(q, 0.0_rp)) + min(maxval(q), 0.0_rp)
  end function plate_distance
end module fluid_shapes

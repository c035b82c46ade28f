! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes trunks of insects: sections of given radius along a centre line that is an arc in the plane of symmetry.
!>
!> The arc has its centre at (x, z) = `centre` and the radius `bend`; s is proportional to the angle, counted from -x to z, and goes
!> from 0 at the front to 1 at the rear end. The level is the distance from the arc, which is scaled across the arc, minus the
!> radius R(s) of the section, as in FLUSI. `fly`: two parabolas in a distorted coordinate, made by FLUSI for the mesh of Maeda &
!> Liu (fruit fly) and for bumblebee BB1 of Dudley & Ellington (1990); `beetle`: half ellipses above and below the arc (Paratuposa).
module fsi_bent_body
  use base_constants, only: PI
  use base_kinds, only: rp
  use fluid_bodies, only: mask_profile
  use fsi_solid_shape, only: level_shape_t, solid_shape_t
  implicit none
  private
  public :: make_fly, make_beetle, make_straight_fly
  public :: STYLE_ROUND, STYLE_SLIM, STYLE_FLAT

  integer, parameter :: STYLE_ROUND = 0 !< round sections
  integer, parameter :: STYLE_SLIM = 1  !< narrower than high
  integer, parameter :: STYLE_FLAT = 2  !< abdomen flattened from above

  real(rp), parameter :: WAIST = 0.6333_rp, FRONT = 1.075_rp !< ends of the parabolas, from the tail on

  type, abstract, extends(level_shape_t) :: arc_t
    real(rp) :: centre(2) = 0            !< x, z, L
    real(rp) :: bend = 0                 !< L
    real(rp) :: first = 0, last = 0      !< angles of the ends, rad
    real(rp) :: margin = 0               !< in s, beyond which there is nothing
  contains
    procedure, private :: place => arc_place
  end type arc_t

  type, extends(arc_t) :: fly_t
    real(rp) :: width = 1                !< factor of the radius
    integer :: style = STYLE_ROUND
  contains
    procedure :: level_at => fly_level
  end type fly_t

  type, extends(arc_t) :: beetle_t
    real(rp) :: length = 1               !< L, the unit of all other lengths
  contains
    procedure :: level_at => beetle_level
  end type beetle_t

  !> FLUSI's older fruit fly: a straight body of revolution made of three parabolas, with a smooth edge along x.
  type, extends(solid_shape_t) :: straight_fly_t
  contains
    procedure :: mask_at => straight_fly_mask
  end type straight_fly_t

  real(rp), parameter :: STRAIGHT_SHIFT = 0.8067_rp, STRAIGHT_LENGTH = 1.2_rp

contains

  !> Returns the body of a fly that is bent along an arc about `centre` (x, z) with radius `bend`; lengths in L. `width` scales
  !> its radii.
  pure type(fly_t) function make_fly(centre, bend, width, style, margin) result(shape)
    real(rp), intent(in) :: centre(2), bend, width, margin
    integer, intent(in) :: style
    shape%centre = centre
    shape%bend = bend
    shape%first = 112*PI/180
    shape%last = 53*PI/180
    shape%margin = margin
    shape%width = width
    shape%style = style
    shape%low = [centre(1) - 0.85_rp*bend, -0.28_rp*bend, centre(2) + 0.55_rp*bend]
    shape%high = [centre(1) + 0.53_rp*bend, 0.28_rp*bend, centre(2) + 1.28_rp*bend]
  end function make_fly

  !> Returns the position s along the arc, and the nearest point of the extended arc.
  pure subroutine arc_place(self, x, z, s, nearest)
    class(arc_t), intent(in) :: self
    real(rp), intent(in) :: x, z
    real(rp), intent(out) :: s, nearest(2)
    real(rp) :: arm(2)
    arm = [x, z] - self%centre
    s = (atan2(arm(2), -arm(1)) - self%first)/(self%last - self%first)
    nearest = self%centre + arm*(self%bend/max(norm2(arm), tiny(1.0_rp)))
  end subroutine arc_place

  !> Returns the signed distance [L] of x from the surface in the section normal to the arc; huge beyond its ends.
  pure real(rp) function fly_level(self, x) result(level)
    class(fly_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    real(rp) :: s, nearest(2), from_tail, radius, stretch(3)
    level = huge(level)
    call self%place(x(1), x(3), s, nearest)
    if (s < -self%margin .or. s > FRONT + self%margin) return
    from_tail = 1 - (s + 0.08_rp*tanh(30*s))/(1 + 0.08_rp*tanh(30.0_rp))
    from_tail = (from_tail + 0.04_rp*tanh(60*from_tail))/(1 + 0.04_rp*tanh(60.0_rp))
    from_tail = sin(1.2_rp*from_tail)/sin(1.2_rp)
    from_tail = FRONT*sign(abs(from_tail)**1.25_rp, from_tail)
    radius = 0
    stretch = 1
    if (self%style == STYLE_SLIM) stretch(2) = 1.09_rp
    if (from_tail < WAIST) then
      radius = (-1.2990_rp*from_tail + 0.9490_rp)*from_tail + 0.0267_rp
      if (self%style == STYLE_FLAT) stretch(3) = 1 - 0.07_rp*(from_tail - WAIST)*from_tail/0.0488_rp
    else if (from_tail <= FRONT) then
      radius = (-2.1667_rp*from_tail + 3.4661_rp)*from_tail - 1.2194_rp
      if (self%style == STYLE_SLIM) stretch(2) = 1.09_rp - 0.19_rp*(from_tail - WAIST)*(from_tail - FRONT)/0.0488_rp
    end if
    if (radius <= 0) return
    radius = self%width*(1 + 0.6_rp*(1 - s)**2)*radius
    level = norm2(stretch*[x(1) - nearest(1), x(2), x(3) - nearest(2)]) - radius
  end function fly_level

  !> Returns the body of a beetle of this `length` [L].
  pure type(beetle_t) function make_beetle(length) result(shape)
    real(rp), intent(in) :: length
    shape%length = length
    shape%centre = [0.0_rp, -1.17_rp]
    shape%bend = 1.27_rp
    shape%first = 113*PI/180
    shape%last = 67*PI/180
    shape%low = length*[-0.6_rp, -0.2_rp, -0.2_rp]
    shape%high = length*[0.6_rp, 0.2_rp, 0.35_rp]
  end function make_beetle

  !> Returns the level of x as a fraction of the length, as in FLUSI; huge beyond the ends of the arc.
  pure real(rp) function beetle_level(self, x) result(level)
    class(beetle_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    real(rp), parameter :: HEIGHTS(2) = [0.22_rp, 0.07_rp], HALF_WIDTH = 0.18_rp !< above and below the arc
    real(rp) :: p(3), s, nearest(2), height, radius
    level = huge(level)
    p = x/self%length
    call self%place(p(1), p(3), s, nearest)
    if (s < 0 .or. s > 1) return
    height = merge(HEIGHTS(1), HEIGHTS(2), p(3) >= nearest(2))
    radius = 2*height*sqrt(max(0.0_rp, 0.25_rp - (s - 0.5_rp)**2))
    if (radius <= 0) return
    ! FLUSI compares these fractions of the length with a smoothing layer whose width is in L.
    level = norm2([p(1) - nearest(1), p(2)*height/HALF_WIDTH, p(3) - nearest(2)]) - radius
  end function beetle_level

  !> Returns FLUSI's straight body of a fly; lengths are in L.
  pure type(straight_fly_t) function make_straight_fly() result(shape)
    shape%low = [-STRAIGHT_SHIFT, -0.22_rp, -0.22_rp]
    shape%high = [STRAIGHT_LENGTH - STRAIGHT_SHIFT, 0.22_rp, 0.22_rp]
  end function make_straight_fly

  !> Returns chi, 0 to 1, at x [L], for half the width h [L] of the step.
  pure real(rp) function straight_fly_mask(self, x, h) result(chi)
    class(straight_fly_t), intent(in) :: self
    real(rp), intent(in) :: x(3), h
    real(rp) :: along, radius
    chi = 0
    if (.not. self%is_near(x, h)) return
    along = x(1) + STRAIGHT_SHIFT
    radius = 0
    if (along < WAIST) then
      radius = (-1.2990_rp*along + 0.9490_rp)*along + 0.0267_rp
    else if (along <= 1) then
      radius = (-2.1667_rp*along + 3.4661_rp)*along - 1.2194_rp
    else if (along <= STRAIGHT_LENGTH) then
      radius = (-12.68_rp*along + 27.4960_rp)*along - 14.7360_rp
    end if
    if (radius <= 0) return
    chi = mask_profile(norm2(x(2:3)) - radius, h)*mask_profile(-along - h, h)*mask_profile(along - STRAIGHT_LENGTH + h, h)
  end function straight_fly_mask
end module fsi_bent_body

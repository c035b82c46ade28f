! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the shape of a rigid solid in its own frame, for the mask.
!>
!> A shape gives chi at any point of its frame. Most shapes use a level d, negative inside, which is the distance from the surface
!> or, as in FLUSI, the distance in a section: chi = mask_profile(d, h) with half the width h of the step.
module fsi_solid_shape
  use base_kinds, only: rp
  use fluid_bodies, only: mask_profile
  implicit none
  private
  public :: solid_shape_t, level_shape_t, shape_holder_t

  !> Lengths in L.
  type, abstract :: solid_shape_t
    real(rp) :: low(3) = 0, high(3) = 0 !< box in the frame that holds chi >= 1/2
  contains
    procedure(mask_of_shape), deferred :: mask_at
    procedure :: is_near => shape_is_near
  end type solid_shape_t

  !> A shape whose chi is the profile of a level.
  type, abstract, extends(solid_shape_t) :: level_shape_t
  contains
    procedure(level_of_shape), deferred :: level_at
    procedure :: mask_at => shape_mask_at
  end type level_shape_t

  !> An element of a list of shapes of any type.
  type :: shape_holder_t
    class(solid_shape_t), allocatable :: shape
  end type shape_holder_t

  abstract interface
    !> Returns chi, 0 to 1, at x in the frame, for half the width h of the step.
    pure real(rp) function mask_of_shape(self, x, h)
      import :: rp, solid_shape_t
      class(solid_shape_t), intent(in) :: self
      real(rp), intent(in) :: x(3), h !< L
    end function mask_of_shape

    !> Returns the signed distance at x, L, negative inside. Near the surface its value is right, elsewhere only its sign.
    pure real(rp) function level_of_shape(self, x)
      import :: rp, level_shape_t
      class(level_shape_t), intent(in) :: self
      real(rp), intent(in) :: x(3) !< L
    end function level_of_shape
  end interface

contains

  !> Returns chi, 0 to 1, at x [L] in the frame: the profile of the level, for half the width h [L] of the step.
  pure real(rp) function shape_mask_at(self, x, h) result(chi)
    class(level_shape_t), intent(in) :: self
    real(rp), intent(in) :: x(3), h
    chi = mask_profile(self%level_at(x), h)
  end function shape_mask_at

  !> Tells whether x is in the box of the shape, or closer to it than h in every direction; lengths in L.
  pure logical function shape_is_near(self, x, h) result(is_near)
    class(solid_shape_t), intent(in) :: self
    real(rp), intent(in) :: x(3), h
    is_near = all(x >= self%low - h) .and. all(x <= self%high + h)
  end function shape_is_near
end module fsi_solid_shape

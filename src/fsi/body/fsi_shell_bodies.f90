! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes hollow flyers with a shell: cone and pyramid, open at the base (Liu, Ristroph, Weathers, Childress & Zhang 2012,
!> DOI 10.1103/PhysRevLett.108.068103), with FLUSI's dimensions. The origin of the frame is H/3 above the middle of the height
!> H, the apex at z = H/3.
module fsi_shell_bodies
  use base_kinds, only: rp
  use fluid_bodies, only: mask_profile
  use fsi_solid_shape, only: level_shape_t, solid_shape_t
  use fsi_triangle, only: make_triangle, triangle_t
  implicit none
  private
  public :: make_cone, make_pyramid

  !> Side length a and half opening angle make the height H = a cos and the base radius a sin.
  type, extends(solid_shape_t) :: cone_t
    real(rp) :: height = 0, slope = 0, half_thickness = 0
  contains
    procedure :: mask_at => cone_mask
  end type cone_t

  !> Square base of side a.
  type, extends(level_shape_t) :: pyramid_t
    real(rp) :: half_thickness = 0
    type(triangle_t) :: sides(4)
  contains
    procedure :: level_at => pyramid_level
  end type pyramid_t

contains

  !> Returns the shell of a cone with this length of its side [L], half angle [rad] and thickness [L].
  pure type(cone_t) function make_cone(side, half_angle, thickness) result(shape)
    real(rp), intent(in) :: side, half_angle, thickness !< L, rad, L
    real(rp) :: reach
    shape%height = side*cos(half_angle)
    shape%slope = side*sin(half_angle)
    shape%half_thickness = thickness/2
    reach = shape%height*shape%slope + shape%half_thickness
    shape%low = [-reach, -reach, -2*shape%height/3]
    shape%high = [reach, reach, shape%height/3]
  end function make_cone

  !> Returns chi, 0 to 1, at x [L], for half the width h [L] of the step. The radius of the shell falls by a sin per unit of z, as
  !> in FLUSI.
  pure real(rp) function cone_mask(self, x, h) result(chi)
    class(cone_t), intent(in) :: self
    real(rp), intent(in) :: x(3), h
    real(rp) :: z, radius
    z = x(3) + self%height/3
    radius = max(0.0_rp, self%slope*(2*self%height/3 - z))
    chi = mask_profile(abs(norm2(x(1:2)) - radius) - self%half_thickness, h)*mask_profile(z - 2*self%height/3, h)* &
          mask_profile(-z - self%height/3, h)
  end function cone_mask

  !> Returns the shell of a pyramid with this length of its side [L], half angle [rad] and thickness [L].
  pure type(pyramid_t) function make_pyramid(side, half_angle, thickness) result(shape)
    real(rp), intent(in) :: side, half_angle, thickness !< L, rad, L
    real(rp) :: height, half, corners(3, 5)
    integer :: i
    height = side*cos(half_angle)
    half = side/2
    shape%half_thickness = thickness/2
    corners(:, 1) = [half, -half, -2*height/3]
    corners(:, 2) = [half, half, -2*height/3]
    corners(:, 3) = [-half, half, -2*height/3]
    corners(:, 4) = [-half, -half, -2*height/3]
    corners(:, 5) = corners(:, 1)
    do i = 1, 4
      shape%sides(i) = make_triangle(corners(:, i), corners(:, i + 1), [0.0_rp, 0.0_rp, height/3])
    end do
    shape%low = [-half, -half, -2*height/3] - shape%half_thickness
    shape%high = [half, half, height/3] + shape%half_thickness
  end function make_pyramid

  !> Returns the signed distance [L] of x from the shell, negative inside it. The pyramid is the set of points inside of all its
  !> sides, and the shell is the layer near its surface.
  pure real(rp) function pyramid_level(self, x) result(level)
    class(pyramid_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    real(rp) :: d2, v, w, signed(4)
    integer :: i
    do i = 1, 4
      call self%sides(i)%closest(x, d2, v, w)
      signed(i) = sign(sqrt(d2), dot_product(x - self%sides(i)%a, self%sides(i)%normal))
    end do
    level = abs(maxval(signed)) - self%half_thickness
  end function pyramid_level
end module fsi_shell_bodies

! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes flat rigid wings as FLUSI draws them: chi is the product of a step at the outline and one at half the thickness, so
!> that the wing ends, smoothed, at its outline. Wing frame: x from root to tip, y to the leading edge.
module fsi_wing_solids
  use base_kinds, only: rp
  use fluid_bodies, only: mask_profile
  use fsi_fourier_outline, only: fourier_outline_t
  use fsi_solid_shape, only: solid_shape_t
  use fsi_wing_relief, only: wing_relief_t
  implicit none
  private
  public :: fourier_wing_t, make_fourier_wing, make_panel_wing

  !> An outline in polar coordinates; the smoothing layer is radial.
  type, extends(solid_shape_t) :: fourier_wing_t
    type(fourier_outline_t) :: outline
    real(rp) :: half_thickness = 0
    type(wing_relief_t) :: relief
    real(rp) :: side = 1 !< direction of z of the heights; -1: a mirror image
  contains
    procedure :: mask_at => fourier_mask
  end type fourier_wing_t

  !> A wing from x = root to tip, with smoothing layers along chord and span. The chord lies between -back and front, and is
  !> constant or varies as two half ellipses.
  type, extends(solid_shape_t) :: panel_wing_t
    real(rp) :: root = 0, tip = 0, front = 0, back = 0
    logical :: is_elliptic = .false.
    real(rp) :: half_thickness = 0
  contains
    procedure :: mask_at => panel_mask
  end type panel_wing_t

contains

  !> Returns the wing with this Fourier outline and `thickness` [L], and with the relief, if there is one.
  type(fourier_wing_t) function make_fourier_wing(outline, planform, thickness, relief) result(shape)
    type(fourier_outline_t), intent(in) :: outline
    real(rp), intent(in) :: planform(:, :) !< (2, n) points of the outline
    real(rp), intent(in) :: thickness
    type(wing_relief_t), intent(in), optional :: relief
    real(rp) :: reach
    shape%outline = outline
    shape%half_thickness = thickness/2
    if (present(relief)) shape%relief = relief
    reach = shape%relief%reach(thickness)
    shape%low = [minval(planform, 2), -reach]
    shape%high = [maxval(planform, 2), reach]
  end function make_fourier_wing

  !> Returns chi, 0 to 1, at x [L] in the wing frame, for half the width h [L] of the step: the product of the steps across the
  !> wing and at its outline.
  pure real(rp) function fourier_mask(self, x, h) result(chi)
    class(fourier_wing_t), intent(in) :: self
    real(rp), intent(in) :: x(3), h
    real(rp) :: arm(2)
    if (self%relief%exists()) then
      chi = mask_profile(abs(x(3) - self%side*self%relief%height_at(x(2), x(1))) - &
                         self%relief%thickness_at(x(2), x(1), 2*self%half_thickness)/2, h)
    else
      chi = mask_profile(abs(x(3)) - self%half_thickness, h)
    end if
    if (chi <= 0) return
    arm = [x(2), x(1)] - self%outline%centre
    chi = chi*mask_profile(norm2(arm) - self%outline%radius(arm), h)
  end function fourier_mask

  !> Returns a rectangular or elliptic wing from x = root to x = tip, with its leading edge at y = front and its trailing edge at
  !> y = -back; lengths in L.
  type(panel_wing_t) function make_panel_wing(root, tip, front, back, is_elliptic, thickness) result(shape)
    real(rp), intent(in) :: root, tip, front, back, thickness
    logical, intent(in) :: is_elliptic
    shape%root = root
    shape%tip = tip
    shape%front = front
    shape%back = back
    shape%is_elliptic = is_elliptic
    shape%half_thickness = thickness/2
    shape%low = [root, -back, -thickness/2]
    shape%high = [tip, front, thickness/2]
  end function make_panel_wing

  !> Returns chi, 0 to 1, at x [L] in the wing frame, for half the width h [L] of the step.
  pure real(rp) function panel_mask(self, x, h) result(chi)
    class(panel_wing_t), intent(in) :: self
    real(rp), intent(in) :: x(3), h
    real(rp) :: half, fraction
    half = (self%tip - self%root)/2
    fraction = 1
    if (self%is_elliptic) fraction = sqrt(max(0.0_rp, 1 - ((x(1) - self%root - half)/half)**2))
    chi = mask_profile(abs(x(3)) - self%half_thickness, h)* &
          mask_profile(max(-fraction*self%back - x(2), x(2) - fraction*self%front), h)
    ! Where the root is the hinge, FLUSI's step there has its outer half only.
    if (x(1) < merge(self%root, self%root + half, self%root <= 0)) then
      chi = chi*mask_profile(self%root - x(1), h)
    else
      chi = chi*mask_profile(x(1) - self%tip, h)
    end if
  end function panel_mask
end module fsi_wing_solids

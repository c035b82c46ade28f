! SPDX-License-Identifier: GPL-3.0-or-later
!> Veins whose material changes along the span: E exp(g s) with the station s = (x - x_root)/R - 1/2, x_root the mean of
!> the clamped points and R the extent of the wing along x. A hinge has the E of its point; joints with a stiffness of
!> their own do not take part.
module solid_effect_gradient
  use base_kinds, only: rp
  use solid_wing, only: wing_t
  implicit none
  private
  public :: stations, gradient_factor

contains

  !> Stations (points) of all points of a wing; without extent along x all are those of the root.
  pure function stations(wing) result(s)
    type(wing_t), intent(in) :: wing
    real(rp) :: s(size(wing%points, 2))
    real(rp) :: root, extent
    s = -0.5_rp
    extent = maxval(wing%points(1, :)) - minval(wing%points(1, :))
    if (.not. extent > 0) return
    root = sum(wing%points(1, wing%root))/max(1, size(wing%root))
    s = (wing%points(1, :) - root)/extent - 0.5_rp
  end function stations

  !> Factor on E at a station; exactly 1 for g = 0.
  pure real(rp) function gradient_factor(g, station) result(factor)
    real(rp), intent(in) :: g, station
    factor = exp(g*station)
  end function gradient_factor
end module solid_effect_gradient

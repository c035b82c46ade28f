! SPDX-License-Identifier: GPL-3.0-or-later
!> Weights points by a disc with a smooth rim.
module solid_disc
  use base_kinds, only: rp
  implicit none
  private
  public :: disc_weight

contains

  !> Returns w at the point (x, y) [m] for disc = (x, y, radius a) [m], r from its centre: w = s^2 (3 - 2 s), s = (1.05 - r/a)/0.1
  !> limited to 0..1. It is 0 everywhere if the radius is 0.
  pure real(rp) function disc_weight(disc, site) result(w)
    real(rp), intent(in) :: disc(3), site(2)
    real(rp), parameter :: OUTER = 1.05_rp, RIM = 0.1_rp ! of the radius
    real(rp) :: s
    w = 0
    if (.not. disc(3) > 0) return
    s = min(1.0_rp, max(0.0_rp, (OUTER - hypot(site(1) - disc(1), site(2) - disc(2))/disc(3))/RIM))
    w = s*s*(3 - 2*s)
  end function disc_weight
end module solid_disc

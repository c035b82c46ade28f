! SPDX-License-Identifier: GPL-3.0-or-later
!> Local damage (or a patch): all stiffness in a disc is multiplied by a factor f.
!>
!> At the distance r from the centre the factor is 1 + (f - 1) w, w = s^2 (3 - 2 s), s = (1.05 - r/a)/0.1 cut to 0..1:
!> whole inside the radius a, with a smooth rim of a tenth of it, halved at a. An element is where its middle is: springs
!> halfway, hinges at their point, and an edge of the membrane has the mean of its two triangles' centroids.
module solid_effect_damage
  use base_kinds, only: rp
  implicit none
  private
  public :: damage_weight

contains

  !> w at the place (x, y) [m] for disc = (x, y, radius) [m]; 0 everywhere without a radius.
  pure real(rp) function damage_weight(disc, place) result(w)
    real(rp), intent(in) :: disc(3), place(2)
    real(rp), parameter :: OUTER = 1.05_rp, RIM = 0.1_rp ! of the radius
    real(rp) :: s
    w = 0
    if (.not. disc(3) > 0) return
    s = min(1.0_rp, max(0.0_rp, (OUTER - hypot(place(1) - disc(1), place(2) - disc(2))/disc(3))/RIM))
    w = s*s*(3 - 2*s)
  end function damage_weight
end module solid_effect_damage

! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the added mass of a wing that moves normal to itself, by strip theory. Over a heaving strip of chord c the potential
!> jumps by 2 w sqrt((c/2)^2 - (y - y_c)^2), so that a piece of membrane carries, per area,
!>
!>     m(x, y) = 2 rho sqrt((c(x)/2)^2 - (y - y_c(x))^2),     rho pi c^2/4 over the chord
!>
!> (the potential of a flat plate that moves normal to itself: Sedov 1965, Two-Dimensional Problems in Hydrodynamics and
!> Aerodynamics). Strips lie along y. A strip that turns about its middle has half the effect of this mass, and the flow around the
!> tip reduces it. The mass is therefore an estimate, and fits should include a factor on it.
module solid_added_mass
  use base_kinds, only: rp
  use solid_wing, only: wing_t
  implicit none
  private
  public :: strip_added_mass

contains

  !> Returns added(n_points) [kg], the mass of a fluid of unit density [1 kg/m^3] that moves with each point along z; 0 without
  !> triangles. A third of the mass of each triangle is assigned to the midpoint of each of its edges, and is shared equally between
  !> both ends of the edge.
  function strip_added_mass(wing) result(added)
    type(wing_t), intent(in) :: wing
    real(rp) :: added(size(wing%points, 2))
    real(rp) :: area, place(2), corner_mass
    integer :: t, k, a, b
    added = 0
    do t = 1, size(wing%triangles, 2)
      associate (c => wing%triangles(:, t))
        area = 0.5_rp*abs((wing%points(1, c(2)) - wing%points(1, c(1)))*(wing%points(2, c(3)) - wing%points(2, c(1))) - &
                          (wing%points(2, c(2)) - wing%points(2, c(1)))*(wing%points(1, c(3)) - wing%points(1, c(1))))
        do k = 1, 3
          a = c(k)
          b = c(mod(k, 3) + 1)
          place = 0.5_rp*(wing%points(:2, a) + wing%points(:2, b))
          corner_mass = 0.5_rp*area/3*areal_mass(wing, place)
          added(a) = added(a) + corner_mass
          added(b) = added(b) + corner_mass
        end do
      end associate
    end do
  end function strip_added_mass

  !> Returns m(x, y)/rho [m] at a place.
  pure real(rp) function areal_mass(wing, place) result(m)
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: place(2)
    real(rp) :: low, high, y
    integer :: t, k, a, b
    low = huge(low)
    high = -huge(high)
    do t = 1, size(wing%triangles, 2)
      do k = 1, 3
        a = wing%triangles(k, t)
        b = wing%triangles(mod(k, 3) + 1, t)
        associate (xa => wing%points(1, a), xb => wing%points(1, b))
          if ((xa - place(1))*(xb - place(1)) > 0) cycle
          if (abs(xb - xa) > 0) then
            y = wing%points(2, a) + (place(1) - xa)/(xb - xa)*(wing%points(2, b) - wing%points(2, a))
          else
            y = wing%points(2, a)
            low = min(low, wing%points(2, b))
            high = max(high, wing%points(2, b))
          end if
          low = min(low, y)
          high = max(high, y)
        end associate
      end do
    end do
    m = 2*sqrt(max(0.0_rp, (high - place(2))*(place(2) - low)))
  end function areal_mass
end module solid_added_mass

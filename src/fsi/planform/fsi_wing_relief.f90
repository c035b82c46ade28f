! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the height of a wing above its plane and its thickness, as FLUSI does: values on a regular lattice over a box in chord
!> and span, bilinear between them and 0 outside the box.
module fsi_wing_relief
  use base_kinds, only: rp
  implicit none
  private
  public :: wing_relief_t

  !> Lengths in L.
  type :: wing_relief_t
    real(rp) :: box(4) = 0                    !< smallest and largest chordwise, then spanwise place
    real(rp), allocatable :: height(:, :)     !< (chordwise, spanwise); toward z of the left wing's frame
    real(rp), allocatable :: thickness(:, :)  !< likewise
  contains
    procedure :: exists => relief_exists
    procedure :: height_at => relief_height_at
    procedure :: thickness_at => relief_thickness_at
    procedure :: reach => relief_reach
    procedure :: scaled => relief_scaled
  end type wing_relief_t

contains

  !> Tells whether the wing is not flat or not of constant thickness.
  pure logical function relief_exists(self) result(exists)
    class(wing_relief_t), intent(in) :: self
    exists = allocated(self%height) .or. allocated(self%thickness)
  end function relief_exists

  !> Returns the height [L] of the middle surface at this position along chord and span; it is 0 for a flat wing.
  pure real(rp) function relief_height_at(self, chord, span) result(height)
    class(wing_relief_t), intent(in) :: self
    real(rp), intent(in) :: chord, span
    height = 0
    if (allocated(self%height)) height = bilinear(self%height, self%box, chord, span)
  end function relief_height_at

  !> Returns the thickness [L] at this position; it is `constant` if the wing does not define it.
  pure real(rp) function relief_thickness_at(self, chord, span, constant) result(thickness)
    class(wing_relief_t), intent(in) :: self
    real(rp), intent(in) :: chord, span, constant
    thickness = constant
    if (allocated(self%thickness)) thickness = bilinear(self%thickness, self%box, chord, span)
  end function relief_thickness_at

  !> Returns the largest distance [L] of any part of the wing from its plane.
  pure real(rp) function relief_reach(self, constant) result(reach)
    class(wing_relief_t), intent(in) :: self
    real(rp), intent(in) :: constant
    reach = constant/2
    if (allocated(self%thickness)) reach = maxval(self%thickness)/2
    if (allocated(self%height)) reach = reach + maxval(abs(self%height))
  end function relief_reach

  !> Returns the relief of a wing that is `factor` times as large.
  pure type(wing_relief_t) function relief_scaled(self, factor) result(scaled)
    class(wing_relief_t), intent(in) :: self
    real(rp), intent(in) :: factor
    scaled%box = factor*self%box
    if (allocated(self%height)) scaled%height = factor*self%height
    if (allocated(self%thickness)) scaled%thickness = factor*self%thickness
  end function relief_scaled

  !> Interpolates values on a regular grid, which fills the box (x_min, x_max, y_min, y_max); 0 outside.
  pure real(rp) function bilinear(values, box, x, y) result(value)
    real(rp), intent(in) :: values(:, :), box(4), x, y
    real(rp) :: place(2), s(2)
    integer :: i(2)
    value = 0
    if (x < box(1) .or. x > box(2) .or. y < box(3) .or. y > box(4)) return
    place = [(x - box(1))/(box(2) - box(1)), (y - box(3))/(box(4) - box(3))]*(shape(values) - 1)
    i = min(int(place), shape(values) - 2)
    s = place - i
    associate (a => values(i(1) + 1:i(1) + 2, i(2) + 1:i(2) + 2))
      value = (1 - s(2))*((1 - s(1))*a(1, 1) + s(1)*a(2, 1)) + s(2)*((1 - s(1))*a(1, 2) + s(1)*a(2, 2))
    end associate
  end function bilinear
end module fsi_wing_relief

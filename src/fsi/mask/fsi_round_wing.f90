! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes flat rigid wings with round edges that end at their outline.
!>
!> Let s be the signed distance from the outline in the plane of the wing, negative inside, and z the height above this plane. The
!> wing is the set of points with sqrt(z^2 + max(0, s + t/2)^2) < t/2, a sheet of thickness t whose edge is half a circle that
!> touches the outline from inside. Where the wing is narrower than t it is thinner, too. For straight edges of length P the volume
!> is A t - (1/2 - pi/8) t^2 P. s is bilinear between the points of a lattice, whose error is below a hundredth of its step for
!> edges that bend by less than one radian in 12 steps. Wing frame: x from root to tip, y to the leading edge.
module fsi_round_wing
  use base_errors, only: require
  use base_kinds, only: rp
  use fsi_solid_shape, only: level_shape_t
  implicit none
  private
  public :: make_round_wing

  !> Lengths in L.
  type, extends(level_shape_t) :: round_wing_t
    real(rp) :: half_thickness = 0
    real(rp), private :: origin(2) = 0, step = 1
    real(rp), allocatable, private :: distance(:, :) !< s at origin + step*[i, j], up to the reach
  contains
    procedure :: level_at => round_level
  end type round_wing_t

contains

  !> Returns the wing between segments (2, 2, n): coordinates [L], both ends; pieces of one or several closed lines in any order.
  !> The step of the lattice is at least a sixteenth of the grid's `spacing`, even if the smoothing layer of the mask is thin.
  type(round_wing_t) function make_round_wing(segments, thickness, smoothing, spacing) result(shape)
    real(rp), intent(in) :: segments(:, :, :)
    real(rp), intent(in) :: thickness, smoothing !< half the width of the mask's step
    real(rp), intent(in) :: spacing
    integer, parameter :: FINE = 4, FINEST = 16  !< steps in the smoothing, in the spacing
    real(rp) :: reach, low(2), high(2)
    integer :: i, n(2)
    call require(size(segments, 3) > 2 .and. thickness > 0 .and. smoothing > 0, 'make_round_wing: a wing is expected')
    low = min(minval(segments(:, 1, :), 2), minval(segments(:, 2, :), 2))
    high = max(maxval(segments(:, 1, :), 2), maxval(segments(:, 2, :), 2))
    shape%half_thickness = thickness/2
    shape%low = [low, -thickness/2]
    shape%high = [high, thickness/2]
    shape%step = max(smoothing/FINE, spacing/FINEST)
    reach = thickness/2 + 2*smoothing
    shape%origin = low - reach
    n = ceiling((high - low + 2*reach)/shape%step)
    allocate (shape%distance(0:n(1), 0:n(2)), source=reach)
    do i = 1, size(segments, 3)
      call come_near(shape, segments(:, 1, i), segments(:, 2, i), reach)
    end do
    ! Initially all signs are those of the outside; each crossed segment along y changes the sign.
    do i = 1, size(segments, 3)
      call change_sides(shape, segments(:, 1, i), segments(:, 2, i))
    end do
  end function make_round_wing

  !> Replaces distances by the distance from the segment a to b where this is smaller.
  pure subroutine come_near(shape, a, b, reach)
    type(round_wing_t), intent(inout) :: shape
    real(rp), intent(in) :: a(2), b(2), reach
    real(rp) :: x(2), along(2), t
    integer :: first(2), last(2), i, j
    first = max(0, floor((min(a, b) - reach - shape%origin)/shape%step))
    last = min(ubound(shape%distance), ceiling((max(a, b) + reach - shape%origin)/shape%step))
    along = b - a
    do j = first(2), last(2)
      do i = first(1), last(1)
        x = shape%origin + shape%step*[i, j] - a
        t = dot_product(x, along)/max(dot_product(along, along), tiny(1.0_rp))
        x = x - max(0.0_rp, min(1.0_rp, t))*along
        shape%distance(i, j) = min(shape%distance(i, j), norm2(x))
      end do
    end do
  end subroutine come_near

  !> Changes the sign beyond the segment from a to b.
  pure subroutine change_sides(shape, a, b)
    type(round_wing_t), intent(inout) :: shape
    real(rp), intent(in) :: a(2), b(2)
    real(rp) :: x, y
    integer :: i, j
    do i = 0, ubound(shape%distance, 1)
      x = shape%origin(1) + shape%step*i
      if ((a(1) <= x) .eqv. (b(1) <= x)) cycle
      y = a(2) + (b(2) - a(2))*(x - a(1))/(b(1) - a(1))
      j = max(0, ceiling((y - shape%origin(2))/shape%step))
      shape%distance(i, j:) = -shape%distance(i, j:)
    end do
  end subroutine change_sides

  !> Returns the signed distance [L] of x from the round edge and the faces, negative inside.
  pure real(rp) function round_level(self, x) result(level)
    class(round_wing_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    real(rp) :: t(2), s
    integer :: i(2)
    t = (x(:2) - self%origin)/self%step
    i = max(0, min(ubound(self%distance) - 1, floor(t)))
    t = max(0.0_rp, min(1.0_rp, t - i))
    associate (d => self%distance)
      s = (1 - t(2))*((1 - t(1))*d(i(1), i(2)) + t(1)*d(i(1) + 1, i(2))) + &
          t(2)*((1 - t(1))*d(i(1), i(2) + 1) + t(1)*d(i(1) + 1, i(2) + 1))
    end associate
    level = hypot(x(3), max(0.0_rp, s + self%half_thickness)) - self%half_thickness
  end function round_level
end module fsi_round_wing

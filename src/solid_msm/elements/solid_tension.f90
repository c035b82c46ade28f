! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a membrane that is stretched in the unloaded wing: an isotropic tension T [N/m] between the veins.
!>
!> A spring along the edge of length l0 carries the constant tension N = T w, w = l0 (cot a + cot b)/2 with the angles a, b opposite
!> to the edge in its triangles (one at the outline): the gradient of T times the area of a flat membrane. The energy is the sum of
!> N (l - l0), so that inner points are in equilibrium where the membrane is flat, and at the outline the veins approach each other
!> by a strain of about T/k_e, less than a millionth.
module solid_tension
  use base_kinds, only: rp
  use solid_extension, only: extensions_t, SPRING_CROSS
  use solid_vectors, only: cross
  implicit none
  private
  public :: tension_widths

contains

  !> Returns w(springs) [m] for points(3, :) [m] and triangles(3, :); 0 for springs that are no edges. The module header defines w.
  pure function tension_widths(points, triangles, springs) result(widths)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: triangles(:, :)
    type(extensions_t), intent(in) :: springs
    real(rp) :: widths(springs%n)
    integer :: first(size(points, 2)), next(springs%n) ! linked lists of the springs of each point
    integer :: s, t, i
    first = 0
    do s = 1, springs%n
      next(s) = 0
      if (springs%family(s) == SPRING_CROSS) cycle
      next(s) = first(minval(springs%nodes(:, s)))
      first(minval(springs%nodes(:, s))) = s
    end do
    widths = 0
    do t = 1, size(triangles, 2)
      do i = 1, 3
        associate (a => triangles(i, t), b => triangles(mod(i, 3) + 1, t), c => triangles(mod(i + 1, 3) + 1, t))
          s = first(min(a, b))
          do while (s > 0)
            if (maxval(springs%nodes(:, s)) == max(a, b)) exit
            s = next(s)
          end do
          if (s == 0) cycle
          associate (e => points(:, a) - points(:, c), f => points(:, b) - points(:, c))
            widths(s) = widths(s) + 0.5_rp*springs%l0(s)*dot_product(e, f)/norm2(cross(e, f))
          end associate
        end associate
      end do
    end do
  end function tension_widths
end module solid_tension

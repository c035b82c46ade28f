! SPDX-License-Identifier: GPL-3.0-or-later
!> The sheet of patchy_surface with a dome in place of the patch: exp(-d^2/2) at the distance d in radii of its centre, as high as
!> the strength, and higher the farther it is from the side x = 0.
module dome_surface
  use base_kinds, only: rp
  use patchy_surface, only: patchy_t, P_PATCH
  implicit none
  private
  public :: dome_t

  type, extends(patchy_t) :: dome_t
  contains
    procedure :: heights => dome_heights
  end type dome_t

contains

  !> Returns the heights(n) at q, and their derivative with respect to the strength of the dome.
  pure subroutine dome_heights(self, q, heights, by_strength)
    class(dome_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: heights(:), by_strength(:)
    integer :: i
    do i = 1, size(heights)
      associate (site => self%labels%site(:, i), centre => q(P_PATCH + 1:P_PATCH + 2))
        by_strength(i) = (0.5_rp + centre(1))*exp(-sum(((site - centre)/exp(q(P_PATCH + 3)))**2)/2)
        heights(i) = q(1) + q(2)*site(1) + q(3)*site(2) + q(P_PATCH)*by_strength(i)
      end associate
    end do
  end subroutine dome_heights
end module dome_surface

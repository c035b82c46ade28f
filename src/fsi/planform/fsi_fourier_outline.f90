! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives FLUSI's outline of a wing as a radius around a centre: R(theta) = a0/2 + sum_i a_i cos(i theta) + b_i sin(i theta), theta
!> = pi + atan2(span - centre(2), chord - centre(1)).
module fsi_fourier_outline
  use base_constants, only: PI
  use base_kinds, only: rp
  implicit none
  private
  public :: fourier_outline_t

  !> Lengths in L.
  type :: fourier_outline_t
    real(rp) :: a0 = 0
    real(rp), allocatable :: ai(:), bi(:) !< of the same size
    real(rp) :: centre(2) = 0             !< chordwise, spanwise
  contains
    procedure :: radius => outline_radius
    procedure :: scaled => outline_scaled
  end type fourier_outline_t

contains

  !> Returns R in the direction of `arm`, chordwise and spanwise from the centre. Harmonics come by recursion.
  pure real(rp) function outline_radius(self, arm) result(radius)
    class(fourier_outline_t), intent(in) :: self
    real(rp), intent(in) :: arm(2)
    real(rp) :: theta
    complex(rp) :: turn, power
    integer :: i
    theta = PI + atan2(arm(2), arm(1))
    turn = cmplx(cos(theta), sin(theta), rp)
    power = 1
    radius = self%a0/2
    do i = 1, size(self%ai)
      power = power*turn
      radius = radius + self%ai(i)*real(power, rp) + self%bi(i)*aimag(power)
    end do
  end function outline_radius

  !> Returns the outline, `factor` times as large.
  pure type(fourier_outline_t) function outline_scaled(self, factor) result(scaled)
    class(fourier_outline_t), intent(in) :: self
    real(rp), intent(in) :: factor
    scaled%a0 = factor*self%a0
    scaled%ai = factor*self%ai
    scaled%bi = factor*self%bi
    scaled%centre = factor*self%centre
  end function outline_scaled
end module fsi_fourier_outline

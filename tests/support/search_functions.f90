! SPDX-License-Identifier: GPL-3.0-or-later
!> Functions with the minimum 0 that optimisers are measured by; n >= 2.
module search_functions
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  implicit none
  private
  public :: value_of

contains

  !> The function of that name at x: sphere, elli, rosen, cigar, discus, diffpow or rastrigin.
  pure real(rp) function value_of(name, x) result(f)
    character(*), intent(in) :: name
    real(rp), intent(in) :: x(:)
    integer :: i, n
    n = size(x)
    f = 0
    select case (name)
    case ('sphere')
      f = sum(x**2)
    case ('elli')
      do i = 1, n
        f = f + 1.0e6_rp**(real(i - 1, rp)/(n - 1))*x(i)**2
      end do
    case ('rosen')
      f = sum(100*(x(:n - 1)**2 - x(2:))**2 + (x(:n - 1) - 1)**2)
    case ('cigar')
      f = x(1)**2 + 1.0e6_rp*sum(x(2:)**2)
    case ('discus')
      f = 1.0e6_rp*x(1)**2 + sum(x(2:)**2)
    case ('diffpow')
      do i = 1, n
        f = f + abs(x(i))**(2 + 4*real(i - 1, rp)/(n - 1))
      end do
    case ('rastrigin')
      f = 10*n + sum(x**2 - 10*cos(TWO_PI*x))
    end select
  end function value_of
end module search_functions

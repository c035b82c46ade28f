! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes units of keys as products of powers of L, T and M, the units of length, time and mass.
module io_units
  use base_kinds, only: rp
  implicit none
  private
  public :: unit_scales_t, unit_value

  !> One L, T and M in another system of units, SI for instance.
  type :: unit_scales_t
    real(rp) :: length = 1, time = 1, mass = 1
  end type unit_scales_t

contains

  !> Returns the value of one `unit` in the other system: 'L^2/T' gives length^2/time. A quotient has one '/', and blanks separate
  !> factors. Units that do not consist of L, T, M and 1 (degree, points, m/s) give 1.
  pure real(rp) function unit_value(unit, scales) result(value)
    character(*), intent(in) :: unit
    type(unit_scales_t), intent(in) :: scales
    integer :: i, power, sense
    real(rp) :: factor
    value = 1
    sense = 1
    i = 1
    do while (i <= len_trim(unit))
      select case (unit(i:i))
      case ('L')
        factor = scales%length
      case ('T')
        factor = scales%time
      case ('M')
        factor = scales%mass
      case ('1', ' ')
        factor = 1
      case ('/')
        sense = -1
        factor = 1
      case default
        value = 1
        return
      end select
      power = 1
      if (i + 2 <= len_trim(unit)) then
        if (unit(i + 1:i + 1) == '^') then
          power = index('123456789', unit(i + 2:i + 2))
          i = i + 2
        end if
      end if
      value = value*factor**(sense*power)
      i = i + 1
    end do
  end function unit_value
end module io_units

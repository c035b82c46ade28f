! SPDX-License-Identifier: GPL-3.0-or-later
!> Mathematical constants.
module base_constants
  use base_kinds, only: rp
  implicit none
  private
  public :: PI, TWO_PI, IMAG

  real(rp), parameter :: PI = 3.14159265358979323846_rp
  real(rp), parameter :: TWO_PI = 2*PI
  complex(rp), parameter :: IMAG = (0.0_rp, 1.0_rp)
end module base_constants

! SPDX-License-Identifier: GPL-3.0-or-later
!> Mathematical constants.
module base_constants
  use base_kinds, only: rp
  implicit none
  private
  public :: PI, TWO_PI

  real(rp), parameter :: PI = 3.14159265358979323846_rp
  real(rp), parameter :: TWO_PI = 2*PI
end module base_constants

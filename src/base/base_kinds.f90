! SPDX-License-Identifier: GPL-3.0-or-later
!> Number kinds. The project computes in double precision only.
module base_kinds
  use, intrinsic :: iso_fortran_env, only: real64, real32, int64, int32
  implicit none
  private
  public :: rp, sp, i4, i8

  integer, parameter :: rp = real64 !< working precision
  integer, parameter :: sp = real32 !< single precision, for output files only
  integer, parameter :: i4 = int32
  integer, parameter :: i8 = int64
end module base_kinds

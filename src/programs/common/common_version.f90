! SPDX-License-Identifier: GPL-3.0-or-later
!> Prints the answer of every program to --version.
module common_version
  use base_build, only: BUILD_COMMIT, BUILD_COMPILER, BUILD_FLAGS, BUILD_TYPE, BUILD_VERSION
  implicit none
  private
  public :: print_version

contains

  !> Writes to `unit` the version, the compiler and its flags. Programs that use transforms give `has_p3dfft`, which says
  !> whether the build includes P3DFFT.
  subroutine print_version(unit, has_p3dfft)
    integer, intent(in) :: unit
    logical, intent(in), optional :: has_p3dfft
    write (unit, '(a)') 'flusi-msm '//BUILD_VERSION//' ('//BUILD_COMMIT//')'
    write (unit, '(a)') 'compiler  '//BUILD_COMPILER//', '//BUILD_TYPE
    write (unit, '(a)') 'flags     '//BUILD_FLAGS
    if (present(has_p3dfft)) write (unit, '(a)') 'P3DFFT    '//trim(merge('yes', 'no ', has_p3dfft))
  end subroutine print_version
end module common_version

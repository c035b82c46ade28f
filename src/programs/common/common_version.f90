! SPDX-License-Identifier: GPL-3.0-or-later
!> What every program answers to --version.
module common_version
  use base_build, only: BUILD_COMMIT, BUILD_COMPILER, BUILD_FLAGS, BUILD_TYPE, BUILD_VERSION
  use spectral_backends, only: HAS_P3DFFT
  implicit none
  private
  public :: print_version

contains

  !> Writes what this binary was built from.
  subroutine print_version(unit)
    integer, intent(in) :: unit
    write (unit, '(a)') 'flusi-msm '//BUILD_VERSION//' ('//BUILD_COMMIT//')'
    write (unit, '(a)') 'compiler  '//BUILD_COMPILER//', '//BUILD_TYPE
    write (unit, '(a)') 'flags     '//BUILD_FLAGS
    write (unit, '(a)') 'P3DFFT    '//trim(merge('yes', 'no ', HAS_P3DFFT))
  end subroutine print_version
end module common_version

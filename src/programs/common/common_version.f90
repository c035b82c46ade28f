! SPDX-License-Identifier: GPL-3.0-or-later
!> What every program answers to --version.
module common_version
  use base_build, only: BUILD_COMMIT, BUILD_COMPILER, BUILD_FLAGS, BUILD_TYPE, BUILD_VERSION
  implicit none
  private
  public :: print_version

contains

  !> Writes what this binary was built from; of a program that transforms, whether P3DFFT was there.
  subroutine print_version(unit, has_p3dfft)
    integer, intent(in) :: unit
    logical, intent(in), optional :: has_p3dfft
    write (unit, '(a)') 'flusi-msm '//BUILD_VERSION//' ('//BUILD_COMMIT//')'
    write (unit, '(a)') 'compiler  '//BUILD_COMPILER//', '//BUILD_TYPE
    write (unit, '(a)') 'flags     '//BUILD_FLAGS
    if (present(has_p3dfft)) write (unit, '(a)') 'P3DFFT    '//trim(merge('yes', 'no ', has_p3dfft))
  end subroutine print_version
end module common_version

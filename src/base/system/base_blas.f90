! SPDX-License-Identifier: GPL-3.0-or-later
!> Chooses kernels and threads of OpenBLAS, once for the whole process.
!>
!> Kernels round differently. A program must therefore choose them before its first product of matrices: otherwise a diagnosis that
!> continues from its journal would compute with others than the one that was interrupted.
module base_blas
  implicit none
  private
  public :: prepare_blas

  interface
    !> Makes OpenBLAS use one thread, and kernels for AVX2 where it takes a processor that has AVX2 for an old one. A user's
    !> OPENBLAS_CORETYPE stays. Does nothing in later calls, and with another BLAS. Not collective.
    subroutine prepare_blas() bind(c, name='flusi_prepare_blas')
    end subroutine prepare_blas
  end interface
end module base_blas

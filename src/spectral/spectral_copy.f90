! SPDX-License-Identifier: GPL-3.0-or-later
!> Kernels that copy whole arrays, so that plain transforms are pipelines as well.
module spectral_copy
  use base_kinds, only: rp
  use spectral_transform, only: kernels_t
  implicit none
  private
  public :: copy_kernels_t

  !> The caller's arrays: one backward or one forward transform.
  type, extends(kernels_t) :: copy_kernels_t
    complex(rp), pointer, contiguous :: spectral(:, :, :) => null()
    real(rp), pointer, contiguous :: physical(:, :, :, :) => null()
  contains
    procedure :: spectral_in => copy_spectral_in
    procedure :: product => copy_product
    procedure :: spectral_out => copy_spectral_out
    procedure :: reduce => copy_reduce
  end type copy_kernels_t

contains

  subroutine copy_spectral_in(self, first, count, fields)
    class(copy_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    fields(:, 1:count, :) = self%spectral(:, first:first + count - 1, :)
  end subroutine copy_spectral_in

  subroutine copy_product(self, first, count, z, in, out)
    class(copy_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    if (self%n_in > 0) self%physical(:, first:first + count - 1, z, :) = in(:, 1:count, :)
    if (self%n_out > 0) out(:, 1:count, :) = self%physical(:, first:first + count - 1, z, :)
  end subroutine copy_product

  subroutine copy_spectral_out(self, first, count, fields)
    class(copy_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    self%spectral(:, first:first + count - 1, :) = fields(:, 1:count, :)
  end subroutine copy_spectral_out

  subroutine copy_reduce(self)
    class(copy_kernels_t), intent(inout) :: self
    associate (nothing_to_reduce => self)
    end associate
  end subroutine copy_reduce
end module spectral_copy

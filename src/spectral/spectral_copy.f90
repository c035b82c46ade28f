! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines kernels that copy whole arrays, so that plain transforms are pipelines as well.
module spectral_copy
  use base_kinds, only: rp
  use spectral_transform, only: kernels_t, transform_t
  implicit none
  private
  public :: copy_backward, copy_forward

  !> The caller's arrays: one backward or one forward transform.
  type, extends(kernels_t) :: copy_kernels_t
    complex(rp), pointer, contiguous :: spectral(:, :, :) => null()
    real(rp), pointer, contiguous :: physical(:, :, :, :) => null()
  contains
    procedure :: spectral_in => copy_spectral_in
    procedure :: product => copy_product
    procedure :: spectral_out => copy_spectral_out
  end type copy_kernels_t

contains

  !> Transforms spectral(nkz, n, nf) to physical(nx, ny_local, nz_local, nf) by pipelines of `most` fields at most. Collective.
  subroutine copy_backward(transform, most, spectral, physical)
    class(transform_t), intent(inout) :: transform
    integer, intent(in) :: most
    complex(rp), contiguous, target, intent(in) :: spectral(:, :, :)
    real(rp), contiguous, target, intent(inout) :: physical(:, :, :, :)
    type(copy_kernels_t) :: kernels
    integer :: f
    do f = 1, size(spectral, 3), most
      kernels%n_in = min(most, size(spectral, 3) - f + 1)
      kernels%spectral => spectral(:, :, f:f + kernels%n_in - 1)
      kernels%physical => physical(:, :, :, f:f + kernels%n_in - 1)
      call transform%pipeline(kernels)
    end do
  end subroutine copy_backward

  !> Transforms physical(nx, ny_local, nz_local, nf) to spectral(nkz, n, nf) by pipelines of `most` fields at most. Collective.
  subroutine copy_forward(transform, most, physical, spectral)
    class(transform_t), intent(inout) :: transform
    integer, intent(in) :: most
    real(rp), contiguous, target, intent(in) :: physical(:, :, :, :)
    complex(rp), contiguous, target, intent(inout) :: spectral(:, :, :)
    type(copy_kernels_t) :: kernels
    integer :: f
    do f = 1, size(spectral, 3), most
      kernels%n_out = min(most, size(spectral, 3) - f + 1)
      kernels%spectral => spectral(:, :, f:f + kernels%n_out - 1)
      kernels%physical => physical(:, :, :, f:f + kernels%n_out - 1)
      call transform%pipeline(kernels)
    end do
  end subroutine copy_forward

  !> Passes the spectrum on these sticks to the pipeline; see kernels_t.
  subroutine copy_spectral_in(self, first, count, fields)
    class(copy_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    fields(:, 1:count, :) = self%spectral(:, first:first + count - 1, :)
  end subroutine copy_spectral_in

  !> Takes or gives the fields on the lines of this batch; see kernels_t.
  subroutine copy_product(self, first, count, z, in, out)
    class(copy_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    if (self%n_in > 0) self%physical(:, first:first + count - 1, z, :) = in(:, 1:count, :)
    if (self%n_out > 0) out(:, 1:count, :) = self%physical(:, first:first + count - 1, z, :)
  end subroutine copy_product

  !> Takes the spectrum on these sticks from the pipeline; see kernels_t.
  subroutine copy_spectral_out(self, first, count, fields)
    class(copy_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    self%spectral(:, first:first + count - 1, :) = fields(:, 1:count, :)
  end subroutine copy_spectral_out
end module spectral_copy

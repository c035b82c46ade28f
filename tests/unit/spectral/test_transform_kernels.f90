! SPDX-License-Identifier: GPL-3.0-or-later
!> Kernels for the transform test: two products of five fields that depend on the global mode number; one of them is the
!> curl of two others.
module test_transform_kernels
  use base_kinds, only: rp
  use spectral_sticks, only: sticks_t
  use spectral_transform, only: kernels_t, transform_t
  implicit none
  private
  public :: square_kernels_t

  type, extends(kernels_t) :: square_kernels_t
    type(sticks_t) :: sticks
    complex(rp), allocatable :: result(:, :, :)
    logical :: has_returned = .false.
    logical :: in_order = .true.
  contains
    procedure :: init, spectral_in, product, spectral_out
  end type square_kernels_t

contains

  subroutine init(self, t)
    class(square_kernels_t), intent(inout) :: self
    class(transform_t), intent(in) :: t
    self%n_in = 5
    self%curl = 4
    self%n_out = 2
    self%sticks = t%sticks
    allocate (self%result(t%sticks%nkz, t%sticks%n, 2))
  end subroutine init

  subroutine spectral_in(self, first, count, fields)
    class(square_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    integer :: s, f, i
    do f = 1, 5
      if (f == 4) cycle
      do s = 1, count
        i = first + s - 1
        fields(:, s, f) = exp(-0.1_rp*(self%sticks%jx(i)**2 + self%sticks%jy(i)**2 + self%sticks%jz**2)/f)* &
                          cmplx(1.0_rp, f*self%sticks%jz + self%sticks%jx(i), rp)
      end do
    end do
    if (.not. self%fill_curl) return
    do s = 1, count
      i = first + s - 1
      fields(:, s, 4) = (0, 1)*(self%sticks%kx(i)*fields(:, s, 2) - self%sticks%ky(i)*fields(:, s, 1))
    end do
  end subroutine spectral_in

  subroutine product(self, first, count, z, in, out)
    class(square_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    if (self%has_returned .or. z < 1 .or. first < 1) self%in_order = .false.
    out(:, 1:count, 1) = in(:, 1:count, 1)*in(:, 1:count, 2)
    out(:, 1:count, 2) = in(:, 1:count, 3)**2 + in(:, 1:count, 4)*in(:, 1:count, 5)
  end subroutine product

  subroutine spectral_out(self, first, count, fields)
    class(square_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    self%has_returned = .true.
    self%result(:, first:first + count - 1, :) = fields(:, 1:count, :)
  end subroutine spectral_out
end module test_transform_kernels

! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the Q criterion of a velocity: Q = -1/2 A_ij A_ji with A_ij = d u_i/d x_j.
!>
!> For a flow without divergence it is (|W|^2 - |S|^2)/2 of the antisymmetric and the symmetric part of A, and half the Laplacian of
!> the pressure where no force acts; it is positive where rotation is stronger than strain (Hunt, Wray & Moin 1988). Derivatives are
!> those of the retained modes. The nine inverse transforms are done in two rounds, so that no round needs more memory than a time
!> step.
module fluid_q_criterion
  use base_kinds, only: rp
  use spectral_transform, only: kernels_t, transform_t
  implicit none
  private
  public :: q_criterion

  !> Components (i, j) of A that are multiplied in the two rounds: first the components in the x-y plane and the diagonal, then the
  !> others.
  integer, parameter :: IN_PLANE(2, 5) = reshape([1, 1, 2, 2, 3, 3, 1, 2, 2, 1], [2, 5])
  integer, parameter :: ACROSS(2, 4) = reshape([1, 3, 3, 1, 2, 3, 3, 2], [2, 4])

  type, extends(kernels_t) :: q_kernels_t
    complex(rp), pointer, contiguous :: u(:, :, :) => null() !< (nkz, sticks, 3)
    real(rp), pointer, contiguous :: q(:, :, :) => null()    !< (nx, ny_local, nz_local) 1/T^2
    real(rp), allocatable :: kx(:), ky(:), kz(:)             !< of the sticks and along them, 1/L
    logical :: is_first = .true.
  contains
    procedure :: spectral_in => q_spectral_in
    procedure :: product => q_product
    procedure :: spectral_out => q_spectral_out
  end type q_kernels_t

contains

  !> Computes Q of the velocity with the spectrum `u` on all points of this rank [1/T^2]. Collective.
  subroutine q_criterion(transform, u, q)
    class(transform_t), intent(inout) :: transform
    complex(rp), contiguous, target, intent(in) :: u(:, :, :)   !< (nkz, sticks, 3)
    real(rp), contiguous, target, intent(inout) :: q(:, :, :)   !< (nx, ny_local, nz_local) 1/T^2
    type(q_kernels_t) :: kernels
    kernels%u => u
    kernels%q => q
    kernels%kx = transform%sticks%kx
    kernels%ky = transform%sticks%ky
    kernels%kz = transform%sticks%kz
    kernels%n_in = size(IN_PLANE, 2)
    call transform%pipeline(kernels)
    kernels%is_first = .false.
    kernels%n_in = size(ACROSS, 2)
    call transform%pipeline(kernels)
  end subroutine q_criterion

  !> Fills `fields` with the derivatives of this round; see kernels_t.
  subroutine q_spectral_in(self, first, count, fields)
    class(q_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    integer :: i, f
    do f = 1, self%n_in
      do i = 1, count
        if (self%is_first) then
          call differentiate(self, first + i - 1, IN_PLANE(:, f), fields(:, i, f))
        else
          call differentiate(self, first + i - 1, ACROSS(:, f), fields(:, i, f))
        end if
      end do
    end do
  end subroutine q_spectral_in

  !> Computes the derivative of component `pair(1)` in direction `pair(2)` on stick `s`.
  pure subroutine differentiate(self, s, pair, derivative)
    class(q_kernels_t), intent(in) :: self
    integer, intent(in) :: s, pair(2)
    complex(rp), intent(inout) :: derivative(:)
    complex(rp), parameter :: I = (0.0_rp, 1.0_rp)
    select case (pair(2))
    case (1)
      derivative = I*self%kx(s)*self%u(:, s, pair(1))
    case (2)
      derivative = I*self%ky(s)*self%u(:, s, pair(1))
    case default
      derivative = I*self%kz*self%u(:, s, pair(1))
    end select
  end subroutine differentiate

  !> Adds the part of this round to Q; see kernels_t.
  subroutine q_product(self, first, count, z, in, out)
    class(q_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    integer :: i, y
    do i = 1, count
      y = first + i - 1
      if (self%is_first) then
        self%q(:, y, z) = -0.5_rp*(in(:, i, 1)**2 + in(:, i, 2)**2 + in(:, i, 3)**2) - in(:, i, 4)*in(:, i, 5)
      else
        self%q(:, y, z) = self%q(:, y, z) - in(:, i, 1)*in(:, i, 2) - in(:, i, 3)*in(:, i, 4)
      end if
    end do
    associate (nothing_to_transform => out)
    end associate
  end subroutine q_product

  !> Does nothing, since nothing is transformed forward; see kernels_t.
  subroutine q_spectral_out(self, first, count, fields)
    class(q_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    associate (nothing_comes => self, there => first, is => count, here => fields)
    end associate
  end subroutine q_spectral_out
end module fluid_q_criterion

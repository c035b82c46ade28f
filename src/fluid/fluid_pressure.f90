! SPDX-License-Identifier: GPL-3.0-or-later
!> Keeps what the static pressure of a pass needs, and computes it on demand.
!>
!> p = Pi - |u|^2/2 in Fourier space, where Pi is the total pressure that the projection removes. Both are cut off at the
!> truncation: their modes beyond it nearly cancel, and if only one of them were cut off, p would contain the modes of the other.
!> Inside the truncation p is exact for the velocity and forces of the pass, since products alias only beyond it. A pass that
!> keeps p transforms |u|^2/2 as one more product and writes one spectral field. p itself costs one inverse transform, or only
!> parts of one if not all lines are wanted.
module fluid_pressure
  use base_errors, only: require
  use base_kinds, only: rp
  use base_memory, only: check_allocation, COMPLEX_BYTES
  use spectral_sticks, only: sticks_t
  use spectral_transform, only: kernels_t, transform_t
  implicit none
  private
  public :: pressure_t

  !> The data of the last pass that kept the pressure. Only `init` allocates them.
  type :: pressure_t
    complex(rp), allocatable, private :: spectrum(:, :) !< (nkz, sticks) p
  contains
    procedure :: init => pressure_init
    procedure :: keep => pressure_keep
    procedure :: field => pressure_field
    procedure :: memory_bytes => pressure_memory_bytes
  end type pressure_t

  !> Gives p in physical space.
  type, extends(kernels_t) :: pressure_kernels_t
    complex(rp), pointer, contiguous :: spectrum(:, :) => null()
    real(rp), pointer, contiguous :: p(:, :, :) => null()
  contains
    procedure :: spectral_in => kernels_spectral_in
    procedure :: product => kernels_product
    procedure :: spectral_out => kernels_spectral_out
  end type pressure_kernels_t

contains

  !> Allocates this rank's share.
  subroutine pressure_init(self, sticks)
    class(pressure_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    integer :: status
    allocate (self%spectrum(sticks%nkz, sticks%n), stat=status)
    call check_allocation(status, [sticks%nkz, sticks%n], COMPLEX_BYTES, 'the pressure')
  end subroutine pressure_init

  !> Keeps the spectrum of p on stick `s`.
  subroutine pressure_keep(self, sticks, s, total, kinetic)
    class(pressure_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    integer, intent(in) :: s
    complex(rp), intent(in) :: total(:)   !< (nkz) Pi
    complex(rp), intent(in) :: kinetic(:) !< (nkz) |u|^2/2
    self%spectrum(:, s) = total - kinetic
    call sticks%truncate(s, self%spectrum(:, s))
  end subroutine pressure_keep

  !> Computes the static pressure p (nx, ny_local, nz_local) from what a pass has kept. On lines that are not wanted it is
  !> undefined. Collective.
  subroutine pressure_field(self, transform, p, lines)
    class(pressure_t), target, intent(in) :: self
    class(transform_t), intent(inout) :: transform
    real(rp), contiguous, target, intent(inout) :: p(:, :, :)
    logical, contiguous, target, optional, intent(in) :: lines(:, :) !< (ny_local, nz_local) the wanted ones, or all
    type(pressure_kernels_t) :: kernels
    call require(allocated(self%spectrum), 'pressure_t: there is no room for the pressure')
    if (present(lines)) kernels%lines => lines
    kernels%n_in = 1
    kernels%spectrum => self%spectrum
    kernels%p => p
    call transform%pipeline(kernels)
  end subroutine pressure_field

  !> Returns the bytes of its large array.
  pure real(rp) function pressure_memory_bytes(self) result(bytes)
    class(pressure_t), intent(in) :: self
    bytes = 0
    if (allocated(self%spectrum)) bytes = 16*real(size(self%spectrum), rp)
  end function pressure_memory_bytes

  !> Fills `fields` with the kept spectrum; see kernels_t.
  subroutine kernels_spectral_in(self, first, count, fields)
    class(pressure_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    fields(:, 1:count, 1) = self%spectrum(:, first:first + count - 1)
  end subroutine kernels_spectral_in

  !> Stores the pressure on the lines of this batch; see kernels_t.
  subroutine kernels_product(self, first, count, z, in, out)
    class(pressure_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    self%p(:, first:first + count - 1, z) = in(:, 1:count, 1)
    associate (nothing_to_transform => out)
    end associate
  end subroutine kernels_product

  !> Does nothing, since nothing is transformed forward; see kernels_t.
  subroutine kernels_spectral_out(self, first, count, fields)
    class(pressure_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    associate (nothing_comes => self, there => first, is => count, here => fields)
    end associate
  end subroutine kernels_spectral_out
end module fluid_pressure

! SPDX-License-Identifier: GPL-3.0-or-later
!> The static pressure of a pass, kept on the way and computed when it is asked for.
!>
!> p = Pi - |u|^2/2 pointwise, where Pi is the truncated total pressure that the projection removes. A pass keeps
!> the spectrum of Pi and |u|^2/2: a write of one spectral field and a sweep over the lines of the grid where the
!> pressure is wanted, while they are in cache; no transform. The pressure itself costs one inverse transform, and
!> only parts of it if not all lines are wanted.
module fluid_pressure
  use base_errors, only: require
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use parallel_block, only: block_t
  use spectral_sticks, only: sticks_t
  use spectral_transform, only: kernels_t, transform_t
  implicit none
  private
  public :: pressure_t

  !> Of the last pass that kept it. Allocated by `init` only.
  type :: pressure_t
    complex(rp), allocatable :: total(:, :)           !< (nkz, sticks) spectrum of Pi
    real(rp), allocatable, private :: kinetic(:, :, :) !< (nx, ny_local, nz_local) |u|^2/2 on `lines`
    logical, allocatable :: lines(:, :)               !< (ny_local, nz_local) where the pass keeps |u|^2/2
    logical :: is_timed = .false.
    real(rp) :: seconds = 0 !< wall time that keeping has taken on this rank so far, if it is timed
  contains
    procedure :: init => pressure_init
    procedure :: keep_kinetic => pressure_keep_kinetic
    procedure :: keep_total => pressure_keep_total
    procedure :: field => pressure_field
    procedure :: memory_bytes => pressure_memory_bytes
  end type pressure_t

  !> Gives Pi in physical space less |u|^2/2.
  type, extends(kernels_t) :: pressure_kernels_t
    complex(rp), pointer, contiguous :: total(:, :) => null()
    real(rp), pointer, contiguous :: kinetic(:, :, :) => null(), p(:, :, :) => null()
  contains
    procedure :: spectral_in => kernels_spectral_in
    procedure :: product => kernels_product
    procedure :: spectral_out => kernels_spectral_out
    procedure :: reduce => kernels_reduce
  end type pressure_kernels_t

contains

  !> Room for this rank's share.
  subroutine pressure_init(self, sticks, block)
    class(pressure_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    type(block_t), intent(in) :: block
    allocate (self%total(sticks%nkz, sticks%n))
    allocate (self%kinetic(block%count(1), block%count(2), block%count(3)))
    allocate (self%lines(block%count(2), block%count(3)), source=.true.)
  end subroutine pressure_init

  !> Keeps |u|^2/2 of the lines first .. first+count-1 of plane z, as far as they are among `lines`.
  subroutine pressure_keep_kinetic(self, first, count, z, u)
    class(pressure_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), intent(in) :: u(:, :, :) !< (nx, at least count, at least 3)
    real(rp) :: begun
    integer :: i
    begun = 0
    if (self%is_timed) begun = wall_seconds()
    do i = 1, count
      if (self%lines(first + i - 1, z)) self%kinetic(:, first + i - 1, z) = &
        0.5_rp*(u(:, i, 1)**2 + u(:, i, 2)**2 + u(:, i, 3)**2)
    end do
    if (self%is_timed) self%seconds = self%seconds + wall_seconds() - begun
  end subroutine pressure_keep_kinetic

  !> Keeps Pi on stick `s`, without the modes outside the truncation.
  subroutine pressure_keep_total(self, sticks, s, stick)
    class(pressure_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    integer, intent(in) :: s
    complex(rp), intent(in) :: stick(:) !< (nkz)
    real(rp) :: begun
    begun = 0
    if (self%is_timed) begun = wall_seconds()
    self%total(:, s) = stick
    call sticks%truncate(s, self%total(:, s))
    if (self%is_timed) self%seconds = self%seconds + wall_seconds() - begun
  end subroutine pressure_keep_total

  !> The static pressure p (nx, ny_local, nz_local), on other lines than those that are wanted undefined. What is
  !> wanted must have been kept. Collective.
  subroutine pressure_field(self, transform, p, lines)
    class(pressure_t), target, intent(in) :: self
    class(transform_t), intent(inout) :: transform
    real(rp), contiguous, target, intent(inout) :: p(:, :, :)
    logical, contiguous, target, optional, intent(in) :: lines(:, :) !< (ny_local, nz_local) those that are wanted, or all
    type(pressure_kernels_t) :: kernels
    if (present(lines)) then
      call require(.not. any(lines .and. .not. self%lines), 'pressure_t: the pass has not kept all of these lines')
      kernels%lines => lines
    else
      call require(all(self%lines), 'pressure_t: the pass has kept some lines only')
    end if
    kernels%n_in = 1
    kernels%total => self%total
    kernels%kinetic => self%kinetic
    kernels%p => p
    call transform%pipeline(kernels)
  end subroutine pressure_field

  !> Bytes of its large arrays.
  pure real(rp) function pressure_memory_bytes(self) result(bytes)
    class(pressure_t), intent(in) :: self
    bytes = 0
    if (allocated(self%total)) bytes = 16*real(size(self%total), rp) + 8*real(size(self%kinetic), rp)
  end function pressure_memory_bytes

  subroutine kernels_spectral_in(self, first, count, fields)
    class(pressure_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    fields(:, 1:count, 1) = self%total(:, first:first + count - 1)
  end subroutine kernels_spectral_in

  subroutine kernels_product(self, first, count, z, in, out)
    class(pressure_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    integer :: i, y
    do i = 1, count
      y = first + i - 1
      if (associated(self%lines)) then
        if (.not. self%lines(y, z)) cycle
      end if
      self%p(:, y, z) = in(:, i, 1) - self%kinetic(:, y, z)
    end do
    associate (nothing_to_transform => out)
    end associate
  end subroutine kernels_product

  subroutine kernels_spectral_out(self, first, count, fields)
    class(pressure_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    associate (nothing_comes => self, there => first, is => count, here => fields)
    end associate
  end subroutine kernels_spectral_out

  subroutine kernels_reduce(self)
    class(pressure_kernels_t), intent(inout) :: self
    associate (nothing_to_reduce => self)
    end associate
  end subroutine kernels_reduce
end module fluid_pressure

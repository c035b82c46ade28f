! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the interface between physics and Fourier transforms.
!>
!> Physics is written as three kernels: *spectral in* turns the state on a few sticks into the fields
!> to invert, *product* multiplies fields in physical space on a few lines, *spectral out* receives the
!> transformed products on a few sticks. `to_points` runs the first two over all sticks and lines, `to_modes` the third
!> over all sticks; `pipeline` is both. Between them results of the products (the largest velocity, forces) may be
!> reduced over the ranks. A backend has to provide `forward` and `backward`; the pipeline given here works on whole
!> arrays with any backend, and a backend may override its two parts with fused ones. `spectral_backends` makes one by
!> its name.
!>
!> Forward transforms are divided by the number of points, so that mode (0,0,0) is the mean.
module spectral_transform
  use base_kinds, only: rp
  use base_memory, only: check_allocation, COMPLEX_BYTES, REAL_BYTES
  use base_errors, only: require
  use parallel_block, only: block_t
  use parallel_exchange, only: traffic_t
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  use spectral_sticks, only: sticks_t
  implicit none
  private
  public :: transform_t, kernels_t

  integer, parameter :: BATCH_POINTS = 2000 !< of a product: its fields stay in the L2 cache

  !> The three kernels of a pipeline and the number of fields they exchange.
  type, abstract :: kernels_t
    integer :: n_in = 0  !< fields that spectral in provides to product
    integer :: n_out = 0 !< fields that product provides to spectral out
    !> Number of the field that is i kx f2 - i ky f1 of the fields f1 and f2, numbers 1 and 2; 0 for none. A backend may compute
    !> it from them during the transform, which saves a transform in z and an exchange. It then clears `fill_curl`, and spectral
    !> in need not compute the field.
    integer :: curl = 0
    logical :: fill_curl = .true.
    !> (ny_local, nz_local) lines whose product is wanted; all of them if not associated. A backend may skip the others. Their
    !> output counts as zero.
    logical, pointer, contiguous :: lines(:, :) => null()
  contains
    procedure(spectral_in_i), deferred :: spectral_in
    procedure(product_i), deferred :: product
    procedure(spectral_out_i), deferred :: spectral_out
    procedure, non_overridable :: place_of => kernels_place_of
  end type kernels_t

  !> The procedures that every transform backend has.
  type, abstract :: transform_t
    type(world_t) :: world
    type(grid_t) :: grid
    type(sticks_t) :: sticks !< retained modes; spectral arrays are (sticks%nkz, sticks%n, fields)
    type(block_t) :: block   !< this rank's box of points; physical arrays are (nx, ny_local, nz_local, fields)
    integer :: rows = 1, columns = 1 !< process grid
    type(traffic_t) :: traffic !< of this rank's exchanges so far, if the backend knows
    complex(rp), allocatable, private :: staged_spectral(:, :, :)
    real(rp), allocatable, private :: staged_physical(:, :, :, :)
    real(rp), allocatable, private :: staged_lines(:, :, :) !< (nx, lines, fields) one batch
  contains
    procedure(backward_i), deferred :: backward
    procedure(forward_i), deferred :: forward
    procedure(free_i), deferred :: free
    procedure(memory_bytes_i), deferred :: memory_bytes
    procedure, non_overridable :: reserve => transform_reserve
    procedure, non_overridable :: staged_bytes => transform_staged_bytes
    procedure, non_overridable :: pipeline => transform_pipeline
    procedure :: to_points => transform_to_points
    procedure :: to_points_part => transform_to_points_part
    procedure :: to_modes => transform_to_modes
    procedure :: most_parts => transform_most_parts
    procedure :: release => transform_release
  end type transform_t

  abstract interface
    !> Fills `fields(:, 1:count, f)` for the local sticks first .. first+count-1.
    subroutine spectral_in_i(self, first, count, fields)
      import :: kernels_t, rp
      class(kernels_t), intent(inout) :: self
      integer, intent(in) :: first, count
      complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    end subroutine spectral_in_i

    !> Fills `out(:, 1:count, n_out)` from `in(nx, lines, n_in)`, on the local lines y = first .. first+count-1 at local plane z.
    subroutine product_i(self, first, count, z, in, out)
      import :: kernels_t, rp
      class(kernels_t), intent(inout) :: self
      integer, intent(in) :: first, count, z
      real(rp), contiguous, intent(in) :: in(:, :, :)
      real(rp), contiguous, intent(inout) :: out(:, :, :)
    end subroutine product_i

    !> Receives the transformed products on the local sticks first .. first+count-1; may overwrite them.
    subroutine spectral_out_i(self, first, count, fields)
      import :: kernels_t, rp
      class(kernels_t), intent(inout) :: self
      integer, intent(in) :: first, count
      complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    end subroutine spectral_out_i

    !> Transforms spectral(nkz, n, nf) to physical(nx, ny_local, nz_local, nf). Collective.
    subroutine backward_i(self, spectral, physical)
      import :: transform_t, rp
      class(transform_t), intent(inout) :: self
      complex(rp), contiguous, target, intent(in) :: spectral(:, :, :)
      real(rp), contiguous, target, intent(inout) :: physical(:, :, :, :)
    end subroutine backward_i

    !> Transforms physical(nx, ny_local, nz_local, nf) to spectral(nkz, n, nf). Modes of the stored sticks that lie outside the
    !> truncation are returned as they are; the kernels must drop them. Collective.
    subroutine forward_i(self, physical, spectral)
      import :: transform_t, rp
      class(transform_t), intent(inout) :: self
      real(rp), contiguous, target, intent(in) :: physical(:, :, :, :)
      complex(rp), contiguous, target, intent(inout) :: spectral(:, :, :)
    end subroutine forward_i

    !> Releases plans, buffers and communicators. Collective.
    subroutine free_i(self)
      import :: transform_t
      class(transform_t), intent(inout) :: self
    end subroutine free_i

    !> Returns the bytes of this rank's buffers.
    pure real(rp) function memory_bytes_i(self)
      import :: transform_t, rp
      class(transform_t), intent(in) :: self
    end function memory_bytes_i
  end interface

contains

  !> Returns the number of field `f` among the exchanged fields if the backend computes the curl during the transform.
  pure integer function kernels_place_of(self, f) result(place)
    class(kernels_t), intent(in) :: self
    integer, intent(in) :: f
    place = f
    if (self%curl > 0 .and. f >= self%curl) place = f - 1
  end function kernels_place_of

  !> Runs all kernels. Collective.
  subroutine transform_pipeline(self, kernels)
    class(transform_t), intent(inout) :: self
    class(kernels_t), intent(inout) :: kernels
    call self%to_points(kernels)
    if (kernels%n_out > 0) call self%to_modes(kernels)
  end subroutine transform_pipeline

  !> Takes the fields of spectral in to the points and multiplies them there, on whole arrays through `backward`. The arrays were
  !> reserved, or grow to the largest need; they hold the products until `to_modes`. Collective.
  subroutine transform_to_points(self, kernels)
    class(transform_t), intent(inout) :: self
    class(kernels_t), intent(inout) :: kernels
    complex(rp), allocatable :: spectral(:, :, :)
    real(rp), allocatable :: physical(:, :, :, :), lines(:, :, :)
    integer :: n_fields, n_in
    n_in = kernels%n_in
    n_fields = n_in + kernels%n_out
    call self%reserve(n_fields)
    call move_alloc(self%staged_spectral, spectral)
    call move_alloc(self%staged_physical, physical)
    call move_alloc(self%staged_lines, lines)
    kernels%fill_curl = .true.
    if (n_in > 0) then
      call kernels%spectral_in(1, self%sticks%n, spectral(:, :, 1:n_in))
      call self%backward(spectral(:, :, 1:n_in), physical(:, :, :, 1:n_in))
    end if
    call multiply_all(kernels, physical, lines(:, :, 1:n_in), lines(:, :, n_in + 1:n_fields))
    call move_alloc(spectral, self%staged_spectral)
    call move_alloc(physical, self%staged_physical)
    call move_alloc(lines, self%staged_lines)
  end subroutine transform_to_points

  !> Hands the transformed products of the last `to_points` to spectral out. Collective.
  subroutine transform_to_modes(self, kernels)
    class(transform_t), intent(inout) :: self
    class(kernels_t), intent(inout) :: kernels
    complex(rp), allocatable :: spectral(:, :, :)
    real(rp), allocatable :: physical(:, :, :, :)
    integer :: first, last
    first = kernels%n_in + 1
    last = kernels%n_in + kernels%n_out
    call move_alloc(self%staged_spectral, spectral)
    call move_alloc(self%staged_physical, physical)
    call self%forward(physical(:, :, :, first:last), spectral(:, :, first:last))
    call kernels%spectral_out(1, self%sticks%n, spectral(:, :, first:last))
    call move_alloc(spectral, self%staged_spectral)
    call move_alloc(physical, self%staged_physical)
  end subroutine transform_to_modes

  !> Does what `to_points` does with only the planes of part `part` of `parts` of each rank's share, so that buffers are smaller by
  !> this factor. Kernels that have output need parts = 1. `split_evenly` of the rank's planes tells which planes these are. Parts
  !> are at most `most_parts`. Collective.
  subroutine transform_to_points_part(self, kernels, part, parts)
    class(transform_t), intent(inout) :: self
    class(kernels_t), intent(inout) :: kernels
    integer, intent(in) :: part, parts
    call require(part == 1 .and. parts == 1, 'transform_t: this transform knows no parts')
    call self%to_points(kernels)
  end subroutine transform_to_points_part

  !> Returns into how many parts a pipeline may be divided.
  pure integer function transform_most_parts(self) result(most)
    class(transform_t), intent(in) :: self
    most = 1
    associate (for_all_backends => self)
    end associate
  end function transform_most_parts

  !> Releases the memory that a pipeline allocates again when it needs it.
  subroutine transform_release(self)
    class(transform_t), intent(inout) :: self
    associate (nothing_to_give_back => self)
    end associate
  end subroutine transform_release

  !> Makes room for pipelines of up to `most` fields, in and out.
  subroutine transform_reserve(self, most)
    class(transform_t), intent(inout) :: self
    integer, intent(in) :: most
    integer :: status
    if (allocated(self%staged_spectral)) then
      if (size(self%staged_spectral, 3) >= most) return
      deallocate (self%staged_spectral, self%staged_physical, self%staged_lines)
    end if
    associate (n => self%block%count)
      allocate (self%staged_spectral(self%sticks%nkz, self%sticks%n, most), stat=status)
      call check_allocation(status, [self%sticks%nkz, self%sticks%n, most], COMPLEX_BYTES, 'spectra of a transform')
      allocate (self%staged_physical(n(1), n(2), n(3), most), stat=status)
      call check_allocation(status, [n, most], REAL_BYTES, 'fields of a transform')
      allocate (self%staged_lines(n(1), max(1, min(n(2), BATCH_POINTS/n(1))), most))
    end associate
    self%staged_lines = 0 ! a partly filled batch must not hold undefined numbers
  end subroutine transform_reserve

  !> Computes the products of all wanted lines: from the first n_in fields of `physical` into the n_out after them, batch by batch
  !> through `in` and `out`.
  subroutine multiply_all(kernels, physical, in, out)
    class(kernels_t), intent(inout) :: kernels
    real(rp), contiguous, intent(inout) :: physical(:, :, :, :), in(:, :, :), out(:, :, :)
    integer :: first, last, count, z, n_in, n_fields
    n_in = kernels%n_in
    n_fields = n_in + kernels%n_out
    do z = 1, size(physical, 3)
      do first = 1, size(physical, 2), size(in, 2)
        last = min(first + size(in, 2) - 1, size(physical, 2))
        count = last - first + 1
        if (associated(kernels%lines)) then
          if (.not. any(kernels%lines(first:last, z))) then
            physical(:, first:last, z, n_in + 1:n_fields) = 0
            cycle
          end if
        end if
        in(:, 1:count, :) = physical(:, first:last, z, 1:n_in)
        call kernels%product(first, count, z, in, out)
        physical(:, first:last, z, n_in + 1:n_fields) = out(:, 1:count, :)
      end do
    end do
  end subroutine multiply_all

  !> Returns the bytes of the whole arrays of `to_points` and `to_modes`.
  pure real(rp) function transform_staged_bytes(self) result(bytes)
    class(transform_t), intent(in) :: self
    bytes = 0
    if (allocated(self%staged_spectral)) bytes = 16*real(size(self%staged_spectral), rp) + &
                                                 8*real(size(self%staged_physical), rp) + &
                                                 8*real(size(self%staged_lines), rp)
  end function transform_staged_bytes
end module spectral_transform

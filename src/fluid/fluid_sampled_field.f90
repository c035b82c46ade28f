! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds a field that is computed only where it is sampled: the lines of the grid near the points of all samples.
module fluid_sampled_field
  use base_kinds, only: rp
  use fluid_sampling, only: sampler_t, samples_t
  use parallel_block, only: allocate_fields, block_t
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: sampled_field_t

  !> Nothing is allocated after `init`.
  type :: sampled_field_t
    real(rp), allocatable :: values(:, :, :, :) !< (nx, ny_local, nz_local, 1)
    logical, allocatable :: lines(:, :)         !< (ny_local, nz_local) where they are wanted
    type(sampler_t), private :: sampler
  contains
    procedure :: init => field_init
    procedure :: choose_lines => field_choose_lines
    procedure :: sample => field_sample
    procedure :: sample_other => field_sample_other
    procedure :: memory_bytes => field_memory_bytes
  end type sampled_field_t

contains

  !> Makes room for a field on this rank's `block` of `grid`.
  subroutine field_init(self, world, grid, block)
    class(sampled_field_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    call self%sampler%init(world, grid, block)
    call allocate_fields(self%values, block, 1, 'a field that is sampled')
    allocate (self%lines(block%count(2), block%count(3)))
  end subroutine field_init

  !> Sets `lines` to the lines near the points of the samples.
  subroutine field_choose_lines(self, samples)
    class(sampled_field_t), intent(inout) :: self
    type(samples_t), intent(in) :: samples(:)
    integer :: i
    self%lines = .false.
    do i = 1, size(samples)
      call self%sampler%select_lines(samples(i)%points, self%lines)
    end do
  end subroutine field_choose_lines

  !> Sets the values of the samples for which the lines were chosen, the same on all ranks. Collective.
  subroutine field_sample(self, samples)
    class(sampled_field_t), intent(in) :: self
    type(samples_t), intent(inout) :: samples(:)
    call self%sample_other(self%values(:, :, :, 1), samples)
  end subroutine field_sample

  !> Sets the values of samples to those of another field (nx, ny_local, nz_local), which has all lines. Collective.
  subroutine field_sample_other(self, field, samples)
    class(sampled_field_t), intent(in) :: self
    real(rp), contiguous, intent(in) :: field(:, :, :)
    type(samples_t), intent(inout) :: samples(:)
    integer :: i
    do i = 1, size(samples)
      call self%sampler%sample(samples(i)%points, field, samples(i)%values)
    end do
  end subroutine field_sample_other

  !> Returns the bytes of its large array on this rank.
  pure real(rp) function field_memory_bytes(self) result(bytes)
    class(sampled_field_t), intent(in) :: self
    bytes = 0
    if (allocated(self%values)) bytes = 8*real(size(self%values), rp)
  end function field_memory_bytes
end module fluid_sampled_field

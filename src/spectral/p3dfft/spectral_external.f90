! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the transforms of optional libraries: P3DFFT is available.
module spectral_external
  use base_errors, only: failure_t, require
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  use spectral_p3dfft, only: p3dfft_t
  use spectral_transform, only: transform_t
  implicit none
  private
  public :: HAS_P3DFFT, make_external, make_external_full

  logical, parameter :: HAS_P3DFFT = .true.

contains

  !> Makes a transform by P3DFFT; arguments and failures are those of `spectral_p3dfft`. Collective.
  subroutine make_external(transform, world, grid, dealias, wanted_rows, effort, most, failure)
    class(transform_t), allocatable, intent(out) :: transform
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: dealias, wanted_rows, effort, most
    type(failure_t), intent(inout) :: failure
    type(p3dfft_t), allocatable :: made
    allocate (made)
    call made%init(world, grid, dealias, wanted_rows, effort, most, failure)
    call move_alloc(made, transform)
  end subroutine make_external

  !> Makes a transform over the same points as `main`, which is one of this module, that keeps all modes.
  subroutine make_external_full(main, full)
    class(transform_t), intent(in) :: main
    class(transform_t), allocatable, intent(out) :: full
    type(p3dfft_t), allocatable :: made
    select type (main)
    type is (p3dfft_t)
      allocate (made)
      call made%init_full(main)
      call move_alloc(made, full)
    class default
      call require(.false., 'make_external_full: a transform of P3DFFT')
    end select
  end subroutine make_external_full
end module spectral_external

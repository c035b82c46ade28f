! SPDX-License-Identifier: GPL-3.0-or-later
!> Stands in for the transforms of optional libraries when none of them is available.
module spectral_external
  use base_errors, only: failure_t, require
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  use spectral_transform, only: transform_t
  implicit none
  private
  public :: HAS_P3DFFT, make_external, make_external_full

  logical, parameter :: HAS_P3DFFT = .false.

contains

  !> Stops the program. It must not be called; callers check `HAS_P3DFFT`.
  subroutine make_external(transform, world, grid, dealias, wanted_rows, effort, most, failure)
    class(transform_t), allocatable, intent(out) :: transform
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: dealias, wanted_rows, effort, most
    type(failure_t), intent(inout) :: failure
    call require(.false., 'make_external: this program was built without P3DFFT')
    associate (nothing => transform, there => world, to => grid, make => dealias, a => effort, field => wanted_rows, &
               of => failure, that => most)
    end associate
  end subroutine make_external

  !> Stops the program: it must not be called.
  subroutine make_external_full(main, full)
    class(transform_t), intent(in) :: main
    class(transform_t), allocatable, intent(out) :: full
    call require(.false., 'make_external_full: this program was built without P3DFFT')
    associate (nothing => main, there => full)
    end associate
  end subroutine make_external_full
end module spectral_external

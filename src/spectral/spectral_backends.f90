! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the available transforms: `builtin`, and `p3dfft` if it was found when the program was built.
module spectral_backends
  use base_errors, only: failure_t, require
  use base_named_kinds, only: named_kind_t
  use parallel_world, only: world_t
  use spectral_external, only: HAS_P3DFFT, make_external, make_external_full
  use spectral_fftw, only: PLAN_ESTIMATE
  use spectral_grid, only: grid_t
  use spectral_pencil, only: pencil_t
  use spectral_sticks, only: DEALIAS_ELLIPSOID, DEALIAS_NONE
  use spectral_transform, only: transform_t
  implicit none
  private
  public :: make_transform, make_full_transform, transform_choices_t, HAS_P3DFFT, TRANSFORMS, TRANSFORM_BUILTIN, TRANSFORM_P3DFFT

  integer, parameter :: TRANSFORM_BUILTIN = 1, TRANSFORM_P3DFFT = 2
  type(named_kind_t), parameter :: TRANSFORMS(2) = [named_kind_t('builtin', TRANSFORM_BUILTIN), &
                                                    named_kind_t('p3dfft', TRANSFORM_P3DFFT)]

  !> Options of a transform.
  type :: transform_choices_t
    integer :: kind = TRANSFORM_BUILTIN   !< or TRANSFORM_P3DFFT
    integer :: dealias = DEALIAS_ELLIPSOID !< modes that are kept
    integer :: wanted_rows = 0            !< rows of the process grid, 0 for the best
    integer :: effort = PLAN_ESTIMATE     !< of FFTW's planning, or PLAN_MEASURE
  end type transform_choices_t

contains

  !> Makes a transform that takes up to `max_in` fields backward and `max_out` fields forward at once. It fails where P3DFFT
  !> does, see `spectral_p3dfft`; even then there is a transform, which may be freed. Stops the program unless the process grid
  !> exists (`process_grid`). Collective.
  subroutine make_transform(transform, world, grid, choices, max_in, max_out, failure)
    class(transform_t), allocatable, intent(out) :: transform
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    type(transform_choices_t), intent(in) :: choices
    integer, intent(in) :: max_in, max_out
    type(failure_t), intent(inout) :: failure
    select case (choices%kind)
    case (TRANSFORM_BUILTIN)
      call make_builtin(transform, world, grid, choices, max_in, max_out)
    case (TRANSFORM_P3DFFT)
      call make_external(transform, world, grid, choices%dealias, choices%wanted_rows, choices%effort, &
                         max_in + max_out, failure)
    case default
      call require(.false., 'make_transform: TRANSFORM_BUILTIN or TRANSFORM_P3DFFT')
    end select
  end subroutine make_transform

  !> Makes a second transform, of up to seven fields backward and one forward at once, over the same points as `main`, which keeps
  !> all modes. Free it before `main`. Collective.
  subroutine make_full_transform(main, full)
    class(transform_t), intent(in) :: main
    class(transform_t), allocatable, intent(out) :: full
    select type (main)
    type is (pencil_t)
      call make_builtin(full, main%world, main%grid, transform_choices_t(dealias=DEALIAS_NONE, wanted_rows=main%rows), 7, 1)
    class default
      call make_external_full(main, full)
    end select
  end subroutine make_full_transform

  !> Makes the transform that this program brings with it.
  subroutine make_builtin(transform, world, grid, choices, max_in, max_out)
    class(transform_t), allocatable, intent(out) :: transform
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    type(transform_choices_t), intent(in) :: choices
    integer, intent(in) :: max_in, max_out
    type(pencil_t), allocatable :: made
    allocate (made)
    call made%init(world, grid, choices%dealias, choices%wanted_rows, choices%effort, max_in, max_out)
    call move_alloc(made, transform)
  end subroutine make_builtin
end module spectral_backends

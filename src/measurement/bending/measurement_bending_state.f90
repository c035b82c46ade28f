! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the shapes of a wing under its loads, from which solutions begin.
module measurement_bending_state
  use base_errors, only: require
  use base_kinds, only: rp
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: bending_state_t

  !> A state of a problem whose groups of data are the loads.
  type, extends(solver_state_t) :: bending_state_t
    real(rp), allocatable :: shapes(:, :, :) !< (3, n_all, loads) [m]
    logical, allocatable :: is_start(:)      !< (loads) a solution may begin at this shape
  contains
    procedure :: init_shapes => state_init_shapes
    procedure :: begin_at_rest => state_begin_at_rest
    procedure :: take_shapes => state_take_shapes
  end type bending_state_t

contains

  !> Makes room for shapes(3, n_all, n_loads). Solutions begin at the unloaded wing.
  pure subroutine state_init_shapes(self, n_all, n_loads)
    class(bending_state_t), intent(inout) :: self
    integer, intent(in) :: n_all, n_loads
    allocate (self%shapes(3, n_all, n_loads), source=0.0_rp)
    allocate (self%is_start(n_loads), source=.false.)
  end subroutine state_init_shapes

  !> Makes the next solutions begin at the unloaded wing.
  pure subroutine state_begin_at_rest(self)
    class(bending_state_t), intent(inout) :: self
    self%is_start = .false.
  end subroutine state_begin_at_rest

  !> Takes the shapes of `other`, at which the next solutions begin, and nothing else. Stops the program if `other` has no shapes of
  !> a wing.
  subroutine state_take_shapes(self, other)
    class(bending_state_t), intent(inout) :: self
    class(solver_state_t), intent(in) :: other
    select type (other)
    class is (bending_state_t)
      self%shapes = other%shapes
      self%is_start = other%is_start
    class default
      call require(.false., 'bending_state_t: the other state must be one of a wing')
    end select
  end subroutine state_take_shapes
end module measurement_bending_state

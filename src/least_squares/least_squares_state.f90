! SPDX-License-Identifier: GPL-3.0-or-later
!> Represents the state of a solver as a value.
!>
!> A problem may need internal iterations, for instance for an equilibrium. Each of them begins where another one has ended, which
!> decides which of several equilibria it finds. A point is therefore evaluated from a state, and the evaluation gives the state
!> there. Fits hold the state with the point to which it belongs.
module least_squares_state
  use base_errors, only: require
  use base_kinds, only: rp
  implicit none
  private
  public :: solver_point_t, solver_state_t

  !> The state of a solver, which problems extend by their data. A problem without internal iterations needs no data. If residuals
  !> may jump from one point to the next, they belong to groups, each of which can be left out.
  type :: solver_state_t
    logical, allocatable :: jumped(:)      !< (groups) residuals do not follow smoothly from those of the state before
    logical, allocatable :: is_left_out(:) !< (groups) residuals are 0, here and at all points that are evaluated from here
  contains
    procedure :: has_jumped => state_has_jumped
    procedure :: leave_out => state_leave_out
    procedure :: begin_at_rest => state_begin_at_rest
    procedure :: take_shapes => state_take_shapes
  end type solver_state_t

  !> A point, and the state of the solver there.
  type :: solver_point_t
    real(rp), allocatable :: p(:)
    class(solver_state_t), allocatable :: state
  end type solver_point_t

contains

  !> Tells whether any residuals have jumped on the way from the previous state.
  pure logical function state_has_jumped(self) result(has_jumped)
    class(solver_state_t), intent(in) :: self
    has_jumped = .false.
    if (allocated(self%jumped)) has_jumped = any(self%jumped)
  end function state_has_jumped

  !> Leaves out the groups that `jumped`, in addition to those left out before. If none has jumped, or if no group would remain,
  !> nothing changes, and `is_done` is false. A state whose residuals jump has groups.
  subroutine state_leave_out(self, jumped, is_done)
    class(solver_state_t), intent(inout) :: self
    logical, intent(in) :: jumped(:)
    logical, intent(out) :: is_done
    is_done = .false.
    if (.not. any(jumped)) return
    call require(allocated(self%is_left_out), 'solver_state_t: what jumps is a group that can be left out')
    is_done = .not. all(jumped .or. self%is_left_out)
    if (is_done) self%is_left_out = jumped .or. self%is_left_out
  end subroutine state_leave_out

  !> Makes the next solutions begin at rest, because a solver may have followed another equilibrium than the one that it finds from
  !> rest. A state without shapes does not change.
  pure subroutine state_begin_at_rest(self)
    class(solver_state_t), intent(inout) :: self
    associate (unused => self)
    end associate
  end subroutine state_begin_at_rest

  !> Takes the shapes of `other`, from which the next solutions begin, and nothing else of it. A state without shapes does not
  !> change.
  subroutine state_take_shapes(self, other)
    class(solver_state_t), intent(inout) :: self
    class(solver_state_t), intent(in) :: other
    associate (unused => self, nothing => other)
    end associate
  end subroutine state_take_shapes
end module least_squares_state

! SPDX-License-Identifier: GPL-3.0-or-later
!> Represents the state of a solver as a value.
!>
!> A problem may need internal iterations, for instance for the shape of a wing under a load. Each of them begins where the last
!> accepted one has ended, which decides which of several equilibria it finds. A fit therefore holds the state in which it has
!> ended, and a search that continues from there gives this state back to the problem.
module least_squares_state
  implicit none
  private
  public :: solver_state_t

  !> Problems extend it by their data. A problem without internal iterations needs none.
  type :: solver_state_t
  contains
    procedure :: begin_at_rest => state_begin_at_rest
    procedure :: take_shapes => state_take_shapes
  end type solver_state_t

contains

  !> Makes the next solutions begin at rest: a solver may have followed another equilibrium than the one to which rest leads. A
  !> state without shapes does not change.
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

! SPDX-License-Identifier: GPL-3.0-or-later
!> Represents the state of a solver as a value.
!>
!> A problem that is solved by iterations of its own, as the shape of a wing under a load is, begins each of them where the
!> last one that was accepted has ended. Which of several equilibria it finds depends on that. A fit therefore carries the
!> state in which it has ended, and a search that goes on from there gives this state back to the problem.
module least_squares_state
  implicit none
  private
  public :: solver_state_t

  !> Problems extend it by what they need; one without iterations of its own needs nothing.
  type :: solver_state_t
  end type solver_state_t
end module least_squares_state

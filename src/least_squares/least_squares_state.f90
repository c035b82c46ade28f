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
  end type solver_state_t
end module least_squares_state

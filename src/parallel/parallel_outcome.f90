! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds one outcome for all ranks of a program.
module parallel_outcome
  use base_outcome, only: outcome_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: agree_on_outcome

contains

  !> Gives all ranks the worst kind of outcome that any of them has. The reason stays on the rank that knows it. Collective.
  subroutine agree_on_outcome(world, outcome)
    type(world_t), intent(in) :: world
    type(outcome_t), intent(inout) :: outcome
    outcome%kind = world%max_integer(outcome%kind)
    outcome%verdict = world%max_integer(outcome%verdict)
  end subroutine agree_on_outcome
end module parallel_outcome

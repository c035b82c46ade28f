! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines who hears what a training does: the log, or nobody.
module training_listener
  use base_kinds, only: i8, rp
  use training_budget, only: budget_t
  implicit none
  private
  public :: training_listener_t

  type, abstract :: training_listener_t
  contains
    procedure(say), deferred :: say
    procedure(progress), deferred :: progress
    procedure(polish_progress), deferred :: polish_progress
    procedure(interval_progress), deferred :: interval_progress
  end type training_listener_t

  abstract interface
    !> A sentence for the user.
    subroutine say(self, text)
      import :: training_listener_t
      class(training_listener_t), intent(inout) :: self
      character(*), intent(in) :: text
    end subroutine say

    !> How far the search is; what is left to it.
    subroutine progress(self, generation, evaluations, left, best, sigma, condition)
      import :: budget_t, i8, rp, training_listener_t
      class(training_listener_t), intent(inout) :: self
      integer, intent(in) :: generation
      integer(i8), intent(in) :: evaluations
      type(budget_t), intent(in) :: left
      real(rp), intent(in) :: best, sigma, condition
    end subroutine progress

    !> How far least squares is from one of its starts, the first of which began at the wall time `begun` [s]: points
    !> solved, and the lowest chi^2 so far.
    subroutine polish_progress(self, start, n_starts, evaluations, chi2, begun)
      import :: rp, training_listener_t
      class(training_listener_t), intent(inout) :: self
      integer, intent(in) :: start, n_starts !< of so many at most
      integer, intent(in) :: evaluations
      real(rp), intent(in) :: chi2, begun
    end subroutine polish_progress

    !> How far the intervals are: `done` of n are found since the wall time `begun` [s].
    subroutine interval_progress(self, name, done, n, evaluations, begun)
      import :: rp, training_listener_t
      class(training_listener_t), intent(inout) :: self
      character(*), intent(in) :: name     !< of the parameter whose interval is being sought
      integer, intent(in) :: done, n, evaluations
      real(rp), intent(in) :: begun
    end subroutine interval_progress
  end interface
end module training_listener

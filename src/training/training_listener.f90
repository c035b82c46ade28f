! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines who receives the messages of a training: the log, or nobody.
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
    !> Passes a sentence to the user.
    subroutine say(self, text)
      import :: training_listener_t
      class(training_listener_t), intent(inout) :: self
      character(*), intent(in) :: text
    end subroutine say

    !> Reports the progress of the search, and its remaining budget.
    subroutine progress(self, generation, evaluations, left, best, sigma, condition)
      import :: budget_t, i8, rp, training_listener_t
      class(training_listener_t), intent(inout) :: self
      integer, intent(in) :: generation
      integer(i8), intent(in) :: evaluations
      type(budget_t), intent(in) :: left
      real(rp), intent(in) :: best, sigma, condition
    end subroutine progress

    !> Reports the progress of least squares. Fits begin from several starts or moves (`kind` says which), the first at the wall
    !> time `begun` [s]; this is fit number `part`. Reports the points solved so far, and the lowest chi^2 of this fit.
    subroutine polish_progress(self, kind, part, n_parts, evaluations, chi2, begun)
      import :: rp, training_listener_t
      class(training_listener_t), intent(inout) :: self
      character(*), intent(in) :: kind
      integer, intent(in) :: part, n_parts !< number of the present fit, and the largest number of fits
      integer, intent(in) :: evaluations
      real(rp), intent(in) :: chi2, begun
    end subroutine polish_progress

    !> Reports the progress of the intervals: `done` of n are found since the wall time `begun` [s].
    subroutine interval_progress(self, name, done, n, evaluations, begun)
      import :: rp, training_listener_t
      class(training_listener_t), intent(inout) :: self
      character(*), intent(in) :: name     !< of the parameter whose interval is computed
      integer, intent(in) :: done, n, evaluations
      real(rp), intent(in) :: begun
    end subroutine interval_progress
  end interface
end module training_listener

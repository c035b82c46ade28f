! SPDX-License-Identifier: GPL-3.0-or-later
!> A sum of squares to be minimised, as its solvers see it: residuals and their derivatives at a point.
module least_squares_problem
  use base_errors, only: require
  use base_kinds, only: rp
  implicit none
  private
  public :: least_squares_t, unknowns_t

  !> Residuals in units of their standard deviations as functions of the unknowns.
  type, abstract :: least_squares_t
    integer :: n_residuals = 0
  contains
    procedure(evaluate_interface), deferred :: evaluate
    procedure :: accept => least_squares_accept
    procedure :: keep => least_squares_keep
    procedure :: go_back => least_squares_go_back
    procedure :: has_jumped => least_squares_has_jumped
    procedure :: leave_out => least_squares_leave_out
  end type least_squares_t

  abstract interface
    !> residuals(n_residuals) and jacobian(n_residuals, unknowns) at p; `is_valid` false: there are none at p,
    !> and a solver must look elsewhere.
    subroutine evaluate_interface(self, p, residuals, jacobian, is_valid)
      import :: least_squares_t, rp
      class(least_squares_t), intent(inout) :: self
      real(rp), intent(in) :: p(:)
      real(rp), intent(out) :: residuals(:), jacobian(:, :)
      logical, intent(out) :: is_valid
    end subroutine evaluate_interface
  end interface

  !> Where the unknowns may lie, and what was thought of them before: normally distributed about `prior`.
  type :: unknowns_t
    real(rp), allocatable :: lower(:), upper(:) !< bounds
    real(rp), allocatable :: prior(:)
    real(rp), allocatable :: prior_sd(:)        !< 0: nothing was known
    real(rp), allocatable :: unit(:)            !< a usual change, in which steps are measured; 1 for logarithms
    logical, allocatable :: is_fixed(:)
  contains
    procedure :: init => unknowns_init
  end type unknowns_t

contains

  !> The point that was evaluated last is where the solver now stands; a problem may keep it as the start of what
  !> follows.
  subroutine least_squares_accept(self)
    class(least_squares_t), intent(inout) :: self
    self%n_residuals = self%n_residuals
  end subroutine least_squares_accept

  !> The problem keeps where the solver stands in `slot`, 1 to 3, so that it can go back there.
  subroutine least_squares_keep(self, slot)
    class(least_squares_t), intent(inout) :: self
    integer, intent(in) :: slot
    call require(any(slot == [1, 2, 3]) .and. self%n_residuals >= 0, 'least_squares_t: slot 1 to 3')
  end subroutine least_squares_keep

  !> The solver stands again where it stood when `keep` was called with this slot.
  subroutine least_squares_go_back(self, slot)
    class(least_squares_t), intent(inout) :: self
    integer, intent(in) :: slot
    call require(any(slot == [1, 2, 3]) .and. self%n_residuals >= 0, 'least_squares_t: slot 1 to 3')
  end subroutine least_squares_go_back

  !> Whether residuals of the last evaluation are not those to which the ones where the solver stands lead smoothly.
  logical function least_squares_has_jumped(self) result(has_jumped)
    class(least_squares_t), intent(in) :: self
    has_jumped = self%n_residuals < 0
  end function least_squares_has_jumped

  !> From now on the data whose residuals jumped in the last evaluation count no more. Not `is_done` if there are none
  !> or no others.
  subroutine least_squares_leave_out(self, is_done)
    class(least_squares_t), intent(inout) :: self
    logical, intent(out) :: is_done
    is_done = self%n_residuals < 0
  end subroutine least_squares_leave_out

  !> n free unknowns without bounds and priors.
  subroutine unknowns_init(self, n)
    class(unknowns_t), intent(out) :: self
    integer, intent(in) :: n
    allocate (self%lower(n), source=-huge(1.0_rp))
    allocate (self%upper(n), source=huge(1.0_rp))
    allocate (self%prior(n), self%prior_sd(n), source=0.0_rp)
    allocate (self%unit(n), source=1.0_rp)
    allocate (self%is_fixed(n), source=.false.)
  end subroutine unknowns_init
end module least_squares_problem

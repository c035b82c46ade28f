! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines a sum of squares to be minimised as its solvers see it: residuals and their derivatives at a point.
module least_squares_problem
  use base_kinds, only: rp
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: least_squares_t, unknowns_t

  !> Residuals in units of their standard deviations as functions of the unknowns.
  type, abstract :: least_squares_t
    integer :: n_residuals = 0
  contains
    procedure(evaluate_interface), deferred :: evaluate
    procedure :: accept => least_squares_accept
    procedure :: get_state => least_squares_get_state
    procedure :: set_state => least_squares_set_state
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

  !> Says that the point that was evaluated last is where the solver now stands. A problem without iterations of its own has
  !> nothing to remember of it.
  subroutine least_squares_accept(self)
    class(least_squares_t), intent(inout) :: self
    associate (unused => self)
    end associate
  end subroutine least_squares_accept

  !> Returns where the solver stands.
  subroutine least_squares_get_state(self, state)
    class(least_squares_t), intent(in) :: self
    class(solver_state_t), allocatable, intent(out) :: state
    allocate (state)
    associate (unused => self)
    end associate
  end subroutine least_squares_get_state

  !> Puts the solver back to where it stood when this problem gave the state.
  subroutine least_squares_set_state(self, state)
    class(least_squares_t), intent(inout) :: self
    class(solver_state_t), intent(in) :: state
    associate (unused => self, nothing => state)
    end associate
  end subroutine least_squares_set_state

  !> Tells whether residuals of the last evaluation are not those to which the ones where the solver stands lead smoothly.
  logical function least_squares_has_jumped(self) result(has_jumped)
    class(least_squares_t), intent(in) :: self
    has_jumped = .false.
    associate (unused => self)
    end associate
  end function least_squares_has_jumped

  !> Leaves out the data whose residuals jumped in the last evaluation, from now on. `is_done` is false if there are none or no
  !> others.
  subroutine least_squares_leave_out(self, is_done)
    class(least_squares_t), intent(inout) :: self
    logical, intent(out) :: is_done
    is_done = .false.
    associate (unused => self)
    end associate
  end subroutine least_squares_leave_out

  !> Makes n free unknowns without bounds and priors.
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

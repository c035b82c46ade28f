! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the interface of a sum of squares to its solvers: residuals and their derivatives at a point.
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
    !> Computes residuals(n_residuals) and jacobian(n_residuals, unknowns) at p. If `is_valid` is false there are none at p, and a
    !> solver must try another point.
    subroutine evaluate_interface(self, p, residuals, jacobian, is_valid)
      import :: least_squares_t, rp
      class(least_squares_t), intent(inout) :: self
      real(rp), intent(in) :: p(:)
      real(rp), intent(out) :: residuals(:), jacobian(:, :)
      logical, intent(out) :: is_valid
    end subroutine evaluate_interface
  end interface

  !> Bounds of the unknowns, and their priors: normally distributed about `prior`.
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

  !> Is called when the solver has moved to the point that was evaluated last. Problems without internal iterations ignore it.
  subroutine least_squares_accept(self)
    class(least_squares_t), intent(inout) :: self
    associate (unused => self)
    end associate
  end subroutine least_squares_accept

  !> Returns the state of the solver.
  subroutine least_squares_get_state(self, state)
    class(least_squares_t), intent(in) :: self
    class(solver_state_t), allocatable, intent(out) :: state
    allocate (state)
    associate (unused => self)
    end associate
  end subroutine least_squares_get_state

  !> Sets the solver back to the state that this problem gave.
  subroutine least_squares_set_state(self, state)
    class(least_squares_t), intent(inout) :: self
    class(solver_state_t), intent(in) :: state
    associate (unused => self, nothing => state)
    end associate
  end subroutine least_squares_set_state

  !> Tells whether residuals of the last evaluation jumped: whether they do not follow smoothly from those at the solver's point.
  logical function least_squares_has_jumped(self) result(has_jumped)
    class(least_squares_t), intent(in) :: self
    has_jumped = .false.
    associate (unused => self)
    end associate
  end function least_squares_has_jumped

  !> Leaves out, from now on, the data whose residuals jumped in the last evaluation. `is_done` is false if there are none or no
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

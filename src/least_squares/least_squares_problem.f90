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
  end type least_squares_t

  abstract interface
    !> Computes residuals(n_residuals) and jacobian(n_residuals, unknowns) at p. Internal iterations begin at the state `from`, and
    !> `to` is the state where they end. If `is_valid` is false there are no residuals at p: a solver must try another point, and
    !> `to` tells at most what has jumped.
    subroutine evaluate_interface(self, p, from, residuals, jacobian, is_valid, to)
      import :: least_squares_t, solver_state_t, rp
      class(least_squares_t), intent(inout) :: self
      real(rp), intent(in) :: p(:)
      class(solver_state_t), intent(in) :: from
      real(rp), intent(out) :: residuals(:), jacobian(:, :)
      logical, intent(out) :: is_valid
      class(solver_state_t), allocatable, intent(out) :: to
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

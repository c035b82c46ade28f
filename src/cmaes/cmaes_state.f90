! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the state of a CMA-ES run, which a checkpoint stores, and the work space of a generation.
module cmaes_state
  use base_kinds, only: rp, i8
  use base_lapack, only: symmetric_eigen_work
  use base_visitor, only: visited_t, visitor_t
  use cmaes_params, only: cmaes_params_t
  implicit none
  private
  public :: cmaes_state_t, cmaes_work_t, WINDOW

  integer, parameter :: WINDOW = 20 !< generations at both ends of the history that stagnation compares

  !> Counts since the beginning of the run.
  type, extends(visited_t) :: cmaes_counts_t
    integer(i8) :: evaluations = 0              !< reported to the search so far, failed ones included
    integer(i8) :: n_infeasible = 0, n_failed = 0
    integer :: n_repairs = 0                    !< decompositions that failed and were replaced by an older one
    integer :: n_floored = 0                    !< decompositions with eigenvalues raised to the floor
    integer :: n_redone = 0                     !< generations repeated with half the step
  contains
    procedure :: visit => counts_visit
  end type cmaes_counts_t

  !> The best feasible candidate so far.
  type, extends(visited_t) :: cmaes_best_t
    logical :: is_seen = .false.                !< a feasible candidate exists
    real(rp) :: f = huge(1.0_rp)
    real(rp), allocatable :: x(:)               !< as it was evaluated, inside the box
    integer(i8) :: evaluation = 0               !< its number, from 1
  contains
    procedure :: visit => best_visit
  end type cmaes_best_t

  !> The course of f, from which the tests of `cmaes_stop` see that a run stagnates.
  type, extends(visited_t) :: cmaes_history_t
    integer :: n = 0                            !< generations stored in the ring buffers
    real(rp), allocatable :: best(:), median(:) !< ring buffers of f of generations; huge where nothing was feasible
    integer :: n_flat = 0                       !< successive generations with equal parents
    real(rp) :: f_scale = -1                    !< unit of the tolerances of f; negative: not known yet
  contains
    procedure :: visit => history_visit
  end type cmaes_history_t

  !> Weights of the penalty for leaving the box, see `cmaes_penalty`.
  type, extends(visited_t) :: cmaes_box_penalty_t
    logical :: is_on = .false.
    real(rp), allocatable :: weights(:)         !< by coordinate; 0 until the penalty begins
    integer :: n = 0                            !< generations put into the ring
    real(rp), allocatable :: spreads(:)         !< ring of interquartile ranges of f, over the sample's variance
  contains
    procedure :: visit => penalty_visit
  end type cmaes_box_penalty_t

  !> The state after generation `generation`. B and d describe C at its last decomposition: C = B diag(d)^2 B^T.
  type, extends(visited_t) :: cmaes_state_t
    ! The normal distribution from which candidates are drawn.
    real(rp), allocatable :: mean(:)            !< m
    real(rp) :: sigma = 0                       !< step size
    real(rp), allocatable :: p_sigma(:), p_c(:) !< evolution paths
    real(rp), allocatable :: c(:, :)            !< covariance matrix over sigma^2
    real(rp), allocatable :: b(:, :), d(:)      !< eigenvectors, square roots of the eigenvalues in ascending order
    real(rp) :: condition = 1                   !< of C, at its last decomposition
    integer :: last_eigen = 0                   !< generation of the last decomposition
    ! Where the run is.
    integer(i8) :: seed = 0                     !< key of the random numbers
    integer :: restart = 0                      !< number of the run in the search, from 0
    integer :: generation = 0                   !< finished generations
    integer :: attempt = 0                      !< number of repetitions of the present generation so far
    integer :: stop_code = 0                    !< of `cmaes_stop`; 0: the run goes on
    type(cmaes_counts_t) :: counts
    type(cmaes_best_t) :: best
    type(cmaes_history_t) :: history
    type(cmaes_box_penalty_t) :: penalty
  contains
    procedure :: reset => state_reset
    procedure :: visit => state_visit
  end type cmaes_state_t

  !> Work space, undefined between two generations except for the two roots, which follow from B and d.
  type :: cmaes_work_t
    real(rp), allocatable :: root(:, :), inverse_root(:, :) !< B diag(d) B^T, B diag(1/d) B^T
    real(rp), allocatable :: x(:, :)   !< n x lambda candidates as drawn
    real(rp), allocatable :: y(:, :)   !< (x - m)/sigma, best first, with room for the path
    real(rp), allocatable :: z(:), step(:), old_mean(:)
    real(rp), allocatable :: matrix(:, :), eigenvalues(:), lapack(:)
    real(rp), allocatable :: keys(:), distances(:)
    real(rp), allocatable :: weights(:) !< of this generation, for its valid candidates and the path
    integer, allocatable :: classes(:), order(:), merged(:)
    integer(i8), allocatable :: bits(:)
    real(rp) :: window(WINDOW) = 0
    real(rp), allocatable :: sorted(:) !< copy of a ring buffer, for its median
  contains
    procedure :: allocate => work_allocate
  end type cmaes_work_t

contains

  !> Makes the state before the first generation, at `mean` with C = 1. Allocates.
  subroutine state_reset(self, params, mean, seed, restart)
    class(cmaes_state_t), intent(out) :: self
    type(cmaes_params_t), intent(in) :: params
    real(rp), intent(in) :: mean(:)
    integer(i8), intent(in) :: seed
    integer, intent(in) :: restart
    integer :: n, i, longest
    n = params%n
    longest = max(params%tolstagnation + WINDOW, params%n_recent)
    allocate (self%mean(n), self%p_sigma(n), self%p_c(n), self%c(n, n), self%b(n, n), self%d(n), self%best%x(n), &
              self%penalty%weights(n))
    allocate (self%history%best(longest), self%history%median(longest), &
              self%penalty%spreads(20 + ceiling(3*real(n, rp)/params%lambda)))
    self%mean = mean
    self%best%x = mean
    self%p_sigma = 0
    self%p_c = 0
    self%c = 0
    do i = 1, n
      self%c(i, i) = 1
    end do
    self%b = self%c
    self%d = 1
    self%penalty%weights = 0
    self%history%best = huge(1.0_rp)
    self%history%median = huge(1.0_rp)
    self%penalty%spreads = 0
    self%sigma = params%sigma0
    self%seed = seed
    self%restart = restart
  end subroutine state_reset

  !> Shows every component to the visitor; the state must have been reset with the same parameters.
  subroutine state_visit(self, visitor)
    class(cmaes_state_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('mean', self%mean)
    call visitor%visit('p_sigma', self%p_sigma)
    call visitor%visit('p_c', self%p_c)
    call visitor%visit('C', self%c)
    call visitor%visit('B', self%b)
    call visitor%visit('d', self%d)
    call visitor%visit('sigma', self%sigma)
    call visitor%visit('condition', self%condition)
    call visitor%visit('seed', self%seed)
    call visitor%visit('restart', self%restart)
    call visitor%visit('generation', self%generation)
    call visitor%visit('attempt', self%attempt)
    call visitor%visit('last_eigen', self%last_eigen)
    call visitor%visit('stop_code', self%stop_code)
    ! In a checkpoint all names are at the same level.
    call self%counts%visit(visitor)
    call self%best%visit(visitor)
    call self%history%visit(visitor)
    call self%penalty%visit(visitor)
  end subroutine state_visit

  !> Shows every component to the visitor.
  subroutine counts_visit(self, visitor)
    class(cmaes_counts_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('n_repairs', self%n_repairs)
    call visitor%visit('n_floored', self%n_floored)
    call visitor%visit('n_redone', self%n_redone)
    call visitor%visit('evaluations', self%evaluations)
    call visitor%visit('n_infeasible', self%n_infeasible)
    call visitor%visit('n_failed', self%n_failed)
  end subroutine counts_visit

  !> Shows every component to the visitor; `x` has its size.
  subroutine best_visit(self, visitor)
    class(cmaes_best_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('has_best', self%is_seen)
    call visitor%visit('best_f', self%f)
    call visitor%visit('best_x', self%x)
    call visitor%visit('best_evaluation', self%evaluation)
  end subroutine best_visit

  !> Shows every component to the visitor; the ring buffers have their size.
  subroutine history_visit(self, visitor)
    class(cmaes_history_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('n_flat', self%n_flat)
    call visitor%visit('f_scale', self%f_scale)
    call visitor%visit('n_history', self%n)
    call visitor%visit('best_history', self%best)
    call visitor%visit('median_history', self%median)
  end subroutine history_visit

  !> Shows every component to the visitor; the arrays have their size.
  subroutine penalty_visit(self, visitor)
    class(cmaes_box_penalty_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('penalty_weights', self%weights)
    call visitor%visit('has_penalty', self%is_on)
    call visitor%visit('n_spread', self%n)
    call visitor%visit('spreads', self%spreads)
  end subroutine penalty_visit

  !> Allocates the work space of generations with these parameters.
  subroutine work_allocate(self, params)
    class(cmaes_work_t), intent(out) :: self
    type(cmaes_params_t), intent(in) :: params
    integer :: n, lambda
    n = params%n
    lambda = params%lambda
    allocate (self%root(n, n), self%inverse_root(n, n), self%x(n, lambda), self%y(n, lambda + 1), self%z(n), &
              self%step(n), self%old_mean(n), self%matrix(n, n), self%eigenvalues(n), self%lapack(symmetric_eigen_work(n)))
    allocate (self%keys(lambda), self%distances(lambda), self%weights(lambda + 1), self%classes(lambda), &
              self%order(lambda), self%merged(lambda), self%bits(lambda))
    allocate (self%sorted(20 + ceiling(3*real(n, rp)/lambda)))
    self%x = 0
  end subroutine work_allocate
end module cmaes_state

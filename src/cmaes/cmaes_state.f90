! SPDX-License-Identifier: GPL-3.0-or-later
!> State of a CMA-ES run, which is what a checkpoint needs, and the work space of a generation.
module cmaes_state
  use base_kinds, only: rp, i8
  use base_lapack, only: symmetric_eigen_work
  use cmaes_archive, only: archive_t
  use cmaes_params, only: cmaes_params_t
  implicit none
  private
  public :: cmaes_state_t, cmaes_work_t, WINDOW

  integer, parameter :: WINDOW = 20 !< generations at both ends of the history that stagnation compares

  !> After generation `generation`. B and d describe C at its last decomposition: C = B diag(d)^2 B^T.
  type :: cmaes_state_t
    real(rp), allocatable :: mean(:)            !< m
    real(rp), allocatable :: p_sigma(:), p_c(:) !< evolution paths
    real(rp), allocatable :: c(:, :)            !< covariance matrix over sigma^2
    real(rp), allocatable :: b(:, :), d(:)      !< eigenvectors, roots of the eigenvalues in rising order
    real(rp) :: sigma = 0                       !< step size
    real(rp) :: condition = 1                   !< of C, at its last decomposition
    integer(i8) :: seed = 0                     !< key of the random numbers
    integer :: restart = 0                      !< number of the run in the search, from 0
    integer :: generation = 0                   !< finished generations
    integer :: attempt = 0                      !< how often the present generation is being repeated
    integer :: last_eigen = 0                   !< generation of the last decomposition
    integer :: n_repairs = 0                    !< decompositions that failed and were replaced by an older one
    integer :: n_floored = 0                    !< decompositions with eigenvalues raised to the floor
    integer :: n_redone = 0                     !< generations repeated with half the step
    integer :: n_flat = 0                       !< successive generations with equal parents
    integer :: stop_code = 0                    !< of `cmaes_stop`; 0: the run goes on
    integer(i8) :: evaluations = 0              !< told so far, failed ones included
    integer(i8) :: n_infeasible = 0, n_failed = 0
    real(rp) :: f_scale = -1                    !< unit of the tolerances of f; negative: not known yet
    logical :: has_best = .false.               !< a feasible candidate was seen
    real(rp) :: best_f = huge(1.0_rp)
    real(rp), allocatable :: best_x(:)          !< as it was evaluated, inside the box
    integer(i8) :: best_evaluation = 0          !< its number, from 1
    integer :: n_history = 0                    !< generations put into the histories
    real(rp), allocatable :: best_history(:), median_history(:) !< rings; huge where nothing was feasible
    real(rp), allocatable :: penalty_weights(:) !< of leaving the box, by coordinate; 0 until it matters
    logical :: has_penalty = .false.
    integer :: n_spread = 0                     !< generations put into the ring of spreads
    real(rp), allocatable :: spreads(:)         !< ring of interquartile ranges of f, over the sample's variance
  contains
    procedure :: reset => state_reset
    procedure :: visit => state_visit
  end type cmaes_state_t

  !> Contents undefined between two generations, except the two roots, which follow from B and d.
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
    real(rp), allocatable :: sorted(:) !< a ring to take the median of
  contains
    procedure :: allocate => work_allocate
  end type cmaes_work_t

contains

  !> The state before the first generation, at `mean` with C = 1.
  subroutine state_reset(self, params, mean, seed, restart)
    class(cmaes_state_t), intent(out) :: self
    type(cmaes_params_t), intent(in) :: params
    real(rp), intent(in) :: mean(:)
    integer(i8), intent(in) :: seed
    integer, intent(in) :: restart
    integer :: n, i, longest
    n = params%n
    longest = max(params%tolstagnation + WINDOW, params%n_recent)
    allocate (self%mean(n), self%p_sigma(n), self%p_c(n), self%c(n, n), self%b(n, n), self%d(n), self%best_x(n), &
              self%penalty_weights(n))
    allocate (self%best_history(longest), self%median_history(longest), &
              self%spreads(20 + ceiling(3*real(n, rp)/params%lambda)))
    self%mean = mean
    self%best_x = mean
    self%p_sigma = 0
    self%p_c = 0
    self%c = 0
    do i = 1, n
      self%c(i, i) = 1
    end do
    self%b = self%c
    self%d = 1
    self%penalty_weights = 0
    self%best_history = huge(1.0_rp)
    self%median_history = huge(1.0_rp)
    self%spreads = 0
    self%sigma = params%sigma0
    self%seed = seed
    self%restart = restart
  end subroutine state_reset

  !> Stores or restores every component; the state has been reset with the same parameters.
  subroutine state_visit(self, archive)
    class(cmaes_state_t), intent(inout) :: self
    type(archive_t), intent(inout) :: archive
    call archive%visit_reals('mean', self%mean)
    call archive%visit_reals('p_sigma', self%p_sigma)
    call archive%visit_reals('p_c', self%p_c)
    call archive%visit_matrix('C', self%c)
    call archive%visit_matrix('B', self%b)
    call archive%visit_reals('d', self%d)
    call archive%visit_real('sigma', self%sigma)
    call archive%visit_real('condition', self%condition)
    call archive%visit_integer('seed', self%seed)
    call archive%visit_default_integer('restart', self%restart)
    call archive%visit_default_integer('generation', self%generation)
    call archive%visit_default_integer('attempt', self%attempt)
    call archive%visit_default_integer('last_eigen', self%last_eigen)
    call archive%visit_default_integer('n_repairs', self%n_repairs)
    call archive%visit_default_integer('n_floored', self%n_floored)
    call archive%visit_default_integer('n_redone', self%n_redone)
    call archive%visit_default_integer('n_flat', self%n_flat)
    call archive%visit_default_integer('stop_code', self%stop_code)
    call archive%visit_integer('evaluations', self%evaluations)
    call archive%visit_integer('n_infeasible', self%n_infeasible)
    call archive%visit_integer('n_failed', self%n_failed)
    call archive%visit_real('f_scale', self%f_scale)
    call visit_logical(archive, 'has_best', self%has_best)
    call archive%visit_real('best_f', self%best_f)
    call archive%visit_reals('best_x', self%best_x)
    call archive%visit_integer('best_evaluation', self%best_evaluation)
    call archive%visit_default_integer('n_history', self%n_history)
    call archive%visit_reals('best_history', self%best_history)
    call archive%visit_reals('median_history', self%median_history)
    call archive%visit_reals('penalty_weights', self%penalty_weights)
    call visit_logical(archive, 'has_penalty', self%has_penalty)
    call archive%visit_default_integer('n_spread', self%n_spread)
    call archive%visit_reals('spreads', self%spreads)
  end subroutine state_visit

  subroutine visit_logical(archive, name, flag)
    type(archive_t), intent(inout) :: archive
    character(*), intent(in) :: name
    logical, intent(inout) :: flag
    integer :: value
    value = merge(1, 0, flag)
    call archive%visit_default_integer(name, value)
    flag = value /= 0
  end subroutine visit_logical

  !> Allocates what generations with these parameters need.
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

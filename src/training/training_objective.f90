! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the costs of a generation of candidates, as tasks (candidate, load) for the pool, longest first.
!>
!> Candidates are solved warm from the solution of the optimiser's mean under the same load. The mean is solved first, itself warm
!> from the mean before. The search keeps these solutions. The cost of a candidate therefore depends on the sequence of means alone,
!> not on the rank that computes it.
module training_objective
  use base_kinds, only: i8, rp
  use base_sort, only: sorting_order
  use base_visitor, only: visited_t, visitor_t
  use measurement_bending_pool, only: bending_batch_t, bending_pool_t
  use measurement_bending_state, only: bending_state_t
  use measurement_bending_task, only: bending_task_t, take_columns, take_facts, task_input, COST_CHI2, COST_MEAN_SQUARE, &
                                      FACT_FACTORISATIONS, FACT_REDONE, FACT_VIOLATION, N_FACTS, TASK_COSTS, TASK_EVALUATE
  use measurement_evaluation, only: evaluation_t
  use measurement_experiment, only: experiment_t
  implicit none
  private
  public :: train_objective_t, candidate_costs_t, full_results

  !> Results for lambda candidates.
  type :: candidate_costs_t
    real(rp), allocatable :: f(:)           !< h [m] or chi^2, if feasible
    real(rp), allocatable :: violation(:)   !< > 0: infeasible, by so much
    logical, allocatable :: has_failed(:)   !< a shape was not found
  end type candidate_costs_t

  !> Static solutions so far.
  type, extends(visited_t) :: solution_counts_t
    integer(i8) :: n_warm = 0           !< from the shape of the mean
    integer(i8) :: n_cold = 0           !< from the unloaded wing
    integer(i8) :: n_redone = 0         !< repeated from the unloaded wing
    integer(i8) :: n_unsolved = 0
    integer(i8) :: n_factorisations = 0 !< of all
  contains
    procedure :: visit => counts_visit
  end type solution_counts_t

  type :: train_objective_t
    type(experiment_t), pointer :: experiment => null()
    type(bending_pool_t), pointer :: pool => null()
    logical :: use_chi2 = .false.
    type(solution_counts_t) :: counts
    real(rp), allocatable, private :: expected(:) !< (loads) relative durations of the tasks
  contains
    procedure :: init => objective_init
    procedure :: rest => objective_rest
    procedure :: solve_mean => objective_solve_mean
    procedure :: evaluate => objective_evaluate
  end type train_objective_t

contains

  !> Shows every component to the visitor.
  subroutine counts_visit(self, visitor)
    class(solution_counts_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('warm', self%n_warm)
    call visitor%visit('cold', self%n_cold)
    call visitor%visit('redone', self%n_redone)
    call visitor%visit('unsolved', self%n_unsolved)
    call visitor%visit('factorisations', self%n_factorisations)
  end subroutine counts_visit

  !> Takes experiment and pool, which must live as long as the objective.
  subroutine objective_init(self, experiment, pool, use_chi2)
    class(train_objective_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: experiment
    type(bending_pool_t), intent(in), target :: pool
    logical, intent(in) :: use_chi2
    self%experiment => experiment
    self%pool => pool
    self%use_chi2 = use_chi2
    allocate (self%expected(size(experiment%loads)), source=1.0_rp)
  end subroutine objective_init

  !> Returns the state from which solutions begin at the unloaded wing.
  function objective_rest(self) result(state)
    class(train_objective_t), intent(in) :: self
    type(bending_state_t) :: state
    call state%init_shapes(self%experiment%model%n_all, size(self%expected))
  end function objective_rest

  !> Solves all loads at the mean, from the solutions `from` of the mean before, and returns them in `to`. A load without a solution
  !> has that of `from`. If the pool is stopped afterwards `to` is `from`, and nothing has changed.
  subroutine objective_solve_mean(self, coordinates, from, to)
    class(train_objective_t), intent(inout) :: self
    real(rp), intent(in) :: coordinates(:)
    type(bending_state_t), intent(in) :: from
    type(bending_state_t), intent(out) :: to
    type(evaluation_t), allocatable :: evaluations(:)
    real(rp), allocatable :: shapes(:, :, :)
    integer :: l
    to = from
    call full_results(self%experiment, self%pool, coordinates, from%is_start, from%shapes, evaluations, shapes)
    if (self%pool%is_stopped) return
    do l = 1, size(evaluations)
      to%is_start(l) = evaluations(l)%is_start
      if (to%is_start(l)) to%shapes(:, :, l) = shapes(:, :, l)
      self%counts%n_factorisations = self%counts%n_factorisations + evaluations(l)%factorisations
    end do
  end subroutine objective_solve_mean

  !> Returns the costs of the candidates coordinates(n, lambda), solved from the solutions `from` of the mean. If the pool is
  !> stopped afterwards they are not complete.
  subroutine objective_evaluate(self, coordinates, from, costs)
    class(train_objective_t), intent(inout) :: self
    real(rp), intent(in) :: coordinates(:, :)
    type(bending_state_t), intent(in) :: from
    type(candidate_costs_t), intent(out) :: costs
    type(bending_batch_t) :: batch
    integer :: k, l, n_loads, lambda, task
    lambda = size(coordinates, 2)
    n_loads = size(self%expected)
    call self%pool%make_batch(lambda*n_loads, TASK_COSTS, 0, batch)
    do k = 1, lambda
      do l = 1, n_loads
        batch%inputs(:, (k - 1)*n_loads + l) = task_input(bending_task_t(TASK_COSTS, l, from%is_start(l)), coordinates(:, k), &
                                                          [integer ::])
      end do
    end do
    batch%starts = reshape(from%shapes, [size(from%shapes)])
    batch%order = longest_first(self, coordinates)
    call self%pool%run(batch)
    allocate (costs%f(lambda), costs%violation(lambda), source=0.0_rp)
    allocate (costs%has_failed(lambda), source=.false.)
    if (self%pool%is_stopped) return
    do k = 1, lambda
      do l = 1, n_loads
        task = (k - 1)*n_loads + l
        if (batch%statuses(task) /= 0) then
          costs%has_failed(k) = .true.
          self%counts%n_unsolved = self%counts%n_unsolved + 1
        end if
        costs%violation(k) = costs%violation(k) + sum(batch%outputs(FACT_VIOLATION:FACT_VIOLATION + 1, task))
        costs%f(k) = costs%f(k) + batch%outputs(merge(COST_CHI2, COST_MEAN_SQUARE, self%use_chi2), task)
        self%counts%n_factorisations = self%counts%n_factorisations + nint(batch%outputs(FACT_FACTORISATIONS, task))
        self%counts%n_redone = self%counts%n_redone + nint(batch%outputs(FACT_REDONE, task))
      end do
    end do
    if (.not. self%use_chi2) costs%f = sqrt(costs%f)
    self%counts%n_warm = self%counts%n_warm + lambda*count(from%is_start)
    self%counts%n_cold = self%counts%n_cold + lambda*count(.not. from%is_start)
    do l = 1, n_loads
      self%expected(l) = sum(batch%seconds(l::n_loads))
    end do
  end subroutine objective_evaluate

  !> Orders tasks by their expected duration: that of their load in the generation before, times one plus the distance of the
  !> candidate from the middle of all, over the mean distance. Only the order depends on the clock.
  function longest_first(self, coordinates) result(order)
    type(train_objective_t), intent(in) :: self
    real(rp), intent(in) :: coordinates(:, :)
    integer, allocatable :: order(:)
    real(rp) :: middle(size(coordinates, 1)), distance(size(coordinates, 2)), mean_distance
    integer(i8) :: keys(size(coordinates, 2)*size(self%expected))
    integer :: k, l
    middle = sum(coordinates, 2)/size(coordinates, 2)
    do k = 1, size(coordinates, 2)
      distance(k) = norm2(coordinates(:, k) - middle)
    end do
    mean_distance = max(sum(distance)/size(distance), tiny(1.0_rp))
    do k = 1, size(coordinates, 2)
      do l = 1, size(self%expected)
        keys((k - 1)*size(self%expected) + l) = -nint(1.0e9_rp*self%expected(l)/sum(self%expected)* &
                                                      (1 + distance(k)/mean_distance), i8)
      end do
    end do
    order = sorting_order(keys)
  end function longest_first

  !> Solves all loads at one point with derivatives and shapes(3, n_all, loads) [m], warm from `starts` where `is_start`. Loads
  !> that are left out are not solved; their shapes are `starts`. If the pool is stopped afterwards the results are not complete,
  !> and not solved. On rank 0.
  subroutine full_results(experiment, pool, coordinates, is_start, starts, evaluations, shapes, &
                          is_left_out)
    type(experiment_t), intent(in) :: experiment
    type(bending_pool_t), intent(inout) :: pool
    real(rp), intent(in) :: coordinates(:), starts(:, :, :)
    logical, intent(in) :: is_start(:)
    logical, intent(in), optional :: is_left_out(:)
    type(evaluation_t), allocatable, intent(out) :: evaluations(:)
    real(rp), allocatable, intent(out) :: shapes(:, :, :)
    type(bending_batch_t) :: batch
    integer, allocatable :: loads(:), all_columns(:)
    integer :: k, l, at, n, n_loads
    n_loads = size(is_start)
    loads = [(l, l=1, n_loads)]
    if (present(is_left_out)) loads = pack(loads,.not. is_left_out)
    all_columns = [(k, k=1, size(coordinates))]
    call pool%make_batch(size(loads), TASK_EVALUATE, size(all_columns), batch)
    allocate (evaluations(n_loads))
    shapes = starts
    do l = 1, n_loads
      call evaluations(l)%init(experiment, l, .true.)
    end do
    do k = 1, size(loads)
      batch%inputs(:, k) = task_input(bending_task_t(TASK_EVALUATE, loads(k), is_start(loads(k))), coordinates, all_columns)
    end do
    batch%starts = reshape(starts, [size(starts)])
    call pool%run(batch)
    n = size(shapes, 1)*size(shapes, 2)
    do k = 1, size(loads)
      l = loads(k)
      associate (one => evaluations(l), output => batch%outputs(:, k))
        call take_facts(output, one)
        one%is_solved = one%is_solved .and. batch%statuses(k) == 0
        at = N_FACTS + size(one%residuals)
        one%residuals = output(N_FACTS + 1:at)
        call take_columns(all_columns, size(coordinates), output, at, one%jacobian)
        shapes(:, :, l) = reshape(output(at + 1:at + n), shape(shapes(:, :, l)))
      end associate
    end do
  end subroutine full_results
end module training_objective

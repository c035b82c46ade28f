! SPDX-License-Identifier: GPL-3.0-or-later
!> Does the tasks of trainings and diagnoses (measurement_bending_task) on any rank. The result depends on the task and on what rank
!> 0 has broadcast, never on earlier work of the rank.
module measurement_bending_runner
  use base_errors, only: require
  use base_kinds, only: rp
  use base_signals, only: signal_caught
  use io_stop, only: stop_rules_t
  use measurement_bending_task, only: bending_task_t, input_size, put_facts, task_of, COST_CHI2, COST_MEAN_SQUARE, N_FACTS, &
                                      N_HEAD, NOT_SOLVED, TASK_COSTS, TASK_DIRECTIONS, TASK_EVALUATE
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_observed_wing, only: observed_wing_t
  use measurement_simulation, only: N_NUISANCES
  use parallel_farm, only: task_runner_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: bending_runner_t

  !> Does the tasks. The context that rank 0 broadcasts is empty or holds the shapes (3, n_all, loads) at which warm solutions
  !> begin.
  type, extends(task_runner_t) :: bending_runner_t
    class(observed_wing_t), allocatable :: wing
    type(stop_rules_t) :: stop_rules
    logical :: has_stop_rules = .false.
    type(evaluation_work_t), private :: work
    real(rp), allocatable, private :: u(:, :) !< (3, n_all) [m] the shape of the last task
  contains
    procedure :: init => runner_init
    procedure :: free => runner_free
    procedure :: input_size => runner_input_size
    procedure :: output_size => runner_output_size
    procedure :: most_output => runner_most_output
    procedure :: run_task => runner_run_task
    procedure :: wants_stop => runner_wants_stop
    procedure :: meet => runner_meet
  end type bending_runner_t

contains

  !> Takes over `wing`, whose actual argument is not allocated afterwards.
  subroutine runner_init(self, wing)
    class(bending_runner_t), intent(inout) :: self
    class(observed_wing_t), allocatable, intent(inout) :: wing
    call self%free()
    call move_alloc(wing, self%wing)
    allocate (self%u(3, self%wing%experiment%model%n_all), source=0.0_rp)
    if (.not. allocated(self%context)) allocate (self%context(0))
  end subroutine runner_init

  !> Releases everything.
  subroutine runner_free(self)
    class(bending_runner_t), intent(inout) :: self
    call self%work%free()
    if (allocated(self%u)) deallocate (self%u)
    if (.not. allocated(self%wing)) return
    call self%wing%free()
    deallocate (self%wing)
  end subroutine runner_free

  !> Returns how many numbers an input has.
  pure integer function runner_input_size(self) result(n)
    class(bending_runner_t), intent(in) :: self
    n = input_size(self%wing%n_coordinates)
  end function runner_input_size

  !> Returns the largest number of values in the output of any task.
  pure integer function runner_most_output(self) result(n)
    class(bending_runner_t), intent(in) :: self
    integer :: kind
    n = maxval([(self%output_size(kind, self%wing%n_coordinates), kind=TASK_EVALUATE, TASK_COSTS)])
  end function runner_most_output

  !> Returns the largest number of values in the output of a task of this kind, with derivatives with respect to n_columns
  !> coordinates.
  pure integer function runner_output_size(self, kind, n_columns) result(n)
    class(bending_runner_t), intent(in) :: self
    integer, intent(in) :: kind, n_columns
    integer :: most, l
    most = 0
    do l = 1, size(self%wing%experiment%loads)
      most = max(most, self%wing%count_rows(l))
    end do
    select case (kind)
    case (TASK_COSTS)
      n = COST_CHI2 - N_FACTS
    case (TASK_EVALUATE)
      n = most*(1 + n_columns) + size(self%u)
    case (TASK_DIRECTIONS)
      n = most*(N_NUISANCES + n_columns + self%wing%patterns%count())
    case default ! TASK_NUISANCES
      n = most*(N_NUISANCES + n_columns)
    end select
    n = n + N_FACTS
  end function runner_output_size

  !> Does a task: see measurement_bending_task. The status is NOT_SOLVED if no shape was found. If the shape lies in an excluded
  !> zone, there are no directions: the caller would discard them.
  subroutine runner_run_task(self, input, output, status)
    class(bending_runner_t), intent(inout) :: self
    real(rp), intent(in) :: input(:)
    real(rp), intent(inout) :: output(:)
    integer, intent(out) :: status
    type(evaluation_t) :: evaluation
    type(bending_task_t) :: task
    real(rp), allocatable :: coordinates(:)
    logical :: is_other
    integer :: n
    task = task_of(input)
    n = self%wing%n_coordinates
    associate (l => task%load, is_wanted => input(N_HEAD + n + 1:) > 0.5_rp)
      call self%wing%take(input(N_HEAD + 1:N_HEAD + n), coordinates, is_other)
      if (is_other) call self%work%init(self%wing%experiment)
      call evaluation%init(self%wing%experiment, l, .false.)
      call solve(self, task, coordinates, evaluation)
      call put_facts(evaluation, output)
      status = merge(0, NOT_SOLVED, evaluation%is_solved)
      if (status /= 0) return
      select case (task%kind)
      case (TASK_COSTS)
        output(COST_MEAN_SQUARE:COST_CHI2) = evaluation%terms(self%wing%experiment, l)
      case (TASK_EVALUATE)
        call give_evaluation(self, is_wanted, l, evaluation%residuals, output(N_FACTS + 1:))
      case default
        if (evaluation%is_feasible()) &
          call give_directions(self, is_wanted, task%kind == TASK_DIRECTIONS, l, output(N_FACTS + 1:))
      end select
    end associate
  end subroutine runner_run_task

  !> Solves the load of the task, from the unloaded wing or from its shape in the context, and compares the result with the
  !> measurement: see `evaluate`.
  subroutine solve(self, task, coordinates, evaluation)
    class(bending_runner_t), intent(inout) :: self
    type(bending_task_t), intent(in) :: task
    real(rp), intent(in) :: coordinates(:)
    type(evaluation_t), intent(inout) :: evaluation
    integer :: n
    n = size(self%u)
    self%u = 0
    if (task%is_warm) then
      call require(size(self%context) == n*size(self%wing%experiment%loads), 'bending_runner_t: starts of warm solutions')
      self%u = reshape(self%context((task%load - 1)*n + 1:task%load*n), shape(self%u))
    end if
    call evaluate(self%wing%experiment, self%work, coordinates, task%load, task%is_warm, self%u, evaluation, task%load_offset)
  end subroutine solve

  !> Puts the residuals of load l into `output`, then the wanted tangents, then the displacements.
  subroutine give_evaluation(self, is_wanted, l, residuals, output)
    class(bending_runner_t), intent(inout) :: self
    logical, intent(in) :: is_wanted(:)
    integer, intent(in) :: l
    real(rp), intent(in) :: residuals(:)
    real(rp), intent(inout) :: output(:)
    integer :: at
    at = self%wing%count_rows(l)
    call self%wing%average(l, residuals, output(:at))
    call give_tangents(self, is_wanted, l, output, at)
    output(at + 1:at + size(self%u)) = reshape(self%u, [size(self%u)])
  end subroutine give_evaluation

  !> Puts the tangents of load l into `output`: first those of nuisances, then those of the wanted coordinates, then, with
  !> `has_patterns`, those of patterns.
  subroutine give_directions(self, is_wanted, has_patterns, l, output)
    class(bending_runner_t), intent(inout) :: self
    logical, intent(in) :: is_wanted(:), has_patterns
    integer, intent(in) :: l
    real(rp), intent(inout) :: output(:)
    real(rp) :: columns(self%wing%experiment%comparisons(l)%n, N_NUISANCES), sd(N_NUISANCES)
    integer :: i, b, at
    b = self%wing%count_rows(l)
    call self%work%nuisance_tangents(self%wing%experiment, l, columns, sd)
    at = 0
    do i = 1, N_NUISANCES
      call self%wing%average(l, sd(i)*columns(:, i), output(at + 1:at + b))
      at = at + b
    end do
    call give_tangents(self, is_wanted, l, output, at)
    do i = 1, merge(self%wing%patterns%count(), 0, has_patterns)
      call self%wing%patterns%tangent(self%wing%experiment, self%work, i, l, columns(:, 1))
      call self%wing%average(l, columns(:, 1), output(at + 1:at + b))
      at = at + b
    end do
  end subroutine give_directions

  !> Puts the tangents of load l for the wanted coordinates into output(at + 1:), and raises `at` to the last number written.
  subroutine give_tangents(self, is_wanted, l, output, at)
    class(bending_runner_t), intent(inout) :: self
    logical, intent(in) :: is_wanted(:)
    integer, intent(in) :: l
    real(rp), intent(inout) :: output(:)
    integer, intent(inout) :: at
    real(rp) :: column(self%wing%experiment%comparisons(l)%n)
    integer :: i, b
    b = self%wing%count_rows(l)
    do i = 1, size(is_wanted)
      if (.not. is_wanted(i)) cycle
      call self%wing%tangent(self%work, i, l, column)
      call self%wing%average(l, column, output(at + 1:at + b))
      at = at + b
    end do
  end subroutine give_tangents

  !> Tells whether a signal has asked rank 0 to stop, or whether its time is over, since a batch may last longer than the job.
  !> Returns false if there are no rules for stopping.
  logical function runner_wants_stop(self) result(wants)
    class(bending_runner_t), intent(inout) :: self
    if (self%has_stop_rules) self%is_stopping = self%is_stopping .or. signal_caught() > 0 .or. self%stop_rules%is_time_over()
    wants = self%is_stopping
  end function runner_wants_stop

  !> Makes all ranks agree on whether to stop. Does nothing if there are no rules for stopping. Collective.
  subroutine runner_meet(self, world)
    class(bending_runner_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    if (self%has_stop_rules) call self%stop_rules%poll(world)
  end subroutine runner_meet
end module measurement_bending_runner

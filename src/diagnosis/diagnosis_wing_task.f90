! SPDX-License-Identifier: GPL-3.0-or-later
!> The task of which a diagnosis of a wing consists: one load at one point, done by any rank. The result depends on
!> the task and on what rank 0 has shared, never on what the rank has done before.
module diagnosis_wing_task
  use base_errors, only: require
  use base_kinds, only: rp
  use diagnosis_wing_bins, only: bin_rows, bins_t
  use diagnosis_wing_quantities, only: is_setup_for, make_setup, quantity_tangent, setup_coordinates, setup_t, &
                                       wing_quantity_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use measurement_simulation, only: N_NUISANCES
  use parallel_farm, only: task_runner_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_runner_t, wing_patterns_t, task_input

  integer, parameter, public :: TASK_EVALUATE = 1, TASK_DIRECTIONS = 2, TASK_PIXELS = 3, TASK_NUISANCES = 4
  integer, parameter, public :: N_FACTS = 1        !< numbers of an output before the results: solved without snap
  integer, parameter, public :: N_LOAD_NUISANCES = N_NUISANCES
  !> Kinds of accidents of a load with one declared sd, in the order of simulation_t, and what they are called.
  integer, parameter, public :: NUISANCE_KIND(N_NUISANCES) = [1, 2, 2, 3, 3, 4]
  character(*), parameter, public :: NUISANCE_NAMES(4) = [character(34) :: 'errors of forces', &
                                                          'errors of places', 'tilts of scans', 'heights of whole scans']
  integer, parameter :: N_HEAD = 5, NOT_SOLVED = 1

  !> Unknown causes: log stiffness in discs, and forces in proportion to the load around the same places.
  type :: wing_patterns_t
    real(rp), allocatable :: place(:, :)     !< (2, n) [m]
    real(rp) :: radius = 0                   !< [m]
  end type wing_patterns_t

  !> Does tasks. The context that rank 0 shares is empty or holds starts of warm solutions, (3, n_all, loads).
  type, extends(task_runner_t) :: wing_runner_t
    type(experiment_t), pointer :: bare => null() !< without unknowns
    type(wing_t), pointer :: wing => null()
    type(wing_quantity_t), allocatable :: quantities(:)
    type(bins_t) :: bins
    type(wing_patterns_t) :: patterns
    type(setup_t), private :: setup
    type(evaluation_work_t), private :: work
    real(rp), allocatable, private :: u(:, :)
  contains
    procedure :: init => runner_init
    procedure :: free => runner_free
    procedure :: input_size => runner_input_size
    procedure :: output_size => runner_output_size
    procedure :: most_output => runner_most_output
    procedure :: run_task => runner_run_task
  end type wing_runner_t

contains

  !> The experiment `bare`, without unknowns, and the wing must live as long as the runner.
  subroutine runner_init(self, bare, wing, quantities, bins, patterns)
    class(wing_runner_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_quantity_t), intent(in) :: quantities(:)
    type(bins_t), intent(in) :: bins
    type(wing_patterns_t), intent(in) :: patterns
    call self%free()
    self%bare => bare
    self%wing => wing
    self%quantities = quantities
    self%bins = bins
    self%patterns = patterns
    allocate (self%u(3, bare%model%n_all), source=0.0_rp)
    if (.not. allocated(self%context)) allocate (self%context(0))
  end subroutine runner_init

  !> Releases everything.
  subroutine runner_free(self)
    class(wing_runner_t), intent(inout) :: self
    call self%work%free()
    if (allocated(self%u)) deallocate (self%u)
    if (allocated(self%setup%order)) deallocate (self%setup%order)
  end subroutine runner_free

  !> Numbers of an input.
  pure integer function runner_input_size(self) result(n)
    class(wing_runner_t), intent(in) :: self
    n = N_HEAD + 2*size(self%quantities)
  end function runner_input_size

  !> Numbers that any task gives back at most.
  pure integer function runner_most_output(self) result(n)
    class(wing_runner_t), intent(in) :: self
    integer :: task
    n = maxval([(self%output_size(task, size(self%quantities)), task=TASK_EVALUATE, TASK_NUISANCES)])
  end function runner_most_output

  !> Numbers that a task with derivatives with respect to `n_columns` quantities gives back at most.
  pure integer function runner_output_size(self, task, n_columns) result(n)
    class(wing_runner_t), intent(in) :: self
    integer, intent(in) :: task, n_columns
    integer :: most
    most = max(0, maxval(self%bins%count))
    select case (task)
    case (TASK_EVALUATE)
      n = most*(1 + n_columns) + 3*self%bare%model%n_all
    case (TASK_NUISANCES)
      n = most*(N_LOAD_NUISANCES + n_columns)
    case (TASK_DIRECTIONS)
      n = most*(N_LOAD_NUISANCES + n_columns + 2*size(self%patterns%place, 2))
    case default
      n = max(0, maxval(self%bare%comparisons%n))
    end select
    n = n + N_FACTS
  end function runner_output_size

  !> A task: load l at q, `aside` [m] of its place, warm or cold; derivatives with respect to the quantities `columns`,
  !> each 0 or 1 in the input.
  pure function task_input(task, l, is_warm, aside, q, columns) result(input)
    integer, intent(in) :: task, l, columns(:)
    logical, intent(in) :: is_warm
    real(rp), intent(in) :: aside(2), q(:)
    real(rp) :: input(N_HEAD + 2*size(q))
    input(:N_HEAD) = [real(task, rp), real(l, rp), merge(1.0_rp, 0.0_rp, is_warm), aside]
    input(N_HEAD + 1:N_HEAD + size(q)) = q
    input(N_HEAD + size(q) + 1:) = 0
    input(N_HEAD + size(q) + columns) = 1
  end function task_input

  !> TASK_EVALUATE gives facts, residuals(b), derivatives(b, columns) in the order of the quantities and the shape;
  !> TASK_DIRECTIONS facts, nuisances(b, 6) of one declared sd (see simulation_t), derivatives(b, columns), patterns(b,
  !> 2 n); TASK_NUISANCES the same without patterns; TASK_PIXELS facts and the residuals of all pixels. b observations of
  !> the load; the status is NOT_SOLVED where there is no shape, or one in an excluded zone.
  subroutine runner_run_task(self, input, output, status)
    class(wing_runner_t), intent(inout) :: self
    real(rp), intent(in) :: input(:)
    real(rp), intent(inout) :: output(:)
    integer, intent(out) :: status
    type(evaluation_t) :: evaluation
    integer :: l, n, nq
    logical :: is_warm
    l = nint(input(2))
    is_warm = input(3) > 0.5_rp
    nq = size(self%quantities)
    n = size(self%u)
    associate (q => input(N_HEAD + 1:N_HEAD + nq))
      if (.not. is_setup_for(self%setup, self%quantities, q)) then
        call make_setup(self%bare, self%wing, self%quantities, q, self%setup)
        call self%work%init(self%setup%experiment)
      end if
      self%u = 0
      if (is_warm) then
        call require(size(self%context) == n*size(self%bare%loads), 'diagnosis_wing_task: starts of warm solutions')
        self%u = reshape(self%context((l - 1)*n + 1:l*n), shape(self%u))
      end if
      call evaluation%init(self%setup%experiment, l, .false.)
      call evaluate(self%setup%experiment, self%work, setup_coordinates(self%setup, q), l, is_warm, self%u, &
                    evaluation, input(N_HEAD - 1:N_HEAD))
      status = merge(0, NOT_SOLVED, evaluation%is_feasible())
      if (status /= 0) return
      output(1) = merge(1, 0, evaluation%is_start)
      select case (nint(input(1)))
      case (TASK_EVALUATE)
        call give_evaluation(self, q, input(N_HEAD + nq + 1:) > 0.5_rp, l, evaluation%residuals, output(N_FACTS + 1:))
      case (TASK_DIRECTIONS, TASK_NUISANCES)
        call give_directions(self, q, input(N_HEAD + nq + 1:) > 0.5_rp, nint(input(1)) == TASK_DIRECTIONS, l, &
                             output(N_FACTS + 1:))
      case default
        output(N_FACTS + 1:N_FACTS + size(evaluation%residuals)) = evaluation%residuals
      end select
    end associate
  end subroutine runner_run_task

  subroutine give_evaluation(self, q, is_wanted, l, residuals, output)
    class(wing_runner_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), residuals(:)
    logical, intent(in) :: is_wanted(:)
    integer, intent(in) :: l
    real(rp), intent(inout) :: output(:)
    real(rp) :: column(size(residuals))
    integer :: i, b, at
    b = self%bins%count(l)
    call bin_rows(self%bins, l, residuals, output(:b))
    at = b
    do i = 1, size(q)
      if (.not. is_wanted(i)) cycle
      call quantity_tangent(self%work, self%setup, self%quantities, q, i, l, column)
      call bin_rows(self%bins, l, column, output(at + 1:at + b))
      at = at + b
    end do
    output(at + 1:at + size(self%u)) = reshape(self%u, [size(self%u)])
  end subroutine give_evaluation

  subroutine give_directions(self, q, is_wanted, has_patterns, l, output)
    class(wing_runner_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    logical, intent(in) :: is_wanted(:), has_patterns
    integer, intent(in) :: l
    real(rp), intent(inout) :: output(:)
    real(rp) :: columns(self%bare%comparisons(l)%n, N_NUISANCES), sd(N_NUISANCES)
    real(rp) :: force(3, self%bare%model%n_all)
    integer :: i, b, at
    b = self%bins%count(l)
    call self%work%nuisance_tangents(self%setup%experiment, l, columns, sd)
    at = 0
    do i = 1, N_NUISANCES
      call bin_rows(self%bins, l, sd(i)*columns(:, i), output(at + 1:at + b))
      at = at + b
    end do
    do i = 1, size(q)
      if (.not. is_wanted(i)) cycle
      call quantity_tangent(self%work, self%setup, self%quantities, q, i, l, columns(:, 1))
      call bin_rows(self%bins, l, columns(:, 1), output(at + 1:at + b))
      at = at + b
    end do
    if (.not. has_patterns) return
    associate (places => self%patterns%place)
      do i = 1, 2*size(places, 2)
        if (i <= size(places, 2)) then
          call self%work%damage_tangent(self%setup%experiment, l, [places(:, i), self%patterns%radius], columns(:, 1))
        else
          call spread_force(self, l, places(:, i - size(places, 2)), force)
          call self%work%force_tangent(self%setup%experiment, l, force, columns(:, 1))
        end if
        call bin_rows(self%bins, l, columns(:, 1), output(at + 1:at + b))
        at = at + b
      end do
    end associate
  end subroutine give_directions

  !> The stated load spread over the wing around a place.
  subroutine spread_force(self, l, place, force)
    class(wing_runner_t), intent(in) :: self
    integer, intent(in) :: l
    real(rp), intent(in) :: place(2)
    real(rp), intent(out) :: force(:, :)
    real(rp) :: weights(self%bare%model%n_points)
    integer :: i
    associate (load => self%bare%measurement%loads(l))
      do i = 1, size(weights)
        weights(i) = exp(-0.5_rp*sum((self%bare%model%points(:2, i) - place)**2)/(0.7_rp*self%patterns%radius)**2)
      end do
      weights = weights/sum(weights)
      force = 0
      do i = 1, size(weights)
        force(:, i) = weights(i)*load%force*load%direction
      end do
    end associate
  end subroutine spread_force
end module diagnosis_wing_task

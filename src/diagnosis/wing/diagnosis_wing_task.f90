! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs the tasks of a diagnosis: one load on one wing (measurement_bending_task), for residuals, tangents or pixels.
module diagnosis_wing_task
  use base_kinds, only: rp
  use diagnosis_wing_bins, only: bin_rows, bins_t
  use diagnosis_wing_parameters, only: is_fit_case_for, make_fit_case, wing_parameter_tangent, fit_case_coordinates, fit_case_t, &
                                       wing_parameter_t
  use measurement_bending_task, only: bending_task_t, bending_worker_t, task_head, task_of, NOT_SOLVED, N_HEAD, &
                                      TASK_DIRECTIONS, TASK_EVALUATE, TASK_NUISANCES
  use measurement_evaluation, only: evaluation_t
  use measurement_experiment, only: experiment_t
  use measurement_simulation, only: N_NUISANCES
  use parallel_farm, only: task_runner_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_runner_t, wing_patterns_t, task_input

  integer, parameter, public :: N_FACTS = 1        !< numbers of an output before the results: solved without snap
  integer, parameter, public :: N_LOAD_NUISANCES = N_NUISANCES
  !> Kinds of errors of a load that have one declared sd, in the order of simulation_t, and their names.
  integer, parameter, public :: NUISANCE_KIND(N_NUISANCES) = [1, 2, 2, 3, 3, 4]
  character(*), parameter, public :: NUISANCE_NAMES(4) = [character(34) :: 'errors of forces', &
                                                          'errors of places', 'tilts of scans', 'heights of whole scans']

  !> Unknown causes: log stiffness in discs, and forces in proportion to the load around the same places.
  type :: wing_patterns_t
    real(rp), allocatable :: site(:, :)     !< (2, n) [m]
    real(rp) :: radius = 0                   !< [m]
  end type wing_patterns_t

  !> Does tasks. The context that rank 0 shares is empty or holds starts of warm solutions, (3, n_all, loads).
  type, extends(task_runner_t) :: wing_runner_t
    type(experiment_t), pointer :: bare => null() !< without unknowns
    type(wing_t), pointer :: wing => null()
    type(wing_parameter_t), allocatable :: parameters(:)
    type(bins_t) :: bins
    type(wing_patterns_t) :: patterns
    type(fit_case_t), private :: fit_case
    type(bending_worker_t), private :: worker
  contains
    procedure :: init => runner_init
    procedure :: free => runner_free
    procedure :: input_size => runner_input_size
    procedure :: output_size => runner_output_size
    procedure :: most_output => runner_most_output
    procedure :: run_task => runner_run_task
  end type wing_runner_t

contains

  !> Takes the experiment `bare`, without unknowns, and the wing. Both must live as long as the runner.
  subroutine runner_init(self, bare, wing, parameters, bins, patterns)
    class(wing_runner_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(bins_t), intent(in) :: bins
    type(wing_patterns_t), intent(in) :: patterns
    call self%free()
    self%bare => bare
    self%wing => wing
    self%parameters = parameters
    self%bins = bins
    self%patterns = patterns
    call self%worker%init(bare%model%n_all)
    if (.not. allocated(self%context)) allocate (self%context(0))
  end subroutine runner_init

  !> Releases everything.
  subroutine runner_free(self)
    class(wing_runner_t), intent(inout) :: self
    call self%worker%free()
    if (allocated(self%fit_case%order)) deallocate (self%fit_case%order)
  end subroutine runner_free

  !> Returns how many numbers an input has.
  pure integer function runner_input_size(self) result(n)
    class(wing_runner_t), intent(in) :: self
    n = N_HEAD + 2*size(self%parameters)
  end function runner_input_size

  !> Returns how many numbers any task gives back at most.
  pure integer function runner_most_output(self) result(n)
    class(wing_runner_t), intent(in) :: self
    integer :: task
    n = maxval([(self%output_size(task, size(self%parameters)), task=TASK_EVALUATE, TASK_NUISANCES)])
  end function runner_most_output

  !> Returns how many numbers a task with derivatives with respect to `n_columns` parameters gives back at most.
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
      n = most*(N_LOAD_NUISANCES + n_columns + 2*size(self%patterns%site, 2))
    case default
      n = max(0, maxval(self%bare%comparisons%n))
    end select
    n = n + N_FACTS
  end function runner_output_size

  !> Returns a task: load l at q, `load_offset` [m] of its place, warm or cold; derivatives with respect to the parameters
  !> `columns`, each 0 or 1 in the input.
  pure function task_input(task, l, is_warm, load_offset, q, columns) result(input)
    integer, intent(in) :: task, l, columns(:)
    logical, intent(in) :: is_warm
    real(rp), intent(in) :: load_offset(2), q(:)
    real(rp) :: input(N_HEAD + 2*size(q))
    input(:N_HEAD) = task_head(task, l, is_warm, load_offset)
    input(N_HEAD + 1:N_HEAD + size(q)) = q
    input(N_HEAD + size(q) + 1:) = 0
    input(N_HEAD + size(q) + columns) = 1
  end function task_input

  !> Returns what a task gives. TASK_EVALUATE gives facts, residuals(b), derivatives(b, columns) in the order of the parameters,
  !> and the shape; TASK_DIRECTIONS facts, nuisances(b, 6) of one declared sd (see simulation_t), derivatives(b, columns),
  !> patterns(b, 2 n); TASK_NUISANCES the same without patterns; TASK_PIXELS facts and the residuals of all pixels. The load has b
  !> observations. The status is NOT_SOLVED if there is no shape, or one in an excluded zone.
  subroutine runner_run_task(self, input, output, status)
    class(wing_runner_t), intent(inout) :: self
    real(rp), intent(in) :: input(:)
    real(rp), intent(inout) :: output(:)
    integer, intent(out) :: status
    type(evaluation_t) :: evaluation
    type(bending_task_t) :: task
    integer :: nq
    task = task_of(input)
    nq = size(self%parameters)
    associate (l => task%load, q => input(N_HEAD + 1:N_HEAD + nq), is_wanted => input(N_HEAD + nq + 1:) > 0.5_rp)
      if (.not. is_fit_case_for(self%fit_case, self%parameters, q)) then
        call make_fit_case(self%bare, self%wing, self%parameters, q, self%fit_case)
        call self%worker%work%init(self%fit_case%experiment)
      end if
      call evaluation%init(self%fit_case%experiment, l, .false.)
      call self%worker%solve(self%fit_case%experiment, task, fit_case_coordinates(self%fit_case, q), self%context, evaluation)
      status = merge(0, NOT_SOLVED, evaluation%is_feasible())
      if (status /= 0) return
      output(1) = merge(1, 0, evaluation%is_start)
      select case (task%kind)
      case (TASK_EVALUATE)
        call give_evaluation(self, q, is_wanted, l, evaluation%residuals, output(N_FACTS + 1:))
      case (TASK_DIRECTIONS, TASK_NUISANCES)
        call give_directions(self, q, is_wanted, task%kind == TASK_DIRECTIONS, l, output(N_FACTS + 1:))
      case default
        output(N_FACTS + 1:N_FACTS + size(evaluation%residuals)) = evaluation%residuals
      end select
    end associate
  end subroutine runner_run_task

  !> Gives residuals and wanted tangents of load `l`, averaged over the bins, and after them the displacements.
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
      call wing_parameter_tangent(self%worker%work, self%fit_case, self%parameters, q, i, l, column)
      call bin_rows(self%bins, l, column, output(at + 1:at + b))
      at = at + b
    end do
    associate (u => self%worker%u)
      output(at + 1:at + size(u)) = reshape(u, [size(u)])
    end associate
  end subroutine give_evaluation

  !> Gives the tangents of load `l` for nuisances, wanted parameters and, if wanted, patterns, averaged over the bins.
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
    call self%worker%work%nuisance_tangents(self%fit_case%experiment, l, columns, sd)
    at = 0
    do i = 1, N_NUISANCES
      call bin_rows(self%bins, l, sd(i)*columns(:, i), output(at + 1:at + b))
      at = at + b
    end do
    do i = 1, size(q)
      if (.not. is_wanted(i)) cycle
      call wing_parameter_tangent(self%worker%work, self%fit_case, self%parameters, q, i, l, columns(:, 1))
      call bin_rows(self%bins, l, columns(:, 1), output(at + 1:at + b))
      at = at + b
    end do
    if (.not. has_patterns) return
    associate (sites => self%patterns%site)
      do i = 1, 2*size(sites, 2)
        if (i <= size(sites, 2)) then
          call self%worker%work%damage_tangent(self%fit_case%experiment, l, [sites(:, i), self%patterns%radius], columns(:, 1))
        else
          call spread_force(self, l, sites(:, i - size(sites, 2)), force)
          call self%worker%work%force_tangent(self%fit_case%experiment, l, force, columns(:, 1))
        end if
        call bin_rows(self%bins, l, columns(:, 1), output(at + 1:at + b))
        at = at + b
      end do
    end associate
  end subroutine give_directions

  !> Returns the stated load, spread over the wing around a place.
  subroutine spread_force(self, l, site, force)
    class(wing_runner_t), intent(in) :: self
    integer, intent(in) :: l
    real(rp), intent(in) :: site(2)
    real(rp), intent(out) :: force(:, :)
    real(rp) :: weights(self%bare%model%n_points)
    integer :: i
    associate (load => self%bare%measurement%loads(l))
      do i = 1, size(weights)
        weights(i) = exp(-0.5_rp*sum((self%bare%model%points(:2, i) - site)**2)/(0.7_rp*self%patterns%radius)**2)
      end do
      weights = weights/sum(weights)
      force = 0
      do i = 1, size(weights)
        force(:, i) = weights(i)*load%force*load%direction
      end do
    end associate
  end subroutine spread_force
end module diagnosis_wing_task

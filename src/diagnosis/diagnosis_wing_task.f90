! SPDX-License-Identifier: GPL-3.0-or-later
!> The task of which a diagnosis of a wing consists: one load at one point, done by any rank. The result depends on the task
!> and on what rank 0 has shared, never on what the rank has done before.
module diagnosis_wing_task
  use base_errors, only: require
  use base_kinds, only: rp
  use diagnosis_wing_bins, only: bin_rows, bins_t
  use diagnosis_wing_quantities, only: differentiate_shape, load_scale, set_load, set_model, wing_quantity_t, &
                                       KIND_SCALE, KIND_ZERO
  use measurement_evaluation, only: zone_violations
  use measurement_experiment, only: experiment_t
  use measurement_sampling, only: surface_sample_t
  use parallel_farm, only: task_runner_t
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_sensitivity, only: direction_sensitivity, force_sensitivity
  use solid_statics, only: solve_static, static_report_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: damage_direction
  implicit none
  private
  public :: wing_runner_t, wing_patterns_t, task_input

  integer, parameter, public :: TASK_EVALUATE = 1, TASK_DIRECTIONS = 2, TASK_PIXELS = 3
  integer, parameter, public :: N_FACTS = 2       !< numbers of an output before the results: solved without snap, chi^2
  integer, parameter, public :: N_LOAD_NUISANCES = 3 !< force, x and y of its place
  integer, parameter :: N_HEAD = 3, NOT_SOLVED = 1

  !> Unknown causes: log stiffness in discs, and forces in proportion to the load around the same places.
  type :: wing_patterns_t
    real(rp), allocatable :: place(:, :)     !< (2, n) [m]
    real(rp) :: radius = 0                   !< [m]
  end type wing_patterns_t

  !> Does tasks. The context that rank 0 shares is empty or holds starts of warm solutions, (3, n_all, loads).
  type, extends(task_runner_t) :: wing_runner_t
    type(experiment_t), pointer :: experiment => null()
    type(wing_quantity_t), allocatable :: quantities(:)
    type(bins_t) :: bins
    type(wing_patterns_t) :: patterns
    type(solid_model_t), private :: model
    type(equilibrium_t), private :: equilibrium
    type(surface_sample_t), private :: sample
    type(load_t), private :: load
    real(rp), allocatable, private :: u(:, :), positions(:, :), moved(:, :)
  contains
    procedure :: init => runner_init
    procedure :: free => runner_free
    procedure :: input_size => runner_input_size
    procedure :: output_size => runner_output_size
    procedure :: run_task => runner_run_task
  end type wing_runner_t

contains

  !> The experiment must live as long as the runner.
  subroutine runner_init(self, experiment, quantities, bins, patterns)
    class(wing_runner_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: experiment
    type(wing_quantity_t), intent(in) :: quantities(:)
    type(bins_t), intent(in) :: bins
    type(wing_patterns_t), intent(in) :: patterns
    call self%free()
    self%experiment => experiment
    self%quantities = quantities
    self%bins = bins
    self%patterns = patterns
    self%model = experiment%model
    call self%equilibrium%init(self%model)
    call self%sample%init(maxval(experiment%comparisons%n_heights))
    call self%load%init(self%model)
    allocate (self%u(3, self%model%n_all), self%positions(3, self%model%n_points), self%moved(3, self%model%n_all), &
              source=0.0_rp)
    if (.not. allocated(self%context)) allocate (self%context(0))
  end subroutine runner_init

  !> Releases everything.
  subroutine runner_free(self)
    class(wing_runner_t), intent(inout) :: self
    call self%equilibrium%free()
    if (allocated(self%u)) deallocate (self%u, self%positions, self%moved)
  end subroutine runner_free

  !> Numbers of an input.
  pure integer function runner_input_size(self) result(n)
    class(wing_runner_t), intent(in) :: self
    n = N_HEAD + 2*size(self%quantities)
  end function runner_input_size

  !> Numbers that any task gives back at most.
  pure integer function runner_output_size(self) result(n)
    class(wing_runner_t), intent(in) :: self
    integer :: most
    most = maxval(self%bins%count)
    n = most*(1 + size(self%quantities)) + 3*self%experiment%model%n_all
    n = max(n, most*(N_LOAD_NUISANCES + 2*size(self%patterns%place, 2)), maxval(self%experiment%comparisons%n))
    n = n + N_FACTS
  end function runner_output_size

  !> A task: load l at q, warm or cold; derivatives with respect to the quantities `columns`, each 0 or 1 in the input.
  pure function task_input(task, l, is_warm, q, columns) result(input)
    integer, intent(in) :: task, l, columns(:)
    logical, intent(in) :: is_warm
    real(rp), intent(in) :: q(:)
    real(rp) :: input(N_HEAD + 2*size(q))
    input(:N_HEAD) = [real(task, rp), real(l, rp), merge(1.0_rp, 0.0_rp, is_warm)]
    input(N_HEAD + 1:N_HEAD + size(q)) = q
    input(N_HEAD + size(q) + 1:) = 0
    input(N_HEAD + size(q) + columns) = 1
  end function task_input

  !> TASK_EVALUATE gives facts, residuals(b), derivatives(b, columns) in the order of the quantities and the shape;
  !> TASK_DIRECTIONS facts, nuisances(b, 3) for relative force and for x and y of the place [1/m], patterns(b, 2 n);
  !> TASK_PIXELS facts and the residuals of all pixels. b observations of the load; the status is NOT_SOLVED where there
  !> is no shape, or one in an excluded zone.
  subroutine runner_run_task(self, input, output, status)
    class(wing_runner_t), intent(inout) :: self
    real(rp), intent(in) :: input(:)
    real(rp), intent(inout) :: output(:)
    integer, intent(out) :: status
    type(static_report_t) :: report
    real(rp), allocatable :: residuals(:, :)
    integer :: l, n, nq
    logical :: is_warm
    l = nint(input(2))
    is_warm = input(3) > 0.5_rp
    nq = size(self%quantities)
    n = size(self%u)
    status = NOT_SOLVED
    associate (q => input(N_HEAD + 1:N_HEAD + nq), e => self%experiment)
      self%u = 0
      if (is_warm) then
        call require(size(self%context) == n*size(e%loads), 'diagnosis_wing_task: starts of warm solutions')
        self%u = reshape(self%context((l - 1)*n + 1:l*n), shape(self%u))
      end if
      call set_model(self%quantities, q, e, l, self%model)
      call set_load(self%quantities, q, e, l, self%load)
      call solve_static(self%equilibrium, self%model, self%load, is_warm, e%options, self%u, report)
      if (.not. report%converged) return
      if (any(zone_violations(e, l, self%u) > 0)) return
      allocate (residuals(e%comparisons(l)%n, 1))
      call compare(self, q, l, residuals(:, 1))
      output(1) = merge(1, 0, report%snaps == 0)
      output(2) = sum((residuals(:, 1)/e%comparisons(l)%sigma)**2)
      select case (nint(input(1)))
      case (TASK_EVALUATE)
        call give_evaluation(self, q, input(N_HEAD + nq + 1:) > 0.5_rp, l, residuals, output(N_FACTS + 1:))
      case (TASK_DIRECTIONS)
        call give_directions(self, q, l, output(N_FACTS + 1:))
      case default
        output(N_FACTS + 1:N_FACTS + size(residuals)) = residuals(:, 1)
      end select
    end associate
    status = 0
  end subroutine runner_run_task

  !> Residuals of all pixels and scalar observations at the shape u.
  subroutine compare(self, q, l, residuals)
    class(wing_runner_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: l
    real(rp), intent(out) :: residuals(:)
    real(rp) :: scale
    self%positions = self%model%points(:, :self%model%n_points) + self%u(:, :self%model%n_points)
    scale = load_scale(self%quantities, q)
    associate (e => self%experiment, comparison => self%experiment%comparisons(l))
      call comparison%residuals(e%measurement%x, e%measurement%y, self%model%points, self%model%triangles, e%edges, &
                                self%positions, pack(q, self%quantities%kind == KIND_ZERO), self%sample, residuals)
      associate (n => comparison%n_heights)
        residuals(:n) = scale*(residuals(:n) + comparison%measured(:n)) - comparison%measured(:n)
      end associate
    end associate
  end subroutine compare

  subroutine give_evaluation(self, q, is_wanted, l, residuals, output)
    class(wing_runner_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), residuals(:, :)
    logical, intent(in) :: is_wanted(:)
    integer, intent(in) :: l
    real(rp), intent(inout) :: output(:)
    real(rp) :: column(size(residuals, 1), 1), average(self%bins%count(l), 1)
    integer :: i, b, at
    b = self%bins%count(l)
    call bin_rows(self%bins, l, residuals, average)
    output(:b) = average(:, 1)
    at = b
    associate (comparison => self%experiment%comparisons(l))
      do i = 1, size(q)
        if (.not. is_wanted(i)) cycle
        if (self%quantities(i)%kind == KIND_SCALE) then
          column = 0
          associate (n => comparison%n_heights)
            column(:n, 1) = residuals(:n, 1) + comparison%measured(:n)
          end associate
        else if (self%quantities(i)%kind == KIND_ZERO) then
          column = 0
          where (comparison%gauges%zero == self%quantities(i)%number) column(comparison%n_heights + 1:, 1) = 1
        else
          call differentiate_shape(self%quantities, q, i, self%experiment, l, self%equilibrium, self%model, self%load, &
                                   self%u, self%moved)
          call see(self, q, l, column(:, 1))
        end if
        call bin_rows(self%bins, l, column, average)
        output(at + 1:at + b) = average(:, 1)
        at = at + b
      end do
    end associate
    output(at + 1:at + size(self%u)) = reshape(self%u, [size(self%u)])
  end subroutine give_evaluation

  !> What the motion `moved` does to the residuals, right after `compare`.
  subroutine see(self, q, l, column)
    class(wing_runner_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: l
    real(rp), intent(out) :: column(:)
    associate (e => self%experiment, comparison => self%experiment%comparisons(l))
      call comparison%derivatives(e%measurement%x, e%measurement%y, self%positions, self%sample, &
                                  self%moved(:, :self%model%n_points), column)
      column(:comparison%n_heights) = load_scale(self%quantities, q)*column(:comparison%n_heights)
    end associate
  end subroutine see

  subroutine give_directions(self, q, l, output)
    class(wing_runner_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: l
    real(rp), intent(inout) :: output(:)
    real(rp) :: column(self%experiment%comparisons(l)%n, 1), average(self%bins%count(l), 1), force(3, size(self%u, 2))
    type(stiffness_t) :: direction
    integer :: i, b, at, n
    b = self%bins%count(l)
    n = size(self%patterns%place, 2)
    at = 0
    do i = 1, N_LOAD_NUISANCES + 2*n
      if (i <= N_LOAD_NUISANCES) then
        if (i == 1) force = self%load%force
        if (i > 1) call shift_force(self, l, i - 1, force)
        call force_sensitivity(self%equilibrium, self%model, force, self%moved)
      else if (i <= N_LOAD_NUISANCES + n) then
        call damage_direction(self%model, [self%patterns%place(:, i - N_LOAD_NUISANCES), self%patterns%radius], direction)
        call direction_sensitivity(self%equilibrium, self%model, self%u, direction, self%moved)
      else
        call spread_force(self, l, self%patterns%place(:, i - N_LOAD_NUISANCES - n), force)
        call force_sensitivity(self%equilibrium, self%model, force, self%moved)
      end if
      call see(self, q, l, column(:, 1))
      call bin_rows(self%bins, l, column, average)
      output(at + 1:at + b) = average(:, 1)
      at = at + b
    end do
  end subroutine give_directions

  !> Derivative of the load when its place moves along x (c = 1) or y (c = 2) within its triangle [N/m].
  subroutine shift_force(self, l, c, force)
    class(wing_runner_t), intent(in) :: self
    integer, intent(in) :: l, c
    real(rp), intent(out) :: force(:, :)
    real(rp) :: area, slope(2, 3), total(3)
    integer :: i
    force = 0
    associate (place => self%experiment%places(l), points => self%model%points)
      if (.not. place%is_in_triangle) return
      associate (p => points(:2, place%corner))
        area = (p(1, 2) - p(1, 1))*(p(2, 3) - p(2, 1)) - (p(1, 3) - p(1, 1))*(p(2, 2) - p(2, 1))
        do i = 1, 3
          associate (a => p(:, mod(i, 3) + 1), d => p(:, mod(i + 1, 3) + 1))
            slope(:, i) = [a(2) - d(2), d(1) - a(1)]/area
          end associate
        end do
      end associate
      total = sum(self%load%force, 2)
      do i = 1, 3
        force(:, place%corner(i)) = force(:, place%corner(i)) + slope(c, i)*total
      end do
    end associate
  end subroutine shift_force

  !> The load spread over the wing around a place.
  subroutine spread_force(self, l, place, force)
    class(wing_runner_t), intent(in) :: self
    integer, intent(in) :: l
    real(rp), intent(in) :: place(2)
    real(rp), intent(out) :: force(:, :)
    real(rp) :: weights(self%model%n_points), total(3)
    integer :: i
    do i = 1, size(weights)
      weights(i) = exp(-0.5_rp*sum((self%model%points(:2, i) - place)**2)/(0.7_rp*self%patterns%radius)**2)
    end do
    weights = weights/sum(weights)
    total = sum(self%load%force, 2)
    if (.not. norm2(total) > 0) total = self%experiment%measurement%loads(l)%direction
    force = 0
    do i = 1, size(weights)
      force(:, i) = weights(i)*total
    end do
  end subroutine spread_force
end module diagnosis_wing_task

! SPDX-License-Identifier: GPL-3.0-or-later
!> Simulates a mass-spring wing and a measurement of it for the statistics. Loads are tasks of a pool: rank 0 leads, all ranks
!> solve, and results do not depend on the number of ranks.
!>
!>     call simulator%init(...)                    collective
!>     if (world%is_root) then
!>       ... statistics ...; call simulator%shut_down()
!>     else
!>       call simulator%serve()
!>     end if
module diagnosis_wing_simulator
  use base_kinds, only: rp
  use diagnosis_flight_data, only: flight_cases_t
  use diagnosis_families, only: FAMILY_FORCE, FAMILY_SCANS, FAMILY_STIFFNESS, FAMILY_VEINS
  use diagnosis_journalled_motion, only: journalled_motion_t
  use diagnosis_journalled_tasks, only: run_journalled_tasks
  use diagnosis_wing_bins, only: bin_distortions, bin_covariance, bins_t, noise_model_t, N_DISTORTIONS
  use diagnosis_wing_entries, only: catalogue_t
  use diagnosis_wing_labels, only: make_labels
  use diagnosis_wing_lattice, only: lay_out_patterns
  use diagnosis_wing_observed, only: diagnosed_wing_t
  use diagnosis_wing_parameters, only: find_parameter, wing_parameter_t, without_sites, KIND_FLIGHT, KIND_INSTRUMENT, &
                                       KIND_MEMBRANE, KIND_PARAMETER, KIND_SOFT
  use diagnosis_wing_places, only: is_on_wing
  use diagnosis_wing_state, only: wing_state, wing_state_t
  use inference_probability, only: MAP_OF_VIBRATION
  use inference_simulator, only: simulator_t, TANGENT_ERROR
  use least_squares_state, only: solver_state_t
  use measurement_bending_pool, only: bending_batch_t, bending_pool_t
  use measurement_bending_runner, only: bending_runner_t
  use measurement_bending_task, only: bending_task_t, take_columns, task_input, FACT_START, N_FACTS, TASK_DIRECTIONS, &
                                      TASK_EVALUATE, TASK_NUISANCES
  use measurement_experiment, only: experiment_t
  use measurement_instrument_causes, only: FORCE_GAIN
  use measurement_observed_wing, only: observed_wing_t, wing_patterns_t
  use measurement_simulation, only: N_LOAD_NUISANCES => N_NUISANCES
  use parallel_world, only: world_t
  use solid_mass_effects, only: mass_parts_t
  use solid_usual_causes, only: PARAM_PLATE
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_simulator_t

  integer, parameter, public :: N_COMMON_NUISANCES = 2 !< gain of all forces, D
  !> Kinds of errors of a load that have one declared sd, in the order of simulation_t, and their names.
  integer, parameter :: NUISANCE_KIND(N_LOAD_NUISANCES) = [1, 2, 2, 3, 3, 4]
  character(*), parameter :: NUISANCE_NAMES(4) = [character(34) :: 'errors of forces', &
                                                  'errors of places', 'tilts of scans', 'heights of whole scans']

  type, extends(simulator_t) :: wing_simulator_t
    type(experiment_t), pointer :: experiment => null()
    type(wing_parameter_t), allocatable :: wing_parameters(:) !< `parameters`, with their meaning for the wing
    type(wing_patterns_t), private :: patterns
    type(bins_t) :: bins
    type(noise_model_t) :: noise                 !< as it is known before any fit
    type(journalled_motion_t) :: motion          !< on rank 0: observations behind those of `bins`, and the journal of all results
    integer :: n_evaluations = 0
    type(bending_pool_t), private :: pool
    real(rp) :: membrane_sd = 0                  !< of log D, which depends on the mesh
    integer, allocatable :: family_kinds(:)      !< FAMILY_*, of the families of unknown causes
    !> Numbers of the parameters for the gain of all forces and for D; 0: none, for instance because the baseline fits it.
    integer, private :: gain = 0, membrane = 0
    real(rp), allocatable, private :: error_directions(:, :) !< (n_observations, :) those of the initial state
  contains
    procedure :: init => wing_init
    procedure :: free => wing_free
    procedure :: serve => wing_serve
    procedure :: shut_down => wing_shut_down
    procedure :: set_error_directions => wing_set_error_directions
    procedure :: initial_state => wing_initial_state
    procedure :: state_from_mesh => wing_state_from_mesh
    procedure :: evaluate => wing_evaluate
    procedure :: covariance => wing_covariance
    procedure :: directions => wing_directions
    procedure :: linearise_at => wing_linearise_at
    procedure :: has_nonlinear_nuisances => wing_has_nonlinear_nuisances
    procedure :: has_common_errors => wing_has_common_errors
    procedure :: independent_fraction => wing_independent_fraction
    procedure :: tangent_error => wing_tangent_error
    procedure :: has_place => wing_has_place
  end type wing_simulator_t

contains

  !> Takes the experiment, which has no unknowns, and the wing, which must live as long as the simulator. Collective.
  subroutine wing_init(self, world, experiment, wing, catalogue, bins, patterns, parts, flights)
    class(wing_simulator_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(experiment_t), intent(in), target :: experiment
    type(wing_t), intent(in), target :: wing
    type(catalogue_t), intent(in) :: catalogue
    type(bins_t), intent(in) :: bins
    type(wing_patterns_t), intent(in) :: patterns
    type(mass_parts_t), intent(in) :: parts !< of the wing's mass, for natural modes and records of motion
    type(flight_cases_t), intent(in) :: flights
    type(diagnosed_wing_t), allocatable :: diagnosed
    class(observed_wing_t), allocatable :: observed
    class(bending_runner_t), allocatable :: runner
    integer :: l, n, n_smooth_errors
    self%experiment => experiment
    self%wing_parameters = catalogue%parameters
    self%parameters = without_sites(catalogue%parameters)
    self%patterns = patterns
    self%effects = catalogue%effects
    self%bins = bins
    self%n_baseline = catalogue%n_baseline
    if (size(experiment%loads) == 0 .and. experiment%measurement%moves()) self%probability_map = MAP_OF_VIBRATION
    if (world%is_root) call self%motion%init(experiment, wing, catalogue%parameters, parts, flights)
    self%motion%mesh = experiment%model%n_points
    self%n_observations = bins%n + self%motion%n
    n_smooth_errors = merge(N_DISTORTIONS, 0, any(bins%cell(1, :bins%n) > 0))
    self%n_alone = 2*size(patterns%site, 2)
    self%n_patterns = self%n_alone + n_smooth_errors*size(experiment%loads)
    self%field = pack([(l, l=1, size(catalogue%parameters))], catalogue%parameters%kind == KIND_SOFT)
    call lay_out_patterns(experiment, catalogue%parameters, patterns, n_smooth_errors, self%field, self%family, self%pattern_site)
    self%family_kinds = [FAMILY_STIFFNESS, FAMILY_FORCE, FAMILY_VEINS, FAMILY_SCANS]
    call self%motion%append_patterns(self%n_patterns, self%family, self%pattern_site, self%family_kinds)
    allocate (diagnosed, runner)
    call diagnosed%init(experiment, wing, catalogue%parameters, bins, patterns)
    call move_alloc(diagnosed, observed)
    call runner%init(observed)
    call self%pool%init(world, runner)
    n = size(experiment%loads)
    allocate (self%error_directions(self%n_observations, 0))
    self%nuisance_kind = [(NUISANCE_KIND, l=1, n)]
    self%n_nuisances = size(self%nuisance_kind) + N_COMMON_NUISANCES + self%motion%n_nuisances
    self%nuisance_names = NUISANCE_NAMES
    self%gain = find_parameter(catalogue%parameters, catalogue%n_baseline, KIND_INSTRUMENT, FORCE_GAIN)
    self%membrane = find_parameter(catalogue%parameters, catalogue%n_baseline, KIND_PARAMETER, PARAM_PLATE)
    if (any(catalogue%parameters%kind == KIND_MEMBRANE)) self%membrane = 0 ! an unknown, and no nuisance
    call make_labels(experiment, bins, self%labels)
    call self%motion%append_labels(self%labels)
  end subroutine wing_init

  !> Releases everything.
  subroutine wing_free(self)
    class(wing_simulator_t), intent(inout) :: self
    call self%pool%free()
    call self%motion%free()
  end subroutine wing_free

  !> Does tasks until rank 0 calls `shut_down`. On the other ranks.
  subroutine wing_serve(self)
    class(wing_simulator_t), intent(inout) :: self
    call self%pool%serve()
  end subroutine wing_serve

  !> Ends `serve`. On rank 0.
  subroutine wing_shut_down(self)
    class(wing_simulator_t), intent(inout) :: self
    call self%pool%shut_down()
  end subroutine wing_shut_down

  !> Gives the initial state directions(n_observations, :), the effects of further errors of unit strength.
  subroutine wing_set_error_directions(self, directions)
    class(wing_simulator_t), intent(inout) :: self
    real(rp), intent(in) :: directions(:, :)
    self%n_nuisances = self%n_nuisances - size(self%error_directions, 2) + size(directions, 2)
    self%error_directions = directions
  end subroutine wing_set_error_directions

  !> Returns the state in which solutions begin at rest and the nuisances are linear about zero errors; see `simulator_t`.
  subroutine wing_initial_state(self, state)
    class(wing_simulator_t), intent(in) :: self
    class(solver_state_t), allocatable, intent(out) :: state
    type(wing_state_t), allocatable :: rest
    allocate (rest)
    call rest%init(self%n_observations, self%bins%n, self%experiment%model%n_all, size(self%experiment%loads))
    rest%error_directions = self%error_directions
    call move_alloc(rest, state)
  end subroutine wing_initial_state

  !> Makes the state that begins at the shapes and has the errors of `other`, a state of the same loads on a mesh of half or of
  !> twice the size. parents(2, points of the finer mesh) are the points of the coarser mesh between which each of them lies.
  subroutine wing_state_from_mesh(self, other, parents, state)
    class(wing_simulator_t), intent(in) :: self
    class(solver_state_t), intent(in) :: other
    integer, intent(in) :: parents(:, :)
    class(solver_state_t), allocatable, intent(out) :: state
    type(wing_state_t), allocatable :: own
    allocate (own)
    call own%init(self%n_observations, self%bins%n, self%experiment%model%n_all, size(self%experiment%loads))
    own%error_directions = self%error_directions
    call own%start_from_mesh(wing_state(other), self%experiment%model%n_points, parents)
    call move_alloc(own, state)
  end subroutine wing_state_from_mesh

  !> Runs one batch: `task` of each of the `loads` at q. Solutions begin at `state`. results(:, size(loads)) has a column for each
  !> load.
  subroutine run_loads(self, task, loads, q, columns, state, results, is_valid)
    class(wing_simulator_t), intent(inout) :: self
    integer, intent(in) :: task, loads(:), columns(:)
    real(rp), intent(in) :: q(:)
    type(wing_state_t), intent(in) :: state
    real(rp), allocatable, intent(out) :: results(:, :)
    logical, intent(out) :: is_valid
    type(bending_batch_t) :: batch
    integer :: l
    call self%pool%make_batch(size(loads), task, size(columns), batch)
    do l = 1, size(loads)
      batch%inputs(:, l) = task_input(bending_task_t(task, loads(l), state%is_start(loads(l)), state%load_offset(:, loads(l))), &
                                      q, columns)
    end do
    batch%starts = [state%shapes]
    call run_journalled_tasks(self%pool, self%motion%journal, batch, is_valid)
    call move_alloc(batch%outputs, results)
    self%n_evaluations = self%n_evaluations + 1
  end subroutine run_loads

  !> Returns the numbers of the loads whose surfaces are wanted.
  pure function wanted_loads(self, is_wanted) result(loads)
    class(wing_simulator_t), intent(in) :: self
    logical, intent(in), optional :: is_wanted(:)
    integer, allocatable :: loads(:)
    integer :: l
    loads = [(l, l=1, size(self%experiment%loads))]
    if (present(is_wanted)) loads = pack(loads, is_wanted(:size(loads)))
  end function wanted_loads

  !> See `simulator_t`. Rank 0 calls it; the others serve.
  subroutine wing_evaluate(self, q, columns, from, residuals, jacobian, is_valid, to, is_wanted)
    class(wing_simulator_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out), optional :: to
    logical, intent(in), optional :: is_wanted(:)
    type(wing_state_t), allocatable :: state
    integer, allocatable :: loads(:)
    real(rp), allocatable :: outputs(:, :)
    integer :: l, k, b, first, at
    residuals = 0
    jacobian = 0
    loads = wanted_loads(self, is_wanted)
    state = wing_state(from)
    call self%motion%flight%use(state%flight)
    call run_loads(self, TASK_EVALUATE, loads, q, columns, state, outputs, is_valid)
    do k = 1, merge(size(loads), 0, is_valid)
      l = loads(k)
      b = self%bins%count(l)
      first = self%bins%first(l)
      residuals(first:first + b - 1) = outputs(N_FACTS + 1:N_FACTS + b, k) - state%linear(first:first + b - 1)
      at = N_FACTS + b
      call take_columns(columns, size(q), outputs(:, k), at, jacobian(first:first + b - 1, :))
      state%is_start(l) = outputs(FACT_START, k) > 0.5_rp
      state%shapes(:, :, l) = reshape(outputs(at + 1:at + size(state%shapes(:, :, l)), k), shape(state%shapes(:, :, l)))
    end do
    if (is_valid .and. wants_motion(self, is_wanted)) &
      call self%motion%recall_evaluation(q, columns, residuals(self%bins%n + 1:), jacobian(self%bins%n + 1:, :), is_valid)
    if (.not. present(to)) return
    if (is_valid) then
      call move_alloc(state, to)
    else
      allocate (to, source=from)
    end if
  end subroutine wing_evaluate

  !> Tells whether any observation of motion is wanted.
  pure logical function wants_motion(self, is_wanted) result(wants)
    class(wing_simulator_t), intent(in) :: self
    logical, intent(in), optional :: is_wanted(:)
    wants = .true.
    if (present(is_wanted)) wants = any(is_wanted(size(self%experiment%loads) + 1:))
  end function wants_motion

  !> See `simulator_t`. Errors of positions are not linear where a load meets a soft place or the edge of a triangle.
  subroutine wing_linearise_at(self, errors, q, state, is_valid)
    class(wing_simulator_t), intent(inout) :: self
    real(rp), intent(in) :: errors(:), q(:)
    class(solver_state_t), allocatable, intent(inout) :: state
    logical, intent(out) :: is_valid
    type(wing_state_t), allocatable :: own
    real(rp) :: residuals(self%n_observations), nothing(self%n_observations, 0)
    real(rp) :: nuisances(self%n_observations, self%n_nuisances)
    integer :: l, first, last, v
    is_valid = .true.
    if (.not. self%has_nonlinear_nuisances()) return
    own = wing_state(state)
    associate (sd => self%experiment%measurement%accuracy%position)
      call own%move_loads(self%experiment, errors, N_LOAD_NUISANCES)
      call self%evaluate(q, [integer ::], own, residuals, nothing, is_valid)
      if (is_valid) call self%directions(q, own, nuisances, nothing, is_valid)
      if (.not. is_valid) return
      do l = 1, size(own%load_offset, 2)
        v = (l - 1)*N_LOAD_NUISANCES + 1
        first = self%bins%first(l)
        last = first + self%bins%count(l) - 1
        own%linear(first:last) = matmul(nuisances(first:last, v + 1:v + 2), own%load_offset(:, l)/sd)
      end do
    end associate
    call move_alloc(own, state)
  end subroutine wing_linearise_at

  !> Tells whether the positions of loads have errors: only these are not linear.
  pure logical function wing_has_nonlinear_nuisances(self) result(has_some)
    class(wing_simulator_t), intent(in) :: self
    has_some = self%experiment%measurement%accuracy%position > 0 .and. size(self%experiment%model%triangles) > 0
  end function wing_has_nonlinear_nuisances

  !> See `simulator_t`.
  subroutine wing_covariance(self, rows, independent_fraction, c)
    class(wing_simulator_t), intent(in) :: self
    integer, intent(in) :: rows(:)
    real(rp), intent(in) :: independent_fraction
    real(rp), intent(out) :: c(:, :)
    if (minval(rows) <= self%bins%n) then ! a block has loads or a mode
      call bin_covariance(self%bins, self%noise%with_independent(independent_fraction), rows, c)
    else
      call self%motion%covariance(rows - self%bins%n, c)
    end if
  end subroutine wing_covariance

  !> See `simulator_t`. Tangents of flights are central differences over a step h, the prior sd, of about 0.08 (rad, or relative).
  !> Their relative error for forces that depend smoothly on angles is h^2/6.
  pure real(rp) function wing_tangent_error(self, i) result(error)
    class(wing_simulator_t), intent(in) :: self
    integer, intent(in) :: i
    error = merge(1.0e-3_rp, TANGENT_ERROR, self%wing_parameters(i)%kind == KIND_FLIGHT)
  end function wing_tangent_error

  !> Tells whether a correlation length is declared, see `simulator_t`.
  pure logical function wing_has_common_errors(self) result(has_some)
    class(wing_simulator_t), intent(in) :: self
    has_some = self%noise%length > 0
  end function wing_has_common_errors

  !> See `simulator_t`.
  pure real(rp) function wing_independent_fraction(self) result(fraction)
    class(wing_simulator_t), intent(in) :: self
    fraction = self%noise%white
  end function wing_independent_fraction

  !> See `simulator_t`.
  logical function wing_has_place(self, e, place) result(has_it)
    class(wing_simulator_t), intent(in) :: self
    integer, intent(in) :: e
    real(rp), intent(in) :: place(:)
    has_it = size(place) == size(self%effects(e)%place_columns) .and. is_on_wing(self%experiment, place)
  end function wing_has_place

  !> See `simulator_t`. The nuisances are the errors of every load (see simulation_t), the gain of all forces, D, the errors of
  !> records of motion, those of flights (see flight_nuisances), and the error of the mesh, in this order.
  subroutine wing_directions(self, q, from, nuisances, patterns, is_valid)
    class(wing_simulator_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: nuisances(:, :), patterns(:, :)
    logical, intent(out) :: is_valid
    type(wing_state_t) :: state
    real(rp), allocatable :: outputs(:, :)
    integer, allocatable :: common(:)
    real(rp) :: sd(N_COMMON_NUISANCES)
    integer :: l, i, b, first, at, shared
    nuisances = 0
    patterns = 0
    common = pack([self%gain, self%membrane], [self%gain, self%membrane] > 0)
    sd = [self%experiment%measurement%accuracy%force_gain, self%membrane_sd]
    state = wing_state(from)
    call self%motion%flight%use(state%flight)
    call run_loads(self, merge(TASK_DIRECTIONS, TASK_NUISANCES, size(patterns, 2) > 0), wanted_loads(self), q, common, state, &
                   outputs, is_valid)
    if (.not. is_valid) return
    shared = size(outputs, 2)*N_LOAD_NUISANCES
    do l = 1, size(outputs, 2)
      b = self%bins%count(l)
      first = self%bins%first(l)
      at = N_FACTS
      do i = 1, N_LOAD_NUISANCES
        nuisances(first:first + b - 1, (l - 1)*N_LOAD_NUISANCES + i) = outputs(at + 1:at + b, l)
        at = at + b
      end do
      do i = 1, size(self%parameters)
        if (.not. any(common == i)) cycle
        if (i == self%gain) nuisances(first:first + b - 1, shared + 1) = sd(1)*outputs(at + 1:at + b, l)
        if (i == self%membrane) nuisances(first:first + b - 1, shared + 2) = sd(2)*outputs(at + 1:at + b, l)
        at = at + b
      end do
      if (size(patterns, 2) == 0) cycle
      do i = 1, self%n_alone
        patterns(first:first + b - 1, i) = outputs(at + 1:at + b, l)
        at = at + b
      end do
      if (.not. any(self%bins%cell(1, :self%bins%n) > 0)) cycle
      i = self%n_alone + N_DISTORTIONS*(l - 1)
      call bin_distortions(self%bins, l, self%experiment%root, self%experiment%model%size, &
                           patterns(first:first + b - 1, i + 1:i + N_DISTORTIONS))
    end do
    shared = shared + N_COMMON_NUISANCES
    nuisances(:, shared + self%motion%n_nuisances + 1:) = state%error_directions
    associate (rows => self%bins%n + 1, last => shared + self%motion%n_nuisances)
      call self%motion%recall_directions(q, self%membrane, self%membrane_sd, self%patterns, nuisances(rows:, shared:last), &
                                         patterns(rows:, :), is_valid)
    end associate
  end subroutine wing_directions
end module diagnosis_wing_simulator

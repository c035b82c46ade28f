! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs a diagnosis from beginning to end. Rank 0 leads; all ranks solve.
module diagnose_job
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_build, only: BUILD_COMMIT, BUILD_VERSION
  use base_checksum, only: checksum_text
  use base_errors, only: failure_t, message_list_t
  use base_decimal, only: fixed
  use base_kinds, only: i8, rp
  use base_named_kinds, only: word_of
  use base_outcome, only: outcome_t, OUTCOME_MISTAKE, OUTCOME_NOT_CONVERGED, OUTCOME_STOPPED, OUTCOME_UNWRITABLE, &
                          OUTCOME_VERDICT
  use base_random, only: random_uniforms
  use common_diagnose_keys, only: REFINES
  use common_wing_doubts, only: print_notices
  use diagnose_command, only: diagnose_command_t, DIAGNOSE_CHECK, DIAGNOSE_PLAN
  use diagnose_comparison, only: print_comparison
  use diagnose_draws, only: draws_file_t
  use diagnose_files, only: write_fragments, write_maps
  use diagnose_flight_cost, only: print_cost, print_wing_cost
  use diagnose_flight_json, only: write_extended_flight
  use diagnose_flight_settings, only: fly_all
  use diagnose_json, only: write_diagnosis_json
  use diagnose_next, only: write_next
  use diagnose_plan_report, only: print_plan
  use diagnose_results, only: print_results, PLAN_RESULT, RESULTS
  use diagnose_settings, only: diagnose_settings_t, load_diagnose_settings
  use diagnose_summary, only: print_verdict
  use diagnose_wing_flights, only: fly_wings
  use diagnosis_discretisation, only: discretisation_error_t, DECISIVE_SNR
  use diagnosis_flight_comparison, only: compare_flights
  use diagnosis_further_runs, only: further_runs_t
  use diagnosis_mode_report, only: describe_modes
  use diagnosis_series_report, only: describe_series
  use diagnosis_next_measurement, only: next_measurement_t, rank_measurements
  use diagnosis_noise, only: check_declared_variance
  use diagnosis_unknown, only: describe_unknown, unknown_t
  use diagnosis_wing_places, only: take_places
  use diagnosis_wing_simulator, only: wing_simulator_t
  use diagnosis_zeros, only: compare_zeros, zeros_t
  use inference_engine, only: diagnosis_t, run_diagnosis
  use io_earlier_results, only: move_earlier_file, EARLIER_SUFFIX
  use io_journal, only: journal_t
  use io_lock, only: lock_t, LOCK_TAKEN
  use parallel_outcome, only: agree_on_outcome
  use parallel_world, only: world_t
  implicit none
  private
  public :: diagnose_t

  integer(i8), parameter :: START_STREAM = 21
  real(rp), parameter :: START_SPREAD = 1.0_rp !< of random starts about the values of [Wing], in coordinates

  type :: diagnose_t
    type(world_t) :: world
    type(diagnose_settings_t) :: settings
    type(wing_simulator_t) :: simulator
    type(diagnosis_t) :: diagnosis
    type(discretisation_error_t) :: discretisation
    type(further_runs_t) :: further
    logical :: has_discretisation = .false. !< the error of the mesh can be estimated
    logical, private :: has_compared = .false. !< this error is known
    logical :: is_over = .false.            !< there is nothing left to do
    type(lock_t), private :: lock !< of the files, on rank 0
    type(journal_t), private :: journal !< of all computed results, on rank 0
    character(:), allocatable, private :: inputs !< when the journal began
    type(outcome_t) :: outcome  !< of the program
  contains
    procedure :: load => diagnose_load
    procedure :: begin => diagnose_begin
    procedure :: open_files => diagnose_open_files
    procedure :: take_files => diagnose_take_files
    procedure :: close_files => diagnose_close_files
    procedure :: compare_meshes => diagnose_compare_meshes
    procedure :: lead => diagnose_lead
    procedure :: serve => diagnose_serve
    procedure :: shut_down => diagnose_shut_down
    procedure :: free => diagnose_free
    procedure :: finish => diagnose_finish
  end type diagnose_t

contains

  !> Reads the input. Mistakes are printed, and the kind of `outcome` then says that the input is not valid. Collective.
  subroutine diagnose_load(self, command, world)
    class(diagnose_t), intent(inout) :: self
    type(diagnose_command_t), intent(in) :: command
    type(world_t), intent(in) :: world
    type(message_list_t) :: errors, notices
    self%world = world
    call load_diagnose_settings(command%ini, command%refine, any(command%action == [DIAGNOSE_PLAN, DIAGNOSE_CHECK]), world, &
                                self%settings, errors, notices)
    if (errors%count() > 0) call self%outcome%end_as(OUTCOME_MISTAKE)
    if (world%is_root .and. errors%count() > 0) then
      call errors%print(error_unit, '')
    else if (world%is_root .and. .not. command%is_again) then
      call print_notices(notices, command%action == DIAGNOSE_CHECK)
    end if
    flush (error_unit)
    call agree_on_outcome(world, self%outcome)
  end subroutine diagnose_load

  !> Makes all ranks ready to take tasks. Collective.
  subroutine diagnose_begin(self, command)
    class(diagnose_t), intent(inout), target :: self
    type(diagnose_command_t), intent(in) :: command
    type(failure_t) :: failure
    call fly(self, command)
    if (self%is_over) return
    associate (s => self%settings)
      call self%simulator%init(self%world, s%experiment, s%wing_case%wing, s%catalogue, s%bins, &
                               s%patterns, s%parts, s%flights)
      if (s%options%is_scale_known .and. .not. s%measurement%is_plan) then
        s%noise%model%factor = 1
        s%noise%model%unloaded = 1
      end if
      self%simulator%noise = s%noise%model
      self%simulator%membrane_sd = s%membrane_sd
      self%has_discretisation = s%finds_discretisation .and. command%action /= DIAGNOSE_PLAN
    end associate
    if (self%has_discretisation) then
      call self%discretisation%init(self%world, self%settings, failure)
      self%has_discretisation = .not. failure%failed
      if (failure%failed .and. self%world%is_root) &
        write (error_unit, '(a)') 'notice: the error of the mesh is not estimated: '//failure%reason
    end if
    if (self%has_discretisation) then
      call self%further%init(self%world, self%simulator, self%discretisation)
    else
      call self%further%init(self%world, self%simulator)
    end if
    if (self%settings%flights%is_ready) &
      call self%further%take_flights(self%settings%choices%flight%rounds, self%settings%runner, self%settings%flights)
    if (self%settings%choices%flight%compare) call self%further%take_runner(self%settings%runner)
  end subroutine diagnose_begin

  !> Locks the files and begins the journal, before anything is computed that it keeps. `is_over` is set if the files cannot be
  !> locked, or earlier results not renamed. Collective.
  subroutine diagnose_open_files(self, command)
    class(diagnose_t), intent(inout), target :: self
    type(diagnose_command_t), intent(in) :: command
    if (self%is_over) return
    if (self%world%is_root) then
      call prepare_files(self, command%action == DIAGNOSE_PLAN)
      if (.not. self%outcome%failure%failed .and. command%action /= DIAGNOSE_PLAN) call begin_journal(self, command)
    end if
    call agree_on_outcome(self%world, self%outcome)
    self%is_over = .not. self%outcome%is_good()
  end subroutine diagnose_open_files

  !> Takes the lock and the journal of `other`, which has begun this diagnosis on the other mesh, and goes on with them. If an input
  !> has changed since then, the journal is removed; if the name of the files has, those of the new name are opened. Collective.
  subroutine diagnose_take_files(self, command, other)
    class(diagnose_t), intent(inout), target :: self
    type(diagnose_command_t), intent(in) :: command
    type(diagnose_t), intent(inout) :: other
    integer :: is_other
    is_other = 0
    if (self%world%is_root) is_other = merge(1, 0, self%settings%name /= other%settings%name)
    if (self%world%max_integer(is_other) == 1) then
      call other%close_files()
      call self%open_files(command)
      return
    end if
    self%lock = other%lock
    other%lock = lock_t()
    if (.not. self%world%is_root) return
    self%inputs = self%settings%config%inputs()
    if (self%inputs == other%inputs) then
      self%journal = other%journal
      other%journal = journal_t()
      call use_journal(self)
    else
      call other%journal%finish(.true.)
    end if
  end subroutine diagnose_take_files

  !> Ends the journal, which is kept after a stop or a full disk for a later run, and releases the lock.
  subroutine diagnose_close_files(self)
    class(diagnose_t), intent(inout) :: self
    call self%journal%finish(all(self%outcome%kind /= [OUTCOME_UNWRITABLE, OUTCOME_STOPPED]))
    call self%lock%release()
  end subroutine diagnose_close_files

  !> Finds the error of the mesh if it decides which mesh the fits use. `wants_finer` tells whether it is so large that they are to
  !> use the finer mesh, and not that of this diagnosis. Collective.
  subroutine diagnose_compare_meshes(self, wants_finer)
    class(diagnose_t), intent(inout), target :: self
    logical, intent(out) :: wants_finer
    integer :: answer
    wants_finer = .false.
    if (self%is_over .or. .not. (self%has_discretisation .and. self%settings%chooses_mesh)) return
    if (self%world%is_root) then
      call find_mesh_error(self)
      wants_finer = self%discretisation%is_found .and. self%discretisation%snr > DECISIVE_SNR
      if (wants_finer) write (error_unit, '(a)') 'notice: a mesh of half the size changes the motion by a signal-to-noise '// &
        'ratio of '//fixed(self%discretisation%snr, 1)//', more than the '//fixed(DECISIVE_SNR, 1)//' that may decide between '// &
        'two causes: all fits use this mesh. With refine = yes they use that of the file, and the change counts as an error'
      flush (error_unit)
    else
      call self%discretisation%serve_first(self%simulator)
    end if
    self%has_compared = .true.
    answer = self%world%max_integer(merge(1, 0, wants_finer))
    wants_finer = answer == 1
  end subroutine diagnose_compare_meshes

  !> Finds the error of the mesh, or prints that there is none. On rank 0; the others are in `serve_first` of the error.
  subroutine find_mesh_error(self)
    class(diagnose_t), intent(inout), target :: self
    call self%discretisation%find(self%settings, self%simulator)
    if (.not. self%discretisation%is_found) write (error_unit, '(a)') 'notice: the error of the mesh is not estimated '// &
      'and not counted: the fit on one of the two meshes failed'
  end subroutine find_mesh_error

  !> Prints what the flights cost, and simulates them unless this is a plan. Collective.
  subroutine fly(self, command)
    class(diagnose_t), intent(inout) :: self
    type(diagnose_command_t), intent(in) :: command
    associate (s => self%settings)
      if (s%choices%flight%compare .and. self%world%is_root) &
        call print_wing_cost(output_unit, s%choices%flight%directions, s%runner, s%flights, self%world)
      if (.not. s%flights%has_records) return
      if (self%world%is_root) call print_cost(output_unit, s%choices%flight%rounds, s%runner, s%flights, self%world)
      flush (output_unit)
      self%is_over = command%action == DIAGNOSE_PLAN .and. s%only_flies()
      if (command%action == DIAGNOSE_PLAN) return
      call fly_all(self%world, s%runner, s%flights, s%catalogue, self%outcome)
      self%is_over = self%outcome%failure%failed
    end associate
  end subroutine fly

  !> Makes the diagnosis, prints it and writes the files; for a plan it prints the smallest effects that the loads would show. Only
  !> rank 0 calls it.
  subroutine diagnose_lead(self, command)
    class(diagnose_t), intent(inout), target :: self
    type(diagnose_command_t), intent(in) :: command
    type(next_measurement_t) :: next
    type(zeros_t) :: zeros
    type(unknown_t) :: unknown
    type(draws_file_t) :: store
    type(failure_t) :: unflown
    character(:), allocatable :: warning
    if (self%is_over) return
    store%path = self%settings%draws_path
    if (command%action == DIAGNOSE_PLAN) then
      call print_plan(output_unit, self%settings, self%simulator, self%outcome%failure, store)
      call self%outcome%classify(OUTCOME_NOT_CONVERGED)
      return
    end if
    if (self%has_discretisation .and. .not. self%has_compared) call find_mesh_error(self)
    call run_diagnosis(self%simulator, starts(self), self%settings%options, self%diagnosis, self%outcome%failure, &
                       store, self%further)
    call take_places(self%settings%catalogue, self%simulator%effects)
    if (self%further%outcome%failure%failed) self%outcome = self%further%outcome
    call self%outcome%classify(OUTCOME_NOT_CONVERGED)
    if (self%outcome%failure%failed) return
    self%settings%noise%model = self%simulator%noise%with_independent(self%diagnosis%model%whitener%independent_fraction)
    warning = self%settings%noise%warning
    call check_declared_variance(self%settings%noise, self%diagnosis%tests%scale)
    if (self%settings%noise%warning /= warning) write (error_unit, '(a)') 'notice: '//self%settings%noise%warning
    call rank_measurements(self%settings, self%simulator, self%diagnosis, next)
    call compare_zeros(self%settings, self%simulator, self%diagnosis, zeros)
    call describe_modes(self%settings, self%simulator, self%diagnosis)
    call describe_series(self%settings, self%simulator, self%diagnosis)
    call compare_flights(self%settings, self%diagnosis)
    unknown = describe_unknown(self%settings, self%simulator, self%diagnosis)
    call print_verdict(output_unit, self%settings, self%diagnosis, self%discretisation, next, zeros, unknown)
    call fly_wings(self%settings, self%diagnosis, self%further, unflown)
    if (unflown%failed) self%settings%comparison%reason = unflown%reason ! the diagnosis does not need these flights
    call print_comparison(output_unit, self%settings)
    call write_fragments(self%settings, self%diagnosis, self%outcome%failure)
    call write_extended_flight(self%settings, self%diagnosis, self%outcome%failure)
    call write_maps(self%settings, self%simulator, self%diagnosis, self%outcome%failure)
    call write_next(self%settings, next, self%outcome%failure)
    ! The verdict is written last: if it exists, all other results exist.
    call write_diagnosis_json(self%settings, self%simulator%labels, self%diagnosis, self%discretisation, next, zeros, unknown, &
                              self%outcome%failure)
    if (.not. self%outcome%failure%failed) call print_results(output_unit, self%settings%name)
    if (self%further%outcome%failure%failed .and. .not. self%outcome%failure%failed) self%outcome = self%further%outcome
    self%outcome%verdict = self%diagnosis%decision%verdict
    if (command%wants_code) call self%outcome%end_as(OUTCOME_VERDICT)
    call self%outcome%classify(OUTCOME_UNWRITABLE)
  end subroutine diagnose_lead

  !> Locks the files against another run, which also shows whether they can be written. Renames the results of an earlier diagnosis,
  !> so that no verdict is left if this run ends without one. Only rank 0 calls it.
  subroutine prepare_files(self, is_plan)
    class(diagnose_t), intent(inout) :: self
    logical, intent(in) :: is_plan
    type(failure_t) :: failure
    character(:), allocatable :: notice
    integer :: state, i
    call self%lock%acquire(self%settings%name//'.lock', state, notice, failure)
    if (failure%failed) then
      call self%outcome%fail(merge(OUTCOME_MISTAKE, OUTCOME_UNWRITABLE, state == LOCK_TAKEN), failure%reason)
      return
    end if
    if (notice /= '') write (error_unit, '(a)') 'notice: '//notice
    if (is_plan) then
      call move(PLAN_RESULT)
    else
      do i = 1, size(RESULTS)
        call move(trim(RESULTS(i)))
      end do
    end if
    if (failure%failed) call self%outcome%fail(OUTCOME_UNWRITABLE, failure%reason)
    flush (error_unit)

  contains

    !> Renames one result of an earlier diagnosis.
    subroutine move(ending)
      character(*), intent(in) :: ending
      logical :: has_moved
      associate (path => self%settings%name//ending)
        call move_earlier_file(path, has_moved, failure)
        if (has_moved) write (error_unit, '(a)') 'notice: '//path//' of an earlier diagnosis was renamed to '//path//EARLIER_SUFFIX
      end associate
    end subroutine move
  end subroutine prepare_files

  !> Begins to store all computed results in a journal. If there is a journal of an unfinished diagnosis of the same inputs, this
  !> diagnosis continues it. Only rank 0 calls it.
  subroutine begin_journal(self, command)
    class(diagnose_t), intent(inout), target :: self
    type(diagnose_command_t), intent(in) :: command
    logical :: goes_on
    self%inputs = self%settings%config%inputs()
    call self%journal%start(self%settings%name//'.journal', checksum_text(self%inputs//' '//word_of(REFINES, command%refine)// &
                                                                          ' '//BUILD_VERSION//' '//BUILD_COMMIT), goes_on)
    if (goes_on) write (error_unit, '(a)') 'notice: '//self%settings%name// &
      '.journal belongs to an unfinished diagnosis of the same inputs; this diagnosis continues it'
    flush (error_unit)
    call use_journal(self)
  end subroutine begin_journal

  !> Makes the simulators of both meshes keep their results in the journal.
  subroutine use_journal(self)
    class(diagnose_t), intent(inout), target :: self
    type(journal_t), pointer :: journal
    journal => self%journal
    self%simulator%motion%journal => journal
    if (self%has_discretisation) call self%discretisation%use_journal(journal)
  end subroutine use_journal

  !> Carries out tasks for rank 0. All other ranks call it.
  subroutine diagnose_serve(self)
    class(diagnose_t), intent(inout) :: self
    if (self%is_over) return
    if (self%has_discretisation .and. .not. self%has_compared) call self%discretisation%serve_first(self%simulator)
    call self%further%serve()
  end subroutine diagnose_serve

  !> Ends `serve` on the other ranks. Only rank 0 calls it.
  subroutine diagnose_shut_down(self)
    class(diagnose_t), intent(inout) :: self
    if (self%is_over) return
    call self%further%shut_down()
  end subroutine diagnose_shut_down

  !> Returns the points from which fits start, one in each column. The first start has the values of [Wing], or the result of the
  !> fit for the error of the mesh. The other starts are random points about the values of [Wing].
  function starts(self) result(points)
    class(diagnose_t), intent(in) :: self
    real(rp), allocatable :: points(:, :)
    real(rp) :: pair(2)
    integer :: s, i
    allocate (points(size(self%simulator%parameters), self%settings%choices%n_starts))
    do s = 1, size(points, 2)
      points(:, s) = self%simulator%null_point()
      if (s == 1 .and. allocated(self%discretisation%start)) points(:, s) = self%discretisation%start
      if (s == 1) cycle
      do i = 1, self%settings%catalogue%n_baseline
        if (.not. self%simulator%parameters(i)%is_log) cycle
        pair = random_uniforms(self%settings%options%seed, START_STREAM, int(s, i8)*1000000_i8 + i)
        points(i, s) = points(i, s) + START_SPREAD*(2*pair(1) - 1)
        points(i, s) = max(self%simulator%parameters(i)%lower, min(self%simulator%parameters(i)%upper, points(i, s)))
      end do
    end do
  end function starts

  !> Ends the work of all ranks. The kind of `outcome` is then the same on all ranks. Collective.
  subroutine diagnose_finish(self)
    class(diagnose_t), intent(inout) :: self
    if (self%outcome%failure%failed .and. (self%world%is_root .or. .not. self%is_over)) &
      write (error_unit, '(a)') 'msm_diagnose: '//self%outcome%failure%reason
    flush (error_unit)
    call self%close_files()
    call self%free()
    call agree_on_outcome(self%world, self%outcome)
  end subroutine diagnose_finish

  !> Releases the simulators. Collective.
  subroutine diagnose_free(self)
    class(diagnose_t), intent(inout) :: self
    call self%simulator%free()
    if (self%has_discretisation) call self%discretisation%free()
  end subroutine diagnose_free
end module diagnose_job

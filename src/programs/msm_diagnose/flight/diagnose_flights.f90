! SPDX-License-Identifier: GPL-3.0-or-later
!> Simulates flights with `flusi` inside this program. Groups of ranks simulate whole flights, each in a folder of its own, whose
!> name depends on the inputs of the flight. A flight that has ended is read and not simulated again. An interrupted flight
!> continues from its backup, or begins again if it has none. Several diagnoses may share the folder of all flights: a lock in the
!> folder of a flight keeps others away from its first file to the mark of its end, and they take the flight then.
module diagnose_flights
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t, message_list_t
  use base_files, only: file_exists, join_path, make_folder, real_path
  use base_kinds, only: i8, rp
  use base_outcome, only: outcome_t, OUTCOME_COLLISION, OUTCOME_DIVERGED, OUTCOME_DONE, OUTCOME_MISTAKE, &
                          OUTCOME_NOT_CONVERGED, OUTCOME_UNWRITABLE
  use base_pause, only: pause_for
  use base_process, only: wall_seconds
  use base_redirection, only: change_folder, redirection_t
  use base_signals, only: signal_caught
  use base_text, only: number_text
  use base_text_file, only: write_text
  use diagnose_flight_case, only: flight_case_t
  use diagnose_flight_landmarks, only: interpolated, read_marks
  use diagnose_flight_refined, only: flight_shift, flown_beats
  use diagnose_flight_structure, only: diagnosed_wing_t, judge_structure
  use diagnosis_flight_runner, only: flight_record_t, flight_request_t, flight_runner_t, N_PHASES
  use diagnosis_wing_parameters, only: wing_parameter_t
  use fsi_rotation, only: cross
  use io_broadcast_text, only: read_text_file
  use io_lock, only: lock_t, LOCK_TAKEN
  use io_series_read, only: read_series
  use measurement_flight, only: N_COMPONENTS
  use parallel_failure, only: broadcast_failure
  use parallel_outcome, only: agree_on_outcome
  use parallel_world, only: world_t
  use simulation_machine, only: check_machine
  use simulation_memory, only: estimate_memory, memory_t
  use simulation_runner, only: simulation_t
  use simulation_settings, only: settings_t
  use simulation_start, only: simulation_start_t
  implicit none
  private
  public :: flusi_runner_t

  character(*), parameter :: LOCKED = 'flight.lock'
  real(rp), parameter :: PAUSE = 0.5_rp !< seconds between two looks at a flight that another diagnosis simulates
  character(*), parameter :: INI = 'flight.ini', LOG = 'log', ENDED = 'ended', FLOWN = 'flown', SERIES = 'forces.t'
  integer, parameter :: COLUMNS = 15 !< of this series: time, F, F unsteady, M, M unsteady, two powers

  type, extends(flight_runner_t) :: flusi_runner_t
    type(flight_case_t), allocatable :: cases(:)
    type(diagnosed_wing_t) :: wing      !< to which places of effects belong
    character(:), allocatable :: folder !< of the folders of all flights
    integer :: ranks = 0                !< of a flight; 0: all
    logical :: is_quiet = .false.
  contains
    procedure :: fly => runner_fly
    procedure :: are_missing => runner_are_missing
    procedure :: judge_structure => runner_judge_structure
  end type flusi_runner_t

  type :: name_t
    character(:), allocatable :: folder, reason
    logical :: has_ended = .false.
  end type name_t

contains

  !> Simulates the requests whose folders hold no ended flight; each group of ranks does one at a time. Then rank 0 reads all
  !> records. `outcome` is a failure if a flight cannot be begun or was stopped. The record of a flight that ends by itself without
  !> a result has the reason. Collective.
  subroutine runner_fly(self, world, requests, records, outcome)
    class(flusi_runner_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(flight_request_t), intent(in) :: requests(:)
    type(flight_record_t), allocatable, intent(out) :: records(:)
    type(outcome_t), intent(inout) :: outcome
    type(name_t), allocatable :: names(:)
    type(world_t) :: group
    integer :: i, k, ranks, n_groups, own
    call tell_structure(self)
    allocate (records(size(requests)), names(size(requests)))
    if (world%is_root) call find_names(self, requests, names)
    call broadcast_names(world, names)
    ranks = world%size
    if (self%ranks > 0) ranks = min(ranks, self%ranks)
    n_groups = world%size/ranks
    own = min(world%rank/ranks, n_groups) ! the last group has the ranks that are left over, and simulates nothing
    call world%split(own, group)
    k = 0
    do i = 1, size(requests)
      if (names(i)%has_ended .or. names(i)%reason /= '') cycle
      if (any([(names(i)%folder == names(k)%folder, k=1, i - 1)])) cycle
      k = count(.not. names(:i - 1)%has_ended) ! groups take turns in a fixed order
      if (modulo(k, n_groups) /= own .or. .not. outcome%is_good()) cycle
      call fly_one(self, group, requests(i), names(i)%folder, outcome)
    end do
    call group%release()
    call agree(world, outcome)
    if (.not. (outcome%is_good() .and. world%is_root)) return
    do i = 1, size(requests)
      call read_record(self%cases(requests(i)%case), names(i), requests(i)%refinement, records(i))
    end do
  end subroutine runner_fly

  !> Tells all cases what the changes of their structure are.
  subroutine tell_structure(self)
    class(flusi_runner_t), intent(inout) :: self
    integer :: k
    do k = 1, size(self%cases)
      if (allocated(self%structure)) self%cases(k)%structure = self%structure
    end do
  end subroutine tell_structure

  !> See `flight_runner_t`.
  subroutine runner_judge_structure(self, number, p, own, reason)
    class(flusi_runner_t), intent(in) :: self
    integer, intent(in) :: number
    type(wing_parameter_t), intent(in) :: p
    real(rp), intent(out) :: own
    character(:), allocatable, intent(out) :: reason
    call judge_structure(self%cases(number)%settings, self%wing, p, own, reason)
  end subroutine runner_judge_structure

  !> Gives all ranks the failure of the first rank that has one. Collective.
  subroutine agree(world, outcome)
    type(world_t), intent(in) :: world
    type(outcome_t), intent(inout) :: outcome
    character(:), allocatable :: reason
    integer :: first, kind
    first = world%max_integer(merge(world%size - world%rank, 0, outcome%failure%failed))
    if (first == 0) return
    kind = world%max_integer(outcome%kind)
    reason = ''
    if (outcome%failure%failed) reason = outcome%failure%reason
    call world%broadcast_text(reason, from=world%size - first)
    if (.not. outcome%failure%failed) call outcome%fail(kind, reason)
  end subroutine agree

  !> Tells for each of the requests whether it has not been simulated. Not collective.
  function runner_are_missing(self, requests) result(missing)
    class(flusi_runner_t), intent(inout) :: self
    type(flight_request_t), intent(in) :: requests(:)
    logical :: missing(size(requests))
    type(name_t), allocatable :: names(:)
    call tell_structure(self)
    allocate (names(size(requests)))
    call find_names(self, requests, names)
    missing = .not. names%has_ended
  end function runner_are_missing

  !> Finds the folder of each flight and whether the flight has ended. Not collective.
  subroutine find_names(self, requests, names)
    class(flusi_runner_t), intent(in) :: self
    type(flight_request_t), intent(in) :: requests(:)
    type(name_t), intent(inout) :: names(:)
    character(:), allocatable :: word, reason
    integer :: i
    do i = 1, size(requests)
      call self%cases(requests(i)%case)%fingerprint(requests(i), word, reason)
      names(i)%folder = join_path(self%folder, word)
      names(i)%reason = ''
      if (allocated(reason)) names(i)%reason = reason
      names(i)%has_ended = file_exists(join_path(names(i)%folder, ENDED))
    end do
  end subroutine find_names

  !> Gives all ranks the names that rank 0 has. Collective.
  subroutine broadcast_names(world, names)
    type(world_t), intent(in) :: world
    type(name_t), intent(inout) :: names(:)
    integer :: i, has_ended
    do i = 1, size(names)
      call world%broadcast_text(names(i)%folder)
      call world%broadcast_text(names(i)%reason)
      has_ended = merge(1, 0, names(i)%has_ended)
      call world%broadcast_integer(has_ended)
      names(i)%has_ended = has_ended == 1
    end do
  end subroutine broadcast_names

  !> Simulates one flight in `folder`, unless another diagnosis has just done so. Its output goes to the file `log` there. A flight
  !> that diverges counts as ended. Collective over the group.
  subroutine fly_one(self, group, request, folder, of_all)
    class(flusi_runner_t), intent(in) :: self
    type(world_t), intent(in) :: group
    type(flight_request_t), intent(in) :: request
    character(*), intent(in) :: folder
    type(outcome_t), intent(inout) :: of_all
    type(settings_t), allocatable :: settings
    type(message_list_t) :: errors
    type(redirection_t) :: redirection
    type(outcome_t) :: outcome
    type(memory_t) :: memory
    type(failure_t) :: own, failure
    type(lock_t) :: lock
    character(:), allocatable :: here
    integer :: has_ended
    allocate (settings)
    call self%cases(request%case)%read(request, settings, errors, group)
    memory = estimate_memory(settings, group%size)
    if (.not. memory%possible) then
      call of_all%fail(OUTCOME_MISTAKE, 'the grid of a flight cannot be shared among '//number_text(group%size)// &
                       ' ranks: give [Flight] ranks')
      return
    end if
    has_ended = 0
    if (group%is_root) then
      call hold(self, folder, lock, own)
      if (.not. own%failed .and. file_exists(join_path(folder, ENDED))) has_ended = 1
      if (.not. own%failed .and. has_ended == 0) &
        call write_text(join_path(folder, INI), self%cases(request%case)%text(request), own)
      if (own%failed .or. has_ended == 1) call lock%release()
    end if
    call group%broadcast_integer(has_ended)
    call broadcast_failure(group, own, failure)
    if (failure%failed) call of_all%fail(OUTCOME_UNWRITABLE, failure%reason)
    if (failure%failed .or. has_ended == 1) return
    here = real_path('.')
    if (group%is_root .and. .not. self%is_quiet) write (output_unit, '(a)') 'flight    '//folder
    call change_folder(folder)
    if (group%is_root) call redirection%begin(LOG)
    call check_machine(group, settings, outcome)
    if (outcome%is_good()) call simulate(group, settings, outcome)
    call agree_on_outcome(group, outcome)
    if (group%is_root) call redirection%finish()
    if (group%is_root) call write_end(outcome, own)
    call change_folder(here)
    if (group%is_root) call lock%release()
    call broadcast_failure(group, own, failure)
    if (failure%failed) call of_all%fail(OUTCOME_UNWRITABLE, folder//'/'//failure%reason)
    if (any(outcome%kind == [OUTCOME_DONE, OUTCOME_DIVERGED, OUTCOME_COLLISION, OUTCOME_NOT_CONVERGED])) return
    call of_all%fail(outcome%kind, 'a flight did not finish; '//join_path(folder, LOG)//' says why. Start the program again '// &
                     'to continue')
  end subroutine fly_one

  !> Locks the folder of a flight, which it makes if it is missing. Waits as long as another diagnosis has it, and says so once.
  !> Fails if nobody can write there, if a signal asks the program to stop, and if the other one has written nothing for an hour:
  !> the state of a process on another machine is unknown.
  subroutine hold(self, folder, lock, failure)
    class(flusi_runner_t), intent(in) :: self
    character(*), intent(in) :: folder
    type(lock_t), intent(inout) :: lock
    type(failure_t), intent(inout) :: failure
    type(failure_t) :: unmade(2) ! ignored, because another group may have made the folder just before
    type(failure_t) :: taken
    character(:), allocatable :: notice
    real(rp), parameter :: LONG = 3600.0_rp !< seconds
    real(rp) :: heard
    integer(i8) :: size_of_log, old_size
    integer :: state
    logical :: is_told
    if (.not. file_exists(self%folder//'/.')) call make_folder(self%folder, unmade(1))
    if (.not. file_exists(folder//'/.')) call make_folder(folder, unmade(2))
    is_told = .false.
    heard = wall_seconds()
    old_size = -1
    do
      taken = failure_t()
      call lock%acquire(join_path(folder, LOCKED), state, notice, taken)
      if (state /= LOCK_TAKEN) exit
      if (.not. (is_told .or. self%is_quiet)) write (output_unit, '(a)') 'waiting   '//taken%reason
      flush (output_unit)
      is_told = .true.
      inquire (file=join_path(folder, LOG), size=size_of_log)
      if (size_of_log /= old_size) heard = wall_seconds()
      old_size = size_of_log
      if (signal_caught() /= 0 .or. wall_seconds() - heard > LONG) exit
      call pause_for(PAUSE)
    end do
    if (taken%failed) call failure%raise(taken%reason)
  end subroutine hold

  !> Runs the simulation in the current folder, from its backup if there is one. Collective over the group.
  subroutine simulate(group, settings, outcome)
    type(world_t), intent(in) :: group
    type(settings_t), intent(in) :: settings
    type(outcome_t), intent(inout) :: outcome
    type(simulation_t), pointer :: simulation !< too large for the stack
    type(simulation_start_t) :: start
    integer :: has_backup
    start%ini = INI
    start%restart_file = ''
    has_backup = 0
    if (group%is_root) has_backup = merge(1, 0, file_exists('runtime_backup0.h5') .or. file_exists('runtime_backup1.h5'))
    call group%broadcast_integer(has_backup)
    start%restart = has_backup == 1
    start%overwrite = .not. start%restart
    allocate (simulation)
    call simulation%init(group, settings, start)
    call simulation%run()
    call simulation%finish()
    outcome = simulation%outcome
    deallocate (simulation)
  end subroutine simulate

  !> Writes the mark of a flight that has ended and need not be simulated again. Fails if it cannot write it.
  subroutine write_end(outcome, failure)
    type(outcome_t), intent(in) :: outcome
    type(failure_t), intent(inout) :: failure
    select case (outcome%kind)
    case (OUTCOME_DONE)
      call write_text(ENDED, FLOWN, failure)
    case (OUTCOME_DIVERGED, OUTCOME_COLLISION, OUTCOME_NOT_CONVERGED)
      call write_text(ENDED, outcome%failure%reason, failure)
    end select
  end subroutine write_end

  !> Reads the result of the flight of this case, name and refinement. It interpolates linearly between the values that were
  !> recorded in the last beat.
  subroutine read_record(case, name, refinement, record)
    type(flight_case_t), intent(in) :: case
    type(name_t), intent(in) :: name
    integer, intent(in) :: refinement
    type(flight_record_t), intent(inout) :: record
    character(:), allocatable :: text, problem
    real(rp), allocatable :: rows(:, :)
    type(failure_t) :: failure
    real(rp) :: times(N_PHASES), x(N_PHASES, COLUMNS), scale
    integer :: i
    record%reason = name%reason
    if (name%reason /= '') return
    call read_text_file(join_path(name%folder, ENDED), text, problem)
    if (allocated(problem)) text = problem
    if (index(text, FLOWN) /= 1) then
      record%reason = 'a flight failed: '//text
      return
    end if
    call read_series(join_path(name%folder, SERIES), COLUMNS, rows, failure)
    if (failure%failed .or. size(rows, 2) < 2) then
      record%reason = join_path(name%folder, SERIES)//': cannot be read; delete this folder to simulate the flight again'
      return
    end if
    associate (u => case%settings%units, s => case%settings)
      scale = u%density*u%length**4*u%frequency**2
      if (s%fluid%grid%is_2d) scale = scale/u%length
      times = [((flown_beats(case%beats, refinement) - 1 + real(i - 1, rp)/N_PHASES)/s%flight%frequency(), i=1, N_PHASES)]
      do i = 2, COLUMNS
        x(:, i) = interpolated(rows(1, :), rows(i, :), times)
      end do
      allocate (record%values(N_PHASES, N_COMPONENTS + 3*case%marks%count()))
      do i = 1, N_PHASES
        associate (force => x(i, 2:4) + x(i, 5:7), torque => x(i, 8:10) + x(i, 11:13))
          record%values(i, 1:3) = scale*force
          record%values(i, 4:6) = scale*u%length*(torque + cross(s%fluid%solids%centre, force))
        end associate
      end do
      record%values(:, 7) = scale*u%length*u%frequency*x(:, 14)
      call read_marks(name%folder, case%marks, times, u%length, flight_shift(s, refinement, case%beats), record%values, failure)
    end associate
    if (failure%failed) then
      record%reason = failure%reason//'; delete this folder to simulate the flight again'
      return
    end if
    record%is_flown = .true.
  end subroutine read_record
end module diagnose_flights

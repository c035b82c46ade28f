! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes one run: it brings together the fluid, its output, its checkpoints and the rules to stop.
module simulation_runner
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t, message_list_t
  use base_files, only: stem_of
  use base_kinds, only: i8, rp
  use base_outcome, only: outcome_t, OUTCOME_COLLISION, OUTCOME_DIVERGED, OUTCOME_DONE, OUTCOME_MISTAKE, OUTCOME_NOT_CONVERGED, &
                          OUTCOME_STOPPED, OUTCOME_UNWRITABLE
  use base_timers, only: timers_t
  use common_progress, only: progress_t
  use common_run, only: run_t
  use fluid_initial_keys, only: FLOW_BACKUP, FLOW_BACKUP_FILE
  use fluid_requests, only: request_t
  use fsi_free_flight, only: launch, settle
  use io_checkpoint, only: checkpoint_writer_t
  use io_checkpoint_slots, only: checkpoint_slots_t
  use io_stop, only: stop_rules_t
  use parallel_world, only: world_t
  use simulation_checkpoints, only: put_state, restore_state, result_names
  use fsi_flight_faults, only: check_flight
  use simulation_mask_run, only: draw_masks
  use simulation_opening, only: opening_t
  use simulation_output, only: output_t
  use simulation_parts, only: run_parts_t
  use simulation_plans, only: plan_run
  use simulation_report, only: print_coupling, print_failure, print_run_header, print_time_table
  use simulation_series, only: run_series_t
  use simulation_settings, only: settings_t
  use simulation_start, only: simulation_start_t
  use simulation_summary, only: write_summary
  use spectral_fftw, only: export_wisdom, PLAN_MEASURE
  implicit none
  private
  public :: simulation_t
  character(*), parameter :: BASE_NAME = 'runtime', BACKUP_NAME = BASE_NAME//'_backup', WISDOM_NAME = 'fftw_wisdom'
  character(*), parameter :: FAILED_NAME = 'failed_backup.h5'

  type, extends(run_parts_t) :: simulation_t
    type(world_t) :: world
    type(settings_t) :: settings
    type(run_series_t), private :: series
    type(output_t), private :: output
    type(checkpoint_slots_t), private :: slots
    type(stop_rules_t), private :: stop_rules
    type(run_t), private :: files                !< files of this run, locked against other runs
    logical, private :: is_built = .false.
    type(progress_t), private :: progress
    type(timers_t), private :: timers
    integer, private :: t_whole = 0, t_start = 0, t_step = 0, t_wings = 0, t_output = 0, t_backup = 0
    character(:), allocatable, private :: name
    type(outcome_t) :: outcome
  contains
    procedure :: init => simulation_init
    procedure :: run => simulation_run
    procedure :: finish => simulation_finish
    procedure, private :: restart, is_done, write_end, back_up, back_up_failed, request_fields, bend, push, move_wings, fail
  end type simulation_t

contains

  !> Builds all parts and starts or restarts the run. After a failure `outcome` says why and the reason is printed. Collective.
  subroutine simulation_init(self, world, settings, start)
    class(simulation_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(settings_t), intent(in) :: settings
    type(simulation_start_t), intent(in) :: start
    type(message_list_t) :: remarks
    type(opening_t) :: opening
    character(:), allocatable :: plans
    logical :: restarts
    self%world = world
    self%settings = settings
    self%name = stem_of(start%ini, '.ini')
    call begin_timers(self)
    restarts = start%restart .or. any(settings%fluid%initial%flow == [FLOW_BACKUP, FLOW_BACKUP_FILE])
    call begin_files(self, start, restarts)
    if (self%outcome%failure%failed) then
      call print_reason(self)
      return
    end if
    self%is_built = .true.
    call self%stop_rules%init(settings%output%limits)
    call plan_run(world, self%settings, WISDOM_NAME, restarts, plans)
    call self%build(world, self%settings, self%outcome%failure)
    call begin_state(self, start, restarts, opening, remarks)
    if (self%outcome%failure%failed) then
      call self%fail(OUTCOME_MISTAKE)
      return
    end if
    call self%files%settle(self%outcome)
    if (self%outcome%failure%failed) call print_reason(self)
    if (self%outcome%failure%failed) return
    call open_results(self, restarts, opening)
    if (self%outcome%failure%failed) then
      call self%fail(OUTCOME_UNWRITABLE)
      return
    end if
    if (world%is_root) then
      call print_run_header(output_unit, self%settings, plans, self%fluid, opening%restart_time, self%thin)
      call remarks%print(output_unit, '')
    end if
    call self%progress%init(world%is_root, settings%output%progress_seconds)
    call self%timers%stop(self%t_start)
  end subroutine simulation_init

  !> Names what is timed, in the order of the table at the end.
  subroutine begin_timers(self)
    type(simulation_t), intent(inout) :: self
    self%t_whole = self%timers%region('whole run')
    call self%timers%start(self%t_whole)
    self%t_start = self%timers%region('start-up')
    self%t_step = self%timers%region('time steps')
    if (self%settings%flexible .or. self%settings%flight%thin%is_thin) &
      self%t_wings = self%timers%region(trim(merge('bending wings      ', 'forces of the wings', self%settings%flexible)))
    self%t_output = self%timers%region('fields and series')
    self%t_backup = self%timers%region('backups')
    call self%timers%start(self%t_start)
  end subroutine begin_timers

  !> Locks the folder for this run. Fails if a new run would find results of another run there. Collective.
  subroutine begin_files(self, start, restarts)
    type(simulation_t), intent(inout) :: self
    type(simulation_start_t), intent(in) :: start
    logical, intent(in) :: restarts
    type(message_list_t) :: patterns
    call self%files%begin(self%world, 'flusi', BASE_NAME, start%ini, self%settings%config, self%outcome)
    if (restarts .and. start%overwrite) call self%outcome%fail(OUTCOME_MISTAKE, &
      '--overwrite starts a new run and inicond = backup continues an old one: leave out one of them')
    call result_names(patterns)
    if (.not. restarts) call self%files%check_new(start%overwrite, patterns, self%outcome)
  end subroutine begin_files

  !> Sets the state of a new run or restores that of a checkpoint. Collective.
  subroutine begin_state(self, start, restarts, opening, remarks)
    type(simulation_t), intent(inout) :: self
    type(simulation_start_t), intent(in) :: start
    logical, intent(in) :: restarts
    type(opening_t), intent(inout) :: opening
    type(message_list_t), intent(inout) :: remarks
    if (restarts) call self%slots%scan(self%world, '.', BACKUP_NAME)
    if (restarts .and. .not. self%outcome%failure%failed) then
      call self%restart(start, remarks)
      opening%restart_time = self%fluid%rhs%state%time
    else if (.not. self%outcome%failure%failed) then
      call self%start(self%outcome%failure)
    end if
    call self%settle_in(self%world, self%settings, self%outcome%failure)
  end subroutine begin_state

  !> Opens the series and the indices, and starts to listen to signals. Collective.
  subroutine open_results(self, restarts, opening)
    type(simulation_t), intent(inout) :: self
    logical, intent(in) :: restarts
    type(opening_t), intent(inout) :: opening
    if (.not. restarts) call self%slots%scan(self%world, '.', BACKUP_NAME) ! an early stop always writes a backup
    call self%slots%identify(self%files%identity)
    call self%stop_rules%listen(self%world)
    opening%world = self%world
    opening%name = self%name
    opening%note = self%settings%units%note()
    call self%series%open(opening, self%settings, self%fluid, self%wings)
    call self%output%init(opening, self%settings%output, self%fluid, self%wings)
    self%outcome%failure = opening%failure
  end subroutine open_results

  !> Steps until the run ends or something asks it to stop. Collective.
  subroutine simulation_run(self)
    class(simulation_t), intent(inout) :: self
    type(request_t) :: request
    real(rp) :: seconds
    if (self%outcome%kind /= OUTCOME_DONE) return
    if (self%settings%output%mask_only) then
      call draw_masks(self%settings, self%fluid, self%output, self%outcome%failure, self%wings)
      if (self%outcome%failure%failed) call self%fail(OUTCOME_UNWRITABLE)
      return
    end if
    associate (state => self%fluid%rhs%state, fluid => self%fluid)
      do while (.not. self%is_done())
        call self%request_fields(.false., request)
        call self%timers%start(self%t_step)
        call fluid%step(request, self%outcome%failure, self%wings, self%trial())
        call self%timers%stop(self%t_step)
        call self%series%write_slip(fluid, self%thin)
        call self%outcome%classify(OUTCOME_DIVERGED)
        if (self%outcome%failure%failed) exit
        if (allocated(self%coupler)) call sample_loads(self)
        if (.not. self%outcome%failure%failed) call write_all(self)
        if (self%outcome%failure%failed) exit
        if (allocated(self%averages)) call self%averages%add(fluid)
        call self%move_wings()
        if (self%outcome%failure%failed) exit
        call self%progress%step_done(state%step, state%time, fluid%dt, fluid%sums%u_max, self%settings%fluid%time%t_max, &
                                     self%settings%fluid%time%nt, seconds)
        call self%series%write_step(fluid, seconds, self%world%size, self%coupler)
        call self%stop_rules%poll(self%world)
        if (self%stop_rules%backup_due .and. self%settings%output%backup .and. .not. self%is_done()) call self%back_up()
        if (self%stop_rules%must_stop .or. self%outcome%failure%failed) exit
      end do
      call self%progress%finish()
      if (.not. self%outcome%failure%failed) then
        if (self%is_done()) then
          call self%write_end(request)
        else
          call self%outcome%end_as(OUTCOME_STOPPED)
          call self%back_up()
          if (self%world%is_root .and. .not. self%outcome%failure%failed) write (output_unit, '(a)') 'stopped early: '// &
            trim(self%stop_rules%reason)//'; the backup is written; continue with --restart'
        end if
      end if
      if (.not. self%outcome%failure%failed) return
      call self%outcome%classify(OUTCOME_UNWRITABLE)
      ! With other parameters flexible wings may continue, but a collision would occur again.
      if (self%outcome%kind == OUTCOME_NOT_CONVERGED) call self%back_up_failed()
      if (self%outcome%kind == OUTCOME_DIVERGED) call self%output%write_failed(fluid, self%outcome%failure)
      call print_reason(self)
    end associate
  end subroutine simulation_run

  !> Writes what is due at the end of the run, and the last backup.
  subroutine write_end(self, request)
    class(simulation_t), intent(inout) :: self
    type(request_t), intent(out) :: request
    call self%request_fields(.true., request)
    call self%fluid%evaluate(request, self%outcome%failure, self%wings)
    call self%series%write_slip(self%fluid, self%thin)
    call self%outcome%classify(OUTCOME_DIVERGED)
    if (self%outcome%failure%failed) return
    if (allocated(self%coupler)) call sample_loads(self)
    if (.not. self%outcome%failure%failed) call write_all(self)
    call self%output%flush(self%fluid, self%outcome%failure)
    if (self%settings%output%backup) call self%back_up()
  end subroutine write_end

  !> Decides which output is due, and saves those parts of the present state that the next step would change.
  subroutine request_fields(self, is_last, request)
    class(simulation_t), intent(inout) :: self
    logical, intent(in) :: is_last
    type(request_t), intent(out) :: request
    call self%output%request_fields(self%fluid, is_last, request, self%averages)
    if (self%output%integrals_due) call self%series%record_spectra(self%fluid)
    if (allocated(self%coupler)) call self%coupler%add_request(request)
  end subroutine request_fields

  !> Samples the load on the flexible wings at their present positions.
  subroutine sample_loads(self)
    type(simulation_t), intent(inout) :: self
    call self%timers%start(self%t_wings)
    call self%coupler%sample_load(self%fluid, self%wings)
    call check_flight(self%wings, self%settings%fluid%grid, self%outcome%failure)
    call self%series%record(self%wings, self%coupler, self%fluid)
    call self%timers%stop(self%t_wings)
    call self%outcome%classify(OUTCOME_COLLISION)
  end subroutine sample_loads

  !> Moves the wings, and the body that flies freely, over the step that the fluid has made.
  subroutine move_wings(self)
    class(simulation_t), intent(inout) :: self
    if (self%settings%flight%flyer%is_free) call launch(self%wings, self%fluid, self%coupler)
    if (self%t_wings > 0) call self%timers%start(self%t_wings)
    if (allocated(self%coupler)) then
      call self%bend()
    else if (allocated(self%thin)) then
      call self%push()
    end if
    if (self%t_wings > 0) call self%timers%stop(self%t_wings)
    ! This is done after a failure, too, so that its checkpoint contains a complete state.
    if (self%settings%flight%flyer%is_free) call settle(self%wings, self%fluid)
  end subroutine move_wings

  !> Moves the flexible wings over the step that the fluid has made.
  subroutine bend(self)
    class(simulation_t), intent(inout) :: self
    call self%coupler%advance(self%fluid%dt, self%wings, self%outcome%failure, self%fluid, self%thin)
    call self%outcome%classify(merge(OUTCOME_DIVERGED, OUTCOME_NOT_CONVERGED, self%fluid%rhs%failure%failed))
  end subroutine bend

  !> Lets rigid wings without thickness act on the step that the fluid has made.
  subroutine push(self)
    class(simulation_t), intent(inout) :: self
    call self%thin%advance_rigid(self%fluid, self%wings, self%outcome%failure)
    call self%outcome%classify(OUTCOME_COLLISION)
  end subroutine push

  !> Closes the files, writes the summary, prints how the time was spent, and releases memory and locks. Collective.
  subroutine simulation_finish(self)
    class(simulation_t), intent(inout) :: self
    if (.not. self%is_built) then
      call self%files%finish()
      return
    end if
    if (self%outcome%kind /= OUTCOME_MISTAKE) then
      call self%series%close(self%outcome%failure)
      if (self%outcome%kind == OUTCOME_DONE .and. allocated(self%wings) .and. self%world%is_root .and. &
          self%settings%fluid%solids%compute_forces) call write_summary(self%settings, self%name, self%outcome%failure)
      if (self%outcome%kind == OUTCOME_DONE .and. self%outcome%failure%failed) call self%fail(OUTCOME_UNWRITABLE)
      call self%timers%stop(self%t_whole)
      call print_time_table(self%world, self%timers, self%t_whole, self%fluid, self%wings)
      if (self%world%is_root .and. allocated(self%coupler)) call print_coupling(output_unit, self%coupler)
    end if
    call self%fluid%free()
    if (allocated(self%coupler)) call self%coupler%free()
    if (allocated(self%thin)) call self%thin%free()
    call self%files%finish()
  end subroutine simulation_finish

  !> Tells whether the run has reached its end time or its number of steps.
  pure logical function is_done(self)
    class(simulation_t), intent(in) :: self
    associate (p => self%settings%fluid, state => self%fluid%rhs%state)
      is_done = state%time >= p%time%t_max .or. state%step >= p%time%nt
    end associate
  end function is_done

  !> Writes the integrals, series and fields that are due.
  subroutine write_all(self)
    type(simulation_t), intent(inout) :: self
    call self%timers%start(self%t_output)
    if (self%output%integrals_due) &
      call self%series%write_integrals(self%fluid, self%outcome%failure, self%wings, self%coupler)
    call self%series%write_pass(self%fluid, self%wings)
    call self%output%write(self%fluid, self%outcome%failure, self%wings, self%coupler, self%averages)
    call self%timers%stop(self%t_output)
  end subroutine write_all

  !> Restores the state from the named checkpoint or the newest valid one.
  subroutine restart(self, start, remarks)
    class(simulation_t), intent(inout) :: self
    type(simulation_start_t), intent(in) :: start
    type(message_list_t), intent(inout) :: remarks
    character(:), allocatable :: path
    path = start%restart_file
    ! --restart continues from the newest backup, even if the run itself began from a named one.
    if (.not. start%restart .and. len(path) == 0) path = self%settings%fluid%initial%backup()
    if (path == '') call self%slots%must_find(path, self%outcome%failure)
    if (self%outcome%failure%failed) return
    call restore_state(self%world, path, self%settings, self%files, start%accepts, self%run_parts_t, remarks, &
                       self%outcome%failure)
    call self%slots%came_from(path)
  end subroutine restart

  !> Writes the next of the two alternating checkpoints, if an evaluation shows that the last step is valid.
  subroutine back_up(self)
    class(simulation_t), intent(inout) :: self
    type(checkpoint_writer_t) :: writer
    type(request_t) :: nothing
    logical :: written
    if (self%outcome%failure%failed .or. self%fluid%rhs%state%step == 0) return
    call self%timers%start(self%t_backup)
    call self%fluid%evaluate(nothing, self%outcome%failure, self%wings)
    call self%series%write_slip(self%fluid, self%thin)
    call self%outcome%classify(OUTCOME_DIVERGED)
    call self%output%flush(self%fluid, self%outcome%failure)
    if (self%outcome%kind /= OUTCOME_DIVERGED) then
      call self%slots%begin(writer, self%outcome%failure)
      call put_state(writer, self%settings, self%run_parts_t, .true.)
      call self%slots%commit(writer, self%outcome%failure)
      ! A restart must plan as this run did, or it would differ in the last bits.
      if (self%world%is_root .and. self%settings%fluid%resolution%planner == PLAN_MEASURE) call export_wisdom(WISDOM_NAME, written)
    end if
    call self%stop_rules%backup_done()
    call self%timers%stop(self%t_backup)
  end subroutine back_up

  !> Writes a checkpoint of a run that failed in a step of its wings: the present flow, and the wings before the step that failed. A
  !> user may continue from it with other parameters. The periodic checkpoints stay as they are. Collective.
  subroutine back_up_failed(self)
    class(simulation_t), intent(inout) :: self
    type(checkpoint_writer_t) :: writer
    type(failure_t) :: writing
    call self%coupler%rewind(self%fluid%rhs%state%time, self%wings)
    call writer%begin(self%world, '.', FAILED_NAME, writing)
    call writer%put_integer('generation', 0_i8)
    call self%files%identity%save(writer)
    call put_state(writer, self%settings, self%run_parts_t, .false.)
    call writer%commit(writing)
    if (writing%failed) then
      self%outcome%failure%reason = self%outcome%failure%reason//'; moreover: '//writing%reason
    else
      self%outcome%failure%reason = self%outcome%failure%reason//'; '//FAILED_NAME//' has the flow, and the wings before this '// &
                                    'step: --restart='//FAILED_NAME//' continues from there, with other parameters'
    end if
  end subroutine back_up_failed

  !> Sets the kind of the failure, unless it has one, and prints the reason.
  subroutine fail(self, kind)
    class(simulation_t), intent(inout) :: self
    integer, intent(in) :: kind
    call self%outcome%classify(kind)
    call print_reason(self)
  end subroutine fail

  !> Prints on root why the run failed.
  subroutine print_reason(self)
    type(simulation_t), intent(in) :: self
    if (self%world%is_root) call print_failure(self%outcome%failure%reason, self%outcome%kind == OUTCOME_DIVERGED, &
      any(self%outcome%kind == [OUTCOME_DIVERGED, OUTCOME_COLLISION, OUTCOME_NOT_CONVERGED]) .and. &
      self%slots%newest_generation() > 0)
  end subroutine print_reason
end module simulation_runner

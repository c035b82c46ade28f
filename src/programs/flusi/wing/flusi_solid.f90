! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs `flusi --solid INI`: it computes the motion of a wing in time without a fluid (see solid_dynamics), on one rank.
module flusi_solid
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  use base_errors, only: failure_t, message_list_t
  use base_files, only: folder_of, join_path, name_of
  use base_kinds, only: rp
  use base_outcome, only: outcome_t, OUTCOME_DONE, OUTCOME_MISTAKE, OUTCOME_NOT_CONVERGED, OUTCOME_STOPPED, OUTCOME_UNWRITABLE
  use base_text, only: number_text
  use common_progress, only: progress_t
  use common_run, only: run_t
  use common_wing_doubts, only: print_notices
  use common_wing_report, only: print_wing
  use flusi_command, only: command_t
  use flusi_solid_output, only: solid_output_t
  use flusi_solid_restart, only: load_solid, save_solid
  use flusi_solid_settings, only: load_solid_settings, solid_settings_t
  use flusi_wing_modes, only: find_modes
  use flusi_wing_sites, only: add_force
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use io_checkpoint_slots, only: checkpoint_slots_t
  use io_identity, only: identity_t
  use io_stop, only: stop_rules_t
  use parallel_world, only: world_t
  use solid_balance, only: balance_t, work_t
  use solid_dynamics, only: dynamic_state_t, dynamics_t, step_report_t
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_statics, only: solve_static, static_options_t, static_report_t
  implicit none
  private
  public :: check_solid, run_solid

  real(rp), parameter :: PART = 1.0e-6_rp !< fraction of a step: times closer than this are equal
  !> Holds one run.
  type :: solid_run_t
    type(world_t) :: world
    type(solid_settings_t) :: settings
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(balance_t) :: balance
    type(work_t) :: work
    type(step_report_t) :: report
    type(solid_output_t) :: output
    type(checkpoint_slots_t) :: slots
    type(run_t) :: files                 !< files of this run, locked against other runs
    type(stop_rules_t) :: stop_rules
    type(progress_t) :: progress
    real(rp), allocatable :: force(:, :) !< (3, n_all) [N] external forces at the time of the state
    integer :: step = 0
    logical :: is_open = .false.         !< output files are open
    type(outcome_t) :: outcome           !< its failure means that files could not be used
  contains
    procedure :: start => run_start
    procedure :: advance => run_advance
    procedure :: is_done => run_is_done
    procedure :: back_up => run_back_up
  end type solid_run_t

contains

  !> Reads the input. Prints the mistakes, if there are any; `outcome` then says so.
  subroutine read_settings(command, settings, is_check, outcome)
    type(command_t), intent(in) :: command
    type(solid_settings_t), intent(out) :: settings
    logical, intent(in) :: is_check
    type(outcome_t), intent(inout) :: outcome
    type(message_list_t) :: errors, notices
    call load_solid_settings(command%ini, command%flusi_compat, settings, errors, notices)
    if (errors%count() > 0) then
      call errors%print(error_unit, '')
      call outcome%end_as(OUTCOME_MISTAKE)
    else
      call print_notices(notices, is_check)
    end if
  end subroutine read_settings

  !> Prints the values of all keys, given or default. If the input has mistakes, it prints the mistakes instead.
  subroutine check_solid(command, outcome)
    type(command_t), intent(in) :: command
    type(outcome_t), intent(inout) :: outcome
    type(solid_settings_t) :: settings
    call read_settings(command, settings, .true., outcome)
    if (outcome%is_good()) call settings%config%print_effective(output_unit)
  end subroutine check_solid

  !> Runs `flusi --solid` to its end and releases its files; `outcome` tells how the run ended. It refuses to run on more than
  !> one rank. Collective.
  subroutine run_solid(command, world, outcome)
    type(command_t), intent(in) :: command
    type(world_t), intent(in) :: world
    type(outcome_t), intent(inout) :: outcome
    type(solid_run_t) :: run
    logical :: started
    if (world%size > 1) then
      if (world%is_root) write (error_unit, '(a)') 'flusi: --solid runs on one rank, not on '//number_text(world%size)// &
        ': start flusi without mpirun'
      call outcome%end_as(OUTCOME_MISTAKE)
      return
    end if
    run%world = world
    call read_settings(command, run%settings, .false., outcome)
    if (.not. outcome%is_good()) return
    call print_wing(output_unit, 'variable-step BDF2 in the frame of the wing', run%settings%wing_case)
    call run%start(command, started)
    if (started) call advance_all(run)
    if (run%is_open) call run%output%close(run%outcome%failure)
    call run%stepper%free()
    call run%files%finish()
    if (run%outcome%failure%failed) write (error_unit, '(a)') 'flusi: '//run%outcome%failure%reason
    if (run%outcome%kind /= OUTCOME_NOT_CONVERGED) call run%outcome%classify(OUTCOME_UNWRITABLE)
    outcome = run%outcome
  end subroutine run_solid

  !> Sets or restores the state at the beginning and opens all files.
  subroutine run_start(self, command, started)
    class(solid_run_t), intent(inout) :: self
    type(command_t), intent(in) :: command
    logical, intent(out) :: started
    type(failure_t) :: problem
    type(message_list_t) :: patterns, remarks
    started = .false.
    call result_names(self%settings%name, patterns)
    call self%files%begin(self%world, 'flusi --solid', self%settings%name, command%ini, self%settings%config, self%outcome)
    if (.not. command%restart) call self%files%check_new(command%overwrite, patterns, self%outcome)
    if (self%outcome%failure%failed) return
    associate (s => self%settings, model => self%settings%wing_case%model)
      allocate (self%force(3, model%n_all), source=0.0_rp)
      call self%stepper%init(model)
      call self%balance%init(model)
      call self%stop_rules%init(s%output%limits)
      if (command%restart) call self%slots%scan(self%world, folder_of(s%name), name_of(s%name)//'_backup')
      call self%state%init(model, 0.0_rp)
      if (command%restart) then
        call restart(self, command, remarks, problem)
      else
        call set_initial_shape(self, problem)
      end if
      if (problem%failed) then
        call self%outcome%fail(merge(OUTCOME_MISTAKE, OUTCOME_NOT_CONVERGED, command%restart), problem%reason)
        return
      end if
      call self%files%settle(self%outcome)
      if (self%outcome%failure%failed) return
      if (.not. command%restart) call self%slots%scan(self%world, folder_of(s%name), name_of(s%name)//'_backup')
      call self%slots%identify(self%files%identity)
      call remarks%print(output_unit, '')
      call self%stop_rules%listen(self%world)
      call self%output%open(self%world, s, self%state, command%restart, self%outcome%failure)
      self%is_open = .true.
      if (self%outcome%failure%failed) return
      call self%progress%init(.true., s%output%progress_seconds, 'largest/R')
      if (.not. command%restart) then
        self%work%start = model%energy(self%state%u)
        call self%output%record(s, s%motion%at(0.0_rp), self%state, self%work, self%report)
        call self%output%save(s, s%motion%at(0.0_rp), self%state, self%outcome%failure)
      end if
      started = .not. self%outcome%failure%failed
    end associate
  end subroutine run_start

  !> Adds to `patterns` the names of the files of a run called `name` (see matches_name).
  subroutine result_names(name, patterns)
    character(*), intent(in) :: name
    type(message_list_t), intent(inout) :: patterns
    call patterns%add(name//'.t')
    call patterns%add(name//'.xmf')
    call patterns%add(name//'_#.h5')
  end subroutine result_names

  !> Sets the shape at the beginning, at rest in the frame of the wing: unloaded, bent by forces, or in a natural mode.
  subroutine set_initial_shape(self, problem)
    type(solid_run_t), intent(inout) :: self
    type(failure_t), intent(inout) :: problem
    type(equilibrium_t) :: solver
    type(load_t) :: load
    type(static_options_t) :: options
    type(static_report_t) :: report
    real(rp), allocatable :: u(:, :), frequencies(:), shapes(:, :, :)
    integer :: i
    associate (s => self%settings, model => self%settings%wing_case%model)
      allocate (u(3, model%n_all), source=0.0_rp)
      if (size(s%released) > 0) then
        call load%init(model)
        do i = 1, size(s%released)
          call add_force(s%released(i), 1.0_rp, load%force)
        end do
        call solver%init(model)
        call solve_static(solver, model, load, .false., options, u, report)
        call solver%free()
        if (report%converged) then
          write (output_unit, '(a,f0.4,a)') 'released  from a bent shape, largest displacement ', &
            1000*sqrt(maxval(sum(u(:, :model%n_points)**2, 1))), ' mm'
        else
          call problem%raise('the equilibrium from which the wing is released was not found: '//report%reason)
        end if
      else if (s%mode > 0) then
        allocate (frequencies(s%mode), shapes(3, model%n_all, s%mode))
        call find_modes(s%wing_case, frequencies, shapes, problem)
        if (.not. problem%failed) then
          u = s%amplitude*shapes(:, :, s%mode)
          write (output_unit, '(a,i0,a,f0.4,a)') 'mode      ', s%mode, ' of the unloaded wing: ', &
            frequencies(s%mode), ' Hz'
        end if
      end if
      call self%state%init(model, 0.0_rp, u=u)
    end associate
  end subroutine set_initial_shape

  !> Restores the state from the named checkpoint or the newest valid one.
  subroutine restart(self, command, remarks, problem)
    type(solid_run_t), intent(inout) :: self
    type(command_t), intent(in) :: command
    type(message_list_t), intent(inout) :: remarks
    type(failure_t), intent(inout) :: problem
    type(checkpoint_reader_t) :: reader
    type(identity_t) :: was
    type(message_list_t) :: none
    character(:), allocatable :: path
    path = command%restart_file
    if (path == '') then
      call self%slots%must_find(path, problem)
      if (problem%failed) return
      path = join_path(folder_of(self%settings%name), path)
    end if
    call reader%open(self%world, path, problem)
    if (problem%failed) return
    call load_solid(reader, self%settings%wing_case%model, self%settings%is_mirrored, self%state, self%step, self%work, &
                    problem)
    call was%load(reader, problem)
    call self%files%judge(was, none, command%accepts, remarks, problem)
    call reader%close(problem)
    call self%slots%came_from(path)
    if (.not. problem%failed) write (output_unit, '(a,es16.9,a)') 'restart   at t = ', self%state%time, ' s from '//path
  end subroutine restart

  !> Steps until the run ends or something asks it to stop.
  subroutine advance_all(run)
    type(solid_run_t), intent(inout) :: run
    real(rp) :: seconds
    logical :: has_failed, has_moved
    has_failed = .false.
    has_moved = .false.
    associate (s => run%settings, state => run%state)
      do while (.not. run%is_done())
        call run%advance()
        has_failed = .not. run%report%converged
        if (has_failed) exit
        has_moved = .true.
        call run%progress%step_done(run%step, state%time, s%dt, run%output%largest/s%wing_case%model%size, s%t_max, &
                                    huge(1), seconds)
        call run%stop_rules%poll(run%world)
        if (run%stop_rules%backup_due .and. s%output%backup .and. .not. run%is_done()) call run%back_up()
        if (run%stop_rules%must_stop .or. run%outcome%failure%failed) exit
      end do
      call run%progress%finish()
      if (run%outcome%failure%failed) return
      if (has_failed) then
        call run%outcome%end_as(OUTCOME_NOT_CONVERGED)
        write (error_unit, '(a,es16.9,a)') 'flusi: the step from t = ', state%time, ' s failed: '//run%report%reason
      else if (.not. run%is_done()) then
        call run%outcome%end_as(OUTCOME_STOPPED)
      end if
      if (has_moved .and. run%outcome%kind /= OUTCOME_STOPPED) &
        call run%output%save(s, s%motion%at(state%time), state, run%outcome%failure)
      if (has_moved .and. (s%output%backup .or. run%outcome%kind /= OUTCOME_DONE)) call run%back_up()
      if (run%outcome%failure%failed) return
      select case (run%outcome%kind)
      case (OUTCOME_DONE)
        write (output_unit, '(a,i0,a)') 'done: ', run%step, ' steps; '//s%name//'.t has the time series, '// &
          s%name//'.xmf the shapes for ParaView'
      case (OUTCOME_STOPPED)
        write (output_unit, '(a)') 'stopped early: '//trim(run%stop_rules%reason)// &
          '; the backup is written; continue with --restart'
      case default
        if (run%step > 0) write (error_unit, '(a)') 'flusi: the last good state is in the newest backup and the '// &
          'last shape'
      end select
    end associate
  end subroutine advance_all

  !> Makes one step, and writes its record and the shape if they are due.
  subroutine run_advance(self)
    class(solid_run_t), intent(inout) :: self
    real(rp) :: h, before
    associate (s => self%settings, state => self%state, model => self%settings%wing_case%model)
      h = s%dt
      ! The last step is shorter if the end time is not a multiple of dt.
      if (s%t_max - state%time < (1 - PART)*s%dt) h = s%t_max - state%time
      before = state%time
      call s%loads%at(before, self%force)
      call self%balance%record(model, s%inertia, s%motion%at(before), state, self%force)
      call s%loads%at(before + h, self%force)
      call self%stepper%step(model, s%inertia, s%motion, self%force, h, s%options, state, self%report)
      if (.not. self%report%converged) return
      self%step = self%step + 1
      call self%balance%add_step(model, s%inertia, s%motion%at(state%time), state, self%force, h, self%work)
      if (mod(self%step, s%series_every) == 0 .or. self%is_done()) &
        call self%output%record(s, s%motion%at(state%time), state, self%work, self%report)
      if (self%output%is_due(s, state%time) .and. .not. self%is_done()) &
        call self%output%save(s, s%motion%at(state%time), state, self%outcome%failure)
    end associate
  end subroutine run_advance

  !> Tells whether the run has reached its end.
  pure logical function run_is_done(self) result(is_done)
    class(solid_run_t), intent(in) :: self
    is_done = self%state%time > self%settings%t_max - PART*self%settings%dt
  end function run_is_done

  !> Writes the next of the two alternating checkpoints.
  subroutine run_back_up(self)
    class(solid_run_t), intent(inout) :: self
    type(checkpoint_writer_t) :: writer
    if (self%outcome%failure%failed .or. self%step == 0) return
    call self%slots%begin(writer, self%outcome%failure)
    call save_solid(writer, self%settings%wing_case%model, self%settings%is_mirrored, self%state, self%step, self%work)
    call self%slots%commit(writer, self%outcome%failure)
    call self%stop_rules%backup_done()
  end subroutine run_back_up
end module flusi_solid

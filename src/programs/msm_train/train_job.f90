! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs a training from beginning to end: it searches, polishes the result by least squares, and writes files. Rank 0 leads; all
!> ranks solve.
module train_job
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_errors, only: failure_t, message_list_t, require
  use base_kinds, only: rp
  use base_named_kinds, only: word_of
  use base_outcome, only: outcome_t, OUTCOME_DONE, OUTCOME_MISTAKE, OUTCOME_NOT_CONVERGED, OUTCOME_STOPPED, OUTCOME_UNWRITABLE
  use base_text, only: number_text
  use cmaes_options, only: WEIGHTINGS
  use common_run, only: run_t
  use common_wing_report, only: print_wing
  use io_earlier_results, only: move_earlier_file, EARLIER_SUFFIX
  use io_identity, only: identity_t
  use measurement_bending_pool, only: bending_pool_t
  use measurement_bending_runner, only: bending_runner_t
  use measurement_observed_wing, only: observed_wing_t
  use parallel_outcome, only: agree_on_outcome
  use parallel_world, only: world_t
  use train_command, only: train_command_t, TRAIN_RUN, TRAIN_SCREEN
  use train_evaluation, only: evaluate_wing, print_loads
  use train_log, only: train_log_t
  use train_output, only: outcome_lines, write_fragment, write_history
  use train_screening, only: prepare_screen, screen_wing
  use train_settings, only: load_train_settings, train_settings_t
  use training_outcome, only: trained_t
  use training_polish, only: polish_points
  use training_search, only: train_search_t
  implicit none
  private
  public :: training_t

  type :: training_t
    type(world_t) :: world
    type(train_settings_t) :: settings
    type(bending_pool_t) :: pool
    type(train_search_t) :: search
    type(train_log_t) :: log
    type(run_t) :: files        !< that rank 0 writes; the lock keeps other runs away from them
    type(trained_t) :: trained  !< on rank 0, once `has_outcome`
    logical :: has_outcome = .false.
    type(outcome_t) :: outcome  !< of the program; its failure means that files could not be used
  contains
    procedure :: load => training_load
    procedure :: begin => training_begin
    procedure :: lead => training_lead
    procedure :: evaluate => training_evaluate
    procedure :: finish => training_finish
  end type training_t

contains

  !> Reads the input of individual `number`. Mistakes are printed, and the kind of `outcome` then says that the input is not
  !> valid. Collective.
  subroutine training_load(self, command, number, world)
    class(training_t), intent(inout) :: self
    type(train_command_t), intent(in) :: command
    integer, intent(in) :: number
    type(world_t), intent(in) :: world
    type(message_list_t) :: errors, ignored
    self%world = world
    call load_train_settings(command%ini, number, command%action == TRAIN_RUN, world, self%settings, errors, ignored)
    if (errors%count() > 0) call self%outcome%end_as(OUTCOME_MISTAKE)
    if (world%is_root) call errors%print(error_unit, '')
    flush (error_unit)
    call agree_on_outcome(world, self%outcome)
  end subroutine training_load

  !> Makes all ranks ready to take tasks. Collective.
  subroutine training_begin(self, command)
    class(training_t), intent(inout), target :: self
    type(train_command_t), intent(in) :: command
    class(observed_wing_t), allocatable :: wing
    class(bending_runner_t), allocatable :: runner
    type(failure_t) :: failure
    if (command%action == TRAIN_SCREEN) call prepare_screen(self%settings, failure)
    call require(.not. failure%failed, 'training_begin: the model of the settings')
    allocate (wing, runner)
    call wing%take_experiment(self%settings%experiment)
    call runner%init(wing)
    call self%pool%init(self%world, runner, self%settings%limits)
    if (self%world%is_root) &
      call print_wing(output_unit, what(), self%settings%wing_case)

  contains

    function what() result(text)
      character(:), allocatable :: text
      text = 'every load from the unloaded wing'
      if (command%action /= TRAIN_RUN) return
      text = 'training by CMA-ES'
      if (self%settings%polish) text = text//' and least squares'
    end function what
  end subroutine training_begin

  !> Searches, polishes and writes the results. Only rank 0 calls it.
  subroutine training_lead(self, command)
    class(training_t), intent(inout), target :: self
    type(train_command_t), intent(in) :: command
    logical :: has_best
    call open_files(self, command)
    if (self%outcome%failure%failed) return
    call self%pool%runner%stop_rules%listen(self%world)
    call tell_what(self)
    if (.not. self%search%is_done) call self%search%choose_start(self%settings, self%pool, self%log)
    call search_and_polish(self, has_best)
    if (take_failure(self)) return
    if (.not. (has_best .or. self%pool%is_stopped)) then
      call self%outcome%end_as(OUTCOME_NOT_CONVERGED)
      call self%log%say('failed    no candidate was feasible: check the bounds of parameters and the forces')
      return
    end if
    if (self%pool%is_stopped) then
      call self%outcome%end_as(OUTCOME_STOPPED)
      call self%pool%poll()
      call self%log%say('stopped early: '//trim(self%pool%runner%stop_rules%reason)// &
                        '; the backup is written; continue with --restart')
      return
    end if
    call tell_outcome(self, self%trained)
  end subroutine training_lead

  !> Searches, then fits by least squares from where the search ended. If a search was short and least squares found no minimum
  !> from there, the search goes on. `has_best` is false if no candidate was feasible. The work is incomplete if the pool is
  !> stopped or files failed.
  subroutine search_and_polish(self, has_best)
    class(training_t), intent(inout), target :: self
    logical, intent(out) :: has_best
    real(rp), allocatable :: u(:), starts(:, :)
    real(rp) :: cost
    has_best = .false.
    do
      call self%search%run(self%settings, self%pool, self%log)
      if (self%search%failure%failed) return
      call write_history(self%settings, self%search%space, self%search%history, self%outcome%failure)
      if (self%pool%is_stopped) return
      call tell_effort(self)
      call self%search%best(has_best, cost, u)
      if (.not. has_best) return
      call self%log%say('search    best cost '//number_text(cost))
      call self%search%starts(self%settings, u, starts)
      call polish_points(self%settings, self%pool, self%search, starts, self%log, self%trained)
      if (self%search%failure%failed) return
      if (self%pool%is_stopped .or. .not. self%settings%search_is_short) return
      if (self%trained%is_polished .and. self%trained%is_solved) return
      call self%log%say('search    continues, because least squares found no minimum from its end')
      self%settings%search_is_short = .false.
      self%search%is_done = .false.
    end do
  end subroutine search_and_polish

  !> Locks the files, restores the search if asked to, and moves earlier results out of the way, so that none of them looks like
  !> the result of this run. Only rank 0 calls it.
  subroutine open_files(self, command)
    class(training_t), intent(inout), target :: self
    type(train_command_t), intent(in) :: command
    type(world_t) :: alone
    type(message_list_t) :: patterns
    logical :: has_moved
    call alone%isolate()
    associate (s => self%settings)
      call self%files%begin(alone, 'msm_train', s%name, command%ini, s%config, self%outcome)
      call patterns%add(s%name//'.log')
      call patterns%add(s%name//'_history.h5')
      call patterns%add(s%result)
      if (.not. command%restart) then
        call self%files%check_new(command%overwrite, patterns, self%outcome)
        call self%files%settle(self%outcome)
      end if
      if (self%outcome%failure%failed) return
      call self%log%open(.true., s%name//'.log', command%restart, s%choices%progress_seconds, &
                         self%outcome%failure)
      if (self%outcome%failure%failed) return
      call self%search%init(s, self%pool)
      if (command%restart .and. s%n_individuals > 1 .and. .not. self%search%has_backup()) then
        call self%log%say('restart   there is no backup of '//s%individual//': the training starts from the beginning')
      else if (command%restart) then
        call restore(self, command)
      end if
      call self%files%settle(self%outcome)
      if (self%outcome%failure%failed) return
      self%search%identity = self%files%identity
      call move_earlier_file(s%result, has_moved, self%outcome%failure)
      if (has_moved) call self%log%say('notice: '//s%result//' of an earlier training was renamed to '//s%result//EARLIER_SUFFIX)
    end associate
  end subroutine open_files

  !> Continues from a checkpoint, and tells which inputs differ from those of the checkpoint.
  subroutine restore(self, command)
    class(training_t), intent(inout), target :: self
    type(train_command_t), intent(in) :: command
    type(identity_t) :: was
    type(message_list_t) :: none, remarks
    type(failure_t) :: judged
    integer :: i
    call self%search%restore(self%settings, command%restart_file, self%log, was, self%outcome%failure)
    call self%files%judge(was, none, command%accepts, remarks, judged)
    if (judged%failed) call self%outcome%failure%raise(judged%reason)
    call self%outcome%classify(OUTCOME_MISTAKE)
    do i = 1, remarks%count()
      if (self%outcome%failure%failed .and. was%is_known()) then
        self%outcome%failure%reason = self%outcome%failure%reason//new_line('a')//'  '//remarks%text(i)
      else if (.not. self%outcome%failure%failed) then
        call self%log%say(remarks%text(i))
      end if
    end do
  end subroutine restore

  !> Tells whether files could not be used during the search. The failure then becomes that of the outcome, and the training ends.
  logical function take_failure(self) result(failed)
    class(training_t), intent(inout) :: self
    failed = self%search%failure%failed
    if (failed) self%outcome%failure = self%search%failure
  end function take_failure

  !> Writes to the log what is compared, which parameters are free, and how the search works.
  subroutine tell_what(self)
    class(training_t), intent(inout) :: self
    integer :: i
    associate (s => self%settings, e => self%settings%experiment, space => self%search%space)
      call self%log%say('data      '//s%measurement_path//': '//number_text(size(e%loads))//' loads, '// &
                        number_text(e%count_residuals(0))//' residuals')
      do i = 1, size(space%names)
        call self%log%say('free      '//trim(space%names(i))//' from '//number_text(space%box%lower(i))//' to '// &
                          number_text(space%box%upper(i))//' '//trim(space%units(i))// &
                          trim(merge(', logarithmic', ', linear     ', space%box%is_log(i))))
      end do
      call self%log%say('search    CMA-ES, '//number_text(self%search%search%run%params%lambda)// &
                        ' candidates, weights '//word_of(WEIGHTINGS, s%search%weights)//', seed '//number_text(int(s%search%seed)))
    end associate
  end subroutine tell_what

  !> Writes to the log how many equilibria were solved and how long that took.
  subroutine tell_effort(self)
    class(training_t), intent(inout) :: self
    character(200) :: line
    associate (o => self%search%objective, pool => self%pool)
      write (line, '(5(a,i0),a,f8.1,a)') 'solved    ', o%counts%n_warm, ' from the shape of the mean, ', o%counts%n_cold, &
        ' from the unloaded wing; ', o%counts%n_redone, ' repeated from it, ', o%counts%n_unsolved, ' unsolved; ', &
        o%counts%n_factorisations, ' factorisations; ', pool%busy_seconds, ' s of all ranks in this run'
      call self%log%say(trim(line))
    end associate
  end subroutine tell_effort

  !> Prints the outcome and writes the files.
  subroutine tell_outcome(self, trained)
    class(training_t), intent(inout) :: self
    type(trained_t), intent(in) :: trained
    character(:), allocatable :: text
    character(120) :: line
    integer :: first, last, l
    call self%log%end_line()
    call print_loads(output_unit, self%settings%experiment, trained%evaluations)
    do l = 1, size(trained%evaluations)
      if (trained%evaluations(l)%snaps > 0) &
        call self%log%say('warning   the wing snaps under '//self%settings%experiment%measurement%loads(l)%name// &
                          ': the cost may jump there, and is hard to minimise; apply a smaller force, or leave this load out')
    end do
    text = outcome_lines(self%settings, self%search%space, trained, '')
    first = 1
    do while (first <= len(text))
      last = first + index(text(first:), new_line('a')) - 2
      call self%log%say(text(first:last))
      first = last + 2
    end do
    if (.not. trained%is_solved) then
      call self%outcome%end_as(OUTCOME_NOT_CONVERGED)
      call self%log%say('failed    at the final point, some load has no solution from the unloaded wing, or the point '// &
                        'lies in an excluded zone: start again with other bounds or another seed')
      return
    end if
    write (line, '(a,es9.2,a)') 'at the final point, solutions from the unloaded wing and from an earlier shape differ by '// &
      'at most ', trained%cold_difference, ' m'
    call self%log%say(trim(line))
    call self%log%say('evaluations '//number_text(int(self%search%evaluations()) + trained%n_evaluations)// &
                      ' in all')
    self%has_outcome = .true.
    if (trained%has_failed_polish()) call self%outcome%end_as(OUTCOME_NOT_CONVERGED)
    call write_fragment(self%settings, self%search%space, trained, self%outcome%failure)
    call write_history(self%settings, self%search%space, self%search%history, self%outcome%failure, trained)
    if (.not. self%outcome%failure%failed) call self%log%say('done: '//self%settings%result//' has the trained wing, for '// &
                                                     '[include]; '//self%settings%name//'_history.h5 has the search')
  end subroutine tell_outcome

  !> Prints the cost of the wing with its given values, or the screening of its parameters. If the program is stopped before all
  !> loads are solved, this does not count as a failure of the wing. Only rank 0 calls it.
  subroutine training_evaluate(self, command)
    class(training_t), intent(inout) :: self
    type(train_command_t), intent(in) :: command
    logical :: are_solved
    if (command%action == TRAIN_SCREEN) then
      call screen_wing(self%settings, self%pool, are_solved)
    else
      call evaluate_wing(self%settings, self%pool, are_solved)
    end if
    if (self%pool%is_stopped) then
      call self%outcome%end_as(OUTCOME_STOPPED)
      call self%pool%poll()
      write (output_unit, '(a)') 'stopped early: '//trim(self%pool%runner%stop_rules%reason)//'; not all loads were solved'
      flush (output_unit)
    else if (.not. are_solved) then
      call self%outcome%end_as(OUTCOME_NOT_CONVERGED)
    end if
  end subroutine training_evaluate

  !> Ends the work of all ranks. The kind of `outcome` is then the same on all ranks. Collective.
  subroutine training_finish(self)
    class(training_t), intent(inout) :: self
    call self%log%close()
    call self%files%finish()
    if (self%outcome%failure%failed) then
      write (error_unit, '(a)') 'msm_train: '//self%outcome%failure%reason
      if (self%outcome%kind == OUTCOME_DONE) call self%outcome%classify(OUTCOME_UNWRITABLE)
    end if
    flush (error_unit)
    call self%pool%free()
    call agree_on_outcome(self%world, self%outcome)
  end subroutine training_finish
end module train_job

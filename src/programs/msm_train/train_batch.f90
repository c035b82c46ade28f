! SPDX-License-Identifier: GPL-3.0-or-later
!> Carries out what the command line of `msm_train` asks for, for one individual after another. It checks all inputs before it
!> begins the first individual. If one individual cannot be trained, it continues with the others.
module train_batch
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_outcome, only: outcome_t, OUTCOME_DONE, OUTCOME_MISTAKE, OUTCOME_STOPPED, OUTCOME_UNWRITABLE
  use base_process, only: wall_seconds
  use base_text, only: number_text
  use common_wing_doubts, only: print_notices
  use parallel_outcome, only: agree_on_outcome
  use parallel_world, only: world_t
  use train_command, only: train_command_t, TRAIN_CHECK, TRAIN_RUN
  use train_job, only: training_t
  use train_settings, only: load_train_settings, train_settings_t
  use train_summary, only: summary_t
  implicit none
  private
  public :: train_individuals

contains

  !> Carries out `command` for every individual. A stop or files that cannot be written end the work at once. `outcome` is that of
  !> the first individual whose training did not reach its end, or OUTCOME_DONE if all did; its kind is the same on all ranks.
  !> Collective.
  subroutine train_individuals(command, world, outcome)
    type(train_command_t), intent(in) :: command
    type(world_t), intent(in) :: world
    type(outcome_t), intent(inout) :: outcome
    type(outcome_t) :: outcome_of_one
    type(summary_t) :: summary
    type(failure_t) :: failure
    integer :: i, n_individuals
    real(rp) :: begun
    begun = wall_seconds()
    call check_all(command, world, n_individuals, outcome)
    if (outcome%kind /= OUTCOME_DONE .or. command%action == TRAIN_CHECK) return
    do i = 1, n_individuals
      call train_one(command, world, i, wall_seconds() - begun, summary, outcome_of_one)
      if (outcome%kind == OUTCOME_DONE) outcome = outcome_of_one
      if (any(outcome_of_one%kind == [OUTCOME_STOPPED, OUTCOME_UNWRITABLE])) return
    end do
    if (world%is_root .and. command%action == TRAIN_RUN .and. n_individuals > 1) call summary%write(failure)
    if (failure%failed) then
      write (error_unit, '(a)') 'msm_train: '//failure%reason
      flush (error_unit)
      outcome%kind = OUTCOME_UNWRITABLE
    end if
    call agree_on_outcome(world, outcome)
  end subroutine train_individuals

  !> Finds the mistakes in the inputs of all individuals, prints each once, and prints what --check asks for. Collective.
  subroutine check_all(command, world, n_individuals, outcome)
    type(train_command_t), intent(in) :: command
    type(world_t), intent(in) :: world
    integer, intent(out) :: n_individuals
    type(outcome_t), intent(inout) :: outcome
    type(train_settings_t) :: settings
    type(message_list_t) :: errors, notices
    integer :: i
    logical :: is_check
    is_check = command%action == TRAIN_CHECK
    n_individuals = 1
    i = 1
    do while (i <= n_individuals)
      call add_new_messages(i)
      n_individuals = settings%n_individuals
      i = i + 1
    end do
    if (n_individuals > 1 .and. command%restart_file /= '') &
      call errors%add('--restart=FILE is valid for one individual only; --restart takes the newest backup of each')
    if (errors%count() > 0) call outcome%end_as(OUTCOME_MISTAKE)
    call agree_on_outcome(world, outcome)
    if (world%is_root .and. outcome%kind /= OUTCOME_DONE) then
      call errors%print(error_unit, '')
    else if (world%is_root) then
      call print_notices(notices, is_check)
      if (is_check) call settings%config%print_effective(output_unit)
    end if
    flush (error_unit)

  contains

    !> Adds the messages of individual `number` that are not in the list yet; most of the input is common to all individuals.
    subroutine add_new_messages(number)
      integer, intent(in) :: number
      type(message_list_t) :: own_errors, own_notices
      call load_train_settings(command%ini, number, any(command%action == [TRAIN_RUN, TRAIN_CHECK]), world, settings, &
                               own_errors, own_notices)
      call add_new(errors, own_errors)
      call add_new(notices, own_notices)
    end subroutine add_new_messages
  end subroutine check_all

  !> Adds the messages of `more` that `all` does not have yet.
  subroutine add_new(all, more)
    type(message_list_t), intent(inout) :: all
    type(message_list_t), intent(in) :: more
    integer :: i, k
    logical :: is_known
    do i = 1, more%count()
      is_known = .false.
      do k = 1, all%count()
        is_known = is_known .or. all%text(k) == more%text(i)
      end do
      if (.not. is_known) call all%add(more%text(i))
    end do
  end subroutine add_new

  !> Trains one individual, from reading its input to writing its files. `spent` [s] is the wall time that has passed since the
  !> program began to train. Collective.
  subroutine train_one(command, world, number, spent, summary, outcome)
    type(train_command_t), intent(in) :: command
    type(world_t), intent(in) :: world
    integer, intent(in) :: number
    real(rp), intent(in) :: spent
    type(summary_t), intent(inout) :: summary
    type(outcome_t), intent(out) :: outcome
    type(training_t), target :: training
    call training%load(command, number, world)
    outcome = training%outcome
    if (outcome%kind /= OUTCOME_DONE) return
    associate (s => training%settings)
      s%limits%stop_seconds = max(0.0_rp, s%limits%stop_seconds - spent)
      if (world%is_root .and. s%n_individuals > 1) then
        write (output_unit, '(a)') '', 'individual '//s%individual//', '//number_text(number)//' of '// &
          number_text(s%n_individuals)
        flush (output_unit)
      end if
    end associate
    call training%begin(command)
    if (world%is_root) then
      if (command%action == TRAIN_RUN) call training%lead(command)
      if (command%action /= TRAIN_RUN) call training%evaluate(command)
      call training%pool%shut_down()
    else
      call training%pool%serve()
    end if
    call training%finish()
    outcome = training%outcome
    if (world%is_root .and. command%action == TRAIN_RUN) &
      call summary%add(training%settings, training%search%space, training%trained, training%has_outcome)
  end subroutine train_one
end module train_batch

! SPDX-License-Identifier: GPL-3.0-or-later
!> msm_train finds the stiffness of a wing from bending tests.
program msm_train
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  use base_errors, only: message_list_t
  use base_outcome, only: exit_code_of, outcome_t, OUTCOME_DONE, OUTCOME_MISTAKE
  use base_process, only: exit_with, launched_rank
  use common_train_keys, only: write_train_reference
  use common_version, only: print_version
  use parallel_world, only: world_t
  use train_batch, only: train_individuals
  use train_command, only: parse_train_command, print_train_usage, train_command_t, TRAIN_HELP, &
                           TRAIN_PARAMETERS, TRAIN_VERSION
  implicit none
  type(train_command_t) :: command
  type(message_list_t) :: errors
  type(world_t) :: world
  type(outcome_t) :: outcome

  call parse_train_command(command, errors)
  ! Actions without MPI print their output once, also if a launcher starts several processes.
  if (errors%count() > 0 .or. any(command%action == [TRAIN_HELP, TRAIN_VERSION, TRAIN_PARAMETERS])) then
    if (launched_rank() > 0) call exit_with(exit_code_of(OUTCOME_DONE))
    select case (merge(0, command%action, errors%count() > 0))
    case (TRAIN_HELP)
      call print_train_usage(output_unit)
    case (TRAIN_VERSION)
      call print_version(output_unit)
    case (TRAIN_PARAMETERS)
      call write_train_reference(output_unit)
    case default
      call errors%print(error_unit, 'msm_train: ')
      call print_train_usage(error_unit)
    end select
    call exit_with(exit_code_of(merge(OUTCOME_MISTAKE, OUTCOME_DONE, errors%count() > 0)))
  end if

  call world%start()
  call train_individuals(command, world, outcome)
  call world%stop()
  call exit_with(outcome%exit_code())
end program msm_train

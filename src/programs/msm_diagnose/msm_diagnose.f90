! SPDX-License-Identifier: GPL-3.0-or-later
!> msm_diagnose finds what the model of a wing gets wrong in its measurements, and why.
program msm_diagnose
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  use base_errors, only: message_list_t
  use base_outcome, only: exit_code_of, OUTCOME_DONE, OUTCOME_MISTAKE
  use base_process, only: exit_with, launched_rank
  use common_diagnose_keys, only: write_diagnose_reference, REFINE_FIT
  use common_version, only: print_version
  use diagnose_causes_reference, only: write_causes_reference
  use diagnose_command, only: diagnose_command_t, parse_diagnose_command, print_diagnose_usage, DIAGNOSE_CAUSES, &
                              DIAGNOSE_CHECK, DIAGNOSE_HELP, DIAGNOSE_PARAMETERS, DIAGNOSE_VERSION
  use diagnose_job, only: diagnose_t
  use parallel_world, only: world_t
  implicit none
  type(diagnose_command_t) :: command
  type(message_list_t) :: errors
  type(diagnose_t), target :: diagnose, finer
  type(diagnose_t), pointer :: job
  type(world_t) :: world
  logical :: is_loaded, wants_finer

  call parse_diagnose_command(command, errors)
  ! Actions without MPI print their output once, also if a launcher starts several processes.
  if (errors%count() > 0 .or. any(command%action == [DIAGNOSE_HELP, DIAGNOSE_VERSION, DIAGNOSE_PARAMETERS, DIAGNOSE_CAUSES])) then
    if (launched_rank() > 0) call exit_with(exit_code_of(OUTCOME_DONE))
    select case (merge(0, command%action, errors%count() > 0))
    case (DIAGNOSE_HELP)
      call print_diagnose_usage(output_unit)
    case (DIAGNOSE_VERSION)
      call print_version(output_unit)
    case (DIAGNOSE_PARAMETERS)
      call write_diagnose_reference(output_unit)
    case (DIAGNOSE_CAUSES)
      call write_causes_reference(output_unit)
    case default
      call errors%print(error_unit, 'msm_diagnose: ')
      call print_diagnose_usage(error_unit)
    end select
    call exit_with(exit_code_of(merge(OUTCOME_MISTAKE, OUTCOME_DONE, errors%count() > 0)))
  end if

  call world%start()
  job => diagnose
  call job%load(command, world)
  if (job%outcome%is_good() .and. command%action == DIAGNOSE_CHECK) then
    if (world%is_root) call job%settings%config%print_effective(output_unit)
  else if (job%outcome%is_good()) then
    call job%begin(command)
    call job%open_files(command)
    call job%compare_meshes(wants_finer)
    is_loaded = .true.
    if (wants_finer) then
      call job%free()
      command%refine = REFINE_FIT
      command%is_again = .true.
      job => finer
      call job%load(command, world)
      is_loaded = job%outcome%is_good() ! the input may have changed
      if (is_loaded) call job%begin(command)
      if (is_loaded) call job%take_files(command, diagnose)
      if (.not. is_loaded) call diagnose%close_files()
    end if
    if (is_loaded) then
      if (world%is_root) then
        call job%lead(command)
        call job%shut_down()
      else
        call job%serve()
      end if
      call job%finish()
    end if
  end if
  call world%stop()
  call exit_with(job%outcome%exit_code())
end program msm_diagnose

! SPDX-License-Identifier: GPL-3.0-or-later
!> flusi simulates incompressible flow around solid bodies. This is its main program.
program flusi
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  use base_errors, only: message_list_t
  use base_outcome, only: exit_code_of, outcome_t, OUTCOME_DONE, OUTCOME_MISTAKE
  use base_process, only: exit_with, launched_rank
  use common_version, only: print_version
  use flusi_command, only: command_t, parse_command_line, print_usage, ACTION_CHECK, ACTION_COMPARE_KEYS, &
                           ACTION_DRY_RUN, ACTION_HELP, ACTION_KEYVALUES, &
                           ACTION_PARAMETERS, ACTION_RUN, ACTION_SOLID, ACTION_SOLID_CHECK, ACTION_STATIC, &
                           ACTION_STATIC_CHECK, ACTION_VERSION
  use flusi_dry_run, only: print_dry_run
  use flusi_parameters, only: read_parameters
  use flusi_postprocess, only: run_keyvalues, run_compare_keys
  use flusi_solid, only: check_solid, run_solid
  use flusi_static, only: run_static
  use parallel_world, only: world_t
  use simulation_keys, only: write_reference
  use simulation_machine, only: check_machine
  use simulation_runner, only: simulation_t
  use simulation_settings, only: settings_t
  use spectral_backends, only: HAS_P3DFFT
  implicit none
  type(command_t) :: command
  type(message_list_t) :: errors
  type(settings_t) :: settings
  type(simulation_t) :: simulation
  type(world_t) :: world
  type(outcome_t) :: outcome
  logical :: needs_mpi

  call parse_command_line(command, errors)
  needs_mpi = errors%count() == 0 .and. any(command%action == [ACTION_RUN, ACTION_DRY_RUN, ACTION_SOLID])
  ! Actions without MPI print their output once, also if a launcher starts several processes.
  if (.not. needs_mpi .and. launched_rank() > 0) call exit_with(exit_code_of(OUTCOME_DONE))
  if (errors%count() > 0) then
    call errors%print(error_unit, 'flusi: ')
    call print_usage(error_unit)
    call exit_with(exit_code_of(OUTCOME_MISTAKE))
  end if

  select case (command%action)
  case (ACTION_HELP)
    call print_usage(output_unit)
  case (ACTION_VERSION)
    call print_version(output_unit, HAS_P3DFFT)
  case (ACTION_PARAMETERS)
    call write_reference(output_unit)
  case (ACTION_KEYVALUES)
    call run_keyvalues(command, outcome)
  case (ACTION_COMPARE_KEYS)
    call run_compare_keys(command, outcome)
  case (ACTION_STATIC, ACTION_STATIC_CHECK)
    call run_static(command, outcome)
  case (ACTION_SOLID_CHECK)
    call check_solid(command, outcome)
  case (ACTION_SOLID)
    call world%start()
    call run_solid(command, world, outcome)
    call world%stop()
  case (ACTION_CHECK)
    call read_parameters(command, settings, outcome)
    if (outcome%is_good()) call settings%config%print_effective(output_unit)
  case default
    call world%start()
    call read_parameters(command, settings, outcome, world)
    if (outcome%is_good() .and. command%action == ACTION_DRY_RUN) then
      call print_dry_run(world, settings)
    else if (outcome%is_good()) then
      call check_machine(world, settings, outcome)
      if (outcome%is_good()) call simulate()
    end if
    call world%stop()
  end select
  call exit_with(outcome%exit_code())

contains

  !> Runs a simulation and keeps its outcome.
  subroutine simulate()
    call simulation%init(world, settings, command%simulation_start_t)
    call simulation%run()
    call simulation%finish()
    outcome = simulation%outcome
  end subroutine simulate
end program flusi

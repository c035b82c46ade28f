! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the parameter file into settings, and prints mistakes and notices.
module flusi_parameters
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  use base_errors, only: message_list_t
  use base_outcome, only: outcome_t, OUTCOME_MISTAKE
  use flusi_command, only: command_t, ACTION_CHECK, ACTION_DRY_RUN
  use io_broadcast_text, only: read_broadcast_text
  use parallel_outcome, only: agree_on_outcome
  use parallel_world, only: world_t
  use simulation_memory, only: memory_t, estimate_memory
  use simulation_settings, only: settings_t, load_settings
  use spectral_backends, only: TRANSFORM_P3DFFT
  use spectral_sticks, only: kept_columns
  implicit none
  private
  public :: read_parameters

contains

  !> Reads and checks the parameter file that `command` names. If `world` is present, root reads it, all ranks get its text, the
  !> number of ranks is checked against the grid, and the call is collective. If there are mistakes, it prints all of them and
  !> sets `outcome` to OUTCOME_MISTAKE. It writes no file.
  subroutine read_parameters(command, settings, outcome, world)
    type(command_t), intent(in) :: command
    type(settings_t), intent(out) :: settings
    type(outcome_t), intent(inout) :: outcome
    type(world_t), intent(in), optional :: world
    type(message_list_t) :: errors, notices
    character(:), allocatable :: text, problem
    logical :: speaks

    speaks = .true.
    if (present(world)) speaks = world%is_root
    call read_broadcast_text(command%ini, text, problem, world)
    if (allocated(problem)) then
      call errors%add(problem)
    else
      call load_settings(text, command%ini, command%flusi_compat, settings, errors, notices, world)
      if (errors%count() == 0 .and. .not. (settings%config%is_given('Time', 'Tmax') .or. settings%fluid%time%has_nt)) &
        call settings%config%complain(notices, 'Time', 'Tmax', 'neither Tmax nor nt is given: nothing but the wall time or '// &
                                      'you will stop the run')
      ! A dry run reports which numbers of ranks are possible.
      if (present(world) .and. errors%count() == 0 .and. command%action /= ACTION_DRY_RUN) &
        call check_ranks(world, settings, errors)
    end if
    if (speaks .and. errors%count() > 0) call errors%print(error_unit, '')
    if (errors%count() > 0) call outcome%end_as(OUTCOME_MISTAKE)
    ! If only some ranks can read a file, all ranks must still take the same decision.
    if (present(world)) call agree_on_outcome(world, outcome)
    if (speaks .and. outcome%kind == OUTCOME_MISTAKE .and. errors%count() == 0) write (error_unit, '(a)') &
      command%ini//': only some ranks can read a file that it names'
    if (speaks .and. outcome%is_good()) &
      call notices%print(merge(error_unit, output_unit, command%action == ACTION_CHECK), 'notice: ')
    flush (error_unit)
  end subroutine read_parameters

  !> Adds an error if the grid cannot be shared among the ranks of this run.
  subroutine check_ranks(world, settings, errors)
    type(world_t), intent(in) :: world
    type(settings_t), intent(in) :: settings
    type(message_list_t), intent(inout) :: errors
    type(memory_t) :: m
    character(140) :: text
    m = estimate_memory(settings, world%size)
    if (m%possible .and. m%largest_buffer <= huge(1)) return
    if (m%possible) then
      write (text, '(a,i0,a)') 'the grid is too large for ', world%size, &
        ' ranks: an exchange buffer would exceed 2^31 '//trim(merge('bytes  ', 'numbers', &
                                                                    settings%fluid%resolution%transform == TRANSFORM_P3DFFT))
    else if (settings%fluid%resolution%transform == TRANSFORM_P3DFFT) then
      write (text, '(2(a,i0))') 'P3DFFT cannot share the grid among ', world%size, ' ranks: columns must not exceed ny and '// &
        'nz, rows must divide the ranks and not exceed ny and ', kept_columns(settings%fluid%grid, &
                                                                              settings%fluid%resolution%dealias)
    else
      write (text, '(a,i0,a)') 'the grid cannot be shared among ', world%size, ' ranks: columns must not exceed nz, rows must '// &
        'divide the ranks and not exceed ny'
    end if
    call settings%config%complain(errors, 'Resolution', 'process_rows', trim(text))
  end subroutine check_ranks
end module flusi_parameters

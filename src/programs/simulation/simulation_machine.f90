! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks whether the machines on which a run starts have the memory that it will need.
module simulation_machine
  use, intrinsic :: iso_fortran_env, only: error_unit
  use base_kinds, only: rp
  use base_machine, only: machine_memory_t, read_machine_memory
  use base_outcome, only: outcome_t, OUTCOME_NO_MEMORY
  use base_process, only: environment_value, host_name
  use parallel_world, only: world_t
  use simulation_memory, only: estimate_memory, memory_t
  use simulation_settings, only: settings_t
  implicit none
  private
  public :: check_machine

contains

  !> Refuses a run, with OUTCOME_NO_MEMORY, that needs more memory than a machine has or than the job may use there. Warns of a run
  !> that needs more than other programs leave free now. The need is that of the flow alone. It makes no check on a machine whose
  !> memory is unknown. Tests set FLUSI_TEST_SYSTEM to a folder with files like those of the system. Collective.
  subroutine check_machine(world, settings, outcome)
    type(world_t), intent(in) :: world
    type(settings_t), intent(in) :: settings
    type(outcome_t), intent(inout) :: outcome
    type(memory_t) :: need
    type(machine_memory_t) :: memory
    real(rp) :: peak
    integer :: n_here, worst, verdict, speaker
    n_here = world%count_here()
    need = estimate_memory(settings, world%size)
    peak = max(need%starting, need%running)
    memory = read_machine_memory(environment_value('FLUSI_TEST_SYSTEM'))
    if (.not. need%possible) return ! another check refuses this run
    verdict = 0
    if (memory%is_known .and. n_here*peak > memory%free) verdict = 1
    if (memory%is_known .and. n_here*peak > memory%total) verdict = 2
    worst = world%max_integer(verdict)
    if (worst == 0) return
    if (worst == 2) call outcome%end_as(OUTCOME_NO_MEMORY)
    speaker = world%max_integer(merge(world%rank, -1, verdict == worst))
    if (world%rank == speaker) call tell(verdict == 2, n_here, peak, memory)
  end subroutine check_machine

  !> Prints how much memory the run needs on this machine, and that the program refuses the run or that the system may end it.
  subroutine tell(is_refused, n_here, need, memory)
    logical, intent(in) :: is_refused
    integer, intent(in) :: n_here
    real(rp), intent(in) :: need !< [byte] for each rank
    type(machine_memory_t), intent(in) :: memory
    character(300) :: line
    write (line, '(i0,a,3(f0.2,a))') n_here, ' ranks on '//host_name()//' need about ', &
      n_here*need/1.0e9_rp, ' GB at most (', need/1.0e9_rp, ' GB each), and ', &
      merge(memory%total, memory%free, is_refused)/1.0e9_rp, ' GB are '
    if (is_refused) then
      write (error_unit, '(a)') 'flusi: '//trim(line)//' all that the machine has or the job may use: use more machines, or a '// &
        'coarser grid; --dry-run tells what other numbers of ranks need'
    else
      write (error_unit, '(a)') 'notice: '//trim(line)//' free: the run may be ended by the system; --dry-run tells what other '// &
        'numbers of ranks need'
    end if
    flush (error_unit)
  end subroutine tell
end module simulation_machine

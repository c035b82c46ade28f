! SPDX-License-Identifier: GPL-3.0-or-later
!> Decides whether a run stops before its end, because of the wall time, the end of the job, a signal or a control file. It also
!> decides when the next backup is due.
module io_stop
  use, intrinsic :: iso_fortran_env, only: error_unit
  use base_errors, only: message_list_t
  use base_kinds, only: rp, i8
  use base_process, only: environment_value, wall_seconds, epoch_seconds
  use base_signals, only: catch_signals, signal_caught
  use io_control, only: prepare_control, poll_control, CONTROL_SAVE_STOP
  use parallel_world, only: world_t
  implicit none
  private
  public :: job_limits_t, stop_rules_t

  !> How long a run may take, and how often it writes a backup.
  type :: job_limits_t
    real(rp) :: stop_seconds = 0      !< wall time after which a run stops
    real(rp) :: backup_seconds = 3600 !< wall time between backups
    real(rp) :: job_end_margin = 300  !< [s] before the end of the job that SLURM announces
  end type job_limits_t

  type :: stop_rules_t
    logical :: must_stop = .false.
    logical :: backup_due = .false.
    character(60) :: reason = ''
    real(rp), private :: last_poll = -huge(1.0_rp)
    real(rp), private :: begun = 0, last_backup = 0, stop_seconds = 0, backup_seconds = 0
    integer(i8), private :: job_end = huge(1_i8)
  contains
    procedure :: init => stop_init
    procedure, nopass :: listen => stop_listen
    procedure :: poll => stop_poll
    procedure :: is_time_over => stop_is_time_over
    procedure :: backup_done => stop_backup_done
  end type stop_rules_t

  real(rp), parameter :: POLL_SECONDS = 0.2_rp
  integer, parameter :: GO_ON = 0, STOP_WALLTIME = 1, STOP_JOB_END = 2, STOP_SIGNAL = 3, STOP_FILE = 4, BACKUP = 10

contains

  !> Starts the clocks and catches SIGTERM, SIGUSR1, SIGINT and SIGHUP.
  subroutine stop_init(self, limits)
    class(stop_rules_t), intent(inout) :: self
    type(job_limits_t), intent(in) :: limits
    character(:), allocatable :: text
    integer(i8) :: end_time
    integer :: status
    self%begun = wall_seconds()
    self%last_backup = self%begun
    self%stop_seconds = limits%stop_seconds
    self%backup_seconds = limits%backup_seconds
    text = environment_value('SLURM_JOB_END_TIME')
    if (text /= '') then
      read (text, *, iostat=status) end_time
      if (status == 0) self%job_end = end_time - nint(limits%job_end_margin, i8)
    end if
    call catch_signals()
  end subroutine stop_init

  !> Writes the control file through which a run can be stopped: the first file that a run writes.
  subroutine stop_listen(world)
    type(world_t), intent(in) :: world
    type(message_list_t) :: messages
    if (.not. world%is_root) return
    call prepare_control('.', messages)
    call messages%print(error_unit, 'flusi: ')
  end subroutine stop_listen

  !> Checks whether to stop or to back up; all ranks decide the same. Collective.
  subroutine stop_poll(self, world)
    class(stop_rules_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(message_list_t) :: messages
    integer :: verdict, signals
    ! A signal may reach one rank only.
    signals = world%max_integer(signal_caught())
    verdict = GO_ON
    if (world%is_root) then
      if (wall_seconds() - self%last_backup > self%backup_seconds) verdict = BACKUP
      ! Files are checked only a few times per second: on a parallel file system each check is a request.
      if (wall_seconds() - self%last_poll > POLL_SECONDS) then
        self%last_poll = wall_seconds()
        if (poll_control('.', messages) == CONTROL_SAVE_STOP) verdict = STOP_FILE
      end if
      call messages%print(error_unit, 'flusi: ')
      if (time_verdict(self) /= GO_ON) verdict = time_verdict(self)
    end if
    call world%broadcast_integer(verdict)
    if (signals > 0) verdict = STOP_SIGNAL
    self%backup_due = verdict == BACKUP
    self%must_stop = .true.
    select case (verdict)
    case (STOP_WALLTIME)
      self%reason = 'the wall time wtimemax is used up'
    case (STOP_JOB_END)
      self%reason = 'the job ends soon'
    case (STOP_SIGNAL)
      self%reason = 'a signal asked for it'
    case (STOP_FILE)
      self%reason = 'a control file asked for it'
    case default
      self%must_stop = .false.
    end select
  end subroutine stop_poll

  !> Tells whether the wall time is used up or the job ends soon, by this rank's clock. Not collective: rank 0 calls it during
  !> long work, before all ranks check.
  logical function stop_is_time_over(self) result(is_over)
    class(stop_rules_t), intent(in) :: self
    is_over = time_verdict(self) /= GO_ON
  end function stop_is_time_over

  !> Tells whether the wall time or the job's time is over.
  integer function time_verdict(self) result(verdict)
    class(stop_rules_t), intent(in) :: self
    verdict = GO_ON
    if (wall_seconds() - self%begun > self%stop_seconds) verdict = STOP_WALLTIME
    if (epoch_seconds() >= self%job_end) verdict = STOP_JOB_END
  end function time_verdict

  !> Counts the time to the next backup from now.
  subroutine stop_backup_done(self)
    class(stop_rules_t), intent(inout) :: self
    self%last_backup = wall_seconds()
    self%backup_due = .false.
  end subroutine stop_backup_done
end module io_stop

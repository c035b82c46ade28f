! SPDX-License-Identifier: GPL-3.0-or-later
!> Declares keys that several programs have: those of [Solver], which choose the path of static solutions, and those of [Saving]
!> on backups and on how long a job runs.
module common_solver_keys
  use base_kinds, only: rp
  use io_keys, only: keys_t
  use io_stop, only: job_limits_t
  use solid_statics, only: static_options_t
  implicit none
  private
  public :: solver_keys, backup_keys, limit_keys

contains

  !> Declares and reads the keys of [Solver] into `options`; `most` is the default of factorisation_limit.
  subroutine solver_keys(keys, options, most)
    type(keys_t), intent(inout) :: keys
    type(static_options_t), intent(inout) :: options
    integer, intent(in) :: most
    call keys%section('Solver', 'solution of the static equilibrium')
    call keys%real('tolerance', options%tolerance, 1.0e-8_rp, 'tolerance of the residual, relative to the load; soft wings do '// &
                   'not reach much smaller values', min=1.0e-12_rp, max=1.0e-3_rp)
    call keys%real('step_limit', options%step_limit, 0.025_rp, 'largest displacement in one stage of the load, relative to '// &
                   'the size of the wing', &
                   above=0.0_rp, max=0.2_rp)
    call keys%integer('factorisation_limit', options%factorisation_limit, most, 'largest number of factorisations of the '// &
                      'stiffness matrix for one load', min=1)
  end subroutine solver_keys

  !> Declares and reads keys of [Saving], which must be the present section of `keys`: whether a run writes backups, and how often.
  subroutine backup_keys(keys, writes, limits)
    type(keys_t), intent(in) :: keys
    logical, intent(inout) :: writes
    type(job_limits_t), intent(inout) :: limits
    call keys%switch('iDoBackup', writes, .true., 'write backups')
    call keys%real('truntime', limits%backup_seconds, 1.0_rp, 'wall time between backups', unit='h', above=0.0_rp, &
                   scale=3600.0_rp)
  end subroutine backup_keys

  !> Declares and reads keys of [Saving], which must be the present section of `keys`: how long a run may take, and how often it
  !> reports its progress.
  subroutine limit_keys(keys, limits, progress_seconds)
    type(keys_t), intent(in) :: keys
    type(job_limits_t), intent(inout) :: limits
    real(rp), intent(inout) :: progress_seconds
    call keys%real('wtimemax', limits%stop_seconds, 8760.0_rp, 'stop with a backup after this wall time', unit='h', &
                   above=0.0_rp, scale=3600.0_rp)
    call keys%real('job_end_margin', limits%job_end_margin, 300.0_rp, &
                   'stop this long before the end of the job that SLURM announces in SLURM_JOB_END_TIME', unit='s', min=0.0_rp)
    call keys%real('progress_interval', progress_seconds, 30.0_rp, 'wall time between progress lines in a log', unit='s', &
                   min=0.0_rp)
  end subroutine limit_keys
end module common_solver_keys

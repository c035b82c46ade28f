! SPDX-License-Identifier: GPL-3.0-or-later
!> Shows how far a run is and how long it will take: in one live line on a terminal, or in one line for each interval in a log.
module common_progress
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_kinds, only: rp
  use base_process, only: is_terminal, wall_seconds
  implicit none
  private
  public :: progress_t, duration

  !> Counts only the steps of this run, so that the estimate is right after a restart.
  type :: progress_t
    private
    logical :: speaks = .false., live = .false.
    real(rp) :: interval = 30, begun = 0, shown = -huge(1.0_rp), last_step = 0
    real(rp) :: seconds_per_step = 0 !< moving average
    integer :: steps = 0
    character(:), allocatable :: quantity !< name of the number that is shown beside the time step
  contains
    procedure :: init => progress_init
    procedure :: step_done => progress_step_done
    procedure :: finish => progress_finish
  end type progress_t

contains

  !> Starts the clock of the progress. `speaks` must be true on root only. `quantity` names the number that `step_done` receives
  !> as u_max.
  subroutine progress_init(self, speaks, interval, quantity)
    class(progress_t), intent(inout) :: self
    logical, intent(in) :: speaks
    real(rp), intent(in) :: interval !< seconds between lines in a log
    character(*), intent(in), optional :: quantity
    self%quantity = 'max|u|'
    if (present(quantity)) self%quantity = quantity
    self%speaks = speaks
    self%live = is_terminal()
    self%interval = merge(0.2_rp, interval, self%live)
    self%begun = wall_seconds()
    self%last_step = self%begun
  end subroutine progress_init

  !> Counts a step that has ended, shows the progress if it is due, and returns in `seconds` the wall time of the step. Every rank
  !> may call it; no rank waits for another.
  subroutine progress_step_done(self, step, time, dt, u_max, t_max, max_steps, seconds)
    class(progress_t), intent(inout) :: self
    integer, intent(in) :: step, max_steps
    real(rp), intent(in) :: time, dt, u_max, t_max
    real(rp), intent(out) :: seconds
    real(rp) :: now, done, left, steps_left
    character(140) :: line
    now = wall_seconds()
    seconds = now - self%last_step
    self%last_step = now
    self%steps = self%steps + 1
    self%seconds_per_step = self%seconds_per_step + (seconds - self%seconds_per_step)/min(self%steps, 50)
    ! The first steps are slower, because caches are empty. They would give a wrong estimate.
    if (.not. self%speaks .or. self%steps < 3 .or. now - self%shown < self%interval) return
    self%shown = now
    steps_left = min((t_max - time)/dt, real(max_steps - step, rp))
    done = max(time/t_max, real(step, rp)/max_steps)
    left = steps_left*self%seconds_per_step
    write (line, '(a,i8,a,es10.3,a,es9.2,a,f7.3,a,es9.2,a,f6.1,a)') 'step', step, '  t', time, '  dt', dt, &
'  '//self%quantity, min(u_max, 999.0_rp), '  s/step', self%seconds_per_step, '  ', 100*done, ' %  ETA '//duration(left)
    if (self%live) then
      write (output_unit, '(a)', advance='no') achar(13)//trim(line)//'   '
    else
      write (output_unit, '(a)') trim(line)
    end if
    flush (output_unit)
  end subroutine progress_step_done

  !> Ends the live line, so that other output begins on a new one.
  subroutine progress_finish(self)
    class(progress_t), intent(in) :: self
    if (self%speaks .and. self%live .and. self%steps > 0) write (output_unit, '(a)') ''
  end subroutine progress_finish

  !> Returns `seconds` as text in everyday form: 45s, 12m30s, 5h10m, 3d04h.
  function duration(seconds) result(text)
    real(rp), intent(in) :: seconds
    character(:), allocatable :: text
    character(24) :: buffer
    integer :: s
    s = nint(min(max(seconds, 0.0_rp), 1.0e9_rp))
    if (s < 60) then
      write (buffer, '(i0,a)') s, 's'
    else if (s < 3600) then
      write (buffer, '(i0,a,i2.2,a)') s/60, 'm', mod(s, 60), 's'
    else if (s < 86400) then
      write (buffer, '(i0,a,i2.2,a)') s/3600, 'h', mod(s, 3600)/60, 'm'
    else
      write (buffer, '(i0,a,i2.2,a)') s/86400, 'd', mod(s, 86400)/3600, 'h'
    end if
    text = trim(buffer)
  end function duration
end module common_progress

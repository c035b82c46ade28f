! SPDX-License-Identifier: GPL-3.0-or-later
!> What `msm_train` tells: on the terminal and in NAME.log, by rank 0; and one live line while it searches.
module app_train_log
  use, intrinsic :: iso_fortran_env, only: output_unit
  use app_progress, only: duration
  use base_kinds, only: i8, rp
  use base_process, only: is_terminal, wall_seconds
  use base_text_file, only: text_file_t
  implicit none
  private
  public :: train_log_t

  type :: train_log_t
    type(text_file_t), private :: file
    logical, private :: speaks = .false., is_live = .false., is_line_open = .false.
    real(rp), private :: interval = 30, begun = 0, shown = -huge(1.0_rp)
    integer(i8), private :: first_evaluations = -1
  contains
    procedure :: open => log_open
    procedure :: say => log_say
    procedure :: progress => log_progress
    procedure :: end_line => log_end_line
    procedure :: close => log_close
  end type train_log_t

contains

  !> Opens the file, behind what it holds after a restart; on ranks that do not speak nothing happens. Without the
  !> file there is no run.
  subroutine log_open(self, speaks, path, is_restart, interval, ok)
    class(train_log_t), intent(inout) :: self
    logical, intent(in) :: speaks, is_restart
    character(*), intent(in) :: path
    real(rp), intent(in) :: interval !< [s] between progress lines in the log
    logical, intent(out) :: ok
    ok = .true.
    self%speaks = speaks
    self%is_live = is_terminal()
    self%interval = interval
    self%begun = wall_seconds()
    if (.not. speaks) return
    if (is_restart) then
      call self%file%append(path, ok)
    else
      call self%file%create(path, ok)
    end if
  end subroutine log_open

  !> A line for both.
  subroutine log_say(self, text)
    class(train_log_t), intent(inout) :: self
    character(*), intent(in) :: text
    logical :: ignored
    if (.not. self%speaks) return
    call self%end_line()
    write (output_unit, '(a)') text
    flush (output_unit)
    if (.not. self%file%is_open()) return
    call self%file%write(text, ignored)
    call self%file%flush(ignored)
  end subroutine log_say

  !> How far the search is; `evaluations_left` at most, with which the time is estimated from the second generation on.
  subroutine log_progress(self, generation, evaluations, evaluations_left, best, sigma, condition)
    class(train_log_t), intent(inout) :: self
    integer, intent(in) :: generation
    integer(i8), intent(in) :: evaluations, evaluations_left
    real(rp), intent(in) :: best, sigma, condition
    real(rp) :: now, left
    character(160) :: line
    character(:), allocatable :: estimate
    logical :: ignored
    if (.not. self%speaks) return
    now = wall_seconds()
    estimate = ''
    if (self%first_evaluations < 0) then
      self%first_evaluations = evaluations
      self%begun = now
    else
      if (now - self%shown < merge(0.2_rp, self%interval, self%is_live)) return
      left = (now - self%begun)*evaluations_left/max(1_i8, evaluations - self%first_evaluations)
      estimate = '  the search ends in at most '//duration(left)
    end if
    write (line, '(a,i6,a,i9,a,es11.4,a,es9.2,a,es9.2,a)') 'generation', generation, '  evaluations', evaluations, &
      '  best', min(best, 9.999e99_rp), '  sigma', sigma, '  condition', condition, estimate
    if (self%is_live) then
      write (output_unit, '(a)', advance='no') achar(13)//trim(line)//'   '
      self%is_line_open = .true.
    else
      write (output_unit, '(a)') trim(line)
    end if
    flush (output_unit)
    self%shown = now
    if (.not. self%file%is_open()) return
    call self%file%write(trim(line), ignored)
    call self%file%flush(ignored)
  end subroutine log_progress

  !> Ends the live line.
  subroutine log_end_line(self)
    class(train_log_t), intent(inout) :: self
    if (self%is_line_open) write (output_unit, '(a)') ''
    self%is_line_open = .false.
  end subroutine log_end_line

  subroutine log_close(self)
    class(train_log_t), intent(inout) :: self
    logical :: ignored
    call self%end_line()
    if (self%file%is_open()) call self%file%close(ignored)
  end subroutine log_close
end module app_train_log

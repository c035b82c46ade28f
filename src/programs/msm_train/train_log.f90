! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the messages of `msm_train` to the terminal and to NAME.log, from rank 0 alone. While it searches and polishes, it shows
!> one live line of progress.
module train_log
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use base_process, only: is_terminal, wall_seconds
  use base_text_file, only: text_file_t
  use common_progress, only: duration
  use training_budget, only: budget_t
  use training_listener, only: training_listener_t
  implicit none
  private
  public :: train_log_t

  type, extends(training_listener_t) :: train_log_t
    type(text_file_t), private :: file
    logical, private :: speaks = .false., is_live = .false., is_line_open = .false.
    real(rp), private :: interval = 30, begun = 0, shown = -huge(1.0_rp), filed = -huge(1.0_rp)
    integer(i8), private :: first_evaluations = -1
  contains
    procedure :: open => log_open
    procedure :: say => log_say
    procedure :: progress => log_progress
    procedure :: polish_progress => log_polish_progress
    procedure :: interval_progress => log_interval_progress
    procedure :: end_line => log_end_line
    procedure :: close => log_close
  end type train_log_t

contains

  !> Opens the log file; after a restart it appends to the file. Does nothing on ranks that print no messages. Fails if the file
  !> cannot be opened, and the training must not run then.
  subroutine log_open(self, speaks, path, is_restart, interval, failure)
    class(train_log_t), intent(inout) :: self
    logical, intent(in) :: speaks, is_restart
    character(*), intent(in) :: path
    real(rp), intent(in) :: interval !< [s] between progress lines in the log
    type(failure_t), intent(inout) :: failure
    self%speaks = speaks
    self%is_live = is_terminal()
    self%interval = interval
    self%begun = wall_seconds()
    if (.not. speaks) return
    if (is_restart) then
      call self%file%append(path, failure)
    else
      call self%file%create(path, failure)
    end if
  end subroutine log_open

  !> Writes a line to the terminal and to the log file.
  subroutine log_say(self, text)
    class(train_log_t), intent(inout) :: self
    character(*), intent(in) :: text
    type(failure_t) :: ignored ! a missing line in the log does not end a training
    if (.not. self%speaks) return
    call self%end_line()
    write (output_unit, '(a)') text
    flush (output_unit)
    if (.not. self%file%is_open()) return
    call self%file%write(text, ignored)
    call self%file%flush(ignored)
  end subroutine log_say

  !> Shows the progress of the search. From the second generation on it estimates the remaining time from the budget that is
  !> `left`.
  subroutine log_progress(self, generation, evaluations, left, best, sigma, condition)
    class(train_log_t), intent(inout) :: self
    integer, intent(in) :: generation
    integer(i8), intent(in) :: evaluations
    type(budget_t), intent(in) :: left
    real(rp), intent(in) :: best, sigma, condition
    real(rp) :: now, seconds
    character(160) :: line
    character(:), allocatable :: until
    if (.not. self%speaks) return
    now = wall_seconds()
    until = ''
    if (self%first_evaluations < 0) then
      self%first_evaluations = evaluations
      self%begun = now
    else
      if (.not. is_due(self, now)) return
      seconds = (now - self%begun)*left%evaluations/max(1_i8, evaluations - self%first_evaluations)
      until = '  '//left%subject()//' ends in at most '//duration(seconds)
    end if
    write (line, '(a,i6,a,i9,a,es11.4,a,es9.2,a,es9.2,a)') 'generation', generation, '  evaluations', evaluations, &
      '  best', min(best, 9.999e99_rp), '  sigma', sigma, '  condition', condition, until
    call show(self, trim(line), now)
  end subroutine log_progress

  !> Shows the progress of least squares from start `part`: the number of points solved and the lowest chi^2 so far. The time that
  !> the earlier starts took since the wall time `begun` [s] gives an estimate of the end; there is none during the first start.
  subroutine log_polish_progress(self, kind, part, n_parts, evaluations, chi2, begun)
    class(train_log_t), intent(inout) :: self
    character(*), intent(in) :: kind        !< 'start' or 'move'
    integer, intent(in) :: part, n_parts    !< number of this part, and the largest number of parts
    integer, intent(in) :: evaluations
    real(rp), intent(in) :: chi2, begun
    real(rp) :: now
    character(160) :: line
    if (.not. self%speaks) return
    now = wall_seconds()
    if (.not. is_due(self, now)) return
    write (line, '(2(a,i0),a,i9,a,es11.4,a)') 'polish from '//kind//' ', part, ' of at most ', n_parts, '  evaluations', &
      evaluations, '  best chi^2', min(chi2, 9.999e99_rp), estimate(part - 1, n_parts, now - begun)
    call show(self, trim(line), now)
  end subroutine log_polish_progress

  !> Shows the progress of the intervals: `done` of n were found since the wall time `begun` [s].
  subroutine log_interval_progress(self, name, done, n, evaluations, begun)
    class(train_log_t), intent(inout) :: self
    character(*), intent(in) :: name     !< of the parameter whose interval is computed
    integer, intent(in) :: done, n, evaluations
    real(rp), intent(in) :: begun
    real(rp) :: now
    character(160) :: line
    if (.not. self%speaks) return
    now = wall_seconds()
    if (.not. is_due(self, now)) return
    write (line, '(2(a,i0),a,i9,a)') 'interval ', done + 1, ' of ', n, ', '//name//'  evaluations', evaluations, &
      estimate(done, n, now - begun)
    call show(self, trim(line), now)
  end subroutine log_interval_progress

  !> Returns an estimate of when all n parts end if the first `done` of them took `seconds`. It is empty until one part is done.
  function estimate(done, n, seconds) result(text)
    integer, intent(in) :: done, n
    real(rp), intent(in) :: seconds
    character(:), allocatable :: text
    text = ''
    if (done > 0) text = '  all end in about '//duration(seconds*(n - done)/done)
  end function estimate

  !> Tells whether another progress line is due.
  pure logical function is_due(self, now)
    type(train_log_t), intent(in) :: self
    real(rp), intent(in) :: now
    is_due = now - self%shown >= merge(0.2_rp, self%interval, self%is_live)
  end function is_due

  !> Shows a progress line. On a terminal it replaces the previous one. In the file it is a line of its own, and such lines are
  !> written no more often than the interval allows.
  subroutine show(self, line, now)
    type(train_log_t), intent(inout) :: self
    character(*), intent(in) :: line
    real(rp), intent(in) :: now
    type(failure_t) :: ignored
    if (self%is_live) then
      write (output_unit, '(a)', advance='no') achar(13)//line//'   '
      self%is_line_open = .true.
    else
      write (output_unit, '(a)') line
    end if
    flush (output_unit)
    self%shown = now
    if (.not. self%file%is_open() .or. (self%is_live .and. now - self%filed < self%interval)) return
    self%filed = now
    call self%file%write(line, ignored)
    call self%file%flush(ignored)
  end subroutine show

  !> Ends the live line.
  subroutine log_end_line(self)
    class(train_log_t), intent(inout) :: self
    if (self%is_line_open) write (output_unit, '(a)') ''
    self%is_line_open = .false.
  end subroutine log_end_line

  !> Ends the live line and closes the log. An error while closing is ignored.
  subroutine log_close(self)
    class(train_log_t), intent(inout) :: self
    type(failure_t) :: ignored
    call self%end_line()
    call self%file%close(ignored)
  end subroutine log_close
end module train_log

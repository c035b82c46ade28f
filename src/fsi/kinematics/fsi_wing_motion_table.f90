! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads FLUSI's kinematics_loader tables: a motion that does not repeat.
!>
!>     T                      period, same unit as the times of the table
!>     R                      wing length, same unit as vert and horz
!>     n                      number of rows
!>     t phi alpha theta pitch vert horz and their derivatives in time     n rows
!>
!> Angles are in degrees; theta is positive upwards, opposite to FLUSI's internal angle. Time becomes t/T, so that only the ratio
!> matters. Between rows each angle is a cubic, and its rates are the derivatives of this cubic; FLUSI interpolates the rates
!> separately, so that they are not the derivatives of the angles. The columns of the body are for [Insects] BodyMotion =
!> kinematics_loader::.
module fsi_wing_motion_table
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: BLANKS, count_words, number_text, parse_integer, parse_real, parse_reals
  use fsi_quaternion, only: attitude_of
  use fsi_wing_motion, only: wing_motion_t
  implicit none
  private
  public :: read_motion_table, read_body_states

  integer, parameter :: COLUMNS = 13
  integer, parameter :: MOST_MISTAKES = 10 !< after that the rest of the table is not read

contains

  !> Fills the three series of `motion` from `text`, the content of the file called `name`. Empty lines and comments after ; # ! or
  !> % are skipped. Mistakes are added to `errors` as name:line: problem; the motion is then unchanged.
  subroutine read_motion_table(text, name, motion, errors)
    character(*), intent(in) :: text, name
    type(wing_motion_t), intent(inout) :: motion
    type(message_list_t), intent(inout) :: errors
    real(rp), allocatable :: rows(:, :), x(:)
    real(rp) :: period, length
    integer :: n_before
    n_before = errors%count()
    call read_rows(text, name, period, length, rows, errors)
    if (errors%count() > n_before) return
    associate (slope => period*PI/180, degree => PI/180)
      x = rows(1, :)/period
      call motion%phi%set_table(x, degree*rows(2, :), slope*rows(8, :))
      call motion%alpha%set_table(x, degree*rows(3, :), slope*rows(9, :))
      call motion%theta%set_table(x, -degree*rows(4, :), -slope*rows(10, :))
    end associate
  end subroutine read_motion_table

  !> Reads the states (14, n) of the body in the same table: time in cycles; centre, `start` and horz/R along x, vert/R along z;
  !> its velocity; the quaternion of the pitch, which here is positive nose down and in the table nose up; angular velocity in the
  !> body.
  subroutine read_body_states(text, name, start, states, errors)
    character(*), intent(in) :: text, name
    real(rp), intent(in) :: start(3) !< L
    real(rp), allocatable, intent(out) :: states(:, :)
    type(message_list_t), intent(inout) :: errors
    real(rp), allocatable :: rows(:, :)
    real(rp) :: period, length
    integer :: n_before, i
    n_before = errors%count()
    call read_rows(text, name, period, length, rows, errors)
    if (errors%count() > n_before) return
    allocate (states(14, size(rows, 2)), source=0.0_rp)
    states(1, :) = rows(1, :)/period
    do i = 1, size(rows, 2)
      states(2:4, i) = start + [rows(7, i), 0.0_rp, rows(6, i)]/length
      states(5:7, i) = [rows(13, i), 0.0_rp, rows(12, i)]*(period/length)
      states(8:11, i) = attitude_of(0.0_rp, -PI/180*rows(5, i), 0.0_rp)
      states(13, i) = -PI/180*rows(11, i)*period
    end do
  end subroutine read_body_states

  !> Reads the rows of a table with its period and length. Adds an error for every line that is wrong.
  subroutine read_rows(text, name, period, length, rows, errors)
    character(*), intent(in) :: text, name
    real(rp), intent(out) :: period, length
    real(rp), allocatable, intent(out) :: rows(:, :)
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: content, place, problem
    real(rp) :: row(COLUMNS), header
    integer :: position, line, n, n_read, n_before
    logical :: found
    n_before = errors%count()
    period = 1
    length = 1
    n = 0
    n_read = 0 ! lines with numbers, header included
    position = 1
    line = 0
    do
      call next_content(text, position, line, content, found)
      if (.not. found .or. errors%count() - n_before >= MOST_MISTAKES) exit
      n_read = n_read + 1
      place = name//':'//number_text(line)//': '
      if (allocated(problem)) deallocate (problem)
      select case (n_read)
      case (1, 2)
        call parse_real(content, header, problem)
        if (.not. allocated(problem) .and. header <= 0) problem = number_text(header)//' is not positive'
        if (n_read == 1 .and. .not. allocated(problem)) period = header
        if (n_read == 2 .and. .not. allocated(problem)) length = header
        if (allocated(problem)) call errors%add(place//trim(merge('period     ', 'wing length', n_read == 1))// &
                                                ': '//problem//'; valid: a real > 0')
      case (3)
        call parse_integer(content, n, problem)
        ! A row takes 26 characters at least: a larger count is wrong and must not be allocated.
        if (.not. allocated(problem) .and. n > len(text)/(2*COLUMNS) + 1) &
          problem = number_text(n)//' rows do not fit into this file'
        if (.not. allocated(problem) .and. n < 2) problem = number_text(n)//' is too small'
        if (allocated(problem)) then
          call errors%add(place//'number of rows: '//problem//'; valid: integer >= 2')
          return ! the rows cannot be separated from what follows
        end if
        allocate (rows(COLUMNS, n))
      case default
        if (n_read - 3 > n) then
          call errors%add(place//'more rows than the '//number_text(n)//' announced in the third line')
          return
        end if
        call read_row(content, row, problem)
        rows(:, n_read - 3) = row
        if (.not. allocated(problem)) call check_time(rows(1, :n_read - 3), problem)
        if (allocated(problem)) call errors%add(place//problem)
      end select
    end do
    if (n_read < 3) then
      call errors%add(name//': ends before the three header lines: period, wing length, number of rows')
    else if (n_read - 3 < n .and. errors%count() - n_before < MOST_MISTAKES) then
      call errors%add(name//': '//number_text(n_read - 3)//' rows, but the third line announces '//number_text(n))
    end if
  end subroutine read_rows

  !> Reads one row of the table. `problem` says what is wrong with it.
  subroutine read_row(content, row, problem)
    character(*), intent(in) :: content
    real(rp), intent(out) :: row(COLUMNS)
    character(:), allocatable, intent(out) :: problem
    integer :: n
    row = 0
    n = count_words(content, BLANKS)
    if (n /= COLUMNS) then
      problem = number_text(n)//trim(merge(' number ', ' numbers', n == 1))//' in a row, not '//number_text(COLUMNS)// &
                ': t phi alpha theta pitch vert horz and their derivatives'
      return
    end if
    call parse_reals(content, BLANKS, row, problem)
  end subroutine read_row

  !> Checks that times begin at 0 and increase.
  subroutine check_time(t, problem)
    real(rp), intent(in) :: t(:)
    character(:), allocatable, intent(inout) :: problem
    integer :: n
    n = size(t)
    if (n == 1) then
      if (abs(t(1)) > 0) problem = 'the first time is '//number_text(t(1))//'; valid: 0'
    else if (t(n) <= t(n - 1)) then
      problem = 'time '//number_text(t(n))//' does not follow '//number_text(t(n - 1))//'; valid: increasing times'
    end if
  end subroutine check_time

  !> Finds the next line that holds more than blanks and a comment, and trims it of both.
  subroutine next_content(text, position, line, content, found)
    character(*), intent(in) :: text
    integer, intent(inout) :: position, line
    character(:), allocatable, intent(out) :: content
    logical, intent(out) :: found
    integer :: last, finish
    content = ''
    found = .false.
    do while (position <= len(text) .and. .not. found)
      last = index(text(position:), achar(10))
      last = merge(len(text), position + last - 2, last == 0)
      finish = scan(text(position:last), ';#!%'//achar(13))
      finish = merge(last, position + finish - 2, finish == 0)
      call trim_blanks(text(position:finish), content)
      position = last + 2
      line = line + 1
      found = len(content) > 0
    end do
  end subroutine next_content

  !> Returns a text without the blanks at its ends.
  subroutine trim_blanks(text, content)
    character(*), intent(in) :: text
    character(:), allocatable, intent(out) :: content
    integer :: first
    first = verify(text, BLANKS)
    content = ''
    if (first > 0) content = text(first:verify(text, BLANKS, back=.true.))
  end subroutine trim_blanks
end module fsi_wing_motion_table

! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the keys of the motion of the body, with FLUSI's names, and tables of a flight.
module fsi_body_motion_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: BLANKS, count_words, number_text, parse_reals
  use fsi_body_motion, only: body_motion_t, LOADER_WORD, MOTION_FREE, MOTION_TABLE, MOTION_TAKEOFF, MOTION_TETHERED, &
                             MOTION_YAWPITCHROLL, MOTIONS, TABLE_WORD
  use fsi_kinematics, only: body_t
  use fsi_wing_motion_table, only: read_body_states
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  use io_broadcast_text, only: read_named_text
  use parallel_world, only: world_t
  implicit none
  private
  public :: body_motion_choices_t, body_motion_choices, body_motion_keys, read_body_motion, read_flight_table, &
            scale_way

  character(*), parameter :: SECTION = 'Insects'
  integer, parameter :: COLUMNS = 14
  real(rp), parameter :: LENGTH_ERROR = 1.0e-3_rp !< error of the length of a quaternion in a table with enough digits

  type :: body_motion_choices_t
    integer :: kind = MOTION_TETHERED      !< BodyMotion
    character(:), allocatable :: word      !< the word for it that the user gives
    character(:), allocatable :: from_file !< yes: a take-off in a table
    real(rp) :: x_takeoff = 0, z_takeoff = 0, velocity(3) = 0
    real(rp) :: factor = 1                 !< factor on the displacement in a table
  end type body_motion_choices_t

contains

  !> Declares and reads the keys of the motion of the body.
  subroutine body_motion_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(body_motion_choices_t), intent(inout) :: c
    real(rp), parameter :: ZERO(3) = 0.0_rp
    call keys%section(SECTION)
    call keys%kind('BodyMotion', c%kind, 'tethered', MOTIONS, &
                   'motion of the body: at rest (the six words after tethered are positions and attitudes of early versions '// &
                   'of FLUSI), free flight, oscillations of FLUSI, the states of a rigidsolidsolver.t, or the pitch and the '// &
                   'displacement from x0 in a kinematics_loader table (docs/guide/free-flight.md)', unbuilt='command-line*', &
                   instead='command-line*: tethered with x0 and yawpitchroll_0, one file for each run', word=c%word)
    call keys%text('KineFromFile', c%from_file, 'no', 'BodyMotion = takeoff: yes reads the motion from a table, infile or '// &
                   'data_kin.dat')
    call keys%real('x_takeoff', c%x_takeoff, 2.0_rp, 'BodyMotion = takeoff: x to which the displacement in the table is added', &
                   unit='L')
    call keys%real('z_takeoff', c%z_takeoff, 0.86_rp, 'BodyMotion = takeoff: z to which the displacement in the table is added', &
                   unit='L')
    call keys%real('body_motion_factor', c%factor, 1.0_rp, 'BodyMotion = from_file::*: factor on the displacement of the body '// &
                   'from its mean position in all whole beats of the table', min=0.0_rp)
    call keys%reals('v0', c%velocity, ZERO, 'velocity of the body at the start', unit='L/T')
  end subroutine body_motion_keys

  !> Returns what the user chose.
  function body_motion_choices(config) result(c)
    type(config_t), intent(in), target :: config
    type(body_motion_choices_t) :: c
    type(keys_t) :: keys
    keys = reading(config)
    call body_motion_keys(keys, c)
  end function body_motion_choices

  !> Makes the motion of the body, which is `body` at the start, and whose wings beat `frequency` times per T. A free body gets its
  !> velocity `v0` here. Mistakes go to `errors`. With `world` the root rank reads files for all, and the call is collective.
  subroutine read_body_motion(config, body, t_end, frequency, motion, errors, notices, world)
    type(config_t), intent(in) :: config
    type(body_t), intent(in) :: body
    real(rp), intent(in) :: t_end     !< end of the run, T
    real(rp), intent(in) :: frequency !< 1/T
    type(body_motion_t), intent(out) :: motion
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(body_motion_choices_t) :: choices
    character(:), allocatable :: path, text, problem
    integer :: errors_before, begin
    choices = body_motion_choices(config)
    associate (word => choices%word)
      motion%centre = body%centre
      motion%angles = body%angles
      motion%velocity = choices%velocity
      motion%known = body
      motion%known(1)%velocity = motion%velocity
      motion%known(2)%velocity = motion%velocity
      motion%kind = choices%kind
      if (all(motion%kind /= [MOTION_FREE, MOTION_YAWPITCHROLL]) .and. norm2(motion%velocity) > 0) &
        call config%complain(notices, SECTION, 'v0', 'has no effect with BodyMotion = '//word)
      if (motion%kind == MOTION_TAKEOFF) call config%complain(errors, SECTION, 'BodyMotion', &
        'is takeoff with KineFromFile = '//choices%from_file//'; the program does not have FLUSI''s legs that push off; valid: '// &
        'KineFromFile = yes with a take-off in a table, free_flight, or '//TABLE_WORD//'a flight')
      if (motion%kind /= MOTION_TABLE) return
      begin = index(word, '::') + 2
      call read_named_text(word(begin:), config%file_name(), path, text, problem, world)
      if (allocated(problem)) then
        call config%complain(errors, SECTION, 'BodyMotion', problem)
        motion%kind = MOTION_TETHERED
        return
      end if
      errors_before = errors%count()
      if (index(word, LOADER_WORD) == 1) then
        call read_body_states(text, path, motion%centre, motion%table, errors)
      else
        call read_flight_table(text, path, motion%table, errors)
      end if
      if (errors%count() > errors_before) then
        motion%kind = MOTION_TETHERED
      else if (motion%table(1, 1) > 0 .or. motion%table(1, size(motion%table, 2)) < t_end) then
        call config%complain(errors, SECTION, 'BodyMotion', 'the states in '//path//' reach from t = '// &
                             number_text(motion%table(1, 1))//' to '// &
                             number_text(motion%table(1, size(motion%table, 2)))//', but the run goes from 0 to '// &
                             number_text(t_end))
      end if
      if (errors%count() == errors_before .and. abs(choices%factor - 1) > 0) call scale_way(choices%factor, frequency, motion%table)
    end associate
  end subroutine read_body_motion

  !> Multiplies the distances of all centres of a table from their mean by `factor`; velocities follow. The mean is that of all
  !> whole beats from the beginning of the table, so that the middle of a periodic way stays where it is; a table of less than a
  !> beat has the mean of all of it.
  pure subroutine scale_way(factor, frequency, table)
    real(rp), intent(in) :: factor, frequency
    real(rp), intent(inout) :: table(:, :)
    real(rp), parameter :: ALMOST = 1.0e-6_rp !< beats
    real(rp) :: mean(3), span, share
    integer :: i, n
    n = size(table, 2)
    span = table(1, n) - table(1, 1)
    if (span*frequency + ALMOST >= 1) span = min(span, floor(span*frequency + ALMOST)/frequency)
    mean = 0
    do i = 2, n
      associate (step => table(1, i) - table(1, i - 1), from => table(2:4, i - 1), way => table(2:4, i) - table(2:4, i - 1))
        share = min(1.0_rp, max(0.0_rp, (table(1, 1) + span - table(1, i - 1))/step))
        mean = mean + share*step*(from + share*way/2)/span
      end associate
    end do
    do i = 1, n
      table(2:4, i) = mean + factor*(table(2:4, i) - mean)
      table(5:7, i) = factor*table(5:7, i)
    end do
  end subroutine scale_way

  !> Reads the rows (14, n) of a rigidsolidsolver.t. Lines that begin with % and columns after the 14th are skipped. Mistakes go
  !> to `errors` as name:line: problem.
  subroutine read_flight_table(text, name, table, errors)
    character(*), intent(in) :: text, name
    real(rp), allocatable, intent(out) :: table(:, :)
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: problem
    real(rp) :: row(COLUMNS)
    integer :: position, last, line, n, pass
    do pass = 1, 2
      position = 1
      line = 0
      n = 0
      do while (position <= len(text))
        last = index(text(position:), achar(10))
        last = merge(len(text), position + last - 2, last == 0)
        line = line + 1
        associate (content => text(position:last))
          if (count_words(content, BLANKS) > 0 .and. index(adjustl(content), '%') /= 1) then
            n = n + 1
            if (pass == 2) then
              if (allocated(problem)) deallocate (problem)
              call read_row(content, row, problem)
              if (.not. allocated(problem) .and. abs(norm2(row(8:11)) - 1) > LENGTH_ERROR) &
                problem = 'columns 8 to 11 must be a unit quaternion'
              table(:, n) = row
              if (.not. allocated(problem) .and. n > 1) then
                if (table(1, n) <= table(1, max(1, n - 1))) problem = 'the time must increase from row to row'
              end if
              if (allocated(problem)) then
                call errors%add(name//':'//number_text(line)//': '//problem)
                return
              end if
            end if
          end if
        end associate
        position = last + 2
      end do
      if (n < 2) then
        call errors%add(name//': '//number_text(n)//' states; valid: two or more rows of time, centre, velocity, '// &
                        'quaternion, angular velocity')
        return
      end if
      if (pass == 1) allocate (table(COLUMNS, n), source=0.0_rp)
    end do
  end subroutine read_flight_table

  !> Reads one row of the table of a body's motion. `problem` says what is wrong with it.
  subroutine read_row(content, row, problem)
    character(*), intent(in) :: content
    real(rp), intent(out) :: row(COLUMNS)
    character(:), allocatable, intent(out) :: problem
    row = 0
    if (count_words(content, BLANKS) < COLUMNS) then
      problem = number_text(count_words(content, BLANKS))//' numbers in a row; valid: '//number_text(COLUMNS)
      return
    end if
    call parse_reals(content, BLANKS, row, problem)
  end subroutine read_row
end module fsi_body_motion_keys

! SPDX-License-Identifier: GPL-3.0-or-later
!> Controls a running program through files in its folder, which rank 0 reads.
!>
!> A file `STOP` requests a checkpoint and the end of the run. As in FLUSI, `runtime_control.ini` with `runtime_control=save_stop;`
!> in its section [runtime_control] requests the same. A request counts once: afterwards STOP is removed, and the ini file is set
!> back to `nothing`.
module io_control
  use base_errors, only: message_list_t
  use base_files, only: file_exists, join_path, remove_file
  use base_text_file, only: write_text
  use base_text_lines, only: read_line
  implicit none
  private
  public :: CONTROL_NOTHING, CONTROL_SAVE_STOP, prepare_control, poll_control

  integer, parameter :: CONTROL_NOTHING = 0, CONTROL_SAVE_STOP = 1

  character(*), parameter :: CONTROL_FILE = 'runtime_control.ini', STOP_FILE = 'STOP'
  character(*), parameter :: NL = new_line('a')
  character(*), parameter :: IDLE = &
                             '; Write save_stop in the place of nothing to save a checkpoint and end the run.'//NL// &
                             '[runtime_control]'//NL//'runtime_control=nothing;'

contains

  !> Writes an idle control file, replacing one that an earlier run left. A STOP file that is already there is kept, because it asks
  !> this run to stop. If the folder cannot be written, a message says so.
  subroutine prepare_control(directory, messages)
    character(*), intent(in) :: directory
    type(message_list_t), intent(inout) :: messages
    logical :: ok
    call write_text(join_path(directory, CONTROL_FILE), IDLE, ok)
    if (.not. ok) call messages%add(join_path(directory, CONTROL_FILE)//': cannot be written')
  end subroutine prepare_control

  !> Returns the request found in `directory`, CONTROL_NOTHING or CONTROL_SAVE_STOP; rank 0 calls it and informs the others. Without
  !> a request it costs two file look-ups. An unknown request, or one that cannot be fulfilled, gives a message, and the file is set
  !> back.
  integer function poll_control(directory, messages) result(request)
    character(*), intent(in) :: directory
    type(message_list_t), intent(inout) :: messages
    character(:), allocatable :: path, wish
    logical :: ok

    request = CONTROL_NOTHING
    path = join_path(directory, STOP_FILE)
    if (file_exists(path)) then
      request = CONTROL_SAVE_STOP
      call remove_file(path, ok)
      if (.not. ok) call messages%add(path//': cannot be removed; the next run will stop too')
    end if

    path = join_path(directory, CONTROL_FILE)
    if (.not. file_exists(path)) return
    wish = control_wish(path)
    select case (wish)
    case ('nothing', '')
      return
    case ('save_stop')
      request = CONTROL_SAVE_STOP
    case ('reload_params')
      call messages%add(path//': reload_params is not supported: a run must be reproducible from its '// &
                        'parameter file; use save_stop, edit the parameters and restart')
    case default
      call messages%add(path//': runtime_control='//wish//' is unknown; valid: nothing | save_stop')
    end select
    call write_text(path, IDLE, ok)
    if (.not. ok) call messages%add(path//': cannot be set back to nothing')
  end function poll_control

  !> Returns the value of the key runtime_control, empty if there is none (an editor may be writing the file at this moment).
  function control_wish(path) result(wish)
    character(*), intent(in) :: path
    character(:), allocatable :: wish, line
    integer :: unit, status, equals
    logical :: found, inside
    wish = ''
    open (newunit=unit, file=path, status='old', action='read', iostat=status)
    if (status /= 0) return
    inside = .false.
    do
      call read_line(unit, line, found)
      if (.not. found) exit
      line = trim(adjustl(line))
      if (index(line, '[') == 1) inside = index(line, '[runtime_control]') == 1
      equals = index(line, '=')
      if (.not. inside .or. equals == 0) cycle
      if (line(:equals - 1) /= 'runtime_control') cycle
      wish = line(equals + 1:)
      if (index(wish, ';') > 0) wish = wish(:index(wish, ';') - 1)
      wish = trim(adjustl(wish))
      exit
    end do
    close (unit)
  end function control_wish
end module io_control

! SPDX-License-Identifier: GPL-3.0-or-later
!> Sorts the arguments of a program: files, at most one option that chooses an action, and options that modify the action.
module common_arguments
  use base_errors, only: message_list_t
  implicit none
  private
  public :: arguments_t, parse_arguments, print_lines

  !> Holds the arguments that were found.
  type :: arguments_t
    integer :: action = 0                     !< index of the action in `actions`; 0: none was given
    logical, allocatable :: has_flag(:)       !< for each of the flags
    logical :: is_final = .false.             !< the action is --help, --version or a reference, which ignores all other arguments
    logical :: restart = .false.
    logical :: overwrite = .false.            !< move the results of an earlier run to another folder
    logical :: accepts = .false.              !< a restart accepts inputs that do not fit the checkpoint
    character(:), allocatable :: restart_file !< empty: the newest valid backup
    integer :: n_files = 0
    character(:), allocatable :: file, other_file !< the first two; empty if not given
  end type arguments_t

contains

  !> Sorts the arguments of the program into `arguments`. The user may give at most one of `actions`. An exception are final actions
  !> (--help, also as -h, --version, --parameters, --causes), which the program must list in `actions` too. The user may give any
  !> number of `flags`. If `takes_restart`, it also accepts --restart, --restart=FILE, --overwrite and
  !> --accept-changes. Adds every mistake to `errors`, but leaves it to the caller to report too many or missing files.
  subroutine parse_arguments(actions, flags, takes_restart, arguments, errors)
    character(*), intent(in) :: actions(:), flags(:)
    logical, intent(in) :: takes_restart
    type(arguments_t), intent(out) :: arguments
    type(message_list_t), intent(inout) :: errors
    character(*), parameter :: RESTART_FROM = '--restart='
    character(:), allocatable :: argument
    integer :: i, number
    arguments%restart_file = ''
    arguments%file = ''
    arguments%other_file = ''
    allocate (arguments%has_flag(size(flags)), source=.false.)
    do i = 1, command_argument_count()
      argument = argument_text(i)
      if (argument == '-h') argument = '--help'
      number = position(argument, actions)
      if (number > 0) then
        arguments%is_final = any(argument == [character(12) :: '--help', '--version', '--parameters', '--causes'])
        if (arguments%action > 0 .and. arguments%action /= number .and. .not. arguments%is_final) &
          call errors%add('"'//argument//'" contradicts "'//trim(actions(arguments%action))//'"')
        arguments%action = number
        if (arguments%is_final) return
      else if (position(argument, flags) > 0) then
        arguments%has_flag(position(argument, flags)) = .true.
      else if (takes_restart .and. argument == '--restart') then
        arguments%restart = .true.
      else if (takes_restart .and. index(argument, RESTART_FROM) == 1) then
        arguments%restart = .true.
        arguments%restart_file = argument(len(RESTART_FROM) + 1:)
        if (arguments%restart_file == '') call errors%add('--restart= needs the name of a backup')
      else if (takes_restart .and. argument == '--overwrite') then
        arguments%overwrite = .true.
      else if (takes_restart .and. argument == '--accept-changes') then
        arguments%accepts = .true.
      else if (index(argument, '-') == 1) then
        call errors%add('unknown argument "'//argument//'"')
      else
        arguments%n_files = arguments%n_files + 1
        if (arguments%n_files == 1) arguments%file = argument
        if (arguments%n_files == 2) arguments%other_file = argument
      end if
    end do
    if (arguments%overwrite .and. arguments%restart) call errors%add('--overwrite contradicts --restart: give one of them')
    if (arguments%accepts .and. .not. arguments%restart) call errors%add('--accept-changes is valid with --restart only')
  end subroutine parse_arguments

  !> Returns the position of `name` in `names`, or 0 if it is not there.
  pure integer function position(name, names)
    character(*), intent(in) :: name, names(:)
    do position = size(names), 1, -1
      if (name == names(position)) return
    end do
  end function position

  !> Returns argument i in its full length, or '' if there is none.
  function argument_text(i) result(text)
    integer, intent(in) :: i
    character(:), allocatable :: text
    integer :: length
    call get_command_argument(i, length=length)
    allocate (character(length) :: text)
    call get_command_argument(i, text)
  end function argument_text

  !> Writes lines to `unit` without trailing blanks.
  subroutine print_lines(unit, lines)
    integer, intent(in) :: unit
    character(*), intent(in) :: lines(:)
    integer :: i
    do i = 1, size(lines)
      write (unit, '(a)') trim(lines(i))
    end do
  end subroutine print_lines
end module common_arguments

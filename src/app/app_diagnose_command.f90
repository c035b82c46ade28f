! SPDX-License-Identifier: GPL-3.0-or-later
!> The command line of `msm_diagnose`.
module app_diagnose_command
  use app_arguments, only: argument_text
  use base_errors, only: message_list_t
  implicit none
  private
  public :: diagnose_command_t, parse_diagnose_command, print_diagnose_usage

  integer, parameter, public :: DIAGNOSE_RUN = 1, DIAGNOSE_CHECK = 2, DIAGNOSE_PLAN = 3, DIAGNOSE_HELP = 4, &
                                DIAGNOSE_VERSION = 5, DIAGNOSE_PARAMETERS = 6

  !> What the user wants.
  type :: diagnose_command_t
    integer :: action = DIAGNOSE_RUN
    character(:), allocatable :: ini !< parameter file
  end type diagnose_command_t

contains

  !> Reads the arguments; every mistake is added to `errors`.
  subroutine parse_diagnose_command(command, errors)
    type(diagnose_command_t), intent(out) :: command
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: argument
    integer :: i
    command%ini = ''
    do i = 1, command_argument_count()
      argument = argument_text(i)
      select case (argument)
      case ('--help', '-h')
        command%action = DIAGNOSE_HELP
        return
      case ('--version')
        command%action = DIAGNOSE_VERSION
        return
      case ('--parameters')
        command%action = DIAGNOSE_PARAMETERS
        return
      case ('--check')
        call choose(DIAGNOSE_CHECK)
      case ('--plan')
        call choose(DIAGNOSE_PLAN)
      case default
        if (index(argument, '-') == 1) then
          call errors%add('unknown argument "'//argument//'"')
        else if (command%ini /= '') then
          call errors%add('too many file names')
        else
          command%ini = argument
        end if
      end select
    end do
    if (command%ini == '') call errors%add('the name of a parameter file is missing')

  contains

    subroutine choose(action)
      integer, intent(in) :: action
      if (command%action /= DIAGNOSE_RUN .and. command%action /= action) &
        call errors%add('"'//argument//'" contradicts an argument before it')
      command%action = action
    end subroutine choose
  end subroutine parse_diagnose_command

  !> Writes how the program is called.
  subroutine print_diagnose_usage(unit)
    integer, intent(in) :: unit
    character(*), parameter :: LINES(14) = [character(84) :: &
                                            'usage: mpirun -n RANKS msm_diagnose FILE.ini [options]', &
                                            '', &
                                          '  --check             print every effective value and where it comes from', &
                                            '  --plan              what the loads of the measurement could show', &
                                            '  --parameters        print the reference of all parameters (Markdown)', &
                                            '  --version           print version, commit, compiler and flags', &
                                            '  --help              print this', &
                                            '', &
                                       'exit codes: 0 adequate, --plan or --check     1 defect of program or machine', &
                                            '           10 one cause is named              2 mistake in the input', &
                                            '           11 several causes are possible     3 numerical failure', &
                                            '           12 a cause that is not in the catalogue', &
                                            '           20 not enough data', &
                                            'parameters: docs/parameters.md, example: ini/diagnose.ini']
    integer :: i
    do i = 1, size(LINES)
      write (unit, '(a)') trim(LINES(i))
    end do
  end subroutine print_diagnose_usage
end module app_diagnose_command

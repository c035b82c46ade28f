! SPDX-License-Identifier: GPL-3.0-or-later
!> The command line of `msm_train`.
module app_train_command
  use app_arguments, only: argument_text
  use base_errors, only: message_list_t
  implicit none
  private
  public :: train_command_t, parse_train_command, print_train_usage

  integer, parameter, public :: TRAIN_RUN = 1, TRAIN_CHECK = 2, TRAIN_EVALUATE = 3, TRAIN_SCREEN = 4, TRAIN_HELP = 5, &
                                TRAIN_VERSION = 6, TRAIN_PARAMETERS = 7

  !> What the user wants.
  type :: train_command_t
    integer :: action = TRAIN_RUN
    character(:), allocatable :: ini          !< parameter file
    logical :: restart = .false.
    character(:), allocatable :: restart_file !< empty: the newest valid backup
  end type train_command_t

contains

  !> Reads the arguments; every mistake is added to `errors`.
  subroutine parse_train_command(command, errors)
    type(train_command_t), intent(out) :: command
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: argument
    integer :: i
    command%ini = ''
    command%restart_file = ''
    do i = 1, command_argument_count()
      argument = argument_text(i)
      select case (argument)
      case ('--help', '-h')
        command%action = TRAIN_HELP
        return
      case ('--version')
        command%action = TRAIN_VERSION
        return
      case ('--parameters')
        command%action = TRAIN_PARAMETERS
        return
      case ('--check')
        call choose(TRAIN_CHECK)
      case ('--evaluate')
        call choose(TRAIN_EVALUATE)
      case ('--screen')
        call choose(TRAIN_SCREEN)
      case ('--restart')
        command%restart = .true.
      case default
        if (index(argument, '--restart=') == 1) then
          command%restart = .true.
          command%restart_file = argument(11:)
          if (command%restart_file == '') call errors%add('--restart= needs the name of a backup')
        else if (index(argument, '-') == 1) then
          call errors%add('unknown argument "'//argument//'"')
        else if (command%ini /= '') then
          call errors%add('too many file names')
        else
          command%ini = argument
        end if
      end select
    end do
    if (command%ini == '') call errors%add('the name of a parameter file is missing')
    if (command%restart .and. command%action /= TRAIN_RUN) call errors%add('--restart goes with a run')

  contains

    subroutine choose(action)
      integer, intent(in) :: action
      if (command%action /= TRAIN_RUN .and. command%action /= action) &
        call errors%add('"'//argument//'" contradicts an argument before it')
      command%action = action
    end subroutine choose
  end subroutine parse_train_command

  !> Writes how the program is called.
  subroutine print_train_usage(unit)
    integer, intent(in) :: unit
    character(*), parameter :: LINES(15) = [character(84) :: &
                                            'usage: mpirun -n RANKS msm_train FILE.ini [options]', &
                                            '', &
                                          '  --check             print every effective value and where it comes from', &
                                            '  --evaluate          print the cost of the wing as [Wing] has it', &
                                  '  --screen            rank veins and joints by their effect on the measured loads', &
                                            '  --restart[=FILE]    go on from the newest valid backup, or from FILE', &
                                            '  --parameters        print the reference of all parameters (Markdown)', &
                                            '  --version           print version, commit, compiler and flags', &
                                            '  --help              print this', &
                                            '', &
                                    'exit codes: 0 the training reached its end     3 numerical failure, backup kept', &
                                     '            1 defect of program or machine  4 stopped early with a checkpoint:', &
                                           '            2 mistake in the input            start again with --restart', &
                                            '', &
                                            'parameters: docs/parameters.md, example: ini/train.ini']
    integer :: i
    do i = 1, size(LINES)
      write (unit, '(a)') trim(LINES(i))
    end do
  end subroutine print_train_usage
end module app_train_command

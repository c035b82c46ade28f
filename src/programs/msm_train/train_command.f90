! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the command line of `msm_train`.
module train_command
  use base_errors, only: message_list_t
  use common_arguments, only: arguments_t, parse_arguments, print_lines
  implicit none
  private
  public :: train_command_t, parse_train_command, print_train_usage

  integer, parameter, public :: TRAIN_RUN = 1, TRAIN_CHECK = 2, TRAIN_EVALUATE = 3, TRAIN_SCREEN = 4, TRAIN_HELP = 5, &
                                TRAIN_VERSION = 6, TRAIN_PARAMETERS = 7
  !> The options are in the order of the action numbers above, from the second number on.
  character(12), parameter :: ACTIONS(6) = [character(12) :: '--check', '--evaluate', '--screen', '--help', &
                                                                                            '--version', '--parameters']

  !> The command holds what the user asks for.
  type :: train_command_t
    integer :: action = TRAIN_RUN
    character(:), allocatable :: ini          !< parameter file
    logical :: restart = .false.
    character(:), allocatable :: restart_file !< empty: the newest valid backup
    logical :: overwrite = .false.            !< move the results of an earlier run to another folder
    logical :: accepts = .false.              !< a restart accepts inputs that do not fit the checkpoint
  end type train_command_t

contains

  !> Reads the command line into `command`. Every mistake is added to `errors`.
  subroutine parse_train_command(command, errors)
    type(train_command_t), intent(out) :: command
    type(message_list_t), intent(inout) :: errors
    type(arguments_t) :: arguments
    call parse_arguments(ACTIONS, [character(0) ::], .true., arguments, errors)
    command%action = TRAIN_RUN + arguments%action
    command%ini = arguments%file
    command%restart = arguments%restart
    command%restart_file = arguments%restart_file
    command%overwrite = arguments%overwrite
    command%accepts = arguments%accepts
    if (arguments%is_final) return
    if (arguments%n_files > 1) call errors%add('too many file names')
    if (arguments%n_files < 1) call errors%add('the name of a parameter file is missing')
    if (command%restart .and. command%action /= TRAIN_RUN) call errors%add('--restart is valid for a run only')
    if (command%overwrite .and. command%action /= TRAIN_RUN) call errors%add('--overwrite is valid for a run only')
  end subroutine parse_train_command

  !> Prints on `unit` how the program is called.
  subroutine print_train_usage(unit)
    integer, intent(in) :: unit
    character(*), parameter :: LINES(18) = [character(84) :: &
                                            'usage: mpirun -n RANKS msm_train FILE.ini [options]', &
                                            '', &
                                          '  --check             print every effective value and where it comes from', &
                                            '  --evaluate          print the cost of the wing with the values of [Wing]', &
                                  '  --screen            rank veins and joints by their effect on the measured loads', &
                                            '  --restart[=FILE]    continue from the newest valid backup, or from FILE', &
                                         '  --accept-changes    with --restart: accept inputs that do not fit the backup', &
                                         '  --overwrite         start from the beginning; move an earlier run aside', &
                                            '  --parameters        print the reference of all parameters (Markdown)', &
                                            '  --version           print version, commit, compiler and flags', &
                                            '  --help              print this', &
                                            '', &
                                    'exit codes: 0 the training reached its end     3 numerical failure, backup kept', &
                                     '            1 defect of the program         4 stopped early with a checkpoint:', &
                                           '            2 mistake in the input            start again with --restart', &
                            '            5 files cannot be written: the disk is full, or the folder read-only', &
                                            '', &
                                            'parameters: docs/formats/parameters.md, example: ini/train.ini']
    call print_lines(unit, LINES)
  end subroutine print_train_usage
end module train_command

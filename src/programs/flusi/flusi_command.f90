! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the command line of `flusi`.
module flusi_command
  use base_errors, only: message_list_t
  use common_arguments, only: arguments_t, parse_arguments, print_lines
  use simulation_start, only: simulation_start_t
  implicit none
  private
  public :: command_t, parse_command_line, print_usage
  public :: ACTION_RUN, ACTION_CHECK, ACTION_DRY_RUN, ACTION_VERSION, ACTION_HELP, ACTION_KEYVALUES, &
            ACTION_COMPARE_KEYS, ACTION_PARAMETERS, ACTION_STATIC, ACTION_STATIC_CHECK, ACTION_SOLID, ACTION_SOLID_CHECK

  integer, parameter :: ACTION_RUN = 1, ACTION_CHECK = 2, ACTION_DRY_RUN = 3, ACTION_VERSION = 4, ACTION_HELP = 5, &
                        ACTION_KEYVALUES = 6, ACTION_COMPARE_KEYS = 7, ACTION_PARAMETERS = 8, ACTION_STATIC = 9, &
                        ACTION_STATIC_CHECK = 10, ACTION_SOLID = 11, ACTION_SOLID_CHECK = 12
  !> These options select the actions above, from the second to the eighth, in the same order.
  character(14), parameter :: ACTIONS(7) = [character(14) :: '--check', '--dry-run', '--version', '--help', &
                                                                        '--keyvalues', '--compare-keys', '--parameters']

  !> Holds what the user asks for on the command line.
  type, extends(simulation_start_t) :: command_t
    integer :: action = ACTION_RUN
    logical :: flusi_compat = .false.         !< duplicate keys: the first wins
    logical :: postprocess = .false.          !< called as FLUSI is called; results are written to files
    character(:), allocatable :: file, other_file
  end type command_t

contains

  !> Reads the arguments of the program into `command`. Adds one message to `errors` for every mistake.
  subroutine parse_command_line(command, errors)
    type(command_t), intent(out) :: command
    type(message_list_t), intent(inout) :: errors
    character(*), parameter :: FLAGS(5) = [character(14) :: '--static', '--solid', '--flusi-compat', &
                                                                                                  '--postprocess', '-p']
    type(arguments_t) :: arguments
    call parse_arguments(ACTIONS, FLAGS, .true., arguments, errors)
    command%action = ACTION_RUN + arguments%action
    command%ini = ''
    command%file = arguments%file
    command%other_file = arguments%other_file
    command%restart = arguments%restart
    command%restart_file = arguments%restart_file
    command%overwrite = arguments%overwrite
    command%accepts = arguments%accepts
    if (arguments%is_final) return
    command%flusi_compat = arguments%has_flag(3)
    command%postprocess = any(arguments%has_flag(4:5))
    associate (is_static => arguments%has_flag(1), is_solid => arguments%has_flag(2))
      if (is_static .and. is_solid) call errors%add('--solid contradicts --static: give one of them')
      if (is_static) call choose_wing_alone(command, '--static', ACTION_STATIC, ACTION_STATIC_CHECK, errors)
      if (is_solid .and. .not. is_static) &
        call choose_wing_alone(command, '--solid', ACTION_SOLID, ACTION_SOLID_CHECK, errors)
    end associate
    call check_files(command, arguments%n_files, errors)
  end subroutine parse_command_line

  !> Changes the action if --static or --solid is given.
  subroutine choose_wing_alone(command, argument, to_run, to_check, errors)
    type(command_t), intent(inout) :: command
    character(*), intent(in) :: argument
    integer, intent(in) :: to_run, to_check
    type(message_list_t), intent(inout) :: errors
    select case (command%action)
    case (ACTION_RUN)
      command%action = to_run
    case (ACTION_CHECK)
      command%action = to_check
    case default
      call errors%add(argument//' goes with '//trim(merge('--check, --restart and --flusi-compat', &
                                                          '--check and --flusi-compat           ', &
                                                          to_run == ACTION_SOLID))//' only')
    end select
  end subroutine choose_wing_alone

  !> Checks that the command line names as many files as its action needs.
  subroutine check_files(command, n_files, errors)
    type(command_t), intent(inout) :: command
    integer, intent(in) :: n_files
    type(message_list_t), intent(inout) :: errors
    integer :: wanted
    wanted = merge(2, 1, command%action == ACTION_COMPARE_KEYS)
    if (n_files > wanted) call errors%add('too many file names')
    select case (command%action)
    case (ACTION_KEYVALUES)
      if (n_files < 1) call errors%add('--keyvalues needs the name of an HDF5 field')
    case (ACTION_COMPARE_KEYS)
      if (n_files < 2) call errors%add('--compare-keys needs the names of two key files')
    case default
      if (command%postprocess) call errors%add('--postprocess knows --keyvalues and --compare-keys; '// &
        'FLUSI''s other tools are in tools/postprocess: docs/guide/post-processing.md')
      if (n_files < 1) call errors%add('the name of a parameter file is missing')
      command%ini = command%file
    end select
    if (command%restart .and. all(command%action /= [ACTION_RUN, ACTION_DRY_RUN, ACTION_SOLID])) &
      call errors%add('--restart is valid for a run only')
    if (command%overwrite .and. all(command%action /= [ACTION_RUN, ACTION_SOLID])) &
      call errors%add('--overwrite is valid for a run only')
  end subroutine check_files

  !> Writes to `unit` how the program is called.
  subroutine print_usage(unit)
    integer, intent(in) :: unit
    character(*), parameter :: LINES(25) = [character(84) :: &
                                            'usage: mpirun -n RANKS flusi FILE.ini [options]', &
                                            '', &
                                          '  --check             print every effective value and where it comes from', &
                                 '  --dry-run           print memory, time step, steps and output files; run nothing', &
                                            '  --restart[=FILE]    continue from the newest valid backup, or from FILE', &
                                         '  --accept-changes    with --restart: accept inputs that do not fit the backup', &
                                         '  --overwrite         start from the beginning; move an earlier run aside', &
                                        '  --flusi-compat      if a key is given twice, the first counts, as in FLUSI', &
                                            '  --parameters        print the reference of all parameters (Markdown)', &
                                            '  --version           print version, commit, compiler and flags', &
                                            '  --help              print this', &
                                            '', &
                               '       flusi --static FILE.ini [--check]           shape of a wing under given loads', &
                                '       flusi --solid FILE.ini [--check|--restart]  motion of a wing without a fluid', &
                                            '       flusi [--postprocess] --keyvalues FIELD.h5', &
                                            '       flusi [--postprocess] --compare-keys A.key B.key', &
                                            '', &
                                   'exit codes: 0 the run reached its end       3 numerical failure, checkpoint kept', &
                                     '            1 defect of the program         4 stopped early with a checkpoint:', &
                                           '            2 mistake in the input            start again with --restart', &
                            '            5 files cannot be written: the disk is full, or the folder read-only', &
                            '              or missing; what was complete before is kept', &
                            '            6 the machine has not enough memory', &
                                            '', &
                                            'parameters: docs/formats/parameters.md, examples: ini/']
    call print_lines(unit, LINES)
  end subroutine print_usage
end module flusi_command

! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the command line of `msm_diagnose`.
module diagnose_command
  use base_errors, only: message_list_t
  use base_named_kinds, only: word_of
  use common_arguments, only: arguments_t, parse_arguments, print_lines
  use common_diagnose_keys, only: REFINES, REFINE_AUTO, REFINE_FIT, REFINE_NO, REFINE_UNSTATED, REFINE_YES
  implicit none
  private
  public :: diagnose_command_t, parse_diagnose_command, print_diagnose_usage

  integer, parameter, public :: DIAGNOSE_RUN = 1, DIAGNOSE_CHECK = 2, DIAGNOSE_PLAN = 3, DIAGNOSE_HELP = 4, &
                                DIAGNOSE_VERSION = 5, DIAGNOSE_PARAMETERS = 6, DIAGNOSE_CAUSES = 7
  !> The options are in the order of the action numbers above, from the second number on.
  character(12), parameter :: ACTIONS(6) = [character(12) :: '--check', '--plan', '--help', '--version', '--parameters', '--causes']

  !> The command holds what the user asks for.
  type :: diagnose_command_t
    integer :: action = DIAGNOSE_RUN
    character(:), allocatable :: ini !< parameter file
    integer :: refine = REFINE_UNSTATED !< REFINE_*, instead of [Diagnose] refine
    logical :: is_again = .false.       !< the same input is read once more: its notices were printed
    logical :: wants_code = .false.     !< the exit code of a diagnosis is that of its verdict, and not 0
  end type diagnose_command_t

contains

  !> Reads the command line into `command`. Every mistake is added to `errors`.
  subroutine parse_diagnose_command(command, errors)
    type(diagnose_command_t), intent(out) :: command
    type(message_list_t), intent(inout) :: errors
    type(arguments_t) :: arguments
    integer, parameter :: N = 6
    character(13), parameter :: FLAGS(N + 1) = [character(13) :: &
                                '--refine', '--refine=yes', '--refine=fit', '--refine=no', '--no-refine', &
                                '--refine=auto', '--exit-code']
    integer, parameter :: CHOICES(N) = [REFINE_YES, REFINE_YES, REFINE_FIT, REFINE_NO, REFINE_NO, REFINE_AUTO]
    integer :: i
    call parse_arguments(ACTIONS, FLAGS, .false., arguments, errors)
    command%action = DIAGNOSE_RUN + arguments%action
    command%ini = arguments%file
    command%wants_code = arguments%has_flag(N + 1)
    if (arguments%is_final) return
    do i = 1, N
      if (.not. arguments%has_flag(i)) cycle
      if (all(command%refine /= [REFINE_UNSTATED, CHOICES(i)])) &
        call errors%add('"'//trim(FLAGS(i))//'" contradicts refine = '//word_of(REFINES, command%refine))
      command%refine = CHOICES(i)
    end do
    if (arguments%n_files > 1) call errors%add('too many file names')
    if (arguments%n_files < 1) call errors%add('the name of a parameter file is missing')
  end subroutine parse_diagnose_command

  !> Prints on `unit` how the program is called.
  subroutine print_diagnose_usage(unit)
    integer, intent(in) :: unit
    character(*), parameter :: LINES(23) = [character(84) :: &
                                            'usage: mpirun -n RANKS msm_diagnose FILE.ini [options]', &
                                            '', &
                                          '  --check             print every effective value and where it comes from', &
                                  '  --plan              predict what the loads can show; no heights are needed', &
                                            '  --refine            count the effect of the mesh as an error', &
                                            '  --refine=fit        as --refine, and fit everything on the finer mesh', &
                                            '  --refine=auto       the one or the other, as the error of the mesh demands', &
                                            '  --refine=no, or', &
                                            '  --no-refine         count no error of the mesh: the data come from the same mesh', &
                                            '  --exit-code         end a diagnosis with the exit code of its verdict', &
                                            '  --parameters        print the reference of all parameters (Markdown)', &
                                            '  --causes            print the reference of all causes (Markdown)', &
                                            '  --version           print version, commit, compiler and flags', &
                                            '  --help              print this', &
                                            '', &
                                            'exit codes: 0 done, whatever the verdict is         1 defect of the program', &
                                            '            2 mistake in the input                  3 numerical failure', &
                                            '            5 files cannot be written', &
                                            'exit codes of verdicts, with --exit-code:', &
                                            '            0 adequate                             10 one cause is named', &
                                            '           11 several causes are possible          12 not in the catalogue', &
                                            '           20 not enough data', &
                                            'parameters: docs/formats/parameters.md, example: ini/diagnose.ini']
    call print_lines(unit, LINES)
  end subroutine print_diagnose_usage
end module diagnose_command

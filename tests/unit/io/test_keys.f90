! SPDX-License-Identifier: GPL-3.0-or-later
!> One statement for each key: the same procedure declares keys with default, range and help, and reads them.
program test_keys
  use base_errors, only: message_list_t
  use base_kinds, only: i8, rp
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10)

  type :: choices_t
    integer :: most = -7
    integer(i8) :: seed = -7
    real(rp) :: step = -7, wall = -7, axis(3) = -7
    logical :: saves = .false.
    character(:), allocatable :: method, path, kept
    real(rp) :: edge = -7, gap = -7, size = -7
    logical :: has_edge = .false., has_most = .false., has_path = .false., moves = .false., old = .false.
    real(rp), allocatable :: series(:), rows(:, :)
  end type choices_t

  type(testkit_t) :: t
  type(registry_t), target :: registry
  type(config_t), target :: config
  type(message_list_t) :: errors, notices
  type(keys_t) :: keys
  type(choices_t) :: c
  call t%start(parallel=.false.)
  keys = declaring(registry)
  call all_keys(keys, c)
  call t%check('what declares keys leaves the variables as they are', c%most == -7 .and. c%seed == -7 .and. &
               .not. c%saves .and. .not. allocated(c%method))

  call load('')
  call t%check('variables get defaults', c%most == 5 .and. c%seed == 1 .and. c%saves .and. c%method == 'fast')
  call t%check_close('in the unit of the variable', c%wall, 7200.0_rp, 0.0_rp)
  call t%check_close('three reals', norm2(c%axis - [0, 0, 1]), 0.0_rp, 0.0_rp)
  call t%check('a default that the program works out leaves the variable', c%path == 'out' .and. .not. allocated(c%kept))

  call load('[Search]'//NL//'most = 3'//NL//'seed = 2000000000'//NL//'step = 0.25'//NL//'wall = 1.5'//NL//'axis = 1 2 3'//NL// &
            '[Saving]'//NL//'saves = no'//NL//'method = slow'//NL//'path = there'//NL//'kept = here'//NL)
  call t%check('variables get what the file says', c%most == 3 .and. c%seed == 2000000000_i8 .and. .not. c%saves .and. &
               c%method == 'slow' .and. c%path == 'there' .and. c%kept == 'here')
  call t%check_close('with their unit', c%wall, 5400.0_rp, 0.0_rp)
  call t%check_close('a list', norm2(c%axis - [1, 2, 3]), 0.0_rp, 0.0_rp)
  call t%check_close('a real', c%step, 0.25_rp, 0.0_rp)

  call load('[Search]'//NL//'most = 11'//NL//'step = 0'//NL//'[Saving]'//NL//'method = slower'//NL)
  call t%check('ranges and words hold', errors%count() == 3)

  call load('')
  call t%check('a length that the program works out leaves the variable, another has its default', &
               c%edge <= -7 .and. abs(c%gap - 0.5_rp) <= 0)
  call t%check('a switch that the program works out leaves the variable', .not. c%moves)
  call t%check('nothing is given', .not. (c%has_edge .or. c%has_most .or. c%has_path))
  call t%check('a list and a matrix that are not given have their defaults', size(c%series) == 2 .and. size(c%rows, 1) == 0)
  call load('[Search]'//NL//'most = 5'//NL//'edge = 3'//NL//'gap = 4'//NL//'series = 1 2 3'//NL//'rows = (/1 2'//NL//'3 4'//NL// &
            '5 6/)'//NL//'moves = yes'//NL//'ancient = yes'//NL//'nothing = 7'//NL//'[Saving]'//NL//'path = out'//NL)
  call t%check('all of this is right', errors%count() == 0)
  call t%check('what is given is known as given, though it is the default', c%has_edge .and. c%has_most .and. c%has_path)
  call t%check('lengths and switches that are given count', abs(c%edge - 3) <= 0 .and. abs(c%gap - 4) <= 0 .and. c%moves)
  call t%check('a list of any length', size(c%series) == 3)
  call t%check('a matrix, (row, column)', all(shape(c%rows) == [3, 2]) .and. abs(c%rows(3, 1) - 5) <= 0)
  call t%check('an older name stands for the key before it', c%old)
  call check_state_keys()
  call load('[Search]'//NL//'most = 11'//NL//'old = maybe'//NL//'gap = -1'//NL//'[Saving]'//NL//'method = golden'//NL)
  call t%check('words that are not built, lengths and switches hold, and wrong values are not given', errors%count() == 4 .and. &
               .not. c%has_most)
  call t%finish()

contains

  !> What a checkpoint depends on: all keys of a section, and the key before the statement.
  subroutine check_state_keys()
    type(message_list_t) :: patterns
    patterns = config%state_keys()
    call t%check('a section and a key belong to the state', patterns%count() == 2)
    if (patterns%count() == 2) call t%check('by their names', patterns%text(1) == '[Box] *' .and. &
                                            patterns%text(2) == '[Search] old')
  end subroutine check_state_keys

  subroutine all_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(choices_t), intent(inout) :: c
    call keys%section('Search', 'for something')
    call keys%integer('most', c%most, 5, 'of all', min=1, max=10, given=c%has_most)
    call keys%integer('seed', c%seed, 1, 'of random numbers', min=0)
    call keys%real('step', c%step, 0.5_rp, 'the first', unit='m', above=0.0_rp)
    call keys%real('wall', c%wall, 2.0_rp, 'time', unit='h', min=0.0_rp, scale=3600.0_rp)
    call keys%reals('axis', c%axis, [0.0_rp, 0.0_rp, 1.0_rp], 'of the turn', unit='m')
    call keys%length('edge', c%edge, 'as long as need be', 'of a triangle', unit='m', above=0.0_rp, given=c%has_edge)
    call keys%length('gap', c%gap, '0.5', 'between two', unit='m', min=0.0_rp)
    call keys%list('series', c%series, [1.0_rp, 2.0_rp], 'of numbers')
    call keys%matrix('rows', c%rows, 2, 'of pairs')
    call keys%switch('moves', c%moves, .false., 'or rests', computed='as the wind blows')
    call keys%switch('old', c%old, .false., 'of long ago')
    call keys%in_checkpoint()
    call keys%older_name('ancient')
    call keys%inert('nothing', 'of another program')
    call keys%section('Saving')
    call keys%switch('saves', c%saves, .true., 'or not')
    call keys%word('method', c%method, 'fast', 'fast|slow', 'of saving', unbuilt='golden')
    call keys%text('path', c%path, 'out', 'of the file', given=c%has_path)
    call keys%text('kept', c%kept, 'what the program chooses', 'of another', computed=.true.)
    call keys%section('Box', 'of the flow', in_checkpoint=.true.)
    call keys%real('size', c%size, 1.0_rp, 'of its sides', unit='m')
  end subroutine all_keys

  subroutine load(text)
    character(*), intent(in) :: text
    type(choices_t) :: fresh
    type(message_list_t) :: none
    errors = none
    c = fresh
    call config%load_text(text, 'keys.ini', registry, errors, notices, .false.)
    keys = reading(config)
    call all_keys(keys, c)
  end subroutine load
end program test_keys

! SPDX-License-Identifier: GPL-3.0-or-later
!> Files that a parameter file names: found here or beside it, read by root, the same on all ranks.
program test_broadcast_text
  use io_broadcast_text, only: named_path, read_named_text, read_broadcast_text
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = new_line('a')
  type(testkit_t) :: t
  character(:), allocatable :: path, text, problem, folder

  call t%start(parallel=.true.)
  ! Folders are made by the build (CMakeLists.txt); the first argument is one beside the working directory.
  call get_folder()
  if (t%world%is_root) then
    call write_file('here.txt', 'here')
    call write_file('both.txt', 'here too')
    call write_file(folder//'/both.txt', 'there too')
    call write_file(folder//'/beside.txt', 'beside')
  end if
  call t%world%barrier()
  call read_broadcast_text('here.txt', text, problem, t%world)
  call t%check('a file is read',.not. allocated(problem) .and. same(text, 'here'//NL))
  call read_broadcast_text('nowhere.txt', text, problem, t%world)
  call t%check('a missing file is a problem on all ranks, with empty text', allocated(problem) .and. same(text, ''))
  if (allocated(problem)) call t%check('which names it', index(problem, 'nowhere.txt') > 0)
  text = 'here'//NL
  if (t%world%is_root) call read_broadcast_text('here.txt', text, problem)
  call t%check('without a world one rank reads alone', same(text, 'here'//NL))

  call named('beside.txt', folder//'/run.ini', folder//'/beside.txt', 'beside')
  call named('both.txt', folder//'/run.ini', 'both.txt', 'here too')
  call named('here.txt', 'run.ini', 'here.txt', 'here')
  call read_named_text('nowhere.txt', folder//'/run.ini', path, text, problem, t%world)
  call t%check('a name that leads nowhere is a problem that names both', allocated(problem) .and. path == '')
  if (allocated(problem)) call t%check('the file and the parameter file', index(problem, 'nowhere.txt') > 0 .and. &
                                       index(problem, folder//'/run.ini') > 0)
  call t%check('an absolute name is not looked for elsewhere', &
               named_path('/beside.txt', folder//'/run.ini', t%world) == '')
  call t%finish()

contains

  subroutine named(name, ini, want, content)
    character(*), intent(in) :: name, ini, want, content
    call read_named_text(name, ini, path, text, problem, t%world)
    call t%check(name//' named by '//ini(index(ini, '/', back=.true.) + 1:)//' is the right one', &
                 .not. allocated(problem) .and. path == want .and. same(text, content//NL))
  end subroutine named

  !> Whether the texts are equal on all ranks.
  logical function same(a, b)
    character(*), intent(in) :: a, b
    same = t%world%max_integer(merge(0, 1, same_here(a, b))) == 0
  end function same

  logical function same_here(a, b)
    character(*), intent(in) :: a, b
    same_here = len(a) == len(b) .and. a == b
  end function same_here

  subroutine write_file(name, content)
    character(*), intent(in) :: name, content
    integer :: unit
    open (newunit=unit, file=name, status='replace')
    write (unit, '(a)') content
    close (unit)
  end subroutine write_file

  subroutine get_folder()
    character(1000) :: argument
    call get_command_argument(1, argument)
    folder = trim(argument)
  end subroutine get_folder
end program test_broadcast_text

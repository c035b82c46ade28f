! SPDX-License-Identifier: GPL-3.0-or-later
!> Files that cannot be written, moved or removed are failures, whose reasons name them; what is there already stays.
program test_files
  use base_errors, only: failure_t
  use base_files, only: empty_file, file_exists, make_folder, remove_file, rename_file, replace_file
  use base_text_file, only: reserve_space, text_file_t, write_text
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_text()
  call test_stream()
  call test_names()
  call t%finish()

contains

  subroutine test_text()
    type(failure_t) :: good, missing, unreserved, there, taken, late
    call write_text('text.txt', 'one', good)
    call t%check('a text is written', .not. good%failed .and. content('text.txt') == 'one')
    call write_text('no/such/folder.txt', 'two', missing)
    call t%check('a missing folder is a failure that names the file', &
                 says(missing, 'no/such/folder.txt: cannot be written; is the folder missing or read-only'))
    call late%raise('something else')
    call write_text('text.txt', 'three', late)
    call t%check('a text is written also after a failure', content('text.txt') == 'three' .and. says(late, 'something else'))
    call reserve_space('reserved', 4, good)
    call t%check('space is reserved', .not. good%failed .and. file_exists('reserved'))
    call remove_file('reserved')
    call reserve_space('no/such/folder', 4, unreserved)
    call t%check('but not in a folder that is missing', says(unreserved, 'no/such/folder: cannot be written'))
    call make_folder('taken', there) ! perhaps of an earlier run of this test
    call write_text('taken', 'text', taken)
    call t%check('a folder is not replaced by a text', says(taken, 'taken: cannot be written') .and. file_exists('taken/.'))
    call t%check('and no part of it stays', .not. file_exists('taken.part'))
  end subroutine test_text

  subroutine test_stream()
    type(text_file_t) :: file
    type(failure_t) :: failure, late, full
    call file%create('stream.txt', failure)
    call file%write('a', failure)
    call file%close(failure)
    call file%append('stream.txt', failure)
    call file%write('b', failure)
    call file%flush(failure)
    call file%close(failure)
    call file%close(failure)
    call t%check('a file grows', .not. failure%failed .and. content('stream.txt') == 'ab')
    call file%create_new('stream.txt', failure)
    call t%check('it is not created anew', says(failure, 'stream.txt: cannot be written') .and. .not. file%is_open())
    call late%raise('something else')
    call file%create('stream.txt', late)
    call t%check('nothing happens to it after a failure', .not. file%is_open() .and. content('stream.txt') == 'ab')
    call file%create('/dev/full', full)
    call file%write('c', full)
    call t%check('a full disk shows', .not. full%failed)
    call file%flush(full)
    call t%check('in the next flush', says(full, '/dev/full: cannot be written'))
    call file%close(full)
    call t%check('and the file is closed', .not. file%is_open())
    full = failure_t()
    call file%create('/dev/full', full)
    call file%write('c', full)
    call file%close(full)
    call t%check('or when it is closed', says(full, '/dev/full: cannot be written'))
  end subroutine test_stream

  subroutine test_names()
    type(failure_t) :: failure, gone, unmoved, undurable, unmade, full
    call write_text('old.txt', 'old', failure)
    call rename_file('old.txt', 'new.txt', failure)
    call t%check('a file gets another name', .not. failure%failed .and. content('new.txt') == 'old' .and. &
                 .not. file_exists('old.txt'))
    call rename_file('old.txt', 'new.txt', unmoved)
    call t%check('a missing one does not', says(unmoved, 'old.txt: cannot be renamed to new.txt'))
    call rename_file('new.txt', 'newer.txt', unmoved)
    call t%check('none does after a failure', file_exists('new.txt'))
    call replace_file('old.txt', 'new.txt', .true., undurable)
    call t%check('nothing is replaced by what is not on the disk', says(undurable, 'old.txt: cannot be flushed to the disk') &
                 .and. content('new.txt') == 'old')
    call empty_file('new.txt', failure)
    call t%check('a file is made empty', .not. failure%failed .and. content('new.txt') == '')
    call remove_file('new.txt', failure)
    call t%check('a file is removed', .not. failure%failed .and. .not. file_exists('new.txt'))
    call remove_file('new.txt', gone)
    call t%check('once', says(gone, 'new.txt: cannot be removed'))
    call empty_file('new.txt', full)
    call t%check('and cannot be made empty then', says(full, 'new.txt: cannot be made empty'))
    call remove_file('new.txt')
    call make_folder('no/such/folder', unmade)
    call t%check('a folder needs one above it', says(unmade, 'no/such/folder: this folder cannot be made'))
  end subroutine test_names

  logical function says(failure, text)
    type(failure_t), intent(in) :: failure
    character(*), intent(in) :: text
    says = failure%failed
    if (says) says = index(failure%reason, text) == 1
  end function says

  !> The lines of a file, one behind the other; ? if there is none.
  function content(path) result(text)
    character(*), intent(in) :: path
    character(:), allocatable :: text
    character(40) :: line
    integer :: unit, status
    text = '?'
    open (newunit=unit, file=path, status='old', action='read', iostat=status)
    if (status /= 0) return
    text = ''
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      text = text//trim(line)
    end do
    close (unit)
  end function content
end program test_files

! SPDX-License-Identifier: GPL-3.0-or-later
!> The lock of a run, the names of its files, what differs between the inputs of two runs, and the identity in a checkpoint.
program test_run_files
  use base_errors, only: failure_t, message_list_t
  use base_files, only: file_exists, remove_file
  use base_listing, only: list_folder, matches_name
  use base_process, only: host_name, process_birth, process_id
  use base_text, only: number_text
  use base_text_file, only: write_text
  use io_earlier_results, only: find_results, move_earlier_file
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use io_identity, only: change_t, identity_t, list_changes
  use io_lock, only: lock_t, LOCK_HELD, LOCK_TAKEN, LOCK_UNWRITABLE
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  character(*), parameter :: NL = new_line('a')

  call t%start(parallel=.true.)
  call test_names()
  call test_changes()
  call test_lock()
  call test_aside()
  call test_checkpoint()
  call t%finish()

contains

  subroutine test_names()
    call t%check('a * is any text, a # a number', matches_name('ux_000500.h5', '*_#.h5') .and. &
                 matches_name('.t', '*.t') .and. matches_name('a_b_1.h5', '*_#.h5'))
    call t%check('and nothing else is', .not. (matches_name('ux_0005a.h5', '*_#.h5') .or. matches_name('ux_.h5', '*_#.h5') &
                                               .or. matches_name('forces.tt', '*.t') .or. matches_name('', '#')))
    call t%check('a text is itself', matches_name('summary.txt', 'summary.txt') .and. .not. matches_name('summary.tx', &
                                                                                                      'summary.txt'))
  end subroutine test_names

  subroutine test_changes()
    type(change_t), allocatable :: changes(:)
    call list_changes('[A] x = 1'//NL//'[A] f = a.dat {content 12}'//NL//'[A] g = b {content 3}'//NL//'[A] gone = 1'//NL, &
                      '[A] x = 2'//NL//'[A] f = b.dat {content 12}'//NL//'[A] g = b {content 4}'//NL//'[A] new = 1'//NL, &
                      changes)
    call t%check('what differs is a value, or the content of a file under whatever name', size(changes) == 2)
    if (size(changes) /= 2) return
    call t%check('a value', changes(1)%text() == '[A] x = 2, was 1')
    call t%check('a content', changes(2)%text() == '[A] g = b: the content of this file has changed')
  end subroutine test_changes

  subroutine test_lock()
    type(lock_t) :: one, two
    character(:), allocatable :: message
    integer :: state
    logical :: ok
    call remove_file('unit.lock', ok)
    call one%acquire('unit.lock', state, message)
    call t%check('the first gets the lock', state == LOCK_HELD .and. message == '')
    call two%acquire('unit.lock', state, message)
    call t%check('the second does not, and is told who has it', state == LOCK_TAKEN .and. &
                 index(message, 'process '//number_text(process_id())//' on '//host_name()) > 0)
    call two%release()
    call t%check('who does not hold it does not remove it', file_exists('unit.lock'))
    call one%release()
    call t%check('who holds it does', .not. file_exists('unit.lock'))
    call left_by(process_id(), '1')
    call one%acquire('unit.lock', state, message)
    call t%check('one of a process of this number that began at another time is replaced, with a notice', &
                 state == LOCK_HELD .and. index(message, 'which has ended') > 0)
    call one%release()
    call write_text('unit.lock', '', ok)
    call one%acquire('unit.lock', state, message)
    call t%check('one that says nothing is respected', state == LOCK_TAKEN .and. index(message, 'remove unit.lock') > 0)
    call remove_file('unit.lock', ok)
    call one%acquire('no/such/folder.lock', state, message)
    call t%check('without a folder there is none', state == LOCK_UNWRITABLE)
    call t%check('a process that runs has begun, one that cannot be has not', process_birth(process_id()) > 0 .and. &
                 process_birth(-1) == 0)
  end subroutine test_lock

  subroutine left_by(process, birth)
    integer, intent(in) :: process
    character(*), intent(in) :: birth
    logical :: ok
    call write_text('unit.lock', '% A run'//NL//'host = '//host_name()//NL//'process = '//number_text(process)//NL// &
                    'birth = '//birth//NL//'since = today', ok)
  end subroutine left_by

  subroutine test_aside()
    type(message_list_t) :: patterns, inputs, found, names
    logical :: ok, has_moved
    call write_text('aside_1.h5', 'a', ok)
    call write_text('aside_2.h5', 'b', ok)
    call patterns%add('aside_#.h5')
    call inputs%add('./aside_2.h5')
    call find_results(patterns, inputs, found)
    call t%check('files are found but for those that are read', found%count() == 1)
    if (found%count() == 1) call t%check('by their names', found%text(1) == 'aside_1.h5')
    call move_earlier_file('aside_1.h5', has_moved)
    call t%check('one moves', has_moved .and. file_exists('aside_1.h5.earlier') .and. .not. file_exists('aside_1.h5'))
    call move_earlier_file('aside_1.h5', has_moved)
    call t%check('once', .not. has_moved)
    call list_folder('no/such/folder', names)
    call t%check('a folder that is not there holds nothing', names%count() == 0)
    call remove_file('aside_2.h5', ok)
    call remove_file('aside_1.h5.earlier', ok)
  end subroutine test_aside

  subroutine test_checkpoint()
    type(identity_t) :: identity, back, none
    type(checkpoint_writer_t) :: writer
    type(checkpoint_reader_t) :: reader
    type(failure_t) :: failure
    character(:), allocatable :: id
    call identity%start('[A] x = 1'//NL)
    id = identity%id
    call t%world%broadcast_text(id)
    identity%id = id
    call writer%begin(t%world, '.', 'identity.h5', failure)
    call identity%save(writer)
    call writer%commit(failure)
    call reader%open(t%world, 'identity.h5', failure)
    call back%load(reader, failure)
    call reader%close(failure)
    call t%check('a checkpoint holds the identity', .not. failure%failed .and. back%is_known())
    if (back%is_known()) call t%check('as it was', back%id == id .and. back%inputs == identity%inputs .and. &
                                      back%fingerprint() == identity%fingerprint() .and. back%version == identity%version)
    call none%start('[A] x = 2'//NL)
    call t%check('another run has another name and fingerprint', none%id /= id .and. &
                 none%fingerprint() /= identity%fingerprint())
  end subroutine test_checkpoint
end program test_run_files

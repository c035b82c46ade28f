! SPDX-License-Identifier: GPL-3.0-or-later
!> Two alternating checkpoints: the newer valid one counts, the older or the broken one is replaced.
program test_slots
  use base_errors, only: failure_t
  use base_files, only: empty_file, remove_file
  use base_kinds, only: i8
  use io_checkpoint, only: checkpoint_writer_t, checkpoint_reader_t
  use io_checkpoint_slots, only: checkpoint_slots_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(checkpoint_slots_t) :: slots, unwritable
  type(failure_t) :: failure

  call t%start(parallel=.true.)
  call forget('backup0.h5')
  call forget('backup1.h5')
  call slots%scan(t%world, '.', 'backup')
  call expect('nothing there', found=.false., newest='', generation=0_i8)
  call t%check('the reason is told', index(slots%reason(1), 'backup1.h5: does not exist') > 0)
  call save('backup0.h5')
  call save('backup1.h5')
  call save('backup0.h5')
  call expect('after three checkpoints', .true., 'backup0.h5', 3_i8)
  call slots%scan(t%world, '.', 'backup')
  call expect('seen by a later run', .true., 'backup0.h5', 3_i8)
  call save('backup1.h5')
  call expect('numbers go on over a restart', .true., 'backup1.h5', 4_i8)

  call slots%came_from('./backup0.h5')
  call expect('a run from the older one', .true., 'backup1.h5', 4_i8)
  call save('backup1.h5')
  call expect('keeps it for its first checkpoint', .true., 'backup1.h5', 5_i8)
  call slots%came_from('elsewhere/initial.h5')
  call expect('a run from another file', .true., 'backup1.h5', 5_i8)
  call save('backup0.h5')
  call expect('replaces the older one', .true., 'backup0.h5', 6_i8)

  call damage('backup0.h5')
  call slots%scan(t%world, '.', 'backup')
  call expect('the newer one is broken', .true., 'backup1.h5', 5_i8)
  call t%check('a broken one has a reason', len(slots%reason(0)) > 0 .and. len(slots%reason(1)) == 0)
  call save('backup0.h5')
  call expect('and replaced', .true., 'backup0.h5', 6_i8)
  call damage('backup0.h5')
  call damage('backup1.h5')
  call slots%scan(t%world, '.', 'backup')
  call expect('both are broken', .false., '', 0_i8)
  call save('backup0.h5')

  call unwritable%scan(t%world, 'no/such/folder', 'backup')
  call save_attempt(unwritable, failure)
  call t%check('a checkpoint that cannot be written is a failure', failure%failed)
  call t%check('and does not count', unwritable%newest_generation() == 0)
  call t%finish()

contains

  subroutine expect(what, found, newest, generation)
    character(*), intent(in) :: what, newest
    logical, intent(in) :: found
    integer(i8), intent(in) :: generation
    character(:), allocatable :: name
    logical :: is_found
    call slots%newest_valid(name, is_found)
    call t%check(what//': newest valid', (is_found .eqv. found) .and. (name == newest .or. .not. found))
    call t%check(what//': generation', slots%newest_generation() == generation)
  end subroutine expect

  subroutine save_attempt(slots, failure)
    type(checkpoint_slots_t), intent(inout) :: slots
    type(failure_t), intent(inout) :: failure
    type(checkpoint_writer_t) :: writer
    call slots%begin(writer, failure)
    call writer%put_integer('step', slots%newest_generation())
    call slots%commit(writer, failure)
  end subroutine save_attempt

  !> The next checkpoint goes into the file `target`.
  subroutine save(target)
    character(*), intent(in) :: target
    type(checkpoint_reader_t) :: reader
    type(failure_t) :: failure
    character(:), allocatable :: name
    integer(i8) :: step
    logical :: found
    call save_attempt(slots, failure)
    call slots%newest_valid(name, found)
    call reader%open(t%world, name, failure)
    call reader%get_integer('step', step, failure)
    call reader%close(failure)
    call t%check('a checkpoint is where it was to go, with its content', found .and. name == target .and. &
                 .not. failure%failed .and. step == slots%newest_generation() - 1)
  end subroutine save

  subroutine damage(path)
    character(*), intent(in) :: path
    if (t%world%is_root) call empty_file(path)
    call t%world%barrier()
  end subroutine damage

  subroutine forget(path)
    character(*), intent(in) :: path
    if (t%world%is_root) call remove_file(path)
    call t%world%barrier()
  end subroutine forget
end program test_slots

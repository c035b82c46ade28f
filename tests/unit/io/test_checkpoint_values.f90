! SPDX-License-Identifier: GPL-3.0-or-later
!> A value of a visited type comes back from a checkpoint bit by bit; what is missing or has another size is refused by its name.
program test_checkpoint_values
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use io_checkpoint_values, only: checkpoint_loader_t, checkpoint_saver_t
  use testkit, only: testkit_t
  use visited_values, only: differences, fill, mixed_t, row_t
  implicit none

  type(testkit_t) :: t

  call t%start(parallel=.true.)
  call write_values()
  call test_values('', .false., .true.)
  call test_values('table_', .true., .true.)
  call test_values('empty_', .false., .false.)
  call test_refusals()
  call t%finish()

contains

  subroutine write_values()
    type(checkpoint_writer_t) :: writer
    type(checkpoint_saver_t) :: saver
    type(failure_t) :: failure
    type(mixed_t) :: full, empty
    type(row_t) :: row
    call fill(full, .true.)
    call fill(empty, .false.)
    row%numbers = [1.0_rp, 2.0_rp]
    call writer%begin(t%world, '.', 'values.h5', failure)
    call saver%begin(writer, '')
    call full%visit(saver)
    call saver%begin(writer, 'table_', reals_are_tables=.true.)
    call full%visit(saver)
    call saver%begin(writer, 'empty_')
    call empty%visit(saver)
    call saver%begin(writer, 'row_')
    call row%visit(saver)
    call writer%put_integer('broken_number', 2_i8**40)
    call writer%commit(failure)
    call t%check('values are written', .not. failure%failed)
  end subroutine write_values

  subroutine open(reader, loader, prefix, reals_are_tables)
    type(checkpoint_reader_t), intent(inout) :: reader
    type(checkpoint_loader_t), intent(inout) :: loader
    character(*), intent(in) :: prefix
    logical, intent(in) :: reals_are_tables
    type(failure_t) :: failure
    call reader%open(t%world, 'values.h5', failure)
    call t%check('the file opens', .not. failure%failed)
    call loader%begin(reader, prefix, reals_are_tables)
  end subroutine open

  subroutine test_values(prefix, reals_are_tables, is_full)
    character(*), intent(in) :: prefix
    logical, intent(in) :: reals_are_tables, is_full
    type(checkpoint_reader_t) :: reader
    type(checkpoint_loader_t) :: loader
    type(failure_t) :: failure
    type(mixed_t) :: value, wanted
    call fill(wanted, is_full)
    call open(reader, loader, prefix, reals_are_tables)
    call value%visit(loader)
    call t%check('they are read: '//reason(loader), .not. loader%failure%failed)
    if (.not. loader%failure%failed) &
      call t%check('all components come back:'//differences(wanted, value), differences(wanted, value) == '')
    call t%check('a real is a number, or a table', reader%has(prefix//'single') .and. reader%has(prefix//'list_count'))
    call reader%close(failure)
  end subroutine test_values

  !> What is not in the file under this name, or in another shape.
  subroutine test_refusals()
    type(mixed_t) :: value, other
    type(row_t) :: row
    type(checkpoint_reader_t) :: reader
    type(checkpoint_loader_t) :: loader
    type(failure_t) :: failure
    integer :: number
    call open(reader, loader, 'nothing_', .false.)
    call value%visit(loader)
    call t%check('a missing number is named: '//reason(loader), index(reason(loader), 'nothing_single') > 0)
    call loader%begin(reader, 'nothing_', reals_are_tables=.true.)
    call other%visit(loader)
    call t%check('a missing table is named: '//reason(loader), index(reason(loader), 'nothing_single') > 0)
    call loader%begin(reader, 'row_')
    allocate (row%numbers(3), source=0.0_rp)
    call row%visit(loader)
    call t%check('an array of another size is refused: '//reason(loader), index(reason(loader), '2 numbers in row_numbers') > 0)
    call loader%begin(reader, 'broken_')
    number = 5
    call loader%visit('number', number)
    call t%check('an integer that is too large is refused: '//reason(loader), index(reason(loader), 'out of range') > 0)
    call t%check('and the number stays', number == 5)
    call loader%begin(reader, 'part_')
    call loader%visit('number', row%numbers)
    call t%check('a number is no array: '//reason(loader), loader%failure%failed)
    call reader%close(failure)
  end subroutine test_refusals

  function reason(loader)
    type(checkpoint_loader_t), intent(in) :: loader
    character(:), allocatable :: reason
    reason = ''
    if (loader%failure%failed) reason = loader%failure%reason
  end function reason
end program test_checkpoint_values

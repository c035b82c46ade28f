! SPDX-License-Identifier: GPL-3.0-or-later
!> Arrays and attributes of HDF5 files that cannot be read are failures, whose reasons name file, object and attribute. So are files
!> that get no name or no seal.
program test_arrays
  use base_errors, only: failure_t
  use base_files, only: file_exists, make_folder, remove_file
  use base_kinds, only: i8, rp
  use io_arrays, only: member_names, read_attribute_integer, read_attribute_reals, read_integers, read_reals, read_text
  use io_attributes, only: put_attribute
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use io_seal, only: check_seal, write_seal, SEAL_GOOD
  use io_table, only: put_table
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(hdf5_file_t) :: file
  type(failure_t) :: failure

  call t%start(parallel=.false.)
  call file%create_serial('arrays.h5', failure)
  call put_table(file, 'table', reshape([1.0_rp, 2.0_rp, 3.0_rp, 4.0_rp], [2, 2]), 'a b', failure)
  call file%make_group('group', failure)
  call put_attribute(file, '/', 'word', 'text', failure)
  call put_attribute(file, '/', 'pair', [1.5_rp, 2.5_rp], failure)
  call put_attribute(file, '/', 'count', 7, failure)
  call file%close(failure)
  call file%open_serial('arrays.h5', failure)
  call t%check('a file is written', .not. failure%failed)
  call test_good()
  call test_bad()
  call file%close(failure)
  call test_publication()
  call t%finish()

contains

  subroutine test_good()
    type(failure_t) :: good
    character(NAME_LENGTH), allocatable :: names(:)
    character(:), allocatable :: text
    real(rp) :: values(4), pair(2)
    integer(i8) :: whole(4)
    integer :: number
    call member_names(file, '/', 2, names, good)
    call read_reals(file, 'table', values, good)
    call read_integers(file, 'table', whole, good)
    call read_text(file, '/', 'word', text, good)
    call read_attribute_reals(file, '/', 'pair', pair, good)
    call read_attribute_integer(file, '/', 'count', number, good)
    call t%check('what is there is read', .not. good%failed .and. size(names) == 2 .and. text == 'text' .and. number == 7 .and. &
                 all(abs(values - [1, 2, 3, 4]) <= 0) .and. all(whole == [1, 2, 3, 4]) .and. &
                 all(abs(pair - [1.5_rp, 2.5_rp]) <= 0))
  end subroutine test_good

  subroutine test_bad()
    type(failure_t) :: many, size_differs, no_set, no_text, number_text, one, real, after
    character(NAME_LENGTH), allocatable :: names(:)
    character(:), allocatable :: text
    real(rp) :: values(3), pair(1)
    integer(i8) :: whole(2)
    integer :: number
    call member_names(file, '/', 1, names, many)
    call t%check('too many names', says(many, '/: the list of contents cannot be read, or is longer than 1') .and. size(names) == 0)
    values = 1
    call read_reals(file, 'table', values, size_differs)
    call t%check('another size', says(size_differs, 'table: cannot be read: damaged') .and. all(abs(values) <= 0))
    call read_integers(file, 'group', whole, no_set)
    call t%check('no array', says(no_set, 'group: cannot be read: damaged') .and. all(whole == 0))
    call read_text(file, '/', 'words', text, no_text)
    call t%check('no attribute', says(no_text, '/: attribute words is missing or not a text') .and. text == '')
    call read_text(file, '/', 'count', text, number_text)
    call t%check('no text', says(number_text, '/: attribute count is missing or not a text'))
    call read_attribute_reals(file, '/', 'pair', pair, one)
    call t%check('another number of values', says(one, '/: attribute pair is missing or not 1 real numbers') .and. &
                 all(abs(pair) <= 0))
    call read_attribute_integer(file, '/', 'pair', number, real)
    call t%check('no integer', says(real, '/: attribute pair is missing or not an integer') .and. number == 0)
    call after%raise('an earlier one')
    call read_attribute_integer(file, '/', 'count', number, after)
    call t%check('a failure does not keep others from being read', number == 7 .and. after%reason == 'an earlier one')
  end subroutine test_bad

  !> A file alone that gets no name or no seal.
  subroutine test_publication()
    type(hdf5_file_t) :: new
    type(failure_t) :: there, taken, late, unsealed
    integer :: state
    call make_folder('taken.h5', there) ! perhaps of an earlier run of this test
    call new%create_serial('taken.h5.part', taken)
    call t%check('a file begins', .not. taken%failed)
    call new%publish('taken.h5', .false., taken, with_seal=.true.)
    call t%check('a folder is not replaced by it', taken%failed)
    if (taken%failed) call t%check('which says so', taken%reason == 'taken.h5.part: cannot be renamed to taken.h5')
    call t%check('and nothing is left of it', .not. file_exists('taken.h5.part'))
    call remove_file('late.h5') ! of a run of this test that failed
    call new%create_serial('late.h5.part', late)
    call late%raise('an earlier one')
    call new%publish('late.h5', .false., late)
    call t%check('a file that failed gets no name', late%reason == 'an earlier one' .and. .not. file_exists('late.h5') .and. &
                 .not. file_exists('late.h5.part'))
    call write_seal('arrays.h5', failure)
    call check_seal('arrays.h5', state)
    call t%check('a file gets a seal', .not. failure%failed .and. state == SEAL_GOOD)
    call write_seal('missing.h5', unsealed)
    call t%check('a missing one does not', unsealed%failed)
    if (unsealed%failed) call t%check('which is a failure', index(unsealed%reason, 'missing.h5: cannot be sealed') == 1)
  end subroutine test_publication

  logical function says(failed, text)
    type(failure_t), intent(in) :: failed
    character(*), intent(in) :: text
    says = failed%failed
    if (says) says = failed%reason == 'arrays.h5: '//text
  end function says
end program test_arrays

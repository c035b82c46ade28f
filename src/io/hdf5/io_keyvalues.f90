! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the key of a field: one line of six numbers by which FLUSI's regression tests recognise a field.
!>
!> time, max f, min f, mean f, mean f**2, mean (x + y + z) f, with x = ix*xl/nx and so on, ix from 0. One process does all the work;
!> MPI need not run.
module io_keyvalues
  use base_errors, only: failure_t
  use base_files, only: file_exists
  use base_kinds, only: rp, i8
  use base_text_file, only: write_text
  use io_datasets, only: read_slab
  use io_fields, only: field_meta_t, find_dataset, read_meta
  use io_hdf5, only: hdf5_file_t
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  implicit none
  private
  public :: N_KEYS, field_keys, key_line, keyvalues, read_keys, compare_keys, write_verdict

  integer, parameter :: N_KEYS = 6
  character(*), parameter :: KEY_NAMES(N_KEYS) = [character(16) :: 'time', 'max', 'min', 'mean', &
                                                                                                        'mean square', &
                                                                                                        'mean (x+y+z)f']
  real(rp), parameter :: KEY_TOLERANCE = 1.0e-4_rp   !< relative
  real(rp), parameter :: SMALL_REFERENCE = 1.0e-7_rp !< below it the tolerance is absolute

contains

  !> Returns the six numbers of the field in `path`, which is read plane by plane.
  subroutine field_keys(path, keys, failure)
    character(*), intent(in) :: path
    real(rp), intent(out) :: keys(N_KEYS)
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    type(field_meta_t) :: meta
    character(:), allocatable :: dataset
    integer(i8), allocatable :: dims(:)
    real(rp), allocatable :: plane(:)

    keys = 0
    call file%open_serial(path, failure)
    call find_dataset(file, dataset, failure)
    call read_meta(file, dataset, meta, failure)
    call file%dataset_shape(dataset, dims, failure)
    if (.not. failure%failed &
        .and. size(dims) /= 3) call failure%raise(path//': is not a three-dimensional field')
    if (.not. failure%failed .and. product(meta%nxyz) == 0) call failure%raise(path//': the field is empty')
    if (.not. failure%failed) then
      allocate (plane(dims(1)*dims(2)))
      call sum_planes()
    end if
    call file%close(failure)

  contains

    !> Finds sum, largest and smallest value of the field, plane by plane.
    subroutine sum_planes()
      real(rp) :: spacing(3), weight(3), line(3), total(3), largest, smallest
      integer :: n(3), i, j, k
      n = meta%nxyz
      spacing = meta%domain_size/n
      total = 0
      largest = -huge(1.0_rp)
      smallest = huge(1.0_rp)
      do k = 1, n(3)
        call read_slab(file, dataset, dims, [0_i8, 0_i8, int(k - 1, i8)], [dims(1), dims(2), 1_i8], plane, &
                       failure)
        if (failure%failed) return
        largest = max(largest, maxval(plane))
        smallest = min(smallest, minval(plane))
        ! Line by line, so that small terms are not lost in one long sum.
        do j = 1, n(2)
          line = 0
          do i = 1, n(1)
            weight = [i - 1, j - 1, k - 1]*spacing
            associate (f => plane(i + (j - 1)*n(1)))
              line = line + [f, f**2, sum(weight)*f]
            end associate
          end do
          total = total + line
        end do
      end do
      keys = [meta%time, largest, smallest, total/(real(n(1), rp)*n(2)*n(3))]
    end subroutine sum_planes
  end subroutine field_keys

  !> Returns the line that FLUSI prints: six numbers in es15.8, one blank apart.
  function key_line(keys) result(line)
    real(rp), intent(in) :: keys(N_KEYS)
    character(:), allocatable :: line
    character(16*N_KEYS) :: buffer
    write (buffer, '(6(es15.8,1x))') keys
    line = trim(buffer)
  end function key_line

  !> Prints the key of the field in `path` to `unit` and writes it to `<path without .h5>.key`.
  subroutine keyvalues(path, unit, failure)
    character(*), intent(in) :: path
    integer, intent(in) :: unit
    type(failure_t), intent(inout) :: failure
    real(rp) :: keys(N_KEYS)
    character(:), allocatable :: key_path
    logical :: ok
    call field_keys(path, keys, failure)
    if (failure%failed) return
    write (unit, '(a)') key_line(keys)
    key_path = trim(path)
    if (index(key_path, '.h5', back=.true.) > 1) key_path = key_path(:index(key_path, '.h5', back=.true.) - 1)
    key_path = key_path//'.key'
    call write_text(key_path, key_line(keys), ok)
    if (.not. ok) call failure%raise(key_path//': cannot be written')
  end subroutine keyvalues

  !> Reads a key file.
  subroutine read_keys(path, keys, failure)
    character(*), intent(in) :: path
    real(rp), intent(out) :: keys(N_KEYS)
    type(failure_t), intent(inout) :: failure
    integer :: unit, status
    keys = 0
    if (failure%failed) return
    if (.not. file_exists(path)) then
      call failure%raise(path//': does not exist')
      return
    end if
    open (newunit=unit, file=path, status='old', action='read', iostat=status)
    if (status == 0) then
      read (unit, *, iostat=status) keys
      close (unit)
    end if
    if (status /= 0) call failure%raise(path//': is not a line of six numbers')
  end subroutine read_keys

  !> Compares the key file `path` with the reference `reference_path`, number by number with a tolerance of
  !> 1e-4 relative, or absolute where the reference is below 1e-7; prints the table to `unit`. NaN never
  !> agrees. Unreadable files are a failure.
  subroutine compare_keys(path, reference_path, unit, ok, failure)
    character(*), intent(in) :: path, reference_path
    integer, intent(in) :: unit
    logical, intent(out) :: ok
    type(failure_t), intent(inout) :: failure
    real(rp) :: keys(N_KEYS), reference(N_KEYS), error
    logical :: good
    integer :: i
    ok = .false.
    call read_keys(path, keys, failure)
    call read_keys(reference_path, reference, failure)
    if (failure%failed) return
    ok = .true.
    write (unit, '(a16,3(1x,a15))') '', 'value', 'reference', 'error'
    do i = 1, N_KEYS
      error = abs(keys(i) - reference(i))
      good = .not. ieee_is_nan(error)
      if (good) then
        if (abs(reference(i)) >= SMALL_REFERENCE) error = error/abs(reference(i))
        good = error <= KEY_TOLERANCE
      end if
      ok = ok .and. good
      write (unit, '(a16,3(1x,es15.8),2x,a)') adjustl(KEY_NAMES(i)), keys(i), reference(i), error, &
        trim(merge('ok       ', 'different', good))
    end do
  end subroutine compare_keys

  !> Writes the verdict of a comparison to the file `return` in the current folder, 0 if `ok` and 1 if not:
  !> FLUSI's test scripts read it there.
  subroutine write_verdict(ok, failure)
    logical, intent(in) :: ok
    type(failure_t), intent(inout) :: failure
    logical :: written
    call write_text('return', merge('0', '1', ok), written)
    if (.not. written) call failure%raise('return: cannot be written')
  end subroutine write_verdict
end module io_keyvalues

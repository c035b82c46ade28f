! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes and reads arrays in HDF5 files: boxes of grid fields and rows of tables, each rank its own part.
!>
!> All procedures follow the rules of io_hdf5: collective on a parallel file with one collective transfer, sticky failures, empty
!> parts allowed. This module converts numbers itself, because the library would use independent transfers for conversions.
module io_datasets
  use base_kinds, only: rp, sp, i4, i8
  use base_memory, only: check_allocation, REAL_BYTES
  use base_errors, only: failure_t, require
  use parallel_block, only: block_t, rows_t
  use io_hdf5, only: hdf5_file_t
  use io_selection, only: row_patterns_t, row_patterns
  use hdf5, only: HID_T, HSIZE_T, SIZE_T, H5P_DATASET_CREATE_F, H5P_DATASET_XFER_F, &
                  H5D_FILL_TIME_NEVER_F, H5FD_MPIO_COLLECTIVE_F, H5S_SELECT_SET_F, H5S_SELECT_OR_F, &
                  H5T_NATIVE_DOUBLE, H5T_NATIVE_REAL, H5T_IEEE_F32LE, H5T_IEEE_F64LE, H5T_FLOAT_F, &
                  H5T_STD_I32LE, H5_INTEGER_KIND, h5kind_to_type, &
                  h5pcreate_f, h5pclose_f, h5pset_fill_time_f, h5pset_dxpl_mpio_f, &
                  h5dcreate_f, h5dopen_f, h5dclose_f, h5dwrite_f, h5dread_f, h5dget_type_f, &
                  h5tget_size_f, h5tget_class_f, h5tclose_f, &
                  h5ldelete_f, h5screate_simple_f, h5sclose_f, h5sselect_none_f, h5sselect_hyperslab_f
  use, intrinsic :: iso_c_binding, only: c_ptr, c_loc
  implicit none
  private
  public :: write_slab, read_slab, read_box, write_rows, read_rows, write_integers

contains

  !> Creates dataset `name` of shape `dims` and writes the box `count` points wide from `start`
  !> (0-based), given as a flat array, first index fastest. Collective on a parallel file.
  subroutine write_slab(file, name, dims, start, count, values, single, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(i8), intent(in) :: dims(:), start(:), count(:)
    real(rp), contiguous, intent(in) :: values(:)
    logical, intent(in) :: single                  !< store 32 bits per number
    type(failure_t), intent(inout) :: failure
    if (failure%failed) return
    call require(size(values, kind=i8) == product(count), 'io_datasets: the array does not fill the box')
    call store(file, name, dims, box_space(dims, start, count), values, single, failure)
  end subroutine write_slab

  !> Reads the box `count` points wide from `start` (0-based) of dataset `name`, which must have shape
  !> `dims`; 32-bit numbers are widened. Collective on a parallel file.
  subroutine read_slab(file, name, dims, start, count, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(i8), intent(in) :: dims(:), start(:), count(:)
    real(rp), contiguous, intent(out) :: values(:)
    type(failure_t), intent(inout) :: failure
    values = 0
    if (failure%failed) return
    call require(size(values, kind=i8) == product(count), 'io_datasets: the array does not fill the box')
    call check_shape(file, name, dims, failure)
    if (failure%failed .or. product(dims) == 0) return
    call fetch(file, name, box_space(dims, start, count), values, failure)
  end subroutine read_slab

  !> Reads the owned box of dataset `name`, which must have shape block%n. Collective.
  subroutine read_box(file, name, block, data, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    type(block_t), intent(in) :: block
    real(rp), intent(out) :: data(:, :, :)         !< shape block%count
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: values(:)
    integer :: status
    call require(all(shape(data) == block%count), 'io_datasets: read_box: data and block differ')
    allocate (values(size(data)), stat=status)
    call check_allocation(status, [size(data)], REAL_BYTES, 'what is written to or read from a file')
    call read_slab(file, name, int(block%n, i8), int(block%start, i8), int(block%count, i8), values, failure)
    call unflatten(size(data, 1), size(data, 2), size(data, 3), values, data)
  end subroutine read_box

  !> Writes the owned rows of a global table as dataset `name` of shape (ncol, rows%n), 64 bits per
  !> number, in global row order. Collective.
  subroutine write_rows(file, name, data, rows, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    real(rp), intent(in) :: data(:, :)             !< shape (ncol, rows%n_local)
    type(rows_t), intent(in) :: rows
    type(failure_t), intent(inout) :: failure
    type(row_patterns_t) :: patterns
    real(rp), allocatable :: values(:)
    integer :: status
    integer(HID_T) :: space
    integer :: i, n
    if (failure%failed) return
    call require(size(data, 2) == rows%n_local, 'io_datasets: write_rows: data and rows differ')
    patterns = row_patterns(rows)
    n = size(data, 1)
    allocate (values(size(data)), stat=status)
    call check_allocation(status, [size(data)], REAL_BYTES, 'what is written to or read from a file')
    do i = 1, rows%n_local
      values((i - 1)*n + 1:i*n) = data(:, row_in_file_order(patterns, i))
    end do
    space = rows_space(n, rows%n, patterns)
    call store(file, name, int([n, rows%n], i8), space, values, .false., failure)
  end subroutine write_rows

  !> Reads the rows `rows` of a dataset of shape (ncol, rows%n); ranks may read the same rows. Collective.
  subroutine read_rows(file, name, data, rows, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    real(rp), intent(out) :: data(:, :)            !< shape (ncol, rows%n_local)
    type(rows_t), intent(in) :: rows
    type(failure_t), intent(inout) :: failure
    type(row_patterns_t) :: patterns
    real(rp), allocatable :: values(:)
    integer :: status
    integer(HID_T) :: space
    integer :: i, n
    data = 0
    if (failure%failed) return
    call require(size(data, 2) == rows%n_local, 'io_datasets: read_rows: data and rows differ')
    n = size(data, 1)
    call check_shape(file, name, int([n, rows%n], i8), failure)
    if (failure%failed .or. n == 0 .or. rows%n == 0) return
    patterns = row_patterns(rows)
    allocate (values(size(data)), stat=status)
    call check_allocation(status, [size(data)], REAL_BYTES, 'what is written to or read from a file')
    space = rows_space(n, rows%n, patterns)
    call fetch(file, name, space, values, failure)
    do i = 1, rows%n_local
      data(:, row_in_file_order(patterns, i)) = values((i - 1)*n + 1:i*n)
    end do
  end subroutine read_rows

  !> Creates the dataset `name` of shape `dims` from integers, first index fastest, in 32 bits each. For a
  !> file of one process.
  subroutine write_integers(file, name, dims, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(i8), intent(in) :: dims(:)
    integer(i4), contiguous, target, intent(in) :: values(:)
    type(failure_t), intent(inout) :: failure
    integer(HID_T) :: space, dataset
    integer :: error, ignored
    if (failure%failed) return
    call require(.not. file%is_parallel .and. size(values) > 0 .and. size(values, kind=i8) == product(dims), &
                 'io_datasets: integers of another number than the shape, or on a parallel file')
    call h5screate_simple_f(size(dims), int(dims, HSIZE_T), space, error)
    call h5dcreate_f(file%id, name, H5T_STD_I32LE, space, dataset, error)
    if (error >= 0) then
      call h5dwrite_f(dataset, h5kind_to_type(i4, H5_INTEGER_KIND), c_loc(values), error)
      call h5dclose_f(dataset, ignored)
      error = min(error, ignored)
    end if
    call file%agree(error >= 0, 'dataset '''//name//''' cannot be written; is the disk full?', failure)
    call h5sclose_f(space, error)
  end subroutine write_integers

  !> Returns the row of the i-th spectrum in the order of the file.
  pure integer function row_in_file_order(patterns, i) result(row)
    type(row_patterns_t), intent(in) :: patterns
    integer, intent(in) :: i
    row = i
    if (allocated(patterns%order)) row = patterns%order(i)
  end function row_in_file_order

  !> Creates a dataset and writes the values to the selected part of it. Releases `space`.
  subroutine store(file, name, dims, space, values, single, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(i8), intent(in) :: dims(:)
    integer(HID_T), intent(in) :: space
    real(rp), contiguous, target, intent(in) :: values(:)
    logical, intent(in) :: single
    type(failure_t), intent(inout) :: failure
    real(sp), allocatable, target :: narrow(:)
    real(rp), target :: nothing(1)
    type(c_ptr) :: address
    integer(HID_T) :: dataset, creation
    logical :: created
    integer :: error

    call h5pcreate_f(H5P_DATASET_CREATE_F, creation, error)
    call h5pset_fill_time_f(creation, H5D_FILL_TIME_NEVER_F, error) ! everything is written anyway
    call h5dcreate_f(file%id, name, merge(H5T_IEEE_F32LE, H5T_IEEE_F64LE, single), space, dataset, error, &
                     creation)
    call file%agree(error >= 0, 'dataset '''//name//''' of shape '//shape_text(dims)//' cannot be created', &
                    failure)
    created = .not. failure%failed
    if (created .and. product(dims) > 0) then
      address = c_loc(nothing) ! an address is needed even when nothing is transferred
      if (single) then
        narrow = real(values, sp)
        if (size(values) > 0) address = c_loc(narrow(1))
      else
        if (size(values) > 0) address = c_loc(values(1))
      end if
      call transfer_values(file, dataset, space, merge(H5T_NATIVE_REAL, H5T_NATIVE_DOUBLE, single), &
                           size(values, kind=i8), address, .true., error)
      call file%agree(error >= 0, 'dataset '''//name//''' cannot be written; is the disk full?', failure)
    end if
    if (created) then
      call h5dclose_f(dataset, error)
      call file%agree(error >= 0, 'dataset '''//name//''' cannot be closed', failure)
      ! Without the dataset the file needs less space, so that it can be closed on a full disk.
      if (failure%failed) call h5ldelete_f(file%id, name, error)
    end if
    call h5pclose_f(creation, error)
    call h5sclose_f(space, error)
  end subroutine store

  !> Reads the selected part of a dataset. Releases `space`.
  subroutine fetch(file, name, space, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(HID_T), intent(in) :: space
    real(rp), contiguous, target, intent(out) :: values(:)
    type(failure_t), intent(inout) :: failure
    real(sp), allocatable, target :: narrow(:)
    real(rp), target :: nothing(1)
    type(c_ptr) :: address
    integer(HID_T) :: dataset, stored
    integer(SIZE_T) :: bytes
    integer :: class, error

    values = 0
    bytes = 0
    class = -1
    call h5dopen_f(file%id, name, dataset, error)
    if (error >= 0) then
      call h5dget_type_f(dataset, stored, error)
      call h5tget_size_f(stored, bytes, error)
      call h5tget_class_f(stored, class, error)
      call h5tclose_f(stored, error)
    end if
    call file%agree(class == H5T_FLOAT_F .and. (bytes == 4 .or. bytes == 8), &
                    'dataset '''//name//''' does not hold real numbers of 32 or 64 bits', failure)
    if (.not. failure%failed) then
      address = c_loc(nothing)
      if (bytes == 4) then
        allocate (narrow(size(values)))
        narrow = 0
        if (size(values) > 0) address = c_loc(narrow(1))
      else
        if (size(values) > 0) address = c_loc(values(1))
      end if
      call transfer_values(file, dataset, space, merge(H5T_NATIVE_REAL, H5T_NATIVE_DOUBLE, bytes == 4), &
                           size(values, kind=i8), address, .false., error)
      if (bytes == 4) values = real(narrow, rp)
      call file%agree(error >= 0, 'dataset '''//name//''' cannot be read', failure)
      call h5dclose_f(dataset, error)
    end if
    call h5sclose_f(space, error)
  end subroutine fetch

  !> Moves `n` values between memory and the selected part of a dataset, collectively.
  subroutine transfer_values(file, dataset, space, memory_type, n, address, is_write, error)
    type(hdf5_file_t), intent(in) :: file
    integer(HID_T), intent(in) :: dataset, space, memory_type
    integer(i8), intent(in) :: n
    type(c_ptr), intent(in) :: address
    logical, intent(in) :: is_write
    integer, intent(out) :: error
    integer(HID_T) :: memory, how
    type(c_ptr) :: target_address
    integer :: ignored

    call h5screate_simple_f(1, int([max(n, 1_i8)], HSIZE_T), memory, error)
    if (n == 0) call h5sselect_none_f(memory, error)
    call h5pcreate_f(H5P_DATASET_XFER_F, how, error)
    if (file%is_parallel) call h5pset_dxpl_mpio_f(how, H5FD_MPIO_COLLECTIVE_F, error)
    if (is_write) then
      call h5dwrite_f(dataset, memory_type, address, error, memory, space, how)
    else
      target_address = address ! HDF5 declares it intent(inout)
      call h5dread_f(dataset, memory_type, target_address, error, memory, space, how)
    end if
    call h5pclose_f(how, ignored)
    call h5sclose_f(memory, ignored)
  end subroutine transfer_values

  !> Makes a data space of shape `dims` with one box selected, possibly empty.
  function box_space(dims, start, count) result(space)
    integer(i8), intent(in) :: dims(:), start(:), count(:)
    integer(HID_T) :: space
    integer :: error
    call h5screate_simple_f(size(dims), int(dims, HSIZE_T), space, error)
    if (product(count) > 0) then
      call h5sselect_hyperslab_f(space, H5S_SELECT_SET_F, int(start, HSIZE_T), int(count, HSIZE_T), error)
    else
      call h5sselect_none_f(space, error)
    end if
  end function box_space

  !> Makes a data space of shape (ncol, n) with some rows selected, possibly none.
  function rows_space(ncol, n, patterns) result(space)
    integer, intent(in) :: ncol, n
    type(row_patterns_t), intent(in) :: patterns
    integer(HID_T) :: space
    integer :: k, error
    call h5screate_simple_f(2, int([ncol, n], HSIZE_T), space, error)
    call h5sselect_none_f(space, error)
    do k = 1, patterns%n
      call h5sselect_hyperslab_f(space, merge(H5S_SELECT_SET_F, H5S_SELECT_OR_F, k == 1), &
                                 int([0, patterns%start(k)], HSIZE_T), int([1, patterns%count(k)], HSIZE_T), &
                                 error, &
                                 int([ncol, patterns%stride(k)], HSIZE_T), int([ncol, patterns%length(k)], &
                                                                               HSIZE_T))
    end do
  end function rows_space

  !> Fails unless the dataset exists and has this shape. Collective on a parallel file.
  subroutine check_shape(file, name, dims, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(i8), intent(in) :: dims(:)
    type(failure_t), intent(inout) :: failure
    integer(i8), allocatable :: stored(:)
    logical :: same
    call file%agree(file%has(name), 'has no dataset '''//name//'''', failure)
    call file%dataset_shape(name, stored, failure)
    if (failure%failed) return
    same = size(stored) == size(dims)
    if (same) same = all(stored == dims)
    call file%agree(same, 'dataset '''//name//''' has shape '//shape_text(stored)//', expected ' &
                    //shape_text(dims), failure)
  end subroutine check_shape

  !> Returns a shape as text, as in (3, 4).
  pure function shape_text(dims) result(text)
    integer(i8), intent(in) :: dims(:)
    character(:), allocatable :: text
    character(24) :: number
    integer :: i
    text = '('
    do i = 1, size(dims)
      write (number, '(i0)') dims(i)
      if (i > 1) text = text//', '
      text = text//trim(number)
    end do
    text = text//')'
  end function shape_text

  !> Copies values of this shape to `data`.
  pure subroutine unflatten(n1, n2, n3, values, data)
    integer, intent(in) :: n1, n2, n3
    real(rp), intent(in) :: values(n1, n2, n3)
    real(rp), intent(out) :: data(:, :, :)
    data = values
  end subroutine unflatten
end module io_datasets

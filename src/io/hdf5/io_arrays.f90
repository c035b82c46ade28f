! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads small arrays and texts of HDF5 files of unknown quality as a whole, on one process: which objects exist, of which kind
!> and shape, and their values.
!>
!> A procedure does its work even after an earlier failure, so that a caller can list all mistakes of a file. Values are returned
!> bit by bit as stored, including signalling NaN; use `is_finite` before computing with them.
module io_arrays
  use base_errors, only: failure_t
  use base_kinds, only: rp, i8
  use base_text, only: number_text
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use io_attributes, only: has_attribute, attribute_size, attribute_class, get_attribute, ATTRIBUTE_INTEGER, &
                           ATTRIBUTE_REAL
  use hdf5, only: HID_T, HSIZE_T, SIZE_T, H5T_NATIVE_DOUBLE, H5T_INTEGER_F, H5T_FLOAT_F, H5T_STRING_F, &
                  H5T_STRING, H5_INTEGER_KIND, H5S_NULL_F, H5P_DEFAULT_F, h5kind_to_type, &
                  h5dopen_f, h5dclose_f, h5dread_f, h5dget_storage_size_f, h5dget_type_f, h5dget_space_f, &
                  h5dget_create_plist_f, h5pget_layout_f, h5pclose_f, H5D_CHUNKED_F, h5dvlen_reclaim_f, &
                  h5sclose_f, h5sget_simple_extent_ndims_f, h5sget_simple_extent_dims_f, &
                  h5sget_simple_extent_type_f, h5gopen_f, h5gclose_f, h5gn_members_f, h5gget_obj_info_idx_f, &
                  h5aopen_by_name_f, h5aclose_f, h5aread_f, h5aget_type_f, h5aget_space_f, &
                  h5tcopy_f, h5tclose_f, h5tget_class_f, h5tget_size_f, h5tis_variable_str_f, &
                  h5tget_cset_f, h5tset_cset_f
  use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_get_halting_mode, ieee_set_halting_mode, &
                                                                              ieee_set_flag
  use, intrinsic :: iso_c_binding, only: c_ptr, c_loc, c_char, c_null_ptr, c_associated, c_f_pointer, &
                                                                            c_size_t
  implicit none
  private
  public :: is_group, member_names, describe_array, read_reals, read_integers, is_finite, is_infinite
  public :: read_text, read_attribute_reals, read_attribute_integer
  public :: ARRAY_MISSING, ARRAY_REAL, ARRAY_INTEGER

  integer, parameter :: ARRAY_MISSING = 0, ARRAY_REAL = 1, ARRAY_INTEGER = 2, ARRAY_OTHER = 3
  character(*), parameter :: DAMAGED = 'cannot be read: damaged'
  integer, parameter :: LONGEST_TEXT = 4096
  integer(i8), parameter :: EXPONENT_BITS = int(z'7FF0000000000000', i8)
  integer(i8), parameter :: MANTISSA_BITS = int(z'000FFFFFFFFFFFFF', i8)

  interface
    integer(c_size_t) function c_strlen(text) bind(C, name='strlen')
      import :: c_size_t, c_ptr
      type(c_ptr), value :: text
    end function c_strlen
  end interface

  !> The state of the floating-point traps while HDF5 converts arbitrary numbers.
  type :: traps_t
    logical :: halting(size(ieee_all)) = .false.
  contains
    procedure :: silence => traps_silence
    procedure :: restore => traps_restore
  end type traps_t

contains

  !> Tells whether the file holds a group of this name.
  logical function is_group(file, name)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(HID_T) :: group
    integer :: error, ignored
    is_group = .false.
    if (.not. file%has(name)) return
    call h5gopen_f(file%id, name, group, error)
    is_group = error >= 0
    if (is_group) call h5gclose_f(group, ignored)
  end function is_group

  !> Returns the names of the objects in a group ('/': the top of the file) in alphabetical order, blank-padded, longer ones cut.
  !> Fails if the list cannot be read or is longer than `most`; they are then empty.
  subroutine member_names(file, group, most, names, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    integer, intent(in) :: most
    character(NAME_LENGTH), allocatable, intent(out) :: names(:)
    type(failure_t), intent(inout) :: failure
    integer :: n, i, kind, error
    logical :: ok
    call h5gn_members_f(file%id, group, n, error)
    ok = error >= 0 .and. n >= 0 .and. n <= most
    allocate (names(merge(n, 0, ok)))
    do i = 1, size(names)
      names(i) = ''
      call h5gget_obj_info_idx_f(file%id, group, i - 1, names(i), kind, error)
      ok = ok .and. error >= 0
    end do
    if (.not. ok) call failure%raise(where_in(file, group)//'the list of contents cannot be read, or is longer than '// &
                                     number_text(most))
  end subroutine member_names

  !> Returns kind and shape of a dataset, first Fortran index first (the reverse of what h5dump shows). An object that is not a
  !> readable dataset of numbers has the kind ARRAY_OTHER and no dimensions.
  subroutine describe_array(file, name, kind, dims)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(out) :: kind
    integer(i8), allocatable, intent(out) :: dims(:)
    integer(HID_T) :: dataset, stored, space, creation
    integer(HSIZE_T), allocatable :: extent(:), largest(:)
    integer(HSIZE_T) :: storage
    integer(SIZE_T) :: bytes
    integer :: class, rank, sort, layout, error, ignored
    kind = ARRAY_MISSING
    allocate (dims(0))
    if (.not. file%has(name)) return
    kind = ARRAY_OTHER
    call h5dopen_f(file%id, name, dataset, error)
    if (error < 0) return
    call h5dget_type_f(dataset, stored, error)
    class = -1
    bytes = 0
    if (error >= 0) then
      call h5tget_class_f(stored, class, error)
      call h5tget_size_f(stored, bytes, error)
      call h5tclose_f(stored, ignored)
    end if
    call h5dget_storage_size_f(dataset, storage, error)
    if (error < 0) storage = 0
    call h5dget_create_plist_f(dataset, creation, error)
    layout = -1
    if (error >= 0) then
      call h5pget_layout_f(creation, layout, error)
      call h5pclose_f(creation, ignored)
    end if
    call h5dget_space_f(dataset, space, error)
    if (error >= 0) then
      call h5sget_simple_extent_type_f(space, sort, error)
      call h5sget_simple_extent_ndims_f(space, rank, error)
      if (error >= 0 .and. rank >= 0) then
        allocate (extent(rank), largest(rank))
        call h5sget_simple_extent_dims_f(space, extent, largest, error)
        if (error >= 0) then
          if (class == H5T_FLOAT_F) kind = ARRAY_REAL
          if (class == H5T_INTEGER_F) kind = ARRAY_INTEGER
          if (kind /= ARRAY_OTHER) dims = int(extent, i8)
          if (sort == H5S_NULL_F) dims = [0_i8]
          ! In a damaged file the library may read beyond the stored data, or fail at the type.
          if (.not. is_plausible(dims, int(bytes, i8), int(storage, i8), layout == H5D_CHUNKED_F)) &
            kind = ARRAY_OTHER
        end if
      end if
      call h5sclose_f(space, ignored)
    end if
    call h5dclose_f(dataset, ignored)
  end subroutine describe_array

  !> Tells whether the numbers have a usual size and, unless they may be compressed, whether the stored data have the expected size.
  !> The caller checks for too many or too large dimensions.
  pure logical function is_plausible(dims, bytes, storage, is_chunked)
    integer(i8), intent(in) :: dims(:), bytes, storage
    logical, intent(in) :: is_chunked
    is_plausible = any(bytes == [1, 2, 4, 8, 16])
    if (.not. is_plausible .or. size(dims) > 2 .or. any(dims > huge(1))) return
    is_plausible = product(dims) == 0 .or. merge(storage > 0, storage == product(dims)*bytes, is_chunked)
  end function is_plausible

  !> Reads all values of a dataset of at most two dimensions, first Fortran index fastest. `values` must have its size. Numbers of
  !> other kinds are converted. Fails if it cannot be read; the values are then 0.
  subroutine read_reals(file, name, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    real(rp), contiguous, intent(out) :: values(:)
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable, target :: buffer(:)
    logical :: ok
    allocate (buffer(size(values) + 1))
    buffer = 0
    call read_whole(file, name, H5T_NATIVE_DOUBLE, size(values, kind=i8), c_loc(buffer), ok)
    if (.not. ok) then
      buffer = 0
      call failure%raise(where_in(file, name)//DAMAGED)
    end if
    values = buffer(:size(values))
  end subroutine read_reals

  !> Reads the values as integers. Values beyond 64 bits become the largest or smallest integer.
  subroutine read_integers(file, name, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(i8), contiguous, intent(out) :: values(:)
    type(failure_t), intent(inout) :: failure
    integer(i8), allocatable, target :: buffer(:)
    logical :: ok
    allocate (buffer(size(values) + 1))
    buffer = 0
    call read_whole(file, name, h5kind_to_type(i8, H5_INTEGER_KIND), size(values, kind=i8), c_loc(buffer), ok)
    if (.not. ok) then
      buffer = 0
      call failure%raise(where_in(file, name)//DAMAGED)
    end if
    values = buffer(:size(values))
  end subroutine read_integers

  !> Reads a whole numeric array of n numbers to an address. `ok` is false if it has another size or kind.
  subroutine read_whole(file, name, memory_type, n, address, ok)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(HID_T), intent(in) :: memory_type
    integer(i8), intent(in) :: n
    type(c_ptr), intent(in) :: address
    logical, intent(out) :: ok
    type(traps_t) :: traps
    type(c_ptr) :: target_address
    integer(HID_T) :: dataset
    integer(i8), allocatable :: dims(:)
    integer :: kind, error, ignored
    call describe_array(file, name, kind, dims)
    ok = (kind == ARRAY_REAL .or. kind == ARRAY_INTEGER) .and. size(dims) <= 2 .and. all(dims < huge(1))
    if (ok) ok = product(dims) == n
    if (.not. ok .or. n == 0) return
    call h5dopen_f(file%id, name, dataset, error)
    ok = error >= 0
    if (.not. ok) return
    call traps%silence()
    target_address = address ! HDF5 declares it intent(inout)
    call h5dread_f(dataset, memory_type, target_address, error)
    call traps%restore()
    ok = error >= 0
    call h5dclose_f(dataset, ignored)
  end subroutine read_whole

  !> Reads a text attribute of `object` ('/': the file), of fixed or variable length, without trailing blanks and NUL. Fails if it
  !> is missing, not one text, longer than 4096 bytes or not readable.
  subroutine read_text(file, object, name, text, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    character(:), allocatable, intent(out) :: text
    type(failure_t), intent(inout) :: failure
    logical :: ok
    text = ''
    ok = has_attribute(file, object, name)
    if (ok) ok = attribute_size(file, object, name) == 1
    if (ok) call read_any_text(file, object, name, text, ok)
    if (.not. ok) call failure%raise(where_in(file, object)//'attribute '//name//' is missing or not a text')
  end subroutine read_text

  !> Reads the text of an attribute that holds one value, without trailing blanks and NUL.
  subroutine read_any_text(file, object, name, text, ok)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    character(:), allocatable, intent(inout) :: text
    logical, intent(out) :: ok
    integer(HID_T) :: attribute, stored
    integer :: class, error, ignored
    logical :: is_variable
    ok = .false.
    call h5aopen_by_name_f(file%id, object, name, attribute, error)
    if (error < 0) return
    call h5aget_type_f(attribute, stored, error)
    if (error >= 0) then
      call h5tget_class_f(stored, class, error)
      if (error >= 0 .and. class == H5T_STRING_F) then
        call h5tis_variable_str_f(stored, is_variable, error)
        if (error >= 0 .and. is_variable) call read_variable_text(attribute, stored, text, ok)
        if (error >= 0 .and. .not. is_variable) call read_fixed_text(attribute, stored, text, ok)
      end if
      call h5tclose_f(stored, ignored)
    end if
    call h5aclose_f(attribute, ignored)
    do while (len(text) > 0)
      if (text(len(text):) /= ' ' .and. text(len(text):) /= achar(0)) exit
      text = text(:len(text) - 1)
    end do
  end subroutine read_any_text

  !> Reads a text of fixed length.
  subroutine read_fixed_text(attribute, stored, text, ok)
    integer(HID_T), intent(in) :: attribute, stored
    character(:), allocatable, intent(out) :: text
    logical, intent(out) :: ok
    integer(SIZE_T) :: length
    integer :: error
    text = ''
    call h5tget_size_f(stored, length, error)
    ok = error >= 0 .and. length <= LONGEST_TEXT
    if (.not. ok) return
    deallocate (text)
    allocate (character(int(length)) :: text)
    call h5aread_f(attribute, stored, text, [1_hsize_t], error)
    ok = error >= 0
    if (.not. ok) text = ''
  end subroutine read_fixed_text

  !> Reads a text of variable length.
  subroutine read_variable_text(attribute, stored, text, ok)
    integer(HID_T), intent(in) :: attribute, stored
    character(:), allocatable, intent(out) :: text
    logical, intent(out) :: ok
    type(c_ptr), target :: buffer(1)
    type(c_ptr) :: address
    character(kind=c_char), pointer :: bytes(:)
    integer(HID_T) :: memory, space
    integer :: set, i, error, ignored
    text = ''
    buffer = c_null_ptr
    address = c_loc(buffer)
    call h5tcopy_f(H5T_STRING, memory, error)
    call h5tget_cset_f(stored, set, error)
    if (error >= 0) call h5tset_cset_f(memory, set, error)
    if (error >= 0) call h5aread_f(attribute, memory, address, error)
    ok = error >= 0 .and. c_associated(buffer(1))
    if (ok) then
      call c_f_pointer(buffer(1), bytes, [min(c_strlen(buffer(1)), int(LONGEST_TEXT, c_size_t))])
      do i = 1, size(bytes)
        text = text//bytes(i)
      end do
      call h5aget_space_f(attribute, space, error)
      address = c_loc(buffer)
      if (error >= 0) then
        call h5dvlen_reclaim_f(memory, space, H5P_DEFAULT_F, address, ignored)
        call h5sclose_f(space, ignored)
      end if
    end if
    call h5tclose_f(memory, ignored)
  end subroutine read_variable_text

  !> Reads a real attribute with as many values as `values`. Fails if there is none; the values are then 0.
  subroutine read_attribute_reals(file, object, name, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    real(rp), intent(out) :: values(:)
    type(failure_t), intent(inout) :: failure
    type(traps_t) :: traps
    type(failure_t) :: own
    if (attribute_class(file, object, name) /= ATTRIBUTE_REAL .or. attribute_size(file, object, name) /= size(values)) then
      call own%raise(where_in(file, object)//'attribute '//name//' is missing or not '//number_text(size(values))// &
                     ' real numbers')
    else
      call traps%silence()
      call get_attribute(file, object, name, values, own)
      call traps%restore()
    end if
    if (.not. own%failed) return
    values = 0
    call failure%raise(own%reason)
  end subroutine read_attribute_reals

  !> Reads an attribute that is one integer. A value beyond 32 bits becomes the largest or smallest integer. Fails if
  !> there is none; the value is then 0.
  subroutine read_attribute_integer(file, object, name, value, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer, intent(out) :: value
    type(failure_t), intent(inout) :: failure
    type(failure_t) :: own
    value = 0
    if (attribute_class(file, object, name) /= ATTRIBUTE_INTEGER .or. attribute_size(file, object, name) /= 1) then
      call own%raise(where_in(file, object)//'attribute '//name//' is missing or not an integer')
    else
      call get_attribute(file, object, name, value, own)
    end if
    if (own%failed) call failure%raise(own%reason)
  end subroutine read_attribute_integer

  !> Returns the words that begin a message about an object of the file.
  pure function where_in(file, object) result(words)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object
    character(:), allocatable :: words
    words = file%path//': '//object//': '
  end function where_in

  !> Tells whether x is a number: neither infinite nor NaN. Looks at the bits only and so raises no floating-point exception.
  pure elemental logical function is_finite(x)
    real(rp), intent(in) :: x
    is_finite = iand(transfer(x, 0_i8), EXPONENT_BITS) /= EXPONENT_BITS
  end function is_finite

  !> Tells whether x is infinite; NaN is not. Looks at the bits only and so raises no floating-point exception.
  pure elemental logical function is_infinite(x)
    real(rp), intent(in) :: x
    is_infinite = .not. is_finite(x) .and. iand(transfer(x, 0_i8), MANTISSA_BITS) == 0
  end function is_infinite

  !> Switches all floating-point traps off and remembers which were on. The HDF5 library raises exceptions while it converts
  !> numbers.
  subroutine traps_silence(self)
    class(traps_t), intent(inout) :: self
    call ieee_get_halting_mode(ieee_all, self%halting)
    call ieee_set_halting_mode(ieee_all, .false.)
  end subroutine traps_silence

  !> Clears the flags of all floating-point exceptions, and switches the traps on again that `silence` found on.
  subroutine traps_restore(self)
    class(traps_t), intent(in) :: self
    call ieee_set_flag(ieee_all, .false.)
    call ieee_set_halting_mode(ieee_all, self%halting)
  end subroutine traps_restore
end module io_arrays

! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes and reads attributes in HDF5 files: numbers and texts attached to a dataset, or to the file itself under the object name
!> '/'. All ranks pass the same values; the rules of io_hdf5 hold (collective, sticky failures).
module io_attributes
  use base_kinds, only: rp, i4, i8
  use base_errors, only: failure_t
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use hdf5, only: HID_T, HSIZE_T, SIZE_T, H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, H5T_STD_I32LE, H5T_STD_I64LE, &
                  H5T_FORTRAN_S1, H5T_INTEGER_F, H5T_FLOAT_F, H5T_STRING_F, H5_INTEGER_KIND, H5S_SCALAR_F, &
                  H5S_NULL_F, H5_INDEX_NAME_F, H5_ITER_INC_F, h5kind_to_type, &
                  h5acreate_by_name_f, h5aopen_by_name_f, h5aclose_f, h5awrite_f, h5aread_f, &
                  h5aexists_by_name_f, h5aget_type_f, h5aget_space_f, h5aopen_by_idx_f, h5aget_name_f, &
                  h5oopen_f, h5oclose_f, h5aget_num_attrs_f, &
                  h5screate_f, h5screate_simple_f, h5sclose_f, h5sget_simple_extent_npoints_f, &
                  h5sget_simple_extent_type_f, &
                  h5tcopy_f, h5tset_size_f, h5tget_size_f, h5tget_class_f, h5tclose_f, h5tis_variable_str_f
  use, intrinsic :: iso_c_binding, only: c_ptr, c_loc
  implicit none
  private
  public :: put_attribute, get_attribute, has_attribute, attribute_names, attribute_class, attribute_size
  public :: ATTRIBUTE_REAL, ATTRIBUTE_INTEGER, ATTRIBUTE_TEXT

  integer, parameter :: ATTRIBUTE_REAL = 1, ATTRIBUTE_INTEGER = 2, ATTRIBUTE_TEXT = 3, ATTRIBUTE_OTHER = 0

  !> put_attribute(file, object, name, value, failure): creates an attribute of dataset `object` ('/':
  !> the file). Values: real, real(:), integer and integer(:) of 4 bytes (stored in 4), integer of 8 bytes,
  !> text of any length.
  interface put_attribute
    module procedure put_real, put_reals, put_integer, put_integers, put_long, put_text
  end interface put_attribute

  !> get_attribute(file, object, name, value, failure): reads an attribute back; numbers are converted to
  !> the kind asked for, an array must have the size stored.
  interface get_attribute
    module procedure get_real, get_reals, get_integer, get_integers, get_long, get_text
  end interface get_attribute

contains

  !> Writes a real.
  subroutine put_real(file, object, name, value, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    real(rp), intent(in) :: value
    type(failure_t), intent(inout) :: failure
    call put_reals(file, object, name, [value], failure)
  end subroutine put_real

  !> Writes a list of reals.
  subroutine put_reals(file, object, name, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    real(rp), intent(in) :: values(:)
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable, target :: buffer(:)
    allocate (buffer(size(values) + 1))
    buffer(:size(values)) = values
    call put_numbers(file, object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, size(values), c_loc(buffer), &
                     failure)
  end subroutine put_reals

  !> Writes an integer.
  subroutine put_integer(file, object, name, value, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer(i4), intent(in) :: value
    type(failure_t), intent(inout) :: failure
    call put_integers(file, object, name, [value], failure)
  end subroutine put_integer

  !> Writes a list of integers.
  subroutine put_integers(file, object, name, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer(i4), intent(in) :: values(:)
    type(failure_t), intent(inout) :: failure
    integer(i4), allocatable, target :: buffer(:)
    allocate (buffer(size(values) + 1))
    buffer(:size(values)) = values
    call put_numbers(file, object, name, H5T_STD_I32LE, h5kind_to_type(i4, H5_INTEGER_KIND), size(values), &
                     c_loc(buffer), failure)
  end subroutine put_integers

  !> Writes a long integer.
  subroutine put_long(file, object, name, value, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer(i8), intent(in) :: value
    type(failure_t), intent(inout) :: failure
    integer(i8), target :: buffer
    buffer = value
    call put_numbers(file, object, name, H5T_STD_I64LE, h5kind_to_type(i8, H5_INTEGER_KIND), 1, &
                     c_loc(buffer), &
                     failure)
  end subroutine put_long

  !> Writes n numbers from an address.
  subroutine put_numbers(file, object, name, file_type, memory_type, n, address, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer(HID_T), intent(in) :: file_type, memory_type
    integer, intent(in) :: n
    type(c_ptr), intent(in) :: address
    type(failure_t), intent(inout) :: failure
    integer(HID_T) :: space, attribute
    integer :: error, ignored
    if (failure%failed) return
    if (n > 0) then
      call h5screate_simple_f(1, int([n], HSIZE_T), space, error)
    else
      call h5screate_f(H5S_NULL_F, space, error)
    end if
    call h5acreate_by_name_f(file%id, object, name, file_type, space, attribute, error)
    if (error >= 0) then
      if (n > 0) call h5awrite_f(attribute, memory_type, address, error)
      call h5aclose_f(attribute, ignored)
    end if
    call h5sclose_f(space, ignored)
    call file%agree(error >= 0, 'attribute '''//name//''' of '''//object//''' cannot be written', failure)
  end subroutine put_numbers

  !> Writes a text.
  subroutine put_text(file, object, name, text, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name, text
    type(failure_t), intent(inout) :: failure
    integer(HID_T) :: space, kind, attribute
    integer :: error, ignored
    if (failure%failed) return
    call h5tcopy_f(H5T_FORTRAN_S1, kind, error)
    call h5tset_size_f(kind, int(max(len(text), 1), SIZE_T), error)
    ! An empty text is an attribute without a value: HDF5 knows no text of length zero.
    call h5screate_f(merge(H5S_SCALAR_F, H5S_NULL_F, len(text) > 0), space, error)
    call h5acreate_by_name_f(file%id, object, name, kind, space, attribute, error)
    if (error >= 0) then
      if (len(text) > 0) call h5awrite_f(attribute, kind, text, [1_hsize_t], error)
      call h5aclose_f(attribute, ignored)
    end if
    call h5sclose_f(space, ignored)
    call h5tclose_f(kind, ignored)
    call file%agree(error >= 0, 'attribute '''//name//''' of '''//object//''' cannot be written', failure)
  end subroutine put_text

  !> Reads a real.
  subroutine get_real(file, object, name, value, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    real(rp), intent(out) :: value
    type(failure_t), intent(inout) :: failure
    real(rp) :: values(1)
    call get_reals(file, object, name, values, failure)
    value = values(1)
  end subroutine get_real

  !> Reads a list of reals of known length.
  subroutine get_reals(file, object, name, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    real(rp), intent(out) :: values(:)
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable, target :: buffer(:)
    allocate (buffer(size(values) + 1))
    buffer = 0
    call get_numbers(file, object, name, ATTRIBUTE_REAL, H5T_NATIVE_DOUBLE, size(values), c_loc(buffer), &
                     failure)
    values = buffer(:size(values))
  end subroutine get_reals

  !> Reads an integer.
  subroutine get_integer(file, object, name, value, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer(i4), intent(out) :: value
    type(failure_t), intent(inout) :: failure
    integer(i4) :: values(1)
    call get_integers(file, object, name, values, failure)
    value = values(1)
  end subroutine get_integer

  !> Reads a list of integers of known length.
  subroutine get_integers(file, object, name, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer(i4), intent(out) :: values(:)
    type(failure_t), intent(inout) :: failure
    integer(i4), allocatable, target :: buffer(:)
    allocate (buffer(size(values) + 1))
    buffer = 0
    call get_numbers(file, object, name, ATTRIBUTE_INTEGER, h5kind_to_type(i4, H5_INTEGER_KIND), &
                     size(values), &
                     c_loc(buffer), failure)
    values = buffer(:size(values))
  end subroutine get_integers

  !> Reads a long integer.
  subroutine get_long(file, object, name, value, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer(i8), intent(out) :: value
    type(failure_t), intent(inout) :: failure
    integer(i8), target :: buffer
    buffer = 0
    call get_numbers(file, object, name, ATTRIBUTE_INTEGER, h5kind_to_type(i8, H5_INTEGER_KIND), 1, &
                     c_loc(buffer), failure)
    value = buffer
  end subroutine get_long

  !> Reads n numbers to an address. Fails if the attribute has another length or type; integers may be read as reals.
  subroutine get_numbers(file, object, name, class, memory_type, n, address, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer, intent(in) :: class
    integer(HID_T), intent(in) :: memory_type
    integer, intent(in) :: n
    type(c_ptr), intent(in) :: address
    type(failure_t), intent(inout) :: failure
    type(c_ptr) :: target_address
    integer(HID_T) :: attribute
    integer :: stored, error, ignored
    logical :: fits
    if (failure%failed) return
    stored = attribute_class(file, object, name)
    fits = stored == class .or. (class == ATTRIBUTE_REAL .and. stored == ATTRIBUTE_INTEGER)
    stored = attribute_size(file, object, name)
    fits = fits .and. stored == n
    error = 0
    if (fits .and. n > 0) then
      call h5aopen_by_name_f(file%id, object, name, attribute, error)
      if (error >= 0) then
        target_address = address ! HDF5 declares it intent(inout)
        call h5aread_f(attribute, memory_type, target_address, error)
        call h5aclose_f(attribute, ignored)
      end if
    end if
    call file%agree(fits .and. error >= 0, 'attribute '''//name//''' of '''//object// &
                    ''' is missing, damaged or of another type or size', failure)
  end subroutine get_numbers

  !> Reads a text of any length.
  subroutine get_text(file, object, name, text, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    character(:), allocatable, intent(out) :: text
    type(failure_t), intent(inout) :: failure
    integer(HID_T) :: attribute, kind
    integer(SIZE_T) :: length
    logical :: is_text
    integer :: n, error, ignored
    text = ''
    if (failure%failed) return
    is_text = attribute_class(file, object, name) == ATTRIBUTE_TEXT
    n = attribute_size(file, object, name)
    error = merge(0, -1, is_text .and. (n == 0 .or. n == 1))
    if (error >= 0 .and. n == 1) then
      call h5aopen_by_name_f(file%id, object, name, attribute, error)
      call h5aget_type_f(attribute, kind, error)
      call h5tget_size_f(kind, length, error)
      deallocate (text)
      allocate (character(int(length)) :: text)
      call h5aread_f(attribute, kind, text, [1_hsize_t], error)
      call h5tclose_f(kind, ignored)
      call h5aclose_f(attribute, ignored)
    end if
    call file%agree(error >= 0, &
                    'attribute '''//name//''' of '''//object//''' is missing, damaged or not a text', &
                    failure)
  end subroutine get_text

  !> Tells whether dataset `object` ('/': the file) carries attribute `name`.
  logical function has_attribute(file, object, name) result(has)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer :: error
    has = .false.
    if (object /= '/') then
      if (.not. file%has(object)) return
    end if
    call h5aexists_by_name_f(file%id, object, name, has, error)
    has = has .and. error >= 0
  end function has_attribute

  !> Returns the kind of an attribute: ATTRIBUTE_REAL, _INTEGER, _TEXT or, also if it is missing, _OTHER.
  integer function attribute_class(file, object, name) result(class)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer(HID_T) :: attribute, kind
    logical :: is_variable
    integer :: stored, error, ignored
    class = ATTRIBUTE_OTHER
    if (.not. has_attribute(file, object, name)) return
    call h5aopen_by_name_f(file%id, object, name, attribute, error)
    if (error < 0) return
    call h5aget_type_f(attribute, kind, error)
    if (error >= 0) then
      call h5tget_class_f(kind, stored, error)
      if (stored == H5T_FLOAT_F) class = ATTRIBUTE_REAL
      if (stored == H5T_INTEGER_F) class = ATTRIBUTE_INTEGER
      if (stored == H5T_STRING_F) then
        call h5tis_variable_str_f(kind, is_variable, error)
        if (.not. is_variable) class = ATTRIBUTE_TEXT
      end if
      call h5tclose_f(kind, ignored)
    end if
    call h5aclose_f(attribute, ignored)
  end function attribute_class

  !> Returns the number of values of an attribute, -1 if it is missing; a text is one value, an empty text none.
  integer function attribute_size(file, object, name) result(n)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer(HID_T) :: attribute, space
    integer(HSIZE_T) :: points
    integer :: kind, error, ignored
    n = -1
    if (.not. has_attribute(file, object, name)) return
    call h5aopen_by_name_f(file%id, object, name, attribute, error)
    if (error < 0) return
    call h5aget_space_f(attribute, space, error)
    if (error >= 0) then
      ! The Fortran interface reports a count of zero as an error.
      call h5sget_simple_extent_type_f(space, kind, error)
      if (error >= 0 .and. kind == H5S_NULL_F) n = 0
      call h5sget_simple_extent_npoints_f(space, points, error)
      if (error >= 0) n = int(points)
      call h5sclose_f(space, ignored)
    end if
    call h5aclose_f(attribute, ignored)
  end function attribute_size

  !> Returns the names of all attributes of an object, in alphabetical order, blank-padded.
  subroutine attribute_names(file, object, names, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object
    character(NAME_LENGTH), allocatable, intent(out) :: names(:)
    type(failure_t), intent(inout) :: failure
    integer(HID_T) :: owner, attribute
    integer :: i, n, error, ignored
    n = 0
    allocate (names(0))
    if (failure%failed) return
    call h5oopen_f(file%id, object, owner, error)
    if (error >= 0) then
      call h5aget_num_attrs_f(owner, n, error)
      if (error < 0) n = 0
      call h5oclose_f(owner, ignored)
    end if
    deallocate (names)
    allocate (names(n))
    do i = 1, n
      names(i) = ''
      call h5aopen_by_idx_f(file%id, object, H5_INDEX_NAME_F, H5_ITER_INC_F, int(i - 1, HSIZE_T), attribute, &
                            error)
      if (error < 0) exit
      ! The result is the length of the name, negative on failure.
      call h5aget_name_f(attribute, int(NAME_LENGTH, SIZE_T), names(i), error)
      call h5aclose_f(attribute, ignored)
      if (error < 0) exit
    end do
    call file%agree(error >= 0, 'attributes of '''//object//''' cannot be listed', failure)
  end subroutine attribute_names
end module io_attributes

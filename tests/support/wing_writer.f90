! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes wing files for tests: a small valid one, of which any part can be replaced by something else.
module wing_writer
  use base_kinds, only: rp
  use hdf5, only: HID_T, HSIZE_T, SIZE_T, H5F_ACC_TRUNC_F, H5F_ACC_RDWR_F, H5P_FILE_ACCESS_F, &
                  H5F_LIBVER_EARLIEST_F, H5F_LIBVER_LATEST_F, H5T_NATIVE_DOUBLE, H5T_NATIVE_INTEGER, &
                  H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_I64LE, H5T_FORTRAN_S1, H5T_STRING, &
                  H5S_SCALAR_F, h5open_f, h5fcreate_f, &
                  h5fopen_f, h5fclose_f, h5pcreate_f, h5pclose_f, h5pset_libver_bounds_f, h5gcreate_f, &
                  h5gclose_f, h5screate_simple_f, h5screate_f, h5sclose_f, h5dcreate_f, h5dwrite_f, h5dclose_f, &
                  h5lexists_f, h5ldelete_f, h5acreate_by_name_f, h5awrite_f, h5aclose_f, h5adelete_by_name_f, &
                  h5aexists_by_name_f, h5tcopy_f, h5tset_size_f, h5tclose_f
  use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_get_halting_mode, ieee_set_halting_mode, &
                                                                              ieee_set_flag
  use, intrinsic :: iso_c_binding, only: c_ptr, c_loc, c_null_char
  implicit none
  private
  public :: wing_writer_t

  type :: wing_writer_t
    integer(HID_T) :: id = -1
  contains
    procedure :: sample
    procedure :: beam
    procedure :: open => writer_open
    procedure :: close => writer_close
    procedure :: group
    procedure :: delete
    procedure :: reals
    procedure :: integers
    procedure :: text_attribute
    procedure :: variable_text_attribute
    procedure :: integer_attribute
    procedure :: real_attribute
    procedure :: delete_attribute
  end type wing_writer_t

contains

  !> A plate of 3 x 3 points 1 mm apart, point i + 3 (j - 1) at column i and row j, with veins A (first row),
  !> B (second row) and C (second column), joints at the middle of B and from A into C, and column 1 as root.
  subroutine sample(self, path, is_new)
    class(wing_writer_t), intent(inout) :: self
    character(*), intent(in) :: path
    logical, intent(in), optional :: is_new !< use the newest layout of HDF5
    integer :: i, j, a, t, triangles(3, 8)
    real(rp) :: points(3, 9)
    do j = 1, 3
      do i = 1, 3
        points(:, i + 3*(j - 1)) = [(i - 1)*1.0e-3_rp, (j - 1)*1.0e-3_rp, 0.0_rp]
      end do
    end do
    t = 0
    do j = 1, 2
      do i = 1, 2
        a = i + 3*(j - 1)
        triangles(:, t + 1) = [a, a + 1, a + 4]
        triangles(:, t + 2) = [a, a + 4, a + 3]
        t = t + 2
      end do
    end do
    call create(self, path, is_new)
    call header(self)
    call self%reals('/points', [3, 9], reshape(points, [27]))
    call self%integers('/triangles', [3, 8], reshape(triangles, [24]))
    call self%group('/veins')
    call vein(self, 'A', [1, 2, 3])
    call vein(self, 'B', [4, 5, 6])
    call vein(self, 'C', [2, 5, 8])
    call self%group('/joints')
    call self%integers('/joints/at_B', [1], [5])
    call self%text_attribute('/joints/at_B', 'vein', 'B')
    call self%integers('/joints/A-C', [3], [1, 2, 5])
    call self%group('/root')
    call self%integers('/root/nodes', [3], [1, 4, 7])
  end subroutine sample

  !> One vein along the x axis, 4 points.
  subroutine beam(self, path)
    class(wing_writer_t), intent(inout) :: self
    character(*), intent(in) :: path
    call create(self, path)
    call header(self)
    call self%reals('/points', [3, 4], real([0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0], rp))
    call self%group('/veins')
    call vein(self, 'A', [1, 2, 3, 4])
    call self%group('/root')
    call self%integers('/root/nodes', [1], [1])
  end subroutine beam

  subroutine header(self)
    class(wing_writer_t), intent(in) :: self
    call self%text_attribute('/', 'schema', 'flusi-msm wing')
    call self%integer_attribute('/', 'version', 1)
    call self%integer_attribute('/', 'index_base', 1)
  end subroutine header

  subroutine vein(self, name, nodes)
    class(wing_writer_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: nodes(:)
    integer :: i
    call self%group('/veins/'//name)
    call self%integers('/veins/'//name//'/nodes', [size(nodes)], nodes)
    call self%reals('/veins/'//name//'/diameters', [size(nodes)], [(1.0e-5_rp*(9 - i), i=1, size(nodes))])
  end subroutine vein

  subroutine create(self, path, is_new)
    class(wing_writer_t), intent(inout) :: self
    character(*), intent(in) :: path
    logical, intent(in), optional :: is_new
    integer(HID_T) :: access
    integer :: error, oldest
    call h5open_f(error)
    oldest = H5F_LIBVER_EARLIEST_F
    if (present(is_new)) oldest = merge(H5F_LIBVER_LATEST_F, oldest, is_new)
    call h5pcreate_f(H5P_FILE_ACCESS_F, access, error)
    call h5pset_libver_bounds_f(access, oldest, H5F_LIBVER_LATEST_F, error)
    call h5fcreate_f(path, H5F_ACC_TRUNC_F, self%id, error, access_prp=access)
    call h5pclose_f(access, error)
  end subroutine create

  !> Opens a file to change it.
  subroutine writer_open(self, path)
    class(wing_writer_t), intent(inout) :: self
    character(*), intent(in) :: path
    integer :: error
    call h5open_f(error)
    call h5fopen_f(path, H5F_ACC_RDWR_F, self%id, error)
  end subroutine writer_open

  subroutine writer_close(self)
    class(wing_writer_t), intent(inout) :: self
    integer :: error
    call h5fclose_f(self%id, error)
  end subroutine writer_close

  subroutine group(self, name)
    class(wing_writer_t), intent(in) :: self
    character(*), intent(in) :: name
    integer(HID_T) :: id
    integer :: error
    call h5gcreate_f(self%id, name, id, error)
    call h5gclose_f(id, error)
  end subroutine group

  !> Removes an object, if it is there.
  subroutine delete(self, name)
    class(wing_writer_t), intent(in) :: self
    character(*), intent(in) :: name
    logical :: exists
    integer :: error
    call h5lexists_f(self%id, name, exists, error)
    if (exists) call h5ldelete_f(self%id, name, error)
  end subroutine delete

  !> Writes or replaces a dataset of reals; units 'm' unless others are given ('-': none).
  subroutine reals(self, name, dims, values, units, is_single)
    class(wing_writer_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: dims(:)
    real(rp), intent(in) :: values(:)
    character(*), intent(in), optional :: units
    logical, intent(in), optional :: is_single
    real(rp), target :: buffer(size(values) + 1)
    integer(HID_T) :: space, id, kind
    integer :: error
    logical :: halting(size(ieee_all))
    call self%delete(name)
    buffer(:size(values)) = values
    kind = H5T_IEEE_F64LE
    if (present(is_single)) kind = merge(H5T_IEEE_F32LE, kind, is_single)
    call h5screate_simple_f(size(dims), int(dims, HSIZE_T), space, error)
    call h5dcreate_f(self%id, name, kind, space, id, error)
    call ieee_get_halting_mode(ieee_all, halting) ! the conversion to single precision may overflow
    call ieee_set_halting_mode(ieee_all, .false.)
    if (size(values) > 0) call h5dwrite_f(id, H5T_NATIVE_DOUBLE, c_loc(buffer), error)
    call ieee_set_flag(ieee_all, .false.)
    call ieee_set_halting_mode(ieee_all, halting)
    call h5dclose_f(id, error)
    call h5sclose_f(space, error)
    if (.not. present(units)) then
      call self%text_attribute(name, 'units', 'm')
    else if (units /= '-') then
      call self%text_attribute(name, 'units', units)
    end if
  end subroutine reals

  !> Writes or replaces a dataset of integers.
  subroutine integers(self, name, dims, values)
    class(wing_writer_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: dims(:), values(:)
    integer, target :: buffer(size(values) + 1)
    integer(HID_T) :: space, id
    integer :: error
    call self%delete(name)
    buffer(:size(values)) = values
    call h5screate_simple_f(size(dims), int(dims, HSIZE_T), space, error)
    call h5dcreate_f(self%id, name, H5T_STD_I64LE, space, id, error)
    if (size(values) > 0) call h5dwrite_f(id, H5T_NATIVE_INTEGER, c_loc(buffer), error)
    call h5dclose_f(id, error)
    call h5sclose_f(space, error)
  end subroutine integers

  subroutine text_attribute(self, object, name, text)
    class(wing_writer_t), intent(in) :: self
    character(*), intent(in) :: object, name, text
    integer(HID_T) :: space, kind, id
    integer :: error
    call self%delete_attribute(object, name)
    call h5tcopy_f(H5T_FORTRAN_S1, kind, error)
    call h5tset_size_f(kind, int(len(text), SIZE_T), error)
    call h5screate_f(H5S_SCALAR_F, space, error)
    call h5acreate_by_name_f(self%id, object, name, kind, space, id, error)
    call h5awrite_f(id, kind, text, [1_hsize_t], error)
    call h5aclose_f(id, error)
    call h5sclose_f(space, error)
    call h5tclose_f(kind, error)
  end subroutine text_attribute

  !> A text as Python programs write it.
  subroutine variable_text_attribute(self, object, name, text)
    class(wing_writer_t), intent(in) :: self
    character(*), intent(in) :: object, name, text
    character(len(text) + 1), target :: bytes
    type(c_ptr), target :: address(1)
    integer(HID_T) :: space, id
    integer :: error
    call self%delete_attribute(object, name)
    bytes = text//c_null_char
    address(1) = c_loc(bytes)
    call h5screate_f(H5S_SCALAR_F, space, error)
    call h5acreate_by_name_f(self%id, object, name, H5T_STRING, space, id, error)
    call h5awrite_f(id, H5T_STRING, c_loc(address), error)
    call h5aclose_f(id, error)
    call h5sclose_f(space, error)
  end subroutine variable_text_attribute

  subroutine integer_attribute(self, object, name, value)
    class(wing_writer_t), intent(in) :: self
    character(*), intent(in) :: object, name
    integer, intent(in) :: value
    integer, target :: buffer(1)
    integer(HID_T) :: space, id
    integer :: error
    call self%delete_attribute(object, name)
    buffer = value
    call h5screate_f(H5S_SCALAR_F, space, error)
    call h5acreate_by_name_f(self%id, object, name, H5T_STD_I64LE, space, id, error)
    call h5awrite_f(id, H5T_NATIVE_INTEGER, c_loc(buffer), error)
    call h5aclose_f(id, error)
    call h5sclose_f(space, error)
  end subroutine integer_attribute

  subroutine real_attribute(self, object, name, values)
    class(wing_writer_t), intent(in) :: self
    character(*), intent(in) :: object, name
    real(rp), intent(in) :: values(:)
    real(rp), target :: buffer(size(values))
    integer(HID_T) :: space, id
    integer :: error
    call self%delete_attribute(object, name)
    buffer = values
    call h5screate_simple_f(1, [size(values, kind=HSIZE_T)], space, error)
    call h5acreate_by_name_f(self%id, object, name, H5T_IEEE_F64LE, space, id, error)
    call h5awrite_f(id, H5T_NATIVE_DOUBLE, c_loc(buffer), error)
    call h5aclose_f(id, error)
    call h5sclose_f(space, error)
  end subroutine real_attribute

  subroutine delete_attribute(self, object, name)
    class(wing_writer_t), intent(in) :: self
    character(*), intent(in) :: object, name
    logical :: exists
    integer :: error
    call h5aexists_by_name_f(self%id, object, name, exists, error)
    if (error >= 0 .and. exists) call h5adelete_by_name_f(self%id, object, name, error)
  end subroutine delete_attribute
end module wing_writer

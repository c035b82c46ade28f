! SPDX-License-Identifier: GPL-3.0-or-later
!> Opens, writes and closes HDF5 files, either by all ranks of a communicator with collective transfers, or by one process.
!>
!> Failure is sticky: every procedure takes a `failure_t`, does nothing if it already failed, and leaves the same verdict on all
!> ranks. A sequence of calls thus needs one check at its end. On a parallel file every procedure is collective; a rank without data
!> takes part with an empty array.
module io_hdf5
  use base_kinds, only: i8
  use base_errors, only: failure_t, require
  use base_files, only: file_exists, remove_file, empty_file, replace_file
  use base_text_file, only: reserve_space
  use io_seal, only: write_seal
  use parallel_failure, only: broadcast_failure
  use parallel_world, only: world_t
  use mpi_f08, only: MPI_INFO_NULL
  use hdf5, only: HID_T, HSIZE_T, H5F_ACC_TRUNC_F, H5F_ACC_RDONLY_F, H5F_CLOSE_STRONG_F, &
                  H5F_LIBVER_V18_F, H5F_SCOPE_GLOBAL_F, H5P_FILE_ACCESS_F, H5T_NATIVE_DOUBLE, &
                  h5open_f, h5iis_valid_f, h5eset_auto_f, &
                  h5fcreate_f, h5fopen_f, h5fclose_f, h5fflush_f, h5lexists_f, &
                  h5pcreate_f, h5pclose_f, h5pset_fapl_mpio_f, h5pset_fclose_degree_f, &
                  h5pset_libver_bounds_f, h5dopen_f, h5dclose_f, h5dget_space_f, h5sclose_f, &
                  h5sget_simple_extent_ndims_f, h5sget_simple_extent_dims_f, &
                  h5gn_members_f, h5gget_obj_info_idx_f, h5gcreate_f, h5gclose_f
  implicit none
  private
  public :: hdf5_file_t, NAME_LENGTH

  type :: hdf5_file_t
    type(world_t) :: world
    logical :: is_parallel = .false.   !< opened by all ranks of `world`
    integer(HID_T) :: id = -1          !< for io_datasets and io_attributes only
    character(:), allocatable :: path
    logical, private :: is_new = .false. !< created by us
  contains
    procedure :: create => file_create
    procedure :: create_serial => file_create_serial
    procedure :: open => file_open
    procedure :: open_serial => file_open_serial
    procedure :: flush => file_flush
    procedure :: close => file_close
    procedure :: publish => file_publish
    procedure :: agree => file_agree
    procedure :: make_group => file_make_group
    procedure :: has => file_has
    procedure :: dataset_names => file_dataset_names
    procedure :: dataset_shape => file_dataset_shape
  end type hdf5_file_t

  ! If HDF5 cannot write its last metadata when it flushes or closes a file, it crashes when MPI ends. Therefore space for these
  ! metadata is reserved at the beginning, in case the disk becomes full.
  character(*), parameter :: RESERVE = '.reserve'
  integer, parameter :: RESERVED_KILOBYTES = 256

  integer, parameter :: NAME_LENGTH = 128 !< longest name of a dataset

contains

  !> Creates a file, replacing an existing one. With `checked`, the layout of HDF5 1.8 is used, whose
  !> metadata carry checksums; the default is the oldest layout, which every tool reads. Collective.
  subroutine file_create(self, world, path, failure, checked)
    class(hdf5_file_t), intent(out) :: self
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    logical, intent(in), optional :: checked
    self%world = world
    self%is_parallel = .true.
    self%path = path
    call create_new(self, failure, checked)
  end subroutine file_create

  !> Creates a file by this process alone, replacing an existing one; MPI need not run.
  subroutine file_create_serial(self, path, failure)
    class(hdf5_file_t), intent(out) :: self
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    self%path = path
    call create_new(self, failure)
  end subroutine file_create_serial

  !> Creates the file and reserves space on the disk for it. Collective.
  subroutine create_new(self, failure, checked)
    class(hdf5_file_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    logical, intent(in), optional :: checked
    integer(HID_T) :: access
    type(failure_t) :: own
    integer :: error

    if (failure%failed) return
    if (self%world%is_root) call reserve_space(self%path//RESERVE, RESERVED_KILOBYTES, own)
    call self%agree(.not. own%failed, 'cannot be created: is the folder missing or the disk full?', failure)
    if (failure%failed) return
    self%is_new = .true.
    access = access_list(self)
    if (present(checked)) then
      if (checked) call h5pset_libver_bounds_f(access, H5F_LIBVER_V18_F, H5F_LIBVER_V18_F, error)
    end if
    call h5fcreate_f(self%path, H5F_ACC_TRUNC_F, self%id, error, access_prp=access)
    call self%agree(error >= 0, 'cannot be created', failure)
    call h5pclose_f(access, error)
    if (failure%failed) call self%close(failure)
  end subroutine create_new

  !> Opens an existing file for reading, on all ranks of `world`. Collective.
  subroutine file_open(self, world, path, failure)
    class(hdf5_file_t), intent(out) :: self
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    self%world = world
    self%is_parallel = .true.
    self%path = path
    call open_for_reading(self, failure)
  end subroutine file_open

  !> Opens an existing file for reading by this process alone; MPI need not run.
  subroutine file_open_serial(self, path, failure)
    class(hdf5_file_t), intent(out) :: self
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    self%path = path
    call open_for_reading(self, failure)
  end subroutine file_open_serial

  !> Opens the file for reading. Collective.
  subroutine open_for_reading(self, failure)
    class(hdf5_file_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    integer(HID_T) :: access
    integer :: error
    if (failure%failed) return
    call self%agree(file_exists(self%path), 'does not exist', failure)
    if (failure%failed) return
    access = access_list(self)
    call h5fopen_f(self%path, H5F_ACC_RDONLY_F, self%id, error, access)
    call self%agree(error >= 0, 'cannot be opened: truncated, damaged or not an HDF5 file', failure)
    call h5pclose_f(access, error)
  end subroutine open_for_reading

  !> Makes the file access properties: who opens the file, and that closing it closes all objects that are open in it.
  function access_list(self) result(access)
    class(hdf5_file_t), intent(in) :: self
    integer(HID_T) :: access
    logical :: is_open
    integer :: error
    ! The predefined types are valid if and only if the library is open, so that no flag is needed.
    call h5iis_valid_f(H5T_NATIVE_DOUBLE, is_open, error)
    if (error < 0 .or. .not. is_open) call h5open_f(error)
    call require(error >= 0, 'io_hdf5: the HDF5 library does not start')
    call h5eset_auto_f(0, error) ! errors are reported once, by us
    call h5pcreate_f(H5P_FILE_ACCESS_F, access, error)
    if (self%is_parallel) call h5pset_fapl_mpio_f(access, self%world%comm%mpi_val, MPI_INFO_NULL%mpi_val, &
                                                  error)
    call h5pset_fclose_degree_f(access, H5F_CLOSE_STRONG_F, error)
  end function access_list

  !> Hands everything written so far to the operating system and, on a parallel file, asks it to put it
  !> on the disk. Collective.
  subroutine file_flush(self, failure)
    class(hdf5_file_t), intent(in) :: self
    type(failure_t), intent(inout) :: failure
    integer :: error
    if (failure%failed) return
    call h5fflush_f(self%id, H5F_SCOPE_GLOBAL_F, error)
    call self%agree(error >= 0, 'cannot be written to the disk', failure)
  end subroutine file_flush

  !> Closes the file, also after a failure; the content of a failed file is lost. Collective.
  subroutine file_close(self, failure)
    class(hdf5_file_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    integer :: error
    call give_space(self, failure)
    self%is_new = .false.
    if (self%id < 0) return
    call h5fclose_f(self%id, error)
    self%id = -1
    if (.not. failure%failed) call self%agree(error >= 0, 'cannot be closed', failure)
  end subroutine file_close

  !> Frees the reserved space, so that the last metadata can be written. After a failure it also frees the space of a new file.
  !> Collective.
  subroutine give_space(self, failure)
    class(hdf5_file_t), intent(inout) :: self
    type(failure_t), intent(in) :: failure
    if (.not. self%is_new) return
    if (self%world%is_root) then
      call remove_file(self%path//RESERVE)
      if (failure%failed) call empty_file(self%path)
    end if
    if (self%is_parallel) call self%world%barrier()
  end subroutine give_space

  !> Closes a file that was written under a temporary name and renames it to `path`; after a failure it
  !> is removed instead. With `durable` the content is on the disk before the rename; with `with_seal` the file gets a seal
  !> (io_seal), for which one process reads all of it. Collective.
  subroutine file_publish(self, path, durable, failure, with_seal)
    class(hdf5_file_t), intent(inout) :: self
    character(*), intent(in) :: path
    logical, intent(in) :: durable
    type(failure_t), intent(inout) :: failure
    logical, intent(in), optional :: with_seal
    type(failure_t) :: own
    call give_space(self, failure)
    if (durable) call self%flush(failure)
    call self%close(failure)
    own = failure
    if (self%world%is_root) then
      if (present(with_seal)) then
        if (with_seal) call write_seal(self%path, own)
      end if
      call replace_file(self%path, path, durable, own)
      if (own%failed) call remove_file(self%path)
    end if
    if (self%is_parallel) then
      call broadcast_failure(self%world, own, failure)
    else if (own%failed) then
      call failure%raise(own%reason)
    end if
  end subroutine file_publish

  !> Fails on all ranks if `ok` is false on any. Collective on a parallel file.
  subroutine file_agree(self, ok, what, failure)
    class(hdf5_file_t), intent(in) :: self
    logical, intent(in) :: ok
    character(*), intent(in) :: what
    type(failure_t), intent(inout) :: failure
    integer :: bad
    bad = merge(0, 1, ok)
    if (self%is_parallel) bad = self%world%max_integer(bad)
    if (bad > 0) call failure%raise(self%path//': '//what)
  end subroutine file_agree

  !> Makes a group, in which datasets can then be written as 'group/name'. Collective.
  subroutine file_make_group(self, name, failure)
    class(hdf5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    type(failure_t), intent(inout) :: failure
    integer(HID_T) :: group
    integer :: error, ignored
    if (failure%failed) return
    call h5gcreate_f(self%id, name, group, error)
    if (error >= 0) call h5gclose_f(group, ignored)
    call self%agree(error >= 0, 'group '''//name//''' cannot be made; is the disk full?', failure)
  end subroutine file_make_group

  !> Tells whether the file holds an object of this name.
  logical function file_has(self, name) result(has)
    class(hdf5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    integer :: error
    has = .false.
    if (self%id < 0) return
    call h5lexists_f(self%id, name, has, error)
    has = has .and. error >= 0
  end function file_has

  !> Returns the names of the objects at the top of the file, blank-padded.
  subroutine file_dataset_names(self, names, failure)
    class(hdf5_file_t), intent(in) :: self
    character(NAME_LENGTH), allocatable, intent(out) :: names(:)
    type(failure_t), intent(inout) :: failure
    integer :: n, i, kind, error
    logical :: ok
    allocate (names(0))
    if (failure%failed) return
    call h5gn_members_f(self%id, '/', n, error)
    ok = error >= 0
    if (ok) then
      deallocate (names)
      allocate (names(n))
      do i = 1, n
        names(i) = ''
        call h5gget_obj_info_idx_f(self%id, '/', i - 1, names(i), kind, error)
        ok = ok .and. error >= 0
      end do
    end if
    call self%agree(ok, 'has no readable list of contents', failure)
  end subroutine file_dataset_names

  !> Returns the shape of a dataset, first Fortran index first.
  subroutine file_dataset_shape(self, name, dims, failure)
    class(hdf5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    integer(i8), allocatable, intent(out) :: dims(:)
    type(failure_t), intent(inout) :: failure
    integer(HID_T) :: dataset, space
    integer(HSIZE_T), allocatable :: extent(:), largest(:)
    integer :: rank, error
    logical :: ok
    allocate (dims(0))
    if (failure%failed) return
    rank = 0
    call h5dopen_f(self%id, name, dataset, error)
    ok = error >= 0
    if (ok) then
      call h5dget_space_f(dataset, space, error)
      ok = error >= 0
      if (ok) then
        call h5sget_simple_extent_ndims_f(space, rank, error)
        allocate (extent(rank), largest(rank))
        call h5sget_simple_extent_dims_f(space, extent, largest, error)
        ok = error >= 0
        if (ok) dims = int(extent, i8)
        call h5sclose_f(space, error)
      end if
      call h5dclose_f(dataset, error)
    end if
    call self%agree(ok, 'has no readable dataset '''//name//'''', failure)
  end subroutine file_dataset_shape
end module io_hdf5

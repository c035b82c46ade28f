! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes and reads field files: one scalar field at one time in one file, in the layout of FLUSI.
!>
!> File `<prefix>_<label>.h5` holds one dataset `<prefix>` of Fortran shape (nx, ny, nz) with attributes time, viscosity, epsi,
!> domain_size, origin and nxyz (x first). Files are written under a temporary name and renamed, so that a killed run never leaves,
!> and a reader never sees, an incomplete file.
module io_fields
  use base_kinds, only: rp, i8
  use base_build, only: BUILD_VERSION, BUILD_COMMIT
  use base_errors, only: failure_t, require
  use base_files, only: join_path, name_of
  use parallel_world, only: world_t
  use parallel_block, only: block_t
  use io_attributes, only: put_attribute, get_attribute, has_attribute
  use io_datasets, only: write_slab, read_box
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  implicit none
  private
  public :: field_form_t, field_meta_t, write_field, read_field, write_slice
  public :: field_label, field_file, slice_file, finest_naming, strided_points, find_dataset, read_meta
  public :: PRECISION_SINGLE, PRECISION_DOUBLE

  integer, parameter :: PRECISION_SINGLE = 4, PRECISION_DOUBLE = 8 !< bytes per stored number

  !> Attributes of a field in a field file; code units.
  type :: field_meta_t
    real(rp) :: time = 0
    real(rp) :: viscosity = 0
    real(rp) :: epsi = 0                !< penalization parameter C_eta
    real(rp) :: domain_size(3) = 1      !< of the periodic box, also for a strided field
    real(rp) :: origin(3) = 0           !< coordinates of the point (0, 0, 0)
    integer :: nxyz(3) = 0              !< stored points; filled in by reading
    character(:), allocatable :: units  !< optional remark on the units, stored if allocated
  end type field_meta_t

  !> How fields are written.
  type :: field_form_t
    character(:), allocatable :: directory, label !< the label tells times apart
    integer :: precision = PRECISION_DOUBLE       !< PRECISION_SINGLE or PRECISION_DOUBLE
    integer :: stride = 1                         !< points with global index mod stride == 0 are stored
  end type field_form_t

  !> A dataset in a file, and the part of it that this rank owns.
  type :: part_t
    character(:), allocatable :: file_name, dataset
    integer(i8), allocatable :: dims(:), start(:), count(:)
    integer :: nxyz(3) = 0 !< stored points of the field
  end type part_t

contains

  !> Returns the label of an output: 'time' gives milli-units of time in 6 digits, 'microtime' micro-units in 9, 'step' the step
  !> in 6; longer numbers take as many digits as they need.
  function field_label(time, step, naming) result(label)
    real(rp), intent(in) :: time
    integer(i8), intent(in) :: step
    character(*), intent(in) :: naming
    character(:), allocatable :: label
    character(24) :: digits
    select case (naming)
    case ('time')
      write (digits, '(i0.6)') nint(1.0e3_rp*time, i8)
    case ('microtime')
      write (digits, '(i0.9)') nint(1.0e6_rp*time, i8)
    case default
      call require(naming == 'step', 'field_label: naming is time, microtime or step')
      write (digits, '(i0.6)') step
    end select
    label = trim(digits)
  end function field_label

  !> Returns the naming that gives outputs `interval` apart different labels: 'microtime' in place of 'time' if the interval is
  !> below 2e-3. An output is written at the first step past its time, so that two outputs may be closer than the interval.
  pure function finest_naming(naming, interval) result(finest)
    character(*), intent(in) :: naming
    real(rp), intent(in) :: interval
    character(:), allocatable :: finest
    finest = trim(naming)
    if (finest == 'time' .and. interval < 2.0e-3_rp) finest = 'microtime'
  end function finest_naming

  !> Returns the name of a field file, without folder.
  pure function field_file(prefix, label) result(name)
    character(*), intent(in) :: prefix, label
    character(:), allocatable :: name
    name = trim(prefix)//'_'//label//'.h5'
  end function field_file

  !> Returns the name of a slice file, without folder; `ix` counts from 0.
  pure function slice_file(name, ix, label) result(file_name)
    character(*), intent(in) :: name, label
    integer, intent(in) :: ix
    character(:), allocatable :: file_name
    character(12) :: digits
    write (digits, '(i0.4)') ix
    file_name = 'slice'//trim(name)//'-ix'//trim(digits)//'_'//label//'.h5'
  end function slice_file

  !> Returns the number of points among n whose 0-based index is a multiple of `stride`.
  pure elemental integer function strided_points(n, stride)
    integer, intent(in) :: n, stride
    strided_points = (n + stride - 1)/stride
  end function strided_points

  !> Writes a field to `<prefix>_<label>.h5`. Fails, and leaves no file, if the file cannot be written. Collective.
  subroutine write_field(world, prefix, block, data, meta, form, failure)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: prefix
    type(block_t), intent(in) :: block
    real(rp), intent(in) :: data(:, :, :)    !< shape block%count
    type(field_meta_t), intent(in) :: meta
    type(field_form_t), intent(in) :: form
    type(failure_t), intent(inout) :: failure
    type(part_t) :: part
    real(rp), allocatable :: values(:)
    integer :: first(3)

    call require(form%stride >= 1, 'write_field: stride below 1')
    call require(all(shape(data) == block%count), 'write_field: data and block differ')
    part%file_name = field_file(prefix, form%label)
    part%dataset = trim(prefix)
    part%nxyz = strided_points(block%n, form%stride)
    part%dims = part%nxyz
    part%start = strided_points(block%start, form%stride) ! kept points before the block
    part%count = strided_points(block%start + block%count, form%stride) - part%start
    if (form%stride == 1) then
      call write_part(world, part, data, meta, form, failure)
      return
    end if
    first = int(part%start)*form%stride - block%start
    allocate (values(product(part%count)))
    call gather(int(part%count), first, form%stride, data, values)
    call write_part(world, part, values, meta, form, failure)
  end subroutine write_field

  !> Writes the plane of global index `ix` (0-based) of a field to `slice<name>-ix####_<label>.h5`, dataset
  !> `slice<name>-ix####` of shape (ny, nz), with all its points. Collective.
  subroutine write_slice(world, name, ix, block, data, meta, form, failure)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: name
    integer, intent(in) :: ix
    type(block_t), intent(in) :: block
    real(rp), intent(in) :: data(:, :, :)    !< shape block%count
    type(field_meta_t), intent(in) :: meta
    type(field_form_t), intent(in) :: form   !< its stride does not count
    type(failure_t), intent(inout) :: failure
    type(part_t) :: part
    real(rp), allocatable :: values(:)
    integer :: count(3)

    call require(ix >= 0 .and. ix < block%n(1), 'write_slice: plane outside of the field')
    call require(all(shape(data) == block%count), 'write_slice: data and block differ')
    count = [1, block%count(2:)]
    if (ix < block%start(1) .or. ix >= block%start(1) + block%count(1)) count = 0
    allocate (values(product(count)))
    call gather(count, [ix - block%start(1), 0, 0], 1, data, values)
    part%file_name = slice_file(name, ix, form%label)
    part%dataset = part%file_name(:index(part%file_name, '_', back=.true.) - 1)
    part%nxyz = [1, block%n(2:)]
    part%dims = block%n(2:)
    part%start = block%start(2:)
    part%count = count(2:)
    call write_part(world, part, values, meta, form, failure)
  end subroutine write_slice

  !> Copies count points from 0-based local index `first` on, every `stride`-th.
  pure subroutine gather(count, first, stride, data, values)
    integer, intent(in) :: count(3), first(3), stride
    real(rp), intent(in) :: data(:, :, :)
    real(rp), intent(out) :: values(count(1), count(2), count(3))
    integer :: i, j, k
    do k = 1, count(3)
      do j = 1, count(2)
        do i = 1, count(1)
          values(i, j, k) = data(first(1) + (i - 1)*stride + 1, first(2) + (j - 1)*stride + 1, &
                                 first(3) + (k - 1)*stride + 1)
        end do
      end do
    end do
  end subroutine gather

  !> Writes one dataset with the attributes of a field and puts the file in its place.
  subroutine write_part(world, part, values, meta, form, failure)
    type(world_t), intent(in) :: world
    type(part_t), intent(in) :: part
    real(rp), intent(in) :: values(product(part%count))
    type(field_meta_t), intent(in) :: meta
    type(field_form_t), intent(in) :: form
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    character(:), allocatable :: path

    call require(form%precision == PRECISION_SINGLE .or. form%precision == PRECISION_DOUBLE, 'io_fields: unknown precision')
    if (failure%failed) return
    path = join_path(form%directory, part%file_name)
    associate (dataset => part%dataset)
      call file%create(world, path//'.part', failure)
      call write_slab(file, dataset, part%dims, part%start, part%count, values, form%precision == PRECISION_SINGLE, failure)
      call put_attribute(file, dataset, 'time', meta%time, failure)
      call put_attribute(file, dataset, 'viscosity', meta%viscosity, failure)
      call put_attribute(file, dataset, 'epsi', meta%epsi, failure)
      call put_attribute(file, dataset, 'domain_size', meta%domain_size, failure)
      call put_attribute(file, dataset, 'origin', meta%origin, failure)
      call put_attribute(file, dataset, 'nxyz', part%nxyz, failure)
      if (allocated(meta%units)) call put_attribute(file, dataset, 'units', meta%units, failure)
      call put_attribute(file, dataset, 'program', 'flusi-msm '//BUILD_VERSION//' '//BUILD_COMMIT, failure)
    end associate
    call file%publish(path, .false., failure)
  end subroutine write_part

  !> Reads the owned box of the field in `path`, which must have shape block%n, and its attributes.
  !> Collective.
  subroutine read_field(world, path, block, data, meta, failure)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    type(block_t), intent(in) :: block
    real(rp), intent(out) :: data(:, :, :)   !< shape block%count
    type(field_meta_t), intent(out) :: meta
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    character(:), allocatable :: dataset
    call file%open(world, path, failure)
    call find_dataset(file, dataset, failure)
    call read_box(file, dataset, block, data, failure)
    call read_meta(file, dataset, meta, failure)
    call file%close(failure)
  end subroutine read_field

  !> Returns the name of the field in an open file: the part of the file name before the first underscore, or else the only dataset
  !> in the file. Collective on a parallel file.
  subroutine find_dataset(file, dataset, failure)
    type(hdf5_file_t), intent(in) :: file
    character(:), allocatable, intent(out) :: dataset
    type(failure_t), intent(inout) :: failure
    character(NAME_LENGTH), allocatable :: names(:)
    dataset = name_of(file%path)
    if (failure%failed) return
    if (index(dataset, '_') > 1) dataset = dataset(:index(dataset, '_') - 1)
    call file%dataset_names(names, failure)
    if (failure%failed) return
    if (any(names == dataset)) return
    call file%agree(size(names) == 1, 'holds neither a dataset '''//dataset//''' nor a single other one', &
                    failure)
    if (.not. failure%failed) dataset = trim(names(1))
  end subroutine find_dataset

  !> Reads the attributes of a field. Those that the file does not have keep their defaults. nxyz is the shape of the dataset, (1,
  !> ny, nz) for a slice. Collective on a parallel file.
  subroutine read_meta(file, dataset, meta, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: dataset
    type(field_meta_t), intent(out) :: meta
    type(failure_t), intent(inout) :: failure
    integer(i8), allocatable :: dims(:)
    call file%dataset_shape(dataset, dims, failure)
    if (failure%failed) return
    call file%agree(size(dims) >= 1 .and. size(dims) <= 3, 'dataset '''//dataset//''' is not a field', &
                    failure)
    if (failure%failed) return
    meta%nxyz = 1
    meta%nxyz(4 - size(dims):) = int(dims)
    if (has('time')) call get_attribute(file, dataset, 'time', meta%time, failure)
    if (has('viscosity')) call get_attribute(file, dataset, 'viscosity', meta%viscosity, failure)
    if (has('epsi')) call get_attribute(file, dataset, 'epsi', meta%epsi, failure)
    if (has('domain_size')) call get_attribute(file, dataset, 'domain_size', meta%domain_size, failure)
    if (has('origin')) call get_attribute(file, dataset, 'origin', meta%origin, failure)
    if (has('units')) call get_attribute(file, dataset, 'units', meta%units, failure)
  contains
    logical function has(name)
      character(*), intent(in) :: name
      has = has_attribute(file, dataset, name)
    end function has
  end subroutine read_meta
end module io_fields

! SPDX-License-Identifier: GPL-3.0-or-later
!> Stores the state for a restart: named numbers, texts and tables in one HDF5 file.
!>
!> A checkpoint is written under a temporary name, forced to the disk and then renamed, so that a file of the final name is
!> complete. Every table carries a checksum and the file one over all names, numbers, texts and table checksums; the sums do not
!> depend on the number of ranks. A reader refuses a file if a single bit of its content differs. Tables are in global row order:
!> any number of ranks may read what any other number wrote.
module io_checkpoint
  use base_checksum, only: checksum_reals, checksum_integers, checksum_text, checksum_add
  use base_errors, only: failure_t, require
  use base_files, only: join_path
  use base_kinds, only: rp, i8
  use io_attributes, only: put_attribute, get_attribute, has_attribute, attribute_names, attribute_class, &
                           ATTRIBUTE_REAL, ATTRIBUTE_INTEGER, ATTRIBUTE_TEXT
  use io_datasets, only: write_rows, read_rows, read_slab
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use io_selection, only: row_indices
  use parallel_block, only: rows_t, split_evenly
  use parallel_world, only: world_t
  implicit none
  private
  public :: checkpoint_writer_t, checkpoint_reader_t

  integer(i8), parameter :: FORMAT_VERSION = 1
  integer, parameter :: CLASS_TABLE = 100         !< in addition to the ATTRIBUTE_ constants
  character(*), parameter :: CONTENTS = 'contents' !< attribute with the checksum of the file
  character(*), parameter :: CHECKSUM = 'checksum' !< attribute of each table

  !> Writes one checkpoint: begin, any number of put_*, commit. A failure on the way is kept and
  !> reported by `commit`. All procedures are collective; replicated values are the same on all ranks.
  type :: checkpoint_writer_t
    private
    type(hdf5_file_t) :: file
    type(failure_t) :: failure
    character(:), allocatable :: path
    integer(i8) :: total = 0 !< checksum of the entries so far
  contains
    procedure :: begin => writer_begin
    procedure :: put_real => writer_put_real
    procedure :: put_integer => writer_put_integer
    procedure :: put_text => writer_put_text
    procedure :: put_reals => writer_put_reals
    procedure :: put_rows => writer_put_rows
    procedure :: commit => writer_commit
  end type checkpoint_writer_t

  !> Reads one checkpoint: open, which verifies everything, any number of get_*, close. All procedures
  !> but `has` are collective.
  type :: checkpoint_reader_t
    private
    type(hdf5_file_t) :: file
  contains
    procedure :: open => reader_open
    procedure :: has => reader_has
    procedure :: get_real => reader_get_real
    procedure :: get_integer => reader_get_integer
    procedure :: get_text => reader_get_text
    procedure :: get_reals => reader_get_reals
    procedure :: get_rows => reader_get_rows
    procedure :: close => reader_close
  end type checkpoint_reader_t

contains

  !> Starts the checkpoint `directory`/`name`; an existing file of that name stays until `commit`.
  subroutine writer_begin(self, world, directory, name, failure)
    class(checkpoint_writer_t), intent(out) :: self
    type(world_t), intent(in) :: world
    character(*), intent(in) :: directory, name
    type(failure_t), intent(inout) :: failure
    self%path = join_path(directory, name)
    self%failure = failure
    call self%file%create(world, self%path//'.part', self%failure, checked=.true.)
    call self%put_integer('format', FORMAT_VERSION)
    failure = self%failure
  end subroutine writer_begin

  !> Stores a replicated real number, all bits of it.
  subroutine writer_put_real(self, name, value)
    class(checkpoint_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(in) :: value
    call put_attribute(self%file, '/', name, value, self%failure)
    call account(self, name, ATTRIBUTE_REAL, checksum_reals([value], 0_i8))
  end subroutine writer_put_real

  !> Stores a replicated integer.
  subroutine writer_put_integer(self, name, value)
    class(checkpoint_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(in) :: value
    call put_attribute(self%file, '/', name, value, self%failure)
    call account(self, name, ATTRIBUTE_INTEGER, checksum_integers([value], 0_i8))
  end subroutine writer_put_integer

  !> Stores a replicated text of any length.
  subroutine writer_put_text(self, name, text)
    class(checkpoint_writer_t), intent(inout) :: self
    character(*), intent(in) :: name, text
    call put_attribute(self%file, '/', name, text, self%failure)
    call account(self, name, ATTRIBUTE_TEXT, checksum_text(text))
  end subroutine writer_put_text

  !> Stores a replicated array of any size; rank 0's values count.
  subroutine writer_put_reals(self, name, values)
    class(checkpoint_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(in) :: values(:)
    type(rows_t) :: rows
    rows = one_run(size(values), 0, merge(size(values), 0, self%file%world%is_root))
    call self%put_rows(name, reshape(values(:rows%n_local), [1, rows%n_local]), rows)
  end subroutine writer_put_reals

  !> Stores a distributed table; together the ranks own every row exactly once.
  subroutine writer_put_rows(self, name, data, rows)
    class(checkpoint_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(in) :: data(:, :)     !< shape (ncol, rows%n_local)
    type(rows_t), intent(in) :: rows
    integer, allocatable :: indices(:)
    integer(i8) :: total
    integer :: i

    call require(size(data, 2) == rows%n_local, 'io_checkpoint: put_rows: data and rows differ')
    call require(self%file%world%sum_int8(int(rows%n_local, i8)) == rows%n, &
                 'io_checkpoint: put_rows: the ranks do not own every row once')
    allocate (indices(rows%n_local))
    indices(:) = row_indices(rows)
    total = 0
    do i = 1, rows%n_local
      total = checksum_add(total, checksum_reals(data(:, i), indices(i)*size(data, 1, kind=i8)))
    end do
    total = self%file%world%sum_int8(total)
    call write_rows(self%file, name, data, rows, self%failure)
    call put_attribute(self%file, name, CHECKSUM, total, self%failure)
    call account(self, name, CLASS_TABLE, total)
  end subroutine writer_put_rows

  !> Completes the checkpoint and puts it in its place; afterwards it survives a kill and a power
  !> failure. After any failure the previous file of this name is untouched.
  subroutine writer_commit(self, failure)
    class(checkpoint_writer_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    call put_attribute(self%file, '/', CONTENTS, self%total, self%failure)
    call self%file%publish(self%path, .true., self%failure)
    if (self%failure%failed) call failure%raise(self%failure%reason)
  end subroutine writer_commit

  !> Adds one entry to the checksum of the file.
  subroutine account(self, name, class, value)
    class(checkpoint_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: class
    integer(i8), intent(in) :: value
    call require(len(name) <= NAME_LENGTH .and. len_trim(name) == len(name) .and. name /= CONTENTS, &
                 'io_checkpoint: bad name '''//name//'''')
    self%total = checksum_add(self%total, entry(name, class, value))
  end subroutine account

  !> Returns the share of one entry in the checksum of the file.
  pure integer(i8) function entry(name, class, value)
    character(*), intent(in) :: name
    integer, intent(in) :: class
    integer(i8), intent(in) :: value
    entry = checksum_integers([checksum_text(name), int(class, i8), value], 0_i8)
  end function entry

  !> Opens a checkpoint and verifies all of it; fails with the reason if it is missing, incomplete or
  !> damaged.
  subroutine reader_open(self, world, path, failure)
    class(checkpoint_reader_t), intent(out) :: self
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    integer(i8) :: total, stored, version

    call self%file%open(world, path, failure)
    if (failure%failed) return
    call self%file%agree(has_attribute(self%file, '/', CONTENTS), 'is not a checkpoint of flusi-msm', failure)
    call get_attribute(self%file, '/', CONTENTS, stored, failure)
    call get_attribute(self%file, '/', 'format', version, failure)
    if (.not. failure%failed) call self%file%agree(version == FORMAT_VERSION, &
                                                   'has the format of another version of flusi-msm: '// &
                                                   'restart with that version', failure)
    total = 0
    call verify_values(self%file, total, failure)
    call verify_tables(self%file, total, failure)
    if (.not. failure%failed) call self%file%agree(total == stored, &
                                                   'is damaged: the checksum of its contents differs', &
                                                   failure)
    if (failure%failed) call self%file%close(failure)
  end subroutine reader_open

  !> Adds the numbers and texts of a checkpoint to `total`.
  subroutine verify_values(file, total, failure)
    type(hdf5_file_t), intent(in) :: file
    integer(i8), intent(inout) :: total
    type(failure_t), intent(inout) :: failure
    character(NAME_LENGTH), allocatable :: names(:)
    character(:), allocatable :: text
    real(rp) :: real_value
    integer(i8) :: long, value
    integer :: i, class

    call attribute_names(file, '/', names, failure)
    do i = 1, size(names)
      if (failure%failed) return
      if (names(i) == CONTENTS) cycle
      value = 0
      class = attribute_class(file, '/', trim(names(i)))
      select case (class)
      case (ATTRIBUTE_REAL)
        call get_attribute(file, '/', trim(names(i)), real_value, failure)
        value = checksum_reals([real_value], 0_i8)
      case (ATTRIBUTE_INTEGER)
        call get_attribute(file, '/', trim(names(i)), long, failure)
        value = checksum_integers([long], 0_i8)
      case (ATTRIBUTE_TEXT)
        call get_attribute(file, '/', trim(names(i)), text, failure)
        value = checksum_text(text)
      end select
      total = checksum_add(total, entry(trim(names(i)), class, value))
    end do
  end subroutine verify_values

  !> Compares every table with its checksum and adds it to `total`.
  subroutine verify_tables(file, total, failure)
    type(hdf5_file_t), intent(in) :: file
    integer(i8), intent(inout) :: total
    type(failure_t), intent(inout) :: failure
    character(NAME_LENGTH), allocatable :: names(:)
    integer(i8) :: stored, found
    integer :: i

    call file%dataset_names(names, failure)
    do i = 1, size(names)
      call get_attribute(file, trim(names(i)), CHECKSUM, stored, failure)
      call table_checksum(file, trim(names(i)), found, failure)
      if (failure%failed) return
      call file%agree(found == stored, 'is damaged: the checksum of table '''//trim(names(i))//''' differs', &
                      failure)
      total = checksum_add(total, entry(trim(names(i)), CLASS_TABLE, stored))
    end do
  end subroutine verify_tables

  !> Returns the checksum of a table; each rank reads an equal share of the rows in pieces.
  subroutine table_checksum(file, name, total, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(i8), intent(out) :: total
    type(failure_t), intent(inout) :: failure
    integer(i8), parameter :: PIECE = 2_i8**20 ! numbers in memory at a time
    integer(i8), allocatable :: dims(:)
    integer(i8) :: first, last, step, most
    real(rp), allocatable :: values(:)
    integer :: start, count

    total = 0
    call file%dataset_shape(name, dims, failure)
    if (failure%failed) return
    call file%agree(size(dims) == 2, 'is damaged: '''//name//''' is not a table', failure)
    if (failure%failed) return
    call split_evenly(int(dims(2)), file%world%size, file%world%rank, start, count)
    step = max(1_i8, PIECE/max(1_i8, dims(1)))
    most = (dims(2) + file%world%size - 1)/file%world%size ! all ranks take part in the same number of reads
    do first = 0, most - 1, step
      last = min(first + step, int(count, i8))
      allocate (values(dims(1)*max(0_i8, last - first)))
      call read_slab(file, name, dims, [0_i8, start + first], [dims(1), max(0_i8, last - first)], values, &
                     failure)
      total = checksum_add(total, checksum_reals(values, (start + first)*dims(1)))
      deallocate (values)
    end do
    total = file%world%sum_int8(total)
  end subroutine table_checksum

  !> Tells whether the checkpoint holds an entry of this name.
  logical function reader_has(self, name) result(has)
    class(checkpoint_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    has = self%file%has(name)
    if (.not. has) has = has_attribute(self%file, '/', name)
  end function reader_has

  !> Reads a real number.
  subroutine reader_get_real(self, name, value, failure)
    class(checkpoint_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rp), intent(out) :: value
    type(failure_t), intent(inout) :: failure
    call get_attribute(self%file, '/', name, value, failure)
  end subroutine reader_get_real

  !> Reads an integer.
  subroutine reader_get_integer(self, name, value, failure)
    class(checkpoint_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    integer(i8), intent(out) :: value
    type(failure_t), intent(inout) :: failure
    call get_attribute(self%file, '/', name, value, failure)
  end subroutine reader_get_integer

  !> Reads a text.
  subroutine reader_get_text(self, name, text, failure)
    class(checkpoint_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(out) :: text
    type(failure_t), intent(inout) :: failure
    call get_attribute(self%file, '/', name, text, failure)
  end subroutine reader_get_text

  !> Reads a replicated array, on every rank, in the size it was stored with.
  subroutine reader_get_reals(self, name, values, failure)
    class(checkpoint_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rp), allocatable, intent(out) :: values(:)
    type(failure_t), intent(inout) :: failure
    integer(i8), allocatable :: dims(:)
    real(rp), allocatable :: data(:, :)
    integer :: n
    n = 0
    call self%file%dataset_shape(name, dims, failure)
    if (size(dims) == 2) n = int(dims(2))
    allocate (data(1, n))
    call read_rows(self%file, name, data, one_run(n, 0, n), failure)
    values = data(1, :)
  end subroutine reader_get_reals

  !> Reads rows of a table, those that this rank wants; the table must have rows%n rows of
  !> size(data, 1) columns.
  subroutine reader_get_rows(self, name, data, rows, failure)
    class(checkpoint_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rp), intent(out) :: data(:, :)    !< shape (ncol, rows%n_local)
    type(rows_t), intent(in) :: rows
    type(failure_t), intent(inout) :: failure
    call read_rows(self%file, name, data, rows, failure)
  end subroutine reader_get_rows

  !> Closes the checkpoint.
  subroutine reader_close(self, failure)
    class(checkpoint_reader_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    call self%file%close(failure)
  end subroutine reader_close

  !> Returns `count` of n rows from `start` on.
  pure function one_run(n, start, count) result(rows)
    integer, intent(in) :: n, start, count
    type(rows_t) :: rows
    rows%n = n
    rows%n_local = count
    allocate (rows%start(1), rows%count(1), rows%stride(1))
    rows%start = start
    rows%count = count
    rows%stride = 1
  end function one_run
end module io_checkpoint

! SPDX-License-Identifier: GPL-3.0-or-later
!> A checkpoint comes back bit by bit on any number of ranks, and damage of any kind is refused.
program test_checkpoint
  use base_errors, only: failure_t
  use base_files, only: file_exists, make_folder
  use base_kinds, only: rp, i8
  use io_attributes, only: put_attribute
  use io_checkpoint, only: checkpoint_writer_t, checkpoint_reader_t
  use io_hdf5, only: hdf5_file_t
  use io_selection, only: row_indices
  use mpi_f08, only: MPI_Comm, MPI_Comm_split
  use parallel_block, only: rows_t
  use parallel_world, only: world_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  integer, parameter :: NCOL = 3, NROW = 23
  character(*), parameter :: INPUT = '[Time]'//new_line('a')//'Tmax=1.0; ends here  '

  call t%start(parallel=.true.)
  call write_example('example.h5')
  call test_other_rank_counts()
  call test_damage()
  call test_refusals()
  call t%finish()

contains

  !> Every size-th row of `world`, the later half first.
  function comb_rows(world, n) result(rows)
    type(world_t), intent(in) :: world
    integer, intent(in) :: n
    type(rows_t) :: rows
    integer :: mine, half
    mine = (n - world%rank + world%size - 1)/world%size
    half = mine/2
    rows%n = n
    rows%start = [world%rank + half*world%size, world%rank]
    rows%count = [mine - half, half]
    rows%stride = [world%size, world%size]
    rows%n_local = mine
  end function comb_rows

  !> The bits of column c of row i: small and huge numbers, a negative zero, a NaN.
  pure integer(i8) function bits(c, i)
    integer, intent(in) :: c, i
    bits = transfer(sin(real(i*NCOL + c, rp))*10.0_rp**(27*(i - 11)), 0_i8)
    if (i == 5) bits = ibset(0_i8, 63)
    if (i == 6 .and. c == 2) bits = int(z'7FF8000000000123', i8)
    if (i == 7) bits = 1_i8
  end function bits

  subroutine write_example(path)
    character(*), intent(in) :: path
    type(checkpoint_writer_t) :: writer
    type(failure_t) :: failure
    type(rows_t) :: rows, empty
    integer(i8), allocatable :: words(:, :)
    integer, allocatable :: indices(:)
    integer :: i, c

    rows = comb_rows(t%world, NROW)
    allocate (indices(rows%n_local), words(NCOL, rows%n_local))
    indices(:) = row_indices(rows)
    do i = 1, rows%n_local
      words(:, i) = [(bits(c, indices(i)), c=1, NCOL)]
    end do
    allocate (empty%start(0), empty%count(0), empty%stride(0))
    call writer%begin(t%world, '.', path, failure)
    call writer%put_real('time', 1.0_rp/3)
    call writer%put_real('dt_old', tiny(1.0_rp))
    call writer%put_integer('step', huge(1_i8))
    call writer%put_text('input', INPUT)
    call writer%put_text('nothing', '')
    call writer%put_text('long', repeat('0123456789', 7000))
    call writer%put_reals('history', [0.1_rp, -0.2_rp, 0.3_rp])
    call writer%put_reals('no_history', [real(rp) ::])
    call writer%put_rows('state', reshape(transfer(words, [0.0_rp]), [NCOL, rows%n_local]), rows)
    call writer%put_rows('no_rows', reshape([real(rp) ::], [4, 0]), empty)
    call writer%commit(failure)
    call t%check('a checkpoint is written',.not. failure%failed)
    if (failure%failed) call t%check(failure%reason, .false.)
    call t%check('and nothing else', file_exists(path) .and. .not. file_exists(path//'.part'))
  end subroutine write_example

  !> Whether the file opens and holds exactly what write_example put; `refused` if it does not open.
  subroutine read_example(world, path, same, refused, reason)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    logical, intent(out) :: same, refused
    character(:), allocatable, intent(out) :: reason
    type(checkpoint_reader_t) :: reader
    type(failure_t) :: failure
    type(rows_t) :: rows
    real(rp), allocatable :: data(:, :), values(:)
    integer, allocatable :: indices(:)
    character(:), allocatable :: text
    real(rp) :: time
    integer(i8) :: step
    integer :: i, c

    reason = ''
    same = .false.
    call reader%open(world, path, failure)
    refused = failure%failed
    if (refused) reason = failure%reason
    if (refused) return
    rows = comb_rows(world, NROW)
    allocate (indices(rows%n_local), data(NCOL, rows%n_local))
    indices(:) = row_indices(rows)
    call reader%get_rows('state', data, rows, failure)
    same = .true.
    do i = 1, rows%n_local
      do c = 1, NCOL
        same = same .and. transfer(data(c, i), 0_i8) == bits(c, indices(i))
      end do
    end do
    call reader%get_real('time', time, failure)
    same = same .and. abs(time - 1.0_rp/3) <= 0
    call reader%get_real('dt_old', time, failure)
    same = same .and. abs(time - tiny(1.0_rp)) <= 0
    call reader%get_integer('step', step, failure)
    same = same .and. step == huge(1_i8)
    call reader%get_text('input', text, failure)
    same = same .and. text == INPUT .and. len(text) == len(INPUT)
    call reader%get_text('nothing', text, failure)
    same = same .and. len(text) == 0
    call reader%get_text('long', text, failure)
    same = same .and. text == repeat('0123456789', 7000)
    call reader%get_reals('history', values, failure)
    same = same .and. size(values) == 3
    if (same) same = all(abs(values - [0.1_rp, -0.2_rp, 0.3_rp]) <= 0)
    call reader%get_reals('no_history', values, failure)
    same = same .and. size(values) == 0
    same = same .and. reader%has('state') .and. reader%has('time') .and. .not. reader%has('other')
    call reader%close(failure)
    same = same .and. .not. failure%failed
  end subroutine read_example

  subroutine test_other_rank_counts()
    type(world_t) :: part
    type(MPI_Comm) :: comm
    character(:), allocatable :: reason
    logical :: same, refused
    call read_example(t%world, 'example.h5', same, refused, reason)
    call t%check('it comes back bit by bit on as many ranks '//reason, same)
    call MPI_Comm_split(t%world%comm, merge(0, 1, t%world%is_root), t%world%rank, comm)
    call part%adopt(comm)
    call read_example(part, 'example.h5', same, refused, reason)
    call t%check('and on one and on all other ranks '//reason, same)
  end subroutine test_other_rank_counts

  !> The file as bytes; on root only.
  subroutine load(path, content)
    character(*), intent(in) :: path
    character(1), allocatable, intent(out) :: content(:)
    integer :: unit, length
    inquire (file=path, size=length)
    allocate (content(length))
    open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read')
    read (unit) content
    close (unit)
  end subroutine load

  subroutine save(path, content)
    character(*), intent(in) :: path
    character(1), intent(in) :: content(:)
    integer :: unit
    open (newunit=unit, file=path, access='stream', form='unformatted', status='replace', action='write')
    write (unit) content
    close (unit)
  end subroutine save

  !> Flips one bit at places all over the file: it is either refused or nothing of the content changed.
  subroutine test_damage()
    character(1), allocatable :: content(:)
    character(1) :: pattern(8)
    character(:), allocatable :: reason
    integer :: length, place, at, n_refused, n_wrong, i
    logical :: same, refused

    length = 0
    at = 0
    if (t%world%is_root) then
      call load('example.h5', content)
      length = size(content)
      pattern = transfer(bits(2, 11), pattern)
      do i = 1, length - 7
        if (all(content(i:i + 7) == pattern)) at = i
      end do
    end if
    call t%world%broadcast_integer(length)
    call t%world%broadcast_integer(at)
    call t%check('the table is stored as it is', at > 0)

    n_refused = 0
    n_wrong = 0
    do place = 1, length, max(1, length/60)
      call flip(content, place)
      call read_example(t%world, 'damaged.h5', same, refused, reason)
      if (refused) n_refused = n_refused + 1
      if (t%world%max_integer(merge(0, 1, refused .or. same)) > 0) n_wrong = n_wrong + 1
    end do
    call t%check('no flipped bit anywhere changes what is read', n_wrong == 0)
    call t%check('flipped bits are refused', n_refused > 20)
    call flip(content, at + 3)
    call read_example(t%world, 'damaged.h5', same, refused, reason)
    call t%check('a flipped bit of a table is refused: '//reason, refused .and. index(reason, 'checksum') > 0)

  end subroutine test_damage

  !> Writes damaged.h5, the content with one flipped bit of byte `place`.
  subroutine flip(content, place)
    character(1), allocatable, intent(in) :: content(:)
    integer, intent(in) :: place
    character(1), allocatable :: damaged(:)
    if (t%world%is_root) then
      damaged = content
      damaged(place) = achar(ieor(iachar(damaged(place)), 2**mod(place, 8)))
      call save('damaged.h5', damaged)
    end if
    call t%world%barrier()
  end subroutine flip

  subroutine test_refusals()
    character(1), allocatable :: content(:)
    character(:), allocatable :: reason
    logical :: same, refused
    integer :: part
    type(checkpoint_writer_t) :: writer
    type(hdf5_file_t) :: file
    type(failure_t) :: failure, there, taken

    do part = 0, 9
      if (t%world%is_root) then
        call load('example.h5', content)
        call save('truncated.h5', content(:(size(content) - 1)*part/9))
      end if
      call t%world%barrier()
      call read_example(t%world, 'truncated.h5', same, refused, reason)
      call t%check('a truncated file is refused: '//reason, refused)
    end do
    call read_example(t%world, 'absent.h5', same, refused, reason)
    call t%check('a missing file is refused: '//reason, refused .and. index(reason, 'does not exist') > 0)

    ! A file that HDF5 finds in order, whose values are not those that were put.
    call file%create(t%world, 'forged.h5', failure, checked=.true.)
    call put_attribute(file, '/', 'format', 1_i8, failure)
    call put_attribute(file, '/', 'time', 1.0_rp, failure)
    call put_attribute(file, '/', 'contents', 1234567890123_i8, failure)
    call file%close(failure)
    call read_example(t%world, 'forged.h5', same, refused, reason)
    call t%check('other values are refused: '//reason, refused .and. index(reason, 'contents differs') > 0)
    call file%create(t%world, 'forged.h5', failure)
    call put_attribute(file, '/', 'time', 1.0_rp, failure)
    call file%close(failure)
    call read_example(t%world, 'forged.h5', same, refused, reason)
    call t%check('another HDF5 file is refused: '//reason, refused .and. index(reason, &
                                                                               'not a checkpoint') > 0)

    call writer%begin(t%world, 'no/such/folder', 'x.h5', failure)
    call writer%put_real('time', 0.0_rp)
    call writer%commit(failure)
    call t%check('a missing folder is a failure', failure%failed)
    if (t%world%is_root) call make_folder('taken.h5', there) ! perhaps of an earlier run of this test
    call writer%begin(t%world, '.', 'taken.h5', taken)
    call t%check('a checkpoint begins', .not. taken%failed)
    call writer%put_real('time', 0.0_rp)
    call writer%commit(taken)
    call t%check('if a folder has its name, that is a failure on all ranks', taken%failed)
    if (taken%failed) call t%check('that names both', taken%reason == './taken.h5.part: cannot be renamed to ./taken.h5')
    call t%check('and nothing is left of it', .not. file_exists('taken.h5.part'))
  end subroutine test_refusals
end program test_checkpoint

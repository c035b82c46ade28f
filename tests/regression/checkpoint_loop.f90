! SPDX-License-Identifier: GPL-3.0-or-later
!> The victim of kill_checkpoint.sh and disk_full.sh.
!>
!>     checkpoint_loop write N   writes N checkpoints of 8 MB, naming each committed generation on stdout
!>     checkpoint_loop verify    prints the newest valid generation; exit code 1 if there is none or if
!>                               it does not hold what was written
program checkpoint_loop
  use base_errors, only: failure_t
  use base_files, only: join_path
  use base_kinds, only: rp, i8
  use io_checkpoint, only: checkpoint_writer_t, checkpoint_reader_t
  use io_checkpoint_slots, only: checkpoint_slots_t
  use parallel_block, only: rows_t, split_evenly
  use parallel_world, only: world_t
  use, intrinsic :: iso_c_binding, only: c_funptr, c_int, c_intptr_t
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  implicit none
  integer, parameter :: NROW = 250000, NCOL = 4
  type(world_t) :: world
  type(checkpoint_slots_t) :: slots
  type(rows_t) :: rows
  real(rp), allocatable :: table(:, :)
  character(16) :: mode, number
  logical :: ok
  integer :: n, code

  interface
    type(c_funptr) function c_signal(number, handler) bind(C, name='signal')
      import :: c_int, c_funptr
      integer(c_int), value :: number
      type(c_funptr), value :: handler
    end function c_signal
  end interface

  call world%start()
  call ignore_size_limit()
  rows%n = NROW
  allocate (rows%start(1), rows%count(1), rows%stride(1))
  rows%stride = 1
  call split_evenly(NROW, world%size, world%rank, rows%start(1), rows%count(1))
  rows%n_local = rows%count(1)
  allocate (table(NCOL, rows%n_local))
  call get_command_argument(1, mode)
  call slots%scan(world, '.', 'runtime_backup')
  ok = .false.
  if (mode == 'write') then
    call get_command_argument(2, number)
    read (number, *) n
    call write_some(n, ok)
  else if (mode == 'verify') then
    call verify(ok)
  end if
  code = world%max_integer(merge(0, 1, ok))
  call world%stop()
  if (code > 0) stop 1

contains

  !> Makes writing beyond the limit on file sizes fail, like writing to a full disk, instead of ending the program.
  subroutine ignore_size_limit()
    integer(c_int), parameter :: SIGXFSZ = 25 ! of Linux
    integer(c_intptr_t), parameter :: SIG_IGN = 1
    type(c_funptr) :: previous
    previous = c_signal(SIGXFSZ, transfer(SIG_IGN, previous))
  end subroutine ignore_size_limit

  !> What generation `generation` holds: every number differs from that of the generation before.
  subroutine fill(generation)
    integer(i8), intent(in) :: generation
    integer :: i, c
    do i = 1, rows%n_local
      do c = 1, NCOL
        table(c, i) = real(rows%start(1) + i, rp)*NCOL + c + 1.0_rp/real(generation, rp)
      end do
    end do
  end subroutine fill

  subroutine write_some(n, ok)
    integer, intent(in) :: n
    logical, intent(out) :: ok
    type(checkpoint_writer_t) :: writer
    type(failure_t) :: failure
    integer :: i
    do i = 1, n
      call fill(slots%newest_generation() + 1)
      call slots%begin(writer, failure)
      call writer%put_integer('copy', slots%newest_generation() + 1)
      call writer%put_rows('table', table, rows)
      call slots%commit(writer, failure)
      if (failure%failed) exit
      if (world%is_root) write (output_unit, '(a,i0)') 'committed ', slots%newest_generation()
      flush (output_unit)
    end do
    ok = .not. failure%failed
    if (failure%failed .and. world%is_root) write (error_unit, '(a)') failure%reason
  end subroutine write_some

  subroutine verify(ok)
    logical, intent(out) :: ok
    type(checkpoint_reader_t) :: reader
    type(failure_t) :: failure
    character(:), allocatable :: name
    real(rp), allocatable :: stored(:, :)
    integer(i8) :: copy
    call slots%newest_valid(name, ok)
    if (world%is_root) write (output_unit, '(a,i0,3a)') 'newest ', slots%newest_generation(), ' (', &
      slots%reason(0), slots%reason(1)//')'
    if (.not. ok) return
    call reader%open(world, join_path('.', name), failure)
    call reader%get_integer('copy', copy, failure)
    allocate (stored(NCOL, rows%n_local))
    call reader%get_rows('table', stored, rows, failure)
    call reader%close(failure)
    ok = .not. failure%failed .and. copy == slots%newest_generation()
    if (.not. ok) return
    call fill(copy)
    ok = all(abs(stored - table) <= 0)
  end subroutine verify
end program checkpoint_loop

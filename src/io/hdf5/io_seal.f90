! SPDX-License-Identifier: GPL-3.0-or-later
!> Seals HDF5 files that people pass on: a line of 64 bytes after the end of the file holds the checksum of all bytes before.
!>
!>     flusi-msm seal 1 crc32 5f3a09c1 bytes 0000000000029455
!>
!> HDF5 does not read beyond the end that a file states, so that every reader opens a sealed file as usual. A program that writes
!> into a sealed file cuts the seal off; the file then counts as unsealed, not as damaged. Some damage crashes the library.
!> Therefore the seal is checked before a file is opened, and a file without a seal is first opened by another process.
module io_seal
  use, intrinsic :: iso_fortran_env, only: int8
  use base_child, only: run_child
  use base_crc32, only: crc32_t
  use base_errors, only: failure_t
  use base_files, only: file_exists, folder_of, join_path, real_path
  use base_kinds, only: i8
  use base_text, only: number_text
  implicit none
  private
  public :: check_seal, write_seal, guard_input
  public :: SEAL_GOOD

  integer, parameter :: SEAL_MISSING = 0, SEAL_GOOD = 1, SEAL_BROKEN = 2
  character(*), parameter :: PROBE = 'msm_probe' !< the program that opens a file first

  integer, parameter :: LENGTH = 64, PIECE = 65536
  character(*), parameter :: MARK = new_line('a')//'flusi-msm seal 1 crc32 ', SIZE_MARK = ' bytes '

contains

  !> Fails if the file `path` must not be passed to HDF5: if its seal shows that it is damaged, or if it has none and the program
  !> msm_probe crashes when it reads the file. `kind` tells msm_probe which kind of file it is. If msm_probe is not in the folder
  !> of the running program, nothing is tried. A file that cannot be read is left to its reader.
  subroutine guard_input(path, kind, failure)
    character(*), intent(in) :: path, kind
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: probe_path
    integer :: state, code, signal
    logical :: started
    if (failure%failed .or. .not. file_exists(path)) return
    call check_seal(path, state)
    if (state == SEAL_BROKEN) then
      call failure%raise(path//': is damaged: its bytes differ from the checksum at its end')
    else if (state == SEAL_MISSING) then
      probe_path = join_path(folder_of(real_path('/proc/self/exe')), PROBE)
      if (.not. file_exists(probe_path)) return
      call run_child(probe_path, kind, path, started, code, signal)
      if (started .and. signal > 0) call failure%raise(path//': is damaged: the HDF5 library crashes when it reads it '// &
                                                       '(signal '//number_text(signal)//')')
    end if
  end subroutine guard_input

  !> Returns the state of the seal of a file. The seal counts as missing if the file cannot be read.
  subroutine check_seal(path, state)
    character(*), intent(in) :: path
    integer, intent(out) :: state
    character(LENGTH) :: seal
    integer(i8) :: total
    integer :: unit, status
    state = SEAL_MISSING
    open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old', iostat=status)
    if (status /= 0) return
    inquire (unit=unit, size=total)
    if (total > LENGTH) then
      read (unit, pos=total - LENGTH + 1, iostat=status) seal
      if (status == 0 .and. index(seal, MARK) == 1) then
        state = SEAL_BROKEN
        if (seal == seal_of(unit, total - LENGTH)) state = SEAL_GOOD
      end if
    end if
    close (unit)
  end subroutine check_seal

  !> Seals a closed file, unless it has a valid seal. Does nothing after a failure; fails if it cannot write the seal.
  subroutine write_seal(path, failure)
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    character(LENGTH) :: seal
    integer(i8) :: total
    integer :: unit, state, status
    if (failure%failed) return
    call check_seal(path, state)
    if (state == SEAL_GOOD) return
    open (newunit=unit, file=path, access='stream', form='unformatted', action='readwrite', status='old', iostat=status)
    if (status == 0) then
      inquire (unit=unit, size=total)
      seal = seal_of(unit, total)
      write (unit, pos=total + 1, iostat=status) seal
      close (unit)
      call check_seal(path, state)
    end if
    if (state /= SEAL_GOOD) call failure%raise(path//': cannot be sealed by a checksum at its end; is the disk full?')
  end subroutine write_seal

  !> Returns the seal of the first `total` bytes; blank if they cannot be read.
  function seal_of(unit, total) result(seal)
    integer, intent(in) :: unit
    integer(i8), intent(in) :: total
    character(LENGTH) :: seal
    integer(int8), allocatable :: bytes(:)
    character(16) :: number
    type(crc32_t) :: sum
    integer(i8) :: at
    integer :: status
    seal = ''
    do at = 0, total - 1, PIECE
      allocate (bytes(min(int(PIECE, i8), total - at)))
      read (unit, pos=at + 1, iostat=status) bytes
      if (status /= 0) return
      call sum%add(bytes)
      deallocate (bytes)
    end do
    write (number, '(i16.16)') total
    seal = MARK//sum%value()//SIZE_MARK//number
    seal(LENGTH:) = new_line('a')
  end function seal_of
end module io_seal

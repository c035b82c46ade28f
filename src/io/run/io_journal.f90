! SPDX-License-Identifier: GPL-3.0-or-later
!> Records answers to questions, and returns them when a program starts again and asks the same questions in the same order. A
!> program that depends only on these answers then continues where it was interrupted.
!>
!> A journal grows by one record for each answer, and a kill does not remove records. It is no HDF5 file, because these can neither
!> be extended nor be read after a kill. Every record has a key, which identifies the question, and a checksum. The first record
!> that is incomplete, damaged or answers another question ends the recall, and is overwritten. One process uses it.
module io_journal
  use base_checksum, only: checksum_add, checksum_integers, checksum_reals
  use base_files, only: file_exists, remove_file
  use base_kinds, only: i8, rp
  implicit none
  private
  public :: journal_t

  integer(i8), parameter :: MARK = int(z'4A4E4C31464D534D', i8), VERSION = 1
  integer, parameter :: HEADER_BYTES = 32, RECORD_BYTES = 32

  type :: journal_t
    integer :: n_recalled = 0                 !< answers that the journal had
    integer :: n_recorded = 0                 !< answers that were added
    logical, private :: is_open = .false., is_recalling = .false.
    character(:), allocatable, private :: path
    integer, private :: unit = -1
    integer(i8), private :: at = 1            !< where the next record begins
  contains
    procedure :: start => journal_start
    procedure :: recall => journal_recall
    procedure :: record => journal_record
    procedure :: finish => journal_finish
  end type journal_t

contains

  !> Opens the journal `path`. `goes_on` is true if it exists and has the same `fingerprint`; otherwise a new journal begins. If no
  !> file can be written, nothing is recorded, and the results are the same.
  subroutine journal_start(self, path, fingerprint, goes_on)
    class(journal_t), intent(inout) :: self
    character(*), intent(in) :: path
    integer(i8), intent(in) :: fingerprint
    logical, intent(out) :: goes_on
    integer(i8) :: header(4)
    integer :: status
    logical :: ok
    goes_on = .false.
    self%path = path
    if (file_exists(path)) then
      open (newunit=self%unit, file=path, access='stream', form='unformatted', action='readwrite', status='old', &
            iostat=status)
      if (status /= 0) return
      read (self%unit, iostat=status) header
      if (status == 0) goes_on = all(header == header_of(fingerprint))
      if (.not. goes_on) then
        close (self%unit)
        call remove_file(path, ok)
      end if
    end if
    if (.not. goes_on) then
      open (newunit=self%unit, file=path, access='stream', form='unformatted', action='readwrite', status='replace', &
            iostat=status)
      if (status /= 0) return
      write (self%unit, iostat=status) header_of(fingerprint)
      flush (self%unit)
    end if
    self%is_open = .true.
    self%is_recalling = goes_on
    self%at = HEADER_BYTES + 1
  end subroutine journal_start

  !> Returns the header of a journal.
  pure function header_of(fingerprint) result(header)
    integer(i8), intent(in) :: fingerprint
    integer(i8) :: header(4)
    header(:3) = [MARK, VERSION, fingerprint]
    header(4) = checksum_integers(header(:3), 0_i8)
  end function header_of

  !> Finds the answer to the question `key` of as many numbers as `values`. If it `is_found`, it also tells whether it is valid.
  subroutine journal_recall(self, key, values, is_valid, is_found)
    class(journal_t), intent(inout) :: self
    integer(i8), intent(in) :: key
    real(rp), contiguous, intent(inout) :: values(:, :)
    logical, intent(inout) :: is_valid
    logical, intent(out) :: is_found
    integer(i8) :: record(4)
    integer :: status
    is_found = .false.
    if (.not. self%is_recalling) return
    read (self%unit, pos=self%at, iostat=status) record
    if (status == 0) is_found = record(1) == key .and. record(2) == size(values, kind=i8)
    if (is_found) read (self%unit, iostat=status) values
    is_found = is_found .and. status == 0
    if (is_found) is_found = record(4) == checksum_of(record(:3), values)
    self%is_recalling = is_found
    if (.not. is_found) return
    is_valid = record(3) == 1
    self%at = self%at + RECORD_BYTES + 8*record(2)
    self%n_recalled = self%n_recalled + 1
  end subroutine journal_recall

  !> Records the answer `values` to the question `key`.
  subroutine journal_record(self, key, values, is_valid)
    class(journal_t), intent(inout) :: self
    integer(i8), intent(in) :: key
    real(rp), contiguous, intent(in) :: values(:, :)
    logical, intent(in) :: is_valid
    integer(i8) :: record(3)
    integer :: status
    if (.not. self%is_open) return
    record = [key, size(values, kind=i8), merge(1_i8, 0_i8, is_valid)]
    write (self%unit, pos=self%at, iostat=status) record, checksum_of(record, values), values
    if (status == 0) flush (self%unit, iostat=status)
    self%is_open = status == 0
    self%at = self%at + RECORD_BYTES + 8*record(2)
    self%n_recorded = self%n_recorded + 1
  end subroutine journal_record

  !> Returns the checksum of a record and its values.
  pure integer(i8) function checksum_of(record, values) result(total)
    integer(i8), intent(in) :: record(3)
    real(rp), intent(in) :: values(:, :)
    integer :: i
    total = checksum_integers(record, 0_i8)
    do i = 1, size(values, 2)
      total = checksum_add(total, checksum_reals(values(:, i), 3 + (i - 1)*size(values, 1, kind=i8)))
    end do
  end function checksum_of

  !> Closes the journal; with `is_done` it is removed.
  subroutine journal_finish(self, is_done)
    class(journal_t), intent(inout) :: self
    logical, intent(in) :: is_done
    integer :: status
    logical :: ok
    if (self%unit == -1) return
    close (self%unit, iostat=status)
    self%unit = -1
    self%is_open = .false.
    self%is_recalling = .false.
    if (is_done) call remove_file(self%path, ok)
  end subroutine journal_finish
end module io_journal

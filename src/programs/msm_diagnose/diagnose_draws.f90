! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads and writes the file in which `msm_diagnose` keeps the null distribution of a design: attributes `key`, `checksum`, and
!> sorted draws. It writes to a temporary name and renames the file, so that programs that use the same file always find a
!> complete one. A file that cannot be read, is damaged or belongs to another design is ignored and replaced.
module diagnose_draws
  use base_checksum, only: checksum_add, checksum_integers, checksum_reals
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use base_process, only: process_id
  use base_text, only: number_text
  use inference_calibration, only: calibration_t
  use inference_calibration_store, only: calibration_store_t
  use io_arrays, only: read_reals
  use io_attributes, only: get_attribute, put_attribute
  use io_hdf5, only: hdf5_file_t
  use io_seal, only: check_seal, SEAL_GOOD
  use io_table, only: put_table
  implicit none
  private
  public :: draws_file_t

  integer, parameter :: VERSION = 1
  integer, parameter :: MOST(4) = [1000000, 1000, 1000, 1] !< draws, families, effects, whether the scale is known

  type, extends(calibration_store_t) :: draws_file_t
    character(:), allocatable :: path !< empty: no draws are kept
  contains
    procedure :: recall => draws_recall
    procedure :: keep => draws_keep
  end type draws_file_t

contains

  !> Reads the null distribution of the design `key`. `is_found` is false if the file has none that is valid. Not collective: one
  !> process calls it.
  subroutine draws_recall(self, key, calibration, is_found)
    class(draws_file_t), intent(inout) :: self
    integer(i8), intent(in) :: key
    type(calibration_t), intent(out) :: calibration
    logical, intent(out) :: is_found
    type(hdf5_file_t) :: file
    type(failure_t) :: failure, ignored
    integer(i8) :: stored, checksum
    integer :: version_found, sizes(4)
    integer :: seal
    is_found = .false.
    if (self%path == '') return
    call check_seal(self%path, seal)
    if (seal /= SEAL_GOOD) return
    call file%open_serial(self%path, failure)
    call get_attribute(file, '/', 'version', version_found, failure)
    call get_attribute(file, '/', 'key', stored, failure)
    call get_attribute(file, '/', 'checksum', checksum, failure)
    call get_attribute(file, '/', 'sizes', sizes, failure)
    call get_attribute(file, '/', 'independent_tests', calibration%n_combined, failure)
    if (.not. failure%failed) then
      if (version_found == VERSION .and. stored == key .and. all(sizes >= 0 .and. sizes <= MOST)) then
        calibration%n_draws = sizes(1)
        calibration%is_scale_known = sizes(4) == 1
        allocate (calibration%n_tests(sizes(3)), calibration%unknown(sizes(1), sizes(2)))
        allocate (calibration%combined(sizes(1)))
        call read_flat(file, 'effects', size(calibration%n_tests), calibration%n_tests, failure)
        call read_table(file, 'unknown', sizes(1), sizes(2), calibration%unknown, failure)
        call read_flat(file, 'combined', sizes(1), calibration%combined, failure)
        if (.not. failure%failed) is_found = checksum == checksum_of(key, calibration)
      end if
    end if
    call file%close(ignored)
  end subroutine draws_recall

  !> Reads n numbers. If n is 0, it does not use the file. Fails if they cannot be read.
  subroutine read_flat(file, name, n, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(in) :: n
    real(rp), intent(out) :: values(n)
    type(failure_t), intent(inout) :: failure
    if (n > 0) call read_reals(file, name, values, failure)
  end subroutine read_flat

  !> Reads a table (n, m). Fails if it cannot be read.
  subroutine read_table(file, name, n, m, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(in) :: n, m
    real(rp), intent(out) :: values(n, m)
    type(failure_t), intent(inout) :: failure
    real(rp) :: flat(n*m)
    call read_flat(file, name, n*m, flat, failure)
    values = reshape(flat, [n, m])
  end subroutine read_table

  !> Writes the null distribution of the design `key`. A failure is not reported. Not collective: one process calls it.
  subroutine draws_keep(self, key, calibration)
    class(draws_file_t), intent(inout) :: self
    integer(i8), intent(in) :: key
    type(calibration_t), intent(in) :: calibration
    type(hdf5_file_t) :: file
    type(failure_t) :: failure
    integer(i8) :: clock
    if (self%path == '') return
    associate (c => calibration)
      call system_clock(clock)
      call file%create_serial(self%path//'.'//number_text(process_id())//'.'// &
                              number_text(int(modulo(clock, 2_i8**30)))//'.part', failure)
      call put_attribute(file, '/', 'version', VERSION, failure)
      call put_attribute(file, '/', 'key', key, failure)
      call put_attribute(file, '/', 'checksum', checksum_of(key, c), failure)
      call put_attribute(file, '/', 'sizes', [c%n_draws, size(c%unknown, 2), size(c%n_tests), &
                                              merge(1, 0, c%is_scale_known)], failure)
      call put_attribute(file, '/', 'independent_tests', c%n_combined, failure)
      call put_table(file, 'effects', reshape(c%n_tests, [size(c%n_tests), 1]), &
                     'independent tests of each effect', failure)
      call put_table(file, 'unknown', c%unknown, &
                     'statistic of each family of unknown causes, sorted', failure)
      call put_table(file, 'combined', reshape(c%combined, [c%n_draws, 1]), &
                     'smallest weighted log p, sorted', failure)
      call file%publish(self%path, .false., failure, with_seal=.true.)
    end associate
  end subroutine draws_keep

  !> Returns a checksum of the key and the draws.
  pure integer(i8) function checksum_of(key, c) result(total)
    integer(i8), intent(in) :: key
    type(calibration_t), intent(in) :: c
    total = checksum_integers([key, int([c%n_draws, size(c%unknown, 2), size(c%n_tests)], i8)], 0_i8)
    total = checksum_add(total, checksum_reals([c%n_combined, c%n_tests, [c%unknown], c%combined], 4_i8))
  end function checksum_of
end module diagnose_draws

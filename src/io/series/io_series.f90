! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes time series to text files (`*.t`): a header line that begins with % and names the columns, an optional second header line
!> with a note, then one record in each line, the time first. Rank 0 writes; the other ranks only learn whether it has succeeded.
!>
!> A restarted run continues a series. Records at and after the restart time are dropped, because the run writes them again. An
!> incomplete last record is dropped, too.
module io_series
  use base_errors, only: failure_t, require
  use base_files, only: file_exists, remove_file, replace_file
  use base_kinds, only: rp
  use base_text_file, only: text_file_t
  use base_text_lines, only: read_line, ends_with_newline, count_words
  use parallel_failure, only: broadcast_failure
  use parallel_world, only: world_t
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  implicit none
  private
  public :: series_t

  !> One open series. Every record is handed to the operating system at once.
  type :: series_t
    private
    type(world_t) :: world
    type(text_file_t) :: file
    type(failure_t) :: failure     !< on rank 0: the first failure; nothing is written after it
    character(:), allocatable :: path, note
    integer :: n_columns = 0
    integer :: digits = 8
  contains
    procedure :: open => series_open
    procedure :: write => series_write
    procedure :: check => series_check
    procedure :: close => series_close
  end type series_t

contains

  !> Opens the series `path`. Without `restart_time` an existing file is replaced; with it the records
  !> before that time are kept. Numbers get `digits` decimals (es15.8 for 8, the default). Fails if
  !> the file cannot be written or if it holds records with another number of columns. Collective.
  subroutine series_open(self, world, path, columns, failure, restart_time, digits, note)
    class(series_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    character(*), intent(in) :: columns(:)  !< names with units, the time first: 'time [-]', ...
    type(failure_t), intent(inout) :: failure
    real(rp), intent(in), optional :: restart_time
    integer, intent(in), optional :: digits
    character(*), intent(in), optional :: note !< a second line that begins with %, unless it is empty

    self%world = world
    self%path = path
    self%failure = failure_t()
    self%n_columns = size(columns)
    self%digits = 8
    self%note = ''
    if (present(note)) self%note = note
    if (present(digits)) self%digits = digits
    call require(size(columns) > 0 .and. self%digits > 0, 'io_series: no columns or no digits')
    if (failure%failed) return
    if (world%is_root) then
      if (present(restart_time) .and. file_exists(path)) then
        call keep_earlier(self, header(self, columns), restart_time)
      else
        call start_afresh(self, header(self, columns))
      end if
    end if
    call self%check(failure)
  end subroutine series_open

  !> Returns '%' and the names over their columns, at least two blanks apart.
  function header(self, columns) result(line)
    class(series_t), intent(in) :: self
    character(*), intent(in) :: columns(:)
    character(:), allocatable :: line
    integer :: i, width
    line = '%'
    do i = 1, size(columns)
      width = self%digits + 8
      if (i == 1) width = width - 2 ! no blank before the first number, but the % sign
      line = line//repeat(' ', max(width - len_trim(columns(i)), merge(1, 2, i == 1)))//trim(columns(i))
    end do
  end function header

  !> Creates the file and writes its first lines.
  subroutine start_afresh(self, first_line)
    class(series_t), intent(inout) :: self
    character(*), intent(in) :: first_line
    call self%file%create(self%path, self%failure)
    call put(self, first_line, .true.)
    if (self%note /= '') call put(self, '% '//self%note, .true.)
  end subroutine start_afresh

  !> Rewrites the file with the records before `restart_time` and opens it for appending.
  subroutine keep_earlier(self, first_line, restart_time)
    class(series_t), intent(inout) :: self
    character(*), intent(in) :: first_line
    real(rp), intent(in) :: restart_time
    character(:), allocatable :: final_path, line, next_line
    character(12) :: got, want
    real(rp) :: time, tolerance
    integer :: unit, status
    logical :: next_found, ended

    final_path = self%path
    ! A time in the file is rounded to `digits` decimals; the record at the restart time itself must be dropped.
    tolerance = 10.0_rp**(-self%digits)*abs(restart_time)
    ended = ends_with_newline(self%path)
    open (newunit=unit, file=self%path, status='old', action='read', iostat=status)
    if (status /= 0) then
      call self%failure%raise(self%path//': cannot be read')
      return
    end if
    self%path = final_path//'.part'
    call start_afresh(self, first_line)
    call read_line(unit, next_line, next_found)
    do while (next_found .and. .not. self%failure%failed)
      call move_alloc(next_line, line)
      call read_line(unit, next_line, next_found)
      if (.not. next_found .and. .not. ended) exit
      if (index(adjustl(line), '%') == 1 .or. len_trim(line) == 0) cycle
      read (line, *, iostat=status) time
      if (status /= 0) cycle
      if (time >= restart_time - tolerance) cycle
      if (count_words(line) /= self%n_columns) then
        write (got, '(i0)') count_words(line)
        write (want, '(i0)') self%n_columns
        call self%failure%raise(final_path//': holds records of '//trim(got)//' columns, this run writes '// &
                                trim(want)//'; move the file away')
        exit
      end if
      call put(self, line, .false.)
    end do
    close (unit)
    call self%file%close(self%failure)
    self%path = final_path
    if (self%failure%failed) then
      call remove_file(final_path//'.part')
      return
    end if
    call replace_file(final_path//'.part', final_path, .false., self%failure)
    call self%file%append(final_path, self%failure)
  end subroutine keep_earlier

  !> Appends one record, time first; on ranks other than 0 nothing happens. `check` reports a failure.
  subroutine series_write(self, values)
    class(series_t), intent(inout) :: self
    real(rp), intent(in) :: values(:)
    character(:), allocatable :: line
    character(16) :: narrow, wide
    integer :: i, width
    if (.not. self%world%is_root .or. self%failure%failed) return
    call require(size(values) == self%n_columns, 'io_series: a record needs one value for each column')
    width = self%digits + 7
    write (narrow, '(a,i0,a,i0,a)') '(es', width, '.', self%digits, ')'
    ! With a three-digit exponent Fortran omits the letter E, and most programs cannot read the number. It is therefore written with
    ! one decimal less and the letter E.
    write (wide, '(a,i0,a,i0,a)') '(es', width, '.', self%digits - 1, 'e3)'
    allocate (character((width + 1)*size(values) - 1) :: line)
    line = repeat(' ', len(line))
    do i = 1, size(values)
      associate (field => line((i - 1)*(width + 1) + 1:i*(width + 1) - 1), x => values(i))
        write (field, narrow) x
        if (index(field, 'E') == 0 .and. ieee_is_finite(x)) write (field, wide) x
      end associate
    end do
    call put(self, line, .true.)
  end subroutine series_write

  !> Writes a line, and makes sure that it is on disk if `now`.
  subroutine put(self, line, now)
    class(series_t), intent(inout) :: self
    character(*), intent(in) :: line
    logical, intent(in) :: now           !< do not leave it in a buffer
    call self%file%write(line, self%failure)
    if (now) call self%file%flush(self%failure)
  end subroutine put

  !> Gives the failure of rank 0 to all ranks. Collective.
  subroutine series_check(self, failure)
    class(series_t), intent(in) :: self
    type(failure_t), intent(inout) :: failure
    call broadcast_failure(self%world, self%failure, failure)
  end subroutine series_check

  !> Closes the series and reports any failure since `open`. Collective.
  subroutine series_close(self, failure)
    class(series_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    call self%file%close(self%failure)
    call self%check(failure)
  end subroutine series_close
end module io_series

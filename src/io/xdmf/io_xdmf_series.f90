! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes an XDMF index of a surface that moves: it has one grid, or a collection of grids, for each time; the caller makes their
!> text. The whole index is rewritten at every time. A restarted run keeps the entries up to its restart. Comments mark where the
!> text of a time begins and ends, and reading relies on them.
module io_xdmf_series
  use base_errors, only: failure_t
  use base_files, only: file_exists
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use base_text_lines, only: read_line, real_text
  implicit none
  private
  public :: xdmf_series_t, xdmf_text

  character(*), parameter :: NL = new_line('a')
  character(*), parameter :: HEAD = '<Grid Name="series" GridType="Collection" CollectionType="Temporal">'//NL
  character(*), parameter :: TAIL = '</Grid>'//NL
  character(*), parameter :: BEGIN_MARK = '<!-- begin ', END_MARK = '<!-- end -->', CLOSING = ' -->'

  !> The index of one surface; one process writes it.
  type :: xdmf_series_t
    private
    character(:), allocatable :: path
    character(:), allocatable :: grids !< the text of all times so far
  contains
    procedure :: open => series_open
    procedure :: add => series_add
  end type xdmf_series_t

contains

  !> Starts the index `path`. With `restart_time` the grids up to that time of an existing index are kept.
  !> Nothing is written yet. Fails if an existing index was not written by this module.
  subroutine series_open(self, path, failure, restart_time)
    class(xdmf_series_t), intent(out) :: self
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    real(rp), intent(in), optional :: restart_time
    logical :: ok
    self%path = path
    self%grids = ''
    if (failure%failed .or. .not. present(restart_time)) return
    if (.not. file_exists(path)) return
    call keep_earlier(self, restart_time, ok)
    if (.not. ok) call failure%raise(path//': was not written by this program: move it away')
  end subroutine series_open

  !> Keeps the grids of an earlier run up to the time of the restart. `ok` is false if the file cannot be used.
  subroutine keep_earlier(self, restart_time, ok)
    class(xdmf_series_t), intent(inout) :: self
    real(rp), intent(in) :: restart_time
    logical, intent(out) :: ok
    character(:), allocatable :: line, grid
    real(rp) :: time
    integer :: unit, status
    logical :: found, inside
    open (newunit=unit, file=self%path, status='old', action='read', iostat=status)
    ok = status == 0
    if (.not. ok) return
    ok = .false.
    inside = .false.
    time = 0
    do
      call read_line(unit, line, found)
      if (.not. found) exit
      if (index(line, '<Xdmf ') == 1) ok = .true.
      if (index(line, BEGIN_MARK) == 1) then
        inside = .true.
        grid = ''
        call read_time(line, time, status)
        if (status /= 0) ok = .false.
      end if
      if (.not. inside) cycle
      grid = grid//line//NL
      if (line /= END_MARK) cycle
      inside = .false.
      ! Times are stored with all digits.
      if (time <= restart_time) self%grids = self%grids//grid
    end do
    close (unit)
  end subroutine keep_earlier

  !> Adds the text of the grids at one time under one label and rewrites the index; an earlier entry with this label is removed,
  !> because its files have been replaced.
  subroutine series_add(self, time, label, grid, failure)
    class(xdmf_series_t), intent(inout) :: self
    real(rp), intent(in) :: time
    character(*), intent(in) :: label !< without blanks
    character(*), intent(in) :: grid  !< ends with a new line
    type(failure_t), intent(inout) :: failure
    integer :: first, last
    logical :: ok
    if (failure%failed) return
    first = index(self%grids, BEGIN_MARK//label//' ')
    if (first > 0) then
      last = first + index(self%grids(first:), END_MARK) + len(END_MARK) - 1
      self%grids = self%grids(:first - 1)//self%grids(last + 1:)
    end if
    self%grids = self%grids//BEGIN_MARK//label//' '//real_text(time)//CLOSING//NL//grid//END_MARK//NL
    call write_text(self%path, xdmf_text(HEAD//self%grids//TAIL), ok)
    if (.not. ok) call failure%raise(self%path//': cannot be written; is the folder missing or the disk full?')
  end subroutine series_add

  !> Returns a whole index around its grids.
  function xdmf_text(grids) result(xml)
    character(*), intent(in) :: grids
    character(:), allocatable :: xml
    xml = '<?xml version="1.0" ?>'//NL//'<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>'//NL//'<Xdmf Version="3.0">'//NL// &
          '<Domain>'//NL//grids//'</Domain>'//NL//'</Xdmf>'
  end function xdmf_text

  !> Returns the time in a line that begins a grid.
  subroutine read_time(line, time, status)
    character(*), intent(in) :: line
    real(rp), intent(out) :: time
    integer, intent(out) :: status
    integer :: first, last
    time = 0
    status = 1
    last = len(line) - len(CLOSING)
    first = index(line(len(BEGIN_MARK) + 1:max(last, len(BEGIN_MARK))), ' ')
    if (first == 0) return
    read (line(len(BEGIN_MARK) + first + 1:last), *, iostat=status) time
  end subroutine read_time
end module io_xdmf_series

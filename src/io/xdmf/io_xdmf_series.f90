! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes an XDMF index of a surface that moves: it has one grid, or a collection of grids, for each time; the caller makes their
!> text. The whole index is rewritten at every time. A restarted run keeps the entries up to its restart. Comments mark where the
!> text of a time begins and ends, and reading relies on them.
module io_xdmf_series
  use base_errors, only: failure_t
  use base_files, only: file_exists
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use base_text_lines, only: real_text
  use io_xdmf_grids, only: grid_marks_t, read_grids
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
    self%path = path
    self%grids = ''
    if (failure%failed .or. .not. present(restart_time)) return
    if (.not. file_exists(path)) return
    call read_grids(path, grid_marks_t(begin=BEGIN_MARK, end=END_MARK, time=BEGIN_MARK, closing=CLOSING), restart_time, &
                    self%grids, failure)
  end subroutine series_open

  !> Adds the text of the grids at one time under one label and rewrites the index; an earlier entry with this label is removed,
  !> because its files have been replaced.
  subroutine series_add(self, time, label, grid, failure)
    class(xdmf_series_t), intent(inout) :: self
    real(rp), intent(in) :: time
    character(*), intent(in) :: label !< without blanks
    character(*), intent(in) :: grid  !< ends with a new line
    type(failure_t), intent(inout) :: failure
    integer :: first, last
    if (failure%failed) return
    first = index(self%grids, BEGIN_MARK//label//' ')
    if (first > 0) then
      last = first + index(self%grids(first:), END_MARK) + len(END_MARK) - 1
      self%grids = self%grids(:first - 1)//self%grids(last + 1:)
    end if
    self%grids = self%grids//BEGIN_MARK//label//' '//real_text(time)//CLOSING//NL//grid//END_MARK//NL
    call write_text(self%path, xdmf_text(HEAD//self%grids//TAIL), failure)
  end subroutine series_add

  !> Returns a whole index around its grids.
  function xdmf_text(grids) result(xml)
    character(*), intent(in) :: grids
    character(:), allocatable :: xml
    xml = '<?xml version="1.0" ?>'//NL//'<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>'//NL//'<Xdmf Version="3.0">'//NL// &
          '<Domain>'//NL//grids//'</Domain>'//NL//'</Xdmf>'
  end function xdmf_text
end module io_xdmf_series

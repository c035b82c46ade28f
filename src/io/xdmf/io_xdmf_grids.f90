! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads back what an XDMF index of an earlier run has up to the time of a restart.
module io_xdmf_grids
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text_lines, only: read_line
  implicit none
  private
  public :: grid_marks_t, read_grids

  character(*), parameter :: NL = new_line('a')

  !> What marks the text of one time in an index. The number of the time ends a line, but for `closing`.
  type :: grid_marks_t
    character(:), allocatable :: begin, end !< beginning of the first line, and the whole last line
    character(:), allocatable :: time       !< beginning of the line with the time, which may be the first line
    character :: before = ' '               !< last character before the number
    character(:), allocatable :: closing    !< characters between the number and the end of the line
    logical :: keeps_last = .true.          !< the text at the time of the restart stays, too
  end type grid_marks_t

contains

  !> Returns the `grids` of the index `path` up to `restart_time`: with the one at this time if the marks say so. Fails if the file
  !> cannot be read or was not written by this program.
  subroutine read_grids(path, marks, restart_time, grids, failure)
    character(*), intent(in) :: path
    type(grid_marks_t), intent(in) :: marks
    real(rp), intent(in) :: restart_time
    character(:), allocatable, intent(out) :: grids
    type(failure_t), intent(inout) :: failure
    real(rp), parameter :: MARGIN = 1.0e-12_rp !< an index has all digits of times, the restart file of another program may not
    character(:), allocatable :: line, grid
    real(rp) :: time, last
    integer :: unit, status
    logical :: found, inside, is_ours
    last = restart_time + merge(MARGIN, -MARGIN, marks%keeps_last)*abs(restart_time)
    grids = ''
    open (newunit=unit, file=path, status='old', action='read', iostat=status)
    if (status /= 0) then
      call failure%raise(path//': cannot be read')
      return
    end if
    is_ours = .false.
    inside = .false.
    time = 0
    do
      call read_line(unit, line, found)
      if (.not. found) exit
      if (index(line, '<Xdmf ') == 1) is_ours = .true.
      if (index(line, marks%begin) == 1) then
        inside = .true.
        grid = ''
      end if
      if (.not. inside) cycle
      grid = grid//line//NL
      if (index(line, marks%time) == 1) then
        call read_time(line, marks, time, status)
        if (status /= 0) is_ours = .false.
      end if
      if (line /= marks%end) cycle
      inside = .false.
      if (time < last .or. (marks%keeps_last .and. time <= last)) grids = grids//grid
    end do
    close (unit)
    if (.not. is_ours) call failure%raise(path//': was not written by this program: move it away')
  end subroutine read_grids

  !> Returns the time in a line that has one; `status` is not 0 if there is none.
  subroutine read_time(line, marks, time, status)
    character(*), intent(in) :: line
    type(grid_marks_t), intent(in) :: marks
    real(rp), intent(out) :: time
    integer, intent(out) :: status
    integer :: first, last
    time = 0
    status = 1
    last = len(line) - len(marks%closing)
    first = index(line(:max(last, 0)), marks%before, back=.true.) + 1
    if (first <= len(marks%time) .or. first > last) return
    read (line(first:last), *, iostat=status) time
  end subroutine read_time
end module io_xdmf_grids

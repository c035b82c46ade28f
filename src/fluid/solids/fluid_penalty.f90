! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes the solids to the fluid: a sparse list of grid points with mask chi, solid velocity u_s and colour. Storage and work
!> are proportional to the volume of the solids, not of the box.
!>
!> Solids that never move are given once (`begin`, `add_line`, `finish`). Moving solids are laid over them line by line
!> (`erase_overlay`, `overlay_line`); both procedures change only the lines that the moving solids touch.
!>
!> Penalization: du/dt = ... - chi/C_eta (u - u_s) (Angot, Bruneau & Fabrie 1999, DOI 10.1007/s002110050401).
module fluid_penalty
  use base_errors, only: require
  use base_kinds, only: rp
  use parallel_block, only: block_t
  implicit none
  private
  public :: penalty_t, N_COLORS, COLOR_WALL, COLOR_BODY, COLOR_OBSTACLE

  integer, parameter :: N_COLORS = 6   !< colours 0 .. 5
  integer, parameter :: COLOR_WALL = 0 !< walls do not count as a body
  integer, parameter :: COLOR_BODY = 1
  integer, parameter :: COLOR_OBSTACLE = 4 !< a body at rest in addition to insects; 2 and 3 are their wings

  !> Penalized points of this rank, line by line: the points of line (y, z) are
  !> line_first(line) .. line_last(line), line = y + ny_local*(z - 1), with x ascending. Other points in the
  !> list are hidden by an overlay. The list never shrinks, so that nothing is allocated once it is long enough.
  type :: penalty_t
    integer :: n_points = 0                !< entries of the list in use, hidden ones included
    integer :: n_lines = 0
    integer, allocatable :: line_first(:)  !< (n_lines)
    integer, allocatable :: line_last(:)   !< (n_lines) below line_first if the line is empty
    integer, allocatable :: x(:)           !< index along the line, 1-based
    integer, allocatable :: color(:)       !< 0 .. 5
    real(rp), allocatable :: chi(:)        !< mask in (0, 1]
    real(rp), allocatable :: us(:, :)      !< (3, :) solid velocity
    integer, private :: filled = 0         !< lines added so far
    integer, private :: n_fixed = 0        !< entries of the solids that never move
    integer, private :: n_overlaid = 0
    integer, allocatable, private :: overlaid(:, :) !< (3, n_overlaid) line, line_first, line_last without overlay
  contains
    procedure :: begin => penalty_begin
    procedure :: add_line => penalty_add_line
    procedure :: finish => penalty_finish
    procedure :: erase_overlay => penalty_erase_overlay
    procedure :: overlay_line => penalty_overlay_line
    procedure :: count_colors => penalty_count_colors
  end type penalty_t

contains

  !> Empties the list. The caller must then add every line once, in storage order.
  subroutine penalty_begin(self, block)
    class(penalty_t), intent(inout) :: self
    type(block_t), intent(in) :: block
    self%n_lines = block%count(2)*block%count(3)
    self%n_points = 0
    self%n_fixed = 0
    self%n_overlaid = 0
    self%filled = 0
    if (.not. allocated(self%line_first)) allocate (self%line_first(self%n_lines), self%line_last(self%n_lines))
    if (.not. allocated(self%x)) allocate (self%x(64), self%color(64), self%chi(64), self%us(3, 64))
    if (.not. allocated(self%overlaid)) allocate (self%overlaid(3, 64))
    self%line_first = 1
    self%line_last = 0
  end subroutine penalty_begin

  !> Adds the points of the next line with chi > 0. Grows the list when needed.
  subroutine penalty_add_line(self, chi, us, color)
    class(penalty_t), intent(inout) :: self
    real(rp), contiguous, intent(in) :: chi(:)   !< (nx)
    real(rp), contiguous, intent(in) :: us(:, :) !< (3, nx)
    integer, contiguous, intent(in) :: color(:)  !< (nx)
    integer :: i
    call require(self%filled < self%n_lines, 'penalty_t: more lines than the block has')
    self%filled = self%filled + 1
    self%line_first(self%filled) = self%n_points + 1
    call reserve(self, size(chi))
    do i = 1, size(chi)
      if (chi(i) > 0) call append(self, i, chi(i), us(:, i), color(i))
    end do
    self%line_last(self%filled) = self%n_points
    self%n_fixed = self%n_points
  end subroutine penalty_add_line

  !> Stops the program unless all lines were given.
  subroutine penalty_finish(self)
    class(penalty_t), intent(in) :: self
    call require(self%filled == self%n_lines, 'penalty_t: fewer lines than the block has')
  end subroutine penalty_finish

  !> Removes every overlay. Only the solids that never move are left.
  subroutine penalty_erase_overlay(self)
    class(penalty_t), intent(inout) :: self
    integer :: i
    do i = self%n_overlaid, 1, -1 ! a line may have several overlays; the first one hides the solids that never move
      associate (saved => self%overlaid(:, i))
        self%line_first(saved(1)) = saved(2)
        self%line_last(saved(1)) = saved(3)
      end associate
    end do
    self%n_overlaid = 0
    self%n_points = self%n_fixed
  end subroutine penalty_erase_overlay

  !> Lays the points 1 .. n over `line`. If a solid that never moves, or an earlier overlay, has the same point, the entry with the
  !> larger chi counts, with its velocity and colour. If both chi are equal, the earlier entry counts.
  subroutine penalty_overlay_line(self, line, n, x, chi, us, color)
    class(penalty_t), intent(inout) :: self
    integer, intent(in) :: line
    integer, intent(in) :: n                     !< >= 1
    integer, contiguous, intent(in) :: x(:)      !< ascending, 1-based
    real(rp), contiguous, intent(in) :: chi(:)   !< > 0
    real(rp), contiguous, intent(in) :: us(:, :) !< (3, :)
    integer, contiguous, intent(in) :: color(:)
    integer :: i, f, last
    f = self%line_first(line)
    last = self%line_last(line)
    call save_line(self, line)
    call reserve(self, n + max(0, last - f + 1))
    self%line_first(line) = self%n_points + 1
    do i = 1, n
      do while (f <= last)
        if (self%x(f) >= x(i)) exit
        call append_fixed(self, f)
      end do
      if (f <= last) then
        if (self%x(f) == x(i)) then
          if (self%chi(f) >= chi(i)) then
            call append_fixed(self, f)
            cycle
          end if
          f = f + 1
        end if
      end if
      call append(self, x(i), chi(i), us(:, i), color(i))
    end do
    do while (f <= last)
      call append_fixed(self, f)
    end do
    self%line_last(line) = self%n_points
  end subroutine penalty_overlay_line

  !> Returns the number of visible points of every colour.
  pure function penalty_count_colors(self) result(points)
    class(penalty_t), intent(in) :: self
    integer :: points(0:N_COLORS - 1)
    integer :: line, i
    points = 0
    do line = 1, self%n_lines
      do i = self%line_first(line), self%line_last(line)
        points(self%color(i)) = points(self%color(i)) + 1
      end do
    end do
  end function penalty_count_colors

  !> Records what `line` shows without overlay.
  subroutine save_line(self, line)
    type(penalty_t), intent(inout) :: self
    integer, intent(in) :: line
    integer, allocatable :: larger(:, :)
    if (self%n_overlaid == size(self%overlaid, 2)) then
      allocate (larger(3, 2*self%n_overlaid))
      larger(:, 1:self%n_overlaid) = self%overlaid
      call move_alloc(larger, self%overlaid)
    end if
    self%n_overlaid = self%n_overlaid + 1
    self%overlaid(:, self%n_overlaid) = [line, self%line_first(line), self%line_last(line)]
  end subroutine save_line

  !> Adds a point of the mask.
  subroutine append(self, x, chi, us, color)
    type(penalty_t), intent(inout) :: self
    integer, intent(in) :: x, color
    real(rp), intent(in) :: chi, us(3)
    self%n_points = self%n_points + 1
    self%x(self%n_points) = x
    self%chi(self%n_points) = chi
    self%us(:, self%n_points) = us
    self%color(self%n_points) = color
  end subroutine append

  !> Appends a copy of entry `f` and moves `f` to the next one.
  subroutine append_fixed(self, f)
    type(penalty_t), intent(inout) :: self
    integer, intent(inout) :: f
    call append(self, self%x(f), self%chi(f), self%us(:, f), self%color(f))
    f = f + 1
  end subroutine append_fixed

  !> Makes room for `more` entries; at least doubles the list when it has to grow.
  subroutine reserve(self, more)
    type(penalty_t), intent(inout) :: self
    integer, intent(in) :: more
    integer, allocatable :: x(:), color(:)
    real(rp), allocatable :: chi(:), us(:, :)
    integer :: n, room
    n = self%n_points
    if (n + more <= size(self%x)) return
    room = max(n + more, 2*size(self%x))
    allocate (x(room), color(room), chi(room), us(3, room))
    x(1:n) = self%x(1:n)
    color(1:n) = self%color(1:n)
    chi(1:n) = self%chi(1:n)
    us(:, 1:n) = self%us(:, 1:n)
    call move_alloc(x, self%x)
    call move_alloc(color, self%color)
    call move_alloc(chi, self%chi)
    call move_alloc(us, self%us)
  end subroutine reserve
end module fluid_penalty

! SPDX-License-Identifier: GPL-3.0-or-later
!> All that the fluid sees of solids: a sparse list of grid points with mask chi, solid velocity u_s and
!> colour. Storage and work follow the solid, not the box.
!>
!> Penalization: du/dt = ... - chi/C_eta (u - u_s) (Angot, Bruneau & Fabrie 1999, DOI 10.1007/s002110050401).
module fluid_penalty
  use base_errors, only: require
  use base_kinds, only: rp
  use parallel_block, only: block_t
  implicit none
  private
  public :: penalty_t, N_COLORS, COLOR_WALL, COLOR_BODY

  integer, parameter :: N_COLORS = 6   !< colours 0 .. 5
  integer, parameter :: COLOR_WALL = 0 !< walls do not count as a body
  integer, parameter :: COLOR_BODY = 1

  !> Penalized points of this rank, line by line: the points of line (y, z) are
  !> line_start(line) + 1 .. line_start(line + 1), line = y + ny_local*(z - 1).
  type :: penalty_t
    integer :: n_points = 0
    integer :: n_lines = 0
    integer, allocatable :: line_start(:)  !< (n_lines + 1)
    integer, allocatable :: x(:)           !< (n_points) index along the line, 1-based
    integer, allocatable :: color(:)       !< (n_points) 0 .. 5
    real(rp), allocatable :: chi(:)        !< (n_points) mask in (0, 1]
    real(rp), allocatable :: us(:, :)      !< (3, n_points) solid velocity
    integer, private :: filled = 0         !< lines added so far
  contains
    procedure :: begin => penalty_begin
    procedure :: add_line => penalty_add_line
    procedure :: finish => penalty_finish
  end type penalty_t

contains

  !> Empties the list; lines must then be added in storage order, every line once.
  subroutine penalty_begin(self, block)
    class(penalty_t), intent(inout) :: self
    type(block_t), intent(in) :: block
    self%n_lines = block%count(2)*block%count(3)
    self%n_points = 0
    self%filled = 0
    if (.not. allocated(self%line_start)) allocate (self%line_start(self%n_lines + 1))
    if (.not. allocated(self%x)) allocate (self%x(64), self%color(64), self%chi(64), self%us(3, 64))
    self%line_start = 0
  end subroutine penalty_begin

  !> Adds the points of the next line with chi > 0. Grows the list when needed.
  subroutine penalty_add_line(self, chi, us, color)
    class(penalty_t), intent(inout) :: self
    real(rp), contiguous, intent(in) :: chi(:)   !< (nx)
    real(rp), contiguous, intent(in) :: us(:, :) !< (3, nx)
    integer, contiguous, intent(in) :: color(:)  !< (nx)
    integer :: i
    call require(self%filled < self%n_lines, 'penalty_t: more lines than the block has')
    do i = 1, size(chi)
      if (chi(i) <= 0) cycle
      if (self%n_points == size(self%x)) call grow(self)
      self%n_points = self%n_points + 1
      self%x(self%n_points) = i
      self%chi(self%n_points) = chi(i)
      self%us(:, self%n_points) = us(:, i)
      self%color(self%n_points) = color(i)
    end do
    self%filled = self%filled + 1
    self%line_start(self%filled + 1) = self%n_points
  end subroutine penalty_add_line

  !> Checks that all lines were given.
  subroutine penalty_finish(self)
    class(penalty_t), intent(in) :: self
    call require(self%filled == self%n_lines, 'penalty_t: fewer lines than the block has')
  end subroutine penalty_finish

  subroutine grow(self)
    type(penalty_t), intent(inout) :: self
    integer, allocatable :: x(:), color(:)
    real(rp), allocatable :: chi(:), us(:, :)
    integer :: n
    n = self%n_points
    allocate (x(2*n), color(2*n), chi(2*n), us(3, 2*n))
    x(1:n) = self%x
    color(1:n) = self%color
    chi(1:n) = self%chi
    us(:, 1:n) = self%us
    call move_alloc(x, self%x)
    call move_alloc(color, self%color)
    call move_alloc(chi, self%chi)
    call move_alloc(us, self%us)
  end subroutine grow
end module fluid_penalty

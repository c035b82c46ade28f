! SPDX-License-Identifier: GPL-3.0-or-later
!> Draws a rigid solid into the mask of the fluid: chi of its shape, u_s = v + omega x r of its frame.
!>
!> Every grid line through the bounding box of the solid is processed in coordinates that are not wrapped, so that the result is the
!> same to the last bit on any rank. A solid at rest is drawn once; later calls only add it to the lines again.
module fsi_rigid_mask
  use base_kinds, only: rp
  use fluid_penalty, only: penalty_t
  use fsi_kinematics, only: body_t
  use fsi_rigid_body, only: rigid_body_t
  use fsi_rotation, only: cross
  use parallel_block, only: block_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: rigid_mask_t

  type :: rigid_mask_t
    integer :: n_cells = 0 !< points of this rank in the last drawing
    type(grid_t), private :: grid
    type(block_t), private :: block
    type(body_t), private :: drawn_at
    logical, private :: is_drawn = .false.
    integer, private :: n_lines = 0
    integer, allocatable, private :: lines(:, :) !< (3, n_lines) line, first and last of its points
    integer, allocatable, private :: x(:), color(:)
    real(rp), allocatable, private :: chi(:), us(:, :)
  contains
    procedure :: init => mask_init
    procedure :: draw => mask_draw
  end type rigid_mask_t

contains

  !> Prepares drawing on this rank's `block` of `grid`. Nothing is drawn yet.
  subroutine mask_init(self, grid, block)
    class(rigid_mask_t), intent(inout) :: self
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    self%grid = grid
    self%block = block
    self%is_drawn = .false.
    if (allocated(self%lines)) return
    allocate (self%lines(3, 64), self%x(1024), self%color(1024), self%chi(1024), self%us(3, 1024))
  end subroutine mask_init

  !> Adds the solid, whose frame is `frame`, to `penalty`. At points where chi of `penalty` is larger or equal, `penalty` is
  !> unchanged. Communicates nothing.
  subroutine mask_draw(self, solid, frame, color, penalty)
    class(rigid_mask_t), intent(inout) :: self
    type(rigid_body_t), intent(in) :: solid
    type(body_t), intent(in) :: frame
    integer, intent(in) :: color
    type(penalty_t), intent(inout) :: penalty
    integer :: i
    if (.not. (self%is_drawn .and. is_same(frame, self%drawn_at))) call find_points(self, solid, frame, color)
    self%is_drawn = .true.
    self%drawn_at = frame
    do i = 1, self%n_lines
      associate (a => self%lines(2, i), z => self%lines(3, i))
        call penalty%overlay_line(self%lines(1, i), z - a + 1, self%x(a:z), self%chi(a:z), self%us(:, a:z), &
                                  self%color(a:z))
      end associate
    end do
  end subroutine mask_draw

  !> Tells whether both frames have the same position and motion.
  pure logical function is_same(a, b)
    type(body_t), intent(in) :: a, b
    is_same = all(abs(a%centre - b%centre) <= 0) .and. all(abs(a%velocity - b%velocity) <= 0) .and. &
              all(abs(a%rotation%matrix - b%rotation%matrix) <= 0) .and. &
              all(abs(a%rotation%omega - b%rotation%omega) <= 0)
  end function is_same

  !> Finds the points of the grid on this rank that are in the mask of a solid.
  subroutine find_points(self, solid, frame, color)
    class(rigid_mask_t), intent(inout) :: self
    type(rigid_body_t), intent(in) :: solid
    type(body_t), intent(in) :: frame
    integer, intent(in) :: color
    real(rp) :: low(3), high(3)
    integer :: first(3), last(3), y, z, local(2:3)
    self%n_lines = 0
    self%n_cells = 0
    call box_in_space(solid, frame, low, high)
    first = ceiling(low/self%grid%spacing)
    last = floor(high/self%grid%spacing)
    if (self%grid%is_2d) then
      if (first(1) > 0 .or. last(1) < 0) return
      first(1) = 0
      last(1) = 0
    end if
    last = min(last, first + self%grid%n - 1) ! no point twice
    do z = first(3), last(3)
      local(3) = modulo(z, self%block%n(3)) - self%block%start(3)
      if (local(3) < 0 .or. local(3) >= self%block%count(3)) cycle
      do y = first(2), last(2)
        local(2) = modulo(y, self%block%n(2)) - self%block%start(2)
        if (local(2) < 0 .or. local(2) >= self%block%count(2)) cycle
        call draw_line(self, solid, frame, color, 1 + local(2) + self%block%count(2)*local(3), [first(1), last(1)], [y, z])
      end do
    end do
  end subroutine find_points

  !> Returns the box in space that holds the solid with its smoothing.
  pure subroutine box_in_space(solid, frame, low, high)
    type(rigid_body_t), intent(in) :: solid
    type(body_t), intent(in) :: frame
    real(rp), intent(out) :: low(3), high(3)
    real(rp) :: middle(3), half(3)
    middle = frame%centre + frame%rotation%to_parent((solid%low + solid%high)/2)
    half = matmul(abs(transpose(frame%rotation%matrix)), (solid%high - solid%low)/2 + solid%smoothing)
    low = middle - half
    high = middle + half
  end subroutine box_in_space

  !> Draws the points from range(1) to range(2), not wrapped, of the line with this number, in the order of their wrapped indices.
  subroutine draw_line(self, solid, frame, color, line, range, yz)
    class(rigid_mask_t), intent(inout) :: self
    type(rigid_body_t), intent(in) :: solid
    type(body_t), intent(in) :: frame
    integer, intent(in) :: color, line
    integer, intent(in) :: range(2), yz(2) !< along x; y and z of the line
    real(rp) :: arm(3), chi
    integer :: i, x, begin, turn, nx
    nx = self%grid%n(1)
    begin = self%n_cells + 1
    turn = range(1) + modulo(-range(1), nx) ! the first point that wraps to 0
    do i = turn, turn + nx - 1
      x = i
      if (x > range(2)) x = x - nx
      if (x < range(1) .or. x > range(2)) cycle
      arm = frame%rotation%to_frame([x, yz]*self%grid%spacing - frame%centre)
      chi = solid%mask_at(arm)
      if (chi <= 0) cycle
      if (self%n_cells == size(self%x)) call grow(self)
      self%n_cells = self%n_cells + 1
      self%x(self%n_cells) = modulo(x, nx) + 1
      self%chi(self%n_cells) = chi
      self%us(:, self%n_cells) = frame%velocity + frame%rotation%to_parent(cross(frame%rotation%omega, arm))
      self%color(self%n_cells) = color
    end do
    if (self%n_cells >= begin) call add_line(self, [line, begin, self%n_cells])
  end subroutine draw_line

  !> Adds a line of points.
  subroutine add_line(self, entry)
    class(rigid_mask_t), intent(inout) :: self
    integer, intent(in) :: entry(3)
    integer, allocatable :: larger(:, :)
    if (self%n_lines == size(self%lines, 2)) then
      allocate (larger(3, 2*self%n_lines))
      larger(:, 1:self%n_lines) = self%lines
      call move_alloc(larger, self%lines)
    end if
    self%n_lines = self%n_lines + 1
    self%lines(:, self%n_lines) = entry
  end subroutine add_line

  !> Doubles the room for points.
  subroutine grow(self)
    class(rigid_mask_t), intent(inout) :: self
    integer, allocatable :: x(:), color(:)
    real(rp), allocatable :: chi(:), us(:, :)
    integer :: n
    n = size(self%x)
    allocate (x(2*n), color(2*n), chi(2*n), us(3, 2*n))
    x(:n) = self%x
    color(:n) = self%color
    chi(:n) = self%chi
    us(:, :n) = self%us
    call move_alloc(x, self%x)
    call move_alloc(color, self%color)
    call move_alloc(chi, self%chi)
    call move_alloc(us, self%us)
  end subroutine grow
end module fsi_rigid_mask

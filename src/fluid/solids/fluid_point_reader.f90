! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the flow at points while a pass of the right-hand side has it on the grid: almost the velocities that fluid_point_forces
!> samples, without a transform.
!>
!> In each direction the W points of the grid around a point count with the weights of fluid_point_kernel. A mode k has the relative
!> error (of its amplitude) 2e-5 for k -> 0, 1e-4 at K/2 and 1.5e-3 at K. The flow must have no modes |k| >= K: the weights cannot
!> leave out those between this sphere and the ellipsoidal truncation.
!>
!> Every rank sums over its own points of the grid; one sum over ranks follows.
module fluid_point_reader
  use base_kinds, only: rp
  use base_process, only: wall_seconds
  use fluid_point_kernel, only: point_kernel_t, KERNEL_STRENGTHS, KERNEL_TERMS, KERNEL_WIDTH
  use parallel_block, only: block_t
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: can_read, point_reader_t

  integer, parameter :: W = KERNEL_WIDTH, TERMS = KERNEL_TERMS

  type :: point_reader_t
    logical :: is_possible = .false. !< the grid has W points in each direction, spacings are equal, and no mode has |k| >= K
    logical :: is_wanted = .false.   !< the next pass reads the flow at the points that `ask` got
    logical :: is_read = .false.     !< `velocities` are those at these points
    real(rp), allocatable :: velocities(:, :) !< (3, points) L/T, the same on all ranks
    real(rp) :: seconds = 0          !< wall time that reading has taken on this rank so far, without the sum over ranks
    integer, private :: n = 0        !< points
    logical, private :: is_reading = .false.
    type(world_t), private :: world
    type(grid_t), private :: grid
    type(block_t), private :: block
    type(point_kernel_t), private :: kernel
    integer, allocatable, private :: first(:, :)           !< (3, points) first cell, 0-based
    real(rp), allocatable, private :: weights(:, :, :, :)  !< (W, TERMS, 3, points)
    integer, allocatable, private :: order(:), start(:)    !< points by their first line; of each line the first of them
    integer, allocatable, private :: plane_start(:)        !< (nz_local + 1) of the points that reach a plane
    integer, allocatable, private :: reaching(:)           !< these points, by their first line
  contains
    procedure :: init => reader_init
    procedure :: ask => reader_ask
    procedure :: begin => reader_begin
    procedure :: read_lines => reader_read_lines
    procedure :: finish => reader_finish
    procedure :: memory_bytes => reader_memory_bytes
  end type point_reader_t

contains

  !> Makes room for up to `most` points in the flow on this block of the grid, with the filter of `radius` K [1/L]. `is_spherical`
  !> tells that the flow has only modes |k| < K.
  subroutine reader_init(self, world, grid, block, radius, is_spherical, most)
    class(point_reader_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    real(rp), intent(in) :: radius
    logical, intent(in) :: is_spherical
    integer, intent(in) :: most
    integer :: x
    self%world = world
    self%grid = grid
    self%block = block
    x = merge(2, 1, grid%is_2d)
    self%is_possible = can_read(grid) .and. (is_spherical .or. all(grid%n(x:) == grid%n(3)))
    if (.not. self%is_possible) return
    call self%kernel%init(radius*grid%max_spacing())
    allocate (self%velocities(3, most), self%weights(W, TERMS, 3, most), source=0.0_rp)
    allocate (self%first(3, most), self%order(most), self%start(grid%n(2) + 1))
    allocate (self%plane_start(block%count(3) + 1), self%reaching(W*most))
  end subroutine reader_init

  !> Tells whether the flow on this grid can be read: with equal spacings, and the points of the weights in each direction.
  pure logical function can_read(grid)
    type(grid_t), intent(in) :: grid
    real(rp), parameter :: EQUAL = 1.0e-9_rp
    can_read = all(grid%n(merge(2, 1, grid%is_2d):) >= W) .and. grid%max_spacing() <= (1 + EQUAL)*grid%min_spacing()
  end function can_read

  !> Asks the next pass that begins with the flow of the state to read it at x(3, n) [L], also outside of the periodic box.
  subroutine reader_ask(self, x)
    class(point_reader_t), intent(inout) :: self
    real(rp), intent(in) :: x(:, :)
    integer :: i, j
    self%n = size(x, 2)
    do i = 1, self%n
      do j = 1, 3
        call self%kernel%weights(x(j, i)/self%grid%spacing(j), self%first(j, i), self%weights(:, :, j, i))
        self%first(j, i) = modulo(self%first(j, i), self%grid%n(j))
      end do
      if (self%grid%is_2d) self%weights(:, :, 1, i) = 1
      do j = 1, TERMS
        self%weights(:, j, 1, i) = KERNEL_STRENGTHS(j)*self%weights(:, j, 1, i)
      end do
    end do
    call sort_by_line(self)
    call list_planes(self)
    self%is_wanted = .true.
    self%is_read = .false.
  end subroutine reader_ask

  !> Puts the points in the order of their first line in y.
  pure subroutine sort_by_line(self)
    class(point_reader_t), intent(inout) :: self
    integer :: i, y
    self%start = 0
    do i = 1, self%n
      y = self%first(2, i) + 2
      self%start(y) = self%start(y) + 1
    end do
    self%start(1) = 1
    do y = 2, size(self%start)
      self%start(y) = self%start(y - 1) + self%start(y)
    end do
    do i = 1, self%n
      y = self%first(2, i) + 1
      self%order(self%start(y)) = i
      self%start(y) = self%start(y) + 1
    end do
  end subroutine sort_by_line

  !> Lists the points that reach each plane of this rank, in this order.
  pure subroutine list_planes(self)
    class(point_reader_t), intent(inout) :: self
    integer :: i, z, filled
    filled = 0
    do z = 1, self%block%count(3)
      self%plane_start(z) = filled + 1
      do i = 1, self%n
        if (modulo(self%block%start(3) + z - 1 - self%first(3, self%order(i)), self%grid%n(3)) >= W) cycle
        filled = filled + 1
        self%reaching(filled) = self%order(i)
      end do
    end do
    self%plane_start(self%block%count(3) + 1) = filled + 1
  end subroutine list_planes

  !> Begins a pass. It reads if points wait and `has_state` says that it has the flow of the state on the grid.
  subroutine reader_begin(self, has_state)
    class(point_reader_t), intent(inout) :: self
    logical, intent(in) :: has_state
    self%is_reading = self%is_wanted .and. has_state
    if (self%is_reading) self%velocities = 0
  end subroutine reader_begin

  !> Adds lines first .. first + count - 1 of the local plane z: `u` (nx, count, 3 and more) has the velocity.
  subroutine reader_read_lines(self, first, count, z, u)
    class(point_reader_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: u(:, :, :)
    real(rp) :: begun
    integer :: e, y, side, from, to
    if (.not. self%is_reading) return
    if (self%plane_start(z) == self%plane_start(z + 1)) return
    begun = wall_seconds()
    do side = 0, 1 ! points that begin in this box, and those that begin before it, in its periodic image
      y = self%block%start(2) + first - 1 + side*self%grid%n(2) ! 0-based
      from = first_from(self, z, y - W + 1)
      to = first_from(self, z, y + count) - 1
      do e = from, to
        call add_lines(self, self%reaching(e), y - self%first(2, self%reaching(e)), count, z, u)
      end do
    end do
    self%seconds = self%seconds + wall_seconds() - begun
  end subroutine reader_read_lines

  !> Returns the number of the first of the points that reach plane z whose first line is `line` or a later one.
  pure integer function first_from(self, z, line) result(low)
    type(point_reader_t), intent(in) :: self
    integer, intent(in) :: z, line
    integer :: high, middle
    low = self%plane_start(z)
    high = self%plane_start(z + 1)
    do while (low < high)
      middle = (low + high)/2
      if (self%first(2, self%reaching(middle)) >= line) then
        high = middle
      else
        low = middle + 1
      end if
    end do
  end function first_from

  !> Adds to point p the lines of `u`, of which the first lies `low` after the first one of the point.
  subroutine add_lines(self, p, low, count, z, u)
    type(point_reader_t), intent(inout) :: self
    integer, intent(in) :: p, low, count, z
    real(rp), contiguous, intent(in) :: u(:, :, :)
    real(rp) :: factor(TERMS, W), part(W, W, 3)
    integer :: a, b, c, k, l, x
    k = modulo(self%block%start(3) + z - 1 - self%first(3, p), self%grid%n(3)) + 1
    a = max(1, 1 - low)
    b = min(count, W - low)
    do l = a, b
      factor(:, l - a + 1) = self%weights(k, :, 3, p)*self%weights(low + l, :, 2, p)
    end do
    x = self%first(1, p)
    associate (own => self%velocities(:, p), weights => self%weights(:, :, 1, p), n => self%grid%n(1))
      if (self%grid%is_2d) then
        do c = 1, 3
          own(c) = own(c) + sum(matmul(weights(1, :), factor(:, :b - a + 1))*u(1, a:b, c))
        end do
      else if (x + W <= n) then
        call add_products(size(u, 1), size(u, 2), [x, a - 1], b - a + 1, u, factor, weights, own)
      else
        do c = 1, 3
          do l = a, b
            part(:n - x, l - a + 1, c) = u(x + 1:, l, c)
            part(n - x + 1:, l - a + 1, c) = u(:W - n + x, l, c)
          end do
        end do
        call add_products(W, W, [0, 0], b - a + 1, part, factor, weights, own)
      end if
    end associate
  end subroutine add_lines

  !> Adds to `velocity` the products of u after `corner`, W numbers on each of m lines, factors of these lines and weights along
  !> them.
  pure subroutine add_products(nx, lines, corner, m, u, factor, weights, velocity)
    integer, intent(in) :: nx, lines, corner(2), m
    real(rp), intent(in) :: u(nx, lines, *), factor(TERMS, m), weights(W, TERMS)
    real(rp), intent(inout) :: velocity(3)
    integer, parameter :: HALF = W/2
    real(rp) :: sums(W, TERMS), parts(HALF)
    integer :: c, i, l
    do c = 1, 3
      sums = 0
      do l = 1, m
        do i = 1, W
          sums(i, 1) = sums(i, 1) + factor(1, l)*u(corner(1) + i, corner(2) + l, c)
          sums(i, 2) = sums(i, 2) + factor(2, l)*u(corner(1) + i, corner(2) + l, c)
        end do
      end do
      sums = sums*weights
      parts = (sums(:HALF, 1) + sums(HALF + 1:, 1)) + (sums(:HALF, 2) + sums(HALF + 1:, 2))
      velocity(c) = velocity(c) + sum(parts(:HALF/2) + parts(HALF/2 + 1:))
    end do
  end subroutine add_products

  !> Ends a pass: if it has read the flow, `velocities` are complete. Collective in this case.
  subroutine reader_finish(self)
    class(point_reader_t), intent(inout) :: self
    if (.not. self%is_reading) return
    call sum_over_ranks(self%world, 3*self%n, self%velocities)
    self%is_reading = .false.
    self%is_wanted = .false.
    self%is_read = .true.
  end subroutine reader_finish

  !> Sums the first n values over all ranks. Collective.
  subroutine sum_over_ranks(world, n, values)
    type(world_t), intent(in) :: world
    integer, intent(in) :: n
    real(rp), intent(inout) :: values(n)
    call world%sum_reals(values)
  end subroutine sum_over_ranks

  !> Returns the bytes of its large arrays on this rank.
  pure real(rp) function reader_memory_bytes(self) result(bytes)
    class(point_reader_t), intent(in) :: self
    bytes = 0
    if (self%is_possible) bytes = 8*real(size(self%weights), rp) + 4*real(size(self%reaching), rp)
  end function reader_memory_bytes
end module fluid_point_reader

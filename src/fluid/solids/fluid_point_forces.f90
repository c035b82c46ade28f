! SPDX-License-Identifier: GPL-3.0-or-later
!> Applies forces at points of the flow, and interpolates the velocity of the flow at these points.
!>
!> Both use one filter Phi(k). The velocity at a point X is
!>
!>     (I u)(X) = sum_k Phi(k) u_k exp(i k.X),          |k| < K,
!>
!> and forces F_m at X_m for a time dt change the flow by its adjoint, projected,
!>
!>     u_k <- u_k + dt/V Phi(k) (1 - k k/k^2) sum_m F_m exp(-i k.X_m).
!>
!> K is the largest radius of a sphere inside the truncation, so that the response depends on distances only. With
!> Phi^2 = 1 + (k/K)^2 a sheet of points acts as a wall without thickness: its effective half thickness is
!> (1/pi) int (1 - Phi^2)/k^2 dk over all k, which vanishes, while Phi = 1 has 2/(pi K), 0.3 dx.
!>
!> The sums over modes are fast transforms to and from the grid, done only where the window about the points reaches
!> (spectral_window).
module fluid_point_forces
  use base_errors, only: require
  use base_kinds, only: rp
  use parallel_block, only: block_t
  use parallel_world, only: world_t
  use fluid_point_filter, only: point_filter_t
  use spectral_grid, only: grid_t
  use spectral_sticks, only: sticks_t, DEALIAS_ELLIPSOID
  use spectral_transform, only: kernels_t, transform_t
  use spectral_window, only: window_weights, WINDOW_WIDTH
  implicit none
  private
  public :: point_forces_t

  !> The window weights of the points on this rank's lines, sorted by line.
  type :: stencils_t
    integer, allocatable :: line_first(:)  !< (ny_local*nz_local + 1) first entry of a line
    integer, allocatable :: point(:)       !< (entries) the point
    real(rp), allocatable :: weight(:)     !< (entries) its weight across x
    integer, allocatable :: first(:, :)    !< (3, points) first cell in each direction, 0-based; in x inside the box
    real(rp), allocatable :: weights(:, :, :) !< (W, 3, points)
    logical, allocatable :: lines(:, :)    !< (ny_local, nz_local) lines with an entry
  end type stencils_t

  type, extends(kernels_t) :: point_forces_t
    private
    type(world_t) :: world
    type(grid_t) :: grid
    type(block_t) :: block
    type(point_filter_t) :: filter
    integer :: n = 0, width_x = WINDOW_WIDTH
    real(rp), public :: radius = 0                     !< K, 1/L
    type(stencils_t) :: stencils
    real(rp), allocatable :: values(:, :)                !< (3, n) velocities or forces
    real(rp) :: impulse = 0, mean_change(3) = 0
    complex(rp), pointer, contiguous :: u(:, :, :) => null()
  contains
    procedure :: init => forces_init
    procedure :: place => forces_place
    procedure :: sample => forces_sample
    procedure :: apply => forces_apply
    procedure :: spectral_in => forces_spectral_in
    procedure :: product => forces_product
    procedure :: spectral_out => forces_spectral_out
    procedure :: memory_bytes => forces_memory_bytes
  end type point_forces_t

contains

  !> Makes room for up to `most` points in the flow on this block of the grid. The grid needs at least W points in each direction,
  !> or one in x, and the truncation 'ellipsoid'.
  subroutine forces_init(self, world, grid, block, sticks, most)
    class(point_forces_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    type(sticks_t), intent(in) :: sticks
    integer, intent(in) :: most
    integer :: n_lines
    call require(all(grid%n >= WINDOW_WIDTH .or. [grid%is_2d, .false., .false.]), &
                 'point_forces_t: the window needs more points in each direction')
    call require(sticks%dealias == DEALIAS_ELLIPSOID, 'point_forces_t: the window needs the ellipsoidal truncation')
    self%world = world
    self%grid = grid
    self%block = block
    self%width_x = merge(1, WINDOW_WIDTH, grid%is_2d)
    n_lines = block%count(2)*block%count(3)
    allocate (self%stencils%line_first(n_lines + 1), self%stencils%lines(block%count(2), block%count(3)))
    allocate (self%stencils%point(WINDOW_WIDTH**2*most), self%stencils%weight(WINDOW_WIDTH**2*most))
    allocate (self%stencils%first(3, most), self%stencils%weights(WINDOW_WIDTH, 3, most))
    allocate (self%values(3, most))
    call self%filter%init(grid, sticks)
    self%radius = self%filter%radius
    self%stencils%line_first = 1
    self%stencils%lines = .false.
  end subroutine forces_init

  !> Moves the points to x(3, n) [L]. They may lie outside of the box, which is periodic.
  subroutine forces_place(self, x)
    class(point_forces_t), intent(inout) :: self
    real(rp), intent(in) :: x(:, :)
    integer :: i, j, k, line, pass, n_lines
    integer, dimension(WINDOW_WIDTH) :: y, z
    self%n = size(x, 2)
    n_lines = size(self%stencils%line_first) - 1
    call require(self%n <= size(self%values, 2), 'point_forces_t: more points than there is room for')
    call find_weights(self, x)
    associate (s => self%stencils, block => self%block)
      ! The first pass counts the entries of every line, the second stores them.
      s%line_first = 0
      do pass = 1, 2
        do i = 1, self%n
          call find_local(s%first(2, i), self%grid%n(2), block%start(2), block%count(2), y)
          call find_local(s%first(3, i), self%grid%n(3), block%start(3), block%count(3), z)
          do k = 1, WINDOW_WIDTH
            if (z(k) == 0) cycle
            do j = 1, WINDOW_WIDTH
              if (y(j) == 0) cycle
              line = y(j) + block%count(2)*(z(k) - 1)
              if (pass == 2) then
                s%point(s%line_first(line)) = i
                s%weight(s%line_first(line)) = s%weights(j, 2, i)*s%weights(k, 3, i)
              end if
              s%line_first(line) = s%line_first(line) + 1
            end do
          end do
        end do
        if (pass == 1) then
          s%lines = reshape(s%line_first(:n_lines) > 0, shape(s%lines))
          call counts_to_starts(s%line_first)
        end if
      end do
      ! Every start has moved to the end of its line, which is the start of the next one.
      s%line_first(2:) = s%line_first(:n_lines)
      s%line_first(1) = 1
    end associate
  end subroutine forces_place

  !> Finds the first cells and the weights of points x(3, n) [L]. Across x a point of a plane flow has one cell.
  subroutine find_weights(self, x)
    class(point_forces_t), intent(inout) :: self
    real(rp), intent(in) :: x(:, :)
    integer :: i, j
    associate (s => self%stencils)
      do i = 1, size(x, 2)
        do j = merge(2, 1, self%grid%is_2d), 3
          call window_weights(x(j, i)/self%grid%spacing(j), s%first(j, i), s%weights(:, j, i))
        end do
        if (self%grid%is_2d) then
          s%first(1, i) = 0
          s%weights(:, 1, i) = 0
          s%weights(1, 1, i) = 1
        else
          s%first(1, i) = modulo(s%first(1, i), self%grid%n(1))
        end if
      end do
    end associate
  end subroutine find_weights

  !> Returns the local numbers of the cells first .. first + W - 1 of n in a periodic direction; 0 for those of other ranks.
  pure subroutine find_local(first, n, start, count, local)
    integer, intent(in) :: first, n, start, count
    integer, intent(out) :: local(WINDOW_WIDTH)
    integer :: i, cell
    cell = modulo(first, n)
    do i = 1, WINDOW_WIDTH
      local(i) = merge(cell - start + 1, 0, cell >= start .and. cell < start + count)
      cell = merge(0, cell + 1, cell + 1 == n)
    end do
  end subroutine find_local

  !> Turns numbers of entries into the number of the first one.
  pure subroutine counts_to_starts(counts)
    integer, intent(inout) :: counts(:)
    integer :: i, count, next
    next = 1
    do i = 1, size(counts)
      count = counts(i)
      counts(i) = next
      next = next + count
    end do
  end subroutine counts_to_starts

  !> Returns the velocities (3, n) [L/T] of the flow `u` (nkz, sticks, 3) at the points, the same on all ranks. Costs three inverse
  !> transforms, but computes only the parts that reach the points. Collective.
  subroutine forces_sample(self, transform, u, velocities)
    class(point_forces_t), intent(inout), target :: self
    class(transform_t), intent(inout) :: transform
    complex(rp), contiguous, target, intent(in) :: u(:, :, :)
    real(rp), intent(inout) :: velocities(:, :)
    call point_at(self, u)
    self%n_in = 3
    self%n_out = 0
    self%values(:, :self%n) = 0
    call transform%pipeline(self)
    call sum_over_ranks(self%world, 3*self%n, self%values)
    velocities(:, :self%n) = self%values(:, :self%n)
    nullify (self%u)
  end subroutine forces_sample

  !> Sums the first n values over all ranks. Collective.
  subroutine sum_over_ranks(world, n, values)
    type(world_t), intent(in) :: world
    integer, intent(in) :: n
    real(rp), intent(inout) :: values(n)
    call world%sum_reals(values)
  end subroutine sum_over_ranks

  !> Changes the flow `u` by forces(3, n) [rho L^4/T^2] that act on it at the points for a time `dt` [T]. The mean flow changes by
  !> dt times the total force times `mean_response` [1/(rho L^3)] of each direction: 1/V where it is free, 0 where it is prescribed.
  !> Costs three forward transforms, but computes only the parts that come from the points. Collective.
  subroutine forces_apply(self, transform, forces, dt, mean_response, u)
    class(point_forces_t), intent(inout), target :: self
    class(transform_t), intent(inout) :: transform
    real(rp), intent(in) :: forces(:, :), dt, mean_response(3)
    complex(rp), contiguous, target, intent(inout) :: u(:, :, :)
    call point_at(self, u)
    self%n_in = 0
    self%n_out = 3
    self%impulse = dt
    self%mean_change = dt*mean_response*sum(forces(:, :self%n), 2)
    self%values(:, :self%n) = forces(:, :self%n)
    call transform%pipeline(self)
    nullify (self%u)
  end subroutine forces_apply

  !> Prepares a pass of the transform over the flow `u`.
  subroutine point_at(self, u)
    type(point_forces_t), intent(inout), target :: self
    complex(rp), contiguous, target, intent(in) :: u(:, :, :)
    self%u => u
    self%lines => self%stencils%lines
  end subroutine point_at

  !> Fills `fields` with the velocity; see kernels_t.
  subroutine forces_spectral_in(self, first, count, fields)
    class(point_forces_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    call self%filter%take(first, count, self%u, fields)
  end subroutine forces_spectral_in

  !> Interpolates velocities at the points, or spreads the forces of the points; see kernels_t.
  subroutine forces_product(self, first, count, z, in, out)
    class(point_forces_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    integer :: i, line
    if (self%n_out > 0) out(:, 1:count, :) = 0
    do i = 1, count
      line = first + i - 1 + self%block%count(2)*(z - 1)
      if (self%n_out > 0) then
        call spread_line(self, line, out(:, i, :))
      else
        call gather_line(self, line, in(:, i, :))
      end if
    end do
  end subroutine forces_product

  !> Adds the velocities on a line of the grid to the values of the points near it.
  subroutine gather_line(self, line, in)
    type(point_forces_t), intent(inout) :: self
    integer, intent(in) :: line
    real(rp), intent(in) :: in(:, :)
    integer :: c, e, j, x
    real(rp) :: sums(3)
    associate (s => self%stencils, w => self%width_x)
      do e = s%line_first(line), s%line_first(line + 1) - 1
        associate (p => s%point(e))
          x = s%first(1, p)
          sums = 0
          if (x + WINDOW_WIDTH <= self%grid%n(1)) then
            do c = 1, 3
              sums(c) = weighted_sum(s%weights(:, 1, p), in(x + 1:x + WINDOW_WIDTH, c))
            end do
          else
            do j = 1, w
              sums = sums + s%weights(j, 1, p)*in(1 + modulo(x + j - 1, self%grid%n(1)), :)
            end do
          end if
          self%values(:, p) = self%values(:, p) + s%weight(e)*sums
        end associate
      end do
    end associate
  end subroutine gather_line

  !> Returns sum(w u), in parts that a processor can add at the same time.
  pure real(rp) function weighted_sum(w, u) result(total)
    real(rp), intent(in) :: w(WINDOW_WIDTH), u(WINDOW_WIDTH)
    integer, parameter :: HALF = WINDOW_WIDTH/2
    real(rp) :: parts(HALF)
    parts = w(:HALF)*u(:HALF) + w(HALF + 1:)*u(HALF + 1:)
    total = sum(parts)
  end function weighted_sum

  !> Adds the forces of the points near a line of the grid to this line.
  subroutine spread_line(self, line, out)
    type(point_forces_t), intent(in) :: self
    integer, intent(in) :: line
    real(rp), intent(inout) :: out(:, :)
    integer :: c, e, j, x
    real(rp) :: force(3)
    associate (s => self%stencils, w => self%width_x)
      do e = s%line_first(line), s%line_first(line + 1) - 1
        associate (p => s%point(e))
          force = s%weight(e)/self%grid%cell_volume()*self%values(:, p)
          x = s%first(1, p)
          if (x + w <= self%grid%n(1)) then
            do c = 1, 3
              out(x + 1:x + w, c) = out(x + 1:x + w, c) + force(c)*s%weights(:w, 1, p)
            end do
          else
            do j = 1, w
              associate (there => out(1 + modulo(x + j - 1, self%grid%n(1)), :))
                there = there + s%weights(j, 1, p)*force
              end associate
            end do
          end if
        end associate
      end do
    end associate
  end subroutine spread_line

  !> Changes the flow by the projected forces; see kernels_t.
  subroutine forces_spectral_out(self, first, count, fields)
    class(point_forces_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    ! The mean flow responds to the total force directly, without the window.
    call self%filter%push(first, count, self%impulse, self%mean_change, fields, self%u)
  end subroutine forces_spectral_out

  !> Returns the bytes of its large arrays on this rank.
  pure real(rp) function forces_memory_bytes(self) result(bytes)
    class(point_forces_t), intent(in) :: self
    bytes = 0
    if (allocated(self%values)) bytes = 12*real(size(self%stencils%point), rp) + self%filter%memory_bytes() + &
                                        4*real(size(self%stencils%line_first), rp)
  end function forces_memory_bytes
end module fluid_point_forces

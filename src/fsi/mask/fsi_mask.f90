! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes mask and solid velocity of triangulated wings.
!>
!> With d the distance of a grid point from the nearest triangle, chi = step(d, t/2, h): 1 for d <= t/2 - h, 0 for d >= t/2 + h,
!> half a cosine between. Every wing is thus a sheet of thickness t with rounded edges, of volume A t + pi t^2 P/8 + pi t^3/6 for a
!> flat one of area A and convex outline P, up to O(h^2 P). u_s is the velocity of the surface at its closest point, not at the grid
!> point. Where surfaces meet, the triangle at the smallest distance determines u_s and colour; among equal distances it is the
!> first triangle.
!>
!> Every triangle visits the grid lines that pass it closer than t/2 + h, and distances are computed on those parts of the lines
!> only: the work is proportional to the area of the wings. All coordinates are those of the whole box, and triangles come in the
!> same order on every rank, so that a line is the same to the last bit on any rank.
module fsi_mask
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use fluid_bodies, only: mask_profile
  use fluid_penalty, only: penalty_t
  use fsi_surface, only: surface_t
  use fsi_triangle, only: triangle_t, make_triangle
  use parallel_block, only: block_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: mask_t

  real(rp), parameter :: ROUNDING = 1 + 1.0e-10_rp !< margin, so that round-off excludes no point within reach
  real(rp), parameter :: FAR_AWAY = 1.0e3_rp       !< distance in box lengths beyond which a wing counts as lost
  real(rp), parameter :: FLAT = 1.0e-6_rp          !< slope of a plane along x that cannot be inverted well

  !> A triangle near this rank's lines.
  type :: near_triangle_t
    type(triangle_t) :: shape
    integer :: surface = 0
    integer :: number = 0
    real(rp) :: low(3) = 0, high(3) = 0 !< its box
    real(rp) :: inverse_slope = 0       !< of its plane along x, 0 if it is flat
  end type near_triangle_t

  !> A triangle on a line: the points first_x .. last_x of the line (y, z) may be within reach. y, z and x are
  !> 0-based and not wrapped: a periodic image keeps its distance from the triangle.
  type :: visit_t
    integer :: near = 0
    integer :: line = 0 !< of this rank
    integer :: y = 0, z = 0
    integer :: first_x = 0, last_x = 0
  end type visit_t

  !> The closest triangle of a grid point.
  type :: point_t
    real(rp) :: distance2 = 0 !< to the nearest triangle so far
    real(rp) :: v = 0, w = 0  !< coordinates of its closest point
    integer :: near = 0       !< that triangle, 0 if none is within reach
  end type point_t

  !> Draws wings on a rank's block. Everything private is scratch that grows to the largest need and stays.
  type :: mask_t
    integer :: n_cells = 0 !< band points of this rank in the last drawing
    integer :: n_tests = 0 !< points visited for them, triangle by triangle
    real(rp) :: half_thickness = 0, smoothing = 0
    type(grid_t), private :: grid
    type(block_t), private :: block
    real(rp), private :: reach = 0
    integer, private :: n_near = 0, n_visits = 0, n_lines = 0
    type(near_triangle_t), allocatable, private :: near(:)
    type(visit_t), allocatable, private :: visits(:)
    integer, allocatable, private :: lines(:)      !< (n_lines) those that are visited
    integer, allocatable, private :: span(:, :)    !< (2, line) smallest and largest x visited, wrapped; nx, -1 if none
    integer, allocatable, private :: offset(:)     !< (line) index in `points` that corresponds to x = 0 of the line
    type(point_t), allocatable, private :: points(:)
    integer, allocatable, private :: x(:), color(:) !< (nx) points of a line to be given to the fluid
    real(rp), allocatable, private :: chi(:), us(:, :)
  contains
    procedure :: init => mask_init
    procedure :: draw => mask_draw
  end type mask_t

contains

  !> Prepares drawing on `block` of `grid`. In a two-dimensional box the section of the wings in the plane x = 0 is
  !> drawn.
  subroutine mask_init(self, grid, block, half_thickness, smoothing)
    class(mask_t), intent(inout) :: self
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    real(rp), intent(in) :: half_thickness !< t/2 [length]
    real(rp), intent(in) :: smoothing      !< h [length], half the width of the step
    integer :: nx, n_lines
    call require(half_thickness >= smoothing .and. smoothing > 0, 'mask_t: 0 < smoothing <= half-thickness is needed')
    call require(block%count(1) == grid%n(1), 'mask_t: lines must be whole')
    self%grid = grid
    self%block = block
    self%half_thickness = half_thickness
    self%smoothing = smoothing
    self%reach = half_thickness + smoothing
    nx = grid%n(1)
    n_lines = block%count(2)*block%count(3)
    if (allocated(self%near)) deallocate (self%near, self%visits, self%lines, self%span, self%offset, self%points, &
                                          self%x, self%color, self%chi, self%us)
    allocate (self%near(256), self%visits(1024), self%points(1024))
    allocate (self%lines(n_lines), self%span(2, n_lines), self%offset(n_lines))
    self%span(1, :) = nx
    self%span(2, :) = -1
    allocate (self%x(nx), self%color(nx), self%chi(nx), self%us(3, nx))
  end subroutine mask_init

  !> Replaces the wings in `penalty` by `surfaces`; solids that never move stay. Fails, with the wings
  !> erased, if a coordinate is not finite or far outside of the box. The same surfaces must be given on all
  !> ranks; communicates nothing.
  subroutine mask_draw(self, surfaces, penalty, failure, over)
    class(mask_t), intent(inout) :: self
    type(surface_t), intent(in) :: surfaces(:)
    type(penalty_t), intent(inout) :: penalty
    type(failure_t), intent(inout) :: failure
    logical, intent(in), optional :: over !< other moving solids have been drawn and stay
    logical :: stays
    integer :: s, i
    stays = .false.
    if (present(over)) stays = over
    if (.not. stays) call penalty%erase_overlay()
    self%n_cells = 0
    self%n_tests = 0
    self%n_near = 0
    self%n_visits = 0
    self%n_lines = 0
    do s = 1, size(surfaces)
      ! In this form the test also fails for NaN.
      if (.not. all(abs(surfaces(s)%points) <= FAR_AWAY*maxval(self%grid%length))) then
        call failure%raise('the position of a wing is outside of the box or not a number: check its motion and the size of the box')
        return
      end if
    end do
    do s = 1, size(surfaces)
      do i = 1, size(surfaces(s)%triangles, 2)
        call sort_triangle(self, surfaces(s)%points, surfaces(s)%triangles(:, i), s, i)
      end do
    end do
    call reserve_points(self)
    do i = 1, self%n_visits
      associate (visit => self%visits(i))
        self%n_tests = self%n_tests + visit%last_x - visit%first_x + 1
        call measure(visit, self%near(visit%near)%shape, self%grid%spacing, self%grid%n(1), self%span(1, visit%line), &
                     self%points(self%offset(visit%line) + self%span(1, visit%line):))
      end associate
    end do
    do i = 1, self%n_lines
      call give_line(self, self%lines(i), surfaces, penalty)
    end do
  end subroutine mask_draw

  !> Lets a triangle visit the lines of this rank that pass within reach, periodic images included.
  subroutine sort_triangle(self, points, corners, surface, number)
    class(mask_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: corners(3), surface, number
    real(rp) :: low(3), high(3)
    integer :: first(2:3), last(2:3), y, z, local(2:3)
    logical :: is_new
    low = min(points(:, corners(1)), points(:, corners(2)), points(:, corners(3)))
    high = max(points(:, corners(1)), points(:, corners(2)), points(:, corners(3)))
    first = ceiling((low(2:3) - self%reach*ROUNDING)/self%grid%spacing(2:3))
    last = floor((high(2:3) + self%reach*ROUNDING)/self%grid%spacing(2:3))
    is_new = .true.
    do z = first(3), last(3)
      local(3) = modulo(z, self%block%n(3)) - self%block%start(3)
      if (local(3) < 0 .or. local(3) >= self%block%count(3)) cycle
      do y = first(2), last(2)
        local(2) = modulo(y, self%block%n(2)) - self%block%start(2)
        if (local(2) < 0 .or. local(2) >= self%block%count(2)) cycle
        if (is_new) call add_triangle(self, points, corners, surface, number, low, high)
        is_new = .false.
        call visit_line(self, self%near(self%n_near), 1 + local(2) + self%block%count(2)*local(3), y, z)
      end do
    end do
  end subroutine sort_triangle

  !> Adds a triangle of a wing to those near this rank.
  subroutine add_triangle(self, points, corners, surface, number, low, high)
    class(mask_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :), low(3), high(3)
    integer, intent(in) :: corners(3), surface, number
    type(near_triangle_t), allocatable :: larger(:)
    if (self%n_near == size(self%near)) then
      allocate (larger(2*self%n_near))
      larger(1:self%n_near) = self%near
      call move_alloc(larger, self%near)
    end if
    self%n_near = self%n_near + 1
    associate (near => self%near(self%n_near))
      near%shape = make_triangle(points(:, corners(1)), points(:, corners(2)), points(:, corners(3)))
      near%surface = surface
      near%number = number
      near%low = low
      near%high = high
      near%inverse_slope = 0
      if (abs(near%shape%normal(1)) > FLAT) near%inverse_slope = 1/near%shape%normal(1)
    end associate
  end subroutine add_triangle

  !> Adds a visit of the line (y, z) if it has points within reach of the triangle's box and of its plane.
  subroutine visit_line(self, near, line, y, z)
    class(mask_t), intent(inout) :: self
    type(near_triangle_t), intent(in) :: near
    integer, intent(in) :: line, y, z
    type(visit_t), allocatable :: larger(:)
    real(rp) :: point(2:3), outside(2:3), rest, reach, from, upto, middle, height
    integer :: first_x, last_x
    reach = self%reach*ROUNDING
    point = [y, z]*self%grid%spacing(2:3)
    outside = max(near%low(2:3) - point, point - near%high(2:3), 0.0_rp)
    rest = reach**2 - outside(2)**2 - outside(3)**2
    if (rest <= 0) return
    from = near%low(1) - sqrt(rest)
    upto = near%high(1) + sqrt(rest)
    associate (shape => near%shape)
      ! |height + normal_x (x - a_x)| <= reach is the slab around the plane; a needle has none.
      height = shape%normal(2)*(point(2) - shape%a(2)) + shape%normal(3)*(point(3) - shape%a(3))
      if (near%inverse_slope > 0 .or. near%inverse_slope < 0) then
        middle = shape%a(1) - height*near%inverse_slope
        from = max(from, middle - reach*abs(near%inverse_slope))
        upto = min(upto, middle + reach*abs(near%inverse_slope))
      else if (abs(height) - 2*FLAT*(upto - from) > reach) then
        return
      end if
    end associate
    first_x = ceiling(from/self%grid%spacing(1))
    last_x = floor(upto/self%grid%spacing(1))
    if (first_x > last_x) return

    if (self%n_visits == size(self%visits)) then
      allocate (larger(2*self%n_visits))
      larger(1:self%n_visits) = self%visits
      call move_alloc(larger, self%visits)
    end if
    self%n_visits = self%n_visits + 1
    self%visits(self%n_visits) = visit_t(self%n_near, line, y, z, first_x, last_x)
    if (self%span(2, line) < 0) then
      self%n_lines = self%n_lines + 1
      self%lines(self%n_lines) = line
    end if
    if (first_x < 0 .or. last_x >= self%grid%n(1)) then
      self%span(:, line) = [0, self%grid%n(1) - 1]
    else
      self%span(:, line) = [min(self%span(1, line), first_x), max(self%span(2, line), last_x)]
    end if
  end subroutine visit_line

  !> Assigns a range of `points` to every visited line; no point is within reach yet.
  subroutine reserve_points(self)
    class(mask_t), intent(inout) :: self
    type(point_t) :: nothing
    integer :: i, n
    n = 0
    do i = 1, self%n_lines
      associate (line => self%lines(i))
        self%offset(line) = n + 1 - self%span(1, line)
        n = n + self%span(2, line) - self%span(1, line) + 1
      end associate
    end do
    if (n > size(self%points)) then
      deallocate (self%points)
      allocate (self%points(2*n))
    end if
    nothing%distance2 = self%reach**2
    self%points(1:n) = nothing
  end subroutine reserve_points

  !> Computes distances of the points of one visit; keeps those that are smaller than the ones known before.
  pure subroutine measure(visit, shape, spacing, nx, start_x, points)
    type(visit_t), intent(in) :: visit
    type(triangle_t), intent(in) :: shape
    real(rp), intent(in) :: spacing(3)
    integer, intent(in) :: nx, start_x
    type(point_t), contiguous, intent(inout) :: points(start_x:) !< of the line
    real(rp) :: p(3), ap(3), height, beside, at_a(0:3), d2, v, w
    integer :: x, i
    p(2:3) = [visit%y, visit%z]*spacing(2:3)
    ap(2:3) = p(2:3) - shape%a(2:3)
    ! Distances from the plane and, outward, from the lines of the edges are linear in x.
    at_a(0) = shape%normal(2)*ap(2) + shape%normal(3)*ap(3)
    at_a(1:3) = shape%outward(2, :)*ap(2) + shape%outward(3, :)*ap(3)
    at_a(3) = at_a(3) - shape%height
    do x = visit%first_x, visit%last_x
      p(1) = x*spacing(1)
      i = x
      if (i < 0 .or. i >= nx) i = modulo(x, nx)
      ap(1) = p(1) - shape%a(1)
      height = at_a(0) + shape%normal(1)*ap(1)
      beside = max(0.0_rp, at_a(1) + shape%outward(1, 1)*ap(1), at_a(2) + shape%outward(1, 2)*ap(1), &
                   at_a(3) + shape%outward(1, 3)*ap(1))
      ! These are lower bounds of the distance to the triangle; they exclude most triangles.
      if (height**2 + beside**2 >= points(i)%distance2) cycle
      call shape%closest(p, d2, v, w)
      if (d2 < points(i)%distance2) points(i) = point_t(d2, v, w, visit%near)
    end do
  end subroutine measure

  !> Turns distances into mask, velocity and colour for the fluid, and clears the line.
  subroutine give_line(self, line, surfaces, penalty)
    class(mask_t), intent(inout) :: self
    integer, intent(in) :: line
    type(surface_t), intent(in) :: surfaces(:)
    type(penalty_t), intent(inout) :: penalty
    real(rp) :: chi
    integer :: x, n, corners(3)
    n = 0
    do x = self%span(1, line), self%span(2, line)
      associate (point => self%points(self%offset(line) + x))
        if (point%near == 0) cycle
        chi = mask_profile(sqrt(point%distance2) - self%half_thickness, self%smoothing)
        if (chi <= 0) cycle
        n = n + 1
        self%x(n) = x + 1
        self%chi(n) = chi
        associate (near => self%near(point%near))
          associate (surface => surfaces(near%surface))
            corners = surface%triangles(:, near%number)
            self%us(:, n) = (1 - point%v - point%w)*surface%velocities(:, corners(1)) + &
                            point%v*surface%velocities(:, corners(2)) + point%w*surface%velocities(:, corners(3))
            self%color(n) = surface%color
          end associate
        end associate
      end associate
    end do
    self%span(:, line) = [self%grid%n(1), -1]
    self%n_cells = self%n_cells + n
    if (n > 0) call penalty%overlay_line(line, n, self%x, self%chi, self%us, self%color)
  end subroutine give_line
end module fsi_mask

! SPDX-License-Identifier: GPL-3.0-or-later
!> Mask and solid velocity of triangulated wings.
!>
!> With d the distance of a grid point from the nearest triangle, chi = step(d, t/2, h): 1 for d <= t/2 - h,
!> 0 for d >= t/2 + h, half a cosine between. Every wing is thus a sheet of thickness t with rounded edges, of
!> volume A t + pi t^2 P/8 + pi t^3/6 for a flat one of area A and convex outline P, up to O(h^2 P). u_s is the
!> velocity of the surface at its closest point, not at the grid point. Where surfaces meet, the smallest
!> distance decides on u_s and colour; among equal ones the first triangle.
!>
!> Triangles are sorted into the grid lines that pass them closer than t/2 + h, and distances are computed for
!> those points of the lines only: work follows the area of the wings. All of it uses coordinates of the whole
!> box, so that every line is the same to the bit on whatever rank it lies.
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

  real(rp), parameter :: ROUNDING = 1 + 1.0e-10_rp !< nothing within reach is lost to round-off
  real(rp), parameter :: FAR_AWAY = 1.0e3_rp       !< box lengths from which on a wing counts as lost

  !> A triangle near this rank's lines.
  type :: near_triangle_t
    type(triangle_t) :: shape
    integer :: surface = 0
    integer :: number = 0
  end type near_triangle_t

  !> A triangle on a line: the points first_x .. last_x of the line (y, z) may be within reach. Indices are
  !> 0-based and not wrapped: a periodic image keeps its distance from the triangle.
  type :: visit_t
    integer :: next = 0 !< next visit of the same line, 0 for none
    integer :: near = 0
    integer :: y = 0, z = 0
    integer :: first_x = 0, last_x = 0
  end type visit_t

  !> Draws wings on a rank's block. Everything private is scratch that grows to the largest need and stays.
  type :: mask_t
    integer :: n_cells = 0 !< band points of this rank in the last drawing
    integer :: n_tests = 0 !< points visited for them, triangle by triangle
    real(rp) :: half_thickness = 0, smoothing = 0
    type(grid_t), private :: grid
    type(block_t), private :: block
    real(rp), private :: reach = 0
    type(near_triangle_t), allocatable, private :: near(:)
    type(visit_t), allocatable, private :: visits(:)
    integer, private :: n_near = 0, n_visits = 0, n_lines = 0
    integer, allocatable, private :: first_visit(:), last_visit(:) !< of every line; 0 between drawings
    integer, allocatable, private :: lines(:)                      !< (n_lines) those that have visits
    ! One line. `distance2` is reach^2 and `nearest` is 0 between lines.
    real(rp), allocatable, private :: distance2(:), v(:), w(:)     !< (0:nx - 1)
    integer, allocatable, private :: nearest(:)                    !< (0:nx - 1)
    integer, allocatable, private :: x(:), color(:)                !< (nx) points to be given to the fluid
    real(rp), allocatable, private :: chi(:), us(:, :)
  contains
    procedure :: init => mask_init
    procedure :: draw => mask_draw
  end type mask_t

contains

  !> Prepares drawing on `block` of `grid`. Not for two-dimensional boxes.
  subroutine mask_init(self, grid, block, half_thickness, smoothing)
    class(mask_t), intent(inout) :: self
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    real(rp), intent(in) :: half_thickness !< t/2 [length]
    real(rp), intent(in) :: smoothing      !< h [length], half the width of the step
    integer :: nx, n_lines
    call require(.not. grid%is_2d, 'mask_t: wings need a three-dimensional box')
    call require(half_thickness >= smoothing .and. smoothing > 0, 'mask_t: 0 < smoothing <= half-thickness is needed')
    self%grid = grid
    self%block = block
    self%half_thickness = half_thickness
    self%smoothing = smoothing
    self%reach = half_thickness + smoothing
    nx = block%count(1)
    n_lines = block%count(2)*block%count(3)
    call require(nx == grid%n(1), 'mask_t: lines must be whole')
    if (allocated(self%first_visit)) deallocate (self%first_visit, self%last_visit, self%lines, self%near, self%visits)
    if (allocated(self%v)) deallocate (self%distance2, self%v, self%w, self%nearest, self%x, self%color, self%chi, self%us)
    allocate (self%first_visit(n_lines), self%last_visit(n_lines), self%lines(n_lines), source=0)
    allocate (self%near(256), self%visits(1024))
    allocate (self%distance2(0:nx - 1), source=self%reach**2)
    allocate (self%v(0:nx - 1), self%w(0:nx - 1), source=0.0_rp)
    allocate (self%nearest(0:nx - 1), source=0)
    allocate (self%x(nx), self%color(nx), source=0)
    allocate (self%chi(nx), self%us(3, nx))
  end subroutine mask_init

  !> Replaces the wings in `penalty` by `surfaces`; solids that never move stay. Fails, with the wings
  !> erased, if a coordinate is not finite or far outside of the box. The same surfaces must be given on all
  !> ranks; communicates nothing.
  subroutine mask_draw(self, surfaces, penalty, failure)
    class(mask_t), intent(inout) :: self
    type(surface_t), intent(in) :: surfaces(:)
    type(penalty_t), intent(inout) :: penalty
    type(failure_t), intent(inout) :: failure
    integer :: s, i
    call penalty%erase_overlay()
    self%n_cells = 0
    self%n_tests = 0
    self%n_near = 0
    self%n_visits = 0
    self%n_lines = 0
    do s = 1, size(surfaces)
      ! Written so that NaN is not in the box either.
      if (.not. all(abs(surfaces(s)%points) <= FAR_AWAY*maxval(self%grid%length))) then
        call failure%raise('a wing has left the box or is not a number')
        return
      end if
    end do
    do s = 1, size(surfaces)
      do i = 1, size(surfaces(s)%triangles, 2)
        call sort_triangle(self, surfaces(s)%points, surfaces(s)%triangles(:, i), s, i)
      end do
    end do
    do i = 1, self%n_lines
      call draw_line(self, self%lines(i), surfaces, penalty)
    end do
  end subroutine mask_draw

  !> Adds a triangle to the lines of this rank that pass within reach, periodic images included.
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
        if (is_new) call add_triangle(self, points, corners, surface, number)
        is_new = .false.
        call visit_line(self, 1 + local(2) + self%block%count(2)*local(3), y, z, low, high)
      end do
    end do
  end subroutine sort_triangle

  subroutine add_triangle(self, points, corners, surface, number)
    class(mask_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: corners(3), surface, number
    type(near_triangle_t), allocatable :: larger(:)
    if (self%n_near == size(self%near)) then
      allocate (larger(2*self%n_near))
      larger(1:self%n_near) = self%near
      call move_alloc(larger, self%near)
    end if
    self%n_near = self%n_near + 1
    self%near(self%n_near)%shape = make_triangle(points(:, corners(1)), points(:, corners(2)), points(:, corners(3)))
    self%near(self%n_near)%surface = surface
    self%near(self%n_near)%number = number
  end subroutine add_triangle

  !> Adds the newest triangle to local line `line` at (y, z) if the line has points within reach of the
  !> triangle's box low .. high and of its plane.
  subroutine visit_line(self, line, y, z, low, high)
    class(mask_t), intent(inout) :: self
    integer, intent(in) :: line, y, z
    real(rp), intent(in) :: low(3), high(3)
    type(visit_t), allocatable :: larger(:)
    type(visit_t) :: visit
    real(rp) :: point(2:3), outside(2:3), rest, reach, from, upto, height, slope
    reach = self%reach*ROUNDING
    point = [y, z]*self%grid%spacing(2:3)
    outside = max(low(2:3) - point, point - high(2:3), 0.0_rp)
    rest = reach**2 - outside(2)**2 - outside(3)**2
    if (rest <= 0) return
    from = low(1) - sqrt(rest)
    upto = high(1) + sqrt(rest)
    associate (shape => self%near(self%n_near)%shape)
      ! |height + slope x| <= reach is the slab around the plane; a needle has none and a slope of 0.
      slope = shape%normal(1)
      height = shape%normal(2)*(point(2) - shape%a(2)) + shape%normal(3)*(point(3) - shape%a(3)) - slope*shape%a(1)
      if (abs(slope) > 1.0e-6_rp) then
        from = max(from, (-height - sign(reach, slope))/slope)
        upto = min(upto, (-height + sign(reach, slope))/slope)
      else if (min(abs(height + slope*from), abs(height + slope*upto)) > reach .and. &
               (height + slope*from)*(height + slope*upto) > 0) then
        return
      end if
    end associate
    visit%first_x = ceiling(from/self%grid%spacing(1))
    visit%last_x = floor(upto/self%grid%spacing(1))
    if (visit%first_x > visit%last_x) return
    visit%near = self%n_near
    visit%y = y
    visit%z = z

    if (self%n_visits == size(self%visits)) then
      allocate (larger(2*self%n_visits))
      larger(1:self%n_visits) = self%visits
      call move_alloc(larger, self%visits)
    end if
    self%n_visits = self%n_visits + 1
    self%visits(self%n_visits) = visit
    if (self%first_visit(line) == 0) then
      self%n_lines = self%n_lines + 1
      self%lines(self%n_lines) = line
      self%first_visit(line) = self%n_visits
    else
      self%visits(self%last_visit(line))%next = self%n_visits
    end if
    self%last_visit(line) = self%n_visits
  end subroutine visit_line

  !> Finds the nearest triangle of every point of a line and gives the points to the fluid.
  subroutine draw_line(self, line, surfaces, penalty)
    class(mask_t), intent(inout) :: self
    integer, intent(in) :: line
    type(surface_t), intent(in) :: surfaces(:)
    type(penalty_t), intent(inout) :: penalty
    integer :: i, nx, first_x, last_x
    nx = self%grid%n(1)
    first_x = nx
    last_x = -1
    i = self%first_visit(line)
    do while (i > 0)
      associate (visit => self%visits(i))
        if (visit%first_x >= 0 .and. visit%last_x < nx) then
          first_x = min(first_x, visit%first_x)
          last_x = max(last_x, visit%last_x)
        else
          first_x = 0
          last_x = nx - 1
        end if
        self%n_tests = self%n_tests + visit%last_x - visit%first_x + 1
        call measure(visit, self%near(visit%near)%shape, self%grid%spacing, nx, self%distance2, self%v, self%w, &
                     self%nearest)
        i = visit%next
      end associate
    end do
    self%first_visit(line) = 0
    self%last_visit(line) = 0
    call give_line(self, line, first_x, last_x, surfaces, penalty)
  end subroutine draw_line

  !> Distances of the points of one visit; keeps what is nearer than what is known.
  pure subroutine measure(visit, shape, spacing, nx, distance2, v, w, nearest)
    type(visit_t), intent(in) :: visit
    type(triangle_t), intent(in) :: shape
    real(rp), intent(in) :: spacing(3)
    integer, intent(in) :: nx
    real(rp), intent(inout) :: distance2(0:nx - 1), v(0:nx - 1), w(0:nx - 1)
    integer, intent(inout) :: nearest(0:nx - 1)
    real(rp) :: p(3), height, d2, point_v, point_w
    integer :: x, i
    p(2:3) = [visit%y, visit%z]*spacing(2:3)
    height = shape%normal(2)*(p(2) - shape%a(2)) + shape%normal(3)*(p(3) - shape%a(3))
    do x = visit%first_x, visit%last_x
      p(1) = x*spacing(1)
      i = x
      if (i < 0 .or. i >= nx) i = modulo(x, nx)
      ! No point of a triangle is nearer than its plane.
      if ((height + shape%normal(1)*(p(1) - shape%a(1)))**2 >= distance2(i)) cycle
      call shape%closest(p, d2, point_v, point_w)
      if (d2 >= distance2(i)) cycle
      distance2(i) = d2
      v(i) = point_v
      w(i) = point_w
      nearest(i) = visit%near
    end do
  end subroutine measure

  !> Turns distances into mask, velocity and colour, and clears the line's scratch.
  subroutine give_line(self, line, first_x, last_x, surfaces, penalty)
    class(mask_t), intent(inout) :: self
    integer, intent(in) :: line, first_x, last_x
    type(surface_t), intent(in) :: surfaces(:)
    type(penalty_t), intent(inout) :: penalty
    real(rp) :: chi
    integer :: x, n, corners(3)
    n = 0
    do x = first_x, last_x
      if (self%nearest(x) == 0) cycle
      chi = mask_profile(sqrt(self%distance2(x)) - self%half_thickness, self%smoothing)
      if (chi > 0) then
        n = n + 1
        self%x(n) = x + 1
        self%chi(n) = chi
        associate (near => self%near(self%nearest(x)))
          associate (surface => surfaces(near%surface))
            corners = surface%triangles(:, near%number)
            self%us(:, n) = (1 - self%v(x) - self%w(x))*surface%velocities(:, corners(1)) + &
                            self%v(x)*surface%velocities(:, corners(2)) + self%w(x)*surface%velocities(:, corners(3))
            self%color(n) = surface%color
          end associate
        end associate
      end if
      self%nearest(x) = 0
      self%distance2(x) = self%reach**2
    end do
    self%n_cells = self%n_cells + n
    if (n > 0) call penalty%overlay_line(line, n, self%x, self%chi, self%us, self%color)
  end subroutine give_line
end module fsi_mask

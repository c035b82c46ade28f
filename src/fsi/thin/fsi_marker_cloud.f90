! SPDX-License-Identifier: GPL-3.0-or-later
!> Samples a sheet by a dense cloud of points, in which markers are seeded and relaxed (fsi_marker_spacing).
!>
!> Triangles are halved at their longest edges until none is longer than CUT spacings. The centres of the smallest triangles are
!> samples that carry their areas. Points of the free edges follow, without area. Samples are sorted into cells of one spacing,
!> whose contents are contiguous. Lengths are compared in steps of 2^-20 spacings or with a tolerance. Lengths that are equal by
!> symmetry therefore count as equal, independently of round-off, and the first sample is taken.
module fsi_marker_cloud
  use base_kinds, only: rp
  use fsi_rotation, only: cross
  use fsi_triangle, only: make_triangle, triangle_t
  implicit none
  private
  public :: cloud_t, site_t, site_on_edge, FREE_EDGE, FRONT, GAP

  ! These numbers occur in no mesh, so that edges and cells do not end exactly there.
  real(rp), parameter :: CUT = 0.2513_rp, EDGE_CUT = 0.1257_rp, SHIFT = 0.3719_rp
  real(rp), parameter :: SAME = 1.0e-9_rp  !< smaller relative differences count as 0
  real(rp), parameter :: FINE = 2.0_rp**20 !< steps of a spacing
  integer, parameter :: MOST_CELLS = 2**22
  integer, parameter :: DEEPEST = 200      !< halvings of a triangle

  !> Kinds of points that `pick` searches.
  integer, parameter :: FREE_EDGE = 1 !< the point of a free edge that is farthest from the markers
  integer, parameter :: FRONT = 2     !< the point nearest to two markers
  integer, parameter :: GAP = 3       !< the point of the sheet that is farthest from the markers

  !> A point of the sheet: sum_k weights(k) points(:, nodes(k)).
  type :: site_t
    integer :: nodes(3) = 0
    real(rp) :: weights(3) = 0 !< not negative, of sum 1
    real(rp) :: x(3) = 0       !< L
    logical :: is_edge = .false. !< lies on a free edge
  end type site_t

  type :: cloud_t
    integer :: n = 0
    integer, allocatable :: owner(:)      !< (n) nearest marker of the last `relax`, 0 if none is near
    real(rp), allocatable :: distance(:)  !< (n) to the nearest marker that was added, at most 2 spacings
    real(rp), private :: spacing = 0, low(3) = 0, cell = 0
    integer, private :: cells(3) = 0, mode = GAP
    real(rp), private :: limit = 0
    type(site_t), allocatable, private :: sites(:)
    integer, allocatable, private :: triangles(:)  !< (n)
    real(rp), allocatable, private :: x(:, :), area(:), second(:)
    integer, allocatable, private :: first(:)      !< samples of cell c: first(c) .. first(c + 1) - 1
    integer, allocatable, private :: filled(:)     !< cells with samples
    integer, allocatable, private :: key(:), at(:) !< (cell) of the sample that `pick` would take in it
  contains
    procedure :: init => cloud_init
    procedure :: clear => cloud_clear
    procedure :: add => cloud_add
    procedure :: search_for => cloud_search_for
    procedure :: pick => cloud_pick
    procedure :: relax => cloud_relax
    procedure :: project => cloud_project
  end type cloud_t

contains

  !> Samples the triangles and their free `edges` (2, m), whose triangles are `owners` (m). Allocates.
  subroutine cloud_init(self, points, triangles, edges, owners, spacing)
    class(cloud_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :)                       !< (3, :) L
    integer, intent(in) :: triangles(:, :), edges(:, :), owners(:)
    real(rp), intent(in) :: spacing                            !< h [L]
    type(site_t), allocatable :: sites(:)
    real(rp), allocatable :: area(:), leaves(:, :)
    integer, allocatable :: of(:), n_leaves(:), n_steps(:)
    integer :: i, k, n
    allocate (n_leaves(size(triangles, 2)), n_steps(size(edges, 2)), leaves(3, 0))
    do i = 1, size(triangles, 2)
      call halve(points(:, triangles(:, i)), CUT*spacing, n_leaves(i), leaves)
    end do
    do i = 1, size(edges, 2)
      n_steps(i) = ceiling(norm2(points(:, edges(2, i)) - points(:, edges(1, i)))/(EDGE_CUT*spacing))
    end do
    n = sum(n_leaves) + sum(n_steps + 1)
    allocate (sites(n), area(n), of(n))
    deallocate (leaves)
    allocate (leaves(4, maxval(n_leaves)))
    n = 0
    do i = 1, size(triangles, 2)
      associate (corners => points(:, triangles(:, i)))
        call halve(corners, CUT*spacing, n_leaves(i), leaves)
        do k = 1, n_leaves(i)
          n = n + 1
          sites(n) = site_t(triangles(:, i), leaves(:3, k), matmul(corners, leaves(:3, k)))
          area(n) = norm2(cross(corners(:, 2) - corners(:, 1), corners(:, 3) - corners(:, 1)))/2*leaves(4, k)
          of(n) = i
        end do
      end associate
    end do
    do i = 1, size(edges, 2)
      do k = 0, n_steps(i)
        n = n + 1
        sites(n) = site_on_edge(points, triangles(:, owners(i)), edges(:, i), real(k, rp)/max(1, n_steps(i)))
        area(n) = 0
        of(n) = owners(i)
      end do
    end do
    call sort_into_cells(self, sites, area, of, spacing)
  end subroutine cloud_init

  !> Returns the place at `fraction` of the way along an edge of a triangle.
  pure type(site_t) function site_on_edge(points, corners, edge, fraction) result(site)
    real(rp), intent(in) :: points(:, :), fraction
    integer, intent(in) :: corners(3), edge(2)
    site%nodes = corners
    where (corners == edge(1)) site%weights = 1 - fraction
    where (corners == edge(2)) site%weights = fraction
    site%x = (1 - fraction)*points(:, edge(1)) + fraction*points(:, edge(2))
    site%is_edge = .true.
  end function site_on_edge

  !> Halves a triangle until no edge is longer than `limit`: barycentric coordinates of the leaves' centres and their
  !> part of the area, (4, n) if `leaves` has room for them.
  pure subroutine halve(corners, limit, n, leaves)
    real(rp), intent(in) :: corners(3, 3), limit
    integer, intent(out) :: n
    real(rp), intent(inout) :: leaves(:, :)
    real(rp) :: stack(3, 3, DEEPEST + 1), part(3, 3), middle(3), edge, longest
    integer :: level(DEEPEST + 1), depth, i, k, this
    n = 0
    depth = 1
    stack(:, :, 1) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])
    level(1) = 0
    do while (depth > 0)
      part = stack(:, :, depth)
      this = level(depth)
      depth = depth - 1
      longest = 0
      k = 0
      do i = 1, 3
        edge = norm2(matmul(corners, part(:, mod(i, 3) + 1) - part(:, i)))
        if (edge > longest*(1 + SAME)) then
          longest = edge
          k = i
        end if
      end do
      if (longest <= limit .or. this == DEEPEST) then
        n = n + 1
        if (n <= size(leaves, 2)) leaves(:, n) = [sum(part, 2)/3, 0.5_rp**this]
      else
        middle = (part(:, k) + part(:, mod(k, 3) + 1))/2
        level(depth + 1:depth + 2) = this + 1
        stack(:, :, depth + 1) = part
        stack(:, k, depth + 1) = middle
        stack(:, :, depth + 2) = part
        stack(:, mod(k, 3) + 1, depth + 2) = middle
        depth = depth + 2
      end if
    end do
  end subroutine halve

  !> Sorts the samples into cells, so that those near a place are found quickly.
  subroutine sort_into_cells(self, sites, area, of, spacing)
    class(cloud_t), intent(inout) :: self
    type(site_t), intent(in) :: sites(:)
    real(rp), intent(in) :: area(:), spacing
    integer, intent(in) :: of(:)
    integer, allocatable :: in(:), order(:), next(:)
    real(rp) :: high(3)
    integer :: i, k
    self%n = size(sites)
    self%spacing = spacing
    do k = 1, 3
      self%low(k) = minval(sites%x(k))
      high(k) = maxval(sites%x(k))
    end do
    self%cell = spacing
    do while (product((high - self%low)/self%cell + 2) > MOST_CELLS)
      self%cell = 2*self%cell
    end do
    self%low = self%low - SHIFT*self%cell
    self%cells = floor((high - self%low)/self%cell) + 1
    allocate (in(self%n), order(self%n))
    self%first = [(0, i=1, product(self%cells) + 1)]
    do i = 1, self%n
      in(i) = number_of(self, cell_of(self, sites(i)%x))
      self%first(in(i) + 1) = self%first(in(i) + 1) + 1
    end do
    self%first(1) = 1
    do i = 1, product(self%cells)
      self%first(i + 1) = self%first(i) + self%first(i + 1)
    end do
    next = self%first
    do i = 1, self%n
      order(next(in(i))) = i
      next(in(i)) = next(in(i)) + 1
    end do
    self%sites = sites(order)
    self%area = area(order)
    self%triangles = of(order)
    self%x = reshape([(sites(order(i))%x, i=1, self%n)], [3, self%n])
    self%filled = pack([(i, i=1, product(self%cells))], self%first(2:) > self%first(:product(self%cells)))
    self%owner = [(0, i=1, self%n)]
    self%distance = [(2*spacing, i=1, self%n)]
    self%second = self%distance
    self%key = [(0, i=1, product(self%cells))]
    self%at = self%key
  end subroutine sort_into_cells

  !> Returns the indices of the cell of a place; outside the cells, of the nearest one.
  pure function cell_of(self, x) result(cell)
    class(cloud_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    integer :: cell(3)
    cell = max(1, min(self%cells, floor((x - self%low)/self%cell) + 1))
  end function cell_of

  !> Returns the number of a cell.
  pure integer function number_of(self, cell) result(number)
    class(cloud_t), intent(in) :: self
    integer, intent(in) :: cell(3)
    number = cell(1) + self%cells(1)*(cell(2) - 1 + self%cells(2)*(cell(3) - 1))
  end function number_of

  !> Forgets all markers.
  subroutine cloud_clear(self)
    class(cloud_t), intent(inout) :: self
    self%distance = 2*self%spacing
    self%second = self%distance
  end subroutine cloud_clear

  !> Adds a marker at `x`.
  subroutine cloud_add(self, x)
    class(cloud_t), intent(inout) :: self
    real(rp), intent(in) :: x(3)
    integer :: centre(3), i, j, k, c, s
    real(rp) :: d
    centre = cell_of(self, x)
    do k = max(1, centre(3) - 2), min(self%cells(3), centre(3) + 2)
      do j = max(1, centre(2) - 2), min(self%cells(2), centre(2) + 2)
        do i = max(1, centre(1) - 2), min(self%cells(1), centre(1) + 2)
          c = number_of(self, [i, j, k])
          do s = self%first(c), self%first(c + 1) - 1
            d = norm2(self%x(:, s) - x)
            if (d >= self%second(s)) cycle
            self%second(s) = max(d, self%distance(s))
            self%distance(s) = min(d, self%distance(s))
          end do
          call search_cell(self, c)
        end do
      end do
    end do
  end subroutine cloud_add

  !> Makes `pick` return samples of the kind `mode`, at least `limit` [L] from all markers.
  subroutine cloud_search_for(self, mode, limit)
    class(cloud_t), intent(inout) :: self
    integer, intent(in) :: mode
    real(rp), intent(in) :: limit
    integer :: i
    self%mode = mode
    self%limit = limit
    do i = 1, size(self%filled)
      call search_cell(self, self%filled(i))
    end do
  end subroutine cloud_search_for

  !> Finds the best sample of cell `c` for the present mode.
  subroutine search_cell(self, c)
    class(cloud_t), intent(inout) :: self
    integer, intent(in) :: c
    integer :: s, key
    self%at(c) = 0
    self%key(c) = huge(1)
    do s = self%first(c), self%first(c + 1) - 1
      if (self%distance(s) < self%limit) cycle
      if (self%mode == FREE_EDGE .and. .not. self%sites(s)%is_edge) cycle
      if (self%mode == FRONT) then
        key = steps(self%distance(s) + self%second(s))
      else
        key = -steps(self%distance(s))
      end if
      if (key >= self%key(c)) cycle
      self%key(c) = key
      self%at(c) = s
    end do

  contains

    integer function steps(length)
      real(rp), intent(in) :: length
      steps = floor(length/self%spacing*FINE + SHIFT)
    end function steps
  end subroutine search_cell

  !> Returns the sample that the present mode searches, if there is one.
  subroutine cloud_pick(self, site, found)
    class(cloud_t), intent(in) :: self
    type(site_t), intent(out) :: site
    logical, intent(out) :: found
    integer :: i, best, key
    best = 0
    key = huge(1)
    do i = 1, size(self%filled)
      if (self%key(self%filled(i)) >= key) cycle
      key = self%key(self%filled(i))
      best = self%at(self%filled(i))
    end do
    found = best > 0
    if (found) site = self%sites(best)
  end subroutine cloud_pick

  !> Moves the markers x (3, m), without the first `n_fixed`, by `speed` times the vector to the centre of the samples that are
  !> nearest to each (Lloyd's method; a speed of 1 to 2). They may leave the sheet.
  subroutine cloud_relax(self, x, n_fixed, speed)
    class(cloud_t), intent(inout) :: self
    real(rp), intent(inout) :: x(:, :)
    integer, intent(in) :: n_fixed
    real(rp), intent(in) :: speed
    real(rp) :: moments(4, size(x, 2)), nearest(self%n), quantum
    integer :: m, s
    call assign(self, x, nearest)
    moments = 0
    do s = 1, self%n
      m = self%owner(s)
      if (m <= n_fixed) cycle
      moments(:, m) = moments(:, m) + self%area(s)*[self%x(:, s), 1.0_rp]
    end do
    quantum = self%spacing/FINE ! round-off does not grow from step to step
    do m = n_fixed + 1, size(x, 2)
      if (.not. moments(4, m) > 0) cycle
      x(:, m) = x(:, m) + speed*(moments(:3, m)/moments(4, m) - x(:, m))
      x(:, m) = quantum*anint(x(:, m)/quantum)
    end do
  end subroutine cloud_relax

  !> Finds the owners of the samples and the squares of their distances; of equally near markers the first.
  subroutine assign(self, x, nearest)
    class(cloud_t), intent(inout) :: self
    real(rp), intent(in) :: x(:, :)
    real(rp), intent(inout) :: nearest(:)
    integer :: centre(3), m, i, j, k, c, s
    real(rp) :: d2
    self%owner = 0
    nearest = huge(1.0_rp)
    do m = 1, size(x, 2)
      centre = cell_of(self, x(:, m))
      do k = max(1, centre(3) - 1), min(self%cells(3), centre(3) + 1)
        do j = max(1, centre(2) - 1), min(self%cells(2), centre(2) + 1)
          do i = max(1, centre(1) - 1), min(self%cells(1), centre(1) + 1)
            c = number_of(self, [i, j, k])
            do s = self%first(c), self%first(c + 1) - 1
              d2 = (self%x(1, s) - x(1, m))**2 + (self%x(2, s) - x(2, m))**2 + (self%x(3, s) - x(3, m))**2
              if (d2 >= nearest(s)*(1 - SAME)) cycle
              nearest(s) = d2
              self%owner(s) = m
            end do
          end do
        end do
      end do
    end do
  end subroutine assign

  !> Returns the places of the sheet next to markers x (3, m), without the first `n_fixed`, in the triangles of the samples that
  !> are nearest to each; `sites` (m) of markers without samples stay.
  subroutine cloud_project(self, points, triangles, x, n_fixed, sites)
    class(cloud_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :), x(:, :)
    integer, intent(in) :: triangles(:, :), n_fixed
    type(site_t), intent(inout) :: sites(:)
    type(triangle_t) :: shape
    real(rp) :: nearest(self%n), best(size(x, 2)), d2, v, w
    integer :: tried(size(x, 2)), m, s
    call assign(self, x, nearest)
    best = huge(1.0_rp)
    tried = 0
    do s = 1, self%n
      m = self%owner(s)
      if (m <= n_fixed) cycle
      if (tried(m) == self%triangles(s)) cycle
      tried(m) = self%triangles(s)
      associate (corners => triangles(:, self%triangles(s)))
        shape = make_triangle(points(:, corners(1)), points(:, corners(2)), points(:, corners(3)))
        call shape%closest(x(:, m), d2, v, w)
        if (d2 + (SAME*self%spacing)**2 >= best(m)) cycle
        best(m) = d2
        sites(m)%nodes = corners
        sites(m)%weights = [max(0.0_rp, 1 - v - w), v, w]
        sites(m)%x = shape%a + v*shape%ab + w*shape%ac
      end associate
    end do
  end subroutine cloud_project
end module fsi_marker_cloud

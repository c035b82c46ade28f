! SPDX-License-Identifier: GPL-3.0-or-later
!> Places the markers of a wing that appears as a section in a two-dimensional flow: a strip whose width lies along y of the wing
!> frame.
!>
!> The section is the line in which the plane in the middle of the width cuts the strip. Stations on it are about a spacing h apart,
!> ends and folds included (fsi_marker_lines). A marker moves with the mean motion of the line across the strip through its station:
!> with N_i the linear functions of the triangles its weights are int N_i dl/int dl. The transpose of the weights converts a force
!> on the marker into forces on the points, those of a constant load along this line.
module fsi_marker_section
  use base_errors, only: require
  use base_kinds, only: rp
  use fsi_marker_lines, only: line_net_t, line_site_t, place_on_lines
  implicit none
  private
  public :: place_section_markers, station_t

  real(rp), parameter :: SAME = 1.0e-9_rp !< of the size of the strip; smaller lengths count as 0
  real(rp), parameter :: NEAR = 0.5_rp    !< of h, distance from the station up to which cuts belong to the line across the strip
  real(rp), parameter :: LEAST = 0.75_rp    !< of h: wanted least distance of markers, and largest gap
  integer, parameter :: N_SAMPLES = 16        !< places in a spacing where gaps are looked for

  !> A marker: sum_k weights(k) points(:, nodes(k)).
  type :: station_t
    integer, allocatable :: nodes(:)
    real(rp), allocatable :: weights(:) !< positive, of sum 1
    logical :: is_edge = .false.        !< an end of the section
  end type station_t

  !> Edges that a plane cuts. They form a linked list at their lower point: last(point), earlier(cut); high(cut) is the upper
  !> point.
  type :: cuts_t
    integer :: n = 0
    integer, allocatable :: last(:), earlier(:), high(:)
    real(rp), allocatable :: x(:, :) !< (3, :) L where, of the first n
  contains
    procedure :: init => cuts_init
    procedure :: find => cuts_find
  end type cuts_t

contains

  !> Finds the stations of a strip. `left_out` counts ends, folds and other sites that were left out because they are too close to
  !> others; `largest_gap` is in h. Deterministic. Allocates.
  subroutine place_section_markers(points, triangles, spacing, stations, left_out, largest_gap)
    real(rp), intent(in) :: points(:, :)   !< (3, n) L
    integer, intent(in) :: triangles(:, :) !< (3, m)
    real(rp), intent(in) :: spacing        !< h [L]
    type(station_t), allocatable, intent(out) :: stations(:)
    integer, intent(out) :: left_out(2)
    real(rp), intent(out) :: largest_gap
    type(line_site_t), allocatable :: wanted(:), fine(:), kept(:)
    real(rp), allocatable :: middle(:, :), x(:, :), gaps(:)
    type(line_net_t) :: net
    integer, allocatable :: links(:, :)
    logical, allocatable :: keep(:)
    real(rp) :: tolerance
    integer :: i, k
    tolerance = SAME*maxval(maxval(points, 2) - minval(points, 2))
    call cut_middle(points, triangles, tolerance, middle, links)
    call require(size(links, 2) > 0, 'place_section_markers: the sheet is no strip along y')
    call place_on_lines(middle, links, spacing, wanted)
    keep = are_clear(positions(middle, links, wanted), spacing)
    left_out = [count(wanted%is_corner .and. .not. keep), count(.not. (wanted%is_corner .or. keep))]
    kept = pack(wanted, keep)

    call place_on_lines(middle, links, spacing/N_SAMPLES, fine)
    x = positions(middle, links, fine)
    gaps = [(huge(1.0_rp), i=1, size(fine))]
    do i = 1, size(kept)
      call see(kept(i))
    end do
    do
      k = maxloc(anint(gaps/(SAME*spacing) + 0.3719_rp), 1) ! the first of equal ones, independently of round-off
      largest_gap = gaps(k)/spacing
      if (largest_gap < LEAST*(1 - SAME)) exit
      kept = [kept, fine(k)]
      call see(fine(k))
    end do

    call net%init(size(middle, 2), links)
    allocate (stations(size(kept)))
    do i = 1, size(kept)
      associate (ends => links(:, kept(i)%link))
        call cut_across(points, triangles, reshape(positions(middle, links, kept(i:i)), [3]), &
                        direction(middle, net, kept(i)), NEAR*spacing, tolerance, stations(i))
        k = ends(merge(1, 2, kept(i)%fraction < 0.5_rp))
        stations(i)%is_edge = kept(i)%is_corner .and. net%first(k + 1) - net%first(k) == 1
      end associate
    end do

  contains

    !> Updates the distances of all candidates from their nearest station by a new one.
    subroutine see(site)
      type(line_site_t), intent(in) :: site
      real(rp) :: here(3)
      integer :: j
      here = reshape(positions(middle, links, [site]), [3])
      do j = 1, size(gaps)
        gaps(j) = min(gaps(j), norm2(x(:, j) - here))
      end do
    end subroutine see
  end subroutine place_section_markers

  !> Tells which of x (3, n) are at least `LEAST` spacings from all earlier accepted ones.
  pure function are_clear(x, spacing)
    real(rp), intent(in) :: x(:, :), spacing
    logical :: are_clear(size(x, 2))
    integer :: i, k
    do i = 1, size(x, 2)
      are_clear(i) = .true.
      do k = 1, i - 1
        if (are_clear(k) .and. norm2(x(:, k) - x(:, i)) < LEAST*spacing*(1 - SAME)) are_clear(i) = .false.
      end do
    end do
  end function are_clear

  !> Finds the line in which the plane in the middle of the width cuts the triangles: points (3, n) and links (2, m).
  pure subroutine cut_middle(points, triangles, tolerance, middle, links)
    real(rp), intent(in) :: points(:, :), tolerance
    integer, intent(in) :: triangles(:, :)
    real(rp), allocatable, intent(out) :: middle(:, :)
    integer, allocatable, intent(out) :: links(:, :)
    type(cuts_t) :: cuts
    logical :: is_above(size(points, 2))
    real(rp) :: y
    integer :: pairs(2, size(triangles, 2)), i, k, m, e, one, other
    y = (minval(points(2, [triangles])) + maxval(points(2, [triangles])))/2
    is_above = points(2, :) > y - tolerance ! points in the plane too, also if round-off puts them below
    call cuts%init(size(points, 2), 3*size(triangles, 2))
    m = 0
    do i = 1, size(triangles, 2)
      if (all(is_above(triangles(:, i))) .or. .not. any(is_above(triangles(:, i)))) cycle
      m = m + 1
      pairs(:, m) = 0
      do k = 1, 3
        one = triangles(k, i)
        other = triangles(mod(k, 3) + 1, i)
        if (is_above(one) .eqv. is_above(other)) cycle
        if (is_above(one)) then
          call cuts%find(points, other, one, y, tolerance, e)
        else
          call cuts%find(points, one, other, y, tolerance, e)
        end if
        pairs(merge(1, 2, pairs(1, m) == 0), m) = e
      end do
    end do
    call unite_equal(cuts%x, tolerance, pairs(:, :m))
    links = pairs(:, pack([(i, i=1, m)], pairs(1, :m) /= pairs(2, :m)))
    middle = cuts%x(:, :cuts%n)
  end subroutine cut_middle

  !> Makes room for `most` cuts. No edge is cut yet.
  pure subroutine cuts_init(self, n_points, most)
    class(cuts_t), intent(inout) :: self
    integer, intent(in) :: n_points, most
    self%n = 0
    allocate (self%last(n_points), self%earlier(most), self%high(most), source=0)
    allocate (self%x(3, most), source=0.0_rp)
  end subroutine cuts_init

  !> Returns the number of the cut through the edge from point `below` the plane to point `above` it. The first call for an edge
  !> makes it.
  pure subroutine cuts_find(self, points, below, above, y, tolerance, number)
    class(cuts_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :), y, tolerance
    integer, intent(in) :: below, above
    integer, intent(out) :: number
    real(rp) :: t
    associate (low => min(below, above), high => max(below, above))
      number = self%last(low)
      do while (number > 0)
        if (self%high(number) == high) return
        number = self%earlier(number)
      end do
      self%n = self%n + 1
      number = self%n
      self%high(number) = high
      self%earlier(number) = self%last(low)
      self%last(low) = number
    end associate
    t = max(0.0_rp, min(1.0_rp, (y - points(2, below))/(points(2, above) - points(2, below))))
    if (points(2, above) < y + tolerance) t = 1
    self%x(:, number) = (1 - t)*points(:, below) + t*points(:, above)
  end subroutine cuts_find

  !> Finds edges that are cut in one common point, x (3, n): their pairs (2, m) of cuts are then equal.
  pure subroutine unite_equal(x, tolerance, pairs)
    real(rp), intent(in) :: x(:, :), tolerance
    integer, intent(inout) :: pairs(:, :)
    integer :: is(size(x, 2)), i, low, high
    is = [(i, i=1, size(is))]
    do i = 1, size(pairs, 2)
      if (norm2(x(:, pairs(1, i)) - x(:, pairs(2, i))) > tolerance) cycle
      low = minval(is(pairs(:, i)))
      high = maxval(is(pairs(:, i)))
      where (is == high) is = low
    end do
    do i = 1, size(pairs, 2)
      pairs(:, i) = is(pairs(:, i))
    end do
  end subroutine unite_equal

  !> Returns the places (3, n) on links.
  pure function positions(points, links, sites) result(x)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: links(:, :)
    type(line_site_t), intent(in) :: sites(:)
    real(rp) :: x(3, size(sites))
    integer :: i
    do i = 1, size(sites)
      associate (ends => links(:, sites(i)%link), t => sites(i)%fraction)
        x(:, i) = (1 - t)*points(:, ends(1)) + t*points(:, ends(2))
      end associate
    end do
  end function positions

  !> Returns the direction of the section at a place, of any length; at a fold it bisects the directions of both sides.
  pure function direction(points, net, site) result(along)
    real(rp), intent(in) :: points(:, :)
    type(line_net_t), intent(in) :: net
    type(line_site_t), intent(in) :: site
    real(rp) :: along(3), other(3)
    integer :: p, k
    associate (links => net%links, first => net%first, at => net%at)
      along = points(:, links(2, site%link)) - points(:, links(1, site%link))
      if (.not. site%is_corner) return
      p = links(merge(1, 2, site%fraction < 0.5_rp), site%link)
      if (first(p + 1) - first(p) /= 2) return
      k = merge(first(p) + 1, first(p), at(1, first(p)) == site%link)
      other = points(:, links(3 - at(2, k), at(1, k))) - points(:, p)
      other = other/norm2(other) - merge(1, -1, site%fraction < 0.5_rp)*along/norm2(along)
      if (norm2(other) > SAME) along = other ! not for a sheet that is folded back on itself
    end associate
  end function direction

  !> Averages along the line across the strip at x: over the nearby cuts by the plane normal to `along`.
  subroutine cut_across(points, triangles, x, along, near, tolerance, station)
    real(rp), intent(in) :: points(:, :), x(3), along(3), near, tolerance
    integer, intent(in) :: triangles(:, :)
    type(station_t), intent(out) :: station
    real(rp) :: normal(3), weights(size(points, 2), 2), total(2)
    integer :: i, side
    normal = [along(1), 0.0_rp, along(3)]
    normal = normal/norm2(normal)
    weights = 0
    ! The weights of an edge in the plane are those of the triangles beyond it or, at an end, of those before it.
    do side = 1, 2
      do i = 1, size(triangles, 2)
        call cut_triangle(points, triangles(:, i), x, normal, near, tolerance, side == 1, weights(:, side))
      end do
      total(side) = sum(weights(:, side))
    end do
    side = merge(1, 2, total(1) > total(2)/2)
    call require(total(side) > 0, 'place_section_markers: the sheet is no strip along y')
    station%nodes = pack([(i, i=1, size(points, 2))], weights(:, side) > 0)
    station%weights = weights(station%nodes, side)/total(side)
  end subroutine cut_across

  !> Adds length times mean linear functions of the cut of one triangle.
  pure subroutine cut_triangle(points, corners, x, normal, near, tolerance, beyond, weights)
    real(rp), intent(in) :: points(:, :), x(3), normal(3), near, tolerance
    integer, intent(in) :: corners(3)
    logical, intent(in) :: beyond !< corners in the plane count as before it, else as beyond
    real(rp), intent(inout) :: weights(:)
    real(rp) :: height(3), fraction(3, 2), ends(3, 2), distance(3), t
    logical :: is_before(3)
    integer :: k, j, n
    height = matmul(normal, points(:, corners) - spread(x, 2, 3))
    where (abs(height) < tolerance) height = 0
    if (beyond) then
      is_before = height <= 0
    else
      is_before = height < 0
    end if
    if (all(is_before) .or. .not. any(is_before)) return
    n = 0
    do k = 1, 3
      j = mod(k, 3) + 1
      if (is_before(k) .eqv. is_before(j)) cycle
      t = height(k)/(height(k) - height(j))
      n = n + 1
      fraction(:, n) = 0
      fraction(k, n) = 1 - t
      fraction(j, n) = t
      ends(:, n) = matmul(points(:, corners), fraction(:, n))
    end do
    distance = (ends(:, 1) + ends(:, 2))/2 - x
    if (hypot(distance(1), distance(3)) > near) return
    weights(corners) = weights(corners) + norm2(ends(:, 2) - ends(:, 1))*(fraction(:, 1) + fraction(:, 2))/2
  end subroutine cut_triangle
end module fsi_marker_section

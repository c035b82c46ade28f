! SPDX-License-Identifier: GPL-3.0-or-later
!> Distributes sites along lines, about a spacing apart: on the outline of a sheet, or on its section.
!>
!> Lines are made of links between points and may branch, touch, end or be closed. They are cut into arcs at their corners: the
!> points where they turn by more than TURN, and points that do not join exactly two links. Every corner is a site; an arc of length
!> l has floor(l/h + 1/2) equal intervals, at least one.
module fsi_marker_lines
  use base_kinds, only: i8, rp
  use base_sort, only: sorting_order
  implicit none
  private
  public :: line_net_t, line_site_t, place_on_lines

  ! These angles lie between those of regular polygons, so that round-off does not decide whether a corner exists.
  real(rp), parameter :: TURN = 35*acos(-1.0_rp)/180
  real(rp), parameter :: HALF = 0.5_rp - 1.0e-6_rp !< lengths of n + 1/2 spacings do not depend on round-off either
  integer(i8), parameter :: FINE = 2_i8**20        !< steps in which angles are compared

  !> A site on a link.
  type :: line_site_t
    integer :: link = 0
    real(rp) :: fraction = 0     !< of the way from the first to the second point of the link
    logical :: is_corner = .false.
  end type line_site_t

  !> Links with those at each point i: at(1, first(i)) .. at(1, first(i + 1) - 1); at(2, :) says which end i is.
  type :: line_net_t
    integer, allocatable :: links(:, :) !< (2, m) points
    integer, allocatable :: first(:), at(:, :)
  contains
    procedure :: init => net_init
  end type line_net_t

contains

  !> Returns sites on the lines of `links`: first the corners (ends and branches, then corners by decreasing angle), then the arcs.
  !> They do not depend on the position and attitude of the points, up to round-off. Allocates.
  subroutine place_on_lines(points, links, spacing, sites)
    real(rp), intent(in) :: points(:, :) !< (3, n) L
    integer, intent(in) :: links(:, :)   !< (2, m) points
    real(rp), intent(in) :: spacing      !< h [L]
    type(line_site_t), allocatable, intent(out) :: sites(:)
    type(line_net_t) :: net
    integer, allocatable :: corners(:), arc(:)
    real(rp), allocatable :: turns(:)
    logical, allocatable :: used(:)
    integer :: i, k, n, n_arc
    call net%init(size(points, 2), links)
    allocate (turns(size(points, 2)), used(size(links, 2)), arc(size(links, 2)))
    do i = 1, size(points, 2)
      turns(i) = turn_at(points, links, net%at(:, net%first(i):net%first(i + 1) - 1))
    end do
    corners = pack([(i, i=1, size(turns))], turns > TURN)
    corners = corners(sorting_order(-int(turns(corners)*FINE, i8)))
    n = size(corners)
    allocate (sites(n))
    do i = 1, n
      k = net%first(corners(i))
      sites(i) = line_site_t(net%at(1, k), real(net%at(2, k) - 1, rp), .true.)
    end do
    used = .false.
    do i = 1, n
      do k = net%first(corners(i)), net%first(corners(i) + 1) - 1
        if (used(net%at(1, k))) cycle
        call follow(net, turns, corners(i), net%at(1, k), used, arc, n_arc)
        call divide(points, links, arc(:n_arc), spacing, .false., sites)
      end do
    end do
    do i = 1, size(points, 2) ! the remaining lines are closed and have no corner
      do k = net%first(i), net%first(i + 1) - 1
        if (used(net%at(1, k))) cycle
        call follow(net, turns, i, net%at(1, k), used, arc, n_arc)
        call divide(points, links, arc(:n_arc), spacing, .true., sites)
      end do
    end do
  end subroutine place_on_lines

  !> Makes the net of these links between n_points points.
  pure subroutine net_init(self, n_points, links)
    class(line_net_t), intent(inout) :: self
    integer, intent(in) :: n_points, links(:, :)
    integer :: filled(n_points), i, k
    self%links = links
    allocate (self%first(n_points + 1), self%at(2, 2*size(links, 2)))
    filled = 0
    do i = 1, size(links, 2)
      do k = 1, 2
        filled(links(k, i)) = filled(links(k, i)) + 1
      end do
    end do
    self%first(1) = 1
    do i = 1, n_points
      self%first(i + 1) = self%first(i) + filled(i)
    end do
    filled = 0
    do i = 1, size(links, 2)
      do k = 1, 2
        self%at(:, self%first(links(k, i)) + filled(links(k, i))) = [i, k]
        filled(links(k, i)) = filled(links(k, i)) + 1
      end do
    end do
  end subroutine net_init

  !> Returns the angle by which the line turns at a point, given its links. It is larger than any angle at ends and branches, and
  !> smaller than any angle where there is no line.
  pure real(rp) function turn_at(points, links, at) result(turn)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: links(:, :), at(:, :)
    real(rp) :: way(3, 2), length(2)
    integer :: k
    turn = merge(-1.0_rp, 4.0_rp, size(at, 2) == 0)
    if (size(at, 2) /= 2) return
    do k = 1, 2
      way(:, k) = points(:, links(3 - at(2, k), at(1, k))) - points(:, links(at(2, k), at(1, k)))
      length(k) = norm2(way(:, k))
    end do
    turn = 0
    if (any(length <= 0)) return
    turn = acos(max(-1.0_rp, min(1.0_rp, -dot_product(way(:, 1)/length(1), way(:, 2)/length(2)))))
  end function turn_at

  !> Returns the arc that leaves point `start` by `link`, up to a corner or back to `start`: its links, negative where they are
  !> passed from the second to the first point.
  pure subroutine follow(net, turns, start, link, used, arc, n)
    type(line_net_t), intent(in) :: net
    integer, intent(in) :: start, link
    real(rp), intent(in) :: turns(:)
    logical, intent(inout) :: used(:)
    integer, intent(inout) :: arc(:)
    integer, intent(out) :: n
    integer :: point, next, k
    point = start
    next = link
    n = 0
    do
      n = n + 1
      used(next) = .true.
      associate (ends => net%links(:, next))
        arc(n) = merge(next, -next, ends(1) == point)
        point = merge(ends(2), ends(1), ends(1) == point)
      end associate
      if (turns(point) > TURN .or. point == start) exit
      k = net%first(point)
      if (used(net%at(1, k))) k = k + 1
      if (used(net%at(1, k))) exit
      next = net%at(1, k)
    end do
  end subroutine follow

  !> Appends the places inside an arc, and its first point if it is closed without a corner.
  subroutine divide(points, links, arc, spacing, is_closed, sites)
    real(rp), intent(in) :: points(:, :), spacing
    integer, intent(in) :: links(:, :), arc(:)
    logical, intent(in) :: is_closed
    type(line_site_t), allocatable, intent(inout) :: sites(:)
    type(line_site_t) :: found(ceiling(1 + length_of(points, links, arc)/spacing))
    real(rp) :: total, passed, length, fraction
    integer :: i, k, n, filled
    total = length_of(points, links, arc)
    n = max(1, floor(total/spacing + HALF))
    filled = 0
    passed = 0
    k = merge(0, 1, is_closed)
    do i = 1, size(arc)
      length = length_of(points, links, arc(i:i))
      do while (k < n)
        if (k*total/n > passed + length .and. i < size(arc)) exit
        fraction = 0
        if (length > 0) fraction = max(0.0_rp, min(1.0_rp, (k*total/n - passed)/length))
        if (arc(i) < 0) fraction = 1 - fraction
        filled = filled + 1
        found(filled) = line_site_t(abs(arc(i)), fraction, .false.)
        k = k + 1
      end do
      passed = passed + length
    end do
    sites = [sites, found(:filled)]
  end subroutine divide

  !> Returns the length of a chain of links.
  pure real(rp) function length_of(points, links, arc) result(length)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: links(:, :), arc(:)
    integer :: i
    length = 0
    do i = 1, size(arc)
      length = length + norm2(points(:, links(2, abs(arc(i)))) - points(:, links(1, abs(arc(i)))))
    end do
  end function length_of
end module fsi_marker_lines

! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the height of a deformed wing at fixed points (x, y), as a profilometer shows it, and its derivatives.
!>
!> Inside a triangle the height is the barycentric interpolation of its corners. Where triangles overlap, the highest one counts.
!> Beside the wing the height is that of the nearest point of its outline, so that it stays continuous while the outline moves
!> across the point. The triangles are drawn into the grid one after another, without a search: the cost is proportional to the
!> number of grid points that they cover.
module measurement_sampling
  use base_kinds, only: rp
  implicit none
  private
  public :: surface_sample_t, sample_surface, sampled_height, height_gradient, outline_edges

  real(rp), parameter :: TOLERANCE = 1.0e-9_rp !< of a barycentric weight, so that edges belong to both sides

  !> Holds the points of the wing between which each sample lies: its height is the sum of weight*z of the corners.
  type :: surface_sample_t
    integer, allocatable :: corner(:, :)    !< (3, n) points; outside the wing the ends of the nearest edge, the second end twice
    real(rp), allocatable :: weight(:, :)   !< (3, n)
    logical, allocatable :: is_beside(:)    !< (n) outside the wing
  contains
    procedure :: init => sample_init
  end type surface_sample_t

contains

  !> Makes room for n samples.
  subroutine sample_init(self, n)
    class(surface_sample_t), intent(out) :: self
    integer, intent(in) :: n
    allocate (self%corner(3, n), source=1)
    allocate (self%weight(3, n), source=0.0_rp)
    allocate (self%is_beside(n), source=.true.)
  end subroutine sample_init

  !> Returns the edges (2, k) that belong to one triangle only.
  function outline_edges(n_points, triangles) result(edges)
    integer, intent(in) :: n_points, triangles(:, :)
    integer, allocatable :: edges(:, :), from(:), next(:)
    logical, allocatable :: is_single(:)
    integer :: t, c, e, f
    ! Half-edge e = 3 (t - 1) + c from corner c of triangle t to the next; lists of the half-edges that start at a point.
    allocate (from(n_points), next(size(triangles)), source=0)
    allocate (is_single(size(triangles)), source=.true.)
    do t = 1, size(triangles, 2)
      do c = 1, 3
        e = 3*(t - 1) + c
        next(e) = from(triangles(c, t))
        from(triangles(c, t)) = e
      end do
    end do
    do t = 1, size(triangles, 2)
      do c = 1, 3
        e = 3*(t - 1) + c
        f = from(triangles(mod(c, 3) + 1, t))
        do while (f > 0)
          if (head(f) == triangles(c, t)) is_single(e) = .false.
          f = next(f)
        end do
      end do
    end do
    allocate (edges(2, count(is_single)))
    f = 0
    do e = 1, size(triangles)
      if (.not. is_single(e)) cycle
      f = f + 1
      edges(:, f) = [triangles(mod(e - 1, 3) + 1, (e - 1)/3 + 1), head(e)]
    end do

  contains

    pure integer function head(half_edge)
      integer, intent(in) :: half_edge
      head = triangles(mod(mod(half_edge - 1, 3) + 1, 3) + 1, (half_edge - 1)/3 + 1)
    end function head

  end function outline_edges

  !> Finds the points of the grid x(:), y(:), which increase, on the surface of `triangles` with corners at positions(3, :) [m].
  !> number(nx, ny) is the number of the sample at a grid point, or 0; node(2, n) is the grid point of each sample.
  pure subroutine sample_surface(positions, triangles, edges, x, y, number, node, sample)
    real(rp), intent(in) :: positions(:, :), x(:), y(:)
    integer, intent(in) :: triangles(:, :), edges(:, :), number(:, :), node(:, :)
    type(surface_sample_t), intent(inout) :: sample
    real(rp) :: w(3), area, site(2)
    integer :: t, i, j, k
    sample%is_beside = .true.
    do t = 1, size(triangles, 2)
      associate (a => positions(:, triangles(1, t)), b => positions(:, triangles(2, t)), &
                 c => positions(:, triangles(3, t)))
        area = twice_area(a, b, c)
        if (.not. abs(area) > 0) cycle
        do j = first_from(y, min(a(2), b(2), c(2))), size(y)
          if (y(j) > max(a(2), b(2), c(2))) exit
          do i = first_from(x, min(a(1), b(1), c(1))), size(x)
            if (x(i) > max(a(1), b(1), c(1))) exit
            k = number(i, j)
            if (k == 0) cycle
            site = [x(i), y(j)]
            w = [twice_area(site, b, c), twice_area(a, site, c), twice_area(a, b, site)]/area
            if (minval(w) < -TOLERANCE) cycle
            if (.not. sample%is_beside(k)) then
              if (.not. dot_product(w, [a(3), b(3), c(3)]) > sampled_height(positions, sample, k)) cycle
            end if
            sample%is_beside(k) = .false.
            sample%corner(:, k) = triangles(:, t)
            sample%weight(:, k) = w
          end do
        end do
      end associate
    end do
    do k = 1, size(node, 2)
      if (sample%is_beside(k)) call find_nearest_edge(positions, edges, [x(node(1, k)), y(node(2, k))], &
                                                      sample%corner(:, k), sample%weight(:, k))
    end do
  end subroutine sample_surface

  !> Returns the height [m] of sample k.
  pure real(rp) function sampled_height(positions, sample, k) result(height)
    real(rp), intent(in) :: positions(:, :)
    type(surface_sample_t), intent(in) :: sample
    integer, intent(in) :: k
    integer :: c
    height = 0
    do c = 1, 3
      height = height + sample%weight(c, k)*positions(3, sample%corner(c, k))
    end do
  end function sampled_height

  !> Returns gradient(3, 3), the derivatives of the height of sample k, which is at (x, y), with respect to the coordinates (first
  !> index) of its corners (second index). Where the surface slopes, sideways motion changes the height too.
  pure subroutine height_gradient(positions, sample, k, site, gradient)
    real(rp), intent(in) :: positions(:, :), site(2)
    type(surface_sample_t), intent(in) :: sample
    integer, intent(in) :: k
    real(rp), intent(out) :: gradient(3, 3)
    real(rp) :: slope(2), p(2), q(2), dz(2), e(2), d(2), rise, length
    integer :: c
    associate (a => positions(:, sample%corner(1, k)), b => positions(:, sample%corner(2, k)), &
               weight => sample%weight(:, k))
      if (.not. sample%is_beside(k)) then
        p = b(:2) - a(:2)
        q = positions(:2, sample%corner(3, k)) - a(:2)
        dz = [b(3), positions(3, sample%corner(3, k))] - a(3)
        slope = [dz(1)*q(2) - dz(2)*p(2), dz(2)*p(1) - dz(1)*q(1)]/(p(1)*q(2) - p(2)*q(1))
        do c = 1, 3
          gradient(:, c) = weight(c)*[-slope(1), -slope(2), 1.0_rp]
        end do
        return
      end if
      gradient = 0
      gradient(3, :) = weight
      if (.not. (weight(2) > 0 .and. weight(2) < 1)) return
      ! The foot of the perpendicular, s = (place - a).e/e.e, moves along the edge.
      e = b(:2) - a(:2)
      d = site - a(:2)
      length = dot_product(e, e)
      rise = b(3) - a(3)
      gradient(:2, 2) = rise*(d - 2*weight(2)*e)/length
      gradient(:2, 1) = -gradient(:2, 2) - rise*e/length
    end associate
  end subroutine height_gradient

  !> Finds the point on the edges that is nearest to `site` in the plane.
  pure subroutine find_nearest_edge(positions, edges, site, corner, weight)
    real(rp), intent(in) :: positions(:, :), site(2)
    integer, intent(in) :: edges(:, :)
    integer, intent(out) :: corner(3)
    real(rp), intent(out) :: weight(3)
    real(rp) :: e(2), d(2), s, distance, nearest, length
    integer :: k
    nearest = huge(nearest)
    corner = 1
    weight = [1.0_rp, 0.0_rp, 0.0_rp]
    do k = 1, size(edges, 2)
      e = positions(:2, edges(2, k)) - positions(:2, edges(1, k))
      d = site - positions(:2, edges(1, k))
      length = dot_product(e, e)
      s = 0
      if (length > 0) s = max(0.0_rp, min(1.0_rp, dot_product(d, e)/length))
      distance = sum((d - s*e)**2)
      if (.not. distance < nearest) cycle
      nearest = distance
      corner = [edges(1, k), edges(2, k), edges(2, k)]
      weight = [1 - s, s, 0.0_rp]
    end do
  end subroutine find_nearest_edge

  !> Returns the index of the first of increasing `values` that is not below `lowest`; one more than their number if all are below.
  pure integer function first_from(values, lowest) result(first)
    real(rp), intent(in) :: values(:), lowest
    integer :: last, middle
    first = 1
    last = size(values) + 1
    do while (first < last)
      middle = (first + last)/2
      if (values(middle) < lowest) then
        first = middle + 1
      else
        last = middle
      end if
    end do
  end function first_from

  !> Returns twice the area of a triangle in the plane, negative if its corners go clockwise.
  pure real(rp) function twice_area(a, b, c) result(area)
    real(rp), intent(in) :: a(:), b(:), c(:)
    area = (b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1))
  end function twice_area
end module measurement_sampling

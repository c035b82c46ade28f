! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes outlines of wings, in the wing frame: x from root to tip with the hinge at 0, y toward the leading edge.
!>
!> FLUSI gives the outline by R(theta) = a0/2 + sum_i a_i cos(i theta) + b_i sin(i theta) around (x0w, y0w) in its
!> own wing frame, where x_w is chordwise, y_w spanwise and theta = pi + atan2(y_w - y0w, x_w - x0w). Its x_w is
!> y here, its y_w is x.
module fsi_planform
  use base_constants, only: PI
  use base_errors, only: require
  use base_kinds, only: rp
  use fsi_fourier_outline, only: fourier_outline_t
  use fsi_wing_relief, only: wing_relief_t
  implicit none
  private
  public :: planform_t, fourier_planform, polygon_planform, curve_planform, rectangular_planform, elliptic_planform

  integer, parameter :: ROUND_POINTS = 1440 !< points of a round outline
  integer, parameter :: CURVE_POINTS = 16   !< points of a curve from one control point to the next

  !> A closed outline; lengths in code units. The last point is joined to the first.
  type :: planform_t
    real(rp), allocatable :: outline(:, :) !< (2, n) x, y
    type(fourier_outline_t) :: fourier     !< the Fourier outline, if it was given in this form and not stretched
    type(wing_relief_t) :: relief          !< of a wing with such an outline that is not flat or has no constant thickness
  contains
    procedure :: area => planform_area
    procedure :: span => planform_span
    procedure :: mean_chord => planform_mean_chord
    procedure :: rescale => planform_rescale
    procedure :: chord_at => planform_chord_at
    procedure :: is_single => planform_is_single
  end type planform_t

contains

  !> Returns FLUSI's Fourier outline as it is: FLUSI's unit is the wing length.
  pure function fourier_planform(a0, ai, bi, x0w, y0w) result(planform)
    real(rp), intent(in) :: a0, ai(:), bi(:) !< of the same size
    real(rp), intent(in) :: x0w, y0w         !< centre in FLUSI's wing frame: chordwise, spanwise
    type(planform_t) :: planform
    real(rp) :: theta, radius
    integer :: i, k
    planform%fourier = fourier_outline_t(a0, ai, bi, [x0w, y0w])
    allocate (planform%outline(2, ROUND_POINTS))
    do k = 1, ROUND_POINTS
      theta = 2*PI*(k - 1)/ROUND_POINTS
      radius = a0/2
      do i = 1, size(ai)
        radius = radius + ai(i)*cos(i*theta) + bi(i)*sin(i*theta)
      end do
      planform%outline(:, k) = [y0w + radius*sin(theta - PI), x0w + radius*cos(theta - PI)]
    end do
  end function fourier_planform

  !> Returns the polygon through `points`.
  pure function polygon_planform(points) result(planform)
    real(rp), intent(in) :: points(:, :) !< (2, n)
    type(planform_t) :: planform
    planform%outline = points
  end function polygon_planform

  !> Returns a smooth curve from the first of `points` through all others to the last, closed by a straight line. It is cubic
  !> between two points, with the tangents of parabolas through three (chord-length parameters).
  pure function curve_planform(points) result(planform)
    real(rp), intent(in) :: points(:, :) !< (2, n), n >= 3, no two neighbours equal
    type(planform_t) :: planform
    real(rp) :: s, before(2), after(2), h(size(points, 2) - 1), tangent(2, size(points, 2))
    integer :: i, k, n
    n = size(points, 2)
    do i = 1, n - 1
      h(i) = norm2(points(:, i + 1) - points(:, i))
    end do
    do i = 2, n - 1
      before = (points(:, i) - points(:, i - 1))/h(i - 1)
      after = (points(:, i + 1) - points(:, i))/h(i)
      tangent(:, i) = (before*h(i) + after*h(i - 1))/(h(i - 1) + h(i))
    end do
    tangent(:, 1) = (points(:, 2) - points(:, 1))/h(1)
    tangent(:, n) = (points(:, n) - points(:, n - 1))/h(n - 1)
    allocate (planform%outline(2, CURVE_POINTS*(n - 1) + 1))
    do i = 1, n - 1
      do k = 0, CURVE_POINTS - 1
        s = real(k, rp)/CURVE_POINTS
        planform%outline(:, CURVE_POINTS*(i - 1) + k + 1) = &
          (1 + 2*s)*(1 - s)**2*points(:, i) + s**2*(3 - 2*s)*points(:, i + 1) + &
          h(i)*(s*(1 - s)**2*tangent(:, i) - s**2*(1 - s)*tangent(:, i + 1))
      end do
    end do
    planform%outline(:, CURVE_POINTS*(n - 1) + 1) = points(:, n)
  end function curve_planform

  !> Returns a rectangle from x = root to x = tip; the part `front` of the chord lies before the x axis.
  pure function rectangular_planform(root, tip, chord, front) result(planform)
    real(rp), intent(in) :: root, tip, chord, front
    type(planform_t) :: planform
    planform%outline = reshape([root, (front - 1)*chord, tip, (front - 1)*chord, tip, front*chord, root, &
                                front*chord], [2, 4])
  end function rectangular_planform

  !> Returns an ellipse from x = root to x = tip of given mean chord; the part `front` of its largest chord lies before the x
  !> axis.
  pure function elliptic_planform(root, tip, mean_chord, front) result(planform)
    real(rp), intent(in) :: root, tip, mean_chord, front
    type(planform_t) :: planform
    real(rp) :: largest, theta
    integer :: k
    largest = 4*mean_chord/PI
    allocate (planform%outline(2, ROUND_POINTS))
    do k = 1, ROUND_POINTS
      theta = 2*PI*(k - 1)/ROUND_POINTS
      planform%outline(:, k) = [(root + tip)/2 + (tip - root)/2*cos(theta), &
                                (front - 0.5_rp)*largest + largest/2*sin(theta)]
    end do
  end function elliptic_planform

  !> Returns the area inside the outline, in the square of its unit.
  pure real(rp) function planform_area(self) result(area)
    class(planform_t), intent(in) :: self
    integer :: i, next
    area = 0
    do i = 1, size(self%outline, 2)
      next = mod(i, size(self%outline, 2)) + 1
      area = area + (self%outline(1, i)*self%outline(2, next) - self%outline(1, next)*self%outline(2, i))/2
    end do
    area = abs(area)
  end function planform_area

  !> Returns the smallest and the largest x.
  pure function planform_span(self) result(span)
    class(planform_t), intent(in) :: self
    real(rp) :: span(2)
    span = [minval(self%outline(1, :)), maxval(self%outline(1, :))]
  end function planform_span

  !> Returns the area divided by the extent in x.
  pure real(rp) function planform_mean_chord(self) result(chord)
    class(planform_t), intent(in) :: self
    real(rp) :: span(2)
    span = self%span()
    chord = self%area()/(span(2) - span(1))
  end function planform_mean_chord

  !> Scales the outline so that its largest x is `tip`, and then y alone so that the mean chord is `mean_chord`. A number <= 0
  !> changes nothing.
  subroutine planform_rescale(self, tip, mean_chord)
    class(planform_t), intent(inout) :: self
    real(rp), intent(in) :: tip, mean_chord
    if (tip > 0) self%relief = self%relief%scaled(tip/maxval(self%outline(1, :)))
    if (tip > 0 .and. allocated(self%fourier%ai)) self%fourier = self%fourier%scaled(tip/maxval(self%outline(1, :)))
    if (mean_chord > 0 .and. allocated(self%fourier%ai)) deallocate (self%fourier%ai) ! it does not fit the outline
    if (tip > 0) self%outline = self%outline*(tip/maxval(self%outline(1, :)))
    if (mean_chord > 0) self%outline(2, :) = self%outline(2, :)*(mean_chord/self%mean_chord())
  end subroutine planform_rescale

  !> Returns the trailing and the leading edge at x; at the ends of the span, the values just inside. `crossings` is the number of
  !> times that the outline crosses x, 2 for a simple outline. Outside of the span it is 0, and so are both edges.
  pure subroutine planform_chord_at(self, x, trailing, leading, crossings)
    class(planform_t), intent(in) :: self
    real(rp), intent(in) :: x
    real(rp), intent(out) :: trailing, leading
    integer, intent(out) :: crossings
    real(rp) :: span(2), inside, y
    integer :: i, next
    span = self%span()
    inside = 1.0e-9_rp*(span(2) - span(1))
    inside = min(span(2) - inside, max(span(1) + inside, x))
    trailing = huge(y)
    leading = -huge(y)
    crossings = 0
    do i = 1, size(self%outline, 2)
      next = mod(i, size(self%outline, 2)) + 1
      associate (p => self%outline(:, i), q => self%outline(:, next))
        if ((p(1) <= inside) .eqv. (q(1) <= inside)) cycle
        crossings = crossings + 1
        y = p(2) + (q(2) - p(2))*(inside - p(1))/(q(1) - p(1))
        trailing = min(trailing, y)
        leading = max(leading, y)
      end associate
    end do
    if (crossings == 0) then
      trailing = 0
      leading = 0
    end if
  end subroutine planform_chord_at

  !> Tells whether every x has one chord, checked at `n` positions; otherwise `where_not` is the first x that has not.
  logical function planform_is_single(self, n, where_not) result(is_single)
    class(planform_t), intent(in) :: self
    integer, intent(in) :: n
    real(rp), intent(out) :: where_not
    real(rp) :: span(2), trailing, leading
    integer :: i, crossings
    call require(n > 0, 'planform_t: look somewhere')
    span = self%span()
    is_single = span(2) > span(1)
    where_not = span(1)
    do i = 1, n
      if (.not. is_single) return
      where_not = span(1) + (span(2) - span(1))*(i - 0.5_rp)/n
      call self%chord_at(where_not, trailing, leading, crossings)
      is_single = crossings == 2
    end do
  end function planform_is_single
end module fsi_planform

! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures the shape of a bent wing on sections across its span: displacement of the trailing edge, twist, camber.
!>
!> A section is the line of material points that have the same x on the unloaded wing. With its ends L (leading
!> edge, largest y) and T (trailing edge), its chord c = L - T, and n = e_x cross c, where e_x is the axis of the
!> span of the wing frame:
!>
!>     trailing edge   displacement of T along z
!>     twist           angle from (c_y, c_z) of the unloaded wing to the present one, about e_x
!>     camber          (p - T).n/(|n| |c|) of the point p of the section where it is largest
!>
!> All three are positive toward the upper side of the wing; the twist is positive if the leading edge turns there. Wings that are
!> mirror images of each other therefore have the same values.
module fsi_wing_shape
  use base_kinds, only: rp
  implicit none
  private
  public :: wing_shape_t, section_t, SPAN

  real(rp), parameter :: SPAN(3) = [0.25_rp, 0.5_rp, 0.75_rp] !< usual sections, as fractions of the largest x

  !> Shape of one section. Lengths are in the unit of the points.
  type :: section_t
    real(rp) :: trailing = 0 !< displacement of the trailing edge
    real(rp) :: twist = 0    !< rad
    real(rp) :: camber = 0   !< of the chord
  end type section_t

  !> The points of one section: each divides an edge of the mesh.
  type :: line_t
    integer, allocatable :: edges(:, :)  !< (2, k) points of the mesh
    real(rp), allocatable :: weights(:)  !< (k) of the second of them
    integer :: leading = 0, trailing = 0 !< indices of both ends among the k points
  end type line_t

  type :: wing_shape_t
    private
    real(rp), allocatable :: points(:, :) !< (3, n) of the unloaded wing
    type(line_t), allocatable :: lines(:)
    real(rp) :: upper = 1                 !< direction of z to the upper side
  contains
    procedure :: init => shape_init
    procedure :: has => shape_has
    procedure :: measure => shape_measure
  end type wing_shape_t

contains

  !> Finds the sections of an unloaded wing at the parts `fractions` of its largest x.
  subroutine shape_init(self, points, triangles, fractions, upper)
    class(wing_shape_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :)   !< (3, n) in the wing frame
    integer, intent(in) :: triangles(:, :) !< (3, m)
    real(rp), intent(in) :: fractions(:)   !< between 0 and 1
    real(rp), intent(in) :: upper          !< +1 or -1: the direction of z to the upper side
    integer :: i
    self%points = points
    self%upper = upper
    if (allocated(self%lines)) deallocate (self%lines)
    allocate (self%lines(size(fractions)))
    do i = 1, size(fractions)
      call cut(points, triangles, fractions(i)*maxval(points(1, :)), self%lines(i))
    end do
  end subroutine shape_init

  !> Tells whether the wing has this section. It has none where its triangles do not reach.
  pure logical function shape_has(self, i) result(has)
    class(wing_shape_t), intent(in) :: self
    integer, intent(in) :: i
    has = size(self%lines(i)%weights) >= 2
  end function shape_has

  !> Finds where the edges of the mesh cross the plane at `x`.
  pure subroutine cut(points, triangles, x, line)
    real(rp), intent(in) :: points(:, :), x
    integer, intent(in) :: triangles(:, :)
    type(line_t), intent(out) :: line
    integer :: found(2, 3*size(triangles, 2)), i, k, a, b, n
    real(rp) :: weights(3*size(triangles, 2)), y(3*size(triangles, 2))
    n = 0
    do i = 1, size(triangles, 2)
      do k = 1, 3
        a = triangles(k, i)
        b = triangles(mod(k, 3) + 1, i)
        ! A point in the plane counts as outboard. Inner edges occur twice, with the same point, which has no effect on the result.
        if ((points(1, a) < x) .eqv. (points(1, b) < x)) cycle
        n = n + 1
        found(:, n) = [min(a, b), max(a, b)]
        weights(n) = (x - points(1, found(1, n)))/(points(1, found(2, n)) - points(1, found(1, n)))
        y(n) = (1 - weights(n))*points(2, found(1, n)) + weights(n)*points(2, found(2, n))
      end do
    end do
    line%edges = found(:, :n)
    line%weights = weights(:n)
    if (n == 0) return
    line%leading = maxloc(y(:n), 1)
    line%trailing = minloc(y(:n), 1)
  end subroutine cut

  !> Measures the sections of the wing displaced by `u` (3, n) [L] in its frame, in the order of `fractions`; they are 0 where it
  !> has none.
  pure subroutine shape_measure(self, u, sections)
    class(wing_shape_t), intent(in) :: self
    real(rp), intent(in) :: u(:, :)
    type(section_t), intent(out) :: sections(:)
    real(rp) :: moved(3, 2), chord(3), before(3), normal(3), height, largest
    integer :: i, k
    do i = 1, size(sections)
      if (.not. self%has(i)) cycle
      associate (line => self%lines(i))
        moved(:, 1) = at(line, line%trailing, u)
        moved(:, 2) = at(line, line%leading, u)
        before = at(line, line%leading, self%points) - at(line, line%trailing, self%points)
        chord = before + moved(:, 2) - moved(:, 1)
        normal = [0.0_rp, -chord(3), chord(2)]
        largest = 0
        do k = 1, size(line%weights)
          height = dot_product(at(line, k, self%points) - at(line, line%trailing, self%points) + at(line, k, u) - &
                               moved(:, 1), normal)
          if (abs(height) > abs(largest)) largest = height
        end do
        sections(i)%trailing = self%upper*moved(3, 1)
        sections(i)%twist = self%upper*atan2(before(2)*chord(3) - before(3)*chord(2), &
                                             before(2)*chord(2) + before(3)*chord(3))
        sections(i)%camber = self%upper*largest/(norm2(normal)*norm2(chord))
      end associate
    end do
  end subroutine shape_measure

  !> Interpolates vectors `x` (3, n) of the points to the k-th point of a section.
  pure function at(line, k, x) result(value)
    type(line_t), intent(in) :: line
    integer, intent(in) :: k
    real(rp), intent(in) :: x(:, :)
    real(rp) :: value(3)
    value = (1 - line%weights(k))*x(:, line%edges(1, k)) + line%weights(k)*x(:, line%edges(2, k))
  end function at
end module fsi_wing_shape

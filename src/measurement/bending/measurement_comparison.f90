! SPDX-License-Identifier: GPL-3.0-or-later
!> Compares a wing of a given shape with what was measured under one load, and differentiates the difference.
!>
!> Heights: the deformation (loaded minus unloaded height) at the grid points on the unloaded wing where both heights are known.
!> These points do not depend on the shape. The scalar observations of the load follow them.
module measurement_comparison
  use base_kinds, only: rp
  use measurement_data, only: measurement_t, QUANTITY_ROTATION
  use measurement_material_point, only: find_material_point, material_point_t
  use measurement_sampling, only: height_gradient, sample_surface, sampled_height, surface_sample_t
  use solid_vectors, only: cross
  use solid_wing, only: wing_t
  implicit none
  private
  public :: comparison_t, observed_shape_t

  !> Describes a scalar observation on the wing.
  type :: gauge_t
    logical :: is_rotation = .false.
    type(material_point_t) :: site
    integer :: nodes(2) = 1        !< ends of the line whose rotation is measured
    real(rp) :: line(3) = 0        !< [m] the unloaded line
    real(rp) :: axis(3) = 0
    integer :: zero = 0
  end type gauge_t

  !> Holds a shape of the wing, its image in the instrument, and the measured points on that image. Nothing is allocated after
  !> `init`.
  type :: observed_shape_t
    real(rp), allocatable :: positions(:, :) !< (3, n_points) [m] of the points of the wing
    real(rp), allocatable :: seen(:, :)      !< (3, n_points) [m] where the instrument sees them
    type(surface_sample_t) :: sample         !< of `seen`, at the measured points of one load
  contains
    procedure :: init => shape_init
  end type observed_shape_t

  !> Holds all values measured under one load. They do not change.
  type :: comparison_t
    integer :: n = 0                          !< number of heights and scalar observations
    integer :: n_heights = 0
    integer, allocatable :: number(:, :)      !< (nx, ny) of the height at a grid point, 0: none
    integer, allocatable :: node(:, :)        !< (2, n_heights) its grid point
    real(rp), allocatable :: unloaded(:)      !< (n_heights) [m] of the wing at rest
    real(rp), allocatable :: measured(:)      !< (n) deformation [m], then values [m] or [rad]
    real(rp), allocatable :: sigma(:)         !< (n) their sd
    type(gauge_t), allocatable :: gauges(:)
  contains
    procedure :: init => comparison_init
    procedure :: locate => comparison_locate
    procedure :: heights => comparison_heights
    procedure :: height_slopes => comparison_height_slopes
    procedure :: residuals => comparison_residuals
    procedure :: derivatives => comparison_derivatives
  end type comparison_t

contains

  !> Makes room for n_points points and at most n_places measured points. The points of the wing are at the origin.
  subroutine shape_init(self, n_points, n_places)
    class(observed_shape_t), intent(out) :: self
    integer, intent(in) :: n_points, n_places
    allocate (self%positions(3, n_points), self%seen(3, n_points), source=0.0_rp)
    call self%sample%init(n_places)
  end subroutine shape_init

  !> Takes load number `l` of a checked measurement of `wing`, whose outline is edges(2, :) and whose length is `length` [m].
  subroutine comparison_init(self, m, l, wing, edges, length)
    class(comparison_t), intent(out) :: self
    type(measurement_t), intent(in) :: m
    integer, intent(in) :: l, edges(:, :)
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: length
    type(surface_sample_t) :: sample
    integer :: i, k, n_gauges
    n_gauges = count(m%observations%load == l)
    allocate (self%number(size(m%x), size(m%y)), source=0)
    associate (load => m%loads(l))
      do k = 1, load%count()
        self%number(load%node(1, k), load%node(2, k)) = k
      end do
      call sample%init(load%count())
      call sample_surface(wing%points, wing%triangles, edges, m%x, m%y, self%number, load%node, sample)
      self%n_heights = count(.not. sample%is_beside)
      self%n = self%n_heights + n_gauges
      allocate (self%node(2, self%n_heights), self%unloaded(self%n_heights), self%measured(self%n), &
                self%sigma(self%n), self%gauges(n_gauges))
      i = 0
      self%number = 0
      do k = 1, load%count()
        if (sample%is_beside(k)) cycle
        i = i + 1
        self%node(:, i) = load%node(:, k)
        self%number(load%node(1, k), load%node(2, k)) = i
        self%unloaded(i) = sampled_height(wing%points, sample, k)
        self%measured(i) = m%deformation(l, k)
        self%sigma(i) = m%deformation_sigma(l, k)
      end do
    end associate
    k = 0
    do i = 1, size(m%observations)
      associate (observation => m%observations(i))
        if (observation%load /= l) cycle
        k = k + 1
        self%gauges(k)%is_rotation = observation%quantity == QUANTITY_ROTATION
        self%gauges(k)%axis = observation%axis
        self%gauges(k)%zero = observation%zero
        self%gauges(k)%site = find_material_point(wing%points, wing%triangles, length, observation%point)
        if (self%gauges(k)%is_rotation) call choose_line(wing, self%gauges(k))
        self%measured(self%n_heights + k) = observation%value
        self%sigma(self%n_heights + k) = observation%sigma
      end associate
    end do
  end subroutine comparison_init

  !> Chooses the line that shows a rotation: the edge of the triangle that lies most across the axis or, in a structure of veins,
  !> the chord from the point before to the point behind.
  subroutine choose_line(wing, gauge)
    type(wing_t), intent(in) :: wing
    type(gauge_t), intent(inout) :: gauge
    real(rp) :: line(3), across, most
    integer :: c, v, k, a, b
    most = -1
    if (gauge%site%is_in_triangle) then
      do c = 1, 3
        call offer(gauge%site%corner(c), gauge%site%corner(mod(c, 3) + 1))
      end do
    else
      do v = 1, size(wing%veins)
        associate (nodes => wing%veins(v)%nodes)
          do k = 1, size(nodes)
            if (nodes(k) /= gauge%site%corner(1)) cycle
            a = nodes(max(1, k - 1))
            b = nodes(min(size(nodes), k + 1))
            call offer(a, b)
          end do
        end associate
      end do
    end if

  contains

    !> Takes the line between two points if it lies more across the axis than all earlier lines.
    subroutine offer(from, to)
      integer, intent(in) :: from, to
      line = wing%points(:, to) - wing%points(:, from)
      across = norm2(cross(gauge%axis, line))
      if (.not. across > most) return
      most = across
      gauge%nodes = [from, to]
      gauge%line = line
    end subroutine offer

  end subroutine choose_line

  !> Finds the measured points of this load on the image of `shape`, on the grid x(:), y(:) [m] of the measurement. The wing has
  !> these `triangles` and the outline edges(2, :). `shape` has room for at least n_heights measured points.
  pure subroutine comparison_locate(self, x, y, triangles, edges, shape)
    class(comparison_t), intent(in) :: self
    real(rp), intent(in) :: x(:), y(:)
    integer, intent(in) :: triangles(:, :), edges(:, :)
    type(observed_shape_t), intent(inout) :: shape
    if (self%n_heights > 0) &
      call sample_surface(shape%seen, triangles, edges, x, y, self%number, self%node, shape%sample)
  end subroutine comparison_locate

  !> Returns the heights(n_heights) [m] of the image of `shape` at the measured points of this load, after `locate`.
  pure subroutine comparison_heights(self, shape, heights)
    class(comparison_t), intent(in) :: self
    type(observed_shape_t), intent(in) :: shape
    real(rp), intent(out) :: heights(:)
    integer :: k
    do k = 1, self%n_heights
      heights(k) = sampled_height(shape%seen, shape%sample, k)
    end do
  end subroutine comparison_heights

  !> Returns slopes(n_heights), the change of the heights if the points of the image move by motion(3, n_points), after `locate`.
  pure subroutine comparison_height_slopes(self, x, y, shape, motion, slopes)
    class(comparison_t), intent(in) :: self
    real(rp), intent(in) :: x(:), y(:), motion(:, :)
    type(observed_shape_t), intent(in) :: shape
    real(rp), intent(out) :: slopes(:)
    real(rp) :: gradient(3, 3)
    integer :: k, c
    do k = 1, self%n_heights
      call height_gradient(shape%seen, shape%sample, k, [x(self%node(1, k)), y(self%node(2, k))], gradient)
      slopes(k) = 0
      do c = 1, 3
        slopes(k) = slopes(k) + dot_product(gradient(:, c), motion(:, shape%sample%corner(c, k)))
      end do
    end do
  end subroutine comparison_height_slopes

  !> Returns residuals(n), computed minus measured, after `locate`. The computed heights are those of the image of `shape` minus the
  !> heights rest(n_heights) [m] without the load. The computed scalar observations follow from the positions of `shape`, from
  !> points(3, n_points) [m] of the wing file and from the unknown offsets zeros(:). Displacements are multiplied by `factor`.
  pure subroutine comparison_residuals(self, points, shape, rest, factor, zeros, residuals)
    class(comparison_t), intent(in) :: self
    real(rp), intent(in) :: points(:, :), rest(:), factor, zeros(:)
    type(observed_shape_t), intent(in) :: shape
    real(rp), intent(out) :: residuals(:)
    real(rp) :: shown
    integer :: k, c
    call self%heights(shape, residuals)
    do k = 1, self%n_heights
      residuals(k) = factor*(residuals(k) - rest(k)) - self%measured(k)
    end do
    do k = 1, size(self%gauges)
      associate (gauge => self%gauges(k), positions => shape%positions)
        shown = 0
        if (gauge%is_rotation) then
          shown = rotation_angle(gauge, positions(:, gauge%nodes(2)) - positions(:, gauge%nodes(1)))
        else
          do c = 1, 3
            shown = shown + gauge%site%weight(c)*dot_product(gauge%axis, positions(:, gauge%site%corner(c)) - &
                                                              points(:, gauge%site%corner(c)))
          end do
        end if
        shown = factor*shown
        if (gauge%zero > 0) shown = shown + zeros(gauge%zero)
        residuals(self%n_heights + k) = shown - self%measured(self%n_heights + k)
      end associate
    end do
  end subroutine comparison_residuals

  !> Returns derivatives(n), the change of the residuals if the positions of `shape` move by motion(3, n_points) and their image by
  !> seen_motion(3, n_points), after `residuals` with the same shape. It leaves out the change of the wing without load.
  pure subroutine comparison_derivatives(self, x, y, shape, motion, seen_motion, derivatives)
    class(comparison_t), intent(in) :: self
    real(rp), intent(in) :: x(:), y(:), motion(:, :), seen_motion(:, :)
    type(observed_shape_t), intent(in) :: shape
    real(rp), intent(out) :: derivatives(:)
    real(rp) :: d(3)
    integer :: k, c
    call self%height_slopes(x, y, shape, seen_motion, derivatives)
    do k = 1, size(self%gauges)
      associate (gauge => self%gauges(k), derivative => derivatives(self%n_heights + k), positions => shape%positions)
        derivative = 0
        if (gauge%is_rotation) then
          d = positions(:, gauge%nodes(2)) - positions(:, gauge%nodes(1))
          d = d - dot_product(d, gauge%axis)*gauge%axis
          derivative = dot_product(cross(gauge%axis, d), motion(:, gauge%nodes(2)) - motion(:, gauge%nodes(1)))/ &
                       dot_product(d, d)
        else
          do c = 1, 3
            derivative = derivative + gauge%site%weight(c)*dot_product(gauge%axis, motion(:, gauge%site%corner(c)))
          end do
        end if
      end associate
    end do
  end subroutine comparison_derivatives

  !> Returns the angle [rad] by which the line has turned about the axis.
  pure real(rp) function rotation_angle(gauge, line)
    type(gauge_t), intent(in) :: gauge
    real(rp), intent(in) :: line(3)
    real(rp) :: before(3)
    before = gauge%line - dot_product(gauge%line, gauge%axis)*gauge%axis
    rotation_angle = atan2(dot_product(gauge%axis, cross(before, line)), dot_product(before, line))
  end function rotation_angle
end module measurement_comparison

! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines simple solids from which bodies are made: sphere, ellipsoids, rod, body of revolution, plate, disk.
!>
!> If FLUSI draws a part by the distance within a section instead of the distance from the surface, this module does the same, so
!> that the masks agree.
module fsi_body_parts
  use base_kinds, only: rp
  use fsi_solid_shape, only: level_shape_t
  implicit none
  private
  public :: make_sphere, make_ellipsoid, make_spindle, make_rod, make_revolution, make_plate, make_disk, make_barrel

  type, extends(level_shape_t) :: sphere_t
    real(rp) :: centre(3) = 0, radius = 0
  contains
    procedure :: level_at => sphere_level
  end type sphere_t

  !> Ellipsoid with its axes along the frame. The level is the distance from the surface, with an error of O(level^2/radius).
  type, extends(level_shape_t) :: ellipsoid_t
    real(rp) :: centre(3) = 0, half_axes(3) = 0
  contains
    procedure :: level_at => ellipsoid_level
  end type ellipsoid_t

  !> FLUSI's ellipsoid of revolution. In each section normal to its axis the level is the distance from the circle of this section.
  !> The body ends sharply at the ends of its axis. `tilt` turns it about y.
  type, extends(level_shape_t) :: spindle_t
    real(rp) :: centre(3) = 0
    real(rp) :: half_length = 0, radius = 0
    integer :: axis = 1
    real(rp) :: squeeze = 1 !< of y: a section is the ellipse (squeeze y)^2 + z^2 = R^2
    real(rp) :: tilt(2) = [1, 0] !< cosine and sine
  contains
    procedure :: level_at => spindle_level
  end type spindle_t

  !> A round rod with spheres at its ends, as FLUSI draws it. Between the ends it is cut off by the sphere around its middle that
  !> passes through the ends.
  type, extends(level_shape_t) :: rod_t
    real(rp) :: from(3) = 0, upto(3) = 0, radius = 0
  contains
    procedure :: level_at => rod_level
  end type rod_t

  !> Body of revolution about x, whose meridian is the polygon through profile(2, n), positions along x and radii. The level is the
  !> distance from its surface.
  type, extends(level_shape_t) :: revolution_t
    real(rp), allocatable :: profile(:, :)
  contains
    procedure :: level_at => revolution_level
  end type revolution_t

  !> Rectangular plate; the level is the largest of the distances from its sides.
  type, extends(level_shape_t) :: plate_t
    real(rp) :: half(3) = 0
  contains
    procedure :: level_at => plate_level
  end type plate_t

  !> Disk with its axis along z; the level is the larger of the distances from rim and faces.
  type, extends(level_shape_t) :: disk_t
    real(rp) :: radius = 0, half_thickness = 0
  contains
    procedure :: level_at => disk_level
  end type disk_t

  !> Cylinder along x that ends sharply at x = +- half_length.
  type, extends(level_shape_t) :: barrel_t
    real(rp) :: half_length = 0, radius = 0
  contains
    procedure :: level_at => barrel_level
  end type barrel_t

contains

  !> Returns the sphere with this centre and radius [L].
  pure type(sphere_t) function make_sphere(centre, radius) result(shape)
    real(rp), intent(in) :: centre(3), radius
    shape%centre = centre
    shape%radius = radius
    shape%low = centre - radius
    shape%high = centre + radius
  end function make_sphere

  !> Returns the signed distance [L] of x from the surface, negative inside.
  pure real(rp) function sphere_level(self, x) result(level)
    class(sphere_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    level = norm2(x - self%centre) - self%radius
  end function sphere_level

  !> Returns the ellipsoid with this centre and these half axes [L], along the frame.
  pure type(ellipsoid_t) function make_ellipsoid(centre, half_axes) result(shape)
    real(rp), intent(in) :: centre(3), half_axes(3)
    shape%centre = centre
    shape%half_axes = half_axes
    shape%low = centre - half_axes
    shape%high = centre + half_axes
  end function make_ellipsoid

  !> Returns the signed distance [L] of x from the surface to first order: F (F - 1)/|grad F| with F = |x/a|.
  pure real(rp) function ellipsoid_level(self, x) result(level)
    class(ellipsoid_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    real(rp) :: scaled(3), k, slope
    scaled = (x - self%centre)/self%half_axes
    k = norm2(scaled)
    slope = norm2(scaled/self%half_axes)
    if (k*minval(self%half_axes) <= 0.1_rp*minval(self%half_axes)) then
      level = -0.9_rp*minval(self%half_axes) ! the gradient vanishes in the middle
    else
      level = k*(k - 1)/slope
    end if
  end function ellipsoid_level

  !> Returns FLUSI's ellipsoid of revolution about x, or about z if `axis` is 3, with these lengths [L]; see `spindle_t`.
  pure type(spindle_t) function make_spindle(centre, half_length, radius, axis, squeeze, tilt) result(shape)
    real(rp), intent(in) :: centre(3), half_length, radius
    integer, intent(in), optional :: axis
    real(rp), intent(in), optional :: squeeze
    real(rp), intent(in), optional :: tilt !< rad
    real(rp) :: reach(3)
    shape%centre = centre
    shape%half_length = half_length
    shape%radius = radius
    if (present(axis)) shape%axis = axis
    if (present(squeeze)) shape%squeeze = squeeze
    if (present(tilt)) shape%tilt = [cos(tilt), sin(tilt)]
    reach = radius
    reach(shape%axis) = half_length
    if (present(tilt)) reach = max(half_length, radius)
    reach(2) = radius/min(1.0_rp, shape%squeeze)
    shape%low = centre - reach
    shape%high = centre + reach
  end function make_spindle

  !> Returns the signed distance [L] of x from the circle in its section, negative inside; huge beyond the ends of the axis.
  pure real(rp) function spindle_level(self, x) result(level)
    class(spindle_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    real(rp) :: p(3), along, across
    p = x - self%centre
    p = [self%tilt(1)*p(1) - self%tilt(2)*p(3), p(2), self%tilt(2)*p(1) + self%tilt(1)*p(3)]
    level = huge(level)
    if (self%axis == 3) then
      along = p(3)
      across = norm2(p(1:2))
    else
      along = p(1)
      across = sqrt((self%squeeze*p(2))**2 + p(3)**2)
    end if
    if ((along/self%half_length)**2 > 1) return
    level = across - self%radius*sqrt(1 - (along/self%half_length)**2)
  end function spindle_level

  !> Returns the round rod of this radius between two places [L].
  pure type(rod_t) function make_rod(from, upto, radius) result(shape)
    real(rp), intent(in) :: from(3), upto(3), radius
    shape%from = from
    shape%upto = upto
    shape%radius = radius
    shape%low = min(from, upto) - radius
    shape%high = max(from, upto) + radius
  end function make_rod

  !> Returns the signed distance [L] of x from the surface as FLUSI draws it, negative inside.
  pure real(rp) function rod_level(self, x) result(level)
    class(rod_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    real(rp) :: axis(3), arm(3), length2
    axis = self%upto - self%from
    length2 = sum(axis**2)
    level = min(norm2(x - self%from), norm2(x - self%upto)) - self%radius
    if (sum((x - (self%from + self%upto)/2)**2) < length2/4) then
      arm = x - self%from
      level = min(level, sqrt(max(0.0_rp, sum(arm**2) - dot_product(arm, axis)**2/length2)) - self%radius)
    end if
  end function rod_level

  !> Returns the body of revolution of profile(2, n): places along x and radii [L].
  pure type(revolution_t) function make_revolution(profile) result(shape)
    real(rp), intent(in) :: profile(:, :) !< (2, n) x ascending and radius >= 0
    real(rp) :: reach
    shape%profile = profile
    reach = maxval(profile(2, :))
    shape%low = [profile(1, 1), -reach, -reach]
    shape%high = [profile(1, size(profile, 2)), reach, reach]
  end function make_revolution

  !> Returns the signed distance [L] of x from the surface. In the half plane (x, r) the nearest piece of the polygon counts,
  !> which is closed to the axis at both ends; inside is below the polygon.
  pure real(rp) function revolution_level(self, x) result(level)
    class(revolution_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    real(rp) :: p(2), nearest, s
    integer :: i, n
    logical :: is_inside
    p = [x(1), hypot(x(2), x(3))]
    n = size(self%profile, 2)
    nearest = min(from_piece(p, [self%profile(1, 1), 0.0_rp], self%profile(:, 1)), &
                  from_piece(p, self%profile(:, n), [self%profile(1, n), 0.0_rp]))
    is_inside = .false.
    do i = 1, n - 1
      associate (a => self%profile(:, i), b => self%profile(:, i + 1))
        nearest = min(nearest, from_piece(p, a, b))
        if (p(1) < a(1) .or. p(1) >= b(1)) cycle
        s = (p(1) - a(1))/(b(1) - a(1))
        is_inside = p(2) < a(2) + s*(b(2) - a(2))
      end associate
    end do
    level = merge(-nearest, nearest, is_inside)
  end function revolution_level

  !> Returns the distance of p from the straight piece a b.
  pure real(rp) function from_piece(p, a, b) result(distance)
    real(rp), intent(in) :: p(2), a(2), b(2)
    real(rp) :: s
    s = 0
    if (norm2(b - a) > 0) s = min(1.0_rp, max(0.0_rp, dot_product(p - a, b - a)/sum((b - a)**2)))
    distance = norm2(p - a - s*(b - a))
  end function from_piece

  !> Returns the rectangular plate about the origin with these half lengths [L].
  pure type(plate_t) function make_plate(half) result(shape)
    real(rp), intent(in) :: half(3)
    shape%half = half
    shape%low = -half
    shape%high = half
  end function make_plate

  !> Returns the largest of the signed distances [L] of x from the sides, negative inside.
  pure real(rp) function plate_level(self, x) result(level)
    class(plate_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    level = maxval(abs(x) - self%half)
  end function plate_level

  !> Returns the disk about the origin with this radius and half thickness [L].
  pure type(disk_t) function make_disk(radius, half_thickness) result(shape)
    real(rp), intent(in) :: radius, half_thickness
    shape%radius = radius
    shape%half_thickness = half_thickness
    shape%high = [radius, radius, half_thickness]
    shape%low = -shape%high
  end function make_disk

  !> Returns the larger of the signed distances [L] of x from rim and faces, negative inside.
  pure real(rp) function disk_level(self, x) result(level)
    class(disk_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    level = max(abs(x(3)) - self%half_thickness, norm2(x(1:2)) - self%radius)
  end function disk_level

  !> Returns the cylinder along x about the origin with this half length and radius [L].
  pure type(barrel_t) function make_barrel(half_length, radius) result(shape)
    real(rp), intent(in) :: half_length, radius
    shape%half_length = half_length
    shape%radius = radius
    shape%high = [half_length, radius, radius]
    shape%low = -shape%high
  end function make_barrel

  !> Returns the signed distance [L] of x from the side of the cylinder, negative inside; huge beyond its ends.
  pure real(rp) function barrel_level(self, x) result(level)
    class(barrel_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    level = huge(level)
    if (abs(x(1)) <= self%half_length) level = norm2(x(2:3)) - self%radius
  end function barrel_level
end module fsi_body_parts

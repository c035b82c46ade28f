! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the plane in which a wing lies unloaded. The bending of the membrane and the rest angles of the veins are those of a flat
!> wing: a membrane must lie in its plane to 1e-6 of its size, and veins may bend out of it by 1e-6 rad.
module solid_flatness
  use base_kinds, only: rp
  use solid_junctions, only: hinge_plan_t
  use solid_vectors, only: cross
  use solid_wing, only: wing_t
  implicit none
  private
  public :: find_flatness

contains

  !> Returns the unit normal of the reference plane: that of the summed area vectors of the triangles, or the given one of a
  !> structure of veins. `raised` is the point of the membrane farthest from its plane, or 0 if the membrane is flat. `bent` is the
  !> point at which veins bend most out of the plane, or 0 if they bend by less than the limit.
  pure subroutine find_flatness(wing, plans, normal, raised, bent)
    type(wing_t), intent(in) :: wing
    type(hinge_plan_t), intent(in) :: plans(:)
    real(rp), intent(out) :: normal(3)
    integer, intent(out) :: raised, bent
    raised = 0
    normal = wing%plane_normal/norm2(wing%plane_normal)
    if (size(wing%triangles, 2) > 0) call fit_membrane(wing, normal, raised)
    bent = bent_point(wing, plans, normal)
  end subroutine find_flatness

  !> Returns the mean normal of the membrane, and a point that is off the plane, 0 if it is flat.
  pure subroutine fit_membrane(wing, normal, raised)
    type(wing_t), intent(in) :: wing
    real(rp), intent(out) :: normal(3)
    integer, intent(out) :: raised
    real(rp), parameter :: FLAT = 1.0e-6_rp
    real(rp) :: extent
    integer :: t, i
    normal = 0
    extent = 0
    raised = 0
    associate (x => wing%points, tri => wing%triangles)
      do t = 1, size(tri, 2)
        normal = normal + area_vector(wing, t)
        extent = max(extent, norm2(x(:, tri(1, t)) - x(:, tri(1, 1))))
      end do
      normal = normal/norm2(normal)
      do t = 1, size(tri, 2)
        do i = 1, 3
          if (abs(dot_product(normal, x(:, tri(i, t)) - x(:, tri(1, 1)))) <= FLAT*extent) cycle
          raised = outlier(wing, FLAT*extent)
          return
        end do
      end do
    end associate
  end subroutine fit_membrane

  !> Returns twice the area of triangle t [m^2] times its unit normal.
  pure function area_vector(wing, t) result(a)
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: t
    real(rp) :: a(3)
    associate (c => wing%triangles(:, t))
      a = cross(wing%points(:, c(2)) - wing%points(:, c(1)), wing%points(:, c(3)) - wing%points(:, c(1)))
    end associate
  end function area_vector

  !> Finds, among a few hundred triangles, the triangle whose plane contains most points, and returns the point of the membrane
  !> farthest from this plane. Unlike the plane of the summed area vectors, this plane is not tilted by a single wrong point.
  pure integer function outlier(wing, tolerance) result(point)
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: tolerance !< [m] for a point in a plane
    integer, parameter :: MOST = 300  ! triangles that are tried
    real(rp) :: heights(size(wing%points, 2)), normal(3)
    logical :: is_in_membrane(size(wing%points, 2))
    integer :: t, m, n_in, best
    m = size(wing%triangles, 2)
    is_in_membrane = .false.
    do t = 1, m
      is_in_membrane(wing%triangles(:, t)) = .true.
    end do
    best = -1
    point = 0
    do t = 1, m, (m + MOST - 1)/MOST
      normal = area_vector(wing, t)
      normal = normal/norm2(normal)
      heights = matmul(normal, wing%points)
      heights = abs(heights - heights(wing%triangles(1, t)))
      n_in = count(heights <= tolerance .and. is_in_membrane)
      if (n_in <= best) cycle
      best = n_in
      point = maxloc(heights, 1, is_in_membrane)
    end do
  end function outlier

  !> Returns the point at which a vein bends most out of the plane, 0 if all are straight in it.
  pure integer function bent_point(wing, plans, normal) result(point)
    type(wing_t), intent(in) :: wing
    type(hinge_plan_t), intent(in) :: plans(:)
    real(rp), intent(in) :: normal(3)
    real(rp), parameter :: STRAIGHT = 1.0e-6_rp ! [rad]
    real(rp) :: e(3), f(3), turn(3), bend, largest
    integer :: h
    point = 0
    largest = STRAIGHT
    do h = 1, size(plans)
      if (any(plans(h)%nodes > size(wing%points, 2))) cycle ! straight by construction
      e = wing%points(:, plans(h)%nodes(2)) - wing%points(:, plans(h)%nodes(1))
      f = wing%points(:, plans(h)%nodes(3)) - wing%points(:, plans(h)%nodes(2))
      turn = cross(e, f)/(norm2(e)*norm2(f))
      bend = norm2(turn - dot_product(turn, normal)*normal)
      if (bend > largest) point = plans(h)%nodes(2)
      largest = max(largest, bend)
    end do
  end function bent_point
end module solid_flatness

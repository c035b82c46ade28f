! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimates the mass of the fluid that a thin wing has to move, compared with the mass of the wing itself.
!>
!> A strip of chord c that moves along its normal accelerates rho pi c^2/4 of fluid per span (Sedov 1965), on average rho pi c/4 per
!> area. If a staggered scheme makes the fluid follow the wall exactly, and the load acts on the wing one step late, the scheme is
!> unstable at any time step if this mass exceeds the mass of the wing (Causin, Gerbeau & Nobile 2005, DOI
!> 10.1016/j.cma.2004.12.005).
module fsi_added_mass
  use base_constants, only: PI
  use base_kinds, only: rp
  implicit none
  private
  public :: added_mass_ratio, light_layer

  real(rp), parameter :: TENTH = 0.1_rp

contains

  !> Returns the largest ratio, over the chords through the centres of the triangles, of the fluid's mass to that of the wing, for a
  !> flat wing in the x-y plane with its chords along y. The mass of a point is spread evenly over a third of the area of its
  !> triangles. SI or any consistent units.
  pure real(rp) function added_mass_ratio(points, triangles, masses, density) result(largest)
    real(rp), intent(in) :: points(:, :)   !< (2 or more, n) along the span and along the chord
    integer, intent(in) :: triangles(:, :) !< (3, m)
    real(rp), intent(in) :: masses(:)      !< (at least n) of the points
    real(rp), intent(in) :: density        !< of the fluid
    real(rp) :: around(size(points, 2)), layer(size(triangles, 2))
    real(rp) :: chord, mass, length, x
    integer :: i, k, m
    m = size(triangles, 2)
    around = areas_around(points, triangles)
    layer = 0
    do i = 1, m
      do k = 1, 3
        layer(i) = layer(i) + masses(triangles(k, i))/around(triangles(k, i))/3
      end do
    end do
    largest = 0
    do i = 1, m
      x = sum(points(1, triangles(:, i)))/3
      chord = 0
      mass = 0
      do k = 1, m
        length = cut(points(:2, triangles(:, k)), x)
        chord = chord + length
        mass = mass + length*layer(k)
      end do
      if (mass > 0) largest = max(largest, density*PI/4*chord**2/mass)
    end do
  end function added_mass_ratio

  !> Returns the mass per area below which a tenth of the area of such a wing lies; 0 without triangles.
  pure real(rp) function light_layer(points, triangles, masses) result(layer)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: triangles(:, :)
    real(rp), intent(in) :: masses(:)
    real(rp) :: around(size(points, 2)), layers(size(points, 2))
    integer :: i
    around = areas_around(points, triangles)
    layers = masses(:size(points, 2))/max(around, tiny(1.0_rp))
    layer = 0
    do i = 1, size(around)
      if (around(i) <= 0) cycle
      if (layer > 0 .and. layers(i) >= layer) cycle
      if (sum(around, mask=layers <= layers(i)) >= TENTH*sum(around)) layer = layers(i)
    end do
  end function light_layer

  !> Returns a third of the area of the triangles about each point.
  pure function areas_around(points, triangles) result(around)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: triangles(:, :)
    real(rp) :: around(size(points, 2))
    integer :: i
    around = 0
    do i = 1, size(triangles, 2)
      associate (a => points(:, triangles(1, i)), b => points(:, triangles(2, i)), c => points(:, triangles(3, i)))
        around(triangles(:, i)) = around(triangles(:, i)) + &
                                  abs((b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1)))/6
      end associate
    end do
  end function areas_around

  !> Returns the length of the part of the line x = const inside a triangle with these corners (2, 3).
  pure real(rp) function cut(corners, x) result(length)
    real(rp), intent(in) :: corners(:, :), x
    real(rp) :: low, high, y
    integer :: k, next
    low = huge(low)
    high = -huge(high)
    do k = 1, 3
      next = modulo(k, 3) + 1
      associate (a => corners(:, k), b => corners(:, next))
        if ((a(1) <= x) .eqv. (b(1) <= x)) cycle
        y = a(2) + (b(2) - a(2))*(x - a(1))/(b(1) - a(1))
        low = min(low, y)
        high = max(high, y)
      end associate
    end do
    length = 0
    if (high > low) length = high - low
  end function cut
end module fsi_added_mass

! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the positions of the elements of a model in the unloaded wing, for laws that depend on the position.
module solid_layout
  use base_kinds, only: rp
  use solid_arch, only: bends_of_curvature, turns_of_curvature
  use solid_extension, only: extensions_t
  use solid_junctions, only: hinge_plan_t
  use solid_plate, only: plate_t
  use solid_tension, only: tension_widths
  use solid_wing, only: wing_t
  implicit none
  private
  public :: layout_t, make_layout, hinge_in_vein, free_place_in_vein, vein_places

  !> Positions of the elements, which do not change.
  type :: layout_t
    real(rp) :: mean_diameter = 0                !< [m] of the veins, the reference of `diameter_exponent`
    real(rp), allocatable :: spring_site(:, :)  !< (2, springs) [m] x, y of the middles
    real(rp), allocatable :: spring_cosine(:)    !< (springs) cos 2 phi, phi the angle to x
    real(rp), allocatable :: hinge_site(:, :)   !< (2, hinges) [m] of their points
    real(rp), allocatable :: edge_site(:, :, :) !< (2, 2, edges of the plate) [m] centroids of both triangles
    real(rp), allocatable :: spring_width(:)     !< (springs) [m] width of the membrane whose isotropic tension a spring carries
    real(rp), allocatable :: edge_bend(:, :)     !< (3, edges of the plate) bending of the edges for unit curvatures [m]
    real(rp), allocatable :: hinge_turn(:, :)    !< (3, hinges) [m] turning of the hinges for unit curvatures
    integer :: soft_hinge = 0                    !< the hinge that the effect `soft` changes; 0: none
    real(rp), private :: root = 0, extent = 0    !< [m] mean x of the clamped points; extent of the wing along x
  contains
    procedure :: station => layout_station
  end type layout_t

contains

  !> Returns where the elements of a wing lie between points(3, :) [m], its own and its ghost points.
  pure subroutine make_layout(points, wing, springs, plans, plate, layout)
    real(rp), intent(in) :: points(:, :)
    type(wing_t), intent(in) :: wing
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    type(plate_t), intent(in) :: plate
    type(layout_t), intent(inout) :: layout
    integer :: s, h, e
    allocate (layout%spring_site(2, springs%n), layout%spring_cosine(springs%n), layout%hinge_site(2, size(plans)), &
              layout%edge_site(2, 2, plate%n))
    layout%root = sum(wing%points(1, wing%root))/max(1, size(wing%root))
    layout%extent = maxval(wing%points(1, :)) - minval(wing%points(1, :))
    layout%spring_width = tension_widths(points, wing%triangles, springs)
    layout%edge_bend = bends_of_curvature(points, plate)
    do s = 1, springs%n
      layout%spring_site(:, s) = sum(points(:2, springs%nodes(:, s)), 2)/2
      associate (d => springs%d0(:, s))
        layout%spring_cosine(s) = (d(1)**2 - d(2)**2)/(d(1)**2 + d(2)**2)
      end associate
    end do
    allocate (layout%hinge_turn(3, size(plans)))
    do h = 1, size(plans)
      layout%hinge_site(:, h) = points(:2, plans(h)%nodes(2))
      layout%hinge_turn(:, h) = turns_of_curvature(points(:2, plans(h)%nodes(1)), points(:2, plans(h)%nodes(3)), &
                                                   sum(plans(h)%lengths)/2)
    end do
    do e = 1, plate%n
      associate (n => plate%nodes(:, e))
        layout%edge_site(:, 1, e) = sum(points(:2, n([1, 2, 3])), 2)/3
        layout%edge_site(:, 2, e) = sum(points(:2, n([1, 2, 4])), 2)/3
      end associate
    end do
  end subroutine make_layout

  !> Returns the station (x - x_root)/R - 1/2 at x [m]; without extent along x that of the root.
  pure real(rp) function layout_station(self, x) result(s)
    class(layout_t), intent(in) :: self
    real(rp), intent(in) :: x
    s = -0.5_rp
    if (self%extent > 0) s = (x - self%root)/self%extent - 0.5_rp
  end function layout_station

  !> Returns the hinge at the point inside vein number `vein` that is nearest to `fraction` (0 to 1) of its length. It is 0 if the
  !> vein has no point inside, or if a joint is there already.
  pure integer function hinge_in_vein(wing, plans, vein, fraction) result(found)
    type(wing_t), intent(in) :: wing
    type(hinge_plan_t), intent(in) :: plans(:)
    integer, intent(in) :: vein
    real(rp), intent(in) :: fraction
    real(rp) :: fractions(size(wing%veins(vein)%nodes))
    integer :: n, h, at
    found = 0
    associate (nodes => wing%veins(vein)%nodes)
      n = size(nodes)
      if (n < 3) return
      fractions = vein_places(wing, vein)
      at = 1 + minloc(abs(fractions(2:n - 1) - fraction), 1)
      do h = 1, size(plans)
        if (plans(h)%nodes(2) /= nodes(at) .or. plans(h)%joint > 0) cycle
        if (any(plans(h)%nodes(1) == nodes([at - 1, at + 1])) .and. &
            any(plans(h)%nodes(3) == nodes([at - 1, at + 1]))) found = h
      end do
    end associate
  end function hinge_in_vein

  !> Returns the place of the point inside vein number `vein` that is nearest to `fraction` (0 to 1) of its length and has no joint:
  !> a soft place there has a hinge. It is `fraction` itself if the vein has no such point.
  pure real(rp) function free_place_in_vein(wing, vein, fraction) result(place)
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: vein
    real(rp), intent(in) :: fraction
    real(rp) :: fractions(size(wing%veins(vein)%nodes))
    logical :: is_free(size(fractions))
    integer :: k, j
    place = fraction
    if (size(fractions) < 3) return
    fractions = vein_places(wing, vein)
    is_free = .false.
    associate (nodes => wing%veins(vein)%nodes)
      do k = 2, size(nodes) - 1
        is_free(k) = .true.
        do j = 1, size(wing%joints)
          associate (hinge => wing%joints(j)%nodes, beside => nodes([k - 1, k + 1]))
            if (hinge(2) == nodes(k) .and. any(hinge(1) == beside) .and. any(hinge(3) == beside)) is_free(k) = .false.
          end associate
        end do
      end do
    end associate
    if (any(is_free)) place = fractions(minloc(abs(fractions - fraction), 1, mask=is_free))
  end function free_place_in_vein

  !> Returns the places of the points of vein number `vein`, from 0 to 1 of its length. It has two points or more.
  pure function vein_places(wing, vein) result(fractions)
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: vein
    real(rp) :: fractions(size(wing%veins(vein)%nodes))
    integer :: k
    associate (nodes => wing%veins(vein)%nodes)
      fractions = 0
      do k = 2, size(nodes)
        fractions(k) = fractions(k - 1) + norm2(wing%points(:, nodes(k)) - wing%points(:, nodes(k - 1)))
      end do
      fractions = fractions/fractions(size(nodes))
    end associate
  end function vein_places
end module solid_layout

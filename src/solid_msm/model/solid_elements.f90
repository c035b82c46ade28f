! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the elements of the model of a wing, and finds their entries in the matrix.
module solid_elements
  use base_kinds, only: rp
  use solid_edges, only: edges_t
  use solid_twist, only: twist_t
  use solid_extension, only: extensions_t, SPRING_VEIN, SPRING_MEMBRANE, SPRING_CROSS
  use solid_hinge, only: hinge_t
  use solid_junctions, only: hinge_plan_t
  use solid_params, only: solid_params_t
  use solid_pattern, only: pattern_t, make_pattern
  use solid_plate, only: plate_t, plate_weights
  use solid_vectors, only: cross
  use solid_wing, only: wing_t
  implicit none
  private
  public :: make_springs, make_hinges, make_plate, link_elements, point_weights

contains

  !> Makes one spring along each vein segment and along each other edge, and the cross-springs if the user wants them.
  subroutine make_springs(wing, edges, params, points, springs)
    type(wing_t), intent(in) :: wing
    type(edges_t), intent(in) :: edges
    type(solid_params_t), intent(in) :: params
    real(rp), intent(in) :: points(:, :)
    type(extensions_t), intent(out) :: springs
    logical, allocatable :: in_vein(:)
    integer :: v, p, e, capacity
    capacity = 2*edges%n
    do v = 1, size(wing%veins)
      capacity = capacity + size(wing%veins(v)%nodes)
    end do
    allocate (springs%nodes(2, capacity), springs%family(capacity), in_vein(edges%n))
    in_vein = .false.
    do v = 1, size(wing%veins)
      do p = 1, size(wing%veins(v)%nodes) - 1
        associate (a => wing%veins(v)%nodes(p), b => wing%veins(v)%nodes(p + 1))
          e = edges%find(a, b)
          if (e > 0) then
            if (in_vein(e)) cycle
            in_vein(e) = .true.
          end if
          call add(a, b, SPRING_VEIN)
        end associate
      end do
    end do
    do e = 1, edges%n
      if (.not. in_vein(e)) call add(edges%nodes(1, e), edges%nodes(2, e), SPRING_MEMBRANE)
    end do
    if (params%cross_springs) then
      do e = 1, edges%n
        if (edges%triangles(2, e) > 0) call add(edges%apexes(1, e), edges%apexes(2, e), SPRING_CROSS)
      end do
    end if
    springs%nodes = springs%nodes(:, :springs%n)
    springs%family = springs%family(:springs%n)
    springs%d0 = points(:, springs%nodes(2, :)) - points(:, springs%nodes(1, :))
    springs%l0 = norm2(springs%d0, 1)

  contains

    subroutine add(a, b, family)
      integer, intent(in) :: a, b, family
      springs%n = springs%n + 1
      springs%nodes(:, springs%n) = [a, b]
      springs%family(springs%n) = family
    end subroutine add
  end subroutine make_springs

  !> Makes the planned hinges. A hinge with a rest angle, or a joint with sides, has the triangles that define its normal.
  subroutine make_hinges(wing, edges, plans, points, normal, has_sides, hinges)
    type(wing_t), intent(in) :: wing
    type(edges_t), intent(in) :: edges
    type(hinge_plan_t), intent(in) :: plans(:)
    real(rp), intent(in) :: points(:, :), normal(3)
    logical, intent(in) :: has_sides
    type(hinge_t), allocatable, intent(out) :: hinges(:)
    real(rp), parameter :: STRAIGHT = 1.0e-9_rp ! [rad]
    real(rp) :: e(3), f(3), angle
    integer :: h, i, used(4), side, edge
    allocate (hinges(size(plans)))
    do h = 1, size(plans)
      hinges(h)%nodes(1:3) = plans(h)%nodes
      hinges(h)%normal0 = normal
      e = points(:, plans(h)%nodes(2)) - points(:, plans(h)%nodes(1))
      f = points(:, plans(h)%nodes(3)) - points(:, plans(h)%nodes(2))
      angle = atan2(dot_product(normal, cross(e, f)), dot_product(e, f))
      hinges(h)%is_straight = norm2(cross(e, f)) <= STRAIGHT*norm2(e)*norm2(f) .and. dot_product(e, f) > 0
      if (has_sides .and. plans(h)%joint > 0) hinges(h)%is_straight = .false.
      if (.not. hinges(h)%is_straight) then
        hinges(h)%cos0 = cos(angle)
        hinges(h)%sin0 = sin(angle)
        used = 0
        do side = 1, 2
          edge = edges%find(plans(h)%nodes(side), plans(h)%nodes(side + 1))
          if (edge == 0) cycle
          do i = 1, 2
            call add_triangle(hinges(h), edges%triangles(i, edge))
          end do
        end do
      end if
      do i = 1, hinges(h)%n_nodes
        hinges(h)%x0(:, i) = points(:, hinges(h)%nodes(i))
      end do
    end do

  contains

    !> Adds a triangle, whose normal the hinge follows, unless it is there.
    subroutine add_triangle(hinge, triangle)
      type(hinge_t), intent(inout) :: hinge
      integer, intent(in) :: triangle
      integer :: c, place
      if (triangle == 0 .or. any(used == triangle)) return
      hinge%n_triangles = hinge%n_triangles + 1
      used(hinge%n_triangles) = triangle
      do c = 1, 3
        place = findloc(hinge%nodes(:hinge%n_nodes), wing%triangles(c, triangle), 1)
        if (place == 0) then
          hinge%n_nodes = hinge%n_nodes + 1
          place = hinge%n_nodes
          hinge%nodes(place) = wing%triangles(c, triangle)
        end if
        hinge%corners(c, hinge%n_triangles) = place
      end do
    end subroutine add_triangle
  end subroutine make_hinges

  !> Makes one bending element for every edge between two triangles.
  function make_plate(edges, points) result(plate)
    type(edges_t), intent(in) :: edges
    real(rp), intent(in) :: points(:, :)
    type(plate_t) :: plate
    real(rp) :: area(3)
    integer :: e
    plate%n = count(edges%triangles(2, :) > 0)
    allocate (plate%nodes(4, plate%n), plate%weights(4, plate%n), plate%upward(plate%n))
    plate%n = 0
    do e = 1, edges%n
      if (edges%triangles(2, e) == 0) cycle
      plate%n = plate%n + 1
      plate%nodes(:, plate%n) = [edges%nodes(:, e), edges%apexes(:, e)]
      plate%weights(:, plate%n) = plate_weights(points(:, plate%nodes(:, plate%n)))
      associate (c => plate%nodes(:, plate%n))
        area = cross(points(:, c(2)) - points(:, c(1)), points(:, c(3)) - points(:, c(4)))
      end associate
      plate%upward(plate%n) = 0 ! a vertical wing has no camber
      if (abs(area(3)) > 1.0e-6_rp*norm2(area)) plate%upward(plate%n) = 1/area(3)
    end do
  end function make_plate

  !> Finds the pattern of the tangent, the entries of all elements in it, and the constant tangent of the plate.
  subroutine link_elements(free, n_free, springs, hinges, plate, twists, pattern)
    integer, intent(in) :: free(:), n_free
    type(extensions_t), intent(inout) :: springs
    type(hinge_t), intent(inout) :: hinges(:)
    type(plate_t), intent(inout) :: plate
    type(twist_t), intent(inout) :: twists(:) !< the twist elements that get entries
    type(pattern_t), intent(out) :: pattern
    integer, allocatable :: pairs(:, :)
    integer :: n, s, h, e
    n = springs%n + 6*plate%n
    do h = 1, size(hinges)
      n = n + hinges(h)%n_nodes*(hinges(h)%n_nodes - 1)/2
    end do
    do h = 1, size(twists)
      n = n + twists(h)%n_nodes*(twists(h)%n_nodes - 1)/2
    end do
    allocate (pairs(2, n))
    pairs(:, :springs%n) = reshape(free([springs%nodes]), [2, springs%n])
    n = springs%n
    do h = 1, size(hinges)
      call add_pairs(hinges(h)%nodes(:hinges(h)%n_nodes))
    end do
    do e = 1, plate%n
      call add_pairs(plate%nodes(:, e))
    end do
    do h = 1, size(twists)
      call add_pairs(twists(h)%nodes(:twists(h)%n_nodes))
    end do
    pattern = make_pattern(n_free, pairs)

    allocate (springs%blocks(3, springs%n))
    do s = 1, springs%n
      associate (f => free(springs%nodes(:, s)))
        springs%blocks(:, s) = [pattern%block_index(f(1), f(1)), pattern%block_index(f(2), f(2)), &
                                abs(pattern%block_index(f(1), f(2)))]
      end associate
    end do
    do h = 1, size(hinges)
      call find_blocks(pattern, free(hinges(h)%nodes(:hinges(h)%n_nodes)), hinges(h)%blocks)
    end do
    do h = 1, size(twists)
      call find_blocks(pattern, free(twists(h)%nodes(:twists(h)%n_nodes)), twists(h)%blocks)
    end do
    call link_plate(free, pattern, plate)

  contains

    !> Adds all pairs of free points among `nodes`.
    subroutine add_pairs(nodes)
      integer, intent(in) :: nodes(:)
      integer :: p, q
      do q = 2, size(nodes)
        do p = 1, q - 1
          n = n + 1
          pairs(:, n) = [free(nodes(p)), free(nodes(q))]
        end do
      end do
    end subroutine add_pairs
  end subroutine link_elements

  !> Sets the upper part of `blocks` to the entries of the pairs of these free points in the pattern; the rest stays.
  pure subroutine find_blocks(pattern, points, blocks)
    type(pattern_t), intent(in) :: pattern
    integer, intent(in) :: points(:)
    integer, intent(inout) :: blocks(:, :)
    integer :: i, j
    do j = 1, size(points)
      do i = 1, j
        blocks(i, j) = pattern%block_index(points(i), points(j))
      end do
    end do
  end subroutine find_blocks

  !> Finds the entries of the elements of the plate, and its constant tangent.
  subroutine link_plate(free, pattern, plate)
    integer, intent(in) :: free(:)
    type(pattern_t), intent(in) :: pattern
    type(plate_t), intent(inout) :: plate
    integer :: e, i, j, b
    allocate (plate%tangent(size(pattern%rows)), source=0.0_rp)
    allocate (plate%blocks(4, 4, plate%n), plate%places(4, 4, plate%n), source=0)
    do e = 1, plate%n
      do j = 1, 4
        do i = 1, j
          plate%places(i, j, e) = pattern%block_index(free(plate%nodes(i, e)), free(plate%nodes(j, e)))
          b = abs(plate%places(i, j, e))
          plate%blocks(i, j, e) = b
          if (b > 0) plate%tangent(b) = plate%tangent(b) + plate%weights(i, e)*plate%weights(j, e)
        end do
      end do
    end do
  end subroutine link_plate

  !> Returns the share of every movable point in the surface, or in the length of a structure without a membrane. The mean is 1;
  !> no share is below 0.1.
  function point_weights(wing, movable) result(weights)
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: movable(:)
    real(rp), allocatable :: weights(:)
    real(rp) :: all_weights(size(wing%points, 2)), length
    integer :: t, v, p
    all_weights = 0
    associate (x => wing%points)
      do t = 1, size(wing%triangles, 2)
        associate (c => wing%triangles(:, t))
          all_weights(c) = all_weights(c) + norm2(cross(x(:, c(2)) - x(:, c(1)), x(:, c(3)) - x(:, c(1))))
        end associate
      end do
      if (size(wing%triangles, 2) == 0) then
        do v = 1, size(wing%veins)
          do p = 1, size(wing%veins(v)%nodes) - 1
            associate (c => wing%veins(v)%nodes(p:p + 1))
              length = norm2(x(:, c(2)) - x(:, c(1)))
              all_weights(c) = all_weights(c) + length
            end associate
          end do
        end do
      end if
    end associate
    weights = all_weights(movable)
    if (size(weights) == 0) return
    weights = max(0.1_rp, weights*size(weights)/sum(weights))
  end function point_weights
end module solid_elements

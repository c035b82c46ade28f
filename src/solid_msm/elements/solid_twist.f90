! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes veins that resist torsion. A segment has no direction across its axis, but the membrane at its sides has a normal,
!> which turns about the vein if the vein is twisted.
!>
!> At the hinge a-b-c with the segments e and f let Ae and Af be the summed area vectors of the triangles at each segment, divided
!> by their lengths in the flat wing. The twist is tau = p.(Ae x Af), p = (e/|e0| + f/|f0|)/2. For small angles it is the angle
!> between both normals about the vein. It is 0 if the vein bends, or if the membrane folds in the same way on both sides. The
!> energy is k tau^2/2 with k = (GJ/EI) times the stiffness of the hinge in bending; solid circles have GJ/EI = 1/(1 + nu). Segments
!> without triangles, at the clamp for instance, are not twisted. Lengths are treated as constant, because the stiff springs change
!> them little.
!>
!> The same normal distinguishes up from down for a vein: a vein whose stress-free shape is bent upward by the angle beta has the
!> additional energy -k beta c, c = n.(f/|f0| - e/|e0|) with n = (Ae + Af)/|Ae + Af|0: see solid_arch.
module solid_twist
  use base_kinds, only: rp
  use solid_edges, only: edges_t
  use solid_junctions, only: hinge_plan_t
  use solid_vectors, only: cross, outer, skew
  implicit none
  private
  public :: twist_t, make_twists, twist_evaluate, camber_evaluate

  integer, parameter, public :: TWIST_NODES = 7 !< most nodes: a, b, c and four apexes

  !> The twist element at one hinge; without nodes it has no effect.
  type :: twist_t
    integer :: n_nodes = 0              !< 0: no membrane at either segment
    logical :: is_twistable = .false.   !< both segments have membrane
    integer :: nodes(TWIST_NODES) = 0   !< a, b, c, then the apexes
    integer :: n_triangles(2) = 0       !< at e and at f
    integer :: corners(3, 2, 2) = 0     !< of each triangle of each segment, as places in `nodes`
    real(rp) :: x0(3, TWIST_NODES) = 0  !< [m]
    real(rp) :: lengths(2) = 1          !< [m] of e and f
    real(rp) :: area = 1                !< [m^2] |Ae + Af| there
    real(rp) :: areas(2) = 1            !< [m^2] |A| of both in the flat wing
    integer :: blocks(TWIST_NODES, TWIST_NODES) = 0 !< upper part: places in the matrix, < 0 transposed, 0 none
  end type twist_t

contains

  !> Makes one element for every planned hinge between points(3, :) [m] with triangles(3, :).
  subroutine make_twists(edges, plans, triangles, points, twists)
    type(edges_t), intent(in) :: edges
    type(hinge_plan_t), intent(in) :: plans(:)
    integer, intent(in) :: triangles(:, :)
    real(rp), intent(in) :: points(:, :)
    type(twist_t), allocatable, intent(out) :: twists(:)
    real(rp) :: area(3, 2)
    integer :: h, side, edge, i
    allocate (twists(size(plans)))
    do h = 1, size(plans)
      associate (one => twists(h), nodes => plans(h)%nodes)
        one%nodes(:3) = nodes
        one%n_nodes = 3
        do side = 1, 2
          one%lengths(side) = norm2(points(:, nodes(side + 1)) - points(:, nodes(side)))
          edge = edges%find(nodes(side), nodes(side + 1))
          if (edge == 0) cycle
          do i = 1, 2
            if (edges%triangles(i, edge) > 0) call add_triangle(one, side, triangles(:, edges%triangles(i, edge)))
          end do
        end do
        do i = 1, one%n_nodes
          one%x0(:, i) = points(:, one%nodes(i))
        end do
        area = area_vectors(one, 0*one%x0)
        one%areas = norm2(area, 1)
        one%is_twistable = minval(one%areas) > 0
        if (.not. maxval(one%areas) > 0) one%n_nodes = 0
        where (.not. one%areas > 0) one%areas = 1
        one%area = norm2(sum(area, 2))
      end associate
    end do
  end subroutine make_twists

  !> Adds a triangle to one side of the twist element.
  pure subroutine add_triangle(one, side, corners)
    type(twist_t), intent(inout) :: one
    integer, intent(in) :: side, corners(3)
    integer :: c, place
    one%n_triangles(side) = one%n_triangles(side) + 1
    do c = 1, 3
      place = findloc(one%nodes(:one%n_nodes), corners(c), 1)
      if (place == 0) then
        one%n_nodes = one%n_nodes + 1
        place = one%n_nodes
        one%nodes(place) = corners(c)
      end if
      one%corners(c, one%n_triangles(side), side) = place
    end do
  end subroutine add_triangle

  !> Returns the energy [J] and, on request, the gradient g(3, 7) [N] and the Hessian h(21, 21) [N/m] for `stiffness` [N m/rad] at
  !> displacements u(3, 7) [m] of the nodes. With `semidefinite` the Hessian is its positive semidefinite Gauss-Newton part.
  pure subroutine twist_evaluate(self, stiffness, u, energy, g, h, semidefinite)
    type(twist_t), intent(in) :: self
    real(rp), intent(in) :: stiffness, u(3, TWIST_NODES)
    real(rp), intent(out) :: energy
    real(rp), intent(out), optional :: g(3, TWIST_NODES), h(3*TWIST_NODES, 3*TWIST_NODES)
    logical, intent(in), optional :: semidefinite
    real(rp) :: p(3), area(3, 2), tau, slope(3, TWIST_NODES), pull(3, 2)
    real(rp) :: weight(TWIST_NODES), b(3, 3, TWIST_NODES, 2) ! dp/dx = share 1, dA/dx = b
    real(rp) :: m(3, 3)
    logical :: exact
    integer :: i, j
    call frame(self, u, p, area, weight, b)
    tau = dot_product(p, cross(area(:, 1), area(:, 2)))
    energy = 0.5_rp*stiffness*tau**2
    if (.not. present(g) .and. .not. present(h)) return
    pull(:, 1) = cross(area(:, 2), p)
    pull(:, 2) = cross(p, area(:, 1))
    slope = 0
    do i = 1, self%n_nodes
      slope(:, i) = weight(i)*cross(area(:, 1), area(:, 2)) + matmul(pull(:, 1), b(:, :, i, 1)) + &
                    matmul(pull(:, 2), b(:, :, i, 2))
    end do
    if (present(g)) g = stiffness*tau*slope
    if (.not. present(h)) return
    exact = .true.
    if (present(semidefinite)) exact = .not. semidefinite
    h = 0
    do j = 1, self%n_nodes
      do i = 1, self%n_nodes
        m = outer(slope(:, i), slope(:, j))
        if (exact) m = m + tau*(crossed(i, j) + transpose(crossed(j, i)))
        h(3*i - 2:3*i, 3*j - 2:3*j) = stiffness*m
      end do
    end do
    if (exact) call add_curvature(self, stiffness*tau, pull, h)

  contains

    !> Returns half of the mixed second derivatives of p.(A1 x A2) by p, A1 and A2.
    pure function crossed(i, j) result(c)
      integer, intent(in) :: i, j
      real(rp) :: c(3, 3)
      c = -weight(i)*matmul(skew(area(:, 2)), b(:, :, j, 1)) + weight(i)*matmul(skew(area(:, 1)), b(:, :, j, 2)) - &
          matmul(transpose(b(:, :, i, 1)), matmul(skew(p), b(:, :, j, 2)))
    end function crossed

  end subroutine twist_evaluate

  !> Returns energy, gradient and Hessian for the energy -moment c of a curved vein; `moment` = k beta [N m]. The Hessian is
  !> indefinite.
  pure subroutine camber_evaluate(self, moment, u, energy, g, h)
    type(twist_t), intent(in) :: self
    real(rp), intent(in) :: moment, u(3, TWIST_NODES)
    real(rp), intent(out) :: energy
    real(rp), intent(out), optional :: g(3, TWIST_NODES), h(3*TWIST_NODES, 3*TWIST_NODES)
    real(rp) :: p(3), area(3, 2), weight(TWIST_NODES), b(3, 3, TWIST_NODES, 2), bend(3), n(3), coefficient(TWIST_NODES)
    real(rp) :: turn(3, 3, TWIST_NODES)
    integer :: i, j
    call frame(self, u, p, area, weight, b)
    coefficient = 0
    coefficient(:3) = [1/self%lengths(1), -1/self%lengths(1) - 1/self%lengths(2), 1/self%lengths(2)]
    bend = matmul(self%x0(:, :3) + u(:, :3), coefficient(:3))
    n = matmul(area, self%areas)/self%area
    energy = -moment*dot_product(n, bend)
    if (.not. present(g) .and. .not. present(h)) return
    turn = (b(:, :, :, 1)*self%areas(1) + b(:, :, :, 2)*self%areas(2))/self%area
    if (present(g)) then
      g = 0
      do i = 1, self%n_nodes
        g(:, i) = -moment*(coefficient(i)*n + matmul(bend, turn(:, :, i)))
      end do
    end if
    if (.not. present(h)) return
    h = 0
    do j = 1, self%n_nodes
      do i = 1, self%n_nodes
        h(3*i - 2:3*i, 3*j - 2:3*j) = -moment*(coefficient(i)*turn(:, :, j) + coefficient(j)*transpose(turn(:, :, i)))
      end do
    end do
    call add_curvature(self, -moment, spread(bend, 2, 2)*spread(self%areas, 1, 3)/self%area, h)
  end subroutine camber_evaluate

  !> Adds the second derivatives of the area vectors, which are quadratic in the positions.
  pure subroutine add_curvature(self, factor, pull, h)
    type(twist_t), intent(in) :: self
    real(rp), intent(in) :: factor, pull(3, 2)
    real(rp), intent(inout) :: h(3*TWIST_NODES, 3*TWIST_NODES)
    real(rp) :: arm(3)
    integer :: side, t, i
    do side = 1, 2
      arm = factor*pull(:, side)/self%areas(side)
      do t = 1, self%n_triangles(side)
        do i = 1, 3
          associate (m => 3*self%corners(i, t, side), ahead => 3*self%corners(mod(i, 3) + 1, t, side))
            h(m - 2:m, ahead - 2:ahead) = h(m - 2:m, ahead - 2:ahead) - skew(arm)
            h(ahead - 2:ahead, m - 2:m) = h(ahead - 2:ahead, m - 2:m) + skew(arm)
          end associate
        end do
      end do
    end do
  end subroutine add_curvature

  !> Computes p, both areas and their derivatives.
  pure subroutine frame(self, u, p, area, weight, b)
    type(twist_t), intent(in) :: self
    real(rp), intent(in) :: u(3, TWIST_NODES)
    real(rp), intent(out) :: p(3), area(3, 2), weight(TWIST_NODES), b(3, 3, TWIST_NODES, 2)
    real(rp) :: lever(3)
    integer :: side, t, i
    weight = 0
    weight(:3) = 0.5_rp*[-1/self%lengths(1), 1/self%lengths(1) - 1/self%lengths(2), 1/self%lengths(2)]
    p = matmul(self%x0(:, :3) + u(:, :3), weight(:3))
    area = area_vectors(self, u)
    b = 0
    do side = 1, 2
      area(:, side) = area(:, side)/self%areas(side)
      do t = 1, self%n_triangles(side)
        do i = 1, 3
          associate (m => self%corners(i, t, side), ahead => self%corners(mod(i, 3) + 1, t, side), &
                     behind => self%corners(mod(i + 1, 3) + 1, t, side))
            lever = self%x0(:, behind) + u(:, behind) - self%x0(:, ahead) - u(:, ahead)
            b(:, :, m, side) = b(:, :, m, side) + skew(lever)/self%areas(side)
          end associate
        end do
      end do
    end do
  end subroutine frame

  !> Returns the summed area vectors [m^2], twice the areas, of the triangles at both segments.
  pure function area_vectors(self, u) result(area)
    type(twist_t), intent(in) :: self
    real(rp), intent(in) :: u(3, TWIST_NODES)
    real(rp) :: area(3, 2), x(3, 3)
    integer :: side, t, i
    area = 0
    do side = 1, 2
      do t = 1, self%n_triangles(side)
        do i = 1, 3
          x(:, i) = self%x0(:, self%corners(i, t, side)) + u(:, self%corners(i, t, side))
        end do
        area(:, side) = area(:, side) + cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1))
      end do
    end do
  end function area_vectors
end module solid_twist

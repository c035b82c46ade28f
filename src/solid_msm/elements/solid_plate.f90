! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the bending of a flat membrane: a quadratic form of the displacement with a constant, positive semidefinite Hessian,
!> one term for every interior edge.
!>
!> E = D |q|^2/(2 (A1 + A2)), q = sum K_a u_a over the edge's ends and the two apexes, where the
!> cotangent weights K make |q| = edge length x dihedral angle for small angles: the isometric bending
!> model of Bergou et al. (2006), doi:10.2312/SCA/SCA06/227-230, with the coefficient that gives
!> D kappa^2/2 per area on a regular mesh. q vanishes for every rotated flat state.
module solid_plate
  use base_kinds, only: rp
  use solid_vectors, only: cross
  implicit none
  private
  public :: plate_t, plate_weights, plate_energy, plate_gradient, edges_energy, edges_tangent

  !> The interior edges of a membrane.
  type :: plate_t
    integer :: n = 0
    integer, allocatable :: nodes(:, :)    !< (4, n) ends and apexes
    real(rp), allocatable :: weights(:, :) !< (4, n) [1/m]
    integer, allocatable :: blocks(:, :, :) !< (4, 4, n) upper part: places in the matrix, 0 clamped
    real(rp), allocatable :: upward(:)     !< (n) [1/m^2] reciprocal of the z component of (x2 - x1) x (x3 - x4) in the flat wing
    integer, allocatable :: places(:, :, :) !< (4, 4, n) the same with a sign: < 0 transposed
    real(rp), allocatable :: tangent(:)    !< (n_blocks) Hessian for D = 1 N m; the blocks are multiples of 1
  end type plate_t

contains

  !> Returns weights(4) = K/sqrt(A1 + A2) of the edge x1-x2 with apexes x3 and x4 [m]. The energy of the edge is
  !> D/2 |sum of weights times u|^2.
  pure function plate_weights(x) result(weights)
    real(rp), intent(in) :: x(3, 4)
    real(rp) :: weights(4), c(2, 2), area(2)
    integer :: t
    do t = 1, 2
      c(1, t) = cotangent(x(:, 2) - x(:, 1), x(:, 2 + t) - x(:, 1))
      c(2, t) = cotangent(x(:, 1) - x(:, 2), x(:, 2 + t) - x(:, 2))
      area(t) = 0.5_rp*norm2(cross(x(:, 2) - x(:, 1), x(:, 2 + t) - x(:, 1)))
    end do
    weights(1) = c(2, 1) + c(2, 2)
    weights(2) = c(1, 1) + c(1, 2)
    weights(3) = -c(1, 1) - c(2, 1)
    weights(4) = -c(1, 2) - c(2, 2)
    weights = weights/sqrt(area(1) + area(2))
  end function plate_weights

  !> Returns the energy [J] for D = 1 N m at displacements u(3, :) [m].
  pure real(rp) function plate_energy(self, u) result(energy)
    type(plate_t), intent(in) :: self
    real(rp), intent(in) :: u(:, :)
    integer :: e
    energy = 0
    do e = 1, self%n
      energy = energy + 0.5_rp*sum(bend(self, e, u)**2)
    end do
  end function plate_energy

  !> Returns the energy [J] of bending stiffnesses d(n) [N m] of single edges at displacements u(3, :) [m].
  pure real(rp) function edges_energy(self, d, u) result(energy)
    type(plate_t), intent(in) :: self
    real(rp), intent(in) :: d(:), u(:, :)
    integer :: e
    energy = 0
    do e = 1, self%n
      energy = energy + 0.5_rp*d(e)*sum(bend(self, e, u)**2)
    end do
  end function edges_energy

  !> Adds the Hessian of `edges_energy` to blocks(3, 3, :) [N/m].
  pure subroutine edges_tangent(self, d, blocks)
    type(plate_t), intent(in) :: self
    real(rp), intent(in) :: d(:)
    real(rp), intent(inout) :: blocks(:, :, :)
    integer :: e, i, j, k, b
    do e = 1, self%n
      if (.not. abs(d(e)) > 0) cycle
      do j = 1, 4
        do i = 1, j
          b = self%blocks(i, j, e)
          if (b == 0) cycle
          do k = 1, 3
            blocks(k, k, b) = blocks(k, k, b) + d(e)*self%weights(i, e)*self%weights(j, e)
          end do
        end do
      end do
    end do
  end subroutine edges_tangent

  !> Adds the gradient for the bending stiffness d + edge(n) [N m] to g(3, :) [N].
  pure subroutine plate_gradient(self, d, edge, u, g)
    type(plate_t), intent(in) :: self
    real(rp), intent(in) :: d, edge(:), u(:, :)
    real(rp), intent(inout) :: g(:, :)
    real(rp) :: q(3)
    integer :: e, a
    do e = 1, self%n
      q = (d + edge(e))*bend(self, e, u)
      do a = 1, 4
        g(:, self%nodes(a, e)) = g(:, self%nodes(a, e)) + self%weights(a, e)*q
      end do
    end do
  end subroutine plate_gradient

  !> Returns the bending vector of edge `e`.
  pure function bend(self, e, u) result(q)
    type(plate_t), intent(in) :: self
    integer, intent(in) :: e
    real(rp), intent(in) :: u(:, :)
    real(rp) :: q(3)
    q = self%weights(1, e)*u(:, self%nodes(1, e)) + self%weights(2, e)*u(:, self%nodes(2, e)) &
        + self%weights(3, e)*u(:, self%nodes(3, e)) + self%weights(4, e)*u(:, self%nodes(4, e))
  end function bend

  !> Returns the cotangent of the angle between two vectors.
  pure real(rp) function cotangent(a, b) result(value)
    real(rp), intent(in) :: a(3), b(3)
    value = dot_product(a, b)/norm2(cross(a, b))
  end function cotangent
end module solid_plate

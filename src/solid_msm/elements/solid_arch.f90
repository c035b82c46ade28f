! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the forces of a wing whose stress-free shape is curved, with the same curvatures [1/m] everywhere: z0 = (k_xx x^2 + k_yy
!> y^2 + 2 k_xy x y)/2 above the plane of the wing file.
!>
!> With the form q of solid_plate, the energy of an edge is D |q - q0 m|^2/2, where q0 is the form of z0 and m the normal of its
!> four points: m = (x2 - x1) x (x3 - x4), divided by its length in the flat wing, which changes little. Without the energy of the
!> flat plate and a constant this is -arch q.m with the moment arch = D q0, a cubic polynomial of the positions that is invariant
!> under rotations (as in Garg, Grinspun, Wardetzky and Zorin 2007, doi:10.2312/SCA/SCA07/091-098). Veins have stress-free
!> curvatures in the same way (`camber_evaluate`). Springs and the clamp are as in the flat wing, so that the unloaded wing takes a
!> shape that hardly stretches it.
module solid_arch
  use base_kinds, only: rp
  use solid_plate, only: plate_t
  use solid_vectors, only: cross, skew
  implicit none
  private
  public :: bends_of_curvature, turns_of_curvature, arch_energy, arch_gradient, arch_tangent

  real(rp), parameter :: E_OF(4) = [-1.0_rp, 1.0_rp, 0.0_rp, 0.0_rp], F_OF(4) = [0.0_rp, 0.0_rp, 1.0_rp, -1.0_rp]

contains

  !> Returns bends(3, edges), the q0 of each edge for unit curvatures xx, yy and xy of the surface at points(3, :) [m].
  pure function bends_of_curvature(points, plate) result(bends)
    real(rp), intent(in) :: points(:, :)
    type(plate_t), intent(in) :: plate
    real(rp) :: bends(3, plate%n)
    integer :: e
    do e = 1, plate%n
      associate (x => points(1, plate%nodes(:, e)), y => points(2, plate%nodes(:, e)), w => plate%weights(:, e))
        bends(:, e) = [0.5_rp*sum(w*x**2), 0.5_rp*sum(w*y**2), sum(w*x*y)]
      end associate
    end do
  end function bends_of_curvature

  !> Returns turns(3), by how much a vein from place a to place b [m] turns over `length` [m] for unit curvatures xx, yy and xy.
  pure function turns_of_curvature(a, b, length) result(turns)
    real(rp), intent(in) :: a(2), b(2), length
    real(rp) :: turns(3), t(2)
    t = (b - a)/max(norm2(b - a), tiny(1.0_rp))
    turns = length*[t(1)**2, t(2)**2, 2*t(1)*t(2)]
  end function turns_of_curvature

  !> Returns the energy [J] of moments arch(edges) [N m] at displacements u(3, :) [m] of points(3, :) [m].
  pure real(rp) function arch_energy(plate, points, arch, u) result(energy)
    type(plate_t), intent(in) :: plate
    real(rp), intent(in) :: points(:, :), arch(:), u(:, :)
    real(rp) :: e(3), f(3), q(3)
    integer :: n
    energy = 0
    do n = 1, plate%n
      call sides(plate, points, n, u, e, f, q)
      energy = energy - arch(n)*plate%upward(n)*dot_product(q, cross(e, f))
    end do
  end function arch_energy

  !> Adds the gradient of `arch_energy` to g(3, :) [N].
  pure subroutine arch_gradient(plate, points, arch, u, g)
    type(plate_t), intent(in) :: plate
    real(rp), intent(in) :: points(:, :), arch(:), u(:, :)
    real(rp), intent(inout) :: g(:, :)
    real(rp) :: e(3), f(3), q(3), factor
    integer :: n, a
    do n = 1, plate%n
      if (.not. abs(arch(n)) > 0) cycle
      call sides(plate, points, n, u, e, f, q)
      factor = -arch(n)*plate%upward(n)
      do a = 1, 4
        associate (p => plate%nodes(a, n))
          g(:, p) = g(:, p) + factor*(plate%weights(a, n)*cross(e, f) + E_OF(a)*cross(f, q) + F_OF(a)*cross(q, e))
        end associate
      end do
    end do
  end subroutine arch_gradient

  !> Adds the Hessian of `arch_energy`, which is indefinite, to blocks(3, 3, :) [N/m].
  pure subroutine arch_tangent(plate, points, arch, u, blocks)
    type(plate_t), intent(in) :: plate
    real(rp), intent(in) :: points(:, :), arch(:), u(:, :)
    real(rp), intent(inout) :: blocks(:, :, :)
    real(rp) :: e(3), f(3), q(3), h(3, 3), factor
    integer :: n, a, b, place
    do n = 1, plate%n
      if (.not. abs(arch(n)) > 0) cycle
      call sides(plate, points, n, u, e, f, q)
      factor = -arch(n)*plate%upward(n)
      do b = 1, 4
        do a = 1, b
          place = plate%places(a, b, n)
          if (place == 0) cycle
          associate (wa => plate%weights(a, n), wb => plate%weights(b, n))
            ! q.(e x f) is linear in each of q = sum w x, e and f.
            h = (F_OF(b)*wa - F_OF(a)*wb)*skew(e) - (E_OF(b)*wa - E_OF(a)*wb)*skew(f) - &
                (E_OF(a)*F_OF(b) - F_OF(a)*E_OF(b))*skew(q)
          end associate
          if (place > 0) then
            blocks(:, :, place) = blocks(:, :, place) + factor*h
          else
            blocks(:, :, -place) = blocks(:, :, -place) + factor*transpose(h)
          end if
        end do
      end do
    end do
  end subroutine arch_tangent

  !> Computes e = x2 - x1, f = x3 - x4 and q of edge n.
  pure subroutine sides(plate, points, n, u, e, f, q)
    type(plate_t), intent(in) :: plate
    real(rp), intent(in) :: points(:, :), u(:, :)
    integer, intent(in) :: n
    real(rp), intent(out) :: e(3), f(3), q(3)
    associate (c => plate%nodes(:, n), w => plate%weights(:, n))
      e = points(:, c(2)) - points(:, c(1)) + u(:, c(2)) - u(:, c(1))
      f = points(:, c(3)) - points(:, c(4)) + u(:, c(3)) - u(:, c(4))
      q = w(1)*u(:, c(1)) + w(2)*u(:, c(2)) + w(3)*u(:, c(3)) + w(4)*u(:, c(4))
    end associate
  end subroutine sides
end module solid_arch

! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes extension springs: E = k (l - l0)^2/2 along veins, membrane edges and cross-springs.
!>
!> The unknown is the displacement u. The elongation is du.(d0 + d)/(l + l0), which does not cancel
!> when the strain is small. In the tension-field membrane (a model, not a numerical aid) springs of
!> the membrane keep only the fraction `slack` of k in compression; the change from 1 to `slack` is
!> linear in the elongation over `width`, so that the tangent is continuous.
module solid_extension
  use base_kinds, only: rp
  use solid_vectors, only: outer, IDENTITY
  implicit none
  private
  public :: extensions_t, extension_energy, extension_gradient, extension_axial, extension_tangent, extension_tangent_change, &
            tension_energy, tension_gradient

  integer, parameter, public :: SPRING_VEIN = 1, SPRING_MEMBRANE = 2, SPRING_CROSS = 3

  !> All extension springs of a wing.
  type :: extensions_t
    integer :: n = 0
    integer, allocatable :: nodes(:, :)  !< (2, n)
    integer, allocatable :: family(:)    !< SPRING_VEIN, SPRING_MEMBRANE or SPRING_CROSS
    real(rp), allocatable :: d0(:, :)    !< (3, n) [m] stress-free vector from node 1 to node 2
    real(rp), allocatable :: l0(:)       !< (n) [m]
    real(rp), allocatable :: tension(:)  !< (n) [N] at the length l0; not allocated: 0
    integer, allocatable :: blocks(:, :) !< (3, n) places of (1,1), (2,2), (1,2) in the matrix; 0: clamped
    real(rp) :: slack = 1                !< remaining stiffness of the membrane in compression, 0 < slack <= 1
    real(rp) :: width = 1.0e-9_rp        !< [m] elongation over which the stiffness changes
  end type extensions_t

contains

  !> Returns the sum of the energies [J] of springs of stiffness k(n) [N/m] at displacements u(3, :) [m].
  pure real(rp) function extension_energy(self, k, u) result(energy)
    type(extensions_t), intent(in) :: self
    real(rp), intent(in) :: k(:), u(:, :)
    real(rp) :: dl, l, direction(3), e, force, slope
    integer :: s
    energy = 0
    do s = 1, self%n
      call elongation(self, s, u, dl, l, direction)
      call law(self, s, dl, e, force, slope)
      energy = energy + k(s)*e
    end do
  end function extension_energy

  !> Adds the gradient of the energy to g(3, :) [N]. `low` (3, :) [m] is a part of the displacement that is too small to be added to
  !> u without rounding error; it matters for springs as stiff as k_e.
  pure subroutine extension_gradient(self, k, u, g, low)
    type(extensions_t), intent(in) :: self
    real(rp), intent(in) :: k(:), u(:, :)
    real(rp), intent(inout) :: g(:, :)
    real(rp), intent(in), optional :: low(:, :)
    real(rp) :: dl, l, direction(3), e, force, slope, pull(3)
    integer :: s, i, j
    do s = 1, self%n
      call elongation(self, s, u, dl, l, direction)
      if (present(low)) dl = dl + dot_product(direction, low(:, self%nodes(2, s)) - low(:, self%nodes(1, s)))
      call law(self, s, dl, e, force, slope)
      pull = (k(s)*force)*direction
      i = self%nodes(1, s)
      j = self%nodes(2, s)
      g(:, i) = g(:, i) - pull
      g(:, j) = g(:, j) + pull
    end do
  end subroutine extension_gradient

  !> Returns the axial forces [N], tension positive. With `step` (3, :) [m] they are the forces that the law, linearised at u,
  !> gives at u + step.
  pure subroutine extension_axial(self, k, u, axial, step)
    type(extensions_t), intent(in) :: self
    real(rp), intent(in) :: k(:), u(:, :)
    real(rp), intent(inout) :: axial(:)
    real(rp), intent(in), optional :: step(:, :)
    real(rp) :: dl, l, direction(3), e, force, slope
    integer :: s
    do s = 1, self%n
      call elongation(self, s, u, dl, l, direction)
      call law(self, s, dl, e, force, slope)
      if (present(step)) force = force + slope* &
                                 dot_product(direction, step(:, self%nodes(2, s)) - step(:, self%nodes(1, s)))
      axial(s) = k(s)*force
    end do
    if (allocated(self%tension)) axial = axial + self%tension
  end subroutine extension_axial

  !> Returns the energy [J] of constant tensions(n) [N] at displacements u(3, :) [m].
  pure real(rp) function tension_energy(self, tension, u) result(energy)
    type(extensions_t), intent(in) :: self
    real(rp), intent(in) :: tension(:), u(:, :)
    real(rp) :: dl, l, direction(3)
    integer :: s
    energy = 0
    do s = 1, self%n
      call elongation(self, s, u, dl, l, direction)
      energy = energy + tension(s)*dl
    end do
  end function tension_energy

  !> Adds the gradient of `tension_energy` to g(3, :) [N].
  pure subroutine tension_gradient(self, tension, u, g)
    type(extensions_t), intent(in) :: self
    real(rp), intent(in) :: tension(:), u(:, :)
    real(rp), intent(inout) :: g(:, :)
    real(rp) :: dl, l, direction(3)
    integer :: s
    do s = 1, self%n
      call elongation(self, s, u, dl, l, direction)
      associate (i => self%nodes(1, s), j => self%nodes(2, s))
        g(:, i) = g(:, i) - tension(s)*direction
        g(:, j) = g(:, j) + tension(s)*direction
      end associate
    end do
  end subroutine tension_gradient

  !> Adds the tangent k t t^T + N/l (1 - t t^T) to `blocks` [N/m]. axial(n) [N] gives the axial force N of the geometric part; with
  !> the axial force of the law the tangent is the exact Hessian. `tension_only` leaves out compression, which makes the tangent
  !> positive semidefinite.
  pure subroutine extension_tangent(self, k, u, axial, tension_only, blocks)
    type(extensions_t), intent(in) :: self
    real(rp), intent(in) :: k(:), u(:, :), axial(:)
    logical, intent(in) :: tension_only
    real(rp), intent(inout) :: blocks(:, :, :)
    real(rp) :: dl, l, direction(3), e, force, slope, h(3, 3), geometric
    integer :: s, b
    do s = 1, self%n
      call elongation(self, s, u, dl, l, direction)
      call law(self, s, dl, e, force, slope)
      geometric = axial(s)/l
      if (tension_only) geometric = max(geometric, 0.0_rp)
      h = (k(s)*slope - geometric)*outer(direction, direction) + geometric*IDENTITY
      b = self%blocks(1, s)
      if (b > 0) blocks(:, :, b) = blocks(:, :, b) + h
      b = self%blocks(2, s)
      if (b > 0) blocks(:, :, b) = blocks(:, :, b) + h
      b = self%blocks(3, s)
      if (b > 0) blocks(:, :, b) = blocks(:, :, b) - h
    end do
  end subroutine extension_tangent

  !> Adds the derivative of that tangent, with the axial forces of the law, to `blocks` [N/m] when the displacements change along
  !> du(3, :) [m]. With d = du2 - du1: l' = t.d, t' = (d - l' t)/l, N' = k slope l'.
  pure subroutine extension_tangent_change(self, k, u, axial, du, blocks)
    type(extensions_t), intent(in) :: self
    real(rp), intent(in) :: k(:), u(:, :), axial(:), du(:, :)
    real(rp), intent(inout) :: blocks(:, :, :)
    real(rp) :: dl, l, t(3), e, force, slope, h(3, 3), d(3), stretch, turn(3), geometric, change
    integer :: s, b
    do s = 1, self%n
      d = du(:, self%nodes(2, s)) - du(:, self%nodes(1, s))
      if (.not. any(abs(d) > 0)) cycle
      call elongation(self, s, u, dl, l, t)
      call law(self, s, dl, e, force, slope)
      stretch = dot_product(t, d)
      turn = (d - stretch*t)/l
      geometric = axial(s)/l
      change = (k(s)*slope - geometric)*stretch/l
      h = (k(s)*law_curvature(self, s, dl)*stretch - change)*outer(t, t) + change*IDENTITY + &
          (k(s)*slope - geometric)*(outer(turn, t) + outer(t, turn))
      b = self%blocks(1, s)
      if (b > 0) blocks(:, :, b) = blocks(:, :, b) + h
      b = self%blocks(2, s)
      if (b > 0) blocks(:, :, b) = blocks(:, :, b) + h
      b = self%blocks(3, s)
      if (b > 0) blocks(:, :, b) = blocks(:, :, b) - h
    end do
  end subroutine extension_tangent_change

  !> Returns the elongation dl, the length l and the direction of spring s under the displacements u.
  pure subroutine elongation(self, s, u, dl, l, direction)
    type(extensions_t), intent(in) :: self
    integer, intent(in) :: s
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(out) :: dl, l, direction(3)
    real(rp) :: du(3), d(3)
    du = u(:, self%nodes(2, s)) - u(:, self%nodes(1, s))
    d = self%d0(:, s) + du
    l = sqrt(d(1)**2 + d(2)**2 + d(3)**2)
    dl = (du(1)*(self%d0(1, s) + d(1)) + du(2)*(self%d0(2, s) + d(2)) + du(3)*(self%d0(3, s) + d(3))) &
         /(l + self%l0(s))
    direction = d/l
  end subroutine elongation

  !> Returns energy, force and slope of a spring of unit stiffness.
  pure subroutine law(self, s, dl, energy, force, slope)
    type(extensions_t), intent(in) :: self
    integer, intent(in) :: s
    real(rp), intent(in) :: dl
    real(rp), intent(out) :: energy, force, slope
    real(rp) :: lost
    energy = 0.5_rp*dl**2
    force = dl
    slope = 1
    if (dl >= 0 .or. self%slack >= 1 .or. self%family(s) == SPRING_VEIN) return
    lost = 1 - self%slack
    if (dl > -self%width) then
      energy = energy + lost*dl**3/(6*self%width)
      force = dl + lost*dl**2/(2*self%width)
      slope = 1 + lost*dl/self%width
    else
      energy = 0.5_rp*self%slack*dl**2 - lost*self%width*(dl/2 + self%width/6)
      force = self%slack*dl - lost*self%width/2
      slope = self%slack
    end if
  end subroutine law

  !> Derivative of the slope of `law`.
  pure real(rp) function law_curvature(self, s, dl) result(curvature)
    type(extensions_t), intent(in) :: self
    integer, intent(in) :: s
    real(rp), intent(in) :: dl
    curvature = 0
    if (dl >= 0 .or. dl <= -self%width .or. self%slack >= 1 .or. self%family(s) == SPRING_VEIN) return
    curvature = (1 - self%slack)/self%width
  end function law_curvature
end module solid_extension

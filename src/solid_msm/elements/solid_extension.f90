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

  integer, parameter :: BATCH = 64 !< springs whose lengths are computed together, so that compilers use vectors

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
    real(rp) :: dl(BATCH), l(BATCH), direction(3, BATCH), e, force, slope, pull(3)
    integer :: s, i, j, b, begin
    do begin = 0, self%n - 1, BATCH
      call elongations(self, begin, u, dl, l, direction)
      do b = 1, min(BATCH, self%n - begin)
        s = begin + b
        i = self%nodes(1, s)
        j = self%nodes(2, s)
        if (present(low)) dl(b) = dl(b) + dot_product(direction(:, b), low(:, j) - low(:, i))
        force = dl(b)
        if (self%slack < 1) call law(self, s, dl(b), e, force, slope)
        pull = (k(s)*force)*direction(:, b)
        g(:, i) = g(:, i) - pull
        g(:, j) = g(:, j) + pull
      end do
    end do
  end subroutine extension_gradient

  !> Returns the axial forces [N], tension positive. With `step` (3, :) [m] they are the forces that the law, linearised at u,
  !> gives at u + step.
  pure subroutine extension_axial(self, k, u, axial, step)
    type(extensions_t), intent(in) :: self
    real(rp), intent(in) :: k(:), u(:, :)
    real(rp), intent(inout) :: axial(:)
    real(rp), intent(in), optional :: step(:, :)
    real(rp) :: dl(BATCH), l(BATCH), direction(3, BATCH), e, force, slope, change(3)
    integer :: s, b, begin
    do begin = 0, self%n - 1, BATCH
      call elongations(self, begin, u, dl, l, direction)
      do b = 1, min(BATCH, self%n - begin)
        s = begin + b
        force = dl(b)
        slope = 1
        if (self%slack < 1) call law(self, s, dl(b), e, force, slope)
        if (present(step)) then
          change = step(:, self%nodes(2, s)) - step(:, self%nodes(1, s))
          force = force + slope*(direction(1, b)*change(1) + direction(2, b)*change(2) + direction(3, b)*change(3))
        end if
        axial(s) = k(s)*force
      end do
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
    real(rp) :: dl(BATCH), l(BATCH), direction(3, BATCH), e, force, slope, h(3, 3), geometric
    integer :: s, b, c, i, begin
    do begin = 0, self%n - 1, BATCH
      call elongations(self, begin, u, dl, l, direction)
      do i = 1, min(BATCH, self%n - begin)
        s = begin + i
        slope = 1
        if (self%slack < 1) call law(self, s, dl(i), e, force, slope)
        geometric = axial(s)/l(i)
        if (tension_only) geometric = max(geometric, 0.0_rp)
        do c = 1, 3
          h(:, c) = ((k(s)*slope - geometric)*direction(c, i))*direction(:, i)
          h(c, c) = h(c, c) + geometric
        end do
        b = self%blocks(1, s)
        if (b > 0) blocks(:, :, b) = blocks(:, :, b) + h
        b = self%blocks(2, s)
        if (b > 0) blocks(:, :, b) = blocks(:, :, b) + h
        b = self%blocks(3, s)
        if (b > 0) blocks(:, :, b) = blocks(:, :, b) - h
      end do
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

  !> Returns elongations dl, lengths l and directions of the springs after number `begin`, as many as BATCH or as there are.
  pure subroutine elongations(self, begin, u, dl, l, direction)
    type(extensions_t), intent(in) :: self
    integer, intent(in) :: begin
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(out) :: dl(BATCH), l(BATCH), direction(3, BATCH)
    real(rp), dimension(BATCH) :: du1, du2, du3, d1, d2, d3
    integer :: b, s, n, i, j
    n = min(BATCH, self%n - begin)
    do b = 1, n
      s = begin + b
      i = self%nodes(1, s)
      j = self%nodes(2, s)
      du1(b) = u(1, j) - u(1, i)
      du2(b) = u(2, j) - u(2, i)
      du3(b) = u(3, j) - u(3, i)
      d1(b) = self%d0(1, s)
      d2(b) = self%d0(2, s)
      d3(b) = self%d0(3, s)
    end do
    do b = 1, n
      dl(b) = du1(b)*(2*d1(b) + du1(b)) + du2(b)*(2*d2(b) + du2(b)) + du3(b)*(2*d3(b) + du3(b))
      d1(b) = d1(b) + du1(b)
      d2(b) = d2(b) + du2(b)
      d3(b) = d3(b) + du3(b)
      l(b) = sqrt(d1(b)**2 + d2(b)**2 + d3(b)**2)
      dl(b) = dl(b)/(l(b) + self%l0(begin + b))
      du1(b) = 1/l(b)
    end do
    do b = 1, n
      direction(1, b) = d1(b)*du1(b)
      direction(2, b) = d2(b)*du1(b)
      direction(3, b) = d3(b)*du1(b)
    end do
  end subroutine elongations

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

! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes bending hinges of veins: E = k Theta^2/2 + k3 Theta^4/4 with the true turning angle Theta from the rest direction, so
!> that the moment is k Theta + k3 Theta^3; k3 is 0 for the usual hinge. A hinge with two sides has the additional energy k1 P(c)/2
!> when it bends toward the normal n, c = n.(tf - te) > 0, P(c) = 4 asin^2(c/2), which is Theta^2 if two flat halves fold.
!>
!> A hinge joins the segments e = xb - xa and f = xc - xb, with unit vectors te and tf. The rest direction of tf is te turned by the
!> signed reference angle theta0 about the material normal n, so that the rest curvature follows the membrane: n is the direction of
!> the summed area vectors of the triangles at both segments, or without a membrane the given normal of the plane. With w = tf -
!> Rot(n, theta0) te and s = |w|^2/4 = sin^2(Theta/2), E = k G(s)/2 + k3 G(s)^2/4, G = 4 asin^2(sqrt s). The energy is invariant
!> under rotations, resists both bending directions alike (circular sections), and a hinge with theta0 = 0 needs no normal. A hinge
!> does not resist torsion; the membrane does. A discrete rod in the sense of Bergou et al. (2008), doi:10.1145/1360612.1360662,
!> with the angle itself in the place of 2 tan(Theta/2).
module solid_hinge
  use base_kinds, only: rp
  use solid_hinge_hessian, only: add_rotation_part, add_side_part, add_turning_areas, add_unit_vector_curvature, &
                                 expand_hessian, projected, semidefinite_part, HINGE_NODES, NEXT
  use solid_vectors, only: cross
  implicit none
  private
  public :: hinge_t, hinge_evaluate, turning_law, HINGE_NODES

  !> One hinge a-b-c.
  type :: hinge_t
    integer :: n_nodes = 3
    integer :: nodes(HINGE_NODES) = 0   !< a, b, c, then the other corners of the triangles
    integer :: n_triangles = 0          !< at the segments; 0 with a rest angle: the normal is fixed
    integer :: corners(3, 4) = 0        !< of the triangles, as places in `nodes`
    real(rp) :: x0(3, HINGE_NODES) = 0  !< [m] stress-free positions
    real(rp) :: normal0(3) = 0          !< unit normal of the reference plane
    logical :: is_straight = .true.     !< theta0 = 0
    real(rp) :: cos0 = 1, sin0 = 0      !< of theta0
    !> upper part: places in the matrix, < 0 transposed, 0 clamped
    integer :: blocks(HINGE_NODES, HINGE_NODES) = 0
  end type hinge_t

  !> A hinge in its bent state. Vectors q are te, tf and n, in this order. All components are computed in each evaluation.
  type :: bend_t
    real(rp) :: t(3, 3), l(3)             !< unit vectors q and the lengths of e, f and A
    real(rp) :: w(3)
    real(rp) :: k, law(0:2)               !< k law/2 is the energy of the turn and its derivatives in s
    real(rp) :: side(0:2)                 !< k1 P/2 and its derivatives in c
    real(rp) :: sq(3, 3), cq(3, 3), gq(3, 3) !< ds/dq, dc/dq, dE/dq
    real(rp) :: levers(3, HINGE_NODES)    !< see find_levers
    logical :: has_normal                 !< n turns with the triangles and enters the energy
    integer :: n_q                        !< number of vectors that enter the energy
  end type bend_t

contains

  !> Returns the energy [J], and on request its gradient g(3, 7) [N] and Hessian h(21, 21) [N/m] with respect to the displacements
  !> u(3, 7) [m] of the nodes of the hinge, for `stiffness` [N m/rad], `cubic` k3 [N m/rad^3] and `lift` k1 [N m/rad], which needs
  !> a hinge with a normal. With `semidefinite` the Hessian is its positive semidefinite Gauss-Newton part. Unused nodes get zero.
  pure subroutine hinge_evaluate(self, stiffness, u, energy, g, h, semidefinite, cubic, lift)
    type(hinge_t), intent(in) :: self
    real(rp), intent(in) :: stiffness, u(3, HINGE_NODES)
    real(rp), intent(out) :: energy
    real(rp), intent(out), optional :: g(3, HINGE_NODES), h(3*HINGE_NODES, 3*HINGE_NODES)
    logical, intent(in), optional :: semidefinite
    real(rp), intent(in), optional :: cubic, lift
    type(bend_t) :: bend
    logical :: exact
    call directions(self, u, bend%t(:, 1), bend%t(:, 2), bend%t(:, 3), bend%l(1), bend%l(2), bend%l(3))
    bend%w = misfit(self, bend%t(:, 1), bend%t(:, 2), bend%t(:, 3))
    call find_laws(stiffness, bend, cubic, lift)
    energy = 0.5_rp*bend%k*bend%law(0)
    energy = energy + bend%side(0)
    if (.not. present(g) .and. .not. present(h)) return
    call find_slopes(self, bend)
    if (bend%has_normal) call find_levers(self, u, bend%levers)
    if (present(g)) call expand_gradient(self, bend, g)
    if (.not. present(h)) return
    exact = .true.
    if (present(semidefinite)) exact = .not. semidefinite
    call find_hessian(self, exact, bend, h)
  end subroutine hinge_evaluate

  !> Computes the laws of the turn and of the side.
  pure subroutine find_laws(stiffness, bend, cubic, lift)
    real(rp), intent(in) :: stiffness
    type(bend_t), intent(inout) :: bend
    real(rp), intent(in), optional :: cubic, lift
    bend%law = turning_law(0.25_rp*dot_product(bend%w, bend%w))
    bend%k = stiffness
    if (present(cubic)) then
      if (abs(cubic) > 0) then
        bend%law = cubic_law(bend%law, stiffness, cubic)
        bend%k = 1
      end if
    end if
    bend%side = 0
    if (present(lift)) then
      if (abs(lift) > 0) bend%side = 0.5_rp*lift*side_law(dot_product(bend%t(:, 3), bend%t(:, 2) - bend%t(:, 1)))
    end if
  end subroutine find_laws

  !> Computes ds/dq, dc/dq and dE/dq.
  pure subroutine find_slopes(self, bend)
    type(hinge_t), intent(in) :: self
    type(bend_t), intent(inout) :: bend
    real(rp) :: versine
    bend%has_normal = .not. self%is_straight .and. self%n_triangles > 0
    bend%n_q = merge(3, 2, bend%has_normal)
    versine = 1 - self%cos0
    associate (te => bend%t(:, 1), tf => bend%t(:, 2), n => bend%t(:, 3), w => bend%w, sq => bend%sq, cq => bend%cq)
      sq(:, 1) = -0.5_rp*w
      if (.not. self%is_straight) sq(:, 1) = -0.5_rp*(self%cos0*w - self%sin0*cross(n, w) + versine*dot_product(n, w)*n)
      sq(:, 2) = 0.5_rp*w
      sq(:, 3) = 0
      if (bend%has_normal) sq(:, 3) = -0.5_rp*(self%sin0*cross(te, w) &
                                               + versine*(dot_product(n, w)*te + dot_product(n, te)*w))
      cq(:, 1) = -n
      cq(:, 2) = n
      cq(:, 3) = tf - te
      bend%gq = (0.5_rp*bend%k*bend%law(1))*sq
      if (abs(bend%side(1)) > 0) bend%gq = bend%gq + bend%side(1)*cq
    end associate
  end subroutine find_slopes

  !> Computes g(3, 7) from dE/dq.
  pure subroutine expand_gradient(self, bend, g)
    type(hinge_t), intent(in) :: self
    type(bend_t), intent(in) :: bend
    real(rp), intent(out) :: g(3, HINGE_NODES)
    real(rp) :: arm(3)
    integer :: j
    g = 0
    arm = projected(bend%gq(:, 1), bend%t(:, 1), bend%l(1))
    g(:, 1) = -arm
    g(:, 2) = arm
    arm = projected(bend%gq(:, 2), bend%t(:, 2), bend%l(2))
    g(:, 2) = g(:, 2) - arm
    g(:, 3) = arm
    if (bend%has_normal) then
      arm = projected(bend%gq(:, 3), bend%t(:, 3), bend%l(3))
      do j = 1, self%n_nodes
        g(:, j) = g(:, j) + cross(arm, bend%levers(:, j))
      end do
    end if
  end subroutine expand_gradient

  !> Computes h(21, 21), or its positive semidefinite part, which leaves out the negative terms of the laws.
  pure subroutine find_hessian(self, exact, bend, h)
    type(hinge_t), intent(in) :: self
    logical, intent(in) :: exact
    type(bend_t), intent(inout) :: bend
    real(rp), intent(out) :: h(3*HINGE_NODES, 3*HINGE_NODES)
    real(rp) :: hq(3, 3, 3, 3)
    integer :: i, j
    associate (t => bend%t, l => bend%l, k => bend%k, law => bend%law, n_q => bend%n_q)
      if (.not. exact) law(1:) = max(law(1:), 0.0_rp)
      call semidefinite_part(self%cos0, self%sin0, n_q, t, l, bend%sq, 0.25_rp*k*law(1), 0.5_rp*k*law(2), hq)
      if (exact .and. bend%has_normal) call add_rotation_part(self%cos0, self%sin0, t, l, bend%w, 0.25_rp*k*law(1), hq)
      if (abs(bend%side(1)) > 0) call add_side_part(n_q, t, l, bend%side, bend%cq, exact, hq)
      if (exact) then
        do i = 1, n_q
          call add_unit_vector_curvature(bend%gq(:, i), t(:, i), l(i), hq(:, :, i, i))
        end do
      end if
      call expand_hessian(self%n_nodes, bend%has_normal, bend%levers, hq, h)
      if (exact .and. bend%has_normal) call add_turning_areas(self%corners(:, :self%n_triangles), &
                                                              projected(bend%gq(:, 3), t(:, 3), l(3)), h)
    end associate
    do j = 2, 3*self%n_nodes
      do i = 1, j - 1
        h(j, i) = h(i, j)
      end do
    end do
  end subroutine find_hessian

  !> Finds levers(3, :), for which dA/dx_m is the cross product with lever(:, m); e = xb - xa and f = xc - xb need no array.
  pure subroutine find_levers(self, u, levers)
    type(hinge_t), intent(in) :: self
    real(rp), intent(in) :: u(3, HINGE_NODES)
    real(rp), intent(out) :: levers(3, HINGE_NODES)
    integer :: t, i
    levers = 0
    do t = 1, self%n_triangles
      do i = 1, 3
        associate (m => self%corners(i, t), ahead => self%corners(NEXT(i), t), &
                   behind => self%corners(NEXT(NEXT(i)), t))
          levers(:, m) = levers(:, m) + self%x0(:, behind) + u(:, behind) - self%x0(:, ahead) - u(:, ahead)
        end associate
      end do
    end do
  end subroutine find_levers

  !> Returns P = 4 asin^2(c/2) for c > 0, else 0, and its first two derivatives.
  pure function side_law(c) result(law)
    real(rp), intent(in) :: c
    real(rp) :: law(0:2), g(0:2)
    law = 0
    if (.not. c > 0) return
    g = turning_law(c**2/4)
    law = [g(0), g(1)*c/2, g(2)*c**2/4 + g(1)/2]
  end function side_law

  !> Returns k G + k3 G^2/2, which is twice the energy, and its first two derivatives, from those of G.
  pure function cubic_law(g, k, k3) result(law)
    real(rp), intent(in) :: g(0:2), k, k3
    real(rp) :: law(0:2)
    law(0) = k*g(0) + 0.5_rp*k3*g(0)**2
    law(1) = (k + k3*g(0))*g(1)
    law(2) = (k + k3*g(0))*g(2) + k3*g(1)**2
  end function cubic_law

  !> Computes unit vectors along both segments, their lengths, the unit normal, and the length of the sum it comes from.
  pure subroutine directions(self, u, te, tf, n, le, lf, la)
    type(hinge_t), intent(in) :: self
    real(rp), intent(in) :: u(3, HINGE_NODES)
    real(rp), intent(out) :: te(3), tf(3), n(3), le, lf, la
    real(rp) :: x(3, 3)
    integer :: t, i
    te = (self%x0(:, 2) - self%x0(:, 1)) + (u(:, 2) - u(:, 1))
    tf = (self%x0(:, 3) - self%x0(:, 2)) + (u(:, 3) - u(:, 2))
    le = sqrt(dot_product(te, te))
    lf = sqrt(dot_product(tf, tf))
    te = te/le
    tf = tf/lf
    n = self%normal0
    la = 1
    if (self%is_straight .or. self%n_triangles == 0) return
    n = 0
    do t = 1, self%n_triangles
      do i = 1, 3
        x(:, i) = self%x0(:, self%corners(i, t)) + u(:, self%corners(i, t))
      end do
      n = n + cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1))
    end do
    la = sqrt(dot_product(n, n))
    n = n/la
  end subroutine directions

  !> Returns w = tf - Rot(n, theta0) te.
  pure function misfit(self, te, tf, n) result(w)
    type(hinge_t), intent(in) :: self
    real(rp), intent(in) :: te(3), tf(3), n(3)
    real(rp) :: w(3)
    w = tf - te
    if (self%is_straight) return
    w = tf - (self%cos0*te + self%sin0*cross(n, te) + ((1 - self%cos0)*dot_product(n, te))*n)
  end function misfit

  !> Returns G = 4 asin^2(sqrt s) = Theta^2 and its first two derivatives; the series avoids the cancellation at small angles. At
  !> Theta = pi the energy has a kink; s is kept just below 1.
  pure function turning_law(s) result(law)
    real(rp), intent(in) :: s
    real(rp) :: law(0:2)
    real(rp), parameter :: SERIES_BELOW = 1.0e-2_rp, LARGEST = 1 - 1.0e-10_rp
    integer, parameter :: TERMS = 10
    real(rp) :: a, q, r, coefficient, power
    integer :: n
    if (s < SERIES_BELOW) then
      law = 0
      coefficient = 4
      power = 1 ! s**(n-1)
      do n = 1, TERMS
        law(0) = law(0) + coefficient*power*s
        law(1) = law(1) + n*coefficient*power
        coefficient = coefficient*2*n**2/real((2*n + 1)*(n + 1), rp) ! of n + 1
        law(2) = law(2) + n*(n + 1)*coefficient*power
        power = power*s
      end do
    else
      q = min(s, LARGEST)
      a = asin(sqrt(q))
      r = q*(1 - q)
      law(0) = 4*a**2
      law(1) = 4*a/sqrt(r)
      law(2) = 2/r - 2*a*(1 - 2*q)/(r*sqrt(r))
    end if
  end function turning_law
end module solid_hinge

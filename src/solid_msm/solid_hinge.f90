! SPDX-License-Identifier: GPL-3.0-or-later
!> Bending hinges of veins: E = k Theta^2/2 + k3 Theta^4/4 with the true turning angle Theta from the rest direction, so
!> that the moment is k Theta + k3 Theta^3; k3 is 0 for the usual hinge. A hinge with two sides has k1 P(c)/2 more
!> when it bends toward the normal n, c = n.(tf - te) > 0, P(c) = 4 asin^2(c/2): Theta^2 where two flat halves fold.
!>
!> A hinge joins the segments e = xb - xa and f = xc - xb, with unit vectors te and tf. The rest
!> direction of tf is te turned by the signed reference angle theta0 about the material normal n, so
!> that rest curvature is carried by the membrane: n is the direction of the summed area vectors of
!> the triangles at both segments, or the given normal of the plane where there is no membrane. With
!> w = tf - Rot(n, theta0) te and s = |w|^2/4 = sin^2(Theta/2), E = k G(s)/2 + k3 G(s)^2/4,
!> G = 4 asin^2(sqrt s).
!> The energy is invariant under rotations, resists both bending directions alike (circular
!> sections), and a hinge with theta0 = 0 needs no normal. It has no torsion; the membrane carries it.
!> A discrete rod in the sense of Bergou et al. (2008), doi:10.1145/1360612.1360662, with the angle
!> itself in the place of 2 tan(Theta/2).
module solid_hinge
  use base_kinds, only: rp
  use solid_vectors, only: cross, skew, outer, IDENTITY
  implicit none
  private
  public :: hinge_t, hinge_evaluate, hinge_angle, turning_law

  integer, parameter, public :: HINGE_NODES = 7 !< most nodes of a hinge: a, b, c and four apexes

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

contains

  !> Energy [J], and on request its gradient g(3, 7) and Hessian h(21, 21) with respect to the
  !> displacements u(3, 7) of the hinge's nodes, for stiffness [N m/rad], `cubic` k3 [N m/rad^3] and
  !> `lift` k1 [N m/rad], which needs a hinge with a normal. With `semidefinite` the Hessian is the positive
  !> semidefinite Gauss-Newton part. Unused nodes are left zero.
  pure subroutine hinge_evaluate(self, stiffness, u, energy, g, h, semidefinite, cubic, lift)
    type(hinge_t), intent(in) :: self
    real(rp), intent(in) :: stiffness, u(3, HINGE_NODES)
    real(rp), intent(out) :: energy
    real(rp), intent(out), optional :: g(3, HINGE_NODES), h(3*HINGE_NODES, 3*HINGE_NODES)
    logical, intent(in), optional :: semidefinite
    real(rp), intent(in), optional :: cubic, lift
    real(rp) :: side(0:2), cq(3, 3) ! k1 P/2 and its derivatives, dc/dq
    real(rp) :: k, te(3), tf(3), n(3), le, lf, la, w(3), s, law(0:2)
    real(rp) :: wq(3, 3, 3)  ! dw/dq, q = te, tf, n
    real(rp) :: sq(3, 3)     ! ds/dq
    real(rp) :: p(3, 3, 3)   ! dq/d(e, f, A)
    real(rp) :: gq(3, 3), hq(3, 3, 3, 3), levers(3, HINGE_NODES), arm(3)
    logical :: exact, has_normal
    integer :: n_q, i, j, t

    call directions(self, u, te, tf, n, le, lf, la)
    w = misfit(self, te, tf, n)
    s = 0.25_rp*dot_product(w, w)
    law = turning_law(s)
    k = stiffness
    if (present(cubic)) then
      if (abs(cubic) > 0) then
        law = cubic_law(law, stiffness, cubic)
        k = 1
      end if
    end if
    energy = 0.5_rp*k*law(0)
    side = 0
    if (present(lift)) then
      if (abs(lift) > 0) side = 0.5_rp*lift*side_law(dot_product(n, tf - te))
    end if
    energy = energy + side(0)
    if (.not. present(g) .and. .not. present(h)) return

    has_normal = .not. self%is_straight .and. self%n_triangles > 0
    n_q = merge(3, 2, has_normal)
    wq(:, :, 1) = -IDENTITY
    if (.not. self%is_straight) wq(:, :, 1) = -(self%cos0*IDENTITY + self%sin0*skew(n) &
                                                + (1 - self%cos0)*outer(n, n))
    wq(:, :, 2) = IDENTITY
    wq(:, :, 3) = 0
    if (has_normal) wq(:, :, 3) = self%sin0*skew(te) &
                                  - (1 - self%cos0)*(outer(n, te) + dot_product(n, te)*IDENTITY)
    sq = 0
    do i = 1, n_q
      sq(:, i) = 0.5_rp*matmul(w, wq(:, :, i))
    end do
    p(:, :, 1) = (IDENTITY - outer(te, te))/le
    p(:, :, 2) = (IDENTITY - outer(tf, tf))/lf
    p(:, :, 3) = 0
    if (has_normal) p(:, :, 3) = (IDENTITY - outer(n, n))/la
    gq = (0.5_rp*k*law(1))*sq ! dE/d(te, tf, n)
    cq(:, 1) = -n
    cq(:, 2) = n
    cq(:, 3) = tf - te
    if (abs(side(1)) > 0) gq = gq + side(1)*cq

    ! dA/dx_m is the cross product with lever(:, m); e = xb - xa and f = xc - xb need no array
    levers = 0
    if (has_normal) then
      do t = 1, self%n_triangles
        do i = 1, 3
          associate (m => self%corners(i, t), ahead => self%corners(mod(i, 3) + 1, t), &
                     behind => self%corners(mod(i + 1, 3) + 1, t))
            levers(:, m) = levers(:, m) + self%x0(:, behind) + u(:, behind) - self%x0(:, ahead) - u(:, ahead)
          end associate
        end do
      end do
    end if

    if (present(g)) then
      g = 0
      arm = matmul(p(:, :, 1), gq(:, 1))
      g(:, 1) = -arm
      g(:, 2) = arm
      arm = matmul(p(:, :, 2), gq(:, 2))
      g(:, 2) = g(:, 2) - arm
      g(:, 3) = arm
      if (has_normal) then
        arm = matmul(p(:, :, 3), gq(:, 3))
        do j = 1, self%n_nodes
          g(:, j) = g(:, j) + cross(arm, levers(:, j))
        end do
      end if
    end if
    if (.not. present(h)) return

    exact = .true.
    if (present(semidefinite)) exact = .not. semidefinite
    if (.not. exact) law(1:) = max(law(1:), 0.0_rp)
    do j = 1, n_q
      do i = 1, n_q
        hq(:, :, i, j) = 0.5_rp*law(1)*matmul(transpose(wq(:, :, i)), wq(:, :, j)) &
                         + law(2)*outer(sq(:, i), sq(:, j))
      end do
    end do
    if (exact .and. has_normal) then
      hq(:, :, 3, 1) = hq(:, :, 3, 1) + 0.5_rp*law(1)*(self%sin0*skew(w) &
                                                       - (1 - self%cos0)*(outer(w, n) + dot_product(w, n)*IDENTITY))
      hq(:, :, 1, 3) = transpose(hq(:, :, 3, 1))
      hq(:, :, 3, 3) = hq(:, :, 3, 3) - 0.5_rp*law(1)*(1 - self%cos0)*(outer(w, te) + outer(te, w))
    end if
    do j = 1, n_q
      do i = 1, n_q
        hq(:, :, i, j) = (0.5_rp*k)*matmul(p(:, :, i), matmul(hq(:, :, i, j), p(:, :, j)))
      end do
    end do
    if (abs(side(1)) > 0) then
      do j = 1, n_q
        do i = 1, n_q
          hq(:, :, i, j) = hq(:, :, i, j) + matmul(p(:, :, i), matmul(side_curvature(i, j, side, cq, exact), &
                                                                      p(:, :, j)))
        end do
      end do
    end if
    if (exact) then
      hq(:, :, 1, 1) = hq(:, :, 1, 1) + unit_vector_curvature(gq(:, 1), te, le)
      hq(:, :, 2, 2) = hq(:, :, 2, 2) + unit_vector_curvature(gq(:, 2), tf, lf)
      if (has_normal) hq(:, :, 3, 3) = hq(:, :, 3, 3) + unit_vector_curvature(gq(:, 3), n, la)
    end if
    call expand_hessian(self%n_nodes, has_normal, levers, hq, h)
    if (.not. (exact .and. has_normal)) return
    arm = matmul(p(:, :, 3), gq(:, 3))
    do t = 1, self%n_triangles
      do i = 1, 3
        associate (m => 3*self%corners(i, t), ahead => 3*self%corners(mod(i, 3) + 1, t))
          h(m - 2:m, ahead - 2:ahead) = h(m - 2:m, ahead - 2:ahead) - skew(arm)
          h(ahead - 2:ahead, m - 2:m) = h(ahead - 2:ahead, m - 2:m) + skew(arm)
        end associate
      end do
    end do
  end subroutine hinge_evaluate

  !> Block (i, j) of the second derivatives of the side's energy in (te, tf, n), without the indefinite part unless
  !> `exact`.
  pure function side_curvature(i, j, side, cq, exact) result(m)
    integer, intent(in) :: i, j
    real(rp), intent(in) :: side(0:2), cq(3, 3)
    logical, intent(in) :: exact
    real(rp) :: m(3, 3)
    m = merge(side(2), max(side(2), 0.0_rp), exact)*outer(cq(:, i), cq(:, j))
    if (exact .and. i /= j .and. i + j == 4) m = m - side(1)*IDENTITY
    if (exact .and. i + j == 5) m = m + side(1)*IDENTITY
  end function side_curvature

  !> P = 4 asin^2(c/2) for c > 0, else 0, and its first two derivatives.
  pure function side_law(c) result(law)
    real(rp), intent(in) :: c
    real(rp) :: law(0:2), g(0:2)
    law = 0
    if (.not. c > 0) return
    g = turning_law(c**2/4)
    law = [g(0), g(1)*c/2, g(2)*c**2/4 + g(1)/2]
  end function side_law

  !> k G + k3 G^2/2, which is twice the energy, and its first two derivatives, from those of G.
  pure function cubic_law(g, k, k3) result(law)
    real(rp), intent(in) :: g(0:2), k, k3
    real(rp) :: law(0:2)
    law(0) = k*g(0) + 0.5_rp*k3*g(0)**2
    law(1) = (k + k3*g(0))*g(1)
    law(2) = (k + k3*g(0))*g(2) + k3*g(1)**2
  end function cubic_law

  !> h = B^T hq B with B = d(e, f, A)/dx: e = xb - xa, f = xc - xb, dA/dx_m the cross product with levers(:, m).
  pure subroutine expand_hessian(n_nodes, has_normal, levers, hq, h)
    integer, intent(in) :: n_nodes
    logical, intent(in) :: has_normal
    real(rp), intent(in) :: levers(3, HINGE_NODES), hq(3, 3, 3, 3)
    real(rp), intent(out) :: h(3*HINGE_NODES, 3*HINGE_NODES)
    real(rp) :: block(3, 3), mixed(3, 3, 3) ! mixed(:, :, m): rows of node m among a, b, c, columns of A
    integer :: i, j
    h = 0
    h(1:3, 1:3) = hq(:, :, 1, 1)
    h(1:3, 7:9) = -hq(:, :, 1, 2)
    h(7:9, 7:9) = hq(:, :, 2, 2)
    h(1:3, 4:6) = -h(1:3, 1:3) - h(1:3, 7:9)
    h(4:6, 7:9) = -h(1:3, 7:9) - h(7:9, 7:9)
    h(4:6, 4:6) = -h(1:3, 4:6) - transpose(h(4:6, 7:9))
    h(4:6, 1:3) = transpose(h(1:3, 4:6))
    h(7:9, 1:6) = transpose(h(1:6, 7:9))
    if (.not. has_normal) return
    mixed(:, :, 1) = -hq(:, :, 1, 3)
    mixed(:, :, 3) = hq(:, :, 2, 3)
    mixed(:, :, 2) = -mixed(:, :, 1) - mixed(:, :, 3)
    do j = 1, n_nodes
      do i = 1, 3
        call cross_columns(mixed(:, :, i), levers(:, j), block)
        h(3*i - 2:3*i, 3*j - 2:3*j) = h(3*i - 2:3*i, 3*j - 2:3*j) + block
        h(3*j - 2:3*j, 3*i - 2:3*i) = h(3*j - 2:3*j, 3*i - 2:3*i) + transpose(block)
      end do
    end do
    do j = 1, n_nodes
      call cross_columns(hq(:, :, 3, 3), levers(:, j), mixed(:, :, 1))
      mixed(:, :, 2) = transpose(mixed(:, :, 1))
      do i = 1, j
        call cross_columns(mixed(:, :, 2), levers(:, i), block)
        h(3*i - 2:3*i, 3*j - 2:3*j) = h(3*i - 2:3*i, 3*j - 2:3*j) + transpose(block)
        if (i < j) h(3*j - 2:3*j, 3*i - 2:3*i) = h(3*j - 2:3*j, 3*i - 2:3*i) + block
      end do
    end do
  end subroutine expand_hessian

  !> b = a skew(l): row by row the cross product of a's row and l.
  pure subroutine cross_columns(a, l, b)
    real(rp), intent(in) :: a(3, 3), l(3)
    real(rp), intent(out) :: b(3, 3)
    b(:, 1) = a(:, 2)*l(3) - a(:, 3)*l(2)
    b(:, 2) = a(:, 3)*l(1) - a(:, 1)*l(3)
    b(:, 3) = a(:, 1)*l(2) - a(:, 2)*l(1)
  end subroutine cross_columns

  !> Second derivative of gt.(v/|v|) with respect to v, where t = v/|v| and l = |v|.
  pure function unit_vector_curvature(gt, t, l) result(h)
    real(rp), intent(in) :: gt(3), t(3), l
    real(rp) :: h(3, 3), along, across(3)
    along = dot_product(gt, t)
    across = gt - along*t
    h = -(outer(across, t) + outer(t, across) + along*(IDENTITY - outer(t, t)))/l**2
  end function unit_vector_curvature

  !> The turning angle Theta >= 0 [rad] from the rest direction at displacements u(3, 7).
  pure real(rp) function hinge_angle(self, u) result(angle)
    type(hinge_t), intent(in) :: self
    real(rp), intent(in) :: u(3, HINGE_NODES)
    real(rp) :: te(3), tf(3), n(3), le, lf, la, w(3)
    call directions(self, u, te, tf, n, le, lf, la)
    w = misfit(self, te, tf, n)
    angle = 2*asin(min(1.0_rp, 0.5_rp*norm2(w)))
  end function hinge_angle

  pure subroutine directions(self, u, te, tf, n, le, lf, la)
    type(hinge_t), intent(in) :: self
    real(rp), intent(in) :: u(3, HINGE_NODES)
    real(rp), intent(out) :: te(3), tf(3), n(3), le, lf, la
    real(rp) :: x(3, 3)
    integer :: t, i
    te = (self%x0(:, 2) - self%x0(:, 1)) + (u(:, 2) - u(:, 1))
    tf = (self%x0(:, 3) - self%x0(:, 2)) + (u(:, 3) - u(:, 2))
    le = norm2(te)
    lf = norm2(tf)
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
    la = norm2(n)
    n = n/la
  end subroutine directions

  !> w = tf - Rot(n, theta0) te.
  pure function misfit(self, te, tf, n) result(w)
    type(hinge_t), intent(in) :: self
    real(rp), intent(in) :: te(3), tf(3), n(3)
    real(rp) :: w(3)
    w = tf - te
    if (self%is_straight) return
    w = tf - (self%cos0*te + self%sin0*cross(n, te) + ((1 - self%cos0)*dot_product(n, te))*n)
  end function misfit

  !> G = 4 asin^2(sqrt s) = Theta^2 and its first two derivatives; the series avoids the cancellation
  !> at small angles. At Theta = pi the energy has a kink; s is kept just below 1.
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

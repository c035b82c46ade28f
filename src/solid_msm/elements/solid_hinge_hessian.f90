! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the parts of the Hessian of a bending hinge, `solid_hinge`.
!>
!> With e, f and A the vectors of the two segments and of the areas beside them, t(:, 3) are the unit vectors te, tf, n and l(3)
!> their lengths. hq(:, :, i, j) are the second derivatives of the energy in the vectors i and j of (e, f, A); only the blocks i <=
!> j are used. Hinges dominate the cost of a tangent, and compilers do not inline small functions of another module. The products of
!> 3 x 3 matrices are therefore written out in this module.
module solid_hinge_hessian
  use base_kinds, only: rp
  use solid_vectors, only: IDENTITY
  implicit none
  private
  public :: semidefinite_part, add_rotation_part, add_side_part, add_unit_vector_curvature, expand_hessian, &
            add_turning_areas, projected

  integer, parameter, public :: HINGE_NODES = 7 !< most nodes of a hinge: a, b, c and four apexes
  integer, parameter, public :: NEXT(3) = [2, 3, 1] !< corner of a triangle

contains

  !> Sets the blocks i <= j of hq to a Wi^T Wj + b si sj^T, where W = dw/d(e, f, A) and s likewise.
  pure subroutine semidefinite_part(cos0, sin0, n_q, t, l, sq, a, b, hq)
    integer, intent(in) :: n_q
    real(rp), intent(in) :: cos0, sin0, t(3, 3), l(3), sq(3, 3), a, b
    real(rp), intent(inout) :: hq(3, 3, 3, 3)
    real(rp) :: wp(3, 3, 3), sp(3, 3), versine, image(3)
    integer :: i, j, r, c
    versine = 1 - cos0
    associate (n => t(:, 3))
      do c = 1, 3
        wp(:, c, 1) = -versine*n(c)*n
        wp(c, c, 1) = wp(c, c, 1) - cos0
      end do
      call add_skew(-sin0, n, wp(:, :, 1))
    end associate
    wp(:, :, 2) = IDENTITY
    if (n_q == 3) then
      associate (n => t(:, 3), te => t(:, 1))
        do c = 1, 3
          wp(:, c, 3) = -versine*te(c)*n
          wp(c, c, 3) = wp(c, c, 3) - versine*dot_product(n, te)
        end do
        call add_skew(sin0, te, wp(:, :, 3))
      end associate
    end if
    do i = 1, n_q
      image = wp(:, 1, i)*t(1, i) + wp(:, 2, i)*t(2, i) + wp(:, 3, i)*t(3, i)
      do c = 1, 3
        wp(:, c, i) = (wp(:, c, i) - t(c, i)*image)/l(i)
      end do
      sp(:, i) = projected(sq(:, i), t(:, i), l(i))
    end do
    do j = 1, n_q
      do i = 1, j
        do c = 1, 3
          do r = 1, 3
            hq(r, c, i, j) = a*(wp(1, r, i)*wp(1, c, j) + wp(2, r, i)*wp(2, c, j) + wp(3, r, i)*wp(3, c, j)) &
                             + b*sp(r, i)*sp(c, j)
          end do
        end do
      end do
    end do
  end subroutine semidefinite_part

  !> Adds a times the product of w and its second derivatives, which are those of Rot(n, theta0) te.
  pure subroutine add_rotation_part(cos0, sin0, t, l, w, a, hq)
    real(rp), intent(in) :: cos0, sin0, t(3, 3), l(3), w(3), a
    real(rp), intent(inout) :: hq(3, 3, 3, 3)
    real(rp) :: m(3, 3), versine, wn(3), ten(3)
    integer :: c
    versine = 1 - cos0
    associate (te => t(:, 1), n => t(:, 3))
      do c = 1, 3
        m(:, c) = -versine*a*w(c)*n
        m(c, c) = m(c, c) - versine*a*dot_product(w, n)
      end do
      call add_skew(-sin0*a, w, m)
      call add_projected(m, te, l(1), n, l(3), hq(:, :, 1, 3))
      wn = projected(w, n, l(3))
      ten = projected(te, n, l(3))
    end associate
    do c = 1, 3
      hq(:, c, 3, 3) = hq(:, c, 3, 3) - versine*a*(wn*ten(c) + ten*wn(c))
    end do
  end subroutine add_rotation_part

  !> Adds the second derivatives of the energy of the side. It leaves out their indefinite part unless `exact`.
  pure subroutine add_side_part(n_q, t, l, side, cq, exact, hq)
    integer, intent(in) :: n_q
    real(rp), intent(in) :: t(3, 3), l(3), side(0:2), cq(3, 3)
    logical, intent(in) :: exact
    real(rp), intent(inout) :: hq(3, 3, 3, 3)
    real(rp) :: cp(3, 3), curvature
    integer :: i, j, c
    curvature = merge(side(2), max(side(2), 0.0_rp), exact)
    do j = 1, n_q
      cp(:, j) = projected(cq(:, j), t(:, j), l(j))
      do i = 1, j
        do c = 1, 3
          hq(:, c, i, j) = hq(:, c, i, j) + curvature*cp(c, j)*cp(:, i)
        end do
      end do
    end do
    if (.not. exact .or. n_q < 3) return
    call add_projected(-side(1)*IDENTITY, t(:, 1), l(1), t(:, 3), l(3), hq(:, :, 1, 3))
    call add_projected(side(1)*IDENTITY, t(:, 2), l(2), t(:, 3), l(3), hq(:, :, 2, 3))
  end subroutine add_side_part

  !> Adds the second derivative of gt.(v/|v|) with respect to v, where t = v/|v| and l = |v|.
  pure subroutine add_unit_vector_curvature(gt, t, l, h)
    real(rp), intent(in) :: gt(3), t(3), l
    real(rp), intent(inout) :: h(3, 3)
    real(rp) :: along, across(3)
    integer :: c
    along = dot_product(gt, t)
    across = gt - along*t
    do c = 1, 3
      h(:, c) = h(:, c) - (t(c)*across + (across(c) - along*t(c))*t)/l**2
      h(c, c) = h(c, c) - along/l**2
    end do
  end subroutine add_unit_vector_curvature

  !> Sets the upper triangle of h to B^T hq B with B = d(e, f, A)/dx. The vectors are e = xb - xa and f = xc - xb; dA/dx_m is the
  !> cross product with levers(:, m).
  pure subroutine expand_hessian(n_nodes, has_normal, levers, hq, h)
    integer, intent(in) :: n_nodes
    logical, intent(in) :: has_normal
    real(rp), intent(in) :: levers(3, HINGE_NODES), hq(3, 3, 3, 3)
    real(rp), intent(out) :: h(3*HINGE_NODES, 3*HINGE_NODES)
    real(rp) :: mixed(3, 3, 3) ! mixed(:, :, m): rows of node m among a, b, c, columns of A
    real(rp) :: rows(3, 3), block(3, 3)
    integer :: i, j, c
    h = 0
    h(1:3, 1:3) = hq(:, :, 1, 1)
    h(1:3, 7:9) = -hq(:, :, 1, 2)
    h(7:9, 7:9) = hq(:, :, 2, 2)
    h(1:3, 4:6) = -h(1:3, 1:3) - h(1:3, 7:9)
    h(4:6, 7:9) = -h(1:3, 7:9) - h(7:9, 7:9)
    h(4:6, 4:6) = -h(1:3, 4:6) - transpose(h(4:6, 7:9))
    if (.not. has_normal) return
    mixed(:, :, 1) = -hq(:, :, 1, 3)
    mixed(:, :, 3) = hq(:, :, 2, 3)
    mixed(:, :, 2) = -mixed(:, :, 1) - mixed(:, :, 3)
    do i = 1, n_nodes
      call cross_columns(hq(:, :, 3, 3), levers(:, i), block)
      rows = transpose(block)
      if (i <= 3) rows = rows + mixed(:, :, i)
      do j = i, n_nodes
        associate (l => levers(:, j), m => 3*i - 3, k => 3*j - 3)
          do c = 1, 3
            h(m + c, k + 1) = h(m + c, k + 1) + rows(c, 2)*l(3) - rows(c, 3)*l(2)
            h(m + c, k + 2) = h(m + c, k + 2) + rows(c, 3)*l(1) - rows(c, 1)*l(3)
            h(m + c, k + 3) = h(m + c, k + 3) + rows(c, 1)*l(2) - rows(c, 2)*l(1)
          end do
        end associate
      end do
    end do
    do j = 1, 3
      do i = 1, j
        call cross_columns(mixed(:, :, j), levers(:, i), block)
        h(3*i - 2:3*i, 3*j - 2:3*j) = h(3*i - 2:3*i, 3*j - 2:3*j) + transpose(block)
      end do
    end do
  end subroutine expand_hessian

  !> Adds to the upper triangle of h the second derivatives of the area vector; arm = dE/dA.
  pure subroutine add_turning_areas(corners, arm, h)
    integer, intent(in) :: corners(:, :)
    real(rp), intent(in) :: arm(3)
    real(rp), intent(inout) :: h(3*HINGE_NODES, 3*HINGE_NODES)
    integer :: t, i, m, ahead
    do t = 1, size(corners, 2)
      do i = 1, 3
        m = corners(i, t)
        ahead = corners(NEXT(i), t)
        if (m < ahead) then
          call add_skew(-1.0_rp, arm, h(3*m - 2:3*m, 3*ahead - 2:3*ahead))
        else
          call add_skew(1.0_rp, arm, h(3*ahead - 2:3*ahead, 3*m - 2:3*m))
        end if
      end do
    end do
  end subroutine add_turning_areas

  !> Returns the derivative of v/|v| = t, |v| = l, applied to a: (1 - t t^T) a/l.
  pure function projected(a, t, l) result(b)
    real(rp), intent(in) :: a(3), t(3), l
    real(rp) :: b(3)
    b = (a - (a(1)*t(1) + a(2)*t(2) + a(3)*t(3))*t)/l
  end function projected

  !> Adds p1 m p2 to h, with the derivatives p of both unit vectors.
  pure subroutine add_projected(m, t1, l1, t2, l2, h)
    real(rp), intent(in) :: m(3, 3), t1(3), l1, t2(3), l2
    real(rp), intent(inout) :: h(3, 3)
    real(rp) :: image(3)
    integer :: c
    image = m(:, 1)*t2(1) + m(:, 2)*t2(2) + m(:, 3)*t2(3)
    do c = 1, 3
      h(:, c) = h(:, c) + projected(m(:, c) - t2(c)*image, t1, l1)/l2
    end do
  end subroutine add_projected

  !> Adds f [a]x to m, where [a]x is the matrix of the vector product with `a`.
  pure subroutine add_skew(f, a, m)
    real(rp), intent(in) :: f, a(3)
    real(rp), intent(inout) :: m(:, :) ! a part of a Hessian is not copied
    m(2, 1) = m(2, 1) + f*a(3)
    m(3, 1) = m(3, 1) - f*a(2)
    m(1, 2) = m(1, 2) - f*a(3)
    m(3, 2) = m(3, 2) + f*a(1)
    m(1, 3) = m(1, 3) + f*a(2)
    m(2, 3) = m(2, 3) - f*a(1)
  end subroutine add_skew

  !> Computes b = a skew(l): row by row the cross product of a's row and l.
  pure subroutine cross_columns(a, l, b)
    real(rp), intent(in) :: a(3, 3), l(3)
    real(rp), intent(out) :: b(3, 3)
    b(:, 1) = a(:, 2)*l(3) - a(:, 3)*l(2)
    b(:, 2) = a(:, 3)*l(1) - a(:, 1)*l(3)
    b(:, 3) = a(:, 1)*l(2) - a(:, 2)*l(1)
  end subroutine cross_columns
end module solid_hinge_hessian

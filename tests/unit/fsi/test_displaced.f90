! SPDX-License-Identifier: GPL-3.0-or-later
!> The free edge of a sheet and the fluid that a sheet displaces, against closed forms.
!>
!> At a corner that points into the sheet (turning -phi) the tubes around both edges meet in the bisecting plane:
!> the true term is -(t^3/6) tan(phi/2), displaced_volumes has -(t^3/12) phi, its first order. For a right angle
!> that is 0.036 t^3 too much for each such corner.
program test_displaced
  use base_constants, only: PI
  use base_kinds, only: rp
  use fsi_displaced, only: displaced_volumes
  use fsi_free_edges, only: find_free_edges
  use fsi_planform, only: elliptic_planform, rectangular_planform
  use fsi_planform_mesh, only: triangulate_planform
  use fsi_rotation, only: cross
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: T = 0.11_rp
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call test_edges()
  call test_rectangle()
  call test_ellipse()
  call test_l_shape()
  call test_orientation()
  call kit%finish()

contains

  !> A square with a square hole, of twelve triangles with one orientation: the outline counter-clockwise, the
  !> hole clockwise.
  subroutine test_edges()
    integer :: triangles(3, 8), i, next(8), length
    integer, allocatable :: edges(:, :)
    ! Points 1 .. 4 are the corners outside, 5 .. 8 those of the hole, both counter-clockwise.
    do i = 1, 4
      triangles(:, 2*i - 1) = [i, mod(i, 4) + 1, i + 4]
      triangles(:, 2*i) = [mod(i, 4) + 1, mod(i, 4) + 5, i + 4]
    end do
    call find_free_edges(8, triangles, edges)
    call kit%check('a square with a hole has eight free edges', size(edges, 2) == 8)
    next = 0
    do i = 1, size(edges, 2)
      next(edges(1, i)) = edges(2, i)
    end do
    call kit%check('they turn counter-clockwise outside and clockwise around the hole', &
                   all(next == [2, 3, 4, 1, 8, 5, 6, 7]))
    length = size(edges, 2)
    call find_free_edges(8, triangles(:, 8:1:-1), edges)
    call kit%check('the order of the triangles does not matter to what they are', size(edges, 2) == length)
    call find_free_edges(8, triangles(:, 1:0), edges)
    call kit%check('no triangle, no edge', size(edges, 2) == 0)
    call find_free_edges(8, triangles(:, 1:1), edges)
    call kit%check('one triangle has three', size(edges, 2) == 3 .and. all(edges(1, :) == triangles(:, 1)))
  end subroutine test_edges

  !> The sum, and what a rigid rotation about an edge stores: the points weigh linear functions exactly,
  !> quadratic ones to second order of the edge length.
  subroutine test_rectangle()
    real(rp), parameter :: A = 1.0_rp, B = 0.4_rp, EDGES(3) = [0.1_rp, 0.05_rp, 0.025_rp]
    real(rp), allocatable :: points(:, :), volumes(:)
    integer, allocatable :: triangles(:, :)
    real(rp) :: exact, error(3)
    integer :: i
    do i = 1, size(EDGES)
      call triangulate_planform(rectangular_planform(0.0_rp, A, B, 0.5_rp), EDGES(i), points, triangles)
      call displaced_volumes(points, triangles, T, volumes)
      call kit%check_close('a rectangle displaces A t + pi t^2 P/8 + pi t^3/6', sum(volumes), &
                           A*B*T + PI*T**2*2*(A + B)/8 + PI*T**3/6, rtol=1.0e-14_rp)
      call kit%check_close('with its centre in the middle', sum(volumes*points(1, :)), sum(volumes)*A/2, &
                           rtol=1.0e-13_rp)
      call kit%check('no point displaces less than nothing', all(volumes > 0))
      ! int chi y^2: interior, the edges y = +-B/2 and the two others, four corners.
      exact = T*A*B**3/12 + PI*T**2/8*(2*A*B**2/4 + 2*B**3/12) + T**3/12*2*PI*B**2/4
      error(i) = abs(sum(volumes*points(2, :)**2)/exact - 1)
    end do
    call kit%check_order('its inertia about the span', EDGES, error, 2.0_rp, 0.3_rp)
    call kit%check_below('which at the default edge length is known to 1 %', error(3), 0.01_rp)
  end subroutine test_rectangle

  !> The polygon of the triangles has the closed form exactly; it approaches the ellipse to second order.
  subroutine test_ellipse()
    real(rp), parameter :: A = 0.5_rp, B = 0.2_rp, LENGTHS(3) = [0.1_rp, 0.05_rp, 0.025_rp]
    real(rp), allocatable :: points(:, :), volumes(:)
    integer, allocatable :: triangles(:, :), edges(:, :)
    real(rp) :: area, perimeter, h, ellipse, error(3)
    integer :: i, k
    ! Ramanujan's perimeter, exact to 1e-6 here.
    h = ((A - B)/(A + B))**2
    ellipse = PI*A*B*T + PI*T**2/8*PI*(A + B)*(1 + 3*h/(10 + sqrt(4 - 3*h))) + PI*T**3/6
    do i = 1, size(LENGTHS)
      call triangulate_planform(elliptic_planform(0.0_rp, 2*A, PI/2*B, 0.5_rp), LENGTHS(i), points, triangles)
      call displaced_volumes(points, triangles, T, volumes)
      call find_free_edges(size(points, 2), triangles, edges)
      area = 0
      perimeter = 0
      do k = 1, size(edges, 2)
        associate (p => points(:, edges(1, k)), q => points(:, edges(2, k)))
          area = area + (p(1)*q(2) - p(2)*q(1))/2
          perimeter = perimeter + norm2(q - p)
        end associate
      end do
      call kit%check_close('a polygon displaces A t + pi t^2 P/8 + pi t^3/6', sum(volumes), &
                           area*T + PI*T**2*perimeter/8 + PI*T**3/6, rtol=1.0e-13_rp)
      error(i) = abs(sum(volumes)/ellipse - 1)
    end do
    call kit%check_below('and an ellipse what its polygon does', error(3), 2.0e-3_rp)
    call kit%check('the better the finer the edges', error(2) < error(1)/3 .and. error(3) < error(2)/3)

  end subroutine test_ellipse

  !> An L of squares: momentum and torque of a rigid rotation to round-off.
  subroutine test_l_shape()
    integer, parameter :: N = 10, M = 8, CUT_X = 4, CUT_Y = 3
    real(rp), parameter :: S = 0.1_rp, OMEGA(3) = [3.0_rp, -7.0_rp, 2.0_rp]
    real(rp) :: corner(2, 6), turning(6), area, perimeter, first(2), momentum(3), middle(3)
    real(rp), allocatable :: points(:, :), volumes(:)
    integer, allocatable :: triangles(:, :)
    integer :: i, next
    call make_l(N, M, CUT_X, CUT_Y, S, points, triangles)
    call displaced_volumes(points, triangles, T, volumes)
    corner = S*reshape([0, 0, N, 0, N, CUT_Y, CUT_X, CUT_Y, CUT_X, M, 0, M], [2, 6])
    turning = PI/2*[1, 1, 1, -1, 1, 1]
    area = S**2*(N*CUT_Y + CUT_X*(M - CUT_Y))
    perimeter = 2*S*(N + M)
    call kit%check_close('an L displaces A t + pi t^2 P/8 + pi t^3/6', sum(volumes), &
                         area*T + PI*T**2*perimeter/8 + PI*T**3/6, rtol=1.0e-14_rp)
    ! int chi x and int chi y: two rectangles, six edges, six corners.
    first = T*S**3*(N*CUT_Y*[N, CUT_Y] + CUT_X*(M - CUT_Y)*[CUT_X, M + CUT_Y])/2
    do i = 1, 6
      next = mod(i, 6) + 1
      first = first + PI*T**2/8*norm2(corner(:, next) - corner(:, i))*(corner(:, i) + corner(:, next))/2 + &
              T**3/12*turning(i)*corner(:, i)
    end do
    call kit%check_below('its centre is that of interior, edges and corners', &
                         maxval(abs(matmul(points(1:2, :), volumes) - first)), 1.0e-15_rp)
    momentum = 0
    do i = 1, size(points, 2)
      momentum = momentum + volumes(i)*cross(OMEGA, points(:, i))
    end do
    middle = [first(1), first(2), 0.0_rp]
    call kit%check_below('its momentum in a rigid rotation is the exact integral', &
                         maxval(abs(momentum - cross(OMEGA, middle))), 1.0e-14_rp)
  end subroutine test_l_shape

  !> Squares of side s, two triangles each, of an n x m rectangle without what is beyond both cuts.
  subroutine make_l(n, m, cut_x, cut_y, s, points, triangles)
    integer, intent(in) :: n, m, cut_x, cut_y
    real(rp), intent(in) :: s
    real(rp), allocatable, intent(out) :: points(:, :)
    integer, allocatable, intent(out) :: triangles(:, :)
    integer :: number(0:n, 0:m), i, j, k
    number = 0
    k = 0
    allocate (points(3, (n + 1)*(m + 1)), triangles(3, 2*n*m))
    do j = 0, m
      do i = 0, n
        if (i > cut_x .and. j > cut_y) cycle
        k = k + 1
        number(i, j) = k
        points(:, k) = s*[i, j, 0]
      end do
    end do
    points = points(:, :k)
    k = 0
    do j = 0, m - 1
      do i = 0, n - 1
        if (i >= cut_x .and. j >= cut_y) cycle
        triangles(:, k + 1) = [number(i, j), number(i + 1, j), number(i + 1, j + 1)]
        triangles(:, k + 2) = [number(i, j), number(i + 1, j + 1), number(i, j + 1)]
        k = k + 2
      end do
    end do
    triangles = triangles(:, :k)
  end subroutine make_l

  !> Neither the side from which the triangles are seen nor where the sheet lies in space matters.
  subroutine test_orientation()
    real(rp), allocatable :: points(:, :), turned(:, :), volumes(:), other(:)
    integer, allocatable :: triangles(:, :)
    real(rp), parameter :: TURN(3, 3) = reshape([0.0_rp, 0.8_rp, 0.6_rp, 0.0_rp, -0.6_rp, 0.8_rp, 1.0_rp, 0.0_rp, &
                                                 0.0_rp], [3, 3])
    call make_l(5, 4, 2, 2, 0.2_rp, points, triangles)
    call displaced_volumes(points, triangles, T, volumes)
    call displaced_volumes(points, triangles([1, 3, 2], :), T, other)
    call kit%check_below('a sheet seen from below displaces the same', maxval(abs(volumes - other)), 1.0e-16_rp)
    turned = matmul(TURN, points) + 0.5_rp
    call displaced_volumes(turned, triangles, T, other)
    call kit%check_below('as does a turned one', maxval(abs(volumes - other)), 1.0e-16_rp)
  end subroutine test_orientation
end program test_displaced

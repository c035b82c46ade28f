! SPDX-License-Identifier: GPL-3.0-or-later
!> Twist, camber and trailing edge of wings that are bent as formulas say.
!>
!> Between the points of the mesh displacements are linear: on a mesh with points on the sections the formulas
!> hold to round-off, on another one to second order of the edge length.
program test_wing_shape
  use base_kinds, only: rp
  use fsi_planform, only: elliptic_planform, rectangular_planform
  use fsi_planform_mesh, only: triangulate_planform
  use fsi_wing_shape, only: section_t, wing_shape_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: FRACTIONS(3) = [0.25_rp, 0.5_rp, 0.75_rp]
  real(rp), parameter :: CHORD = 0.4_rp, TWISTED = 0.7_rp, CAMBERED = 0.12_rp, BENT = 0.3_rp
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call test_plate()
  call test_mirror()
  call test_order()
  call test_missing()
  call kit%finish()

contains

  !> A rectangle 0 <= x <= 1, 0 <= y <= CHORD in n x n squares of two triangles.
  subroutine make_plate(n, points, triangles)
    integer, intent(in) :: n
    real(rp), allocatable, intent(out) :: points(:, :)
    integer, allocatable, intent(out) :: triangles(:, :)
    integer :: i, j, p, k
    allocate (points(3, (n + 1)**2), triangles(3, 2*n**2))
    k = 0
    do j = 0, n
      do i = 0, n
        p = 1 + i + (n + 1)*j
        points(:, p) = [real(i, rp)/n, CHORD*j/n, 0.0_rp]
        if (i == n .or. j == n) cycle
        triangles(:, k + 1) = [p, p + 1, p + n + 2]
        triangles(:, k + 2) = [p, p + n + 2, p + n + 1]
        k = k + 2
      end do
    end do
  end subroutine make_plate

  !> A wing whose triangles begin beyond a section has none there, and the others as ever.
  subroutine test_missing()
    real(rp), allocatable :: points(:, :), u(:, :)
    integer, allocatable :: triangles(:, :)
    type(wing_shape_t) :: shape
    type(section_t) :: sections(3), shifted(3)
    call make_plate(8, points, triangles)
    u = twist(points)
    points(1, :) = points(1, :) + 1
    call shape%init(points, triangles, FRACTIONS, upper=1.0_rp)
    call kit%check('from 50 to 100 % of the span there is no section at 25 %',.not. shape%has(1))
    call kit%check('at 75 % there is', shape%has(3))
    call shape%measure(u, sections)
    call kit%check('where there is none all is 0', abs(sections(1)%trailing) + abs(sections(1)%twist) + &
                   abs(sections(1)%camber) <= 0)
    points(1, :) = points(1, :) - 1
    call shape%init(points, triangles, FRACTIONS, upper=1.0_rp)
    call shape%measure(u, shifted)
    call kit%check_close('75 % of the one is 50 % of the other', sections(3)%twist, shifted(2)%twist, rtol=1.0e-12_rp)
  end subroutine test_missing

  !> Displacement: every section turned by TWISTED x about the trailing edge y = 0, which rises by BENT x^2.
  pure function twist(points) result(u)
    real(rp), intent(in) :: points(:, :)
    real(rp) :: u(3, size(points, 2))
    u(1, :) = 0
    u(2, :) = points(2, :)*(cos(TWISTED*points(1, :)) - 1)
    u(3, :) = points(2, :)*sin(TWISTED*points(1, :)) + BENT*points(1, :)**2
  end function twist

  !> Displacement: a parabola over the chord whose height grows along the span to CAMBERED chords.
  pure function camber(points) result(u)
    real(rp), intent(in) :: points(:, :)
    real(rp) :: u(3, size(points, 2))
    u(1:2, :) = 0
    u(3, :) = 4*CAMBERED*points(1, :)*points(2, :)*(CHORD - points(2, :))/CHORD
  end function camber

  subroutine test_plate()
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    type(wing_shape_t) :: shape
    type(section_t) :: s(3)
    call make_plate(8, points, triangles)
    call shape%init(points, triangles, FRACTIONS, upper=1.0_rp)
    call shape%measure(0*points, s)
    call kit%check('a flat wing has none of all', all(abs(s%twist) + abs(s%camber) + abs(s%trailing) <= 0))
    call shape%measure(twist(points), s)
    call kit%check_below('a twisted wing has its angles', maxval(abs(s%twist - TWISTED*FRACTIONS)), 1.0e-14_rp)
    call kit%check_below('and no camber', maxval(abs(s%camber)), 1.0e-14_rp)
    call kit%check_below('its trailing edge is bent', maxval(abs(s%trailing - BENT*FRACTIONS**2)), 1.0e-15_rp)
    call shape%measure(camber(points), s)
    call kit%check_below('a cambered wing has its camber', maxval(abs(s%camber - CAMBERED*FRACTIONS)), 1.0e-14_rp)
    call kit%check_below('and no twist', maxval(abs(s%twist)), 1.0e-14_rp)
    call shape%measure(-camber(points), s)
    call kit%check_below('with a sign', maxval(abs(s%camber + CAMBERED*FRACTIONS)), 1.0e-14_rp)
    call shape%measure(both(points), s)
    call kit%check_below('camber does not depend on twist', maxval(abs(s%camber - CAMBERED*FRACTIONS)), 1.0e-14_rp)
    call kit%check_below('nor twist on camber', maxval(abs(s%twist - 2.0_rp)), 1.0e-14_rp)
  end subroutine test_plate

  !> The cambered wing, turned as a whole by 2 rad about the x axis.
  pure function both(points) result(u)
    real(rp), intent(in) :: points(:, :)
    real(rp) :: u(3, size(points, 2)), x(3, size(points, 2))
    x = points + camber(points)
    u = x
    u(2, :) = cos(2.0_rp)*x(2, :) - sin(2.0_rp)*x(3, :)
    u(3, :) = sin(2.0_rp)*x(2, :) + cos(2.0_rp)*x(3, :)
    u = u - points
  end function both

  !> The mirror image has the same numbers.
  subroutine test_mirror()
    real(rp), allocatable :: points(:, :), u(:, :)
    integer, allocatable :: triangles(:, :)
    type(wing_shape_t) :: shape
    type(section_t) :: a(3), b(3)
    call make_plate(8, points, triangles)
    u = twist(points) + camber(points)
    call shape%init(points, triangles, FRACTIONS, upper=1.0_rp)
    call shape%measure(u, a)
    call shape%init(points, triangles, FRACTIONS, upper=-1.0_rp)
    u(3, :) = -u(3, :)
    call shape%measure(u, b)
    call kit%check('a mirror image has the same numbers', all(abs(a%twist - b%twist) + abs(a%camber - b%camber) + &
                                                              abs(a%trailing - b%trailing) <= 0))
  end subroutine test_mirror

  !> On triangles of any shape.
  subroutine test_order()
    real(rp), parameter :: EDGES(3) = [0.08_rp, 0.04_rp, 0.02_rp]
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    type(wing_shape_t) :: shape
    type(section_t) :: s(3)
    real(rp) :: error(3)
    integer :: i
    do i = 1, size(EDGES)
      call triangulate_planform(elliptic_planform(0.0_rp, 1.0_rp, CHORD, 0.5_rp), EDGES(i), points, triangles)
      call shape%init(points, triangles, FRACTIONS, upper=1.0_rp)
      call shape%measure(twist(points), s)
      error(i) = maxval(abs(s%twist - TWISTED*FRACTIONS))
    end do
    ! A chord of the mesh differs from the true one by h^2/8 times its curvature TWISTED^2, over the chord.
    call kit%check_below('the twist on another mesh', error(1), EDGES(1)**2*TWISTED)
    call kit%check('the better the finer it is', error(3) < error(1)/4)
  end subroutine test_order
end program test_wing_shape

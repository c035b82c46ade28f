! SPDX-License-Identifier: GPL-3.0-or-later
!> Distance from a point to a triangle, against brute-force minimisation over the barycentric coordinates and
!> against the condition of a closest point of a convex set: (p - q).(x - q) <= 0 for all of its points x.
program test_triangle
  use base_kinds, only: rp
  use base_random, only: random_stream_t
  use fsi_triangle, only: triangle_t, make_triangle
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: kit
  type(random_stream_t) :: random
  real(rp), parameter :: SIZES(3) = [1.0e-6_rp, 1.0_rp, 1.0e3_rp]
  real(rp) :: a(3), b(3), c(3), worst(4), height
  integer :: i, k

  call kit%start(parallel=.false.)
  random%seed = 1
  call test_regions()

  worst = 0
  do i = 1, 300
    a = random_point()
    b = random_point()
    c = random_point()
    call try_points(a, b, c, 3)
  end do
  call report('random triangles', 1.0e-13_rp)

  do k = 1, size(SIZES)
    do i = 1, 30
      a = SIZES(k)*random_point()
      b = SIZES(k)*random_point()
      c = SIZES(k)*random_point()
      call try_points(a, b, c, 1)
    end do
  end do
  call report('triangles of 1e-6, 1 and 1e3', 1.0e-13_rp)

  do i = 1, 20
    a = random_point()
    b = random_point()
    call try_points(a, a, a, 1)
    call try_points(a, b, b, 1)
    call try_points(b, a, b, 1)
    call try_points(b, b, a, 1)
    call try_points(a, b, (a + b)/2, 1)
    call try_points(a, b, 3*b - 2*a, 1)
    call try_points(b, a, b + 0.3_rp*(b - a), 1)
  end do
  call report('points and segments instead of triangles', 1.0e-13_rp)

  ! Needles: their distance may err by the height below which they are taken as segments.
  do k = 2, 17
    height = 10.0_rp**(-k)
    do i = 1, 20
      a = random_point()
      b = random_point()
      c = a + (b - a)*(2*random_number_01() - 0.5_rp) + height*random_point()
      call try_points(a, b, c, 1)
    end do
  end do
  call report('needles of heights 1e-2 .. 1e-17', 1.0e-8_rp)
  call kit%finish()

contains

  !> Uniform in the cube (-1, 1)^3.
  function random_point() result(p)
    real(rp) :: p(3)
    integer :: j
    do j = 1, 3
      p(j) = 2*random_number_01() - 1
    end do
  end function random_point

  real(rp) function random_number_01() result(x)
    x = random%uniform()
  end function random_number_01

  !> One point in each of the seven regions of the triangle (0,0,0) (2,0,0) (0,1,0), with known answers, and
  !> the region behind an obtuse corner, where the edge whose side p is on does not hold the closest point.
  subroutine test_regions()
    real(rp), parameter :: O(3) = 0
    call expect('face', [0.5_rp, 0.25_rp, 3.0_rp], 9.0_rp, 0.25_rp, 0.25_rp)
    call expect('corner a', [-1.0_rp, -1.0_rp, 0.0_rp], 2.0_rp, 0.0_rp, 0.0_rp)
    call expect('corner b', [4.0_rp, -1.0_rp, 1.0_rp], 6.0_rp, 1.0_rp, 0.0_rp)
    call expect('corner c', [-1.0_rp, 3.0_rp, 0.0_rp], 5.0_rp, 0.0_rp, 1.0_rp)
    call expect('edge ab', [1.0_rp, -2.0_rp, 2.0_rp], 8.0_rp, 0.5_rp, 0.0_rp)
    call expect('edge ac', [-3.0_rp, 0.25_rp, 0.0_rp], 9.0_rp, 0.0_rp, 0.25_rp)
    call expect('edge bc', [2.0_rp, 2.5_rp, 0.0_rp], 5.0_rp, 0.5_rp, 0.5_rp)
    call expect('a corner itself', [2.0_rp, 0.0_rp, 0.0_rp], 0.0_rp, 1.0_rp, 0.0_rp)
    worst = 0
    call try_point(O, [1.0_rp, 0.0_rp, 0.0_rp], [-3.0_rp, 0.1_rp, 0.0_rp], [1.2_rp, 0.5_rp, 0.2_rp])
    call try_point(O, [1.0_rp, 0.0_rp, 0.0_rp], [-3.0_rp, 0.1_rp, 0.0_rp], [0.2_rp, -0.5_rp, 0.2_rp])
    call try_point(O, [1.0_rp, 0.0_rp, 0.0_rp], [-3.0_rp, 0.1_rp, 0.0_rp], [-0.1_rp, -2.0_rp, 0.2_rp])
    call report('obtuse corner', 1.0e-13_rp)
  end subroutine test_regions

  subroutine expect(region, p, d2, v, w)
    character(*), intent(in) :: region
    real(rp), intent(in) :: p(3), d2, v, w
    type(triangle_t) :: triangle
    real(rp) :: got(3)
    triangle = make_triangle([0.0_rp, 0.0_rp, 0.0_rp], [2.0_rp, 0.0_rp, 0.0_rp], [0.0_rp, 1.0_rp, 0.0_rp])
    call triangle%closest(p, got(1), got(2), got(3))
    call kit%check('region '//region//' has distance and coordinates worked out by hand', &
                   all(abs(got - [d2, v, w]) <= 1.0e-14_rp))
  end subroutine expect

  !> Points around the triangle, near it and far away, and some of its own.
  subroutine try_points(a, b, c, n)
    real(rp), intent(in) :: a(3), b(3), c(3)
    integer, intent(in) :: n
    real(rp) :: length
    integer :: j
    length = max(norm2(b - a), norm2(c - a), norm2(c - b), 1.0e-6_rp)
    do j = 1, n
      call try_point(a, b, c, (a + b + c)/3 + length*random_point())
      call try_point(a, b, c, (a + b + c)/3 + 5*length*random_point())
      call try_point(a, b, c, a + 0.01_rp*length*random_point())
      call try_point(a, b, c, 0.2_rp*a + 0.3_rp*b + 0.5_rp*c)
      call try_point(a, b, c, c)
    end do
  end subroutine try_points

  !> Gathers in `worst`, relative to the size of the coordinates: coordinates outside of the triangle;
  !> distance that is not that of the coordinates; optimality; how much nearer brute force has come. Coordinates
  !> in the triangle are a feasible point, so that a distance above the smallest one would show in the last.
  subroutine try_point(a, b, c, p)
    real(rp), intent(in) :: a(3), b(3), c(3), p(3)
    type(triangle_t) :: triangle
    real(rp) :: d2, v, w, q(3), size_of, brute
    triangle = make_triangle(a, b, c)
    call triangle%closest(p, d2, v, w)
    q = (1 - v - w)*a + v*b + w*c
    size_of = max(norm2(a), norm2(b), norm2(c), norm2(p), 1.0e-100_rp)
    worst(1) = max(worst(1), -v, -w, v + w - 1)
    worst(2) = max(worst(2), abs(sqrt(d2) - norm2(p - q))/size_of)
    worst(3) = max(worst(3), dot_product(p - q, a - q)/size_of**2, dot_product(p - q, b - q)/size_of**2, &
                   dot_product(p - q, c - q)/size_of**2)
    brute = brute_force(a, b, c, p)
    worst(4) = max(worst(4), (sqrt(d2) - brute)/size_of)
  end subroutine try_point

  !> Smallest distance over a grid of coordinates that closes in on its best point.
  real(rp) function brute_force(a, b, c, p) result(smallest)
    real(rp), intent(in) :: a(3), b(3), c(3), p(3)
    integer, parameter :: N = 16
    real(rp) :: v, w, best(2), around(2), half, d
    integer :: level, j, l
    best = 0.5_rp
    half = 0.5_rp
    smallest = huge(smallest)
    do level = 1, 18
      around = best
      do j = -N, N
        do l = -N, N
          v = min(1.0_rp, max(0.0_rp, around(1) + half*j/N))
          w = min(1 - v, max(0.0_rp, around(2) + half*l/N))
          d = norm2(p - (1 - v - w)*a - v*b - w*c)
          if (d < smallest) then
            smallest = d
            best = [v, w]
          end if
        end do
      end do
      half = half/3
    end do
  end function brute_force

  !> `tolerance`: round-off, or the height of needles.
  subroutine report(what, tolerance)
    character(*), intent(in) :: what
    real(rp), intent(in) :: tolerance
    call kit%check_below(what//': coordinates lie in the triangle', worst(1), 1.0e-15_rp)
    call kit%check_below(what//': the distance is that of the closest point', worst(2), 1.0e-13_rp)
    call kit%check_below(what//': no corner is nearer than the plane through the closest point', worst(3), tolerance)
    call kit%check_below(what//': brute force finds nothing nearer', worst(4), tolerance)
    worst = 0
  end subroutine report
end program test_triangle

! SPDX-License-Identifier: GPL-3.0-or-later
!> Heights of deformed triangles at fixed places, their derivatives, the cost of Truong et al. and the excluded zones
!> against formulas of their own.
program test_measurement_comparison
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use measurement_comparison, only: observed_shape_t
  use measurement_data, only: measurement_t, QUANTITY_ROTATION
  use measurement_evaluation, only: zone_violations, VIOLATION_BACKWARD, VIOLATION_FOLDED
  use measurement_experiment, only: experiment_t
  use measurement_sampling, only: height_gradient, outline_edges, sample_surface, sampled_height, surface_sample_t
  use sample_wings, only: make_fly_wing
  use solid_params, only: default_params
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: NX = 41, NY = 31
  real(rp), parameter :: ROUND_OFF = 1.0e-13_rp, A = 0.3_rp, B = -0.7_rp, C = 1.1_rp, SLOPE = 0.01_rp, MM = 1.0e-3_rp
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call see_linear_surfaces()
  call see_the_highest()
  call differentiate_heights()
  call compare_by_hand()
  call t%finish()

contains

  !> A rectangle 2 x 1 of 8 x 4 cells with the material points moved about in it, on the plane z = A + B x + C y.
  subroutine make_rectangle(positions, triangles)
    real(rp), allocatable, intent(out) :: positions(:, :)
    integer, allocatable, intent(out) :: triangles(:, :)
    integer :: i, j, k, corner
    real(rp) :: x, y
    allocate (positions(3, 45), triangles(3, 64))
    k = 0
    do j = 0, 4
      do i = 0, 8
        x = i/8.0_rp
        y = j/4.0_rp
        positions(1, 1 + i + 9*j) = 2*(x + 0.1_rp*x*(1 - x)*cos(3*y)) ! the outline stays the rectangle
        positions(2, 1 + i + 9*j) = y + 0.2_rp*y*(1 - y)*sin(5*x)
        if (i == 8 .or. j == 4) cycle
        corner = 1 + i + 9*j
        triangles(:, k + 1) = [corner, corner + 1, corner + 10]
        triangles(:, k + 2) = [corner, corner + 10, corner + 9]
        k = k + 2
      end do
    end do
    positions(3, :) = plane(positions(1, :), positions(2, :))
  end subroutine make_rectangle

  pure elemental real(rp) function plane(x, y)
    real(rp), intent(in) :: x, y
    plane = A + B*x + C*y
  end function plane

  !> A grid around the rectangle; the numbers of its points run backward.
  subroutine make_grid(x, y, number, node)
    real(rp), intent(out) :: x(NX), y(NY)
    integer, intent(out) :: number(NX, NY)
    integer, allocatable, intent(out) :: node(:, :)
    integer :: i, j, k
    x = [(-0.3_rp + 2.6_rp*((i - 1.0_rp)/(NX - 1))**1.1_rp, i=1, NX)]
    y = [(-0.2_rp + 1.4_rp*(j - 1)/(NY - 1), j=1, NY)]
    allocate (node(2, NX*NY))
    k = NX*NY
    do j = 1, NY
      do i = 1, NX
        number(i, j) = k
        node(:, k) = [i, j]
        k = k - 1
      end do
    end do
  end subroutine make_grid

  !> In the rectangle the plane is seen, beside it the height of the nearest point, which is the place cut to it.
  subroutine see_linear_surfaces()
    real(rp), allocatable :: positions(:, :)
    integer, allocatable :: triangles(:, :), edges(:, :), node(:, :)
    type(surface_sample_t) :: sample
    real(rp) :: x(NX), y(NY), inside_error, beside_error, height, px, py
    integer :: number(NX, NY), k, n_wrong
    call make_rectangle(positions, triangles)
    call make_grid(x, y, number, node)
    edges = outline_edges(size(positions, 2), triangles)
    call t%check('the outline has the edges of the rectangle', size(edges, 2) == 24)
    call sample%init(NX*NY)
    call sample_surface(positions, triangles, edges, x, y, number, node, sample)
    inside_error = 0
    beside_error = 0
    n_wrong = 0
    do k = 1, NX*NY
      px = x(node(1, k))
      py = y(node(2, k))
      height = sampled_height(positions, sample, k)
      if (sample%is_beside(k) .neqv. (px < 0 .or. px > 2 .or. py < 0 .or. py > 1)) n_wrong = n_wrong + 1
      if (sample%is_beside(k)) then
        px = max(0.0_rp, min(2.0_rp, px))
        py = max(0.0_rp, min(1.0_rp, py))
        beside_error = max(beside_error, abs(height - plane(px, py)))
      else
        inside_error = max(inside_error, abs(height - plane(px, py)))
      end if
    end do
    call t%check('every place is known to be inside or beside', n_wrong == 0 .and. any(sample%is_beside) .and. &
                 .not. all(sample%is_beside))
    call t%check_below('linear fields are exact on deformed triangles', inside_error, ROUND_OFF)
    call t%check_below('beside the wing the nearest point of the outline is seen', beside_error, ROUND_OFF)
  end subroutine see_linear_surfaces

  subroutine see_the_highest()
    integer, parameter :: TRIANGLES(3, 2) = reshape([1, 2, 3, 4, 5, 6], [3, 2]), NODE(2, 1) = 1, &
                          NUMBER(2, 2) = reshape([1, 0, 0, 0], [2, 2])
    real(rp), parameter :: CORNER(3, 3) = reshape([0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, &
                                                   0.0_rp], [3, 3]), ABOVE(3) = [0.0_rp, 0.0_rp, 1.0_rp]
    type(surface_sample_t) :: sample
    real(rp) :: positions(3, 6)
    integer :: i, edges(2, 0)
    call sample%init(1)
    positions(:, :3) = CORNER
    positions(:, 4:) = CORNER + spread(ABOVE, 2, 3)
    do i = 1, 2
      call sample_surface(positions, TRIANGLES, edges, [0.2_rp, 3.0_rp], [0.2_rp, 3.0_rp], NUMBER, NODE, sample)
      call t%check_close('the highest triangle is seen', sampled_height(positions, sample, 1), 1.0_rp, ROUND_OFF)
      positions(3, :) = 1 - positions(3, :)
    end do
  end subroutine see_the_highest

  !> Derivatives equal central differences of half width H: third derivatives times H^2/6 are below 1e-6 for motions
  !> of order one on cells of 1/4. Places that change the triangle or the edge in between have a kink and are left out.
  subroutine differentiate_heights()
    real(rp), parameter :: H = 1.0e-5_rp
    real(rp), allocatable :: positions(:, :), motion(:, :)
    integer, allocatable :: triangles(:, :), edges(:, :), node(:, :)
    type(surface_sample_t) :: ahead, behind, sample
    real(rp) :: x(NX), y(NY), gradient(3, 3), derivative, worst(2)
    integer :: number(NX, NY), k, i, n_used(2), kind
    call make_rectangle(positions, triangles)
    call make_grid(x, y, number, node)
    edges = outline_edges(size(positions, 2), triangles)
    allocate (motion, source=positions)
    motion(1, :) = sin(7*positions(1, :) + positions(2, :))
    motion(2, :) = cos(4*positions(1, :) - 3*positions(2, :))
    motion(3, :) = sin(5*positions(2, :)*positions(1, :))
    positions(3, :) = positions(3, :) + sin(3*positions(1, :)) ! not a plane
    call sample%init(NX*NY)
    call ahead%init(NX*NY)
    call behind%init(NX*NY)
    call sample_surface(positions, triangles, edges, x, y, number, node, sample)
    call sample_surface(positions + H*motion, triangles, edges, x, y, number, node, ahead)
    call sample_surface(positions - H*motion, triangles, edges, x, y, number, node, behind)
    worst = 0
    n_used = 0
    do k = 1, NX*NY
      if (any(ahead%corner(:, k) /= behind%corner(:, k)) .or. (ahead%is_beside(k) .neqv. behind%is_beside(k))) cycle
      if (count(ahead%weight(:, k) > 0) /= count(behind%weight(:, k) > 0)) cycle
      call height_gradient(positions, sample, k, [x(node(1, k)), y(node(2, k))], gradient)
      derivative = 0
      do i = 1, 3
        derivative = derivative + dot_product(gradient(:, i), motion(:, sample%corner(i, k)))
      end do
      derivative = derivative - (sampled_height(positions + H*motion, ahead, k) &
                                 - sampled_height(positions - H*motion, behind, k))/(2*H)
      kind = merge(1, 2, sample%is_beside(k))
      worst(kind) = max(worst(kind), abs(derivative))
      n_used(kind) = n_used(kind) + 1
    end do
    call t%check('most places are compared', sum(n_used) > 0.9_rp*NX*NY .and. all(n_used > 400))
    call t%check_below('derivatives inside equal differences', worst(2), 1.0e-6_rp)
    call t%check_below('derivatives beside equal differences', worst(1), 1.0e-6_rp)
  end subroutine differentiate_heights

  !> A wing that is tilted and shifted: residuals and h by hand.
  subroutine compare_by_hand()
    type(wing_t) :: wing
    type(measurement_t) :: m
    type(experiment_t) :: experiment
    type(failure_t) :: failure
    type(static_options_t) :: options
    real(rp), allocatable :: u(:, :)
    wing = make_fly_wing(24, 12)
    call measure_by_hand(m)
    call experiment%init(m, wing, default_params(wing), [integer ::], options, failure)
    call t%check('the experiment is made',.not. failure%failed)
    call t%check('the unknown is the offset', experiment%count() == 1)
    ! Rigid: z = SLOPE x by a turn about y in small angles, so that x does not change.
    allocate (u(3, experiment%model%n_all), source=0.0_rp)
    u(3, :) = SLOPE*experiment%model%points(1, :)
    call check_residuals(m, experiment, u)
    call check_zones(experiment, u)
  end subroutine compare_by_hand

  !> Two loads at one point, whose heights do not depend on the place, and two observations.
  subroutine measure_by_hand(m)
    type(measurement_t), intent(out) :: m
    integer :: l, k, i, j, n
    allocate (m%x(20), m%y(10), m%unloaded(20, 10), m%unloaded_sigma(20, 10), m%has_unloaded(20, 10), m%loads(2), &
              m%observations(2), m%zeros(1))
    m%zeros = 'z'
    m%x = [((i - 0.5_rp)*0.4_rp*MM, i=1, 20)]
    m%y = [(-2*MM + (j - 0.5_rp)*0.25_rp*MM, j=1, 10)]
    m%unloaded = 1.0e-5_rp
    m%unloaded_sigma = 3.0e-6_rp
    m%has_unloaded = .true.
    do l = 1, 2
      associate (load => m%loads(l))
        n = 100/l
        load%name = 'a'
        load%force = 1.0e-4_rp
        load%direction = [0.0_rp, 0.0_rp, 1.0_rp]
        load%point = [4*MM, -1*MM]
        allocate (load%node(2, n), load%height(n), load%sigma(n))
        load%node(1, :) = [(1 + mod(k, 20), k=1, n)]
        load%node(2, :) = [(1 + k/20, k=1, n)]
        load%height = 1.0e-5_rp + l*1.0e-4_rp
        load%sigma = 4.0e-6_rp
      end associate
    end do
    m%observations%load = 2
    m%observations%sigma = 1
    m%observations%value = 0.005_rp
    m%observations(1)%point = [4*MM, -1*MM]
    m%observations(1)%axis = [0.0_rp, 0.0_rp, 1.0_rp]
    m%observations(1)%zero = 1
    m%observations(2)%point = [4*MM, -1*MM]
    m%observations(2)%axis = [0.0_rp, 1.0_rp, 0.0_rp]
    m%observations(2)%quantity = QUANTITY_ROTATION
  end subroutine measure_by_hand

  !> Residuals of the points moved by u, and h.
  subroutine check_residuals(m, experiment, u)
    type(measurement_t), intent(in) :: m
    type(experiment_t), intent(inout) :: experiment
    real(rp), intent(in) :: u(:, :)
    type(observed_shape_t) :: shape
    real(rp), allocatable :: residuals(:)
    real(rp) :: h, expected, worst, zeros(1)
    integer :: l, k, n, first
    n = experiment%count_residuals(0)
    allocate (residuals(n))
    call shape%init(experiment%model%n_points, 100)
    shape%positions = experiment%model%points(:, :experiment%model%n_points) + u(:, :experiment%model%n_points)
    shape%seen = shape%positions
    zeros = 0.001_rp
    expected = 0
    worst = 0
    first = 1
    do l = 1, 2
      associate (comparison => experiment%comparisons(l))
        call comparison%locate(m%x, m%y, experiment%model%triangles, experiment%edges, shape)
        call comparison%residuals(experiment%model%points, shape, comparison%unloaded, 1.0_rp, zeros, &
                                  residuals(first:first + comparison%n - 1))
        call t%check('some places are on the wing and some beside', comparison%n_heights > 20 .and. &
                     comparison%n_heights < m%loads(l)%count())
        h = 0
        do k = 1, comparison%n_heights
          h = h + (SLOPE*m%x(comparison%node(1, k)) - l*1.0e-4_rp)**2
          worst = max(worst, abs(residuals(first + k - 1) - (SLOPE*m%x(comparison%node(1, k)) - l*1.0e-4_rp)))
        end do
        expected = expected + h/comparison%n_heights
        call t%check_close('sd of deformations', comparison%sigma(1), 5.0e-6_rp, rtol=ROUND_OFF)
        first = first + comparison%n
      end associate
    end do
    call t%check_below('residuals by hand', worst, 1.0e-16_rp)
    call t%check_close('h by hand', experiment%cost(residuals), sqrt(expected), rtol=ROUND_OFF)
    call t%check_close('displacement by hand', residuals(n - 1), SLOPE*4*MM + 0.001_rp - 0.005_rp, atol=1.0e-15_rp)
    call t%check_close('rotation by hand: z rises toward the tip, which is negative about y', residuals(n), &
                       -atan(SLOPE) - 0.005_rp, atol=ROUND_OFF)
  end subroutine check_residuals

  !> In which excluded zones the wing moved by u is, by -u, and folded.
  subroutine check_zones(experiment, u)
    type(experiment_t), intent(in) :: experiment
    real(rp), intent(in) :: u(:, :)
    real(rp), allocatable :: folded(:, :)
    real(rp) :: violation(2)
    violation = zone_violations(experiment, 1, u)
    call t%check('the shape is in no zone',.not. any(abs(violation) > 0))
    violation = zone_violations(experiment, 1, -u)
    call t%check_close('against the force: how far', violation(VIOLATION_BACKWARD), SLOPE*4*MM/experiment%model%size, &
                       rtol=1.0e-12_rp)
    folded = u
    folded(:2, experiment%tip) = -0.6_rp*(experiment%model%points(:2, experiment%tip) - experiment%root(:2))
    violation = zone_violations(experiment, 1, folded)
    call t%check_close('folded: how far', violation(VIOLATION_FOLDED), 0.1_rp, rtol=1.0e-12_rp)
  end subroutine check_zones
end program test_measurement_comparison

! SPDX-License-Identifier: GPL-3.0-or-later
!> Large deflections of cantilevers against the inextensible elastica and Turek & Hron's beams.
program test_solid_beams
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use derivative_checks, only: STENCIL
  use sample_wings, only: make_beam
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t, couple_t, support_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_vectors, only: cross
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_small_load()
  call test_elastica()
  call test_circle()
  call test_guided_circle()
  call test_directions()
  call test_turek_hron()
  call t%finish()

contains

  !> A cantilever of length `length` and bending stiffness `ei`, springs of stiffness k each.
  subroutine make_cantilever(n, length, ei, k, direction, model)
    integer, intent(in) :: n
    real(rp), intent(in) :: length, ei, k, direction(3)
    type(solid_model_t), intent(out) :: model
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(failure_t) :: failure
    wing = make_beam(n, length, 1.0_rp, direction)
    params = default_params(wing)
    params%young = ei*64/PI
    params%k_vein = k
    call model%init(wing, params, failure)
    call t%check('a beam without membrane is a valid model',.not. failure%failed)
  end subroutine make_cantilever

  subroutine solve(model, load, tolerance, u, report)
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: tolerance
    real(rp), allocatable, intent(out) :: u(:, :)
    type(static_report_t), intent(out) :: report
    type(equilibrium_t) :: work
    type(static_options_t) :: options
    allocate (u(3, model%n_all), source=0.0_rp)
    options%tolerance = tolerance
    options%step_limit = 0.05_rp
    call work%init(model)
    call solve_static(work, model, load, .false., options, u, report)
    call work%free()
    call t%check('the beam finds its equilibrium', report%converged .and. report%snaps == 0)
  end subroutine solve

  !> N equal segments with the half hinge 2EI/l at the root are too soft by exactly 1/(2 N^2).
  subroutine test_small_load()
    real(rp), parameter :: P = 1.0e-4_rp
    type(solid_model_t) :: model
    type(load_t) :: load
    type(static_report_t) :: report
    real(rp), allocatable :: u(:, :)
    real(rp) :: w
    integer :: n
    n = 5
    do while (n <= 80)
      call make_cantilever(n, 1.0_rp, 1.0_rp, 1.0e4_rp, [1.0_rp, 0.0_rp, 0.0_rp], model)
      call load%init(model)
      call load%add_point(n + 1, [0.0_rp, 0.0_rp, P])
      call solve(model, load, 1.0e-9_rp, u, report)
      w = u(3, n + 1)/(P/3)
      call t%check_close('the tip of a cantilever is too soft by 1/(2 N^2)', (w - 1)*2*n**2, 1.0_rp, &
                         atol=1.0e-4_rp)
      n = 2*n
    end do
  end subroutine test_small_load

  !> Tip deflection, shortening and angle of the elastica under a dead tip load alpha = P L^2/EI.
  subroutine elastica(alpha, q, w, shortening, tip_angle)
    real(rp), intent(in) :: alpha, q !< tip load; distributed load q L^3/EI
    real(rp), intent(out) :: w, shortening, tip_angle
    real(rp) :: low, high, y(4)
    integer :: i
    low = 0
    high = 0.5_rp*PI
    do i = 1, 60 ! the tip angle for which the root is clamped
      tip_angle = 0.5_rp*(low + high)
      y = integrate(alpha, q, tip_angle)
      if (y(1) > 0) then
        high = tip_angle
      else
        low = tip_angle
      end if
    end do
    w = y(3)
    shortening = 1 - y(4)
  end subroutine elastica

  !> From the tip to the root: angle, -curvature, and the integrals of its sine and cosine.
  function integrate(alpha, q, tip_angle) result(y)
    real(rp), intent(in) :: alpha, q, tip_angle
    real(rp) :: y(4), k1(4), k2(4), k3(4), k4(4), h, s
    integer, parameter :: STEPS = 1000
    integer :: i
    y = [tip_angle, 0.0_rp, 0.0_rp, 0.0_rp]
    h = 1.0_rp/STEPS
    do i = 1, STEPS
      s = (i - 1)*h
      k1 = slope(alpha + q*s, y)
      k2 = slope(alpha + q*(s + h/2), y + h/2*k1)
      k3 = slope(alpha + q*(s + h/2), y + h/2*k2)
      k4 = slope(alpha + q*(s + h), y + h*k3)
      y = y + h/6*(k1 + 2*k2 + 2*k3 + k4)
    end do
  end function integrate

  pure function slope(load, y) result(f)
    real(rp), intent(in) :: load, y(4)
    real(rp) :: f(4)
    f = [y(2), -load*cos(y(1)), sin(y(1)), cos(y(1))]
  end function slope

  subroutine test_elastica()
    real(rp), parameter :: ALPHAS(4) = [0.5_rp, 2.0_rp, 5.0_rp, 10.0_rp]
    type(solid_model_t) :: model
    type(load_t) :: load
    type(static_report_t) :: report
    real(rp), allocatable :: u(:, :)
    real(rp) :: w, shortening, angle, errors(4), h(4)
    character(40) :: label
    integer :: a, n, i
    call elastica(10.0_rp, 0.0_rp, w, shortening, angle)
    call t%check_close('the elastica of the test agrees with elliptic integrals', w, 0.810609_rp, &
                       atol=1.0e-6_rp)
    do a = 1, size(ALPHAS)
      call elastica(ALPHAS(a), 0.0_rp, w, shortening, angle)
      write (label, '(a,f5.1)') ' at P L^2/EI =', ALPHAS(a)
      do i = 1, 4
        n = 5*2**i
        call make_cantilever(n, 1.0_rp, 1.0_rp, 1.0e9_rp, [1.0_rp, 0.0_rp, 0.0_rp], model)
        call load%init(model)
        call load%add_point(n + 1, [0.0_rp, 0.0_rp, ALPHAS(a)])
        call solve(model, load, 1.0e-6_rp, u, report)
        errors(i) = hypot(u(3, n + 1) - w, u(1, n + 1) + shortening)
        h(i) = 1.0_rp/n
      end do
      call t%check_below('a beam of 80 segments follows the elastica'//trim(label), errors(4)/w, 1.0e-4_rp)
      call t%check_order('the tip converges to the elastica'//trim(label), h, errors, 2.0_rp, 0.1_rp)
    end do
  end subroutine test_elastica

  !> Under an end moment M all hinges turn by M l/EI: for M = 2 pi EI/L the beam closes. A chain has no
  !> torsional stiffness and tilts sideways beyond M = pi/2 EI/L, so the path is followed to 1.4 EI/L;
  !> that the tangent is indefinite at 1.7 EI/L, and that guides mend it, shows that this is a
  !> bifurcation of the chain in space and no failure of the path.
  subroutine test_circle()
    integer, parameter :: N = 24
    type(solid_model_t) :: model
    type(load_t) :: load
    type(static_report_t) :: report
    real(rp), allocatable :: u(:, :)
    call make_cantilever(N, 1.0_rp, 1.0_rp, 1.0e6_rp, [1.0_rp, 0.0_rp, 0.0_rp], model)
    call load%init(model)
    load%couples = [couple_t([N, N + 1], [0.0_rp, -1.0_rp, 0.0_rp], 1.4_rp)]
    call solve(model, load, 1.0e-8_rp, u, report)
    call test_load_tangent(model, load, u)
    call t%check_below('an end moment bends a beam to an arc', maxval(abs(u - arc(model, 1.4_rp))), 1.0e-9_rp)
    call check_stability(model, load, 1.4_rp, .true.)
    call check_stability(model, load, 1.7_rp, .false.)
    load%supports = guides(model)
    call check_stability(model, load, 1.7_rp, .true.)
  end subroutine test_circle

  !> Between frictionless guides, which hold y and carry no force, the beam is followed until it
  !> closes. Its points are l/(2 sin(delta/2)) instead of l/delta from the centre, delta = 2 pi/N, so
  !> that the farthest one misses the circle by pi/(6 N^2) L.
  subroutine test_guided_circle()
    integer, parameter :: N(4) = [12, 24, 48, 96]
    type(solid_model_t) :: model
    type(load_t) :: load
    type(static_report_t) :: report
    real(rp), allocatable :: u(:, :)
    real(rp) :: circle(3), angle, errors(size(N)), h(size(N))
    integer :: i, p
    do i = 1, size(N)
      call make_cantilever(N(i), 1.0_rp, 1.0_rp, 1.0e6_rp, [1.0_rp, 0.0_rp, 0.0_rp], model)
      call load%init(model)
      load%couples = [couple_t([N(i), N(i) + 1], [0.0_rp, -1.0_rp, 0.0_rp], 2*PI)]
      load%supports = guides(model)
      call solve(model, load, 1.0e-8_rp, u, report)
      call t%check_below('under 2 pi EI/L the path ends in a closed beam', &
                         norm2(model%points(:, N(i) + 1) + u(:, N(i) + 1)), 1.0e-9_rp)
      call t%check_below('whose hinges all turn alike', maxval(abs(u - arc(model, 2*PI))), 1.0e-9_rp)
      call t%check_below('and whose guides carry no force', maxval(abs(u(2, :))), 1.0e-14_rp)
      errors(i) = 0
      do p = 1, N(i) + 1
        angle = 2*PI*(p - 1)/N(i)
        circle = [sin(angle), 0.0_rp, 1 - cos(angle)]/(2*PI)
        errors(i) = max(errors(i), norm2(model%points(:, p) + u(:, p) - circle))
      end do
      h(i) = 1.0_rp/N(i)
    end do
    call t%check_order('the beam converges to the circle', h, errors, 2.0_rp, 0.02_rp)
    call t%check_close('with the constant pi/6', errors(4)/h(4)**2, PI/6, rtol=1.0e-3_rp)
  end subroutine test_guided_circle

  !> Stiff springs along y at all points.
  function guides(model) result(supports)
    type(solid_model_t), intent(in) :: model
    type(support_t), allocatable :: supports(:)
    integer :: p
    supports = [(support_t(p, [0.0_rp, 1.0e4_rp, 0.0_rp]), p=1, model%n_points)]
  end function guides

  !> Whether the arc under this moment is stable.
  subroutine check_stability(model, load, moment, is_stable)
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(inout) :: load
    real(rp), intent(in) :: moment
    logical, intent(in) :: is_stable
    type(equilibrium_t) :: work
    real(rp) :: u(3, model%n_all)
    logical :: is_spd
    load%couples(1)%moment = moment
    u = arc(model, moment)
    call work%init(model)
    call work%start(model, load, u)
    work%stage = 1
    call work%law_axial(model, u)
    call work%factorise(model, load, u, .false., 0.0_rp, is_spd)
    call work%free()
    call t%check('a chain in space is stable under an end moment up to pi/2 EI/L', is_spd .eqv. is_stable)
  end subroutine check_stability

  !> The tangent of a load of every kind is the derivative of its forces, and these of its work: the couple with a
  !> dead force, weight and supports.
  subroutine test_load_tangent(model, couple, u)
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: couple
    real(rp), intent(in) :: u(:, :)
    real(rp), parameter :: FACTOR = 0.9_rp
    real(rp), parameter :: H = 5.0e-4_rp ! (4 H/l)^8 = 3e-11 for segments l, times the coefficient 1/630
    type(load_t) :: load
    real(rp), dimension(3, model%n_all) :: direction, forces, there, slopes
    real(rp) :: blocks(3, 3, size(model%pattern%rows)), product(3, model%n_free), slope
    integer :: i, c, s
    load = couple
    call load%add_point(5, [0.3_rp, -0.7_rp, 1.1_rp])
    call load%add_gravity([(0.1_rp*i, i=1, model%n_points)], [0.2_rp, 0.1_rp, -0.4_rp])
    load%supports = [support_t(3, 1.0e3_rp*[1.0_rp, 2.0_rp, 3.0_rp]), support_t(9, [5.0e2_rp, 0.0_rp, 0.0_rp])]
    direction = reshape([((sin(1.3_rp*i + 2.1_rp*c), c=1, 3), i=1, model%n_all)], [3, model%n_all])
    call model%zero_clamped(direction)
    slope = 0
    slopes = 0
    do s = -4, 4
      if (s == 0) cycle
      there = u + s*H*direction
      slope = slope + sign(1, s)*STENCIL(abs(s))*load%work(model, there, FACTOR)/H
      forces = 0
      call load%subtract_from(model, there, FACTOR, forces)
      slopes = slopes + sign(1, s)*STENCIL(abs(s))*forces/H
    end do
    forces = 0
    call load%subtract_from(model, u, FACTOR, forces)
    call t%check_close('the forces of a load are the derivative of its work', -sum(forces*direction), slope, &
                       rtol=1.0e-9_rp)
    blocks = 0
    call load%subtract_tangent(model, u, FACTOR, blocks)
    product = 0
    call model%pattern%multiply(blocks, 1.0_rp, direction(:, model%movable), product)
    call t%check_below('the tangent of a load is the derivative of its forces', &
                       maxval(abs(product - slopes(:, model%movable)))/maxval(abs(product)), 1.0e-9_rp)
  end subroutine test_load_tangent

  !> Displacements of a chain whose segments point at (i - 1/2) times the same angle.
  function arc(model, total_turn) result(u)
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: total_turn
    real(rp) :: u(3, model%n_all), x(3), angle
    integer :: i, n
    n = model%n_points - 1
    u = 0
    x = 0
    do i = 1, n
      angle = (i - 0.5_rp)*total_turn/n
      x = x + [cos(angle), 0.0_rp, sin(angle)]/n
      u(:, i + 1) = x - model%points(:, i + 1)
    end do
  end function arc

  !> A beam at 37 degrees or along y or z bends like one along x, in every plane.
  subroutine test_directions()
    integer, parameter :: N = 16
    real(rp), parameter :: ANGLE = 37*PI/180
    real(rp), parameter :: AXES(3, 4) = reshape([1.0_rp, 0.0_rp, 0.0_rp, cos(ANGLE), sin(ANGLE), 0.0_rp, &
                                                 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp], [3, 4])
    type(solid_model_t) :: model
    type(load_t) :: load
    type(static_report_t) :: report
    real(rp), allocatable :: u(:, :)
    real(rp) :: e(3), across(3, 2), w, first
    integer :: a, c
    do a = 1, size(AXES, 2)
      e = AXES(:, a)
      across(:, 1) = [0.0_rp, 0.0_rp, 1.0_rp]
      if (e(3) > 0) across(:, 1) = [1.0_rp, 0.0_rp, 0.0_rp]
      across(:, 2) = cross(across(:, 1), e)
      do c = 1, 2
        call make_cantilever(N, 1.0_rp, 1.0_rp, 1.0e5_rp, e, model)
        call load%init(model)
        call load%add_point(N + 1, 4*across(:, c))
        call solve(model, load, 1.0e-10_rp, u, report)
        w = dot_product(u(:, N + 1), across(:, c))
        if (a == 1 .and. c == 1) first = w
        call t%check_close('the direction of a beam in space does not matter', w, first, rtol=1.0e-9_rp)
      end do
    end do
  end subroutine test_directions

  !> Turek & Hron (2006), CSM1 and CSM2: own weight of a beam 0.35 m x 0.02 m, plane strain. The inextensible
  !> elastica misses the published two-dimensional values by 0.73 and 0.70 % (u_y), 1.09 and 1.08 % (u_x).
  subroutine test_turek_hron()
    integer, parameter :: N = 80
    real(rp), parameter :: YOUNG(2) = [1.4e6_rp, 5.6e6_rp], L = 0.35_rp, H = 0.02_rp
    real(rp), parameter :: PUBLISHED(2, 2) = reshape([-7.187e-3_rp, -66.10e-3_rp, -0.4690e-3_rp, &
                                                      -16.97e-3_rp], [2, 2])
    type(solid_model_t) :: model
    type(load_t) :: load
    type(static_report_t) :: report
    real(rp), allocatable :: u(:, :), masses(:)
    real(rp) :: ei, q, w, shortening, angle
    integer :: c
    do c = 1, 2
      ei = YOUNG(c)*H**3/12/(1 - 0.4_rp**2)
      q = 1000*2*H
      call make_cantilever(N, L, ei, 1.0e9_rp, [1.0_rp, 0.0_rp, 0.0_rp], model)
      allocate (masses(N + 1), source=1000*H*L/N)
      masses(N + 1) = masses(N + 1)/2
      call load%init(model)
      call load%add_gravity(masses, [0.0_rp, -2.0_rp, 0.0_rp])
      deallocate (masses)
      call solve(model, load, 1.0e-6_rp, u, report)
      call elastica(0.0_rp, q*L**3/ei, w, shortening, angle)
      call t%check_close('Turek-Hron''s beam deflects like the elastica', u(2, N + 1), -L*w, rtol=1.0e-3_rp)
      call t%check_close('and shortens like it', u(1, N + 1), -L*shortening, rtol=2.0e-3_rp)
      ! chains of hinges are softer than the elastica, hence nearer to the beam that also shears
      call t%check_below('u_y misses the published value by no more than the elastica', &
                         abs(u(2, N + 1) - PUBLISHED(2, c)), abs(-L*w - PUBLISHED(2, c)))
      call t%check_below('u_x misses the published value by no more than the elastica', &
                         abs(u(1, N + 1) - PUBLISHED(1, c)), abs(-L*shortening - PUBLISHED(1, c)))
    end do
  end subroutine test_turek_hron
end program test_solid_beams

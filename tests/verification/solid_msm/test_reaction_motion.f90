! SPDX-License-Identifier: GPL-3.0-or-later
!> The motion of a wing under a load that answers its velocity: an added mass A that takes the momentum A v out of the
!> wing, f = -A (v_(n+1) - v_n)/dt.
!>
!> BDF2 gives the wing's own mass the rate (3 v_(n+1) - 4 v_n + v_(n-1))/(2 dt) and A that of implicit Euler, both the
!> same in the first step. So a diagonal A is there exactly a mass of the points, and later up to the first order in dt. Nothing
!> holds the free wing; summed over the steps its equation says that
!> sum of m (3 v_n - v_(n-1))/2 + A v_n is constant from the first step on, to what Newton's method leaves.
program test_reaction_motion
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use marker_reaction, only: marker_reaction_t, exponential_kernel, layer_kernel, place_markers
  use sample_wings, only: make_beam, make_fly_wing
  use solid_dynamics, only: copy_state, dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  use solid_motion, only: steady_motion_t
  use solid_params, only: default_params, solid_params_t
  use solid_vectors, only: cross
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: MASS = 250.0e-9_rp ! [kg] of a wing
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call compare_with_masses()
  call fly_light(is_layer=.false.)
  call fly_light(is_layer=.true.)
  call jerk_light()
  call step_without()
  call t%finish()

contains

  !> A fly's wing, with or without a rod beside it that is clamped in its place, and springs that are soft enough for
  !> long steps.
  subroutine make_wing(is_free, model, inertia)
    logical, intent(in) :: is_free
    type(solid_model_t), intent(out) :: model
    type(inertia_t), intent(out) :: inertia
    type(wing_t) :: wing, rod
    type(solid_params_t) :: params
    type(failure_t) :: failure
    real(rp), allocatable :: masses(:)
    integer :: n
    wing = make_fly_wing(24, 12)
    n = size(wing%points, 2)
    allocate (masses(n), source=MASS/n)
    if (is_free) then
      rod = make_beam(1, 1.0e-3_rp, 5.0e-5_rp, [1.0_rp, 0.0_rp, 0.0_rp])
      wing%points = reshape([wing%points, rod%points - 0.01_rp], [3, n + 2])
      wing%points(3, n + 1:) = 0
      rod%veins(1)%nodes = [n + 1, n + 2]
      wing%veins = [wing%veins, rod%veins]
      wing%root = [n + 1, n + 2]
      masses = [masses, 0.0_rp, 0.0_rp]
    end if
    params = default_params(wing)
    params%cross_springs = .true.
    call model%init(wing, params, failure)
    call t%check('a wing is built',.not. failure%failed)
    call inertia%init(model, masses)
  end subroutine make_wing

  !> Markers on all points of a clamped wing, with A = a times the unit matrix: a wing whose points are heavier by a.
  subroutine compare_with_masses()
    real(rp), parameter :: T_END = 4.0e-4_rp
    integer, parameter :: STEPS(3) = [40, 80, 160]
    type(solid_model_t) :: model
    type(inertia_t) :: light, heavy
    real(rp), allocatable :: first(:, :), added(:, :), with_mass(:, :)
    real(rp) :: errors(3), a
    integer :: k
    call make_wing(.false., model, light)
    light%mass = 0.01_rp*light%mass
    a = MASS/model%n_points
    heavy = light
    heavy%mass(:model%n_points) = heavy%mass(:model%n_points) + a
    allocate (first(3, model%n_all), added(3, model%n_all), with_mass(3, model%n_all))
    call bend(model, light, a, T_END/STEPS(1), 1, added)
    call bend(model, heavy, 0.0_rp, T_END/STEPS(1), 1, with_mass)
    ! Residuals of 1e-12 of the forces, and the tip is not softer than the force on it over its way.
    call t%check_below('in the first step it is a mass', norm2(added - with_mass)/norm2(with_mass), 1.0e-9_rp)
    do k = 1, 3
      call bend(model, light, a, T_END/STEPS(k), STEPS(k), added)
      call bend(model, heavy, 0.0_rp, T_END/STEPS(k), STEPS(k), with_mass)
      errors(k) = norm2(added - with_mass)/norm2(with_mass)
    end do
    call t%check_below('later nearly', errors(3), 0.05_rp)
    call t%check_order('and the better the shorter the steps, with the first order', 1.0_rp/STEPS, errors, 1.0_rp, 0.2_rp)
  end subroutine compare_with_masses

  !> Displacements after steps under a sudden force, with an added mass a [kg] of every point if it is above 0.
  subroutine bend(model, inertia, a, dt, n_steps, u)
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    real(rp), intent(in) :: a, dt
    integer, intent(in) :: n_steps
    real(rp), intent(out) :: u(:, :)
    type(marker_reaction_t) :: reaction
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: rest
    real(rp) :: force(3, model%n_all), weights(3, model%n_points), response(3*model%n_points, 3*model%n_points)
    integer :: nodes(3, model%n_points), i
    force = 0
    force(3, :model%n_points) = 5.0e-4_rp/model%n_points
    nodes = spread([(i, i=1, model%n_points)], 1, 3)
    weights = spread([1.0_rp, 0.0_rp, 0.0_rp], 2, model%n_points)
    options%tolerance = 1.0e-12_rp
    if (a > 0) then
      response = 0
      do i = 1, size(response, 1)
        response(i, i) = 1/a
      end do
      call reaction%init(model, nodes, weights, response, dt)
    end if
    call stepper%init(model)
    call state%init(model, 0.0_rp)
    do i = 1, n_steps
      if (a > 0) then
        call reaction%begin_step(rest%frame, state%u, state%v)
        call stepper%step(model, inertia, rest, force, dt, options, state, report, reaction=reaction)
      else
        call stepper%step(model, inertia, rest, force, dt, options, state, report)
      end if
      if (.not. (report%converged .and. report%substeps == 1)) exit
    end do
    call t%check('every step converges', report%converged .and. report%substeps == 1)
    u = state%u
    call stepper%free()
  end subroutine bend

  !> A free wing with a hundredth of its mass, thrown, spinning and bent, in a medium whose added mass is about that of the
  !> whole wing.
  subroutine fly_light(is_layer)
    logical, intent(in) :: is_layer !< the medium is a smoothed fluid; otherwise of a kernel
    integer, parameter :: STEPS = 200, MARKERS = 50
    real(rp), parameter :: DT = 1.0e-5_rp, SPEED(3) = [0.4_rp, -0.2_rp, 0.3_rp], SPIN(3) = [120.0_rp, -90.0_rp, 200.0_rp]
    character(:), allocatable :: what
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(marker_reaction_t) :: reaction
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: rest
    real(rp), allocatable :: weights(:, :), sites(:, :), v(:, :), force(:, :), old_v(:, :)
    integer, allocatable :: nodes(:, :)
    real(rp) :: first(3), begun(3), constant(3), drift, allowed, sway, energy, last_energy, x, rough, most_rough, growth
    integer :: i
    logical :: fine
    what = ' of a kernel'
    if (is_layer) what = ' of a layer'
    call make_wing(.true., model, inertia)
    inertia%mass = 0.01_rp*inertia%mass
    call place_markers(model, MARKERS, nodes, weights, sites)
    if (is_layer) then
      call reaction%init(model, nodes, weights, layer_kernel(sites, 5.0e-4_rp, 3.0_rp), DT)
    else
      call reaction%init(model, nodes, weights, exponential_kernel(sites, 1.0e-3_rp, 0.1_rp, MASS), DT)
    end if
    allocate (v(3, model%n_all), force(3, model%n_all), old_v(3, model%n_all))
    v = 0
    force = 0
    do i = 1, model%n_points
      if (.not. inertia%mass(i) > 0) cycle
      x = model%points(1, i)/model%size
      v(:, i) = SPEED + cross(SPIN, model%points(:, i))
      v(3, i) = v(3, i) + 3*(x**2 - x)
    end do
    call stepper%init(model)
    call state%init(model, 0.0_rp, v=v)
    options%tolerance = 1.0e-12_rp
    begun = momentum(inertia, reaction, DT, state%v, state%v)
    first = begun
    last_energy = energy_of(model, inertia, reaction, DT, state)
    fine = .true.
    drift = 0
    allowed = 1.0e-10_rp
    sway = 0
    growth = 0
    rough = 0
    most_rough = 0
    do i = 1, STEPS
      old_v = state%v
      call reaction%begin_step(rest%frame, state%u, state%v)
      call stepper%step(model, inertia, rest, force, DT, options, state, report, reaction=reaction)
      fine = fine .and. report%converged .and. report%substeps == 1
      if (.not. report%converged) exit
      constant = momentum(inertia, reaction, DT, state%v, state%old_v)
      if (i == 1) first = constant
      drift = max(drift, norm2(constant - first)/norm2(begun))
      ! The sum of what Newton's method leaves at the points acts like a force.
      allowed = allowed + DT*sqrt(real(model%n_free, rp))*minval(report%residuals, mask=report%residuals > 0)/norm2(begun)
      sway = max(sway, norm2(momentum(inertia, reaction, DT, state%v, state%v) - begun)/norm2(begun))
      energy = energy_of(model, inertia, reaction, DT, state)
      growth = max(growth, energy/last_energy - 1)
      last_energy = energy
    end do
    print '(a,7es11.3)', 'drift, allowed, sway, growth, energy', drift, allowed, sway, growth, energy, last_energy
    call t%check('every step of the light wing converges at once'//what, fine)
    call t%check_below('momentum and impulses agree'//what, drift, allowed)
    call t%check_below('momentum changes by what BDF2 leaves'//what, sway, 1.0e-3_rp)
    call t%check_below('energy does not grow'//what, growth, 1.0e-3_rp)
    call stepper%free()
  end subroutine fly_light

  !> Sum of m (3 v - old_v)/2 + A v.
  function momentum(inertia, reaction, dt, v, old_v) result(p)
    type(inertia_t), intent(in) :: inertia
    type(marker_reaction_t), intent(inout) :: reaction
    real(rp), intent(in) :: dt, v(:, :), old_v(:, :)
    real(rp) :: p(3), y(3, size(v, 2))
    y = 0
    call reaction%tangent(v, y)
    p = dt*sum(y, 2) + matmul(1.5_rp*v - 0.5_rp*old_v, inertia%mass)
  end function momentum

  !> Kinetic energy of wing and medium, and the elastic one [J].
  real(rp) function energy_of(model, inertia, reaction, dt, state) result(energy)
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(marker_reaction_t), intent(inout) :: reaction
    real(rp), intent(in) :: dt
    type(dynamic_state_t), intent(in) :: state
    real(rp) :: y(3, model%n_all)
    y = 0
    call reaction%tangent(state%v, y)
    energy = 0.5_rp*dt*sum(state%v*y) + 0.5_rp*dot_product(inertia%mass, sum(state%v**2, 1)) + model%energy(state%u)
  end function energy_of

  !> A clamped wing with a hundredth of its mass that is hit in long steps: where Newton's method may not take as many
  !> iterations as it needs, steps are made in pieces, and lead to the same shape up to what shorter steps change.
  subroutine jerk_light()
    integer, parameter :: STEPS = 4, MARKERS = 50
    real(rp), parameter :: DT = 2.0e-4_rp
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(marker_reaction_t) :: reaction
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state(2)
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: spin
    real(rp), allocatable :: weights(:, :), sites(:, :), force(:, :)
    integer, allocatable :: nodes(:, :)
    integer :: i, way, pieces(2)
    logical :: fine
    call make_wing(.false., model, inertia)
    inertia%mass = 0.01_rp*inertia%mass
    call place_markers(model, MARKERS, nodes, weights, sites)
    call reaction%init(model, nodes, weights, layer_kernel(sites, 5.0e-4_rp, 3.0_rp), DT)
    allocate (force(3, model%n_all), source=0.0_rp)
    force(3, :model%n_points) = 1.0e-2_rp/model%n_points
    spin%frame%omega = [0.0_rp, 300.0_rp, 1000.0_rp]
    call stepper%init(model)
    pieces = 0
    do way = 1, 2
      call state(way)%init(model, 0.0_rp)
      reaction%ended = 0
      fine = .true.
      do i = 1, STEPS
        call reaction%begin_step(spin%frame, state(way)%u, state(way)%v)
        call stepper%step(model, inertia, spin, force, DT, options, state(way), report, reaction=reaction)
        fine = fine .and. report%converged
        pieces(way) = pieces(way) + report%substeps
      end do
      call t%check('a light wing steps through a sudden load', fine)
      call t%check('the load learns of every piece', reaction%ended == pieces(way))
      options%iterations = 3
    end do
    print '(a,2i4,3es11.3)', 'pieces, difference', pieces, maxval(abs(state(1)%u)), maxval(abs(state(2)%u)), &
      maxval(abs(state(2)%u - state(1)%u))
    call t%check('in pieces where it must', pieces(2) > pieces(1))
    call stepper%free()
  end subroutine jerk_light

  !> What a step with a reaction leaves in the work space changes no bit of one without.
  subroutine step_without()
    real(rp), parameter :: DT = 2.0e-5_rp
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(marker_reaction_t) :: reaction
    type(dynamics_t) :: stepper(2)
    type(dynamic_state_t) :: state(2), other
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: spin
    real(rp), allocatable :: weights(:, :), sites(:, :), force(:, :)
    integer, allocatable :: nodes(:, :)
    integer :: i, k
    call make_wing(.false., model, inertia)
    call place_markers(model, 30, nodes, weights, sites)
    call reaction%init(model, nodes, weights, exponential_kernel(sites, 1.0e-3_rp, 0.1_rp, MASS), DT)
    allocate (force(3, model%n_all), source=0.0_rp)
    force(3, :model%n_points) = 2.0e-3_rp/model%n_points
    spin%frame%omega = [0.0_rp, 300.0_rp, 1000.0_rp]
    call other%init(model, 0.0_rp)
    do k = 1, 2
      call stepper(k)%init(model)
      call state(k)%init(model, 0.0_rp)
    end do
    do i = 1, 5
      call reaction%begin_step(spin%frame, other%u, other%v)
      call stepper(2)%step(model, inertia, spin, force, DT, options, other, report, reaction=reaction)
      do k = 1, 2
        call stepper(k)%step(model, inertia, spin, force, DT, options, state(k), report)
      end do
    end do
    call t%check('a reaction changes the motion', norm2(other%u - state(1)%u) > 0.1_rp*norm2(state(1)%u))
    call t%check('but no bit of steps without it',.not. any(abs(state(2)%u - state(1)%u) > 0 &
                                                            .or. abs(state(2)%v - state(1)%v) > 0))
    do k = 1, 2
      call stepper(k)%free()
    end do
  end subroutine step_without
end program test_reaction_motion

! SPDX-License-Identifier: GPL-3.0-or-later
!> A fly's wing that nothing holds, thrown, spinning and vibrating: its linear momentum is constant to what
!> Newton's method leaves, its angular momentum to the second order of the time step.
program test_solid_momentum
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use sample_wings, only: make_beam, make_fly_wing
  use solid_dynamics, only: dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_inertia, only: inertia_t, momenta_t, measure_motion
  use solid_model, only: solid_model_t
  use solid_motion, only: steady_motion_t
  use solid_params, only: solid_params_t, default_params
  use solid_vectors, only: cross
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: T_END = 2.0e-3_rp, MASS = 250.0e-9_rp
  real(rp), parameter :: SPEED(3) = [0.4_rp, -0.2_rp, 0.3_rp] ![m/s]
  real(rp), parameter :: SPIN(3) = [120.0_rp, -90.0_rp, 200.0_rp] ![rad/s]
  integer, parameter :: STEPS(3) = [100, 200, 400]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(inertia_t) :: inertia
  real(rp) :: errors(3), drift, deformed
  integer :: r

  call t%start(parallel=.false.)
  call make_free_wing()
  do r = 1, 3
    call fly(STEPS(r), drift, errors(r), deformed)
    call t%check_below('linear momentum is conserved', drift, 1.0e-12_rp)
  end do
  call t%check_below('the wing bends by more than 3 % of its length on the way', 0.03_rp, deformed)
  call t%check_below('angular momentum is conserved', errors(3), 1.0e-5_rp)
  call t%check_order('and the better the shorter the steps', 1.0_rp/STEPS, errors, 2.0_rp, 0.3_rp)
  call t%finish()

contains

  !> What is clamped is a rod of two points beside the wing.
  subroutine make_free_wing()
    type(wing_t) :: rod
    type(solid_params_t) :: params
    type(failure_t) :: failure
    real(rp), allocatable :: masses(:)
    integer :: n
    wing = make_fly_wing(24, 12)
    n = size(wing%points, 2)
    rod = make_beam(1, 1.0e-3_rp, 5.0e-5_rp, [1.0_rp, 0.0_rp, 0.0_rp])
    wing%points = reshape([wing%points, rod%points - 0.01_rp], [3, n + 2])
    wing%points(3, n + 1:) = 0
    rod%veins(1)%nodes = [n + 1, n + 2]
    wing%veins = [wing%veins, rod%veins]
    wing%root = [n + 1, n + 2]
    params = default_params(wing)
    params%cross_springs = .true.
    call model%init(wing, params, failure)
    call t%check('a free wing is built',.not. failure%failed)
    allocate (masses(n + 2), source=0.0_rp)
    masses(:n) = MASS/n
    call inertia%init(model, masses)
  end subroutine make_free_wing

  !> Relative changes of the momenta up to T_END, and how far the wing bends, over its length.
  subroutine fly(n_steps, linear, angular, bending)
    integer, intent(in) :: n_steps
    real(rp), intent(out) :: linear, angular, bending
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: rest
    type(momenta_t) :: first, last
    real(rp) :: v(3, model%n_all), force(3, model%n_all), x, length
    integer :: i
    v = 0
    force = 0
    length = maxval(model%points(1, :))
    do i = 1, model%n_points
      if (.not. inertia%mass(i) > 0) cycle
      x = model%points(1, i)/length
      v(:, i) = SPEED + cross(SPIN, model%points(:, i))
      v(3, i) = v(3, i) + 3*(x**2 - x)*SPEED(3)*4 + 0.5_rp*sin(9*x)*model%points(2, i)/length
    end do
    call stepper%init(model)
    call state%init(model, 0.0_rp, v=v)
    first = measure_motion(inertia, model, rest%at(0.0_rp), state%u, state%v)
    bending = 0
    do i = 1, n_steps
      call stepper%step(model, inertia, rest, force, T_END/n_steps, options, state, report)
      if (.not. report%converged) exit
      bending = max(bending, bend(state%u)/length)
    end do
    call t%check('every step converges', report%converged)
    last = measure_motion(inertia, model, rest%at(T_END), state%u, state%v)
    linear = norm2(last%linear - first%linear)/norm2(first%linear)
    angular = norm2(last%angular - first%angular)/norm2(first%angular)
    call stepper%free()
  end subroutine fly

  !> How far the middle of a vein along the wing stands off the line through its ends [m].
  real(rp) function bend(u)
    real(rp), intent(in) :: u(:, :)
    real(rp) :: x(3, 3), along(3)
    integer :: nodes(3)
    associate (vein => wing%veins(3)%nodes)
      nodes = [vein(1), vein(size(vein)/2), vein(size(vein))]
    end associate
    x = model%points(:, nodes) + u(:, nodes)
    along = (x(:, 3) - x(:, 1))/norm2(x(:, 3) - x(:, 1))
    bend = norm2(cross(along, x(:, 2) - x(:, 1)))
  end function bend
end program test_solid_momentum

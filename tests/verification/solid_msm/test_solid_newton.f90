! SPDX-License-Identifier: GPL-3.0-or-later
!> Newton's method in a step of a wing's motion: its order, its retries, its failure.
program test_solid_newton
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use sample_wings, only: make_fly_wing
  use solid_dynamics, only: dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use turning_motion, only: turning_motion_t
  implicit none
  real(rp), parameter :: K_DEFAULT = 1.0e5_rp
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_order(' at rest', damping=0.0_rp, omega=0.0_rp)
  call test_order(' with damping of the rate of the elastic forces', damping=1.0e-4_rp, omega=0.0_rp)
  call test_order(' in a frame that turns', damping=0.0_rp, omega=500.0_rp)
  call test_retries()
  call t%finish()

contains

  !> A fly's wing of 250 ug with springs of stiffness k [N/m].
  subroutine make_wing(k, model, inertia)
    real(rp), intent(in) :: k
    type(solid_model_t), intent(out) :: model
    type(inertia_t), intent(out) :: inertia
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(failure_t) :: failure
    wing = make_fly_wing(24, 12)
    params = default_params(wing)
    params%k_vein = k
    params%k_membrane = k
    call model%init(wing, params, failure)
    call t%check('the model of a wing is built',.not. failure%failed)
    call inertia%init(model, spread(250.0e-9_rp/model%n_points, 1, model%n_points))
  end subroutine make_wing

  !> log(r_(k+1)/r_k)/log(r_k/r_(k-1)) of the last three residuals above rounding, in steps under a sudden load that
  !> bends the wing by half its length, with a new tangent in every iteration. Residuals round at eps k |u| sqrt(n), so
  !> that soft springs leave the widest range below the first residual, which is that of the extrapolated shape.
  subroutine test_order(what, damping, omega)
    character(*), intent(in) :: what
    real(rp), intent(in) :: damping, omega !< [s] of the rate of the elastic forces, [1/s]
    integer, parameter :: STEPS = 10
    real(rp), parameter :: K_SOFT = 1.0e2_rp, DT = 5.0e-4_rp
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(turning_motion_t) :: spin
    real(rp), allocatable :: force(:, :)
    real(rp) :: orders(STEPS), rounding
    integer :: i, n, last
    logical :: fine
    call make_wing(K_SOFT, model, inertia)
    inertia%rayleigh_stiffness = damping
    call stepper%init(model)
    call state%init(model, 0.0_rp)
    allocate (force(3, model%n_all), source=0.0_rp)
    force(3, :) = 2.0e-3_rp/model%n_points
    spin%omega0 = omega
    options%worth_reuse = 0
    options%factorisations = huge(1)
    options%tolerance = 1.0e-14_rp
    n = 0
    fine = .true.
    do i = 1, STEPS
      call stepper%step(model, inertia, spin, force, DT, options, state, report)
      fine = fine .and. report%converged .and. report%substeps == 1
      rounding = epsilon(DT)*K_SOFT*sqrt(real(model%n_free, rp))*maxval(abs(state%u))
      last = count(report%residuals > 5*rounding) - 1
      if (last < 3) cycle
      n = n + 1
      associate (r => report%residuals(last - 2:last))
        orders(n) = log(r(3)/r(2))/log(r(2)/r(1))
      end associate
    end do
    call t%check('all steps converge'//what, fine)
    call t%check('most have three residuals below the first one and above rounding'//what, n > STEPS/2)
    call t%check_below('the order of Newton''s method, median of steps'//what, 1.7_rp, median(orders(:n)))
    call t%check_below('and its smallest'//what, 1.4_rp, minval(orders(:n)))
    call stepper%free()
  end subroutine test_order

  !> Of an even number the lower one of the two in the middle.
  pure real(rp) function median(x)
    real(rp), intent(in) :: x(:)
    integer :: i
    do i = 1, size(x)
      median = x(i)
      if (count(x < median) <= (size(x) - 1)/2 .and. count(x <= median) > (size(x) - 1)/2) return
    end do
  end function median

  !> Under a sudden load in a turning frame: few iterations; steps in pieces; failure.
  subroutine test_retries()
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(turning_motion_t) :: spin
    real(rp), allocatable :: force(:, :), before(:, :)
    integer :: i
    call make_wing(K_DEFAULT, model, inertia)
    call stepper%init(model)
    call state%init(model, 0.0_rp)
    allocate (force(3, model%n_all), source=0.0_rp)
    force(3, :) = 2.0e-3_rp/model%n_points
    spin%omega0 = 500
    spin%alpha = 1.0e6_rp
    options%worth_reuse = 0
    do i = 1, 20
      call stepper%step(model, inertia, spin, force, 2.0e-5_rp, options, state, report)
      if (.not. report%converged) exit
    end do
    call t%check('a wing steps through a sudden load in a turning frame', report%converged)
    call t%check_below('in a few iterations', real(report%iterations, rp), 5.0_rp)
    call t%check_below('and moves', 1.0e-4_rp, maxval(abs(state%u)))
    options%iterations = 2
    options%tolerance = 1.0e-10_rp
    call stepper%step(model, inertia, spin, 5*force, 1.0e-4_rp, options, state, report)
    call t%check('a step that fails is made in pieces', report%converged .and. report%substeps > 1)
    call t%check_close('and ends at its time', state%time, 5.0e-4_rp, rtol=1.0e-12_rp)
    options%halvings = 0
    options%iterations = 1
    before = state%u
    call stepper%step(model, inertia, spin, 50*force, 1.0e-3_rp, options, state, report)
    call t%check('a hopeless step is a failure with a reason',.not. report%converged .and. &
                 allocated(report%reason))
    call t%check('and leaves the state as it was',.not. maxval(abs(before - state%u)) > 0 .and. &
                 abs(state%time - 5.0e-4_rp) < 1.0e-15_rp)
    call stepper%free()
  end subroutine test_retries
end program test_solid_newton

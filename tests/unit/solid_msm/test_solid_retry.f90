! SPDX-License-Identifier: GPL-3.0-or-later
!> A time step that fails half-way, after some of its shorter substeps were accepted, leaves the state
!> as it was, to the last bit; one that succeeds in substeps says how many.
program test_solid_retry
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use breaking_motion, only: breaking_motion_t
  use model_variation, only: set_parameter
  use sample_wings, only: make_beam
  use solid_dynamics, only: dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  use solid_params, only: default_params
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 6
  real(rp), parameter :: DT = 1.0e-2_rp

  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(inertia_t) :: inertia
  type(dynamics_t) :: stepper
  type(dynamic_state_t) :: state, before
  type(dynamic_options_t) :: options
  type(step_report_t) :: report
  type(breaking_motion_t) :: motion
  type(failure_t) :: failure
  real(rp), allocatable :: force(:, :)
  integer :: step

  call t%start(parallel=.false.)
  wing = make_beam(N, 1.0_rp, 0.1_rp, [1.0_rp, 0.0_rp, 0.0_rp])
  call model%init(wing, default_params(wing), failure)
  call t%check('the beam is valid',.not. failure%failed)
  call set_parameter(model, model%params%find('E'), 1.0e6_rp)
  call inertia%init(model, spread(1.0_rp/N, 1, N + 1))
  inertia%rayleigh_stiffness = 1.0e-2_rp
  allocate (force(3, model%n_all), source=0.0_rp)
  force(3, N + 1) = 1
  call stepper%init(model)
  call state%init(model, 0.0_rp)
  do step = 1, 3
    call stepper%step(model, inertia, motion, force, DT, options, state, report)
    call t%check('a step in one piece', report%converged .and. report%substeps == 1)
  end do
  before = state
  options%iterations = 3 ! Newton's method will not follow the jerk that comes
  options%factorisations = huge(1)
  options%halvings = 2   ! the first half is accepted, the third quarter fails
  motion%end = state%time + 0.6_rp*DT
  call stepper%step(model, inertia, motion, force, DT, options, state, report)
  call t%check('a frame that breaks half-way fails the step, with a reason',.not. report%converged .and. &
               allocated(report%reason))
  call t%check('after pieces that were accepted', report%substeps == 1)
  call t%check('the time is what it was',.not. abs(state%time - before%time) > 0 .and. &
               .not. abs(state%old_step - before%old_step) > 0)
  call t%check('the shape and its history, too',.not. differ(state%u, before%u) .and. &
               .not. differ(state%old_u, before%old_u))
  call t%check('and the velocities',.not. differ(state%v, before%v) .and. .not. differ(state%old_v, before%old_v))
  call t%check('and the elastic forces',.not. differ(state%g, before%g) .and. &
               .not. differ(state%old_g, before%old_g))
  call stepper%free()
  call t%finish()

contains

  pure logical function differ(a, b)
    real(rp), intent(in) :: a(:, :), b(:, :)
    differ = any(abs(a - b) > 0)
  end function differ
end program test_solid_retry

! SPDX-License-Identifier: GPL-3.0-or-later
!> The motion of a wing that rings: limits of a relaxing oscillator, the energy of one with drag, one on a base that moves, and the
!> motion that the time integration of flusi finds. The argument names a wing file.
program test_ringing
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use loaded_wing, only: wing_of_argument
  use measurement_series_projections, only: products
  use solid_damping_effects, only: damping_effects_t
  use solid_dragged_flow, only: drag_t
  use solid_dynamics, only: dynamic_options_t, dynamic_state_t, dynamics_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_joint_forces, only: apply_joints
  use solid_mass_effects, only: mass_effects_t, mass_parts_t
  use solid_modal, only: modal_t
  use solid_model, only: solid_model_t
  use solid_motion, only: steady_motion_t
  use solid_params, only: default_params, solid_params_t
  use solid_ringing, only: ringing_t, shake_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use weighed_model, only: make_weighed_model
  implicit none
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(solid_params_t) :: params
  type(mass_parts_t) :: parts

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  params = default_params(wing)
  params%joint = 1.0e-6_rp
  call prepare()
  call test_limits()
  call test_drag()
  call test_shake()
  call test_time_integration(2, 0.0_rp, 0.0_rp)
  call test_time_integration(16, 0.03_rp, 0.04_rp)
  call t%finish()

contains

  subroutine prepare()
    logical :: is_valid
    call make_weighed_model(wing, params, parts, model, is_valid)
    call t%check('the wing is valid', is_valid)
  end subroutine prepare

  !> One mode of 1 rad/s that relaxes, released from 1. Slowly: it rings as if 1 + g times as stiff about the share g/(1 + g) of
  !> its release. Fast: as with damping of g tau in proportion to its stiffness; both errors are of first order in 1/tau and tau.
  subroutine test_limits()
    integer, parameter :: N = 60
    real(rp), parameter :: G = 0.3_rp, SLOW(2) = [2.0e4_rp, 1.0e4_rp], FAST(2) = [2.0e-4_rp, 1.0e-4_rp]
    type(damping_effects_t) :: relaxing
    type(ringing_t) :: ring
    real(rp) :: exact(N), times(N), error(2), v, d
    integer :: i, k
    ring%interval = 0.2_rp
    times = [(k*ring%interval, k=0, N - 1)]
    relaxing%relaxation = G
    do i = 1, 2
      relaxing%relaxation_time = SLOW(i)
      call ring_alone(ring, relaxing, N)
      exact = (G + cos(sqrt(1 + G)*times))/(1 + G)
      error(i) = maxval(abs(ring%seen(:, 1) - exact))
    end do
    call t%check_below('a wing that relaxes slowly is stiffer', error(1), 1.0e-3_rp)
    call t%check_close('up to an error of first order', error(2)/error(1), 2.0_rp, rtol=0.05_rp)
    do i = 1, 2
      relaxing%relaxation_time = FAST(i)
      call ring_alone(ring, relaxing, N)
      d = 0.5_rp*G*FAST(i)
      v = sqrt(1 - d**2)
      exact = exp(-d*times)*(cos(v*times) + d/v*sin(v*times))
      error(i) = maxval(abs(ring%seen(:, 1) - exact))
    end do
    call t%check_below('a wing that relaxes fast is damped in proportion to its stiffness', error(1), 1.0e-5_rp)
    call t%check_below('up to an error of higher order', error(2), 0.6_rp*error(1))
  end subroutine test_limits

  subroutine ring_alone(ring, how, n)
    type(ringing_t), intent(inout) :: ring
    type(damping_effects_t), intent(in) :: how
    integer, intent(in) :: n
    real(rp) :: one(1, 1), none(1, 1)
    one = 1
    none = 0
    call ring%run([1.0_rp], none, one, [1.0_rp], how, n, [real(rp) ::])
  end subroutine ring_alone

  !> One mode of 1 rad/s with drag, released from x = 1: x'' + x = -b |x'| x'. While it moves down from x = a, where it rests,
  !> v^2 = 1/(2 b^2) + x/b - (1/(2 b^2) + a/b) exp(2 b (x - a)); the next half turn is the mirror image from the other end.
  subroutine test_drag()
    integer, parameter :: N = 100
    real(rp), parameter :: B(2) = [0.1_rp, 0.5_rp]
    type(damping_effects_t) :: nothing
    type(ringing_t) :: ring
    real(rp) :: error, a, x, v, left
    integer :: i, k, side
    do i = 1, 2
      ring%interval = TWO_PI/30
      ring%drag = drag_t(B(i), [0.5_rp, 0.25_rp], reshape([1.0_rp, 2.0_rp**(1/3.0_rp)], [2, 1]))
      call ring_alone(ring, nothing, N)
      error = 0
      a = 1
      side = 1
      left = 0
      do k = 2, N
        x = side*ring%seen(k, 1)
        v = side*ring%rate(k, 1)
        if (v > 0) then ! the turn is complete
          a = other_end(a, B(i))
          side = -side
          x = -x
          v = -v
        end if
        left = 0.5_rp/B(i)**2 + x/B(i) - (0.5_rp/B(i)**2 + a/B(i))*exp(2*B(i)*(x - a))
        error = max(error, abs(v**2 - left))
      end do
      call t%check_below('the energy of a wing with drag falls as it must', error, 2.0e-6_rp)
      call t%check_below('after several turns', a, 0.7_rp)
    end do
  end subroutine test_drag

  !> The same mode without drag on a base that moves with a sin(w t) + b cos(w t): the sum of free and forced motion.
  subroutine test_shake()
    integer, parameter :: N = 60
    real(rp), parameter :: W = 1.7_rp, A = 0.4_rp, B = -0.3_rp
    type(damping_effects_t) :: nothing
    type(ringing_t) :: ring
    real(rp) :: exact(N), times(N)
    integer :: k
    ring%interval = 0.2_rp
    ring%start = 0.3_rp
    ring%shake = shake_t(1, W, [A, B])
    ring%shaken = [1.0_rp]
    times = [(ring%start + k*ring%interval, k=0, N - 1)]
    call ring_alone(ring, nothing, N)
    exact = cos(times) + (A*(sin(W*times) - W*sin(times)) + B*(cos(W*times) - cos(times)))/(1 - W**2)
    call t%check_below('a base that moves drives the wing', maxval(abs(ring%seen(:, 1) - exact)), 1.0e-12_rp)
  end subroutine test_shake

  !> How far a half turn from `a` goes: (1 - 2 b y) exp(2 b y) = (1 + 2 b a) exp(-2 b a), by bisection.
  pure real(rp) function other_end(a, b) result(y)
    real(rp), intent(in) :: a, b
    real(rp) :: low, high
    integer :: k
    low = 0
    high = min(a, 0.5_rp/b)
    do k = 1, 60
      y = 0.5_rp*(low + high)
      if ((1 - 2*b*y)*exp(2*b*y) > (1 + 2*b*a)*exp(-2*b*a)) then
        low = y
      else
        high = y
      end if
    end do
  end function other_end

  !> flusi's BDF2 of the whole nonlinear wing, viscoelastic with Rayleigh's damping, drag and friction of joints (of so many radians
  !> of the first mode), released a little from the shape of two modes: the difference at one tip to the motion in `r` modes falls
  !> with the square of the step. Friction of joints and drag move further modes too. `drag` is c times the displacement of the tip
  !> over the mass per area.
  subroutine test_time_integration(r, friction, drag)
    integer, intent(in) :: r
    real(rp), intent(in) :: friction, drag
    integer, parameter :: A_PERIOD(2) = [100, 200]
    type(modal_t) :: modal
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: rest
    type(failure_t) :: failure
    type(ringing_t) :: ring
    type(damping_effects_t) :: how
    real(rp), allocatable :: u(:, :), force(:, :), mass(:, :), stiff(:, :, :)
    real(rp) :: dt, look(1, r), push(r), joints(r, r), error(2)
    integer :: tip_point, n, i
    allocate (mass(3, model%n_all), force(3, model%n_all), source=0.0_rp)
    call parts%masses(mass_effects_t(), 0.0_rp, mass)
    call modal%init(model)
    call modal%solve(mass, r, failure)
    how%joints = friction/sqrt(modal%lambda(1))
    inertia%joint_friction = how%joints
    call inertia%init(model, mass(1, :model%n_points))
    how%mass = 0.1_rp*sqrt(modal%lambda(1))
    how%stiffness = 0.02_rp/sqrt(modal%lambda(1))
    how%relaxation = 0.3_rp
    how%relaxation_time = 1/sqrt(modal%lambda(1))
    call give_damping(how, inertia)
    inertia%drag = drag*sum(inertia%mass)/sum(inertia%area)/(1.0e-5_rp*model%size)
    if (drag > 0) call give_drag(inertia, modal%shapes(3, :, :r), ring)
    tip_point = maxloc(model%points(1, :model%n_points), 1)
    look(1, :) = modal%shapes(3, tip_point, :)
    push = 0
    push(:2) = 1.0e-5_rp*model%size/look(1, 1)*modal%lambda(:2)*[1.0_rp, 0.3_rp]
    allocate (stiff(3, model%n_all, r))
    call apply_joints(modal, stiff)
    joints = products(modal%shapes(:, :, :r), stiff)
    u = modal%shapes(:, :, 1)*push(1)/modal%lambda(1) + modal%shapes(:, :, 2)*push(2)/modal%lambda(2)
    do i = 1, 2
      dt = TWO_PI/sqrt(modal%lambda(1))/A_PERIOD(i)
      ring%interval = dt
      call ring%run(modal%lambda, joints, look, push, how, 3*A_PERIOD(i) + 1, [real(rp) ::])
      call stepper%init(model)
      call state%init(model, 0.0_rp, u=u)
      error(i) = 0
      do n = 1, 3*A_PERIOD(i)
        call stepper%step(model, inertia, rest, force, dt, options, state, report)
        error(i) = max(error(i), abs(state%u(3, tip_point) - ring%seen(n + 1, 1)))
      end do
      error(i) = error(i)/maxval(abs(ring%seen))
      call stepper%free()
    end do
    call t%check('there is friction in the joints', inertia%rubs() .eqv. friction > 0)
    call t%check_below('the motion is that of the time integration', error(2), 2.0e-2_rp)
    call t%check_close('whose error is of second order', error(1)/error(2), 4.0_rp, rtol=0.1_rp)
    call modal%free()
  end subroutine test_time_integration

  subroutine give_damping(how, inertia)
    type(damping_effects_t), intent(in) :: how
    type(inertia_t), intent(inout) :: inertia
    inertia%rayleigh_mass = how%mass
    inertia%rayleigh_stiffness = how%stiffness
    inertia%relaxation = how%relaxation
    inertia%relaxation_time = how%relaxation_time
  end subroutine give_damping

  !> A constructor of drag_t would take other numbers of `across`, by an error of gfortran 12.
  subroutine give_drag(inertia, across, ring)
    type(inertia_t), intent(in) :: inertia
    real(rp), intent(in) :: across(:, :)
    type(ringing_t), intent(inout) :: ring
    ring%drag%strength = inertia%drag
    ring%drag%area = inertia%area
    ring%drag%across = across
  end subroutine give_drag
end program test_ringing

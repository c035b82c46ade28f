! SPDX-License-Identifier: GPL-3.0-or-later
!> Shows how the membrane's bending stiffness D, which is chosen and not measured, changes the shapes of a wing, and which Young's
!> modulus and joints a fit to shapes would find instead.
module bench_dependence
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use loaded_wing, only: N_LOADS, MODERATE_FORCES, load_at
  use model_variation, only: shape_sensitivities
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params, membrane_thickness
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_wing, only: wing_t
  use wing_shapes, only: deflection
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  private
  public :: print_dependence

contains

  !> Prints the changes with D. The data are the vertical displacements of all points under ten moderate loads for
  !> D = 0.2 mN mm and E = 12.6 GPa, joints as the veins. For each D: the deflections of the loaded places without a fit,
  !> then E and a factor common to all joints by Gauss-Newton steps with exact derivatives.
  subroutine print_dependence(wing)
    type(wing_t), intent(in) :: wing
    real(rp), parameter :: D(4) = [0.4e-6_rp, 0.2e-6_rp, 0.1e-6_rp, 0.05e-6_rp], REFERENCE = 0.2e-6_rp
    integer, parameter :: STEPS = 12
    type(solid_params_t) :: params, reference_params
    type(solid_model_t) :: model
    type(equilibrium_t) :: work
    type(failure_t) :: failure
    type(load_t) :: loads(N_LOADS)
    real(rp), allocatable :: u(:, :, :), z(:, :), residual(:, :), jacobian(:, :, :)
    real(rp) :: w(N_LOADS), ratios(N_LOADS), rms, first_rms, step(2), trial(2), trial_rms, x(2)
    integer :: cross_springs, i, l, iteration, snaps, halving
    write (output_unit, '(a)') 'cross   D mN mm  h um  w/w(D=0.2) min  mean   max  rms um    E factor  '// &
      'joints factor  rms um  snaps'
    do cross_springs = 0, 1
      params = default_params(wing)
      params%plate = REFERENCE
      params%young = 12.6e9_rp
      params%cross_springs = cross_springs == 1
      call model%init(wing, params, failure)
      call require(.not. failure%failed .and. size(wing%joints) > 0, 'a wing with joints is needed')
      call work%init(model)
      reference_params = model%params
      if (.not. allocated(u)) allocate (u(3, model%n_all, N_LOADS), z(model%n_points, N_LOADS), &
                                        residual(model%n_points, N_LOADS), jacobian(model%n_points, N_LOADS, 2))
      do l = 1, N_LOADS
        call load_at(model, l, MODERATE_FORCES(l), loads(l))
      end do
      z = 0
      call evaluate(model, work, loads, z, u, residual, jacobian, rms, snaps)
      z = residual
      w = [(deflection(loads(l), u(:, :, l)), l=1, N_LOADS)]
      do i = 1, size(D)
        x = 0 ! ln of the factors
        params = reference_params
        params%plate = D(i)
        call model%set_params(params)
        call evaluate(model, work, loads, z, u, residual, jacobian, rms, snaps)
        first_rms = rms
        ratios = [(deflection(loads(l), u(:, :, l))/w(l), l=1, N_LOADS)]
        do iteration = 1, STEPS
          step = gauss_newton(residual, jacobian)
          do halving = 0, 6
            trial = x + step*0.5_rp**halving
            params%young = reference_params%young*exp(trial(1))
            params%joint = reference_params%joint*exp(trial(2))
            call model%set_params(params)
            call evaluate(model, work, loads, z, u, residual, jacobian, trial_rms, snaps)
            if (trial_rms <= rms) exit
          end do
          if (trial_rms > rms) exit
          x = trial
          rms = trial_rms
          if (norm2(step) < 1.0e-4_rp) exit
        end do
        write (output_unit, '(l5,f9.3,f7.2,f12.4,2f7.4,f9.2,f12.4,f12.4,f10.2,i6)') cross_springs == 1, &
          D(i)*1.0e6_rp, membrane_thickness(params, D(i))*1.0e6_rp, minval(ratios), sum(ratios)/N_LOADS, &
          maxval(ratios), first_rms*1.0e6_rp, exp(x), rms*1.0e6_rp, snaps
        flush (output_unit)
      end do
      call work%free()
    end do
  end subroutine print_dependence

  !> Computes the residuals [m] of all points under all loads against z, their derivatives with respect to ln E and the ln of the
  !> joints' common factor, and their rms. The computation of the shapes does not start from a known shape.
  subroutine evaluate(model, work, loads, z, u, residual, jacobian, rms, snaps)
    type(solid_model_t), intent(in) :: model
    type(equilibrium_t), intent(inout) :: work
    type(load_t), intent(in) :: loads(:)
    real(rp), intent(in) :: z(:, :)
    real(rp), intent(inout) :: u(:, :, :)
    real(rp), intent(out) :: residual(:, :), jacobian(:, :, :), rms
    integer, intent(out) :: snaps
    type(static_options_t) :: options
    type(static_report_t) :: report
    integer, allocatable :: numbers(:)
    real(rp), allocatable :: derivatives(:, :, :)
    integer :: l, p, n, n_joints
    n_joints = size(model%params%joint)
    n = model%n_points
    numbers = [model%params%find('E'), (model%params%count_basic() - n_joints + p, p=1, n_joints)]
    allocate (derivatives(3, model%n_all, size(numbers)))
    snaps = 0
    do l = 1, size(loads)
      call solve_static(work, model, loads(l), .false., options, u(:, :, l), report)
      call require(report%converged, 'a shape of the benchmark was not found')
      snaps = snaps + report%snaps
      call shape_sensitivities(work, model, u(:, :, l), numbers, derivatives)
      residual(:, l) = u(3, :n, l) - z(:, l)
      jacobian(:, l, 1) = derivatives(3, :n, 1)
      jacobian(:, l, 2) = sum(derivatives(3, :n, 2:), 2)
    end do
    rms = norm2(residual)/sqrt(real(size(residual), rp))
  end subroutine evaluate

  !> Computes the step that minimises the linearised sum of squares.
  pure function gauss_newton(residual, jacobian) result(step)
    real(rp), intent(in) :: residual(:, :), jacobian(:, :, :)
    real(rp) :: step(2), a, b, c, r(2)
    a = sum(jacobian(:, :, 1)**2)
    b = sum(jacobian(:, :, 1)*jacobian(:, :, 2))
    c = sum(jacobian(:, :, 2)**2)
    r = -[sum(jacobian(:, :, 1)*residual), sum(jacobian(:, :, 2)*residual)]
    step = [c*r(1) - b*r(2), a*r(2) - b*r(1)]/(a*c - b**2)
  end function gauss_newton
end module bench_dependence

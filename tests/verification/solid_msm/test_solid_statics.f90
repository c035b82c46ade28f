! SPDX-License-Identifier: GPL-3.0-or-later
!> The loading path of a fly's wing: reproducible, stable, with exact sensitivities; failures are values.
program test_solid_statics
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_lapack, only: singular_values
  use base_parameter, only: parameter_t
  use model_variation, only: set_parameter, shape_sensitivities
  use sample_wings, only: make_fly_wing
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params, membrane_thickness, membrane_note
  use solid_plate, only: plate_weights
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: PLACES(2, 3) = &
                         reshape([5.8e-3_rp, 0.1e-3_rp, 7.9e-3_rp, -0.3e-3_rp, 4.0e-3_rp, -1.6e-3_rp], [2, 3])
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_plate_on_a_cylinder()
  call test_path(.false.)
  call test_path(.true.)
  call test_tension_field()
  call test_sensitivities()
  call test_failures()
  call t%finish()

contains

  !> On a lattice of equilateral triangles the plate's energy is D kappa^2/2 per area in any direction.
  subroutine test_plate_on_a_cylinder()
    real(rp), parameter :: PI = 3.14159265358979324_rp, A = 0.3_rp, KAPPA = 0.8_rp
    real(rp) :: x(3, 4), z(4), weights(4), energy, phi
    integer :: orientation, direction
    do direction = 0, 4
      phi = 0.2_rp*direction
      energy = 0
      do orientation = 0, 2
        associate (angle => orientation*PI/3)
          x(:, 1) = 0
          x(:, 2) = A*[cos(angle), sin(angle), 0.0_rp]
          x(:, 3) = A*[cos(angle + PI/3), sin(angle + PI/3), 0.0_rp]
          x(:, 4) = A*[cos(angle - PI/3), sin(angle - PI/3), 0.0_rp]
        end associate
        z = 0.5_rp*KAPPA*(cos(phi)*x(1, :) + sin(phi)*x(2, :))**2
        weights = plate_weights(x)
        energy = energy + 0.5_rp*sum(weights*z)**2
      end do
      call t%check_close('a bent plate stores D kappa^2/2 per area', energy/(0.5_rp*sqrt(3.0_rp)*A**2), &
                         0.5_rp*KAPPA**2, rtol=1.0e-12_rp)
    end do
  end subroutine test_plate_on_a_cylinder

  subroutine make_model(cross_springs, model)
    logical, intent(in) :: cross_springs
    type(solid_model_t), intent(out) :: model
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(failure_t) :: failure
    wing = make_fly_wing(40, 12)
    params = default_params(wing)
    params%cross_springs = cross_springs
    call model%init(wing, params, failure)
    call t%check('the wing is valid',.not. failure%failed)
  end subroutine make_model

  subroutine make_load(model, place, force, load)
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: place
    real(rp), intent(in) :: force
    type(load_t), intent(out) :: load
    type(failure_t) :: failure
    call load%init(model)
    call load%add_at(model, PLACES(:, place), [0.0_rp, 0.0_rp, force], failure)
    call t%check('the load is on the wing',.not. failure%failed)
  end subroutine make_load

  subroutine test_path(cross_springs)
    logical, intent(in) :: cross_springs
    type(solid_model_t) :: model
    type(equilibrium_t) :: work
    type(load_t) :: load
    type(static_report_t) :: report
    type(static_options_t) :: options
    real(rp), allocatable :: u(:, :), fine(:, :), warm(:, :)
    real(rp), allocatable :: factors(:), values(:)
    integer :: i, p, n, plate, thickness
    call make_model(cross_springs, model)
    call work%init(model)
    allocate (u(3, model%n_all), fine(3, model%n_all), warm(3, model%n_all), source=0.0_rp)
    n = model%params%count_basic()
    plate = model%params%find('D')
    thickness = model%params%find('thickness')
    factors = [(exp(0.1_rp*sin(7.3_rp*p**2)), p=1, n)]
    values = [(model%params%get(p), p=1, n)]
    do i = 1, size(PLACES, 2)
      call make_load(model, i, 0.5e-3_rp, load)
      options = static_options_t()
      call solve_static(work, model, load, .false., options, u, report)
      call t%check('the loaded wing reaches a stable equilibrium', report%converged .and. &
                   report%residual <= 1.0e-8_rp)
      call t%check_below('in few factorisations', real(report%factorisations, rp), 60.0_rp)
      options%step_limit = options%step_limit/2.5_rp
      call solve_static(work, model, load, .false., options, fine, report)
      call t%check_below('two step sizes give the same shape', maxval(abs(fine - u)), 1.0e-9_rp)
      options = static_options_t()
      do p = 1, n ! a neighbour in parameter space, then back again
        if (p == plate .or. p == thickness) cycle
        call set_parameter(model, p, values(p)*factors(p))
      end do
      call solve_static(work, model, load, .false., options, warm, report)
      do p = 1, n
        call set_parameter(model, p, values(p))
      end do
      call solve_static(work, model, load, .true., options, warm, report)
      call t%check('a warm start takes few factorisations', report%converged .and. &
                   report%factorisations <= 12)
      call t%check_below('a warm start ends in the shape of the cold one', maxval(abs(warm - u)), 1.0e-9_rp)
    end do
    call work%free()
  end subroutine test_path

  !> A membrane that goes slack: stable equilibria that do not depend on the steps, and a lower potential energy
  !> than with a membrane that does not, since every spring stores less.
  subroutine test_tension_field()
    type(solid_model_t) :: model, stiff
    type(solid_params_t) :: params
    type(equilibrium_t) :: work, work_stiff
    type(load_t) :: load
    type(static_report_t) :: report
    type(static_options_t) :: options, halved
    real(rp), allocatable :: u(:, :), fine(:, :), full(:, :)
    real(rp) :: potential(2)
    integer :: i
    call make_model(.true., stiff)
    call make_model(.true., model)
    params = model%params
    params%slack = 0.05_rp
    params%slack_width = 1.0e-7_rp
    call model%set_params(params)
    call work%init(model)
    call work_stiff%init(stiff)
    halved%step_limit = options%step_limit/2
    allocate (u(3, model%n_all), fine(3, model%n_all), full(3, model%n_all), source=0.0_rp)
    do i = 1, size(PLACES, 2)
      call make_load(model, i, 0.5e-3_rp, load)
      call solve_static(work, model, load, .false., options, u, report)
      call t%check('a wing with a slack membrane reaches a stable equilibrium', report%converged .and. &
                   report%residual <= 1.0e-8_rp)
      call solve_static(work, model, load, .false., halved, fine, report)
      call t%check_below('the same with half the step', maxval(abs(fine - u)), 1.0e-9_rp)
      call solve_static(work_stiff, stiff, load, .false., options, full, report)
      potential = [model%energy(u) - load%work(model, u, 1.0_rp), &
                   stiff%energy(full) - load%work(stiff, full, 1.0_rp)]
      call t%check('the slack membrane stores less', potential(1) < potential(2))
    end do
    call work%free()
    call work_stiff%free()
  end subroutine test_tension_field

  subroutine test_sensitivities()
    real(rp), parameter :: STENCIL(4) = [4/5.0_rp, -1/5.0_rp, 4/105.0_rp, -1/280.0_rp], H = 0.004_rp
    type(solid_model_t) :: model
    type(equilibrium_t) :: work
    type(load_t) :: load
    type(parameter_t) :: parameter
    type(static_report_t) :: report
    type(static_options_t) :: options
    real(rp), allocatable :: u(:, :), other(:, :), d(:, :, :), fd(:, :), values(:)
    real(rp) :: value, step, unit, scale
    integer :: i, p, s, side
    call make_model(.true., model)
    call work%init(model)
    options%tolerance = 3.0e-9_rp
    allocate (u(3, model%n_all), fd(3, model%n_all), d(3, model%n_all, model%params%count_basic()), source=0.0_rp)
    do i = 1, size(PLACES, 2)
      call make_load(model, i, 0.5e-3_rp, load)
      call solve_static(work, model, load, .false., options, u, report)
      call shape_sensitivities(work, model, u, [(p, p=1, model%params%count_basic())], d)
      scale = maxval(abs(d(:, :, model%params%find('E'))))
      do p = 1, model%params%count_basic()
        parameter = model%params%describe(p)
        value = model%params%get(p)
        unit = 1 ! of a step that matters
        if (parameter%is_effect .and. .not. parameter%is_log) unit = parameter%prior_sd
        fd = 0
        do s = 1, 4
          do side = -1, 1, 2
            step = side*s*H
            call set_parameter(model, p, merge(value*exp(step), value + step*unit, parameter%is_log))
            other = u
            call solve_static(work, model, load, .true., options, other, report)
            call t%check('the neighbour is reached without a snap', report%converged .and. &
                         .not. report%was_redone_cold)
            fd = fd + side*STENCIL(s)*other/(H*unit)
          end do
        end do
        call set_parameter(model, p, value)
        call t%check_below('the derivative of the shape to '//parameter%name, maxval(abs(fd - d(:, :, p)))/ &
                           max(maxval(abs(d(:, :, p))), 1.0e-3_rp*scale), 1.0e-6_rp)
      end do
    end do
    values = singular_values(reshape(d, [3*model%n_all, model%params%count_basic()]))
    call t%check_close('singular values keep the Frobenius norm', norm2(values), norm2(d), rtol=1.0e-12_rp)
    call t%check_below('thickness and D are one parameter', values(size(values))/values(1), 1.0e-9_rp)
    call work%free()
  end subroutine test_sensitivities

  subroutine test_failures()
    type(solid_model_t) :: model
    type(equilibrium_t) :: work
    type(load_t) :: load
    type(failure_t) :: failure
    type(static_report_t) :: report
    type(static_options_t) :: options
    character(:), allocatable :: note
    logical :: is_soft
    real(rp), allocatable :: u(:, :)
    call make_model(.false., model)
    call work%init(model)
    allocate (u(3, model%n_all), source=0.0_rp)
    call t%check_close('D = 0.2 mN mm means 7.6 um at 5 GPa', membrane_thickness(model%params, 2.0e-7_rp), &
                       7.59e-6_rp, &
                       rtol=1.0e-3_rp)
    call membrane_note(model%params, note, is_soft)
    call t%check('the note says what D means', index(note, ' 7.59 um') > 0 .and. .not. is_soft)
    model%params%plate = 2.0e-8_rp
    call membrane_note(model%params, note, is_soft)
    call t%check('a small D is warned of', is_soft)
    model%params%plate = 2.0e-7_rp
    call load%init(model)
    call solve_static(work, model, load, .false., options, u, report)
    call t%check('without load nothing moves', report%converged .and. maxval(abs(u)) < 1.0e-15_rp)
    call load%add_at(model, [0.02_rp, 0.0_rp], [0.0_rp, 0.0_rp, 1.0e-3_rp], failure)
    call t%check('a load beside the wing is refused', failure%failed)
    call make_load(model, 1, 1.0e-3_rp, load)
    options%factorisation_limit = 5
    call solve_static(work, model, load, .false., options, u, report)
    call t%check('too little work is a failure with a reason',.not. report%converged .and. &
                 allocated(report%reason))
    options = static_options_t()
    call set_parameter(model, model%params%find('D'), 0.0_rp)
    call solve_static(work, model, load, .false., options, u, report)
    call t%check('a membrane without bending stiffness is refused',.not. report%converged .and. &
                 allocated(report%reason))
    call work%free()
  end subroutine test_failures
end program test_solid_statics

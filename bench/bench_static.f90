! SPDX-License-Identifier: GPL-3.0-or-later
!> Static shapes of a wing: how often, how fast and how reproducibly they are found.
!>
!> usage: bench_static WING.h5 [table]
!>
!> Ten loads x four Young's moduli x soft and stiff joints x cross-springs off and on, with forces that
!> move the loaded point by 0.05 to 0.3 R; each shape cold, with steps of half the size, and warm from
!> the shape for parameters that differ by factors exp(0.1 N(0,1)), or cold again where that shape lies
!> behind a snap. D is 0.2 mN mm; with `table` a row
!> is printed for each of several D. The last line is a JSON object for D = 0.2 mN mm.
program bench_static
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use bench_places, only: N_LOADS, load_at, wing_of_argument
  use solid_dynamics, only: dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_equilibrium, only: equilibrium_t
  use solid_inertia, only: inertia_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_motion, only: steady_motion_t
  use solid_params, only: solid_params_t, default_params, membrane_thickness
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_wing, only: wing_t
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  integer, parameter :: N_CASES = 16*N_LOADS
  real(rp), parameter :: YOUNG(4) = [0.5e9_rp, 5.0e9_rp, 12.6e9_rp, 50.0e9_rp], JOINTS(2) = [0.05_rp, 5.0_rp]
  real(rp), parameter :: TABLE(5) = [0.02e-6_rp, 0.05e-6_rp, 0.1e-6_rp, 0.2e-6_rp, 0.4e-6_rp] ! D [N m]

  type :: case_t
    logical :: cold = .false., warm = .false.
    integer :: cold_factorisations = 0, warm_factorisations = 0, snaps = 0
    real(rp) :: cold_ms = 0, warm_ms = 0
    real(rp) :: step_difference = 0, warm_difference = 0 ! [m]
    logical :: redone = .false.
    real(rp) :: deflection = 0 ! of the loaded point, over R
    real(rp) :: residual = 0
  end type case_t

  type(case_t) :: results(N_CASES)
  character(16) :: argument
  real(rp) :: step_ms
  integer :: row

  call get_command_argument(2, argument)
  write (output_unit, '(a)') '       D      h    cold  warm   fac. cold   fac. warm snaps redone  '// &
    'steps differ  warm differs   cold ms       warm ms       w/R'
  write (output_unit, '(a)') '  mN mm     um  converged   median  max  median max              '// &
    ' > 1 nm   max m    > 1 nm   max m   median  max   median max'
  do row = 1, size(TABLE)
    if (argument == 'table') call run(TABLE(row), results)
  end do
  call run(0.2e-6_rp, results)
  step_ms = bdf2_step_ms()
  write (output_unit, '(a,i0,a,i0,a,f9.1,a,f9.1,a,f9.1,a)') '{"cases":', N_CASES, ',"converged":', &
    count(results%cold .and. results%warm), ',"cold_ms_median":', median(results%cold_ms), &
    ',"warm_ms_median":', median(results%warm_ms), ',"bdf2_ms":', step_ms, '}'

contains

  !> All cases for one D [N m]; prints a row.
  subroutine run(plate, cases)
    real(rp), intent(in) :: plate
    type(case_t), intent(out) :: cases(:)
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(equilibrium_t) :: work
    type(failure_t) :: failure
    real(rp), allocatable :: stiff(:)
    integer :: cross_springs, e, j, l, n
    wing = wing_of_argument()
    n = 0
    do cross_springs = 0, 1
      params = default_params(wing)
      params%plate = plate
      params%young = 12.6e9_rp
      params%cross_springs = cross_springs == 1
      call model%init(wing, params, failure)
      call require(.not. failure%failed, 'the benchmark''s wing is wrong')
      stiff = model%params%joint ! as the veins at 12.6 GPa
      call work%init(model)
      do e = 1, size(YOUNG)
        do j = 1, size(JOINTS)
          params = model%params
          params%young = YOUNG(e)
          params%joint = JOINTS(j)*stiff
          do l = 1, N_LOADS
            n = n + 1
            call one_case(model, work, params, l, cases(n))
          end do
        end do
      end do
      call work%free()
    end do
    write (output_unit, '(f8.3,f7.2,2i6,i8,i6,i6,i6,2i6,i8,es10.1,i7,es10.1,4f8.1,2f6.2)') plate*1.0e6_rp, &
      membrane_thickness(params, plate)*1.0e6_rp, count(cases%cold), count(cases%warm), &
      nint(median(real(cases%cold_factorisations, rp))), maxval(cases%cold_factorisations), &
      nint(median(real(cases%warm_factorisations, rp))), maxval(cases%warm_factorisations), &
      sum(cases%snaps), count(cases%redone), count(cases%step_difference > 1.0e-9_rp), &
      maxval(cases%step_difference), count(cases%warm_difference > 1.0e-9_rp), &
      maxval(cases%warm_difference), median(cases%cold_ms), maxval(cases%cold_ms), &
      median(cases%warm_ms), maxval(cases%warm_ms), minval(cases%deflection), &
      maxval(cases%deflection)
    flush (output_unit)
  end subroutine run

  subroutine one_case(model, work, params, place, result)
    type(solid_model_t), intent(inout) :: model
    type(equilibrium_t), intent(inout) :: work
    type(solid_params_t), intent(in) :: params
    integer, intent(in) :: place
    type(case_t), intent(out) :: result
    type(solid_params_t) :: other
    type(load_t) :: load
    type(static_report_t) :: report
    type(static_options_t) :: options, search
    real(rp), allocatable :: u(:, :), v(:, :)
    real(rp) :: force, target, t0, t1, w, last_force, last_w, next
    integer :: attempt, p
    logical :: is_warm
    allocate (u(3, model%n_all), v(3, model%n_all), source=0.0_rp)
    call model%set_params(params)
    target = model%size*(0.06_rp + 0.22_rp*mod(3*place, N_LOADS)/(N_LOADS - 1))
    force = 1.0e-5_rp
    last_w = 0
    search%redo_cold = .false.
    search%tolerance = 1.0e-3_rp
    do attempt = 1, 8 ! the force for this deflection
      call load_at(model, place, force, load)
      call solve_static(work, model, load, attempt > 1, search, u, report)
      w = deflection(load, u)
      if (.not. report%converged .or. abs(w/target - 1) < 0.15_rp) exit
      next = force*min(8.0_rp, max(0.125_rp, target/w))
      if (last_w > 0) next = force*min(8.0_rp, max(0.125_rp, &
                                                   (target/w)**(log(force/last_force)/log(w/last_w))))
      last_force = force
      last_w = w
      force = next
    end do
    call cpu_time(t0)
    call solve_static(work, model, load, .false., options, u, report)
    call cpu_time(t1)
    result%cold_ms = 1000*(t1 - t0)
    result%cold = report%converged
    result%residual = report%residual
    result%cold_factorisations = report%factorisations
    result%snaps = report%snaps
    result%deflection = deflection(load, u)/model%size

    options%step_limit = options%step_limit/2
    call solve_static(work, model, load, .false., options, v, report)
    result%step_difference = maxval(abs(v - u))
    options = static_options_t()

    other = params
    other%young = params%young*exp(0.1_rp*normal(place, 0))
    do p = 1, size(params%joint)
      other%joint(p) = params%joint(p)*exp(0.1_rp*normal(place, p))
    end do
    call model%set_params(other)
    call solve_static(work, model, load, .false., options, v, report)
    call model%set_params(params)
    is_warm = report%snaps == 0 ! a shape behind a snap is no start: the path there may not be the cold one
    call cpu_time(t0)
    call solve_static(work, model, load, is_warm, options, v, report)
    call cpu_time(t1)
    result%warm_ms = 1000*(t1 - t0)
    result%warm = report%converged
    result%warm_factorisations = report%factorisations
    result%redone = report%was_redone_cold .or. .not. is_warm
    result%warm_difference = maxval(abs(v - u))

  end subroutine one_case

  !> Movement [m] of the loaded place.
  real(rp) function deflection(load, u)
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: u(:, :)
    deflection = sum(load%force(3, :)*u(3, :))/sum(load%force(3, :))
  end function deflection

  !> A number from a fixed sample of the normal distribution, roughly.
  pure real(rp) function normal(i, j)
    integer, intent(in) :: i, j
    real(rp) :: x(12)
    integer :: k
    x = [(modulo(12.9898_rp*i + 78.233_rp*j + 37.719_rp*k + 0.618_rp*k**2*(i + 3*j), 1.0_rp), k=1, 12)]
    normal = sum(x) - 6
  end function normal

  real(rp) function median(values)
    real(rp), intent(in) :: values(:)
    real(rp) :: sorted(size(values)), x
    integer :: i, j
    sorted = values
    do i = 2, size(sorted)
      x = sorted(i)
      j = i - 1
      do while (j >= 1)
        if (sorted(j) <= x) exit
        sorted(j + 1) = sorted(j)
        j = j - 1
      end do
      sorted(j + 1) = x
    end do
    median = sorted((size(sorted) + 1)/2)
  end function median

  !> CPU time of one step, 1/1000 of a wingbeat at 158 Hz, moving under 2 mN.
  real(rp) function bdf2_step_ms() result(ms)
    integer, parameter :: STEPS = 40
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(failure_t) :: failure
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: spin
    real(rp), allocatable :: force(:, :)
    real(rp) :: t0, t1
    integer :: i, iterations
    wing = wing_of_argument()
    params = default_params(wing)
    params%cross_springs = .true.
    call model%init(wing, params, failure)
    call require(.not. failure%failed, 'the benchmark''s wing is wrong')
    call inertia%init(model, spread(250.0e-9_rp/model%n_points, 1, model%n_points))
    call stepper%init(model)
    call state%init(model, 0.0_rp)
    allocate (force(3, model%n_all), source=0.0_rp)
    force(3, :) = 2.0e-3_rp/model%n_points
    spin%frame%omega = [0.0_rp, 300.0_rp, 1000.0_rp]
    iterations = 0
    call cpu_time(t0)
    do i = 1, STEPS
      call stepper%step(model, inertia, spin, force, 1.0e-3_rp/158, options, state, report)
      call require(report%converged, 'a time step of the benchmark failed')
      iterations = iterations + report%iterations
    end do
    call cpu_time(t1)
    call stepper%free()
    ms = 1000*(t1 - t0)/STEPS
    write (output_unit, '(a,f6.2,a,f5.1,a,f6.3,a)') 'BDF2: ', ms, ' ms and ', real(iterations, rp)/STEPS, &
      ' iterations a step, the wing has moved by ', maxval(abs(state%u))*1000, ' mm'
  end function bdf2_step_ms
end program bench_static

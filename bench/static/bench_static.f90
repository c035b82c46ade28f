! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures how often, how fast and how reproducibly the static shapes of a wing are found.
!>
!> usage: bench_static WING.h5 [table [STRIDE] | robust | dependence | step]
!>
!> The cases are ten loads x four Young's moduli x soft and stiff joints x cross-springs off and on, with forces that move the
!> loaded point by about 0.06 to 0.28 R (within 15 %). Each shape is computed cold (from the shape at rest), with steps of half
!> the size, and warm from the shape for parameters that differ by factors exp(0.1 N(0,1)), or cold again where the wing has to
!> snap through between the two shapes. D is 0.2 mN mm, and the last line is a JSON object.
!>
!> `table`: the same forces for several D, a row for each; of the cases only every STRIDE-th.
!> `robust`: E from 0.1 to 100 GPa, joints over four decades, deflections up to 0.45 of the place's
!> distance from the root. `dependence`: how D changes deflections, and which E and joints hide it.
!> `step`: time steps only.
program bench_static
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use bench_dependence, only: print_dependence
  use loaded_wing, only: N_LOADS, place_on_wing, wing_of_argument
  use solid_dynamics, only: dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_equilibrium, only: equilibrium_t
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  use solid_motion, only: steady_motion_t
  use solid_params, only: solid_params_t, default_params, membrane_thickness
  use solid_wing, only: wing_t
  use wing_shapes, only: shape_t, find_force, measure_shape, median
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  integer, parameter :: N_CASES = 16*N_LOADS
  real(rp), parameter :: YOUNG(4) = [0.5e9_rp, 5.0e9_rp, 12.6e9_rp, 50.0e9_rp], JOINTS(2) = [0.05_rp, 5.0_rp]
  real(rp), parameter :: PLATE = 0.2e-6_rp, TABLE(4) = [0.4e-6_rp, 0.1e-6_rp, 0.05e-6_rp, 0.02e-6_rp] ! D [N m]
  type(wing_t) :: wing
  type(shape_t) :: shapes(N_CASES), others(N_CASES)
  real(rp) :: forces(N_CASES), step_ms, radius
  character(16) :: mode, argument
  integer :: row, stride

  call get_command_argument(2, mode)
  call get_command_argument(3, argument)
  stride = 1
  if (len_trim(argument) > 0) read (argument, *) stride
  wing = wing_of_argument()
  radius = maxval(wing%points(1, :))
  select case (mode)
  case ('table')
    call print_heading()
    call run(PLATE, stride, .true., forces, shapes)
    call print_row(PLATE, stride, shapes, shapes)
    do row = 1, size(TABLE)
      call run(TABLE(row), stride, .false., forces, others)
      call print_row(TABLE(row), stride, others, shapes)
    end do
  case ('robust')
    call run_robust()
  case ('dependence')
    call print_dependence(wing)
  case ('step')
    step_ms = bdf2_step_ms()
    write (output_unit, '(a,i0,a,f0.2,a)') '{"points":', size(wing%points, 2), ',"bdf2_ms":', step_ms, '}'
  case default
    call print_heading()
    call run(PLATE, stride, .true., forces, shapes)
    call print_row(PLATE, stride, shapes, shapes)
    write (output_unit, '(a,f5.3,a,f5.3,a)') 'The loaded places move by ', minval(shapes%deflection)/radius, ' to ', &
      maxval(shapes%deflection)/radius, ' R'
    step_ms = bdf2_step_ms()
    write (output_unit, '(3(a,i0),3(a,f9.1),a)') '{"cases":', N_CASES, ',"converged":', &
      count(shapes%cold .and. shapes%warm), ',"repeated":', count(shapes%repeated), &
      ',"cold_ms_median":', median(shapes%cold_ms), ',"warm_ms_median":', median(shapes%warm_ms), ',"bdf2_ms":', step_ms, '}'
  end select

contains

  !> Runs every `stride`-th case for one D [N m], with forces that are searched for or given.
  subroutine run(plate, stride, is_search, forces, shapes)
    real(rp), intent(in) :: plate
    integer, intent(in) :: stride
    logical, intent(in) :: is_search
    real(rp), intent(inout) :: forces(:)
    type(shape_t), intent(out) :: shapes(:)
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(equilibrium_t) :: work
    type(failure_t) :: failure
    real(rp), allocatable :: stiff(:), u(:, :)
    integer :: cross_springs, e, j, l, n
    n = 0
    do cross_springs = 0, 1
      params = default_params(wing)
      params%plate = plate
      params%young = 12.6e9_rp
      params%cross_springs = cross_springs == 1
      call model%init(wing, params, failure)
      call require(.not. failure%failed, 'the benchmark''s wing is wrong')
      stiff = model%params%joint ! as stiff as the veins at 12.6 GPa
      call work%init(model)
      if (.not. allocated(u)) allocate (u(3, model%n_all))
      do e = 1, size(YOUNG)
        do j = 1, size(JOINTS)
          params = model%params
          params%young = YOUNG(e)
          params%joint = JOINTS(j)*stiff
          do l = 1, N_LOADS
            n = n + 1
            if (mod(n - 1, stride) > 0) cycle
            call model%set_params(params)
            if (is_search) call find_force(model, work, l, model%size* &
                                           (0.06_rp + 0.22_rp*mod(3*l, N_LOADS)/(N_LOADS - 1)), forces(n))
            call measure_shape(model, work, params, l, forces(n), u, shapes(n))
          end do
        end do
      end do
      call work%free()
    end do
  end subroutine run

  subroutine print_heading()
    write (output_unit, '(a)') '      D     h cases cold warm  fac. cold   fac. warm  snaps redone  '// &
      'steps differ  warm differs   cold ms         warm ms       w/w(D=0.2)'
    write (output_unit, '(a)') '  mN mm    um       converged median  max median  max               '// &
      '>1 nm   max m >1 nm   max m  median     max median     max  min  mean   max'
  end subroutine print_heading

  !> Prints the results for one D [N m], and the deflections that the same forces cause with the default D.
  subroutine print_row(plate, stride, all_shapes, references)
    real(rp), intent(in) :: plate
    integer, intent(in) :: stride
    type(shape_t), intent(in) :: all_shapes(:), references(:)
    type(shape_t) :: s((size(all_shapes) - 1)/stride + 1)
    real(rp) :: ratios(size(s))
    s = all_shapes(::stride)
    ratios = s%deflection/references(::stride)%deflection
    write (output_unit, '(f7.3,f6.2,3i5,2(i7,i5),2i7,2(i6,es9.1),2(f8.1,f8.0),3f6.3)') plate*1.0e6_rp, &
      membrane_thickness(default_params(wing), plate)*1.0e6_rp, size(s), count(s%cold), count(s%warm), &
      nint(median(real(s%cold_factorisations, rp))), maxval(s%cold_factorisations), &
      nint(median(real(s%warm_factorisations, rp))), maxval(s%warm_factorisations), &
      sum(s%snaps), count(s%redone), count(s%step_difference > 1.0e-9_rp), maxval(s%step_difference), &
      count(s%warm_difference > 1.0e-9_rp), maxval(s%warm_difference), median(s%cold_ms), &
      maxval(s%cold_ms), median(s%warm_ms), maxval(s%warm_ms), minval(ratios), &
      sum(ratios, s%cold)/max(1, count(s%cold)), maxval(ratios)
    flush (output_unit)
  end subroutine print_row

  !> Prints cases far from the usual parameters: two loads x two deflections for each E and each factor on the joints, whose
  !> stiffness at factor 1 is that of the veins at 12.6 GPa. Each pair has a row.
  subroutine run_robust()
    real(rp), parameter :: E(4) = [1.0e8_rp, 1.0e9_rp, 1.0e10_rp, 1.0e11_rp], FACTORS(5) = &
                           [0.01_rp, 0.1_rp, 1.0_rp, 10.0_rp, 100.0_rp], DEFLECTIONS(2) = [0.1_rp, 0.45_rp]
    integer, parameter :: PLACES(2) = [5, 6]
    type(shape_t) :: shapes(size(PLACES)*size(DEFLECTIONS))
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(equilibrium_t) :: work
    type(failure_t) :: failure
    real(rp), allocatable :: stiff(:), u(:, :)
    real(rp) :: force, place(2)
    integer :: i, j, l, d, n
    params = default_params(wing)
    params%plate = PLATE
    params%young = 12.6e9_rp
    call model%init(wing, params, failure)
    call require(.not. failure%failed, 'the benchmark''s wing is wrong')
    stiff = model%params%joint
    call work%init(model)
    allocate (u(3, model%n_all))
    write (output_unit, '(a)') '  E GPa  joints cases cold warm  fac. cold   fac. warm  snaps redone  '// &
      'steps differ  warm differs    w/R'
    write (output_unit, '(a)') '                      converged median  max median  max               '// &
      '>1 nm   max m >1 nm   max m  min  max'
    do i = 1, size(E)
      do j = 1, size(FACTORS)
        params = model%params
        params%young = E(i)
        params%joint = FACTORS(j)*stiff
        n = 0
        do d = 1, size(DEFLECTIONS)
          do l = 1, size(PLACES)
            n = n + 1
            call model%set_params(params)
            place = place_on_wing(model, PLACES(l))
            call find_force(model, work, PLACES(l), DEFLECTIONS(d)*place(1), force)
            call measure_shape(model, work, params, PLACES(l), force, u, shapes(n))
          end do
        end do
        write (output_unit, '(f7.1,f8.2,3i5,2(i7,i5),2i7,2(i6,es9.1),2f6.2)') E(i)*1.0e-9_rp, FACTORS(j), n, &
          count(shapes%cold), count(shapes%warm), nint(median(real(shapes%cold_factorisations, rp))), &
          maxval(shapes%cold_factorisations), nint(median(real(shapes%warm_factorisations, rp))), &
          maxval(shapes%warm_factorisations), sum(shapes%snaps), count(shapes%redone), &
          count(shapes%step_difference > 1.0e-9_rp), maxval(shapes%step_difference), &
          count(shapes%warm_difference > 1.0e-9_rp), maxval(shapes%warm_difference), &
          minval(shapes%deflection)/model%size, maxval(shapes%deflection)/model%size
        flush (output_unit)
      end do
    end do
    call work%free()
  end subroutine run_robust

  !> Measures the CPU time of one step, which is 1/1000 of a wingbeat at 158 Hz and in which the wing moves under 2 mN.
  real(rp) function bdf2_step_ms() result(ms)
    integer, parameter :: STEPS = 40
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

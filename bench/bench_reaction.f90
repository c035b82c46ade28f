! SPDX-License-Identifier: GPL-3.0-or-later
!> Time steps of a wing with a dense load that answers its velocity, against those without, of the same wing in the
!> same run, step by step in turn: other load on the machine meets both.
!>
!> usage: bench_reaction WING.h5
!>
!> A row for each response (`layer`: of a fluid that smooths over the distance of the markers; `kernel`: exp(-r/l)), mass of the wing and
!> number of markers: medians of the CPU time of a step without and with the load and of their ratio; iterations of
!> Newton's method, factorisations, iterations of GMRES and products with the dense matrix a step.
program bench_reaction
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use bench_places, only: wing_of_argument
  use bench_shapes, only: median
  use marker_reaction, only: marker_reaction_t, place_markers, exponential_kernel, layer_kernel
  use solid_dynamics, only: dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  use solid_motion, only: steady_motion_t
  use solid_params, only: solid_params_t, default_params
  use solid_wing, only: wing_t
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  integer, parameter :: MARKERS(2) = [60, 433], STEPS = 60
  real(rp), parameter :: MASS = 250.0e-9_rp, DENSITY = 1.2_rp, DT = 1.0e-3_rp/158 ! [kg], [kg/m^3], [s]
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(solid_params_t) :: params
  type(failure_t) :: failure
  integer :: i, k

  wing = wing_of_argument()
  params = default_params(wing)
  params%cross_springs = .true.
  call model%init(wing, params, failure)
  call require(.not. failure%failed, 'the benchmark''s wing is wrong')
  write (output_unit, '(a)') 'response  mass   3 m   ms without   with  ratio   Newton     factors     GMRES  products  |w| mm'
  do k = 1, 2
    do i = 1, size(MARKERS)
      call measure(k == 1, MARKERS(i), MASS)
      call measure(k == 1, MARKERS(i), MASS/100)
    end do
  end do

contains

  !> One row.
  subroutine measure(is_layer, n_markers, mass_of_wing)
    logical, intent(in) :: is_layer
    integer, intent(in) :: n_markers
    real(rp), intent(in) :: mass_of_wing
    type(marker_reaction_t) :: reaction
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper(2)
    type(dynamic_state_t) :: state(2)
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: spin
    real(rp), allocatable :: force(:, :), weights(:, :), places(:, :)
    integer, allocatable :: nodes(:, :)
    real(rp) :: t(0:2), ms(2, STEPS), spacing
    integer :: i, counts(3, 2)
    call place_markers(model, n_markers, nodes, weights, places)
    spacing = sqrt(27.0e-6_rp/n_markers)
    if (is_layer) then
      call reaction%init(model, nodes, weights, layer_kernel(places, 0.7_rp*spacing, DENSITY), DT)
    else
      call reaction%init(model, nodes, weights, exponential_kernel(places, 2*spacing, 0.1_rp, MASS), DT)
    end if
    spin%frame%omega = [0.0_rp, 300.0_rp, 1000.0_rp]
    allocate (force(3, model%n_all), source=0.0_rp)
    force(3, :) = 2.0e-3_rp/model%n_points
    call inertia%init(model, spread(mass_of_wing/model%n_points, 1, model%n_points))
    do i = 1, 2
      call stepper(i)%init(model)
      call state(i)%init(model, 0.0_rp)
    end do
    counts = 0
    do i = 1, STEPS
      call cpu_time(t(0))
      if (mass_of_wing < MASS) then
        inertia%mass = 100*inertia%mass
        call stepper(1)%step(model, inertia, spin, force, DT, options, state(1), report)
        inertia%mass = inertia%mass/100
      else
        call stepper(1)%step(model, inertia, spin, force, DT, options, state(1), report)
      end if
      call require(report%converged, 'a time step without reaction failed')
      counts(:, 1) = counts(:, 1) + [report%iterations, report%factorisations, 0]
      call cpu_time(t(1))
      call reaction%begin_step(spin%frame, state(2)%u, state(2)%v)
      call stepper(2)%step(model, inertia, spin, force, DT, options, state(2), report, reaction=reaction)
      call require(report%converged, 'a time step with a reaction failed')
      call cpu_time(t(2))
      counts(:, 2) = counts(:, 2) + [report%iterations, report%factorisations, 0]
      ms(:, i) = 1000*(t(1:2) - t(0:1))
    end do
    counts(3, 2) = stepper(2)%solver%residuals%n_iterations
    write (output_unit, '(a,t10,f5.2,i6,f12.2,f8.2,f7.2,2(f6.1,f5.1),2f9.1,2f7.3)') merge('layer ', 'kernel', is_layer), &
      mass_of_wing/MASS, size(reaction%around), median(ms(1, :)), median(ms(2, :)), median(ms(2, :)/ms(1, :)), &
      transpose(real(counts(1:2, :), rp))/STEPS, real(counts(3, 2), rp)/STEPS, real(reaction%calls, rp)/STEPS, &
      maxval(abs(state(1)%u))*1000, maxval(abs(state(2)%u))*1000
    flush (output_unit)
    do i = 1, 2
      call stepper(i)%free()
    end do
  end subroutine measure
end program bench_reaction

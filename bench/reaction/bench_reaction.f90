! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures time steps of a wing with a dense load that depends on its velocity, and steps of the same wing without it. Both are
!> made in turn in the same run, so that other load on the machine disturbs both alike.
!>
!> usage: bench_reaction WING.h5
!>
!> Prints a row for each response (`flow`: that of air around a wing without thickness; `kernel`: exp(-r/l), with the wing's mass
!> as the added one), each mass of the wing (1: 250 ug, also without the load) and each distance of the markers. The row has
!> medians of the CPU time of a step without and with the load and of their ratio; the iterations of Newton's method and the
!> factorisations, both without and with the load; the iterations of the linear solver and the products with the dense matrix in a
!> step; and how far the wing has moved. The program is called through bench/reaction/run.
program bench_reaction
  use base_constants, only: PI
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use fsi_green, only: green_t
  use fsi_markers, only: markers_t
  use loaded_wing, only: wing_of_argument
  use marker_reaction, only: marker_reaction_t, exponential_kernel
  use solid_dynamics, only: dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  use solid_motion, only: steady_motion_t
  use solid_params, only: solid_params_t, default_params
  use solid_wing, only: wing_t
  use wing_shapes, only: median
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  integer, parameter :: STEPS = 60
  real(rp), parameter :: SPACINGS(2) = [7.9e-4_rp, 2.57e-4_rp] ! [m] of 180 and 1300 unknowns
  real(rp), parameter :: MASS = 250.0e-9_rp, DT = 1.0e-3_rp/158 ! [kg], [s]
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
  write (output_unit, '(a)') 'response   mass    3 m  without ms  with   ratio  Newton       factors    linear products     |u| mm'
  do k = 1, 2
    do i = 1, size(SPACINGS)
      call measure(k == 1, SPACINGS(i), MASS)
      call measure(k == 1, SPACINGS(i), MASS/100)
    end do
  end do

contains

  !> Measures and prints one row.
  subroutine measure(is_flow, spacing, mass_of_wing)
    logical, intent(in) :: is_flow
    real(rp), intent(in) :: spacing, mass_of_wing
    type(markers_t) :: markers
    type(marker_reaction_t) :: reaction
    type(inertia_t) :: inertia, usual
    type(dynamics_t) :: stepper(2)
    type(dynamic_state_t) :: state(2)
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: spin
    real(rp), allocatable :: force(:, :), sites(:, :)
    real(rp) :: t(0:2), ms(2, STEPS)
    integer :: i, counts(2, 2), inner
    call markers%init(model%points(:, :model%n_points), model%triangles, spacing, .false.)
    allocate (sites(3, markers%n))
    call markers%positions(model%points, sites)
    if (is_flow) then
      call reaction%init(model, markers%nodes, markers%weights, flow_kernel(sites, spacing), DT)
    else
      call reaction%init(model, markers%nodes, markers%weights, &
                         exponential_kernel(sites, 2*spacing, 0.1_rp, MASS), DT)
    end if
    spin%frame%omega = [0.0_rp, 300.0_rp, 1000.0_rp]
    allocate (force(3, model%n_all), source=0.0_rp)
    force(3, :) = 2.0e-3_rp/model%n_points
    call inertia%init(model, spread(mass_of_wing/model%n_points, 1, model%n_points))
    call usual%init(model, spread(MASS/model%n_points, 1, model%n_points))
    do i = 1, 2
      call stepper(i)%init(model)
      call state(i)%init(model, 0.0_rp)
    end do
    counts = 0
    inner = 0
    do i = 1, STEPS
      call cpu_time(t(0))
      call stepper(1)%step(model, usual, spin, force, DT, options, state(1), report)
      call require(report%converged, 'a time step without reaction failed')
      counts(:, 1) = counts(:, 1) + [report%iterations, report%factorisations]
      call cpu_time(t(1))
      call reaction%begin_step(spin%frame, state(2)%u, state(2)%v)
      call stepper(2)%step(model, inertia, spin, force, DT, options, state(2), report, reaction=reaction)
      call require(report%converged, 'a time step with a reaction failed')
      call cpu_time(t(2))
      counts(:, 2) = counts(:, 2) + [report%iterations, report%factorisations]
      inner = inner + report%inner
      ms(:, i) = 1000*(t(1:2) - t(0:1))
    end do
    write (output_unit, '(a,t10,f6.2,i7,f10.2,f8.2,f7.2,2(f7.1,f5.1),2f9.1,2f7.3)') merge('flow  ', 'kernel', is_flow), &
      mass_of_wing/MASS, size(reaction%around), median(ms(1, :)), median(ms(2, :)), median(ms(2, :)/ms(1, :)), &
      transpose(real(counts, rp))/STEPS, real(inner, rp)/STEPS, real(reaction%calls, rp)/STEPS, &
      maxval(abs(state(1)%u))*1000, maxval(abs(state(2)%u))*1000
    flush (output_unit)
    do i = 1, 2
      call stepper(i)%free()
    end do
  end subroutine measure
  !> Computes the velocities at markers in air that impulses at these markers cause: 1/rho times the Green tensor of fsi_green for
  !> a grid whose spacing is half that of the markers and which is truncated at two thirds.
  function flow_kernel(sites, spacing) result(m)
    real(rp), intent(in) :: sites(:, :), spacing
    real(rp) :: m(3*size(sites, 2), 3*size(sites, 2))
    real(rp), parameter :: DENSITY = 1.2_rp ! [kg/m^3]
    type(green_t) :: green
    integer :: i, j
    call green%init(2*PI/3*2/spacing, 1.1_rp*norm2(maxval(sites, 2) - minval(sites, 2)), .false.)
    do j = 1, size(sites, 2)
      do i = 1, size(sites, 2)
        m(3*i - 2:3*i, 3*j - 2:3*j) = green%at(sites(:, i) - sites(:, j))/DENSITY
      end do
    end do
  end function flow_kernel
end program bench_reaction

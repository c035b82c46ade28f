! SPDX-License-Identifier: GPL-3.0-or-later
!> The pressure of a Taylor-Green flow, known exactly, on a wing at rest in it: from the spectrum over the
!> sampling and the wing frame to newtons and the first motion of the wing.
program test_coupler
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fsi_coupler, only: coupler_t
  use fsi_coupler_params, only: coupler_params_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flight_params, only: flight_params_t
  use fsi_kinematics, only: body_rotation
  use fsi_rotation, only: angle_t, cross
  use io_units, only: unit_scales_t
  use sample_wings, only: make_fly_wing
  use solid_inertia, only: momenta_t
  use solid_params, only: default_params
  use solid_wing, only: wing_t
  use support_fluid, only: box_3d, make_fluid, NL
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: TWO_PI = 6.283185307179586_rp, MASS = 250.0e-9_rp, STEP = 1.0e-6_rp
  real(rp), parameter :: DISTANCE = 0.35_rp
  type(testkit_t) :: t
  real(rp) :: error(2)

  call t%start(parallel=.true.)
  call fly(32, error(1))
  call fly(64, error(2))
  ! The regularized delta damps a wave k by at most (k dx)^2/4 in each direction, here k = 2.
  call t%check_below('the load is that of the exact pressure', error(2), 3*(2*TWO_PI/64)**2/4)
  call t%check_close('to second order', error(1)/error(2), 4.0_rp, rtol=0.1_rp)
  call t%finish()

contains

  !> One step of the coupler on n^3 points; `error` is that of the force on the surface.
  subroutine fly(n, error)
    integer, intent(in) :: n
    real(rp), intent(out) :: error
    type(fluid_t) :: fluid
    type(request_t) :: request
    type(failure_t) :: failure
    type(flapping_wings_t) :: wings
    type(coupler_t) :: coupler
    type(coupler_params_t) :: params
    type(flight_params_t) :: flight
    type(wing_t) :: wing
    type(momenta_t) :: momenta
    real(rp), allocatable :: force(:, :)
    real(rp) :: newton, impulse(3), total(3)
    integer :: i

    call make_fluid(t%world, box_3d(n, TWO_PI)//'[ReynoldsNumber]'//NL//'nu=0.1'//NL// &
                    '[InitialCondition]'//NL//'inicond=taylor_green'//NL//'[Time]'//NL//'Tmax=1'//NL, fluid)
    wing = make_fly_wing(24, 12)
    params%units = unit_scales_t(length=9.0e-3_rp/1.5_rp, time=1.0e-3_rp, mass=1.2_rp*(9.0e-3_rp/1.5_rp)**3)
    params%distance = DISTANCE
    call params%model%init(wing, default_params(wing), failure)
    call params%inertia%init(params%model, [(MASS/size(wing%points, 2), i=1, size(wing%points, 2))])
    call make_flight(wing, params%units%length, flight)
    call wings%init(flight, fluid%rhs%params%grid, fluid%transform%block)
    call coupler%init(t%world, params, fluid, 0.0_rp, wings)
    request%pressure = .true.
    call fluid%evaluate(request, failure, wings)
    call coupler%sample_load(fluid, wings)
    call exact_force(wings%surfaces(1)%points, wings%surfaces(1)%triangles, force)
    total = sum(force, 2)
    error = norm2(coupler%surface_load(1) - total)/norm2(total)

    call coupler%advance(STEP, wings, failure)
    call t%check('the wing is advanced',.not. failure%failed)
    newton = params%units%mass*params%units%length/params%units%time**2
    force(:, wing%root) = 0 ! taken by the hinge
    impulse = STEP*params%units%time*newton*wings%poses(1)%vector_to_wing(sum(force, 2))
    momenta = coupler%measure(1)
    ! Elastic forces are of second order in the step: (omega dt)^2 < 1e-6 for springs of 1e5 N/m and 1e-10 kg.
    call t%check_below('the first step gives the wing the impulse of the load', &
                       norm2(momenta%linear - impulse)/norm2(impulse), 1.5_rp*error + 1.0e-4_rp)
    call t%check_close('the deformation is the state in code units', norm2(wings%deformation(1)%v(:, 50)), &
                       norm2(coupler%states(1)%v(:, 50))*params%units%time/params%units%length, rtol=1.0e-12_rp)
    call t%check_close('so is its displacement', norm2(wings%deformation(1)%u(:, 50)), &
                       norm2(coupler%states(1)%u(:, 50))/params%units%length, rtol=1.0e-12_rp)
    call t%check_close('and its acceleration, from rest', norm2(wings%deformation(1)%a(:, 50)), &
                       norm2(wings%deformation(1)%v(:, 50))/STEP, rtol=1.0e-12_rp)
    call coupler%free()
    call fluid%free()
  end subroutine fly

  !> A wing at rest somewhere in the flow, at no special angle.
  subroutine make_flight(wing, metre, flight)
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: metre
    type(flight_params_t), intent(out) :: flight
    flight%half_thickness = 0.15_rp
    flight%smoothing = 0.1_rp
    flight%body%centre = [2.1_rp, 2.4_rp, 3.3_rp]
    flight%body%rotation = body_rotation(roll=angle_t(value=0.3_rp), pitch=angle_t(value=-0.5_rp), &
                                         yaw=angle_t(value=0.9_rp))
    allocate (flight%wings(1))
    flight%wings(1)%points = wing%points/metre
    flight%wings(1)%triangles = wing%triangles
    call flight%wings(1)%motion%set_constant(phi=0.2_rp, alpha=0.6_rp, theta=0.1_rp)
  end subroutine make_flight

  !> A third of (p_below - p_above) A n of every triangle on each of its corners.
  subroutine exact_force(points, triangles, force)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: triangles(:, :)
    real(rp), allocatable, intent(out) :: force(:, :)
    real(rp) :: normal(3), centre(3), area
    integer :: i, k
    allocate (force(3, size(points, 2)), source=0.0_rp)
    do i = 1, size(triangles, 2)
      associate (a => points(:, triangles(1, i)), b => points(:, triangles(2, i)), c => points(:, triangles(3, i)))
        normal = cross(b - a, c - a)
        centre = (a + b + c)/3
      end associate
      area = norm2(normal)/2
      normal = normal/norm2(normal)
      do k = 1, 3
        force(:, triangles(k, i)) = force(:, triangles(k, i)) + area/3*normal* &
                                    (pressure(centre - DISTANCE*normal) - pressure(centre + DISTANCE*normal))
      end do
    end do
  end subroutine exact_force

  !> Of the Taylor-Green flow (sin x cos y cos z, -cos x sin y cos z, 0), but for a constant.
  pure real(rp) function pressure(x)
    real(rp), intent(in) :: x(3)
    pressure = (cos(2*x(1)) + cos(2*x(2)))*(cos(2*x(3)) + 2)/16
  end function pressure
end program test_coupler

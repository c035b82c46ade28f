! SPDX-License-Identifier: GPL-3.0-or-later
!> What must come out of coupled runs without knowing the solution: the wing in a flow without density is the wing
!> alone; no wing is no wing; the grid is not felt; where the couplings are stable; friction of a linear flow.
program test_coupling_limits
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_sampling, only: sampler_t, samples_t
  use fluid_solver, only: fluid_t
  use fsi_added_mass, only: added_mass_ratio, light_layer
  use fsi_coupler, only: coupler_t
  use fsi_coupler_params, only: COUPLING_EXTRAPOLATED, COUPLING_STRONG, COUPLING_WEAK
  use fsi_coupling_history, only: coupling_history_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flight_params, only: flight_params_t
  use fsi_pressure_load, only: pressure_load_t
  use fsi_rotation, only: cross
  use fsi_surface, only: surface_t
  use fsi_wing_frame, only: flapping_motion_t
  use solid_dynamics, only: dynamic_state_t, dynamics_t, step_report_t
  use support_coupling, only: flight_t, BOX, PERIOD
  use support_fluid, only: box_3d, make_fluid, NL
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: AREA = 27.0e-6_rp !< [m^2] about that of the wing
  type(testkit_t) :: t

  call t%start(parallel=.true.)
  call no_density()
  call no_wing()
  call translation()
  call stability()
  call rectangle()
  call steps()
  call friction()
  call t%finish()

contains

  !> The motion goes to that of the wing alone in proportion to the density, with every coupling.
  subroutine no_density()
    real(rp), parameter :: T_END = 0.1_rp
    type(flight_t), allocatable :: f
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: alone
    type(step_report_t) :: report
    type(flapping_motion_t) :: motion
    real(rp), allocatable :: nothing(:, :)
    real(rp) :: changed(3), size_u
    real(rp), parameter :: DENSITIES(3) = [1.2e-2_rp, 1.2e-3_rp, 1.2e-30_rp]
    integer :: i, coupling
    do coupling = COUPLING_WEAK, COUPLING_STRONG
      do i = 1, 3
        allocate (f)
        f%params%coupling = coupling
        f%density = DENSITIES(i)
        call f%start(t%world)
        call f%step(T_END)
        call t%check('the flight succeeds',.not. f%failure%failed)
        if (.not. allocated(nothing)) then
          associate (given => f%wings%params, p => f%params)
            motion%body = given%body
            motion%mount = given%wings(1)%mount
            motion%motion = given%wings(1)%motion
            motion%length = p%units%length
            motion%frequency = 1/p%units%time
            allocate (nothing(3, p%model%n_all), source=0.0_rp)
            call stepper%init(p%model)
            call alone%init(p%model, 0.0_rp)
            do while (alone%time < (T_END - f%dt/2)*PERIOD)
              call stepper%step(p%model, p%inertia, motion, nothing, f%dt*PERIOD, p%options, alone, report)
            end do
          end associate
          size_u = maxval(abs(alone%u))
          call t%check('the wing alone bends', size_u > 1.0e-5_rp)
        end if
        changed(i) = maxval(abs(f%coupler%states(1)%u - alone%u))/size_u
        call f%free()
        deallocate (f)
      end do
      call t%check_close('the flow bends the wing in proportion to its density', changed(1)/changed(2), 10.0_rp, &
                         rtol=0.01_rp)
      ! Newton's method leaves 1e-8 of the forces, and only if its steps differ: those of sub-iterations begin elsewhere.
      call t%check_below('and not at all without density', changed(3), merge(1.0e-8_rp, 1.0e-12_rp, &
                                                                             coupling == COUPLING_STRONG))
    end do
  end subroutine no_density

  !> Coupling without wings and without anything is the same to the bit.
  subroutine no_wing()
    type(fluid_t) :: free, coupled
    type(flapping_wings_t) :: wings
    type(coupler_t) :: coupler
    type(flight_params_t) :: flight
    type(flight_t) :: f
    type(request_t) :: request, nothing
    type(failure_t) :: failure
    character(:), allocatable :: text
    integer :: i
    text = box_3d(16, BOX)//'[ReynoldsNumber]'//NL//'nu=0.05'//NL//'[Time]'//NL//'Tmax=1000'//NL//'dt_fixed=0.01'// &
           NL//'[InitialCondition]'//NL//'inicond=taylor_green'//NL
    call make_fluid(t%world, text, free)
    call make_fluid(t%world, text//'[Penalization]'//NL//'iPenalization=1'//NL//'iMask=empty'//NL//'eps=0.02'//NL, &
                    coupled, trials=.true.)
    ! A model is needed, wings are not.
    call f%start(t%world)
    allocate (flight%wings(0))
    flight%half_thickness = 0.4_rp
    flight%smoothing = 0.1_rp
    call wings%init(flight, coupled%rhs%params%grid, coupled%transform%block)
    f%params%coupling = COUPLING_STRONG
    call coupler%init(t%world, f%params, coupled, 0.0_rp, wings)
    call coupler%add_request(request)
    do i = 1, 5
      call free%step(nothing, failure)
      call coupled%step(request, failure, wings, coupler%trial)
      call coupler%sample_load(coupled, wings)
      call coupler%advance(coupled%dt, wings, failure, coupled)
    end do
    call t%check('steps without wings succeed',.not. failure%failed)
    call t%check('no wing is the pure fluid to the bit', all(abs(coupled%rhs%state%u - free%rhs%state%u) <= 0) .and. &
                 all(abs(coupled%rhs%state%history - free%rhs%state%history) <= 0))
    call coupler%free()
    call f%free()
    call free%free()
    call coupled%free()
  end subroutine no_wing

  !> Everything moved by parts of a cell: forces change by little, and by less on a finer grid.
  subroutine translation()
    real(rp) :: here(6), there(6)
    real(rp) :: changed(2, 2)
    integer :: i
    do i = 1, 2
      call flown([0.0_rp, 0.0_rp, 0.0_rp], 12 + 12*i, here)
      call flown(BOX/(12 + 12*i)*[0.3_rp, 0.5_rp, 0.7_rp], 12 + 12*i, there)
      changed(1, i) = norm2(there(:3) - here(:3))/norm2(here(:3))
      changed(2, i) = norm2(there(4:) - here(4:))/norm2(here(4:))
    end do
    ! The sum over the cells of the smoothed mask and the delta function know the grid, both to second order and more.
    call t%check_below('a shift by parts of a cell changes the surface load by 1 in 500', changed(1, 1), 2.0e-3_rp)
    call t%check_below('and the penalization force by 1 in 300', changed(2, 1), 3.3e-3_rp)
    call t%check_below('on the finer grid by less: surface load', changed(1, 2), changed(1, 1)/2)
    call t%check_below('on the finer grid by less: penalization', changed(2, 2), changed(2, 1)/2)
  end subroutine translation

  !> Force of the surface load and of the penalization at the end of a flight.
  subroutine flown(shift, n, force)
    real(rp), intent(in) :: shift(3)
    integer, intent(in) :: n
    real(rp), intent(out) :: force(6)
    type(flight_t) :: f
    f%n = n
    f%shift = shift
    call f%start(t%world)
    call f%step(0.2_rp)
    call f%sample()
    call t%check('the flight succeeds',.not. f%failure%failed)
    force = [f%coupler%loads(1)%force, f%fluid%sums%force(:, f%wings%surfaces(1)%color)]
    call f%free()
  end subroutine flown

  !> A layer of fluid of the thickness of the sheet pulls the wing with rho t/C_eta per velocity. A point under it
  !> alone, s = (dt/C_eta) rho t/(mass per area), is moved by BDF2 to z^n with
  !>
  !>     weak          3 z^2/2 - (2 - s) z + 1/2 = 0:           |z| < 1 for s < 4
  !>     extrapolated  3 z^2/2 - (2 - 2 s) z + 1/2 - s = 0:     |z| < 1 for s < 4/3
  !>
  !> whatever the mass of the fluid around. The wing as a whole bears more, strong coupling whatever there is.
  subroutine stability()
    real(rp) :: speed
    logical :: failed
    call light(COUPLING_WEAK, 3.9_rp, speed, failed)
    call t%check('weak: stable below 4', speed < 3 .and. .not. failed)
    call light(COUPLING_WEAK, 20.0_rp, speed, failed)
    call t%check('weak: unstable far beyond', failed .or. speed > 100)
    call light(COUPLING_EXTRAPOLATED, 1.3_rp, speed, failed)
    call t%check('extrapolated: stable below 4/3', speed < 6 .and. .not. failed)
    call light(COUPLING_EXTRAPOLATED, 6.5_rp, speed, failed)
    call t%check('extrapolated: unstable far beyond', failed .or. speed > 100)
    call light(COUPLING_STRONG, 20.0_rp, speed, failed)
    call t%check('strong: stable there', speed < 3 .and. .not. failed)
  end subroutine stability

  !> Largest speed in a flight with s as above.
  subroutine light(coupling, s, speed, failed)
    integer, intent(in) :: coupling
    real(rp), intent(in) :: s
    real(rp), intent(out) :: speed
    logical, intent(out) :: failed
    type(flight_t) :: f
    f%c_eta = f%dt/0.9_rp
    f%mass = 0.9_rp/s*AREA*f%density*0.4_rp*6.0e-3_rp
    f%params%coupling = coupling
    call f%start(t%world)
    call f%step(0.3_rp)
    failed = f%failure%failed
    speed = maxval(abs(f%coupler%states(1)%v))
    call f%free()
  end subroutine light

  !> rho pi c/4 per mass of the layer, for a rectangle of an even layer, and for one that is heavier in front: with a
  !> mass of 1, 1, 3 and 1, 3, 3 layers at the corners of its two triangles, a chord at 2/3 of its length weighs 17/9.
  subroutine rectangle()
    real(rp), parameter :: CHORD = 0.4_rp, LAYER = 3.0_rp, DENSITY = 1.2_rp, PI = 3.141592653589793_rp
    real(rp), parameter :: TINY_EDGE = 1.0e-3_rp
    real(rp) :: points(3, 4), masses(4), flap(3, 3)
    integer :: triangles(3, 2)
    points(:, 1) = [0.0_rp, 0.0_rp, 0.0_rp]
    points(:, 2) = [1.0_rp, 0.0_rp, 0.0_rp]
    points(:, 3) = [1.0_rp, CHORD, 0.0_rp]
    points(:, 4) = [0.0_rp, CHORD, 0.0_rp]
    triangles(:, 1) = [1, 2, 3]
    triangles(:, 2) = [1, 3, 4]
    masses = LAYER*CHORD*[2.0_rp, 1.0_rp, 2.0_rp, 1.0_rp]/6
    call t%check_close('added mass of a rectangle', added_mass_ratio(points, triangles, masses, DENSITY), &
                       DENSITY*PI/4*CHORD/LAYER, rtol=1.0e-12_rp)
    masses(3:4) = 3*masses(3:4)
    call t%check_close('of one that is heavier in front', added_mass_ratio(points, triangles, masses, DENSITY), &
                       DENSITY*PI/4*CHORD/(LAYER*17/9), rtol=1.0e-12_rp)
    call t%check_close('its lighter part is behind', light_layer(points, triangles, masses), LAYER, rtol=1.0e-12_rp)
    flap = points(:, 1:3)
    flap(1, 1) = flap(1, 2) - TINY_EDGE
    flap(2, 3) = flap(2, 2) + TINY_EDGE
    call t%check_close('a light flap of less than a tenth does not matter', &
                       light_layer(reshape([points, flap], [3, 7]), reshape([triangles, [5, 6, 7]], [3, 3]), &
                                   [masses, 0.0_rp, 0.0_rp, 0.0_rp]), LAYER, rtol=1.0e-12_rp)
    masses(2) = masses(2)/5
  call t%check_close('a light corner of a sixth does', light_layer(points, triangles, masses), LAYER/5, rtol=1.0e-12_rp)
  end subroutine rectangle

  !> A load that is linear in time is extrapolated exactly over steps of different length, and kept in the first.
  subroutine steps()
    type(coupling_history_t) :: history
    real(rp) :: load(3, 2, 1), later(3, 2, 1)
    call history%init(2, 1)
    load = 5
    call history%extrapolate(0.1_rp, load, later)
    call t%check('the first step has nothing to extrapolate', all(abs(later - 5) <= 0))
    history%force = load
    call history%record_step(0.1_rp, later)
    call history%extrapolate(0.3_rp, load + 2*0.1_rp, later)
    call t%check_below('a linear load over steps of different length', maxval(abs(later - (5 + 2*0.4_rp))), 1.0e-14_rp)
  end subroutine steps

  !> A flow that moves with the turning wing as far as the faces of the sheet and is linear beyond, differently on
  !> both sides. The delta function is exact on what is linear.
  subroutine friction()
    real(rp), parameter :: ABOVE = 0.7_rp, BELOW = -0.2_rp, NU = 0.3_rp, HALF = 0.2_rp, DISTANCE = 0.7_rp, NEAR = 0.3_rp
    type(flight_t) :: f
    type(sampler_t) :: sampler
    type(pressure_load_t) :: load
    type(samples_t) :: beside(2)
    type(failure_t) :: failure
    real(rp), allocatable :: velocity(:, :, :, :), pressure(:, :, :)
    real(rp) :: x(3), normal(3), along(3), s, expected(3)
    integer :: i, j, k
    f%n = 48
    call f%start(t%world)
    call f%wings%place(0.25_rp, f%fluid%rhs%penalty, failure)
    associate (pose => f%wings%poses(1), grid => f%fluid%rhs%params%grid, block => f%fluid%transform%block, &
               surface => f%wings%surfaces(1))
      normal = pose%vector_to_space([0.0_rp, 0.0_rp, 1.0_rp])
      along = pose%vector_to_space([0.6_rp, 0.8_rp, 0.0_rp])
      allocate (velocity(block%count(1), block%count(2), block%count(3), 3))
      allocate (pressure(block%count(1), block%count(2), block%count(3)))
      do k = 1, block%count(3)
        do j = 1, block%count(2)
          do i = 1, block%count(1)
            x = ([i, j, k] - 1 + block%start)*grid%spacing
            s = dot_product(x - pose%hinge, normal)
            velocity(i, j, k, :) = pose%hinge_velocity + cross(pose%vector_to_space(pose%omega), x - pose%hinge) + &
                                   (ABOVE*max(0.0_rp, s - HALF) + BELOW*max(0.0_rp, -s - HALF))*along
            pressure(i, j, k) = sign(5 - 2*abs(s), s)
          end do
        end do
      end do
      call sampler%init(t%world, grid, block)
      call load%init(surface)
      call sample(surface, sampler, DISTANCE, 0*pressure, beside(1))
      call load%take_pressure(surface, beside(:1))
      do i = 1, 3
        call sample(surface, sampler, DISTANCE, velocity(:, :, :, i), beside(1))
        call load%take_velocity(i, beside(1))
      end do
      call load%add_friction(surface, NU, DISTANCE, HALF)
      expected = NU*(ABOVE + BELOW)*surface%area()*along
      call t%check('the wing turns', norm2(pose%omega) > 1)
      call t%check_below('friction of a linear flow', norm2(sum(load%friction, 2) - expected), &
                         1.0e-11_rp*norm2(expected))
      call t%check('it is the force without pressure', all(abs(load%force - load%friction) <= 0))
      call sample(surface, sampler, NEAR, pressure, beside(1))
      call load%take_pressure(surface, beside(:1))
      call t%check_below('a pressure difference that falls off', maxval(abs(load%jump - 2*(5 - 2*NEAR))), 1.0e-12_rp)
      call sample(surface, sampler, 2*NEAR, pressure, beside(2))
      call load%take_pressure(surface, beside)
      call t%check_below('the same at the mid surface', maxval(abs(load%jump - 10)), 1.0e-12_rp)
    end associate
    call f%free()
  end subroutine friction

  !> Samples a field at a distance from the wing.
  subroutine sample(surface, sampler, distance, field, samples)
    type(surface_t), intent(in) :: surface
    type(sampler_t), intent(in) :: sampler
    real(rp), intent(in) :: distance, field(:, :, :)
    type(samples_t), intent(inout) :: samples
    call samples%init(2*size(surface%triangles, 2))
    call surface%points_beside(distance, samples%points)
    call sampler%sample(samples%points, field, samples%values)
  end subroutine sample
end program test_coupling_limits

! SPDX-License-Identifier: GPL-3.0-or-later
!> A flexible wing without thickness in the flow: without density it is the wing alone, very stiff it is the rigid one,
!> light it flies; what it loses the flow receives; both couplings agree; the errors of motion, force and energies fall with the
!> step, and parts of steps hardly change the motion; its place on the grid hardly matters.
program test_thin_coupling
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_shells, only: count_shells, shell_energies
  use fsi_coupler_params, only: COUPLING_STRONG, COUPLING_WEAK
  use fsi_wing_deformation, only: rotate_forces_to_space
  use fsi_wing_frame, only: flapping_motion_t
  use solid_dynamics, only: dynamic_state_t, dynamics_t, step_report_t
  use support_coupling, only: BOX, flight_t, PERIOD
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.true.)
  call no_density()
  call stiff()
  call light()
  call balance()
  call steps()
  call parts()
  call too_far()
  call translation()
  call t%finish()

contains

  !> A flight without thickness, ready to step.
  subroutine prepare(f, coupling)
    type(flight_t), intent(inout) :: f
    integer, intent(in), optional :: coupling
    f%is_thin = .true.
    f%params%coupling = COUPLING_WEAK
    if (present(coupling)) f%params%coupling = coupling
    call f%start(t%world)
    call t%check('a flight begins',.not. f%failure%failed)
  end subroutine prepare

  !> The motion goes to that of the wing alone in proportion to the density.
  subroutine no_density()
    real(rp), parameter :: T_END = 0.1_rp, DENSITIES(3) = [1.2e-2_rp, 1.2e-3_rp, 1.2e-30_rp]
    type(flight_t), allocatable :: f
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: alone
    type(step_report_t) :: report
    type(flapping_motion_t) :: motion
    real(rp), allocatable :: nothing(:, :)
    real(rp) :: changed(3), size_u
    integer :: i
    do i = 1, 3
      allocate (f)
      f%density = DENSITIES(i)
      call prepare(f)
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
      end if
      changed(i) = maxval(abs(f%coupler%states(1)%u - alone%u))/size_u
      call f%free()
      deallocate (f)
    end do
    call t%check_close('the flow bends the wing in proportion to its density', changed(1)/changed(2), 10.0_rp, rtol=0.01_rp)
    ! Newton's method leaves 1e-8 of the forces.
    call t%check_below('and not at all without density', changed(3), 1.0e-8_rp)
  end subroutine no_density

  !> The loads go to those of the rigid wing as the wing gets stiffer. Before its release a wing has them exactly.
  subroutine stiff()
    real(rp), parameter :: T_END = 0.1_rp, SOFTNESS(2) = [1.0e-3_rp, 1.0e-4_rp]
    type(flight_t), allocatable :: f
    type(request_t) :: nothing
    real(rp) :: rigid(7), loads(7), differs(2)
    integer :: i
    allocate (f)
    call prepare(f)
    do while (f%fluid%rhs%state%time < T_END - f%dt/2)
      call f%fluid%step(nothing, f%failure, f%wings)
      call f%thin%advance_rigid(f%fluid, f%wings, f%failure)
    end do
    rigid = loads_of(f)
    call f%free()
    deallocate (f)
    do i = 1, 2
      allocate (f)
      f%softness = SOFTNESS(i)
      f%params%inertia%rayleigh_stiffness = 1.0e-4_rp ! the start makes a stiff wing ring
      call prepare(f)
      call f%step(T_END)
      loads = loads_of(f)
      differs(i) = norm2(loads - rigid)/norm2(rigid)
      call f%free()
      deallocate (f)
    end do
    allocate (f)
    f%params%release = 2*T_END
    call prepare(f)
    call f%step(T_END)
    ! The condition of the response is some hundreds.
    call t%check_below('a wing that is held has the loads of the rigid one', norm2(loads_of(f) - rigid)/norm2(rigid), 1.0e-11_rp)
    call f%free()
    deallocate (f)
    print '(a,2es10.2)', 'stiff wings differ from the rigid one by', differs
    ! A wing of softness 1 bends by a third of its length in 0.3 T, and this one by a thousandth of that. The ratio deviates from a
    ! tenth by terms of second order, the difference times itself, and by the damping of the ringing.
    call t%check_below('a stiff wing has nearly the loads of the rigid one', differs(1), 0.01_rp)
    call t%check_below('and they go to these in proportion to its softness', differs(2), 0.12_rp*differs(1))
  end subroutine stiff

  !> Force, moment, power.
  function loads_of(f) result(loads)
    type(flight_t), intent(in) :: f
    real(rp) :: loads(7)
    associate (l => f%wings%marker_loads(1))
      loads = [l%force, l%moment, l%power]
    end associate
  end function loads_of

  !> Wings of a hundredth and a thousandth of the mass fly, with one pass a step and without any limit of the step, and
  !> do the same: the air that they move is all that has mass.
  subroutine light()
    real(rp), parameter :: T_END = 0.3_rp, MASS = 250.0e-9_rp
    type(flight_t), allocatable :: f
    real(rp), allocatable :: u(:, :, :)
    integer :: i
    logical :: flies
    flies = .true.
    do i = 1, 2
      allocate (f)
      f%mass = MASS/merge(100, 1000, i == 1)
      call prepare(f)
      call f%step(T_END)
      flies = flies .and. .not. f%failure%failed .and. f%coupler%wings(1)%report%substeps <= 1
      if (.not. allocated(u)) allocate (u(3, size(f%coupler%states(1)%u, 2), 2))
      u(:, :, i) = f%coupler%states(1)%u
      call f%free()
      deallocate (f)
    end do
    call t%check('wings of a hundredth of the mass and less fly', flies)
    print '(a,3es10.2)', 'light wings: size and difference', maxval(abs(u)), maxval(abs(u(:, :, 2) - u(:, :, 1)))
    ! The heavier one has 3 % of the mass of the air that it moves, rho pi/4 c^2 per length. Inertia makes a part of its motion.
    call t%check_below('and do nearly the same', maxval(abs(u(:, :, 2) - u(:, :, 1))), 0.01_rp*maxval(abs(u)))
  end subroutine light

  !> In every step the mean flow takes up the force on the wing, the load on its points adds up to that force, and the
  !> flow receives the power that the wing loses but for the slip. The first steps are left out of that of a wing in a small
  !> box: there the flow has all its velocity from the forces of one step, which leave out the periodic images.
  subroutine balance()
    type(flight_t), allocatable :: f
    type(request_t) :: nothing
    real(rp), allocatable :: on_points(:, :)
    real(rp) :: before(3), after(3), errors(5), sampled, lost, received
    integer :: step
    logical :: is_new, is_read
    real(rp), parameter :: READING = 1.0e-4_rp !< 1e-5 of long waves, 1e-3 of the hundredth that is next to K
    allocate (f)
    call prepare(f)
    is_read = .true.
    errors = 0
    lost = 0
    received = 0
    allocate (on_points(3, f%params%model%n_points))
    f%wings%params%thin%slip_interval = 1
    before = mean_flow(f)
    do step = 1, 30
      call f%fluid%step(nothing, f%failure, f%wings)
      ! The pass has read at the markers what was sampled there at the end of the last step.
      if (step > 1) errors(4) = max(errors(4), maxval(abs(f%fluid%rhs%reader%velocities - f%thin%flow))/f%thin%slip%speed)
      ! And the slip that it takes from that is the sampled one.
      f%thin%slip%is_measured = .false.
      call f%thin%read_slip(f%fluid, is_new)
      is_read = is_read .and. (is_new .eqv. step > 1)
      if (is_new) then
        errors(5) = max(errors(5), abs(f%thin%slip%after - sampled)/f%thin%slip%speed)
      end if
      call f%coupler%sample_load(f%fluid, f%wings)
      call f%coupler%advance(f%fluid%dt, f%wings, f%failure, f%fluid, f%thin)
      call f%thin%sample_slip(f%fluid)
      after = mean_flow(f)
      associate (load => f%wings%marker_loads(1))
        ! The mean of u x omega is 0 but for the round-off of a sum over the grid.
        errors(1) = max(errors(1), maxval(abs((after - before)*f%fluid%transform%grid%volume()/f%fluid%dt + load%force)) &
                        /norm2(load%force))
        call f%wings%place(f%fluid%rhs%state%time, f%fluid%rhs%penalty, f%failure)
        call rotate_forces_to_space(f%coupler%history%applied(:, :, 1), f%params%units, .false., f%wings%poses(1), on_points)
        errors(2) = max(errors(2), norm2(sum(on_points, 2) - load%force)/norm2(load%force))
        lost = lost + load%power
        received = received + f%thin%slip%received
        sampled = f%thin%slip%after
        if (step > 10) errors(3) = max(errors(3), f%thin%slip%after/f%thin%slip%speed)
      end associate
      before = after
    end do
    call t%check('the steps succeed',.not. f%failure%failed)
    print '(a,7es10.2)', 'momentum, load, slip, reading it, its largest, power lost, received', errors, lost, received
    call t%check('every step has a slip, which is taken once', is_read .and. f%fluid%rhs%reader%is_possible)
    call t%check_below('the next pass reads the flow at the markers', errors(4), READING)
    call t%check_below('and the largest slip', errors(5), READING)
    call t%check_below('the flow receives the momentum that the wing loses', errors(1), 1.0e-10_rp)
    call t%check_below('the load on the points is the force on the flow, turned', errors(2), 1.0e-12_rp)
    call t%check_below('the flow follows the wing', errors(3), 0.02_rp)
    call t%check_close('and receives its power', received, lost, rtol=0.02_rp)
    call f%free()
  end subroutine balance

  function mean_flow(f) result(mean)
    type(flight_t), intent(in) :: f
    real(rp) :: mean(3)
    mean = 0
    associate (sticks => f%fluid%transform%sticks)
      if (sticks%zero > 0) mean = real(f%fluid%rhs%state%u(1, sticks%zero, :))
    end associate
    call t%world%sum_reals(mean)
  end function mean_flow

  !> Motion and the balance of the wing converge with the square of the step; the wing has not begun to vibrate faster than steps
  !> resolve. The flow gets the impulse of a step at its end: of the work dt F.V of the wing it gains dt F.(V + D/2), where D is how
  !> much the flow has changed at the markers in this step by itself. This, and its part of the force, is of first order, but
  !> small. The strong coupling, which moves the markers to where the wing is found, changes the motion by far less than half the
  !> step does.
  subroutine steps()
    real(rp), parameter :: T_END = 0.1_rp, DT(3) = [0.005_rp, 0.0025_rp, 0.00125_rp]
    type(flight_t), allocatable :: f
    real(rp), allocatable :: u(:, :, :)
    real(rp) :: strong, errors(4, 0:3), forces(3, 0:3), orders(4)
    integer :: i
    do i = 0, 3
      allocate (f)
      f%dt = DT(max(i, 1))
      f%params%tolerance = 1.0e-9_rp
      call prepare(f, merge(COUPLING_STRONG, COUPLING_WEAK, i == 0))
      call fly_with_energies(f, T_END, errors(:, i), forces(:, i))
      call t%check('the flight succeeds',.not. f%failure%failed)
      if (i == 0) call t%check('the strong coupling repeats steps', f%coupler%report%total > f%coupler%report%steps)
      if (.not. allocated(u)) allocate (u(3, size(f%coupler%states(1)%u, 2), 0:3))
      u(:, :, i) = f%coupler%states(1)%u
      call f%free()
      deallocate (f)
    end do
    orders = log(abs([norm2(u(:, :, 2) - u(:, :, 1))/norm2(u(:, :, 3) - u(:, :, 2)), &
                      norm2(forces(:, 2) - forces(:, 1))/norm2(forces(:, 3) - forces(:, 2)), &
                      errors(3, 2)/errors(3, 3), errors(2, 2)/errors(2, 3)]))/log(2.0_rp)
    strong = norm2(u(:, :, 1) - u(:, :, 0))/norm2(u(:, :, 2) - u(:, :, 1))
    print '(a,4f6.2,es10.2)', 'orders of motion, force, balance, gain; strong', orders, strong
    print '(a,3es10.2)', 'differences of motion and force', norm2(u(:, :, 3) - u(:, :, 2))/norm2(u(:, :, 3)), &
      norm2(forces(:, 3) - forces(:, 2))/norm2(forces(:, 3))
    print '(a,4(/,4es10.2))', 'errors of powers and energies', errors
    call t%check_below('the error of the motion falls with the square of the step', 1.7_rp, orders(1))
    call t%check_below('so does that of the balance of the wing', 1.6_rp, orders(3))
    call t%check_below('that of the force falls with the step', 0.9_rp, orders(2))
    ! A mean that is taken for the force at the end of a step of T/800 has 2 %: the force grows by a factor of e in 0.03 T.
    call t%check_below('and is small', norm2(forces(:, 3) - forces(:, 2)), 0.006_rp*norm2(forces(:, 3)))
    call t%check_below('the strong coupling changes far less than the step does', strong, 0.02_rp)
    call t%check_below('the flow receives the power that the wing loses but for the slip', maxval(abs(errors(1, :))), 2.0e-3_rp)
    call t%check_below('the gain of the flow goes to the loss of the wing', 0.8_rp, orders(4))
    call t%check_below('and has a small error', abs(errors(2, 2)), 0.01_rp)
    call t%check_below('what the hinge gives is in wing and flow', abs(errors(4, 3)), 0.6_rp*abs(errors(4, 2)))
  end subroutine steps

  !> Newton's method that may take one iteration makes most steps in parts. If wing and flow then exchange the same impulse, the
  !> motion is that of small steps: closer to it than that of half the step.
  subroutine parts()
    real(rp), parameter :: T_END = 0.1_rp, SHORTER(3) = [8, 2, 1] !< times than the steps that are made in parts
    type(flight_t), allocatable :: f
    real(rp), allocatable :: u(:, :, :)
    real(rp) :: errors(2)
    integer :: i, n, pieces
    do i = 1, 3
      allocate (f)
      f%dt = f%dt/SHORTER(i)
      if (i == 3) f%params%options%iterations = 1
      call prepare(f)
      pieces = 0
      n = 0
      do while (f%fluid%rhs%state%time < T_END - f%dt/2 .and. .not. f%failure%failed)
        n = n + 1
        call f%step(n*f%dt)
        pieces = pieces + t%world%max_integer(f%coupler%wings(1)%report%substeps)
      end do
      call t%check('the flight succeeds',.not. f%failure%failed)
      if (.not. allocated(u)) allocate (u(3, size(f%coupler%states(1)%u, 2), 3))
      u(:, :, i) = f%coupler%states(1)%u
      call f%free()
      deallocate (f)
    end do
    errors = [norm2(u(:, :, 2) - u(:, :, 1)), norm2(u(:, :, 3) - u(:, :, 1))]/norm2(u(:, :, 1))
    print '(a,2i4,2es10.2)', 'steps and parts; errors of half the step and of parts', n, pieces, errors
    call t%check('steps are made in parts', pieces >= 4*n)
    call t%check_below('parts are closer to small steps than half the step', errors(2), 0.5_rp*errors(1))
  end subroutine parts

  !> A wing that bends beyond the limit ends the flight before the forces of this step reach the flow or the next step.
  subroutine too_far()
    real(rp), parameter :: T_END = 0.02_rp
    type(flight_t), allocatable :: f
    real(rp), allocatable :: on_flow(:, :), last(:, :)
    allocate (f)
    call prepare(f)
    call f%step(T_END)
    on_flow = f%thin%force
    last = f%thin%wings(1)%last_force
    call t%check('there are forces', any(abs(on_flow) > 0) .and. any(abs(last) > 0))
    f%coupler%params%largest_deflection = 1.0e-12_rp
    call f%step(T_END + f%dt)
    call t%check('a wing bends too far', f%failure%failed)
    call t%check('the flow has the forces of the step before', all(abs(f%thin%force - on_flow) <= 0))
    call t%check('and so has the next load', all(abs(f%thin%wings(1)%last_force - last) <= 0))
    call f%free()
  end subroutine too_far

  !> Flies to `t_end`. Returns errors of powers and energies, in parts of the work of the wing on the flow: work that the flow
  !> receives, which is less by that at the slip; kinetic energy that it gains by the forces; imbalance of the wing's own energy;
  !> imbalance of wing and flow together: the energy that the hinge gives and that neither of them receives. `force` is that on the
  !> wing at the end of the last step, from the means of the last two steps.
  subroutine fly_with_energies(f, t_end, errors, force)
    type(flight_t), intent(inout) :: f
    real(rp), intent(in) :: t_end
    real(rp), intent(out) :: errors(4), force(3)
    type(request_t) :: nothing
    real(rp) :: means(3, 2)
    real(rp) :: lost, received, gained, joule
    lost = 0
    received = 0
    gained = 0
    errors = huge(1.0_rp)
    means = 0
    f%wings%params%thin%slip_interval = 1
    do while (f%fluid%rhs%state%time < t_end - f%dt/2)
      call f%fluid%step(nothing, f%failure, f%wings)
      call f%coupler%sample_load(f%fluid, f%wings)
      gained = gained - flow_energy(f)
      call f%coupler%advance(f%fluid%dt, f%wings, f%failure, f%fluid, f%thin)
      if (f%failure%failed) return
      gained = gained + flow_energy(f)
      lost = lost + f%dt*f%wings%marker_loads(1)%power
      call f%thin%sample_slip(f%fluid)
      received = received + f%dt*f%thin%slip%received
      means = reshape([means(:, 2), f%wings%marker_loads(1)%force], [3, 2])
    end do
    force = 1.5_rp*means(:, 2) - 0.5_rp*means(:, 1)
    associate (units => f%params%units, wing => f%coupler%energies(1))
      joule = units%mass*(units%length/units%time)**2
      errors = [received - lost, gained - lost, wing%imbalance()/joule, &
                (wing%imbalance() + wing%load_work)/joule + gained]/lost
    end associate
  end subroutine fly_with_energies

  !> Returns the kinetic energy of the flow, rho L^5/T^2.
  function flow_energy(f) result(energy)
    type(flight_t), intent(in) :: f
    real(rp) :: energy
    real(rp), allocatable :: shells(:, :)
    associate (grid => f%fluid%transform%grid, sticks => f%fluid%transform%sticks)
      allocate (shells(0:count_shells(t%world, grid, sticks) - 1, 3))
      call shell_energies(t%world, grid, sticks, f%fluid%rhs%state%u, shells)
      energy = sum(shells)*grid%volume()
    end associate
  end function flow_energy

  !> Everything moved by parts of a cell: the force on the wing changes by no more than the window's error of the velocities at the
  !> markers, 1e-6, because the response of the markers depends on their distances alone.
  subroutine translation()
    type(flight_t), allocatable :: f
    real(rp) :: force(3, 2)
    integer :: i
    do i = 1, 2
      allocate (f)
      if (i == 2) f%shift = BOX/f%n*[0.3_rp, 0.5_rp, 0.7_rp]
      call prepare(f)
      call f%step(0.1_rp)
      call t%check('the flight succeeds',.not. f%failure%failed)
      force(:, i) = f%wings%marker_loads(1)%force
      call f%free()
      deallocate (f)
    end do
    print '(a,es10.2)', 'a shift by parts of a cell changes the force by', norm2(force(:, 2) - force(:, 1))/norm2(force(:, 1))
    call t%check_below('a shift by parts of a cell changes the force by the error of the window', &
                       norm2(force(:, 2) - force(:, 1)), 1.0e-6_rp*norm2(force(:, 1)))
  end subroutine translation
end program test_thin_coupling

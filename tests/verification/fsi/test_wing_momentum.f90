! SPDX-License-Identifier: GPL-3.0-or-later
!> Momentum of a moving wing: what it displaces, and what it gives to the fluid.
!>
!> Mask and displaced volumes. The mask is the sheet of thickness 2 r averaged over r, whose mean is t/2 and whose
!> variance is h^2 (1 - 8/pi^2). Displaced volumes are cubic in t, so that the average is that of t +- 2 h sqrt(1 -
!> 8/pi^2): what remains is how well a sum over grid points takes the integrals of chi. The moment of the mask has the
!> points' own places instead of the closest ones', which at a free edge are further out; `displaced` adds that.
!>
!> Fluid. With a free mean flow the box obeys V U(n+1) = V U(n) - (b10 F(n) + b11 F(n-1)) exactly, F the penalization
!> force on all wings (as in test_force_balance). The total force contains d/dt int chi u_s as well: its impulse is
!> the momentum that the fluid outside of the wing has lost, int u - chi u_s, up to the second order of the time step
!> in which the rate of change of the displaced momentum is summed.
program test_wing_momentum
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fsi_displaced, only: displaced_volumes
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_free_edges, only: find_free_edges
  use fsi_rotation, only: cross
  use support_wings, only: make_wings, NL, write_lines
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: LEFT = 2
  real(rp), parameter :: ORIGIN(3) = 0, LOW(2) = [0.05_rp, -0.2_rp], HIGH(2) = [0.75_rp, 0.1_rp] !< of the wing
  type(testkit_t) :: kit

  call kit%start(parallel=.true.)
  call write_lines(kit%world, 'wing.ini', '[Wing]'//NL//'type=rectangular'//NL//'root=0.05'//NL//'length=0.75'//NL// &
                   'mean_chord=0.3'//NL//'front=0.33333333333333333')
  call write_lines(kit%world, 'beat.ini', '[kinematics]'//NL//'type=fourier'//NL//'units=degree'//NL// &
                   'nfft_phi=1'//NL//'a0_phi=20.0'//NL//'ai_phi=55.0'//NL//'bi_phi=8.0'//NL// &
                   'nfft_alpha=2'//NL//'a0_alpha=-10.0'//NL//'ai_alpha=0.0 4.0'//NL//'bi_alpha=45.0 -6.0'//NL// &
                   'nfft_theta=1'//NL//'a0_theta=6.0'//NL//'ai_theta=3.0'//NL//'bi_theta=-9.0')
  call test_mask()
  call test_impulse()
  call test_steady_turning()
  call kit%finish()

contains

  !> One wing in a box of side 2 with n^3 points, thickness 0.16 and smoothing 0.08.
  function one_wing(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text
    character(80) :: points
    write (points, '(3(a,i0))') 'nx=', n, NL//'ny=', n, NL//'nz=', n
    text = '[Resolution]'//NL//trim(points)//NL//'[Geometry]'//NL//'xl=2'//NL//'yl=2'//NL//'zl=2'//NL// &
           '[ReynoldsNumber]'//NL//'nu=0.02'//NL//'[InitialCondition]'//NL//'inicond=quiescent'//NL// &
           '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=Insect'//NL//'eps=0.01'//NL// &
           '[Flexible_wing]'//NL//'wing_smoothing=0.08'//NL// &
           '[Insects]'//NL//'WingShape=from_file::wing.ini'//NL//'wing_edge=0.0125'//NL//'WingThickness=0.16'//NL// &
      'RightWing=no'//NL//'x0=1.03 0.61 0.97'//NL//'x_pivot_l=0.0 0.1 0.0'//NL//'yawpitchroll_0=17.0 -12.0 23.0'//NL// &
           'eta0=-70'//NL
  end function one_wing

  subroutine test_mask()
    integer, parameter :: POINTS(3) = [24, 48, 96]
    real(rp), parameter :: FROM = 0.21_rp, UPTO = 0.27_rp
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    real(rp) :: want(7), got(7), changed(7, 2), impulse(6), error(3, 3), scale(2)
    integer :: i
    do i = 1, size(POINTS)
      call make_wings(kit%world, one_wing(POINTS(i))//'FlappingMotion_left=from_file::beat.ini'//NL// &
                      '[Time]'//NL//'Tmax=1'//NL//'[MeanFlow]'//NL// &
                      'iMeanFlow=1'//NL//'ux=0'//NL//'uy=0'//NL//'uz=0'//NL, fluid, wings)
      call look(fluid, wings, FROM, changed(:, 1))
      call displaced(wings, fluid%rhs%params%solids%centre, want)
      scale = [norm2(want(2:4)), norm2(want(5:7))]
      error(i, 1) = abs(changed(1, 1)/want(1) - 1)
      error(i, 2) = norm2(changed(2:4, 1) - want(2:4))/scale(1)
      error(i, 3) = norm2(changed(5:7, 1) - want(5:7))/scale(2)
      call look(fluid, wings, UPTO, changed(:, 2))
      call displaced(wings, fluid%rhs%params%solids%centre, got)
      call kit%check_below('momentum and moment on the grid change as the smoothed sheet''s do', &
                        norm2(changed(2:7, 2) - changed(2:7, 1) - (got(2:7) - want(2:7)))/norm2(got(2:7) - want(2:7)), &
                           merge(3.0e-2_rp, 3.0e-3_rp, i == 1))
      call fluid%free()
    end do
    call make_wings(kit%world, one_wing(24)//'FlappingMotion_left=from_file::beat.ini'//NL//'[Time]'//NL//'Tmax=1', &
                    fluid, wings)
    call rate_integral(fluid, wings, FROM, UPTO, changed(2:7, 1), impulse)
    call kit%check_below('the exact rate of the displaced momentum is its derivative', &
                         norm2(changed(2:4, 1) - impulse(1:3)), 1.0e-7_rp*norm2(impulse(1:3)))
    call kit%check_below('as that of the moment', norm2(changed(5:7, 1) - impulse(4:6)), 1.0e-7_rp*norm2(impulse(4:6)))
    call fluid%free()
    ! chi has continuous slopes: third order or better, see test_wing_mask.
    call kit%check_below('volume on 24^3 points', error(1, 1), 2.0e-3_rp)
    call kit%check_below('volume on 96^3 points', error(3, 1), 2.0e-3_rp/64)
    call kit%check_below('momentum on 24^3 points', error(1, 2), 4.0e-3_rp)
    call kit%check_below('momentum on 96^3 points', error(3, 2), 4.0e-3_rp/64)
    call kit%check_below('moment on 24^3 points', error(1, 3), 6.0e-3_rp)
    ! The points weigh the moment, which is quadratic, to (edge/chord)^2.
    call kit%check_below('moment on 96^3 points', error(3, 3), 3.0e-4_rp)
  end subroutine test_mask

  !> Volume, momentum and moment of the wing in the mask at `time`.
  subroutine look(fluid, wings, time, sums)
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(inout) :: wings
    real(rp), intent(in) :: time
    real(rp), intent(out) :: sums(7)
    type(request_t) :: nothing
    type(failure_t) :: failure
    fluid%rhs%state%time = time
    call fluid%evaluate(nothing, failure, wings)
    if (failure%failed) error stop 'the wings cannot be placed'
    sums = [fluid%sums%solid_volume(LEFT), fluid%sums%solid_momentum(:, LEFT), fluid%sums%solid_moment(:, LEFT)]
  end subroutine look

  !> The same of the smoothed sheet, from displaced volumes; with what the edges add to the moment.
  subroutine displaced(wings, centre, sums)
    type(flapping_wings_t), intent(in) :: wings
    real(rp), intent(in) :: centre(3)
    real(rp), intent(out) :: sums(7)
    real(rp), allocatable :: volumes(:)
    integer, allocatable :: edges(:, :)
    real(rp) :: t(2), outward(3), edge(3), normal(3), bisector(3), corner(3), shift
    integer :: i, k
    associate (surface => wings%surfaces(1), params => wings%params)
      shift = 2*params%smoothing*sqrt(1 - 8/PI**2)
      t = 2*params%half_thickness + [shift, -shift]
      sums = 0
      call find_free_edges(size(surface%points, 2), surface%triangles, edges)
      normal = wings%poses(1)%vector_to_space([0.0_rp, 0.0_rp, 1.0_rp])
      do k = 1, 2
        call displaced_volumes(surface%points, surface%triangles, t(k), volumes)
        do i = 1, size(volumes)
          associate (x => surface%points(:, i), u => surface%velocities(:, i))
            sums = sums + volumes(i)/2*[1.0_rp, u, cross(x - centre, u)]
          end associate
        end do
        ! int d over half a disk is 2/3 r^3 outward, over a quarter of a ball pi/4 r^4 sin(45 degrees).
        do i = 1, size(edges, 2)
          edge = surface%points(:, edges(2, i)) - surface%points(:, edges(1, i))
          outward = cross(edge, normal)
          sums(5:7) = sums(5:7) + t(k)**3/24*cross(outward, (surface%velocities(:, edges(1, i)) + &
                                                             surface%velocities(:, edges(2, i)))/2)
        end do
        do i = 0, 3
          bisector = [2*mod(i, 2) - 1, 2*(i/2) - 1, 0]*0.5_rp
          corner = [merge(HIGH(1), LOW(1), bisector(1) > 0), merge(HIGH(2), LOW(2), bisector(2) > 0), 0.0_rp]
          sums(5:7) = sums(5:7) + PI/4*(t(k)/2)**4/2*cross(wings%poses(1)%vector_to_space(bisector), &
                                                           wings%poses(1)%velocity_at(corner))
        end do
      end do
    end associate
  end subroutine displaced

  !> int (d/dt int chi u_s, d/dt int chi r x u_s) dt by Simpson's rule with twenty intervals, and what `change` it
  !> should be by sums over the points.
  subroutine rate_integral(fluid, wings, from, upto, change, impulse)
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(inout) :: wings
    real(rp), intent(in) :: from, upto
    real(rp), intent(out) :: change(6), impulse(6)
    real(rp), parameter :: WEIGHTS(0:2) = [2.0_rp, 4.0_rp, 1.0_rp]
    real(rp) :: sums(7)
    integer :: i
    impulse = 0
    change = 0
    do i = 0, 20
      call look(fluid, wings, from + (upto - from)*i/20, sums)
      impulse = impulse + merge(WEIGHTS(2), WEIGHTS(mod(i, 2)), mod(i, 20) == 0)*(upto - from)/60* &
                [fluid%unsteady_force(:, LEFT), fluid%unsteady_moment(:, LEFT)]
      if (mod(i, 20) == 0) change = change + merge(-1, 1, i == 0)*points_of(wings, fluid%rhs%params%solids%centre)
    end do
  end subroutine rate_integral

  !> The box loses what the penalization takes, exactly; the total force is what the fluid outside has lost.
  subroutine test_impulse()
    real(rp), parameter :: STEPS(2) = [2.0e-3_rp, 1.0e-3_rp]
    real(rp) :: error(2), exact
    integer :: i
    do i = 1, 2
      call impulse_error('FlappingMotion_left=from_file::beat.ini', 'AB2', STEPS(i), 0.2_rp, exact, error(i))
      call kit%check_below('a flapping wing: the box loses the penalization force, per step', exact, 1.0e-15_rp)
    end do
    call kit%check_below('the total force is what the fluid outside has lost', error(1), 2.0e-4_rp)
    call kit%check_order('to second order of the time step', STEPS, error, 2.0_rp, 0.3_rp)
  end subroutine test_impulse

  !> A plate that turns uniformly about a hinge at rest, phi(t) = 360 t degrees, by a table: the unsteady force is
  !> the centripetal one.
  subroutine test_steady_turning()
    real(rp) :: error(2), exact
    integer :: i
    real(rp), parameter :: STEPS(2) = [2.0e-3_rp, 1.0e-3_rp]
    call write_lines(kit%world, 'turning.dat', '1.0'//NL//'1.0'//NL//'2'//NL//'0.0 0.0 60.0 0.0 0.0 0.0 0.0 360.0 '// &
                     '0.0 0.0 0.0 0.0 0.0'//NL//'1.0 360.0 60.0 0.0 0.0 0.0 0.0 360.0 0.0 0.0 0.0 0.0 0.0')
    do i = 1, 2
      call impulse_error('FlappingMotion_left=kinematics_loader::turning.dat', 'AB2', STEPS(i), 0.2_rp, exact, error(i))
      call kit%check_below('a turning plate: the box loses the penalization force, per step', exact, 1.0e-15_rp)
    end do
    call kit%check_below('the total force is what the fluid outside has lost', error(1), 2.0e-4_rp)
    call kit%check_order('to second order of the time step', STEPS, error, 2.0_rp, 0.3_rp)
  end subroutine test_steady_turning

  !> Runs one wing in fluid at rest with a free mean flow. `exact` is the worst error of the mean velocity per step,
  !> `error` that of the impulse of the total force relative to it.
  subroutine impulse_error(motion, scheme, dt, t_end, exact, error)
    character(*), intent(in) :: motion, scheme
    real(rp), intent(in) :: dt, t_end
    real(rp), intent(out) :: exact, error
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(request_t) :: nothing
    type(failure_t) :: failure
    character(60) :: step
    real(rp) :: volume, expected(3), mean(3), force(3), old(3), total(3), begun(6), change(6), sums(3), weights(2)
    integer :: n
    write (step, '(a,es12.4,a,es12.4)') 'dt_fixed=', dt, NL//'Tmax=', t_end
    call make_wings(kit%world, one_wing(24)//motion//NL//'[Time]'//NL//'iTimeMethodFluid='//scheme//NL//step//NL// &
                    '[MeanFlow]'//NL//'iMeanFlow_x=free'//NL//'iMeanFlow_y=free'//NL//'iMeanFlow_z=free'//NL, fluid, &
                    wings)
    volume = product(fluid%rhs%params%grid%length)
    exact = 0
    total = 0
    begun = points_of(wings, ORIGIN)
    do n = 1, nint(t_end/dt)
      old = force
      call fluid%step(nothing, failure, wings)
      if (n > 1) exact = max(exact, maxval(abs(fluid%sums%mean - mean - expected)))
      force = sum(fluid%sums%force, 2)
      weights = merge([dt, 0.0_rp], [1.5_rp*dt, -0.5_rp*dt], n == 1)
      expected = -weights(1)*force/volume
      if (n > 1) expected = expected - weights(2)*old/volume
      mean = fluid%sums%mean
      ! Trapezoidal rule of the unsteady part.
      total = total - volume*expected + merge(dt/2, dt, n == 1)*sum(fluid%unsteady_force, 2)
    end do
    call fluid%evaluate(nothing, failure, wings)
    total = total + dt/2*sum(fluid%unsteady_force, 2)
    change = points_of(wings, ORIGIN) - begun
    sums = change(1:3) - volume*fluid%sums%mean
    error = norm2(total - sums)/norm2(sums)
    call fluid%free()
  end subroutine impulse_error

  !> int chi u_s and int chi r x u_s of the sharp sheet.
  function points_of(wings, centre) result(sums)
    type(flapping_wings_t), intent(in) :: wings
    real(rp), intent(in) :: centre(3)
    real(rp) :: sums(6)
    real(rp), allocatable :: volumes(:)
    integer :: i
    associate (wing => wings%params%wings(1), surface => wings%surfaces(1))
      call displaced_volumes(wing%points, wing%triangles, 2*wings%params%half_thickness, volumes)
      sums = 0
      do i = 1, size(volumes)
     sums = sums + volumes(i)*[surface%velocities(:, i), cross(surface%points(:, i) - centre, surface%velocities(:, i))]
      end do
    end associate
  end function points_of
end program test_wing_momentum

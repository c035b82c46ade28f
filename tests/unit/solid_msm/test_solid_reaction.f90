! SPDX-License-Identifier: GPL-3.0-or-later
!> A load that answers the velocity of a wing in Newton's method: its tangent against differences of its force, the
!> linear solution against a dense one, with what earlier solutions have left too, and how a step converges.
program test_solid_reaction
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_lapack, only: solve_least_squares
  use marker_reaction, only: layer_kernel, marker_reaction_t, place_markers
  use sample_wings, only: make_fly_wing
  use solid_dynamic_solve, only: dynamic_solver_t
  use solid_dynamics, only: dynamics_t, dynamic_options_t, dynamic_state_t, step_report_t
  use solid_extension, only: extension_axial
  use solid_inertia, only: inertia_t, gyroscopic_turn
  use solid_model, only: solid_model_t
  use solid_motion, only: frame_t, steady_motion_t
  use solid_params, only: solid_params_t, default_params
  use solid_vectors, only: cross, skew
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: MARKERS = 30
  real(rp), parameter :: DT = 1.0e-5_rp, Q = 1.5_rp/DT
  type(testkit_t) :: t
  type(solid_model_t) :: model
  type(inertia_t) :: inertia
  type(marker_reaction_t) :: reaction
  real(rp), allocatable :: u(:, :), v(:, :), x(:, :)

  call t%start(parallel=.false.)
  call make_all()
  call compare_differences()
  call compare_dense()
  call converge()
  call count_work()
  call t%finish()

contains

  !> A wing of 2.5 ug, bent, with markers whose medium has a tenth of a gram in a litre, 100 times as much as the wing.
  subroutine make_all()
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(failure_t) :: failure
    real(rp), allocatable :: weights(:, :), places(:, :)
    integer, allocatable :: nodes(:, :)
    integer :: i
    wing = make_fly_wing(24, 12)
    params = default_params(wing)
    params%cross_springs = .true.
    call model%init(wing, params, failure)
    call t%check('a wing is built',.not. failure%failed)
    call inertia%init(model, spread(2.5e-9_rp/model%n_points, 1, model%n_points))
    call place_markers(model, MARKERS, nodes, weights, places)
    call reaction%init(model, nodes, weights, layer_kernel(places, 7.0e-4_rp, 3.0_rp), DT)
    allocate (u(3, model%n_all), v(3, model%n_all), x(3, model%n_all), source=0.0_rp)
    do i = 1, model%n_all
      u(3, i) = 5*model%points(1, i)**2
      v(:, i) = sin(700*model%points(1, i) + [0.0_rp, 1.0_rp, 2.0_rp])
      x(:, i) = cos(900*model%points(2, i) + [0.0_rp, 1.0_rp, 2.0_rp])
    end do
    call model%zero_clamped(u)
    call model%zero_clamped(v)
    call model%zero_clamped(x)
  end subroutine make_all

  !> The force is linear in u and v: central differences have round-off only. In a turning frame the tangent is that of the
  !> velocity in space, to which the frame adds omega x u.
  subroutine compare_differences()
    real(rp), parameter :: STEP = 1.0e-4_rp, OMEGA(3) = [300.0_rp, 0.0_rp, 1000.0_rp]
    type(frame_t) :: frame
    real(rp), dimension(3, model%n_all) :: plus, minus, y, z
    y = 0
    z = 0
    call reaction%begin_step(frame, 0*u, v)
    call reaction%tangent(x, y)
    call reaction%tangent(v, z)
    call t%check_close('C is symmetric', sum(v*y), sum(x*z), rtol=1.0e-12_rp)
    call t%check('and positive', sum(x*y) > 0 .and. sum(v*z) > 0)
    call reaction%force(frame, u + STEP*x, v + Q*STEP*x, plus)
    call reaction%force(frame, u - STEP*x, v - Q*STEP*x, minus)
    z = (minus - plus)/(2*STEP)
    call t%check_below('the tangent is -df/dv', maxval(abs(z - Q*y))/maxval(abs(Q*y)), 1.0e-12_rp)
    frame%omega = OMEGA
    call reaction%force(frame, u + STEP*x, v + Q*STEP*x, plus)
    call reaction%force(frame, u - STEP*x, v - Q*STEP*x, minus)
    z = (minus - plus)/(2*STEP)
    y = 0
    call reaction%tangent(in_space(x, frame, Q), y)
    call t%check_below('in a turning frame, too', maxval(abs(z - y))/maxval(abs(y)), 1.0e-12_rp)
  end subroutine compare_differences

  !> Returns the velocities in space that displacements x(3, :) at the rate q cause in a frame that turns.
  pure function in_space(x, frame, q) result(w)
    real(rp), intent(in) :: x(:, :), q
    type(frame_t), intent(in) :: frame
    real(rp) :: w(3, size(x, 2))
    integer :: i
    do i = 1, size(x, 2)
      w(:, i) = q*x(:, i) + cross(frame%omega, x(:, i))
    end do
  end function in_space

  !> Three solutions with one matrix and one with another, where the directions of the first three are no good.
  subroutine compare_dense()
    real(rp), parameter :: ENOUGH = 1.0e-12_rp
    type(dynamic_solver_t) :: solver
    type(frame_t) :: frame
    real(rp) :: dense(3*model%n_free, 3*model%n_free), r(3, model%n_all), answer(3, model%n_all), rate
    integer :: k, n(4)
    logical :: is_spd, is_solved
    frame%omega = [300.0_rp, 0.0_rp, 1000.0_rp]
    frame%alpha = [0.0_rp, 1.0e5_rp, 0.0_rp]
    call solver%init(model)
    call extension_axial(model%springs, model%stiffness%extension, u, solver%equilibrium%axial)
    n = 0
    rate = Q
    do k = 1, 4
      if (k == 4) rate = 0.7_rp*Q
      if (k == 1 .or. k == 4) then
        call solver%start(model, inertia, frame, rate)
        call solver%assemble(model, inertia, u, .false.)
        call make_dense(solver, frame, rate, dense)
      end if
      if (k == 1) call solver%factorise(model, inertia, u, is_spd, reaction)
      r = x
      if (k == 3) r = 0.3_rp*x + v
      solver%n_inner = 0
      call solver%solve_reaction(model, r, ENOUGH, reaction, is_solved)
      n(k) = solver%n_inner
      call t%check('the equations are solved', is_spd .and. is_solved)
      call t%check_below('up to what is asked for', residual(dense, solver%x, r), 1.0e-9_rp)
      answer = 0
      call reaction%tangent(in_space(solver%x, frame, rate), answer)
      call model%zero_clamped(answer)
      call t%check_below('the answer of the reaction is known', norm2(solver%answer - answer), 1.0e-11_rp*norm2(answer))
      call t%check_below('as by a dense solver', difference(dense, solver%x, r), 1.0e-9_rp)
    end do
    print '(a,4i4)', 'iterations', n
    call t%check('the same again takes no iterations', n(1) > 3 .and. n(2) == 0)
    call t%check('another right-hand side some', n(3) > 0 .and. n(3) < n(1) + 3)
    call t%check('another matrix needs all of them', n(4) > n(3))
    call solver%free()
  end subroutine compare_dense

  !> S + N + C (q + omega x), column by column.
  subroutine make_dense(solver, frame, rate, dense)
    type(dynamic_solver_t), intent(in) :: solver
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: rate
    real(rp), intent(out) :: dense(:, :)
    real(rp), dimension(3, model%n_all) :: e, y
    integer :: i, j, k, c
    dense = 0
    do j = 1, model%n_free
      do k = model%pattern%start(j), model%pattern%start(j + 1) - 1
        i = model%pattern%rows(k)
        dense(3*i - 2:3*i, 3*j - 2:3*j) = solver%equilibrium%blocks(:, :, k)
        dense(3*j - 2:3*j, 3*i - 2:3*i) = transpose(solver%equilibrium%blocks(:, :, k))
      end do
    end do
    do j = 1, model%n_free
      associate (own => dense(3*j - 2:3*j, 3*j - 2:3*j))
        own = own + skew(gyroscopic_turn(inertia, frame, rate, model%movable(j)))
      end associate
      do c = 1, 3
        e = 0
        y = 0
        e(c, model%movable(j)) = 1
        e = in_space(e, frame, rate)
        call reaction%tangent(e, y)
        dense(:, 3*j - 3 + c) = dense(:, 3*j - 3 + c) + reshape(y(:, model%movable), [3*model%n_free])
      end do
    end do
  end subroutine make_dense

  !> |A y + r|/|r|.
  real(rp) function residual(dense, y, r)
    real(rp), intent(in) :: dense(:, :), y(:, :), r(:, :)
    residual = norm2(matmul(dense, reshape(y(:, model%movable), [3*model%n_free])) + &
                     reshape(r(:, model%movable), [3*model%n_free]))/norm2(r(:, model%movable))
  end function residual

  !> How far y is from -A^-1 r, over its size.
  real(rp) function difference(dense, y, r)
    real(rp), intent(in) :: dense(:, :), y(:, :), r(:, :)
    real(rp) :: a(3*model%n_free, 3*model%n_free), b(3*model%n_free), z(3*model%n_free)
    logical :: ok
    a = dense
    b = -reshape(r(:, model%movable), [3*model%n_free])
    call solve_least_squares(a, b, z, ok)
    difference = norm2(reshape(y(:, model%movable), [3*model%n_free]) - z)/norm2(z)
    if (.not. ok) difference = huge(difference)
  end function difference

  !> Where the wing moves so little that its equations are linear, Newton's method leaves of a residual what the linear solution
  !> leaves, 3e-3 or less, down to rounding.
  subroutine converge()
    real(rp), parameter :: LINEAR = 3.0e-3_rp
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: rest
    real(rp) :: force(3, model%n_all)
    real(rp) :: residuals(0:15, 5), rounding
    integer :: i, k, n(5), loads
    logical :: fine
    call stepper%init(model)
    call state%init(model, 0.0_rp)
    force = 0
    force(3, :model%n_points) = 1.0e-9_rp/model%n_points
    fine = .true.
    rounding = 0 ! the largest residual with which a step ends
    loads = 0
    reaction%calls = 0
    do i = 1, 5
      call reaction%begin_step(rest%frame, state%u, state%v)
      call stepper%step(model, inertia, rest, force, DT, options, state, report, reaction=reaction)
      fine = fine .and. report%converged .and. report%substeps == 1
      print '(20es9.1)', report%residuals(:report%iterations)
      n(i) = report%iterations
      loads = loads - report%inner
      residuals(:, i) = report%residuals(0:15)
      rounding = max(rounding, report%residuals(n(i)))
    end do
    do i = 1, 5
      do k = 1, n(i) - 1
        fine = fine .and. residuals(k, i) <= 1.1_rp*LINEAR*residuals(k - 1, i) + 2*rounding
      end do
    end do
    loads = loads + reaction%calls
    call t%check('a step computes the load at its beginning and at its end', loads == 2*5 .and. minval(n) > 1)
    call t%check_below('down to rounding', rounding, 1.0e-4_rp*minval(residuals(0, :)))
    call t%check('in the linear range an iteration leaves what its linear equations leave', fine)
    call stepper%free()
  end subroutine converge

  !> A sudden spin throws the extrapolated shape far off in the first steps, later steps are smooth.
  subroutine count_work()
    integer, parameter :: STEPS = 12
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: spin
    real(rp) :: force(3, model%n_all)
    integer :: i, n(4, STEPS)
    logical :: fine
    spin%frame%omega = [0.0_rp, 300.0_rp, 1000.0_rp]
    call stepper%init(model)
    call state%init(model, 0.0_rp)
    force = 0
    force(3, :model%n_points) = 2.0e-3_rp/model%n_points
    fine = .true.
    do i = 1, STEPS
      call reaction%begin_step(spin%frame, state%u, state%v)
      call stepper%step(model, inertia, spin, force, DT, options, state, report, reaction=reaction)
      fine = fine .and. report%converged
      n(:, i) = [report%iterations, report%factorisations, report%inner, report%substeps]
    end do
    print '(a,/,(4i5))', 'iterations, factorisations, solutions, substeps', n
    call t%check('steps of a wing that bends much are solved', fine .and. all(n(4, :) == 1))
    ! 24 factorisations; one for each tangent would be 32.
    call t%check('factors serve several tangents', sum(n(2, :)) <= 28)
    ! 228 solutions and at most 9 iterations; 283 and 11 if the first tangents served on, far from the solution.
    call t%check('tangents are new where the shape is far off', sum(n(3, :3)) <= 255 .and. maxval(n(1, :)) <= 10)
    call stepper%free()
  end subroutine count_work
end program test_solid_reaction

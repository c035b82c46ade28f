! SPDX-License-Identifier: GPL-3.0-or-later
!> The load of the flow on a wing without thickness in a time step that Newton's method makes in parts. The wing feels the impulse
!> that the flow receives, the flow follows the wing at the end of the step, and where wing and flow accelerate evenly, parts change
!> nothing. In every step the momentum of a free wing changes by this impulse.
program test_flow_reaction
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fsi_green, only: green_t
  use fsi_markers, only: markers_t
  use io_units, only: unit_scales_t
  use sample_wings, only: make_beam, make_fly_wing
  use solid_dynamics, only: copy_state, dynamic_options_t, dynamic_state_t, dynamics_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, solid_params_t
  use solid_wing, only: wing_t
  use stubborn_reaction, only: speeding_motion_t, stubborn_reaction_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: METRE = 6.0e-3_rp, PERIOD = 1/158.0_rp !< [m] of L, [s] of T
  real(rp), parameter :: SPEED = METRE/PERIOD                   !< [m/s] of L/T
  real(rp), parameter :: DX = 0.125_rp, K = 2*acos(-1.0_rp)/(3*DX)
  type(unit_scales_t), parameter :: UNITS = unit_scales_t(length=METRE, time=PERIOD, mass=1.2_rp*METRE**3)
  real(rp), parameter :: NEWTON = 1.2_rp*METRE**4/PERIOD**2     !< [N] of rho L^4/T^2
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call evenly()
  call bending()
  call momentum()
  call t%finish()

contains

  !> A fly's wing with its markers, clamped, or free beside a rod that is clamped in its place.
  subroutine make_all(is_free, model, inertia, markers, reaction)
    logical, intent(in) :: is_free
    type(solid_model_t), intent(out) :: model
    type(inertia_t), intent(out) :: inertia
    type(markers_t), intent(out) :: markers
    type(stubborn_reaction_t), intent(out) :: reaction
    real(rp), parameter :: MASS = 250.0e-9_rp ! [kg]
    type(wing_t) :: wing, rod
    type(solid_params_t) :: params
    type(failure_t) :: failure
    type(green_t) :: green
    real(rp), allocatable :: masses(:), x(:, :)
    logical :: has_factor
    integer :: n
    wing = make_fly_wing(24, 12)
    n = size(wing%points, 2)
    allocate (masses(n), source=MASS/n)
    if (is_free) then
      rod = make_beam(1, 1.0e-3_rp, 5.0e-5_rp, [1.0_rp, 0.0_rp, 0.0_rp])
      wing%points = reshape([wing%points, rod%points - 0.01_rp], [3, n + 2])
      wing%points(3, n + 1:) = 0
      rod%veins(1)%nodes = [n + 1, n + 2]
      wing%veins = [wing%veins, rod%veins]
      wing%root = [n + 1, n + 2]
      masses = [masses, 0.0_rp, 0.0_rp]
    end if
    params = default_params(wing)
    params%cross_springs = .true.
    call model%init(wing, params, failure)
    call inertia%init(model, masses)
    call markers%init(wing%points/METRE, wing%triangles, 2*DX, .false.)
    allocate (x(3, markers%n))
    call markers%positions(wing%points/METRE, x)
    call green%init(K, 3.0_rp, .false.)
    call reaction%response%init(markers%n, .false.)
    call reaction%response%build(green, x, has_factor)
    call reaction%init(markers, model%points, UNITS)
    call reaction%update_response()
    call t%check('a wing with markers is built',.not. failure%failed .and. has_factor)
  end subroutine make_all

  !> A free wing all of whose points gain speed evenly in a frame that does so, too, in a flow that would, by itself, gain speed
  !> evenly at each marker, under the forces on the points that this takes. That is an exact solution of BDF2 for any division of
  !> steps, with forces that do not change.
  subroutine evenly()
    integer, parameter :: PARTS(5) = [1, 2, 1, 4, 2]
    real(rp), parameter :: DT = 2.0e-5_rp, GAIN(3) = [300.0_rp, -200.0_rp, 500.0_rp] ! [s], [m/s^2]
    type(speeding_motion_t), parameter :: MOTION = speeding_motion_t(velocity=[0.3_rp, -0.5_rp, 0.2_rp], &
                                                                     acceleration=[-150.0_rp, 250.0_rp, 400.0_rp])
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(markers_t) :: markers
    type(stubborn_reaction_t) :: reaction
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    real(rp), allocatable :: force(:, :), flow_gain(:, :), exact(:, :), speeds(:, :), last(:, :)
    real(rp) :: off(3)
    integer :: i, m, p
    call make_all(.true., model, inertia, markers, reaction)
    allocate (force(3, model%n_all), flow_gain(3, markers%n), exact(3, markers%n), speeds(3, markers%n), source=0.0_rp)
    do m = 1, markers%n
      flow_gain(:, m) = 400*[sin(1.0_rp*m), cos(0.3_rp*m), sin(0.7_rp*m) - 1]
      exact(:, m) = (GAIN + MOTION%acceleration - flow_gain(:, m))/(SPEED/PERIOD)
    end do
    speeds = exact
    call reaction%response%solve(speeds, exact)
    allocate (last, source=exact)
    call markers%spread(exact, force)
    force = NEWTON*force
    do p = 1, model%n_points
      force(:, p) = force(:, p) + inertia%mass(p)*(GAIN + MOTION%acceleration)
    end do
    options%tolerance = 1.0e-12_rp
    call stepper%init(model)
    call state%init(model, 0.0_rp)
    off = 0
    do i = 1, size(PARTS)
      reaction%least = PARTS(i)
      do m = 1, markers%n
        speeds(:, m) = (MOTION%velocity + (i - 1)*DT*(GAIN + MOTION%acceleration) + DT*flow_gain(:, m))/SPEED
      end do
      if (i > 1) last = reaction%last
      call reaction%begin(speeds, last, DT/PERIOD)
      call stepper%step(model, inertia, MOTION, force, DT, options, state, report, reaction=reaction)
      call t%check('a step in as many parts as it must', report%converged .and. report%substeps == PARTS(i))
      do p = 1, model%n_points
        if (inertia%mass(p) > 0) off(1) = max(off(1), norm2(state%v(:, p) - i*DT*GAIN)/norm2(i*DT*GAIN))
      end do
      off(2) = max(off(2), norm2(reaction%on_flow - exact)/norm2(exact))
      off(3) = max(off(3), impulse_error(markers, reaction))
    end do
    print '(a,3es10.2)', 'even: velocities, force on the flow, impulse', off
    ! Newton's method leaves 1e-12 of the forces, and stiff springs of displacements that are a hundredth of the wing another 1e-14.
    call t%check_below('the wing moves as without parts', off(1), 1.0e-9_rp)
    call t%check_below('the flow receives the same forces', off(2), 1.0e-9_rp)
    call t%check_below('whose impulse the wing feels', off(3), 1.0e-12_rp)
    call stepper%free()
  end subroutine evenly

  !> A clamped wing that bends under a sudden force, in a flow that comes toward it: one step in several divisions, each of them
  !> twice, as the strong coupling makes it.
  subroutine bending()
    real(rp), parameter :: DT = 5.0e-5_rp
    integer, parameter :: LEAST(4) = [1, 2, 2, 4], PIECES(4) = [1, 2, 3, 4]
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(markers_t) :: markers
    type(stubborn_reaction_t) :: reaction
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: begun, state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(speeding_motion_t) :: motion
    real(rp), allocatable :: force(:, :), flow(:, :), wanted(:, :), on_flow(:, :, :), nothing(:, :)
    integer :: i, repetition
    call make_all(.false., model, inertia, markers, reaction)
    allocate (force(3, model%n_all), flow(3, markers%n), wanted(3, markers%n), on_flow(3, markers%n, 4), &
              nothing(3, markers%n), source=0.0_rp)
    motion%acceleration = [0.0_rp, 100.0_rp, -400.0_rp]
    force(3, :model%n_points) = 1.0e-4_rp/model%n_points
    flow(3, :) = -0.02_rp
    call stepper%init(model)
    call begun%init(model, 0.0_rp)
    call state%init(model, 0.0_rp)
    do i = 1, size(LEAST)
      reaction%least = LEAST(i)
      reaction%splits_later = PIECES(i) == 3
      do repetition = 1, 2
        call copy_state(begun, state)
        call reaction%begin(flow, nothing, DT/PERIOD)
        call stepper%step(model, inertia, motion, force, DT, options, state, report, reaction=reaction)
        if (repetition == 1) on_flow(:, :, i) = reaction%on_flow
      end do
      call t%check('a step in as many parts as it must', report%converged .and. report%substeps == PIECES(i))
      call t%check('which the repetition begins anew',.not. any(abs(reaction%on_flow - on_flow(:, :, i)) > 0))
      call t%check_below('the wing feels the impulse that the flow receives', impulse_error(markers, reaction), 1.0e-12_rp)
      call markers%positions(state%v/SPEED, wanted)
      wanted = (wanted + spread(DT*motion%acceleration/SPEED, 2, markers%n) - flow)/(DT/PERIOD)
      call reaction%response%solve(wanted, flow)
      ! The condition of the response is some hundreds.
      call t%check_below('the flow follows the wing', norm2(reaction%on_flow - flow)/norm2(flow), 1.0e-11_rp)
      flow = 0
      flow(3, :) = -0.02_rp
    end do
    print '(a,4es10.2)', 'bending: forces on the flow differ by', &
      (norm2(on_flow(:, :, i) - on_flow(:, :, 1))/norm2(on_flow(:, :, 1)), i=1, 4)
    call stepper%free()
  end subroutine bending

  !> A free wing in a flow that pulls each marker in another direction, more and more: it bends while it moves. Springs give it no
  !> momentum, so that masses times velocities change by the impulse that the flow loses, in steps of any length and division.
  subroutine momentum()
    integer, parameter :: PARTS(7) = [1, 1, 2, 1, 4, 2, 1]
    real(rp), parameter :: STEPS(7) = 1.0e-5_rp*[1.0_rp, 1.0_rp, 2.0_rp, 1.5_rp, 1.0_rp, 2.0_rp, 3.0_rp] ! [s]
    type(speeding_motion_t) :: still
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(markers_t) :: markers
    type(stubborn_reaction_t) :: reaction
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    real(rp), allocatable :: force(:, :), flow(:, :), last(:, :)
    real(rp) :: before(3), after(3), impulse(3), off
    integer :: i, m
    call make_all(.true., model, inertia, markers, reaction)
    allocate (force(3, model%n_all), flow(3, markers%n), last(3, markers%n), source=0.0_rp)
    options%tolerance = 1.0e-12_rp
    call stepper%init(model)
    call state%init(model, 0.0_rp)
    off = 0
    before = 0
    do i = 1, size(STEPS)
      reaction%least = PARTS(i)
      do m = 1, markers%n
        flow(:, m) = 0.01_rp*i**2*[sin(1.0_rp*m) + 1, cos(0.3_rp*m), sin(0.7_rp*m) - 1]
      end do
      call reaction%begin(flow, last, STEPS(i)/PERIOD)
      call stepper%step(model, inertia, still, force, STEPS(i), options, state, report, reaction=reaction)
      call t%check('a step in as many parts as it must', report%converged .and. report%substeps == PARTS(i))
      last = reaction%last
      after = matmul(state%v, inertia%mass)
      impulse = -NEWTON*STEPS(i)*sum(reaction%on_flow, 2)
      off = max(off, norm2(after - before - impulse)/norm2(impulse))
      before = after
    end do
    print '(a,es10.2)', 'momentum of the wing against the impulse of the flow', off
    ! Newton's method leaves 1e-12 of the forces, of which those of springs are by far the largest.
    call t%check_below('the wing gets the momentum that the flow loses', off, 1.0e-9_rp)
    call stepper%free()
  end subroutine momentum

  !> Difference of the mean load that the wing has felt in a step from that of the forces on the flow, over the size of the load.
  real(rp) function impulse_error(markers, reaction) result(error)
    type(markers_t), intent(in) :: markers
    type(stubborn_reaction_t), intent(in) :: reaction
    real(rp) :: load(3, size(reaction%felt, 2))
    load = 0
    call markers%spread(reaction%on_flow, load)
    error = norm2(reaction%felt + NEWTON*load)/(NEWTON*norm2(load))
  end function impulse_error
end program test_flow_reaction

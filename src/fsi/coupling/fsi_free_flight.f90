! SPDX-License-Identifier: GPL-3.0-or-later
!> Advances an insect that flies freely, before and after the step of the flow.
!>
!> The flow makes its step from t(n) to t(n+1) with the insect at t(n). Then
!>
!>     launch    position and attitude of t(n+1), and its momenta by the forces of t(n) and t(n-1), with the flow's weights
!>     (wings)   flexible wings make their step in the frame of t(n+1) with the accelerations known so far; wings
!>               without thickness find the forces of this step
!>     settle    the impulse of those forces, and the velocities for the wings at t(n+1).
!>
!> Markers sample the flow with velocities that assume the forces of the last step. The error is (change of force) dt/m, which is of
!> the order of the ratio of the added mass of the wings to the mass of the insect.
module fsi_free_flight
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fluid_penalty, only: COLOR_BODY
  use fluid_solver, only: fluid_t
  use fsi_body_motion, only: MOTION_FREE
  use fsi_body_volume, only: displaced_moments
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flyer, only: DAMPED, least_fraction, SMALLEST_FRACTION
  use fsi_kinematics, only: pose_wing, wing_pose_t
  use fsi_moments, only: second_of_inertia, whole_t
  use fsi_quaternion, only: attitude_of
  use parallel_world, only: world_t
  implicit none
  private
  public :: prepare_flight, begin_flight, launch, settle

contains

  !> Makes `wings`, whose masses are known, the wings of a flyer at its start.
  subroutine prepare_flight(wings)
    type(flapping_wings_t), intent(inout) :: wings
    real(rp) :: inertia(3, 3)
    integer :: i
    allocate (wings%flyer)
    associate (flyer => wings%flyer)
      flyer%params = wings%params%flyer
      flyer%state%centre = wings%params%body%centre
      flyer%state%velocity = wings%params%motion%velocity
      flyer%state%attitude = attitude_of(wings%params%body%angles(1), wings%params%body%angles(2), &
                                         wings%params%body%angles(3))
      flyer%body%mass = flyer%params%mass
      do i = 1, size(wings%params%wings)
        if (allocated(wings%deformation)) then
          flyer%body%mass = flyer%body%mass - sum(wings%masses)
        else
          flyer%body%mass = flyer%body%mass - wings%params%wings(i)%moments%mass
        end if
      end do
      inertia = 0
      do i = 1, 3
        inertia(i, i) = flyer%params%inertia(i)
      end do
      flyer%body%second = second_of_inertia(inertia)
      flyer%carried = wings%motion
      flyer%carried%kind = MOTION_FREE
    end associate
  end subroutine prepare_flight

  !> Prepares a flyer after its first placing. If it was not restored, the procedure computes the fluid that it displaces and its
  !> initial momenta. Limits the step of the fluid. Fails if the body is too light. Does nothing after a failure. Collective.
  subroutine begin_flight(world, wings, fluid, failure, coupler)
    type(world_t), intent(in) :: world
    type(flapping_wings_t), intent(inout) :: wings
    type(fluid_t), intent(inout) :: fluid
    type(failure_t), intent(inout) :: failure
    type(coupler_t), intent(inout), optional :: coupler !< of flexible wings
    type(whole_t) :: rest
    real(rp) :: time
    integer, parameter :: N_SAMPLES = 32 !< in one beat
    integer :: i
    if (failure%failed) return
    associate (flyer => wings%flyer, grid => fluid%rhs%params%grid, state => fluid%rhs%state)
      if (.not. flyer%is_restored) then
        if (.not. flyer%params%carries_fluid) &
          flyer%displaced = displaced_moments(world, grid, fluid%transform%block, fluid%rhs%penalty, COLOR_BODY, &
                                              wings%body%centre, wings%body%rotation%matrix)
        call flyer%state%start(wings%whole(state%time))
        call wings%motion%show(state%time, flyer%state%body())
        call flyer%carried%show(state%time, flyer%state%body())
        rest = wings%whole(state%time)
        do i = 0, N_SAMPLES - 1
          time = state%time
          if (size(wings%params%wings) > 0) time = time + i/(N_SAMPLES*wings%params%frequency())
          flyer%fraction = min(flyer%fraction, least_fraction(wings%own(time), wings%whole(time), flyer%params%held))
        end do
      end if
      if (present(coupler)) call carry_wings(wings, coupler)
      if (flyer%fraction < SMALLEST_FRACTION) then
        call failure%raise('the insect is too light to fly freely: its mass is '//number_text(flyer%params%mass)// &
                           ', body and wings displace fluid of mass '//number_text(flyer%params%mass - rest%mass)// &
                           ' in the mask, and without that fluid '//number_text(flyer%fraction)// &
                           ' of its inertia is left; valid: more than '//number_text(SMALLEST_FRACTION)// &
                           '. Raise [Insects] mass or J_body_yawpitchroll, or set [Penalization] unst_corrections = no, '// &
                           'with which the insect carries this fluid along, as in FLUSI')
        return
      end if
      fluid%rhs%params%solids%dt_fraction = DAMPED*flyer%fraction
      associate (p => fluid%rhs%params, fraction => DAMPED*flyer%fraction)
        if (p%solids%is_on .and. p%time%dt_fixed > fraction*p%time%cfl_eta*p%solids%c_eta) &
          call failure%raise('[Time] dt_fixed is too large for a body of this mass in this fluid: valid up to '// &
                             'CFL_eta eps '//number_text(fraction)//' = '//number_text(fraction*p%time%cfl_eta*p%solids%c_eta))
      end associate
    end associate
  end subroutine begin_flight

  !> Advances the flyer over the step that `fluid` has made, without the forces of the markers.
  subroutine launch(wings, fluid, coupler)
    type(flapping_wings_t), intent(inout) :: wings
    type(fluid_t), intent(in) :: fluid
    type(coupler_t), intent(inout), optional :: coupler !< of flexible wings
    associate (flyer => wings%flyer, dt => fluid%dt, time => fluid%sums_time)
      call flyer%advance(time, dt, wings%whole(time), wings%whole(fluid%rhs%state%time, ahead=dt))
      call wings%motion%show(fluid%rhs%state%time, flyer%carried%known(2))
      if (present(coupler)) call carry_wings(wings, coupler)
    end associate
  end subroutine launch

  !> Completes that step: afterwards the flyer has its state at the end of the step.
  subroutine settle(wings, fluid)
    type(flapping_wings_t), intent(inout) :: wings
    type(fluid_t), intent(in) :: fluid
    type(wing_pose_t) :: poses(size(wings%poses))
    real(rp) :: force(3), moment(3)
    integer :: i
    associate (flyer => wings%flyer, time => fluid%rhs%state%time, body => wings%flyer%carried%known(2))
      do i = 1, size(poses)
        call pose_wing(body, wings%params%wings(i)%mount, wings%params%wings(i)%motion, time, poses(i))
      end do
      call wings%marker_total(poses, body%centre, force, moment)
      call flyer%settle(fluid%sums_time, fluid%dt, wings%whole(time), force, moment)
      flyer%state%acceleration = body%acceleration
      flyer%state%omega_rate = body%rotation%omega_rate
      call wings%motion%show(time, flyer%state%body())
    end associate
  end subroutine settle

  !> Attaches flexible wings to the body in its state after `launch`.
  subroutine carry_wings(wings, coupler)
    type(flapping_wings_t), intent(in) :: wings
    type(coupler_t), intent(inout) :: coupler
    integer :: i
    do i = 1, size(coupler%wings)
      coupler%wings(i)%motion%carrier = wings%flyer%carried
    end do
  end subroutine carry_wings
end module fsi_free_flight

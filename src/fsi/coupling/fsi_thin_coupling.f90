! SPDX-License-Identifier: GPL-3.0-or-later
!> Advances flexible wings without thickness over a time step, together with the flow.
!>
!> The fluid has made its step without the wings. The markers sample it at the extrapolated positions of the wings at the end of the
!> step. The wings make their step under the load by which the flow resists this motion (fsi_flow_reaction). The flow receives
!> the impulse that the wing feels, to round-off. Load and motion are found at the same time, so that neither extrapolation
!> of the load nor sub-iterations are needed, and the wing may be arbitrarily light. The strong coupling repeats the step with the
!> markers on the new positions of the wings, until the positions no longer change; it samples the same flow again and needs no
!> evaluation of the flow.
!>
!> The wing feels the force to second order in the step, the flow to first order: it gets the impulse of the step at its end.
module fsi_thin_coupling
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fluid_solver, only: fluid_t
  use fsi_coupler_params, only: coupler_params_t, COUPLING_STRONG
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_kinematics, only: pose_wing, wing_pose_t
  use fsi_rigid_fit, only: fit_rotation
  use fsi_thin_wings, only: thin_wings_t
  use fsi_wing_deformation, only: check_deflections, predict_deformation, set_deformation
  use fsi_wing_mirror, only: mirror_vectors
  use fsi_wing_solver, only: wing_solver_t
  use solid_dynamics, only: dynamic_state_t
  implicit none
  private
  public :: advance_thin_wings, thin_report_t

  !> Report on a step.
  type :: thin_report_t
    integer :: passes = 0       !< number of times that the wings have made the step
    real(rp) :: distance = 0    !< between assumed and computed markers, over the displacement of the fastest
  end type thin_report_t

contains

  !> Advances the wings over the step that `fluid` has just made, and applies their forces to it at the end. `states` and
  !> `solvers` have begun the step. `force` (3, n_all, wings) [N] is the mean force of the flow on the points in the step, along the
  !> axes of the wing file. `wings` keep their place and get the new deformation. Fails if Newton's method does, if markers come too
  !> close to each other, if a wing bends beyond the limit, or if the strong coupling does not converge; then the run cannot
  !> continue from this state. Collective.
  subroutine advance_thin_wings(thin, fluid, wings, params, solvers, states, force, report, failure)
    type(thin_wings_t), intent(inout) :: thin
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(inout) :: wings
    type(coupler_params_t), intent(in) :: params
    type(wing_solver_t), intent(inout) :: solvers(:)
    type(dynamic_state_t), intent(inout) :: states(:)
    real(rp), intent(inout) :: force(:, :, :)
    type(thin_report_t), intent(out) :: report
    type(failure_t), intent(inout) :: failure
    type(wing_pose_t) :: poses(size(solvers))
    real(rp) :: way
    integer :: i, last
    logical :: is_held
    is_held = wings%time + fluid%dt <= params%release
    do i = 1, size(solvers)
      call find_pose(wings, i, fluid%rhs%state%time, poses(i))
      if (is_held) then
        states(i)%time = states(i)%time + fluid%dt*params%units%time
      else
        call predict_deformation(states(i), params%units, fluid%dt, thin%wings(i)%is_mirrored, wings%deformation(i))
      end if
    end do
    last = merge(params%iterations, 1, params%coupling == COUPLING_STRONG .and. .not. is_held)
    do while (report%passes < last)
      report%passes = report%passes + 1
      do i = 1, size(solvers)
        call place_markers(thin, i, wings, poses(i))
      end do
      if (report%passes == 1) call update_responses(thin, wings, failure)
      if (failure%failed) return
      call thin%sample_flow(fluid, wings)
      do i = 1, size(solvers)
        call meet_flow(thin, i, poses(i), fluid%dt)
        if (is_held) call hold_wing(thin, i, solvers(i), states(i), force(:, :, i))
        if (.not. is_held) call advance_wing(thin, i, fluid%dt, params, solvers(i), states(i), force(:, :, i))
      end do
      do i = 1, size(solvers)
        if (.not. is_held) call solvers(i)%broadcast(thin%world, states(i), failure)
      end do
      if (failure%failed) return
      do i = 1, size(solvers)
        call set_deformation(states(i), params%units, thin%wings(i)%is_mirrored, wings%deformation(i))
      end do
      call move_markers(thin, wings, poses, report%distance)
      way = fluid%dt*sqrt(maxval(sum(thin%u**2, 1)))
      report%distance = report%distance/max(way, tiny(way))
      if (report%distance <= params%tolerance) exit
    end do
    if (last > 1 .and. report%distance > params%tolerance) call fail_to_converge(report, failure)
    call check_deflections(wings, params%largest_deflection, failure) ! before the wings and the flow keep the force
    if (failure%failed) return
    do i = 1, size(solvers)
      call distribute_forces(thin, i, poses(i), params, force(:, :, i))
    end do
    call thin%apply_forces(fluid, wings, poses)
  end subroutine advance_thin_wings

  !> Says that the strong coupling has not converged.
  subroutine fail_to_converge(report, failure)
    type(thin_report_t), intent(in) :: report
    type(failure_t), intent(inout) :: failure
    call failure%raise('the strong coupling has not converged: after '//number_text(report%passes)//' passes the markers '// &
                       'still move by '//number_text(report%distance)//' of their displacement in the step: set a '// &
                       'smaller [Time] CFL or more [Flexible_wing] coupling_iterations')
  end subroutine fail_to_converge

  !> Returns the pose of wing i at `time`.
  subroutine find_pose(wings, i, time, pose)
    type(flapping_wings_t), intent(in) :: wings
    integer, intent(in) :: i
    real(rp), intent(in) :: time
    type(wing_pose_t), intent(out) :: pose
    associate (given => wings%params%wings(i))
      call pose_wing(wings%motion%at(time, wings%params%body), given%mount, given%motion, time, pose)
    end associate
  end subroutine find_pose

  !> Places the markers of wing i where its deformation puts them at the end of the step.
  subroutine place_markers(thin, i, wings, pose)
    type(thin_wings_t), intent(inout) :: thin
    integer, intent(in) :: i
    type(flapping_wings_t), intent(in) :: wings
    type(wing_pose_t), intent(in) :: pose
    integer :: m
    associate (wing => thin%wings(i))
      call wing%markers%positions(wings%deformation(i)%u, wing%bent)
      do m = 1, wing%markers%n
        thin%x(:, wing%first + m - 1) = pose%point_to_space(wing%flat(:, m) + wing%bent(:, m))
      end do
    end associate
  end subroutine place_markers

  !> Rotates the responses of all wings with their markers. Recomputes the responses of wings that have changed their shape since
  !> the last computation.
  subroutine update_responses(thin, wings, failure)
    type(thin_wings_t), intent(inout) :: thin
    type(flapping_wings_t), intent(in) :: wings
    type(failure_t), intent(inout) :: failure
    real(rp), parameter :: MIRROR(3) = [1.0_rp, 1.0_rp, -1.0_rp] !< to the axes of the file, in which the response is made
    real(rp) :: rotation(3, 3), farthest
    logical, dimension(size(thin%wings)) :: are_changed, has_factor
    integer :: i
    do i = 1, size(thin%wings)
      associate (wing => thin%wings(i))
        wing%work = wing%flat + wing%bent
        call fit_rotation(wing%shape, wing%work, rotation, farthest)
        are_changed(i) = farthest > wings%params%thin%response_limit*wings%params%thin%spacing
        if (are_changed(i)) then
          wing%shape = wing%work
        else
          if (wing%is_mirrored) rotation = rotation*spread(MIRROR, 1, 3)*spread(MIRROR, 2, 3)
          call wing%reaction%response%turn(rotation)
        end if
      end associate
    end do
    call thin%rebuild_responses(are_changed, has_factor)
    do i = 1, size(thin%wings)
      if (.not. has_factor(i)) call failure%raise('the '//trim(wings%params%wings(i)%side)//' wing has bent so far that its '// &
                                                  'markers are too close or too far apart, and its motion does not determine '// &
                                                  'their forces: check its shape and the stiffness in [Wing]')
    end do
  end subroutine update_responses

  !> Runs on the owner of wing i. The reaction of the wing begins the step of `dt` with the flow at its markers. The helpers of the
  !> owner take part in the solutions that it needs for the wing, and return when the owner ends them.
  subroutine meet_flow(thin, i, pose, dt)
    type(thin_wings_t), intent(inout) :: thin
    integer, intent(in) :: i
    type(wing_pose_t), intent(in) :: pose
    real(rp), intent(in) :: dt
    integer :: m
    associate (wing => thin%wings(i))
      if (wing%is_helper) call wing%end_solutions()
      if (.not. wing%is_owner) return
      do m = 1, wing%markers%n
        wing%work(:, m) = pose%vector_to_wing(thin%flow(:, wing%first + m - 1))
      end do
      if (wing%is_mirrored) call mirror_vectors(wing%work)
      call wing%reaction%begin(wing%work, wing%last_force, dt)
    end associate
  end subroutine meet_flow

  !> Runs on the owner of wing i, which keeps its shape: returns the force of the flow on it, after `meet_flow`.
  subroutine hold_wing(thin, i, solver, state, force)
    type(thin_wings_t), intent(inout) :: thin
    integer, intent(in) :: i
    type(wing_solver_t), intent(in) :: solver
    type(dynamic_state_t), intent(in) :: state
    real(rp), intent(inout) :: force(:, :)
    associate (wing => thin%wings(i))
      if (.not. wing%is_owner) return
      call wing%reaction%force(solver%motion%at(state%time), state%u, state%v, force)
      call wing%reaction%end_part()
      call wing%end_solutions()
    end associate
  end subroutine hold_wing

  !> Runs on the owner of wing i: makes its step of `dt` under the force of the flow, after `meet_flow`.
  subroutine advance_wing(thin, i, dt, params, solver, state, force)
    type(thin_wings_t), intent(inout) :: thin
    integer, intent(in) :: i
    real(rp), intent(in) :: dt
    type(coupler_params_t), intent(in) :: params
    type(wing_solver_t), intent(inout) :: solver
    type(dynamic_state_t), intent(inout) :: state
    real(rp), intent(inout) :: force(:, :) !< no other load acts; it returns as 0
    associate (wing => thin%wings(i))
      if (.not. wing%is_owner) return
      force = 0
      call solver%solve(params%model, params%inertia, params%options, force, dt*params%units%time, state, wing%reaction)
      call wing%end_solutions()
    end associate
  end subroutine advance_wing

  !> Returns the velocities of the markers in space, and their largest distance [L] from the places where they sampled the flow.
  subroutine move_markers(thin, wings, poses, distance)
    type(thin_wings_t), intent(inout) :: thin
    type(flapping_wings_t), intent(in) :: wings
    type(wing_pose_t), intent(in) :: poses(:)
    real(rp), intent(out) :: distance
    integer :: i, m
    distance = 0
    do i = 1, size(poses)
      associate (wing => thin%wings(i), u => thin%u(:, thin%wings(i)%first:thin%wings(i)%last))
        call wing%markers%positions(wings%deformation(i)%u, wing%work)
        distance = max(distance, sqrt(maxval(sum((wing%work - wing%bent)**2, 1))))
        do m = 1, wing%markers%n
          u(:, m) = poses(i)%velocity_at(wing%flat(:, m) + wing%work(:, m))
        end do
        call wing%markers%positions(wings%deformation(i)%v, wing%work)
        do m = 1, wing%markers%n
          u(:, m) = u(:, m) + poses(i)%vector_to_space(wing%work(:, m))
        end do
      end associate
    end do
  end subroutine move_markers

  !> Gives the forces that the owner of wing i has found to all ranks, as forces on the flow and as the load on the points.
  subroutine distribute_forces(thin, i, pose, params, force)
    type(thin_wings_t), intent(inout) :: thin
    integer, intent(in) :: i
    type(wing_pose_t), intent(in) :: pose
    type(coupler_params_t), intent(in) :: params
    real(rp), intent(inout) :: force(:, :)
    integer :: m
    associate (wing => thin%wings(i), units => params%units)
      if (wing%is_owner) then
        wing%work = wing%reaction%on_flow
        wing%last_force = wing%reaction%last
      end if
      call thin%broadcast(wing%work, wing%owner)
      call thin%broadcast(wing%last_force, wing%owner)
      force = 0
      call wing%markers%spread(wing%work, force)
      force = -(units%mass*units%length/units%time**2)*force
      if (wing%is_mirrored) call mirror_vectors(wing%work)
      do m = 1, wing%markers%n
        thin%force(:, wing%first + m - 1) = pose%vector_to_space(wing%work(:, m))
      end do
    end associate
  end subroutine distribute_forces
end module fsi_thin_coupling

! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimates how long a run will be, and decides whether FFTW measures its plans for it.
!>
!> Measuring takes about MEASURING seconds on any grid. A step takes about STEP seconds for each point, and measured plans make it
!> faster by up to a tenth. They pay off where measuring costs less than 1 % of the run. The rule uses the parameters alone, not the
!> clock or the number of ranks, so that the same input always gets the same plans.
module simulation_plans
  use base_constants, only: PI
  use base_files, only: file_exists
  use base_kinds, only: rp
  use fluid_initial_keys, only: FLOW_RING, FLOW_ROGALLO, FLOW_TAYLOR_GREEN, FLOW_TAYLOR_GREEN_2D
  use fluid_params, only: fluid_params_t
  use fluid_shapes, only: SHAPE_COUETTE
  use fluid_timestep, only: next_step_length
  use parallel_world, only: world_t
  use simulation_settings, only: settings_t
  use spectral_fftw, only: import_wisdom, PLAN_AUTO, PLAN_ESTIMATE, PLAN_MEASURE
  implicit none
  private
  public :: plan_run, expected_steps, choose_planner

  real(rp), parameter :: MEASURING = 1.0_rp !< s
  real(rp), parameter :: STEP = 2.5e-8_rp   !< s for each point

contains

  !> Chooses how FFTW plans the run and returns the `reason` as text. If FFTW measures, it takes the plans from the file
  !> `wisdom` where they are available. Collective.
  subroutine plan_run(world, settings, wisdom, restarts, reason)
    type(world_t), intent(in) :: world
    type(settings_t), intent(inout) :: settings
    character(*), intent(in) :: wisdom
    logical, intent(in) :: restarts
    character(:), allocatable, intent(out) :: reason
    real(rp) :: dt, speed, steps
    integer :: has_wisdom
    logical :: done
    has_wisdom = 0
    if (world%is_root) has_wisdom = merge(1, 0, file_exists(wisdom))
    call world%broadcast_integer(has_wisdom)
    call expected_steps(settings, dt, speed, steps)
    call choose_planner(settings%fluid%resolution%planner, steps, product(real(settings%fluid%grid%n, rp)), restarts, &
                        has_wisdom == 1, reason)
    if (settings%fluid%resolution%planner == PLAN_MEASURE) call import_wisdom(wisdom, done)
  end subroutine plan_run

  !> Estimates the length `dt` [T] and the number of the time steps from the parameters, for the expected velocity `speed`
  !> [L/T]. The flow decides on the actual steps.
  subroutine expected_steps(settings, dt, speed, steps)
    type(settings_t), intent(in) :: settings
    real(rp), intent(out) :: dt, speed, steps
    type(fluid_params_t) :: endless
    associate (p => settings%fluid)
      speed = reference_speed(p)
      if (p%solids%is_moving) speed = max(speed, 0.5_rp*PI*settings%flight%tip_speed()) ! the peak of a cosine
      endless = p
      endless%time%t_max = huge(1.0_rp)
      dt = next_step_length(endless, speed, 0.0_rp, 0.0_rp, [0.0_rp])
      steps = min(p%time%t_max/dt, real(p%time%nt, rp))
    end associate
  end subroutine expected_steps

  !> Replaces `planner`, PLAN_AUTO or another one, by PLAN_ESTIMATE or PLAN_MEASURE, and returns the reason as text. A run that
  !> continues measures if the first part of the run did; `has_wisdom` tells that by the file of its plans.
  subroutine choose_planner(planner, steps, points, restarts, has_wisdom, reason)
    integer, intent(inout) :: planner
    real(rp), intent(in) :: steps, points !< of the run and of the grid
    logical, intent(in) :: restarts, has_wisdom
    character(:), allocatable, intent(out) :: reason
    logical :: measures
    if (planner /= PLAN_AUTO) then
      reason = 'as [Resolution] planner says'
      return
    end if
    if (restarts) then
      measures = has_wisdom
      reason = trim(merge('as before: fftw_wisdom exists     ', 'as before: no fftw_wisdom exists  ', has_wisdom))
    else
      measures = steps*points*STEP > 100*MEASURING
      reason = trim(merge('the run is long ', 'the run is short', measures))
    end if
    planner = merge(PLAN_MEASURE, PLAN_ESTIMATE, measures)
  end subroutine choose_planner

  !> Returns a velocity [L/T] that the flow will have, as far as it follows from the parameters.
  pure real(rp) function reference_speed(p) result(speed)
    type(fluid_params_t), intent(in) :: p
    speed = max(norm2(p%mean%velocity), norm2(p%solids%us_fixed))
    select case (p%initial%flow)
    case (FLOW_RING)
      speed = max(speed, abs(p%initial%omega1)/(PI*max(p%solids%size, tiny(1.0_rp))))
    case (FLOW_TAYLOR_GREEN, FLOW_TAYLOR_GREEN_2D)
      speed = max(speed, 1.0_rp)
    case (FLOW_ROGALLO)
      speed = max(speed, 3*sqrt(2*p%initial%omega1/3))
    end select
    if (p%solids%mask == SHAPE_COUETTE) speed = max(speed, p%solids%omega*p%solids%r1)
  end function reference_speed
end module simulation_plans

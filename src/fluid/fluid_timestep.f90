! SPDX-License-Identifier: GPL-3.0-or-later
!> Chooses the length of the next time step within the limits of stability and accuracy.
module fluid_timestep
  use base_kinds, only: rp
  use fluid_mean_keys, only: MEAN_SINUSOIDAL
  use fluid_params, only: fluid_params_t
  implicit none
  private
  public :: next_step_length, is_due, TOO_FAST

  !> A larger velocity means that the flow has diverged, because the units are chosen such that velocities are of order 1.
  real(rp), parameter :: TOO_FAST = 1.0e3_rp

  !> Largest dt/C_sp. AB2 is stable up to 1. At 1, however, the second root of its characteristic polynomial is -1, and the
  !> vorticity in the sponge oscillates without decay. At 1/2 the moduli of both roots are below 0.65.
  real(rp), parameter :: SPONGE_LIMIT = 0.5_rp

contains

  !> Returns the length [T] of the next step by FLUSI's rule. The step is dt = CFL min(dx)/max|u|, rounded to two significant
  !> digits, so that it stays constant for many steps. It is then limited by dt_max, by the explicit penalization (CFL_eta C_eta
  !> dt_fraction) and by the explicit sponge (C_sp). A prescribed dt_fixed replaces this rule. The last step ends at t_max.
  !>
  !> With intelligent_dt, the time until the next event of any interval in `intervals` (0 = none) is divided into equal steps. A
  !> step is then at most twice the previous step. Without this limit AB2 would extrapolate by a large factor dt/dt_old after a tiny
  !> step, which occurs where events of several intervals lie close together. With even_end the last two steps are equal, so that
  !> the last step is not tiny.
  pure real(rp) function next_step_length(p, u_max, time, dt_old, intervals) result(dt)
    type(fluid_params_t), intent(in) :: p
    real(rp), intent(in) :: u_max !< largest |u| in the box at `time`
    real(rp), intent(in) :: time
    real(rp), intent(in) :: dt_old !< the previous step, 0 if there is none
    real(rp), intent(in) :: intervals(:)
    real(rp) :: left, speed
    integer :: i

    if (p%time%dt_fixed > 0) then
      dt = p%time%dt_fixed
    else
      dt = 1.0e-3_rp ! used for a fluid at rest, for which CFL gives no limit
      speed = u_max
      ! A sinusoidal mean flow passes through zero. The limit uses its amplitude, which it reaches within later steps.
      if (any(p%mean%kind == MEAN_SINUSOIDAL)) speed = max(speed, &
                                                     norm2(merge(p%mean%velocity, 0.0_rp, p%mean%kind == MEAN_SINUSOIDAL)))
      if (speed >= 1.0e-8_rp) dt = two_digits(p%time%cfl*p%grid%min_spacing()/speed)
      if (p%time%dt_max > 0) dt = min(dt, p%time%dt_max)
      if (p%solids%is_on) dt = min(dt, p%solids%dt_fraction*(p%time%cfl_eta*p%solids%c_eta))
      if (p%sponge%is_on) dt = min(dt, SPONGE_LIMIT*p%sponge%damping_time)
      if (any(p%mean%kind == MEAN_SINUSOIDAL) .and. p%mean%frequency > 0) dt = min(dt, 0.02_rp/p%mean%frequency)
    end if
    left = p%time%t_max - time
    if (p%time%intelligent_dt) then
      if (dt_old > 0) dt = min(dt, 2*dt_old)
      do i = 1, size(intervals)
        if (intervals(i) > 0) left = min(left, intervals(i)*(1 - fraction_done(time, intervals(i))))
      end do
      if (left < huge(1)*dt) dt = left/max(1, ceiling(left/dt - 1.0e-9_rp))
    else if (p%time%even_end .and. left < 2*dt) then
      dt = left/max(1, ceiling(left/dt - 1.0e-9_rp))
    else
      dt = min(dt, left)
    end if
  end function next_step_length

  !> Returns the fraction of `interval` by which `time` exceeds the last multiple of it. A time just before a multiple counts as
  !> this multiple.
  pure real(rp) function fraction_done(time, interval) result(fraction)
    real(rp), intent(in) :: time, interval
    fraction = time/interval - floor_of(time, interval)
  end function fraction_done

  !> Returns the number of the last event at or before `time`, with a tolerance for accumulated round-off.
  pure real(rp) function floor_of(time, interval) result(k)
    real(rp), intent(in) :: time, interval
    k = aint(time/interval + 1.0e-9_rp)
  end function floor_of

  !> Tells whether an event of `interval` lies in (time - dt_old, time]. Before the first step (dt_old = 0) the result is true.
  pure logical function is_due(time, dt_old, interval) result(due)
    real(rp), intent(in) :: time, dt_old, interval
    due = .false.
    if (interval <= 0) return
    due = dt_old <= 0
    if (.not. due) due = floor_of(time, interval) > floor_of(time - dt_old, interval)
  end function is_due

  !> Returns a number rounded to two significant digits, as the format es7.1 rounds it.
  pure real(rp) function two_digits(x) result(rounded)
    real(rp), intent(in) :: x
    character(12) :: text
    write (text, '(es9.1e3)') x
    read (text, '(es9.1e3)') rounded
  end function two_digits
end module fluid_timestep

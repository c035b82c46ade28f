! SPDX-License-Identifier: GPL-3.0-or-later
!> Advances the mean velocity, the mode k = 0, in each direction: it is free, prescribed, or accelerated by the reaction of the
!> solids on a given mass of fluid.
module fluid_mean_flow
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use fluid_inflow, only: inflow_growth
  use fluid_mean_keys, only: MEAN_DYNAMIC, MEAN_FIXED, MEAN_FREE, MEAN_SINUSOIDAL
  use fluid_params, only: fluid_params_t
  implicit none
  private
  public :: mean_acceleration, mean_response, imposed_mean_flow

contains

  !> Returns the right-hand side of the mean flow: `n` as computed, or -F/m_fluid in directions where the mean flow is dynamic.
  pure function mean_acceleration(p, time, force, n) result(a)
    type(fluid_params_t), intent(in) :: p
    real(rp), intent(in) :: time
    real(rp), intent(in) :: force(3) !< force on all solids, walls included
    complex(rp), intent(in) :: n(3)
    complex(rp) :: a(3)
    a = n
    where (p%mean%kind == MEAN_DYNAMIC) a = cmplx(-force/p%mean%mass*ramp(p, time), 0.0_rp, rp)
  end function mean_acceleration

  !> Returns how a force on the fluid at points accelerates the mean flow, 1/(rho L^3), in each direction: by the mass of the
  !> fluid where the mean flow is free, by the given mass of fluid where it is dynamic, not at all where it is prescribed.
  pure function mean_response(p, time) result(response)
    type(fluid_params_t), intent(in) :: p
    real(rp), intent(in) :: time
    real(rp) :: response(3)
    response = 0
    where (p%mean%kind == MEAN_FREE) response = 1/p%grid%volume()
    where (p%mean%kind == MEAN_DYNAMIC) response = ramp(p, time)/p%mean%mass
    if (p%walls%has_inflow) response(2) = 0
  end function mean_response

  !> Returns the mean velocity `u` [L/T] at `time` [T] with its prescribed components replaced.
  pure function imposed_mean_flow(p, time, u) result(mean)
    type(fluid_params_t), intent(in) :: p
    real(rp), intent(in) :: time
    complex(rp), intent(in) :: u(3)
    complex(rp) :: mean(3)
    mean = u
    where (p%mean%kind == MEAN_FIXED) mean = p%mean%velocity
    if (p%walls%has_inflow) mean(2) = inflow_growth(p, time)*p%mean%velocity(2)
    where (p%mean%kind == MEAN_SINUSOIDAL) mean = p%mean%velocity*sin(TWO_PI*p%mean%frequency*time)
  end function imposed_mean_flow

  !> Returns the smooth start of the dynamic mean flow: 0 until release, then a cubic to 1 within tau.
  pure real(rp) function ramp(p, time) result(r)
    type(fluid_params_t), intent(in) :: p
    real(rp), intent(in) :: time
    real(rp) :: s
    r = 1
    if (.not. p%mean%has_ramp) return
    s = 1
    if (p%mean%ramp > 0) s = max(0.0_rp, min(1.0_rp, (time - p%mean%release)/p%mean%ramp))
    if (time < p%mean%release) s = 0
    r = s*s*(3 - 2*s)
  end function ramp
end module fluid_mean_flow

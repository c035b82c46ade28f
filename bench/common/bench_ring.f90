! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the vortex ring that the benchmarks of a time step compute.
module bench_ring
  use base_kinds, only: rp
  use fluid_initial_keys, only: FLOW_RING
  use fluid_params, only: fluid_params_t
  use fluid_solid_keys, only: CHANNEL_NONE, MASK_NONE
  use spectral_fftw, only: PLAN_MEASURE
  use spectral_grid, only: make_grid
  use spectral_sticks, only: DEALIAS_ELLIPSOID
  implicit none
  private
  public :: vortex_ring

contains

  !> Sets the parameters of the ring on n(3) points in a box whose longest side is 2.5, with measured FFT plans and a fixed time
  !> step.
  function vortex_ring(n) result(p)
    integer, intent(in) :: n(3)
    type(fluid_params_t) :: p
    p%grid = make_grid(n, 2.5_rp*n/maxval(n))
    p%resolution%planner = PLAN_MEASURE
    p%resolution%dealias = DEALIAS_ELLIPSOID
    p%nu = 1.0e-2_rp
    p%time%t_max = huge(1.0_rp)
    p%time%dt_fixed = 1.0e-4_rp
    p%initial%flow = FLOW_RING
    p%initial%omega1 = 12
    p%solids%size = 0.125_rp*minval(p%grid%length)
    p%solids%centre = p%grid%length/2
    p%solids%mask = MASK_NONE
    p%walls%channel = CHANNEL_NONE
  end function vortex_ring
end module bench_ring

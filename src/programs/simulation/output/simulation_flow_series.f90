! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the rows of the time series of the flow, of its time step and of the mask, with FLUSI's file names and columns.
module simulation_flow_series
  use base_kinds, only: rp
  use fluid_penalty, only: N_COLORS
  use simulation_series_table, only: moment_t, series_table_t, EVERY_INTEGRAL, EVERY_STEP, TIME_COLUMN
  implicit none
  private
  public :: add_flow_series

  character(*), parameter :: XYZ = 'xyz', T = TIME_COLUMN

contains

  !> Adds the series that every run has, and those of the mask if there are `solids`.
  subroutine add_flow_series(table, solids)
    type(series_table_t), intent(inout) :: table
    logical, intent(in) :: solids
    integer :: c
    call table%add('dt.t', [character(40) :: T, 'dt [T]', 'CFL [-]', 'dt*nu/dx^2 [-]', 'dt/eps [-]'], EVERY_STEP, dt_values)
    call table%add('timesteps_info.t', [character(40) :: T, 'wall time per step [s]', 'step', 'dt [T]', 'ranks'], EVERY_STEP, &
                   cost_values)
    call table%add('ekin.t', [character(40) :: T, 'kinetic energy [rho L^5/T^2]'], EVERY_STEP, ekin_values)
    call table%add('energy.t', energy_columns(), EVERY_INTEGRAL, energy_values)
    call table%add('divu.t', [character(40) :: T, 'max |div u| [1/T]', 'max |div u|(1-chi) [1/T]'], EVERY_INTEGRAL, &
                   divergence_values)
    call table%add('meanflow.t', [character(40) :: T, 'mean ux [L/T]', 'mean uy [L/T]', 'mean uz [L/T]'], EVERY_INTEGRAL, &
                   mean_flow_values)
    call table%add('mask_volume.t', [character(40) :: T, 'int chi [L^3]', 'int chi usx [L^4/T]', 'int chi usy [L^4/T]', &
                                     'int chi usz [L^4/T]'], EVERY_INTEGRAL, mask_volume_values, exists=solids)
    call table%add('u_residual.t', &
                   [character(40) :: T, ('rms |u-us| color '//achar(iachar('0') + c)//' [L/T]', c=0, N_COLORS - 1)], &
                   EVERY_INTEGRAL, residual_values, exists=solids)
  end subroutine add_flow_series

  !> Returns time step, CFL number, viscous and penalization numbers.
  subroutine dt_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    real(rp) :: h
    associate (p => now%fluid%rhs%params, dt => now%fluid%dt)
      h = p%grid%min_spacing()
      values = [now%fluid%sums_time, dt, dt*now%fluid%sums%u_max/h, dt*p%nu/h**2, &
                merge(dt/p%solids%c_eta, 0.0_rp, p%solids%is_on)]
    end associate
  end subroutine dt_values

  !> Returns wall time of the step, number of steps, time step, ranks.
  subroutine cost_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    values = [now%fluid%sums_time, now%seconds, real(now%fluid%rhs%state%step, rp), now%fluid%dt, real(now%ranks, rp)]
  end subroutine cost_values

  !> Returns the kinetic energy.
  subroutine ekin_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    values = [now%fluid%sums_time, now%fluid%sums%kinetic_energy]
  end subroutine ekin_values

  !> Returns energies and dissipations of the fluid and of the box, and the power of the penalization.
  subroutine energy_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    associate (s => now%fluid%sums, nu => now%fluid%rhs%params%nu)
      values = [now%fluid%sums_time, sum(s%energy_fluid), s%energy_fluid, nu*sum(s%enstrophy_fluid), nu*s%enstrophy_fluid, &
                sum(s%energy), s%energy, nu*sum(s%enstrophy), nu*s%enstrophy, sum(s%power), sum(s%power, 2)]
    end associate
  end subroutine energy_values

  !> Returns the column titles of the energy file.
  function energy_columns() result(columns)
    character(40) :: columns(21)
    character(5), parameter :: REGIONS(2) = ['fluid', 'box  ']
    character(1) :: i
    integer :: w, c, n
    columns(1) = T
    n = 1
    do w = 1, 2
      columns(n + 1) = 'E '//trim(REGIONS(w))//' [rho L^5/T^2]'
      columns(n + 5) = 'dissipation '//trim(REGIONS(w))//' [rho L^5/T^3]'
      do c = 1, 3
        i = XYZ(c:c)
        columns(n + 1 + c) = 'E'//i//' '//trim(REGIONS(w))//' [rho L^5/T^2]'
        columns(n + 5 + c) = 'dissipation '//i//' '//trim(REGIONS(w))//' [rho L^5/T^3]'
      end do
      n = n + 8
    end do
    columns(18) = 'penalization power [rho L^5/T^3]'
    do c = 1, 3
      columns(18 + c) = 'penalization power '//XYZ(c:c)//' [rho L^5/T^3]'
    end do
  end function energy_columns

  !> Returns the largest divergence, everywhere and outside the solids.
  subroutine divergence_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    values = [now%fluid%sums_time, now%fluid%sums%divergence, now%fluid%sums%divergence_fluid]
  end subroutine divergence_values

  !> Returns the mean velocity.
  subroutine mean_flow_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    values = [now%fluid%sums_time, now%fluid%sums%mean]
  end subroutine mean_flow_values

  !> Returns the volume of the mask and its momentum.
  subroutine mask_volume_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    associate (s => now%fluid%sums)
      values = [now%fluid%sums_time, sum(s%solid_volume), sum(s%solid_momentum, 2)]
    end associate
  end subroutine mask_volume_values

  !> Returns the rms of the slip in the mask of each colour.
  subroutine residual_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    associate (s => now%fluid%sums)
      values = [now%fluid%sums_time, sqrt(s%slip/max(s%solid_volume, tiny(1.0_rp)))]
    end associate
  end subroutine residual_values
end module simulation_flow_series

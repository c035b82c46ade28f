! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the rows of the series that tell in every step how well the coupling of each flexible wing
!> works, `coupling_left.t` and `coupling_right.t`.
!>
!> A record belongs to the beginning of its step. It holds the sampled load that bends the wing, and the difference between this
!> load and that of the penalization, which is the same load as the flow feels it. The work of the step follows.
module simulation_coupling_series
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flight_params, only: flight_params_t
  use fsi_wing_loads, only: wing_loads, wing_loads_t
  use simulation_series_table, only: moment_t, series_table_t, EVERY_STEP, TIME_COLUMN
  implicit none
  private
  public :: add_coupling_series, record_loads

  character(*), parameter :: XYZ = 'xyz'
  integer, parameter :: N_LOADS = 9 !< number of columns known at the beginning of a step; the first is the time

contains

  !> Adds one series for each wing, and makes room in `now` for what `record_loads` records.
  subroutine add_coupling_series(table, now, flight)
    type(series_table_t), intent(inout) :: table
    type(moment_t), intent(inout) :: now
    type(flight_params_t), intent(in) :: flight
    character(40) :: columns(N_LOADS + 2)
    character(:), allocatable :: load, flow, evaluations
    integer :: i, c
    load = 'pressure'
    flow = 'penalty'
    evaluations = 'evaluations of the flow'
    if (flight%thin%is_thin) then
      load = 'markers'
      flow = 'flow'
      evaluations = 'passes of the wings'
    end if
    columns(1) = TIME_COLUMN
    do c = 1, 3
      columns(1 + c) = 'F'//XYZ(c:c)//' of the '//load//' [rho L^4/T^2]'
      columns(4 + c) = 'F'//XYZ(c:c)//' '//load//' - '//flow//' [rho L^4/T^2]'
    end do
    columns(8:) = [character(40) :: 'power to the flow [rho L^5/T^3]', 'power '//load//' - '//flow//' [rho L^5/T^3]', &
                   'factorisations', evaluations]
    allocate (now%sampled(N_LOADS, size(flight%wings)))
    do i = 1, size(flight%wings)
      call table%add('coupling_'//trim(flight%wings(i)%side)//'.t', columns, EVERY_STEP, coupling_values, item=i)
    end do
  end subroutine add_coupling_series

  !> Stores the loads that `coupler` has just sampled, and the loads of the penalization in the same pass of `fluid`.
  subroutine record_loads(now, wings, coupler, fluid)
    type(moment_t), intent(inout) :: now
    type(flapping_wings_t), intent(in) :: wings
    type(coupler_t), intent(in) :: coupler
    type(fluid_t), intent(in) :: fluid
    type(wing_loads_t) :: penalty
    integer :: i
    do i = 1, size(now%sampled, 2)
      penalty = wing_loads(wings, i, fluid)
      associate (load => coupler%loads(i))
        now%sampled(:, i) = [fluid%sums_time, load%force, load%force - penalty%force, load%power, load%power - penalty%power]
      end associate
    end do
  end subroutine record_loads

  !> Returns the recorded loads of a wing, and the work of the step that the coupler has just made.
  subroutine coupling_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    values = [now%sampled(:, now%item), real([now%coupler%wings(now%item)%factorisations, &
                                              max(1, now%coupler%report%iterations)], rp)]
  end subroutine coupling_values
end module simulation_coupling_series

! SPDX-License-Identifier: GPL-3.0-or-later
!> Records in every step how well the coupling of each flexible wing works, in `coupling_left.t` and `coupling_right.t`.
!>
!> A record belongs to the beginning of its step. It holds the sampled load that bends the wing, and the difference between this
!> load and that of the penalization, which is the same load as the flow feels it. The work of the step follows.
module simulation_coupling_series
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flight_params, only: flight_params_t
  use fsi_wing_loads, only: wing_loads, wing_loads_t
  use io_series, only: series_t
  use simulation_opening, only: opening_t
  implicit none
  private
  public :: coupling_series_t

  character(*), parameter :: XYZ = 'xyz'
  integer, parameter :: N_LOADS = 9 !< number of columns known at the beginning of a step; the first is the time

  !> Writes one series for each flexible wing. In every step, call `record` at its beginning and `write` at its end.
  type :: coupling_series_t
    private
    type(series_t), allocatable :: wing(:)
    real(rp), allocatable :: loads(:, :) !< (N_LOADS, wings) of the step that is being made
  contains
    procedure :: open => series_open
    procedure :: record => series_record
    procedure :: write => series_write
    procedure :: close => series_close
  end type coupling_series_t

contains

  !> Opens one file for each wing through `opening`, which keeps the first failure. Collective.
  subroutine series_open(self, opening, flight)
    class(coupling_series_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
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
    columns(1) = 'time [T]'
    do c = 1, 3
      columns(1 + c) = 'F'//XYZ(c:c)//' of the '//load//' [rho L^4/T^2]'
      columns(4 + c) = 'F'//XYZ(c:c)//' '//load//' - '//flow//' [rho L^4/T^2]'
    end do
    columns(8:) = [character(40) :: 'power to the flow [rho L^5/T^3]', 'power '//load//' - '//flow//' [rho L^5/T^3]', &
                   'factorisations', evaluations]
    allocate (self%wing(size(flight%wings)), self%loads(N_LOADS, size(flight%wings)))
    do i = 1, size(self%wing)
      call opening%open(self%wing(i), 'coupling_'//trim(flight%wings(i)%side)//'.t', columns)
    end do
  end subroutine series_open

  !> Stores the loads that `coupler` has just sampled, and the loads of the penalization in the same pass of `fluid`.
  subroutine series_record(self, wings, coupler, fluid)
    class(coupling_series_t), intent(inout) :: self
    type(flapping_wings_t), intent(in) :: wings
    type(coupler_t), intent(in) :: coupler
    type(fluid_t), intent(in) :: fluid
    type(wing_loads_t) :: penalty
    integer :: i
    do i = 1, size(self%wing)
      penalty = wing_loads(wings, i, fluid)
      associate (load => coupler%loads(i))
        self%loads(:, i) = [fluid%sums_time, load%force, load%force - penalty%force, load%power, &
                            load%power - penalty%power]
      end associate
    end do
  end subroutine series_record

  !> Writes one record for each wing on the step that `coupler` has just made. `close` reports a failure.
  subroutine series_write(self, coupler)
    class(coupling_series_t), intent(inout) :: self
    type(coupler_t), intent(in) :: coupler
    integer :: i
    do i = 1, size(self%wing)
      call self%wing(i)%write([self%loads(:, i), real([coupler%wings(i)%factorisations, &
                                                       max(1, coupler%report%iterations)], rp)])
    end do
  end subroutine series_write

  !> Closes all files. Fails if any of them could not be written completely. Collective.
  subroutine series_close(self, failure)
    class(coupling_series_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    integer :: i
    if (.not. allocated(self%wing)) return
    do i = 1, size(self%wing)
      call self%wing(i)%close(failure)
    end do
  end subroutine series_close
end module simulation_coupling_series

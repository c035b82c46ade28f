! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the time series of a run with FLUSI's file names and columns. The table of all series follows from the settings.
module simulation_series
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_thin_wings, only: thin_wings_t
  use fsi_wing_loads, only: wing_loads, wing_loads_t
  use simulation_body_series, only: add_body_series
  use simulation_coupling_series, only: add_coupling_series, record_loads
  use simulation_flight_series, only: add_flight_series
  use simulation_flow_series, only: add_flow_series
  use simulation_force_series, only: add_force_series
  use simulation_opening, only: opening_t
  use simulation_series_table, only: moment_t, series_table_t, EVERY_INTEGRAL, EVERY_PASS, EVERY_SLIP, EVERY_STEP
  use simulation_settings, only: settings_t
  use simulation_spectra, only: add_spectra, record_spectra, write_wavenumbers
  implicit none
  private
  public :: run_series_t

  !> Writes all time series of a run.
  type :: run_series_t
    private
    type(series_table_t) :: table
    type(moment_t) :: now !< what the next records are of
  contains
    procedure :: open => series_open
    procedure :: record => series_record
    procedure :: record_spectra => series_record_spectra
    procedure :: write_pass => series_write_pass
    procedure :: write_step => series_write_step
    procedure :: write_slip => series_write_slip
    procedure :: write_integrals => series_write_integrals
    procedure :: close => series_close
  end type run_series_t

contains

  !> Opens all files. Moving wings must be at their positions. `fluid`, and `wings` if wings move, are absent only where there is no
  !> run and `opening` only gathers names. Collective.
  subroutine series_open(self, opening, settings, fluid, wings)
    class(run_series_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    type(settings_t), intent(in) :: settings
    type(fluid_t), intent(in), optional :: fluid
    type(flapping_wings_t), intent(in), optional :: wings
    associate (solids => settings%fluid%solids, flight => settings%flight, table => self%table, now => self%now)
      call add_flow_series(table, solids%is_on)
      if ((solids%is_on .or. solids%is_moving) .and. solids%compute_forces) &
        call add_force_series(table, opening%world, solids%is_moving, fluid, wings)
      if (settings%output%spectra) call add_spectra(table, now, opening%world, fluid)
      if (solids%is_moving) then
        call add_flight_series(table, now, flight, settings%flexible, wings)
        if (flight%flyer%is_free) call add_body_series(table)
        if (settings%flexible) call add_coupling_series(table, now, flight)
      end if
      call table%open(opening)
      if (settings%output%spectra .and. present(fluid)) call write_wavenumbers(opening, fluid)
    end associate
  end subroutine series_open

  !> Stores the loads that `coupler` sampled at the beginning of the step, for the records of the step.
  subroutine series_record(self, wings, coupler, fluid)
    class(run_series_t), intent(inout) :: self
    type(flapping_wings_t), intent(in) :: wings
    type(coupler_t), intent(in) :: coupler
    type(fluid_t), intent(in) :: fluid
    call record_loads(self%now, wings, coupler, fluid)
  end subroutine series_record

  !> Stores the energy spectra of the present state if the run writes them. The integrals need them after the next step, which
  !> changes the state. Collective.
  subroutine series_record_spectra(self, fluid)
    class(run_series_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    call record_spectra(self%now, fluid)
  end subroutine series_record_spectra

  !> Writes the records of every pass. Wings and body must be where they were in it.
  subroutine series_write_pass(self, fluid, wings)
    class(run_series_t), intent(inout) :: self
    type(fluid_t), intent(in), target :: fluid
    type(flapping_wings_t), intent(in), target, optional :: wings
    self%now%fluid => fluid
    nullify (self%now%wings)
    if (present(wings)) self%now%wings => wings
    call self%table%write(EVERY_PASS, self%now)
  end subroutine series_write_pass

  !> Writes the records of every step at the time at which the step began. `seconds` is the wall time that the step took. With
  !> `coupler`, the caller must have called `record` in this step. `write_integrals` or `close` reports a failure.
  subroutine series_write_step(self, fluid, seconds, ranks, coupler)
    class(run_series_t), intent(inout) :: self
    type(fluid_t), intent(in), target :: fluid
    real(rp), intent(in) :: seconds
    integer, intent(in) :: ranks
    type(coupler_t), intent(in), target, optional :: coupler
    self%now%fluid => fluid
    self%now%seconds = seconds
    self%now%ranks = ranks
    nullify (self%now%wings, self%now%coupler)
    if (present(coupler)) self%now%coupler => coupler
    call self%table%write(EVERY_STEP, self%now)
  end subroutine series_write_step

  !> Writes the slip of wings without thickness after the last step, if it was due and the pass that `fluid` has just made is the
  !> first that knows it.
  subroutine series_write_slip(self, fluid, thin)
    class(run_series_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    type(thin_wings_t), intent(inout), target, optional :: thin
    logical :: is_new
    if (.not. present(thin)) return
    call thin%read_slip(fluid, is_new)
    if (.not. is_new) return
    self%now%thin => thin
    call self%table%write(EVERY_SLIP, self%now)
    nullify (self%now%thin)
  end subroutine series_write_slip

  !> Writes the integrals of the last pass, which must have requested them, and the bending by the load that `coupler` has just
  !> sampled. The wings must be where they were in that pass. Fails if any series can no longer be written, for instance on a full
  !> disk. Collective.
  subroutine series_write_integrals(self, fluid, failure, wings, coupler)
    class(run_series_t), intent(inout) :: self
    type(fluid_t), intent(in), target :: fluid
    type(failure_t), intent(inout) :: failure
    type(flapping_wings_t), intent(in), target, optional :: wings
    type(coupler_t), intent(in), target, optional :: coupler
    integer :: i
    self%now%fluid => fluid
    self%now%loads = [wing_loads_t ::]
    nullify (self%now%wings, self%now%coupler)
    if (present(coupler)) self%now%coupler => coupler
    if (present(wings)) then
      self%now%wings => wings
      self%now%loads = [(wing_loads(wings, i, fluid), i=1, size(wings%surfaces))]
    end if
    call self%table%write(EVERY_INTEGRAL, self%now)
    ! All series are in one folder: a full disk is also found by the series that is written at every step.
    call self%table%check('ekin.t', failure)
    call self%table%check('energy.t', failure)
  end subroutine series_write_integrals

  !> Closes all files. Fails if any of them could not be written completely. Collective.
  subroutine series_close(self, failure)
    class(run_series_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    call self%table%close(failure)
  end subroutine series_close
end module simulation_series

! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the time series of a run with FLUSI's file names and columns. Root writes, and every record is flushed to the disk at
!> once.
module simulation_series
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_penalty, only: N_COLORS, COLOR_BODY
  use fluid_solver, only: fluid_t
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_surface_load, only: surface_load_t
  use fsi_thin_wings, only: thin_wings_t
  use fsi_wing_loads, only: wing_loads_t, wing_loads
  use io_series, only: series_t
  use parallel_world, only: world_t
  use simulation_body_series, only: body_series_t
  use simulation_coupling_series, only: coupling_series_t
  use simulation_flight_series, only: flight_series_t
  use simulation_opening, only: opening_t
  use simulation_settings, only: settings_t
  use simulation_spectra, only: spectra_t
  implicit none
  private
  public :: run_series_t

  character(*), parameter :: XYZ = 'xyz', T = 'time [T]'

  !> Writes all time series of a run.
  type :: run_series_t
    private
    type(series_t) :: dt, timesteps, ekin, slip           !< every step
    type(series_t) :: energy, divergence, mean_flow       !< every integral interval
    type(series_t) :: forces, mask_volume, residual
    type(series_t) :: part(0:N_COLORS - 1)
    type(flight_series_t) :: flight
    type(body_series_t) :: body                           !< every step of a free flight
    type(spectra_t) :: spectra
    type(coupling_series_t) :: coupling                   !< every step
    logical :: has_color(0:N_COLORS - 1) = .false.
    logical :: solids = .false., compute_forces = .false., has_wings = .false., has_slip = .false.
  contains
    procedure :: open => series_open
    procedure :: record => series_record
    procedure :: write_flight => series_write_flight
    procedure :: record_spectra => series_record_spectra
    procedure :: write_step => series_write_step
    procedure :: write_integrals => series_write_integrals
    procedure :: write_bending => series_write_bending
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
    associate (p => settings%fluid%solids)
      self%solids = p%is_on
      self%has_wings = p%is_moving
      self%compute_forces = (p%is_on .or. p%is_moving) .and. p%compute_forces
    end associate
    call opening%open(self%dt, 'dt.t', [character(40) :: T, 'dt [T]', 'CFL [-]', 'dt*nu/dx^2 [-]', 'dt/eps [-]'])
    call opening%open(self%timesteps, 'timesteps_info.t', [character(40) :: T, 'wall time per step [s]', 'step', &
                                                           'dt [T]', 'ranks'])
    call opening%open(self%ekin, 'ekin.t', [character(40) :: T, 'kinetic energy [rho L^5/T^2]'])
    call opening%open(self%energy, 'energy.t', energy_columns())
    call opening%open(self%divergence, 'divu.t', [character(40) :: T, 'max |div u| [1/T]', 'max |div u|(1-chi) [1/T]'])
    call opening%open(self%mean_flow, 'meanflow.t', [character(40) :: T, 'mean ux [L/T]', 'mean uy [L/T]', 'mean uz [L/T]'])
    if (self%solids) call open_solids(self, opening)
    if (self%compute_forces) call open_forces(self, opening, fluid, wings)
    if (settings%output%spectra) call self%spectra%open(opening, fluid)
    if (self%has_wings) call open_wings(self, opening, settings, wings)
  end subroutine series_open

  !> Opens the time series of the mask and of the slip in it.
  subroutine open_solids(self, opening)
    class(run_series_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    integer :: c
    call opening%open(self%mask_volume, 'mask_volume.t', [character(40) :: T, 'int chi [L^3]', 'int chi usx [L^4/T]', &
                                                          'int chi usy [L^4/T]', 'int chi usz [L^4/T]'])
    call opening%open(self%residual, 'u_residual.t', &
                      [character(40) :: T, ('rms |u-us| color '//achar(iachar('0') + c)//' [L/T]', c=0, N_COLORS - 1)])
  end subroutine open_solids

  !> Opens the series of the forces on all solids and on each part. Only a run knows the parts.
  subroutine open_forces(self, opening, fluid, wings)
    class(run_series_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    type(fluid_t), intent(in), optional :: fluid
    type(flapping_wings_t), intent(in), optional :: wings
    character(16) :: name
    integer :: c
    call opening%open(self%forces, 'forces.t', force_columns(self%has_wings))
    if (.not. present(fluid)) then
      call opening%list('forces_part*.t')
      return
    end if
    call find_colors(self, opening%world, fluid, wings)
    do c = COLOR_BODY, N_COLORS - 1
      if (.not. self%has_color(c)) cycle
      write (name, '(a,i1,a)') 'forces_part', c, '.t'
      call opening%open(self%part(c), trim(name), force_columns(is_wing(wings, c) .or. is_body(wings, c)))
    end do
  end subroutine open_forces

  !> Opens the time series of wings and body.
  subroutine open_wings(self, opening, settings, wings)
    class(run_series_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    type(settings_t), intent(in) :: settings
    type(flapping_wings_t), intent(in), optional :: wings
    self%has_slip = settings%flight%thin%is_thin
    if (self%has_slip) call opening%open(self%slip, 'slip.t', &
      [character(40) :: T, 'largest slip after the step [L/T]', 'before its forces [L/T]', 'largest wing speed [L/T]', &
                        'power to the flow [rho L^5/T^3]', 'iterations of the forces', 'share of the slip that they leave'])
    call self%flight%open(opening, settings%flight, settings%flexible, wings)
    if (settings%flight%flyer%is_free) call self%body%open(opening)
    if (settings%flexible) call self%coupling%open(opening, settings%flight)
  end subroutine open_wings

  !> Finds which colours the solids have. Collective.
  subroutine find_colors(self, world, fluid, wings)
    class(run_series_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(fluid_t), intent(in) :: fluid
    type(flapping_wings_t), intent(in), optional :: wings
    real(rp) :: points(0:N_COLORS - 1)
    integer :: c
    points = fluid%rhs%penalty%count_colors()
    call world%sum_reals(points)
    self%has_color = points > 0.5_rp
    do c = 0, N_COLORS - 1
      self%has_color(c) = self%has_color(c) .or. is_wing(wings, c)
    end do
  end subroutine find_colors

  !> Returns the column titles of the energy file.
  function energy_columns() result(columns)
    character(40) :: columns(21)
    character(5), parameter :: PLACE(2) = ['fluid', 'box  ']
    character(1) :: i
    integer :: w, c, n
    columns(1) = 'time [T]'
    n = 1
    do w = 1, 2
      columns(n + 1) = 'E '//trim(PLACE(w))//' [rho L^5/T^2]'
      columns(n + 5) = 'dissipation '//trim(PLACE(w))//' [rho L^5/T^3]'
      do c = 1, 3
        i = XYZ(c:c)
        columns(n + 1 + c) = 'E'//i//' '//trim(PLACE(w))//' [rho L^5/T^2]'
        columns(n + 5 + c) = 'dissipation '//i//' '//trim(PLACE(w))//' [rho L^5/T^3]'
      end do
      n = n + 8
    end do
    columns(18) = 'penalization power [rho L^5/T^3]'
    do c = 1, 3
      columns(18 + c) = 'penalization power '//XYZ(c:c)//' [rho L^5/T^3]'
    end do
  end function energy_columns

  !> Returns the column titles of the files of forces, with powers if `has_power`.
  function force_columns(has_power) result(columns)
    logical, intent(in) :: has_power
    character(40), allocatable :: columns(:)
    integer :: c
    allocate (columns(13))
    columns(1) = 'time [T]'
    do c = 1, 3
      columns(1 + c) = 'F'//XYZ(c:c)//' [rho L^4/T^2]'
      columns(4 + c) = 'F'//XYZ(c:c)//' unsteady [rho L^4/T^2]'
      columns(7 + c) = 'M'//XYZ(c:c)//' [rho L^5/T^2]'
      columns(10 + c) = 'M'//XYZ(c:c)//' unsteady [rho L^5/T^2]'
    end do
    if (has_power) columns = [columns, power_columns()]
  end function force_columns

  !> Returns the columns that forces.t has in addition if there are wings.
  function power_columns() result(columns)
    character(40) :: columns(2)
    columns = [character(40) :: 'aerodynamic power [rho L^5/T^3]', 'inertial power [rho L^5/T^3]']
  end function power_columns

  !> Stores the loads that `coupler` sampled at the beginning of the step, for the records of the step.
  subroutine series_record(self, wings, coupler, fluid)
    class(run_series_t), intent(inout) :: self
    type(flapping_wings_t), intent(in) :: wings
    type(coupler_t), intent(in) :: coupler
    type(fluid_t), intent(in) :: fluid
    call self%coupling%record(wings, coupler, fluid)
  end subroutine series_record

  !> Writes the record of a free flyer, if there is one. The flyer must be where it was in the last pass of the fluid.
  subroutine series_write_flight(self, wings)
    class(run_series_t), intent(inout) :: self
    type(flapping_wings_t), intent(in), optional :: wings
    if (.not. present(wings)) return
    if (allocated(wings%flyer)) call self%body%write(wings%time, wings%flyer)
  end subroutine series_write_flight

  !> Stores the energy spectra of the present state if the run writes them. The integrals need them after the next step, which
  !> changes the state. Collective.
  subroutine series_record_spectra(self, fluid)
    class(run_series_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    call self%spectra%record(fluid)
  end subroutine series_record_spectra

  !> Writes the records of every step at the time at which the step began. `seconds` is the wall time that the step took. With
  !> `coupler`, the caller must have called `record` in this step. `write_integrals` or `close` reports a failure.
  subroutine series_write_step(self, fluid, seconds, ranks, coupler, thin)
    class(run_series_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    real(rp), intent(in) :: seconds
    integer, intent(in) :: ranks
    type(coupler_t), intent(in), optional :: coupler
    type(thin_wings_t), intent(in), optional :: thin
    real(rp) :: h
    associate (p => fluid%rhs%params, t => fluid%sums_time, dt => fluid%dt)
      h = p%grid%min_spacing()
      call self%dt%write([t, dt, dt*fluid%sums%u_max/h, dt*p%nu/h**2, merge(dt/p%solids%c_eta, 0.0_rp, p%solids%is_on)])
      call self%timesteps%write([t, seconds, real(fluid%rhs%state%step, rp), dt, real(ranks, rp)])
      call self%ekin%write([t, fluid%sums%kinetic_energy])
    end associate
    if (present(coupler)) call self%coupling%write(coupler)
    if (.not. present(thin)) return
    if (thin%slip%is_measured) call self%slip%write([fluid%sums_time, thin%slip%after, thin%slip%before, &
                                                  thin%slip%speed, thin%slip%received, &
                                                  real(thin%slip%iterations, rp), thin%slip%left])
  end subroutine series_write_step

  !> Writes the integrals of the last pass, which must have requested them. The wings must be where they were in that pass.
  !> Fails if any series can no longer be written, for instance on a full disk. Collective.
  subroutine series_write_integrals(self, fluid, failure, wings)
    class(run_series_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    type(failure_t), intent(inout) :: failure
    type(flapping_wings_t), intent(in), optional :: wings
    type(wing_loads_t), allocatable :: loads(:)
    real(rp) :: rms(0:N_COLORS - 1), force(3), moment(3)
    real(rp), allocatable :: powers(:)
    type(surface_load_t) :: at_markers
    integer :: c, i
    allocate (loads(0))
    if (present(wings)) loads = [(wing_loads(wings, i, fluid), i=1, size(wings%surfaces))]
    associate (t => fluid%sums_time, s => fluid%sums, nu => fluid%rhs%params%nu)
      call self%energy%write([t, sum(s%energy_fluid), s%energy_fluid, nu*sum(s%enstrophy_fluid), &
                              nu*s%enstrophy_fluid, sum(s%energy), s%energy, nu*sum(s%enstrophy), nu*s%enstrophy, &
                              sum(s%power), sum(s%power, 2)])
      call self%divergence%write([t, s%divergence, s%divergence_fluid])
      call self%mean_flow%write([t, s%mean])
      call self%spectra%write(t)
      if (self%solids) then
        call self%mask_volume%write([t, sum(s%solid_volume), sum(s%solid_momentum, 2)])
        rms = sqrt(s%slip/max(s%solid_volume, tiny(1.0_rp)))
        call self%residual%write([t, rms])
      end if
      if (self%compute_forces) then
        force = 0
        moment = 0
        if (present(wings)) call wings%marker_total(wings%poses, fluid%rhs%params%solids%centre, force, moment)
        call self%forces%write([t, sum(s%force(:, COLOR_BODY:), 2) + force, sum(fluid%unsteady_force(:, COLOR_BODY:), 2), &
                                sum(s%moment(:, COLOR_BODY:), 2) + moment, sum(fluid%unsteady_moment(:, COLOR_BODY:), 2), &
                                total_power(wings, loads, body_power(wings, fluid))])
        do c = COLOR_BODY, N_COLORS - 1
          if (.not. self%has_color(c) .or. is_wing(wings, c)) cycle
          powers = [real(rp) ::]
          if (is_body(wings, c)) powers = [body_power(wings, fluid), 0.0_rp]
          at_markers = marker_part(wings, c)
          call self%part(c)%write([t, s%force(:, c) + at_markers%force, fluid%unsteady_force(:, c), &
                                   s%moment(:, c) + at_markers%moment, fluid%unsteady_moment(:, c), powers])
        end do
        ! As in FLUSI, moments of a wing are about its hinge.
        do i = 1, size(loads)
          c = wings%surfaces(i)%color
          associate (l => loads(i))
            if (self%has_color(c)) call self%part(c)%write( &
              [t, l%force - l%unsteady_force, l%unsteady_force, l%torque - l%unsteady_torque, l%unsteady_torque, &
               l%power, l%inertial_power])
          end associate
        end do
      end if
      if (present(wings)) call self%flight%write(wings, loads, body_power(wings, fluid))
    end associate
    ! All series are in one folder: a full disk is also found by the series that is written at every step.
    call self%ekin%check(failure)
    call self%energy%check(failure)
  end subroutine series_write_integrals

  !> Tells whether this colour is that of one of the wings.
  pure logical function is_wing(wings, color)
    type(flapping_wings_t), intent(in), optional :: wings
    integer, intent(in) :: color
    integer :: i
    is_wing = .false.
    if (present(wings)) is_wing = any([(wings%surfaces(i)%color == color, i=1, size(wings%surfaces))])
  end function is_wing

  !> Tells whether this colour is that of the body of an insect.
  pure logical function is_body(wings, color)
    type(flapping_wings_t), intent(in), optional :: wings
    integer, intent(in) :: color
    is_body = .false.
    if (present(wings)) is_body = color == COLOR_BODY .and. wings%has_body()
  end function is_body

  !> Returns the load on the body by markers of wings without thickness that lie inside it.
  pure type(surface_load_t) function marker_part(wings, color) result(load)
    type(flapping_wings_t), intent(in), optional :: wings
    integer, intent(in) :: color
    if (.not. is_body(wings, color)) return
    if (allocated(wings%marker_loads)) load = wings%marker_loads(size(wings%marker_loads))
  end function marker_part

  !> Returns the aerodynamic power of the body of an insect; it is 0 if there is none.
  pure real(rp) function body_power(wings, fluid) result(power)
    type(flapping_wings_t), intent(in), optional :: wings
    type(fluid_t), intent(in) :: fluid
    type(surface_load_t) :: at_markers
    power = 0
    if (.not. is_body(wings, COLOR_BODY)) return
    at_markers = marker_part(wings, COLOR_BODY)
    power = sum(fluid%sums%power(:, COLOR_BODY)) - wings%params%solid%power_of_fluid(wings%body) + at_markers%power
  end function body_power

  !> Writes the records of flexible wings and of the load that the coupler has just sampled.
  subroutine series_write_bending(self, wings, coupler)
    class(run_series_t), intent(inout) :: self
    type(flapping_wings_t), intent(in) :: wings
    type(coupler_t), intent(in) :: coupler
    call self%flight%write_bending(wings, coupler)
  end subroutine series_write_bending

  !> Returns the aerodynamic power of all wings and the body, and the inertial power of the wings. It is empty if `wings` is
  !> absent.
  pure function total_power(wings, loads, of_body) result(power)
    type(flapping_wings_t), intent(in), optional :: wings
    type(wing_loads_t), intent(in) :: loads(:)
    real(rp), intent(in) :: of_body
    real(rp), allocatable :: power(:)
    if (present(wings)) then
      power = [sum(loads%power) + of_body, sum(loads%inertial_power)]
    else
      allocate (power(0))
    end if
  end function total_power

  !> Closes all files. Fails if any of them could not be written completely. Collective.
  subroutine series_close(self, failure)
    class(run_series_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    integer :: c
    call self%dt%close(failure)
    call self%timesteps%close(failure)
    call self%ekin%close(failure)
    call self%energy%close(failure)
    call self%divergence%close(failure)
    call self%mean_flow%close(failure)
    if (self%solids) then
      call self%mask_volume%close(failure)
      call self%residual%close(failure)
    end if
    if (self%compute_forces) then
      call self%forces%close(failure)
      do c = COLOR_BODY, N_COLORS - 1
        if (self%has_color(c)) call self%part(c)%close(failure)
      end do
    end if
    call self%spectra%close(failure)
    if (self%has_wings) call self%flight%close(failure)
    if (self%has_slip) call self%slip%close(failure)
    call self%body%close(failure)
    call self%coupling%close(failure)
  end subroutine series_close
end module simulation_series

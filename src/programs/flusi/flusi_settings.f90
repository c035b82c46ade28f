! SPDX-License-Identifier: GPL-3.0-or-later
!> Everything the user set, from all sections, with notices on what was assumed.
module flusi_settings
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use common_solver_keys, only: read_limits
  use fluid_params, only: fluid_params_t, read_fluid_params
  use flusi_averages, only: average_params_t, read_average_keys
  use flusi_flexible, only: read_coupler, read_wing_file, wants_flexible, wants_wing_file
  use flusi_flight_faults, only: foresee_flight
  use flusi_free_flight, only: check_free_flight
  use flusi_keys, only: register_all_keys
  use flusi_setting_checks, only: check_scale, check_si_numbers, check_units_together, check_wing_use, notice_flow, &
                                  notice_frequency
  use flusi_translations, only: translate_words
  use fsi_body_keys, only: wants_body
  use fsi_coupler_params, only: coupler_params_t
  use fsi_flight_checks, only: check_place, check_room
  use fsi_flight_params, only: flight_params_t, read_flight_params
  use fsi_thin_keys, only: prepare_thin_flow, wants_thin_wings
  use io_config, only: config_t
  use io_registry, only: registry_t
  use io_stop, only: job_limits_t
  use io_units, only: unit_scales_t
  use parallel_world, only: world_t
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: settings_t, output_params_t, units_t, load_settings

  !> SI values of one code unit.
  type :: units_t
    logical :: given = .false.
    logical :: si_input = .false. !< numbers of the parameter file are in SI units
    real(rp) :: length = 1, frequency = 1, density = 1
  contains
    procedure :: scales => units_scales
    procedure :: note => units_note
  end type units_t

  !> What to write, how often, and when to stop.
  type :: output_params_t
    real(rp) :: t_save = 0, t_save_first = 0, t_integral = 0
    integer :: it_integral = 0
    logical :: velocity = .false., pressure = .false., vorticity = .false., vorticity_magnitude = .false., &
               mask = .false., solid_velocity = .false., wing_sides = .false., q_criterion = .false.
    logical :: spectra = .false.
    logical :: single_precision = .true.
    integer :: stride = 1
    character(:), allocatable :: naming
    logical :: one_period = .false.
    real(rp) :: period = 1
    logical :: backup = .true.
    logical :: mask_only = .false.    !< there is no flow
    type(average_params_t) :: averages
    type(job_limits_t) :: limits      !< of backups, and when to stop
    real(rp) :: progress_seconds = 30
    logical :: slices = .false.
    integer :: slice(4) = -2, it_slice = 0, stack = 1
    real(rp) :: t_slice = 0, t_slice_first = 0
  contains
    procedure :: needs_fields => output_needs_fields
    procedure :: needs_flow => output_needs_flow
    procedure :: held_fields => output_held_fields
    procedure :: needs_scratch => output_needs_scratch
  end type output_params_t

  type :: settings_t
    type(fluid_params_t) :: fluid
    type(flight_params_t) :: flight   !< set if fluid%moving
    type(coupler_params_t) :: coupler !< set if flexible
    logical :: flexible = .false.     !< the flow bends the wings
    type(output_params_t) :: output
    type(units_t) :: units
    type(config_t) :: config
  contains
    procedure :: needs_fields => settings_needs_fields
    procedure :: needs_pressure => settings_needs_pressure
    procedure :: needs_trials => settings_needs_trials
    procedure :: samples_pressure => settings_samples_pressure
  end type settings_t

contains

  !> Reads parameter text, the same on every rank, and the files that it names; all mistakes go to `errors`,
  !> remarks to `notices`. With `world` root reads these files for all, and this is collective.
  subroutine load_settings(text, name, flusi_compat, settings, errors, notices, world)
    character(*), intent(in) :: text, name !< content and name of the file
    logical, intent(in) :: flusi_compat
    type(settings_t), intent(out) :: settings
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(registry_t) :: registry
    call register_all_keys(registry)
    call settings%config%load_text(text, name, registry, errors, notices, flusi_compat, world)
    if (settings%config%asks_for_unbuilt()) return
    ! Keys with mistakes hold their defaults now, so that mistakes across keys are found in the same go.
    call read_units(settings%config, settings%units, errors, notices)
    call translate_words(settings%config, notices)
    call read_fluid_params(settings%config, settings%fluid, errors, draws_solids(settings%config), &
                           notices)
    if (settings%units%si_input) call check_si_numbers(settings%config, settings%fluid, errors)
    call check_wing_use(settings%config, settings%fluid%solids%is_moving, errors)
    call read_output(settings%config, settings%fluid, settings%output, errors)
    if (settings%output%mask_only) settings%fluid%solids%compute_forces = .false.
    if (settings%fluid%solids%is_moving) call read_wings(settings, name, errors, notices, world)
    call notice_idle_settings(settings, notices)
  end subroutine load_settings

  !> Whether any moving solid is in the mask.
  logical function draws_solids(config)
    type(config_t), intent(in) :: config
    draws_solids = .not. wants_thin_wings(config) .or. wants_body(config)
  end function draws_solids

  subroutine read_output(c, fluid, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: fluid
    type(output_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    character(6) :: key
    integer :: i
    p%t_save = c%get_real('Saving', 'tsave')
    p%t_save_first = c%get_real('Saving', 'tsave_first')
    p%t_integral = c%get_real('Saving', 'tintegral')
    p%it_integral = c%get_integer('Saving', 'itdrag')
    p%velocity = c%get_switch('Saving', 'iSaveVelocity')
    p%pressure = c%get_switch('Saving', 'iSavePress')
    p%vorticity = c%get_switch('Saving', 'iSaveVorticity')
    p%vorticity_magnitude = c%get_switch('Saving', 'iSaveMagVorticity')
    p%q_criterion = c%get_switch('Saving', 'iSaveQ')
    p%spectra = c%get_switch('Saving', 'iSaveSpectrae')
    p%mask = c%get_switch('Saving', 'iSaveMask') .and. fluid%solids%is_on
    p%solid_velocity = c%get_switch('Saving', 'iSaveSolidVelocity') .and. fluid%solids%is_on
    p%wing_sides = c%get_switch('Saving', 'iSaveWingSides') .and. fluid%solids%is_moving
    p%single_precision = c%get_word('Saving', 'field_precision') == 'single'
    p%stride = c%get_integer('Saving', 'striding')
    p%naming = c%get_word('Saving', 'naming')
    p%one_period = c%get_switch('Saving', 'save_only_one_period')
    p%period = c%get_real('Saving', 'tsave_period')
    p%backup = c%get_switch('Saving', 'iDoBackup')
    p%limits%backup_seconds = 3600*c%get_real('Saving', 'truntime')
    call read_limits(c, p%limits, p%progress_seconds)
    p%mask_only = c%get_switch('DryRun', 'dry_run_without_fluid')
    p%slices = c%get_switch('SaveSlices', 'use_slicing')
    call read_average_keys(c, p%averages)
    p%it_slice = c%get_integer('SaveSlices', 'itslice')
    p%stack = c%get_integer('SaveSlices', 'ncache_slices')
    p%t_slice = c%get_real('SaveSlices', 'tslice')
    p%t_slice_first = c%get_real('SaveSlices', 'tslice_first')
    do i = 1, 4
      write (key, '(a,i1)') 'slice', i
      p%slice(i) = c%get_integer('SaveSlices', key)
      if (p%slices .and. p%slice(i) >= fluid%grid%n(1)) &
        call c%complain(errors, 'SaveSlices', key, 'there is no such plane: indices run from 0 to nx-1')
    end do
    if (p%slices .and. all(p%slice < 0)) &
      call c%complain(errors, 'SaveSlices', 'use_slicing', 'no slice is chosen: set slice1 to the x index of a plane')
    if (any(mod(fluid%grid%n, p%stride) /= 0 .and. fluid%grid%n > 1)) &
      call c%complain(errors, 'Saving', 'striding', 'must divide nx, ny and nz')
    if (p%mask_only) call leave_mask_only(c, fluid, p, errors)
  end subroutine read_output

  !> Drops what needs a flow.
  subroutine leave_mask_only(c, fluid, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: fluid
    type(output_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    p%velocity = .false.
    p%pressure = .false.
    p%vorticity = .false.
    p%vorticity_magnitude = .false.
    p%wing_sides = .false.
    p%slices = .false.
    p%averages%is_on = .false.
    p%backup = .false.
    if (.not. (p%mask .or. p%solid_velocity .or. fluid%solids%is_moving)) call c%complain(errors, 'DryRun', &
      'dry_run_without_fluid', 'there is nothing to draw; valid with [Penalization] iPenalization = 1 and [Saving] '// &
      'iSaveMask = 1')
    if (p%t_save > fluid%time%t_max .and. fluid%time%t_max > 0) p%t_save = fluid%time%t_max
  end subroutine leave_mask_only

  !> Settings that are allowed but do nothing.
  subroutine notice_idle_settings(s, notices)
    type(settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: notices
    associate (p => s%fluid, c => s%config)
      if (s%flight%thin%is_thin .and. .not. s%fluid%solids%is_on .and. c%get_switch('Saving', 'iSaveMask')) &
        call notices%add('[Insects] surface = thin: wings without thickness have no mask to save')
      if (.not. (p%solids%is_on .or. s%flight%thin%is_thin) .and. (c%get_switch('Saving', 'iSaveMask') .or. &
                                   c%get_switch('Saving', 'iSaveSolidVelocity'))) &
        call notices%add('iPenalization = 0: there is no mask to save')
      if (c%get_switch('Saving', 'iSaveWingSides') .and. .not. p%solids%is_moving) &
        call notices%add('[Saving] iSaveWingSides has no effect: there are no wings')
      if (p%solids%is_on .and. any(p%solids%mask == ['none ', 'empty']) .and. p%walls%channel == 'no' .and. &
          .not. p%walls%has_cavity) &
        call notices%add('iPenalization = 1, but there is no body and no wall; eps limits the time step all the same')
    end associate
  end subroutine notice_idle_settings

  !> The wings; moments of force are taken about the body's centre from now on, as in FLUSI.
  subroutine read_wings(s, name, errors, notices, world)
    type(settings_t), intent(inout) :: s
    character(*), intent(in) :: name
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(wing_case_t) :: wing_case
    logical :: has_file
    integer :: errors_before
    real(rp) :: metre, file_unit, unit
    metre = merge(1/s%units%length, 0.0_rp, s%units%given)
    file_unit = merge(s%units%length, 1.0_rp, s%units%si_input)
    has_file = .false.
    errors_before = errors%count()
    if (wants_wing_file(s%config)) then
      call read_wing_file(s%config, wing_case, has_file, errors, notices, world)
      call read_flight_params(s%config, name, s%fluid%grid, s%fluid%time%t_max, metre, file_unit, s%flight, errors, &
                              notices, world, wing_case%wing)
    else
      call read_flight_params(s%config, name, s%fluid%grid, s%fluid%time%t_max, metre, file_unit, s%flight, errors, &
                              notices, world)
    end if
    if (s%units%given .and. errors%count() == errors_before) then
      call check_scale(s%config, s%flight, s%units%length, errors)
      if (errors%count() > errors_before) return ! all that follows would be wrong by the same factor
    end if
    s%flexible = has_file .and. wants_flexible(s%config)
    if (wants_flexible(s%config)) call read_coupler(s%config, wing_case, has_file, s%flight, s%fluid%grid, s%fluid%time%t_max, &
                                                    s%units%scales(), s%units%given, s%coupler, errors, notices)
    call check_free_flight(s%config, wing_case, has_file, s%flexible, s%units%scales(), s%units%given, s%fluid, s%flight, &
                           s%coupler, errors, notices)
    call check_place(s%config, s%flight, s%fluid%grid, errors)
    if (errors%count() == errors_before) call check_room(s%config, s%flight, s%fluid%grid, s%fluid%time%t_max, errors)
    if (errors%count() == errors_before) call foresee_flight(s%config, s%flight, s%fluid%grid, &
                                                             s%fluid%time%t_max, s%flexible, errors, notices)
    if (s%units%given) call notice_frequency(s%config, s%units%frequency, notices)
    unit = merge(s%units%length**2*s%units%frequency, 0.0_rp, s%units%given .and. .not. s%units%si_input)
    if (errors%count() == errors_before) call notice_flow(s%config, s%fluid, s%flight, unit, notices)
    s%fluid%solids%centre = s%flight%body%centre
    if (s%config%get_word('Insects', 'surface') == 'auto') call s%config%settle('Insects', 'surface', &
      trim(merge('thin     ', 'penalized', s%flight%thin%is_thin)), 'auto')
    if (.not. s%fluid%solids%is_on) s%output%mask = .false.
    if (.not. s%fluid%solids%is_on) s%output%solid_velocity = .false.
    if (s%flight%thin%is_thin .and. errors%count() == errors_before) &
      call prepare_thin_flow(s%config, s%flight%thin, s%flight%tip_speed() + norm2(s%fluid%mean%velocity) + &
                             s%flight%motion%mean_speed(), s%fluid, errors, notices)
  end subroutine read_wings

  !> The SI values of the units; with input = SI all numbers of the file are read in SI units.
  subroutine read_units(c, units, errors, notices)
    type(config_t), intent(inout) :: c
    type(units_t), intent(inout) :: units
    type(message_list_t), intent(inout) :: errors, notices
    units%length = c%get_real('units', 'length')
    units%frequency = c%get_real('units', 'frequency')
    units%density = c%get_real('units', 'density')
    units%si_input = c%get_word('units', 'input') == 'SI'
    call check_units_together(c, units%given, errors)
    if (units%si_input) then
      call c%set_units(units%scales())
    else if (.not. units%given) then
      call notices%add('no [units] section: all quantities are dimensionless, fluid density 1')
    end if
  end subroutine read_units

  !> SI values of the units in one line for the head of files; empty if they were not given.
  function units_note(self) result(text)
    class(units_t), intent(in) :: self
    character(:), allocatable :: text
    character(200) :: line
    text = ''
    if (.not. self%given) return
    associate (u => self)
      write (line, '(5(a,es12.5),a)') 'units: L =', u%length, ' m, 1/T =', u%frequency, ' 1/s, rho =', u%density, &
        ' kg/m^3, force rho L^4/T^2 =', u%density*u%length**4*u%frequency**2, ' N, power rho L^5/T^3 =', &
        u%density*u%length**5*u%frequency**3, ' W'
    end associate
    text = trim(line)
  end function units_note

  !> SI values of one L, T and M.
  pure type(unit_scales_t) function units_scales(self) result(scales)
    class(units_t), intent(in) :: self
    scales = unit_scales_t(self%length, 1/self%frequency, self%density*self%length**3)
  end function units_scales

  !> Whether any output needs velocity or vorticity in physical space.
  pure logical function output_needs_fields(self) result(needs)
    class(output_params_t), intent(in) :: self
    needs = self%slices .or. self%averages%is_on
  end function output_needs_fields

  !> Whether any output looks at one field of velocity or vorticity after the other.
  pure logical function output_needs_flow(self) result(needs)
    class(output_params_t), intent(in) :: self
    needs = self%velocity .or. self%vorticity .or. self%vorticity_magnitude .or. self%wing_sides
  end function output_needs_flow

  !> How many fields of nx points the output keeps: sums of means over time, and stacked slices.
  pure real(rp) function output_held_fields(self, nx) result(n)
    class(output_params_t), intent(in) :: self
    integer, intent(in) :: nx
    n = self%averages%n_fields()
    if (self%slices .and. self%stack > 1) n = n + 3*count(self%slice >= 0)*real(self%stack, rp)/nx
  end function output_held_fields

  !> Whether any output needs room to make a field.
  pure logical function output_needs_scratch(self) result(needs)
    class(output_params_t), intent(in) :: self
    needs = self%needs_fields() .or. self%needs_flow() .or. self%pressure .or. self%mask .or. self%solid_velocity .or. &
            self%q_criterion
  end function output_needs_scratch

  !> Whether any pass will be asked for velocity or vorticity in physical space.
  pure logical function settings_needs_fields(self) result(needs)
    class(settings_t), intent(in) :: self
    needs = self%output%needs_fields() .or. (self%samples_pressure() .and. self%coupler%needs_fields())
  end function settings_needs_fields

  !> Whether the coupling will make trials of the flow.
  pure logical function settings_needs_trials(self) result(needs)
    class(settings_t), intent(in) :: self
    needs = self%samples_pressure() .and. self%coupler%needs_trials()
  end function settings_needs_trials

  !> Whether any pass will be asked for the pressure.
  pure logical function settings_needs_pressure(self) result(needs)
    class(settings_t), intent(in) :: self
    needs = self%output%pressure .or. self%output%wing_sides .or. self%samples_pressure()
  end function settings_needs_pressure

  !> Whether the load that bends the wings is that of the pressure beside them.
  pure logical function settings_samples_pressure(self) result(looks)
    class(settings_t), intent(in) :: self
    looks = self%flexible .and. .not. self%flight%thin%is_thin
  end function settings_samples_pressure
end module flusi_settings

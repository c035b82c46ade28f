! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds everything that the user set in all sections, with notices on what the program assumed.
module simulation_settings
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fluid_params, only: fluid_params_t, read_fluid_params
  use fluid_solid_keys, only: CHANNEL_NONE, MASK_EMPTY, MASK_NONE
  use fsi_body_keys, only: wants_body
  use fsi_coupler_params, only: coupler_params_t
  use fsi_flight_checks, only: check_place, check_room
  use fsi_flight_params, only: flight_params_t, read_flight_params
  use fsi_scene, only: scene_t
  use fsi_thin_keys, only: prepare_thin_flow, surface_choice, wants_thin_wings, SURFACE_AUTO
  use io_config, only: config_t
  use io_registry, only: registry_t
  use parallel_world, only: world_t
  use simulation_flexible, only: read_coupling, read_wing_file, set_mechanics, wants_flexible, wants_wing_file
  use fsi_flight_faults, only: foresee_flight
  use simulation_free_flight, only: check_free_flight, take_masses
  use simulation_keys, only: register_all_keys
  use simulation_landmarks, only: mark_wings
  use simulation_output_params, only: output_params_t, read_output, wanted_output
  use simulation_setting_checks, only: check_scale, check_si_numbers, check_wing_use, notice_flow, notice_frequency
  use simulation_translations, only: translate_words
  use simulation_units, only: read_units, units_t
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: settings_t, load_settings

  !> Holds the settings of a run, read and checked.
  type :: settings_t
    type(fluid_params_t) :: fluid
    type(flight_params_t) :: flight   !< set if fluid%solids%is_moving
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

  !> Reads the parameter `text`, which is the same on every rank, and the files that it names. Adds all mistakes to `errors` and
  !> all remarks to `notices`. If `world` is present, root reads these files for all ranks and the call is collective.
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
    ! Keys with mistakes hold their defaults, so that mistakes between keys are found at the same time.
    call read_units(settings%config, settings%units, errors, notices)
    call translate_words(settings%config, notices)
    call read_fluid_params(settings%config, settings%fluid, errors, draws_solids(settings%config), &
                           notices)
    if (settings%units%si_input) call check_si_numbers(settings%config, settings%fluid, errors)
    call check_wing_use(settings%config, settings%fluid%solids%is_moving, errors)
    call read_output(settings%config, settings%fluid, settings%output, errors)
    if (settings%output%mask_only) settings%fluid%solids%compute_forces = .false.
    if (settings%fluid%solids%is_moving) call read_wings(settings, errors, notices, world)
    call notice_idle_settings(settings, notices)
  end subroutine load_settings

  !> Tells whether a moving solid is in the mask.
  logical function draws_solids(config)
    type(config_t), intent(in) :: config
    draws_solids = .not. wants_thin_wings(config) .or. wants_body(config)
  end function draws_solids

  !> Adds a notice for each setting that is allowed but has no effect.
  subroutine notice_idle_settings(s, notices)
    type(settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: notices
    type(output_params_t) :: wanted
    wanted = wanted_output(s%config)
    associate (p => s%fluid)
      if (s%flight%thin%is_thin .and. .not. s%fluid%solids%is_on .and. wanted%fields%mask) &
        call notices%add('[Insects] surface = thin: wings without thickness have no mask to save')
      if (.not. (p%solids%is_on .or. s%flight%thin%is_thin) .and. (wanted%fields%mask .or. wanted%fields%solid_velocity)) &
        call notices%add('iPenalization = 0: there is no mask to save')
      if (.not. p%solids%is_moving .and. size(wanted%landmarks(1)%rows) + size(wanted%landmarks(2)%rows) > 0) &
        call notices%add('[Saving] landmarks_left and landmarks_right have no effect: there are no wings')
      if (wanted%fields%wing_sides .and. .not. p%solids%is_moving) &
        call notices%add('[Saving] iSaveWingSides has no effect: there are no wings')
      if (p%solids%is_on .and. any(p%solids%mask == [MASK_NONE, MASK_EMPTY]) .and. p%walls%channel == CHANNEL_NONE .and. &
          .not. p%walls%has_cavity) &
        call notices%add('iPenalization = 1, but there is no body and no wall; eps still limits the time step')
    end associate
  end subroutine notice_idle_settings

  !> Reads the wings. From here on, moments of force are taken about the centre of the body, as in FLUSI.
  subroutine read_wings(s, errors, notices, world)
    type(settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    type(wing_case_t) :: wing_case
    type(scene_t) :: scene
    logical :: has_file
    integer :: errors_before
    real(rp) :: unit
    scene = scene_t(s%fluid%grid, s%fluid%time%t_max, merge(1/s%units%length, 0.0_rp, s%units%given), &
                    merge(s%units%length, 1.0_rp, s%units%si_input))
    has_file = .false.
    errors_before = errors%count()
    if (wants_wing_file(s%config)) then
      call read_wing_file(s%config, wing_case, has_file, errors, notices, world)
      call read_flight_params(s%config, scene, s%flight, errors, notices, world, wing_case%wing)
    else
      call read_flight_params(s%config, scene, s%flight, errors, notices, world)
    end if
    if (s%units%given .and. errors%count() == errors_before) then
      call check_scale(s%config, s%flight, s%units%length, errors)
      if (errors%count() > errors_before) return ! all following checks would be wrong by the same factor
    end if
    s%flexible = has_file .and. wants_flexible(s%config)
    if (wants_flexible(s%config)) then
      call read_coupling(s%config, s%units, s%flight, s%fluid, s%coupler, errors, notices)
      if (has_file .and. s%units%given .and. wing_case%has_mass) &
        call set_mechanics(s%config, wing_case, s%fluid%grid, s%units%scales(), s%coupler)
      if (s%coupler%inertia%drag > 0) &
        call notices%add('[Damping] drag acts on the wings in addition to the drag of the simulated flow: set it to 0 here')
    end if
    if (has_file .and. .not. s%flexible .and. wing_case%has_mass .and. s%units%given) &
      call take_masses(wing_case, s%units%scales(), s%flight)
    call check_free_flight(s%config, s%units%scales(), s%flexible, s%fluid, s%flight, s%coupler, errors, notices)
    if (errors%count() == errors_before) call mark_wings(s%config, scene%file_unit, s%output, s%flight, errors)
    call check_place(s%config, s%flight, s%fluid%grid, errors)
    if (errors%count() == errors_before) call check_room(s%config, s%flight, s%fluid%grid, s%fluid%time%t_max, errors)
    if (errors%count() == errors_before) call foresee_flight(s%config, s%flight, s%fluid%grid, &
                                                             s%fluid%time%t_max, s%flexible, errors, notices)
    if (s%units%given) call notice_frequency(s%flight%frequency(), s%units%frequency, notices)
    unit = merge(s%units%length**2*s%units%frequency, 0.0_rp, s%units%given .and. .not. s%units%si_input)
    if (errors%count() == errors_before) call notice_flow(s%config, s%fluid, s%flight, unit, notices)
    s%fluid%solids%centre = s%flight%body%centre
    if (surface_choice(s%config) == SURFACE_AUTO) call s%config%settle('Insects', 'surface', &
      trim(merge('thin     ', 'penalized', s%flight%thin%is_thin)), 'auto')
    if (.not. s%fluid%solids%is_on) s%output%fields%mask = .false.
    if (.not. s%fluid%solids%is_on) s%output%fields%solid_velocity = .false.
    if (s%flight%thin%is_thin .and. errors%count() == errors_before) &
      call prepare_thin_flow(s%config, s%flight%thin, s%flight%tip_speed() + norm2(s%fluid%mean%velocity) + &
                             s%flight%motion%mean_speed(), s%fluid, errors, notices)
  end subroutine read_wings

  !> Tells whether any pass must provide velocity or vorticity in physical space.
  pure logical function settings_needs_fields(self) result(needs)
    class(settings_t), intent(in) :: self
    needs = self%output%needs_fields() .or. (self%samples_pressure() .and. self%coupler%needs_fields())
  end function settings_needs_fields

  !> Tells whether the coupling repeats steps of the flow as trials.
  pure logical function settings_needs_trials(self) result(needs)
    class(settings_t), intent(in) :: self
    needs = self%samples_pressure() .and. self%coupler%needs_trials()
  end function settings_needs_trials

  !> Tells whether any pass must provide the pressure.
  pure logical function settings_needs_pressure(self) result(needs)
    class(settings_t), intent(in) :: self
    needs = self%output%fields%pressure .or. self%output%fields%wing_sides .or. self%samples_pressure()
  end function settings_needs_pressure

  !> Tells whether the pressure beside the wings gives the load that bends them.
  pure logical function settings_samples_pressure(self) result(samples)
    class(settings_t), intent(in) :: self
    samples = self%flexible .and. .not. self%flight%thin%is_thin
  end function settings_samples_pressure
end module simulation_settings

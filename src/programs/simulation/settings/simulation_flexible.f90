! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the keys of flexible wings in the flow, and makes from them the mechanics that the coupler needs.
module simulation_flexible
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t, word_of
  use base_text, only: number_text
  use common_wing_effects, only: refuse_root_compliance
  use common_wing_keys, only: read_wing_keys, register_damping_keys, register_wing_keys, wing_choices_t
  use common_wing_settings, only: load_wing, read_damping
  use fluid_params, only: fluid_params_t
  use fsi_added_mass, only: added_mass_ratio, light_layer
  use fsi_coupler_params, only: coupler_params_t, COUPLING_EXTRAPOLATED, COUPLING_STRONG, COUPLING_WEAK
  use fsi_flight_params, only: flapping_wing_t, flight_params_t
  use fsi_rotation, only: angle_t
  use fsi_wing_shape, only: SPAN, wing_shape_t
  use fsi_wing_source, only: source_choices, source_choices_t, SOURCE_NONE
  use fsi_wings_key, only: has_flexible_wings, says_rigid_wings
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  use io_units, only: unit_scales_t
  use parallel_world, only: world_t
  use simulation_units, only: units_t
  use solid_wing_case, only: wing_case_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: register_flexible_keys, stated_coupling, wants_flexible, wants_wing_file, read_wing_file, read_coupling, set_mechanics

  character(*), parameter :: F = 'Flexible_wing', DISTANCE = 'load_distance'
  real(rp), parameter :: FLAT = 1.0e-9_rp

  !> What bends the wings.
  integer, parameter :: LOAD_PRESSURE = 1, LOAD_VISCOUS = 2
  type(named_kind_t), parameter :: LOADS(2) = [named_kind_t('pressure', LOAD_PRESSURE), &
                                               named_kind_t('pressure_viscous', LOAD_VISCOUS)]
  type(named_kind_t), parameter :: COUPLINGS(3) = [named_kind_t('weak', COUPLING_WEAK), &
                                                   named_kind_t('extrapolated', COUPLING_EXTRAPOLATED), &
                                                   named_kind_t('strong', COUPLING_STRONG)]

  !> Holds those keys of [Flexible_wing] that coupler_params_t does not hold.
  type :: coupling_choices_t
    logical :: asks = .false., says = .false.  !< for flexible wings, by FLUSI's name; whether the key is there
    integer :: load = LOAD_PRESSURE
    logical :: has_coupling = .false., has_distance = .false., has_load = .false., has_extrapolated = .false.
    logical :: has_tolerance = .false., has_iterations = .false., has_gravity = .false.
  end type coupling_choices_t

contains

  !> Adds [Wing], [Mass], [Damping] and the coupling keys of [Flexible_wing] to `registry`.
  subroutine register_flexible_keys(registry)
    type(registry_t), intent(inout), target :: registry
    type(coupling_choices_t) :: choices
    type(coupler_params_t) :: params
    type(keys_t) :: keys
    keys = declaring(registry)
    call coupling_keys(keys, choices, params)
    call register_wing_keys(registry, required=.false.)
    call register_damping_keys(registry)
  end subroutine register_flexible_keys

  !> Visits the keys that couple wings and flow.
  subroutine coupling_keys(keys, c, p)
    type(keys_t), intent(inout) :: keys
    type(coupling_choices_t), intent(inout) :: c
    type(coupler_params_t), intent(inout) :: p
    real(rp), parameter :: ZERO(3) = 0.0_rp
    call keys%section(F)
    call keys%switch('use_flexible_wing_model', c%asks, .false., 'FLUSI''s name for [Insects] wings = flexible', &
                     computed='as [Insects] wings says', given=c%says)
    call keys%length('load_distance', p%distance, 't_wing + wing_smoothing + max(dx)', 'distance from the mid surface at '// &
                     'which the flow is sampled on both sides', unit='L', above=0.0_rp, given=c%has_distance)
    call keys%kind('load', c%load, 'pressure', LOADS, 'what bends the wings: the pressure on both sides, '// &
                   'or the viscous traction as well', given=c%has_load)
    call keys%switch('load_extrapolated', p%extrapolates, .false., 'the pressure difference is also sampled at twice the '// &
                     'distance, and extrapolated linearly to the mid surface', given=c%has_extrapolated)
    call keys%kind('coupling', p%coupling, 'weak', COUPLINGS, 'load on the wings during a step; weak: the load at its '// &
                   'beginning; extrapolated: the load extrapolated to its end; strong: the load at its end, found by '// &
                   'sub-iterations', given=c%has_coupling)
    call keys%real('coupling_tolerance', p%tolerance, 1.0e-3_rp, 'strong: largest relative change of the load in the last '// &
                   'sub-iteration', above=0.0_rp, given=c%has_tolerance)
    call keys%integer('coupling_iterations', p%iterations, 20, 'strong: largest number of evaluations of the flow in a step; '// &
                      'the run stops if they are not enough', min=1, given=c%has_iterations)
    call keys%real('T_release', p%release, 0.0_rp, 'the wings are held rigid until this time', unit='T', min=0.0_rp)
    call keys%real('largest_deflection', p%largest_deflection, 1.0_rp, 'the run stops if a point is deflected by more than '// &
                   'this, in wing lengths', &
                   above=0.0_rp)
    call keys%reals('gravity', p%gravity, ZERO, 'acceleration of gravity on the wings, in the axes of the flow', unit='m/s^2', &
                    given=c%has_gravity)
  end subroutine coupling_keys

  !> Tells whether the wings of this run bend: either [Insects] or a key of [Flexible_wing] asks for it.
  logical function wants_flexible(config)
    type(config_t), intent(in) :: config
    type(coupling_choices_t) :: c
    type(coupler_params_t) :: unused
    call read_coupling_keys(config, c, unused)
    wants_flexible = has_flexible_wings(config) .or. c%asks
  end function wants_flexible

  !> Returns the word of [Flexible_wing] for the coupling that the user gives, or for `otherwise`, COUPLING_*, if there is none.
  function stated_coupling(config, otherwise) result(word)
    type(config_t), intent(in) :: config
    integer, intent(in) :: otherwise
    character(:), allocatable :: word
    type(coupling_choices_t) :: c
    type(coupler_params_t) :: p
    call read_coupling_keys(config, c, p)
    word = word_of(COUPLINGS, merge(p%coupling, otherwise, c%has_coupling))
  end function stated_coupling

  !> Reads the keys that couple wings and flow.
  subroutine read_coupling_keys(config, c, p)
    type(config_t), intent(in), target :: config
    type(coupling_choices_t), intent(inout) :: c
    type(coupler_params_t), intent(inout) :: p
    type(keys_t) :: keys
    keys = reading(config)
    call coupling_keys(keys, c, p)
  end subroutine read_coupling_keys

  !> Tells whether the wings take their shape from [Wing] file. Flexible wings do, and so do rigid wings for which WingShape
  !> gives no shape.
  logical function wants_wing_file(config)
    type(config_t), intent(in) :: config
    type(source_choices_t) :: source
    type(wing_choices_t) :: wing
    source = source_choices(config)
    call read_wing_keys(config, wing)
    wants_wing_file = wants_flexible(config) .or. &
                      (source%source == SOURCE_NONE .and. wing%has_file)
  end function wants_wing_file

  !> Adds to `errors` every input that contradicts flexible wings. `has_file` tells whether [Wing] names a file.
  subroutine check_flexible(config, errors, has_file)
    type(config_t), intent(in) :: config
    type(message_list_t), intent(inout) :: errors
    logical, intent(out) :: has_file
    type(coupling_choices_t) :: c
    type(coupler_params_t) :: unused
    type(source_choices_t) :: source
    type(wing_choices_t) :: wing
    call read_coupling_keys(config, c, unused)
    source = source_choices(config)
    call read_wing_keys(config, wing)
    has_file = wing%has_file
    if (says_rigid_wings(config)) &
      call config%complain(errors, 'Insects', 'wings', 'contradicts [Flexible_wing] use_flexible_wing_model = yes')
    if (source%source /= SOURCE_NONE) call config%complain(errors, 'Insects', 'WingShape', &
                                       'contradicts wings = flexible, which have the shape of [Wing] file; valid: none')
    if (c%says .and. .not. c%asks) &
      call config%complain(errors, F, 'use_flexible_wing_model', 'contradicts [Insects] wings = flexible')
    if (source%length > 0) call config%complain(errors, 'Insects', 'wing_length', &
                                            'contradicts wings = flexible, whose file is in metres; set [units] length')
    if (.not. has_file) &
      call config%complain(errors, 'Wing', 'file', 'is missing: wings = flexible need a wing file; take one of the folder '// &
                           'wings, or make one from a drawing with tools/make_wing, or from FLUSI''s *.dat files, which '// &
                           'state neither unit nor diameters: tools/import_flusi_mesh . wing.h5 '// &
                           '--unit METRES --root-vein D_ROOT D_TIP --vein D_ROOT D_TIP; '// &
                           'then [Wing] file = wing.h5, [units] length, frequency, density')
  end subroutine check_flexible

  !> Reads [Wing] and the file that it names. `found` tells whether the result is a wing that a flow can use: it has triangles,
  !> and a wing that bends is flat. Adds mistakes to `errors` and remarks to `notices`. Collective if `world` is present.
  subroutine read_wing_file(config, wing_case, found, errors, notices, world)
    type(config_t), intent(in) :: config
    type(wing_case_t), intent(out) :: wing_case
    logical, intent(out) :: found
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world
    found = .false.
    if (wants_flexible(config)) then
      call check_flexible(config, errors, found)
      if (.not. found) return
    end if
    call load_wing(config, wants_flexible(config), wing_case, found, errors, notices, world)
    if (.not. found) return
    if (size(wing_case%wing%triangles) == 0) then
      call config%complain(errors, 'Wing', 'file', 'has no triangles: a flow needs a surface')
      found = .false.
    end if
    if (.not. found .or. .not. wants_flexible(config)) return
    call refuse_root_compliance(config, wing_case%requested, errors)
    ! Curvatures, places and sections are those of a wing in this plane.
    if (any(abs(wing_case%wing%points(3, :)) > FLAT*wing_case%model%size)) then
      call config%complain(errors, 'Wing', 'file', 'is not flat in the plane z = 0, as wings = flexible need it')
      found = .false.
    end if
  end subroutine read_wing_file

  !> Reads the keys of the coupling into `params`. Adds mistakes to `errors` and remarks to `notices`. It also works without a
  !> readable wing, so that the user sees mistakes of the coupling and of the wing at the same time.
  subroutine read_coupling(config, units, flight, fluid, params, errors, notices)
    type(config_t), intent(in) :: config
    type(units_t), intent(in) :: units
    type(flight_params_t), intent(in) :: flight
    type(fluid_params_t), intent(in) :: fluid
    type(coupler_params_t), intent(out) :: params
    type(message_list_t), intent(inout) :: errors, notices
    type(coupling_choices_t) :: c
    ! An incomplete [units] is reported elsewhere.
    if (.not. any(units%has)) &
      call config%complain(errors, 'units', 'length', 'is missing: the mechanics of the wings is in SI units; set length, '// &
                           'frequency and density in [units]')
    params%distance = flight%half_thickness + flight%smoothing + fluid%grid%max_spacing()
    call read_coupling_keys(config, c, params)
    params%states_gravity = c%has_gravity
    params%friction = c%load == LOAD_VISCOUS
    if (params%coupling /= COUPLING_STRONG .and. (c%has_tolerance .or. c%has_iterations)) &
      call notices%add('[Flexible_wing] coupling_tolerance and coupling_iterations have no effect without '// &
                       'coupling = strong')
    if (flight%thin%is_thin) call notice_pressure_keys([c%has_distance, c%has_load, c%has_extrapolated], notices)
    if (params%release >= fluid%time%t_max) &
      call notices%add('[Flexible_wing] T_release is not before Tmax: the wings are rigid during the whole run')
    if (params%distance < flight%half_thickness + flight%smoothing) &
      call config%complain(errors, F, DISTANCE, 'lies inside the smoothing layer of the mask; valid: at least '// &
                           't_wing + wing_smoothing')
    call check_wings(config, flight, params, errors, notices)
  end subroutine read_coupling

  !> Checks what the coupling requires of the wings, if there are any with units.
  subroutine check_wings(config, flight, params, errors, notices)
    type(config_t), intent(in) :: config
    type(flight_params_t), intent(in) :: flight
    type(coupler_params_t), intent(in) :: params
    type(message_list_t), intent(inout) :: errors, notices
    if (size(flight%wings) == 0) return
    if (size(flight%wings(1)%points) == 0) return
    if (.not. flight%wings(1)%length() > 0) return ! without units
    call notice_sections(flight%wings(1), notices)
    if (.not. params%release > 0) call notice_start(flight%wings, notices)
    if (merge(2, 1, params%extrapolates)*params%distance > flight%wings(1)%length()) &
      call config%complain(errors, F, DISTANCE, &
                           'is more than the length of the wing, '//number_text(flight%wings(1)%length())// &
                           ': the pressure there differs from the pressure on the wing')
  end subroutine check_wings

  !> Sets those parts of `params` that come from the wing: its model, its inertia and damping, and the mass of fluid that it
  !> carries along. `units` gives one L, T and M in SI units.
  subroutine set_mechanics(config, wing_case, grid, units, params)
    type(config_t), intent(in) :: config
    type(wing_case_t), intent(in) :: wing_case
    type(grid_t), intent(in) :: grid
    type(unit_scales_t), intent(in) :: units
    type(coupler_params_t), intent(inout) :: params
    real(rp), allocatable :: span_chord(:, :)
    params%model = wing_case%model
    call params%inertia%init(wing_case%model, wing_case%mass%nodal)
    call read_damping(config, wing_case%model, params%inertia)
    params%membrane = 0
    if (wing_case%mass%area > 0) params%membrane = wing_case%mass%membrane/wing_case%mass%area
    params%density = wing_case%material%vein_density
    params%units = units
    ! A plane flow runs along the length of the sheet, whose width is the depth that has no end.
    span_chord = wing_case%wing%points(:2, :)
    if (grid%is_2d) span_chord = span_chord([2, 1], :)
    params%added_mass = added_mass_ratio(span_chord, wing_case%wing%triangles, wing_case%mass%nodal, units%mass/units%length**3)
    params%light_layer = light_layer(wing_case%wing%points, wing_case%wing%triangles, wing_case%mass%nodal)
  end subroutine set_mechanics

  !> Adds remarks on keys for the pressure next to the wings, which wings without thickness do not need.
  subroutine notice_pressure_keys(given, notices)
    logical, intent(in) :: given(3) !< which of them the user gives
    type(message_list_t), intent(inout) :: notices
    character(17), parameter :: NAMES(3) = [character(17) :: DISTANCE, 'load', 'load_extrapolated']
    integer :: i
    do i = 1, size(NAMES)
      if (given(i)) call notices%add('[Flexible_wing] '//trim(NAMES(i))//' has no effect '// &
                                     'with [Insects] surface = thin: the forces of the markers are the whole load')
    end do
  end subroutine notice_pressure_keys

  !> Adds a remark if flexible wings move at full speed from the first step on: the sudden start makes them vibrate.
  subroutine notice_start(wings, notices)
    type(flapping_wing_t), intent(in) :: wings(:)
    type(message_list_t), intent(inout) :: notices
    type(angle_t) :: phi, alpha, theta
    integer :: i
    do i = 1, size(wings)
      call wings(i)%motion%evaluate(0.0_rp, phi, alpha, theta)
      if (.not. maxval(abs([phi%rate, alpha%rate, theta%rate])) > 0) cycle
      call notices%add('[Insects] wing_ramp is 0, and the flexible wings move at t = 0: they start with a shock; wing_ramp of '// &
                       'a quarter of a beat starts them smoothly')
      return
    end do
  end subroutine notice_start

  !> Adds remarks on sections for output that lie outside the wing.
  subroutine notice_sections(wing, notices)
    type(flapping_wing_t), intent(in) :: wing
    type(message_list_t), intent(inout) :: notices
    type(wing_shape_t) :: shape
    integer :: i
    call shape%init(wing%points, wing%triangles, SPAN, 1.0_rp)
    do i = 1, size(SPAN)
      if (shape%has(i)) cycle
      call notices%add('the wing has no section at '//number_text(nint(100*SPAN(i)))//' % of its span: its triangles '// &
                       'reach from '//number_text(minval(wing%points(1, :)))//' to '// &
                       number_text(maxval(wing%points(1, :)))//' L; trailing edge, twist and camber there are 0 in '// &
                       'bending_*.t')
    end do
  end subroutine notice_sections
end module simulation_flexible

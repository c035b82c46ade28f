! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the catalogue of what a simulation of a bending test may lack. It has one entry for each effect: a sentence for people,
!> the parameters that the effect releases, the sites where the diagnosis tries it, and the data that it needs to be visible.
module diagnosis_wing_catalogue
  use base_kinds, only: rp
  use base_parameter, only: define_parameter, parameter_t
  use diagnosis_flight_catalogue, only: enter_flights
  use diagnosis_wing_entries, only: append_variant, catalogue_t, enter_instrument, enter_named, millimetres, percent
  use diagnosis_wing_damping, only: add_damping, enter_damping
  use diagnosis_wing_flight, only: flight_data_t
  use diagnosis_wing_inertia, only: add_air, enter_inertia
  use diagnosis_wing_lattice, only: lattice
  use diagnosis_wing_needs, only: missing_of, needs_holds, needs_levels, needs_mass, needs_membrane, &
                                  needs_small_deflections
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_DAMAGE, KIND_SOFT, KIND_ZERO
  use inference_simulator, only: variant_t
  use measurement_experiment, only: experiment_t
  use measurement_instrument, only: CREEP, DRIFT, DRIFT_RATE, FORCE_GAIN, FORCE_OFFSET, FORCE_TILT_X, FORCE_TILT_Y, &
                                    GRAVITY_X, GRAVITY_Y, GRAVITY_Z, HEIGHT_SCALE, LOAD_SHIFT_X, LOAD_SHIFT_Y, &
                                    MAP_ROTATION, MAP_SCALE, MAP_SHIFT_X, MAP_SHIFT_Y, NONLINEARITY, PISTON, TILT_X, &
                                    TILT_Y
  use solid_effect, only: effect_t, effect_text_t, NEED_DISC, NEED_SOFT_PLACE
  use solid_effects, only: list_effects
  use solid_layout, only: hinge_in_vein
  use solid_wing, only: wing_t
  implicit none
  private
  public :: catalogue_t, make_catalogue

  real(rp), parameter :: DECADE = 2.302585092994046_rp
  real(rp), parameter :: DAMAGE_RADIUS = 0.1_rp, DAMAGE_SPACING = 0.12_rp !< of the wing's size
  !> The same for finer scans where damage was found.
  real(rp), parameter :: FINER_RADII(3) = [0.06_rp, 0.085_rp, 0.12_rp], FINER_SPACING = 0.05_rp

contains

  !> Makes the catalogue for an experiment without unknowns on `wing`. The baseline seeks the parameters of these
  !> numbers, with `decades` as sd of their priors.
  subroutine make_catalogue(experiment, wing, numbers, decades, catalogue, flights)
    type(experiment_t), intent(in) :: experiment
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: numbers(:)
    real(rp), intent(in) :: decades
    type(catalogue_t), intent(out) :: catalogue
    type(flight_data_t), intent(in), optional :: flights !< of records of forces over the beat
    type(parameter_t) :: p
    integer :: i, n
    allocate (catalogue%parameters(0), catalogue%effects(0))
    do i = 1, size(numbers)
      n = catalogue%add_parameter(experiment, numbers(i))
      catalogue%parameters(n)%prior_sd = decades*DECADE
      if (.not. catalogue%parameters(n)%is_log) catalogue%parameters(n)%prior_sd = decades
    end do
    call add_air(catalogue, experiment)
    call add_damping(catalogue, experiment)
    do i = 1, size(experiment%measurement%zeros)
      call define_parameter(p, 'zero:'//trim(experiment%measurement%zeros(i)), 'm', .false., -experiment%model%size, &
                            experiment%model%size)
      n = catalogue%add(wing_parameter(p, KIND_ZERO, i))
    end do
    catalogue%n_baseline = size(catalogue%parameters)
    if (present(flights)) then
      if (flights%has_records) call enter_flights(catalogue, flights%facts, experiment%measurement%flights, flights%effects)
      ! Nothing else is seen in forces on a wing whose motion is prescribed.
      if (flights%has_records .and. size(experiment%loads) == 0 .and. .not. experiment%measurement%moves()) return
    end if
    call enter_structure(catalogue, experiment, numbers)
    call enter_scans(catalogue, experiment, wing)
    call enter_inertia(catalogue, experiment, wing)
    call enter_damping(catalogue, experiment)
    call enter_measurement(catalogue, experiment)
  end subroutine make_catalogue

  !> Enters parameters of the wing that the baseline does not seek already: those that every wing has, and its effects, in the
  !> order of CAUSES and then in that of the list of effects.
  subroutine enter_structure(c, e, numbers)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    character(20), parameter :: CAUSES(15) = &
                                [character(20) :: 'root_compliance', 'root_stiffness', 'E_gradient', 'E_per_vein', 'taper', &
                                 'membrane_bending', 'elasticity', 'orthotropy', 'pretension', 'camber', 'vein_torsion', &
                                 'joint_hardening', 'one_joint_hardening', 'one_way_joint', 'cuticle']
    type(effect_t), allocatable :: list(:)
    type(effect_text_t) :: text
    integer :: k, i
    list = list_effects()
    do k = 1, size(CAUSES)
      call enter_general(c, e, numbers, trim(CAUSES(k)))
      do i = 1, size(list)
        call list(i)%tell(text)
        if (text%cause == CAUSES(k)) call enter_effect(c, e, numbers, list(i), text)
      end do
    end do
    do i = 1, size(list)
      call list(i)%tell(text)
      if (all(CAUSES /= text%cause) .and. .not. is_scanned(list(i))) call enter_effect(c, e, numbers, list(i), text)
    end do
  end subroutine enter_structure

  !> Tells whether an effect is tried at many places: see `enter_scans`.
  pure logical function is_scanned(effect)
    type(effect_t), intent(in) :: effect
    is_scanned = any(effect%needs == NEED_DISC .or. effect%needs == NEED_SOFT_PLACE)
  end function is_scanned

  !> Enters an effect: its parameters together, or those of joints one after another.
  subroutine enter_effect(c, e, numbers, effect, text)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    type(effect_t), intent(in) :: effect
    type(effect_text_t), intent(in) :: text
    character(len(effect%parameters%name) + 1) :: names(effect%n)
    names = effect%parameters(:effect%n)%name
    if (effect%is_per_joint) names(1) = trim(names(1))//'*'
    call enter_named(c, e, numbers, text, names, is_joint=.not. effect%is_per_joint, missing=missing_of(e, effect%needs))
  end subroutine enter_effect

  !> Enters the effect called `cause` if it belongs to parameters that every wing has.
  subroutine enter_general(c, e, numbers, cause)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    character(*), intent(in) :: cause
    type(effect_text_t) :: text
    text%cause = cause
    select case (cause)
    case ('root_stiffness')
      text%title = 'root of another stiffness'
      text%sentence = 'The veins bend more or less easily where the wing is clamped.'
      call enter_named(c, e, numbers, text, [character(20) :: 'root'], .true., '')
    case ('E_per_vein')
      text%title = 'a vein of another material'
      text%sentence = 'One vein is softer or stiffer than the others.'
      call enter_named(c, e, numbers, text, [character(20) :: 'E:*'], .false., '')
    case ('taper')
      text%title = 'other cross-sections of veins'
      text%sentence = 'Thin veins are stiffer or softer against thick ones than solid circles would be: hollow or flattened veins.'
      call enter_named(c, e, numbers, text, [character(20) :: 'diameter_exponent'], .true., '')
    case ('membrane_bending')
      text%title = 'stiffer or softer membrane'
      text%sentence = 'The membrane resists bending more or less than was assumed.'
      call enter_named(c, e, numbers, text, [character(20) :: 'D'], .true., '')
    case ('elasticity')
      text%title = 'stiffness of membrane and springs'
      text%sentence = 'Everything elastic that is not fitted, membrane and springs, is stiffer or softer than was assumed, '// &
                      'as if all forces had another size.'
      call enter_named(c, e, numbers, text, [character(20) :: 'D', 'k_vein', 'k_membrane', 'k_cross'], .true., '')
    end select
  end subroutine enter_general

  !> Enters a soft place of a vein and damage of the membrane, each at many positions.
  subroutine enter_scans(c, e, wing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    type(variant_t), allocatable :: variants(:)
    type(wing_parameter_t) :: soft
    real(rp), allocatable :: way(:)
    integer :: v, k, n
    allocate (variants(0))
    soft = factor_at_sites('soft', -9.0_rp, 4.6_rp, 2.0_rp, KIND_SOFT)
    do v = 1, size(wing%veins)
      associate (nodes => wing%veins(v)%nodes)
        way = [0.0_rp]
        do k = 2, size(nodes)
          way = [way, way(k - 1) + norm2(wing%points(:, nodes(k)) - wing%points(:, nodes(k - 1)))]
        end do
        do k = 2, size(nodes) - 1
          soft%vein = v
          soft%fraction = way(k)/way(size(way))
          soft%number = hinge_in_vein(wing, e%model%plans, v, soft%fraction)
          if (soft%number == 0) cycle
          if (any(c%parameters%kind == KIND_SOFT .and. c%parameters%number == soft%number)) cycle
          n = c%add(soft)
          call append_variant(variants, wing%veins(v)%name//' at '//percent(soft%fraction), n, wing%points(:2, nodes(k)))
        end do
      end associate
    end do
    if (size(variants) > 0) &
      call enter_scanned(c, NEED_SOFT_PLACE, variants)
    deallocate (variants)
    allocate (variants(0))
    call scan_damage(c, e, wing, DAMAGE_SPACING, [DAMAGE_RADIUS], .false., variants)
    call scan_damage(c, e, wing, FINER_SPACING, FINER_RADII, .true., variants)
    if (size(variants) > 0) &
      call enter_scanned(c, NEED_DISC, variants)
  end subroutine enter_scans

  !> Enters an effect that needs a place, with these places.
  subroutine enter_scanned(c, need, variants)
    type(catalogue_t), intent(inout) :: c
    integer, intent(in) :: need
    type(variant_t), intent(in) :: variants(:)
    type(effect_t), allocatable :: list(:)
    type(effect_text_t) :: text
    integer :: i
    list = list_effects()
    do i = 1, size(list)
      if (all(list(i)%needs /= need)) cycle
      call list(i)%tell(text)
      call c%enter(text%cause, text%title, text%sentence, .false., '', variants)
    end do
  end subroutine enter_scanned

  !> Returns discs of these radii around the points of a lattice; radii and spacing are shares of the wing's size.
  subroutine scan_damage(c, e, wing, spacing, radii, is_finer, variants)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: spacing, radii(:)
    logical, intent(in) :: is_finer
    type(variant_t), allocatable, intent(inout) :: variants(:)
    real(rp), allocatable :: sites(:, :)
    type(wing_parameter_t) :: damage
    integer :: k, r, n
    damage = factor_at_sites('damage', -4.6_rp, 4.6_rp, 1.0_rp, KIND_DAMAGE)
    call lattice(wing, e%model%size, spacing, sites)
    do k = 1, size(sites, 2)
      do r = 1, size(radii)
        damage%disc = [sites(:, k), radii(r)*e%model%size]
        n = c%add(damage)
        call append_variant(variants, 'around ('//millimetres(sites(1, k))//', '//millimetres(sites(2, k))// &
                            ') mm, radius '//millimetres(radii(r)*e%model%size)//' mm', n, sites(:, k))
        variants(size(variants))%is_finer = is_finer
      end do
    end do
  end subroutine scan_damage

  !> Returns the coordinate of a factor on stiffness at one of many places, between these bounds.
  function factor_at_sites(name, lower, upper, prior_sd, kind) result(p)
    character(*), intent(in) :: name
    real(rp), intent(in) :: lower, upper, prior_sd
    integer, intent(in) :: kind
    type(wing_parameter_t) :: p
    type(parameter_t) :: factor
    call define_parameter(factor, name, '1', .true., lower, upper)
    factor%prior_sd = prior_sd
    p = wing_parameter(factor, kind, 0)
  end function factor_at_sites

  !> Enters the errors of the measurement.
  subroutine enter_measurement(c, e)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    call enter_instrument(c, e, 'force_gain', 'wrong gain of the force sensor', [FORCE_GAIN], .true., &
                          'All forces were larger or smaller than stated, by one factor.', '')
    call enter_instrument(c, e, 'force_offset', 'zero error of the force sensor', [FORCE_OFFSET], .true., &
                          'The same force was added to every force that is stated.', needs_levels(e))
    call enter_instrument(c, e, 'force_direction', 'forces that were not upright', &
                          [FORCE_TILT_X, FORCE_TILT_Y], .true., &
                          'All forces leaned to one side.', '')
    call enter_instrument(c, e, 'load_position', 'forces beside the stated places', [LOAD_SHIFT_X, LOAD_SHIFT_Y], &
                          .true., 'All forces acted at a distance from the stated places, the same for all.', &
                          needs_membrane(e))
    call enter_instrument(c, e, 'height_scale', 'wrong scale of the heights', [HEIGHT_SCALE], .true., &
                          'All heights were larger or smaller than stated, by one factor.', '')
    call enter_instrument(c, e, 'scan_plane', 'tilted or lifted scans', [TILT_X, TILT_Y, PISTON], .true., &
                          'All loaded scans were tilted or lifted against the unloaded one, in the same way.', '')
    call enter_instrument(c, e, 'registration', 'shifted or turned maps', [MAP_SHIFT_X, MAP_SHIFT_Y, MAP_ROTATION, &
                                                                           MAP_SCALE], .true., &
                          'In the height maps the wing was shifted, turned or magnified against what the file says.', '')
    call enter_instrument(c, e, 'drift', 'a wing that changed during the experiment', [DRIFT], .true., &
                          'The wing became stiffer (it dried) or softer from one measurement to the next.', '')
    call enter_instrument(c, e, 'drift_in_time', 'a wing that changed with time', [DRIFT_RATE], .true., &
                          'The wing became stiffer (it dried) or softer with time.', '')
    call enter_instrument(c, e, 'creep', 'creep under load', [CREEP], .false., &
                          'The wing went on bending while the force was held.', needs_holds(e))
    call enter_instrument(c, e, 'gravity', 'weight of the wing', [GRAVITY_X, GRAVITY_Y, GRAVITY_Z], .true., &
                          'The wing''s own weight bends it, also when nothing pushes.', needs_mass(e))
    call enter_instrument(c, e, 'nonlinearity', 'large deflections', [NONLINEARITY], .false., &
                          'The wing bends so far that twice the force does not bend it twice as far. Geometry alone does that.', &
                          needs_small_deflections(e))
  end subroutine enter_measurement

end module diagnosis_wing_catalogue

! SPDX-License-Identifier: GPL-3.0-or-later
!> The catalogue: what a simulation of a bending test may lack, one entry for each effect, with a sentence for people,
!> the parameters that it releases, the positions at which it is tried, and what data it needs to show.
module diagnosis_wing_catalogue
  use base_kinds, only: rp
  use diagnosis_wing_entries, only: append_variant, catalogue_t, enter_instrument, enter_named, millimetres, percent
  use diagnosis_wing_inertia, only: add_air, enter_inertia
  use diagnosis_wing_lattice, only: lattice
  use diagnosis_wing_needs, only: needs_holds, needs_levels, needs_mass, needs_membrane, needs_sides, &
                                  needs_small_deflections, needs_springs_both_ways, needs_stress_free_rest
  use diagnosis_wing_quantities, only: wing_quantity_t, KIND_DAMAGE, KIND_SOFT, KIND_ZERO
  use inference_simulator, only: quantity_t, variant_t
  use measurement_experiment, only: experiment_t
  use measurement_instrument, only: CREEP, DRIFT, DRIFT_RATE, FORCE_GAIN, FORCE_OFFSET, FORCE_TILT_X, FORCE_TILT_Y, &
                                    GRAVITY_X, GRAVITY_Y, GRAVITY_Z, HEIGHT_SCALE, LOAD_SHIFT_X, LOAD_SHIFT_Y, &
                                    MAP_ROTATION, MAP_SCALE, MAP_SHIFT_X, MAP_SHIFT_Y, NONLINEARITY, PISTON, TILT_X, &
                                    TILT_Y
  use solid_layout, only: hinge_in_vein
  use solid_wing, only: wing_t
  implicit none
  private
  public :: catalogue_t, make_catalogue

  real(rp), parameter :: DECADE = 2.302585092994046_rp
  real(rp), parameter :: STRONG_TORSION = 0.2_rp !< a quarter of what solid circular veins have
  real(rp), parameter :: DAMAGE_RADIUS = 0.1_rp, DAMAGE_SPACING = 0.12_rp !< of the wing's size
  !> The same where damage was found.
  real(rp), parameter :: FINER_RADII(3) = [0.06_rp, 0.085_rp, 0.12_rp], FINER_SPACING = 0.05_rp

contains

  !> The catalogue for an experiment without unknowns of its own on `wing`; the baseline seeks the parameters of these
  !> numbers, with `decades` as sd of their priors.
  subroutine make_catalogue(experiment, wing, numbers, decades, catalogue)
    type(experiment_t), intent(in) :: experiment
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: numbers(:)
    real(rp), intent(in) :: decades
    type(catalogue_t), intent(out) :: catalogue
    integer :: i, n
    allocate (catalogue%quantities(0), catalogue%kinds(0), catalogue%effects(0))
    do i = 1, size(numbers)
      n = catalogue%add_parameter(experiment, numbers(i))
      catalogue%quantities(n)%prior_sd = decades*DECADE
      if (.not. catalogue%quantities(n)%is_log) catalogue%quantities(n)%prior_sd = decades
    end do
    call add_air(catalogue, experiment)
    do i = 1, size(experiment%measurement%zeros)
      n = catalogue%add_quantity(quantity_t('zero:'//trim(experiment%measurement%zeros(i)), 'm', .false., 0.0_rp, &
                                            0.0_rp, -experiment%model%size, experiment%model%size), &
                                 wing_quantity_t(kind=KIND_ZERO, number=i))
    end do
    catalogue%n_baseline = size(catalogue%quantities)
    call enter_structure(catalogue, experiment, numbers)
    call enter_scans(catalogue, experiment, wing)
    call enter_inertia(catalogue, experiment, wing)
    call enter_measurement(catalogue, experiment)
  end subroutine make_catalogue

  !> Entries that are parameters of the wing, where the baseline does not seek them already.
  subroutine enter_structure(c, e, numbers)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    character(:), allocatable :: levels
    integer :: n
    levels = needs_levels(e)
    call enter_named(c, e, numbers, 'root_compliance', 'compliant root', [character(20) :: 'root_flap', 'root_twist'], &
                 .true., 'The clamp or the wing''s root gives way: the whole wing turns about it, in proportion to '// &
                     'the moment of the force.', '')
    call enter_named(c, e, numbers, 'root_stiffness', 'root of another stiffness', [character(20) :: 'root'], .true., &
                     'The veins bend more or less easily where the wing is clamped.', '')
    call enter_named(c, e, numbers, 'E_gradient', 'stiffness that changes along the span', &
                     [character(20) :: 'E_gradient'], .true., &
                     'The veins'' material is softer or stiffer toward the tip than at the root.', '')
    call enter_named(c, e, numbers, 'E_per_vein', 'a vein of another material', [character(20) :: 'E:*'], .false., &
                     'One vein is softer or stiffer than the others.', '')
    call enter_named(c, e, numbers, 'taper', 'other cross-sections of veins', [character(20) :: 'diameter_exponent'], &
                     .true., 'Thin veins are stiffer or softer against thick ones than solid circles would be: '// &
                     'hollow or flattened veins.', '')
    call enter_named(c, e, numbers, 'membrane_bending', 'stiffer or softer membrane', [character(20) :: 'D'], .true., &
                     'The membrane resists bending more or less than was assumed.', '')
    call enter_named(c, e, numbers, 'elasticity', 'stiffness of membrane and springs', &
                     [character(20) :: 'D', 'k_vein', 'k_membrane', 'k_cross'], .true., &
                     'Everything elastic that is not sought, membrane and springs, is stiffer or softer than was '// &
                     'assumed, as if all forces had another size.', '')
    call enter_named(c, e, numbers, 'orthotropy', 'membrane that is stiffer in one direction', &
                     [character(20) :: 'orthotropy'], .true., &
                     'The membrane stretches less easily along the span than across it, or the other way round.', '')
    call enter_named(c, e, numbers, 'pretension', 'stretched membrane', [character(20) :: 'pretension'], .true., &
                     'The membrane is stretched between the veins already when nothing pushes, like a drumskin.', &
                     needs_stress_free_rest(e, needs_springs_both_ways(e)))
    call enter_named(c, e, numbers, 'camber', 'a wing that is not flat', &
                     [character(20) :: 'camber_span', 'camber_chord', 'camber_twist'], .true., &
                     'The wing is curved or twisted when nothing pushes, and stiffer or softer for that.', &
                     needs_stress_free_rest(e, needs_membrane(e)))
    call enter_named(c, e, numbers, 'vein_torsion', 'veins that resist torsion', [character(20) :: 'torsion'], .true., &
                     'Veins resist being twisted about themselves, not only being bent.', needs_membrane(e))
    ! Veins that twist freely have modes of their own, which little torsion ends: its tangent at null shows them alone.
    do n = 1, size(c%quantities)
      if (c%quantities(n)%name == 'torsion') c%quantities(n)%strong = STRONG_TORSION
    end do
    call enter_named(c, e, numbers, 'joint_hardening', 'joints that harden', &
                     [character(20) :: 'joint_hardening'], .true., &
                     'Joints of veins get stiffer, or give way, the more they are bent.', levels)
    call enter_named(c, e, numbers, 'one_joint_hardening', 'one joint that hardens', [character(20) :: 'hardening:*'], &
                     .false., 'One joint gets stiffer, or gives way, the more it is bent.', levels)
    call enter_named(c, e, numbers, 'one_way_joint', 'a one-way joint', [character(20) :: 'one_way:*'], .false., &
                     'One joint bends more easily in one direction, up or down, than in the other.', needs_sides(e))
    call enter_named(c, e, numbers, 'cuticle', 'nonlinear cuticle', [character(20) :: 'cuticle'], .true., &
                     'The veins themselves get stiffer, or soften, the more they are bent.', levels)
  end subroutine enter_structure

  !> A soft place of a vein and damage of the membrane, each at many positions.
  subroutine enter_scans(c, e, wing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    type(variant_t), allocatable :: variants(:)
    type(wing_quantity_t) :: kind
    real(rp), allocatable :: way(:)
    integer :: v, k, n
    allocate (variants(0))
    do v = 1, size(wing%veins)
      associate (nodes => wing%veins(v)%nodes)
        way = [0.0_rp]
        do k = 2, size(nodes)
          way = [way, way(k - 1) + norm2(wing%points(:, nodes(k)) - wing%points(:, nodes(k - 1)))]
        end do
        do k = 2, size(nodes) - 1
          kind = wing_quantity_t(kind=KIND_SOFT, vein=v, share=way(k)/way(size(way)))
          kind%number = hinge_in_vein(wing, e%model%plans, v, kind%share)
          if (kind%number == 0) cycle
          if (any(c%kinds%kind == KIND_SOFT .and. c%kinds%number == kind%number)) cycle
          n = c%add_quantity(quantity_t('soft', '1', .true., 0.0_rp, 2.0_rp, -9.0_rp, 4.6_rp), kind)
          call append_variant(variants, wing%veins(v)%name//' at '//percent(kind%share), n, wing%points(:2, nodes(k)))
        end do
      end associate
    end do
    if (size(variants) > 0) &
      call c%enter('soft_place', 'a joint that the model does not have', &
                  'One vein is softer (or stiffer) at one place than it looks: an unseen joint, a crack or a repair.', &
                   .false., '', variants)
    deallocate (variants)
    allocate (variants(0))
    call scan_damage(c, e, wing, DAMAGE_SPACING, [DAMAGE_RADIUS], .false., variants)
    call scan_damage(c, e, wing, FINER_SPACING, FINER_RADII, .true., variants)
    if (size(variants) > 0) &
      call c%enter('damage', 'a damaged region', &
                   'Veins and membrane of one region are softer, as if torn, or stiffer than the rest.', .false., '', &
                   variants)
  end subroutine enter_scans

  !> Discs of these radii around the points of a lattice; radii and spacing are shares of the wing's size.
  subroutine scan_damage(c, e, wing, spacing, radii, is_finer, variants)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: spacing, radii(:)
    logical, intent(in) :: is_finer
    type(variant_t), allocatable, intent(inout) :: variants(:)
    real(rp), allocatable :: places(:, :)
    integer :: k, r, n
    call lattice(wing, e%model%size, spacing, places)
    do k = 1, size(places, 2)
      do r = 1, size(radii)
        n = c%add_quantity(quantity_t('damage', '1', .true., 0.0_rp, 1.0_rp, -4.6_rp, 4.6_rp), &
                           wing_quantity_t(kind=KIND_DAMAGE, disc=[places(:, k), radii(r)*e%model%size]))
        call append_variant(variants, 'around ('//millimetres(places(1, k))//', '//millimetres(places(2, k))// &
                            ') mm, radius '//millimetres(radii(r)*e%model%size)//' mm', n, places(:, k))
        variants(size(variants))%is_finer = is_finer
      end do
    end do
  end subroutine scan_damage

  !> Entries that are errors of the measurement.
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
                          'The wing lay elsewhere, turned or magnified in the height maps than the file says.', '')
    call enter_instrument(c, e, 'drift', 'a wing that changed during the experiment', [DRIFT], .true., &
                          'The wing became stiffer (it dried) or softer from one measurement to the next.', '')
    call enter_instrument(c, e, 'drift_in_time', 'a wing that changed with time', [DRIFT_RATE], .true., &
                          'The wing became stiffer (it dried) or softer with time.', '')
    call enter_instrument(c, e, 'creep', 'creep under load', [CREEP], .false., &
                          'The wing went on bending while the force was held.', needs_holds(e))
    call enter_instrument(c, e, 'gravity', 'weight of the wing', [GRAVITY_X, GRAVITY_Y, GRAVITY_Z], .true., &
                          'The wing''s own weight bends it, also when nothing pushes.', needs_mass(e))
    call enter_instrument(c, e, 'nonlinearity', 'large deflections', [NONLINEARITY], .false., &
                          'The wing bends so far that twice the force is not twice the way, as geometry alone makes it.', &
                          needs_small_deflections(e))
  end subroutine enter_measurement

end module diagnosis_wing_catalogue

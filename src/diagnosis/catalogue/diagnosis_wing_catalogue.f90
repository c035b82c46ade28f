! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the catalogue of what a simulation of a bending test may lack. It has one entry for each effect: a sentence for people,
!> the parameters that the effect releases, the sites where the diagnosis tries it, and the data that it needs to be visible.
module diagnosis_wing_catalogue
  use base_cause, only: cause_t
  use base_kinds, only: rp
  use base_parameter, only: define_parameter, parameter_t
  use diagnosis_flight_catalogue, only: enter_flights
  use diagnosis_flight_data, only: flight_cases_t
  use diagnosis_flight_structure, only: is_flown_first
  use diagnosis_wing_entries, only: append_variant, catalogue_t, enter_instrument, enter_structural, percent
  use diagnosis_wing_damping, only: add_damping, enter_damping
  use diagnosis_wing_inertia, only: add_air, enter_flown_inertia, enter_inertia
  use diagnosis_wing_lattice, only: lattice
  use diagnosis_wing_needs, only: missing_of
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_DAMAGE, KIND_MEMBRANE, KIND_SOFT, KIND_ZERO
  use diagnosis_wing_places, only: append_anywhere, append_place, enter_anywhere
  use diagnosis_wing_shake, only: enter_shake
  use inference_simulator, only: variant_t
  use measurement_experiment, only: experiment_t
  use measurement_instrument_causes, only: list_instrument_causes
  use solid_effect, only: NEED_DISC, NEED_SOFT_PLACE
  use solid_effects, only: list_effect_causes
  use solid_layout, only: hinge_in_vein, vein_places
  use solid_structure_causes, only: list_structure_causes
  use solid_usual_causes, only: PARAM_PLATE, PARAM_THICKNESS
  use solid_wing, only: wing_t
  implicit none
  private
  public :: catalogue_t, make_catalogue

  real(rp), parameter :: DECADE = 2.302585092994046_rp
  real(rp), parameter :: DAMAGE_RADIUS = 0.1_rp, DAMAGE_SPACING = 0.12_rp !< of the wing's size
  !> The same for finer scans where damage was found.
  real(rp), parameter :: FINER_RADII(3) = [0.06_rp, 0.085_rp, 0.12_rp], FINER_SPACING = 0.05_rp
  real(rp), parameter :: RADII(2) = [0.03_rp, 0.2_rp] !< smallest and largest one of a search, of the wing's size

contains

  !> Makes the catalogue for an experiment without unknowns on `wing`. The baseline fits the parameters of these numbers, with
  !> `decades` as sd of their priors.
  subroutine make_catalogue(experiment, wing, numbers, decades, catalogue, flights, membrane_sd)
    type(experiment_t), intent(in) :: experiment
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: numbers(:)
    real(rp), intent(in) :: decades
    type(catalogue_t), intent(out) :: catalogue
    type(flight_cases_t), intent(in), optional :: flights !< of records of forces over the beat, if there are any
    real(rp), intent(in), optional :: membrane_sd         !< of the logarithm of D, 0: D is exact
    type(parameter_t) :: p
    integer :: i, n
    allocate (catalogue%parameters(0), catalogue%effects(0))
    do i = 1, size(numbers)
      n = catalogue%add_parameter(experiment, numbers(i))
      catalogue%parameters(n)%prior_sd = decades*DECADE
      if (.not. catalogue%parameters(n)%is_log) catalogue%parameters(n)%prior_sd = decades
    end do
    if (present(membrane_sd)) call add_membrane(catalogue, experiment, numbers, membrane_sd)
    call add_air(catalogue, experiment)
    call add_damping(catalogue, experiment)
    do i = 1, size(experiment%measurement%zeros)
      call define_parameter(p, 'zero:'//trim(experiment%measurement%zeros(i)), 'm', .false., -experiment%model%size, &
                            experiment%model%size)
      n = catalogue%add(wing_parameter(p, KIND_ZERO, i))
    end do
    catalogue%n_baseline = size(catalogue%parameters)
    if (present(flights)) then
      if (flights%has_records) call enter_flights(catalogue, flights%cases, experiment%measurement%flights, flights%effects)
      if (flights%has_records .and. size(experiment%loads) == 0 .and. .not. experiment%measurement%moves()) then
        ! On a wing whose motion is prescribed, forces show nothing else.
        if (.not. flights%bend()) return
        call enter_structure(catalogue, experiment, numbers, flights)
        call enter_flown_inertia(catalogue, experiment, wing, flights)
        return
      end if
    end if
    call enter_structure(catalogue, experiment, numbers)
    call enter_scans(catalogue, experiment, wing)
    call enter_inertia(catalogue, experiment, wing)
    if (present(flights)) call enter_flown_inertia(catalogue, experiment, wing, flights)
    call enter_damping(catalogue, experiment)
    call enter_shake(catalogue, experiment)
    call enter_measurement(catalogue, experiment)
  end subroutine make_catalogue

  !> Adds the error of D to the baseline where there are natural modes or records. With bending tests alone it is one of the
  !> nuisances, which act linearly. The phase of a record turns with D. A usual error of D changes it by many times the errors of
  !> the data, which no tangent follows.
  subroutine add_membrane(c, e, numbers, sd)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    real(rp), intent(in) :: sd
    real(rp), parameter :: LARGEST = 20
    type(parameter_t) :: p
    integer :: n
    if (.not. (sd > 0 .and. e%measurement%moves()) .or. size(e%model%triangles) == 0) return
    if (any(numbers == PARAM_PLATE .or. numbers == PARAM_THICKNESS) .or. .not. e%model%params%get(PARAM_PLATE) > 0) return
    call define_parameter(p, 'membrane_error', '1', .true., 1/LARGEST, LARGEST)
    p%prior_sd = sd
    n = c%add(wing_parameter(p%as_coordinate(1.0_rp), KIND_MEMBRANE, PARAM_PLATE))
  end subroutine add_membrane

  !> Enters parameters of the wing that the baseline does not fit already: those that every wing has, and its effects. `enter_scans`
  !> enters those that are tried at many sites. With `flights` there are no other data: it enters what the first flights show.
  subroutine enter_structure(c, e, numbers, flights)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    type(flight_cases_t), intent(in), optional :: flights
    type(cause_t), allocatable :: list(:)
    integer :: i
    list = list_structure_causes()
    do i = 1, size(list)
      if (any(list(i)%needs == NEED_DISC .or. list(i)%needs == NEED_SOFT_PLACE)) cycle
      if (present(flights)) then
        if (.not. is_flown_first(flights%effects, list(i)%name)) cycle
      end if
      call enter_structural(c, e, numbers, list(i), missing_of(e, list(i)%needs))
    end do
  end subroutine enter_structure

  !> Enters a soft place of a vein and damage of the membrane, each at many positions.
  subroutine enter_scans(c, e, wing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    type(variant_t), allocatable :: variants(:)
    type(wing_parameter_t) :: soft
    real(rp), allocatable :: places(:)
    integer :: v, k, n
    allocate (variants(0))
    soft = factor_at_sites(NEED_SOFT_PLACE, KIND_SOFT)
    do v = 1, size(wing%veins)
      associate (nodes => wing%veins(v)%nodes)
        places = vein_places(wing, v)
        do k = 2, size(nodes) - 1
          soft%vein = v
          soft%fraction = places(k)
          soft%file_fraction = soft%fraction
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
    if (size(variants) == 0) return
    call append_anywhere(c, e, factor_at_sites(NEED_DISC, KIND_DAMAGE), DAMAGE_SPACING/2*e%model%size, RADII*e%model%size, variants)
    call enter_scanned(c, NEED_DISC, variants)
    call enter_anywhere(c)
  end subroutine enter_scans

  !> Enters the cause that needs a site, with these sites.
  subroutine enter_scanned(c, need, variants)
    type(catalogue_t), intent(inout) :: c
    integer, intent(in) :: need
    type(variant_t), intent(in) :: variants(:)
    call c%enter(cause_at_place(need), '', variants)
  end subroutine enter_scanned

  !> Returns the effect that needs a site of this kind.
  function cause_at_place(need) result(cause)
    integer, intent(in) :: need
    type(cause_t) :: cause
    type(cause_t), allocatable :: list(:)
    integer :: i
    list = list_effect_causes()
    do i = 1, size(list)
      if (any(list(i)%needs == need)) cause = list(i)
    end do
  end function cause_at_place

  !> Returns discs of these radii around the points of a lattice; radii and spacing are fractions of the wing's size.
  subroutine scan_damage(c, e, wing, spacing, radii, is_finer, variants)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: spacing, radii(:)
    logical, intent(in) :: is_finer
    type(variant_t), allocatable, intent(inout) :: variants(:)
    real(rp), allocatable :: sites(:, :)
    type(wing_parameter_t) :: damage
    integer :: k, r
    damage = factor_at_sites(NEED_DISC, KIND_DAMAGE)
    call lattice(wing, e%model%size, spacing, sites)
    do k = 1, size(sites, 2)
      do r = 1, size(radii)
        damage%disc = [sites(:, k), radii(r)*e%model%size]
        call append_place(c, damage, is_finer, variants)
      end do
    end do
  end subroutine scan_damage

  !> Returns the coordinate of a factor on stiffness at one of many sites: that of the effect which has this need.
  function factor_at_sites(need, kind) result(p)
    integer, intent(in) :: need, kind
    type(wing_parameter_t) :: p
    type(cause_t) :: cause
    cause = cause_at_place(need)
    associate (factor => cause%parameters(1)%value)
      p = wing_parameter(factor%as_coordinate(factor%null), kind, 0)
    end associate
  end function factor_at_sites

  !> Enters the errors of the measurement.
  subroutine enter_measurement(c, e)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(cause_t), allocatable :: list(:)
    integer :: i
    list = list_instrument_causes(e%instrument%scales)
    do i = 1, size(list)
      call enter_instrument(c, e, list(i), missing_of(e, list(i)%needs))
    end do
  end subroutine enter_measurement
end module diagnosis_wing_catalogue

! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the entries of the catalogue that describe the mass of the wing and its distribution, which only natural modes,
!> records of motion, and flights of wings that bend can show. Without these the catalogue has none of them.
module diagnosis_wing_inertia
  use base_cause, only: cause_t
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use diagnosis_flight_data, only: flight_cases_t
  use diagnosis_flight_structure, only: is_flown_first
  use diagnosis_wing_entries, only: append_variant, catalogue_t
  use diagnosis_wing_lattice, only: lattice
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_MASS, KIND_POINT_MASS
  use diagnosis_wing_places, only: append_anywhere, append_place, enter_anywhere
  use inference_simulator, only: variant_t
  use measurement_experiment, only: experiment_t
  use solid_effect, only: NEED_MASS_PLACE, NEED_MEMBRANE, NEED_VEINS
  use solid_mass_effects, only: added_mass_parameter, list_mass_causes, MASS_ADDED
  use solid_wing, only: wing_t
  implicit none
  private
  public :: add_air, enter_flown_inertia, enter_inertia

  real(rp), parameter :: SPACING = 0.1_rp, FINER_SPACING = 0.04_rp !< of the sites of a point mass, of the wing's size

contains

  !> Adds a parameter to the baseline. If the wing moved in air, the baseline fits the ratio of the air that moves with the wing to
  !> that of strip theory.
  subroutine add_air(c, e)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer :: n
    type(parameter_t) :: p
    if (.not. e%measurement%is_in_air()) return
    p = added_mass_parameter()
    n = c%add(wing_parameter(p%as_coordinate(p%null), KIND_MASS, MASS_ADDED))
  end subroutine add_air

  !> Enters the mass of the wing, and a point mass at any site.
  subroutine enter_inertia(c, e, wing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    type(cause_t), allocatable :: list(:)
    integer :: i
    if (.not. e%measurement%moves()) return
    list = list_mass_causes(sum(e%masses))
    do i = 1, size(list)
      associate (needs => list(i)%needs)
        call require(all(needs == NEED_VEINS .or. needs == NEED_MEMBRANE .or. needs == NEED_MASS_PLACE), &
                     'diagnosis_wing_inertia: an unknown need of '//list(i)%name)
        if (any(needs == NEED_VEINS) .and. size(wing%veins) == 0) cycle
        if (any(needs == NEED_MEMBRANE) .and. size(wing%triangles) == 0) cycle
        call enter_one(c, e, wing, list(i))
      end associate
    end do
  end subroutine enter_inertia

  !> Enters the masses that the first flights show, if no other data show them.
  subroutine enter_flown_inertia(c, e, wing, flights)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    type(flight_cases_t), intent(in) :: flights
    type(cause_t), allocatable :: list(:)
    integer :: i
    if (e%measurement%moves() .or. .not. flights%bend()) return
    list = list_mass_causes(1.0_rp)
    do i = 1, size(list)
      if (is_flown_first(flights%effects, list(i)%name)) call enter_one(c, e, wing, list(i))
    end do
  end subroutine enter_flown_inertia

  !> Enters a cause that has one parameter of the masses, at all sites if it needs one.
  subroutine enter_one(c, e, wing, cause)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    type(cause_t), intent(in) :: cause
    type(variant_t), allocatable :: variants(:)
    integer :: n
    allocate (variants(0))
    associate (p => cause%parameters(1)%value)
      if (any(cause%needs == NEED_MASS_PLACE)) then
        call scan(c, e, wing, p, SPACING, .false., variants)
        call scan(c, e, wing, p, FINER_SPACING, .true., variants)
        call append_anywhere(c, e, wing_parameter(p%as_coordinate(p%null), KIND_POINT_MASS, 0), SPACING/2*e%model%size, &
                             [real(rp) ::], variants)
      else
        n = c%add(wing_parameter(p%as_coordinate(p%null), KIND_MASS, cause%parameters(1)%number))
        call append_variant(variants, '', n, [0.0_rp, 0.0_rp])
      end if
    end associate
    call c%enter(cause, '', variants)
    if (any(cause%needs == NEED_MASS_PLACE)) call enter_anywhere(c)
  end subroutine enter_one

  !> Enters the parameter p of a point mass at every site of a lattice.
  subroutine scan(c, e, wing, p, fraction, is_finer, variants)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    type(parameter_t), intent(in) :: p
    real(rp), intent(in) :: fraction
    logical, intent(in) :: is_finer
    type(variant_t), allocatable, intent(inout) :: variants(:)
    real(rp), allocatable :: sites(:, :)
    type(wing_parameter_t) :: one
    integer :: k
    one = wing_parameter(p%as_coordinate(p%null), KIND_POINT_MASS, 0)
    call lattice(wing, e%model%size, fraction, sites)
    do k = 1, size(sites, 2)
      one%disc = [sites(:, k), fraction*e%model%size]
      call append_place(c, one, is_finer, variants)
    end do
  end subroutine scan
end module diagnosis_wing_inertia

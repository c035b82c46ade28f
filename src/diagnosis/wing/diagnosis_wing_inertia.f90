! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the entries of the catalogue that describe the mass of the wing and its distribution, which only natural modes and
!> records of motion can show. Without these the catalogue has none of them.
module diagnosis_wing_inertia
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use diagnosis_wing_entries, only: append_variant, catalogue_t, millimetres
  use diagnosis_wing_lattice, only: lattice
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_MASS, KIND_POINT_MASS
  use inference_simulator, only: variant_t
  use measurement_experiment, only: experiment_t
  use solid_mass_effects, only: describe_mass_effect, MASS_ADDED, MASS_GRADIENT, MASS_MEMBRANE, MASS_POINT, MASS_VEINS
  use solid_wing, only: wing_t
  implicit none
  private
  public :: add_air, enter_inertia

  real(rp), parameter :: SPACING = 0.1_rp, FINER_SPACING = 0.04_rp !< of places of a point mass, of the wing's size

contains

  !> Adds a parameter to the baseline. If the wing moved in air, it fits the ratio of the air that moves with the wing to that of
  !> strip theory.
  subroutine add_air(c, e)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer :: n
    if (e%measurement%is_in_air()) n = add_effect(c, MASS_ADDED)
  end subroutine add_air

  !> Adds an effect of the masses, and gives its number.
  integer function add_effect(c, number) result(n)
    type(catalogue_t), intent(inout) :: c
    integer, intent(in) :: number
    type(parameter_t) :: p
    p = describe_mass_effect(number, 0.0_rp)
    n = c%add(wing_parameter(p%as_coordinate(p%null), KIND_MASS, number))
  end function add_effect

  !> Enters the mass of the wing, and a point mass at any place.
  subroutine enter_inertia(c, e, wing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    type(variant_t), allocatable :: variants(:)
    if (.not. e%measurement%moves()) return
    if (size(wing%veins) > 0) call enter_one(c, MASS_VEINS, 'vein_mass', 'heavier or lighter veins', &
                                             'The veins weigh more or less than was assumed.')
    if (size(wing%triangles) > 0) then
      call enter_one(c, MASS_MEMBRANE, 'membrane_mass', 'heavier or lighter membrane', &
                     'The membrane weighs more or less than was assumed.')
      call enter_one(c, MASS_GRADIENT, 'membrane_gradient', 'mass of the membrane that changes along the span', &
                     'The membrane is heavier, or lighter, toward the tip than at the root, as if its thickness changed.')
    end if
    allocate (variants(0))
    call scan(c, e, wing, SPACING, .false., variants)
    call scan(c, e, wing, FINER_SPACING, .true., variants)
    call c%enter('point_mass', 'a mass that the model does not have', &
                 'Something sits on the wing at one place: dust, glue or a marker.', .false., '', variants)
  end subroutine enter_inertia

  !> Enters one parameter of the masses as a separate effect.
  subroutine enter_one(c, number, name, title, sentence)
    type(catalogue_t), intent(inout) :: c
    integer, intent(in) :: number
    character(*), intent(in) :: name, title, sentence
    type(variant_t), allocatable :: variants(:)
    allocate (variants(0))
    call append_variant(variants, '', add_effect(c, number), [0.0_rp, 0.0_rp])
    call c%enter(name, title, sentence, .false., '', variants)
  end subroutine enter_one

  !> Enters a point mass at every place of a lattice.
  subroutine scan(c, e, wing, fraction, is_finer, variants)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: fraction
    logical, intent(in) :: is_finer
    type(variant_t), allocatable, intent(inout) :: variants(:)
    real(rp), allocatable :: sites(:, :)
    type(parameter_t) :: p
    type(wing_parameter_t) :: one
    integer :: k, n
    p = describe_mass_effect(MASS_POINT, sum(e%masses))
    one = wing_parameter(p%as_coordinate(p%null), KIND_POINT_MASS, 0)
    call lattice(wing, e%model%size, fraction, sites)
    do k = 1, size(sites, 2)
      one%disc = [sites(:, k), fraction*e%model%size]
      n = c%add(one)
      call append_variant(variants, 'at ('//millimetres(sites(1, k))//', '//millimetres(sites(2, k))//') mm', n, sites(:, k))
      variants(size(variants))%is_finer = is_finer
    end do
  end subroutine scan
end module diagnosis_wing_inertia

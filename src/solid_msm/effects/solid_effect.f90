! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the law of an effect: what an evaluation of a wing needs. One module solid_effect_* makes one such law, and
!> solid_effects lists them. The law has no texts, so that the list costs an evaluation little. Its `tell` makes the cause
!> (base_cause): the parameters of the effect with units, ranges, priors and words, what it needs, and its texts. Reports, the
!> catalogue of the diagnosis and the tables of the documents use the causes.
!>
!> A law multiplies the stiffness that the usual parameters give, in three stages: single elements, then regions, then moments
!> that follow from the stiffness so far. An effect that adds a force independent of the stiffness is a load.
module solid_effect
  use base_cause, only: cause_t
  use base_kinds, only: rp
  use solid_effect_values, only: effects_t
  use solid_element_stiffness, only: stiffness_t
  use solid_extension, only: extensions_t
  use solid_junctions, only: hinge_plan_t
  use solid_layout, only: layout_t
  implicit none
  private
  public :: effect_t, effect_site_t

  integer, parameter, public :: STAGE_NONE = 0, STAGE_ELEMENTS = 1, STAGE_REGIONS = 2, STAGE_MOMENTS = 3, STAGE_LOADS = 4

  !> Requirements of effects: NEED_DISC to NEED_MEMBRANE, NEED_VEINS and NEED_MASS_PLACE on the wing, the others on data.
  integer, parameter, public :: NEED_DISC = 1, NEED_SOFT_PLACE = 2, NEED_SIDED_JOINTS = 3, &
                                NEED_SIDED_VEINS = 4, NEED_NO_SLACK = 5, NEED_MEMBRANE = 6, NEED_UNSTRESSED_REST = 7, &
                                NEED_LEVELS = 8, NEED_BOTH_DIRECTIONS = 9, NEED_MODES_ABOUT_REST = 10, NEED_VEINS = 11, &
                                NEED_MASS_PLACE = 12, NEED_AIR = 13, N_WING_NEEDS = 13
  integer, parameter :: MOST_PARAMETERS = 3 !< of one effect

  type :: effect_t
    integer :: n = 1                          !< number of parameters, unless `is_per_joint`
    logical :: is_log = .false.               !< they vary by factors and have no effect at 1; otherwise they have none at 0
    logical :: is_per_joint = .false.         !< every joint has the parameter
    logical :: is_thickness = .false.         !< the mass of the membrane follows its value, as by `membrane_gradient`
    logical :: curves_rest = .false.          !< it bends the wing without a load
    integer :: clamp_axis(MOST_PARAMETERS) = 0 !< a parameter lets the clamp turn about x (1) or y (2), by value times moment
    integer :: stage = STAGE_NONE             !< of `apply`
    procedure(stiffness_law), pointer, nopass :: apply => null()
    procedure(stiffness_slope), pointer, nopass :: derive => null()
    procedure(modulus_law), pointer, nopass :: modulus => null()        !< factor on E of the veins at a hinge
    procedure(modulus_law), pointer, nopass :: modulus_slope => null()  !< of its logarithm
    procedure(cause_teller), pointer :: tell => null()
  end type effect_t

  !> Holds what a law acts on: the values of the parameters of its effect, and the elements of the wing.
  type :: effect_site_t
    integer :: k = 1                            !< the parameter for a derivative
    real(rp), allocatable :: values(:)          !< of the effect
    type(effects_t), pointer :: effects         !< of all, with their places
    type(extensions_t), pointer :: springs
    type(hinge_plan_t), pointer :: plans(:)
    type(layout_t), pointer :: layout
  end type effect_site_t

  abstract interface
    !> Changes `stiffness` to the stiffness with the effect.
    pure subroutine stiffness_law(site, stiffness)
      import :: effect_site_t, stiffness_t
      type(effect_site_t), intent(in) :: site
      type(stiffness_t), intent(inout) :: stiffness
    end subroutine stiffness_law

    !> Puts the derivative of `stiffness` (of the model with all effects) with respect to parameter site%k of the effect into
    !> `direction`, which is 0 before: per log unit if the parameter varies by factors.
    pure subroutine stiffness_slope(site, stiffness, direction)
      import :: effect_site_t, stiffness_t
      type(effect_site_t), intent(in) :: site
      type(stiffness_t), intent(in) :: stiffness
      type(stiffness_t), intent(inout) :: direction
    end subroutine stiffness_slope

    !> Returns a factor for the value of an effect with one parameter, at a hinge.
    pure real(rp) function modulus_law(value, plan)
      import :: rp, hinge_plan_t
      real(rp), intent(in) :: value
      type(hinge_plan_t), intent(in) :: plan
    end function modulus_law

    !> Makes the cause of the diagnosis that corresponds to the effect, with all its texts. Its parameters are in the order of their
    !> values, and have no numbers, because these depend on the wing. The name of a parameter of each joint is the part NAME: before
    !> the name of the joint. In words, @ is the joint or the site.
    pure subroutine cause_teller(self, cause)
      import :: cause_t, effect_t
      class(effect_t), intent(in) :: self
      type(cause_t), intent(out) :: cause
    end subroutine cause_teller
  end interface
end module solid_effect

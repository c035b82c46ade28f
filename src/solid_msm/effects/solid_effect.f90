! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the record that describes an effect: its parameters with units, ranges and priors, its requirements, its law with the
!> derivative, and its texts for people. One module solid_effect_* makes one such record, and solid_effects lists them. Reports,
!> the catalogue of the diagnosis and the tables of the documents use these records.
!>
!> A law multiplies the stiffness that the usual parameters give, in three stages: single elements, then regions, then moments
!> that follow from the stiffness so far. An effect that adds a force independent of the stiffness is a load.
module solid_effect
  use base_cause, only: LAST_PLACE
  use base_kinds, only: rp
  use base_wording, only: wording_t
  use solid_effect_values, only: effects_t
  use solid_element_stiffness, only: stiffness_t
  use solid_extension, only: extensions_t
  use solid_junctions, only: hinge_plan_t
  use solid_layout, only: layout_t
  implicit none
  private
  public :: effect_t, effect_parameter_t, effect_site_t, effect_text_t

  integer, parameter, public :: STAGE_NONE = 0, STAGE_ELEMENTS = 1, STAGE_REGIONS = 2, STAGE_MOMENTS = 3, STAGE_LOADS = 4

  !> Requirements of effects: NEED_DISC to NEED_MEMBRANE, NEED_VEINS and NEED_MASS_PLACE on the wing, the others on data.
  integer, parameter, public :: NEED_NOTHING = 0, NEED_DISC = 1, NEED_SOFT_PLACE = 2, NEED_SIDED_JOINTS = 3, &
                                NEED_SIDED_VEINS = 4, NEED_NO_SLACK = 5, NEED_MEMBRANE = 6, NEED_UNSTRESSED_REST = 7, &
                                NEED_LEVELS = 8, NEED_BOTH_DIRECTIONS = 9, NEED_MODES_ABOUT_REST = 10, NEED_VEINS = 11, &
                                NEED_MASS_PLACE = 12, N_WING_NEEDS = 12
  integer, parameter :: MOST_PARAMETERS = 3 !< of one effect

  type :: effect_parameter_t
    character(20) :: name = ''        !< of a parameter of each joint: the part NAME: before the name of the joint
    character(12) :: unit = '1'
    logical :: is_log = .false.       !< it varies by factors and has no effect at 1; otherwise it has none at 0
    real(rp) :: lower = 0, upper = 0  !< in its unit
    real(rp) :: prior_sd = 1          !< of its coordinate
    real(rp) :: strong = 0            !< further start of fits, for effects whose tangent at null misleads; 0: none
    integer :: clamp_axis = 0         !< it lets the clamp turn about x (1) or y (2), by its value times the moment
  end type effect_parameter_t

  type :: effect_t
    integer :: n = 1                          !< number of parameters, unless `is_per_joint`
    type(effect_parameter_t) :: parameters(MOST_PARAMETERS)
    logical :: is_per_joint = .false.         !< every joint has the first parameter
    integer :: needs(4) = NEED_NOTHING        !< the first one that is not met is reported
    integer :: place = LAST_PLACE             !< in the catalogue of the diagnosis
    logical :: curves_rest = .false.          !< it bends the wing without a load
    integer :: stage = STAGE_NONE             !< of `apply`
    procedure(stiffness_law), pointer, nopass :: apply => null()
    procedure(stiffness_slope), pointer, nopass :: derive => null()
    procedure(modulus_law), pointer, nopass :: modulus => null()        !< factor on E of the veins at a hinge
    procedure(modulus_law), pointer, nopass :: modulus_slope => null()  !< of its logarithm
    procedure(text_teller), pointer, nopass :: tell => null()
  end type effect_t

  !> Holds the texts of an effect. In wordings, @ is the joint or the site.
  type :: effect_text_t
    character(:), allocatable :: cause        !< name of the entry in the catalogue of the diagnosis
    character(:), allocatable :: title, sentence !< of the entry
    character(:), allocatable :: definition   !< with the equation
    character(:), allocatable :: data         !< that make it detectable
    character(:), allocatable :: confused     !< what it may be confused with
    type(wording_t) :: words(MOST_PARAMETERS)
    type(wording_t) :: beyond(MOST_PARAMETERS)    !< for values of at least `far`
    real(rp) :: far(MOST_PARAMETERS) = huge(1.0_rp)
  end type effect_text_t

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

    !> Returns all texts of the effect.
    pure subroutine text_teller(text)
      import :: effect_text_t
      type(effect_text_t), intent(out) :: text
    end subroutine text_teller
  end interface
end module solid_effect

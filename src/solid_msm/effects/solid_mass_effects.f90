! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes possible errors of the inertia of a wing, as parameters with a null value at which they have no effect.
!>
!> | name | what | unit | null |
!> |---|---|---|---|
!> | `vein_mass` | factor on the mass of all veins | 1 | 1 |
!> | `membrane_mass` | factor on the mass of the membrane | 1 | 1 |
!> | `membrane_gradient` | g: mass of the membrane times exp(g (x/R - 1/2)), x from the root, R the extent along x | 1 | 0 |
!> | `added_mass` | factor on the air that strip theory lets the wing accelerate along z | 1 | 1 |
!> | `point_mass` | a mass at a site: dust, glue, a marker | kg | 0 |
!>
!> All effects of a mass are linear in the factors and in the point mass.
module solid_mass_effects
  use base_cause, only: cause_t, enlist, make_cause
  use base_kinds, only: rp
  use base_parameter, only: define_effect, parameter_t
  use base_wording, only: word_factor, word_plain, ASSUMED, SCALE_EXPONENT, SCALE_FACTOR
  use solid_added_mass, only: strip_added_mass
  use solid_effect, only: NEED_MASS_PLACE, NEED_MEMBRANE, NEED_VEINS
  use solid_mass, only: mass_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: mass_effects_t, mass_parts_t, list_mass_causes, added_mass_parameter

  integer, parameter, public :: MASS_VEINS = 1, MASS_MEMBRANE = 2, MASS_GRADIENT = 3, MASS_ADDED = 4, MASS_POINT = 5, &
                                N_MASS_EFFECTS = 5
  character(*), parameter :: MOTION = 'natural modes, records of motion or flights of wings that bend'

  !> Holds the values of the effects, and the site of the point mass.
  type :: mass_effects_t
    real(rp) :: veins = 1, membrane = 1, gradient = 0, added = 1
    real(rp) :: point = 0                        !< [kg]
    integer :: corner(3) = 1                     !< points of the wing that carry it
    real(rp) :: weight(3) = [1.0_rp, 0.0_rp, 0.0_rp] !< fractions of the mass at these points
  contains
    procedure :: get => effects_get
    procedure :: set => effects_set
  end type mass_effects_t

  !> Holds the parts of the mass of a wing.
  type :: mass_parts_t
    real(rp), allocatable :: veins(:), membrane(:), fixed(:) !< (n_points) [kg]; the last one is a known mass on the wing
    real(rp), allocatable :: added(:)    !< (n_points) [m^3] times the density of the fluid: along z
    real(rp), allocatable :: station(:)  !< (n_points) x/R - 1/2
  contains
    procedure :: init => parts_init
    procedure :: masses => parts_masses
    procedure :: derivative => parts_derivative
  end type mass_parts_t

contains

  !> Returns the causes that are errors of the inertia of a wing with this mass [kg]. Natural modes and records of motion show them.
  pure function list_mass_causes(wing_mass) result(list)
    real(rp), intent(in) :: wing_mass
    type(cause_t), allocatable :: list(:)
    call enlist(list, mass_of_veins())
    call enlist(list, mass_of_membrane())
    call enlist(list, gradient_of_membrane())
    call enlist(list, mass_at_point(wing_mass))
  end function list_mass_causes

  !> Returns the parameter of the air that moves with the wing, which a baseline fits.
  pure function added_mass_parameter() result(p)
    type(parameter_t) :: p
    call define_effect(p, 'added_mass', '1', .true., 0.1_rp, 5.0_rp, 0.3_rp)
  end function added_mass_parameter

  pure function mass_of_veins() result(cause)
    type(cause_t) :: cause
    type(parameter_t) :: p
    cause = make_cause('vein_mass', 'heavier or lighter veins', 'The veins weigh more or less than was assumed.', MOTION)
    cause%needs = [NEED_VEINS]
    call define_effect(p, 'vein_mass', '1', .true., 0.1_rp, 10.0_rp, 0.3_rp)
    call cause%add(MASS_VEINS, p)
    call word_factor(cause%parameters(1)%words, SCALE_FACTOR, 'The veins weigh more:', 'The veins weigh less:', 'heavier', &
                     'lighter', ASSUMED, 'as heavy as was assumed', 1.0_rp)
  end function mass_of_veins

  pure function mass_of_membrane() result(cause)
    type(cause_t) :: cause
    type(parameter_t) :: p
    cause = make_cause('membrane_mass', 'heavier or lighter membrane', 'The membrane weighs more or less than was assumed.', MOTION)
    cause%needs = [NEED_MEMBRANE]
    call define_effect(p, 'membrane_mass', '1', .true., 0.1_rp, 10.0_rp, 0.3_rp)
    call cause%add(MASS_MEMBRANE, p)
    call word_factor(cause%parameters(1)%words, SCALE_FACTOR, 'The membrane weighs more:', 'The membrane weighs less:', 'heavier', &
                     'lighter', ASSUMED, 'as heavy as was assumed', 1.0_rp)
  end function mass_of_membrane

  pure function gradient_of_membrane() result(cause)
    type(cause_t) :: cause
    type(parameter_t) :: p
    cause = make_cause('membrane_gradient', 'mass of the membrane that changes along the span', &
                       'The membrane is heavier, or lighter, toward the tip than at the root, as if its thickness changed.', MOTION)
    cause%needs = [NEED_MEMBRANE]
    call define_effect(p, 'membrane_gradient', '1', .false., -5.0_rp, 5.0_rp, 1.0_rp)
    call cause%add(MASS_GRADIENT, p)
    call word_factor(cause%parameters(1)%words, SCALE_EXPONENT, 'The membrane''s mass rises toward the tip:', &
                     'The membrane''s mass falls toward the tip:', 'more', 'less', 'there than at the root', 'that at the root', &
                     0.0_rp)
  end function gradient_of_membrane

  !> Returns the point mass, which is tried at many sites. Its prior is a fraction of the mass of the wing.
  pure function mass_at_point(wing_mass) result(cause)
    real(rp), intent(in) :: wing_mass
    type(cause_t) :: cause
    type(parameter_t) :: p
    cause = make_cause('point_mass', 'a mass that the model does not have', &
                       'Something sits on the wing at one place: dust, glue or a marker.', MOTION)
    cause%needs = [NEED_MASS_PLACE]
    call define_effect(p, 'point_mass', 'kg', .false., 0.0_rp, wing_mass, 0.05_rp*wing_mass)
    call cause%add(MASS_POINT, p, 'the mass of the wing')
    call word_plain(cause%parameters(1)%words, 'g', 'Something sits on the wing @:', 'The wing is lighter @:', '', '', '', 0.0_rp)
    cause%parameters(1)%words%factor = 1.0e3_rp
  end function mass_at_point

  !> Returns the value of effect i, in its unit.
  pure real(rp) function effects_get(self, i) result(value)
    class(mass_effects_t), intent(in) :: self
    integer, intent(in) :: i
    select case (i)
    case (MASS_VEINS)
      value = self%veins
    case (MASS_MEMBRANE)
      value = self%membrane
    case (MASS_GRADIENT)
      value = self%gradient
    case (MASS_ADDED)
      value = self%added
    case default
      value = self%point
    end select
  end function effects_get

  !> Sets the value of effect i, in its unit.
  pure subroutine effects_set(self, i, value)
    class(mass_effects_t), intent(inout) :: self
    integer, intent(in) :: i
    real(rp), intent(in) :: value
    select case (i)
    case (MASS_VEINS)
      self%veins = value
    case (MASS_MEMBRANE)
      self%membrane = value
    case (MASS_GRADIENT)
      self%gradient = value
    case (MASS_ADDED)
      self%added = value
    case default
      self%point = value
    end select
  end subroutine effects_set

  !> Splits the lumped `mass` of `wing` into the parts that the effects change, those of veins and of the membrane, and the rest;
  !> and finds the mass of air that moves with the wing (solid_added_mass).
  subroutine parts_init(self, wing, mass)
    class(mass_parts_t), intent(out) :: self
    type(wing_t), intent(in) :: wing
    type(mass_t), intent(in) :: mass
    real(rp) :: root, span
    root = sum(wing%points(1, wing%root))/size(wing%root)
    span = maxval(wing%points(1, :)) - minval(wing%points(1, :))
    self%veins = mass%of_veins
    self%membrane = mass%nodal - mass%of_veins - mass%of_point
    self%fixed = mass%of_point
    self%added = strip_added_mass(wing)
    self%station = (wing%points(1, :) - root)/span - 0.5_rp
  end subroutine parts_init

  !> Returns mass(3, n_all) [kg], for each direction of each point. Ghost points have no mass. The fluid around the wing has this
  !> density [kg/m^3], 0 in vacuum.
  pure subroutine parts_masses(self, effects, density, mass)
    class(mass_parts_t), intent(in) :: self
    type(mass_effects_t), intent(in) :: effects
    real(rp), intent(in) :: density
    real(rp), intent(out) :: mass(:, :)
    integer :: i, c
    mass = 0
    do i = 1, size(self%veins)
      mass(:, i) = effects%veins*self%veins(i) + effects%membrane*exp(effects%gradient*self%station(i))*self%membrane(i) + &
                   self%fixed(i)
      mass(3, i) = mass(3, i) + density*effects%added*self%added(i)
    end do
    do c = 1, 3
      mass(:, effects%corner(c)) = mass(:, effects%corner(c)) + effects%weight(c)*effects%point
    end do
  end subroutine parts_masses

  !> Returns slope(3, n_all), the derivative of these masses with respect to the coordinate of effect i: [kg] per log unit of the
  !> factors, per unit of the others. `effects` has the site of the point mass.
  pure subroutine parts_derivative(self, effects, density, i, slope)
    class(mass_parts_t), intent(in) :: self
    type(mass_effects_t), intent(in) :: effects
    real(rp), intent(in) :: density
    integer, intent(in) :: i
    real(rp), intent(out) :: slope(:, :)
    real(rp) :: membrane(size(self%membrane))
    integer :: n, c
    n = size(self%veins)
    membrane = effects%membrane*exp(effects%gradient*self%station)*self%membrane
    slope = 0
    select case (i)
    case (MASS_VEINS)
      slope(:, :n) = spread(effects%veins*self%veins, 1, 3)
    case (MASS_MEMBRANE)
      slope(:, :n) = spread(membrane, 1, 3)
    case (MASS_GRADIENT)
      slope(:, :n) = spread(self%station*membrane, 1, 3)
    case (MASS_ADDED)
      slope(3, :n) = density*effects%added*self%added
    case default
      do c = 1, 3
        slope(:, effects%corner(c)) = slope(:, effects%corner(c)) + effects%weight(c)
      end do
    end select
  end subroutine parts_derivative
end module solid_mass_effects

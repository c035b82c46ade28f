! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes veins that resist torsion: k tau^2/2 with the turning tau of the membrane's normal along the vein (solid_twist), k =
!> GJ/EI times the stiffness of the hinge in bending.
module solid_effect_torsion
  use base_kinds, only: rp
  use base_wording, only: word_fraction
  use solid_effect, only: effect_parameter_t, effect_site_t, effect_t, effect_text_t, NEED_MEMBRANE, NEED_SIDED_VEINS, &
                          STAGE_MOMENTS
  use solid_element_stiffness, only: stiffness_t
  implicit none
  private
  public :: torsion_effect

contains

  !> Returns the effect `torsion`: parameter, law and texts. Veins that twist freely have special modes, which a little torsional
  !> stiffness removes; the tangent at the null shows only those modes.
  pure function torsion_effect() result(effect)
    type(effect_t) :: effect
    real(rp), parameter :: STRONG = 0.2_rp ! a quarter of the value of solid circular veins
    effect%parameters(1) = effect_parameter_t('torsion', '1', .false., 0.0_rp, 10.0_rp, 1.0_rp, STRONG)
    effect%needs(:2) = [NEED_MEMBRANE, NEED_SIDED_VEINS]
    effect%stage = STAGE_MOMENTS
    effect%apply => apply_torsion
    effect%derive => derive_torsion
    effect%place = 110
    effect%tell => tell_torsion
  end function torsion_effect

  !> Sets the torsional stiffness of the veins.
  pure subroutine apply_torsion(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    stiffness%has_twist = .true.
    stiffness%twist = site%values(1)*stiffness%hinge
  end subroutine apply_torsion

  !> Returns the derivative of the stiffness with respect to GJ/EI.
  pure subroutine derive_torsion(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    associate (unused => site)
    end associate
    direction%twist = stiffness%hinge
    direction%has_twist = .true.
  end subroutine derive_torsion

  !> Returns the texts for this effect.
  pure subroutine tell_torsion(text)
    type(effect_text_t), intent(out) :: text
    text%cause = 'vein_torsion'
    text%title = 'veins that resist torsion'
    text%sentence = 'Veins resist being twisted about themselves, not only being bent.'
    text%definition = 'GJ/EI of veins and joints: k tau^2/2 with the turning tau of the membrane''s normal along the vein; '// &
                      '`[Wing] sided_veins = yes` makes room for it'
    text%data = 'a membrane'
    text%confused = 'D, E of single veins'
    call word_fraction(text%words(1), 'Veins resist being twisted: with', &
      'Veins resist being twisted less than was assumed: with', 'of their stiffness against bending (solid round veins: 0.77)', &
      0.0_rp)
  end subroutine tell_torsion
end module solid_effect_torsion

! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes veins that resist torsion: k tau^2/2 with the turning tau of the membrane's normal along the vein (solid_twist), k =
!> GJ/EI times the stiffness of the hinge in bending.
module solid_effect_torsion
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_fraction
  use solid_effect, only: effect_site_t, effect_t, NEED_MEMBRANE, NEED_SIDED_VEINS, STAGE_MOMENTS
  use solid_element_stiffness, only: stiffness_t
  implicit none
  private
  public :: torsion_effect

contains

  !> Returns the effect `torsion`. The header of this module has the law.
  pure function torsion_effect() result(effect)
    type(effect_t) :: effect
    effect%stage = STAGE_MOMENTS
    effect%apply => apply_torsion
    effect%derive => derive_torsion
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

  !> Makes the cause: parameters, needs, texts and words. Veins that twist freely have special modes, which a little torsional
  !> stiffness removes; the tangent at the null shows only those modes.
  pure subroutine tell_torsion(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    real(rp), parameter :: STRONG = 0.2_rp ! a quarter of the value of solid circular veins
    cause = make_cause('vein_torsion', 'veins that resist torsion', &
                       'Veins resist being twisted about themselves, not only being bent.', &
                       'a membrane')
    cause%definition = 'GJ/EI of veins and joints: k tau^2/2 with the turning tau of the membrane''s normal along the vein; '// &
                       '`[Wing] sided_veins = yes` makes room for it'
    cause%confused = 'D, E of single veins'
    cause%needs = [NEED_MEMBRANE, NEED_SIDED_VEINS]
    cause%place = 110
    call cause%add(0, effect_parameter('torsion', '1', self%is_log, 0.0_rp, 10.0_rp, 1.0_rp))
    cause%parameters(1)%value%strong = STRONG
    call word_fraction(cause%parameters(1)%words, 'Veins resist being twisted: with', &
      'Veins resist being twisted less than was assumed: with', 'of their stiffness against bending (solid round veins: 0.77)', &
      0.0_rp)
  end subroutine tell_torsion
end module solid_effect_torsion

! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a compliant clamp: it turns about x and about y by a compliance times the moment at the centre of the clamped points,
!> exactly for large turns. The law is that of solid_bent_wing; no stiffness of the wing changes.
module solid_effect_root
  use base_kinds, only: rp
  use base_wording, only: word_plain, DEGREES
  use solid_effect, only: effect_parameter_t, effect_t, effect_text_t, NEED_MODES_ABOUT_REST
  implicit none
  private
  public :: root_effect

contains

  !> Returns the effects `root_flap` and `root_twist`: parameters, law and texts. The header of this module has the law.
  pure function root_effect() result(effect)
    type(effect_t) :: effect
    effect%n = 2
    effect%parameters(1) = effect_parameter_t('root_flap', 'rad/(N m)', .false., 0.0_rp, 1.0e5_rp, 1.0e4_rp, clamp_axis=2)
    effect%parameters(2) = effect_parameter_t('root_twist', 'rad/(N m)', .false., 0.0_rp, 1.0e5_rp, 1.0e4_rp, clamp_axis=1)
    effect%needs(1) = NEED_MODES_ABOUT_REST
    effect%place = 10
    effect%tell => tell_root
  end function root_effect

  !> Returns the texts for this effect.
  pure subroutine tell_root(text)
    type(effect_text_t), intent(out) :: text
    text%cause = 'root_compliance'
    text%title = 'compliant root'
    text%sentence = 'The clamp or the wing''s root gives way: the whole wing turns about it, in proportion to the moment of '// &
                    'the force.'
    text%definition = 'the clamp turns about y and about x by this times the moment at the centre of the clamped points; '// &
                      'exact for large turns'
    text%data = 'loads at several places'
    text%confused = 'tilt of scans, joints near the root'
    call word_plain(text%words(1), '', 'The root gives way and lets the wing flap, by', &
      'The root lets the wing flap less than was assumed, by', '', '', 'for every uN m of moment about y', 0.0_rp)
    call word_plain(text%words(2), '', 'The root gives way and lets the wing twist, by', &
      'The root lets the wing twist less than was assumed, by', '', '', 'for every uN m of moment about x', 0.0_rp)
    text%words(:2)%factor = 1.0e-6_rp*DEGREES
    text%words(1)%unit = 'degrees'
    text%words(2)%unit = 'degrees'
  end subroutine tell_root
end module solid_effect_root

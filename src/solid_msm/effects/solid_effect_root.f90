! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a compliant clamp: it turns about x and about y by a compliance times the moment at the centre of the clamped points,
!> exactly for large turns. The law is that of solid_bent_wing; no stiffness of the wing changes.
module solid_effect_root
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_plain, DEGREES
  use solid_effect, only: effect_t, NEED_MODES_ABOUT_REST
  implicit none
  private
  public :: root_effect

contains

  !> Returns the effects `root_flap` and `root_twist`. The header of this module has the law.
  pure function root_effect() result(effect)
    type(effect_t) :: effect
    effect%n = 2
    effect%clamp_axis(:2) = [2, 1]
    effect%tell => tell_root
  end function root_effect

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_root(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('root_compliance', 'compliant root', &
                       'The clamp or the wing''s root gives way: the whole wing turns about it, in proportion to the moment of '// &
                       'the force.', &
                       'loads at several places')
    cause%definition = 'the clamp turns about y and about x by this times the moment at the centre of the clamped points; '// &
                       'exact for large turns'
    cause%confused = 'tilt of scans, joints near the root'
    cause%needs = [NEED_MODES_ABOUT_REST]
    cause%place = 10
    call cause%add(0, effect_parameter('root_flap', 'rad/(N m)', self%is_log, 0.0_rp, 1.0e5_rp, 1.0e4_rp))
    call cause%add(0, effect_parameter('root_twist', 'rad/(N m)', self%is_log, 0.0_rp, 1.0e5_rp, 1.0e4_rp))
    call word_plain(cause%parameters(1)%words, '', 'The root gives way and lets the wing flap, by', &
      'The root lets the wing flap less than was assumed, by', '', '', 'for every uN m of moment about y', 0.0_rp)
    call word_plain(cause%parameters(2)%words, '', 'The root gives way and lets the wing twist, by', &
      'The root lets the wing twist less than was assumed, by', '', '', 'for every uN m of moment about x', 0.0_rp)
    cause%parameters%words%factor = 1.0e-6_rp*DEGREES
    cause%parameters(1)%words%unit = 'degrees'
    cause%parameters(2)%words%unit = 'degrees'
  end subroutine tell_root
end module solid_effect_root

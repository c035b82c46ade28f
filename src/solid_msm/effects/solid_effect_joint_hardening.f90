! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes joints whose moment is not proportional to their turning: M = k Theta (1 + h Theta^2). All joints have the same h. What
!> single joints add to it is another effect.
module solid_effect_joint_hardening
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use solid_effect, only: effect_site_t, effect_t, NEED_LEVELS, STAGE_MOMENTS
  use solid_element_stiffness, only: stiffness_t
  use solid_hardening_words, only: word_joint
  implicit none
  private
  public :: joint_hardening_effect

contains

  !> Returns the effect `joint_hardening`, which all joints share. The header of this module has the law.
  pure function joint_hardening_effect() result(effect)
    type(effect_t) :: effect
    effect%stage = STAGE_MOMENTS
    effect%apply => apply_joint_hardening
    effect%derive => derive_joint_hardening
    effect%tell => tell_joint_hardening
  end function joint_hardening_effect

  !> Adds the hardening of all joints.
  pure subroutine apply_joint_hardening(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    where (site%plans%joint > 0) stiffness%hardening = stiffness%hardening + site%values(1)
  end subroutine apply_joint_hardening

  !> Returns the derivative of the stiffness with respect to the hardening of all joints.
  pure subroutine derive_joint_hardening(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    where (site%plans%joint > 0) direction%cubic = stiffness%hinge
  end subroutine derive_joint_hardening

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_joint_hardening(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('joint_hardening', 'joints that harden', &
                       'Joints of veins get stiffer, or give way, the more they are bent.', &
                       'two forces at one place; three distinguish it from an offset of the force')
    cause%definition = 'h: moment of every joint k Theta (1 + h Theta^2)'
    cause%confused = 'cuticle, load shifts if there is one level only'
    cause%needs = [NEED_LEVELS]
    cause%place = 120
    call cause%add(0, effect_parameter('joint_hardening', '1/rad^2', self%is_log, -1.0_rp, 1.0e5_rp, 10.0_rp))
    call word_joint(cause%parameters(1), 'All joints get stiffer the more they are bent:', &
                    'All joints give way the more they are bent:')
  end subroutine tell_joint_hardening
end module solid_effect_joint_hardening

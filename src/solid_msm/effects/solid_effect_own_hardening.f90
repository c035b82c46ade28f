! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes joints whose moment is not proportional to their turning, M = k Theta (1 + (h + h_j) Theta^2): h_j is what joint j adds
!> to the h of all joints.
module solid_effect_own_hardening
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use solid_effect, only: effect_site_t, effect_t, NEED_LEVELS, STAGE_MOMENTS
  use solid_element_stiffness, only: stiffness_t
  use solid_hardening_words, only: word_joint
  implicit none
  private
  public :: own_hardening_effect

contains

  !> Returns the effects `hardening:<joint>`, of one joint each. The header of this module has the law.
  pure function own_hardening_effect() result(effect)
    type(effect_t) :: effect
    effect%is_per_joint = .true.
    effect%stage = STAGE_MOMENTS
    effect%apply => apply_own_hardening
    effect%derive => derive_own_hardening
    effect%tell => tell_own_hardening
  end function own_hardening_effect

  !> Adds the hardening of each joint.
  pure subroutine apply_own_hardening(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    integer :: h
    do h = 1, size(site%plans)
      if (site%plans(h)%joint > 0) stiffness%hardening(h) = stiffness%hardening(h) + site%values(site%plans(h)%joint)
    end do
  end subroutine apply_own_hardening

  !> Returns the derivative of the stiffness with respect to the hardening of joint `k`.
  pure subroutine derive_own_hardening(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    where (site%plans%joint == site%k) direction%cubic = stiffness%hinge
  end subroutine derive_own_hardening

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_own_hardening(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('one_joint_hardening', 'one joint that hardens', &
                       'One joint gets stiffer, or gives way, the more it is bent.', &
                       'two forces at one place; three distinguish it from an offset of the force')
    cause%definition = 'what is added to h for this joint'
    cause%confused = 'joint_hardening, one-way joints'
    cause%needs = [NEED_LEVELS]
    cause%place = 130
    call cause%add(0, effect_parameter('hardening:', '1/rad^2', self%is_log, -1.0_rp, 1.0e5_rp, 10.0_rp))
    call word_joint(cause%parameters(1), 'Joint @ gets stiffer the more it is bent:', 'Joint @ gives way the more it is bent:')
  end subroutine tell_own_hardening
end module solid_effect_own_hardening

! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes one-way joints: a factor on the stiffness of a joint when it bends up, to +z of the unloaded wing (`lift` of
!> solid_hinge).
module solid_effect_one_way
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_factor, SCALE_FACTOR
  use solid_effect, only: effect_site_t, effect_t, NEED_BOTH_DIRECTIONS, NEED_SIDED_JOINTS, STAGE_MOMENTS
  use solid_element_stiffness, only: stiffness_t
  implicit none
  private
  public :: one_way_effect

contains

  !> Returns the effects `one_way:<joint>`, of one joint each. The header of this module has the law.
  pure function one_way_effect() result(effect)
    type(effect_t) :: effect
    effect%is_log = .true.
    effect%is_per_joint = .true.
    effect%stage = STAGE_MOMENTS
    effect%apply => apply_one_way
    effect%derive => derive_one_way
    effect%tell => tell_one_way
  end function one_way_effect

  !> Adds the difference between upward and downward stiffness of each joint.
  pure subroutine apply_one_way(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    integer :: h
    do h = 1, size(site%plans)
      if (site%effects%has_sides .and. site%plans(h)%joint > 0) &
        stiffness%lift(h) = stiffness%hinge(h)*(site%values(site%plans(h)%joint) - 1)
    end do
  end subroutine apply_one_way

  !> Returns the derivative of the stiffness with respect to the logarithm of the factor of joint `k`.
  pure subroutine derive_one_way(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    where (site%plans%joint == site%k .and. site%effects%has_sides) direction%lift = stiffness%hinge*site%values(site%k)
  end subroutine derive_one_way

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_one_way(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('one_way_joint', 'a one-way joint', &
                       'One joint bends more easily in one direction, up or down, than in the other.', &
                       'loads up and down')
    cause%definition = 'factor on the stiffness of one joint when it bends up, to +z of the unloaded wing; `[Wing] '// &
                       'sided_joints = yes` gives joints their sides'
    cause%confused = 'hardening and rest camber, if all loads are on one side'
    cause%needs = [NEED_BOTH_DIRECTIONS, NEED_SIDED_JOINTS]
    cause%place = 140
    call cause%add(0, effect_parameter('one_way:', '1', self%is_log, 0.1_rp, 10.0_rp, 0.5_rp))
    call word_factor(cause%parameters(1)%words, SCALE_FACTOR, 'Joint @ bends less easily up (+z) than down:', &
      'Joint @ bends more easily up (+z) than down:', 'stiffer', 'softer', 'upward than downward', &
      'as stiff upward as downward', 1.0_rp)
  end subroutine tell_one_way
end module solid_effect_one_way

! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes an additional soft hinge: a factor on the stiffness of the hinge at the point inside a vein that is nearest to a
!> fraction of its length.
module solid_effect_soft
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_factor, SCALE_FACTOR
  use solid_effect, only: effect_site_t, effect_t, NEED_SOFT_PLACE, STAGE_ELEMENTS
  use solid_element_stiffness, only: stiffness_t
  implicit none
  private
  public :: soft_effect, add_hinge

contains

  !> Returns the effect `soft`. The header of this module has the law.
  pure function soft_effect() result(effect)
    type(effect_t) :: effect
    effect%is_log = .true.
    effect%stage = STAGE_ELEMENTS
    effect%apply => apply_soft
    effect%derive => derive_soft
    effect%tell => tell_soft
  end function soft_effect

  !> Makes one hinge softer or stiffer.
  pure subroutine apply_soft(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    associate (h => site%layout%soft_hinge)
      if (h > 0) stiffness%hinge(h) = site%values(1)*stiffness%hinge(h)
    end associate
  end subroutine apply_soft

  !> Returns the derivative of the stiffness with respect to the logarithm of the factor.
  pure subroutine derive_soft(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    if (site%layout%soft_hinge > 0) call add_hinge(site%layout%soft_hinge, stiffness, direction)
  end subroutine derive_soft

  !> Sets `direction` at hinge h to the derivative of `stiffness` with respect to the logarithm of the stiffness of that hinge.
  pure subroutine add_hinge(h, stiffness, direction)
    integer, intent(in) :: h
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    direction%hinge(h) = stiffness%hinge(h)
    direction%cubic(h) = stiffness%cubic(h)
    direction%lift(h) = stiffness%lift(h)
    direction%twist(h) = stiffness%twist(h)
    direction%camber_moment(h) = stiffness%camber_moment(h)
    direction%has_arch = stiffness%has_arch
    direction%has_twist = stiffness%has_twist
  end subroutine add_hinge

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_soft(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('soft_place', 'a joint that the model does not have', &
                       'One vein is softer (or stiffer) at one place than it looks: an unseen joint, a crack or a repair.', &
                       'loads beyond the place')
    cause%definition = 'factor on the stiffness of the hinge at `[Wing] soft_place` = VEIN FRACTION: the point inside the vein '// &
                       'nearest to this fraction of its length'
    cause%confused = 'neighbouring joints, damage'
    cause%needs = [NEED_SOFT_PLACE]
    call cause%add(0, effect_parameter('soft', '1', self%is_log, 1.0e-4_rp, 1.0e2_rp, 2.0_rp))
    call word_factor(cause%parameters(1)%words, SCALE_FACTOR, 'Vein @ bends less easily:', 'Vein @ bends more easily:', 'stiffer', &
      'softer', 'there than it looks', 'as stiff there as it looks', 1.0_rp)
  end subroutine tell_soft
end module solid_effect_soft

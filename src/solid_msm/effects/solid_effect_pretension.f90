! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a membrane that is stretched in the unloaded wing: an isotropic tension T [N/m] between the veins. Each spring
!> carries the tension of the width of membrane that it represents (solid_tension).
module solid_effect_pretension
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_plain
  use solid_effect, only: effect_site_t, effect_t, NEED_MEMBRANE, NEED_NO_SLACK, NEED_UNSTRESSED_REST, STAGE_LOADS
  use solid_element_stiffness, only: stiffness_t
  implicit none
  private
  public :: pretension_effect

contains

  !> Returns the effect `pretension`. The header of this module has the law.
  pure function pretension_effect() result(effect)
    type(effect_t) :: effect
    effect%stage = STAGE_LOADS
    effect%apply => apply_pretension
    effect%derive => derive_pretension
    effect%tell => tell_pretension
  end function pretension_effect

  !> Sets the tension of the springs in the unloaded wing.
  pure subroutine apply_pretension(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    stiffness%has_tension = .true.
    stiffness%tension = site%values(1)*site%layout%spring_width
  end subroutine apply_pretension

  !> Returns the derivative of the stiffness with respect to the tension.
  pure subroutine derive_pretension(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    associate (unused => stiffness)
    end associate
    direction%tension = site%layout%spring_width
    direction%has_tension = .true.
  end subroutine derive_pretension

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_pretension(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('pretension', 'stretched membrane', &
                       'The membrane is stretched between the veins already when nothing pushes, like a drumskin.', &
                       'a membrane')
    cause%definition = 'T: isotropic tension of the membrane in the unloaded wing; springs carry T l0 (cot a + cot b)/2, a '// &
                       'and b opposite to them'
    cause%confused = 'D, at small loads'
    cause%needs = [NEED_UNSTRESSED_REST, NEED_NO_SLACK, NEED_MEMBRANE]
    cause%place = 90
    call cause%add(0, effect_parameter('pretension', 'N/m', self%is_log, 0.0_rp, 10.0_rp, 0.1_rp))
    call word_plain(cause%parameters(1)%words, 'N/m', 'The membrane is stretched when nothing pushes, by', &
      'The membrane is stretched less than was assumed when nothing pushes, by', '', '', '', 0.0_rp)
  end subroutine tell_pretension
end module solid_effect_pretension

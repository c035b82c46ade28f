! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes veins whose material changes along the span: E exp(g s) with the station s = (x - x_root)/R - 1/2, x_root the mean of
!> the clamped points and R the extent of the wing along x. A hinge has the E of its point. Joints with a stiffness of their own
!> are not affected.
module solid_effect_gradient
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_factor, SCALE_EXPONENT
  use solid_effect, only: effect_t
  use solid_junctions, only: hinge_plan_t
  implicit none
  private
  public :: gradient_effect

contains

  !> Returns the effect `E_gradient`. The header of this module has the law.
  pure function gradient_effect() result(effect)
    type(effect_t) :: effect
    effect%modulus => gradient_factor
    effect%modulus_slope => gradient_slope
    effect%tell => tell_gradient
  end function gradient_effect

  !> Returns the factor on E, exactly 1 for a gradient of 0.
  pure real(rp) function gradient_factor(value, plan) result(factor)
    real(rp), intent(in) :: value
    type(hinge_plan_t), intent(in) :: plan
    factor = exp(value*plan%station)
  end function gradient_factor

  !> Returns the derivative of the logarithm of E.
  pure real(rp) function gradient_slope(value, plan) result(slope)
    real(rp), intent(in) :: value
    type(hinge_plan_t), intent(in) :: plan
    slope = plan%station + 0*value
  end function gradient_slope

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_gradient(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('E_gradient', 'stiffness that changes along the span', &
                       'The veins'' material is softer or stiffer toward the tip than at the root.', &
                       'loads along the span')
    cause%definition = 'E exp(g s), s = (x - x_root)/R - 1/2; joints with a stiffness of their own do not take part'
    cause%confused = 'thinner veins, E of single veins; E and all joints take up most of it'
    cause%place = 30
    call cause%add(0, effect_parameter('E_gradient', '1', self%is_log, -5.0_rp, 5.0_rp, 1.0_rp))
    call word_factor(cause%parameters(1)%words, SCALE_EXPONENT, 'E rises toward the tip:', 'E falls toward the tip:', 'higher', &
      'lower', 'than at the root', 'that at the root', 0.0_rp)
  end subroutine tell_gradient
end module solid_effect_gradient

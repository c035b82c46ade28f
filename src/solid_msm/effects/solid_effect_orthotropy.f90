! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a membrane that is stiffer in one direction: springs times 1 + a cos 2 phi, phi their angle to x.
module solid_effect_orthotropy
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_factor, SCALE_CONTRAST
  use solid_effect, only: effect_site_t, effect_t, STAGE_ELEMENTS
  use solid_element_stiffness, only: stiffness_t
  use solid_extension, only: SPRING_MEMBRANE
  implicit none
  private
  public :: orthotropy_effect

contains

  !> Returns the effect `orthotropy`. The header of this module has the law.
  pure function orthotropy_effect() result(effect)
    type(effect_t) :: effect
    effect%stage = STAGE_ELEMENTS
    effect%apply => apply_orthotropy
    effect%derive => derive_orthotropy
    effect%tell => tell_orthotropy
  end function orthotropy_effect

  !> Makes the springs of the membrane stiffer along x than along y, or softer.
  pure subroutine apply_orthotropy(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    integer :: s
    do s = 1, site%springs%n
      if (site%springs%family(s) == SPRING_MEMBRANE) &
        stiffness%extension(s) = stiffness%extension(s)*(1 + site%values(1)*site%layout%spring_cosine(s))
    end do
  end subroutine apply_orthotropy

  !> Returns the derivative of the stiffness with respect to the contrast.
  pure subroutine derive_orthotropy(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    real(rp) :: factor
    integer :: s
    do s = 1, site%springs%n
      if (site%springs%family(s) /= SPRING_MEMBRANE) cycle
      factor = site%layout%spring_cosine(s)
      direction%extension(s) = stiffness%extension(s)*factor/(1 + site%values(site%k)*factor)
    end do
  end subroutine derive_orthotropy

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_orthotropy(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('orthotropy', 'membrane that is stiffer in one direction', &
                       'The membrane stretches less easily along the span than across it, or the other way round.', &
                       'large deflections')
    cause%definition = 'springs of the membrane times 1 + a cos 2 phi, phi their angle to x'
    cause%confused = 'k_membrane; small in most tests'
    cause%place = 80
    call cause%add(0, effect_parameter('orthotropy', '1', self%is_log, -0.9_rp, 0.9_rp, 0.5_rp))
    call word_factor(cause%parameters(1)%words, SCALE_CONTRAST, 'The membrane stretches less easily along the span:', &
      'The membrane stretches more easily along the span:', 'stiffer', 'softer', 'along it than across it', &
      'as stiff along it as across it', 0.0_rp)
  end subroutine tell_orthotropy
end module solid_effect_orthotropy

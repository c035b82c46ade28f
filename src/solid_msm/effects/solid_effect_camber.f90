! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a wing that is curved where it is free of stress, with the same curvatures [1/m] everywhere: z0 = (k_xx x^2 + k_yy y^2
!> + 2 k_xy x y)/2 above the plane of the wing file. Moments bend the edges of the membrane (solid_arch) and the veins
!> (`camber_evaluate` of solid_twist); springs and the clamp are those of the flat wing.
module solid_effect_camber
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_plain
  use solid_effect, only: effect_site_t, effect_t, NEED_MEMBRANE, NEED_SIDED_VEINS, NEED_UNSTRESSED_REST, STAGE_MOMENTS
  use solid_element_stiffness, only: stiffness_t
  implicit none
  private
  public :: camber_effect

  character(*), parameter :: CURVED = 'The wing is curved when nothing pushes:', &
                             TWISTED = 'The wing is twisted when nothing pushes:'

contains

  !> Returns the effects `camber_span`, `camber_chord` and `camber_twist`. The header of this module has the law.
  pure function camber_effect() result(effect)
    type(effect_t) :: effect
    effect%n = 3
    effect%curves_rest = .true.
    effect%stage = STAGE_MOMENTS
    effect%apply => apply_camber
    effect%derive => derive_camber
    effect%tell => tell_camber
  end function camber_effect

  !> Adds the moments of a wing that is curved without loads.
  pure subroutine apply_camber(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    stiffness%has_arch = .true.
    stiffness%arch = (stiffness%plate + stiffness%edge)*matmul(site%values, site%layout%edge_bend)
    stiffness%camber_moment = stiffness%hinge*matmul(site%values, site%layout%hinge_turn)
  end subroutine apply_camber

  !> Returns the derivative of the stiffness with respect to curvature `k`.
  pure subroutine derive_camber(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    direction%arch = (stiffness%plate + stiffness%edge)*site%layout%edge_bend(site%k, :)
    direction%camber_moment = stiffness%hinge*site%layout%hinge_turn(site%k, :)
    direction%has_arch = .true.
  end subroutine derive_camber

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_camber(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('camber', 'a wing that is not flat', &
                       'The wing is curved or twisted without a load, and therefore stiffer or softer.', &
                       'a membrane')
    cause%definition = 'curvatures xx, yy, xy of membrane and veins where they are free of stress; springs and the clamp are '// &
                       'those of the flat wing; the unloaded shape is the equilibrium of all; needs `[Wing] sided_veins = yes`'
    cause%confused = 'one-way joints, tilted forces'
    cause%needs = [NEED_UNSTRESSED_REST, NEED_MEMBRANE, NEED_SIDED_VEINS]
    cause%place = 100
    call cause%add(0, effect_parameter('camber_span', '1/m', self%is_log, -20.0_rp, 20.0_rp, 3.0_rp))
    call cause%add(0, effect_parameter('camber_chord', '1/m', self%is_log, -300.0_rp, 300.0_rp, 30.0_rp))
    call cause%add(0, effect_parameter('camber_twist', '1/m', self%is_log, -60.0_rp, 60.0_rp, 10.0_rp))
    call word_plain(cause%parameters(1)%words, 'per m', CURVED, CURVED, 'along the span, with root and tip toward +z', &
      'along the span, with root and tip toward -z', '', 0.0_rp)
    call word_plain(cause%parameters(2)%words, 'per m', CURVED, CURVED, 'across the span, with both edges toward +z', &
      'across the span, with both edges toward -z', '', 0.0_rp)
    call word_plain(cause%parameters(3)%words, 'per m', TWISTED, TWISTED, 'with its edge at +y toward +z at the tip', &
      'with its edge at +y toward -z at the tip', '', 0.0_rp)
  end subroutine tell_camber
end module solid_effect_camber

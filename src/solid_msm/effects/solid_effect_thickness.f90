! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a membrane whose thickness changes along the span: t exp(g s) with the station s of solid_effect_gradient. Its springs
!> carry in proportion to t, it bends with D exp(3 g s), and it weighs in proportion to t (mass_effects_t). The station is that of
!> the middle of a spring, and the mean of the centroids of both triangles at an edge.
module solid_effect_thickness
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_factor, SCALE_EXPONENT
  use solid_effect, only: effect_site_t, effect_t, NEED_MEMBRANE, STAGE_ELEMENTS
  use solid_element_stiffness, only: stiffness_t
  use solid_extension, only: SPRING_VEIN
  implicit none
  private
  public :: thickness_effect

contains

  !> Returns the effect `thickness_gradient`. The header of this module has the law.
  pure function thickness_effect() result(effect)
    type(effect_t) :: effect
    effect%stage = STAGE_ELEMENTS
    effect%is_thickness = .true.
    effect%apply => apply_thickness
    effect%derive => derive_thickness
    effect%tell => tell_thickness
  end function thickness_effect

  !> Makes the membrane thicker toward the tip, or thinner.
  pure subroutine apply_thickness(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    integer :: i
    do i = 1, site%springs%n
      if (site%springs%family(i) /= SPRING_VEIN) &
        stiffness%extension(i) = stiffness%extension(i)*exp(site%values(1)*site%layout%station(site%layout%spring_site(1, i)))
    end do
    do i = 1, size(stiffness%edge)
      stiffness%edge(i) = (stiffness%plate + stiffness%edge(i))*exp(3*site%values(1)*edge_station(site, i)) - stiffness%plate
    end do
    stiffness%has_edges = .true.
  end subroutine apply_thickness

  !> Returns the derivative of the stiffness with respect to g.
  pure subroutine derive_thickness(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    integer :: i
    do i = 1, site%springs%n
      if (site%springs%family(i) /= SPRING_VEIN) &
        direction%extension(i) = stiffness%extension(i)*site%layout%station(site%layout%spring_site(1, i))
    end do
    do i = 1, size(stiffness%edge)
      direction%edge(i) = 3*edge_station(site, i)*(stiffness%plate + stiffness%edge(i))
      direction%arch(i) = 3*edge_station(site, i)*stiffness%arch(i)
    end do
    direction%has_edges = .true.
    direction%has_arch = stiffness%has_arch
  end subroutine derive_thickness

  !> Returns the station of an edge.
  pure real(rp) function edge_station(site, i) result(station)
    type(effect_site_t), intent(in) :: site
    integer, intent(in) :: i
    station = site%layout%station(sum(site%layout%edge_site(1, :, i))/2)
  end function edge_station

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_thickness(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('thickness_gradient', 'membrane whose thickness changes along the span', &
                       'The membrane is thicker, or thinner, toward the tip than at the root: it weighs more there and bends '// &
                       'less.', &
                       'loads along the span, natural modes or records of motion')
    cause%definition = 'springs of the membrane times exp(g s), D exp(3 g s), mass of the membrane times exp(g s), '// &
                       's = (x - x_root)/R - 1/2'
    cause%confused = 'a mass of the membrane that changes along the span, D'
    cause%place = 85
    cause%needs = [NEED_MEMBRANE]
    call cause%add(0, effect_parameter('thickness_gradient', '1', self%is_log, -2.0_rp, 2.0_rp, 0.5_rp))
    call word_factor(cause%parameters(1)%words, SCALE_EXPONENT, 'The membrane is thicker toward the tip:', &
      'The membrane is thinner toward the tip:', 'thicker', 'thinner', 'there than at the root', 'as thick as at the root', 0.0_rp)
  end subroutine tell_thickness
end module solid_effect_thickness

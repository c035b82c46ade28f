! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes local damage (or a patch): all stiffness in a disc is multiplied by a factor f.
!>
!> At the distance r from the centre the factor is 1 + (f - 1) w, w = s^2 (3 - 2 s), s = (1.05 - r/a)/0.1 cut to 0..1: w is 1 inside
!> the disc, 1/2 at the radius a, and falls to 0 in a smooth rim whose width is a tenth of a. The site of an element is its middle:
!> the midpoint of a spring, the point of a hinge, and for an edge of the membrane the mean of the centroids of its two triangles.
module solid_effect_damage
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use base_wording, only: word_factor, SCALE_FACTOR
  use solid_disc, only: damage_weight => disc_weight
  use solid_effect, only: effect_site_t, effect_t, NEED_DISC, STAGE_REGIONS
  use solid_element_stiffness, only: stiffness_t
  use solid_layout, only: layout_t
  implicit none
  private
  public :: damage_effect, add_damage, damage_weight

contains

  !> Returns the effect `damage`. The header of this module has the law.
  pure function damage_effect() result(effect)
    type(effect_t) :: effect
    effect%is_log = .true.
    effect%stage = STAGE_REGIONS
    effect%apply => apply_damage
    effect%derive => derive_damage
    effect%tell => tell_damage
  end function damage_effect

  !> Makes all elements in the damaged disc softer or stiffer.
  pure subroutine apply_damage(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    real(rp) :: lost
    integer :: s, h, e
    if (.not. site%effects%has_damage()) return
    lost = site%values(1) - 1
    do s = 1, site%springs%n
      stiffness%extension(s) = stiffness%extension(s)*(1 + lost*damage_weight(site%effects%disc, site%layout%spring_site(:, s)))
    end do
    do h = 1, size(site%plans)
      stiffness%hinge(h) = stiffness%hinge(h)*(1 + lost*damage_weight(site%effects%disc, site%layout%hinge_site(:, h)))
    end do
    do e = 1, size(stiffness%edge)
      stiffness%edge(e) = stiffness%edge(e) + (stiffness%plate + stiffness%edge(e))*lost* &
                          (damage_weight(site%effects%disc, site%layout%edge_site(:, 1, e)) + &
                           damage_weight(site%effects%disc, site%layout%edge_site(:, 2, e)))/2
    end do
    stiffness%has_edges = .true.
  end subroutine apply_damage

  !> Returns the derivative of the stiffness with respect to the logarithm of the factor.
  pure subroutine derive_damage(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    call add_damage(site%effects%disc, site%values(1), site%springs%n, site%layout, stiffness, direction)
  end subroutine derive_damage

  !> Sets `direction` to f w/(1 + (f - 1) w) times `stiffness`, which has damage with the factor f in disc = (x, y, radius) [m].
  !> With f = 1 that is w times the stiffness without damage: the derivative per log unit of the factor. w is that of solid_disc.
  pure subroutine add_damage(disc, f, n_springs, layout, stiffness, direction)
    real(rp), intent(in) :: disc(3), f
    integer, intent(in) :: n_springs
    type(layout_t), intent(in) :: layout
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    real(rp) :: w
    integer :: i
    associate (k => stiffness)
      do i = 1, n_springs
        w = damage_weight(disc, layout%spring_site(:, i))
        direction%extension(i) = k%extension(i)*fraction_of(w)
      end do
      do i = 1, size(k%hinge)
        w = damage_weight(disc, layout%hinge_site(:, i))
        direction%hinge(i) = k%hinge(i)*fraction_of(w)
        direction%cubic(i) = k%cubic(i)*fraction_of(w)
        direction%lift(i) = k%lift(i)*fraction_of(w)
        direction%twist(i) = k%twist(i)*fraction_of(w)
        direction%camber_moment(i) = k%camber_moment(i)*fraction_of(w)
      end do
      do i = 1, size(k%edge)
        w = (damage_weight(disc, layout%edge_site(:, 1, i)) + damage_weight(disc, layout%edge_site(:, 2, i)))/2
        direction%edge(i) = (k%plate + k%edge(i))*fraction_of(w)
        direction%arch(i) = k%arch(i)*fraction_of(w)
      end do
      direction%has_edges = .true.
      direction%has_arch = k%has_arch
      direction%has_twist = k%has_twist
    end associate

  contains

    pure real(rp) function fraction_of(weight)
      real(rp), intent(in) :: weight
      fraction_of = f*weight/(1 + (f - 1)*weight)
    end function fraction_of

  end subroutine add_damage

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_damage(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    cause = make_cause('damage', 'a damaged region', &
                       'Veins and membrane of one region are softer, as if torn, or stiffer than the rest.', &
                       'loads beyond the disc')
    cause%definition = 'factor on all stiffness in the disc `[Wing] damage_disc` = x y radius [m], with a rim of a tenth of '// &
                       'the radius'
    cause%confused = 'a soft place, neighbouring joints'
    cause%needs = [NEED_DISC]
    call cause%add(0, effect_parameter('damage', '1', self%is_log, 1.0e-2_rp, 1.0e2_rp, 1.0_rp))
    call word_factor(cause%parameters(1)%words, SCALE_FACTOR, 'Veins and membrane @ are stiffer:', &
      'Veins and membrane @ are softer:', 'stiffer', 'softer', 'than was assumed', 'as stiff as was assumed', 1.0_rp)
  end subroutine tell_damage
end module solid_effect_damage

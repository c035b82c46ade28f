! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes veins whose moment is not proportional to their curvature. All hinges that are no joints are pieces of cuticle with M =
!> EI kappa (1 + c kappa^2), the curvature kappa = Theta/l over the length l that bends. So M = k Theta (1 + h Theta^2) with h =
!> c/l^2.
module solid_effect_cuticle
  use base_cause, only: cause_t, make_cause
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter
  use solid_effect, only: effect_site_t, effect_t, NEED_LEVELS, STAGE_MOMENTS
  use solid_element_stiffness, only: stiffness_t
  use solid_hardening_words, only: word_hardening
  use solid_junctions, only: hinge_plan_t
  implicit none
  private
  public :: cuticle_effect

contains

  !> Returns the effect `cuticle`. The header of this module has the law.
  pure function cuticle_effect() result(effect)
    type(effect_t) :: effect
    effect%stage = STAGE_MOMENTS
    effect%apply => apply_cuticle
    effect%derive => derive_cuticle
    effect%tell => tell_cuticle
  end function cuticle_effect

  !> Adds the hardening of the veins.
  pure subroutine apply_cuticle(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    integer :: h
    do h = 1, size(site%plans)
      if (site%plans(h)%joint > 0) cycle
      stiffness%hardening(h) = stiffness%hardening(h) + site%values(1)/bending_length(site%plans(h))**2
    end do
  end subroutine apply_cuticle

  !> Returns the derivative of the stiffness with respect to the hardening of the veins.
  pure subroutine derive_cuticle(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    real(rp) :: factor
    integer :: h
    do h = 1, size(site%plans)
      factor = 1/bending_length(site%plans(h))**2
      if (site%plans(h)%joint == 0) direction%cubic(h) = stiffness%hinge(h)*factor
    end do
  end subroutine derive_cuticle

  !> Returns the length [m] that bends: half of both segments, or of the free segment at the clamped root.
  pure real(rp) function bending_length(plan) result(length)
    type(hinge_plan_t), intent(in) :: plan
    length = sum(plan%lengths)/2
  end function bending_length

  !> Makes the cause: parameters, needs, texts and words.
  pure subroutine tell_cuticle(self, cause)
    class(effect_t), intent(in) :: self
    type(cause_t), intent(out) :: cause
    character(*), parameter :: MORE = 'Veins get stiffer the more they are bent:', &
                               LESS = 'Veins give way the more they are bent:'
    real(rp), parameter :: WEAK = 5.0e-6_rp ! [m^2] from this value on, reports give the stiffness at a radius of 10 mm
    cause = make_cause('cuticle', 'nonlinear cuticle', &
                       'The veins themselves get stiffer, or soften, the more they are bent.', &
                       'two forces at one place; three distinguish it from an offset of the force')
    cause%definition = 'c: moment of all other hinges EI kappa (1 + c kappa^2), kappa = Theta over the length that bends'
    cause%confused = 'joint_hardening'
    cause%needs = [NEED_LEVELS]
    cause%place = 150
    call cause%add(0, effect_parameter('cuticle', 'm^2', self%is_log, -1.0e-5_rp, 1.0e-3_rp, 1.0e-5_rp))
    associate (one => cause%parameters(1))
      call word_hardening(one%words, MORE//' at a radius of 1 mm', LESS//' at a radius of 1 mm', 1.0e6_rp)
      call word_hardening(one%beyond, MORE//' at a radius of 10 mm', LESS//' at a radius of 10 mm', 1.0e4_rp)
      one%far = WEAK
    end associate
  end subroutine tell_cuticle
end module solid_effect_cuticle

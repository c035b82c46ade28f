! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes hinges whose moment is not proportional to their turning: M = k Theta (1 + h Theta^2).
!>
!> Every joint has the common h and an individual one. All other hinges are pieces of cuticle with M = EI kappa (1 + c
!> kappa^2), the curvature kappa = Theta/l over the length l that bends, so that h = c/l^2.
module solid_effect_hardening
  use base_kinds, only: rp
  use base_wording, only: word_factor, DEGREES, SCALE_LINEAR
  use solid_effect, only: effect_parameter_t, effect_site_t, effect_t, effect_text_t, NEED_LEVELS, STAGE_MOMENTS
  use solid_element_stiffness, only: stiffness_t
  use solid_junctions, only: hinge_plan_t
  implicit none
  private
  public :: joint_hardening_effect, own_hardening_effect, cuticle_effect

  real(rp), parameter :: STRONG = 100.0_rp   !< [1/rad^2] from this value on, reports give the stiffness at 1 degree
  real(rp), parameter :: WEAK = 5.0e-6_rp    !< [m^2] from this value on, reports give the stiffness at a radius of 10 mm

contains

  !> Returns the effect `joint_hardening`, which all joints share: parameter, law and texts.
  pure function joint_hardening_effect() result(effect)
    type(effect_t) :: effect
    effect%parameters(1) = effect_parameter_t('joint_hardening', '1/rad^2', .false., -1.0_rp, 1.0e5_rp, 10.0_rp)
    effect%needs(1) = NEED_LEVELS
    effect%stage = STAGE_MOMENTS
    effect%apply => apply_joint_hardening
    effect%derive => derive_joint_hardening
    effect%place = 120
    effect%tell => tell_joint_hardening
  end function joint_hardening_effect

  !> Adds the hardening of all joints.
  pure subroutine apply_joint_hardening(site, stiffness)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(inout) :: stiffness
    where (site%plans%joint > 0) stiffness%hardening = stiffness%hardening + site%values(1)
  end subroutine apply_joint_hardening

  !> Returns the derivative of the stiffness with respect to the hardening of all joints.
  pure subroutine derive_joint_hardening(site, stiffness, direction)
    type(effect_site_t), intent(in) :: site
    type(stiffness_t), intent(in) :: stiffness
    type(stiffness_t), intent(inout) :: direction
    where (site%plans%joint > 0) direction%cubic = stiffness%hinge
  end subroutine derive_joint_hardening

  !> Returns the effects `hardening:<joint>`, of one joint each: parameter, law and texts.
  pure function own_hardening_effect() result(effect)
    type(effect_t) :: effect
    effect%parameters(1) = effect_parameter_t('hardening:', '1/rad^2', .false., -1.0_rp, 1.0e5_rp, 10.0_rp)
    effect%is_per_joint = .true.
    effect%needs(1) = NEED_LEVELS
    effect%stage = STAGE_MOMENTS
    effect%apply => apply_own_hardening
    effect%derive => derive_own_hardening
    effect%place = 130
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

  !> Returns the effect `cuticle`, the hardening of the veins: parameter, law and texts.
  pure function cuticle_effect() result(effect)
    type(effect_t) :: effect
    effect%parameters(1) = effect_parameter_t('cuticle', 'm^2', .false., -1.0e-5_rp, 1.0e-3_rp, 1.0e-5_rp)
    effect%needs(1) = NEED_LEVELS
    effect%stage = STAGE_MOMENTS
    effect%apply => apply_cuticle
    effect%derive => derive_cuticle
    effect%place = 150
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

  !> Returns the texts for the hardening of all joints.
  pure subroutine tell_joint_hardening(text)
    type(effect_text_t), intent(out) :: text
    text%cause = 'joint_hardening'
    text%title = 'joints that harden'
    text%sentence = 'Joints of veins get stiffer, or give way, the more they are bent.'
    text%definition = 'h: moment of every joint k Theta (1 + h Theta^2)'
    text%data = 'two forces at one place; three distinguish it from an offset of the force'
    text%confused = 'cuticle, load shifts if there is one level only'
    call word_factor(text%words(1), SCALE_LINEAR, 'All joints get stiffer the more they are bent: at 10 degrees', &
      'All joints give way the more they are bent: at 10 degrees', 'stiffer', 'softer', 'than when straight', &
      'as stiff as when straight', 0.0_rp)
    text%words(1)%factor = (10/DEGREES)**2
    call word_factor(text%beyond(1), SCALE_LINEAR, 'All joints get stiffer the more they are bent: at 1 degree', &
      'All joints give way the more they are bent: at 1 degree', 'stiffer', 'softer', 'than when straight', &
      'as stiff as when straight', 0.0_rp)
    text%beyond(1)%factor = (1/DEGREES)**2
    text%far(1) = STRONG
  end subroutine tell_joint_hardening

  !> Returns the texts for the hardening of one joint.
  pure subroutine tell_own_hardening(text)
    type(effect_text_t), intent(out) :: text
    text%cause = 'one_joint_hardening'
    text%title = 'one joint that hardens'
    text%sentence = 'One joint gets stiffer, or gives way, the more it is bent.'
    text%definition = 'what is added to h for this joint'
    text%data = 'two forces at one place; three distinguish it from an offset of the force'
    text%confused = 'joint_hardening, one-way joints'
    call word_factor(text%words(1), SCALE_LINEAR, 'Joint @ gets stiffer the more it is bent: at 10 degrees', &
      'Joint @ gives way the more it is bent: at 10 degrees', 'stiffer', 'softer', 'than when straight', &
      'as stiff as when straight', 0.0_rp)
    text%words(1)%factor = (10/DEGREES)**2
    call word_factor(text%beyond(1), SCALE_LINEAR, 'Joint @ gets stiffer the more it is bent: at 1 degree', &
      'Joint @ gives way the more it is bent: at 1 degree', 'stiffer', 'softer', 'than when straight', &
      'as stiff as when straight', 0.0_rp)
    text%beyond(1)%factor = (1/DEGREES)**2
    text%far(1) = STRONG
  end subroutine tell_own_hardening

  !> Returns the texts for the hardening of the veins.
  pure subroutine tell_cuticle(text)
    type(effect_text_t), intent(out) :: text
    text%cause = 'cuticle'
    text%title = 'nonlinear cuticle'
    text%sentence = 'The veins themselves get stiffer, or soften, the more they are bent.'
    text%definition = 'c: moment of all other hinges EI kappa (1 + c kappa^2), kappa = Theta over the length that bends'
    text%data = 'two forces at one place; three distinguish it from an offset of the force'
    text%confused = 'joint_hardening'
    call word_factor(text%words(1), SCALE_LINEAR, 'Veins get stiffer the more they are bent: at a radius of 1 mm', &
      'Veins give way the more they are bent: at a radius of 1 mm', 'stiffer', 'softer', 'than when straight', &
      'as stiff as when straight', 0.0_rp)
    text%words(1)%factor = 1.0e6_rp
    call word_factor(text%beyond(1), SCALE_LINEAR, 'Veins get stiffer the more they are bent: at a radius of 10 mm', &
      'Veins give way the more they are bent: at a radius of 10 mm', 'stiffer', 'softer', 'than when straight', &
      'as stiff as when straight', 0.0_rp)
    text%beyond(1)%factor = 1.0e4_rp
    text%far(1) = WEAK
  end subroutine tell_cuticle
end module solid_effect_hardening

! SPDX-License-Identifier: GPL-3.0-or-later
!> Hinges whose moment is not proportional to their turning: M = k Theta (1 + h Theta^2).
!>
!> Joints have the common h and one of their own. All other hinges are pieces of cuticle with M = EI kappa (1 + c
!> kappa^2), the curvature kappa = Theta/l over the length l that bends, so that h = c/l^2.
module solid_effect_hardening
  use base_kinds, only: rp
  use solid_effects, only: effects_t
  use solid_junctions, only: hinge_plan_t
  implicit none
  private
  public :: hardening_of, bending_length

contains

  !> h [1/rad^2] of a hinge.
  pure real(rp) function hardening_of(effects, plan) result(h)
    type(effects_t), intent(in) :: effects
    type(hinge_plan_t), intent(in) :: plan
    if (plan%joint > 0) then
      h = effects%hardening + effects%joint_hardening(plan%joint)
    else
      h = effects%cuticle/bending_length(plan)**2
    end if
  end function hardening_of

  !> The length [m] that bends: half of both segments, or of the free one at the clamped root.
  pure real(rp) function bending_length(plan) result(length)
    type(hinge_plan_t), intent(in) :: plan
    length = sum(plan%lengths)/2
  end function bending_length
end module solid_effect_hardening

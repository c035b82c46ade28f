! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes directions in the space of stiffness: derivatives with respect to the effects of a model, and with respect to effects
!> that the model does not have, so that a scan need not add them to the model.
!>
!> Given to `solid_model_t%gradient`, a direction yields the derivative of the gradient; see also
!> `direction_sensitivity`. All directions are allocated as needed.
module solid_stiffness_effects
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use solid_effect, only: effect_site_t, effect_t
  use solid_effect_damage, only: add_damage
  use solid_effect_soft, only: add_hinge
  use solid_effects, only: find_effect, list_effects, modulus_factors, values_of, N_EFFECTS
  use solid_model, only: solid_model_t
  use solid_stiffness, only: allocate_stiffness, apply_effects, bending_stiffness, clear_stiffness, &
                             has_own_stiffness, stiffness_t
  implicit none
  private
  public :: parameter_direction, bending_direction, hinge_direction, keep_joints, damage_direction

contains

  !> Returns the derivative of all stiffnesses with respect to parameter `number` of the model, per log unit of parameters that
  !> vary by factors. It is 0 for parameters on which no stiffness depends.
  subroutine parameter_direction(model, number, direction)
    type(solid_model_t), intent(in), target :: model
    integer, intent(in) :: number
    type(stiffness_t), intent(inout) :: direction
    type(parameter_t) :: parameter
    type(effect_t) :: list(N_EFFECTS)
    type(effect_site_t) :: site
    integer :: e
    call prepare(model, direction)
    if (number <= model%params%count_basic()) then
      parameter = model%params%describe(number)
      call model%stiffness_derivative(number, parameter%is_log, direction)
      return
    end if
    list = list_effects()
    call find_effect(list, model%params%effects%n_joints, number - model%params%count_basic(), e, site%k)
    site%values = values_of(list, e, model%params%effects)
    site%effects => model%params%effects
    site%springs => model%springs
    site%plans => model%plans
    site%layout => model%layout
    if (associated(list(e)%derive)) call list(e)%derive(site, model%stiffness, direction)
    if (associated(list(e)%modulus)) call modulus_direction(model, list(e), site%values(1), direction)
  end subroutine parameter_direction

  !> Returns the derivative for an effect that changes E of the veins and has the value `value`.
  subroutine modulus_direction(model, effect, value, direction)
    type(solid_model_t), intent(in) :: model
    type(effect_t), intent(in) :: effect
    real(rp), intent(in) :: value
    type(stiffness_t), intent(inout) :: direction
    real(rp) :: modulus(size(model%plans))
    integer :: h
    associate (params => model%params, plans => model%plans, layout => model%layout)
      modulus = modulus_factors(params%effects, plans)
      do h = 1, size(plans)
        if (has_own_stiffness(params, plans(h))) cycle
        direction%hinge(h) = effect%modulus_slope(value, plans(h))* &
                             bending_stiffness(params, plans(h), layout%mean_diameter, modulus(h))
      end do
      call apply_effects(params, model%springs, plans, layout, direction)
    end associate
  end subroutine modulus_direction

  !> Returns the derivative of all stiffnesses with respect to the logarithm of a factor on all bending stiffness, that of hinges
  !> and of the membrane.
  subroutine bending_direction(model, direction)
    type(solid_model_t), intent(in) :: model
    type(stiffness_t), intent(inout) :: direction
    call prepare(model, direction)
    direction%hinge = model%stiffness%hinge
    direction%cubic = model%stiffness%cubic
    direction%lift = model%stiffness%lift
    direction%plate = model%stiffness%plate
    direction%edge = model%stiffness%edge
    direction%has_edges = model%stiffness%has_edges
    direction%arch = model%stiffness%arch
    direction%camber_moment = model%stiffness%camber_moment
    direction%twist = model%stiffness%twist
    direction%has_arch = model%stiffness%has_arch
    direction%has_twist = model%stiffness%has_twist
  end subroutine bending_direction

  !> Returns the derivative of all stiffnesses with respect to the logarithm of the stiffness of hinge h of the model.
  subroutine hinge_direction(model, h, direction)
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: h
    type(stiffness_t), intent(inout) :: direction
    call require(h >= 1 .and. h <= size(model%plans), 'hinge_direction: no such hinge')
    call prepare(model, direction)
    call add_hinge(h, model%stiffness, direction)
  end subroutine hinge_direction

  !> Returns in `joints` the model in which only the hinges of its joints are elastic, or nothing if it has no joints.
  subroutine keep_joints(model, joints)
    type(solid_model_t), intent(in) :: model
    type(solid_model_t), allocatable, intent(out) :: joints
    type(stiffness_t) :: stiffness
    allocate (joints, source=model)
    call prepare(model, stiffness)
    stiffness%hinge = merge(model%stiffness%hinge, 0.0_rp, model%plans%joint > 0)
    joints%stiffness = stiffness
    joints%springs%tension = stiffness%tension
  end subroutine keep_joints

  !> Returns the derivative of all stiffnesses with respect to the logarithm of the factor of a damage in disc = (x, y, radius)
  !> [m] that is not there yet: at the factor 1, in addition to all effects of the model.
  subroutine damage_direction(model, disc, direction)
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: disc(3)
    type(stiffness_t), intent(inout) :: direction
    call prepare(model, direction)
    call add_damage(disc, 1.0_rp, model%springs%n, model%layout, model%stiffness, direction)
  end subroutine damage_direction

  !> Makes a direction whose derivatives are all 0.
  subroutine prepare(model, direction)
    type(solid_model_t), intent(in) :: model
    type(stiffness_t), intent(inout) :: direction
    if (.not. allocated(direction%hinge)) &
      call allocate_stiffness(model%springs, model%plans, model%plate%n, direction)
    call clear_stiffness(direction)
  end subroutine prepare
end module solid_stiffness_effects

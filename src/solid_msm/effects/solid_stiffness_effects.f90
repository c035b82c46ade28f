! SPDX-License-Identifier: GPL-3.0-or-later
!> Directions in the space of stiffness: derivatives with respect to the effects of a model, and with respect to effects
!> that the model does not have, so that they can be scanned without being put in.
!>
!> Given to `solid_model_t%gradient`, a direction yields the derivative of the gradient; see also
!> `direction_sensitivity`. All directions are allocated as needed.
module solid_stiffness_effects
  use base_errors, only: require
  use base_kinds, only: rp
  use solid_effect_damage, only: damage_weight
  use solid_effect_hardening, only: bending_length
  use solid_effects, only: EFFECT_GRADIENT, EFFECT_DAMAGE, EFFECT_SOFT, EFFECT_ORTHOTROPY, EFFECT_HARDENING, &
                           EFFECT_CUTICLE, EFFECT_ROOT_FLAP, EFFECT_ROOT_TWIST, EFFECT_PRETENSION, EFFECT_CAMBER, &
                           EFFECT_TORSION, N_EFFECTS
  use solid_extension, only: SPRING_MEMBRANE
  use solid_model, only: solid_model_t
  use solid_parameter, only: parameter_t
  use solid_stiffness, only: allocate_stiffness, apply_effects, bending_stiffness, clear_stiffness, &
                             has_own_stiffness, stiffness_t
  implicit none
  private
  public :: parameter_direction, bending_direction, hinge_direction, damage_direction

contains

  !> Derivative of all stiffnesses with respect to parameter `number` of the model, per log unit of parameters that vary
  !> by factors. The stiffness does not depend on some: then it is 0.
  subroutine parameter_direction(model, number, direction)
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: number
    type(stiffness_t), intent(inout) :: direction
    type(parameter_t) :: parameter
    real(rp) :: factor
    integer :: h, s, effect
    call prepare(model, direction)
    associate (params => model%params, plans => model%plans, layout => model%layout, k => model%stiffness)
      effect = number - params%count_usual()
      if (effect <= 0) then
        parameter = params%describe(number)
        call model%stiffness_derivative(number, parameter%is_log, direction)
        return
      end if
      select case (effect)
      case (EFFECT_GRADIENT)
        do h = 1, size(plans)
          if (has_own_stiffness(params, plans(h))) cycle
          direction%hinge(h) = plans(h)%station*bending_stiffness(params, plans(h), layout%mean_diameter)
        end do
        call apply_effects(params, model%springs, plans, layout, direction)
      case (EFFECT_DAMAGE)
        call add_damage(model, params%effects%disc, direction, params%effects%damage)
      case (EFFECT_SOFT)
        if (layout%soft_hinge > 0) call hinge_direction(model, layout%soft_hinge, direction)
      case (EFFECT_ORTHOTROPY)
        do s = 1, model%springs%n
          if (model%springs%family(s) /= SPRING_MEMBRANE) cycle
          factor = layout%spring_cosine(s)
          direction%extension(s) = k%extension(s)*factor/(1 + params%effects%orthotropy*factor)
        end do
      case (EFFECT_HARDENING)
        where (plans%joint > 0) direction%cubic = k%hinge
      case (EFFECT_CUTICLE)
        do h = 1, size(plans)
          factor = 1/bending_length(plans(h))**2
          if (plans(h)%joint == 0) direction%cubic(h) = k%hinge(h)*factor
        end do
      case (EFFECT_PRETENSION)
        direction%tension = layout%spring_width
        direction%has_tension = .true.
      case (EFFECT_CAMBER + 1:EFFECT_CAMBER + 3)
        direction%arch = (k%plate + k%edge)*layout%edge_bend(effect - EFFECT_CAMBER, :)
        direction%bow = k%hinge*layout%hinge_turn(effect - EFFECT_CAMBER, :)
        direction%has_arch = .true.
      case (EFFECT_TORSION)
        direction%twist = k%hinge
        direction%has_twist = .true.
      case (EFFECT_ROOT_FLAP, EFFECT_ROOT_TWIST) ! see solid_bent_wing
        return
      case default
        if (effect <= N_EFFECTS + size(params%joint)) then
          where (plans%joint == effect - N_EFFECTS) direction%cubic = k%hinge
        else
          effect = effect - N_EFFECTS - size(params%joint)
          where (plans%joint == effect .and. params%effects%has_sides) &
            direction%lift = k%hinge*params%effects%one_way(effect)
        end if
      end select
    end associate
  end subroutine parameter_direction

  !> Derivative with respect to the logarithm of a factor on all bending stiffness: hinges and membrane.
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
    direction%bow = model%stiffness%bow
    direction%twist = model%stiffness%twist
    direction%has_arch = model%stiffness%has_arch
    direction%has_twist = model%stiffness%has_twist
  end subroutine bending_direction

  !> Derivative with respect to the logarithm of the stiffness of hinge h of the model.
  subroutine hinge_direction(model, h, direction)
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: h
    type(stiffness_t), intent(inout) :: direction
    call require(h >= 1 .and. h <= size(model%plans), 'hinge_direction: no such hinge')
    call prepare(model, direction)
    direction%hinge(h) = model%stiffness%hinge(h)
    direction%cubic(h) = model%stiffness%cubic(h)
    direction%lift(h) = model%stiffness%lift(h)
    direction%twist(h) = model%stiffness%twist(h)
    direction%bow(h) = model%stiffness%bow(h)
    direction%has_arch = model%stiffness%has_arch
    direction%has_twist = model%stiffness%has_twist
  end subroutine hinge_direction

  !> Derivative with respect to the logarithm of the factor of a damage with disc = (x, y, radius) [m] that is not there
  !> yet: at the factor 1, beside all effects of the model.
  subroutine damage_direction(model, disc, direction)
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: disc(3)
    type(stiffness_t), intent(inout) :: direction
    call prepare(model, direction)
    call add_damage(model, disc, direction)
  end subroutine damage_direction

  !> f w/(1 + (f - 1) w) times the stiffness, for a damage f that the model has, or w times it.
  subroutine add_damage(model, disc, direction, damage)
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: disc(3)
    type(stiffness_t), intent(inout) :: direction
    real(rp), intent(in), optional :: damage
    real(rp) :: w, f
    integer :: i
    f = 1
    if (present(damage)) f = damage
    associate (layout => model%layout, k => model%stiffness)
      do i = 1, model%springs%n
        direction%extension(i) = k%extension(i)*share(damage_weight(disc, layout%spring_place(:, i)))
      end do
      do i = 1, size(model%plans)
        w = damage_weight(disc, layout%hinge_place(:, i))
        direction%hinge(i) = k%hinge(i)*share(w)
        direction%cubic(i) = k%cubic(i)*share(w)
        direction%lift(i) = k%lift(i)*share(w)
        direction%twist(i) = k%twist(i)*share(w)
        direction%bow(i) = k%bow(i)*share(w)
      end do
      do i = 1, model%plate%n
        w = (damage_weight(disc, layout%edge_place(:, 1, i)) + damage_weight(disc, layout%edge_place(:, 2, i)))/2
        direction%edge(i) = (k%plate + k%edge(i))*share(w)
        direction%arch(i) = k%arch(i)*share(w)
      end do
      direction%has_edges = .true.
      direction%has_arch = k%has_arch
      direction%has_twist = k%has_twist
    end associate

  contains

    pure real(rp) function share(weight)
      real(rp), intent(in) :: weight
      share = f*weight/(1 + (f - 1)*weight)
    end function share

  end subroutine add_damage

  subroutine prepare(model, direction)
    type(solid_model_t), intent(in) :: model
    type(stiffness_t), intent(inout) :: direction
    if (.not. allocated(direction%hinge)) &
      call allocate_stiffness(model%springs, model%plans, model%plate%n, direction)
    call clear_stiffness(direction)
  end subroutine prepare
end module solid_stiffness_effects
